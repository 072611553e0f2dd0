//! Sizes that cannot be: negative springs, and candidates beyond what is plausible.

use stiffbench_numeric::statistics::f_upper_tail;

use crate::search::LinearModel;
use crate::search::constants::OMNIBUS_LEVEL;

use super::find::Basis;
use super::findings::LoadCaseSearch;
use super::held_out_shares::displacement_rms;
use super::outcome::LoadCaseUnexplained;
use crate::elastostatics::outcome::micro_unit;
use crate::elastostatics::posed::PosedLoadCases;

/// A candidate with a size that it cannot have.
pub(super) struct ImpossibleTerm {
    /// Its place among the candidates.
    pub(super) term: usize,
    /// The size.
    pub(super) value: f64,
}

impl LoadCaseSearch<'_, '_> {
    /// The selected candidate that is farthest beyond its bounds, or takes more from a parameter than there is of it.
    pub(super) fn impossible_term(&self, model: &LinearModel) -> Option<ImpossibleTerm> {
        let values = parameters_after(self.basis, &model.fit.values);
        let sizes = &model.fit.values[self.basis.columns.len()..];
        let beyond = |term: usize, value: f64| -> f64 {
            let candidate = &self.candidates[term];
            let [lowest, highest] = candidate.bounds;
            let largest = |size: f64| if size.is_finite() { size.abs() } else { 0.0 };
            let range = largest(lowest).max(largest(highest));
            let outside = (lowest - value).max(value - highest);
            if outside > 0.0 {
                // Below zero there is no range to measure by.
                return if range > 0.0 { outside / range } else { 1.0 };
            }
            let Some((parameter, share)) = &candidate.takes_from else {
                return 0.0;
            };
            let name = parameter.to_string();
            let after = values.iter().find(|(known, _)| *known == name);
            let own = after.map_or_else(
                || self.basis.baseline.factors.get(parameter),
                |(_, own)| *own,
            );
            f64::from(u8::from(share * value > own))
        };
        let terms = model.terms.iter().zip(sizes);
        terms
            .map(|(&term, &value)| (beyond(term, value), ImpossibleTerm { term, value }))
            .filter(|(beyond, _)| *beyond > 0.0)
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, impossible)| impossible)
    }
}

/// Values of the free parameters beside what was found: springs by their change, factors by that of their logarithm.
pub(super) fn parameters_after(basis: &Basis, deltas: &[f64]) -> Vec<(String, f64)> {
    let estimates = &basis.baseline.estimates;
    let free = basis.free.iter().map(|&place| &estimates[place]);
    free.zip(deltas)
        .map(|(one, delta)| {
            let value = if one.parameter.is_factor() {
                one.value * delta.exp()
            } else {
                one.value + delta
            };
            (one.name.clone(), value)
        })
        .collect()
}

/// What the fit leaves because springs cannot be negative, if that is no noise (F test); its largest residual.
pub(super) fn negative_springs(
    posed: &PosedLoadCases,
    basis: &Basis,
    start: &LinearModel,
) -> Option<LoadCaseUnexplained> {
    let values = parameters_after(basis, &start.fit.values);
    let springs = basis.free.iter().zip(values).filter(|(place, (_, value))| {
        let parameter = &basis.baseline.estimates[**place].parameter;
        !parameter.is_factor() && *value < 0.0
    });
    let negative = springs.count() as f64;
    let dof = basis.residuals.len().saturating_sub(basis.columns.len()) as f64;
    let squares =
        |residuals: &[f64]| displacement_rms(posed, residuals).powi(2) * residuals.len() as f64;
    let (bounded, free) = (squares(&basis.residuals), squares(&start.fit.residuals));
    let lack = (bounded - free) / negative / (free / dof);
    if !lack.is_finite() || lack <= 0.0 {
        return None;
    }
    let p = f_upper_tail(lack, negative, dof).filter(|p| *p <= OMNIBUS_LEVEL)?;
    let rows = posed.rows().zip(&basis.residuals);
    let ((case, read), residual) = rows.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let agreement = basis.baseline.agreement.as_ref()?;
    let sd = agreement.sd()[usize::from(read.is_rotation())];
    Some(LoadCaseUnexplained {
        p,
        test: "springs that would have to be negative",
        pose: posed.labels[case.label].clone(),
        component: read.name(),
        size: *residual,
        unit: micro_unit(read.is_rotation()),
        standard_errors: (residual / sd?.max(f64::MIN_POSITIVE)).abs(),
    })
}
