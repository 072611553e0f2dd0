//! Reports: what a page holds, what is marked on it, and that no changed digit goes unnoticed.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use stiffbench_test_files::desk::{Desk, Ran, assert_output_contains};

use super::{desk, desk_with_session, five_columns};
use crate::support::tables::Table;
use crate::support::{Contains, Json};

/// A desk with `session` and its `report.html`, of two poses, without diagnosis.
fn desk_with_report(options: &str) -> Desk {
    let desk = desk();
    desk.run("simulate session --poses P1,P3 --seed 4")
        .succeeds();
    desk.run(&format!("report session --no-diagnosis {options}"))
        .succeeds();
    desk
}

/// The paragraphs of the answer of a report, in lines.
fn answer(data: &Value) -> String {
    let blocks = data["answer"].list().iter();
    let texts = blocks.filter_map(|block| block["text"].as_str());
    texts.collect::<Vec<_>>().join("\n")
}

/// The rows of the table of a report with such a head.
fn rows<'d>(data: &'d Value, heads: &[&str]) -> &'d [Value] {
    let mut blocks = data["body"].list().iter();
    let table = blocks.find(|block| {
        let columns = block["columns"].as_array();
        columns.is_some_and(|columns| {
            let has = |head: &&str| columns.iter().any(|column| column["head"] == **head);
            heads.iter().all(has)
        })
    });
    table.unwrap()["rows"].list()
}

/// Every item of a report, stated.
pub(super) const DETAILS: &str = "authorised_by = \"A. Nyone\"\nexternal_providers = \"not applicable\"\nperformed = 2026-11-20\n\
    [laboratory]\nname = \"Lab\"\naddress = \"Street 1\"\nlocation = \"Hall 3\"\n[customer]\nname = \"C\"\ncontact = \"Road 2\"\n\
    [item]\ndescription = \"robot\"\nidentification = \"4711\"\ncondition = \"good\"\nreceived = 2026-11-18\n\
    [method]\nreference = \"LI 12\"\nsampling = \"not applicable\"\ndeviations = \"none\"\n";

#[test]
fn a_page_stands_alone_is_small_and_has_the_same_bytes_twice() {
    let desk = desk_with_report("");
    let page = desk.read("session/report.html");
    for outside in [
        "http:", "https:", "src=", "@import", "url(", "<link", "href=",
    ] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.len() < 2_500_000, "{}", page.len());
    assert!(page.matches("<svg").count() >= 3);
    desk.run("report session --no-diagnosis --out again.html")
        .succeeds();
    assert_eq!(page, desk.read("again.html"));
    // The same session elsewhere gives the same page.
    let elsewhere = desk.path("elsewhere");
    std::fs::create_dir(&elsewhere).unwrap();
    for name in ["session.toml", "readings.csv", "robot.toml"] {
        std::fs::copy(desk.path("session").join(name), elsewhere.join(name)).unwrap();
    }
    desk.run("report elsewhere --no-diagnosis --out third.html")
        .succeeds();
    assert_eq!(page, desk.read("third.html"));
}

/// The command `robot map` is another way to the same numbers.
#[test]
fn the_map_of_a_page_is_that_of_the_fitted_model() {
    let desk = desk_with_report("");
    let fit = desk.run("fit session --json").succeeds().stdout;
    desk.write("fit.json", &fit);
    let map = desk.data(
        "robot map --fit fit.json --mechanisms F --samples 600 --sampling low-discrepancy --directions x,y,z",
    );
    let page = desk.data("report session --no-diagnosis --out again.html");
    let rows = rows(&page, &["direction", "smallest", "largest"]);
    assert_eq!(rows.len(), 4);
    let columns = map["mechanisms"][0]["stiffness"].list();
    for (row, column) in rows.iter().zip(columns) {
        for (place, end) in [(1, "smallest"), (2, "largest")] {
            let printed: f64 = row[place].word().parse().unwrap();
            let value = column[end]["sampled"]["value"]["value"].number();
            // Four digits are printed.
            assert!((printed / value - 1.0).abs() < 0.0005, "{row}: {value}");
        }
    }
    let html = desk.read("again.html");
    html.must_contain(&["<h2>Stiffness over the workspace</h2>"]);
}

