//! The files that the program writes: complete, readable, and the same bytes for the same seed.

use super::{Desk, Ran};

/// An SVG that parses, with something drawn in it.
fn assert_svg(desk: &Desk, name: &str) {
    let options = resvg::usvg::Options::default();
    let tree = resvg::usvg::Tree::from_str(&desk.read(name), &options)
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(tree.root().has_children(), "{name} is empty");
}

fn assert_png(desk: &Desk, name: &str) {
    let bytes = std::fs::read(desk.path(name)).unwrap();
    assert!(
        bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.len() > 1000,
        "{name}"
    );
}

const FIGURES: [&str; 7] = [
    "load-displacement",
    "stiffness",
    "factors",
    "correlation",
    "residuals",
    "workspace",
    "robot",
];

#[test]
fn the_demonstration_writes_all_it_lists() {
    let desk = Desk::new();
    let data = desk.data("demo --out here/demo");
    let files: Vec<&str> = data["files"]
        .as_array()
        .unwrap()
        .iter()
        .map(|file| file.as_str().unwrap())
        .collect();
    for file in &files {
        assert!(desk.path(file).is_file(), "{file}");
    }
    for figure in FIGURES {
        let name = format!("here/demo/figures/{figure}");
        assert!(files.contains(&format!("{name}.svg").as_str()), "{name}");
        assert_svg(&desk, &format!("{name}.svg"));
        assert_png(&desk, &format!("{name}.png"));
    }
    assert!(desk.read("here/demo/tables.txt").contains("95 % interval"));
    // The session it leaves can be used as it stands, and again.
    let fit = desk.data("fit here/demo/session --train P1,P3");
    assert_eq!(fit["factors"], data["fit"]["factors"]);
    desk.run("demo --out here/demo").succeeds();
}

#[test]
fn every_figure_can_be_drawn_alone() {
    let desk = Desk::with_session();
    for figure in FIGURES {
        let data = if ["workspace", "robot"].contains(&figure) {
            "--poses 500"
        } else {
            "--data session"
        };
        desk.run(&format!("plot {figure} {data} --out figures/{figure}"))
            .succeeds();
        assert_svg(&desk, &format!("figures/{figure}.svg"));
        assert_png(&desk, &format!("figures/{figure}.png"));
    }
    desk.run("plot robot --out only.svg").succeeds();
    assert!(desk.path("only.svg").is_file() && !desk.path("only.png").exists());
    desk.run("plot load-displacement --data session --data session --out overlay.svg")
        .succeeds();
    desk.run("compare session session --figure compared.svg")
        .succeeds();
    desk.run("robot workspace --poses 100 --figure workspace.svg")
        .succeeds();
    desk.run("fit session --figures fit --save-factors fit/factors.toml")
        .succeeds();
    for name in [
        "overlay.svg",
        "compared.svg",
        "workspace.svg",
        "fit/stiffness.svg",
        "fit/factors.svg",
        "fit/correlation.svg",
    ] {
        assert_svg(&desk, name);
    }
}

#[test]
fn saved_factors_are_read_again() {
    let desk = Desk::with_session();
    let fit = desk.data("fit session --save-factors fitted.toml");
    let from_file = desk.data("significance --pose P1 --factors fitted.toml");
    for (place, name) in ["A", "Iy", "Iz", "J"].iter().enumerate() {
        assert_eq!(
            from_file["factors"]["beam"][place],
            fit["factors"]["beam"][name]["value"]
        );
    }
    // A session may name such a file beside it.
    desk.write("session/mine.toml", &desk.read("fitted.toml"));
    let header = desk.read("session/session.toml").replacen(
        "factors = \"m_fsd\"",
        "factors = \"mine.toml\"",
        1,
    );
    desk.write("session/session.toml", &header);
    let again = desk.data("fit session");
    assert_eq!(
        again["factors"]["beam"]["Iy"]["start"],
        fit["factors"]["beam"]["Iy"]["value"]
    );
}

#[test]
fn a_simulated_session_is_complete_and_its_truth_stands_apart() {
    let desk = Desk::new();
    for (plan, readings) in [("paper", 480), ("sweeps", 480), ("load-unload", 900)] {
        assert_eq!(
            desk.data(&format!("simulate {plan} --plan {plan}"))["readings"],
            readings
        );
        for file in [
            "readings.csv",
            "session.toml",
            "robot.toml",
            "simulation.toml",
        ] {
            assert!(desk.path(plan).join(file).is_file());
        }
        assert!(
            !desk
                .read(&format!("{plan}/session.toml"))
                .contains("reading_sd")
        );
        assert!(
            desk.read(&format!("{plan}/simulation.toml"))
                .contains("reading_sd_um = 3")
        );
        desk.run(&format!("fit {plan}")).succeeds();
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let desk = Desk::new();
    for (name, seed) in [("a", 7), ("b", 7), ("c", 8)] {
        desk.run(&format!("simulate {name} --seed {seed}"))
            .succeeds();
    }
    for file in [
        "readings.csv",
        "session.toml",
        "robot.toml",
        "simulation.toml",
    ] {
        assert_eq!(
            desk.read(&format!("a/{file}")),
            desk.read(&format!("b/{file}")),
            "{file}"
        );
    }
    assert_ne!(desk.read("a/readings.csv"), desk.read("c/readings.csv"));
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let desk = Desk::with_session();
    for arguments in [
        "fit session --train P1,P3 --bootstrap 200 --seed 1 --json",
        "robot workspace --poses 2000 --seed 3 --json",
        "paper --json",
    ] {
        let [one, two] = ["1", "2"].map(|threads| {
            Ran::of(desk.command(arguments).env("RAYON_NUM_THREADS", threads))
                .succeeds()
                .stdout
        });
        assert!(!one.is_empty());
        assert!(one == two, "{arguments}");
    }
    let interval = |seed: u32| {
        desk.data(&format!("fit session --bootstrap 200 --seed {seed}"))["factors"]["beam"]["Iy"]["ci95_bootstrap"].clone()
    };
    assert!(interval(1).is_array());
    assert_ne!(interval(1), interval(2));
}
