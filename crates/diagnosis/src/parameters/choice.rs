//! Which parameters of the model a fit may move, and how far.

use stiffbench_beams::robot::ModelParameter;

/// What a fit does with one parameter.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FitRole {
    /// Moves it within its bounds.
    Free,
    /// Keeps it at its start.
    Fixed,
    /// Keeps its ratio to another parameter of the list; two springs that start rigid are kept equal.
    TiedTo(ModelParameter),
}

/// A parameter and its role.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenParameter {
    /// The parameter.
    pub parameter: ModelParameter,
    /// What the fit does with it.
    pub role: FitRole,
    /// Smallest and largest value, in the unit of the parameter; `None` for those of its kind: [`ParameterChoice::range`] for a factor,
    /// zero to the softest that is plausible for a spring.
    pub bounds: Option<[f64; 2]>,
}

/// The parameters of a fit: the paper's eight factors first, then others by name.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterChoice {
    /// The parameters.
    pub members: Vec<ChosenParameter>,
    /// Bounds of free factors as multiples of their start.
    pub range: [f64; 2],
}

impl Default for ParameterChoice {
    /// Factors of beams free, those of links fixed, bounds 0.1 and 10 times the start: a poorly determined factor let loose would
    /// take up effects that are not its own, at absurd values.
    fn default() -> Self {
        let role = |parameter: &ModelParameter| {
            if ModelParameter::BEAMS.contains(parameter) {
                FitRole::Free
            } else {
                FitRole::Fixed
            }
        };
        let member = |parameter: ModelParameter| ChosenParameter {
            role: role(&parameter),
            parameter,
            bounds: None,
        };
        Self {
            members: ModelParameter::CLASSES.into_iter().map(member).collect(),
            range: [0.1, 10.0],
        }
    }
}

impl ParameterChoice {
    /// Gives a parameter a role; one that is not in the list joins it.
    pub fn set(&mut self, parameter: &ModelParameter, role: FitRole) {
        self.member(parameter).role = role;
    }

    /// Bounds a parameter, in its unit.
    pub fn bound(&mut self, parameter: &ModelParameter, bounds: [f64; 2]) {
        self.member(parameter).bounds = Some(bounds);
    }

    /// The parameters, in the order of every result.
    #[must_use]
    pub fn parameters(&self) -> Vec<ModelParameter> {
        let members = self.members.iter();
        members.map(|member| member.parameter.clone()).collect()
    }

    fn member(&mut self, parameter: &ModelParameter) -> &mut ChosenParameter {
        let known = self.members.iter().position(|m| m.parameter == *parameter);
        let place = known.unwrap_or_else(|| {
            self.members.push(ChosenParameter {
                parameter: parameter.clone(),
                role: FitRole::Fixed,
                bounds: None,
            });
            self.members.len() - 1
        });
        &mut self.members[place]
    }
}
