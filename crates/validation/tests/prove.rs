//! The proof: its scorer by hand-made verdicts, its seal, and a tiny run from end to end.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use serde_json::{Value as Json, json};
use stiffbench::mismatch::{
    Beginnings, ConfigurationSizes, Diagnosis, EstimatedValue, Finding, Location, MisfitShares,
    NoiseBasis, Omnibus, OmnibusTest, Quality, ReadingNoise, Stratum, Verdict, VerdictGrade,
};
use stiffbench::physics::{Effect, Law, Place, laws};
use stiffbench::readings::SessionHeader;
use stiffbench::source_text::SourceText;
use stiffbench_validation::prove::{
    BlindVerdict, NamedCause, Observer, Score, SealedAnswer, SealedAnswers, SealedSets,
    SessionTexts, Set, ValidationSession, VerdictOutcome, criteria, score, unseal,
};

fn data() -> PathBuf {
    stiffbench_test_files::repository().join("data")
}

fn read(path: &str) -> String {
    fs::read_to_string(data().join("concealed").join(path)).unwrap()
}

fn joint(law: Law, name: &str, size: f64) -> Effect {
    let mut values = vec![0.0; law.parameters.len()];
    values[0] = size;
    Effect::new(law, Place::Joint(name.to_owned()), values).unwrap()
}

fn finding(effect: Effect, group: Option<u32>) -> Finding {
    let value = |&value: &f64| EstimatedValue::of_covariance(value, (Some(0.1 * value.abs()), 1e6));
    Finding {
        values: effect.values.iter().map(value).collect(),
        combination: None,
        effect,
        grade: VerdictGrade::Is,
        shares: MisfitShares::default(),
        at_bound: false,
        spans_range: false,
        alternative_group: group,
        end_effect_m: 1e-5,
        absorbed_share: 0.2,
        log_bayes: 20.0,
        standard_errors: 8.0,
        p_family: 1e-4,
        rivals: Vec::new(),
    }
}

/// A diagnosis with these findings and a held-out error of 2 µm.
fn said(verdict: Verdict, findings: Vec<Finding>) -> BlindVerdict {
    let quality = Quality {
        rms_m: 2e-6,
        held_out_rms_m: Some(2e-6),
        held_out_noise_units: None,
        held_out: Vec::new(),
        reduced_chi2: 1.0,
    };
    let unexplained = Location {
        stratum: Stratum::Rest,
        pose: None,
        direction: None,
        period_s: None,
        p_family: 0.5,
        p_at_floor: false,
        size_m: 0.0,
    };
    BlindVerdict {
        session: "s".to_owned(),
        bench: "b".to_owned(),
        diagnosis: Ok(Diagnosis {
            verdict,
            grade: VerdictGrade::Is,
            lacking: Vec::new(),
            locations: Vec::new(),
            sizes: ConfigurationSizes::Common,
            beginnings: Beginnings::default(),
            findings,
            unexplained,
            unexplained_standard_errors: 0.0,
            omnibus: Omnibus {
                p: 1.0,
                contrast: OmnibusTest::Pattern(Stratum::Rest),
            },
            shares: MisfitShares::default(),
            misfit_steps: None,
            before: quality.clone(),
            after: quality,
            known_effects: Vec::new(),
            factors: Vec::new(),
            noise_basis: NoiseBasis::Repeats,
            noise: ReadingNoise {
                reading_sd_m: 1e-6,
                zero_sd_m: 1e-6,
                run_slope_sd: 1e-3,
                ..ReadingNoise::default()
            },
            noise_dof: [1e6; 3],
            further_noise: [None; 2],
            detection_limits: Vec::new(),
            impossible: Vec::new(),
            parameters: Vec::new(),
            effects: Vec::new(),
        }),
    }
}

