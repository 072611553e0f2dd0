//! The fast engine against the plain one, on problems of random numbers.

use nalgebra::DMatrix;
use proptest::prelude::*;

use super::constants::LEFT_OUT;
use super::*;

mod plain;

pub(crate) use plain::Plain;

/// Rows in three blocks of seven, in which two columns are shared.
const BLOCK: usize = 7;
const ROWS: usize = 3 * BLOCK;

/// Numbers between -1 and 1 that differ for each seed.
fn wave(seed: u64, number: usize) -> Vec<f64> {
    let turn = 0.37 + 0.11 * number as f64 + 1e-3 * seed as f64;
    (0..ROWS)
        .map(|row| (turn * (row as f64 + 1.3) * (1.0 + 0.01 * row as f64)).sin())
        .collect()
}

/// A covariance as the search has it, and dense.
fn covariance(seed: u64) -> (Covariance, DMatrix<f64>) {
    let (variances, errors, blocks, dense) = parts_of_covariance(seed);
    (Covariance::with_errors(&variances, &errors, blocks), dense)
}

/// The order in which the rows of a block come: those of three series, of which two are missing the last time.
const COMING: [(usize, usize, usize); BLOCK] = [
    // Row, series, time.
    (0, 0, 0),
    (3, 1, 0),
    (5, 2, 0),
    (1, 0, 1),
    (4, 1, 1),
    (6, 2, 1),
    (2, 0, 2),
];

/// Errors of three series with memories of their own and one error in common, and their correlations.
fn common_errors(seed: u64) -> (RowErrors, DMatrix<f64>) {
    let share = wave(seed, 45);
    let common = wave(seed, 46);
    let correlations = [0.8, 0.5, -0.4];
    let mut states = Vec::new();
    let mut dense = DMatrix::identity(ROWS, ROWS);
    for block in 0..ROWS / BLOCK {
        for (place, (row, series, time)) in COMING.into_iter().enumerate() {
            let mut correlation = [1.0; MOST_STATES];
            correlation[series] = correlations[series];
            if place == 0 {
                correlation = [0.0; MOST_STATES];
            } else if COMING[place - 1].2 != time {
                correlation[MOST_STATES - 1] = 0.0;
            }
            let row = block * BLOCK + row;
            let mut has = [0.0; MOST_STATES];
            has[series] = 0.7 * share[row].abs();
            has[MOST_STATES - 1] = 0.6 * common[row];
            states.push(RowStates {
                row,
                correlation,
                has,
            });
        }
        for (row, series, time) in COMING {
            for (other, of, then) in COMING {
                let (i, j) = (block * BLOCK + row, block * BLOCK + other);
                if i == j {
                    continue;
                }
                let mut sum = 0.0;
                if series == of {
                    let apart = i32::try_from(time.abs_diff(then)).unwrap();
                    sum +=
                        0.49 * share[i].abs() * share[j].abs() * correlations[series].powi(apart);
                }
                if time == then {
                    sum += 0.36 * common[i] * common[j];
                }
                dense[(i, j)] = sum;
            }
        }
    }
    (RowErrors::Common(states), dense)
}

/// Variances, errors and blocks of a covariance, and the whole of it, dense; of even seeds rows remember the row before them, of those that five
/// divides they have the errors of several series.
fn parts_of_covariance(seed: u64) -> (Vec<f64>, RowErrors, Vec<LowRankBlock>, DMatrix<f64>) {
    let variances: Vec<f64> = wave(seed, 40).iter().map(|x| 0.3 + x * x).collect();
    let several = seed.is_multiple_of(5).then(|| common_errors(seed));
    let correlations: Vec<RowCorrelation> = if seed.is_multiple_of(2) {
        let correlations = wave(seed, 43).into_iter().zip(wave(seed, 45)).enumerate();
        let of_row = |(row, (correlation, share)): (usize, (f64, f64))| RowCorrelation {
            correlation: if row % BLOCK == 0 {
                0.0
            } else {
                0.9 * correlation
            },
            share: share.abs(),
        };
        correlations.map(of_row).collect()
    } else {
        Vec::new()
    };
    let correlation = |i: usize, j: usize| {
        if let Some((_, dense)) = &several {
            return dense[(i, j)];
        }
        if i == j || correlations.is_empty() {
            return f64::from(u8::from(i == j));
        }
        let between = correlations[i.min(j) + 1..=i.max(j)].iter();
        let steps: f64 = between.map(|row| row.correlation).product();
        steps * (correlations[i].share * correlations[j].share).sqrt()
    };
    let mut dense = DMatrix::from_fn(ROWS, ROWS, |i, j| {
        (variances[i] * variances[j]).sqrt() * correlation(i, j)
    });
    let shared = [wave(seed, 41), wave(seed, 42)];
    let block = |start: usize| {
        let rows = start..start + BLOCK;
        let columns = shared
            .iter()
            .flat_map(|column| column[rows.clone()].to_vec());
        LowRankBlock {
            columns: columns.collect(),
            rows: rows.clone(),
        }
    };
    let blocks: Vec<LowRankBlock> = [0, BLOCK, 2 * BLOCK].map(block).into();
    for block in &blocks {
        for column in block.columns.chunks(BLOCK) {
            for (i, a) in block.rows.clone().zip(column) {
                for (j, b) in block.rows.clone().zip(column) {
                    dense[(i, j)] += a * b;
                }
            }
        }
    }
    let errors = several.map_or(RowErrors::Correlated(correlations), |(errors, _)| errors);
    (variances, errors, blocks, dense)
}

