//! An emulated bench in a process of its own: worked by lines, read through its ports by plain serialport.

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use serialport::TTYPort;

use super::{Desk, desk};

/// How long a test waits for what must come.
const PATIENCE: Duration = Duration::from_secs(30);

/// A running bench and the lines to it.
struct Bench {
    process: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    force: TTYPort,
    displacement: TTYPort,
}

impl Bench {
    fn new(desk: &Desk, arguments: &str) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_stiffbench"))
            .current_dir(&desk.folder)
            .args(["emulate", "--link", "ports", "--speed", "100"])
            .args(arguments.split_whitespace())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let input = process.stdin.take().unwrap();
        let mut output = BufReader::new(process.stdout.take().unwrap());
        while read_line(&mut output) != "ready" {}
        let port = |name: &str| {
            let path = desk.path("ports").join(name);
            let builder = serialport::new(path.to_str().unwrap(), 9600);
            builder
                .timeout(Duration::from_millis(10))
                .open_native()
                .unwrap()
        };
        let [force, displacement] = ["force", "displacement"].map(port);
        Self {
            process,
            input,
            output,
            force,
            displacement,
        }
    }

    /// What a line is answered.
    fn answer(&mut self, command: &str) -> String {
        writeln!(self.input, "{command}").unwrap();
        read_line(&mut self.output)
    }

    fn tell(&mut self, command: &str) {
        assert_eq!(self.answer(command), "ok", "{command}");
    }

    /// What a Mark-10 and a Mitutoyo show, N (compression positive) and mm.
    fn shown(&mut self) -> (f64, f64) {
        let force = ask(&mut self.force, b"?C\r", "\r\n");
        let displacement = ask(&mut self.displacement, b"1\r", "\r");
        let newtons = force.strip_suffix(" N").unwrap().parse().unwrap();
        let millimetres = displacement.strip_prefix("01A").unwrap().parse().unwrap();
        (newtons, millimetres)
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn read_line(output: &mut impl BufRead) -> String {
    let mut line = String::new();
    assert_ne!(
        output.read_line(&mut line).unwrap(),
        0,
        "the bench has ended"
    );
    line.trim_end().to_owned()
}

fn ask(port: &mut TTYPort, command: &[u8], end: &str) -> String {
    port.write_all(command).unwrap();
    let since = Instant::now();
    let mut text = String::new();
    while !text.ends_with(end) {
        let mut bytes = [0; 64];
        match port.read(&mut bytes) {
            Ok(count) => text.push_str(std::str::from_utf8(&bytes[..count]).unwrap()),
            Err(error) => assert_eq!(error.kind(), ErrorKind::TimedOut, "{error}"),
        }
        assert!(since.elapsed() < PATIENCE, "only {text:?} came");
    }
    text.trim_end().to_owned()
}

#[test]
fn the_gauges_show_the_compliance_of_the_robot() {
    let desk = desk();
    let data = desk.data("robot compliance --pose P3");
    let mut bench = Bench::new(&desk, "--noise-free --procedure paper");
    bench.tell("pose P3");
    for (i, direction) in ["x", "y", "z"].into_iter().enumerate() {
        bench.tell(&format!("direction {direction}"));
        bench.tell("wait");
        bench.tell("zero displacement");
        bench.tell("apply -70 7 2");
        bench.tell("wait");
        let (newtons, millimetres) = bench.shown();
        // The operator stops within 0.4 N, and the gauge shows tenths.
        assert!((newtons - 70.0).abs() < 0.46, "{newtons}");
        let compliance_m_per_n = data["compliance"][i][i].as_f64().unwrap();
        let expected_mm = -1000.0 * compliance_m_per_n * newtons;
        // Half a step of either gauge.
        let steps_mm = 0.0006 + 1000.0 * compliance_m_per_n * 0.051;
        assert!(
            (millimetres - expected_mm).abs() < steps_mm,
            "{direction}: {millimetres} mm, {expected_mm} mm expected"
        );
    }
}

#[test]
fn the_same_seed_shows_the_same_in_another_process() {
    let shown = [(); 2].map(|()| {
        let desk = desk();
        let mut bench = Bench::new(&desk, "--seed 11 --poses P2,P4");
        bench.tell("pose P4");
        bench.tell("run 2");
        // A zero belongs to a gauge at rest.
        bench.tell("wait");
        bench.tell("zero displacement");
        bench.tell("apply -40 4 2");
        bench.tell("wait");
        bench.shown()
    });
    assert_eq!(shown[0], shown[1]);
}

#[test]
fn lines_that_mean_nothing_are_answered_and_the_bench_goes_on() {
    let desk = desk();
    let mut bench = Bench::new(&desk, "--noise-free");
    for (command, part) in [
        ("hello", "is no command"),
        ("pose P9", "no pose P9"),
        ("direction w", "not a direction"),
        ("apply much", "much"),
        ("apply nan", "is no load"),
        ("zero spring", "is no gauge"),
        ("unit force mm", "no unit mm"),
        ("fault force nonsense", "no fault nonsense"),
    ] {
        let answer = bench.answer(command);
        assert!(
            answer.starts_with("wrong: ") && answer.contains(part),
            "{answer}"
        );
    }
    bench.tell("push force -");
    assert_eq!(bench.shown().0, 8.0);
    bench.tell("let-go");
    bench.tell("fault force nul");
    assert!(bench.answer("state").starts_with("0.0000 N"));
}

#[test]
fn a_gauge_that_is_turned_round_counts_the_other_way() {
    let desk = desk();
    let mut bench = Bench::new(&desk, "--noise-free --turned force,displacement");
    bench.tell("zero displacement");
    bench.tell("push force -");
    assert_eq!(bench.shown(), (-8.0, 0.0));
    bench.tell("push displacement -");
    assert_eq!(bench.shown(), (-8.0, 0.15));
    bench.tell("let-go");
    bench.tell("push -10");
    // A hand pushes a quarter more than it is asked for.
    assert_eq!(bench.shown(), (-12.5, 0.15));
}

#[test]
fn it_ends_with_its_input_and_takes_its_ports_along() {
    let desk = desk();
    desk.write("faults.toml", "schema = \"stiffbench/faults/1\"\n");
    let ran = desk
        .run("emulate --link ports --faults faults.toml --json")
        .succeeds();
    let data = &ran.json()["data"];
    assert!(data["ports"]["force"].as_str().unwrap().ends_with("force"));
    assert_eq!(desk.path("ports").read_dir().unwrap().count(), 0);
}

#[test]
fn what_cannot_be_emulated_is_refused() {
    let desk = desk();
    desk.write(
        "faults.toml",
        "schema = \"stiffbench/faults/1\"\n[[fault]]\nwhat = \"nulls\"\n",
    );
    for (arguments, code, part) in [
        (
            "emulate --force mark10-series6",
            2,
            "did you mean mark10-series5",
        ),
        ("emulate --force mitutoyo-01a", 2, "measures displacement"),
        ("emulate --faults faults.toml", 11, "no fault nulls"),
        ("emulate --faults none.toml", 11, "none.toml"),
        ("emulate --poses P9", 10, "P9"),
    ] {
        let ran = desk.run(arguments).exits_with(code);
        assert!(ran.stderr.contains(part), "{arguments}: {}", ran.stderr);
    }
}
