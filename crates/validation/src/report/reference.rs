//! The paper's Table IV repeated: the 36-element model fitted to one pose beside a reference of solids.
//!
//! A second table states what the reference is worth: beams with the constants of the prisms and with shear, which solids of slender
//! members must come near, and the beams of the robot file before any fit.

use std::fmt::Write;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::reference::{
    PoseModel, ReferenceCell, ReferenceModel, ReferenceRecord, RunBy, beams_of_the_prisms,
};
use stiffbench::fit::{
    CellModel, FitError, MeasuredCell, MeasuredStiffness, MonteCarloSettings, WeightBasis,
    fit_single_source,
};
use stiffbench::robot::{
    FittingFactors, JointModel, Mechanism, MechanismModel, Robot, RobotError, Theory,
};
use stiffbench::structure::{Solver, StructureError};
use stiffbench::test_point::{Cell, Direction, PoseId};

use super::table_iv::{PaperRow, PaperTableIv};
use stiffbench::report::{Table, significant};

const UM_PER_M: f64 = 1e6;

/// A model that was written.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReferenceExport {
    /// Its folder.
    pub folder: PathBuf,
    /// The model.
    pub model: ReferenceModel,
}

/// What CalculiX made of a model.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReferenceRun {
    /// Folder of the model.
    pub folder: PathBuf,
    /// Program, version and machine.
    pub run: RunBy,
    /// Displacements.
    pub cells: Vec<ReferenceCell>,
}

/// Fitted beams beside a reference, and the paper's table of the same.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReferenceSummary {
    /// The model.
    pub reference: ReferenceModel,
    /// Program, version and machine.
    pub run: RunBy,
    /// Each pose.
    pub poses: Vec<ReferencePoseSummary>,
    /// Time of one solution of the fitted beams, s.
    #[serde(rename = "fitted_s")]
    pub seconds_per_solve: f64,
    /// What the paper prints.
    pub paper: PaperReferenceSummary,
}

/// One pose of a reference.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReferencePoseSummary {
    /// Name.
    pub pose: String,
    /// Solid elements.
    pub elements: usize,
    /// Their nodes.
    pub nodes: usize,
    /// Beam elements.
    pub beams: usize,
    /// Factors fitted to the smallest loads.
    pub factors: ReferenceFactors,
    /// Directions that no value of their factor brings to the reference.
    pub misses: Vec<String>,
    /// Each load.
    pub rows: Vec<ReferenceRowSummary>,
    /// Largest distance of the fitted beams from the reference, percent; `null` without a load.
    pub largest_difference_percent: Option<f64>,
    /// Fewest percent of the reference's time that the fitted beams save.
    pub time_saved_percent: f64,
}

/// Factors of one pose.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[serde(rename_all = "PascalCase")]
pub struct ReferenceFactors {
    /// Of the area.
    pub a: f64,
    /// Of the second moment about y.
    pub iy: f64,
    /// Of the second moment about z.
    pub iz: f64,
    /// Of the torsion constant.
    pub j: f64,
}

/// Displacement under one load, by each model.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ReferenceRowSummary {
    /// Direction of force.
    pub direction: String,
    /// Force, N.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// By the reference, µm.
    pub reference_um: f64,
    /// By the fitted beams, µm.
    pub fitted_um: f64,
    /// How far the fitted beams lie from the reference, percent.
    pub difference_percent: f64,
    /// By the beams with the factors that the reference was written with, µm.
    pub unfitted_um: f64,
    /// By beams with the constants of the prisms and with shear, µm.
    pub prisms_um: f64,
    /// Time of the reference, s.
    pub reference_s: f64,
}

/// The paper's own reference and fitted beams.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct PaperReferenceSummary {
    /// Elements of its reference.
    pub elements: usize,
    /// Beam elements.
    pub beams: usize,
    /// Fewest percent of the reference's time that its beams save.
    pub time_saved_percent: f64,
    /// Largest distance of its beams from its reference, percent.
    pub largest_difference_percent: f64,
}

