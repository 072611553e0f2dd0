//! Emulated gauges behind pseudo-terminals, opened by name through plain serialport: what they answer, and what faults make of it.

#![cfg(unix)]
use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serialport::TTYPort;
use stiffbench_gauges::Channel;
use stiffbench_gauges::emulator::{
    EmulatedGauge, EmulatedLine, FaultScript, HostOptions, PanelAction, PtyHost, ScriptedFault,
};
use tempfile::TempDir;

use crate::support::shipped_instrument;

/// How long a test waits for what must come; nothing is asserted of how soon it does.
const PATIENCE: Duration = Duration::from_secs(20);

/// 12.3 N of compression and 0.415 mm, on a Mark-10 and a Mitutoyo, by links in a folder.
struct Bench {
    folder: TempDir,
    host: PtyHost,
}

impl Bench {
    fn new(faults: &str) -> Self {
        let folder = TempDir::new().unwrap();
        let text = format!("schema = \"stiffbench/faults/1\"\n{faults}");
        let source = stiffbench_units_and_text::source_text::SourceText::new("faults", text);
        let options = HostOptions {
            links: Some(folder.path().to_owned()),
            faults: FaultScript::parse(&source).unwrap(),
            ..HostOptions::default()
        };
        let host = PtyHost::start(lines(), options).unwrap();
        Self { folder, host }
    }

    fn open(&self, channel: Channel) -> TTYPort {
        open(&self.folder.path().join(channel.to_string()))
    }

    fn fail(&self, line: &str) {
        self.host.fail(fault(line));
    }
}

fn lines() -> Vec<EmulatedLine> {
    let [force, displacement] = ["mark10-series5", "mitutoyo-01a"].map(shipped_instrument);
    vec![
        EmulatedLine::new(EmulatedGauge::described(&force, Arc::new(|| -12.3))),
        EmulatedLine::new(EmulatedGauge::described(
            &displacement,
            Arc::new(|| 0.000_415),
        )),
    ]
}

fn fault(line: &str) -> ScriptedFault {
    FaultScript::parse_line(line).unwrap()
}

/// Opens a port as soon as it can be.
fn open(path: &Path) -> TTYPort {
    let since = Instant::now();
    loop {
        let builder = serialport::new(path.to_str().unwrap(), 9600);
        match builder.timeout(Duration::from_millis(5)).open_native() {
            Ok(port) => return port,
            Err(error) => assert!(since.elapsed() < PATIENCE, "{}: {error}", path.display()),
        }
    }
}

/// What comes until `end`.
fn read_until(port: &mut TTYPort, end: &[u8]) -> Vec<u8> {
    let since = Instant::now();
    let mut got = Vec::new();
    while !got.ends_with(end) {
        let mut bytes = [0; 64];
        match port.read(&mut bytes) {
            Ok(count) => got.extend(&bytes[..count]),
            Err(error) if error.kind() == ErrorKind::TimedOut => {}
            Err(error) => panic!("{error}, after {got:?}"),
        }
        let text = String::from_utf8_lossy(&got);
        assert!(since.elapsed() < PATIENCE, "only {text:?} came");
    }
    got
}

fn ask(port: &mut TTYPort, command: &[u8], end: &[u8]) -> String {
    port.write_all(command).unwrap();
    String::from_utf8_lossy(&read_until(port, end)).into_owned()
}

/// Reads until the line is gone.
fn wait_for_the_end(port: &mut TTYPort) {
    let since = Instant::now();
    let mut bytes = [0; 64];
    loop {
        match port.read(&mut bytes) {
            Ok(0) => return,
            Err(error) if error.kind() != ErrorKind::TimedOut => return,
            _ => assert!(since.elapsed() < PATIENCE, "the line is still there"),
        }
    }
}

#[test]
fn gauges_answer_by_name() {
    let bench = Bench::new("");
    let mut force = bench.open(Channel::Force);
    let mut displacement = bench.open(Channel::Displacement);
    for _ in 0..3 {
        assert_eq!(ask(&mut force, b"?C\r", b"\n"), "12.3 N\r\n");
        assert_eq!(ask(&mut displacement, b"1\r", b"\r"), "01A+0000.415\r");
    }
    assert_eq!(bench.host.packets_sent(Channel::Force), 3);
}

#[test]
fn a_port_can_be_opened_again_and_a_second_program_is_refused() {
    let bench = Bench::new("");
    for _ in 0..5 {
        let mut force = bench.open(Channel::Force);
        assert_eq!(ask(&mut force, b"?C\r", b"\n"), "12.3 N\r\n");
        let path = bench.host.port(Channel::Force).unwrap();
        let second = serialport::new(path.to_str().unwrap(), 9600).open_native();
        assert!(second.is_err());
    }
}

#[test]
fn without_links_the_terminals_have_their_own_names() {
    let host = PtyHost::start(lines(), HostOptions::default()).unwrap();
    let [force, displacement] = Channel::ALL.map(|channel| host.port(channel).unwrap());
    assert_ne!(force, displacement);
    assert_eq!(ask(&mut open(&force), b"?C\r", b"\n"), "12.3 N\r\n");
}