#[test]
fn a_report_with_a_diagnosis_names_the_verdict_and_is_small() {
    let desk = desk();
    desk.run("simulate session --poses P1,P2,P3 --seed 4")
        .succeeds();
    let data = desk.data("report session --train P1,P3");
    let answer = answer(&data);
    let verdict = data["diagnosis"]["numbers"]["headline"].word();
    let page = desk.read("session/report.html");
    page.must_contain(&["What the model leaves out"]);
    assert!(page.contains(&verdict[..20]) && answer.contains(&verdict[..20]));
    assert!(page.len() < 2_500_000, "{}", page.len());
    // Nothing is named, and so nothing improves.
    assert!(!answer.contains("falls from"), "{answer}");
    assert!(data["fit"]["numbers"]["cells"].is_array());
    desk.run("report verify session/report.html session")
        .succeeds();
}

#[test]
fn each_of_200_changed_digits_is_found() {
    let desk = desk_with_report("");
    let page = desk.read("session/report.html");
    let digits: Vec<usize> = printed_digits(&page);
    assert!(digits.len() > 3000, "{}", digits.len());
    let mut rng = ChaCha8Rng::seed_from_u64(26);
    for _ in 0..200 {
        let at = digits[rng.random_range(0..digits.len())];
        let old = page.as_bytes()[at] - b'0';
        let new = (old + rng.random_range(1..10_u8)) % 10;
        let mut changed = page.clone();
        changed.replace_range(at..=at, &new.to_string());
        let read = stiffbench::report::page::read_page("page", changed).unwrap();
        let template = stiffbench::report::page::PageFormat::Html.template();
        let check = read.check(&template, None).unwrap();
        assert!(!check.good, "byte {at}: {old} to {new} was not found");
        assert!(!check.differences[0].place.is_empty());
    }
}

/// Bytes of digits that are printed: text, tables and drawings, and the embedded data.
fn printed_digits(page: &str) -> Vec<usize> {
    let body = page.find("<body>").unwrap();
    let digits = page.bytes().enumerate().skip(body);
    digits
        .filter(|(_, byte)| byte.is_ascii_digit())
        .map(|(at, _)| at)
        .collect()
}

#[test]
fn a_changed_number_is_named_with_its_line_and_what_it_was() {
    let desk = desk_with_report("");
    let page = desk.read("session/report.html");
    let row = page.find("<tr><td>P1</td><td>x").unwrap();
    let cell = row + page[row..].find(">0.0").unwrap() + ">0.0".len();
    let mut changed = page.clone();
    changed.replace_range(cell..=cell, "9");
    desk.write("changed.html", &changed);
    let run = desk.run("report verify changed.html").exits_with(30);
    let line = page[..cell].matches('\n').count() + 1;
    run.stdout.must_contain(&[&format!("line {line} "), "0.09"]);
    let data = desk.run("report verify changed.html --json").exits_with(30);
    let data = data.json();
    assert_eq!(data["ok"], false);
    assert_eq!(data["data"]["good"], false);
    desk.run("report verify session/report.html").succeeds();
}

#[test]
fn missing_items_are_listed_and_marked_and_stated_ones_are_not() {
    let desk = desk_with_report("--out bare.html");
    let run = desk
        .run("report session --no-diagnosis --out more.html")
        .succeeds();
    run.stdout.must_contain(&[
        "laboratory.name",
        "customer.name",
        "item.received",
        "--issued DATE",
    ]);
    desk.read("bare.html").must_contain(&[">missing</"]);
    assert!(!desk.read("bare.html").contains("not applicable"));
    desk.write("details.toml", DETAILS);
    let options = "--details details.toml --issued 2026-11-25 --out full.html";
    let data = desk.data(&format!("report session --no-diagnosis {options}"));
    let open = data["items"].list().iter();
    assert_eq!(open.filter(|item| item["value"].is_null()).count(), 0);
    let page = desk.read("full.html");
    page.must_contain(&["Hall 3", "2026-11-18", "not applicable"]);
    assert!(!page.contains(">missing</"));
}

