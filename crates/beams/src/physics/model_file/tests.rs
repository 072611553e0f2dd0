use proptest::prelude::*;

use super::*;
use std::collections::BTreeMap;

use crate::physics::{Law, Place, PlaceKind, laws};
use crate::robot::{FittingFactors, ModelParameter, SpringAxis};
use crate::structure::Property;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

fn parse(text: &str) -> Result<ModelFile, ModelFileError> {
    ModelFile::parse(&SourceText::new("model.toml", text))
}

const EXAMPLE: &str = r#"
schema = "stiffbench/model/1"
robot = "robot.toml"
mechanism = "F"

[provenance]
session = "s-1"
verdict = "explained"

[factors]
beam = { A = 1, Iy = 0.8, Iz = 1.1, J = 1.0 }
link = { A = 1.0, Iy = 1.0, Iz = 1.0, J = 1.0 }

[[effects]]
physics = "joint-backlash"
place = { joint = "A3" }
alternative_group = 1
[effects.parameters]
play = { value = 120, unit = "urad", u = 10, dof = 40.0, ci95 = [100, 140] }
seat_moment = { value = 3.6, unit = "N*m" }

[[effects]]
physics = "thermal-drift"
parameters.rate = { value = 6.2e-6, unit = "m/K" }

[[alternatives]]
physics = "slip"
place = { run = { pose = "P3", direction = "z", repeat = 2 }, step = 5 }
alternative_group = 1
parameters.jump = { value = -3e-5, unit = "m" }
"#;

#[test]
fn an_example_is_read_in_si() {
    let model = parse(EXAMPLE).unwrap();
    assert_eq!(model.mechanism.as_deref(), Some("F"));
    assert_eq!(model.provenance.verdict.as_deref(), Some("explained"));
    assert_eq!(model.factors.as_ref().unwrap().beam, [1.0, 0.8, 1.1, 1.0]);
    let [backlash, drift] = &model.effects[..] else {
        panic!("{model:?}")
    };
    assert_eq!(backlash.effect.values, [1.2e-4, 3.6]);
    assert_eq!(backlash.uncertainties[0].u, Some(1e-5));
    assert_eq!(backlash.uncertainties[0].ci95, Some([1e-4, 1.4e-4]));
    assert_eq!(backlash.uncertainties[1], ParameterUncertainty::default());
    assert_eq!(drift.effect.law, laws::DRIFT_PER_KELVIN);
    assert_eq!(drift.effect.place, Place::Clock(None));
    assert_eq!(model.alternatives[0].alternative_group, Some(1));
    assert_eq!(model.acting().len(), 2);
}

#[test]
fn what_is_written_is_the_form_of_the_documentation() {
    let text = parse(EXAMPLE).unwrap().to_toml();
    assert!(
        text.contains("# twist = 0 for |tau| < seat_moment"),
        "{text}"
    );
    assert!(
        text.contains("\"rad\", u = 1e-5, dof = 40.0, ci95 = [0.0001, 0.00014] }"),
        "{text}"
    );
    assert!(
        text.contains("# The following alternatives are not applied."),
        "{text}"
    );
    assert!(
        !parse("schema = \"stiffbench/model/1\"")
            .unwrap()
            .to_toml()
            .contains("act.")
    );
}

/// One change of the example, where its error stands, what the message says, and what the help says.
type Mistake = (
    &'static str,
    &'static str,
    (usize, usize),
    &'static str,
    &'static str,
);

#[rustfmt::skip]
const WRONG: [Mistake; 24] = [
    ("robot = \"robot.toml\"", "robot = ", (3, 9), "", ""),
    ("model/1", "model/2", (2, 10), "`stiffbench/model/2`", "version"),
    ("schema =", "format =", (1, 1), "no `schema`", ""),
    ("mechanism =", "mechanim =", (4, 1), "no key `mechanim`", "`mechanism`"),
    ("[[alternatives]]", "[[alternatifs]]", (26, 3), "no key `alternatifs`", "`alternatives`"),
    ("session =", "seson =", (7, 1), "no key `seson` in `provenance`", "`session`"),
    ("Iy = 0.8", "Iy = -0.8", (11, 22), "above zero", ""),
    ("Iy = 0.8, ", "", (11, 8), "`Iy` is missing in `factors.beam`", ""),
    ("Iy = 0.8", "Iy = nan", (11, 22), "a finite number", ""),
    ("\"joint-backlash\"", "\"joint-backlsh\"", (15, 11), "no law `joint-backlsh`", "joint-backlash"),
    ("\"joint-backlash\"", "7", (15, 11), "a text in quotes", ""),
    ("{ joint = \"A3\" }", "{ element = \"A3\" }", (16, 11), "no key `element`", "joint"),
    ("{ joint = \"A3\" }", "{ joint = 3 }", (16, 19), "a name in quotes", ""),
    ("place = { joint = \"A3\" }\n", "", (14, 1), "joint-backlash needs a place", "@A3"),
    ("alternative_group = 1\n[", "alternative_group = -1\n[", (17, 21), "a whole number", ""),
    ("play =", "pley =", (19, 1), "no parameter `pley`", "play"),
    ("unit = \"urad\"", "unit = \"mm\"", (19, 8), "cannot have the unit `mm`", "rad, mrad"),
    (", unit = \"urad\"", "", (19, 8), "`unit` is missing in `effects.parameters.play`", ""),
    ("value = 120", "value = -120", (19, 8), "not below zero", ""),
    ("[100, 140]", "[140, 100]", (19, 65), "the smaller first", ""),
    ("u = 10", "u = -10", (19, 42), "not below zero", ""),
    ("seat_moment = { value = 3.6, unit = \"N*m\" }\n", "", (14, 1), "needs seat_moment", "joint-backlash@A3"),
    ("direction = \"z\", repeat", "direction = \"\", repeat", (28, 44), "a name in quotes", ""),
    ("repeat = 2 }, step", "repeat = 2, place = 3 }, step", (28, 61), "no key `place` in `alternatives.place.run`", "pose"),
];

