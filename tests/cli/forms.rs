//! Every form of a result holds the same quantities: those of the JSON are read back from the text, the Markdown, the page, the tables and the model
//! file of random results.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use super::{Desk, desk};
use crate::support::Json;

/// What is measured, and the options that make it; `{}` stands for a random size.
const KINDS: [&str; 5] = [
    "--procedure load-unload --mechanism A --effect joint-backlash@A3:play={}urad,seat_moment=9N*m",
    "--mechanism F --true-factor beam.Iy=0.{}",
    "--robot serial-arm --displacement-axes x,y,z --true-factor beam.Iz=0.{}",
    "--robot serial-arm --load-cases 30 --repeats 3 --true-factor beam.J=0.{}",
    "--robot franka-panda --load-cases 40 --repeats 2 --reading-sd-um {}",
];

/// Cells of the tables of a text in Markdown, which is what a terminal shows too.
fn rows_of_markdown(text: &str) -> Vec<Vec<String>> {
    let lines = text.lines().filter(|line| line.starts_with('|'));
    let cells = |line: &str| {
        let line = line.trim_matches('|').replace("\\_", "_");
        line.split('|').map(plain).collect()
    };
    lines.map(cells).collect()
}

/// Cells of the tables of a page.
fn rows_of_page(page: &str) -> Vec<Vec<String>> {
    let rows = page.split("<tr").skip(1);
    let rows = rows.map(|row| row.split("</tr>").next().unwrap_or_default());
    let cells = |row: &str| {
        let cells = row.split("<t").skip(1);
        let cells = cells.filter(|cell| {
            cell.starts_with('d') || cell.starts_with("h ") || cell.starts_with("h>")
        });
        let inside = cells.filter_map(|cell| cell.split_once('>'));
        let inside = inside.map(|(_, text)| text.split("</t").next().unwrap_or_default());
        inside.map(plain).collect()
    };
    rows.map(cells).collect()
}

/// A cell without marks of its form.
fn plain(cell: &str) -> String {
    let mut text = String::new();
    let mut is_mark = false;
    for c in cell.chars() {
        match c {
            '<' => is_mark = true,
            '>' if is_mark => is_mark = false,
            c if !is_mark => text.push(c),
            _ => {}
        }
    }
    let text = text
        .replace("&#x2f;", "/")
        .replace("&amp;", "&")
        .replace('\u{a0}', " ");
    text.replace('µ', "u").replace('²', "^2").trim().to_owned()
}

/// Whether a printed number is a value rounded to the digits that are printed.
fn is_rounded(printed: &str, value: f64) -> bool {
    let Ok(number) = printed.parse::<f64>() else {
        return false;
    };
    let (digits, power) = printed.split_once('e').unwrap_or((printed, "0"));
    let decimals = digits
        .split_once('.')
        .map_or(0, |(_, behind)| behind.len() as i32);
    let half = 0.5 * 10_f64.powi(power.parse::<i32>().unwrap() - decimals);
    (number - value).abs() <= half * (1.0 + 1e-9)
}

/// The row of a parameter in the table that has such a head.
fn row_of<'r>(rows: &'r [Vec<String>], head: &str, name: &str) -> (&'r [String], &'r [String]) {
    let at = rows
        .iter()
        .position(|row| row.iter().any(|cell| cell.starts_with(head)) && row.len() > 3);
    let at = at.unwrap_or_else(|| panic!("no table has a column {head}: {rows:?}"));
    let mut behind = rows[at..].iter();
    let row = behind.find(|row| {
        row.first()
            .is_some_and(|cell| cell.trim_matches('`') == name)
    });
    (
        &rows[at],
        row.unwrap_or_else(|| panic!("no row of {name}: {rows:?}")),
    )
}

/// What a column is multiplied by, from its unit.
fn per_unit(head: &str) -> f64 {
    if ["urad", "um/", "1e-6"]
        .iter()
        .any(|unit| head.contains(unit))
    {
        1e6
    } else {
        1.0
    }
}

