//! Backward elimination: from a group of terms together to those that the rows need beside the others.

use super::constants::STRONG_EVIDENCE;
use super::forward::{ForwardProblem, evidence_of_terms, rivals};

/// Takes the term that the rows need least out of a model, again and again, until each that is left has strong evidence beside the others.
///
/// Terms that show together and hide each other alone are found this way, and forward selection misses them.
///
/// # Errors
/// That of the problem.
pub fn backward_elimination<P: ForwardProblem>(
    problem: &P,
    start: &P::Model,
) -> Result<P::Model, P::Error> {
    let mut model = start.clone();
    while problem.terms(&model) > 0 {
        let terms = evidence_of_terms(problem, &model)?.into_iter().enumerate();
        let weakest = terms.min_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((term, _)) = weakest.filter(|(_, evidence)| *evidence <= STRONG_EVIDENCE) else {
            break;
        };
        let rest = problem.without(&model, term)?;
        let terms = problem.terms(&rest);
        if terms == 0 {
            return Ok(rest);
        }
        // The last term put back finds parameters and covariance of what is left from each other.
        let ranked = rivals(problem, &rest, terms - 1)?;
        let last = ranked
            .iter()
            .find(|one| problem.is_term(&rest, terms - 1, one));
        model = match last {
            Some(last) => problem.with(last)?.unwrap_or(rest),
            None => rest,
        };
    }
    Ok(model)
}
