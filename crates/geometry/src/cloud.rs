//! Point clouds: their cleaning, their normals, and the reconstruction of surfaces from them.

mod batches;
mod clean;
mod distances;
mod kd_tree;
mod lattice;
mod local;
mod normals;
mod poisson;
mod report;
mod sample;
mod table;
mod tetrahedra;

pub use clean::clean;
pub use distances::spacing;
pub use kd_tree::KdTree;
pub use local::LocalFrame;
pub use normals::{normals, orient_along_tree, orient_from, try_normals};
pub use poisson::{MAX_NODES, PoissonError, poisson};
pub use report::{CleanError, CleanOptions, CleanReport, CleanStep};
pub use sample::sample_meshes;
pub use table::points_table;

use glam::DVec3;

/// Points with the data measured at each. Every list but `points` is either empty or as long as `points`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointCloud {
    /// Positions, m.
    pub points: Vec<DVec3>,
    /// Unit normals, pointing outwards.
    pub normals: Vec<DVec3>,
    /// Red, green, blue, 0 to 255.
    pub colours: Vec<[u8; 3]>,
}

impl PointCloud {
    /// Returns the points with the numbers in `keep`, in that order, with their data.
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