/// Fits single-pose factors to the smallest loads of each pose and compares every load with them; `timed` times a solution of the first
/// pose, s.
///
/// # Errors
/// [`FitError`] if a pose of the reference lacks a direction, or the robot a pose.
pub fn reference_summary(
    robot: &Robot,
    mechanism: &Mechanism,
    record: &ReferenceRecord,
    timed: impl Fn(&ReferencePoseSummary) -> Result<f64, FitError>,
) -> Result<ReferenceSummary, FitError> {
    let with_results = |model: &&PoseModel| {
        let mut cells = record.cells.iter();
        cells.any(|cell| cell.pose == model.pose)
    };
    let poses = record.model.poses.iter().filter(with_results);
    let mut poses = poses
        .map(|model| compare_pose(robot, mechanism, record, model))
        .collect::<Result<Vec<_>, _>>()?;
    let seconds_per_solve = match poses.first() {
        Some(pose) => timed(pose)?,
        None => f64::NAN,
    };
    for pose in &mut poses {
        let times = pose.rows.iter().map(|row| row.reference_s);
        let fastest_s = times.fold(f64::INFINITY, f64::min);
        pose.time_saved_percent = 100.0 * (1.0 - seconds_per_solve / fastest_s);
    }
    let paper = PaperTableIv::printed();
    let [elements, beams] = paper.cells;
    Ok(ReferenceSummary {
        reference: record.model.clone(),
        run: record.run.clone(),
        poses,
        seconds_per_solve,
        paper: PaperReferenceSummary {
            elements,
            beams,
            time_saved_percent: paper.time_saved_percent(),
            largest_difference_percent: paper.largest_percent(),
        },
    })
}

fn compare_pose(
    robot: &Robot,
    mechanism: &Mechanism,
    record: &ReferenceRecord,
    model: &PoseModel,
) -> Result<ReferencePoseSummary, FitError> {
    let pose = PoseId::new(&model.pose);
    let cells = record.cells.iter();
    let cells: Vec<&ReferenceCell> = cells.filter(|cell| cell.pose == model.pose).collect();
    let fits = fit_single_source(
        robot,
        mechanism,
        &smallest_loads(&cells),
        &[(pose.clone(), 1.0)],
        &MonteCarloSettings::default(),
    )?;
    let factors = &fits[0].fit.factors;
    let [beam, link] = record.model.factor_values;
    let written = FittingFactors::of_classes(beam, link);
    let fitted = compliance(robot, mechanism, &pose, factors)?;
    let unfitted = compliance(robot, mechanism, &pose, &written)?;
    let prisms = prism_compliance(robot, mechanism, &pose, &written)?;
    let row = |cell: &&ReferenceCell| {
        let axis = axis(cell).index();
        let um = |m_per_n: [f64; 3]| cell.force_n * m_per_n[axis] * UM_PER_M;
        let reference_um = cell.displacement_um[axis];
        ReferenceRowSummary {
            direction: cell.direction.clone(),
            force_n: cell.force_n,
            reference_um,
            fitted_um: um(fitted),
            difference_percent: 100.0 * (um(fitted) / reference_um - 1.0),
            unfitted_um: um(unfitted),
            prisms_um: um(prisms),
            reference_s: cell.seconds,
        }
    };
    let rows: Vec<ReferenceRowSummary> = cells.iter().map(row).collect();
    let sizes = rows.iter().map(|row| row.difference_percent.abs());
    let [a, iy, iz, j] = factors.beam;
    Ok(ReferencePoseSummary {
        pose: model.pose.clone(),
        elements: model.elements,
        nodes: model.nodes,
        beams: record.model.beams,
        factors: ReferenceFactors { a, iy, iz, j },
        misses: fits[0].misses(),
        largest_difference_percent: sizes.max_by(f64::total_cmp),
        rows,
        time_saved_percent: f64::NAN,
    })
}

