//! Runs in the path of the load: where it comes back near zero, another begins.

/// A run may begin where the load is below this share of the largest.
pub(super) const NEAR_ZERO: f64 = 0.15;

/// Between two runs the load must have been above this share of the largest.
const LOADED: f64 = 0.5;

/// The run of each load of a cell, from 1, in the order of measurement.
///
/// Of the loads near zero between two loadings the last of the smallest begins the next run; a single one is where the next run begins.
pub(super) fn runs_of(loads: &[f64]) -> Vec<u32> {
    let largest = loads
        .iter()
        .fold(0.0_f64, |largest, load| largest.max(load.abs()));
    let mut starts = Vec::new();
    let mut was_loaded = false;
    let mut lowest: Option<usize> = None;
    for (index, load) in loads.iter().enumerate() {
        let size = load.abs();
        if size >= LOADED * largest {
            if let Some(start) = lowest.filter(|_| was_loaded) {
                starts.push(start);
            }
            (was_loaded, lowest) = (true, None);
        } else if size <= NEAR_ZERO * largest
            && lowest.is_none_or(|lowest| size <= loads[lowest].abs())
        {
            lowest = Some(index);
        }
    }
    let mut run = 1;
    let mut next = starts.into_iter().peekable();
    let of = |index| {
        if next.next_if_eq(&index).is_some() {
            run += 1;
        }
        run
    };
    (0..loads.len()).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_up_and_down() {
        let loads = [0.0, 10.0, 20.0, 10.0, 0.0, 0.0, 10.0, 20.0, 10.0, 0.0];
        assert_eq!(runs_of(&loads), [1, 1, 1, 1, 1, 2, 2, 2, 2, 2]);
    }

    #[test]
    fn steps_up_only_and_a_shared_zero() {
        assert_eq!(
            runs_of(&[1.0, 10.0, 20.0, 1.0, 10.0, 20.0]),
            [1, 1, 1, 2, 2, 2]
        );
        assert_eq!(runs_of(&[0.0, 20.0, 0.0, 20.0, 0.0]), [1, 1, 2, 2, 2]);
        assert_eq!(runs_of(&[-1.0, -20.0, -1.0, -20.0]), [1, 1, 2, 2]);
    }

    #[test]
    fn a_sign_that_changes_and_nothing_at_all() {
        // Without a load near zero in between, both signs are one run.
        assert_eq!(runs_of(&[20.0, -20.0]), [1, 1]);
        assert_eq!(runs_of(&[0.0, 0.0]), [1, 1]);
        assert_eq!(runs_of(&[]), [] as [u32; 0]);
    }
}
