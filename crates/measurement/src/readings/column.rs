//! The columns of `readings.csv`: what each is called, in which unit, and which other names are understood.

use std::fmt;

use super::number::Conversion;
use stiffbench_units_and_text::quantity::Kind;

/// A column of `readings.csv`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Column {
    /// Session id.
    Session,
    /// Sequence number of the reading.
    Seq,
    /// RFC 3339 time.
    Utc,
    /// Seconds since the session began.
    Time,
    /// Name of the pose.
    Pose,
    /// `x`, `y` or `z`.
    Direction,
    /// `loading` or `unloading`.
    Branch,
    /// Place in the load sequence, from 0.
    Step,
    /// The load aimed at.
    Target,
    /// n-th application of the sequence or load, from 1.
    Repeat,
    /// n-th try of the reading, from 1.
    Attempt,
    /// Readings with one virgin history.
    Run,
    /// Readings with one gauge zero.
    Zero,
    /// Signed force.
    Force,
    /// The force gauge's own text.
    ForceRaw,
    /// What the force gauge showed unloaded; it is taken off.
    ForceZero,
    /// Signed displacement.
    Displacement,
    /// The dial gauge's own text.
    DisplacementRaw,
    /// What the dial gauge showed under the preload; it is taken off.
    DisplacementZero,
    /// Seconds under this load before capture.
    Hold,
    /// Temperature.
    Temperature,
    /// Whether the reading counts.
    Status,
    /// Rule id and reason.
    Flag,
    /// Free text.
    Note,
    /// How the reading came about if it was not measured: simulated or emulated, with what acted.
    Origin,
}

impl Column {
    /// All columns, in the order in which they are written.
    pub const ALL: [Self; 25] = [
        Self::Session,
        Self::Seq,
        Self::Utc,
        Self::Time,
        Self::Pose,
        Self::Direction,
        Self::Branch,
        Self::Step,
        Self::Target,
        Self::Repeat,
        Self::Attempt,
        Self::Run,
        Self::Zero,
        Self::Force,
        Self::ForceRaw,
        Self::ForceZero,
        Self::Displacement,
        Self::DisplacementRaw,
        Self::DisplacementZero,
        Self::Hold,
        Self::Temperature,
        Self::Status,
        Self::Flag,
        Self::Note,
        Self::Origin,
    ];

    /// The five columns without which a table is not accepted.
    pub const REQUIRED: [Self; 5] = [
        Self::Pose,
        Self::Direction,
        Self::Repeat,
        Self::Force,
        Self::Displacement,
    ];

    /// The name this column is written under, with its unit.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Session => "session",
            Self::Seq => "seq",
            Self::Utc => "utc",
            Self::Time => "t_s",
            Self::Pose => "pose",
            Self::Direction => "direction",
            Self::Branch => "branch",
            Self::Step => "step",
            Self::Target => "target_N",
            Self::Repeat => "repeat",
            Self::Attempt => "attempt",
            Self::Run => "run",
            Self::Zero => "zero_id",
            Self::Force => "force_N",
            Self::ForceRaw => "force_raw",
            Self::ForceZero => "force_zero_N",
            Self::Displacement => "displacement_um",
            Self::DisplacementRaw => "displacement_raw",
            Self::DisplacementZero => "displacement_zero_um",
            Self::Hold => "hold_s",
            Self::Temperature => "temp_degC",
            Self::Status => "status",
            Self::Flag => "flag",
            Self::Note => "note",
            Self::Origin => "origin",
        }
    }

    /// The unit it is written in; empty for a column without a unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Target | Self::Force | Self::ForceZero => "N",
            Self::Displacement | Self::DisplacementZero => "um",
            Self::Time | Self::Hold => "s",
            Self::Temperature => "degC",
            _ => "",
        }
    }

    /// What it measures, for a column with a unit.
    #[must_use]
    pub fn kind(self) -> Option<Kind> {
        match self {
            Self::Target | Self::Force | Self::ForceZero => Some(Kind::Force),
            Self::Displacement | Self::DisplacementZero => Some(Kind::Displacement),
            Self::Time | Self::Hold => Some(Kind::Time),
            Self::Temperature => Some(Kind::Temperature),
            _ => None,
        }
    }

    /// The column of a quantity, by its name without unit, in lower case.
    fn of_quantity(name: &str) -> Option<Self> {
        Some(match name {
            "force" | "load" => Self::Force,
            "displacement" | "disp" | "deflection" | "travel" | "distance" => Self::Displacement,
            "force_zero" => Self::ForceZero,
            "displacement_zero" | "disp_zero" => Self::DisplacementZero,
            "target" | "target_force" | "target_load" => Self::Target,
            "t" | "time" => Self::Time,
            "hold" | "hold_time" => Self::Hold,
            "temp" | "temperature" => Self::Temperature,
            _ => return None,
        })
    }
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The meaning of a name in a header.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum NamedColumn<'a> {
    /// A column, and how its numbers become SI.
    Column(Column, Conversion),
    /// A quantity without a unit.
    NoUnit(Column),
    /// A quantity with a unit that does not belong to it.
    WrongUnit(Column, &'a str),
    /// Not one of our columns.
    Unknown,
}

