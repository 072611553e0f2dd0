//! Numbers that cannot lose their unit at the edges: bytes, files and people.
//!
//! Inside numerics plain `f64` in SI with a suffix (`force_n`, `displacement_m`) is used; here are the types for where a number
//! enters or leaves, the unit spellings that files may use, and the form in which results are printed and written to JSON.

use uom::si::{ISQ, Quantity as UomQuantity, SI};
use uom::typenum::{N1, N2, P1, P2, Z0};

/// Signed force along a global axis.
pub type Force = uom::si::f64::Force;
/// Signed displacement along a global axis.
pub type Displacement = uom::si::f64::Length;
/// Force per displacement at the end point, N/m in SI.
pub type Stiffness = UomQuantity<ISQ<Z0, P1, N2, Z0, Z0, Z0, Z0>, SI<f64>, f64>;
/// Displacement per force at the end point, m/N in SI.
pub type Compliance = UomQuantity<ISQ<Z0, N1, P2, Z0, Z0, Z0, Z0>, SI<f64>, f64>;

/// Metres in a micrometre.
pub const METRES_PER_MICROMETRE: f64 = 1e-6;

/// Writes metres as micrometres, for fields of results that end in `_um`.
///
/// # Errors
/// Those of the serializer.
pub fn in_micrometres<S: serde::Serializer>(
    metres: &f64,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(metres / METRES_PER_MICROMETRE)
}

/// Stiffness in the unit of files and print: 1 N/µm is 1e6 N/m.
pub const NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE: f64 = 1e6;

/// What a column or an instrument measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// Force, SI unit newton.
    Force,
    /// Displacement, SI unit metre.
    Displacement,
    /// Time, SI unit second.
    Time,
    /// Temperature difference, kelvin; degrees Celsius have the same step.
    Temperature,
    /// Torque or bending moment, SI unit newton metre.
    Torque,
    /// Angle, SI unit radian.
    Angle,
}

impl Kind {
    /// The factor that takes a number in `unit` to SI, or `None` if `unit` does not name this kind.
    ///
    /// Spelling is that of column names and of gauges: case matters only where it changes the meaning (`mN`, `MN`).
    ///
    /// # Source
    /// BIPM, The International System of Units, 9th edition, tables 7 and 8; pound-force and kilogram-force from the exact
    /// values in NIST SP 811 (2008), appendix B.8.
    #[must_use]
    pub fn si_factor(self, unit: &str) -> Option<f64> {
        let factor = match (self, unit) {
            (Self::Force, "N") => 1.0,
            (Self::Force, "mN") => 1e-3,
            (Self::Force, "uN" | "µN" | "μN") => 1e-6,
            (Self::Force, "nN") => 1e-9,
            (Self::Force, "kN") => 1e3,
            (Self::Force, "gf" | "g") => 9.806_65e-3,
            (Self::Force, "kgf" | "kg") => 9.806_65,
            (Self::Force, "lbf" | "lbF" | "lb") => 4.448_221_615_260_5,
            (Self::Force, "ozf" | "ozF" | "oz") => 0.278_013_850_953_781_2,
            (Self::Displacement, "m") => 1.0,
            (Self::Displacement, "mm") => 1e-3,
            (Self::Displacement, "um" | "µm" | "μm" | "micron") => 1e-6,
            (Self::Displacement, "nm") => 1e-9,
            (Self::Displacement, "in" | "inch") => 0.025_4,
            (Self::Time, "s") => 1.0,
            (Self::Time, "ms") => 1e-3,
            (Self::Time, "min") => 60.0,
            (Self::Time, "h") => 3600.0,
            (Self::Temperature, "degC" | "°C" | "C" | "K") => 1.0,
            (Self::Torque, "Nm" | "N*m" | "N.m") => 1.0,
            (Self::Torque, "Nmm" | "N*mm" | "mNm") => 1e-3,
            (Self::Torque, "kNm" | "kN*m") => 1e3,
            (Self::Angle, "rad") => 1.0,
            (Self::Angle, "mrad") => 1e-3,
            (Self::Angle, "urad" | "µrad" | "μrad") => 1e-6,
            (Self::Angle, "deg" | "°") => std::f64::consts::PI / 180.0,
            (Self::Angle, "arcsec") => std::f64::consts::PI / 648_000.0,
            _ => return None,
        };
        Some(factor)
    }

    /// The spellings accepted for this kind, for messages.
    #[must_use]
    pub fn units(self) -> &'static str {
        match self {
            Self::Force => "N, mN, uN, nN, kN, gf, kgf, lbf, ozf",
            Self::Displacement => "um, mm, m, nm, in",
            Self::Time => "s, ms, min, h",
            Self::Temperature => "degC, K",
            Self::Torque => "Nm, Nmm, kNm",
            Self::Angle => "urad, mrad, rad, deg, arcsec",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use uom::si::force::newton;
    use uom::si::length::micrometer;

    #[test]
    fn force_over_displacement_is_a_stiffness() {
        let stiffness: Stiffness =
            Force::new::<newton>(-50.0) / Displacement::new::<micrometer>(-100.0);
        assert!((stiffness.value / NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE - 0.5).abs() < 1e-15);
        let compliance: Compliance = stiffness.recip();
        assert!((compliance.value - 2e-6).abs() < 1e-20);
    }

    #[test]
    fn a_unit_of_another_kind_is_refused() {
        assert_eq!(Kind::Force.si_factor("mm"), None);
        assert_eq!(Kind::Displacement.si_factor("N"), None);
        assert_eq!(Kind::Force.si_factor("lbf"), Some(4.448_221_615_260_5));
    }
}
