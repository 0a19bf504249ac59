//! Screened Poisson surface reconstruction (Kazhdan and Hoppe 2013) on a regular lattice: an indicator function is fitted
//! whose gradient follows the points' normals and which vanishes at the points; the surface is its zero level.
//!
//! Differences of the indicator along the lattice's edges are fitted to the normals and its values at the points to 0, by
//! conjugate gradients from coarse lattices to fine ones. The surface is extracted from tetrahedra (Doi and Koide 1991),
//! so that it is a closed manifold whatever its shape.

use super::lattice::Lattice;
use super::tetrahedra::surface;
use crate::{Cancelled, Context, ErrorKind, Mesh};
use glam::DVec3;
use rayon::prelude::*;

/// Weight of the fit at the points relative to the fit of the normals.
const SCREENING: f64 = 4.0;
/// Cells of the finest lattice around the points on every side.
const MARGIN_CELLS: f64 = 6.0;
/// Fewest cells along the longest side of the coarsest lattice.
const MIN_COARSE_CELLS: f64 = 12.0;
/// Most steps of conjugate gradients on one lattice.
const MAX_STEPS: usize = 150;
/// Residual, relative to the right-hand side, at which the steps end.
const RELATIVE_RESIDUAL: f64 = 1e-3;
/// Most nodes of the finest lattice.
pub const MAX_NODES: f64 = 8e6;
/// Mean product of two linear hat functions across a surface: converts the density of points around a node to points for
/// each cell's area.
const MEAN_HAT_PRODUCT: f64 = 2.0 / 3.0;

/// Why no surface can be reconstructed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PoissonError {
    /// The lists have different lengths or are empty.
    #[error("{points} points with {normals} normals; expected as many of both, and some")]
    Lists {
        /// Number of points.
        points: usize,
        /// Number of normals.
        normals: usize,
    },
    /// The cells are too small, or their size is no length.
    #[error(
        "cells of {cell} m make {nodes:.0} nodes about the points; expected at most {MAX_NODES:.0}"
    )]
    Cell {
        /// Side of a cell, m.
        cell: f64,
        /// Number of nodes that they make.
        nodes: f64,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl PoissonError {
    /// Returns the kind of the error.
    pub fn kind(&self) -> ErrorKind {
        match self {
            PoissonError::Cancelled(_) => ErrorKind::Cancelled,
            _ => ErrorKind::Request,
        }
    }
}

/// Reconstructs the closed surface through `points` whose unit `normals` point outwards. `cell` is the side of a cell of
/// the lattice, m; smaller features are smoothed away. The surface is cut off, and closed, where `inside` (a signed
/// distance, m) falls below 0.
///
/// # Errors
/// [`PoissonError`] where the lists do not match, the cells are too many, or the caller asked to stop.
pub fn poisson(
    points: &[DVec3],
    normals: &[DVec3],
    cell: f64,
    inside: impl Fn(DVec3) -> f64,
    context: &Context,
) -> Result<Mesh, PoissonError> {
    if points.len() != normals.len() || points.is_empty() {
        return Err(PoissonError::Lists {
            points: points.len(),
            normals: normals.len(),
        });
    }
    let (low, high) = points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| {
            (a.min(*p), b.max(*p))
        });
    let extent = high - low + 2.0 * MARGIN_CELLS * cell;
    let nodes = (extent / cell + 1.0).to_array().iter().product::<f64>();
    if !(cell > 0.0 && nodes <= MAX_NODES) {
        return Err(PoissonError::Cell { cell, nodes });
    }
    let mut halvings = 0;
    while extent.max_element() / (cell * f64::from(2 << halvings)) >= MIN_COARSE_CELLS {
        halvings += 1;
    }
    let coarse = cell * f64::from(1 << halvings);
    let cells = (extent / coarse).ceil().to_array();
    let cells = cells.map(|n| (n as usize).max(2));
    let middle = 0.5 * (low + high);
    let mut values: Option<(Lattice, Vec<f64>)> = None;
    for level in 0..=halvings {
        context.report(f64::from(level) / f64::from(halvings + 1))?;
        let cell = coarse / f64::from(1 << level);
        let cells = cells.map(|n| n << level);
        let reach = DVec3::from_array(cells.map(|n| n as f64)) * cell;
        let lattice = Lattice {
            low: middle - 0.5 * reach,
            cell,
            size: cells.map(|n| n + 1),
        };
        let start = match &values {
            Some((before, values)) => refined(before, values, &lattice),
            None => vec![0.0; lattice.nodes()],
        };
        let system = System::new(lattice, points, normals, context)?;
        values = Some((lattice, system.solve(start, context)?));
    }
    let Some((lattice, values)) = values else {
        return Ok(Mesh::default());
    };
    let at = |p: &DVec3| -> f64 {
        let around = lattice.around(*p, None);
        around.iter().map(|(i, w)| w * values[*i]).sum()
    };
    let level = points.iter().map(at).sum::<f64>() / points.len() as f64;
    Ok(surface(&lattice, &values, level, inside, context)?)
}

