//! Rolled I and U sections.

use std::f64::consts::PI;

use crate::structure::{Section, ShearCoefficients};

use super::profiles::ProfileError;

/// A rolled section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rolled {
    /// Constants.
    pub(crate) section: Section,
    /// Shear area over area.
    pub(crate) shear: ShearCoefficients,
}

/// A series of rolled sections.
#[derive(Debug)]
pub(crate) struct RolledSeries {
    /// Its name.
    pub(crate) name: &'static str,
    sizes: RolledSizes,
}

#[derive(Debug)]
enum RolledSizes {
    /// Size, and height, width, web, flange, fillet, mm (EN 10365).
    ParallelFlanges(&'static [(u16, [f64; 5])]),
    /// Size, and width, web, mm; A, cm²; Iy, Iz, It, cm⁴ (DIN 1026-1): flanges that taper by 8 %.
    TaperedFlanges(&'static [(u16, [f64; 6])]),
}

/// All series.
#[rustfmt::skip]
pub(crate) const SERIES: [RolledSeries; 4] = [
    RolledSeries { name: "IPE", sizes: RolledSizes::ParallelFlanges(&[
        (80, [80.0, 46.0, 3.8, 5.2, 5.0]), (100, [100.0, 55.0, 4.1, 5.7, 7.0]), (120, [120.0, 64.0, 4.4, 6.3, 7.0]),
        (140, [140.0, 73.0, 4.7, 6.9, 7.0]), (160, [160.0, 82.0, 5.0, 7.4, 9.0]), (180, [180.0, 91.0, 5.3, 8.0, 9.0]),
        (200, [200.0, 100.0, 5.6, 8.5, 12.0]), (220, [220.0, 110.0, 5.9, 9.2, 12.0]), (240, [240.0, 120.0, 6.2, 9.8, 15.0]),
        (270, [270.0, 135.0, 6.6, 10.2, 15.0]), (300, [300.0, 150.0, 7.1, 10.7, 15.0]), (330, [330.0, 160.0, 7.5, 11.5, 18.0]),
        (360, [360.0, 170.0, 8.0, 12.7, 18.0]), (400, [400.0, 180.0, 8.6, 13.5, 21.0]), (450, [450.0, 190.0, 9.4, 14.6, 21.0]),
        (500, [500.0, 200.0, 10.2, 16.0, 21.0]), (550, [550.0, 210.0, 11.1, 17.2, 24.0]), (600, [600.0, 220.0, 12.0, 19.0, 24.0]),
    ]) },
    RolledSeries { name: "HEA", sizes: RolledSizes::ParallelFlanges(&[
        (100, [96.0, 100.0, 5.0, 8.0, 12.0]), (120, [114.0, 120.0, 5.0, 8.0, 12.0]), (140, [133.0, 140.0, 5.5, 8.5, 12.0]),
        (160, [152.0, 160.0, 6.0, 9.0, 15.0]), (180, [171.0, 180.0, 6.0, 9.5, 15.0]), (200, [190.0, 200.0, 6.5, 10.0, 18.0]),
        (220, [210.0, 220.0, 7.0, 11.0, 18.0]), (240, [230.0, 240.0, 7.5, 12.0, 21.0]), (260, [250.0, 260.0, 7.5, 12.5, 24.0]),
        (280, [270.0, 280.0, 8.0, 13.0, 24.0]), (300, [290.0, 300.0, 8.5, 14.0, 27.0]),
    ]) },
    RolledSeries { name: "HEB", sizes: RolledSizes::ParallelFlanges(&[
        (100, [100.0, 100.0, 6.0, 10.0, 12.0]), (120, [120.0, 120.0, 6.5, 11.0, 12.0]), (140, [140.0, 140.0, 7.0, 12.0, 12.0]),
        (160, [160.0, 160.0, 8.0, 13.0, 15.0]), (180, [180.0, 180.0, 8.5, 14.0, 15.0]), (200, [200.0, 200.0, 9.0, 15.0, 18.0]),
        (220, [220.0, 220.0, 9.5, 16.0, 18.0]), (240, [240.0, 240.0, 10.0, 17.0, 21.0]), (260, [260.0, 260.0, 10.0, 17.5, 24.0]),
        (280, [280.0, 280.0, 10.5, 18.0, 24.0]), (300, [300.0, 300.0, 11.0, 19.0, 27.0]),
    ]) },
    RolledSeries { name: "UPN", sizes: RolledSizes::TaperedFlanges(&[
        (80, [45.0, 6.0, 11.0, 106.0, 19.4, 2.16]), (100, [50.0, 6.0, 13.5, 206.0, 29.3, 2.81]),
        (120, [55.0, 7.0, 17.0, 364.0, 43.2, 4.15]), (140, [60.0, 7.0, 20.4, 605.0, 62.7, 5.68]),
        (160, [65.0, 7.5, 24.0, 925.0, 85.3, 7.39]), (180, [70.0, 8.0, 28.0, 1350.0, 114.0, 9.55]),
        (200, [75.0, 8.5, 32.2, 1910.0, 148.0, 11.9]), (220, [80.0, 9.0, 37.4, 2690.0, 197.0, 16.0]),
        (240, [85.0, 9.5, 42.3, 3600.0, 248.0, 19.7]), (260, [90.0, 10.0, 48.3, 4820.0, 317.0, 25.5]),
        (280, [95.0, 10.0, 53.3, 6280.0, 399.0, 31.0]), (300, [100.0, 10.0, 58.8, 8030.0, 495.0, 37.4]),
    ]) },
];

impl RolledSeries {
    /// The section of a size.
    pub(super) fn find(&self, size: &str) -> Result<Rolled, ProfileError> {
        let wanted: Option<u16> = size.parse().ok();
        let found = match self.sizes {
            RolledSizes::ParallelFlanges(rows) => {
                let row = rows.iter().find(|(size, _)| Some(*size) == wanted);
                row.map(|(_, dimensions)| parallel_flanges(dimensions.map(|mm| 1e-3 * mm)))
            }
            RolledSizes::TaperedFlanges(rows) => {
                let row = rows.iter().find(|(size, _)| Some(*size) == wanted);
                row.map(|&(size, constants)| tapered_flanges(f64::from(size), constants))
            }
        };
        found.ok_or_else(|| ProfileError::UnknownSize {
            series: self.name,
            size: size.to_owned(),
            known: self.known(),
        })
    }

    fn known(&self) -> String {
        let sizes: Vec<String> = match self.sizes {
            RolledSizes::ParallelFlanges(rows) => {
                rows.iter().map(|(size, _)| size.to_string()).collect()
            }
            RolledSizes::TaperedFlanges(rows) => {
                rows.iter().map(|(size, _)| size.to_string()).collect()
            }
        };
        sizes.join(", ")
    }
}

/// Constants from height, width, web, flange and fillet, m.
///
/// # Source
/// Area and second moments in closed form with the four fillets. Torsion: It as ArcelorMittal states it for rolled sections (Sections and
/// merchant bars, notations and formulae).
fn parallel_flanges([h, b, tw, tf, r]: [f64; 5]) -> Rolled {
    // A fillet: a square of side r less a quarter of a circle; its centroid lies this far from the corner.
    let fillet = (1.0 - PI / 4.0) * r * r;
    let centroid = r * (10.0 - 3.0 * PI) / (12.0 - 3.0 * PI);
    let own = r.powi(4) * (1.0 / 3.0 - PI / 16.0 - 1.0 / (9.0 * (4.0 - PI)));
    let web = h - 2.0 * tf;
    let area = 2.0 * b * tf + web * tw + 4.0 * fillet;
    let iy = (b * h.powi(3) - (b - tw) * web.powi(3)) / 12.0
        + 4.0 * (own + fillet * (0.5 * web - centroid).powi(2));
    let iz = (2.0 * tf * b.powi(3) + web * tw.powi(3)) / 12.0
        + 4.0 * (own + fillet * (0.5 * tw + centroid).powi(2));
    let corner = ((r + 0.5 * tw).powi(2) + (r + tf).powi(2) - r * r) / (2.0 * r + tf);
    let torsion = 2.0 / 3.0 * (b - 0.63 * tf) * tf.powi(3)
        + web * tw.powi(3) / 3.0
        + 2.0 * (tw / tf) * (0.145 + 0.1 * r / tf) * corner.powi(4);
    Rolled {
        section: Section {
            area_m2: area,
            iy_m4: iy,
            iz_m4: iz,
            j_m4: torsion,
        },
        shear: ShearCoefficients {
            along_y: 5.0 / 6.0 * 2.0 * b * tf / area,
            along_z: h * tw / area,
        },
    }
}

/// Constants as the table prints them.
fn tapered_flanges(h_mm: f64, [b_mm, web_mm, a_cm2, iy, iz, it]: [f64; 6]) -> Rolled {
    let area_mm2 = 100.0 * a_cm2;
    let web_mm2 = h_mm * web_mm;
    let flange_mm = (area_mm2 - web_mm2) / (2.0 * (b_mm - web_mm));
    Rolled {
        section: Section {
            area_m2: 1e-4 * a_cm2,
            iy_m4: 1e-8 * iy,
            iz_m4: 1e-8 * iz,
            j_m4: 1e-8 * it,
        },
        shear: ShearCoefficients {
            along_y: 5.0 / 6.0 * 2.0 * b_mm * flange_mm / area_mm2,
            along_z: web_mm2 / area_mm2,
        },
    }
}
