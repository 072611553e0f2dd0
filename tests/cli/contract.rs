//! The keys and units of JSON output that programs of others rely on, and some numbers.

use serde_json::Value;

use super::{desk, desk_with_session};
use crate::support::{Contains, Json};

/// A quantity: value and unit, and an uncertainty with coverage factor and degrees of freedom, or the words why there is none.
fn assert_quantity(quantity: &Value, unit: &str) {
    assert!(quantity["value"].is_number(), "{quantity}");
    assert_eq!(quantity["unit"], unit);
    let [u, expanded, k] = ["u", "U", "k"].map(|key| quantity[key].number());
    assert!((expanded - k * u).abs() <= 1e-12 * expanded, "{quantity}");
    assert!(quantity["dof"].is_number(), "{quantity}");
}

#[test]
fn stiffness() {
    let desk = desk_with_session();
    let data = desk.data("stiffness session");
    let cells = data["cells"].list();
    assert_eq!(cells.len(), 12);
    for cell in cells {
        assert!(cell["pose"].is_string() && cell["direction"].is_string());
        assert_eq!(cell["n_runs"], 5);
        assert_quantity(&cell["stiffness_paper"], "N/um");
        assert_quantity(&cell["stiffness_regression"], "N/um");
        assert!(cell["zero_offset_um"].is_number());
        let loads = cell["loads"].list();
        assert_eq!(loads.len(), 8);
        for (load, target) in loads.iter().zip([0, -10, -20, -30, -40, -50, -60, -70]) {
            assert_eq!(load["target_N"], f64::from(target));
            assert_eq!(load["n"], 5);
            assert!(load["mean_um"].is_number() && load["sd_um"].is_number());
        }
    }
}

#[test]
fn fit() {
    let desk = desk_with_session();
    let data = desk
        .data("fit session --train P1,P3 --parameter beam.J=fixed --parameter link.A=tied:beam.A");
    let factors = &data["factors"];
    for class in ["beam", "link"] {
        for name in ["A", "Iy", "Iz", "J"] {
            let factor = &factors[class][name];
            assert!(factor["value"].number() > 0.0);
            let status = factor["status"].word();
            assert!(
                ["free", "fixed", "tied", "at_bound", "not_identified"].contains(&status),
                "{status}"
            );
            assert_eq!(factor["ci95"].is_array(), status == "free", "{factor}");
        }
    }
    assert_eq!(factors["beam"]["J"]["status"], "fixed");
    assert_eq!(factors["link"]["A"]["status"], "tied");
    assert_eq!(factors["beam"]["Iy"]["status"], "free");
    let names = data["correlation"]["names"].list();
    assert_eq!(data["correlation"]["matrix"].list().len(), names.len());
    let mut worst: f64 = 0.0;
    for cell in data["cells"].list() {
        let held_out = ["P2", "P4"].contains(&cell["pose"].word());
        assert_eq!(cell["held_out"], held_out);
        assert_eq!(cell["measured"]["unit"], "N/um");
        let ratio = cell["ratio_percent"].number();
        let [measured, predicted] =
            ["measured", "predicted"].map(|key| cell[key]["value"].number());
        assert!((ratio - 100.0 * predicted / measured).abs() < 1e-9);
        if held_out {
            worst = worst.max((ratio - 100.0).abs());
        }
    }
    assert!((data["max_error_percent"].number() - worst).abs() < 1e-9);
}

#[test]
fn compliance_is_symmetric_and_its_nodes_are_named() {
    let desk = desk();
    let data = desk.data("robot compliance hp-robot --mechanism F --pose P1 --factors m_fsd");
    let row = |i: usize| -> Vec<f64> {
        data["compliance"][i]
            .list()
            .iter()
            .map(Json::number)
            .collect()
    };
    let c: Vec<Vec<f64>> = (0..6).map(row).collect();
    for i in 0..6 {
        assert!(c[i][i] > 0.0);
        for j in 0..6 {
            // Forces and moments have different units: reciprocity is decided by the diagonal.
            assert!(
                (c[i][j] - c[j][i]).abs() < 1e-8 * (c[i][i] * c[j][j]).sqrt(),
                "{i} {j}"
            );
        }
    }
    assert_eq!(
        data["rows"],
        serde_json::json!(["ux", "uy", "uz", "rx", "ry", "rz"])
    );
    assert_eq!(
        data["columns"],
        serde_json::json!(["Fx", "Fy", "Fz", "Mx", "My", "Mz"])
    );
    // The end node in P1, where the paper states z = 1.638 m and y = 1.229 m.
    let end: Vec<f64> = data["nodes"]["F8"]
        .list()
        .iter()
        .map(Json::number)
        .collect();
    assert!(
        end[0].abs() < 1e-9 && (end[1] - 1.229).abs() < 0.003 && (end[2] - 1.638).abs() < 0.003,
        "{end:?}"
    );
}