/// A compliant joint A3 of 6 standard errors with rivals at given distances.
fn compliant(rivals: &[(&str, &str, f64)]) -> Json {
    json!({
        "physics": "joint-compliance", "place": { "joint": "A3" },
        "parameters": { "c": { "value": 1e-6, "unit": "rad/(N*m)" } },
        "standard_errors": 6.0, "standard_errors_beside_the_others": 6.0,
        "end_effect_um": 10.0, "absorbed_share": 0.5,
        "rivals": rivals.iter().map(|(physics, joint, between)| json!({
            "physics": physics, "place": { "joint": joint }, "standard_errors_between": between
        })).collect::<Vec<_>>(),
    })
}

fn answer(expected: &str, may_be_missed: bool, truth: &[Json]) -> SealedAnswer {
    serde_json::from_value(json!({
        "mode": "law", "expected": expected, "may_be_missed": may_be_missed, "truth": truth,
        "published_validation_passes": true, "floor_rms_um": 1.6,
        "beam_factors": { "A": 1.0 },
        "noise": { "sigma": 1.2, "sigma0": 2.0, "slope": 2e-3, "res_um": 1.0, "force_resolution_N": 0.1 },
    }))
    .unwrap()
}

/// Scores a verdict for an observer who finds the rivals of an answer as far away as it lists them, and all else at nine standard errors.
fn scored(verdict: &BlindVerdict, answer: &SealedAnswer) -> Score {
    let listed = |number: usize, member: &Effect| {
        let mut rivals = answer.truth[number].rivals.iter();
        let own = rivals
            .find(|rival| rival.physics == member.law.name && rival.place == json!(member.place));
        Ok(own.map_or(9.0, |rival| rival.standard_errors_between))
    };
    score(verdict, answer, Set::Development, &listed).unwrap()
}

fn outcome(verdict: Verdict, findings: Vec<Finding>, answer: &SealedAnswer) -> VerdictOutcome {
    scored(&said(verdict, findings), answer).outcome
}

#[test]
fn a_right_name_at_the_right_place_is_right() {
    let answer = answer("named", false, &[compliant(&[])]);
    let truth = || finding(joint(laws::JOINT_COMPLIANCE, "A3", 1.1e-6), None);
    let score = scored(&said(Verdict::Explained, vec![truth()]), &answer);
    assert_eq!(score.outcome, VerdictOutcome::Right);
    assert_eq!(score.truths[0].named, NamedCause::Alone);
    assert_eq!(score.truths[0].size_covered, Some(true));
    assert!((score.truths[0].size_ratio.unwrap() - 1.1).abs() < 1e-12);
    assert!((score.held_out_ratio.unwrap() - 1.25).abs() < 1e-12);
    assert!(score.is_concealed());
    let far = finding(joint(laws::JOINT_COMPLIANCE, "A3", 2e-6), None);
    let far = scored(&said(Verdict::Explained, vec![far]), &answer);
    assert_eq!(far.truths[0].size_covered, Some(false));
    // Right, but more is said than there is.
    let other = finding(joint(laws::JOINT_BACKLASH, "A1", 1e-6), None);
    let extra = outcome(Verdict::Explained, vec![truth(), other], &answer);
    assert_eq!(extra, VerdictOutcome::Extra);
    let unknown = outcome(Verdict::Unknown, vec![truth()], &answer);
    assert_eq!(unknown, VerdictOutcome::StructureClaimed);
}

#[test]
fn another_place_or_another_law_is_a_wrong_name() {
    let answer = answer("named", false, &[compliant(&[])]);
    for wrong in [
        joint(laws::JOINT_COMPLIANCE, "A2", 1e-6),
        joint(laws::JOINT_FRICTION, "A3", 1e-6),
    ] {
        let findings = vec![finding(wrong, None)];
        assert_eq!(
            outcome(Verdict::Explained, findings.clone(), &answer),
            VerdictOutcome::WrongName
        );
        assert_eq!(
            outcome(Verdict::Unknown, findings, &answer),
            VerdictOutcome::UnknownInstead
        );
    }
    assert_eq!(
        outcome(Verdict::NothingMissing, vec![], &answer),
        VerdictOutcome::NotFound
    );
    assert_eq!(
        outcome(Verdict::InsufficientData, vec![], &answer),
        VerdictOutcome::Undecided
    );
}

