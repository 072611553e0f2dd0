//! The paper's Table IV repeated: the 36-element model fitted to one pose beside a reference of solids.
//!
//! A second table states what the reference is worth: beams with the constants of the prisms and with shear, which solids of slender
//! members must come near, and the beams of the robot file before any fit.

use std::fmt::Write;

use crate::reference::{PoseModel, ReferenceCell, ReferenceRecord, beams_of_the_prisms};
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
use stiffbench::report::{Table, numbers, significant, words};

const UM_PER_M: f64 = 1e6;

/// Displacement under one load, by each model.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceRow {
    /// The reference.
    pub reference: ReferenceCell,
    /// Along the force, by the reference, µm.
    pub reference_um: f64,
    /// By the fitted beams, µm.
    pub fitted_um: f64,
    /// By the beams with the factors that the reference was written with, µm.
    pub unfitted_um: f64,
    /// By beams with the constants of the prisms and with shear, µm.
    pub prisms_um: f64,
}

impl ReferenceRow {
    /// How far the fitted beams lie from the reference, percent.
    #[must_use]
    pub fn difference_percent(&self) -> f64 {
        100.0 * (self.fitted_um / self.reference_um - 1.0)
    }
}

/// One pose.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferencePose {
    /// The reference's model of it.
    pub model: PoseModel,
    /// Single-pose factors, A, Iy, Iz, J.
    pub factors: [f64; 4],
    /// Directions that no value of their factor brings to the reference.
    pub misses: Vec<String>,
    /// Every load.
    pub rows: Vec<ReferenceRow>,
}

/// A reference and the beams fitted to it.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceReport {
    /// The reference.
    pub record: ReferenceRecord,
    /// Its poses.
    pub poses: Vec<ReferencePose>,
    /// Time of one solution of the fitted beams, s; known to whom has a clock.
    pub seconds_per_solve: f64,
}

/// Fits single-pose factors to the smallest loads of each pose and compares every load with them.
///
/// # Errors
/// [`FitError`] if a pose of the reference lacks a direction, or the robot a pose.
pub fn reference_report(
    robot: &Robot,
    mechanism: &Mechanism,
    record: &ReferenceRecord,
) -> Result<ReferenceReport, FitError> {
    let pose = |model: &PoseModel| compare_pose(robot, mechanism, record, model);
    let with_results = |model: &&PoseModel| {
        let mut cells = record.cells.iter();
        cells.any(|cell| cell.pose == model.pose)
    };
    Ok(ReferenceReport {
        record: record.clone(),
        poses: record
            .model
            .poses
            .iter()
            .filter(with_results)
            .map(pose)
            .collect::<Result<_, _>>()?,
        seconds_per_solve: f64::NAN,
    })
}

