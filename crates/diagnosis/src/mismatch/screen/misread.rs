//! Values of a table that were recorded wrongly and agree with all others once they are put right: poses or components exchanged, another unit, sign
//! or decimal point.
//!
//! With y what the model leaves of the values as recorded and y - d as corrected, the model fitted anew for every mistake that may have been made,
//! each beside one more mistake of the model if that explains more, a mistake that was made leaves y in the direction of d. Two chances are asked
//! for, the larger of which counts:
//!
//! - that the residuals of all values, by unknown physics of whatever direction, lie as near to d of any mistake (the angle between a fixed direction
//!   and one at random: Muirhead, Aspects of Multivariate Statistical Theory, 1982, theorem 1.5.7);
//! - that these values alone, off by anything, come as near to what the mistake gives.
//!
//! So nothing is compared with the scatter of readings, and physics that the model lacks does not count for a mistake unless it imitates one.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use stiffbench_numeric::statistics::f_upper_tail;

use super::usual_factor::{alike, usual_factors};
use crate::search::constants::{BAD_READING_LEVEL, COLUMN_LEFT, STRONG_EVIDENCE};
use crate::search::{FittedRows, chance_of_any};

/// Chance that cells which are off by anything look exchanged, or as if their decimal point were wrong (1). Stated.
const BY_COINCIDENCE: f64 = 0.01;

/// Mistakes in the names of cells that are fitted in full (1): those that explain most if the model is linear. Numerics.
const MISTAKES_FITTED: usize = 12;

/// Poses that stand farther apart in a table than this are not exchanged (1): somebody takes the next line, or one near it. By judgement.
const MOST_APART: usize = 50;

/// What a value is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct ValueName {
    pub(crate) pose: usize,
    /// What was read.
    pub(crate) component: usize,
    /// What it is a value of: only components of one kind are exchanged.
    pub(crate) kind: usize,
    /// The load: values that are exchanged have it in common.
    pub(crate) load: usize,
}

/// A value that was read, or is put right, with its standard error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NamedValue {
    pub(crate) value: f64,
    pub(crate) u: f64,
}

/// The scale on which values are compared with a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ValueScale {
    Linear,
    Logarithmic,
}

impl ValueScale {
    /// A value multiplied by a factor; `None` if it cannot be one.
    fn times(self, value: f64, factor: f64) -> Option<f64> {
        match self {
            Self::Linear => Some(value * factor),
            Self::Logarithmic => (factor > 0.0).then(|| value + factor.ln()),
        }
    }

    /// A value on this scale.
    pub(crate) fn scaled(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithmic => value.ln(),
        }
    }

    /// What a value of this scale is, and its standard error.
    pub(crate) fn unscaled(self, value: f64, u: f64) -> (f64, f64) {
        match self {
            Self::Linear => (value, u),
            Self::Logarithmic => (value.exp(), u * value.exp()),
        }
    }

    /// How many times as long a value is that is multiplied by a factor (1).
    fn lengthened(self, factor: f64) -> f64 {
        match self {
            Self::Linear => factor.abs(),
            Self::Logarithmic => 1.0,
        }
    }
}

/// A fit of the model to values.
#[derive(Debug, Clone)]
pub(crate) struct ValueFit {
    /// Weighted squares.
    pub(crate) squares: f64,
    /// The values that it predicts.
    pub(crate) predicted: Vec<f64>,
    /// Derivatives of the weighted residuals to the parameters, one column each: the values first, then what else is known.
    pub(crate) columns: Vec<Vec<f64>>,
    pub(crate) parameters: Vec<f64>,
}

/// Values of a table, and what there is to know of them beside a model.
pub(crate) struct RecordedValues {
    pub(crate) names: Vec<ValueName>,
    /// As recorded.
    pub(crate) values: Vec<NamedValue>,
    pub(crate) scale: ValueScale,
    /// How many values the same factor must have changed at least, unless it is one that all agree with.
    pub(crate) fewest: usize,
    /// Least variance of what a fit leaves, in units of `u`: 1 where `u` is known, 0 where a fit alone shows the scatter.
    pub(crate) least_variance: f64,
}

