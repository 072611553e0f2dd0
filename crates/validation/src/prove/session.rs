//! A concealed session, ready to be diagnosed.

use std::io::Cursor;

use stiffbench::analysis::Failure;
use stiffbench::bench::{Jack, NoiseModel, VirtualBench};
use stiffbench_beams::physics::ActingPhysics;
use stiffbench_beams::robot::{FittingFactors, Pose, Robot};
use stiffbench_diagnosis::fit::usual_parameters;
use stiffbench_diagnosis::mismatch::{Observations, RobotBaseline};
use stiffbench_diagnosis::parameters::ParameterChoice;
use stiffbench_measurement::procedure::Procedure;
use stiffbench_measurement::readings::{ReadingTable, SessionHeader, read_readings};
use stiffbench_units_and_text::source_text::SourceText;

use super::error::ProveError;

/// The texts of a session.
#[derive(Debug, Clone)]
pub struct SessionTexts {
    /// Name of the session.
    pub id: String,
    /// `session.toml`.
    pub header: SourceText,
    /// `readings.csv`.
    pub readings: String,
    /// The robot file that the header names.
    pub robot: SourceText,
}

/// A session with its robot.
#[derive(Debug)]
pub struct ValidationSession {
    /// Its name.
    pub id: String,
    /// Its robot.
    pub robot: Robot,
    /// Its mechanism.
    pub mechanism: String,
    /// Where its factors start.
    pub factors: FittingFactors,
    /// Its readings.
    pub observations: Observations,
    /// Which parameters are free in its baseline.
    choice: ParameterChoice,
    poses: Vec<Pose>,
}

impl ValidationSession {
    /// Reads the texts of a session.
    ///
    /// # Errors
    /// If a text is not what it must be.
    pub fn read(texts: &SessionTexts) -> Result<Self, Failure> {
        let robot = Robot::parse(&texts.robot)?;
        let header = SessionHeader::from_toml(&texts.header.name, &texts.header.text)?.header;
        let readings = Cursor::new(texts.readings.as_bytes());
        let table = read_readings(&texts.id, readings)?;
        let factors = match &header.factors {
            Some(name) => robot.factor_set(name)?,
            None => robot.default_factors().1,
        };
        let choice = ParameterChoice::default();
        Self::of_table(robot, (factors, choice), &table, &header)
    }

    /// The plan of a robot in its named poses by a procedure, without noise. Where the robot file frees springs, they are free in the
    /// baseline and the factors of beams are fixed.
    ///
    /// # Errors
    /// For a robot, mechanism or procedure that cannot be.
    pub fn planned(
        source: &SourceText,
        mechanism: Option<&str>,
        procedure: &Procedure,
    ) -> Result<Self, Failure> {
        let robot = Robot::parse(source)?;
        let chosen = robot.mechanism(mechanism)?;
        let factors = robot.with_own_springs(&robot.default_factors().1);
        let choice = usual_parameters(&robot, chosen);
        let physics = ActingPhysics::new(&robot, chosen, Vec::new())?;
        let noise = NoiseModel::NONE;
        let table = VirtualBench::new(&robot, &physics, &factors, noise, Jack::default())?.run(
            procedure,
            &procedure.name,
            0,
        )?;
        let header = SessionHeader {
            mechanism: Some(chosen.name.clone()),
            procedure: Some(procedure.to_record()),
            ..SessionHeader::default()
        };
        Self::of_table(robot, (factors, choice), &table, &header)
    }

    fn of_table(
        robot: Robot,
        (factors, choice): (FittingFactors, ParameterChoice),
        table: &ReadingTable,
        header: &SessionHeader,
    ) -> Result<Self, Failure> {
        let mechanism = robot.mechanism(header.mechanism.as_deref())?.name.clone();
        let observations = Observations::new(table, Some(header));
        let poses = observations
            .poses
            .iter()
            .map(|pose| robot.pose(pose).cloned())
            .collect::<Result<_, _>>()?;
        Ok(Self {
            id: table.source.clone(),
            robot,
            mechanism,
            factors,
            observations,
            choice,
            poses,
        })
    }

    /// The beam model that the readings are compared with.
    ///
    /// # Errors
    /// If it cannot be computed.
    pub fn baseline(&self) -> Result<RobotBaseline<'_>, Failure> {
        let mechanism = self.robot.mechanism(Some(&self.mechanism))?;
        Ok(RobotBaseline::new(
            &self.robot,
            mechanism,
            self.factors.clone(),
            self.poses.clone(),
            &self.choice,
            self.observations.largest_m_per_n(0.0),
        )?)
    }

    /// Robot and mechanism in words.
    #[must_use]
    pub fn bench(&self) -> String {
        format!("{} {}", self.robot.name, self.mechanism)
    }
}

/// The readings of a plan with fewer poses or repeats: rows of a table whose columns `pose` and `repeat` are named so.
///
/// # Errors
/// [`ProveError::Form`] if the table has no such columns.
pub fn fewer_readings(
    texts: &SessionTexts,
    poses: Option<usize>,
    repeats: Option<u32>,
) -> Result<SessionTexts, ProveError> {
    let mut lines = texts.readings.lines();
    let heads: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = |name: &str| {
        heads
            .iter()
            .position(|head| *head == name)
            .ok_or_else(|| ProveError::Form {
                file: format!("readings of session {}", texts.id),
                problem: format!("there is no column {name}"),
            })
    };
    let (pose_column, repeat_column) = (column("pose")?, column("repeat")?);
    let mut kept_poses: Vec<&str> = Vec::new();
    let mut kept = vec![heads.join(",")];
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        let pose = fields.get(pose_column).copied().unwrap_or_default();
        if !kept_poses.contains(&pose) {
            kept_poses.push(pose);
        }
        let repeat: Option<u32> = fields.get(repeat_column).and_then(|f| f.parse().ok());
        let known = kept_poses.iter().position(|known| *known == pose);
        let few_poses = poses.is_none_or(|most| known.is_some_and(|place| place < most));
        let few_repeats = repeats.is_none_or(|most| repeat.is_some_and(|r| r <= most));
        if few_poses && few_repeats {
            kept.push(line.to_owned());
        }
    }
    Ok(SessionTexts {
        readings: kept.join("\n") + "\n",
        ..texts.clone()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plans_are_cut_to_poses_and_repeats() {
        let texts = SessionTexts {
            id: "x".to_owned(),
            header: SourceText::new("", ""),
            readings: "pose,direction,repeat\nP1,x,1\nP1,x,4\nP2,x,1\nP1,y,1\n".to_owned(),
            robot: SourceText::new("", ""),
        };
        let cut = |poses, repeats| fewer_readings(&texts, poses, repeats).unwrap().readings;
        assert_eq!(
            cut(Some(1), None),
            "pose,direction,repeat\nP1,x,1\nP1,x,4\nP1,y,1\n"
        );
        assert_eq!(
            cut(None, Some(3)),
            "pose,direction,repeat\nP1,x,1\nP2,x,1\nP1,y,1\n"
        );
        let none = SessionTexts {
            readings: "a,b\n".to_owned(),
            ..texts.clone()
        };
        assert!(matches!(
            fewer_readings(&none, None, None),
            Err(ProveError::Form { .. })
        ));
    }
}