fn axis(cell: &ReferenceCell) -> Direction {
    cell.direction
        .parse()
        .expect("a record that was read has directions x, y, z")
}

/// Stiffness under the smallest load of each direction, as the paper fits it at 50 N.
fn smallest_loads(cells: &[&ReferenceCell]) -> MeasuredStiffness {
    let of = |wanted: Direction| {
        cells
            .iter()
            .filter(|cell| axis(cell) == wanted)
            .min_by(|a, b| a.force_n.abs().total_cmp(&b.force_n.abs()))
            .map(|cell| MeasuredCell {
                cell: Cell::new(PoseId::new(&cell.pose), wanted),
                line: 0,
                stiffness_n_per_m: cell.force_n / cell.displacement_um[wanted.index()] * UM_PER_M,
                ln_uncertainty: None,
                reading_noise: None,
            })
    };
    MeasuredStiffness {
        cells: Direction::ALL.into_iter().filter_map(of).collect(),
        basis: WeightBasis::Equal,
        ..MeasuredStiffness::default()
    }
}

/// Displacement per force along each axis, m/N, as the fits work it out.
fn compliance(
    robot: &Robot,
    mechanism: &Mechanism,
    pose: &PoseId,
    factors: &FittingFactors,
) -> Result<[f64; 3], FitError> {
    let cells = Direction::ALL.map(|direction| Cell::new(pose.clone(), direction));
    let stiffness = CellModel::new(robot, mechanism, &[], &cells)?.stiffness(factors)?;
    Ok([0, 1, 2].map(|i| 1.0 / stiffness[i]))
}

/// The same of beams with the constants of the prisms, shear included.
fn prism_compliance(
    robot: &Robot,
    mechanism: &Mechanism,
    pose: &PoseId,
    factors: &FittingFactors,
) -> Result<[f64; 3], RobotError> {
    let mut model = MechanismModel::new(
        robot,
        mechanism,
        &JointModel::Rigid,
        Theory::Timoshenko,
        factors,
    )?;
    model.place(robot.pose(pose)?)?;
    let structure = beams_of_the_prisms(model.structure());
    let wrong = |source: StructureError| RobotError::Structure {
        mechanism: mechanism.name.clone(),
        source,
    };
    let mut solver = Solver::new(&structure).map_err(wrong)?;
    solver.update(&structure).map_err(wrong)?;
    let found = solver.end_translation_compliance();
    Ok([0, 1, 2].map(|i| found[i][i]))
}

/// A number with so many decimals, and no minus before what rounds to zero.
fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| c == '0' || c == '.') => digits.to_owned(),
        _ => text,
    }
}

impl ReferenceFactors {
    /// The same for beams and links.
    #[must_use]
    pub fn of_both_classes(&self) -> FittingFactors {
        let Self { a, iy, iz, j } = *self;
        FittingFactors::of_classes([a, iy, iz, j], [a, iy, iz, j])
    }
}

impl ReferenceRowSummary {
    fn load(&self) -> String {
        format!("{} {}", self.direction, self.force_n)
    }
}

impl ReferencePoseSummary {
    /// Table IV with the paper's columns beside ours.
    fn table(&self, seconds_per_solve: f64, paper: &PaperTableIv) -> Table {
        let printed = |row: &ReferenceRowSummary, value: fn(&PaperRow) -> f64, decimals| {
            let direction = row.direction.parse().ok();
            let printed = direction.and_then(|direction| paper.row(direction, row.force_n));
            printed.map_or_else(|| "-".to_owned(), |row| fixed(value(row), decimals))
        };
        Table::of(&self.rows)
            .words("force, N", |row| row.load())
            .numbers("solids, um", |row| significant(row.reference_um, 6))
            .numbers("fitted beams, um", |row| significant(row.fitted_um, 6))
            .numbers("difference, %", |row| fixed(row.difference_percent, 3))
            .numbers("paper, %", |row| {
                printed(row, |row| row.difference_percent, 2)
            })
            .numbers("solids, s", |row| format!("{:.1}", row.reference_s))
            .numbers("paper, s", |row| printed(row, |row| row.reference_s, 0))
            .numbers("fitted beams, s", |_| significant(seconds_per_solve, 2))
            .numbers("paper, s", |row| printed(row, |row| row.fitted_s, 2))
            .into()
    }

