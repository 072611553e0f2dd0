//! Serial arms of rigid links with springs, made by code; those of `fixtures/virtual-joints`.

use std::sync::Arc;

use indexmap::IndexMap;
use stiffbench_beams::robot::{
    Angle, Body, BodyPlace, BodyPoint, ElementClass, FittingFactors, Joint, JointModel,
    JointMotion, JointSprings, MassPlace, Mechanism, MechanismModel, Member, ModelParameter,
    MultiPosePredictor, NodePlace, Payload, Plane, PointMass, Pose, Predictor, RatedSection,
    RigidLink, Robot, RobotNode, SpringAxis, SpringDefault, Theory, Tool, Variable, Yielding,
};
use stiffbench_beams::structure::{Compliance6, Hinge, Section, ShearCoefficients};
use stiffbench_numeric::vector::{along6, cross, subtract};
use stiffbench_units_and_text::source_text::SourceText;

use super::STEEL;
use super::rows::{Row, number, rows};

pub(crate) fn vector(row: &Row, key: &str) -> [f64; 3] {
    ["x", "y", "z"].map(|axis| number(row, &format!("{key}_{axis}")))
}

/// A spring of a compliance; rigid if that is zero.
pub(crate) fn spring(compliance: f64) -> SpringDefault {
    let yielding = match compliance {
        0.0 => Yielding::Rigid,
        c => Yielding::Compliance(c),
    };
    SpringDefault {
        yielding,
        ..SpringDefault::default()
    }
}

/// Derivatives of the whole compliance in a pose by the general solver. Those of poses solved together are solved too, and agree along
/// oblique directions.
pub(crate) fn derivatives(
    together: &mut MultiPosePredictor<'_>,
    robot: &Robot,
    pose: &Pose,
    values: &FittingFactors,
    parameters: &[ModelParameter],
) -> Vec<Compliance6> {
    let mechanism = robot.mechanism(None).unwrap();
    let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
    let model =
        MechanismModel::with_parameters(robot, mechanism, &joints, theory, values, parameters);
    let mut single = Predictor::of(model.unwrap()).unwrap();
    single.place(pose).unwrap();
    let _ = single.compliance();
    let whole = single.compliance_derivatives(parameters);
    let units = [[0.6, 0.0, 0.8], [0.48, 0.6, -0.64], [0.0, 1.0, 0.0]];
    together.place(0, pose).unwrap();
    together.differentiate_whole();
    together.solve(values, true).unwrap();
    for unit in units {
        for (found, whole) in together.whole_gradient(0).iter().zip(&whole) {
            let size: f64 = (0..3).map(|i| whole.0[i][i].abs()).sum();
            let error = (found.along(unit) - whole.along(unit)).abs();
            assert!(error <= 1e-9 * size, "{unit:?}: {error:e} of {size:e}");
        }
    }
    whole
}

/// A joint of an arm, as it follows the one before.
#[derive(Debug, Clone)]
pub(crate) struct ArmJoint {
    pub(crate) motion: JointMotion,
    /// Unit axis and node on the body before, in its axes.
    pub(crate) axis: [f64; 3],
    pub(crate) at_m: [f64; 3],
    pub(crate) springs: JointSprings,
    /// Mass and centre of the body behind it.
    pub(crate) mass: Option<(f64, [f64; 3])>,
    /// The link that leads to it; rigid if there is none.
    pub(crate) link: Option<ArmBeam>,
}

/// A link that bends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ArmBeam {
    pub(crate) section: Section,
    /// What its local y is turned towards, in the axes of its body.
    pub(crate) y: [f64; 3],
}

/// What an arm ends in.
#[derive(Debug, Clone, Default)]
pub(crate) struct ArmEnd {
    /// Where the tool is mounted, and its centre, on the last body.
    pub(crate) flange_m: [f64; 3],
    pub(crate) tool_m: [f64; 3],
    pub(crate) base: [SpringDefault; 6],
    pub(crate) tool: [SpringDefault; 6],
    pub(crate) payload: Option<Payload>,
    /// The link from the last joint to the flange.
    pub(crate) link: Option<ArmBeam>,
}

/// The beams of an arm, with their sections and planes.
#[derive(Debug, Default)]
struct Beams {
    members: Vec<Member>,
    sections: IndexMap<String, RatedSection>,
    planes: Vec<Plane>,
}