#[test]
fn sets_may_hold_what_is_near_and_nothing_else() {
    let rivals = [
        ("joint-compliance", "A2", 1.5),
        ("joint-backlash", "A3", 3.9),
        ("joint-backlash", "A2", 4.0),
    ];
    let ambiguous = answer("ambiguous", false, &[compliant(&rivals)]);
    let set = |effects: &[(Law, &str)]| -> Score {
        let members = effects
            .iter()
            .map(|(law, name)| finding(joint(*law, name, 1e-6), Some(1)));
        scored(&said(Verdict::Ambiguous, members.collect()), &ambiguous)
    };
    let truth = (laws::JOINT_COMPLIANCE, "A3");
    let twin = (laws::JOINT_COMPLIANCE, "A2");
    assert_eq!(set(&[truth, twin]).outcome, VerdictOutcome::Right);
    let near = (laws::JOINT_BACKLASH, "A3");
    let score = set(&[truth, twin, near]);
    assert_eq!(score.outcome, VerdictOutcome::Right);
    assert_eq!(score.truths[0].named, NamedCause::InSet(3));
    // Four standard errors apart, and more.
    for far in [(laws::JOINT_BACKLASH, "A2"), (laws::JOINT_BACKLASH, "C1")] {
        let score = set(&[truth, twin, far]);
        assert_eq!(score.outcome, VerdictOutcome::Padded);
        assert_eq!(score.truths[0].padding.len(), 1);
    }
    let score = set(&[truth, near]);
    assert_eq!(score.outcome, VerdictOutcome::Incomplete);
    assert_eq!(score.truths[0].left_out.len(), 1);
    // A set without the truth.
    assert_eq!(set(&[twin, near]).outcome, VerdictOutcome::WrongName);
    // Naming one of several that cannot be distinguished.
    let alone = vec![finding(joint(truth.0, truth.1, 1e-6), None)];
    let alone = outcome(Verdict::Explained, alone, &ambiguous);
    assert_eq!(alone, VerdictOutcome::Incomplete);
}

/// A session of the open list, and its answer.
fn open_session(id: &str) -> (ValidationSession, SealedAnswer) {
    let folder = format!("sessions/{id}");
    let text = read(&format!("{folder}/session.toml"));
    let named = SessionHeader::from_toml("session.toml", &text)
        .unwrap()
        .header;
    let robot = format!("{folder}/{}", named.robot.unwrap());
    let session = ValidationSession::read(&SessionTexts {
        id: id.to_owned(),
        header: SourceText::new("session.toml", text),
        readings: read(&format!("{folder}/readings.csv")),
        robot: SourceText::new(robot.as_str(), read(&robot)),
    });
    let text = read("development-answers.json");
    let answers = SealedAnswers::parse("development-answers.json", &text).unwrap();
    (session.unwrap(), answers.get(id).unwrap().clone())
}

#[test]
fn the_observer_finds_the_distances_of_the_other_implementation() {
    // A compliant joint beside a drift: 2.33 standard errors from an inclined load by OpenSees.
    let (session, answer) = open_session("b5aa8212");
    let observer = Observer::new(&session, &answer).unwrap().unwrap();
    let between = |name: &str| observer.between(0, &name.parse().unwrap()).unwrap();
    let of_load = between("load-misalignment@z>y:angle=1mrad");
    assert!((of_load - 2.33).abs() < 0.05, "{of_load}");
    // By reciprocity an inclined gauge does the same; OpenSees' program does not know it.
    let of_gauge = between("gauge-misalignment@z>y:angle=1mrad");
    assert!((of_gauge - of_load).abs() < 0.01, "{of_gauge}");
    let of_stand = between("gauge-stand-compliance@z:c=1nm/N");
    assert!((of_stand - 6.24).abs() < 0.15, "{of_stand}");
    // The truth, and a richer law that contains it.
    let other_size = between("joint-compliance@A4:c=1urad/(N*m)");
    assert!(other_size < 0.05, "{other_size}");
    let richer = between("joint-friction@A4:c=1urad/(N*m),friction_moment=1N*m");
    assert_eq!(richer, 0.0);

    let (session, answer) = open_session("085cadf0");
    let outside = Observer::new(&session, &answer).unwrap();
    assert!(
        outside.is_none(),
        "a plastic joint is no law of the library"
    );
}

