//! Measured stiffness as a fit takes it: the logarithm of each cell, and of several gauges the compliances along the other axes, with what is
//! known of their uncertainty.

use nalgebra::DMatrix;
use stiffbench_measurement::stiffness::{Method, PooledScatter, StiffnessTable};
use stiffbench_measurement::stiffness_list::ListedStiffness;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::Cell;

use crate::mismatch::CellSlopes;

/// Stiffness of one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredCell {
    /// Pose and direction.
    pub cell: Cell,
    /// Line of the list that states it, from 1; 0 if none does.
    pub line: u32,
    /// Stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// What the cell's uncertainty of ln K consists of; `None` if nothing is known.
    pub ln_uncertainty: Option<LnUncertainty>,
    /// The same without what differs from run to run: its own part is from reading noise alone. `None` if that was not seen.
    pub reading_noise: Option<LnUncertainty>,
}

/// Standard uncertainty of ln K in parts, each relative (1).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
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
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Default,
    serde::Serialize,
    serde::Deserialize,
    schemars::JsonSchema,
)]
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
    #[default]
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

/// Displacement per force along another axis than that of the load, by one of several gauges that were read at once.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredCompliance {
    /// Pose, axis and load.
    pub cell: Cell,
    /// Direction of the load.
    pub load: LoadDirection,
    /// The compliance, m/N.
    pub compliance_m_per_n: f64,
    /// Its own standard uncertainty, m/N: without repeats that from reading noise alone.
    pub u_m_per_n: f64,
    /// Effect of one standard uncertainty of the calibration of the force and of the displacement, m/N.
    pub calibration_m_per_n: [f64; 2],
}

/// Measured stiffness of all cells.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasuredStiffness {
    /// The cells, in the order of the data.
    pub cells: Vec<MeasuredCell>,
    /// Compliances along other axes than that of the load.
    pub across: Vec<MeasuredCompliance>,
    /// Covariance of what cells and compliances scatter by themselves: of the ln K, then of the compliances, m/N. `None` if they have nothing in
    /// common, or nothing is known.
    pub own_covariance: Option<DMatrix<f64>>,
    /// Where the uncertainties come from.
    pub basis: WeightBasis,
    /// Cells of the data without a usable stiffness, with the reason.
    pub unusable: Vec<(Cell, String)>,
}

impl MeasuredStiffness {
    /// The values of a list; their uncertainties only where all have one.
    #[must_use]
    pub fn of_list(list: &[ListedStiffness]) -> Self {
        let stated = list.iter().all(|one| one.relative_u.is_some());
        let measured = |one: &ListedStiffness| MeasuredCell {
            cell: one.cell.clone(),
            line: one.line,
            stiffness_n_per_m: one.stiffness_n_per_m,
            ln_uncertainty: one.relative_u.filter(|_| stated).map(|own| LnUncertainty {
                own,
                ..LnUncertainty::default()
            }),
            reading_noise: None,
        };
        Self {
            cells: list.iter().map(measured).collect(),
            basis: if stated {
                WeightBasis::Stated
            } else {
                WeightBasis::Equal
            },
            ..Self::default()
        }
    }

    /// Takes the stiffness by `method` of every cell of a table.
    ///
    /// The scatter from run to run of one cell rests on as many degrees of freedom as it has runs less one, four with five repeats;
    /// weights from so few would make some cells count far too much by chance, and intervals too short. What makes a run's slope
    /// differ from the next one's (seating, friction in the jack) is relative and common to all cells, what reading noise adds is
    /// known from the readings: the first is pooled over the cells, u² = s²/n + σ²/(c² Σ(F - F̄)²), with n runs and compliance c.
    #[must_use]
    pub fn from_table(table: &StiffnessTable, method: Method) -> Self {
        Self::of(table, method, None)
    }

    /// Takes the stiffness of every cell from the slopes of its readings; the table has what they do not: calibration, and cells without a
    /// stiffness.
    #[must_use]
    pub fn from_slopes(table: &StiffnessTable, slopes: &CellSlopes) -> Self {
        Self::of(table, Method::Regression, Some(slopes))
    }

