//! The text of a robot file with other sections.
//!
//! Decision. The text is edited where the numbers stand, not written anew: comments, order and everything that is not a section stay as
//! their author left them.

use std::ops::Range;

use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::source_text::Step::Key;

use super::{RatedSection, Robot};

impl Robot {
    /// The text of the file this robot was read from with the section constants that `changed` has.
    ///
    /// Numbers that differ are replaced, in so many digits that they are read back exactly; all else stays byte by byte. Where a section
    /// has no mass of its own, the density of its material makes its mass follow the area.
    ///
    /// # Arguments
    /// - `source`: what this robot was read from.
    /// - `changed`: this robot with other constants in its sections.
    #[must_use]
    pub fn text_with_sections(&self, source: &SourceText, changed: &Self) -> String {
        let Some(spans) = source.toml_spans() else {
            return source.text.clone();
        };
        let mut edits: Vec<(Range<usize>, f64)> = Vec::new();
        for (name, section) in &changed.sections {
            let Some(known) = self.sections.get(name) else {
                continue;
            };
            let pairs = constants(known).into_iter().zip(constants(section));
            for ((key, before), (_, after)) in pairs {
                let path = [Key("sections"), Key(name), Key(key)];
                // A path that ends early is a mass that the file does not state.
                let is_stated = source.text[spans.key(&path)].trim_matches(['"', '\'']) == key;
                if let (Some(after), true) = (after.filter(|_| after != before), is_stated) {
                    edits.push((spans.value(&path), after));
                }
            }
        }
        edits.sort_by_key(|(span, _)| std::cmp::Reverse(span.start));
        let mut text = source.text.clone();
        for (span, value) in edits {
            text.replace_range(span, &format!("{value:e}"));
        }
        text
    }
}

/// Keys of a section and what they hold.
fn constants(rated: &RatedSection) -> [(&'static str, Option<f64>); 5] {
    let section = &rated.section;
    [
        ("A", Some(section.area_m2)),
        ("Iy", Some(section.iy_m4)),
        ("Iz", Some(section.iz_m4)),
        ("J", Some(section.j_m4)),
        ("mass_per_m", rated.mass_kg_per_m),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_test_files::shipped_robot;

    #[test]
    fn only_the_numbers_that_differ_change_and_are_read_back_exactly() {
        let mut source = shipped_robot("hp-robot").unwrap();
        // One mass is stated and one follows from a density; the third section has none.
        let steel = source.text.find("[materials.").unwrap();
        assert!(source.text[steel..].contains("\nG = "));
        source.text = source
            .text
            .replacen("\nG = ", "\ndensity = 7850.0\nG = ", 1);
        let spans = |text: &str| SourceText::new("robot.toml", text.to_owned());
        let robot = Robot::parse(&source).unwrap();
        let mut changed = robot.clone();
        let names = ["forearm", "rod_F2"];
        for (name, factor) in names.iter().zip([1.0 / 3.0, 7.123_456_789]) {
            let rated = &mut changed.sections[*name];
            rated.section = rated.section.scaled([factor, 1.0, factor * factor, 1.0]);
            rated.mass_kg_per_m = rated.mass_kg_per_m.map(|mass| mass * factor);
        }
        let text = robot.text_with_sections(&source, &changed);
        let read = Robot::parse(&spans(&text)).unwrap();
        for (name, section) in &changed.sections {
            assert_eq!(read.sections[name].section, section.section, "{name}");
            let [read, wanted] = [&read.sections[name], section].map(|s| s.mass_kg_per_m.unwrap());
            // Density times area, rounded in another order.
            assert!((read / wanted - 1.0).abs() < 1e-15, "{name}");
        }
        let differing = source
            .text
            .lines()
            .zip(text.lines())
            .filter(|(a, b)| a != b);
        let count = differing.count();
        assert!((1..=4).contains(&count), "{count}");
        assert_eq!(source.text.lines().count(), text.lines().count());
        assert_eq!(robot.text_with_sections(&source, &robot), source.text);
    }

    #[test]
    fn a_stated_mass_grows_with_its_section() {
        let mut source = shipped_robot("serial-arm").unwrap();
        source.text = source.text.replacen(
            "[sections.tube1]",
            "[sections.tube1]\nmass_per_m = 12.5 # with cables",
            1,
        );
        let robot = Robot::parse(&source).unwrap();
        let mut changed = robot.clone();
        changed.sections["tube1"].mass_kg_per_m = Some(13.0);
        let text = robot.text_with_sections(&source, &changed);
        assert!(text.contains("mass_per_m = 1.3e1 # with cables"), "{text}");
        let read = Robot::parse(&SourceText::new("arm.toml", text)).unwrap();
        assert_eq!(read.sections["tube1"].mass_kg_per_m, Some(13.0));
    }
}
