//! A session on an emulated bench: its ports, its hand, and what somebody there would answer.

use std::path::Path;

use crate::analysis::{ArgumentError, ResolvedModel};
use crate::cli::failure::Failure;
use crate::cli::model::effects_text;
use crate::clock::Clock;
use crate::instrument::Channel;
use crate::physics::ActingPhysics;
use crate::procedure::Procedure;
use crate::readings::{InstrumentRecord, Instruments, SessionHeader};
use crate::session::{Answers, Operator, SessionPlan};

use super::args::{BenchArgs, EmulationArgs, StatedGauge};
use super::gauges::record_of;
use super::prepare::robot_of;

#[cfg(unix)]
pub(super) use crate::cli::emulated::BenchOperator;

/// There are no emulated benches on this system.
#[cfg(not(unix))]
pub(super) enum BenchOperator {}

/// Gauges of an emulated bench where none are named: units in every packet, a zero command each.
#[cfg(unix)]
const GAUGES: [&str; 2] = ["mark10-series5", "mahr-dk-u1"];

/// Session seconds in a real one.
pub(super) fn speed(args: &BenchArgs) -> f64 {
    args.emulation.speed.max(1.0)
}

/// Refuses effects where the bench is a real one.
pub(super) fn check_effects(args: &BenchArgs, resolved: &ResolvedModel) -> Result<(), Failure> {
    if args.emulation.emulated || resolved.physics.effects.is_empty() {
        return Ok(());
    }
    ArgumentError::refuse(
        "--effect, --model",
        "effects act on an emulated bench only",
        "add --emulated, or leave them out",
    )
}

/// Starts an emulated bench if one is asked for, and puts its ports in the place of real ones.
///
/// # Arguments
/// - `begun_with`: the records that the session was begun with, for resuming.
#[cfg(unix)]
pub(super) fn emulate(
    args: &mut BenchArgs,
    resolved: &ResolvedModel,
    procedure: &Procedure,
    begun_with: &Instruments,
    clock: Clock,
) -> Result<Option<BenchOperator>, Failure> {
    use crate::bench::EmulatedSetup;
    use crate::cli::emulated::Emulation;
    use crate::cli::gauge::descriptions::find_description;
    use crate::cli::rehearsal::unit_in_use;
    use crate::instrument::emulator::FaultScript;

    if !args.emulation.emulated {
        return Ok(None);
    }
    let channels = SessionPlan::new(procedure, &[]).channels();
    let instruments = channels.iter().map(|channel| {
        let usual = GAUGES[usize::from(channel.is_displacement())];
        let record = record_of(begun_with, *channel);
        let before = record.and_then(InstrumentRecord::description_name);
        let named = args.of(*channel).instrument;
        let named = named.unwrap_or_else(|| before.unwrap_or(usual).to_owned());
        (*channel, named)
    });
    let instruments: Vec<(Channel, String)> = instruments.collect();
    let hand = Emulation {
        resolved,
        procedure,
        gauges: instruments.clone(),
        protocols: &args.protocols,
        setup: EmulatedSetup {
            seed: args.emulation.seed,
            ..EmulatedSetup::default()
        },
        session: clock,
        faults: FaultScript::default(),
        links: None,
    }
    .start()?;
    for (channel, name) in instruments {
        let stated = StatedGauge {
            port: Some(hand.port(channel).display().to_string()),
            unit: unit_in_use(&find_description(&name, &args.protocols)?.description),
            instrument: Some(name),
        };
        args.emulated_gauges.push((channel, stated));
    }
    // Nothing is measured, so nothing can be measured wrongly.
    args.allow_unverified = true;
    Ok(Some(hand))
}

/// There are no emulated benches on this system.
#[cfg(not(unix))]
pub(super) fn emulate(
    _args: &mut BenchArgs,
    _chosen: &ResolvedModel,
    _procedure: &Procedure,
    _begun_with: &Instruments,
    _clock: Clock,
) -> Result<Option<BenchOperator>, Failure> {
    Ok(None)
}

