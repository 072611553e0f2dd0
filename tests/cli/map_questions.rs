//! `stiffbench robot map` asked for figures, loads, own weight and designs.

use super::{assert_output_contains, desk, misuse};
use crate::support::{Contains, Json};

#[test]
fn a_load_moves_the_end_and_a_limit_bounds_the_load() {
    let desk = desk();
    let arguments = "robot map --mechanisms F --samples 300 --load 0,-50,0 --limit 0.5";
    let text = desk.run(arguments).succeeds().stdout;
    text.must_contain(&[
        "F = (0, -50, 0) N",
        "displacement, µm",
        "rotation, µrad",
        "largest load, N",
        "0.5 mm",
    ]);
    let load = &desk.data(arguments)["load"];
    assert_eq!(load["force_N"][1], -50.0);
    let number = |key: &str, of: &str| load["mechanisms"][0][key][of].number();
    // What moves the end furthest by 50 N bears the least load.
    let product = number("displacement", "greatest") * number("largest_load", "least");
    assert!((product / (50.0 * 500.0) - 1.0).abs() < 1e-9, "{product}");
    assert!(number("displacement_y", "greatest") < 0.0);
    // Stiffness and load say the same of the direction of the load.
    let map = desk.data("robot map --mechanisms F --samples 300 --directions y --no-principal");
    let least =
        map["mechanisms"][0]["stiffness"][0]["smallest"]["sampled"]["value"]["value"].number();
    assert!((number("displacement_y", "least") / (-50.0 / least) - 1.0).abs() < 1e-9);
    desk.run(&format!("{arguments} --out out --figures out/figures"))
        .succeeds();
    assert!(desk.path("out/figures/load-F.png").is_file() && desk.path("out/map.json").is_file());
}

#[test]
fn sag_needs_masses_and_their_absence_is_explained() {
    let desk = desk();
    let error = misuse(&desk, "robot map --samples 10 --sag");
    assert_output_contains(&error, &["no masses", "mass_per_m", "density", "[masses]"]);
    let page = include_str!("../../docs/robot-file-1.md");
    let start = page.find("```toml\n").unwrap() + "```toml\n".len();
    let length = page[start..].find("```").unwrap();
    desk.write("arm.toml", &page[start..start + length]);
    let sag = &desk.data("robot map arm.toml --samples 50 --sag")["sag"];
    let mechanism = &sag["mechanisms"][1];
    assert_eq!(mechanism["mechanism"], "levelled");
    assert!(mechanism["sections_without_mass"].list().is_empty());
    // Steel of 7850 kg/m3: post 0.5 + 0.15 m, tube 0.6 + 0.2 + 0.15 m; rod 0.6 m of 2.9 kg/m; 4 kg and 11 kg.
    let steel = 7850.0 * (3.0e-3 * 0.65 + 1.2e-3 * 0.95);
    let mass = mechanism["mass_kg"].number();
    assert!((mass - steel - 2.9 * 0.6 - 15.0).abs() < 1e-9, "{mass}");
    assert!(mechanism["displacement_y"]["greatest"].number() < 0.0);
    let text = desk
        .run("robot map arm.toml --samples 50 --sag")
        .succeeds()
        .stdout;
    text.must_contain(&["mechanism levelled: 41.0", "own weight"]);
}
