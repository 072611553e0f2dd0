//! Solves the beam model of a shipped robot in one pose: the stiffness of its end in each direction.

use std::error::Error;
use std::fmt::Write;

use stiffbench::analysis::{ModelChoice, resolve};
use stiffbench::robot::Predictor;
use stiffbench::test_point::{Direction, PoseId};

#[expect(clippy::print_stdout, reason = "an example prints its result")]
fn main() -> Result<(), Box<dyn Error>> {
    print!("{}", report()?);
    Ok(())
}

/// What the example prints.
pub(crate) fn report() -> Result<String, Box<dyn Error>> {
    let choice = ModelChoice {
        robot: Some("hp-robot".to_owned()),
        mechanism: Some("F".to_owned()),
        factors: Some("m_fsd".to_owned()),
        ..ModelChoice::default()
    };
    let model = resolve(&choice, None)?;
    let mut predictor = Predictor::new(&model.robot, model.mechanism()?, &model.factors)?;
    predictor.place(model.robot.pose(&PoseId::new("P1"))?)?;
    // Displacement in m along each axis for a force of 1 N along each axis.
    let compliance = predictor.translation_compliance();
    let mut text = format!("{} in P1\n", model.robot.name);
    for (axis, direction) in Direction::ALL.into_iter().enumerate() {
        let stiffness_n_per_um = 1e-6 / compliance[axis][axis];
        writeln!(text, "{direction}: {stiffness_n_per_um:.4} N/µm")?;
    }
    Ok(text)
}
