//! A point cloud with what is known of its file.

use glam::DVec3;
use greenstick_geometry::PointCloud;

/// A point cloud as read from a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CloudFile {
    /// The points, m. Coordinates may be NaN where a scanner marks missing returns.
    pub cloud: PointCloud,
    /// What was subtracted from every point because the coordinates in the file are far from 0, m.
    pub origin: DVec3,
    /// How the file was interpreted and what was left out, one sentence each.
    pub notes: Vec<String>,
}
