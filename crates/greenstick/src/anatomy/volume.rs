//! The volume: segments of the stem as VTK image data, section by section, so that no more than the compressed slices of
//! one segment is ever held.
//!
//! A segment's sections are square to the centreline; its image is placed in the world by the frame at its middle. For a
//! straight stem that is exact; the report gives how far the centreline of a bent one leaves it.

use super::report::SegmentReport;
use crate::Error;
use glam::DVec3;
use greenstick_formats::Encoded;
use greenstick_formats::vtk::{
    Block, Image, ImageArray, ImageNumber, compress, write_image, write_multiblock,
};
use greenstick_geometry::{Cancelled, Context};
use greenstick_wood::anatomy::{Anatomy, Segment, VoxelSlice};
use rayon::prelude::*;

/// Sections between two reports of progress.
const SECTIONS_PER_REPORT: usize = 32;

/// The compressed voxels of a section.
struct CompressedSlice {
    rings: Vec<u8>,
    tissues: Vec<u8>,
    colours: Vec<u8>,
    wood_voxels: usize,
    bridged: f64,
}

impl CompressedSlice {
    fn new(slice: &VoxelSlice, number: ImageNumber) -> Self {
        let rings = slice.rings.iter();
        let rings: Vec<u8> = match number {
            ImageNumber::U8 => rings.map(|&ring| ring as u8).collect(),
            ImageNumber::U16 => rings.flat_map(|ring| ring.to_le_bytes()).collect(),
        };
        CompressedSlice {
            rings: compress(&rings),
            tissues: compress(&slice.tissues),
            colours: compress(slice.colours.as_flattened()),
            wood_voxels: slice.wood_voxels,
            bridged: slice.bridged,
        }
    }
}

/// One `.vti` for a stem of one segment; else one for each, and a `.vtm` that lists them.
pub(super) fn volume<E: From<Error>>(
    anatomy: &Anatomy,
    context: &Context,
    sink: &mut dyn FnMut(Encoded) -> Result<(), E>,
) -> Result<Vec<SegmentReport>, E> {
    let segments = &anatomy.sections().segments;
    let (mut reports, mut blocks) = (Vec::new(), Vec::new());
    for (i, segment) in segments.iter().enumerate() {
        let slices = compressed_slices(anatomy, segment, &context.item(i, segments.len()))
            .map_err(Error::from)?;
        let name = match segments.len() {
            1 => "volume.vti".to_owned(),
            _ => format!("volume_{i:03}.vti"),
        };
        reports.push(report(anatomy, segment, &slices, &name));
        let file = write_image(&image(anatomy, segment, slices), &name);
        sink(file.map_err(Error::from)?)?;
        blocks.push(Block {
            name: format!("segment {i}"),
            file: name,
        });
    }
    if blocks.len() > 1 {
        sink(write_multiblock(&blocks, "volume.vtm"))?;
    }
    Ok(reports)
}

fn compressed_slices(
    anatomy: &Anatomy,
    segment: &Segment,
    context: &Context,
) -> Result<Vec<CompressedSlice>, Cancelled> {
    let stem = anatomy.sections();
    let count = stem.grid.count;
    let number = ring_number(anatomy);
    let mut slices = Vec::with_capacity(count);
    for start in (0..count).step_by(SECTIONS_PER_REPORT) {
        context.report(start as f64 / count as f64)?;
        let batch: Vec<CompressedSlice> = (start..count.min(start + SECTIONS_PER_REPORT))
            .into_par_iter()
            .map(|k| {
                let length = stem.length_in_segment(segment, k);
                let slice = anatomy.voxel_slice(length, context)?;
                Ok(CompressedSlice::new(&slice, number))
            })
            .collect::<Result<_, Cancelled>>()?;
        slices.extend(batch);
    }
    Ok(slices)
}

/// The type of numbers that holds all rings.
fn ring_number(anatomy: &Anatomy) -> ImageNumber {
    if anatomy.ring_count() > 255 {
        ImageNumber::U16
    } else {
        ImageNumber::U8
    }
}

fn image(anatomy: &Anatomy, segment: &Segment, slices: Vec<CompressedSlice>) -> Image {
    let grid = &anatomy.sections().grid;
    let spacing = anatomy.sections().spacing();
    let half = 0.5 * grid.count as f64;
    let f = &segment.frame;
    let corner: DVec3 = (f.x + f.y) * (half * grid.pixel) + f.tangent * (half * spacing);
    let (mut rings, mut tissues, mut colours) = (Vec::new(), Vec::new(), Vec::new());
    for slice in slices {
        rings.push(slice.rings);
        tissues.push(slice.tissues);
        colours.push(slice.colours);
    }
    let array = |name: &str, components, number, slices| ImageArray {
        name: name.to_owned(),
        components,
        number,
        slices,
    };
    Image {
        counts: [grid.count; 3],
        origin: f.origin - corner,
        spacing: [grid.pixel, grid.pixel, spacing],
        directions: [f.x, f.y, f.tangent],
        arrays: vec![
            array("ring", 1, ring_number(anatomy), rings),
            array("zone", 1, ImageNumber::U8, tissues),
            array("colour", 3, ImageNumber::U8, colours),
        ],
    }
}

fn report(
    anatomy: &Anatomy,
    segment: &Segment,
    slices: &[CompressedSlice],
    name: &str,
) -> SegmentReport {
    let grid = &anatomy.sections().grid;
    let spacing = anatomy.sections().spacing();
    let voxels: usize = slices.iter().map(|s| s.wood_voxels).sum();
    SegmentReport {
        file: name.to_owned(),
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