#[test]
fn a_stream_comes_without_being_asked_for_again() {
    let bench = Bench::new("");
    let mut force = bench.open(Channel::Force);
    force.write_all(b"AOUT10\r").unwrap();
    let mut got = Vec::new();
    while got.len() < 10 * "12.3 N\r\n".len() {
        got.extend(read_until(&mut force, b"\n"));
    }
    let text = String::from_utf8(got).unwrap();
    assert!(text.split_terminator("\r\n").all(|line| line == "12.3 N"));
}

#[test]
fn an_unplugged_line_ends_and_comes_back_under_its_name() {
    let bench = Bench::new("");
    let mut force = bench.open(Channel::Force);
    ask(&mut force, b"Z\r?C\r", b"\n");
    bench.fail("force unplug for_s=0.1");
    wait_for_the_end(&mut force);
    drop(force);
    // The gauge itself was on all the time.
    assert_eq!(
        ask(&mut bench.open(Channel::Force), b"?C\r", b"\n"),
        "0.0 N\r\n"
    );
}

#[test]
fn swapped_adapters_come_back_under_each_others_name() {
    let bench = Bench::new("");
    let mut force = bench.open(Channel::Force);
    let mut displacement = bench.open(Channel::Displacement);
    bench.fail("both swap for_s=0");
    wait_for_the_end(&mut force);
    wait_for_the_end(&mut displacement);
    drop((force, displacement));
    assert_eq!(
        ask(&mut bench.open(Channel::Force), b"1\r", b"\r"),
        "01A+0000.415\r"
    );
    assert_eq!(
        ask(&mut bench.open(Channel::Displacement), b"?C\r", b"\n"),
        "12.3 N\r\n"
    );
}

#[test]
fn a_suspended_machine_answers_afterwards() {
    let bench = Bench::new("[[fault]]\nwhat = \"suspend\"\nphase = \"lid\"\nfor_s = 0.3\n");
    let mut force = bench.open(Channel::Force);
    // Before the lid is shut: a thread may lose its turn anywhere.
    let since = Instant::now();
    bench.host.phase("lid");
    assert_eq!(ask(&mut force, b"?C\r", b"\n"), "12.3 N\r\n");
    assert!(since.elapsed() >= Duration::from_millis(290));
}

#[test]
fn scripted_faults_hit_the_packet_and_the_load_they_name() {
    let bench = Bench::new(
        "[[fault]]\ngauge = \"force\"\nwhat = \"garbage\"\nbytes = \"23\"\npacket = 2\n\
         [[fault]]\ngauge = \"displacement\"\nwhat = \"tool-off\"\nreading = 2\nfor_s = 0.05\n",
    );
    let mut force = bench.open(Channel::Force);
    let answers: Vec<String> = (0..3).map(|_| ask(&mut force, b"?C\r", b"\n")).collect();
    assert_eq!(answers, ["12.3 N\r\n", "#12.3 N\r\n", "12.3 N\r\n"]);
    let mut displacement = bench.open(Channel::Displacement);
    bench.host.reading();
    assert_eq!(ask(&mut displacement, b"1\r", b"\r"), "01A+0000.415\r");
    bench.host.reading();
    assert_eq!(ask(&mut displacement, b"1\r", b"\r"), "901\r");
    let since = Instant::now();
    while ask(&mut displacement, b"1\r", b"\r") == "901\r" {
        assert!(since.elapsed() < PATIENCE, "it does not end");
    }
}

#[test]
fn panel_actions_change_what_is_sent() {
    let bench = Bench::new("");
    let mut force = bench.open(Channel::Force);
    let press = |panel| bench.host.press(Channel::Force, &panel);
    press(PanelAction::Unit("kN".into())).unwrap();
    assert_eq!(ask(&mut force, b"?C\r", b"\n"), "0.0123 kN\r\n");
    assert!(press(PanelAction::Unit("mm".into())).is_err());
    press(PanelAction::DataKey).unwrap();
    assert_eq!(read_until(&mut force, b"\n"), b"0.0123 kN\r\n");
}

#[test]
fn lines_and_links_go_with_the_host() {
    let bench = Bench::new("");
    let mut force = bench.open(Channel::Force);
    let Bench { folder, host } = bench;
    drop(host);
    wait_for_the_end(&mut force);
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}

#[test]
fn the_documented_script_is_one() {
    let page = "crates/gauges/fault-script.md";
    let (text, example) = (
        stiffbench_test_files::text(page),
        stiffbench_test_files::example(page, "toml"),
    );
    let source = stiffbench_units_and_text::source_text::SourceText::new("docs", example);
    assert_eq!(FaultScript::parse(&source).unwrap().faults.len(), 4);
    // Every fault has its line in the table.
    let words = text.lines().filter_map(|line| line.strip_prefix("| `"));
    let words = words.filter_map(|line| line.split('`').next());
    let known = words.filter(|word| FaultScript::parse_line(&format!("both {word} ")).is_ok());
    // `unit` needs to know which.
    assert_eq!(known.count(), 19);
}
