//! The volume: segments of the stem as VTK image data, section by section, so that no more than the compressed slices of
//! one segment is ever held.
//!
//! A segment's sections are square to the centreline; its image is placed in the world by the frame at its middle. For a
//! straight stem that is exact; the report gives how far the centreline of a bent one leaves it.

use super::outputs::Outputs;
use crate::Error;
use glam::DVec3;
use greenstick_formats::vtk::{Block, Image, ImageArray, ImageNumber, compress, write_multiblock};
use greenstick_geometry::{Context, Metadata};
use greenstick_wood::anatomy::{Anatomy, Segment, SegmentReport, SliceMeasures, VoxelSlice};

/// The compressed voxels of a section.
struct CompressedSlice {
    rings: Vec<u8>,
    tissues: Vec<u8>,
    colours: Vec<u8>,
    measures: SliceMeasures,
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
            measures: slice.into(),
        }
    }
}

/// One `.vti` for a stem of one segment; else one for each, and a `.vtm` that lists them.
pub(super) fn write<E: From<Error>>(
    anatomy: &Anatomy,
    context: &Context,
    outputs: &mut Outputs<E>,
) -> Result<Vec<SegmentReport>, E> {
    let segments = &anatomy.sections().segments;
    let (mut reports, mut blocks) = (Vec::new(), Vec::new());
    for (i, segment) in segments.iter().enumerate() {
        let compress = |slice: &VoxelSlice| CompressedSlice::new(slice, ring_number(anatomy));
        let slices = anatomy
            .map_slices(segment, compress, &context.item(i, segments.len()))
            .map_err(Error::from)?;
        let name = match segments.len() {
            1 => "volume.vti".to_owned(),
            _ => format!("volume_{i:03}.vti"),
        };
        let measures: Vec<SliceMeasures> = slices.iter().map(|s| s.measures).collect();
        reports.push(SegmentReport::new(anatomy, segment, &measures, &name));
        outputs.volume(image(anatomy, segment, slices), &name)?;
        blocks.push(Block {
            name: format!("segment {i}"),
            file: name,
        });
    }
    if blocks.len() > 1 {
        outputs.add(write_multiblock(&blocks, "volume.vtm"))?;
    }
    Ok(reports)
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
        metadata: Metadata::default(),
    }
}
