//! What `fit` prints of a fit beside its values.

use super::{desk, desk_with_session};

#[test]
fn standard_errors_covariance_and_correlations_are_given_with_every_fit() {
    let desk = desk_with_session();
    let data = desk.data("fit session");
    let found = &data["correlation"];
    let names = found["names"].as_array().unwrap();
    assert_eq!(names.len(), 4);
    for (place, name) in names.iter().enumerate() {
        let parameters = data["parameters"].as_array().unwrap();
        let own = parameters.iter().find(|one| one["name"] == *name).unwrap();
        let [se, value] = ["se", "value"].map(|key| own[key].as_f64().unwrap());
        // The variance of ln a is that of a over its square.
        let variance = found["covariance"][place][place].as_f64().unwrap();
        let expected = (se / value).powi(2);
        assert!((variance / expected - 1.0).abs() < 1e-9, "{name}");
    }
    let page = desk.run("fit session").succeeds().stdout;
    let rho = found["matrix"][1][0].as_f64().unwrap();
    let row = page
        .lines()
        .find(|line| line.starts_with("| 2 beam.Iy"))
        .unwrap();
    assert!(row.contains(&format!("{rho:+.2}")), "{row}");
    assert!(page.contains("| standard error |"), "{page}");
}

#[test]
fn a_pair_that_the_data_can_hardly_distinguish_is_named() {
    let page = desk().run("fit paper-experiment --train P1,P3 --free link.Iz");
    let page = page.succeeds().stdout;
    assert!(
        page.contains("can hardly be distinguished: correlation -")
            && page.contains("one larger and the other smaller fits nearly as well"),
        "{page}"
    );
}

#[test]
fn a_parameter_that_no_cell_depends_on_did_not_move() {
    let desk = desk();
    // The vertical and radial stiffness of a planar mechanism do not depend on torsion.
    desk.write(
        "planar.csv",
        "pose,direction,stiffness_N_per_um\n\
         P1,y,0.0313\nP1,z,0.241\nP2,y,0.0297\nP2,z,0.429\nP3,y,0.0353\nP3,z,0.275\nP4,y,0.0377\nP4,z,0.296\n",
    );
    let line = "fit planar.csv --robot hp-robot --fix beam.A";
    let data = desk.data(line);
    let parameters = data["parameters"].as_array().unwrap();
    let torsion = parameters.iter().find(|one| one["name"] == "beam.J");
    let torsion = torsion.unwrap();
    assert_eq!(torsion["status"], "not_identified");
    assert_eq!(torsion["moved"], false);
    assert_eq!(torsion["value"], torsion["start"]);
    assert_eq!(
        (data["rank"].as_u64(), data["free"].as_u64()),
        (Some(2), Some(3))
    );
    let page = desk.run(line).succeeds().stdout;
    for part in [
        "not identified, did not move",
        "no measured cell depends on it; it keeps its start",
        "The cells determine 2 of 3 parameters (rank of the Jacobian); condition number infinite.",
    ] {
        assert!(page.contains(part), "{part}: {page}");
    }
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
