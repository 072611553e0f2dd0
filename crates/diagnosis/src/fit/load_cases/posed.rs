//! Load cases of one robot: poses, loads and what was read, all in the axes of the base.

use stiffbench_beams::robot::{JointMotion, Mechanism, Pose, Robot, TrackedPoses, Variable};
use stiffbench_measurement::load_cases::{JointUnit, LoadAxes, LoadCase, LoadCaseTable};
use stiffbench_measurement::stiffness::step_of;
use stiffbench_numeric::vector::dot;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::read_axis::ReadAxis;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use crate::fit::FitError;
use crate::mismatch::ReadQuantity;
use crate::parameters::place_of;

/// Names of the components, in the order of loads, displacements and positions.
pub(in crate::fit) const COMPONENTS: [&str; 9] = [
    "displacement x",
    "displacement y",
    "displacement z",
    "rotation x",
    "rotation y",
    "rotation z",
    "position x",
    "position y",
    "position z",
];

/// Different forces that show the step in which they were read (1): fewer may be round because they were planned. By judgement.
const SHOW_A_STEP: usize = 30;

/// Joint values that differ by no more are readings of one pose, degrees or mm.
const SAME_POSE: f64 = 1.0;

/// Components that are a smaller share of a force are rounding of the axes.
const ALONG_AN_AXIS: f64 = 1e-9;

/// A component that was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadComponent {
    /// Its place among displacement x, y, z and rotation x, y, z along the stated axes, and position x, y, z along those of the tracker.
    pub component: usize,
    /// The unit vector of six along which it was read, in the axes of the base; of a position in those of the tracker.
    pub unit: [f64; 6],
    /// What was read, m or rad.
    pub value: f64,
}

impl ReadComponent {
    /// Whether it is a rotation.
    #[must_use]
    pub fn is_rotation(&self) -> bool {
        self.quantity() == ReadQuantity::Rotation
    }

    /// Whether it is an absolute position.
    #[must_use]
    pub fn is_position(&self) -> bool {
        self.quantity() == ReadQuantity::Position
    }

    /// What it is of.
    #[must_use]
    pub fn quantity(&self) -> ReadQuantity {
        match self.component {
            0..3 => ReadQuantity::Displacement,
            3..6 => ReadQuantity::Rotation,
            _ => ReadQuantity::Position,
        }
    }

    /// Its name, for example `displacement x`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        COMPONENTS[self.component]
    }

    /// Its axis among the stated ones.
    #[must_use]
    pub fn axis(&self) -> Direction {
        Direction::ALL[self.component % 3]
    }
}

/// A load in a pose with what was read.
#[derive(Debug, Clone, PartialEq)]
pub struct PosedLoad {
    /// Line of the table.
    pub line: u32,
    /// Place of its name among the named poses.
    pub label: usize,
    /// Place of its joint values among the distinct ones.
    pub pose: usize,
    /// n-th application of the load.
    pub repeat: u32,
    /// Force and moment at the end in the axes of the base, N and N·m.
    pub load: [f64; 6],
    /// What was read.
    pub components: Vec<ReadComponent>,
}

impl PosedLoad {
    /// Size of its force, N.
    #[must_use]
    pub fn force_n(&self) -> f64 {
        let [x, y, z, ..] = self.load;
        dot([x, y, z], [x, y, z]).sqrt()
    }

    /// What a component reads of motions of the tool centre, in the axes of the base, and what it reads of the rigid robot: nothing unless a
    /// tracker sees its position, m.
    pub(super) fn seen(
        &self,
        read: &ReadComponent,
        tracker: Option<&TrackedPoses>,
    ) -> (ReadAxis, f64) {
        match tracker {
            Some(tracker) if read.is_position() => tracker.seen(self.pose, read.axis()),
            _ => {
                let axis = ReadAxis::new(read.axis(), read.is_rotation(), read.unit);
                (axis, 0.0)
            }
        }
    }