#[test]
fn pass_and_fail_follow_the_decision_rule() {
    let desk = desk_with_report("");
    let data = desk.data("stiffness session");
    let cell = &data["cells"][0]["stiffness_regression"];
    let (value, expanded) = (cell["value"].number(), cell["U"].number());
    let decided = |rule: &str, limit: f64, out: &str| {
        let details = format!(
            "{rule}[[requirement]]\npose = \"P1\"\ndirection = \"x\"\nat_least_N_per_um = {limit}\n"
        );
        desk.write("details.toml", &details);
        let command = format!("report session --no-diagnosis --details details.toml --out {out}");
        let data = desk.data(&command);
        data["conformity"]["requirements"][0]["decision"].clone()
    };
    let guard = "decision_rule = \"guard-band\"\n";
    assert_eq!(decided(guard, value - 2.0 * expanded, "a.html"), "pass");
    assert_eq!(
        decided(guard, value - 0.5 * expanded, "b.html"),
        "conditional-pass"
    );
    assert_eq!(
        decided(guard, value + 0.5 * expanded, "c.html"),
        "conditional-fail"
    );
    assert_eq!(decided(guard, value + 2.0 * expanded, "d.html"), "fail");
    let simple = "decision_rule = \"simple-acceptance\"\n";
    assert_eq!(decided(simple, value - 0.5 * expanded, "e.html"), "pass");
    assert_eq!(decided("", value, "f.html"), Value::Null);
    desk.read("f.html")
        .must_contain(&["no statement of conformity"]);
    desk.read("b.html").must_contain(&["conditional pass"]);
}

#[cfg(unix)]
#[test]
fn an_emulated_session_that_was_stopped_is_partial() {
    let desk = desk();
    desk.write(
        "short.toml",
        "schema = \"stiffbench/procedure/1\"\nname = \"short\"\nposes = [\"P1\"]\ndirections = [\"x\"]\nloads_N = [-10, -20, -30]\nrepeats = 2\n",
    );
    let options = "--emulated --seed 5 --speed 600 --robot hp-robot --procedure short.toml --no-input --answer temperature=21";
    // The question of the sign check has no answer, so that the session ends as partial.
    let run = desk.run(&format!("session run whole {options}"));
    if run.code != 0 {
        assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
    }
    desk.run("report whole --no-diagnosis").succeeds();
    let page = desk.read("whole/report.html");
    page.must_contain(&["EMULATED"]);
    assert_eq!(
        page.contains("<span>PARTIAL · EMULATED</span>"),
        run.code != 0
    );
    desk.run("report verify whole/report.html whole").succeeds();
    // The session has its days: details that state others are no report.
    desk.write("days.toml", "performed = \"2020-01-02\"\n");
    let other_days = "report whole --no-diagnosis --details days.toml --out days.html";
    let error = desk.refusal(other_days, 10, "stiffbench::report::contradiction");
    assert_output_contains(&error, &["`performed` states 2020-01-02", "taken on"]);
    assert!(!desk.path("days.html").exists());
    // A calibration that had run out stands on the first page with the digits of its certificate.
    desk.write("records.toml", &overdue(&desk.read("whole/session.toml")));
    let later = "report whole --no-diagnosis --instrument-records records.toml --out overdue.html";
    let run = desk.run(later).succeeds();
    let page = desk.read("overdue.html");
    let first = page.split("<h2>").next().unwrap();
    first.must_contain(&[
        "CALIBRATION OVERDUE",
        "certificate K-1, OVERDUE (due 2020-01-02)",
        "displacement gauge: not stated",
        "loads -10, -20, -30 N",
        "no statement of conformity",
    ]);
    page.must_contain(&[">0.15 N (k = 2)</td>", "measured by"]);
    run.stdout.must_contain(&["CALIBRATION OVERDUE"]);
}

/// A session whose force gauge had a certificate that ran out.
fn overdue(session: &str) -> String {
    let record =
        "[instruments.force]\nU_N = 0.15\nk = 2\ncertificate = \"K-1\"\ndue = 2020-01-02\n";
    session.replacen("[instruments.force]\n", record, 1)
}

