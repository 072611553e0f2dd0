//! Values of the parameters of a robot file, which may use one another.

use std::collections::HashMap;

use super::expression::{Expression, ExpressionError};
use super::file::OrderedTable;

/// Why a parameter has no value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum ParameterProblem {
    /// Its expression has none.
    Expression(ExpressionError),
    /// It needs itself, through these names.
    Circular(Vec<String>),
}

/// Values by name; each parameter is evaluated once, whatever the order they are listed in.
///
/// # Errors
/// The name of the parameter that has no value, and why.
pub(super) fn values(
    parameters: &OrderedTable<Expression>,
) -> Result<HashMap<&str, f64>, (&str, ParameterProblem)> {
    let needs: Vec<Vec<usize>> = parameters
        .values()
        .map(|expression| {
            let names = expression.names();
            // A name that is no parameter is reported where the expression is evaluated.
            names
                .iter()
                .filter_map(|name| parameters.get_index_of(name))
                .collect()
        })
        .collect();
    let mut values: HashMap<&str, f64> = HashMap::new();
    let mut open = vec![false; parameters.len()];
    // Parameters being evaluated, each with how many of its needs were checked: a stack of our own, because a chain of
    // parameters may be longer than the thread's stack is deep.
    let mut path: Vec<(usize, usize)> = Vec::new();
    for start in 0..parameters.len() {
        path.push((start, 0));
        while let Some((current, seen)) = path.pop() {
            let (name, expression) = parameters
                .get_index(current)
                .expect("indices come from the table");
            if values.contains_key(name.as_str()) {
                continue;
            }
            open[current] = true;
            let Some(&needed) = needs[current].get(seen) else {
                let lookup = |inner: &str| values.get(inner).copied();
                let value = expression
                    .value(&lookup)
                    .map_err(|problem| (name.as_str(), ParameterProblem::Expression(problem)))?;
                values.insert(name, value);
                open[current] = false;
                continue;
            };
            path.push((current, seen + 1));
            if open[needed] {
                return Err((
                    name,
                    ParameterProblem::Circular(around(parameters, &path, needed)),
                ));
            }
            path.push((needed, 0));
        }
    }
    Ok(values)
}

/// Names on the way from a parameter back to itself.
fn around(
    parameters: &OrderedTable<Expression>,
    path: &[(usize, usize)],
    needed: usize,
) -> Vec<String> {
    let on_path = path.iter().map(|(place, _)| *place);
    let cycle = on_path.skip_while(|place| *place != needed);
    cycle
        .chain(std::iter::once(needed))
        .filter_map(|place| parameters.get_index(place))
        .map(|(name, _)| name.clone())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(entries: &[(&str, &str)]) -> OrderedTable<Expression> {
        entries
            .iter()
            .map(|(name, text)| ((*name).to_owned(), Expression::Text((*text).to_owned())))
            .collect()
    }

    #[test]
    fn parameters_use_one_another_in_any_order() {
        let table = table(&[("a", "b + 1"), ("b", "c - 0.5"), ("c", "2")]);
        let values = values(&table).unwrap();
        assert_eq!([values["a"], values["b"], values["c"]], [2.5, 1.5, 2.0]);
    }

    #[test]
    fn a_circle_is_named() {
        let table = table(&[("a", "b"), ("b", "c"), ("c", "1 + b")]);
        let circular = ParameterProblem::Circular(vec!["b".into(), "c".into(), "b".into()]);
        assert_eq!(values(&table), Err(("c", circular)));
    }

    #[test]
    fn every_parameter_is_evaluated_once() {
        // Evaluating each use again would take 2^200 steps.
        let names: Vec<String> = (0..200).map(|i| format!("p{i}")).collect();
        let mut table: OrderedTable<Expression> = names
            .windows(2)
            .map(|pair| {
                let text = format!("{} - {}", pair[1], pair[1]);
                (pair[0].clone(), Expression::Text(text))
            })
            .collect();
        table.insert("p199".into(), Expression::Number(3.0));
        assert_eq!(values(&table).unwrap()["p0"], 0.0);
    }

    #[test]
    fn a_long_chain_does_not_exhaust_the_stack() {
        let mut table: OrderedTable<Expression> = (0..100_000)
            .map(|i| (format!("p{i}"), Expression::Text(format!("p{}", i + 1))))
            .collect();
        table.insert("p100000".into(), Expression::Number(1.0));
        assert_eq!(values(&table).unwrap()["p0"], 1.0);
    }
}
