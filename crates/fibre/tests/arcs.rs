//! Clamps that bend the wood between them into an arc, and scenes on stems of other lengths than they were written for.

mod support;

use glam::{DVec3, dvec3};
use greenstick_fibre::scene::{BUILT_IN, Scene, SetUp, set_up};
use greenstick_fibre::solvers::QuasiStatic;
use greenstick_fibre::{Bundle, NoContacts, Rod, RodMaterial, Solver};

const YOUNG: f64 = 1e10;

/// Rods side by side that no bond joins, at the places of `section` (m), with vertices `edge` m apart, along a line that
/// leaves x by `bow` m in its middle.
fn stem(section: &[(f64, f64)], area: f64, length: f64, bow: f64) -> (Bundle, Vec<f64>) {
    let material = RodMaterial::solid(area, YOUNG, YOUNG / 16.0, 600.0);
    let edges = 60;
    let mut along = Vec::new();
    let rods: Vec<Rod> = section
        .iter()
        .map(|&(y, z)| {
            let vertices = (0..=edges).map(|i| {
                let part = f64::from(i) / f64::from(edges);
                along.push(length * part);
                let off = 4.0 * bow * part * (1.0 - part);
                dvec3(length * part, y, z + off)
            });
            Rod::new(vertices.collect(), material)
        })
        .collect();
    (Bundle::new(&rods, false).unwrap(), along)
}