impl Beams {
    fn push(&mut self, beam: &ArmBeam, nodes: [usize; 2], body: usize, first_plane: usize) {
        let name = format!("beam {body}");
        let plane = first_plane + self.planes.len();
        self.planes.push(Plane {
            name: name.clone(),
            body,
            normal: beam.y,
        });
        let rated = RatedSection {
            section: beam.section,
            material: STEEL,
            shear: ShearCoefficients {
                along_y: 1.0,
                along_z: 1.0,
            },
            mass_kg_per_m: None,
        };
        self.members.push(Member {
            name: name.clone(),
            nodes,
            chain: "arm".to_owned(),
            class: ElementClass::Beam,
            section: self.sections.insert_full(name, rated).0,
            body,
            plane,
            groups: vec!["arm".into()],
        });
    }
}

/// An arm of rigid links; weight acts along -z.
///
/// Body i stands behind joint i (body 0 is the ground), node i at joint i, then follow flange and tool centre.
#[expect(
    clippy::too_many_lines,
    reason = "one robot from its first body to its mechanism"
)]
pub(crate) fn arm(joints: &[ArmJoint], end: &ArmEnd) -> Robot {
    let (mut bodies, mut nodes, mut links) = (Vec::new(), Vec::new(), Vec::new());
    let (mut planes, mut own, mut masses) = (Vec::new(), Vec::new(), Vec::new());
    let mut beams = Beams::default();
    let body = |name: String, place| Body {
        name,
        chain: None,
        place,
    };
    let fixed = |name: String, body: usize, at_m: [f64; 3]| RobotNode {
        name: name.into(),
        place: NodePlace::Fixed { body, at_m },
    };
    let link = |nodes: [usize; 2], body: usize| RigidLink {
        name: format!("link {body} {nodes:?}"),
        nodes,
        chain: "arm".to_owned(),
        body,
        is_added: false,
    };
    bodies.push(body("ground".to_owned(), BodyPlace::Ground));
    nodes.push(fixed("foot".to_owned(), 0, [0.0; 3]));
    let mut last = 0;
    for (place, joint) in joints.iter().enumerate() {
        let (before, behind) = (place, place + 1);
        let origin = nodes.len();
        nodes.push(fixed(format!("N{behind}"), before, joint.at_m));
        let moved = Angle {
            offset_deg: 0.0,
            terms: vec![(place, 1.0)],
        };
        match &joint.link {
            Some(beam) => beams.push(beam, [last, origin], before, joints.len()),
            None => links.push(link([last, origin], before)),
        }
        let (parent, axis) = (before, joint.axis);
        last = origin;
        let place_of_body = match joint.motion {
            JointMotion::Turns => BodyPlace::Turned {
                parent,
                origin,
                axis,
                angle: moved,
            },
            JointMotion::Slides => BodyPlace::Slid {
                parent,
                origin,
                axis,
                distance: moved,
            },
        };
        bodies.push(body(format!("B{behind}"), place_of_body));
        if joint.motion == JointMotion::Slides {
            last = nodes.len();
            nodes.push(fixed(format!("S{behind}"), behind, [0.0; 3]));
            links.push(link([origin, last], before));
        }
        planes.push(Plane {
            name: format!("P{behind}"),
            body: before,
            normal: axis,
        });
        own.push(Joint {
            name: format!("J{behind}"),
            node: last,
            bodies: [before, behind],
            chain: Some("arm".to_owned()),
            plane: place,
            motion: joint.motion,
            springs: joint.springs.clone(),
        });
        if let Some((mass_kg, at_m)) = joint.mass {
            masses.push(PointMass {
                name: format!("M{behind}"),
                mass_kg,
                place: MassPlace::Point(BodyPoint { body: behind, at_m }),
            });
        }
    }
    let flange = nodes.len();
    nodes.push(fixed("flange".to_owned(), joints.len(), end.flange_m));
    nodes.push(fixed("tool".to_owned(), joints.len(), end.tool_m));
    match &end.link {
        Some(beam) => beams.push(beam, [last, flange], joints.len(), joints.len()),
        None => links.push(link([last, flange], joints.len())),
    }
    planes.extend(beams.planes);
    let variable = |(place, joint): (usize, &ArmJoint)| Variable {
        name: format!("q{}", place + 1),
        motion: joint.motion,
        min_deg: -180.0,
        max_deg: 180.0,
        nominal_deg: 0.0,
    };
    let mechanism = Mechanism {
        name: "arm".to_owned(),
        chains: vec!["arm".to_owned()],
        members: (0..beams.members.len()).collect(),
        rigid_links: (0..links.len()).collect(),
        locked: Vec::new(),
    };
    Robot {
        source: Arc::new(SourceText::new("arm", "")),
        name: "arm".to_owned(),
        variables: joints.iter().enumerate().map(variable).collect(),
        limits: Vec::new(),
        planes,
        bodies,
        joints: own,
        nodes,
        members: beams.members,
        rigid_links: links,
        supports: vec![0],
        end: flange + 1,
        tool: Tool {
            mount: Some(flange),
            body: Some(joints.len()),
            axes: None,
            springs: end.tool.clone(),
            payload: end.payload,
        },
        base: end.base.clone(),
        sections: beams.sections,
        vertical: [0.0, 0.0, 1.0],
        axis_words: [None, None, None],
        masses,
        balancers: Vec::new(),
        mechanisms: std::iter::once(("arm".to_owned(), mechanism)).collect(),
        factors: IndexMap::new(),
        poses: Vec::new(),
        floor_m: None,
        base_radius_m: None,
        warnings: Vec::new(),
    }
}