    /// What the reference is worth: the same loads on beams that were not fitted.
    fn check(&self) -> Table {
        let to_solids = |row: &ReferenceRowSummary, um: f64| {
            format!("{:+.2}", 100.0 * (um / row.reference_um - 1.0))
        };
        Table::of(&self.rows)
            .words("force, N", |row| row.load())
            .numbers("solids, um", |row| significant(row.reference_um, 6))
            .numbers("beams of the prisms, um", |row| {
                significant(row.prisms_um, 6)
            })
            .numbers("to solids, %", |row| to_solids(row, row.prisms_um))
            .numbers("beams of the robot file, um", |row| {
                significant(row.unfitted_um, 6)
            })
            .numbers("to solids, %", |row| to_solids(row, row.unfitted_um))
            .into()
    }

    /// The three sentences of the paper on its Table IV, with our numbers.
    fn in_short(&self, paper: &PaperReferenceSummary) -> Table {
        let fewer = |solids: usize, beams: usize| {
            format!("{:.4}", 100.0 * (1.0 - beams as f64 / solids as f64))
        };
        let largest = self.largest_difference_percent;
        let rows = [
            (
                "elements of the reference",
                self.elements.to_string(),
                paper.elements.to_string(),
            ),
            (
                "elements of the fitted beams",
                self.beams.to_string(),
                paper.beams.to_string(),
            ),
            (
                "fewer elements, %",
                fewer(self.elements, self.beams),
                fewer(paper.elements, paper.beams),
            ),
            (
                "time saved at least, %",
                format!("{:.4}", self.time_saved_percent),
                format!("{:.2}", paper.time_saved_percent),
            ),
            (
                "largest difference, %",
                largest.map_or_else(|| "-".to_owned(), |percent| format!("{percent:.3}")),
                format!("{:.2}", paper.largest_difference_percent),
            ),
        ];
        Table::of(rows)
            .words("Table IV in short", |(name, ..)| *name)
            .numbers("here", |(_, here, _)| here.clone())
            .numbers("paper", |(.., paper)| paper.clone())
            .into()
    }
}

impl ReferenceSummary {
    /// For people.
    #[must_use]
    pub fn text(&self) -> String {
        let Self {
            reference: model,
            run,
            ..
        } = self;
        let large = if model.large_displacements {
            "large displacements"
        } else {
            "small displacements"
        };
        let mut text = format!(
            "Reference of solids: {}, mechanism {}, factors {}; {} {} elements of up to {} mm, {large};\n{}, {} thread(s), {}.\n",
            model.robot,
            model.mechanism,
            model.factors,
            model.poses.first().map_or(0, |pose| pose.elements),
            model.element,
            model.size_mm,
            run.program,
            run.threads,
            run.date,
        );
        let paper = PaperTableIv::printed();
        for pose in &self.poses {
            let ReferenceFactors { a, iy, iz, j } = pose.factors;
            let [a, iy, iz, j] = [a, iy, iz, j].map(|factor| significant(factor, 4));
            let _ = write!(
                text,
                "\nPose {}. Beams fitted to the smallest loads by the paper's steps 2 to 4: A {a}, Iy {iy}, Iz {iz}, J {j}\n\n{}\n{}\n\
                 What the reference is worth: beams that were not fitted, under the same loads.\n\n{}",
                pose.pose,
                pose.table(self.seconds_per_solve, &paper).text(),
                pose.in_short(&self.paper).text(),
                pose.check().text()
            );
        }
        text
    }

    /// What no factor reached.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let poses = self.poses.iter();
        poses.flat_map(|pose| pose.misses.iter().cloned()).collect()
    }
}