/// A model of the values of a table.
pub(crate) trait ValueModel {
    /// How many parameters are free.
    fn free(&self) -> usize;

    /// How many single mistakes of the model there may be.
    fn alternatives(&self) -> usize {
        0
    }

    /// Whether a mistake may have drawn the fit so far from where it would be that what is linear about it says little.
    fn may_be_drawn(&self, read: &[NamedValue], as_recorded: &ValueFit) -> bool;

    /// Fits the model, with one mistake of it or none, to some of the values; `None` where that fails.
    ///
    /// # Arguments
    /// - `start`: a fit from which to start.
    fn fit(
        &mut self,
        values: &[NamedValue],
        keep: &dyn Fn(usize) -> bool,
        alternative: Option<usize>,
        start: Option<&ValueFit>,
    ) -> Option<ValueFit>;
}

/// What may have been done to a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ValueChange {
    /// It has the name of another.
    NameOf(usize),
    /// It agrees once it is multiplied by this.
    Times(f64),
}

/// What the values of another were recorded under.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Exchanged {
    Pose(usize),
    Component(usize),
}

/// Values that somebody recorded wrongly in one way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Mistake {
    /// Their pose; `None` of all.
    pub(crate) pose: Option<usize>,
    /// Their component; `None` of all.
    pub(crate) component: Option<usize>,
    /// What was exchanged with theirs.
    pub(crate) exchanged_with: Option<Exchanged>,
    /// Of each value that it changes.
    pub(crate) changes: Vec<(usize, ValueChange)>,
}

/// A mistake that was made, by all that the values show.
pub(crate) struct FoundMistake {
    pub(crate) mistake: Mistake,
    /// The values put right, and the fit to them.
    pub(crate) corrected: Vec<NamedValue>,
    pub(crate) fit: ValueFit,
    /// Variance of what the fit leaves, in units of `u`.
    pub(crate) variance: f64,
    /// Chance that values without it look as if it had been made.
    pub(crate) p: f64,
}

impl Mistake {
    /// The values that it changes.
    fn places(&self) -> BTreeSet<usize> {
        self.changes.iter().map(|(place, _)| *place).collect()
    }

    /// What was read, put right.
    fn corrected(&self, table: &RecordedValues) -> Vec<NamedValue> {
        let read = &table.values;
        let mut out = read.clone();
        for (place, change) in &self.changes {
            match change {
                ValueChange::NameOf(other) => out[*place] = read[*other],
                ValueChange::Times(factor) => {
                    let right = table.scale.times(read[*place].value, *factor);
                    out[*place].value = right.expect("only possible factors are tried");
                }
            }
        }
        out
    }

    /// How many values of the same places would be such a mistake too.
    fn alike(&self) -> f64 {
        match self.changes.first() {
            Some((_, ValueChange::Times(factor))) => alike(*factor),
            _ => 1.0,
        }
    }

    /// How many times as long each value is that it puts right.
    fn lengthened(&self, scale: ValueScale) -> f64 {
        match self.changes.first() {
            Some((_, ValueChange::Times(factor))) => scale.lengthened(*factor),
            _ => 1.0,
        }
    }