fn compare_pose(
    robot: &Robot,
    mechanism: &Mechanism,
    record: &ReferenceRecord,
    model: &PoseModel,
) -> Result<ReferencePose, FitError> {
    let pose = PoseId::new(&model.pose);
    let cells: Vec<&ReferenceCell> = record
        .cells
        .iter()
        .filter(|cell| cell.pose == model.pose)
        .collect();
    let fits = fit_single_source(
        robot,
        mechanism,
        &smallest_loads(&cells),
        &[(pose.clone(), 1.0)],
        &MonteCarloSettings::default(),
    )?;
    let factors = fits[0].fit.factors.clone();
    let [beam, link] = record.model.factor_values;
    let written = FittingFactors::of_classes(beam, link);
    let fitted = compliance(robot, mechanism, &pose, &factors)?;
    let unfitted = compliance(robot, mechanism, &pose, &written)?;
    let prisms = prism_compliance(robot, mechanism, &pose, &written)?;
    let row = |cell: &ReferenceCell| {
        let axis = axis(cell).index();
        let um = |m_per_n: [f64; 3]| cell.force_n * m_per_n[axis] * UM_PER_M;
        ReferenceRow {
            reference: cell.clone(),
            reference_um: cell.displacement_um[axis],
            fitted_um: um(fitted),
            unfitted_um: um(unfitted),
            prisms_um: um(prisms),
        }
    };
    Ok(ReferencePose {
        model: model.clone(),
        factors: factors.beam,
        misses: fits[0].misses(),
        rows: cells.into_iter().map(row).collect(),
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

impl ReferencePose {
    /// The row on which the fitted beams lie furthest from the reference.
    #[must_use]
    pub fn largest(&self) -> Option<&ReferenceRow> {
        let size = |row: &ReferenceRow| row.difference_percent().abs();
        self.rows.iter().max_by(|a, b| size(a).total_cmp(&size(b)))
    }

    /// Fewest percent of the reference's time that the fitted beams save.
    pub(super) fn time_saved_percent(&self, seconds: f64) -> f64 {
        let times = self.rows.iter().map(|row| row.reference.seconds);
        100.0 * (1.0 - seconds / times.fold(f64::INFINITY, f64::min))
    }

    /// Table IV with the paper's columns beside ours.
    fn table(&self, seconds_per_solve: f64, paper: &PaperTableIv) -> Table {
        let mut table = Table::new([
            words("force, N"),
            numbers("solids, um"),
            numbers("fitted beams, um"),
            numbers("difference, %"),
            numbers("paper, %"),
            numbers("solids, s"),
            numbers("paper, s"),
            numbers("fitted beams, s"),
            numbers("paper, s"),
        ]);
        for row in &self.rows {
            let printed = paper.row(axis(&row.reference), row.reference.force_n);
            let of_paper = |value: fn(&PaperRow) -> f64, decimals: usize| {
                printed.map_or_else(|| "-".to_owned(), |row| fixed(value(row), decimals))
            };
            table.row([
                format!("{} {}", row.reference.direction, row.reference.force_n),
                significant(row.reference_um, 6),
                significant(row.fitted_um, 6),
                fixed(row.difference_percent(), 3),
                of_paper(|row| row.difference_percent, 2),
                format!("{:.1}", row.reference.seconds),
                of_paper(|row| row.reference_s, 0),
                significant(seconds_per_solve, 2),
                of_paper(|row| row.fitted_s, 2),
            ]);
        }
        table
    }

    /// What the reference is worth: the same loads on beams that were not fitted.
    fn check(&self) -> Table {
        let mut table = Table::new([
            words("force, N"),
            numbers("solids, um"),
            numbers("beams of the prisms, um"),
            numbers("to solids, %"),
            numbers("beams of the robot file, um"),
            numbers("to solids, %"),
        ]);
        for row in &self.rows {
            let to_solids = |um: f64| format!("{:+.2}", 100.0 * (um / row.reference_um - 1.0));
            table.row([
                format!("{} {}", row.reference.direction, row.reference.force_n),
                significant(row.reference_um, 6),
                significant(row.prisms_um, 6),
                to_solids(row.prisms_um),
                significant(row.unfitted_um, 6),
                to_solids(row.unfitted_um),
            ]);
        }
        table
    }
}

impl ReferenceReport {
    /// For people.
    #[must_use]
    pub fn text(&self) -> String {
        let ReferenceRecord { model, run, .. } = &self.record;
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
            let [a, iy, iz, j] = pose.factors.map(|factor| significant(factor, 4));
            let _ = write!(
                text,
                "\nPose {}. Beams fitted to the smallest loads by the paper's steps 2 to 4: A {a}, Iy {iy}, Iz {iz}, J {j}\n\n{}\n{}\n\
                 What the reference is worth: beams that were not fitted, under the same loads.\n\n{}",
                pose.model.pose,
                pose.table(self.seconds_per_solve, &paper).text(),
                self.in_short(pose, &paper),
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

    /// The three sentences of the paper on its Table IV, with our numbers.
    fn in_short(&self, pose: &ReferencePose, paper: &PaperTableIv) -> String {
        let cells = [pose.model.elements, self.record.model.beams];
        let fewer = |[solids, beams]: [usize; 2]| {
            format!("{:.4}", 100.0 * (1.0 - beams as f64 / solids as f64))
        };
        let saved = pose.time_saved_percent(self.seconds_per_solve);
        let largest = pose.largest().map(ReferenceRow::difference_percent);
        let mut table = Table::new([
            words("Table IV in short"),
            numbers("here"),
            numbers("paper"),
        ]);
        let mut row = |name: &str, here: String, paper: String| {
            table.row([name.to_owned(), here, paper]);
        };
        for (i, name) in ["elements of the reference", "elements of the fitted beams"]
            .into_iter()
            .enumerate()
        {
            row(name, cells[i].to_string(), paper.cells[i].to_string());
        }
        row("fewer elements, %", fewer(cells), fewer(paper.cells));
        row(
            "time saved at least, %",
            format!("{saved:.4}"),
            format!("{:.2}", paper.time_saved_percent()),
        );
        row(
            "largest difference, %",
            largest.map_or_else(|| "-".to_owned(), |percent| format!("{:.3}", percent.abs())),
            format!("{:.2}", paper.largest_percent()),
        );
        table.text()
    }
}
