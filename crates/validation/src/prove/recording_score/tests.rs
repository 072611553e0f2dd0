use super::*;
use crate::prove::recordings::Recordings;

fn recording(keys: &str) -> Recording {
    let known = format!(
        "schema = \"stiffbench/recordings/1\"\n[[recording]]\nname = \"r\"\nfiles = []\nsource = \"\"\nlicence = \"\"\nwhy = \"\"\n\
         {keys}\n[recording.figures]\n"
    );
    Recordings::parse("r.toml", &known)
        .unwrap()
        .recording
        .remove(0)
}

/// Relaxation, which friction imitates at one rate; a curve beside it.
fn loop_at_one_rate() -> Recording {
    recording(
        "verdict = \"ambiguous\"\nalso-right = [\"explained\", \"odd-polynomial\"]\nphysics = [\"relaxation\"]\n\
         only-in-sets = [\"joint-friction\"]\nnot = [\"slip\"]",
    )
}

const fn law(law: &str, group: Option<u32>, share: f64) -> SaidLaw<'_> {
    SaidLaw {
        law,
        group,
        share: Some(share),
    }
}

fn counted(
    known: &Recording,
    verdict: Verdict,
    grade: VerdictGrade,
    said: &[SaidLaw<'_>],
) -> (RecordingOutcome, Vec<String>) {
    let names = foreign(known, verdict, said);
    let names = names.into_iter().map(str::to_owned).collect();
    (outcome(known, verdict, grade, said), names)
}

const NONE: Vec<String> = Vec::new();

#[test]
fn the_physics_leads_alone_or_in_a_set() {
    let known = loop_at_one_rate();
    let said = [
        law("relaxation", None, 0.9),
        law("odd-polynomial", None, 0.1),
    ];
    let found = counted(&known, Verdict::Explained, VerdictGrade::Mostly, &said);
    assert_eq!(found, (RecordingOutcome::Right, NONE));
    let said = [
        law("joint-friction", Some(1), 0.9),
        law("relaxation", Some(1), 0.9),
    ];
    let found = counted(&known, Verdict::Ambiguous, VerdictGrade::Is, &said);
    assert_eq!(found, (RecordingOutcome::Right, NONE));
    // No more than likely is no headline.
    let found = counted(&known, Verdict::Ambiguous, VerdictGrade::Weak, &said);
    assert_eq!(found, (RecordingOutcome::NotRight, NONE));
}

#[test]
fn what_may_stand_beside_the_physics_does_not_lead() {
    let known = loop_at_one_rate();
    let said = [
        law("odd-polynomial", None, 0.6),
        law("relaxation", None, 0.4),
    ];
    let found = counted(&known, Verdict::Explained, VerdictGrade::Mostly, &said);
    assert_eq!(found, (RecordingOutcome::RightBehind, NONE));
    let found = counted(&known, Verdict::Explained, VerdictGrade::Mostly, &said[..1]);
    assert_eq!(found, (RecordingOutcome::NotRight, NONE));
}

#[test]
fn a_law_of_a_set_is_foreign_alone() {
    let known = loop_at_one_rate();
    let said = [law("joint-friction", None, 0.9)];
    let found = counted(&known, Verdict::Explained, VerdictGrade::Is, &said);
    let names = vec!["joint-friction".to_owned()];
    assert_eq!(found, (RecordingOutcome::FalseDominant, names));
}

#[test]
fn under_unknown_a_part_may_be_any_law_that_is_not_excluded() {
    let known = loop_at_one_rate();
    let said = [law("joint-friction", None, 0.5), law("slip", None, 0.2)];
    let found = counted(&known, Verdict::Unknown, VerdictGrade::Unknown, &said);
    assert_eq!(found, (RecordingOutcome::NotRight, vec!["slip".to_owned()]));
    let found = counted(&known, Verdict::Unknown, VerdictGrade::Unknown, &[]);
    assert_eq!(found, (RecordingOutcome::Mute, NONE));
    let null = recording("verdict = \"nothing-missing\"\nalso-right = []\nphysics = []\nnot = []");
    let found = counted(&null, Verdict::NothingMissing, VerdictGrade::Nothing, &[]);
    assert_eq!(found, (RecordingOutcome::Right, NONE));
    let found = counted(&null, Verdict::Unknown, VerdictGrade::Unknown, &[]);
    assert_eq!(found, (RecordingOutcome::Mute, NONE));
}
