//! Voxels of a section.

use super::model::Anatomy;
use super::sections::Segment;
use greenstick_geometry::{Cancelled, Context};
use rayon::prelude::*;

/// Slices between two reports of progress.
const SLICES_PER_REPORT: usize = 32;

/// The code of the tissue of voxels that are not wood; wood has [`crate::tissue::Zone::code`].
pub const NO_TISSUE: u8 = 255;

/// The voxels of one section, row by row, each row along the section's x, the first row at its lowest y.
#[derive(Debug, Clone, PartialEq)]
pub struct VoxelSlice {
    /// Ring, counted from 1 at the pith; 0 where there is no wood.
    pub rings: Vec<u16>,
    /// Code of the tissue; [`NO_TISSUE`] where there is no wood.
    pub tissues: Vec<u8>,
    /// Colour, sRGB; black where there is no wood.
    pub colours: Vec<[u8; 3]>,
    /// Number of voxels that are wood.
    pub wood_voxels: usize,
    /// Part of the section's girth that was bridged across holes of the mesh, 0 to 1.
    pub bridged: f64,
}

impl Anatomy<'_> {
    /// Converts the voxels of each section of a segment by all threads of the current pool. No more slices are held than
    /// are converted at a time.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn map_slices<T: Send>(
        &self,
        segment: &Segment,
        convert: impl Fn(&VoxelSlice) -> T + Sync,
        context: &Context,
    ) -> Result<Vec<T>, Cancelled> {
        let count = self.sections().grid.count;
        let mut slices = Vec::with_capacity(count);
        for start in (0..count).step_by(SLICES_PER_REPORT) {
            context.report(start as f64 / count as f64)?;
            let batch: Vec<T> = (start..count.min(start + SLICES_PER_REPORT))
                .into_par_iter()
                .map(|k| {
                    let length = self.sections().length_in_segment(segment, k);
                    Ok(convert(&self.voxel_slice(length, context)?))
                })
                .collect::<Result<_, Cancelled>>()?;
            slices.extend(batch);
        }
        Ok(slices)
    }

    /// The voxels of the section at a length, m. A plane that misses the stem has none of wood.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn voxel_slice(&self, length: f64, context: &Context) -> Result<VoxelSlice, Cancelled> {
        context.check()?;
        let grid = &self.sections().grid;
        let voxels = grid.count * grid.count;
        let mut slice = VoxelSlice {
            rings: vec![0; voxels],
            tissues: vec![NO_TISSUE; voxels],
            colours: vec![[0; 3]; voxels],
            wood_voxels: 0,
            bridged: 0.0,
        };
        let Some(section) = self.sections().section(length) else {
            return Ok(slice);
        };
        let raster = self.rasterize(&section, grid, context)?;
        slice.wood_voxels = raster.wood.count();
        slice.bridged = section.outline.bridged;
        // Passes come in runs, all of which mean the same.
        let mut end = 0;
        for run in raster.passes.chunk_by(|a, b| a == b) {
            let voxels = end..end + run.len();
            end = voxels.end;
            if run[0] == 0 {
                continue;
            }
            let meaning = raster.legend.of(run[0]);
            slice.rings[voxels.clone()].fill(meaning.ring);
            slice.tissues[voxels.clone()].fill(meaning.tissue.code());
            slice.colours[voxels].fill(raster.palette[usize::from(run[0])]);
        }
        Ok(slice)
    }
}
