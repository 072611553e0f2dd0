//! Elements far stiffer than their neighbours: right to six digits, or refused by name.

use stiffbench_beams::structure::{Solver, Structure, StructureError};

use super::support::{SECTION, STEEL, chain};

const PIECES: usize = 4;
const LENGTH_M: f64 = 1.6;

/// A cantilever of four pieces of which one is stiffer.
fn cantilever(stiff: usize, factor: f64) -> Structure {
    let piece_m = LENGTH_M / PIECES as f64;
    let places: Vec<[f64; 3]> = (0..=PIECES)
        .map(|i| [piece_m * i as f64, 0.0, 0.0])
        .collect();
    let mut structure = chain(&places, [0.0, 1.0, 0.0]);
    structure.elements[stiff].section = SECTION.scaled([factor; 4]);
    structure
}

/// Castigliano: the compliance across is the integral of (L - x)²/EI, piece by piece.
fn compliance_across(stiff: usize, factor: f64) -> f64 {
    let piece_m = LENGTH_M / PIECES as f64;
    let left = |piece: usize| LENGTH_M - piece_m * piece as f64;
    let pieces = (0..PIECES).map(|piece| {
        let by = if piece == stiff { factor } else { 1.0 };
        (left(piece).powi(3) - left(piece + 1).powi(3)) / (3.0 * by)
    });
    pieces.sum::<f64>() / (STEEL.youngs_modulus_pa * SECTION.iz_m4)
}

#[test]
fn a_stiff_piece_is_right_to_six_digits_or_refused_by_name() {
    let mut refused = 0;
    for stiff in 0..PIECES {
        for exponent in 0..=14 {
            let factor = 10_f64.powi(exponent);
            let structure = cantilever(stiff, factor);
            let solved = Solver::new(&structure).and_then(|mut solver| {
                solver.update(&structure)?;
                Ok(solver.end_compliance().0[1][1])
            });
            match solved {
                Ok(found) => {
                    let exact = compliance_across(stiff, factor);
                    assert!(
                        (found / exact - 1.0).abs() < 1e-6,
                        "piece {stiff}, factor {factor:e}: {found} {exact}"
                    );
                }
                Err(StructureError::TooStiff { first, ratio, .. }) => {
                    assert_eq!(&*first, format!("N{stiff}"));
                    assert!((ratio / factor - 1.0).abs() < 1e-9);
                    refused += 1;
                }
                Err(other) => panic!("{other}"),
            }
        }
    }
    assert!(refused > 0);
}
