//! `stiffbench doctor`: is this computer ready for a session?

use std::io::{IsTerminal, Write};
use std::path::Path;
use std::time::Instant;

use clap::Args;
use jiff::Timestamp;
use jiff::tz::TimeZone;

use crate::instrument::Channel;
use crate::instrument::port::{PortInfo, list_ports, permission_remedy};
use crate::report::{CheckReport, DoctorReport, VERSION};

use super::colour::is_wanted;
use super::config::{Config, unknown_variables};
use super::gauge::open::{BINDINGS_FILE, read_bindings};
use super::locale::{is_utf8, locale};
use super::{Failure, Global, Outcome};

/// Arguments of `doctor`.
#[derive(Debug, Args)]
#[command(
    after_help = "It opens no port and changes nothing. A check that fails makes the exit code 1 under --strict.\n\nExamples:\n  stiffbench doctor\n  stiffbench doctor --json --strict"
)]
pub(super) struct DoctorArgs {}

/// Free space below which a session should not begin, bytes.
const LITTLE_SPACE: u64 = 100_000_000;

/// Time to write a record to the disk above which a session feels slow, ms.
const SLOW_DISK_MS: f64 = 50.0;

/// Records written to measure that time.
const RECORDS: usize = 15;

/// Smallest terminal that the full-screen view fits, columns and lines.
const SMALLEST: (u16, u16) = (80, 24);

/// The first year that a clock can show.
const FIRST_YEAR: i16 = 2025;

/// Runs all checks.
pub(super) fn run(_args: &DoctorArgs, global: &Global) -> Outcome {
    let (configuration, config) = configuration(global);
    let mut checks = vec![version(), clock(), configuration];
    checks.extend(settings(&config, global));
    checks.extend(ports());
    checks.push(bindings(&config));
    checks.extend(terminal(global));
    checks.extend(disk());
    let report = DoctorReport::new(checks);
    let exit = u8::from(report.failed > 0);
    Outcome::new("doctor", report.document(), report).with_strict_exit(exit)
}

fn version() -> CheckReport {
    let parquet = if cfg!(feature = "parquet") {
        ", with Parquet"
    } else {
        ", without Parquet"
    };
    let (system, processor) = (std::env::consts::OS, std::env::consts::ARCH);
    CheckReport::ok(
        "version",
        format!("stiffbench {VERSION}, {system} {processor}{parquet}"),
    )
}

fn clock() -> CheckReport {
    let now = Timestamp::now().to_zoned(TimeZone::UTC);
    let shown = now.strftime("%Y-%m-%d %H:%M UTC").to_string();
    if now.year() < FIRST_YEAR {
        return CheckReport::warning(
            "clock",
            shown,
            "set the clock: readings and calibrations are dated by it",
        );
    }
    CheckReport::ok("clock", shown)
}

/// What is configured; nothing where it cannot be read.
fn configuration(global: &Global) -> (CheckReport, Config) {
    let config = match Config::load(global.no_config) {
        Ok(config) => config,
        Err(error) => {
            let problem = Failure::from(error).message();
            let remedy = "correct the file, or use --no-config";
            let check = CheckReport::failed("configuration", problem, remedy);
            return (check, Config::default());
        }
    };
    let files = config.files.iter().filter(|file| file.exists);
    let files: Vec<String> = files.map(|file| file.path.display().to_string()).collect();
    let found = match files.as_slice() {
        _ if config.ignored => "ignored".to_owned(),
        [] => "no file".to_owned(),
        files => files.join(", "),
    };
    (CheckReport::ok("configuration", found), config)
}

/// What settings name that is not there, and variables that set nothing.
fn settings(config: &Config, global: &Global) -> Vec<CheckReport> {
    let absent = config.absent_files().map(|(setting, set)| {
        let (name, value, place) = (setting.name, &set.value, &set.place);
        let found = format!("{name} {value}, which {place} names, is not there");
        CheckReport::failed("setting", found, "correct the setting, or make the file")
    });
    let mut checks: Vec<CheckReport> = absent.collect();
    if !global.no_config {
        let unknown = unknown_variables().into_iter();
        checks.extend(
            unknown.map(|found| CheckReport::warning("variable", found, "rename it, or unset it")),
        );
    }
    checks
}

/// The serial ports, and whether this user may open each.
fn ports() -> Vec<CheckReport> {
    let ports = match list_ports() {
        Ok(ports) if ports.is_empty() => {
            let remedy = "plug a gauge in; the emulated bench needs none";
            return vec![CheckReport::warning("ports", "no serial port", remedy)];
        }
        Ok(ports) => ports,
        Err(error) => {
            let found = Failure::from(error).message();
            return vec![CheckReport::failed("ports", found, "see the cause")];
        }
    };
    ports.iter().map(port).collect()
}

