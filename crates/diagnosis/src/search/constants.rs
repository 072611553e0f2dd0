//! Every number of the search that could be another, with unit, meaning, and what set it.
//!
//! Five kinds of origin are distinguished:
//!
//! - **stated**: part of what the search promises;
//! - **source**: a book or paper;
//! - **by hand**: chosen by hand on simulated benches (`stiffbench-validate prove --only errors`, `--only calibration`, `--only concealed`), in
//!   the commit given; where a trial was counted, its seed and result are those of the table in `CHANGELOG.md`;
//! - **by judgement**: set in the commit given, which states no trial; where `docs/method.md`, section 11, lists it, it was counted afterwards;
//! - **numerics**: rounding, work or memory; no verdict depends on it beyond its tolerance.
//!
//! What half and twice a number changes on sessions with known answers is the table of `docs/method.md`, section 11; a test holds its values to
//! those here. Numbers that belong to one physical law stand in the file of the law.

// Level and critical values.

/// Chance that noise alone passes for one of the laws (1). Stated: together with `OMNIBUS_LEVEL` 4 %.
pub const LAW_LEVEL: f64 = 0.03;

/// The part of [`LAW_LEVEL`] for mistakes of the robot file and of the set-up (1). Stated.
pub(crate) const SETUP_LEVEL: f64 = 0.005;

/// Chance that noise alone passes for unexplained structure (1). Stated.
pub(crate) const OMNIBUS_LEVEL: f64 = 0.01;

/// The same for the largest pattern, half of `OMNIBUS_LEVEL` (1). Stated.
pub const UNEXPLAINED_LEVEL: f64 = 0.5 * OMNIBUS_LEVEL;

/// Chance of the family below which a name is given without reservation (1). Stated.
pub(crate) const CERTAIN: f64 = 0.005;

/// Share of the misfit, in the readings and in those left out, that names must explain to be most of the answer (1). Stated.
pub(crate) const MOST_OF_THE_MISFIT: f64 = 0.75;

/// Misfit that can be divided into shares, in standard deviations of what noise leaves (1). Stated.
pub(crate) const VISIBLE_MISFIT: f64 = 3.0;

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

/// Share of null samples by which the number of independent shapes of a family is counted (1): 100 samples. By hand (103a3a2).
pub(crate) const TAIL: f64 = 0.01;

/// No critical value of Δχ² is lower: a likelihood ratio of 20. A loose member has no size to be fitted, and one that changes next to
/// nothing would pass by next to nothing. By hand (6e1a649).
pub(crate) const LEAST_CRITICAL_VALUE: f64 = 6.0;

/// Cosine from which two shapes of one candidate with as free an amplitude count as one in null samples (1). By hand (750d6b5).
pub(crate) const SAME_DIRECTION: f64 = 0.985;

// Noise of null samples.

/// Residuals from which on they show their distribution (1); with fewer the noise is normal. By hand (d2ad58c).
pub(crate) const ENOUGH_FOR_A_DISTRIBUTION: usize = 200;

/// Residuals beyond this many standard deviations are resampled as if they were there: they may be the effect that is searched for. By hand
/// (d2ad58c).
pub(crate) const LARGEST_RESAMPLED: f64 = 4.5;

/// Standard deviation of the normal part added to each resampled residual, in those of the residuals, so that no sample is one of the few
/// hundred values seen. By hand (d2ad58c).
pub(crate) const SMOOTHING: f64 = 0.3;

/// Smoothed residuals that are drawn from (1): so many that each is rare. Numerics.
pub(crate) const POOL: usize = 1 << 16;

// Forward selection.

/// Most effects that are searched for (1). Stated.
pub(crate) const MOST_EFFECTS: usize = 3;

/// The same of a part, whose recording shows more than a session of single readings. Stated.
pub(crate) const MOST_OF_A_PART: usize = 5;

/// Laws of a part with which the search begins again where what it found first does not explain most (1). Stated.
pub(crate) const OTHER_STARTS: usize = 3;

/// Share of its critical value that the best candidate needs under the covariance of the model without it, to be checked under its own.
///
/// Under the first an effect that differs between repeats hides part of itself. By hand (cba106e).
pub(crate) const WORTH_A_LOOK: f64 = 0.7;

