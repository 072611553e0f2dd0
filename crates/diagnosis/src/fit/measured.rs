//! Measured stiffness as a fit takes it: the logarithm of each cell with what is known of its uncertainty.

use stiffbench_measurement::stiffness::{Method, PooledScatter, StiffnessTable};
use stiffbench_units_and_text::test_point::Cell;

/// Stiffness of one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredCell {
    /// Pose and direction.
    pub cell: Cell,
    /// Stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// What the cell's uncertainty of ln K consists of; `None` if nothing is known.
    pub ln_uncertainty: Option<LnUncertainty>,
    /// The same without what differs from run to run: its own part is from reading noise alone. `None` if that was not seen.
    pub reading_noise: Option<LnUncertainty>,
}

/// Standard uncertainty of ln K in parts, each relative (1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LnUncertainty {
    /// The cell's own, from the scatter of its readings and runs.
    pub own: f64,
    /// Effect of one standard uncertainty of the force gauge's calibration, common to all cells.
    pub force_calibration: f64,
    /// The same for the displacement gauge.
    pub displacement_calibration: f64,
}

impl LnUncertainty {
    /// All parts together.
    #[must_use]
    pub fn combined(&self) -> f64 {
        (self.own * self.own
            + self.force_calibration.powi(2)
            + self.displacement_calibration.powi(2))
        .sqrt()
    }
}

/// Where the cells' own uncertainties come from.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "basis")]
pub enum WeightBasis {
    /// Scatter of run slopes and of readings, each pooled over all cells.
    Pooled {
        /// Standard deviation of the slope from run to run, relative, that reading noise does not explain.
        run_slope_sd: f64,
        /// Degrees of freedom behind it.
        dof: f64,
    },
    /// Each cell's own scatter, because no cell has the three runs from which runs can be compared.
    EachCell,
    /// Reading noise of each cell, and a scatter from run to run that the residuals of the fit ask for: no cell has two runs to show it.
    FromResiduals {
        /// Standard deviation of the slope from run to run, relative.
        run_slope_sd: f64,
        /// Degrees of freedom behind it: cells less free factors.
        dof: f64,
    },
    /// Stated with the stiffness values.
    Stated,
    /// Nothing is known: all cells weigh the same.
    Equal,
}

impl WeightBasis {
    /// Degrees of freedom behind the weights; infinite for stated ones.
    #[must_use]
    pub fn dof(self) -> f64 {
        match self {
            Self::Pooled { dof, .. } | Self::FromResiduals { dof, .. } => dof,
            Self::EachCell | Self::Stated | Self::Equal => f64::INFINITY,
        }
    }
}

/// Measured stiffness of all cells.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredStiffness {
    /// The cells, in the order of the data.
    pub cells: Vec<MeasuredCell>,
    /// Where the uncertainties come from.
    pub basis: WeightBasis,
    /// Cells of the data without a usable stiffness, with the reason.
    pub unusable: Vec<(Cell, String)>,
}

