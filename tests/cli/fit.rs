//! What `fit` prints of a fit beside its values.

use serde_json::Value;

use super::{assert_output_contains, desk, desk_with_session, unwrapped};
use crate::support::{Contains, Json};

#[test]
fn standard_errors_covariance_and_correlations_are_given_with_every_fit() {
    let desk = desk_with_session();
    let data = desk.data("fit session");
    let found = &data["correlation"];
    let names = found["names"].list();
    assert_eq!(names.len(), 4);
    for (place, name) in names.iter().enumerate() {
        let own = data["parameters"].named(name.word());
        let [se, value] = ["se", "value"].map(|key| own[key].number());
        // The variance of ln a is that of a over its square.
        let variance = found["covariance"][place][place].number();
        let expected = (se / value).powi(2);
        assert!((variance / expected - 1.0).abs() < 1e-9, "{name}");
    }
    let page = desk.run("fit session").succeeds().stdout;
    let rho = found["matrix"][1][0].number();
    let row = page
        .lines()
        .find(|line| line.starts_with("| 2 beam.Iy"))
        .unwrap();
    row.must_contain(&[&format!("{rho:+.2}")]);
    page.must_contain(&["| standard error |"]);
}

#[test]
fn an_interval_of_the_covariance_that_the_likelihood_does_not_support_is_warned_of() {
    let desk = desk_with_session();
    let disagreements = |line: &str| {
        let page = desk.run(line).succeeds().stdout;
        let notes = page
            .lines()
            .filter(|line| line.contains("the covariance gives"));
        notes.map(str::to_owned).collect::<Vec<_>>()
    };
    // Readings of many repeats: intervals of a few percent, within which the likelihood is a parabola.
    assert_eq!(disagreements("fit session"), Vec::<String>::new());
    // Twelve values that scatter by 20 %: the interval of beam.A reaches four times as far up as down.
    let found = disagreements("fit paper-experiment");
    let of_beam = found.iter().find(|note| note.starts_with("note: beam.A:"));
    assert!(
        of_beam.is_some_and(|note| note.contains("the profile likelihood")),
        "{found:?}"
    );
}

#[test]
fn a_rejected_reading_is_left_out_and_listed_with_its_reason() {
    let desk = desk_with_session();
    let readings = desk.read("session/readings.csv");
    let mut lines: Vec<String> = readings.lines().map(str::to_owned).collect();
    let marked = |line: &str, status: &str, flag: &str| {
        let (before, after) = line.split_once(",accepted,,").unwrap();
        format!("{before},{status},{flag},{after}")
    };
    let number = |line: &str| line.split(',').nth(1).unwrap().parse::<u64>().unwrap();
    let (rejected, flagged) = (number(&lines[3]), number(&lines[20]));
    lines[3] = marked(&lines[3], "rejected", "operator: bumped the table");
    lines[20] = marked(&lines[20], "accepted", "drift: 4 um");
    desk.write("marked.csv", &lines.join("\n"));
    lines.remove(3);
    desk.write("without.csv", &lines.join("\n"));

    let fit = |file: &str| desk.data(&format!("fit {file} --robot session/robot.toml"));
    let (with, without) = (fit("marked.csv"), fit("without.csv"));
    assert_eq!(with["parameters"], without["parameters"]);
    let marks = with["marked"].list();
    assert_eq!(marks.len(), 2);
    assert_eq!(marks[0]["status"], "rejected");
    assert_eq!(marks[0]["flag"], "operator: bumped the table");
    assert_eq!(marks[0]["readings"][0], rejected);
    let page = desk
        .run("fit marked.csv --robot session/robot.toml")
        .succeeds();
    for line in [
        format!("Left out, rejected (operator: bumped the table): 1 reading, number {rejected}."),
        format!("Used despite a flag (drift: 4 um): 1 reading, number {flagged}."),
    ] {
        assert!(page.stdout.contains(&line), "{}", page.stdout);
    }
}

