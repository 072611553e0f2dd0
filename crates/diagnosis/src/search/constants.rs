//! Numbers that several files of the search share, with unit, meaning, and what set them. Each other number stands in the file that uses it.
//!
//! Five kinds of origin are distinguished, here and there:
//!
//! - **stated**: part of what the search promises;
//! - **source**: a book or paper;
//! - **by hand**: chosen by hand on simulated benches (`stiffbench-validate prove --only errors`, `--only calibration`, `--only concealed`), in
//!   the commit given; where a trial was counted, its seed and result are those of the table in `CHANGELOG.md`;
//! - **by judgement**: set in the commit given, which states no trial; where `docs/method.md`, section 11, lists it, it was counted afterwards;
//! - **numerics**: rounding, work or memory; no verdict depends on it beyond its tolerance.
//!
//! What half and twice a number changes on sessions with known answers is the table of `docs/method.md`, section 11; a test holds its values to
//! those of the code. Numbers that belong to one physical law stand in the file of the law.

// Level and critical values.

/// Chance that noise alone passes for one of the laws (1). Stated: together with `OMNIBUS_LEVEL` 4 %.
pub const LAW_LEVEL: f64 = 0.03;

/// Chance that noise alone passes for unexplained structure (1). Stated.
pub(crate) const OMNIBUS_LEVEL: f64 = 0.01;

/// The same for the largest pattern, half of `OMNIBUS_LEVEL` (1). Stated.
pub const UNEXPLAINED_LEVEL: f64 = 0.5 * OMNIBUS_LEVEL;

/// Share of the misfit, in the readings and in those left out, that names must explain to be most of the answer (1). Stated.
pub(crate) const MOST_OF_THE_MISFIT: f64 = 0.75;

/// Null samples (1). The critical value at 0.5 % then rests on 50 samples: a standard error of 14 % of that level. By hand (750d6b5).
pub const NULL_SAMPLES: usize = 10_000;
const _: () = assert!(
    NULL_SAMPLES.is_multiple_of(SAMPLES_TOGETHER),
    "null samples come in whole blocks"
);

/// Samples beyond a value below which a chance is no longer counted (1): with ten its standard error is a third. Numerics.
pub(crate) const COUNTED: usize = 10;

/// Length of an effect, standard errors, at which most of them are to be found under the level.
///
/// At this length a law with a single shape is found in more than nine of ten sessions; shorter effects are weak evidence anyway. By hand
/// (103a3a2); the rule around it is that of Roeder & Wasserman (Statistical Science 24, 2009, p. 398).
pub const DESIGN_LENGTH: f64 = 4.5;

/// Cosine from which two shapes of one candidate with as free an amplitude count as one in null samples (1). By hand (750d6b5).
pub(crate) const SAME_DIRECTION: f64 = 0.985;

// Forward selection.

/// Most effects that are searched for (1). Stated.
pub(crate) const MOST_EFFECTS: usize = 3;

/// Share of the Δχ² that is asked for which the linear Δχ² of a candidate must reach to be fitted in full.
///
/// Fits do add several times as much now and then: a joint's effect that grows large, and what other effects could explain by values that
/// a fit holds. By hand (65f5168).
pub(crate) const WORTH_A_FIT: f64 = 0.3;

/// Log Bayes factor that each of several effects needs beside the others; and by which a simpler law may be behind a richer one that
/// contains it. A ratio of 20: "strong" evidence (Kass & Raftery, Journal of the American Statistical Association 90, 1995, p. 777). Before it
/// was asked for, 2.4 % of 580 sessions with one effect got a second name.
pub const STRONG_EVIDENCE: f64 = 3.0;

/// Rounds in which parameters and covariance are found from each other (1). Numerics.
pub(crate) const ALTERNATIONS: usize = 3;

/// Share of what a run leaves beyond noise that a jump in it explains at least (1): more than half, so that both sides are flatter than the jump is
/// high. Definition.
pub(crate) const FLAT: f64 = 0.5;

// Noise of the readings.

/// Fall of minus twice the logarithm of the likelihood for which a further part of the noise is kept: 5 % of benches without it. Source: the
/// upper 5 % point of chi-squared with one degree of freedom (Self & Liang, Journal of the American Statistical Association 82, 1987, give a
/// smaller one for a variance at zero: fewer are kept).
pub(crate) const ASKED_FOR: f64 = 3.84;

// Bad readings.

/// Chance that a good reading of a bench is called bad (1). Stated.
pub(crate) const BAD_READING_LEVEL: f64 = 0.003;

/// Applications of a load from which on a reading can be compared with the others (1): of two it is open which is wrong. Stated.
pub(crate) const ENOUGH_REPEATS: usize = 3;