/// Rows of a table are as long as its head in every form, whatever a pose is called.
#[test]
fn a_bar_in_the_name_of_a_pose_shifts_no_column_in_any_form() {
    let desk = desk();
    desk.run("simulate session --poses P1,P3 --seed 4")
        .succeeds();
    for (file, old, new) in [
        ("readings.csv", ",P1,", ",P|1,"),
        ("robot.toml", "[poses.P1]", "[poses.\"P|1\"]"),
        ("session.toml", "\"P1\"", "\"P|1\""),
        ("session.toml", "robot_sha256", "# robot_sha256"),
    ] {
        let path = format!("session/{file}");
        desk.write(&path, &desk.read(&path).replace(old, new));
    }
    for out in ["page.html", "page.md", "page.typ"] {
        desk.run(&format!("report session --no-diagnosis --out {out}"))
            .succeeds();
    }
    let rows = |text: &str, begins: &str, cell: &str| {
        let rows = text.lines().filter(|line| line.starts_with(begins));
        rows.map(|row| row.matches(cell).count())
            .collect::<Vec<_>>()
    };
    // Three directions in the results, three in the fit.
    let (html, markdown) = (desk.read("page.html"), desk.read("page.md"));
    assert_eq!(
        rows(&html, "<tr><td>P|1</td><td>", "</td>"),
        [8, 8, 8, 6, 6, 6]
    );
    let plain = markdown.replace("\\|", "");
    assert_eq!(rows(&plain, "| P1 |", "|"), [9, 9, 9, 7, 7, 7]);
    assert_eq!(desk.read("page.typ").matches("\"P|1\", \"x\", ").count(), 2);
}

#[test]
fn a_replacement_names_the_report_and_the_reason() {
    let desk = desk_with_report("--out first.html");
    desk.command(
        "report session --no-diagnosis --out second.html --amends SB-20261120-0123456789 --reason",
    )
    .arg("wrong serial number")
    .assert()
    .success();
    let page = desk.read("second.html");
    page.must_contain(&[
        "This report replaces report SB-20261120-0123456789.",
        "wrong serial number",
    ]);
    desk.run("report session --amends SB-1").exits_with(2);
    desk.run("report session --reason because").exits_with(2);
}

#[test]
fn the_day_of_issue_is_never_that_of_the_clock() {
    let desk = desk_with_report("--issued 2026-11-25 --out a.html");
    desk.read("a.html").must_contain(&["issued 2026-11-25"]);
    desk.command("report session --no-diagnosis --out b.html")
        .env("SOURCE_DATE_EPOCH", "1700000000")
        .assert()
        .success();
    desk.read("b.html").must_contain(&["issued 2023-11-14"]);
    desk.command("report session --no-diagnosis --out c.html")
        .env("SOURCE_DATE_EPOCH", "yesterday")
        .assert()
        .code(2);
}

#[test]
fn typst_gets_every_text_as_a_string() {
    let desk = desk_with_session();
    desk.write(
        "report.toml",
        "[item]\ndescription = '#panic(\"no\") \\ $x$ *bold*'\n",
    );
    desk.run("report session --no-diagnosis --details report.toml --out page.typ")
        .succeeds();
    let text = desk.read("page.typ");
    text.must_contain(&["\"#panic(\\\"no\\\") \\\\ $x$ *bold*\""]);
    assert!(text.contains("drawing(bytes(\"<svg xmlns=") && !text.contains("{{"));
    // Outside of strings stand the words of the template alone.
    let mut outside = String::new();
    let (mut is_string, mut is_escaped) = (false, false);
    for c in text.chars() {
        match c {
            _ if is_escaped => is_escaped = false,
            '\\' if is_string => is_escaped = true,
            '"' => is_string = !is_string,
            c if !is_string => outside.push(c),
            _ => {}
        }
    }
    assert!(!is_string && !outside.contains("panic") && !outside.contains("svg xmlns"));
    assert_eq!(
        outside.matches('(').count(),
        outside.matches(')').count(),
        "{outside}"
    );
    desk.refusal(
        "report verify page.typ",
        11,
        "stiffbench::report::not_a_report",
    );
}

#[test]
fn a_locale_without_utf_8_gets_ascii() {
    let desk = desk_with_session();
    let stated = |locale: &str, file: &str| {
        let line = format!("report session --no-diagnosis --out {file}");
        let ran = Ran::of(desk.command(&line).env("LC_ALL", locale)).succeeds();
        ran.stdout
    };
    stated("C.UTF-8", "a.html").must_contain(&[" ± "]);
    let plain = stated("C", "b.html");
    assert!(plain.contains(" +- ") && plain.is_ascii(), "{plain}");
    desk.read("b.html").must_contain(&[" ± "]);
}