#[test]
fn of_two_effects_each_needs_its_own_finding() {
    let drift = json!({
        "physics": "thermal-drift", "place": { "clock": true },
        "parameters": { "rate": { "value": 1e-8, "unit": "m/s" } },
        "standard_errors": 12.0, "standard_errors_beside_the_others": 11.9,
        "end_effect_um": 3.0, "absorbed_share": 0.1, "rivals": [],
    });
    let both = answer("named", false, &[compliant(&[]), drift]);
    let compliance = || finding(joint(laws::JOINT_COMPLIANCE, "A3", 1e-6), None);
    let drifting = |law| {
        finding(
            Effect::new(law, Place::Clock(None), vec![1e-8]).unwrap(),
            None,
        )
    };
    let right = vec![compliance(), drifting(laws::DRIFT_PER_SECOND)];
    let score = scored(&said(Verdict::Explained, right), &both);
    assert_eq!(score.outcome, VerdictOutcome::Right);
    assert!(score.truths.iter().all(|t| t.named == NamedCause::Alone));
    // The drift of the other unit is another law.
    let other = vec![compliance(), drifting(laws::DRIFT_PER_KELVIN)];
    assert_eq!(
        outcome(Verdict::Explained, other, &both),
        VerdictOutcome::WrongName
    );
    let one = vec![compliance()];
    assert_eq!(
        outcome(Verdict::Explained, one, &both),
        VerdictOutcome::Partly
    );
    // Two findings of the same effect do not stand for two effects.
    let twice = vec![compliance(), compliance()];
    assert_eq!(
        outcome(Verdict::Explained, twice, &both),
        VerdictOutcome::WrongName
    );
}

#[test]
fn nothing_small_and_unknown() {
    let nothing = answer("nothing-missing", false, &[]);
    assert_eq!(
        outcome(Verdict::NothingMissing, vec![], &nothing),
        VerdictOutcome::Right
    );
    assert_eq!(
        outcome(Verdict::Unknown, vec![], &nothing),
        VerdictOutcome::FalseAlarm
    );
    assert_eq!(
        outcome(Verdict::InsufficientData, vec![], &nothing),
        VerdictOutcome::Undecided
    );
    let small = answer("named", true, &[compliant(&[])]);
    assert_eq!(
        outcome(Verdict::NothingMissing, vec![], &small),
        VerdictOutcome::MayBeMissed
    );
    let mut outside = answer("unknown", false, &[]);
    for (left, missed) in [
        (9.0, VerdictOutcome::NotFound),
        (4.5, VerdictOutcome::MayBeMissed),
    ] {
        outside.left_by_library = Some(left);
        let found = finding(joint(laws::JOINT_FRICTION, "A3", 1e-6), None);
        let with = |verdict, findings| outcome(verdict, findings, &outside);
        assert_eq!(
            with(Verdict::Unknown, vec![found.clone()]),
            VerdictOutcome::Right
        );
        let named = if left > 6.0 {
            VerdictOutcome::WrongName
        } else {
            VerdictOutcome::PartNamed
        };
        assert_eq!(with(Verdict::Explained, vec![found]), named);
        assert_eq!(with(Verdict::NothingMissing, vec![]), missed);
    }
}