/// Share of the readings that may be bad (1): more are no exceptions. Stated.
pub(crate) const MOST_BAD_READINGS: f64 = 0.02;

/// Multiple of [`BAD_READING_LEVEL`] from which on a reading or run is good without an estimate of the noise that leaves it out (1). Numerics.
pub(crate) const CLEARLY_GOOD: f64 = 30.0;

// Noise of a coarse gauge.

/// Share of the variance of a reading from which on the step of the gauge is what scatters (1). By hand (aed7720): alarms 9 of 182 with rounded
/// null samples, 13 without (seed 701); 14 of 182 with them at seed 20261130.
pub(crate) const COARSE: f64 = 0.5;

// Rivals.

/// Log Bayes factor by which any rival must be behind to be distinguishable: a ratio of 150, just above three standard errors. "Very strong"
/// evidence (Kass & Raftery, as above).
pub const DISTINGUISHABLE: f64 = 5.0;

// Unexplained structure.

/// A candidate's column shorter than this share of its length before projection is absorbed by the baseline (1). Numerics.
pub(crate) const ABSORBED: f64 = 1e-6;

/// Share of its length that a column must keep beside others, for all of them to be fitted together (1): a standard error a thousand times larger
/// than alone tells nothing. Numerics.
pub(crate) const LEAST_INDEPENDENT: f64 = 1e-3;

// What a diagnosis needs and says.

/// Readings of a single line from which on what it leaves out is found together with what it could be (1): a drift of six standard errors in
/// 95 % (`crates/diagnosis/tests/mismatch_specimens.rs`).
pub(crate) const ENOUGH_OF_A_LINE: usize = 18;

/// Readings of a part that are about as many as a diagnosis uses (1): of a longer recording every second, every third and so on. By judgement: 5000 take
/// some seconds, and neighbours say the same.
pub const MOST_READINGS_OF_A_PART: usize = 5_000;

/// Degrees of freedom that readings without repeats must leave beside the parameters: with fewer no candidate can be believed. By judgement (e15065f).
pub(crate) const FEWEST_LEFT: usize = 6;

/// Degrees of freedom below which an earlier session carries no information on a variance (1). By judgement (94fd81c).
pub(crate) const FEWEST_DOF: f64 = 3.0;

// What a session shows.

/// A joint whose release would add more than this many times the compliance of the structure lies in no closed loop (1). Numerics.
pub(crate) const OPEN_LOOP: f64 = 1e4;

/// Readings that must follow a jump (1): with fewer it is an outlier. By judgement (750d6b5).
pub(crate) const AFTER_A_JUMP: usize = 2;

/// Quantile of the normal distribution for a power of 80 %. Stated.
pub(crate) const POWER_80: f64 = 0.84;

// Numerics.

/// Share of a column's length that may be told from rounding (1). Numerics.
pub(crate) const ROUNDING: f64 = 1e-9;

/// A square that is less than this share of its first term has lost too many digits, and is computed from the white vector. Numerics.
pub(crate) const CANCELLED: f64 = 1e-8;

/// Null samples that share their products (1): as many as fill five registers of sixteen numbers. Numerics.
pub(crate) const SAMPLES_TOGETHER: usize = 80;

/// How far, in lengths of a vector as the fit leaves it, a low-rank basis may leave it out: Δχ² of 16 changes by 0.08 at random, a critical
/// value not. Numerics.
pub(crate) const LEFT_OUT: f64 = 0.01;

/// A vector this many times longer before the projection than after it is projected in double precision. Numerics.
pub(crate) const LONG: f64 = 1e3;

// Where a model fails: the strata. No verdict depends on these.

/// Level, all tests together, below which a stratum is looked into (1). Stated.
pub const STRATUM_LEVEL: f64 = 0.05;

/// A reading of whose own error the model leaves less than this share carries no information on itself (1). By judgement (f10797f).
pub(crate) const UNSEEN_READING: f64 = 0.05;

/// A column of which what is taken out first leaves less than this share is not worth a degree of freedom (1). By judgement (f10797f).
pub(crate) const COLUMN_LEFT: f64 = 1e-2;

/// A joint or base that turns by more than this under a newton metre does not hold a pose, rad/(N·m). By judgement (8de8e53).
pub(crate) const SOFTEST: f64 = 1e-2;

// The next measurement. No verdict depends on these.

/// Expected log-likelihood ratio below which a plan does not distinguish a pair: as a diagnosis would not.
pub const CANNOT_TELL: f64 = STRONG_EVIDENCE;

/// Expected log-likelihood ratio from which a plan distinguishes a pair: as a diagnosis would.
pub const CAN_TELL: f64 = DISTINGUISHABLE;
