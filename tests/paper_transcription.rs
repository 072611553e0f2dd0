//! The transcribed tables of the paper against themselves: what follows from other cells is recomputed, and what does not agree is
//! listed as an erratum, no more and no less.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

type Row = BTreeMap<String, String>;

fn rows(file: &str) -> Vec<Row> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data/paper")
        .join(file);
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().collect::<Result<_, _>>().unwrap()
}

/// Table, model, direction, pose and quantity: what makes a cell.
type Place = [String; 5];

fn place(row: &Row) -> Place {
    [
        "table",
        "mechanism_or_model",
        "direction_in_table",
        "pose",
        "quantity",
    ]
    .map(|key| row[key].clone())
}

/// A printed number and half of its last digit.
#[derive(Clone, Copy)]
struct Printed {
    value: f64,
    half_digit: f64,
}

fn printed(text: &str) -> Printed {
    let decimals = text.split_once('.').map_or(0, |(_, digits)| digits.len());
    Printed {
        value: text.parse().unwrap(),
        half_digit: 0.5 * 10_f64.powi(-(decimals as i32)),
    }
}

fn cells() -> BTreeMap<Place, Printed> {
    let rows = rows("tables.csv");
    let cells: BTreeMap<Place, Printed> = rows
        .iter()
        .map(|row| (place(row), printed(&row["value"])))
        .collect();
    assert_eq!(cells.len(), rows.len(), "a cell stands twice");
    cells
}

/// Whose ratio a percentage is: the two cells, if it is one.
fn parts_of_ratio(
    [table, model, direction, pose, quantity]: &Place,
    cells: &BTreeMap<Place, Printed>,
) -> [Place; 2] {
    let cell = |model: &str, direction: &str, quantity: &str| -> Place {
        [table, model, direction, pose, quantity].map(str::to_owned)
    };
    let quantity = quantity.trim_end_matches(", ratio");
    match (table.as_str(), model.split_once('/')) {
        ("III", _) => {
            let factors = match model.as_str() {
                "only a_A=100" => "[100,1,1,1]",
                "only a_Iy=100" => "[1,100,1,1]",
                "only a_Iz=100" => "[1,1,100,1]",
                "only a_J=100" => "[1,1,1,100]",
                other => panic!("{other}"),
            };
            [factors, "[1,1,1,1]"].map(|f| {
                cell(
                    &format!("a=[aA,aIy,aIz,aJ]={f}"),
                    direction,
                    "displacement at -50 N",
                )
            })
        }
        ("X", _) => [direction.as_str(), "x"].map(|d| cell(model, d, "mean stiffness")),
        (_, Some((above, below))) => {
            let below = if above.starts_with("mechanism") {
                format!("mechanism {below}")
            } else {
                below.to_owned()
            };
            let single = cell(&format!("{above} (single pose)"), direction, quantity);
            let above = cell(above, direction, quantity);
            [
                if cells.contains_key(&above) {
                    above
                } else {
                    single
                },
                cell(&below, direction, quantity),
            ]
        }
        _ => panic!("{model} is no ratio"),
    }
}

#[test]
fn values_that_do_not_follow_are_listed_in_the_errata() {
    let cells = cells();
    let mut wrong: BTreeSet<Place> = BTreeSet::new();
    let (mut ratios, mut differences) = (0, 0);
    for row in rows("tables.csv").iter().filter(|row| row["unit"] == "%") {
        let here = place(row);
        let [above, below] = parts_of_ratio(&here, &cells).map(|part| cells[&part]);
        let expected = 100.0 * above.value / below.value;
        // Rounding of the two cells and of the ratio itself.
        let spread = above.half_digit / above.value.abs() + below.half_digit / below.value.abs();
        let found = cells[&here];
        if (found.value - expected).abs() > expected.abs() * spread + found.half_digit {
            wrong.insert(here);
        }
        ratios += 1;
    }
    for (here, found) in cells
        .iter()
        .filter(|(place, _)| place[4] == "stiffness difference")
    {
        let of = |quantity: &str| {
            let mut place = here.clone();
            quantity.clone_into(&mut place[4]);
            cells[&place]
        };
        let (least, most) = (of("minimum stiffness"), of("maximum stiffness"));
        let bound = least.half_digit + most.half_digit + found.half_digit + 1e-12;
        if (most.value - least.value - found.value).abs() > bound {
            wrong.insert(here.clone());
        }
        differences += 1;
    }
    assert_eq!((ratios, differences), (144, 18));
    let computed = [
        "VI,M-FSD/experiment",
        "VII,mechanism F",
        "VII,mechanism F/A",
        "VIII,mechanism F",
        "VIII,mechanism F/A",
    ];
    let found: BTreeSet<String> = wrong
        .iter()
        .map(|place| format!("{},{}", place[0], place[1]))
        .collect();
    assert_eq!(
        found.iter().map(String::as_str).collect::<Vec<_>>(),
        computed
    );
    let listed: BTreeSet<Place> = rows("errata.csv").iter().map(place).collect();
    assert!(wrong.is_subset(&listed), "{:?}", wrong.difference(&listed));
}

