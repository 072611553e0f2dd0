//! Vectors of three components in global axes, and pairs of them: forces with moments, displacements with rotations.
//!
//! Leaf module, inlined into the loops of other crates. Plain arrays: the few products needed here do not ask for a matrix library in public signatures.

/// Scalar product.
#[must_use]
#[inline]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Work of forces and moments in displacements and rotations, or another scalar product of six components.
#[must_use]
#[inline]
pub fn dot6(a: [f64; 6], b: [f64; 6]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4] + a[5] * b[5]
}

/// A force without a moment, or a displacement without a rotation.
#[must_use]
#[inline]
pub fn along6([x, y, z]: [f64; 3]) -> [f64; 6] {
    [x, y, z, 0.0, 0.0, 0.0]
}

/// Vector product.
#[must_use]
#[inline]
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Euclidean length.
#[must_use]
#[inline]
pub fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// A vector times a number.
#[must_use]
#[inline]
pub fn scale(a: [f64; 3], factor: f64) -> [f64; 3] {
    a.map(|c| c * factor)
}

/// a - b.
#[must_use]
#[inline]
pub fn subtract(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Rotation matrix about a unit axis (Rodrigues), row by row.
#[must_use]
pub fn rotation(axis: [f64; 3], angle_rad: f64) -> [[f64; 3]; 3] {
    let (sin, cos) = angle_rad.sin_cos();
    let [x, y, z] = axis;
    let versine = 1.0 - cos;
    [
        [
            cos + x * x * versine,
            x * y * versine - z * sin,
            x * z * versine + y * sin,
        ],
        [
            y * x * versine + z * sin,
            cos + y * y * versine,
            y * z * versine - x * sin,
        ],
        [
            z * x * versine - y * sin,
            z * y * versine + x * sin,
            cos + z * z * versine,
        ],
    ]
}