/// The emulated bench of a session that goes on: its robot, its mechanism, its gauges.
pub(super) fn emulate_again(
    args: &mut BenchArgs,
    header: &SessionHeader,
    folder: &Path,
    plan: &SessionPlan,
    clock: Clock,
) -> Result<Option<BenchOperator>, Failure> {
    if !args.emulation.emulated {
        return Ok(None);
    }
    if let Some((seed, _)) = header.origin.as_deref().and_then(emulated_before) {
        args.emulation.seed = seed;
    }
    let model = robot_of(header, folder, plan)?;
    emulate(args, &model, &plan.procedure, &header.instruments, clock)
}

/// What the mark of emulated readings begins with, before the seed.
const EMULATED: &str = "emulated gauges; seed ";

/// The mark of readings that nobody measures; `None` at a real bench.
pub(super) fn origin(args: &BenchArgs, physics: &ActingPhysics) -> Option<String> {
    let EmulationArgs { emulated, seed, .. } = args.emulation;
    let effects = effects_text(physics);
    emulated.then(|| format!("{EMULATED}{seed}; {effects}"))
}

/// Seed and effects of an emulated session, from its mark (see [`origin`]): it goes on with the same bench.
pub(super) fn emulated_before(origin: &str) -> Option<(u64, Vec<String>)> {
    let (seed, effects) = origin.strip_prefix(EMULATED)?.split_once("; ")?;
    let effects = effects.strip_prefix("effects ").into_iter();
    let effects = effects.flat_map(|all| all.split("; ")).map(str::to_owned);
    Some((seed.parse().ok()?, effects.collect()))
}

/// Refuses to go on with measured readings by emulated ones, or the other way round.
pub(super) fn refuse_mixture(
    args: &BenchArgs,
    header: &SessionHeader,
) -> Result<(), ArgumentError> {
    let (problem, help) = match (args.emulation.emulated, &header.origin) {
        (true, None) => (
            "the readings of this session were measured; emulated ones would be mixed with them",
            "resume it without --emulated, at its bench",
        ),
        (false, Some(_)) => (
            "the readings of this session are marked as emulated, and measured ones would bear that mark too",
            "resume it with --emulated, or begin a session at the bench",
        ),
        (true, Some(_)) | (false, None) => return Ok(()),
    };
    Err(ArgumentError::new("--emulated", problem, help))
}

/// What somebody at an emulated bench would answer who does what is asked for.
pub(super) fn of_a_hand(plan: &SessionPlan) -> Result<Answers, Failure> {
    let way = if plan.procedure.load_sense() < 0.0 {
        "minus"
    } else {
        "plus"
    };
    let mut answers = Answers::default();
    for answer in [
        "ready=true",
        "setup=true",
        "unit=same",
        "humidity=",
        "bench-note=",
        "temperature-end=",
        "humidity-end=",
        "bench-note-end=",
        &format!("sign-check={way}"),
    ] {
        answers.take_argument(answer)?;
    }
    Ok(answers)
}

/// Runs something with an operator whose hand turns the jack of an emulated bench.
pub(super) fn with_hand<T>(
    operator: &mut dyn Operator,
    hand: Option<&BenchOperator>,
    run: impl FnOnce(&mut dyn Operator) -> T,
) -> T {
    #[cfg(unix)]
    if let Some(hand) = hand {
        let mut helping = crate::cli::rehearsal::SimulatedOperator::new(operator, hand);
        return run(&mut helping);
    }
    #[cfg(not(unix))]
    let _ = hand;
    run(operator)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_of_an_emulated_session_says_what_was_emulated() {
        let none = emulated_before("emulated gauges; seed 7; no effects beside the beams");
        assert_eq!(none, Some((7, Vec::new())));
        let two = emulated_before(
            "emulated gauges; seed 0; effects thermal-drift@clock:rate=1e-7 m/s; joint-backlash@A3:play=3e-5 rad,seat_moment=9.0 N*m",
        );
        let (seed, effects) = two.unwrap_or_default();
        assert_eq!(seed, 0);
        assert_eq!(effects.len(), 2);
        for effect in effects {
            assert!(effect.parse::<crate::physics::Effect>().is_ok(), "{effect}");
        }
        assert_eq!(emulated_before("simulated; seed 7; noise"), None);
    }
}