    /// Tells of all that are considered: a component of a pose, a pose or a component multiplied by a usual factor; two components or two poses exchanged, there
    /// or everywhere.
    fn all(table: &RecordedValues, mut tell: impl FnMut(Self)) {
        let names = &table.names;
        let mut sets: BTreeMap<(Option<usize>, Option<usize>), Vec<usize>> = BTreeMap::new();
        for (place, name) in names.iter().enumerate() {
            let (pose, component) = (Some(name.pose), Some(name.component));
            for key in [(pose, component), (pose, None), (None, component)] {
                sets.entry(key).or_default().push(place);
            }
        }
        let of_names: HashMap<ValueName, usize> = names.iter().copied().zip(0..).collect();
        let kinds = names.iter().map(|name| (name.component, name.kind));
        let kinds: &BTreeMap<usize, usize> = &kinds.collect();
        let poses: BTreeSet<usize> = names.iter().map(|name| name.pose).collect();
        let mut known = BTreeSet::new();
        for (&(pose, component), set) in &sets {
            let of_component = component.into_iter().flat_map(|own| {
                let others = kinds
                    .range(own + 1..)
                    .filter(move |(other, _)| kinds[other] == kinds[&own]);
                others.map(|(other, _)| Exchanged::Component(*other))
            });
            let of_pose = pose
                .into_iter()
                .flat_map(|own| poses.range(own + 1..=own + MOST_APART));
            let others = of_component.chain(of_pose.map(|other| Exchanged::Pose(*other)));
            for with in others {
                let renamed = |name: ValueName| match with {
                    Exchanged::Pose(pose) => ValueName { pose, ..name },
                    Exchanged::Component(component) => ValueName { component, ..name },
                };
                let pairs = set
                    .iter()
                    .filter_map(|place| Some((*place, *of_names.get(&renamed(names[*place]))?)));
                let both = pairs.flat_map(|(a, b)| [(a, b), (b, a)]);
                let changes: Vec<(usize, ValueChange)> = both
                    .map(|(place, other)| (place, ValueChange::NameOf(other)))
                    .collect();
                if !changes.is_empty() {
                    tell(Self {
                        pose,
                        component,
                        exchanged_with: Some(with),
                        changes,
                    });
                }
            }
            let others = names.len() - set.len();
            let is_seen = set.len() >= table.fewest && others >= set.len();
            // Of equal sets the narrower comes first.
            if is_seen && known.insert(set) {
                let is_possible = |factor: &f64| {
                    let mut all = set.iter().map(|place| table.values[*place].value);
                    all.all(|value| table.scale.times(value, *factor).is_some())
                };
                for factor in usual_factors().filter(is_possible) {
                    let changes = set.iter().map(|place| (*place, ValueChange::Times(factor)));
                    tell(Self {
                        pose,
                        component,
                        exchanged_with: None,
                        changes: changes.collect(),
                    });
                }
            }
        }
    }
}

/// By what mistakes are compared: -2 ln of the likelihood of what was read, the scatter fitted with the model.
///
/// What agrees once it is multiplied by f has f times the density of what was read: else whatever makes values small would seem to leave little.
#[derive(Debug, Clone, Copy)]
struct MistakeLikelihood {
    scale: ValueScale,
    dof: f64,
    /// Less than the scatter no fit leaves but by luck.
    least_variance: f64,
}

impl MistakeLikelihood {
    fn variance(self, squares: f64) -> f64 {
        let variance = (squares / self.dof).max(self.least_variance);
        variance.max(f64::MIN_POSITIVE)
    }

    /// -2 ln of it, but for a constant.
    ///
    /// # Arguments
    /// - `squares`: what a fit leaves of the values put right.
    fn deviance(self, mistake: Option<&Mistake>, squares: f64) -> f64 {
        let longer = mistake.map_or(0.0, |mistake| {
            mistake.changes.len() as f64 * mistake.lengthened(self.scale).ln()
        });
        self.dof * self.variance(squares).ln() - 2.0 * longer
    }
}

/// A mistake, fitted.
struct FittedMistake {
    mistake: Mistake,
    corrected: Vec<NamedValue>,
    alternative: Option<usize>,
    fit: ValueFit,
}

impl FittedMistake {
    fn deviance(&self, likelihood: MistakeLikelihood) -> f64 {
        likelihood.deviance(Some(&self.mistake), self.fit.squares)
    }
}