fn port(port: &PortInfo) -> CheckReport {
    let label = port.label.as_deref().unwrap_or("no USB adapter");
    let found = format!("{} ({label})", port.path);
    if may_open(Path::new(&port.path)) {
        return CheckReport::ok("port", found);
    }
    CheckReport::failed(
        "port",
        format!("{found}: this user may not open it"),
        &permission_remedy(Path::new(&port.path)),
    )
}

#[cfg(unix)]
fn may_open(port: &Path) -> bool {
    use rustix::fs::{Access, access};
    access(port, Access::READ_OK | Access::WRITE_OK).is_ok()
}

#[cfg(not(unix))]
fn may_open(_port: &Path) -> bool {
    true
}

/// The gauges that are bound to adapters.
fn bindings(config: &Config) -> CheckReport {
    let named = config.value("bindings").map(|set| set.value.as_str());
    let path = Path::new(named.unwrap_or(BINDINGS_FILE));
    if !path.exists() {
        return CheckReport::ok("bindings", format!("no {}", path.display()));
    }
    match read_bindings(path) {
        Ok((bindings, _)) => {
            let all = [
                (Channel::Force, &bindings.force),
                (Channel::Displacement, &bindings.displacement),
            ];
            let bound = all.into_iter().filter_map(|(channel, bound)| {
                let instrument = &bound.as_ref()?.instrument;
                Some(format!("{channel}: {instrument}"))
            });
            let bound: Vec<String> = bound.collect();
            CheckReport::ok(
                "bindings",
                format!("{} ({})", path.display(), bound.join(", ")),
            )
        }
        Err(failure) => CheckReport::failed(
            "bindings",
            failure.message(),
            "bind the gauges again: stiffbench gauge bind",
        ),
    }
}

/// Character set, size and colour of the terminal.
fn terminal(global: &Global) -> Vec<CheckReport> {
    let locale = match locale(|name| std::env::var(name).ok()) {
        Some(locale) if is_utf8(&locale) => CheckReport::ok("locale", locale),
        other => CheckReport::warning(
            "locale",
            other.unwrap_or_else(|| "not set".to_owned()),
            "export LANG=C.UTF-8, so that signs such as µ appear",
        ),
    };
    vec![locale, size(global)]
}

fn size(global: &Global) -> CheckReport {
    if !std::io::stdout().is_terminal() || !std::io::stdin().is_terminal() {
        return CheckReport::ok("terminal", "none: sessions use plain lines");
    }
    let colour = if is_wanted(global.color, true) {
        "with colour"
    } else {
        "without colour"
    };
    if std::env::var("TERM").is_ok_and(|term| term == "dumb") {
        return CheckReport::warning(
            "terminal",
            "TERM=dumb",
            "use another terminal, or session run --line",
        );
    }
    match crossterm::terminal::size() {
        Ok((columns, lines)) if columns < SMALLEST.0 || lines < SMALLEST.1 => CheckReport::warning(
            "terminal",
            format!("{columns} x {lines}"),
            "enlarge it to 80 x 24 or more, or use session run --line",
        ),
        Ok((columns, lines)) => {
            CheckReport::ok("terminal", format!("{columns} x {lines}, {colour}"))
        }
        Err(error) => CheckReport::warning("terminal", error.to_string(), "use session run --line"),
    }
}

/// Free space, and how long a record takes to the disk.
fn disk() -> Vec<CheckReport> {
    let mut checks: Vec<CheckReport> = free_bytes().map(space).into_iter().collect();
    checks.push(match record_ms() {
        Ok(ms) if ms > SLOW_DISK_MS => CheckReport::warning(
            "disk",
            format!("{ms:.1} ms for a record"),
            "measure on a local disk; a network folder or card slows every reading",
        ),
        Ok(ms) => CheckReport::ok("disk", format!("{ms:.1} ms for a record")),
        Err(error) => CheckReport::failed(
            "disk",
            format!("the current folder cannot be written: {error}"),
            "change to a folder that may be written to",
        ),
    });
    checks
}

fn space(free: u64) -> CheckReport {
    let found = format!("{:.1} GB free", free as f64 * 1e-9);
    if free < LITTLE_SPACE {
        return CheckReport::failed(
            "space",
            found,
            "make room: a session needs a few MB, its traces more",
        );
    }
    CheckReport::ok("space", found)
}

/// Free space in the current folder, bytes; `None` where the system does not state it.
#[cfg(unix)]
fn free_bytes() -> Option<u64> {
    let found = rustix::fs::statvfs(".").ok()?;
    Some(found.f_bavail * found.f_frsize)
}

#[cfg(not(unix))]
fn free_bytes() -> Option<u64> {
    None
}

/// Median time of writing a record and waiting until it is on the disk, ms.
fn record_ms() -> std::io::Result<f64> {
    let mut file = tempfile::tempfile_in(".")?;
    let mut times = Vec::new();
    for _ in 0..RECORDS {
        let begun = Instant::now();
        file.write_all(&[b'.'; 400])?;
        file.sync_data()?;
        times.push(begun.elapsed().as_secs_f64() * 1e3);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[RECORDS / 2])
}