/// The same problem for both engines: two columns, one of them with a prior.
struct Problem {
    space: WhiteSpace,
    residual: Vec<f64>,
    plain: Plain,
}

fn problem(seed: u64) -> Problem {
    let (covariance, dense) = covariance(seed);
    let (columns, prior_sd) = ([wave(seed, 50), wave(seed, 51)], [0.7]);
    let mut y = wave(seed, 52);
    y.push(0.4);
    let space = WhiteSpace::new(covariance, &prior_sd, &columns);
    let mut residual = space.white(&y[..ROWS]);
    residual[ROWS] = y[ROWS];
    space.project(&mut residual);
    let plain = Plain::new(&dense, &prior_sd, &columns, space.basis(), &y);
    Problem {
        space,
        residual,
        plain,
    }
}

fn near(found: f64, expected: f64, scale: f64) -> Result<(), TestCaseError> {
    prop_assert!(
        (found - expected).abs() <= 1e-9 * scale,
        "{found} {expected}"
    );
    Ok(())
}

fn same_moments(found: Moments, expected: Moments) -> Result<(), TestCaseError> {
    near(found.square, expected.square, expected.square)?;
    // A product may be zero by chance: no white residual here is longer than ten.
    near(
        found.product,
        expected.product,
        10.0 * expected.square.sqrt(),
    )
}

proptest! {
    #[test]
    fn scores_of_both_engines_are_the_same(seed in 0..10_000_u64) {
        let Problem { space, residual, plain } = problem(seed);
        let fast = Batched::new(&space, &residual);
        let scratch = &mut Vec::new();
        let (first, second) = (wave(seed, 60), wave(seed, 61));
        let close: Vec<f64> = first.iter().zip(&second).map(|(a, b)| a + 0.1 * b).collect();
        for rows in [0..ROWS, BLOCK..2 * BLOCK, BLOCK..ROWS] {
            same_moments(fast.moments(&first, &rows, scratch), plain.moments(&first, &rows, scratch))?;
            for pair in [[&first, &second], [&first, &close]] {
                let pair = pair.map(|shape| &shape[..]);
                let found = fast.pair_moments(pair, &rows, scratch);
                let expected = plain.pair_moments(pair, &rows, scratch);
                same_moments(found.first, expected.first)?;
                same_moments(found.second, expected.second)?;
            }
        }
    }

    #[test]
    fn null_samples_of_both_engines_are_the_same(seed in 0..10_000_u64) {
        let Problem { space, residual, plain } = problem(seed);
        // Eighteen vectors of four directions, and two that live in one block.
        let vector = |number: usize| -> Vec<f64> {
            let shares = |k: usize| (0.7 * (number * (k + 1)) as f64).cos();
            let waves: Vec<Vec<f64>> = (0..4).map(|k| wave(seed, 70 + k)).collect();
            let sum = |row: usize| (0..4).map(|k| shares(k) * waves[k][row]).sum::<f64>();
            (0..ROWS).map(|row| if number < 18 || row < BLOCK { sum(row) } else { 0.0 }).collect()
        };
        let shape = |number: usize| {
            let unit = space.white(&vector(number));
            let length = norm(&space.projected(&vector(number)));
            NullShape {
                family: number % 3,
                units: vec![RowVector::from(unit.iter().map(|x| x / length).collect::<Vec<f64>>())],
                length: 2.0,
                multiples: [[0.0, 1.0], [f64::NEG_INFINITY, f64::INFINITY]][number % 2],
            }
        };
        let groups = || -> Vec<NullShapes<'_>> {
            let group = |group: usize| move || (0..20).filter(|n| n % 2 == group).map(shape).collect();
            (0..2).map(|number| Box::new(group(number)) as NullShapes<'_>).collect()
        };
        let blocks = [0..BLOCK, BLOCK..2 * BLOCK, 2 * BLOCK..ROWS];
        let noise = NullNoise::normal(160, seed);
        let found = Batched::new(&space, &residual).null_maxima(groups(), 3, &blocks, &noise);
        let expected = plain.null_maxima(groups(), 3, &blocks, &noise);
        let close = |found: &[f64], expected: &[f64], tolerance: f64| {
            found.len() == 160
                && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < tolerance * (1.0 + b))
        };
        // A low-rank basis leaves out a hundredth of a standard error at most, and there are two of them.
        prop_assert!((0..3).all(|f| close(&found[f], &expected[f], 6.0 * LEFT_OUT)));
    }
}

