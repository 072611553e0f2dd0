//! The paper's Tables I and III to VI: what is computed again equals the print as far as it should, and every other cell has a reason.

use stiffbench::report::{PaperCell, PaperReport, paper_report};
use stiffbench::robot::Robot;
use stiffbench::shipped::shipped_robot;

fn report(robot: &str) -> PaperReport {
    paper_report(&Robot::parse(&shipped_robot(robot).unwrap()).unwrap()).unwrap()
}

fn of_table<'a>(report: &'a PaperReport, table: &str) -> Vec<&'a PaperCell> {
    report
        .cells
        .iter()
        .filter(|cell| cell.table == table)
        .collect()
}

#[test]
fn every_printed_cell_is_there_and_has_a_number_or_a_reason() {
    let report = report("hp-robot");
    let counts = ["I", "III", "IV", "V", "VI"].map(|table| of_table(&report, table).len());
    // 7 chains × 6; 15 displacements and 12 percentages; 3 directions × 3 rows × 8; the same × 4 poses × 2 quantities; 3 rows × 12.
    assert_eq!(counts, [42, 27, 72, 72, 36]);
    for cell in &report.cells {
        let explained = cell.reproduced || cell.reason.is_some();
        assert!(explained, "{cell:?}");
    }
}

#[test]
fn table_i_is_equal() {
    for cell in of_table(&report("hp-robot"), "I") {
        assert_eq!(cell.ours, Some(cell.paper), "{cell:?}");
    }
}

#[test]
fn table_iii_agrees_where_bending_rules() {
    let report = report("hp-robot");
    let cells = of_table(&report, "III");
    let cell = |row: &str, place: &str| {
        cells
            .iter()
            .find(|c| c.row.contains(row) && c.place == place)
            .unwrap()
            .ours
            .unwrap()
    };
    // Iy rules the vertical direction and Iz the lateral one, as in the print (1.64 % and 3.47 % left); the reconstruction's figures are
    // those of data/robots/README.md.
    assert!((cell("only a_Iy", "vertical P1") - 2.48).abs() < 0.005);
    assert!((cell("only a_Iz", "lateral P1") - 5.58).abs() < 0.005);
    // What is printed above 100 % is impossible: stiffening never raises the displacement under the load.
    for cell in &cells {
        if cell.quantity.ends_with('%') {
            assert!(cell.ours.unwrap() <= 100.0 + 1e-9, "{cell:?}");
            assert!(
                cell.paper <= 100.0 || cell.reason.as_deref().unwrap().starts_with("impossible"),
                "{cell:?}"
            );
        }
    }
}

#[test]
fn tables_iv_to_vi_lie_within_the_scatter_of_the_reconstruction() {
    // Section constants were fitted to all tables at once: 12 % (Table V) and 14.5 % (Table VI) root mean square, worst cell 29 %.
    let report = report("hp-robot");
    for (table, models, rms_bound) in [("V", "S-FSD", 0.121), ("VI", "M-FSD", 0.146)] {
        let ratios: Vec<f64> = of_table(&report, table)
            .into_iter()
            .filter(|cell| cell.row == models && cell.quantity.starts_with("stiffness"))
            .map(|cell| cell.ratio.unwrap())
            .collect();
        assert_eq!(ratios.len(), 12);
        let rms = (ratios.iter().map(|r| r.ln().powi(2)).sum::<f64>() / 12.0).sqrt();
        assert!(
            rms < rms_bound && rms > 0.9 * rms_bound,
            "table {table}: {rms}"
        );
        assert!(
            ratios.iter().all(|ratio| (0.77..1.30).contains(ratio)),
            "table {table}: {ratios:?}"
        );
    }
    for cell in of_table(&report, "IV")
        .into_iter()
        .filter(|cell| cell.ours.is_some())
    {
        assert!(cell.reproduced, "{cell:?}");
    }
}

#[test]
fn the_joint_fit_stands_beside_the_papers_errors() {
    let report = report("hp-robot");
    // Table VI prints 123.66 % and 78.33 % as the worst held-out ratios.
    let [first, second] = report.stated_worst_percent;
    assert!((first - 23.66).abs() < 1e-9 && (second - 21.67).abs() < 1e-9);
    let [joint, procedure] =
        [&report.joint, &report.procedure].map(|fit| fit.max_error_percent().unwrap());
    assert_eq!(report.joint.judged_cells().count(), 6);
    // The reconstruction fits worse than the paper says of its own model; that the joint fit beats the procedure is what is held here.
    assert!(joint < procedure, "{joint} {procedure}");
}

#[test]
fn the_variant_fits_the_direct_tables_better() {
    let worst = |robot: &str| {
        let report = report(robot);
        let cells = of_table(&report, "V");
        cells
            .iter()
            .filter(|c| c.row == "S-FSD")
            .map(|c| c.ratio.unwrap().ln().abs())
            .fold(0.0, f64::max)
    };
    assert!(worst("hp-robot-host-dominant") < worst("hp-robot"));
}