/// Interpolates the values of a lattice at the nodes of one with half its cells.
fn refined(coarse: &Lattice, values: &[f64], fine: &Lattice) -> Vec<f64> {
    (0..fine.nodes())
        .into_par_iter()
        .map(|i| {
            let around = coarse.around(fine.position(i), None);
            around.iter().map(|(i, w)| w * values[*i]).sum()
        })
        .collect()
}

/// The normal equations of both fits, for the indicator at the nodes.
struct System {
    lattice: Lattice,
    right_side: Vec<f64>,
    diagonal: Vec<f64>,
    screens: Vec<Screen>,
}

/// The term by which the indicator is fitted to 0 at a point.
struct Screen {
    /// Nodes around the point with their weights.
    around: [(usize, f64); 8],
    /// Weight of the point.
    weight: f64,
}

impl System {
    fn new(
        lattice: Lattice,
        points: &[DVec3],
        normals: &[DVec3],
        context: &Context,
    ) -> Result<Self, Cancelled> {
        context.check()?;
        let strides = lattice.strides();
        let arounds: Vec<_> = points.iter().map(|p| lattice.around(*p, None)).collect();
        let mut density = vec![0.0; lattice.nodes()];
        for (i, w) in arounds.iter().flatten() {
            density[*i] += w;
        }
        context.check()?;
        // The area that each point stands for, in squared sides of a cell.
        let areas: Vec<f64> = arounds
            .iter()
            .map(|around| {
                MEAN_HAT_PRODUCT / around.iter().map(|(i, w)| w * density[*i]).sum::<f64>()
            })
            .collect();
        context.check()?;
        let mut right_side = vec![0.0; lattice.nodes()];
        for ((p, n), area) in points.iter().zip(normals).zip(&areas) {
            for axis in 0..3 {
                for (i, w) in lattice.around(*p, Some(axis)) {
                    // The indicator is higher inside.
                    let step = -n[axis] * area * w;
                    right_side[i] -= step;
                    right_side[i + strides[axis]] += step;
                }
            }
        }
        let screens: Vec<Screen> = arounds
            .into_iter()
            .zip(areas)
            .map(|(around, area)| Screen {
                around,
                weight: SCREENING * area,
            })
            .collect();
        let mut system = System {
            lattice,
            right_side,
            diagonal: Vec::new(),
            screens,
        };
        context.check()?;
        let mut diagonal = system.map_nodes(|_, neighbours, _| neighbours);
        for Screen { around, weight } in &system.screens {
            for (i, w) in around {
                diagonal[*i] += weight * w * w;
            }
        }
        system.diagonal = diagonal;
        Ok(system)
    }

