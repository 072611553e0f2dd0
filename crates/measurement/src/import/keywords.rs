//! What a column may be, by the words of its name and by its unit.

use stiffbench_units_and_text::quantity::Kind;

use super::columns::ColumnRole;
use crate::readings::Conversion;
use crate::table_files::keywords::{
    BRANCH, DIRECTION, DISPLACEMENT, DISPLACEMENT_LETTERS, FORCE, MOMENT, NOT_READ, POSE, REPEAT,
    ROTATION, SPECIMEN, STRAIN, STRESS, TEMPERATURE, TIME, has, plain, words_of,
};
use crate::table_files::{FileColumn, StampKind};

/// What the two quantities of a table may be: kinds of units, and words of names.
pub(super) struct ReadQuantities {
    force: (&'static [Kind], &'static [&'static str]),
    displacement: (&'static [Kind], &'static [&'static str]),
    has_joints: bool,
}

/// At a robot: a force and a displacement, and joints.
pub(super) const OF_A_ROBOT: ReadQuantities = ReadQuantities {
    force: (&[Kind::Force], &[FORCE]),
    displacement: (&[Kind::Displacement], &[DISPLACEMENT]),
    has_joints: true,
};

/// At a part: also torque against angle, and stress against strain.
pub(super) const OF_A_PART: ReadQuantities = ReadQuantities {
    force: (
        &[Kind::Force, Kind::Torque, Kind::Stress],
        &[FORCE, MOMENT, STRESS],
    ),
    displacement: (
        &[Kind::Displacement, Kind::Angle, Kind::Strain],
        &[DISPLACEMENT, ROTATION, STRAIN],
    ),
    has_joints: false,
};

/// A role with how sure it is, from 1.
pub(super) type RoleGuess = (ColumnRole, u8);

/// Whether `unit` is one of this kind.
pub(super) fn is_of(kind: Kind, unit: &str) -> bool {
    Conversion::from_unit(kind, unit).is_some()
}

/// The roles a column may have.
///
/// # Arguments
/// - `read`: what the table may hold.
/// - `stamp`: what its cells state of a time, if they are no numbers.
pub(super) fn roles_of(
    column: &FileColumn,
    read: &ReadQuantities,
    stamp: Option<StampKind>,
) -> Vec<RoleGuess> {
    let plain = plain(&column.stem);
    let words: Vec<&str> = words_of(&plain).collect();
    let sure = |list: &str| match words.as_slice() {
        [one] if has(list, one) => Some(3),
        _ if words.iter().any(|word| has(list, word)) => Some(2),
        _ => None,
    };
    let surest = |lists: &[&str]| lists.iter().filter_map(|list| sure(list)).max();
    if stamp == Some(StampKind::Date) {
        return vec![(ColumnRole::Date, 3)];
    }
    if stamp.is_some() || has(TIME, &plain) {
        return vec![(ColumnRole::Time, 3)];
    }
    let unit = column.unit.as_deref();
    let of_kind = |kind| unit.is_some_and(|unit| is_of(kind, unit));
    if column.is_numeric && of_kind(Kind::Time) {
        return vec![(ColumnRole::Time, sure(TIME).unwrap_or(1))];
    }
    if !read.has_joints
        && let Some(sure) = sure(SPECIMEN).filter(|_| unit.is_none())
    {
        return vec![(ColumnRole::Configuration, sure)];
    }
    if !column.is_numeric {
        // What tells joined files and sheets apart.
        if matches!(column.name.as_str(), "file" | "sheet") {
            return vec![(ColumnRole::Repeat, 1)];
        }
        let named = [
            (ColumnRole::Pose, POSE),
            (ColumnRole::Direction, DIRECTION),
            (ColumnRole::Repeat, REPEAT),
            (ColumnRole::Branch, BRANCH),
        ];
        let named = named.into_iter();
        return named
            .filter_map(|(role, list)| Some((role, sure(list)?)))
            .collect();
    }
    let joint = joint_name(&plain, &column.stem).filter(|_| read.has_joints);
    if let Some(joint) = joint {
        return vec![(ColumnRole::Joint(joint), 3)];
    }
    let is_read = !words.iter().any(|word| has(NOT_READ, word));
    if is_read && read.force.0.iter().copied().any(of_kind) {
        return vec![(ColumnRole::Force, 1 + surest(read.force.1).unwrap_or(0))];
    }
    if is_read && read.displacement.0.iter().copied().any(of_kind) {
        // Gauges that go by a name come before those by their number alone.
        let has_name = words
            .iter()
            .any(|word| !word.bytes().all(|b| b.is_ascii_digit()));
        return vec![(
            ColumnRole::Displacement,
            u8::from(has_name) + surest(read.displacement.1).unwrap_or(0),
        )];
    }
    let has_known_unit = Kind::ALL.into_iter().any(of_kind);
    let one_word = words.len() == 1;
    let letter = one_word && has(DISPLACEMENT_LETTERS, words[0]);
    let numeric = [
        (ColumnRole::Force, surest(read.force.1).filter(|_| is_read)),
        (
            ColumnRole::Displacement,
            surest(read.displacement.1)
                .filter(|_| is_read && !has_known_unit && sure(POSE).is_none())
                .or(letter.then_some(1)),
        ),
        (ColumnRole::Repeat, sure(REPEAT).filter(|_| !has_known_unit)),
        (ColumnRole::Pose, sure(POSE).filter(|_| !has_known_unit)),
        (ColumnRole::Time, sure(TIME).filter(|_| unit.is_none())),
        (ColumnRole::Temperature, sure(TEMPERATURE)),
        (
            ColumnRole::Direction,
            sure(DIRECTION).filter(|_| !has_known_unit),
        ),
    ];
    let numeric = numeric.into_iter();
    numeric
        .filter_map(|(role, sure)| Some((role, sure?)))
        .collect()
}

/// The variable of a column with joint values: `q1`, `J2`, `joint_J1`, `Achse 3`, `axis 1`, `theta2`.
pub(super) fn joint_name(plain: &str, stem: &str) -> Option<String> {
    if let Some(rest) = stem
        .get(..6)
        .filter(|head| head.eq_ignore_ascii_case("joint_"))
    {
        return Some(stem[rest.len()..].to_owned()).filter(|name| !name.is_empty());
    }
    const NAMES: [&str; 11] = [
        "joint", "gelenk", "achse", "axis", "axe", "asse", "eje", "theta", "q", "j", "a",
    ];
    let digits = plain.find(|c: char| c.is_ascii_digit())?;
    let (word, number) = plain.split_at(digits);
    let word = word.trim_end_matches([' ', '_', '-']);
    let is_number = number.len() <= 2 && number.bytes().all(|b| b.is_ascii_digit());
    let short = word.len() == 1;
    (is_number && NAMES.contains(&word)).then(|| {
        if short {
            stem.trim().to_owned()
        } else {
            format!("q{number}")
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn best(stem: &str, unit: Option<&str>, is_numeric: bool) -> Option<ColumnRole> {
        let column = FileColumn {
            name: stem.to_owned(),
            stem: stem.to_owned(),
            unit: unit.map(str::to_owned),
            unit_from: None,
            is_numeric,
        };
        let roles = roles_of(&column, &OF_A_ROBOT, None);
        roles
            .into_iter()
            .max_by_key(|(_, sure)| *sure)
            .map(|(role, _)| role)
    }

    #[test]
    fn columns_in_five_languages() {
        for (names, role) in [
            (
                "Force,Kraft,Forza,Fuerza,Load,Last,Charge,Carico,Carga,Axial Force,Prüfkraft,F",
                ColumnRole::Force,
            ),
            (
                "Displacement,Weg,Verschiebung,Déplacement,Spostamento,Desplazamiento,Travel,x",
                ColumnRole::Displacement,
            ),
            (
                "Repeat,Wiederholung,Répétition,Ripetizione,Repetición,run",
                ColumnRole::Repeat,
            ),
            ("Time,Zeit,Temps,Tempo,Tiempo,X_Value", ColumnRole::Time),
            (
                "Temperature,Temperatur,Temperatura",
                ColumnRole::Temperature,
            ),
        ] {
            for name in names.split(',') {
                assert_eq!(best(name, None, true), Some(role.clone()), "{name}");
            }
        }
        for (names, role) in [
            (
                "Pose,Posture,Posa,Postura,Position,Stellung",
                ColumnRole::Pose,
            ),
            (
                "Direction,Richtung,Direzione,Dirección,Achse",
                ColumnRole::Direction,
            ),
            ("branch,Ast,Branche", ColumnRole::Branch),
        ] {
            for name in names.split(',') {
                assert_eq!(best(name, None, false), Some(role.clone()), "{name}");
            }
        }
    }

    #[test]
    fn units_and_joints() {
        assert_eq!(best("Kanal 1", Some("kgf"), true), Some(ColumnRole::Force));
        assert_eq!(
            best("Position", Some("mm"), true),
            Some(ColumnRole::Displacement)
        );
        assert_eq!(best("Position", None, true), Some(ColumnRole::Pose));
        assert_eq!(best("Soll-Kraft", Some("N"), true), None);
        for (name, joint) in [
            ("q1", "q1"),
            ("J2", "J2"),
            ("Achse 3", "q3"),
            ("joint_q4", "q4"),
        ] {
            let joint = ColumnRole::Joint(joint.to_owned());
            assert_eq!(best(name, Some("deg"), true), Some(joint), "{name}");
        }
        assert_eq!(best("a", None, true), None);
    }

    #[test]
    fn a_part_has_torques_angles_stresses_and_strains() {
        let role = |stem: &str, unit: Option<&str>| {
            let column = FileColumn {
                name: stem.to_owned(),
                stem: stem.to_owned(),
                unit: unit.map(str::to_owned),
                unit_from: None,
                is_numeric: true,
            };
            let roles = roles_of(&column, &OF_A_PART, None);
            roles.into_iter().next().map(|(role, _)| role)
        };
        for (stem, unit) in [
            ("torque", Some("Nm")),
            ("M", Some("N*m")),
            ("Spannung", Some("MPa")),
            ("Force", Some("N")),
        ] {
            assert_eq!(role(stem, unit), Some(ColumnRole::Force), "{stem}");
        }
        for (stem, unit) in [
            ("angle", Some("deg")),
            ("q1", Some("rad")),
            ("strain", None),
            ("travel", Some("mm")),
        ] {
            assert_eq!(role(stem, unit), Some(ColumnRole::Displacement), "{stem}");
        }
    }
}
