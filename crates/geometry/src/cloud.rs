//! Point clouds: what a scanner gives, their cleaning and their normals.

mod clean;
mod eigen;
mod neighbours;
mod normals;
mod poisson;
mod sample;
mod tetrahedra;

pub use clean::{CleanError, CleanOptions, CleanReport, CleanStep, clean, spacing};
pub use eigen::eigen;
pub use neighbours::Neighbours;
pub use normals::{normals, orient_along_tree, orient_from};
pub use poisson::{MOST_NODES, PoissonError, poisson};
pub use sample::sample_meshes;

use glam::DVec3;

/// Points with what was measured at each. Every list but `points` is either empty or as long as `points`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointCloud {
    /// Positions, m.
    pub points: Vec<DVec3>,
    /// Unit normals out of the wood.
    pub normals: Vec<DVec3>,
    /// Red, green, blue, 0 to 255.
    pub colours: Vec<[u8; 3]>,
}

impl PointCloud {
    /// The points numbered in `keep`, in that order, with what belongs to them.
    pub fn select(&self, keep: &[u32]) -> Self {
        fn pick<T: Copy>(from: &[T], keep: &[u32]) -> Vec<T> {
            if from.is_empty() {
                return Vec::new();
            }
            keep.iter().map(|&i| from[i as usize]).collect()
        }
        PointCloud {
            points: pick(&self.points, keep),
            normals: pick(&self.normals, keep),
            colours: pick(&self.colours, keep),
        }
    }
}