/// Finds the mistake that was made in a table.
pub(crate) fn find_mistake(
    table: &RecordedValues,
    model: &mut dyn ValueModel,
) -> Option<FoundMistake> {
    let read = &table.values;
    // One more mistake of the model may be made, and one direction is that of the mistake of the table.
    let dof = read.len().checked_sub(model.free() + 2)?;
    let dof = Some(dof as f64).filter(|dof| *dof > 0.0)?;
    let likelihood = MistakeLikelihood {
        scale: table.scale,
        dof,
        least_variance: table.least_variance,
    };
    let as_recorded = model.fit(read, &|_| true, None, None)?;
    let Nearest {
        mistakes,
        considered,
        left,
    } = nearest(table, model, &as_recorded, likelihood);
    let tried = (considered * (1 + model.alternatives())) as f64;
    let chance = |before: f64, after: f64| {
        let ratio = (before - after).max(0.0) / likelihood.variance(after);
        chance_of_any(0.5 * f_upper_tail(ratio, 1.0, dof).unwrap_or(1.0), tried)
    };
    if chance(as_recorded.squares, left) > BAD_READING_LEVEL {
        return None;
    }
    let mut fitted: Vec<FittedMistake> = Vec::new();
    for mistake in mistakes {
        let corrected = mistake.corrected(table);
        let fit = model.fit(&corrected, &|_| true, None, None);
        fitted.extend(fit.map(|fit| FittedMistake {
            mistake,
            corrected,
            alternative: None,
            fit,
        }));
    }
    let by_deviance = |a: &FittedMistake, b: &FittedMistake| {
        a.deviance(likelihood).total_cmp(&b.deviance(likelihood))
    };
    fitted.sort_by(by_deviance);
    fitted.truncate(MISTAKES_FITTED);
    let (_, before) = best_fit(model, read, &as_recorded)?;
    // A mistake that was made leaves less by itself than any other mistake of the model.
    let without = likelihood.deviance(None, before.squares);
    fitted.retain(|one| one.deviance(likelihood) < without);
    for one in &mut fitted {
        if let Some((alternative, fit)) = best_fit(model, &one.corrected, &one.fit) {
            (one.alternative, one.fit) = (alternative, fit);
        }
    }
    fitted.sort_by(by_deviance);
    let chosen = unambiguous(&fitted, likelihood)?;
    // The values by themselves: their distance from what all others predict, as recorded and as corrected.
    let changed = chosen.mistake.places();
    let is_other = |place| !changed.contains(&place);
    let (fit, alternative) = (&chosen.fit, chosen.alternative);
    let of_others = model.fit(&chosen.corrected, &is_other, alternative, Some(fit));
    let of_others = of_others.map_or(0.0, |fit| fit.squares);
    let variance = likelihood.variance(chosen.fit.squares);
    let seen = (changed.len() as f64).min(dof);
    let lengthened = chosen.mistake.lengthened(likelihood.scale);
    let near = (chosen.fit.squares - of_others).max(seen * variance);
    // In the unit of the corrected values too.
    let far = (lengthened.powi(2) * (before.squares - of_others)).max(near);
    let by_coincidence = chosen.mistake.alike() * (near / far).powf(0.5 * seen);
    let p = chance(before.squares, chosen.fit.squares);
    if p > BAD_READING_LEVEL || by_coincidence > BY_COINCIDENCE {
        return None;
    }
    Some(FoundMistake {
        mistake: chosen.mistake.clone(),
        corrected: chosen.corrected.clone(),
        fit: chosen.fit.clone(),
        variance,
        p: p.max(by_coincidence),
    })
}

/// The fit that leaves least, with one mistake of the model or none.
fn best_fit(
    model: &mut dyn ValueModel,
    values: &[NamedValue],
    start: &ValueFit,
) -> Option<(Option<usize>, ValueFit)> {
    let all = std::iter::once(None).chain((0..model.alternatives()).map(Some));
    let fitted = all.filter_map(|alternative| {
        let fit = model.fit(values, &|_| true, alternative, Some(start))?;
        Some((alternative, fit))
    });
    fitted.min_by(|(_, a), (_, b)| a.squares.total_cmp(&b.squares))
}

/// Mistakes that may have been made.
struct Nearest {
    mistakes: Vec<Mistake>,
    /// How many were considered.
    considered: usize,
    /// Squares below which none of them leaves less.
    left: f64,
}