#[test]
fn refits_in_a_pipe_have_a_line_a_tenth_unless_progress_is_off() {
    let desk = desk_with_session();
    let line = "fit session --bootstrap 40 --seed 1";
    let lines = |options: &str| {
        let ran = desk.run(&format!("{line} {options}")).succeeds();
        let own = ran
            .stderr
            .lines()
            .filter(|line| line.starts_with("refits: "));
        own.map(str::to_owned).collect::<Vec<_>>()
    };
    let found = lines("");
    assert_eq!(found.len(), 10);
    assert_eq!(found[9], "refits: 40 of 40 done");
    assert_eq!(lines("--progress text"), found);
    assert!(lines("--progress none").is_empty() && lines("--json").is_empty());
    assert!(lines("--quiet").is_empty());
    assert!(lines("--progress bar").is_empty());
    let map = desk.run("robot map --samples 50").succeeds();
    map.stderr
        .must_contain(&["maps of mechanisms: 6 of 6 done"]);
}

#[test]
fn a_parameter_on_its_bound_has_no_uncertainty_and_no_load_case_is_planned_for_it() {
    let desk = desk();
    desk.run("simulate seven --seed 7").succeeds();
    let line = "fit seven --parameter beam.Iy=0.003..0.00486";
    let data = desk.data(line);
    let bound = data["parameters"].named("beam.Iy");
    assert_eq!(bound["status"], "at_bound");
    let planned = data["next"].as_array().into_iter().flatten();
    let mut errors = planned.flat_map(|one| one["errors"].list());
    assert!(errors.all(|one| one["name"] != "beam.Iy"));
    let words = unwrapped(&desk.run(line).stdout);
    words.must_contain(&["unless you widen the bound"]);
}

#[test]
fn a_plan_starts_from_the_standard_error_of_the_table() {
    let desk = desk();
    desk.run("simulate seven --seed 7").succeeds();
    let data = desk.data("fit seven --train P1,P3");
    let planned = &data["next"][0]["errors"][0];
    assert_eq!(planned["name"], "beam.J");
    let stated = data["parameters"].named("beam.J");
    let relative = stated["se"].number() / stated["value"].number();
    let now = planned["now"].number();
    assert!((now / relative - 1.0).abs() < 1e-3, "{now} {relative}");
}

#[test]
fn refits_on_a_bound_are_counted_and_those_that_stand_still_give_no_interval() {
    let desk = desk_with_session();
    // Of these cells one or two alone leave parameters undetermined.
    let line = "fit session --train P1,P3 --bootstrap 100 --bootstrap-over cells --seed 3";
    let fit = desk.run(&format!("{line} --json")).succeeds().json();
    let warnings = fit["warnings"].to_string();
    warnings.must_contain(&["refits of the bootstrap ended on its bound"]);
    for one in fit["data"]["parameters"].list() {
        let interval = &one["ci95_bootstrap"];
        assert!(
            interval.is_null() || interval[0].as_f64() < interval[1].as_f64(),
            "{one}"
        );
    }
    let page = desk.run(line).succeeds().stdout;
    page.must_contain(&["Bootstrap: 100 replicates, cells resampled (seed 3)"]);
}

#[test]
fn derived_quantities_have_propagated_intervals() {
    let desk = desk_with_session();
    let line = "fit session --derive ratio=beam.Iy/beam.Iz";
    let data = desk.data(line);
    let parameter = |name: &str| {
        let own = data["parameters"].named(name);
        ["value", "se"].map(|key| own[key].number())
    };
    let ([y, u_y], [z, u_z]) = (parameter("beam.Iy"), parameter("beam.Iz"));
    let rho = data["correlation"]["matrix"][1][2].number();
    let (a, b) = (u_y / y, u_z / z);
    let expected = y / z * (a * a + b * b - 2.0 * rho * a * b).sqrt();
    let derived = &data["derived"][0];
    assert_eq!(derived["value"].as_f64(), Some(y / z));
    assert!((derived["se"].number() / expected - 1.0).abs() < 1e-9);
    let page = desk.run(line).succeeds().stdout;
    page.must_contain(&["| ratio   | beam.Iy/beam.Iz |"]);
    let wrong = desk.run("fit session --derive ratio=beam.Iy/beam.Ix --json");
    assert_output_contains(
        &wrong.json()["error"],
        &["`beam.Ix` is not a parameter of the fit", "did you mean"],
    );

    // The stiffness of a spring is the inverse of its compliance.
    let fanuc = super::load_cases::fanuc();
    let data = fanuc.data("fit cases.csv --robot fanuc.toml --derive k1=1/joint.J1");
    let spring = data["parameters"].named("joint.J1");
    let [c, u, k] = ["value", "se", "stiffness"].map(|key| spring[key].number());
    let [derived, se] = ["value", "se"].map(|key| data["derived"][0][key].number());
    assert!((derived / k - 1.0).abs() < 1e-12 && (se / (u / (c * c)) - 1.0).abs() < 1e-9);
}

