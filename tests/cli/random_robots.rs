//! Random robots through the commands: what `robot check` likes can be simulated and fitted, and the intervals hold the truth.

use std::fmt::Write;

use super::desk;
use crate::support::Json;

/// Sections of beams.
const SECTIONS: [&str; 5] = [
    "box 120x80x5 aluminium",
    "tube 90x6",
    "round 60 titanium",
    "IPE 200",
    "bar 80x40 aluminium",
];

/// Tables of load cases of each robot, each with noise of its own.
const TABLES: u64 = 4;

/// Random numbers of a seed (`SplitMix64`).
struct Random(u64);

impl Random {
    /// Evenly distributed from 0 to 1.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    fn is(&mut self, probability: f64) -> bool {
        self.share() < probability
    }

    fn below(&mut self, count: usize) -> usize {
        (self.share() * count as f64) as usize
    }

    /// A point between the ends of its third coordinate, mm.
    fn at_mm(&mut self, low: f64, high: f64) -> [f64; 3] {
        [(-150.0, 150.0), (-150.0, 150.0), (low, high)]
            .map(|(low, high)| self.between(low, high).round())
    }
}

/// A robot file, and the compliance of each spring that is to be found, rad/(N·m) or m/N.
struct RandomRobot {
    text: String,
    springs: Vec<(String, f64)>,
}

impl RandomRobot {
    /// Hinges and slides, coupled joints, springs across axes, tied springs, a branch, beams, and springs of tool and base.
    fn new(seed: u64) -> Self {
        let mut random = Random(seed);
        let count = 2 + random.below(5);
        let mut text =
            format!("schema = \"stiffbench/robot/2\"\nname = \"random {seed}\"\nup = \"z\"\n");
        text.push_str("[joints]\n");
        let (mut springs, mut hinges) = (Vec::new(), Vec::<String>::new());
        for number in 1..=count {
            let name = format!("J{number}");
            let axis = if seed.is_multiple_of(3) {
                format!("\"{}\"", ["x", "y", "z"][random.below(3)])
            } else {
                format!("{:?}", [0; 3].map(|_| random.between(0.1, 1.0)))
            };
            let at_mm = random.at_mm(150.0, 500.0);
            let mut keys = format!("at_mm = {at_mm:?}, axis = {axis}");
            if random.is(0.25) {
                let n_per_um = random.between(5.0, 100.0);
                let bearing = ["fixed", "moving"][random.below(2)];
                let _ = write!(
                    keys,
                    ", kind = \"sliding\", bearing = \"{bearing}\", min_mm = 0, max_mm = 400, stiffness_N_per_um = {n_per_um}"
                );
                springs.push((format!("joint.{name}.along"), 1e-6 / n_per_um));
            } else {
                keys.push_str(", min_deg = -120, max_deg = 120");
                if !hinges.is_empty() && random.is(0.2) {
                    let other = &hinges[random.below(hinges.len())];
                    let _ = write!(keys, ", spring = \"tied\", tied_to = \"joint.{other}\"");
                } else {
                    let nm_per_rad = 10_f64.powf(random.between(4.5, 6.0));
                    let _ = write!(keys, ", stiffness_Nm_per_rad = {nm_per_rad}");
                    springs.push((format!("joint.{name}"), 1.0 / nm_per_rad));
                    hinges.push(name.clone());
                }
                if random.is(0.3) {
                    keys.push_str(", across = { y = { stiffness_Nm_per_rad = 2e6 } }");
                }
                if hinges.len() > 1 && random.is(0.3) {
                    let _ = write!(keys, ", angle = {{ {} = -1, {name} = 1 }}", hinges[0]);
                }
            }
            if random.is(0.5) {
                let section = SECTIONS[random.below(SECTIONS.len())];
                let _ = write!(keys, ", link = \"{section}\"");
            }
            let _ = writeln!(text, "{name} = {{ {keys} }}");
        }
        if random.is(0.4) {
            let branch = 1 + random.below(count);
            let _ = writeln!(
                text,
                "B1 = {{ on = \"J{branch}\", at_mm = [0, 0, 100], min_deg = -90, max_deg = 90, spring = \"rigid\" }}"
            );
        }
        let at_mm = random.at_mm(150.0, 400.0);
        let _ = writeln!(text, "[tool]\non = \"J{count}\"\nat_mm = {at_mm:?}");
        if random.is(0.3) {
            text.push_str("springs = { x = { stiffness_N_per_um = 20 }, rz = { stiffness_Nm_per_rad = 3e5 } }\n");
        }
        if random.is(0.3) {
            text.push_str("[base]\nsprings = { rx = { stiffness_Nm_per_rad = 2e6 }, z = { stiffness_N_per_um = 300 } }\n");
        }
        Self { text, springs }
    }
}

/// Simulates load cases of random robots, fits their springs, and counts the intervals of 95 %: those that hold the truth, and all.
fn intervals_of(seeds: std::ops::RangeInclusive<u64>) -> [usize; 2] {
    let (mut hold, mut all) = (0, 0);
    for seed in seeds {
        let desk = desk();
        let robot = RandomRobot::new(seed);
        desk.write("robot.toml", &robot.text);
        desk.run("robot check robot.toml").succeeds();
        let free = robot.springs.iter().map(|(name, _)| name.as_str());
        let free = free.collect::<Vec<_>>().join(",");
        for noise in 0..TABLES {
            let seed = TABLES * seed + noise;
            desk.run(&format!(
                "simulate s{noise} --robot robot.toml --load-cases 40 --seed {seed}"
            ))
            .succeeds();
            let fit = desk.data(&format!("fit s{noise} --parameter {free}=free"));
            for (name, truth) in &robot.springs {
                let own = fit["parameters"].named(name);
                // A spring that no load turns has no interval.
                let [Some(low), Some(high)] = [0, 1].map(|end| own["ci95"][end].as_f64()) else {
                    assert_eq!(own["status"], "not_identified", "{}\n{own}", robot.text);
                    continue;
                };
                all += 1;
                hold += usize::from((low..=high).contains(truth));
            }
        }
        desk.data(&format!("diagnose s0 --parameter {free}=free --no-figures"));
    }
    [hold, all]
}

#[test]
fn random_robots_are_simulated_fitted_and_diagnosed() {
    let [hold, all] = intervals_of(1..=3);
    assert!(all >= 20 && hold * 100 >= all * 80, "{hold} of {all}");
}

#[test]
#[ignore = "some minutes; `just nightly` runs it"]
fn intervals_of_forty_random_robots_hold_the_truth() {
    let [hold, all] = intervals_of(1..=40);
    let share = hold as f64 / all as f64;
    assert!((0.93..=0.97).contains(&share), "{hold} of {all}");
}