/// The mistakes that leave least if the model is linear about its fit to what was recorded; where they may have drawn that fit also those of whole
/// components, which it takes for its parameters.
fn nearest(
    table: &RecordedValues,
    model: &dyn ValueModel,
    as_recorded: &ValueFit,
    likelihood: MistakeLikelihood,
) -> Nearest {
    let read = &table.values;
    let rows = as_recorded.columns.first().map_or(read.len(), Vec::len);
    let of_places = |values: &mut dyn Iterator<Item = (usize, f64)>| {
        let mut column = vec![0.0; rows];
        for (place, value) in values {
            column[place] = value / read[place].u;
        }
        column
    };
    let left = as_recorded.predicted.iter().zip(read);
    let left = left.map(|(predicted, read)| predicted - read.value);
    let mut fitted = FittedRows::new(of_places(&mut left.enumerate()));
    for column in &as_recorded.columns {
        fitted.set_free(column.clone().into(), COLUMN_LEFT * COLUMN_LEFT);
    }
    // The squares of the residual of what was put right.
    let squares = |mistake: &Mistake| {
        let mut changes = mistake.changes.iter().map(|(place, change)| {
            let own = read[*place].value;
            let right = match change {
                ValueChange::NameOf(other) => read[*other].value,
                ValueChange::Times(factor) => table.scale.times(own, *factor).unwrap_or(own),
            };
            (*place, own - right)
        });
        let shift = fitted.shift(of_places(&mut changes).into());
        (as_recorded.squares + 2.0 * shift.product + shift.square).max(0.0)
    };
    let is_drawn = model.may_be_drawn(read, as_recorded);
    let (mut near, mut whole, mut count) = (Vec::new(), Vec::new(), 0);
    let mut left = if is_drawn { 0.0 } else { as_recorded.squares };
    Mistake::all(table, |mistake| {
        count += 1;
        let squares = squares(&mistake);
        left = f64::min(left, squares);
        if mistake.pose.is_none() && is_drawn {
            whole.push(mistake);
        } else {
            let deviance = likelihood.deviance(Some(&mistake), squares);
            let place = near.partition_point(|(other, _)| *other <= deviance);
            if place < MISTAKES_FITTED {
                near.insert(place, (deviance, mistake));
                near.truncate(MISTAKES_FITTED);
            }
        }
    });
    let near = near.into_iter().map(|(_, mistake)| mistake);
    Nearest {
        mistakes: whole.into_iter().chain(near).collect(),
        considered: count,
        left,
    }
}