    fn of(table: &StiffnessTable, method: Method, slopes: Option<&CellSlopes>) -> Self {
        let scatter = table.pooled_scatter.unwrap_or(PooledScatter::UNSEEN);
        let lines = table.cells.iter().filter_map(|row| row.line.as_ref().ok());
        let readings = table
            .pooled_scatter
            .or_else(|| PooledScatter::about_lines(lines));
        let pooled = table.run_slope.map(|run_slope| (run_slope, scatter));
        let mut measured = Self {
            basis: match (slopes, pooled) {
                (Some(slopes), _) if slopes.from_repeats => WeightBasis::Pooled {
                    run_slope_sd: slopes.noise.run_slope_sd,
                    dof: slopes.dof,
                },
                (Some(_), _) => WeightBasis::Equal,
                (None, Some((run_slope, _))) => WeightBasis::Pooled {
                    run_slope_sd: run_slope.variance.sqrt(),
                    dof: run_slope.dof,
                },
                (None, None) => WeightBasis::EachCell,
            },
            ..Self::default()
        };
        for row in &table.cells {
            let usable = match row.by(method) {
                Ok(estimate) if estimate.estimate.value > 0.0 => Ok(estimate),
                Ok(estimate) => Err(format!(
                    "its stiffness is {:.4e} N/m, which no structure has",
                    estimate.estimate.value
                )),
                Err(reason) => Err(reason.to_string()),
            };
            let estimate = match usable {
                Ok(estimate) => estimate,
                Err(reason) => {
                    measured.unusable.push((row.cell.clone(), reason));
                    continue;
                }
            };
            let by_readings = slopes.and_then(|slopes| slopes.stiffness(&row.cell));
            let line = row.line.as_ref().ok();
            let of_cell = pooled
                .zip(line)
                .and_then(|((run_slope, scatter), line)| run_slope.of_cell(line, &scatter));
            let of_slope = by_readings.map(|(_, ln_u)| ln_u);
            let seen = slopes.is_none_or(|slopes| slopes.from_repeats);
            let own = of_slope
                .or(of_cell.map(f64::sqrt))
                .or(estimate.ln_parts.independent)
                .filter(|_| seen);
            let with_own = |own: f64| LnUncertainty {
                own,
                force_calibration: estimate.ln_parts.force_calibration,
                displacement_calibration: estimate.ln_parts.displacement_calibration,
            };
            let of_readings = readings.zip(line);
            let of_readings = of_readings.and_then(|(scatter, line)| scatter.slope_variance(line));
            let of_readings = of_slope.filter(|_| !seen).or(of_readings.map(f64::sqrt));
            measured.cells.push(MeasuredCell {
                cell: row.cell.clone(),
                line: 0,
                stiffness_n_per_m: by_readings.map_or(estimate.estimate.value, |(k, _)| k),
                ln_uncertainty: own.map(with_own),
                reading_noise: of_readings.map(with_own),
            });
        }
        measured.weigh_all_or_none();
        if let Some(slopes) = slopes {
            measured.take_across(slopes);
        }
        measured
    }

