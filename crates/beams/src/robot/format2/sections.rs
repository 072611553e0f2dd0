//! Cross-sections: those of the file, and profiles that links name.

use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::toml_text::DocumentStep::{self, Key};

use crate::robot::RatedSection;
use crate::robot::error::{RobotError, RobotProblem};
use crate::structure::{Material, Section, ShearCoefficients};

use super::builder::RobotBuilder;
use super::materials::{MATERIALS, named_material};
use super::parts::SectionRow;
use super::profiles::{ProfileError, SectionProfile, shapes};

/// Material of a section that names none.
const DEFAULT_MATERIAL: &str = "steel";

/// Shear coefficient of a rectangle (Timoshenko 1921), of sections given by constants alone.
const DEFAULT_SHEAR: f64 = 5.0 / 6.0;

/// Elastic constants and density, kg/m³.
type RatedMaterial = (Material, Option<f64>);

impl RobotBuilder<'_> {
    /// The sections that the file names.
    pub(super) fn sections_of_file(&mut self) -> Result<(), RobotError> {
        for (name, row) in &self.file.sections {
            let section = self.section_of_row(name, row)?;
            self.sections.insert(name.clone(), section);
        }
        Ok(())
    }

    fn section_of_row(&self, name: &str, row: &SectionRow) -> Result<RatedSection, RobotError> {
        let at = |key| [Key("sections"), Key(name), Key(key)];
        let material = row.material.as_deref().unwrap_or(DEFAULT_MATERIAL);
        let (material, density) = self.material(material, &at("material"))?;
        let constants = [
            row.area
                .as_ref()
                .map(|m| self.positive(m, &at("A"), format!("A of section {name}"))),
            row.iy
                .as_ref()
                .map(|m| self.positive(m, &at("Iy"), format!("Iy of section {name}"))),
            row.iz
                .as_ref()
                .map(|m| self.positive(m, &at("Iz"), format!("Iz of section {name}"))),
            row.j
                .as_ref()
                .map(|m| self.positive(m, &at("J"), format!("J of section {name}"))),
        ];
        let given = constants.iter().flatten().count();
        let (section, mut shear) = match (&row.profile, constants) {
            (Some(profile), _) if given == 0 => {
                let path = at("profile");
                let profile = SectionProfile::parse(profile)
                    .map_err(|e| self.no_profile(&e, profile, &path))?;
                (profile.section, profile.shear)
            }
            (None, [Some(area), Some(iy), Some(iz), Some(j)]) => {
                let section = Section {
                    area_m2: area?,
                    iy_m4: iy?,
                    iz_m4: iz?,
                    j_m4: j?,
                };
                let shear = ShearCoefficients {
                    along_y: DEFAULT_SHEAR,
                    along_z: DEFAULT_SHEAR,
                };
                (section, shear)
            }
            _ => {
                let message = "a section has either a `profile` or all of `A`, `Iy`, `Iz`, `J`";
                let path = [Key("sections"), Key(name)];
                return Err(self.error(&path, RobotProblem::Shape(message)));
            }
        };
        if let Some([along_y, along_z]) = row.shear {
            for coefficient in [along_y, along_z] {
                let what = format!("a shear coefficient of section {name}");
                self.positive_value(coefficient, &at("shear"), what)?;
            }
            shear = ShearCoefficients { along_y, along_z };
        }
        let mass = row.mass.as_ref();
        let mass =
            mass.map(|mass| self.positive(mass, &at("mass"), format!("mass of section {name}")));
        Ok(RatedSection {
            mass_kg_per_m: mass
                .transpose()?
                .or_else(|| Some(density? * section.area_m2)),
            section,
            material,
            shear,
        })
    }

    fn material(&self, name: &str, path: &[DocumentStep<'_>]) -> Result<RatedMaterial, RobotError> {
        if let Some(row) = self.file.materials.get(name) {
            let at = |key| [Key("materials"), Key(name), Key(key)];
            let density = row.density.as_ref();
            let density = density.map(|density| {
                self.positive(
                    density,
                    &at("density"),
                    format!("density of material {name}"),
                )
            });
            let elastic = Material {
                youngs_modulus_pa: self.positive(
                    &row.youngs_modulus,
                    &at("E"),
                    format!("E of material {name}"),
                )?,
                shear_modulus_pa: self.positive(
                    &row.shear_modulus,
                    &at("G"),
                    format!("G of material {name}"),
                )?,
            };
            return Ok((elastic, density.transpose()?));
        }
        let known = named_material(name);
        let place = known.map(|_| 0);
        let names = MATERIALS.iter().map(|material| material.name);
        let names = names.chain(self.file.materials.keys().map(String::as_str));
        self.found(place, path, "material", name, names)?;
        let known = known.map(|known| (known.elastic, Some(known.density_kg_per_m3)));
        Ok(known.expect("the name was found"))
    }

    /// Index of the section that a link names: one of the file, or a profile with its material.
    pub(super) fn section(
        &mut self,
        text: &str,
        path: &[DocumentStep<'_>],
    ) -> Result<usize, RobotError> {
        if let Some(place) = self.sections.get_index_of(text) {
            return Ok(place);
        }
        let text = text.trim();
        let last = text.rsplit_once(char::is_whitespace);
        // A last word that begins with a letter names the material; sizes begin with a digit.
        let last = last.filter(|(_, word)| word.starts_with(char::is_alphabetic));
        let (profile, material) = last.unwrap_or((text, DEFAULT_MATERIAL));
        let parsed =
            SectionProfile::parse(profile).map_err(|error| self.no_profile(&error, text, path))?;
        let (material, density) = self.material(material, path)?;
        let section = RatedSection {
            section: parsed.section,
            material,
            shear: parsed.shear,
            mass_kg_per_m: density.map(|density| density * parsed.section.area_m2),
        };
        Ok(self.sections.insert_full(text.to_owned(), section).0)
    }

    /// The error for a text that is no profile; where its first word is near a section of the file, that is named.
    fn no_profile(
        &self,
        error: &ProfileError,
        text: &str,
        path: &[DocumentStep<'_>],
    ) -> RobotError {
        let names = self.file.sections.keys().map(String::as_str);
        let file_names: Vec<&str> = names.collect();
        let shape_names: Vec<&str> = shapes().collect();
        let word = text.split_whitespace().next().unwrap_or(text);
        let near = nearest(text, file_names.iter().copied())
            .or_else(|| nearest(word, shape_names.iter().copied()));
        let help = match (error, near) {
            (ProfileError::UnknownShape { .. }, Some(near)) => format!("did you mean `{near}`?"),
            (ProfileError::UnknownShape { .. }, None) => {
                let mut names = file_names;
                names.extend(shape_names);
                format!(
                    "write the name of a section or a profile ({}), or leave it out: a link without section is rigid",
                    names.join(", ")
                )
            }
            _ => "for example `tube 120x6 aluminium`, dimensions in mm".to_owned(),
        };
        self.error_with(path, RobotProblem::Syntax(error.to_string()), help)
    }
}