#[test]
fn compliance_follows_every_choice() {
    let desk = desk();
    let lateral = |options: &str| {
        desk.data(&format!("robot compliance --pose P1 {options}"))["compliance"][0][0].number()
    };
    let plain = lateral("");
    for option in [
        "--set theta2=390",
        "--set theta2=390 theta3=330",
        "--mechanism A",
        "--factors unit",
        "--pinned",
        "--timoshenko",
        "--robot serial-arm",
    ] {
        let other = lateral(option);
        assert!(
            (other / plain - 1.0).abs() > 1e-6,
            "{option} changes nothing: {other}"
        );
    }
    // Shear makes a beam softer, and a turning joint a robot.
    assert!(lateral("--timoshenko") > plain && lateral("--pinned") > plain);
    // The pose is given by its angles as well as by its name.
    let by_angles =
        desk.data("robot compliance --set theta1=360 theta2=397.322 theta3=341.757 theta4=50");
    assert!((by_angles["compliance"][0][0].number() / plain - 1.0).abs() < 1e-9);
}

#[test]
fn the_truth_behind_a_simulation_lies_in_the_intervals() {
    let desk = desk();
    desk.run("simulate exact --noise-free --true-factor beam.Iy=0.006")
        .succeeds();
    let data = desk.data("fit exact");
    let true_beam = [0.002_997, 0.006, 0.964_219, 1.0];
    for (name, truth) in ["A", "Iy", "Iz", "J"].into_iter().zip(true_beam) {
        let factor = &data["factors"]["beam"][name];
        let interval: Vec<f64> = factor["ci95"].list().iter().map(Json::number).collect();
        assert!(
            interval[0] < truth && truth < interval[1],
            "{name}: {factor}"
        );
        assert!(interval[1] / interval[0] < 1.01, "{name}: {factor}");
    }
    assert_eq!(data["termination"], "converged");
}

#[test]
fn springs_are_parameters_of_fit_factor_file_map_significance_and_diagnosis() {
    let desk = desk();
    let spring = "joint-compliance@S2:c=8urad/(N*m)";
    desk.run(&format!(
        "simulate arm --robot serial-arm --seed 3 --effect {spring}"
    ))
    .succeeds();
    let fixed = "--parameter beam.A,beam.Iy,beam.Iz,beam.J=fixed";
    let fit =
        format!("fit arm {fixed} --parameter joint.S2,base.rx=free --parameter joint.S2=0..1e-4");
    let printed = desk.run(&format!("{fit} --save-factors springs.toml --json"));
    let printed = printed.succeeds().stdout;
    desk.write("fit.json", &printed);
    let whole: serde_json::Value = serde_json::from_str(&printed).unwrap();
    let parameters = &whole["data"]["parameters"];
    assert_eq!(parameters.list().len(), 10);
    let of = |name: &str| parameters.named(name);
    let joint = of("joint.S2");
    assert_eq!(joint["unit"], "rad/(N*m)");
    assert_eq!(joint["status"], "free");
    let upper = joint["bounds"][1].number();
    assert!((upper / 1e-4 - 1.0).abs() < 1e-12, "{upper}");
    let ends = [0, 1].map(|end| joint["ci95"][end].number());
    assert!(
        ends[0] < 8e-6 && 8e-6 < ends[1] && ends[1] < 8.5e-6,
        "{joint}"
    );
    assert!(joint["se"].number() < 2e-7);
    assert_eq!(of("beam.Iy")["status"], "fixed");
    assert_eq!(of("beam.Iy")["bounds"], serde_json::Value::Null);
    // The factor file carries the spring to every command.
    let compliance = |options: &str| {
        let data = desk.data(&format!("robot compliance serial-arm --pose P1 {options}"));
        data["compliance"][1][1].number()
    };
    let by_file = compliance("--factors springs.toml");
    let c = joint["value"].number();
    let rocks = of("base.rx")["value"].number();
    let effects = format!(
        "--effect joint-compliance@S2:c={c:e}rad/(N*m) --effect base-compliance@x:c={rocks:e}rad/(N*m)"
    );
    let by_effect = compliance(if rocks > 0.0 {
        &effects
    } else {
        effects.split(" --effect base").next().unwrap()
    });
    assert!(
        (by_file / by_effect - 1.0).abs() < 1e-9,
        "{by_file} {by_effect}"
    );
    let map = desk.data("robot map serial-arm --fit fit.json --samples 200 --no-principal");
    map.to_string().must_contain(&["joint-compliance"]);
    let ranked = desk.data("robot significance serial-arm --parameters joint.S2,section.tube1.Iy");
    assert_eq!(ranked["further"].list().len(), 2);
    assert!(ranked["further"][0]["adds_one_percent_at"]["y"].number() > 0.0);
    let known = desk.data("diagnose arm --parameter joint.S2=free --no-figures --out known");
    assert_eq!(known["verdict"], "nothing-missing");
    let factors = known["factors"].list();
    assert_eq!(factors.len(), 5, "{factors:?}");
    desk.read("known/model.toml")
        .must_contain(&["joints_rad_per_Nm"]);
}
