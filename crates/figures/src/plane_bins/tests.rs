//! Tests of bins over a plane.

use super::*;

/// Points of a lattice that is not aligned with the bins, inside a triangle, with a value that rises evenly.
fn slope() -> Vec<([f64; 2], f64)> {
    let lattice = (0..60).flat_map(|i| (0..60).map(move |j| (f64::from(i), f64::from(j))));
    lattice
        .map(|(i, j)| [-0.3 + 0.0171 * i + 0.002 * j, 0.4031 + 0.0163 * j])
        .filter(|[a, b]| a + b < 1.1)
        .map(|[a, b]| ([a, b], 3.0 + 2.0 * a - 5.0 * b))
        .collect()
}

#[test]
fn every_point_is_in_the_bin_around_it() {
    let points = slope();
    let bins = PlaneBins::gather(points.iter().copied(), 0.05);
    assert_eq!(bins.count(), points.len());
    assert_eq!(bins.left_out(), 0);
    for bin in bins.filled() {
        let [a, b] = bin.centre_m;
        let inside: Vec<f64> = points
            .iter()
            .filter(|([x, y], _)| (x - a).abs() < 0.025 && (y - b).abs() < 0.025)
            .map(|(_, value)| *value)
            .collect();
        assert_eq!(inside.len(), bin.count, "{bin:?}");
        let mean = inside.iter().sum::<f64>() / inside.len() as f64;
        // Sums of some ten numbers near one.
        assert!((mean - bin.value).abs() < 1e-13, "{bin:?}");
        assert!(bin.range[0] <= bin.value && bin.value <= bin.range[1]);
    }
}

#[test]
fn the_smooth_estimate_follows_a_slope_up_to_the_border() {
    let bins = PlaneBins::gather(slope().into_iter(), 0.05);
    let mut largest = [0.0_f64; 2];
    for bin in bins.filled() {
        let [a, b] = bin.centre_m;
        let exact = 3.0 + 2.0 * a - 5.0 * b;
        let errors = [bins.smooth(bin.place).unwrap() - exact, bin.value - exact];
        largest = [0, 1].map(|i| largest[i].max(errors[i].abs()));
    }
    // Rounding for the plane; the means are off by up to half a bin where the border cuts it.
    assert!(largest[0] < 1e-11, "{largest:?}");
    assert!(largest[1] > 0.03, "{largest:?}");
}

#[test]
fn the_side_follows_points_and_extent() {
    let lattice = |n: u32| -> Vec<[f64; 2]> {
        (0..n * n)
            .map(|i| {
                [
                    f64::from(i % n) / f64::from(n),
                    f64::from(i / n) / f64::from(n),
                ]
            })
            .collect()
    };
    // Six in a bin where the whole rectangle is full; never finer than can be seen.
    let side = PlaneBins::side_for(&lattice(30));
    assert!((side - (6.0_f64 / 900.0).sqrt()).abs() < 5e-3, "{side}");
    let side = PlaneBins::side_for(&lattice(400));
    assert!((side - 1.0 / 110.0).abs() < 2e-4, "{side}");
    assert!(PlaneBins::side_for(&[]) > 0.0 && PlaneBins::side_for(&[[1.0, 1.0]]) > 0.0);
}

#[test]
fn points_on_a_line_have_their_mean() {
    let points = (0..20).map(|i| ([0.01 * f64::from(i), 0.02 * f64::from(i)], f64::from(i)));
    let bins = PlaneBins::gather(points, 0.1);
    let first = bins.filled().next().unwrap();
    assert_eq!(bins.smooth(first.place), Some(first.value));
    assert_eq!(bins.smooth([1, 0]), None);
}

