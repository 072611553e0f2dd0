//! What a column may be, by the words of its name in English, German, French, Italian and Spanish.

use stiffbench_units_and_text::quantity::Kind;

use super::columns::ColumnRole;
use crate::readings::Conversion;
use crate::table_files::{FileColumn, StampKind};

const FORCE: &str = "force kraft fuerza forza load last charge carico carga effort prufkraft standardkraft normalkraft f";
const DISPLACEMENT: &str = "displacement disp weg verschiebung deplacement spostamento desplazamiento deflection travel extension \
     auslenkung durchbiegung traversenweg standardweg stroke crosshead deformation verformung fleche course corsa freccia flecha \
     recorrido carrera messuhr dial comparateur comparatore comparador position posicion posizione";
const DISPLACEMENT_LETTERS: &str = "x d s u w delta";
const POSE: &str = "pose pos stellung haltung posture posa postura position posicion posizione configuration konfiguration punkt messpunkt point \
     punto lage";
const DIRECTION: &str =
    "direction richtung direzione direccion dir axis achse axe asse eje sens verso";
const REPEAT: &str = "repeat rep repetition wiederholung wdh ripetizione repeticion repetibilite run lauf trial series essai serie prova ensayo versuch durchgang durchlauf messreihe \
     cycle zyklus ciclo messung mesure misura medida segment";
const BRANCH: &str = "branch ast branche ramo rama";
const TIME: &str =
    "time zeit temps tempo tiempo timestamp zeitstempel uhrzeit heure ora hora date datum x_value";
const TEMPERATURE: &str = "temperature temp temperatur temperatura";

/// Words of columns that hold a plan, a limit or a rate rather than what was read.
const NOT_READ: &str = "soll sollwert target setpoint nominal consigne objetivo max min maximum minimum peak sd std stdev error fehler rate speed \
     geschwindigkeit vitesse velocita velocidad";

/// A role with how sure it is, from 1.
pub(super) type RoleGuess = (ColumnRole, u8);

/// Whether `unit` is one of this kind.
pub(super) fn is_of(kind: Kind, unit: &str) -> bool {
    Conversion::from_unit(kind, unit).is_some()
}

fn has(words: &str, word: &str) -> bool {
    words.split_whitespace().any(|known| known == word)
}

/// The roles a column may have.
///
/// # Arguments
/// - `stamp`: what its cells state of a time, if they are no numbers.
pub(super) fn roles_of(column: &FileColumn, stamp: Option<StampKind>) -> Vec<RoleGuess> {
    let plain = plain(&column.stem);
    let words: Vec<&str> = plain
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .collect();
    let sure = |list: &str| match words.as_slice() {
        [one] if has(list, one) => Some(3),
        _ if words.iter().any(|word| has(list, word)) => Some(2),
        _ => None,
    };
    if stamp == Some(StampKind::Date) {
        return vec![(ColumnRole::Date, 3)];
    }
    if stamp.is_some() || has(TIME, &plain) {
        return vec![(ColumnRole::Time, 3)];
    }
    let unit = column.unit.as_deref();
    let of_kind = |kind| unit.is_some_and(|unit| is_of(kind, unit));
    if !column.is_numeric {
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
    if let Some(joint) = joint_name(&plain, &column.stem) {
        return vec![(ColumnRole::Joint(joint), 3)];
    }
    let is_read = !words.iter().any(|word| has(NOT_READ, word));
    if is_read && of_kind(Kind::Force) {
        return vec![(ColumnRole::Force, 1 + sure(FORCE).unwrap_or(0))];
    }
    if is_read && of_kind(Kind::Displacement) {
        return vec![(
            ColumnRole::Displacement,
            1 + sure(DISPLACEMENT).unwrap_or(0),
        )];
    }
    let has_known_unit = Kind::ALL.into_iter().any(of_kind);
    let one_word = words.len() == 1;
    let letter = one_word && has(DISPLACEMENT_LETTERS, words[0]);
    let numeric = [
        (ColumnRole::Force, sure(FORCE).filter(|_| is_read)),
        (
            ColumnRole::Displacement,
            sure(DISPLACEMENT)
                .filter(|_| is_read && !has_known_unit && sure(POSE).is_none())
                .or(letter.then_some(1)),
        ),
        (ColumnRole::Repeat, sure(REPEAT)),
        (ColumnRole::Pose, sure(POSE)),
        (
            ColumnRole::Time,
            sure(TIME).filter(|_| unit.is_none() || of_kind(Kind::Time)),
        ),
        (ColumnRole::Time, of_kind(Kind::Time).then_some(1)),
        (ColumnRole::Temperature, sure(TEMPERATURE)),
        (ColumnRole::Direction, sure(DIRECTION)),
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

/// Small letters without accents.
pub(super) fn plain(text: &str) -> String {
    let letters = text.trim().chars().flat_map(char::to_lowercase);
    letters
        .map(|c| match c {
            'ä' | 'á' | 'à' | 'â' | 'ã' => 'a',
            'é' | 'è' | 'ê' | 'ë' => 'e',
            'í' | 'ì' | 'î' | 'ï' => 'i',
            'ö' | 'ó' | 'ò' | 'ô' | 'õ' => 'o',
            'ü' | 'ú' | 'ù' | 'û' => 'u',
            'ç' => 'c',
            'ñ' => 'n',
            other => other,
        })
        .collect()
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
        let roles = roles_of(&column, None);
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
}