    /// Computes a value for every node from its number, the number of its neighbours, and a function that sums over them.
    fn map_nodes(
        &self,
        value: impl Fn(usize, f64, &dyn Fn(&[f64]) -> f64) -> f64 + Sync,
    ) -> Vec<f64> {
        let [nx, ny, nz] = self.lattice.size;
        let strides = self.lattice.strides();
        let mut out = vec![0.0; self.lattice.nodes()];
        out.par_chunks_mut(nx).enumerate().for_each(|(row, out)| {
            let (y, z) = (row % ny, row / ny);
            for (x, out) in out.iter_mut().enumerate() {
                let i = row * nx + x;
                let mut beside = [usize::MAX; 6];
                let mut count = 0;
                for (k, (at, most)) in [(x, nx), (y, ny), (z, nz)].into_iter().enumerate() {
                    if at > 0 {
                        beside[count] = i - strides[k];
                        count += 1;
                    }
                    if at + 1 < most {
                        beside[count] = i + strides[k];
                        count += 1;
                    }
                }
                let sum = |v: &[f64]| beside[..count].iter().map(|j| v[*j]).sum::<f64>();
                *out = value(i, count as f64, &sum);
            }
        });
        out
    }

    /// Multiplies the matrix of the system by a vector.
    fn multiply(&self, v: &[f64]) -> Vec<f64> {
        let mut out = self.map_nodes(|i, count, sum| count * v[i] - sum(v));
        for Screen { around, weight } in &self.screens {
            let at: f64 = around.iter().map(|(i, w)| w * v[*i]).sum();
            for (i, w) in around {
                out[*i] += weight * at * w;
            }
        }
        out
    }

    /// Solves the system by conjugate gradients with a diagonal preconditioner, starting from `x`.
    fn solve(&self, mut x: Vec<f64>, context: &Context) -> Result<Vec<f64>, Cancelled> {
        let precondition = |r: &[f64]| -> Vec<f64> {
            let pairs = r.par_iter().zip(&self.diagonal);
            pairs.map(|(r, d)| r / d.max(1e-12)).collect()
        };
        let product = self.multiply(&x);
        let mut r: Vec<f64> = self
            .right_side
            .iter()
            .zip(&product)
            .map(|(b, a)| b - a)
            .collect();
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut rz = dot(&r, &z);
        let end = RELATIVE_RESIDUAL
            * RELATIVE_RESIDUAL
            * dot(&self.right_side, &precondition(&self.right_side));
        for _ in 0..MAX_STEPS {
            context.check()?;
            if rz <= end {
                break;
            }
            let ap = self.multiply(&p);
            let along = dot(&p, &ap);
            if along <= 0.0 {
                break;
            }
            let alpha = rz / along;
            x.par_iter_mut().zip(&p).for_each(|(x, p)| *x += alpha * p);
            r.par_iter_mut().zip(&ap).for_each(|(r, a)| *r -= alpha * a);
            z = precondition(&r);
            let next = dot(&r, &z);
            let beta = next / rz;
            p.par_iter_mut()
                .zip(&z)
                .for_each(|(p, z)| *p = z + beta * *p);
            rz = next;
        }
        Ok(x)
    }
}

