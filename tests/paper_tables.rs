//! The paper's Tables III to VI: what is computed again equals the print as far as it should. Table I is held where chains are counted.

use stiffbench::analysis::{
    Data, FitData, FitSettings, ModelChoice, OpenSettings, PaperFitSettings,
};
use stiffbench::fit::{CellModel, Scope, significance};
use stiffbench::report::DemoTableVi;
use stiffbench::report::paper::{Printed, direction, printed_rows};
use stiffbench::robot::Robot;
use stiffbench::shipped::shipped_robot;
use stiffbench::stiffness::Method;
use stiffbench::structure::Property;
use stiffbench::test_point::{Cell, Direction, PoseId};

fn robot(name: &str) -> Robot {
    Robot::parse(&shipped_robot(name).unwrap()).unwrap()
}

/// Printed rows of a model in a table.
fn rows(table: &str, model: &str) -> Vec<Printed> {
    let mut rows = printed_rows();
    rows.retain(|row| row.table == table && row.mechanism_or_model == model);
    rows
}

/// Stiffness where a row was printed, with a factor set of the robot, N/m.
fn stiffness_n_per_m(robot: &Robot, set: &str, row: &Printed) -> f64 {
    let direction = direction(&row.physical_direction).unwrap();
    let cells = [Cell::new(PoseId::new(&row.pose), direction)];
    let mut model = CellModel::new(robot, robot.mechanism(None).unwrap(), &[], &cells).unwrap();
    model.stiffness(&robot.factor_set(set).unwrap()).unwrap()[0]
}

/// Ours over the print for each printed stiffness of a model.
fn ratios(robot: &Robot, table: &str, model: &str, set: &str) -> Vec<f64> {
    let rows = rows(table, model).into_iter();
    let rows = rows.filter(|row| row.quantity.starts_with("stiffness"));
    let ratios = rows.map(|row| 1e-6 * stiffness_n_per_m(robot, set, &row) / row.value);
    ratios.collect()
}

#[test]
fn table_iii_agrees_where_bending_rules() {
    let robot = robot("hp-robot");
    let unit = robot.factor_set("unit").unwrap();
    let (mechanism, p1) = (robot.mechanism(None).unwrap(), PoseId::new("P1"));
    let found = significance(&robot, mechanism, &p1, &unit, Scope::All, None, &[]).unwrap();
    let left = |property: Property, direction: Direction| {
        100.0 * found.remaining[property.index()][direction.index()]
    };
    // Iy rules the vertical direction and Iz the lateral one, as in the print (1.64 % and 3.47 % left); the reconstruction's figures are
    // those of data/robots/README.md.
    assert!((left(Property::Iy, Direction::Y) - 2.48).abs() < 0.005);
    assert!((left(Property::Iz, Direction::X) - 5.58).abs() < 0.005);
    // What is printed above 100 % is impossible: stiffening never raises the displacement under the load.
    assert!(
        found
            .remaining
            .as_flattened()
            .iter()
            .all(|left| *left <= 1.0 + 1e-11)
    );
}

#[test]
fn tables_iv_to_vi_lie_within_the_scatter_of_the_reconstruction() {
    // Section constants were fitted to all tables at once: 12 % (Table V) and 14.5 % (Table VI) root mean square, worst cell 29 %.
    let robot = robot("hp-robot");
    for (table, model, set, rms_bound) in [
        ("V", "S-FSD", "s_fsd", 0.121),
        ("VI", "M-FSD", "m_fsd", 0.146),
    ] {
        let ratios = ratios(&robot, table, model, set);
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
    let mut single_pose = rows("IV", "S-FSD (single pose)");
    single_pose.retain(|row| !row.quantity.contains("time"));
    assert_eq!(single_pose.len(), 12);
    for mut row in single_pose {
        let load = row.quantity.split(" at ").nth(1).unwrap();
        let load_n: f64 = load.split(' ').next().unwrap().parse().unwrap();
        row.pose = "P1".to_owned();
        let ratio = 1e6 * load_n / stiffness_n_per_m(&robot, "s_fsd_p1", &row) / row.value;
        assert!((1.0 / 1.30..=1.30).contains(&ratio), "{row:?}: {ratio}");
    }
}

#[test]
fn the_joint_fit_stands_beside_the_papers_errors() {
    let data = Data::open("paper-experiment".as_ref(), &OpenSettings::default()).unwrap();
    let data = FitData::new(data, &ModelChoice::default(), Method::Regression).unwrap();
    let train = Some(["P1", "P3"].map(str::to_owned).to_vec());
    let procedure = PaperFitSettings {
        train: train.clone(),
        ..PaperFitSettings::default()
    };
    let procedure = data.fit_as_paper(&procedure).unwrap().outcome;
    let joint = FitSettings {
        train,
        ..FitSettings::default()
    };
    let joint = data.fit(&joint, &|| ()).unwrap();
    // Table VI prints 123.66 % and 78.33 % as the worst held-out ratios.
    let table = DemoTableVi::new(&procedure, &joint);
    let [first, second] = table.stated_worst_percent;
    assert!((first - 23.66).abs() < 1e-9 && (second - 21.67).abs() < 1e-9);
    assert_eq!(joint.judged_cells().count(), 6);
    // The reconstruction fits worse than the paper says of its own model; that the joint fit beats the procedure is what is held here.
    assert!(table.joint.unwrap() < table.procedure.unwrap(), "{table:?}");
}

#[test]
fn the_variant_fits_the_direct_tables_better() {
    let worst = |name: &str| {
        let ratios = ratios(&robot(name), "V", "S-FSD", "s_fsd").into_iter();
        ratios.map(|ratio| ratio.ln().abs()).fold(0.0, f64::max)
    };
    assert!(worst("hp-robot-host-dominant") < worst("hp-robot"));
}