#[test]
fn errata_quote_what_is_printed() {
    let tables: BTreeMap<Place, String> = rows("tables.csv")
        .into_iter()
        .map(|row| (place(&row), row["value"].clone()))
        .collect();
    for row in rows("errata.csv") {
        assert_eq!(tables[&place(&row)], row["printed"], "{row:?}");
        assert!(!row["why"].is_empty());
    }
}

/// Displacements above 100 % in Table III, which no linear structure can show, are all listed.
#[test]
fn table_iii_grows_four_times() {
    let listed = rows("errata.csv")
        .iter()
        .filter(|row| row["table"] == "III")
        .count();
    let table = rows("tables.csv");
    let percent = table
        .iter()
        .filter(|row| row["table"] == "III" && row["unit"] == "%");
    assert_eq!(
        percent
            .filter(|row| printed(&row["value"]).value > 100.0)
            .count(),
        listed
    );
}

/// Stiffness of Table V is 50 N over the displacement beside it.
#[test]
fn table_v_stiffness_is_load_over_displacement() {
    let cells = cells();
    let mut count = 0;
    for (here, stiffness) in cells
        .iter()
        .filter(|(place, _)| place[0] == "V" && place[4] == "stiffness")
    {
        let mut beside = here.clone();
        "displacement at -50 N".clone_into(&mut beside[4]);
        let displacement = cells[&beside];
        let expected = -50.0 / displacement.value;
        let rounding = expected * displacement.half_digit / displacement.value.abs();
        assert!(
            (stiffness.value - expected).abs() <= stiffness.half_digit + rounding,
            "{here:?}"
        );
        count += 1;
    }
    assert_eq!(count, 24);
}

/// Each table has one direction a letter; the letters change between tables as the README says.
#[test]
fn axes_of_the_tables() {
    let mut axes: BTreeMap<String, BTreeSet<(String, String)>> = BTreeMap::new();
    for row in rows("tables.csv")
        .into_iter()
        .filter(|row| row["table"] != "I")
    {
        let pair = (
            row["direction_in_table"].clone(),
            row["physical_direction"].clone(),
        );
        axes.entry(row["table"].clone()).or_default().insert(pair);
    }
    let swapped = [("x", "radial"), ("y", "vertical"), ("z", "lateral")];
    let ours = [("x", "lateral"), ("y", "vertical"), ("z", "radial")];
    for (table, found) in &axes {
        let expected = if ["III", "V", "VI"].contains(&table.as_str()) {
            swapped
        } else {
            ours
        };
        let known =
            |(letter, direction): &(String, String)| expected.contains(&(letter, direction));
        assert!(found.iter().all(known), "{table}: {found:?}");
    }
    assert_eq!(axes.len(), 8);
}

#[test]
fn extracts_are_the_tables() {
    let cells = cells();
    let extract = rows("experiment-table-vi.csv");
    assert_eq!(extract.len(), 12);
    for row in extract {
        // Our x is across the arm, which Table VI calls z.
        let letter = match row["direction"].as_str() {
            "x" => "z",
            "z" => "x",
            other => other,
        };
        assert_eq!(row["letter_in_table"], letter);
        for (column, model) in [
            ("experiment_N_per_um", "experiment"),
            ("m_fsd_N_per_um", "M-FSD"),
        ] {
            let place = ["VI", model, letter, &row["pose"], "stiffness"].map(str::to_owned);
            assert_eq!(printed(&row[column]).value, cells[&place].value, "{row:?}");
        }
    }
}

/// Combined factors against the plain means of P1 and P3: three differ, the others agree to the last digit.
#[test]
fn combined_factors_are_not_all_means() {
    let rows = rows("factors.csv");
    let mut different = Vec::new();
    for set in ["S-FSD", "M-FSD"] {
        let of = |pose: &str| {
            rows.iter()
                .find(|r| r["set"] == set && r["class"] == "beam" && r["pose"] == pose)
                .unwrap()
        };
        for factor in ["A", "Iy", "Iz", "J"] {
            let [p1, p3, both] = ["P1", "P3", "P1 and P3"].map(|pose| printed(&of(pose)[factor]));
            if (0.5 * (p1.value + p3.value) - both.value).abs() > 1.01 * both.half_digit {
                different.push(format!("{set} {factor}"));
            }
        }
    }
    assert_eq!(different, ["S-FSD Iy", "S-FSD Iz", "M-FSD A"]);
}
