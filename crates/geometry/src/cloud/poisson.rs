//! Screened Poisson reconstruction (Kazhdan and Hoppe 2013) on a regular grid: the closed surface whose inside has an
//! indicator with the gradient that the points' normals tell, and that passes through the points.
//!
//! Differences of the indicator along the grid's edges are fitted to the normals, its values at the points to 0, by
//! conjugate gradients from coarse grids to fine ones. The surface is cut out of the grid's tetrahedra (Doi and Koide 1991),
//! so that it is closed and a manifold whatever its form.

use super::tetrahedra::surface;
use crate::{Cancelled, Context, Mesh};
use glam::DVec3;
use rayon::prelude::*;

/// Weight of the points against their normals.
const SCREENING: f64 = 4.0;
/// Cells about the points on every side, of the finest grid.
const MARGIN: f64 = 6.0;
/// Cells along the longest side of the coarsest grid, at least.
const COARSEST: f64 = 12.0;
/// Steps of conjugate gradients on one grid, at most, and the residual, of the right side's, at which they end.
const STEPS: usize = 150;
const RESIDUAL: f64 = 1e-3;
/// Nodes of the finest grid, at most.
pub const MOST_NODES: f64 = 8e6;
/// Mean of the product of two linear hats across a surface: what turns points about a point into points of a cell's area.
const HATS: f64 = 2.0 / 3.0;

/// Why there is no surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PoissonError {
    /// Lists of different lengths, or none.
    #[error("{points} points with {normals} normals; expected as many of both, and some")]
    Lists {
        /// Number of points.
        points: usize,
        /// Number of normals.
        normals: usize,
    },
    /// Cells that are too small or no length.
    #[error(
        "cells of {cell} m make {nodes:.0} nodes about the points; expected at most {MOST_NODES:.0}"
    )]
    Cell {
        /// Side of a cell, m.
        cell: f64,
        /// Nodes.
        nodes: f64,
    },
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Nodes at equal distances along all axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice {
    pub low: DVec3,
    pub cell: f64,
    /// Nodes along x, y, z.
    pub size: [usize; 3],
}

impl Lattice {
    fn nodes(&self) -> usize {
        self.size.iter().product()
    }

    /// Steps from a node to the next along x, y, z.
    pub fn strides(&self) -> [usize; 3] {
        [1, self.size[0], self.size[0] * self.size[1]]
    }

    /// The eight nodes about a point with their weights; the lattice moved by half a cell along an axis, where one is given.
    fn about(&self, p: DVec3, half: Option<usize>) -> [(usize, f64); 8] {
        let mut q = ((p - self.low) / self.cell).to_array();
        if let Some(axis) = half {
            q[axis] -= 0.5;
        }
        let strides = self.strides();
        let mut first = 0;
        let mut part = [0.0; 3];
        for k in 0..3 {
            // Of edges there is one less than of nodes.
            let last = self.size[k] - 2 - usize::from(half == Some(k));
            let base = q[k].floor().clamp(0.0, last as f64);
            part[k] = (q[k] - base).clamp(0.0, 1.0);
            first += base as usize * strides[k];
        }
        std::array::from_fn(|corner| {
            let (mut at, mut weight) = (first, 1.0);
            for k in 0..3 {
                if corner >> k & 1 == 1 {
                    at += strides[k];
                    weight *= part[k];
                } else {
                    weight *= 1.0 - part[k];
                }
            }
            (at, weight)
        })
    }
}

/// The closed surface through `points` whose unit `normals` point out of it; `cell` is the side of a grid's cell, m, and what
/// is smaller is smoothed away. It is cut off, and closed, where `inside` (a distance, m) falls below 0.
///
/// # Errors
/// [`PoissonError`] where lists do not fit together, cells are too many, or the caller stops the work.
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
    let extent = high - low + 2.0 * MARGIN * cell;
    let nodes = (extent / cell + 1.0).to_array().iter().product::<f64>();
    if !(cell > 0.0 && nodes <= MOST_NODES) {
        return Err(PoissonError::Cell { cell, nodes });
    }
    let mut halvings = 0;
    while extent.max_element() / (cell * f64::from(2 << halvings)) >= COARSEST {
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
            Some((before, values)) => finer(before, values, &lattice),
            None => vec![0.0; lattice.nodes()],
        };
        let system = System::new(lattice, points, normals);
        values = Some((lattice, system.solved(start)));
    }
    let Some((lattice, values)) = values else {
        return Ok(Mesh::default());
    };
    let at = |p: &DVec3| -> f64 {
        let about = lattice.about(*p, None);
        about.iter().map(|(i, w)| w * values[*i]).sum()
    };
    let level = points.iter().map(at).sum::<f64>() / points.len() as f64;
    Ok(surface(&lattice, &values, level, inside))
}

/// Values of a lattice at the nodes of one of half its cells.
fn finer(coarse: &Lattice, values: &[f64], fine: &Lattice) -> Vec<f64> {
    let [nx, ny, _] = fine.size;
    (0..fine.nodes())
        .into_par_iter()
        .map(|i| {
            let at = [i % nx, i / nx % ny, i / (nx * ny)].map(|k| k as f64);
            let about = coarse.about(fine.low + DVec3::from_array(at) * fine.cell, None);
            about.iter().map(|(i, w)| w * values[*i]).sum()
        })
        .collect()
}

/// What the indicator has to be: the normal equations of both fits.
struct System {
    lattice: Lattice,
    right: Vec<f64>,
    diagonal: Vec<f64>,
    /// Nodes about each point with their weights, and the point's own weight.
    screens: Vec<([(usize, f64); 8], f64)>,
}

