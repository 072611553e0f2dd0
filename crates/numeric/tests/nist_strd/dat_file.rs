//! The files of NIST's Statistical Reference Datasets for nonlinear regression.

/// One certified problem.
pub(crate) struct Certified {
    /// Two starts, the far and the near one.
    pub(crate) starts: [Vec<f64>; 2],
    pub(crate) parameters: Vec<f64>,
    pub(crate) standard_deviations: Vec<f64>,
    pub(crate) residual_sum_of_squares: f64,
    pub(crate) residual_standard_deviation: f64,
    /// Response, then one or two predictors (the second is 0 if there is one).
    pub(crate) observations: Vec<(f64, [f64; 2])>,
}

fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace()
        .map(|word| word.parse().unwrap())
        .collect()
}

fn value_after(text: &str, title: &str) -> f64 {
    let line = text.lines().find(|line| line.starts_with(title)).unwrap();
    line[title.len()..].trim().parse().unwrap()
}

/// Reads `<name>.dat`; the header has fixed places: parameters from line 41, data from line 61.
pub(crate) fn read(name: &str) -> Certified {
    let folder = stiffbench_test_files::repository().join("fixtures/nist-strd/nonlinear");
    let text = std::fs::read_to_string(folder.join(format!("{name}.dat"))).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let rows: Vec<Vec<f64>> = lines[40..60]
        .iter()
        .take_while(|line| line.contains('='))
        .map(|line| numbers(line.split_once('=').unwrap().1))
        .collect();
    let column = |k: usize| rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
    let observations: Vec<(f64, [f64; 2])> = lines[60..]
        .iter()
        .filter(|line| !line.trim().is_empty())
        .map(|line| {
            let row = numbers(line);
            (row[0], [row[1], row.get(2).copied().unwrap_or(0.0)])
        })
        .collect();
    assert_eq!(
        observations.len(),
        value_after(&text, "Number of Observations:") as usize
    );
    Certified {
        starts: [column(0), column(1)],
        parameters: column(2),
        standard_deviations: column(3),
        residual_sum_of_squares: value_after(&text, "Residual Sum of Squares:"),
        residual_standard_deviation: value_after(&text, "Residual Standard Deviation:"),
        observations,
    }
}

/// Reads a linear problem: (estimate, standard deviation) of each parameter, and the lines of data, y first.
pub(crate) fn read_linear(name: &str) -> (Vec<(f64, f64)>, Vec<Vec<f64>>) {
    let folder = stiffbench_test_files::repository().join("fixtures/nist-strd/linear");
    let text = std::fs::read_to_string(folder.join(format!("{name}.dat"))).unwrap();
    let certified = text
        .lines()
        .filter_map(|line| {
            let words: Vec<&str> = line.split_whitespace().collect();
            let is_parameter = words.len() == 3 && words[0].starts_with('B');
            is_parameter.then(|| (words[1].parse().unwrap(), words[2].parse().unwrap()))
        })
        .collect();
    let data = text
        .lines()
        .skip(60)
        .filter(|line| !line.trim().is_empty())
        .map(numbers)
        .collect();
    (certified, data)
}