#[test]
fn outside_the_library_a_law_at_the_place_is_mostly_and_one_elsewhere_a_wrong_name() {
    let mut truth = compliant(&[]);
    truth["physics"] = json!("joint-plasticity");
    let mut outside = answer("unknown", false, &[truth]);
    outside.left_by_library = Some(9.0);
    let graded = |grade, joints: &[&str]| {
        let at = |name: &&str| finding(joint(laws::JOINT_FRICTION, name, 1e-6), None);
        let mut verdict = said(Verdict::Explained, joints.iter().map(at).collect());
        verdict.diagnosis.as_mut().unwrap().grade = grade;
        scored(&verdict, &outside).outcome
    };
    assert_eq!(
        graded(VerdictGrade::Mostly, &["A3"]),
        VerdictOutcome::Mostly
    );
    // Nothing is said of the rest under *is*, and another joint is not the place.
    for (grade, joints) in [
        (VerdictGrade::Is, &["A3"][..]),
        (VerdictGrade::Mostly, &["A2"]),
        (VerdictGrade::Mostly, &["A3", "A2"]),
    ] {
        assert_eq!(
            graded(grade, joints),
            VerdictOutcome::WrongName,
            "{joints:?}"
        );
    }
}

#[test]
fn acceptance_criteria_count_their_own_sessions() {
    let named = answer("named", false, &[compliant(&[])]);
    let truth = vec![finding(joint(laws::JOINT_COMPLIANCE, "A3", 1e-6), None)];
    let nothing = answer("nothing-missing", false, &[]);
    let scores = [
        scored(&said(Verdict::Explained, truth), &named),
        scored(&said(Verdict::NothingMissing, vec![]), &named),
        scored(&said(Verdict::NothingMissing, vec![]), &nothing),
    ];
    let counted = |start: &str| -> (usize, usize) {
        let criteria = criteria(&scores);
        let criterion = criteria.iter().find(|p| p.what.starts_with(start)).unwrap();
        (criterion.share.hits, criterion.share.trials)
    };
    assert_eq!(counted("false alarms"), (0, 1));
    assert_eq!(counted("one effect of 6 or more, not slip"), (1, 2));
    assert_eq!(counted("one effect of 4.5"), (0, 0));
    assert_eq!(counted("one slip"), (0, 0));
    assert_eq!(counted("the published validation passes"), (1, 2));
}

#[test]
fn opened_answers_are_those_of_the_open_list() {
    let plain = unseal(&read("answers.sealed")).unwrap();
    let all = SealedAnswers::parse("answers.sealed", &plain).unwrap();
    let open = SealedAnswers::parse(
        "development-answers.json",
        &read("development-answers.json"),
    )
    .unwrap();
    let sets = SealedSets::parse("sets.toml", &read("sets.toml")).unwrap();
    let mut names = sets.development.clone();
    names.sort();
    let known: Vec<&String> = open.iter().map(|(name, _)| name).collect();
    assert_eq!(known, names.iter().collect::<Vec<_>>());
    for (name, answer) in open.iter() {
        assert_eq!(all.get(name).unwrap(), answer, "{name}");
    }
    let both = sets.development.len() + sets.proof.len();
    assert_eq!(all.iter().count(), both);
    let archive = fs::File::open(data().join("concealed/proof-sessions.zip")).unwrap();
    let mut packed = zip::ZipArchive::new(archive).unwrap();
    for (name, set) in sets.chosen(None) {
        let folder = data().join("concealed/sessions").join(&name);
        let readings = format!("sessions/{name}/readings.csv");
        let is_open = set == Set::Development;
        assert_eq!(folder.is_dir(), is_open, "{name}");
        assert_eq!(packed.by_name(&readings).is_err(), is_open, "{name}");
    }
}

fn prove(arguments: &[&str], threads: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stiffbench-validate"))
        .arg("prove")
        .args(arguments)
        .env("RAYON_NUM_THREADS", threads)
        .output()
        .unwrap()
}