/// Share of the Δχ² that is asked for which the linear Δχ² of a candidate must reach to be fitted in full.
///
/// Fits do add several times as much now and then: a joint's effect that grows large, and what other effects could explain by values that
/// a fit holds. By hand (65f5168).
pub(crate) const WORTH_A_FIT: f64 = 0.3;

/// Candidates that are fitted in full at a time (1). By hand (9e2cc84).
pub(crate) const MOST_FITTED: usize = 24;

/// Δχ² behind the best linear one, to which candidates are fitted in full: a Bayes factor of e^13. By hand (750d6b5).
pub(crate) const FITTED_WITHIN: f64 = 26.0;

/// Share of the best Δχ² by which a law of parts may be behind before its shape is fitted (1): a shape halfway between two that are searched shows half
/// of the whole. Numerics.
pub(crate) const FAR_FROM_ITS_BEST: f64 = 0.5;

/// Slips that are fitted in full at a time (1): one of a few micrometres may as well have come a step or two earlier or later. By hand: of
/// 100 slips 0.9 beyond their critical value 81 were rightly named with six, 75 with two.
pub(crate) const MOST_SLIPS_FITTED: usize = 6;

/// Log Bayes factor by which another candidate must explain more to take the place of an effect. By hand (750d6b5).
pub(crate) const SWAP_GAIN: f64 = 0.5;

/// Log Bayes factor that each of several effects needs beside the others; and by which a simpler law may be behind a richer one that
/// contains it. A ratio of 20: "strong" evidence (Kass & Raftery, Journal of the American Statistical Association 90, 1995, p. 777). Before it
/// was asked for, 2.4 % of 580 sessions with one effect got a second name.
pub const STRONG_EVIDENCE: f64 = 3.0;

/// Fall of the weighted squares in poses left out above which an effect helps there (1). Stated: none but zero favours neither side.
pub(crate) const HELD_OUT_FALL: f64 = 0.0;

/// Share of an effect's squares in one pose above which the other poses do not determine it (1). By hand (cba106e).
pub(crate) const ONE_POSE: f64 = 0.5;

/// Relative difference of all standard deviations below which two estimates of a covariance are the same (1): far less than either is known.
/// Numerics.
pub(crate) const SAME_COVARIANCE: f64 = 0.02;

/// Rounds in which parameters and covariance are found from each other (1). Numerics.
pub(crate) const ALTERNATIONS: usize = 3;

/// Δχ² of an effect from which the shape of its kinked parameters is searched with full fits. By hand (750d6b5).
pub(crate) const WORTH_A_SHAPE_SEARCH: f64 = 30.0;

/// Share of a slip's Δχ² that goes where one reading may be anything, if that reading decides about it (1). By hand (fc4705d): alarms on benches with skewed
/// errors 12 of 182 with the rule, 18 without (seed 708).
pub(crate) const ONE_READING: f64 = 0.5;

/// Share of what a run leaves beyond noise that a jump in it explains at least (1): more than half, so that both sides are flatter than the jump is
/// high. Definition.
pub(crate) const FLAT: f64 = 0.5;

/// Readings over which a gradual change in a run comes at least: a jump that is read while it happens takes two. Definition.
pub(crate) const GRADUAL_READINGS: usize = 3;

/// The same as a share of the readings of the run (1). Definition.
pub(crate) const GRADUAL_SHARE: f64 = 0.25;

/// Standard errors of skewness and kurtosis from which on residuals are not normal. By hand (fc4705d).
pub(crate) const NOT_NORMAL: f64 = 5.0;

// Noise of the readings.

/// Standard deviation of the prior of the logarithm of each variance of the noise (1): a factor of seven either way of a standard deviation. By
/// hand (750d6b5).
pub(crate) const PRIOR_LOG_VARIANCE_SD: f64 = 4.0;

/// Relative error of the slope of a run about which that prior lies (1), and of a reading that grows with its displacement. By hand (750d6b5).
pub(crate) const PRIOR_RUN_SLOPE_SD: f64 = 3e-3;

/// Fall of minus twice the logarithm of the likelihood for which a further part of the noise is kept: 5 % of benches without it. Source: the
/// upper 5 % point of chi-squared with one degree of freedom (Self & Liang, Journal of the American Statistical Association 82, 1987, give a
/// smaller one for a variance at zero: fewer are kept).
pub(crate) const ASKED_FOR: f64 = 3.84;

/// Scatter of forces within a load step, as a share of the largest force, above which repeats of the step are not the same load (1). By
/// judgement (750d6b5).
pub(crate) const SAME_STEP: f64 = 0.05;