    /// Takes the compliances along other axes than that of the load.
    fn take_across(&mut self, slopes: &CellSlopes) {
        let calibration = self.cells.iter().find_map(|cell| {
            let parts = cell.ln_uncertainty.or(cell.reading_noise)?;
            Some([parts.force_calibration, parts.displacement_calibration])
        });
        let calibration = calibration.unwrap_or_default();
        for series in &slopes.series {
            for (place, cell) in series.cells.iter().enumerate() {
                if cell.load.is_none() {
                    continue;
                }
                let compliance_m_per_n = series.compliance_m_per_n[place];
                self.across.push(MeasuredCompliance {
                    cell: cell.clone(),
                    load: series.load.clone(),
                    compliance_m_per_n,
                    u_m_per_n: series.covariance[(place, place)].sqrt(),
                    // Of an error of a scale ln K has as much as minus the logarithm of a compliance.
                    calibration_m_per_n: calibration.map(|of_ln_k| -of_ln_k * compliance_m_per_n),
                });
            }
        }
        if self.across.is_empty() || !slopes.from_repeats {
            return;
        }
        let along = self.cells.iter().map(|cell| {
            let found = slopes.find(&cell.cell);
            found.map(|at| (at, -cell.stiffness_n_per_m))
        });
        let across = self.across.iter();
        let across = across.map(|one| slopes.find(&one.cell).map(|at| (at, 1.0)));
        let rows: Vec<_> = along.chain(across).collect();
        let own = self.own_variances().unwrap_or_default();
        self.own_covariance = Some(DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
            match (rows[i], rows[j]) {
                (Some(([series, a], of_a)), Some(([other, b], of_b))) if series == other => {
                    of_a * of_b * slopes.series[series].covariance[(a, b)]
                }
                _ if i == j => own.get(i).copied().unwrap_or_default(),
                _ => 0.0,
            }
        }));
    }

    /// Own variances of the ln K and of the compliances, m²/N²; `None` without weights.
    fn own_variances(&self) -> Option<Vec<f64>> {
        let along = self.cells.iter();
        let along = along.map(|cell| Some(cell.ln_uncertainty?.own.powi(2)));
        let across = self.across.iter().map(|one| Some(one.u_m_per_n.powi(2)));
        along.chain(across).collect()
    }

    /// The covariance of what ln K and compliances scatter by themselves; `None` without weights.
    pub(super) fn own_covariance(&self) -> Option<DMatrix<f64>> {
        if self.cells.is_empty() && self.basis == WeightBasis::Equal {
            return None;
        }
        let own = || Some(DMatrix::from_diagonal(&self.own_variances()?.into()));
        self.own_covariance.clone().or_else(own)
    }

    /// Number of values that a fit has: stiffnesses and compliances.
    #[must_use]
    pub fn values(&self) -> usize {
        self.cells.len() + self.across.len()
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
            across: sessions.iter().flat_map(|one| one.across.clone()).collect(),
            own_covariance: joined_covariance(sessions),
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
        let along = self.cells.iter().map(|one| &one.cell);
        let all = along.chain(self.across.iter().map(|one| &one.cell));
        let kept = all.enumerate().filter(|(_, cell)| keep(cell));
        let kept: Vec<usize> = kept.map(|(place, _)| place).collect();
        let cells = self.cells.iter().filter(|one| keep(&one.cell));
        let across = self.across.iter().filter(|one| keep(&one.cell));
        let own = self.own_covariance.as_ref();
        Self {
            cells: cells.cloned().collect(),
            across: across.cloned().collect(),
            own_covariance: own.map(|own| own.select_rows(&kept).select_columns(&kept)),
            basis: self.basis,
            unusable: self.unusable.clone(),
        }
    }

    /// Whether every cell has an uncertainty.
    #[must_use]
    pub fn has_uncertainties(&self) -> bool {
        self.values() > 0 && self.own_covariance().is_some()
    }
}

/// Of several sessions, which have nothing in common: the ln K of all, then the compliances of all; `None` if none has compliances.
fn joined_covariance(sessions: &[MeasuredStiffness]) -> Option<DMatrix<f64>> {
    if sessions.iter().all(|one| one.across.is_empty()) {
        return None;
    }
    let all: usize = sessions.iter().map(MeasuredStiffness::values).sum();
    let mut joined = DMatrix::zeros(all, all);
    let mut along = 0;
    let mut across: usize = sessions.iter().map(|one| one.cells.len()).sum();
    for one in sessions {
        let own = one.own_covariance()?;
        let of_cells = along..along + one.cells.len();
        let of_across = across..across + one.across.len();
        (along, across) = (of_cells.end, of_across.end);
        let places: Vec<usize> = of_cells.chain(of_across).collect();
        for (i, &a) in places.iter().enumerate() {
            for (j, &b) in places.iter().enumerate() {
                joined[(a, b)] = own[(i, j)];
            }
        }
    }
    Some(joined)
}