#[test]
fn a_tiny_proof_is_the_same_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let data = data();
    let verdicts = ["1", "3"].map(|threads| {
        let out = folder.path().join(threads);
        let words = [
            "--only",
            "concealed",
            "--set",
            "development",
            "--sessions",
            "2",
            "--data",
            data.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
            "--json",
        ];
        let output = prove(&words, threads);
        assert!(
            output.status.success(),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let printed: Json = serde_json::from_slice(&output.stdout).unwrap();
        let scored = &printed["data"]["parts"]["concealed"]["development"];
        assert_eq!(scored["scores"].as_array().unwrap().len(), 2);
        let stored: Json =
            serde_json::from_str(&fs::read_to_string(out.join("prove.json")).unwrap()).unwrap();
        assert_eq!(stored["data"], printed["data"]);
        assert!(out.join("tables.txt").is_file());
        fs::read_to_string(out.join("verdicts.json")).unwrap()
    });
    assert_eq!(verdicts[0], verdicts[1]);
}

#[test]
fn without_its_data_the_validation_names_their_source() {
    let folder = tempfile::tempdir().unwrap();
    let nowhere = folder.path().join("nowhere");
    let output = prove(&["--data", nowhere.to_str().unwrap(), "--json"], "1");
    assert_eq!(output.status.code(), Some(11));
    let printed: Json = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed["error"]["code"], "stiffbench::input::proof_data");
    let help = printed["error"]["help"].as_str().unwrap();
    assert!(help.contains("--data"), "{help}");
}

#[test]
fn power_is_counted_for_the_laws_and_sizes_that_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let (data, out) = (data(), folder.path().join("power"));
    let power = |laws: &str| {
        let places = [
            "--data",
            data.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
        ];
        let asked = [
            "--only", "power", "--laws", laws, "--sizes", "8", "--trials", "1", "--json",
        ];
        let output = prove(&[&places[..], &asked[..]].concat(), "2");
        let printed: Json = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), printed)
    };
    let (code, printed) = power("creep");
    assert_eq!(code, Some(0));
    let cases = printed["data"]["parts"]["power"]["cases"].as_array();
    let [case] = &cases.unwrap()[..] else {
        panic!("creep is tried on one bench: {printed}");
    };
    assert_eq!(case["laws"], json!(["creep"]));
    let points = case["points"].as_array().unwrap();
    assert_eq!(points.len(), 1);
    assert_eq!(points[0]["standard_errors"], 8.0);
    // At eight standard errors a diagnosis that finds creep in less than half of six benches has lost its way.
    assert!(points[0]["found"]["hits"].as_u64().unwrap() >= 3, "{case}");
    // An observer who knows the noise misses none of these, and never counts what is not found as rightly named.
    let ideal = &points[0]["ideal"];
    let hits = |what: &str| ideal[what]["hits"].as_u64().unwrap();
    assert!(hits("right") <= hits("nameable") && hits("nameable") <= hits("found"));
    assert!(hits("right") > 3900, "{ideal}");
    let tables = fs::read_to_string(out.join("tables.txt")).unwrap();
    let name = |line: &str| line.split('|').nth(1).map(|cell| cell.trim().to_owned());
    let of_creep = tables
        .lines()
        .filter(|line| name(line).as_deref() == Some("creep"));
    assert_eq!(
        of_creep.count(),
        2,
        "by itself, and beside the observer:\n{tables}"
    );

    let (code, printed) = power("cereep");
    assert_eq!(code, Some(2), "{printed}");
    assert!(
        printed["error"]["help"]
            .as_str()
            .unwrap()
            .contains("did you mean creep?")
    );
}

