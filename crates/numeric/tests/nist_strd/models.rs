//! The 27 models with their derivatives, in the notation of NIST's files.
//!
//! Each function gives the predicted response at the predictors `x` for the parameters `b` and writes its derivatives to `d`.

use std::f64::consts::PI;

pub(crate) type Model = fn(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64;

/// All 27 problems, by NIST's level of difficulty.
#[rustfmt::skip]
pub(crate) const PROBLEMS: [(&str, Model); 27] = [
    // lower
    ("Misra1a", saturating_exponential), ("Chwirut2", chwirut), ("Chwirut1", chwirut), ("Lanczos3", lanczos), ("Gauss1", gauss),
    ("Gauss2", gauss), ("DanWood", power), ("Misra1b", misra1b),
    // average
    ("Kirby2", rational_quadratic), ("Hahn1", rational_cubic), ("Nelson", nelson), ("MGH17", mgh17), ("Lanczos1", lanczos),
    ("Lanczos2", lanczos), ("Gauss3", gauss), ("Misra1c", misra1c), ("Misra1d", misra1d), ("Roszman1", roszman), ("ENSO", enso),
    // higher
    ("MGH09", mgh09), ("Thurber", rational_cubic), ("BoxBOD", saturating_exponential), ("Rat42", rat42), ("MGH10", mgh10),
    ("Eckerle4", eckerle), ("Rat43", rat43), ("Bennett5", bennett),
];

/// b1 (1 − exp(−b2 x)): Misra1a, BoxBOD.
fn saturating_exponential(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    d[0] = -(-b[1] * x[0]).exp_m1();
    d[1] = b[0] * x[0] * (-b[1] * x[0]).exp();
    b[0] * d[0]
}

/// b1 (1 − (1 + b2 x/2)⁻²).
fn misra1b(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let u = 1.0 + b[1] * x[0] / 2.0;
    d[0] = 1.0 - u.powi(-2);
    d[1] = b[0] * x[0] * u.powi(-3);
    b[0] * d[0]
}

/// b1 (1 − (1 + 2 b2 x)^(−1/2)).
fn misra1c(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let u = 1.0 + 2.0 * b[1] * x[0];
    d[0] = 1.0 - u.powf(-0.5);
    d[1] = b[0] * x[0] * u.powf(-1.5);
    b[0] * d[0]
}

/// b1 b2 x/(1 + b2 x).
fn misra1d(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let u = 1.0 + b[1] * x[0];
    d[0] = b[1] * x[0] / u;
    d[1] = b[0] * x[0] / (u * u);
    b[0] * d[0]
}

/// exp(−b1 x)/(b2 + b3 x): Chwirut1, Chwirut2.
fn chwirut(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let u = b[1] + b[2] * x[0];
    let y = (-b[0] * x[0]).exp() / u;
    d[0] = -x[0] * y;
    d[1] = -y / u;
    d[2] = -x[0] * y / u;
    y
}

/// b1 exp(−b2 x) + b3 exp(−b4 x) + b5 exp(−b6 x): Lanczos1 to 3.
fn lanczos(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let mut y = 0.0;
    for k in [0, 2, 4] {
        d[k] = (-b[k + 1] * x[0]).exp();
        d[k + 1] = -x[0] * b[k] * d[k];
        y += b[k] * d[k];
    }
    y
}

/// b1 exp(−b2 x) + b3 exp(−(x − b4)²/b5²) + b6 exp(−(x − b7)²/b8²): Gauss1 to 3.
fn gauss(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    d[0] = (-b[1] * x[0]).exp();
    d[1] = -x[0] * b[0] * d[0];
    let mut y = b[0] * d[0];
    for k in [2, 5] {
        let u = (x[0] - b[k + 1]) / b[k + 2];
        d[k] = (-u * u).exp();
        d[k + 1] = b[k] * d[k] * 2.0 * u / b[k + 2];
        d[k + 2] = d[k + 1] * u;
        y += b[k] * d[k];
    }
    y
}

/// b1 x^b2: DanWood.
fn power(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    d[0] = x[0].powf(b[1]);
    let y = b[0] * d[0];
    d[1] = y * x[0].ln();
    y
}

/// Numerator of degree `degree` over 1 + …; parameters from the constant up, numerator first.
fn rational(degree: usize, x: f64, b: &[f64], d: &mut [f64]) -> f64 {
    let polynomial =
        |coefficients: &[f64]| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let numerator = polynomial(&b[..=degree]);
    let denominator = 1.0 + x * polynomial(&b[degree + 1..]);
    let y = numerator / denominator;
    let mut power_of_x = 1.0;
    for k in 0..=degree {
        d[k] = power_of_x / denominator;
        if k > 0 {
            d[degree + k] = -y * d[k];
        }
        power_of_x *= x;
    }
    y
}

/// Kirby2.
fn rational_quadratic(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    rational(2, x[0], b, d)
}

/// Hahn1, Thurber.
fn rational_cubic(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    rational(3, x[0], b, d)
}

/// ln y = b1 − b2 x1 exp(−b3 x2).
fn nelson(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let e = (-b[2] * x[1]).exp();
    d[0] = 1.0;
    d[1] = -x[0] * e;
    d[2] = b[1] * x[0] * x[1] * e;
    b[0] - b[1] * x[0] * e
}

/// b1 + b2 exp(−b4 x) + b3 exp(−b5 x).
fn mgh17(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    d[0] = 1.0;
    d[1] = (-x[0] * b[3]).exp();
    d[2] = (-x[0] * b[4]).exp();
    d[3] = -x[0] * b[1] * d[1];
    d[4] = -x[0] * b[2] * d[2];
    b[0] + b[1] * d[1] + b[2] * d[2]
}

/// b1 − b2 x − arctan(b3/(x − b4))/π.
fn roszman(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let u = x[0] - b[3];
    let square = u * u + b[2] * b[2];
    d[0] = 1.0;
    d[1] = -x[0];
    d[2] = -u / square / PI;
    d[3] = -b[2] / square / PI;
    b[0] - b[1] * x[0] - (b[2] / u).atan() / PI
}

/// A constant and three cycles, the periods of two of them unknown.
fn enso(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let year = 2.0 * PI * x[0] / 12.0;
    d[0] = 1.0;
    d[1] = year.cos();
    d[2] = year.sin();
    let mut y = b[0] + b[1] * d[1] + b[2] * d[2];
    for k in [3, 6] {
        let (period, cosine, sine) = (b[k], b[k + 1], b[k + 2]);
        let angle = 2.0 * PI * x[0] / period;
        d[k + 1] = angle.cos();
        d[k + 2] = angle.sin();
        d[k] = (cosine * angle.sin() - sine * angle.cos()) * angle / period;
        y += cosine * angle.cos() + sine * angle.sin();
    }
    y
}

/// b1 (x² + b2 x)/(x² + b3 x + b4).
fn mgh09(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let x = x[0];
    let denominator = x * x + x * b[2] + b[3];
    d[0] = (x * x + x * b[1]) / denominator;
    let y = b[0] * d[0];
    d[1] = b[0] * x / denominator;
    d[2] = -y * x / denominator;
    d[3] = -y / denominator;
    y
}

/// b1/(1 + exp(b2 − b3 x)).
fn rat42(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let e = (b[1] - b[2] * x[0]).exp();
    d[0] = 1.0 / (1.0 + e);
    let y = b[0] * d[0];
    d[1] = -y * e * d[0];
    d[2] = -x[0] * d[1];
    y
}

/// b1/(1 + exp(b2 − b3 x))^(1/b4).
fn rat43(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let e = (b[1] - b[2] * x[0]).exp();
    d[0] = (1.0 + e).powf(-1.0 / b[3]);
    let y = b[0] * d[0];
    d[1] = -y / b[3] * e / (1.0 + e);
    d[2] = -x[0] * d[1];
    d[3] = y * e.ln_1p() / (b[3] * b[3]);
    y
}

/// b1 exp(b2/(x + b3)).
fn mgh10(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let u = x[0] + b[2];
    d[0] = (b[1] / u).exp();
    let y = b[0] * d[0];
    d[1] = y / u;
    d[2] = -y * b[1] / (u * u);
    y
}

/// b1/b2 exp(−((x − b3)/b2)²/2).
fn eckerle(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let u = (x[0] - b[2]) / b[1];
    d[0] = (-0.5 * u * u).exp() / b[1];
    let y = b[0] * d[0];
    d[1] = y * (u * u - 1.0) / b[1];
    d[2] = y * u / b[1];
    y
}

/// b1 (b2 + x)^(−1/b3).
fn bennett(x: [f64; 2], b: &[f64], d: &mut [f64]) -> f64 {
    let u = b[1] + x[0];
    d[0] = u.powf(-1.0 / b[2]);
    let y = b[0] * d[0];
    d[1] = -y / (b[2] * u);
    d[2] = y * u.ln() / (b[2] * b[2]);
    y
}
