//! A model as the text of its file, complete and commented.

use std::fmt::Write as _;

use stiffbench_units_and_text::toml_text::quoted;

use super::{FoundEffect, MODEL_SCHEMA, ModelFile, ParameterUncertainty};

impl ModelFile {
    /// The text of the file; [`ModelFile::parse`] gives the same model back.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = String::from(
            "# A beam model with the physics that was found, for --model of fit, simulate and other commands.\n\
             # Values are in SI units. docs/physics.md explains laws, places and parameters.\n",
        );
        let _ = writeln!(text, "schema = \"{MODEL_SCHEMA}\"");
        if self.robot.is_some() {
            text.push_str("# Relative to this file, or the name of a shipped robot.\n");
        }
        key(&mut text, "robot", self.robot.as_ref());
        key(&mut text, "robot_sha256", self.robot_sha256.as_ref());
        key(&mut text, "mechanism", self.mechanism.as_ref());
        let provenance = &self.provenance;
        if *provenance != super::Provenance::default() {
            text.push_str("\n[provenance]\n");
            key(&mut text, "session", provenance.session.as_ref());
            key(&mut text, "software", provenance.software.as_ref());
            key(&mut text, "verdict", provenance.verdict.as_ref());
        }
        if let Some(factors) = &self.factors {
            text.push_str("\n# Multipliers of the nominal section constants.\n[factors]\n");
            text.push_str(&factors.to_toml());
        }
        for found in &self.effects {
            push_effect(&mut text, "effects", found);
        }
        if !self.alternatives.is_empty() {
            text.push_str(
                "\n# The following alternatives are not applied. The data do not distinguish them from the effect above with the same alternative_group:\n\
                 # to use one, exchange the two.\n",
            );
        }
        for found in &self.alternatives {
            push_effect(&mut text, "alternatives", found);
        }
        text
    }
}

fn key(text: &mut String, key: &str, value: Option<&String>) {
    if let Some(value) = value {
        let _ = writeln!(text, "{key} = {}", quoted(value));
    }
}

fn push_effect(text: &mut String, array: &str, found: &FoundEffect) {
    let effect = &found.effect;
    let _ = writeln!(text, "\n[[{array}]]");
    let _ = writeln!(text, "physics = \"{}\"", effect.law);
    let _ = writeln!(text, "# {}", effect.law.equation);
    // A place is a table of names and numbers, and so it can be written.
    let place = toml::Value::try_from(&effect.place)
        .map_or_else(|_| String::new(), |place| place.to_string());
    let _ = writeln!(text, "place = {place}");
    if let Some(group) = found.alternative_group {
        let _ = writeln!(text, "alternative_group = {group}");
    }
    for (index, (spec, value)) in effect.parameters().enumerate() {
        let known = found.uncertainties.get(index).copied();
        let _ = writeln!(
            text,
            "parameters.{} = {{ value = {value:?}, unit = \"{}\"{} }}",
            spec.name,
            spec.unit(),
            known.unwrap_or_default()
        );
    }
}

impl std::fmt::Display for ParameterUncertainty {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(u) = self.u {
            write!(f, ", u = {u:?}")?;
        }
        if let Some(dof) = self.dof.filter(|dof| dof.is_finite()) {
            write!(f, ", dof = {dof:?}")?;
        }
        if let Some([low, high]) = self.ci95 {
            write!(f, ", ci95 = [{low:?}, {high:?}]")?;
        }
        Ok(())
    }
}