    /// Direction and amount of its load; without a load an amount of zero along z.
    pub(in crate::fit) fn load_along(&self) -> (LoadDirection, f64) {
        let unloaded = || (LoadDirection::of_axis(Direction::Z).clone(), 0.0);
        LoadDirection::of_wrench(self.load).unwrap_or_else(unloaded)
    }

    /// Its force, for example `F = -40 N along z`; by components where it is along no axis of the base.
    pub(in crate::fit) fn force_words(&self) -> String {
        let [x, y, z, ..] = self.load;
        let size = self.force_n();
        let along = Direction::ALL.iter().zip([x, y, z]);
        let mut acting = along.filter(|(_, force)| force.abs() > ALONG_AN_AXIS * size);
        match (acting.next(), acting.next()) {
            (None, _) => "F = 0".to_owned(),
            (Some((axis, force)), None) => format!("F = {force} N along {axis}"),
            _ => format!("F = ({x}, {y}, {z}) N"),
        }
    }
}

/// Load cases of one robot.
#[derive(Debug, Clone, PartialEq)]
pub struct PosedLoadCases {
    /// Names of the poses, in the order in which they first appear.
    pub labels: Vec<PoseId>,
    /// Distinct joint values.
    pub poses: Vec<Pose>,
    /// The load cases, in the order of the table.
    pub cases: Vec<PosedLoad>,
    /// What a user should know of poses and axes.
    pub warnings: Vec<String>,
}

impl PosedLoadCases {
    /// Puts a table of load cases into the poses and axes of a robot.
    ///
    /// # Errors
    /// [`FitError`] for variables, poses and axes that the robot does not have, and poses that it cannot take.
    pub fn new(
        robot: &Robot,
        mechanism: &Mechanism,
        table: &LoadCaseTable,
    ) -> Result<Self, FitError> {
        let variables = variables(robot, table)?;
        let mut posed = Self {
            labels: table.poses(),
            poses: Vec::new(),
            cases: Vec::with_capacity(table.cases.len()),
            warnings: Vec::new(),
        };
        for case in &table.cases {
            let pose = pose_of(robot, table, &variables, case)?;
            let pose = place_of(&mut posed.poses, &pose);
            let axes = axes_of(robot, mechanism, table, case, &posed.poses[pose])?;
            let label = posed.labels.iter().position(|label| *label == case.pose);
            posed.cases.push(PosedLoad {
                line: case.line,
                label: label.unwrap_or_default(),
                pose,
                repeat: case.repeat,
                load: load_along(&axes, case),
                components: components_along(&axes, case),
            });
        }
        posed.warn_of_absent(robot, &variables);
        posed.warn_of_limits(robot);
        posed.warn_of_shared_names(robot);
        Ok(posed)
    }

    /// Adds load cases of the same robot; poses of one name and joint values are one.
    pub fn join(&mut self, further: Self) {
        for mut case in further.cases {
            let label = &further.labels[case.label];
            case.label = place_of(&mut self.labels, label);
            case.pose = place_of(&mut self.poses, &further.poses[case.pose]);
            self.cases.push(case);
        }
        self.warnings.extend(further.warnings);
    }

    /// Number of components that were read.
    #[must_use]
    pub fn component_count(&self) -> usize {
        self.cases.iter().map(|case| case.components.len()).sum()
    }

    /// Whether absolute positions were read; else displacements and rotations under a load.
    #[must_use]
    pub fn has_positions(&self) -> bool {
        self.rows().any(|(_, read)| read.is_position())
    }

    /// Every component with its load case, in the order of all vectors of rows.
    pub fn rows(&self) -> impl Iterator<Item = (&PosedLoad, &ReadComponent)> {
        let cases = self.cases.iter();
        cases.flat_map(|case| case.components.iter().map(move |one| (case, one)))
    }

    /// Place of the name of the pose of each row among the named poses.
    pub(in crate::fit) fn labels_of_rows(&self) -> Vec<usize> {
        self.rows().map(|(case, _)| case.label).collect()
    }