impl System {
    fn new(lattice: Lattice, points: &[DVec3], normals: &[DVec3]) -> Self {
        let strides = lattice.strides();
        let abouts: Vec<_> = points.iter().map(|p| lattice.about(*p, None)).collect();
        let mut density = vec![0.0; lattice.nodes()];
        for (i, w) in abouts.iter().flatten() {
            density[*i] += w;
        }
        // The area, in cells' sides squared, that each point stands for.
        let areas: Vec<f64> = abouts
            .iter()
            .map(|about| HATS / about.iter().map(|(i, w)| w * density[*i]).sum::<f64>())
            .collect();
        let mut right = vec![0.0; lattice.nodes()];
        for ((p, n), area) in points.iter().zip(normals).zip(&areas) {
            for axis in 0..3 {
                for (i, w) in lattice.about(*p, Some(axis)) {
                    // The indicator is higher inside.
                    let step = -n[axis] * area * w;
                    right[i] -= step;
                    right[i + strides[axis]] += step;
                }
            }
        }
        let screens: Vec<_> = abouts
            .into_iter()
            .zip(areas)
            .map(|(about, area)| (about, SCREENING * area))
            .collect();
        let mut made = System {
            lattice,
            right,
            diagonal: Vec::new(),
            screens,
        };
        let mut diagonal = made.rows(|_, neighbours, _| neighbours);
        for (about, weight) in &made.screens {
            about
                .iter()
                .for_each(|(i, w)| diagonal[*i] += weight * w * w);
        }
        made.diagonal = diagonal;
        made
    }

    /// A number for every node from its own, the number of its neighbours and a way to sum over them.
    fn rows(&self, of: impl Fn(usize, f64, &dyn Fn(&[f64]) -> f64) -> f64 + Sync) -> Vec<f64> {
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
                *out = of(i, count as f64, &sum);
            }
        });
        out
    }

    fn applied(&self, v: &[f64]) -> Vec<f64> {
        let mut out = self.rows(|i, count, sum| count * v[i] - sum(v));
        for (about, weight) in &self.screens {
            let at: f64 = about.iter().map(|(i, w)| w * v[*i]).sum();
            about.iter().for_each(|(i, w)| out[*i] += weight * at * w);
        }
        out
    }

    /// Conjugate gradients, scaled by the diagonal.
    fn solved(&self, mut x: Vec<f64>) -> Vec<f64> {
        let scaled = |r: &[f64]| -> Vec<f64> {
            let pairs = r.par_iter().zip(&self.diagonal);
            pairs.map(|(r, d)| r / d.max(1e-12)).collect()
        };
        let applied = self.applied(&x);
        let mut r: Vec<f64> = self
            .right
            .iter()
            .zip(&applied)
            .map(|(b, a)| b - a)
            .collect();
        let mut z = scaled(&r);
        let mut p = z.clone();
        let mut rz = dot(&r, &z);
        let end = RESIDUAL * RESIDUAL * dot(&self.right, &scaled(&self.right));
        for _ in 0..STEPS {
            if rz <= end {
                break;
            }
            let ap = self.applied(&p);
            let along = dot(&p, &ap);
            if along <= 0.0 {
                break;
            }
            let alpha = rz / along;
            x.par_iter_mut().zip(&p).for_each(|(x, p)| *x += alpha * p);
            r.par_iter_mut().zip(&ap).for_each(|(r, a)| *r -= alpha * a);
            z = scaled(&r);
            let next = dot(&r, &z);
            let beta = next / rz;
            p.par_iter_mut()
                .zip(&z)
                .for_each(|(p, z)| *p = z + beta * *p);
            rz = next;
        }
        x
    }
}

/// The product of two lists, summed in parts of a fixed length, so that threads change no bit.
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

    fn made(points: &[DVec3], normals: &[DVec3], cell: f64) -> Mesh {
        let mesh = poisson(points, normals, cell, |_| f64::INFINITY, &Context::quiet()).unwrap();
        let report = mesh.check();
        assert!(report.is_solid(), "{report}");
        mesh
    }

    #[test]
    fn a_ball_comes_back_within_a_cell() {
        let middle = DVec3::new(3.0, -2.0, 1.0);
        // Fibonacci's lattice, and one side ten times as dense as the other.
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
        let mesh = made(&points, &normals, 0.05);
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
    fn a_long_body_comes_back_and_can_be_cut_off() {
        // Twelve times as long as wide: thinner than a cell of the coarsest grid.
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
        let mesh = made(&points, &normals, 0.15);
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
    fn a_torus_comes_back_with_its_hole() {
        let (wide, thin, cell) = (1.0, 0.35, 0.06);
        let form: Vec<(DVec3, DVec3)> = (0..15_000)
            .map(|i| {
                // Two numbers far from fractions cover both angles evenly.
                let turn = |step: f64| std::f64::consts::TAU * (step * f64::from(i)).fract();
                let (a, b) = (turn(0.754_877_666_246_692_8), turn(0.569_840_290_998_053_3));
                let out = DVec3::new(a.cos(), a.sin(), 0.0);
                let n = out * b.cos() + DVec3::Z * b.sin();
                (out * wide + n * thin, n)
            })
            .collect();
        let (points, normals): (Vec<_>, Vec<_>) = form.into_iter().unzip();
        let mesh = made(&points, &normals, cell);
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
    fn what_makes_no_grid_is_refused() {
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