#[test]
fn every_mistake_is_shown_in_its_place() {
    for (from, to, place, says, helps) in WRONG {
        let text = EXAMPLE.replacen(from, to, 1);
        assert_ne!(text, EXAMPLE, "{from}");
        let error = parse(&text).expect_err(to);
        let message = error.to_string();
        assert!(message.contains(says), "{to}: {message}");
        assert_eq!((error.line, error.column), place, "{to}: {message}");
        assert!(error.help.unwrap_or_default().contains(helps), "{to}");
    }
}

#[test]
fn fixed_places_must_agree_with_the_file() {
    let creep = |place: &str| {
        parse(&format!(
            "schema = \"{MODEL_SCHEMA}\"\n[[effects]]\nphysics = \"creep\"\n{place}\nparameters = {{ k = {{ value = 0.01, unit = \"1/decade\" }}, \
             t0 = {{ value = 1, unit = \"s\" }} }}\n"
        ))
    };
    assert!(creep("").is_ok());
    assert!(creep("place = { structure = true }").is_ok());
    for place in [
        "{ structure = false }",
        "{ clock = true }",
        "{}",
        "\"structure\"",
    ] {
        let error = creep(&format!("place = {place}")).expect_err(place);
        assert_eq!(error.line, 4, "{place}");
    }
}

/// Numbers of every size; the smallest and the largest included.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        (-300..300_i32, -9.999..9.999_f64).prop_map(|(power, digits)| digits * 10_f64.powi(power)),
        Just(0.0),
        Just(f64::MAX),
        Just(f64::MIN_POSITIVE),
    ]
}

fn a_place(kind: PlaceKind) -> BoxedStrategy<Place> {
    let direction = || prop::sample::select(Direction::ALL.to_vec());
    match kind {
        PlaceKind::Joint => ".{1,12}".prop_map(Place::Joint).boxed(),
        PlaceKind::AcrossJoint => (".{1,12}", direction())
            .prop_map(|(joint, axis)| Place::AcrossJoint { joint, axis })
            .boxed(),
        PlaceKind::ToolAbout | PlaceKind::ToolAlong => {
            let own = SpringAxis::ALL.into_iter().map(Place::Tool);
            let own = own.filter(|place| place.kind() == kind);
            prop::sample::select(own.collect::<Vec<_>>()).boxed()
        }
        PlaceKind::Element => ".{1,12}".prop_map(Place::Element).boxed(),
        PlaceKind::Axis => direction().prop_map(Place::Axis).boxed(),
        PlaceKind::Direction => direction().prop_map(Place::Direction).boxed(),
        PlaceKind::Toward => (0..3_usize, 1..3_usize)
            .prop_map(|(along, on)| Place::Toward {
                direction: Direction::ALL[along],
                toward: Direction::ALL[(along + on) % 3],
            })
            .boxed(),
        PlaceKind::Run => (".{1,8}", direction(), any::<u32>(), any::<u32>())
            .prop_map(|(pose, direction, repeat, step)| Place::Run {
                pose: PoseId::new(&pose),
                direction: direction.into(),
                repeat,
                step,
                gauge: None,
            })
            .boxed(),
        PlaceKind::Length => ("[^.]{1,8}", ".{1,8}")
            .prop_map(|(body, entry)| Place::Length { body, entry })
            .boxed(),
        PlaceKind::JointAngle => (".{1,8}", prop::option::of("[^/]{1,8}"))
            .prop_map(|(joint, pose)| Place::JointAngle {
                joint,
                pose: pose.as_deref().map(PoseId::new),
            })
            .boxed(),
        PlaceKind::Group => (
            ".{1,8}",
            prop::option::of(prop::sample::select(Property::ALL.to_vec())),
        )
            .prop_map(|(group, property)| Place::Group { group, property })
            .boxed(),
        PlaceKind::Mechanism => ".{1,12}".prop_map(Place::Mechanism).boxed(),
        fixed => Just(fixed.only().unwrap()).boxed(),
    }
}

