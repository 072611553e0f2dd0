//! An emulated bench in a process of its own, read through its ports by plain serialport.

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use serialport::TTYPort;

use super::{Desk, desk};
use crate::support::{Contains, Json};

/// How long a test waits for what must come.
const PATIENCE: Duration = Duration::from_secs(30);

/// A running bench and what it says.
struct Bench {
    process: Child,
    output: BufReader<ChildStdout>,
    force: TTYPort,
    displacement: TTYPort,
}

impl Bench {
    fn new(desk: &Desk, arguments: &str) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_stiffbench"))
            .current_dir(&desk.folder)
            .args(["gauge", "emulate", "--link", "ports", "--stay"])
            .args(arguments.split_whitespace())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
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
            output,
            force,
            displacement,
        }
    }

    /// Force in N and displacement in µm of each load, as the bench says them, by what stands before them.
    fn loads(&mut self) -> Vec<(String, [f64; 2])> {
        let mut loads = Vec::new();
        loop {
            let line = read_line(&mut self.output);
            if line == "end" {
                return loads;
            }
            let (place, values) = line.split_once(": ").unwrap();
            let words: Vec<&str> = values.split_whitespace().collect();
            let [force_n, "N", displacement_um, "µm"] = words[..] else {
                panic!("{line}");
            };
            let values = [force_n, displacement_um].map(|word| word.parse().unwrap());
            loads.push((place.to_owned(), values));
        }
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
fn the_bench_follows_the_procedure_with_the_compliance_of_the_robot() {
    let desk = desk();
    let data = desk.data("robot compliance --pose P3");
    let mut bench = Bench::new(
        &desk,
        "--noise-free --poses P3 --loads-n 0,-70 --repeats 1 --speed 200",
    );
    let loads = bench.loads();
    assert_eq!(loads.len(), 6);
    for (i, direction) in ["x", "y", "z"].into_iter().enumerate() {
        let at = |step: usize| {
            let place = format!("P3 {direction} run 1 step {step}");
            loads.iter().find(|(known, _)| *known == place).unwrap().1
        };
        let ([from_n, from_um], [to_n, to_um]) = (at(1), at(2));
        // The operator stops within 0.4 N.
        assert!((to_n + 70.0).abs() < 0.41, "{to_n}");
        let expected_um = 1e6 * data["compliance"][i][i].number() * (to_n - from_n);
        assert!(
            ((to_um - from_um) / expected_um - 1.0).abs() < 1e-4,
            "{direction}: {from_um} to {to_um} um, {expected_um} um expected"
        );
    }
    // The load is off and the force gauge was zeroed without it.
    assert_eq!(bench.shown().0, 0.0);
}

#[test]
fn the_gauges_show_the_load_while_it_is_on() {
    let desk = desk();
    let mut bench = Bench::new(
        &desk,
        "--noise-free --poses P1 --directions z --loads-n 0,-60 --repeats 1 --speed 20",
    );
    let began = Instant::now();
    loop {
        let (newtons, millimetres) = bench.shown();
        // 60 N of pressure push the end 0.3 mm.
        if newtons > 59.0 && millimetres < -0.2 {
            break;
        }
        assert!(began.elapsed() < PATIENCE, "{newtons} N, {millimetres} mm");
    }
}

#[test]
fn the_same_seed_shows_the_same_in_another_process() {
    let loads = [(); 2].map(|()| {
        let plan = "--seed 11 --poses P4 --directions y --loads-n 0,-40 --repeats 2 --speed 200";
        Bench::new(&desk(), plan).loads()
    });
    assert_eq!(loads[0], loads[1]);
}

#[test]
fn it_ends_after_the_last_load_and_takes_its_ports_along() {
    let desk = desk();
    desk.write("faults.toml", "schema = \"stiffbench/faults/1\"\n");
    let ran = desk
        .run("gauge emulate --link ports --faults faults.toml --poses P1 --directions x --loads-n 0,-10 --repeats 1 --speed 100 --json")
        .succeeds();
    ran.stderr.must_contain(&["P1 x run 1 step 1: "]);
    let data = &ran.json()["data"];
    assert!(data["ports"]["force"].word().ends_with("force"));
    assert_eq!(desk.path("ports").read_dir().unwrap().count(), 0);
}

#[test]
fn a_signal_ends_it_and_takes_its_links_away() {
    use std::os::unix::process::ExitStatusExt;

    let desk = desk();
    let mut bench = Bench::new(
        &desk,
        "--poses P1 --directions x --loads-n 0,-10 --repeats 1",
    );
    let links = ["ports/force", "ports/displacement"].map(|link| desk.path(link));
    assert!(links.iter().all(|link| link.is_symlink()));
    let id = bench.process.id().to_string();
    let stopped = Command::new("kill").args(["-TERM", &id]).status().unwrap();
    assert!(stopped.success());
    assert_eq!(bench.process.wait().unwrap().signal(), Some(15));
    assert!(links.iter().all(|link| !link.is_symlink()));
}
