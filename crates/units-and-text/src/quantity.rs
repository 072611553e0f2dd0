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

/// Radians in a microradian.
pub const RAD_PER_MICRORADIAN: f64 = 1e-6;

/// Metres and radians that files have in micrometres and microradians, also where there may be none.
pub mod micro {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    use super::METRES_PER_MICROMETRE;

    /// A number, or none.
    pub trait Amount: Copy {
        /// The same with its number changed.
        #[must_use]
        fn map_amount(self, change: impl Fn(f64) -> f64) -> Self;
    }

    impl Amount for f64 {
        fn map_amount(self, change: impl Fn(f64) -> f64) -> Self {
            change(self)
        }
    }

    impl Amount for Option<f64> {
        fn map_amount(self, change: impl Fn(f64) -> f64) -> Self {
            self.map(change)
        }
    }

    /// Writes metres as micrometres.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn serialize<T: Amount + Serialize, S: Serializer>(
        metres: &T,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let written = metres.map_amount(|metres| metres / METRES_PER_MICROMETRE);
        written.serialize(serializer)
    }

    /// Reads micrometres as the metres that are written as these.
    ///
    /// # Errors
    /// Those of the deserializer.
    pub fn deserialize<'de, T: Amount + Deserialize<'de>, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<T, D::Error> {
        let read = T::deserialize(deserializer)?;
        Ok(read.map_amount(|micrometres| {
            // The product may be one step off.
            let metres = micrometres * METRES_PER_MICROMETRE;
            let is_it = |metres: &f64| metres / METRES_PER_MICROMETRE == micrometres;
            let near = [metres, metres.next_up(), metres.next_down()];
            near.into_iter().find(is_it).unwrap_or(metres)
        }))
    }
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
    /// Stress, SI unit pascal.
    Stress,
    /// Strain, SI unit one.
    Strain,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 8] = [
        Self::Force,
        Self::Displacement,
        Self::Time,
        Self::Temperature,
        Self::Torque,
        Self::Angle,
        Self::Stress,
        Self::Strain,
    ];

    /// The SI unit, as it is printed.
    #[must_use]
    pub fn si_unit(self) -> &'static str {
        match self {
            Self::Force => "N",
            Self::Displacement => "m",
            Self::Time => "s",
            Self::Temperature => "K",
            Self::Torque => "N*m",
            Self::Angle => "rad",
            Self::Stress => "Pa",
            Self::Strain => "1",
        }
    }

    /// The factor that takes a number in `unit` to SI, or `None` if `unit` does not name this kind.
    ///
    /// Spelling is that of column names and of gauges: case matters only where it changes the meaning (`mN`, `MN`).
    ///
    /// # Source
    /// BIPM, The International System of Units, 9th edition, tables 7 and 8; pound-force and kilogram-force from the exact
    /// values in NIST SP 811 (2008), appendix B.8. `tonf` is none: it means 2000 lbf, 2240 lbf or 1000 kgf. Pounds per square inch and pound-force inches follow from these and the inch.
    #[must_use]
    pub fn si_factor(self, unit: &str) -> Option<f64> {
        let factor = match (self, symbol(unit).unwrap_or(unit)) {
            (Self::Force, "N" | "Н") => 1.0,
            (Self::Force, "mN") => 1e-3,
            (Self::Force, "uN" | "µN" | "μN") => 1e-6,
            (Self::Force, "nN") => 1e-9,
            (Self::Force, "daN") => 10.0,
            (Self::Force, "kN" | "кН") => 1e3,
            (Self::Force, "MN") => 1e6,
            (Self::Force, "gf" | "g") => 9.806_65e-3,
            (Self::Force, "kgf" | "kg" | "kp" | "кгс") => 9.806_65,
            (Self::Force, "tf" | "t") => 9_806.65,
            (Self::Force, "lbf" | "lbF" | "lb" | "lbs") => 4.448_221_615_260_5,
            (Self::Force, "klbf" | "kip" | "kips") => 4_448.221_615_260_5,
            (Self::Force, "ozf" | "ozF" | "oz") => 0.278_013_850_953_781_2,
            (Self::Displacement, "m" | "м") => 1.0,
            (Self::Displacement, "mm" | "мм") => 1e-3,
            (Self::Displacement, "cm") => 1e-2,
            (Self::Displacement, "um" | "µm" | "μm" | "мкм") => 1e-6,
            (Self::Displacement, "nm") => 1e-9,
            (Self::Displacement, "in") => 0.025_4,
            (Self::Displacement, "mil" | "mils" | "thou") => 2.54e-5,
            (Self::Displacement, "uin" | "µin" | "μin") => 2.54e-8,
            (Self::Time, "s" | "sec" | "Sec" | "с" | "сек" | "秒") => 1.0,
            (Self::Time, "ms" | "мс") => 1e-3,
            (Self::Time, "min" | "мин") => 60.0,
            (Self::Time, "h") => 3600.0,
            (Self::Time, "d") => 86_400.0,
            (Self::Temperature, "degC" | "°C" | "C" | "K") => 1.0,
            (Self::Temperature, "degF" | "°F" | "F") => 5.0 / 9.0,
            (Self::Torque, "Nm" | "N*m" | "N.m" | "N·m" | "N-m" | "Н·м" | "Нм") => 1.0,
            (Self::Torque, "Nmm" | "N*mm" | "N.mm" | "N·mm" | "N-mm" | "mNm") => 1e-3,
            (
                Self::Torque,
                "lbfin" | "lbf*in" | "lbf.in" | "lbf·in" | "lbf-in" | "in-lbf" | "in*lbf",
            ) => 0.112_984_829_027_616_7,
            (Self::Torque, "kNm" | "kN*m") => 1e3,
            (Self::Angle, "rad") => 1.0,
            (Self::Angle, "mrad") => 1e-3,
            (Self::Angle, "urad" | "µrad" | "μrad") => 1e-6,
            (Self::Angle, "deg" | "°") => std::f64::consts::PI / 180.0,
            (Self::Angle, "arcmin") => std::f64::consts::PI / 10_800.0,
            (Self::Angle, "arcsec") => std::f64::consts::PI / 648_000.0,
            (Self::Stress, "Pa") => 1.0,
            (Self::Stress, "kPa") => 1e3,
            (Self::Stress, "MPa" | "N/mm2" | "N/mm²" | "N/mm^2") => 1e6,
            (Self::Stress, "GPa") => 1e9,
            (Self::Stress, "psi") => 6_894.757_293_168_361,
            (Self::Stress, "ksi") => 6_894_757.293_168_361,
            (Self::Strain, "mm/mm" | "m/m" | "in/in") => 1.0,
            (Self::Strain, "%") => 1e-2,
            (
                Self::Strain,
                "um/m" | "µm/m" | "μm/m" | "microstrain" | "ustrain" | "µstrain" | "µε" | "με",
            ) => 1e-6,
            _ => return None,
        };
        Some(factor)
    }

    /// The spellings accepted for this kind, for messages.
    #[must_use]
    pub fn units(self) -> &'static str {
        match self {
            Self::Force => "N, mN, uN, nN, daN, kN, MN, gf, kgf, kp, tf, lbf, klbf, kip, ozf",
            Self::Displacement => "um, mm, m, nm, cm, in, mil, uin",
            Self::Time => "s, ms, min, h, d",
            Self::Temperature => "degC, K, degF",
            Self::Torque => "N*m, N*mm, kN*m, lbf*in",
            Self::Angle => "urad, mrad, rad, deg, arcmin, arcsec",
            Self::Stress => "Pa, kPa, MPa, GPa, psi, ksi",
            Self::Strain => "mm/mm, %, um/m, microstrain",
        }
    }
}

