//! What `import` prints of tables that people have: equal runs, one flaw in many rows.

use std::fmt::Write;

use super::desk;

#[test]
fn equal_runs_have_no_endless_digits() {
    let desk = desk();
    for (name, loads) in [("few", 4), ("many", 8)] {
        let mut text = "force [N],travel [mm],run\n".to_owned();
        for run in 1..=3 {
            for load in 0..loads {
                let travel = 201 * load + i32::from(load % 2 == 1);
                writeln!(text, "{}.1,0.{travel:05},{run}", 10 * load).unwrap();
            }
        }
        desk.write(&format!("{name}.csv"), &text);
        let ran = desk
            .run(&format!("import {name}.csv --out {name} --direction y"))
            .succeeds();
        let row = ran.stdout.lines().find(|line| line.contains("| P1 "));
        let longest = row.unwrap().split('|').map(|cell| cell.trim().len()).max();
        assert!(longest.unwrap() < 12, "{}", ran.stdout);
        // Eight different readings show the step of the display, four do not.
        assert_eq!(
            ran.stdout.contains("the 3 runs do not differ"),
            name == "few",
            "{}",
            ran.stdout
        );
    }
}

#[test]
fn one_flaw_in_many_rows_is_one_line() {
    let desk = desk();
    let mut text = "force [N],travel [mm],run\n".to_owned();
    for run in 1..=5 {
        for load in 0..40 {
            let turned = if load % 4 == 1 { "-" } else { "" };
            let noise = (7 * load + 3 * run) % 5;
            writeln!(
                text,
                "{},{turned}0.{:05},{run}",
                2 * load,
                100 * load + noise
            )
            .unwrap();
        }
    }
    desk.write("a.csv", &text);
    let ran = desk.run("import a.csv --out s --direction y").succeeds();
    let of = |words: &str| {
        ran.stdout
            .lines()
            .filter(|line| line.contains(words))
            .count()
    };
    assert_eq!(
        of("opposite signs, F/δ has no meaning"),
        1,
        "{}",
        ran.stdout
    );
    let flag = "flag, P1 y: 10 of displacement-sign, first: at 2 N";
    assert!(ran.stdout.contains(flag), "{}", ran.stdout);
}
