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