/// Relative luminance of a colour `#rrggbb` (WCAG 2.2).
fn luminance(colour: &str) -> f64 {
    let part = |at: usize| {
        let value = f64::from(u8::from_str_radix(&colour[at..at + 2], 16).unwrap()) / 255.0;
        if value <= 0.040_45 {
            value / 12.92
        } else {
            ((value + 0.055) / 1.055).powf(2.4)
        }
    };
    0.2126 * part(1) + 0.7152 * part(3) + 0.0722 * part(5)
}

#[test]
fn text_has_contrast_on_light_dark_and_printed_paper() {
    let template = stiffbench::report::page::PageFormat::Html.template().text;
    let schemes: Vec<&str> = template.split(":root {").skip(1).collect();
    assert_eq!(schemes.len(), 3);
    // What is not set again is that of the light scheme.
    let colour = |scheme: &str, name: &str| {
        let value = scheme.split(&format!("--{name}: ")).nth(1);
        let value = value.map(|rest| rest.split(';').next().unwrap().to_owned())?;
        let short = value.len() == 4;
        Some(if short {
            value
                .chars()
                .skip(1)
                .fold("#".to_owned(), |all, c| format!("{all}{c}{c}"))
        } else {
            value
        })
    };
    for scheme in schemes
        .iter()
        .map(|scheme| scheme.split('}').next().unwrap())
    {
        for (ink, paper) in [
            ("ink", "paper"),
            ("ink", "tint"),
            ("quiet", "paper"),
            ("quiet", "tint"),
            ("warn", "paper"),
            ("warn", "warn-tint"),
        ] {
            let [ink_value, paper_value] =
                [ink, paper].map(|name| luminance(&colour(scheme, name).unwrap()));
            let (light, dark) = (ink_value.max(paper_value), ink_value.min(paper_value));
            let contrast = (light + 0.05) / (dark + 0.05);
            assert!(contrast >= 4.5, "{ink} on {paper}: {contrast}");
        }
    }
}

#[test]
fn load_cases_have_a_report_with_springs_and_it_can_be_verified() {
    let desk = desk();
    let cases = stiffbench_test_files::repository().join("data/load-cases/fanuc-r2000ic");
    let (cases, to) = (cases.display(), "--robot fanuc-r2000ic --out fanuc.html");
    let data = desk.data(&format!("report {cases} {to}"));
    let answer = answer(&data);
    // The fit prints 860874 N*m/rad.
    answer.must_contain(&["joint.J1\u{a0}861"]);
    answer.must_contain(&["rigid robot"]);
    // What is named weakly is no improvement to promise.
    answer.must_contain(&["There is a weak sign of"]);
    assert!(!answer.contains("falls from"), "{answer}");
    let unseen = &data["diagnosis"]["numbers"]["after"]["held_out_rms_um"];
    assert!((140.0..180.0).contains(&unseen.number()), "{unseen}");
    assert_eq!(data["sessions"][0]["load_cases"], 43);
    let findings = data["diagnosis"]["numbers"]["findings"].list();
    assert!(
        findings.iter().any(|one| one["place"]["joint"] == "J3"),
        "{findings:?}"
    );
    let page = desk.read("fanuc.html");
    assert!(!page.contains("Uncertainty budget"));
    page.must_contain(&["Residual vectors"]);
    desk.run(&format!("report verify fanuc.html {cases}"))
        .succeeds();
    // One digit of a compliance in the embedded data and the text.
    std::fs::write(
        desk.path("changed.html"),
        page.replacen("860874", "860875", 1),
    )
    .unwrap();
    desk.run(&format!("report verify changed.html {cases}"))
        .exits_with(30);
}

#[test]
fn a_page_of_another_template_is_never_verified_without_it() {
    let desk = desk_with_report("");
    let own = desk.run("report --print-template").succeeds().stdout;
    desk.write("own.html", &own.replace("<h1>", "<h1 lang=\"en\">"));
    desk.run("report session --no-diagnosis --template own.html --out page.html")
        .succeeds();
    desk.run("report verify page.html session --template own.html")
        .succeeds();
    let page = desk.read("page.html");
    let digit = printed_digits(&page)[3];
    let other = if page.as_bytes()[digit] == b'7' {
        "8"
    } else {
        "7"
    };
    desk.write(
        "altered.html",
        &format!("{}{other}{}", &page[..digit], &page[digit + 1..]),
    );
    for name in ["page.html", "altered.html"] {
        let ran = desk.run(&format!("report verify {name} session"));
        assert_eq!(ran.code, 11, "{name}: {}", ran.stdout);
        ran.stdout.must_contain(&["NOT VERIFIED", "--template"]);
    }
    let ran = desk.run("report verify altered.html session --template own.html");
    assert_eq!(ran.code, 30, "{}", ran.stdout);
}