/// The scalar product, summed in parts of a fixed length so that the number of threads does not change a bit.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    const PART: usize = 4096;
    let parts: Vec<f64> = a
        .par_chunks(PART)
        .zip(b.par_chunks(PART))
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum())
        .collect();
    parts.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reconstruct(points: &[DVec3], normals: &[DVec3], cell: f64) -> Mesh {
        let mesh = poisson(points, normals, cell, |_| f64::INFINITY, &Context::quiet()).unwrap();
        let report = mesh.check();
        assert!(report.is_solid(), "{report}");
        mesh
    }

    #[test]
    fn a_sphere_is_reconstructed_within_half_a_cell() {
        let middle = DVec3::new(3.0, -2.0, 1.0);
        // A Fibonacci lattice, and one side ten times as dense as the other.
        let normals: Vec<DVec3> = (0..20_000)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 20_000.0;
                let angle = f64::from(i) * 2.399_963_229_728_653;
                let r = (1.0 - z * z).sqrt();
                DVec3::new(r * angle.cos(), r * angle.sin(), z)
            })
            .enumerate()
            .filter(|(i, n)| n.x > 0.0 || i % 10 == 0)
            .map(|(_, n)| n)
            .collect();
        let points: Vec<DVec3> = normals.iter().map(|n| middle + 0.5 * *n).collect();
        let mesh = reconstruct(&points, &normals, 0.05);
        for p in &mesh.positions {
            let off = p.distance(middle) - 0.5;
            assert!(off.abs() < 0.025, "{off}");
        }
        let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.125;
        assert!(
            (mesh.volume() / volume - 1.0).abs() < 0.02,
            "{}",
            mesh.volume()
        );
    }

    #[test]
    fn a_long_ellipsoid_is_reconstructed_and_can_be_cut_off() {
        // Twelve times as long as wide: thinner than a cell of the coarsest lattice.
        let long = DVec3::new(1.0, 1.0, 12.0);
        let (points, normals): (Vec<DVec3>, Vec<DVec3>) = (0..30_000)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 30_000.0;
                let angle = f64::from(i) * 2.399_963_229_728_653;
                let r = (1.0 - z * z).sqrt();
                let n = DVec3::new(r * angle.cos(), r * angle.sin(), z);
                (n * long, (n / long).normalize())
            })
            .unzip();
        let mesh = reconstruct(&points, &normals, 0.15);
        let volume = 16.0 * std::f64::consts::PI;
        assert!(
            (mesh.volume() / volume - 1.0).abs() < 0.02,
            "{}",
            mesh.volume()
        );
        let half = poisson(&points, &normals, 0.15, |p| p.z, &Context::quiet()).unwrap();
        assert!(half.check().is_solid());
        assert!(
            (2.0 * half.volume() / volume - 1.0).abs() < 0.02,
            "{}",
            half.volume()
        );
        assert!(half.positions.iter().all(|p| p.z > -0.1));
    }

    #[test]
    fn a_torus_is_reconstructed_with_its_hole() {
        let (wide, thin, cell) = (1.0, 0.35, 0.06);
        let torus: Vec<(DVec3, DVec3)> = (0..15_000)
            .map(|i| {
                // Two badly approximable numbers cover both angles evenly.
                let turn = |step: f64| std::f64::consts::TAU * (step * f64::from(i)).fract();
                let (a, b) = (turn(0.754_877_666_246_692_8), turn(0.569_840_290_998_053_3));
                let out = DVec3::new(a.cos(), a.sin(), 0.0);
                let n = out * b.cos() + DVec3::Z * b.sin();
                (out * wide + n * thin, n)
            })
            .collect();
        let (points, normals): (Vec<_>, Vec<_>) = torus.into_iter().unzip();
        let mesh = reconstruct(&points, &normals, cell);
        for p in &mesh.positions {
            let off = (p.truncate().length() - wide).hypot(p.z) - thin;
            assert!(off.abs() < 0.5 * cell, "{off}");
        }
        // Vertices − edges + triangles is 0 for one hole; a closed mesh has three edges for two triangles.
        let characteristic = mesh.positions.len() as i64 - mesh.triangles.len() as i64 / 2;
        assert_eq!(characteristic, 0);
        let volume = 2.0 * std::f64::consts::PI.powi(2) * wide * thin * thin;
        assert!(
            (mesh.volume() / volume - 1.0).abs() < 0.03,
            "{}",
            mesh.volume()
        );
    }

    #[test]
    fn bad_cells_and_lists_are_refused() {
        let [p, n] = [[DVec3::ZERO, DVec3::ONE], [DVec3::Z; 2]];
        let quiet = Context::quiet();
        for cell in [0.0, -1.0, f64::NAN, 1e-6] {
            let error = poisson(&p, &n, cell, |_| 1.0, &quiet).unwrap_err();
            assert!(matches!(error, PoissonError::Cell { .. }), "{error}");
        }
        assert!(matches!(
            poisson(&p, &n[..1], 0.1, |_| 1.0, &quiet),
            Err(PoissonError::Lists { .. })
        ));
    }
}