    /// The same without some components, by their places among the rows.
    #[must_use]
    pub fn without_rows(&self, rows: &[usize]) -> Self {
        let mut without = self.clone();
        let mut row = 0..;
        for case in &mut without.cases {
            let is_kept = |_: &ReadComponent| row.next().is_none_or(|row| !rows.contains(&row));
            case.components.retain(is_kept);
        }
        without.cases.retain(|case| !case.components.is_empty());
        without
    }

    /// The same with the values of a variable of the robot with the other sign; `None` where they are all zero, or where axes other than those of
    /// the base turn with them.
    #[must_use]
    pub(in crate::fit) fn with_other_sign(&self, variable: usize) -> Option<Self> {
        let is_of_base = |read: &ReadComponent| {
            let own = (0..6).map(|place| f64::from(u8::from(place == read.component % 6)));
            own.zip(read.unit).all(|(own, unit)| own == unit)
        };
        let mut values = self.poses.iter().map(|pose| pose.angles_deg[variable]);
        let is_known = self.rows().all(|(_, read)| is_of_base(read));
        if !is_known || values.all(|value| value == 0.0) {
            return None;
        }
        let mut other = self.clone();
        for pose in &mut other.poses {
            pose.angles_deg[variable] *= -1.0;
        }
        Some(other)
    }

    /// The same with one component multiplied by a factor, or with all.
    #[must_use]
    pub(in crate::fit) fn with_components_times(
        &self,
        component: Option<usize>,
        factor: f64,
    ) -> Self {
        let mut other = self.clone();
        let all = other.cases.iter_mut().flat_map(|case| &mut case.components);
        for read in all.filter(|read| component.is_none_or(|own| own == read.component)) {
            read.value *= factor;
        }
        other
    }

    /// The median size of the forces, N.
    #[must_use]
    pub fn usual_force_n(&self) -> f64 {
        let mut forces: Vec<f64> = self.cases.iter().map(PosedLoad::force_n).collect();
        stiffbench_numeric::statistics::median(&mut forces).unwrap_or_default()
    }

    /// The step in which components of the force were read, N: all are whole multiples of it; `None` of values that show no step, or of which
    /// too many may have been set.
    #[must_use]
    pub fn force_step_n(&self) -> Option<f64> {
        let forces = self.cases.iter().flat_map(|case| &case.load[..3]);
        let mut sizes: Vec<f64> = forces.map(|force| force.abs()).collect();
        sizes.retain(|size| *size > 0.0);
        sizes.sort_by(f64::total_cmp);
        sizes.dedup();
        step_of(sizes.iter().copied()).filter(|_| sizes.len() >= SHOW_A_STEP)
    }

    /// Variables without a column; under forces at the tool only those count that move it, beside own weight all do.
    fn warn_of_absent(&mut self, robot: &Robot, variables: &[usize]) {
        if variables.is_empty() {
            return;
        }
        let weight = self.has_positions();
        let absent: Vec<&str> = (0..robot.variables.len())
            .filter(|variable| !variables.contains(variable))
            .filter(|&variable| weight || robot.moves_tool(variable))
            .map(|variable| robot.variables[variable].name.as_str())
            .collect();
        if !absent.is_empty() {
            self.warnings.push(format!(
                "assumed: no joint column for {}: each has its value in the pose of that name in the robot file, else its nominal value",
                absent.join(", ")
            ));
        }
    }

    /// A name stands for one pose: those under it are left out together.
    fn warn_of_shared_names(&mut self, robot: &Robot) {
        let values = |case: &PosedLoad| {
            let values = self.poses[case.pose].angles_deg.iter();
            let values = values.zip(&robot.variables);
            values.map(|(value, variable)| match variable.motion {
                JointMotion::Turns => *value,
                JointMotion::Slides => 1e3 * value,
            })
        };
        for (label, name) in self.labels.iter().enumerate() {
            let mut cases = self.cases.iter().filter(|case| case.label == label);
            let Some(first) = cases.next() else { continue };
            let differs = |case: &&PosedLoad| {
                let mut pairs = values(case).zip(values(first));
                pairs.any(|(here, there)| (here - there).abs() > SAME_POSE)
            };
            let others: Vec<u32> = cases.filter(differs).map(|case| case.line).collect();
            if let Some(line) = others.first() {
                self.warnings.push(format!(
                    "line {line}: pose {name} has other joint values than in line {}{}: give each pose its own name",
                    first.line,
                    and_further(others.len() - 1, "line")
                ));
            }
        }
    }