#[test]
fn a_page_without_its_options_is_not_verified_against_a_session() {
    let desk = desk_with_report("");
    let page = desk.read("session/report.html");
    let (before, rest) = page.split_once("id=\"stiffbench-data\">").unwrap();
    let (json, after) = rest.split_once("</script>").unwrap();
    let mut data: Value = serde_json::from_str(json).unwrap();
    data["settings"] = Value::Null;
    let changed = format!("{before}id=\"stiffbench-data\">{data}</script>{after}");
    desk.write("changed.html", &changed);
    let ran = desk.run("report verify changed.html session");
    assert_eq!(ran.code, 30, "{}", ran.stdout);
    ran.stdout.must_contain(&["/settings"]);
}

#[test]
fn an_end_of_line_too_much_is_found() {
    let desk = desk_with_report("");
    desk.write("longer.html", &(desk.read("session/report.html") + "\n"));
    assert_eq!(desk.run("report verify longer.html").code, 30);
}

#[test]
fn an_improvement_is_stated_only_where_the_error_falls() {
    let desk = desk();
    desk.run("simulate con --mechanism A --procedure load-unload --effect joint-backlash@A3:play=30urad,seat_moment=9N*m --seed 2")
        .succeeds();
    let data = desk.data("report con");
    let answer = answer(&data);
    if let Some((_, numbers)) = answer.split_once("falls from ") {
        let mut numbers = numbers
            .split(' ')
            .filter_map(|word| word.parse::<f64>().ok());
        let [before, after] = [numbers.next().unwrap(), numbers.next().unwrap()];
        assert!(after < before, "{answer}");
    }
    answer.must_contain(&["play in joint A3"]);
}

#[test]
fn names_cannot_turn_what_is_printed() {
    let desk = desk();
    let table = five_columns(&["P1"], 3).replace("P1,", "P\u{202e}1\u{1b},");
    desk.write("readings.csv", &table);
    let ran = desk.run("report readings.csv --out page.html").succeeds();
    assert!(!ran.stdout.contains('\u{1b}'), "{}", ran.stdout);
    let page = desk.read("page.html");
    assert!(!page.contains(['\u{202e}', '\u{1b}']));
    desk.run("report verify page.html readings.csv").succeeds();
}

#[test]
fn readings_that_differ_from_their_journal_are_marked() {
    let desk = desk();
    desk.run("session run s --emulated --speed 200 --no-input --poses P1 --directions x --repeats 3 --loads-n=0,-20,-40 --answer temperature=21")
        .succeeds();
    let mut readings = Table::parse(&desk.read("s/readings.csv"));
    readings.set(readings.len() - 1, "displacement_um", &999);
    desk.write("s/readings.csv", &readings.text());
    let data = desk.data("report s --trust-csv --no-diagnosis");
    let marks: Vec<&str> = data["marks"]
        .list()
        .iter()
        .filter_map(Value::as_str)
        .collect();
    assert!(marks.contains(&"NOT PROTECTED"), "{marks:?}");
}

#[test]
fn what_states_nothing_is_refused() {
    let desk = desk_with_report("");
    let schema = "schema = \"stiffbench/report-details/1\"\n";
    for (details, part) in [
        ("[laboratory]\nname = \" \"\n", "`laboratory.name` is empty"),
        ("title = \"\"\n", "`title` is empty"),
        ("[item]\nreceived = 07:32:00\n", "expected a date or a text"),
    ] {
        desk.write("report.toml", &format!("{schema}{details}"));
        let code = "stiffbench::report::details";
        let error = desk.refusal(
            "report session --details report.toml --out new.html",
            10,
            code,
        );
        assert_output_contains(&error, &[part]);
    }
    let mut command = desk.command("report session --out new.html");
    let empty = Ran::of(command.args(["--amends", "", "--reason", ""]));
    assert_eq!(empty.code, 2, "{}", empty.stderr);
    assert!(!desk.path("new.html").exists());
}
