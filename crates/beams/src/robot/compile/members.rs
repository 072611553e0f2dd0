//! Members with their sections and materials, and the mechanisms they make up.

use indexmap::IndexMap;

use crate::robot::RatedSection;
use crate::robot::error::RobotError;
use crate::robot::file;
use crate::robot::loads::{MassPlace, PointMass};
use crate::robot::model::{Mechanism, Member};
use crate::structure::{Material, Section, ShearCoefficients};
use stiffbench_units_and_text::toml_text::DocumentStep::{self, Index, Key};

use super::Compiler;

/// Shear coefficient of a rectangle (Timoshenko 1921), used when a section names none.
const DEFAULT_SHEAR_COEFFICIENT: f64 = 5.0 / 6.0;

impl Compiler<'_> {
    pub(super) fn members(
        &self,
        sections: &IndexMap<String, RatedSection>,
    ) -> Result<Vec<Member>, RobotError> {
        let member = |(place, entry): (usize, &file::ElementEntry)| {
            let at = |key| [Key("elements"), Index(place), Key(key)];
            let node = |index: usize| {
                self.node(
                    entry.nodes[index].as_str(),
                    &[&at("nodes")[..], &[Index(index)]].concat(),
                )
            };
            let known = sections.keys().map(String::as_str);
            let section = sections.get_index_of(&entry.section);
            let nodes = [node(0)?, node(1)?];
            self.apart(nodes, &at("nodes"), "an element needs two different nodes")?;
            Ok(Member {
                name: entry.id.clone(),
                nodes,
                chain: entry.chain.clone(),
                class: entry.class,
                section: self.found(section, &at("section"), "section", &entry.section, known)?,
                body: self.body(&entry.body, &at("body"))?,
                plane: self.plane(&entry.plane, &at("plane"))?,
                groups: Vec::new(),
            })
        };
        self.file.elements.iter().enumerate().map(member).collect()
    }

    /// Elastic constants and density, kg/m³, of each material.
    fn materials(&self) -> Result<Vec<(Material, Option<f64>)>, RobotError> {
        let material = |(name, entry): (&String, &file::MaterialEntry)| {
            let modulus = |value, key| {
                let path = [Key("materials"), Key(name), Key(key)];
                self.positive(value, &path, format!("{key} of material {name}"))
            };
            let density = entry.density.map(|density| modulus(density, "density"));
            let elastic = Material {
                youngs_modulus_pa: modulus(entry.youngs_modulus, "E")?,
                shear_modulus_pa: modulus(entry.shear_modulus, "G")?,
            };
            Ok((elastic, density.transpose()?))
        };
        self.file.materials.iter().map(material).collect()
    }

    pub(super) fn sections(&self) -> Result<IndexMap<String, RatedSection>, RobotError> {
        let materials = self.materials()?;
        let names = &self.file.materials;
        let section = |(name, entry): (&String, &file::SectionEntry)| {
            let at = |key| [Key("sections"), Key(name), Key(key)];
            let known = names.keys().map(String::as_str);
            let place = names.get_index_of(&entry.material);
            let place = self.found(place, &at("material"), "material", &entry.material, known)?;
            let constant =
                |value, key| self.positive(value, &at(key), format!("{key} of section {name}"));
            let mut shear = [DEFAULT_SHEAR_COEFFICIENT; 2];
            for (value, given) in shear.iter_mut().zip(entry.shear.iter().flatten()) {
                let what = format!("a shear coefficient of section {name}");
                *value = self.positive(*given, &at("shear"), what)?;
            }
            let (material, density) = materials[place];
            let stated = entry.mass_per_m.map(|mass| constant(mass, "mass_per_m"));
            let rated = RatedSection {
                section: Section {
                    area_m2: constant(entry.area, "A")?,
                    iy_m4: constant(entry.iy, "Iy")?,
                    iz_m4: constant(entry.iz, "Iz")?,
                    j_m4: constant(entry.j, "J")?,
                },
                material,
                shear: ShearCoefficients {
                    along_y: shear[0],
                    along_z: shear[1],
                },
                mass_kg_per_m: stated.transpose()?.or_else(|| Some(density? * entry.area)),
            };
            Ok((name.clone(), rated))
        };
        self.file.sections.iter().map(section).collect()
    }

    pub(super) fn masses(&self) -> Result<Vec<PointMass>, RobotError> {
        let mass = |(name, &mass): (&String, &f64)| {
            let path = [Key("masses"), Key(name)];
            Ok(PointMass {
                name: name.clone(),
                place: MassPlace::Node(self.node(name, &path)?),
                mass_kg: self.positive(mass, &path, format!("the mass at {name}"))?,
            })
        };
        self.file.masses.iter().map(mass).collect()
    }

    pub(super) fn mechanisms(&self) -> Result<IndexMap<String, Mechanism>, RobotError> {
        let mut mechanisms = IndexMap::new();
        for (name, entry) in &self.file.mechanisms {
            let at = |key| [Key("mechanisms"), Key(name), Key(key)];
            for (place, chain) in entry.chains.iter().enumerate() {
                let mut chains = self.file.elements.iter().map(|e| e.chain.as_str());
                let exists = chains.any(|c| c == chain).then_some(0);
                let known = self.file.elements.iter().map(|e| e.chain.as_str());
                self.found(
                    exists,
                    &[&at("chains")[..], &[Index(place)]].concat(),
                    "chain",
                    chain,
                    known,
                )?;
            }
            let element = |compiler: &Self, name: &str, path: &[DocumentStep<'_>]| {
                let known = compiler.file.elements.iter().map(|e| e.id.as_str());
                compiler.found(
                    compiler.elements.get(name).copied(),
                    path,
                    "element",
                    name,
                    known,
                )
            };
            let single = self.names(&entry.elements, &at("elements"), element)?;
            let mut locked = self.names(&entry.locked, &at("locked"), Self::joint)?;
            for (motor, joint) in &entry.drives {
                locked.push(self.joint(joint, &[&at("drives")[..], &[Key(motor)]].concat())?);
            }
            let members = (0..self.file.elements.len())
                .filter(|place| {
                    entry.chains.contains(&self.file.elements[*place].chain)
                        || single.contains(place)
                })
                .collect();
            mechanisms.insert(
                name.clone(),
                Mechanism {
                    name: name.clone(),
                    chains: entry.chains.clone(),
                    members,
                    rigid_links: Vec::new(),
                    locked,
                },
            );
        }
        Ok(mechanisms)
    }
}