/// Share of the largest load within which a run of a part begins where the one before ended, so that its history goes on. Definition.
pub(crate) const CONTINUES: f64 = 0.05;

/// Path of a run, in its range, beyond which it is no way up with small errors but loads in shuffled order, if none of it is unloading. Definition.
pub(crate) const SHUFFLED: f64 = 2.0;

// Bad readings.

/// Chance that a good reading of a bench is called bad (1). Stated.
pub(crate) const BAD_READING_LEVEL: f64 = 0.003;

/// Applications of a load from which on a reading can be compared with the others (1): of two it is open which is wrong. Stated.
pub(crate) const ENOUGH_REPEATS: usize = 3;

/// Share of the readings that may be bad (1): more are no exceptions. Stated.
pub(crate) const MOST_BAD_READINGS: f64 = 0.02;

/// Multiple of [`BAD_READING_LEVEL`] from which on a reading or run is good without an estimate of the noise that leaves it out (1). Numerics.
pub(crate) const CLEARLY_GOOD: f64 = 30.0;

/// Readings on either side that show the curve of a run near one of them (1): a parabola, a kink and a jump need so many. By judgement.
pub(crate) const NEIGHBOURS: usize = 4;

/// Chance that cells which are off by anything look exchanged, or as if their decimal point were wrong (1). Stated.
pub(crate) const BY_COINCIDENCE: f64 = 0.01;

/// Relative standard error of the compliance of a cell up to which it is compared with the model (1): far below a factor of two. By judgement.
pub(crate) const LEAST_KNOWN_CELL: f64 = 0.1;

/// Mistakes in the names of cells that are fitted in full (1): those that explain most if the model is linear. Numerics.
pub(crate) const MISTAKES_FITTED: usize = 12;

/// Standard errors by which a jump and its return may differ (1). Stated.
pub(crate) const SAME_JUMP: f64 = 3.0;

// Noise of a coarse gauge.

/// Share of the variance of a reading from which on the step of the gauge is what scatters (1). By hand (aed7720): alarms 9 of 182 with rounded
/// null samples, 13 without (seed 701); 14 of 182 with them at seed 20261130.
pub(crate) const COARSE: f64 = 0.5;

/// Standard deviation of a reading before it is rounded by a coarse gauge, as a share of its step, where no repeats show it (1). By hand (aed7720).
pub(crate) const FINEST: f64 = 0.05;

// Rivals.

/// Log Bayes factor by which any rival must be behind to be distinguishable: a ratio of 150, just above three standard errors. "Very strong"
/// evidence (Kass & Raftery, as above).
pub const DISTINGUISHABLE: f64 = 5.0;

/// The same for a rival whose effect has a cosine κ with the winner's: this times κ⁴, for the rows that speak for the one say less of the
/// other. By hand (7c24409): right sets 95.1, 95.3, 98.9 % at 4.5, 6, 8 standard errors; 95.3, 93.7, 98.5 % with 5 κ² (seed 709).
pub(crate) const DISTINGUISHABLE_BY_COSINE: f64 = 8.0;

// Unexplained structure.

/// Δχ² by which an effect must exceed the best pattern without a law in its stead to keep its name: three standard errors. By hand (516ef64).
pub(crate) const BEYOND_PATTERNS: f64 = 9.0;

/// A pattern shorter than this share of its length before projection is absorbed by the baseline (1). Numerics.
pub(crate) const ABSORBED_PATTERN: f64 = 1e-3;

/// The same of a candidate's column. Numerics.
pub(crate) const ABSORBED: f64 = 1e-6;

/// Share of its length that a column must keep beside others, for all of them to be fitted together (1): a standard error a thousand times larger
/// than alone tells nothing. Numerics.
pub(crate) const LEAST_INDEPENDENT: f64 = 1e-3;

/// Readings in a run from which on a rhythm in their order is searched for (1). By judgement (0f36cf8).
pub(crate) const ENOUGH_FOR_A_RHYTHM: usize = 32;

/// Distance from a plausible bound, as a share of it, at which a size stands there (1): fits stop at bounds up to rounding, and a page prints three
/// digits. Stated.
pub(crate) const AT_A_PLAUSIBLE_BOUND: f64 = 1e-3;

/// Runs from which on a swing of the clock is searched for (1): fewer show a trend at most. By judgement.
pub(crate) const RUNS_OF_A_SWING: usize = 8;