    /// Poses beyond a limit, one warning a limit.
    fn warn_of_limits(&mut self, robot: &Robot) {
        let mut broken: Vec<(String, String, usize)> = Vec::new();
        for (place, pose) in self.poses.iter().enumerate() {
            for violation in robot.violated_limits(pose) {
                let limit = violation.limit;
                if let Some((_, _, further)) = broken.iter_mut().find(|one| one.0 == limit) {
                    *further += 1;
                    continue;
                }
                let first = self.cases.iter().find(|case| case.pose == place);
                let (line, label) = first.map_or((0, 0), |case| (case.line, case.label));
                let first = format!(
                    "line {line}, pose {}: outside the limit {limit} by {:.3}",
                    self.labels[label], violation.excess_deg
                );
                broken.push((limit, first, 0));
            }
        }
        let warnings = broken.into_iter();
        self.warnings.extend(
            warnings.map(|(_, first, further)| format!("{first}{}", and_further(further, "pose"))),
        );
    }
}

/// How many more of a kind a warning stands for.
fn and_further(count: usize, what: &str) -> String {
    match count {
        0 => String::new(),
        1 => format!(" (and 1 further {what})"),
        _ => format!(" (and {count} further {what}s)"),
    }
}

/// The robot's variable of each joint column.
fn variables(robot: &Robot, table: &LoadCaseTable) -> Result<Vec<usize>, FitError> {
    let names = || {
        robot
            .variables
            .iter()
            .map(|variable| variable.name.as_str())
    };
    let find = |name: &str| {
        let exact = names().position(|known| known == name);
        exact.or_else(|| names().position(|known| known.eq_ignore_ascii_case(name)))
    };
    for column in &table.unused_columns {
        refuse_bare_variable(robot, table, column)?;
    }
    let columns = table
        .joints
        .iter()
        .map(|column| -> Result<usize, FitError> {
            let variable = &column.variable;
            let found = find(variable).ok_or_else(|| FitError::UnknownVariable {
                file: table.source.clone(),
                robot: robot.name.clone(),
                variable: variable.clone(),
                known: names().collect::<Vec<_>>().join(", "),
                advice: match nearest(variable, names()) {
                    Some(near) => format!("is `joint_{near}_deg` meant?"),
                    None => "name the column joint_VARIABLE_deg with a variable of the robot file"
                        .to_owned(),
                },
            })?;
            let words = |is_angle: bool| if is_angle { "an angle" } else { "a length" };
            let turns = robot.variables[found].motion == JointMotion::Turns;
            if turns != (column.unit == JointUnit::Angle) {
                return Err(FitError::JointUnit {
                    file: table.source.clone(),
                    variable: variable.clone(),
                    found: words(!turns),
                    expected: words(turns),
                });
            }
            Ok(found)
        });
    columns.collect()
}

/// Refuses a column that is named like a variable: joint values that are not read would be those of another pose.
fn refuse_bare_variable(
    robot: &Robot,
    table: &LoadCaseTable,
    column: &str,
) -> Result<(), FitError> {
    let is_meant = |name: &str| {
        let head = column.trim().get(..name.len());
        let rest = column.trim().get(name.len()..).unwrap_or_default();
        head.is_some_and(|head| head.eq_ignore_ascii_case(name))
            && (rest.is_empty() || rest.starts_with(['_', ' ', '(', '[']))
    };
    let mut variables = robot.variables.iter();
    let Some(variable) = variables.find(|variable| is_meant(&variable.name)) else {
        return Ok(());
    };
    Err(FitError::BareVariable {
        file: table.source.clone(),
        robot: robot.name.clone(),
        column: column.to_owned(),
        expected: joint_column(variable),
    })
}