/// Of the mistakes that explain about as much as the best the one with the fewest values, if the others have all of its values too.
fn unambiguous(fitted: &[FittedMistake], likelihood: MistakeLikelihood) -> Option<&FittedMistake> {
    let within = fitted.first()?.deviance(likelihood) + 2.0 * STRONG_EVIDENCE;
    let near = || {
        fitted
            .iter()
            .filter(|one| one.deviance(likelihood) <= within)
    };
    let chosen = near().min_by_key(|one| one.mistake.places().len())?;
    let own = chosen.mistake.places();
    near()
        .all(|one| own.is_subset(&one.mistake.places()))
        .then_some(chosen)
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    const POSES: usize = 8;
    const LOADS: usize = 3;
    const COMPONENTS: usize = 3;

    /// Values that are linear in four parameters.
    struct LinearModel(DMatrix<f64>);

    /// Numbers between -1 and 1 that look random.
    fn number(place: usize) -> f64 {
        (12.9898 * (place + 1) as f64).sin() * 43_758.545 % 1.0
    }

    impl LinearModel {
        fn new() -> (RecordedValues, Self) {
            let all = (0..POSES).flat_map(|pose| {
                let loads = 0..LOADS;
                loads.flat_map(move |load| {
                    (0..COMPONENTS).map(move |component| ValueName {
                        pose,
                        component,
                        kind: 0,
                        load,
                    })
                })
            });
            let names: Vec<ValueName> = all.collect();
            let columns = DMatrix::from_fn(names.len(), 4, |row, one| number(4 * row + one));
            let exact = &columns * DVector::from_vec(vec![3.0, 2.0, 4.0, 1.5]);
            let values = exact.iter().enumerate().map(|(row, exact)| NamedValue {
                value: exact + 0.02 * number(7000 + row),
                u: 0.02,
            });
            let table = RecordedValues {
                values: values.collect(),
                names,
                scale: ValueScale::Linear,
                fewest: 3,
                least_variance: 0.0,
            };
            (table, Self(columns))
        }
    }

    fn of(table: &RecordedValues, is_meant: impl Fn(ValueName) -> bool) -> Vec<usize> {
        let all = 0..table.names.len();
        all.filter(|place| is_meant(table.names[*place])).collect()
    }

    impl ValueModel for LinearModel {
        fn free(&self) -> usize {
            4
        }

        fn may_be_drawn(&self, _read: &[NamedValue], _as_recorded: &ValueFit) -> bool {
            false
        }

        fn fit(
            &mut self,
            values: &[NamedValue],
            keep: &dyn Fn(usize) -> bool,
            _alternative: Option<usize>,
            _start: Option<&ValueFit>,
        ) -> Option<ValueFit> {
            let weight = |row: usize| if keep(row) { 1.0 / values[row].u } else { 0.0 };
            let white =
                DMatrix::from_fn(values.len(), 4, |row, one| weight(row) * self.0[(row, one)]);
            let read = DVector::from_fn(values.len(), |row, _| weight(row) * values[row].value);
            let parameters = white.clone().svd(true, true).solve(&read, 1e-12).ok()?;
            Some(ValueFit {
                squares: (&white * &parameters - read).norm_squared(),
                predicted: (&self.0 * &parameters).iter().copied().collect(),
                columns: white
                    .column_iter()
                    .map(|one| one.iter().copied().collect())
                    .collect(),
                parameters: Vec::new(),
            })
        }
    }

    #[test]
    fn nothing_is_found_in_a_table_without_a_mistake() {
        let (table, mut model) = LinearModel::new();
        assert!(find_mistake(&table, &mut model).is_none());
    }

    #[test]
    fn a_usual_factor_is_found_where_it_is() {
        for factor in [-1.0, 10.0, 1e-3, 25.4, 1.0 / 9.806_65] {
            for (pose, component) in [(Some(3), None), (None, Some(1)), (Some(5), Some(2))] {
                let (mut table, mut model) = LinearModel::new();
                let is_meant = |name: ValueName| {
                    pose.is_none_or(|pose| pose == name.pose)
                        && component.is_none_or(|component| component == name.component)
                };
                for place in of(&table, is_meant) {
                    table.values[place].value /= factor;
                }
                let found = find_mistake(&table, &mut model).unwrap().mistake;
                assert_eq!((found.pose, found.component), (pose, component), "{factor}");
                let ValueChange::Times(times) = found.changes[0].1 else {
                    panic!("{found:?}");
                };
                assert!((times / factor - 1.0).abs() < 1e-9, "{times} for {factor}");
            }
        }
        // Twice the value is no usual mistake.
        let (mut table, mut model) = LinearModel::new();
        for place in of(&table, |name| name.pose == 3) {
            table.values[place].value *= 2.0;
        }
        assert!(find_mistake(&table, &mut model).is_none());
    }

    #[test]
    fn poses_and_components_that_are_exchanged_are_found() {
        let of_pose = |name: ValueName| ValueName { pose: 6, ..name };
        let of_component = |name: ValueName| ValueName {
            component: 2,
            ..name
        };
        type Renamed<'r> = &'r dyn Fn(ValueName) -> ValueName;
        let cases: [(Option<usize>, Option<usize>, Exchanged, Renamed<'_>); 3] = [
            (Some(2), None, Exchanged::Pose(6), &of_pose),
            (None, Some(0), Exchanged::Component(2), &of_component),
            (Some(4), Some(1), Exchanged::Component(2), &of_component),
        ];
        for (pose, component, with, renamed) in cases {
            let (mut table, mut model) = LinearModel::new();
            let is_meant = |name: ValueName| {
                pose.is_none_or(|pose| pose == name.pose)
                    && component.is_none_or(|component| component == name.component)
            };
            for place in of(&table, is_meant) {
                let other = renamed(table.names[place]);
                let other = table.names.iter().position(|name| *name == other).unwrap();
                table.values.swap(place, other);
            }
            let found = find_mistake(&table, &mut model).unwrap().mistake;
            let named = (found.pose, found.component, found.exchanged_with);
            assert_eq!(named, (pose, component, Some(with)));
        }
    }
}