/// Most frequencies that are searched for (1). It bounds the work of runs of more than 400 readings and sessions of more than 100 runs. By
/// judgement (0f36cf8).
pub(crate) const FREQUENCIES: usize = 200;

// What a diagnosis needs and says.

/// Readings of a single line from which on what it leaves out is found together with what it could be (1): a drift of six standard errors in
/// 95 % (`crates/diagnosis/tests/mismatch_specimens.rs`).
pub(crate) const ENOUGH_OF_A_LINE: usize = 18;

/// Readings of a part from which on they are a recording, of which neighbours show the scatter (1): of fewer the scatter is what a model leaves. By
/// judgement.
pub(crate) const ENOUGH_OF_A_RECORDING: usize = 100;

/// Readings of a part that are about as many as a diagnosis uses (1): of a longer recording every second, every third and so on. By judgement: 5000 take
/// some seconds, and neighbours say the same.
pub const MOST_READINGS_OF_A_PART: usize = 5_000;

/// Rivals that are printed (1).
pub(crate) const RIVALS: usize = 8;

/// A factor whose interval spans more than this share of what was allowed beforehand is not identified by the data (1). By hand (750d6b5).
pub(crate) const IDENTIFIED: f64 = 0.5;

/// Degrees of freedom that readings without repeats must leave beside the parameters: with fewer no candidate can be believed. By judgement (e15065f).
pub(crate) const FEWEST_LEFT: usize = 6;

/// Poses without which readings that are not repeated distinguish nothing. By judgement (e15065f).
pub(crate) const FEWEST_POSES: usize = 3;

/// Degrees of freedom below which an earlier session carries no information on a variance (1). By judgement (94fd81c).
pub(crate) const FEWEST_DOF: f64 = 3.0;

/// Earlier sessions with a smaller chance to have the same noise are not pooled (1). By judgement (94fd81c).
pub(crate) const LEAST_CHANCE_OF_SAME_NOISE: f64 = 0.01;

// What cannot be seen.

/// White length at its largest possible size, standard errors, below which a shape is left out. Numerics.
pub(crate) const INVISIBLE: f64 = 1e-3;

/// White length of a joint that turns freely, standard errors, up to which no law at that joint is tried: none turns it further. By hand
/// (cba106e).
pub(crate) const HIDDEN_JOINT: f64 = 2.0;

/// Linear Δχ² of a member's absence, as a share of the squared length of what it changes, below which no fit makes it positive: halfway from
/// what a structure with the member leaves (-1) to what explains nothing (0). By hand (65f5168).
pub(crate) const HOPELESS: f64 = -0.5;

/// Squared length, in standard errors, below which the readings carry no information on a member: it may as well be loose. Numerics.
pub(crate) const INVISIBLE_MEMBER: f64 = 1e-6;

/// A joint whose release would add more than this many times the compliance of the structure lies in no closed loop (1). Numerics.
pub(crate) const OPEN_LOOP: f64 = 1e4;

/// Readings that must follow a jump (1): with fewer it is an outlier. By judgement (750d6b5).
pub(crate) const AFTER_A_JUMP: usize = 2;

/// Quantile of the normal distribution for a power of 80 %. Stated.
pub(crate) const POWER_80: f64 = 0.84;

// Numerics.

/// Share of a column's length that may be told from rounding (1). Numerics.
pub(crate) const ROUNDING: f64 = 1e-9;

/// White length, standard errors, from which a column of the baseline counts: shorter ones no fit can use. Numerics.
pub(crate) const SHORTEST_COLUMN: f64 = 1e-6;

/// A square that is less than this share of its first term has lost too many digits, and is computed from the white vector. Numerics.
pub(crate) const CANCELLED: f64 = 1e-8;

/// Null samples that share their products (1): as many as fill five registers of sixteen numbers. Numerics.
pub(crate) const SAMPLES_TOGETHER: usize = 80;

/// How far, in lengths of a vector as the fit leaves it, a low-rank basis may leave it out: Δχ² of 16 changes by 0.08 at random, a critical
/// value not. Numerics.
pub(crate) const LEFT_OUT: f64 = 0.01;

/// Directions from which on others are taken apart (1): noise along them stays in a fast memory. Numerics.
pub(crate) const DIRECTIONS_TOGETHER: usize = 8192;