#[test]
fn models_of_the_same_cells_are_ranked_and_others_refused() {
    let desk = desk_with_session();
    let keep = |name: &str, line: &str| {
        let found = desk.run(&format!("{line} --json")).succeeds().stdout;
        desk.write(name, &found);
    };
    keep("simpler.json", "fit session --parameter beam.J=fixed");
    keep("train.json", "fit session --train P1,P3");
    desk.run("simulate other --seed 9").succeeds();
    keep("other.json", "fit other");

    let line = "fit session --against simpler.json";
    let data = desk.data(line);
    let models = data["comparison"]["models"].list();
    assert_eq!(models[0]["free"], 4);
    assert_eq!(models[1]["free"], 3);
    // The true factor is one that the fit began at: nothing is gained by freeing it, or little.
    for model in models {
        let number = |key: &str| model[key].number();
        let (k, n) = (number("free"), 12.0);
        let expected = number("squares") + 2.0 * k + 2.0 * k * (k + 1.0) / (n - k - 1.0);
        assert!((number("aicc") - expected).abs() < 1e-9);
    }
    let test = &data["comparison"]["nested"][0];
    assert_eq!(test["simpler"], "simpler.json");
    assert_eq!(test["richer"], "this fit");
    assert_eq!(test["dof"], serde_json::json!([1, 8]));
    let page = desk.run(line).succeeds().stdout;
    page.must_contain(&["simpler.json is contained in this fit: F(1, 8) = "]);
    for (file, reason) in [("other.json", "other data"), ("train.json", "other poses")] {
        let refused = desk.run(&format!("fit session --against {file} --json"));
        assert_ne!(refused.code, 0);
        assert_output_contains(&refused.json()["error"], &[reason, "cannot be ranked"]);
    }
}

#[test]
fn a_fit_of_stiffnesses_and_a_diagnosis_of_readings_have_one_noise() {
    let desk = desk();
    let sessions = [
        "--procedure paper --seed 3",
        "--procedure load-unload --mechanism A --seed 3",
        "--procedure load-unload --mechanism A --displacement-axes x,y,z --seed 3",
        "--procedure iso-9283-static-compliance --directions x,0,0.6,0.8 --mechanism A --seed 4",
    ];
    for (number, simulated) in sessions.into_iter().enumerate() {
        let session = format!("s{number}");
        desk.run(&format!("simulate {session} {simulated}"))
            .succeeds();
        let fit = desk.data(&format!("fit {session}"));
        let diagnosis = desk.data(&format!("diagnose {session} --no-figures"));
        assert_eq!(diagnosis["verdict"], "nothing-missing", "{simulated}");
        let factors = diagnosis["factors"].list();
        assert!(!factors.is_empty(), "{simulated}");
        for factor in factors {
            let own = fit["parameters"].list().iter();
            let mut own = own.filter(|one| one["name"] == factor["name"]);
            let own = own.next().unwrap();
            let ends = |of: &Value| [0, 1].map(|end| of["ci95"][end].number());
            let value = |of: &Value| of["value"].number();
            let ([low, high], [lower, upper]) = (ends(&factor["after"]), ends(own));
            let off = (value(own) - value(&factor["after"])) / (high - low);
            assert!(off.abs() < 0.1, "{simulated}: {own} {factor}");
            let ratio = (upper - lower) / (high - low);
            assert!((0.9..1.1).contains(&ratio), "{simulated}: {own} {factor}");
        }
    }
}
