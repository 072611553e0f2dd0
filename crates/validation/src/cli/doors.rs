//! The part of `prove` that sends the same readings through every door of the program.

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::process::Command;

use rayon::prelude::*;
use serde_json::{Value, json};
use tempfile::TempDir;

use stiffbench::analysis::{ReadError, named_procedure};
use stiffbench::cli::args::Global;
use stiffbench::cli::failure::{CliError, Failure};
use stiffbench::cli::figure_files::write_again;
use stiffbench::cli::json_of;
use stiffbench::cli::progress::progress;
use stiffbench::physics::{Effect, Law, laws};

use crate::prove::{
    DoorAnswer, DoorBench, DoorBenches, DoorJudge, DoorLedger, JudgedCase, coverage, differences,
    disagreements, is_named, vector_table,
};
use crate::report::DoorsReport;

use super::prove::read;
use super::prove_args::ProveArgs;

/// Laws under `--quick`, on the first bench.
const QUICK_LAWS: [Law; 12] = [
    laws::JOINT_COMPLIANCE,
    laws::JOINT_BACKLASH,
    laws::JOINT_FRICTION,
    laws::JOINT_NONLINEARITY,
    laws::LOAD_MISALIGNMENT,
    laws::FORCE_GAUGE_NONLINEARITY,
    laws::CREEP,
    laws::DRIFT_PER_SECOND,
    laws::SETTING_IN,
    laws::SLIP,
    laws::GAUGE_PERIODIC,
    laws::CONSTANT_FORCE,
];

/// What is run: the commands of this program or of another build, on benches under loads.
pub(super) struct Doors<'a> {
    program: Option<&'a Path>,
    pub(super) benches: DoorBenches,
    /// Largest load, N.
    pub(super) largest_n: f64,
}

/// A session to be judged.
struct DoorCase<'a> {
    judge: DoorJudge,
    bench: &'a DoorBench,
    effect: Option<&'a str>,
}

/// Judges the doors and writes what the ledger would be.
///
/// # Arguments
/// - `trials`: sessions of which the intervals are counted; 0 under `--quick`.
pub(super) fn judge_doors(
    args: &ProveArgs,
    global: &Global,
    trials: usize,
) -> Result<DoorsReport, Failure> {
    let ledger = args.data.join("doors").join("ledger.toml");
    let ledger = DoorLedger::parse(&ledger.display().to_string(), &read(&ledger)?)?;
    let doors = Doors::new(args)?;
    let cases = doors.cases(args.quick);
    let bar = progress(global, "readings through every door", cases.len() as u64);
    let judged: Vec<JudgedCase> = cases
        .par_iter()
        .map(|case| {
            let judged = doors.judge(case);
            bar.inc(1);
            judged
        })
        .collect::<Result<_, Failure>>()?;
    bar.finish_and_clear();
    let bar = progress(global, "sessions with nothing missing", trials as u64);
    let covered = (1..=trials as u64).into_par_iter().map(|trial| {
        let answers = doors.with_nothing_missing(args.seed + trial);
        bar.inc(1);
        answers
    });
    let covered = covered.collect::<Result<Vec<_>, Failure>>()?;
    bar.finish_and_clear();
    let (answers, truths): (Vec<_>, Vec<_>) = covered.into_iter().unzip();
    let (sessions, tables): (Vec<_>, Vec<_>) = answers.into_iter().map(<(_, _)>::from).unzip();
    let truth = truths.into_iter().next().unwrap_or_default();
    if !args.quick {
        let anew = DoorLedger::new(&judged).to_toml();
        write_again(&args.out.join("doors-ledger.toml"), anew.as_bytes())?;
    }
    Ok(DoorsReport {
        disagreements: disagreements(&ledger, &judged, !args.quick),
        cases: judged,
        coverage: if sessions.is_empty() {
            Vec::new()
        } else {
            let of_door = [("session", sessions), ("table", tables)].into_iter();
            let rows = of_door.flat_map(|(door, answers)| coverage(door, &answers, &truth));
            rows.collect()
        },
    })
}