/// The symbol of a unit that is written as a word, in any capitals.
///
/// Words that mean something else at the end of a name are none: the second, a meter, a micrometer.
fn symbol(word: &str) -> Option<&'static str> {
    // Longer than any of them.
    const LONGEST: usize = 12;
    if !(3..=LONGEST).contains(&word.len()) {
        return None;
    }
    Some(match word.to_ascii_lowercase().as_str() {
        "newton" | "newtons" => "N",
        "kilonewton" | "kilonewtons" => "kN",
        "pounds" => "lbf",
        "metres" | "meters" => "m",
        "centimetre" | "centimetres" | "centimeter" | "centimeters" => "cm",
        "millimetre" | "millimetres" | "millimeter" | "millimeters" => "mm",
        "micron" | "microns" | "micrometre" | "micrometres" | "micrometers" => "um",
        "inch" | "inches" => "in",
        "seconds" | "sekunden" | "secondes" | "segundos" | "secondi" => "s",
        "milliseconds" => "ms",
        "minutes" | "minuten" => "min",
        "hours" | "stunden" => "h",
        "day" | "days" => "d",
        "degrees" => "deg",
        "radians" => "rad",
        "percent" => "%",
        "celsius" => "degC",
        _ => return None,
    })
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

    #[test]
    fn derived_units_follow_from_their_parts() {
        let (lbf, inch) = (4.448_221_615_260_5, 0.0254);
        let near = |kind: Kind, unit: &str, expected: f64| {
            let factor = kind.si_factor(unit).unwrap();
            assert!((factor / expected - 1.0).abs() < 1e-15, "{unit}: {factor}");
        };
        near(Kind::Torque, "lbf*in", lbf * inch);
        near(Kind::Stress, "psi", lbf / (inch * inch));
        near(Kind::Stress, "ksi", 1000.0 * lbf / (inch * inch));
        near(Kind::Displacement, "mil", inch / 1000.0);
        near(Kind::Displacement, "uin", inch / 1e6);
        near(Kind::Force, "kip", 1000.0 * lbf);
        near(Kind::Force, "kp", 9.806_65);
        near(Kind::Force, "t", 9_806.65);
        near(Kind::Force, "daN", 10.0);
        near(
            Kind::Angle,
            "arcmin",
            60.0 * Kind::Angle.si_factor("arcsec").unwrap(),
        );
        near(Kind::Time, "d", 24.0 * 3600.0);
    }

    #[test]
    fn listed_units_are_known() {
        for kind in Kind::ALL {
            for unit in kind.units().split(", ") {
                assert!(kind.si_factor(unit).is_some(), "{kind:?} {unit}");
            }
        }
    }

    #[test]
    fn words_are_units_in_any_capitals() {
        for (kind, word, unit) in [
            (Kind::Displacement, "Microns", "um"),
            (Kind::Displacement, "Millimeters", "mm"),
            (Kind::Force, "NEWTONS", "N"),
            (Kind::Force, "Pounds", "lbf"),
            (Kind::Angle, "Degrees", "deg"),
            (Kind::Time, "Sekunden", "s"),
        ] {
            assert_eq!(kind.si_factor(word), kind.si_factor(unit), "{word}");
        }
        for word in ["second", "meter", "micrometer", "Microns per"] {
            assert!(
                Kind::ALL.iter().all(|kind| kind.si_factor(word).is_none()),
                "{word}"
            );
        }
    }
}