/// The six springs of the base or of the tool.
fn six(end: &Row, key: &str) -> [SpringDefault; 6] {
    SpringAxis::ALL.map(|axis| spring(number(end, &format!("{key}_{axis}"))))
}

/// The pose that the joints of an arm stand in.
fn standing<'a>(joints: impl IntoIterator<Item = &'a Row>) -> Pose {
    let values = joints.into_iter().map(|row| number(row, "value"));
    Pose {
        angles_deg: values.collect(),
    }
}

/// An arm of the fixtures with the pose it stands in.
pub(crate) fn of_fixture(joints: &[&Row], end: &Row) -> (Robot, Pose) {
    let joint = |row: &&Row| ArmJoint {
        motion: match row["motion"].as_str() {
            "slides" => JointMotion::Slides,
            _ => JointMotion::Turns,
        },
        axis: vector(row, "axis"),
        at_m: vector(row, "at"),
        springs: JointSprings {
            own: spring(number(row, "own")),
            about: vector(row, "about").map(spring),
        },
        mass: Some((number(row, "mass"), vector(row, "centre"))),
        link: None,
    };
    let arm_end = ArmEnd {
        flange_m: vector(end, "flange"),
        tool_m: vector(end, "tool"),
        base: six(end, "base"),
        tool: six(end, "held"),
        payload: Some(Payload {
            mass_kg: number(end, "payload"),
            at_m: vector(end, "payload"),
        }),
        link: None,
    };
    let joints_of_arm: Vec<ArmJoint> = joints.iter().map(joint).collect();
    (
        arm(&joints_of_arm, &arm_end),
        standing(joints.iter().copied()),
    )
}

/// The arms of the fixtures with beams, each with its pose.
pub(crate) fn with_beams() -> Vec<(Robot, Pose)> {
    let all = rows("virtual-joints/mixed_arms.csv");
    let beam = |row: &Row| {
        let of = |key: &str| number(row, key);
        (of("A") > 0.0).then(|| ArmBeam {
            section: Section {
                area_m2: of("A"),
                iy_m4: of("Iy"),
                iz_m4: of("Iz"),
                j_m4: of("J"),
            },
            y: vector(row, "y"),
        })
    };
    let of_arm = |rows: &[Row]| {
        let (end, joints) = rows.split_last().unwrap();
        let joint = |row: &Row| {
            let [own, y, z] = vector(row, "about").map(spring);
            ArmJoint {
                motion: JointMotion::Turns,
                axis: vector(row, "axis"),
                at_m: vector(row, "at"),
                springs: JointSprings {
                    own,
                    about: [SpringDefault::default(), y, z],
                },
                mass: None,
                link: beam(row),
            }
        };
        let (flange, tool) = (vector(end, "at"), vector(end, "tool"));
        let arm_end = ArmEnd {
            flange_m: flange,
            tool_m: [0, 1, 2].map(|i| flange[i] + tool[i]),
            base: six(end, "base"),
            tool: six(end, "held"),
            payload: None,
            link: beam(end),
        };
        let pose = standing(joints);
        let joints: Vec<ArmJoint> = joints.iter().map(joint).collect();
        (arm(&joints, &arm_end), pose)
    };
    all.chunk_by(|a, b| a["arm"] == b["arm"])
        .map(of_arm)
        .collect()
}

/// All arms of the fixtures, by number.
pub(crate) fn all() -> Vec<(Robot, Pose)> {
    let joints = rows("virtual-joints/arms.csv");
    let ends = rows("virtual-joints/ends.csv");
    ends.iter()
        .map(|end| {
            let own = joints.iter().filter(|row| row["arm"] == end["arm"]);
            of_fixture(&own.collect::<Vec<_>>(), end)
        })
        .collect()
}