impl MeasuredStiffness {
    /// Takes the stiffness by `method` of every cell of a table.
    ///
    /// The scatter from run to run of one cell rests on as many degrees of freedom as it has runs less one, four with five repeats;
    /// weights from so few would make some cells count far too much by chance, and intervals too short. What makes a run's slope
    /// differ from the next one's (seating, friction in the jack) is relative and common to all cells, what reading noise adds is
    /// known from the readings: the first is pooled over the cells, u² = s²/n + σ²/(c² Σ(F - F̄)²), with n runs and compliance c.
    #[must_use]
    pub fn from_table(table: &StiffnessTable, method: Method) -> Self {
        let scatter = table.pooled_scatter.unwrap_or(PooledScatter::UNSEEN);
        let lines = table.cells.iter().filter_map(|row| row.line.as_ref().ok());
        let readings = table
            .pooled_scatter
            .or_else(|| PooledScatter::about_lines(lines));
        let pooled = table.run_slope.map(|run_slope| (run_slope, scatter));
        let mut measured = Self {
            cells: Vec::new(),
            basis: match pooled {
                Some((run_slope, _)) => WeightBasis::Pooled {
                    run_slope_sd: run_slope.variance.sqrt(),
                    dof: run_slope.dof,
                },
                None => WeightBasis::EachCell,
            },
            unusable: Vec::new(),
        };
        for row in &table.cells {
            let estimate = match row.by(method) {
                Ok(estimate) if estimate.estimate.value > 0.0 => estimate,
                Ok(estimate) => {
                    let reason = format!(
                        "its stiffness is {:.4e} N/m, which no structure has",
                        estimate.estimate.value
                    );
                    measured.unusable.push((row.cell.clone(), reason));
                    continue;
                }
                Err(reason) => {
                    measured
                        .unusable
                        .push((row.cell.clone(), reason.to_string()));
                    continue;
                }
            };
            let line = row.line.as_ref().ok();
            let of_cell = pooled
                .zip(line)
                .and_then(|((run_slope, scatter), line)| run_slope.of_cell(line, &scatter));
            let own = of_cell.map(f64::sqrt).or(estimate.ln_parts.independent);
            let with_own = |own: f64| LnUncertainty {
                own,
                force_calibration: estimate.ln_parts.force_calibration,
                displacement_calibration: estimate.ln_parts.displacement_calibration,
            };
            let of_readings = readings.zip(line);
            let of_readings = of_readings.and_then(|(scatter, line)| scatter.slope_variance(line));
            measured.cells.push(MeasuredCell {
                cell: row.cell.clone(),
                stiffness_n_per_m: estimate.estimate.value,
                ln_uncertainty: own.map(with_own),
                reading_noise: of_readings.map(f64::sqrt).map(with_own),
            });
        }
        measured.weigh_all_or_none();
        measured
    }

    /// The cells of several sessions, each with the uncertainty that its own session shows; a cell measured in two of them counts twice.
    #[must_use]
    pub fn joined(sessions: &[Self]) -> Self {
        let pooled = sessions.iter().map(|session| match session.basis {
            WeightBasis::Pooled { run_slope_sd, dof } => Some((run_slope_sd, dof)),
            _ => None,
        });
        let pooled: Option<Vec<(f64, f64)>> = pooled.collect();
        let basis = pooled.map_or(WeightBasis::EachCell, |pooled| {
            let dof: f64 = pooled.iter().map(|(_, dof)| dof).sum();
            let squares: f64 = pooled.iter().map(|(sd, dof)| sd * sd * dof).sum();
            WeightBasis::Pooled {
                run_slope_sd: (squares / dof.max(f64::MIN_POSITIVE)).sqrt(),
                dof,
            }
        });
        let mut joined = Self {
            cells: sessions.iter().flat_map(|one| one.cells.clone()).collect(),
            basis,
            unusable: sessions
                .iter()
                .flat_map(|one| one.unusable.clone())
                .collect(),
        };
        joined.weigh_all_or_none();
        joined
    }

    /// Weights are either known for all cells or used for none: one cell without would otherwise have to be guessed.
    fn weigh_all_or_none(&mut self) {
        if self.cells.iter().any(|cell| cell.ln_uncertainty.is_none()) {
            for cell in &mut self.cells {
                cell.ln_uncertainty = None;
            }
            self.basis = WeightBasis::Equal;
        }
    }

    /// The cells of the named poses, or all others.
    #[must_use]
    pub fn select(&self, keep: impl Fn(&Cell) -> bool) -> Self {
        Self {
            cells: self
                .cells
                .iter()
                .filter(|cell| keep(&cell.cell))
                .cloned()
                .collect(),
            basis: self.basis,
            unusable: self.unusable.clone(),
        }
    }

    /// Whether every cell has an uncertainty.
    #[must_use]
    pub fn has_uncertainties(&self) -> bool {
        !self.cells.is_empty() && self.cells.iter().all(|cell| cell.ln_uncertainty.is_some())
    }
}