impl<'a> Doors<'a> {
    pub(super) fn new(args: &'a ProveArgs) -> Result<Self, Failure> {
        let benches = args.data.join("doors").join("benches.toml");
        let benches = DoorBenches::parse(&benches.display().to_string(), &read(&benches)?)?;
        let (procedure, _) = named_procedure(&benches.procedure)?;
        let largest_n = procedure.loads_n.iter();
        Ok(Self {
            program: args.program.as_deref(),
            largest_n: largest_n.fold(0.0, |largest, load| largest.max(load.abs())),
            benches,
        })
    }

    fn cases(&self, is_quick: bool) -> Vec<DoorCase<'_>> {
        let mut cases = Vec::new();
        for judge in DoorJudge::ALL {
            for bench in &self.benches.bench {
                let nothing = (judge == DoorJudge::Pair).then_some(None);
                let effects = nothing
                    .into_iter()
                    .chain(bench.effects_for(judge).into_iter().map(Some));
                cases.extend(effects.map(|effect| DoorCase {
                    judge,
                    bench,
                    effect,
                }));
            }
        }
        let first = self.benches.bench.first().map(|bench| &bench.name);
        cases.retain(|case| {
            let law = case.effect.and_then(|effect| effect.parse::<Effect>().ok());
            let law = law.map(|effect| effect.law);
            let is_first = Some(&case.bench.name) == first;
            let is_of_judge = match case.judge {
                DoorJudge::Pair | DoorJudge::ThreeGauges => true,
                DoorJudge::Oblique | DoorJudge::Across => law.is_some_and(Law::is_of_a_joint),
                DoorJudge::LoadCases => is_first,
                DoorJudge::Positions => case.bench.instead.contains_key(&case.judge),
            };
            let is_short = case.judge == DoorJudge::Pair
                && is_first
                && law.is_none_or(|law| QUICK_LAWS.contains(&law));
            is_of_judge && (is_short || !is_quick)
        });
        cases
    }

    /// Simulates a session and judges what the doors answer.
    fn judge(&self, case: &DoorCase<'_>) -> Result<JudgedCase, Failure> {
        let folder = temporary()?;
        let session = folder.path().join("session");
        let seed = self.benches.seed;
        let simulated = self.simulate(case.bench, case.effect, case.judge, seed, &session);
        let effect = case.effect.unwrap_or_default();
        let named = name(effect);
        let row = |session: String, table: String, differs| JudgedCase {
            judge: case.judge,
            bench: case.bench.name.clone(),
            effect: effect.to_owned(),
            session,
            table,
            differs,
        };
        let wrong = |what: &str| vec![what.to_owned()];
        if let Err(failure) = simulated {
            let (named, why) = (named.to_owned(), code(&failure));
            return Ok(row(named, why, wrong("not simulated")));
        }
        if case.judge == DoorJudge::Pair {
            let [session, table] = self.by_both_doors(folder.path())?;
            let differs = differences(&session, &table);
            return Ok(row(session.words(), table.words(), differs));
        }
        let answer = self.answer(&session, None);
        let differs = if is_named(&answer, named) {
            Vec::new()
        } else {
            wrong("not named")
        };
        Ok(row(named.to_owned(), answer.words(), differs))
    }

    /// What both doors answer to a session with nothing missing on the first bench, and the true factors.
    fn with_nothing_missing(&self, seed: u64) -> Result<([DoorAnswer; 2], TrueFactors), Failure> {
        let folder = temporary()?;
        let session = folder.path().join("session");
        let bench = &self.benches.bench[0];
        let simulated = self.simulate(bench, None, DoorJudge::Pair, seed, &session);
        let factors = &simulated.unwrap_or_default()["data"]["factors"];
        let mut truth = Vec::new();
        for class in ["beam", "link"] {
            for (place, constant) in ["A", "Iy", "Iz", "J"].into_iter().enumerate() {
                let factor = factors[class][place].as_f64();
                truth.extend(factor.map(|factor| (format!("{class}.{constant}"), factor)));
            }
        }
        Ok((self.by_both_doors(folder.path())?, truth))
    }

    /// The answers to a session of a folder and to the same readings as a table of vectors, which is written beside it.
    fn by_both_doors(&self, folder: &Path) -> Result<[DoorAnswer; 2], Failure> {
        let [session, table] = ["session", "table"].map(|name| folder.join(name));
        let readings = vector_table(&read(&session.join("readings.csv"))?)?;
        write_again(&table.join("readings.csv"), readings.as_bytes())?;
        for name in ["session.toml", "robot.toml"] {
            let from = session.join(name);
            fs::copy(&from, table.join(name)).map_err(ReadError::of(&from))?;
        }
        Ok([self.answer(&session, None), self.answer(&table, None)])
    }

    /// What `fit` and `diagnose` answer.
    ///
    /// # Arguments
    /// - `stated`: an effect that is stated and not searched, and nothing else either; none for the usual search.
    pub(super) fn answer(&self, data: &Path, stated: Option<&str>) -> DoorAnswer {
        let stated = stated.map(|effect| ["--effect", effect]);
        let all = Law::names().join(",");
        let unsearched = stated.map(|_| ["--without", &all]);
        let [stated, unsearched] = [stated, unsearched].map(|words| words.into_iter().flatten());
        let fit: Vec<&str> = ["fit"].into_iter().chain(stated.clone()).collect();
        let diagnose: Vec<&str> = (["diagnose", "--no-figures"].into_iter())
            .chain(stated)
            .chain(unsearched)
            .chain(["--out"])
            .collect();
        let diagnosis = self.run(&diagnose, &[&data.join("diagnosis"), data]);
        DoorAnswer::read(&diagnosis, &self.run(&fit, &[data]), self.largest_n)
    }

    pub(super) fn simulate(
        &self,
        bench: &DoorBench,
        effect: Option<&str>,
        judge: DoorJudge,
        seed: u64,
        out: &Path,
    ) -> Result<Value, Value> {
        let seed = seed.to_string();
        let mut words = vec!["simulate", "--robot", &bench.robot, "--seed", &seed];
        if !judge.is_of_single_loads() {
            words.extend(["--procedure", &self.benches.procedure]);
        }
        words.extend(judge.simulation());
        for (option, value) in [
            ("--mechanism", bench.mechanism.as_deref()),
            ("--effect", effect),
        ] {
            words.extend(value.into_iter().flat_map(|value| [option, value]));
        }
        self.run(&words, &[out])
    }

    /// The object that a command prints, or that of its failure.
    fn run(&self, words: &[&str], paths: &[&Path]) -> Result<Value, Value> {
        let words = ["--no-config"].iter().chain(words).map(OsString::from);
        let words = words.chain(paths.iter().map(OsString::from));
        let Some(program) = self.program else {
            return json_of(words);
        };
        let printed = Command::new(program).args(words).arg("--json").output();
        let printed = printed
            .map_err(|error| error.to_string())
            .and_then(|printed| {
                serde_json::from_slice::<Value>(&printed.stdout).map_err(|error| error.to_string())
            });
        match printed {
            Ok(object) if object["ok"] == true => Ok(object),
            Ok(failure) => Err(failure),
            Err(error) => Err(json!({ "error": { "code": error } })),
        }
    }
}

/// Factors by name, with their true values.
pub(super) type TrueFactors = Vec<(String, f64)>;

/// Law and place of an effect.
fn name(effect: &str) -> &str {
    effect.split(':').next().unwrap_or_default()
}

fn code(failure: &Value) -> String {
    failure["error"]["code"]
        .as_str()
        .unwrap_or_default()
        .to_owned()
}

pub(super) fn temporary() -> Result<TempDir, CliError> {
    tempfile::tempdir().map_err(|source| CliError::Write {
        path: std::env::temp_dir(),
        source,
    })
}
