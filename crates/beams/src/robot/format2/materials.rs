//! Materials that a file may name without describing them.

use crate::structure::Material;

/// A material with its density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NamedMaterial {
    /// What a file calls it.
    pub(crate) name: &'static str,
    /// Elastic constants.
    pub(crate) elastic: Material,
    /// Density, kg/m³.
    pub(crate) density_kg_per_m3: f64,
    /// Where the numbers stand.
    pub(crate) source: &'static str,
}

/// The materials, the usual one first.
pub(crate) const MATERIALS: [NamedMaterial; 6] = [
    material(
        "steel",
        [210.0, 81.0, 7850.0],
        "EN 1993-1-1, 3.2.6; EN 1991-1-1, table A.4",
    ),
    material("aluminium", [70.0, 27.0, 2700.0], "EN 1999-1-1, 3.2.5"),
    material(
        "stainless-steel",
        [200.0, 77.0, 7900.0],
        "EN 1993-1-4, 2.1.3; EN 10088-1, 1.4301",
    ),
    material(
        "cast-iron",
        [110.0, 44.0, 7200.0],
        "EN 1561, annex A, EN-GJL-250",
    ),
    material(
        "ductile-iron",
        [169.0, 66.0, 7100.0],
        "EN 1563, annex D, EN-GJS-400-15",
    ),
    material(
        "titanium",
        [114.0, 44.0, 4430.0],
        "ASM Handbook, volume 2, Ti-6Al-4V",
    ),
];

/// E and G in GPa, density in kg/m³.
const fn material(
    name: &'static str,
    [e_gpa, g_gpa, density_kg_per_m3]: [f64; 3],
    source: &'static str,
) -> NamedMaterial {
    NamedMaterial {
        name,
        elastic: Material {
            youngs_modulus_pa: e_gpa * 1e9,
            shear_modulus_pa: g_gpa * 1e9,
        },
        density_kg_per_m3,
        source,
    }
}

/// The material of a name; `aluminum` too.
pub(crate) fn named_material(name: &str) -> Option<&'static NamedMaterial> {
    let name = if name == "aluminum" {
        "aluminium"
    } else {
        name
    };
    MATERIALS.iter().find(|material| material.name == name)
}
