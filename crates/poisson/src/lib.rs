//! Screened Poisson surfaces of point clouds (Kazhdan and Hoppe 2013), by the crate `poisson_reconstruction`.
//!
//! For what is no surface over angle and length: forks, stumps, folded bark. It is a crate of its own because the library
//! brings a linear algebra and a collision crate along.
#![deny(missing_docs)]

use glam::DVec3;
use greenstick_geometry::{Cancelled, Context, Mesh, PointCloud};
use poisson_reconstruction::PoissonReconstruction;

/// Weight of the points against the normals, as the paper has it.
const SCREENING: f64 = 4.0;
/// Rounds of the solver on each level.
const ROUNDS: usize = 10;
/// Finest and coarsest level; each halves the cells of the one before.
const DEPTHS: (u32, u32) = (4, 9);
/// Width of the finest cells in spacings of the points.
const CELL: f64 = 2.0;

/// Why there is no surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PoissonError {
    /// Points without normals.
    #[error("{normals} normals for {points} points; expected an oriented unit normal for each")]
    Normals {
        /// Points.
        points: usize,
        /// Normals.
        normals: usize,
    },
    /// Nothing came out.
    #[error("the points enclose nothing; expected points around a body, their normals outwards")]
    Nothing,
    /// The caller stopped the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// The closed surface through points with normals that look outwards. `spacing` is the distance between neighbours, m.
///
/// # Errors
/// [`PoissonError`] where there are no normals or no surface.
pub fn surface(cloud: &PointCloud, spacing: f64, context: &Context) -> Result<Mesh, PoissonError> {
    let (points, normals) = (&cloud.points, &cloud.normals);
    if points.is_empty() || normals.len() != points.len() || spacing.is_nan() || spacing <= 0.0 {
        return Err(PoissonError::Normals {
            points: points.len(),
            normals: normals.len(),
        });
    }
    context.step("bark", 0.0)?;
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in points {
        (low, high) = (low.min(*p), high.max(*p));
    }
    let size = (high - low).max_element();
    let mut depth = DEPTHS.0;
    while depth < DEPTHS.1 && size / f64::from(1u32 << depth) > CELL * spacing {
        depth += 1;
    }
    let places: Vec<_> = points.iter().map(|p| p.to_array().into()).collect();
    let directions: Vec<_> = normals.iter().map(|n| n.to_array().into()).collect();
    let solved = PoissonReconstruction::from_points_and_normals(
        &places,
        &directions,
        SCREENING,
        depth.saturating_sub(1) as usize,
        depth as usize,
        ROUNDS,
    );
    context.step("bark", 0.7)?;
    let buffers = solved.reconstruct_mesh_buffers();
    let vertices = buffers.vertices();
    let mut mesh = Mesh {
        positions: vertices.iter().map(|v| DVec3::new(v.x, v.y, v.z)).collect(),
        ..Mesh::default()
    };
    mesh.triangles = buffers
        .indices()
        .chunks_exact(3)
        .map(|t| [t[0], t[1], t[2]])
        .collect();
    if mesh.triangles.is_empty() {
        return Err(PoissonError::Nothing);
    }
    if mesh.volume() < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    context.step("bark", 1.0)?;
    Ok(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_keeps_its_volume() {
        let count = 4000;
        let points: Vec<DVec3> = (0..count)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
                let angle = f64::from(i) * 2.399_963_229_728_653;
                let r = (1.0 - z * z).sqrt();
                DVec3::new(r * angle.cos(), r * angle.sin(), z)
            })
            .collect();
        let cloud = PointCloud {
            normals: points.clone(),
            points,
            colours: Vec::new(),
        };
        let mesh = surface(&cloud, 0.05, &Context::quiet()).unwrap();
        let ball = 4.0 / 3.0 * std::f64::consts::PI;
        assert!(
            (mesh.volume() / ball - 1.0).abs() < 0.03,
            "{}",
            mesh.volume()
        );
        let error = surface(&PointCloud::default(), 0.05, &Context::quiet()).unwrap_err();
        assert!(error.to_string().contains("0 normals"), "{error}");
    }
}