/// The arms of the fixtures with springs about their own axes alone, so that every spring is a variable of the pose.
pub(crate) fn of_own_springs() -> Vec<(Robot, Pose)> {
    let mut arms = all();
    for (robot, _) in &mut arms {
        for joint in &mut robot.joints {
            joint.springs.about = Default::default();
        }
        robot.base = Default::default();
        robot.tool.springs = Default::default();
    }
    arms
}

/// Where each joint of an arm stands, and its axis.
pub(crate) fn hinges(predictor: &Predictor<'_>) -> Vec<([f64; 3], [f64; 3])> {
    let structure = predictor.model().structure();
    let members = &structure.rigid_members;
    let hinge = |hinge: usize| {
        let mut ends = members.iter().flat_map(|member| &member.ends);
        let at = ends.find(|at| at.hinges.contains(&hinge)).unwrap();
        (
            structure.nodes[at.node].position_m,
            structure.hinges[hinge].axis,
        )
    };
    (0..structure.hinges.len()).map(hinge).collect()
}

/// How the end of an arm moves with each joint, from where joints and end stand.
pub(crate) fn motions(predictor: &Predictor<'_>) -> Vec<[f64; 6]> {
    let structure = predictor.model().structure();
    let end_m = structure.nodes[structure.end.node].position_m;
    let joints = hinges(predictor).into_iter().zip(&structure.hinges);
    let motion = |((at_m, axis), hinge): (([f64; 3], [f64; 3]), &Hinge)| {
        if hinge.slides {
            return along6(axis);
        }
        let [x, y, z] = cross(axis, subtract(end_m, at_m));
        [x, y, z, axis[0], axis[1], axis[2]]
    };
    joints.map(motion).collect()
}

/// By how much the torques of a pose change with each joint: differences over steps of 1e-3 rad or m. With Richardson's extrapolation
/// the truncation is far below 1e-10.
pub(crate) fn slopes(
    robot: &Robot,
    pose: &Pose,
    torques: impl Fn(&Pose) -> Vec<f64>,
) -> Vec<Vec<f64>> {
    let slope = |joint: usize, step: f64| -> Vec<f64> {
        let at = |step: f64| {
            let mut moved = pose.clone();
            moved.angles_deg[joint] += match robot.joints[joint].motion {
                JointMotion::Turns => step.to_degrees(),
                JointMotion::Slides => step,
            };
            torques(&moved)
        };
        let pairs = at(step).into_iter().zip(at(-step));
        pairs.map(|(up, down)| (up - down) / (2.0 * step)).collect()
    };
    let of_joint = |joint: usize| {
        let [wide, fine, finest] = [4e-3, 2e-3, 1e-3].map(|step| slope(joint, step));
        let extrapolated = (0..wide.len()).map(|i| {
            let first = (4.0 * fine[i] - wide[i]) / 3.0;
            let second = (4.0 * finest[i] - fine[i]) / 3.0;
            (16.0 * second - first) / 15.0
        });
        extrapolated.collect()
    };
    (0..robot.joints.len()).map(of_joint).collect()
}

/// The compliance of an arm whose torques have slopes: q = C (Jᵀ w + S q), solved by repetition, which converges where the springs are
/// far stiffer than what has the slopes.
pub(crate) fn by_repetition(predictor: &Predictor<'_>, slopes: &[Vec<f64>]) -> Compliance6 {
    let motions = motions(predictor);
    let hinges = predictor.model().structure().hinges.iter();
    let compliances: Vec<f64> = hinges.map(|h| 1.0 / h.stiffness_nm_per_rad).collect();
    let joints = 0..motions.len();
    let mut found = Compliance6([[0.0; 6]; 6]);
    for load in 0..6 {
        let mut turned = vec![0.0; motions.len()];
        for _ in 0..300 {
            let turn = |i: usize| {
                let more: f64 = joints.clone().map(|j| slopes[j][i] * turned[j]).sum();
                compliances[i] * (motions[i][load] + more)
            };
            turned = joints.clone().map(turn).collect();
        }
        for row in 0..6 {
            found.0[row][load] = joints.clone().map(|j| motions[j][row] * turned[j]).sum();
        }
    }
    found
}

/// Largest difference of two compliances, by the diagonal of a third.
pub(crate) fn largest_difference(a: &Compliance6, b: &Compliance6, of: &Compliance6) -> f64 {
    let mut largest = 0.0_f64;
    for i in 0..6 {
        for j in 0..6 {
            let scale = (of.0[i][i] * of.0[j][j]).sqrt();
            if scale > 0.0 {
                largest = largest.max((a.0[i][j] - b.0[i][j]).abs() / scale);
            }
        }
    }
    largest
}