/// The meaning of a header name: `force_N`, `Force [N]`, `load (lbf)`, `disp_mm`, `zero_id`. Capitals and blanks around it do not count.
pub(super) fn understand(name: &str) -> NamedColumn<'_> {
    let name = name.trim();
    let lower = name.to_lowercase();
    if let Some(column) = Column::of_quantity(&lower) {
        return NamedColumn::NoUnit(column);
    }
    if let Some(column) = Column::ALL
        .into_iter()
        .find(|column| column.kind().is_none() && column.name() == lower)
    {
        return NamedColumn::Column(column, Conversion::NONE);
    }
    let Some((stem, unit)) = split_unit(name) else {
        return NamedColumn::Unknown;
    };
    let Some(column) = Column::of_quantity(&stem.to_lowercase()) else {
        return NamedColumn::Unknown;
    };
    match column
        .kind()
        .and_then(|kind| Conversion::from_unit(kind, unit))
    {
        Some(conversion) => NamedColumn::Column(column, conversion),
        None => NamedColumn::WrongUnit(column, unit),
    }
}

/// `force_N`, `Force [N]`, `Force (N)` into name and unit.
pub(crate) fn split_unit(name: &str) -> Option<(&str, &str)> {
    for (open, close) in [('[', ']'), ('(', ')')] {
        if let Some(rest) = name.strip_suffix(close) {
            let (stem, unit) = rest.split_once(open)?;
            return Some((stem.trim().trim_end_matches('_'), unit.trim()));
        }
    }
    name.rsplit_once('_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_written_name_is_understood() {
        for column in Column::ALL {
            let NamedColumn::Column(found, conversion) = understand(column.name()) else {
                panic!("{column} is not understood");
            };
            assert_eq!(found, column);
            let expected = match column {
                Column::Displacement | Column::DisplacementZero => -6,
                _ => 0,
            };
            assert_eq!(conversion, Conversion::Shift(expected));
        }
    }

    #[test]
    fn other_spellings_are_understood() {
        let column = |name| match understand(name) {
            NamedColumn::Column(column, conversion) => (column, conversion),
            other => panic!("{name}: {other:?}"),
        };
        assert_eq!(
            column("disp_mm"),
            (Column::Displacement, Conversion::Shift(-3))
        );
        assert_eq!(
            column(" Deflection_um "),
            (Column::Displacement, Conversion::Shift(-6))
        );
        assert_eq!(column("Force [kN]"), (Column::Force, Conversion::Shift(3)));
        assert_eq!(column("FORCE_N"), (Column::Force, Conversion::Shift(0)));
        assert_eq!(
            column("Displacement (µm)"),
            (Column::Displacement, Conversion::Shift(-6))
        );
        assert_eq!(column("time_min"), (Column::Time, Conversion::Factor(60.0)));
        assert_eq!(column("POSE"), (Column::Pose, Conversion::NONE));
    }

    #[test]
    fn units_are_not_guessed() {
        assert_eq!(understand("force"), NamedColumn::NoUnit(Column::Force));
        assert_eq!(
            understand("force_mm"),
            NamedColumn::WrongUnit(Column::Force, "mm")
        );
        assert_eq!(
            understand("displacement_furlong"),
            NamedColumn::WrongUnit(Column::Displacement, "furlong")
        );
        // A standard deviation is not a displacement.
        assert_eq!(understand("disp_sd_mm"), NamedColumn::Unknown);
        assert_eq!(understand("operator"), NamedColumn::Unknown);
    }
}
