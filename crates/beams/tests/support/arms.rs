//! Serial arms of rigid links with springs, made by code; those of `fixtures/virtual-joints`.

use std::collections::BTreeMap;
use std::sync::Arc;

use indexmap::IndexMap;
use stiffbench_beams::robot::{
    Angle, Body, BodyPlace, BodyPoint, ElementClass, FittingFactors, Joint, JointModel,
    JointMotion, JointSprings, MassPlace, Mechanism, MechanismModel, Member, ModelParameter,
    MultiPosePredictor, NodePlace, Payload, Plane, PointMass, Pose, Predictor, RatedSection,
    RigidLink, Robot, RobotNode, SpringAxis, SpringDefault, Theory, Tool, Variable, Yielding,
};
use stiffbench_beams::structure::{Compliance6, Section, ShearCoefficients};
use stiffbench_units_and_text::source_text::SourceText;

use super::STEEL;

pub(crate) type Row = BTreeMap<String, String>;

/// Rows of a table of `fixtures/virtual-joints`.
pub(crate) fn rows(file: &str) -> Vec<Row> {
    let folder = stiffbench_test_files::repository().join("fixtures/virtual-joints");
    let mut reader = csv::Reader::from_path(folder.join(file)).unwrap();
    reader.deserialize().collect::<Result<_, _>>().unwrap()
}

pub(crate) fn number(row: &Row, key: &str) -> f64 {
    row[key].parse().unwrap()
}

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
    let six = |key: &str| SpringAxis::ALL.map(|axis| spring(number(end, &format!("{key}_{axis}"))));
    let arm_end = ArmEnd {
        flange_m: vector(end, "flange"),
        tool_m: vector(end, "tool"),
        base: six("base"),
        tool: six("held"),
        payload: Some(Payload {
            mass_kg: number(end, "payload"),
            at_m: vector(end, "payload"),
        }),
        link: None,
    };
    let joints_of_arm: Vec<ArmJoint> = joints.iter().map(joint).collect();
    let pose = Pose {
        angles_deg: joints.iter().map(|row| number(row, "value")).collect(),
    };
    (arm(&joints_of_arm, &arm_end), pose)
}

/// The arms of the fixtures with beams, each with its pose.
pub(crate) fn with_beams() -> Vec<(Robot, Pose)> {
    let all = rows("mixed_arms.csv");
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
        let six =
            |key: &str| SpringAxis::ALL.map(|axis| spring(number(end, &format!("{key}_{axis}"))));
        let (flange, tool) = (vector(end, "at"), vector(end, "tool"));
        let arm_end = ArmEnd {
            flange_m: flange,
            tool_m: [0, 1, 2].map(|i| flange[i] + tool[i]),
            base: six("base"),
            tool: six("held"),
            payload: None,
            link: beam(end),
        };
        let pose = Pose {
            angles_deg: joints.iter().map(|row| number(row, "value")).collect(),
        };
        let joints: Vec<ArmJoint> = joints.iter().map(joint).collect();
        (arm(&joints, &arm_end), pose)
    };
    all.chunk_by(|a, b| a["arm"] == b["arm"])
        .map(of_arm)
        .collect()
}

/// All arms of the fixtures, by number.
pub(crate) fn all() -> Vec<(Robot, Pose)> {
    let joints = rows("arms.csv");
    let ends = rows("ends.csv");
    ends.iter()
        .map(|end| {
            let own: Vec<&Row> = joints
                .iter()
                .filter(|row| row["arm"] == end["arm"])
                .collect();
            of_fixture(&own, end)
        })
        .collect()
}
