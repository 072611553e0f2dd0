//! What a result was made of: data, robot, mechanism and factors, with their hashes. It stands before every result.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::plot::Figure;
use crate::readings::{OverdueGauge, SessionHeader};
use crate::robot::{FittingFactors, Robot};
use crate::session::read_inside;

use super::data::{Data, LoadedSession, gauges_text};
use super::hash::sha256;
use super::model::ResolvedModel;
use super::session_table::SessionTable;

/// Digits of a hash in text; JSON has them all.
const SHORT_HASH: usize = 12;

/// The inputs of a result.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Inputs {
    /// Readings or stiffness values.
    data: Vec<DataInput>,
    /// The robot file.
    robot: Option<NamedInput>,
    /// Mechanisms of the robot.
    mechanisms: Vec<String>,
    /// The factors of the model, or those that a fit starts from.
    factors: Option<NamedInput>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct NamedInput {
    name: String,
    sha256: String,
    /// The configuration file or variable that named it.
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<String>,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct DataInput {
    name: String,
    sha256: String,
    /// How the readings came about if they were not measured.
    origin: Option<String>,
    /// The file that they were imported from, if they were.
    #[serde(skip_serializing_if = "Option::is_none")]
    imported: Option<String>,
    /// Calibrations of gauges that were given beside the data.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    calibration: Vec<String>,
    /// Gauges whose calibration is overdue; among the warnings in JSON.
    #[serde(skip)]
    overdue: Vec<OverdueGauge>,
}

impl Inputs {
    /// SHA-256 of each of the data, in hexadecimal.
    pub fn hashes_of_data(&self) -> impl Iterator<Item = &str> {
        self.data.iter().map(|data| &*data.sha256)
    }

    /// Name of the robot and SHA-256 of its file, if there is one.
    #[must_use]
    pub fn robot(&self) -> Option<(&str, &str)> {
        let robot = self.robot.as_ref()?;
        Some((&robot.name, &robot.sha256))
    }

    /// Readings.
    #[must_use]
    pub fn with_session(self, session: &LoadedSession) -> Self {
        let mut inputs = self.with_table(session);
        if let Some(input) = inputs.data.last_mut() {
            input.imported = session.header.as_ref().and_then(imported);
        }
        inputs
    }

    /// Data to fit or to diagnose.
    #[must_use]
    pub fn with_data(self, data: &Data) -> Self {
        match data {
            Data::Readings(all) => all.iter().fold(self, Self::with_session),
            Data::LoadCases(all) => all.iter().fold(self, Self::with_table),
            Data::Stiffness { name, sha256, .. } => self.with_list(name, sha256),
        }
    }

    /// A table of vectors or load cases.
    #[must_use]
    pub fn with_table<T>(mut self, session: &SessionTable<T>) -> Self {
        self.data.push(DataInput {
            name: session.name.clone(),
            sha256: session.sha256.clone(),
            origin: session.origin.clone(),
            calibration: session.calibration.clone(),
            overdue: session.overdue.clone(),
            imported: None,
        });
        self
    }

    /// A session folder: its table, if there is one yet, and what its header says of the model.
    #[must_use]
    pub fn with_folder(mut self, folder: &Path, header: &SessionHeader) -> Self {
        if let Ok(table) = read_inside(folder, "readings.csv") {
            self.data.push(DataInput {
                name: folder.display().to_string(),
                sha256: sha256(table),
                origin: header.origin.clone(),
                ..DataInput::default()
            });
        }
        if let (Some(name), Some(hash)) = (&header.robot, &header.robot_sha256) {
            self.robot = Some(NamedInput {
                name: name.clone(),
                sha256: hash.clone(),
                from: None,
            });
        }
        self.mechanisms.extend(header.mechanism.clone());
        self
    }

    /// Stiffness values, by name and text.
    #[must_use]
    pub fn with_list(mut self, name: &str, sha256: &str) -> Self {
        self.data.push(DataInput {
            name: name.to_owned(),
            sha256: sha256.to_owned(),
            origin: None,
            ..DataInput::default()
        });
        self
    }

    /// A robot with one mechanism and its factors.
    #[must_use]
    pub fn with_model(self, chosen: &ResolvedModel) -> Self {
        let mut inputs = self.with_robot(&chosen.robot, &chosen.source.text);
        if let Some(robot) = &mut inputs.robot {
            robot.from.clone_from(&chosen.robot_from);
        }
        inputs
            .with_factors(&chosen.factors_name, &chosen.factors)
            .with_mechanism(&chosen.mechanism)
    }

    /// A robot and the text of its file.
    #[must_use]
    pub fn with_robot(mut self, robot: &Robot, text: &str) -> Self {
        self.robot = Some(NamedInput {
            name: robot.name.clone(),
            sha256: sha256(text),
            from: None,
        });
        self
    }

    /// Factors, by the name of their set.
    #[must_use]
    pub fn with_factors(mut self, name: &str, factors: &FittingFactors) -> Self {
        self.factors = Some(NamedInput {
            name: name.to_owned(),
            sha256: sha256(factors.to_toml()),
            from: None,
        });
        self
    }

    /// A mechanism of the robot.
    #[must_use]
    pub fn with_mechanism(mut self, name: &str) -> Self {
        self.mechanisms.push(name.to_owned());
        self
    }

    /// What the user called the first data; empty without data.
    pub(super) fn data_name(&self) -> &str {
        self.data.first().map_or("", |data| &data.name)
    }

    /// The lines before a result, with a blank one behind them; empty without inputs.
    #[must_use]
    pub fn text(&self) -> String {
        let lines = self.lines();
        if lines.is_empty() {
            return String::new();
        }
        lines.join("\n") + "\n\n"
    }

    /// The figure with its inputs before the caption.
    #[must_use]
    pub fn on(&self, figure: &Figure) -> Figure {
        let lines = self.lines().into_iter();
        let mut words: Vec<String> = lines.map(|line| line + ".").collect();
        words.extend((!figure.caption.is_empty()).then(|| figure.caption.clone()));
        Figure {
            caption: words.join(" "),
            ..figure.clone()
        }
    }

    /// One line for each table of data and one for the model.
    fn lines(&self) -> Vec<String> {
        let data = self.data.iter();
        let data = data.map(|data| format!("Data: {}", data.words()));
        data.chain(self.model_words()).collect()
    }

    fn model_words(&self) -> Option<String> {
        let robot = self.robot.as_ref()?.words();
        let mechanisms = match self.mechanisms.as_slice() {
            [] => String::new(),
            [one] => format!(", mechanism {one}"),
            several => format!(", mechanisms {}", several.join(", ")),
        };
        let factors = self.factors.as_ref();
        let factors = factors.map_or_else(String::new, |factors| {
            format!(", factors {}", factors.words())
        });
        Some(format!("Robot: {robot}{mechanisms}{factors}"))
    }
}

impl NamedInput {
    fn words(&self) -> String {
        let words = format!("{} ({})", self.name, short(&self.sha256));
        match &self.from {
            Some(from) => format!("{words} from {from}"),
            None => words,
        }
    }
}

impl DataInput {
    fn words(&self) -> String {
        let words = format!("{} ({})", self.name, short(&self.sha256));
        let origin = self.origin.iter();
        let origin = origin.map(|origin| format!(", NOT MEASURED: {origin}"));
        let imported = self.imported.iter().map(|words| format!(", {words}"));
        let calibration = self.calibration.iter().map(|words| format!("; {words}"));
        let overdue = (!self.overdue.is_empty()).then(|| gauges_text(&self.overdue));
        let overdue = overdue.map(|gauges| format!(", CALIBRATION OVERDUE: {gauges}"));
        let marks = origin.chain(overdue).chain(imported).chain(calibration);
        let marks: Vec<String> = marks.collect();
        words + &marks.concat()
    }
}

/// The mark of readings that no session measured.
fn imported(header: &SessionHeader) -> Option<String> {
    let record = header.import.as_ref()?;
    let source = record.source.as_deref().unwrap_or("a file");
    let hash = record.source_sha256.as_deref().map(short);
    let hash = hash.map_or_else(String::new, |hash| format!(" ({hash})"));
    Some(format!("imported from {source}{hash}, not protected"))
}

fn short(hash: &str) -> &str {
    hash.get(..SHORT_HASH).unwrap_or(hash)
}