#[test]
fn a_covariance_with_memory_is_what_it_says() {
    for seed in [2, 3, 5] {
        let (covariance, dense) = covariance(seed);
        let before = wave(seed, 44);
        let mut inverse = before.clone();
        covariance.whiten(&mut inverse);
        let mut there_and_back = inverse.clone();
        covariance.whiten_transposed(&mut inverse);
        let product = &dense * DMatrix::from_column_slice(ROWS, 1, &inverse);
        covariance.unwhiten(&mut there_and_back);
        let mut own = before.clone();
        covariance.own_part(&mut own);
        let mut rest = before.clone();
        for block in covariance.inverse_columns() {
            assert_eq!(block.columns.len(), 2 * BLOCK);
        }
        let shared = [wave(seed, 41), wave(seed, 42)];
        for (row, value) in rest.iter_mut().enumerate() {
            let block = row / BLOCK * BLOCK..(row / BLOCK + 1) * BLOCK;
            let in_common = shared.iter().map(|column| {
                let along: f64 = block
                    .clone()
                    .map(|other| column[other] * before[other])
                    .sum();
                column[row] * along
            });
            let all: f64 = (0..ROWS)
                .map(|other| dense[(row, other)] * before[other])
                .sum();
            *value = all - in_common.sum::<f64>();
        }
        for row in 0..ROWS {
            assert!((product[row] - before[row]).abs() < 1e-9);
            assert!((there_and_back[row] - before[row]).abs() < 1e-9);
            assert!((own[row] - rest[row]).abs() < 1e-9, "{row}");
        }
    }
}

#[test]
fn rows_that_weigh_nothing_are_as_if_they_were_not_there() {
    let (covariance, dense) = covariance(3);
    // Some of a block, all of another, none of the third.
    let left_out: Vec<bool> = (0..ROWS)
        .map(|row| row % 3 == 0 && row < BLOCK || row / BLOCK == 1)
        .collect();
    let kept: Vec<usize> = (0..ROWS).filter(|row| !left_out[*row]).collect();
    let before = wave(3, 44);
    let mut inverse = before.clone();
    let covariance = covariance.without(&left_out);
    covariance.whiten(&mut inverse);
    covariance.whiten_transposed(&mut inverse);
    for &row in &kept {
        let product: f64 = kept
            .iter()
            .map(|&other| dense[(row, other)] * inverse[other])
            .sum();
        assert!((product - before[row]).abs() < 1e-9, "{row}");
    }
    assert!((0..ROWS).all(|row| !left_out[row] || inverse[row] == 0.0));
}

