//! The numbers of a voxelised segment.

use super::model::Anatomy;
use super::sections::Segment;
use super::voxels::VoxelSlice;
use serde::{Deserialize, Serialize};

/// A voxelised segment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SegmentReport {
    /// Its file.
    pub file: String,
    /// Where it begins and ends along the centreline, m.
    pub range_m: [f64; 2],
    /// Voxels along each side.
    pub voxels: usize,
    /// Sides of a voxel, m.
    pub voxel_m: [f64; 3],
    /// Volume of the voxels that are wood, m³.
    pub volume_m3: f64,
    /// How far the centreline leaves the straight line along which the image is placed, at most, m.
    pub off_straight_m: f64,
    /// Sections whose outline was closed across holes of the mesh.
    pub sections_with_holes: usize,
    /// Sections with no voxel of wood.
    pub sections_without_wood: usize,
    /// The largest part of a section's girth that was bridged across holes, 0 to 1.
    pub girth_guessed: f64,
}

/// How much wood a slice of voxels has, and how sure its outline is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SliceMeasures {
    /// Number of voxels that are wood.
    pub wood_voxels: usize,
    /// Part of the section's girth that was bridged across holes of the mesh, 0 to 1.
    pub bridged: f64,
}

impl From<&VoxelSlice> for SliceMeasures {
    fn from(slice: &VoxelSlice) -> Self {
        SliceMeasures {
            wood_voxels: slice.wood_voxels,
            bridged: slice.bridged,
        }
    }
}

impl SegmentReport {
    /// Returns the report of a segment with these slices, which is in a file of this name.
    pub fn new(
        anatomy: &Anatomy,
        segment: &Segment,
        slices: &[SliceMeasures],
        file: &str,
    ) -> SegmentReport {
        let grid = &anatomy.sections().grid;
        let spacing = anatomy.sections().spacing();
        let voxels: usize = slices.iter().map(|s| s.wood_voxels).sum();
        SegmentReport {
            file: file.to_owned(),
            range_m: [segment.range.0, segment.range.1],
            voxels: grid.count,
            voxel_m: [grid.pixel, grid.pixel, spacing],
            volume_m3: voxels as f64 * (grid.pixel * grid.pixel * spacing),
            off_straight_m: segment.sagitta,
            sections_with_holes: slices.iter().filter(|s| s.bridged > 0.0).count(),
            sections_without_wood: slices.iter().filter(|s| s.wood_voxels == 0).count(),
            girth_guessed: slices.iter().map(|s| s.bridged).fold(0.0, f64::max),
        }
    }
}