#[test]
fn power_trials_cover_slips_everywhere_and_noise_of_earlier_sessions() {
    let folder = tempfile::tempdir().unwrap();
    let (data, out) = (data(), folder.path().join("power"));
    let counted = |arguments: &[&str]| {
        let places = [
            "--data",
            data.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
            "--only",
            "power",
            "--json",
        ];
        let output = prove(&[&places[..], arguments].concat(), "2");
        assert_eq!(output.status.code(), Some(0));
        let printed: Json = serde_json::from_slice(&output.stdout).unwrap();
        printed["data"].clone()
    };
    // 24 trials of each size, eight a place.
    let data = counted(&["--laws", "slip", "--trials", "600"]);
    assert_eq!(data["earlier_sessions"], 0);
    let case = &data["parts"]["power"]["cases"][0];
    let places = case["places"].as_array().unwrap();
    assert_eq!(places.len(), 3);
    for (number, place) in places.iter().enumerate() {
        assert!(place["step"].as_u64().unwrap() >= 1, "{place}");
        let others = places[..number].iter();
        for other in others {
            assert!(other["run"] != place["run"] && other["step"] != place["step"]);
        }
    }
    let base = [
        "--laws",
        "base-compliance",
        "--sizes",
        "4.5",
        "--trials",
        "400",
    ];
    let alone = counted(&base);
    let together = counted(&[&base[..], &["--earlier", "4"]].concat());
    assert_eq!(together["earlier_sessions"], 4);
    let found = |data: &Json| data["parts"]["power"]["cases"][0]["points"][0]["found"].clone();
    let [alone, together] = [found(&alone), found(&together)];
    assert_eq!(alone["trials"], together["trials"]);
    // The same sessions, their noise known better: of 16 no more than two are lost for it.
    let hits = |share: &Json| share["hits"].as_u64().unwrap();
    assert!(hits(&together) + 2 >= hits(&alone), "{alone} {together}");
    let text = fs::read_to_string(out.join("tables.txt")).unwrap();
    assert!(
        text.contains("noise estimated from 4 earlier sessions too"),
        "{text}"
    );
}

#[test]
fn the_doors_of_one_robot_differ_as_the_ledger_lists_and_in_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let (data, out) = (data(), folder.path().join("doors"));
    let arguments = [
        "--only",
        "doors",
        "--quick",
        "--strict",
        "--json",
        "--data",
        data.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ];
    let output = prove(&arguments, "2");
    let printed: Json = serde_json::from_slice(&output.stdout).unwrap();
    let doors = &printed["data"]["parts"]["doors"];
    // Nothing missing, and twelve laws.
    assert_eq!(doors["cases"].as_array().unwrap().len(), 13, "{printed}");
    assert_eq!(doors["disagreements"], json!([]));
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn intervals_of_stated_laws_hold_what_was_simulated() {
    let folder = tempfile::tempdir().unwrap();
    let (data, out) = (data(), folder.path().join("forced"));
    let arguments = [
        "--only",
        "forced",
        "--doors",
        "session,part",
        "--laws",
        "joint-backlash,creep",
        "--sizes",
        "10",
        "--trials",
        "150",
        "--json",
        "--data",
        data.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ];
    let output = prove(&arguments, "2");
    let printed: Json = serde_json::from_slice(&output.stdout).unwrap();
    let points = printed["data"]["parts"]["forced"].as_array().unwrap();
    let (mut hits, mut trials) = (0, 0);
    for (door, law, values) in [
        ("session", "joint-backlash", 2),
        ("session", "creep", 2),
        ("part", "joint-backlash", 2),
        ("part", "joint-backlash (force read)", 2),
    ] {
        let point = points
            .iter()
            .find(|point| point["door"] == door && point["law"] == law);
        let rows = point.unwrap_or_else(|| panic!("{law}: {printed}"))["coverage"]
            .as_array()
            .unwrap();
        let of_law = rows.iter().filter(|row| {
            let name = row["parameter"].as_str();
            name.is_some_and(|name| name.contains('@'))
        });
        let of_law: Vec<&Json> = of_law.map(|row| &row["share"]).collect();
        assert!(of_law.len() >= values, "{door} {law}: {rows:?}");
        for share in of_law {
            assert_eq!(share["trials"], 6, "{door} {law}");
            trials += share["trials"].as_u64().unwrap();
            hits += share["hits"].as_u64().unwrap();
        }
    }
    // Of 48 intervals 95 % hold the truth; fewer than 39 have a chance of 0.01 % (binomial).
    assert!(10 * hits >= 8 * trials, "{hits} of {trials}");
    assert!(out.join("tables.txt").is_file());
}