/// Vectors from which a low-rank basis is chosen (1); those of more are chosen apart, for neighbours in the list are most alike. Numerics.
pub(crate) const VECTORS_TOGETHER: usize = 160;

/// A vector this many times longer before the projection than after it is projected in double precision. Numerics.
pub(crate) const LONG: f64 = 1e3;

/// Directions in one block of rows from which on the rows themselves are as good a basis (1). Numerics.
pub(crate) const MOST_DIRECTIONS: usize = 64;

// Where a model fails: the strata. No verdict depends on these.

/// Level, all tests together, below which a stratum is looked into (1). Stated.
pub const STRATUM_LEVEL: f64 = 0.05;

/// Share of a stratum's squares above which one spot is said to hold it (1). By judgement (f10797f).
pub(crate) const ONE_SPOT: f64 = 0.8;

/// Forces closer than this share of the usual distance between loads are one level (1). By judgement (f10797f).
pub(crate) const ONE_LEVEL: f64 = 0.3;

/// Forces closer than this share of the largest are one level in any case (1): no jack is set more closely. By judgement (f10797f).
pub(crate) const SAME_FORCE: f64 = 0.01;

/// A reading of whose own error the model leaves less than this share carries no information on itself (1). By judgement (f10797f).
pub(crate) const UNSEEN_READING: f64 = 0.05;

/// A factor that moves no reading by more than this many standard errors within all that is known of it is left out: it absorbs nothing. By
/// judgement (f10797f).
pub(crate) const ABSORBS_NOTHING: f64 = 0.05;

/// A column of which what is taken out first leaves less than this share is not worth a degree of freedom (1). By judgement (f10797f).
pub(crate) const COLUMN_LEFT: f64 = 1e-2;

/// Degrees of freedom above which a variance counts as known (1). Numerics.
pub(crate) const KNOWN_VARIANCE: f64 = 1e5;

/// A period longer than this share of the displacement is a curve over the load (1). By judgement (f10797f).
pub(crate) const LONGEST_PERIOD: f64 = 0.5;

/// Parts with a larger cosine between their effects cannot be distinguished (1). By judgement (f10797f).
pub(crate) const INSEPARABLE_PARTS: f64 = 0.98;

/// Compliance of a joint times the stiffness of its loop beyond which even a pin does not explain it (1); above 1 for poses in which the loop is
/// stiffer. By judgement (8de8e53).
pub(crate) const A_PIN: f64 = 1.5;

/// A joint or base that turns by more than this under a newton metre does not hold a pose, rad/(N·m). By judgement (8de8e53).
pub(crate) const SOFTEST: f64 = 1e-2;

/// Factor by which no property of an element is wrong (1): the bounds of the factors. Stated.
pub(crate) const MOST_WRONG: f64 = 10.0;

/// A part of whose effect the factors leave less than this share is not seen (1). Numerics.
pub(crate) const HIDDEN_PART: f64 = 1e-3;

// The next measurement. No verdict depends on these.

/// Expected log-likelihood ratio below which a plan does not distinguish a pair: as a diagnosis would not.
pub const CANNOT_TELL: f64 = STRONG_EVIDENCE;

/// Expected log-likelihood ratio from which a plan distinguishes a pair: as a diagnosis would.
pub const CAN_TELL: f64 = DISTINGUISHABLE;

/// Pairs that are planned for (1), those with the largest posterior. By judgement (2d002a9).
pub(crate) const MOST_PAIRS: usize = 6;

/// Courses of a law that are kept for each rival it may imitate (1): those nearest to it. By judgement (2d002a9).
pub(crate) const IMITATIONS: usize = 6;

/// Rivals that are listed for each law and place (1).
pub(crate) const NEAREST: usize = 3;

/// Share by which a planned time varies from one reading to the next, at most (1). By judgement (2d002a9).
pub(crate) const TIMES_VARY: f64 = 0.2;

/// Scatter of a reading on a bench of which nothing is known yet, m: a dial gauge with a step of 10 µm, read to 6 µm, √(6² + 10²/12). Stated.
pub(crate) const USUAL_READING_SD_M: f64 = 6.66e-6;

/// Scatter of its zero, m. Stated.
pub(crate) const USUAL_ZERO_SD_M: f64 = 5e-6;

/// Relative scatter of its slope from run to run (1): how well the fixture seats. Stated.
pub(crate) const USUAL_RUN_SLOPE_SD: f64 = 5e-3;