fn found() -> impl Strategy<Value = FoundEffect> {
    let law = prop::sample::select(Law::ALL.to_vec());
    law.prop_flat_map(|law| {
        let count = law.parameters.len();
        let uncertainty = (
            prop::option::of(number().prop_map(f64::abs)),
            prop::option::of(0.0..1e6_f64),
            prop::option::of((number(), number())),
        )
            .prop_map(|(u, dof, ends)| ParameterUncertainty {
                u,
                dof,
                ci95: ends.map(|(a, b)| [a.min(b), a.max(b)]),
            });
        (
            a_place(law.place_kind),
            prop::collection::vec(number(), count),
            prop::collection::vec(uncertainty, count),
            prop::option::of(any::<u32>()),
        )
            .prop_map(
                move |(place, mut values, uncertainties, alternative_group)| {
                    for (value, spec) in values.iter_mut().zip(law.parameters) {
                        if !spec.sign.allows(*value) {
                            *value = value.abs().max(f64::MIN_POSITIVE);
                        }
                    }
                    FoundEffect {
                        effect: Effect::new(law, place, values).unwrap(),
                        uncertainties,
                        alternative_group,
                    }
                },
            )
    })
}

/// Compliances of springs of every kind.
fn springs() -> impl Strategy<Value = BTreeMap<ModelParameter, f64>> {
    let joint = "[^.]{1,9}".prop_map(|name| ModelParameter::Joint(name.into()));
    let along = "[^.]{1,9}".prop_map(|name| ModelParameter::JointAlong(name.into()));
    let about = ("[^.]{1,9}", prop::sample::select(Direction::ALL.to_vec()))
        .prop_map(|(name, axis)| ModelParameter::JointAbout(name.into(), axis));
    let axis = || prop::sample::select(SpringAxis::ALL.to_vec());
    let ends = (axis(), any::<bool>()).prop_map(|(axis, base)| {
        if base {
            ModelParameter::Base(axis)
        } else {
            ModelParameter::Tool(axis)
        }
    });
    let spring = prop_oneof![joint, along, about, ends];
    prop::collection::btree_map(spring, 0.0..1.0_f64, 0..5)
}

prop_compose! {
    fn a_model()(
        words in prop::array::uniform6(prop::option::of(".{0,20}")),
        factors in prop::option::of(prop::array::uniform8(1e-9..1e9_f64)),
        sections in prop::collection::btree_map(".{1,9}", prop::array::uniform4(1e-9..1e9_f64), 0..3),
        springs in springs(),
        effects in prop::collection::vec(found(), 0..4),
        alternatives in prop::collection::vec(found(), 0..3),
    ) -> ModelFile {
        let [robot, robot_sha256, mechanism, session, software, verdict] = words;
        ModelFile {
            robot, robot_sha256, mechanism,
            provenance: Provenance { session, software, verdict },
            factors: factors.map(|f| FittingFactors {
                sections,
                springs,
                ..FittingFactors::of_classes([f[0], f[1], f[2], f[3]], [f[4], f[5], f[6], f[7]])
            }),
            effects, alternatives,
        }
    }
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(model in a_model()) {
        let text = model.to_toml();
        prop_assert_eq!(parse(&text).map_err(|error| error.to_string()), Ok(model), "{}", text);
    }

    #[test]
    fn no_text_makes_the_reader_panic(cut in 0..EXAMPLE.len(), put in ".{0,3}") {
        let mut at = cut;
        while !EXAMPLE.is_char_boundary(at) { at -= 1; }
        let _ = parse(&format!("{}{put}{}", &EXAMPLE[..at], &EXAMPLE[at..]));
    }

    #[test]
    fn the_compact_form_of_an_effect_is_read_back(found in found()) {
        let named = match &found.effect.place {
            Place::Joint(name) | Place::Element(name) | Place::Mechanism(name) => name.trim() == name,
            Place::AcrossJoint { joint, .. } => joint.trim_start() == joint,
            Place::Length { body, entry } => body.trim_start() == body && entry.trim_end() == entry,
            Place::JointAngle { joint, pose } => {
                let pose = pose.as_ref().map_or("", PoseId::as_str);
                joint.trim_start() == joint && pose.trim_end() == pose && !(pose.is_empty() && (joint.contains('/') || joint.trim() != joint))
            }
            Place::Group { group, property } => {
                group.trim() == group && (property.is_some() || !group.contains('.'))
            }
            Place::Run { pose, .. } => pose.as_str().trim() == pose.as_str(),
            _ => true,
        };
        prop_assume!(named);
        let text = found.effect.compact();
        prop_assert_eq!(text.parse::<Effect>(), Ok(found.effect), "{}", text);
    }
}