#[test]
fn products_under_the_inverse_of_a_covariance_are_those_of_the_dense_one() {
    // Steps whose rows come twice in a block, and further columns; the further columns alone.
    let ones: Vec<usize> = (0..ROWS).map(|row| (row * 3) % 5).collect();
    let further = [wave(4, 60), wave(4, 61)];
    for (seed, steps) in [(2, 5), (3, 5), (4, 5), (5, 5), (2, 0), (3, 0), (5, 0)] {
        let (variances, errors, blocks, dense) = parts_of_covariance(seed);
        let precision = Precision::new(&variances, &errors, blocks);
        let cholesky = dense.cholesky().unwrap();
        let error = precision.log_determinant() - cholesky.ln_determinant();
        assert!(error.abs() < 1e-9);
        let rows = BLOCK..ROWS;
        let of_rows = |column: &[f64]| column[rows.clone()].to_vec();
        let ones = if steps == 0 { &[] } else { &ones[rows.clone()] };
        let further: Vec<Vec<f64>> = further.iter().map(|column| of_rows(column)).collect();
        let size = steps + further.len();
        let x = DMatrix::from_fn(ROWS, size, |row, column| {
            let Some(row) = row.checked_sub(rows.start) else {
                return 0.0;
            };
            match column.checked_sub(steps) {
                Some(place) => further[place][row],
                None => f64::from(u8::from(ones[row] == column)),
            }
        });
        let expected = x.tr_mul(&cholesky.solve(&x));
        let further: Vec<&[f64]> = further.iter().map(Vec::as_slice).collect();
        let columns = SparseRows {
            ones,
            one_columns: steps,
            further: &further,
        };
        let mut sums = vec![0.0; size * size];
        precision.add_products(&rows, &columns, &mut sums);
        for i in 0..size {
            for j in 0..=i {
                let error = sums[i * size + j] - expected[(i, j)];
                assert!(error.abs() < 1e-9, "seed {seed}, {steps} steps: {i}, {j}");
            }
        }
    }
}

#[test]
fn what_the_baseline_absorbs_is_left_to_the_last_digit_of_the_white_vector() {
    let Problem {
        space, residual, ..
    } = problem(1);
    let column = wave(1, 51);
    let found = Batched::new(&space, &residual).moments(&column, &(0..ROWS), &mut Vec::new());
    let white = space.projected(&column);
    assert_eq!(found.square, dot(&white, &white));
}

#[test]
fn residuals_of_an_estimated_variance_make_a_score_less_rare() {
    use stiffbench_numeric::statistics::f_upper_tail;
    let known = under_known_covariance(16.0, 1.0, 20.0);
    let as_rare = f_upper_tail(known, 1.0, 1e9).unwrap();
    let rare = f_upper_tail(16.0, 1.0, 20.0).unwrap();
    // Quantiles are found to six digits.
    assert!((as_rare - rare).abs() < 1e-5 * rare, "{as_rare} {rare}");
}

#[test]
fn levels_add_up_and_a_family_of_one_shape_has_the_lowest_value() {
    // Squares of normal numbers: one in the first family, the largest of twelve in the second.
    let (covariance, _) = covariance(3);
    let space = WhiteSpace::new(covariance, &[], &[]);
    let unit = |row: usize, family: usize| NullShape {
        family,
        units: vec![RowVector {
            first: row,
            values: vec![1.0],
        }],
        length: 1.0,
        multiples: [f64::NEG_INFINITY, f64::INFINITY],
    };
    let one =
        |row: usize| -> NullShapes<'_> { Box::new(move || vec![unit(row, usize::from(row > 0))]) };
    let shapes = (0..13).map(one).collect();
    let all = 0..ROWS;
    let engine = Batched::new(&space, &[0.0; ROWS]);
    let noise = NullNoise::normal(16_000, 5);
    let maxima = engine.null_maxima(shapes, 2, std::slice::from_ref(&all), &noise);
    let values = CriticalValues::calibrate(&["one", "twelve"], &maxima, 0.04);
    assert!(values.of("one") < values.of("twelve"));
    let exceeds = |sample: &usize| {
        maxima[0][*sample] > values.of("one") || maxima[1][*sample] > values.of("twelve")
    };
    let share = (0..16_000).filter(exceeds).count() as f64 / 16_000.0;
    assert!((share - 0.04).abs() < 1e-3, "{share}");
    let p = values.p("twelve", values.of("twelve"));
    assert!((p - 0.04).abs() < 1e-9, "{p}");
    assert_eq!(values.of("unknown"), values.of("twelve"));
}

#[test]
fn alone_the_shape_counts_that_critical_values_are_of() {
    let evidence = |delta_chi2, linear_delta_chi2| Evidence {
        delta_chi2,
        linear_delta_chi2,
        amplitudes: 1.0,
        parameters: 2,
        dof: 1e6,
        critical_value: 9.0,
        log_prior: 0.0,
    };
    assert_eq!(evidence(16.0, 12.0).judged(true), 12.0);
    assert_eq!(evidence(16.0, 12.0).judged(false), 16.0);
    // A linear score that no fit reaches is none.
    assert_eq!(evidence(10.0, 12.0).judged(true), 10.0);
    assert_eq!(evidence(9.0, 9.0).log_bayes(), 0.0);
}