/// The parameters of a fit as a form prints them.
fn assert_parameters(fit: &Value, rows: &[Vec<String>], form: &str) {
    for parameter in fit["data"]["parameters"].list() {
        let name = parameter["name"].word();
        // Of a robot without beams no factors are printed.
        if rows.iter().all(|row| row.iter().all(|cell| cell != name)) {
            assert_eq!(parameter["status"], "fixed", "{form}, {name}");
            continue;
        }
        let is_spring = parameter["unit"] != "1";
        let (head, row) = row_of(rows, if is_spring { "compliance" } else { "value" }, name);
        let column = |what: &str| head.iter().position(|cell| cell.starts_with(what)).unwrap();
        let value_at = column(if is_spring { "compliance" } else { "value" });
        let scale = per_unit(&head[value_at]);
        let Some(value) = parameter["value"].as_f64() else {
            assert_eq!(row[value_at], "-", "{form}, {name}");
            continue;
        };
        assert!(
            is_rounded(&row[value_at], scale * value),
            "{form}, {name}: {} and {value}",
            row[value_at]
        );
        if let Some(u) = parameter["se"]
            .as_f64()
            .filter(|_| parameter["status"] == "free")
        {
            let printed = &row[column("standard error")];
            assert!(
                is_rounded(printed, scale * u),
                "{form}, u of {name}: {printed} and {u}"
            );
        }
        let ends = parameter["ci95"]
            .as_array()
            .filter(|_| parameter["islands"].list().is_empty());
        let printed = row[column("95 %")].split_once(" to ");
        if let (Some(ends), Some((low, high))) = (ends, printed) {
            for (printed, end) in [(low, &ends[0]), (high, &ends[1])] {
                let end = scale * end.number();
                assert!(
                    is_rounded(printed, end),
                    "{form}, interval of {name}: {printed} and {end}"
                );
            }
        }
    }
}

/// Findings of the JSON in the model file, which holds them in full, and in the page of a diagnosis.
fn assert_findings(desk: &Desk, diagnosis: &Value) {
    let page = desk.read("found/verdict.txt").replace('µ', "u");
    let stored: Value = serde_json::from_str(&desk.read("found/diagnosis.json")).unwrap();
    assert_eq!(stored["data"]["findings"], diagnosis["data"]["findings"]);
    assert!(
        super::unwrapped(&page).contains(diagnosis["data"]["headline"].word()),
        "{page}"
    );
    let model: toml::Table = desk.read("found/model.toml").parse().unwrap();
    let effects = model.get("effects").and_then(|effects| effects.as_array());
    let effects = effects.map(Vec::as_slice).unwrap_or_default();
    let grouped = |finding: &&Value| {
        finding["alternative_group"]
            .as_u64()
            .is_none_or(|group| group == 0)
    };
    for finding in diagnosis["data"]["findings"].list().iter().filter(grouped) {
        if finding["kind"] != "physics" {
            continue;
        }
        let own = effects
            .iter()
            .find(|effect| effect["physics"].as_str() == finding["physics"].as_str());
        let Some(own) = own else { continue };
        for (name, value) in finding["parameters"].as_object().unwrap() {
            let stored = own["parameters"][name.as_str()]["value"]
                .as_float()
                .unwrap();
            assert_eq!(Some(stored), value["value"].as_f64(), "{name}");
        }
    }
}

#[test]
fn random_results_have_the_same_quantities_in_every_form() {
    let mut random = ChaCha8Rng::seed_from_u64(20_261_129);
    for kind in KINDS {
        let desk = desk();
        let (size, seed) = (random.random_range(40..=90), random.random_range(1..1000));
        let options = kind.replace("{}", &size.to_string());
        desk.run(&format!("simulate s --seed {seed} {options}"))
            .succeeds();
        let fit = desk.run("fit s --json").succeeds().json();
        assert_parameters(
            &fit,
            &rows_of_markdown(&desk.run("fit s").succeeds().stdout),
            "text",
        );
        for form in ["html", "md"] {
            desk.run(&format!("report s --out r.{form}")).succeeds();
        }
        assert_parameters(&fit, &rows_of_markdown(&desk.read("r.md")), "Markdown");
        assert_parameters(&fit, &rows_of_page(&desk.read("r.html")), "page");
        let diagnosis = desk
            .run("diagnose s --out found --no-figures --json")
            .succeeds()
            .json();
        assert_findings(&desk, &diagnosis);
        if kind.contains("--load-cases") || kind.contains("axes") {
            continue;
        }
        // K: in the table of the exchange in full, in the page rounded.
        let stiffness = desk.run("stiffness s --json").succeeds().json();
        desk.run("export s --out tables").succeeds();
        let table = desk.read("tables/stiffness.csv");
        let page = rows_of_page(&desk.read("r.html"));
        let mut lines = table.lines().skip(1);
        for cell in stiffness["data"]["cells"].list() {
            let k = cell["stiffness_regression"]["value"].number();
            let line: Vec<&str> = lines.next().unwrap().split(',').collect();
            assert_eq!(
                (Some(line[0]), Some(line[1])),
                (cell["pose"].as_str(), cell["direction"].as_str())
            );
            assert_eq!(line[4].parse::<f64>().unwrap(), k);
            let is_own =
                |row: &&Vec<String>| row.len() > 5 && row[0] == line[0] && row[1] == line[1];
            let row = page.iter().find(is_own).unwrap();
            assert!(is_rounded(&row[3], k), "{row:?} and {k}");
        }
    }
}