/// The column of a table that holds the values of a variable.
fn joint_column(variable: &Variable) -> String {
    format!("joint_{}_{}", variable.name, variable.motion.usual_unit())
}

/// The pose of a case: the robot's of that name, or its nominal one, with the joint values of the table.
fn pose_of(
    robot: &Robot,
    table: &LoadCaseTable,
    variables: &[usize],
    case: &LoadCase,
) -> Result<Pose, FitError> {
    let named = robot.pose(&case.pose).ok();
    if variables.is_empty() && named.is_none() {
        return Err(FitError::UnknownPose {
            file: table.source.clone(),
            line: case.line,
            pose: case.pose.to_string(),
            robot: robot.name.clone(),
            example: robot
                .variables
                .first()
                .map_or_else(String::new, joint_column),
        });
    }
    let mut pose = named.cloned().unwrap_or_else(|| robot.nominal_pose());
    for (&variable, value) in variables.iter().zip(&case.joints) {
        let turns = robot.variables[variable].motion == JointMotion::Turns;
        pose.angles_deg[variable] = if turns { value.to_degrees() } else { *value };
    }
    Ok(pose)
}

/// Unit vectors of the axes along which the components of a case stand, in those of the base.
fn axes_of(
    robot: &Robot,
    mechanism: &Mechanism,
    table: &LoadCaseTable,
    case: &LoadCase,
    pose: &Pose,
) -> Result<[[f64; 3]; 3], FitError> {
    let body = match &case.axes {
        LoadAxes::Base => return Ok(Direction::ALL.map(Direction::unit_vector)),
        LoadAxes::Tool => robot.tool.body.or_else(|| robot.end_body(mechanism)),
        LoadAxes::Body(name) => robot.bodies.iter().position(|body| body.name == *name),
    };
    let Some(body) = body else {
        let bodies = || robot.bodies.iter().map(|body| body.name.as_str());
        let axes = case.axes.to_string();
        return Err(FitError::UnknownAxes {
            file: table.source.clone(),
            line: case.line,
            robot: robot.name.clone(),
            known: bodies().collect::<Vec<_>>().join(", "),
            advice: match nearest(&axes, bodies().chain(["base", "tool"])) {
                Some(near) => format!("is `{near}` meant?"),
                None => "write base, tool, or the id of a body of the robot file".to_owned(),
            },
            axes,
        });
    };
    let axes = robot.body_axes(body, pose);
    let axes = axes.map_err(|source| FitError::Pose {
        file: table.source.clone(),
        line: case.line,
        pose: case.pose.to_string(),
        source,
    })?;
    let in_base = |local: [f64; 3]| -> [f64; 3] {
        [0, 1, 2].map(|i| (0..3).map(|k| local[k] * axes[k][i]).sum())
    };
    Ok(match (&case.axes, &robot.tool.axes) {
        (LoadAxes::Tool, Some(own)) => own.map(in_base),
        _ => axes,
    })
}

/// Force and moment in the axes of the base.
fn load_along(axes: &[[f64; 3]; 3], case: &LoadCase) -> [f64; 6] {
    let mut load = [0.0; 6];
    for (axis, unit) in axes.iter().enumerate() {
        for (place, share) in unit.iter().enumerate() {
            load[place] += case.force_n[axis] * share;
            load[3 + place] += case.moment_nm[axis] * share;
        }
    }
    load
}

/// The components that were read, with their directions in the axes of the base; positions have those of the tracker.
fn components_along(axes: &[[f64; 3]; 3], case: &LoadCase) -> Vec<ReadComponent> {
    let motion = case.displacement_m.iter().chain(&case.rotation_rad);
    let read = motion.chain(&case.position_m);
    read.enumerate()
        .filter_map(|(component, value)| {
            let mut unit = [0.0; 6];
            let own = Direction::ALL[component % 3].unit_vector();
            let (first, axis) = match component / 3 {
                2 => (0, &own),
                kind => (3 * kind, &axes[component % 3]),
            };
            unit[first..first + 3].copy_from_slice(axis);
            value.map(|value| ReadComponent {
                component,
                unit,
                value,
            })
        })
        .collect()
}