#[test]
fn a_gap_takes_the_slope_of_its_neighbours_and_the_outside_stays_empty() {
    let lattice =
        (0..40).flat_map(|i| (0..40).map(move |j| [i, j].map(|k| 0.005 + 0.01 * f64::from(k))));
    let in_gap = |[a, b]: [f64; 2]| (0.1..0.15).contains(&a) && (0.2..0.25).contains(&b);
    let points = lattice
        .filter(|at| !in_gap(*at))
        .map(|[a, b]| ([a, b], a - 2.0 * b));
    let bins = PlaneBins::gather(points, 0.05);
    assert_eq!((bins.size(), bins.filled().count()), ([8, 8], 63));
    let value = bins.smooth([2, 4]).unwrap();
    assert!((value - (0.125 - 2.0 * 0.225)).abs() < 1e-12, "{value}");
    assert_eq!(bins.smooth([8, 4]), None);
}

#[test]
fn a_notch_in_a_straight_border_is_a_gap_and_a_corner_is_none() {
    let lattice =
        (0..40).flat_map(|i| (0..40).map(move |j| [i, j].map(|k| 0.005 + 0.01 * f64::from(k))));
    let is_out = |[a, b]: [f64; 2]| a < 0.05 && ((0.2..0.25).contains(&b) || b > 0.35);
    let points = lattice
        .filter(|at| !is_out(*at))
        .map(|[a, b]| ([a, b], a - 2.0 * b));
    let bins = PlaneBins::gather(points, 0.05);
    let value = bins.smooth([0, 4]).unwrap();
    assert!((value - (0.025 - 2.0 * 0.225)).abs() < 1e-12, "{value}");
    assert_eq!(bins.smooth([0, 7]), None);
    assert!(bins.drawn().any(|(place, _)| place == [0, 4]));
}

#[test]
fn a_bin_may_show_its_least_or_its_median() {
    let points = slope();
    let points = || points.iter().copied().chain([([0.1, f64::NAN], 0.0)]);
    for kind in [BinValue::Least, BinValue::Median, BinValue::Greatest] {
        let bins = PlaneBins::gather_as(kind, points(), 0.05);
        let means = PlaneBins::gather(points(), 0.05);
        assert_eq!((bins.value(), bins.left_out()), (kind, 1));
        for (bin, mean) in bins.filled().zip(means.filled()) {
            let [a, b] = bin.centre_m;
            let mut inside: Vec<f64> = points()
                .filter(|([x, y], _)| (x - a).abs() < 0.025 && (y - b).abs() < 0.025)
                .map(|(_, value)| value)
                .collect();
            inside.sort_by(f64::total_cmp);
            let n = inside.len();
            let expected = match kind {
                BinValue::Median => 0.5 * (inside[(n - 1) / 2] + inside[n / 2]),
                BinValue::Greatest => inside[n - 1],
                _ => inside[0],
            };
            assert!((bin.value - expected).abs() < 1e-12, "{bin:?}");
            assert_eq!((bin.count, bin.range), (mean.count, mean.range));
        }
    }
}

#[test]
fn what_is_not_finite_is_counted() {
    let points = [
        ([0.0, 0.0], 1.0),
        ([f64::NAN, 0.0], 1.0),
        ([0.0, 0.0], f64::INFINITY),
    ];
    let bins = PlaneBins::gather(points.into_iter(), 1.0);
    assert_eq!((bins.count(), bins.left_out()), (1, 2));
    let none = PlaneBins::gather(std::iter::empty(), 1.0);
    assert_eq!((none.size(), none.filled().count()), ([0, 0], 0));
}

#[test]
fn bins_of_one_side_lie_on_one_another() {
    let one = PlaneBins::gather([([0.31, -0.2], 1.0)].into_iter(), 0.1);
    let two = PlaneBins::gather([([0.39, -0.11], 1.0), ([9.0, 9.0], 1.0)].into_iter(), 0.1);
    let centre = |bins: &PlaneBins| bins.filled().next().unwrap().centre_m;
    for (a, b) in centre(&one).into_iter().zip(centre(&two)) {
        assert!((a - b).abs() < 1e-12);
    }
}
