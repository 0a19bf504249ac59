//! The volume: segments of the stem as VTK image data, section by section, so that no more than the compressed slices is
//! ever held.
//!
//! A segment's sections are square to the centreline; its image is placed in the world by the frame at its middle. For a
//! straight stem that is exact; the report gives how far the centreline of a bent one leaves it.

use super::Work;
use super::report::SegmentReport;
use crate::Error;
use glam::DVec3;
use greenstick_formats::Encoded;
use greenstick_formats::vtk::{
    Block, Image, ImageArray, ImageNumber, compress, write_image, write_multiblock,
};
use greenstick_geometry::Context;
use greenstick_wood::anatomy::Segment;
use rayon::prelude::*;

/// Sections between two looks at whether to stop.
const BATCH: usize = 32;

/// What is made of a section.
struct Slice {
    ring: Vec<u8>,
    zone: Vec<u8>,
    colour: Vec<u8>,
    voxels: usize,
    guessed: f64,
}

/// One `.vti` for a stem of one segment; else one for each, and a `.vtm` that lists them.
pub(super) fn volume(
    work: &Work,
    context: &Context,
) -> Result<(Vec<Encoded>, Vec<SegmentReport>), Error> {
    let segments = &work.anatomy.segments;
    let (mut files, mut reports, mut listed) = (Vec::new(), Vec::new(), Vec::new());
    for (i, segment) in segments.iter().enumerate() {
        let count = work.anatomy.grid.count;
        let mut slices = Vec::with_capacity(count);
        for start in (0..count).step_by(BATCH) {
            let done = (i as f64 + start as f64 / count as f64) / segments.len() as f64;
            context.report(done)?;
            let batch: Vec<Slice> = (start..count.min(start + BATCH))
                .into_par_iter()
                .map(|k| slice(work, work.anatomy.length_of(segment, k)))
                .collect();
            slices.extend(batch);
        }
        let name = match segments.len() {
            1 => "volume.vti".to_owned(),
            _ => format!("volume_{i:03}.vti"),
        };
        reports.push(report(work, segment, &slices, &name));
        files.push(write_image(&image(work, segment, slices), &name)?);
        listed.push(Block {
            name: format!("segment {i}"),
            file: name,
        });
    }
    if listed.len() > 1 {
        files.push(write_multiblock(&listed, "volume.vtm"));
    }
    Ok((files, reports))
}

fn slice(work: &Work, length: f64) -> Slice {
    let grid = &work.anatomy.grid;
    let pixels = grid.count * grid.count;
    let wide = work.anatomy.rings > 255;
    let Some(section) = work.anatomy.section(length) else {
        return Slice {
            ring: compress(&vec![0; pixels * if wide { 2 } else { 1 }]),
            zone: compress(&vec![NO_WOOD; pixels]),
            colour: compress(&vec![0; 3 * pixels]),
            voxels: 0,
            guessed: 0.0,
        };
    };
    let drawn = work.drawn(&section, grid);
    let (passes, numbers) = (&drawn.passes, &drawn.numbers);
    let ring = |p: u16| numbers.ring[usize::from(p)];
    let rings: Vec<u8> = if wide {
        passes.iter().flat_map(|&p| ring(p).to_le_bytes()).collect()
    } else {
        passes.iter().map(|&p| ring(p) as u8).collect()
    };
    let zone = |p: u16| {
        if p == 0 {
            NO_WOOD
        } else {
            numbers.zone[usize::from(p)].code()
        }
    };
    let zones: Vec<u8> = passes.iter().map(|&p| zone(p)).collect();
    let colours: Vec<[u8; 3]> = passes
        .iter()
        .map(|&p| drawn.palette[usize::from(p)])
        .collect();
    Slice {
        ring: compress(&rings),
        zone: compress(&zones),
        colour: compress(colours.as_flattened()),
        voxels: drawn.map.count(),
        guessed: section.outline.guessed,
    }
}

/// Zone of voxels that are not wood.
const NO_WOOD: u8 = 255;

fn image(work: &Work, segment: &Segment, slices: Vec<Slice>) -> Image {
    let grid = &work.anatomy.grid;
    let spacing = work.anatomy.spacing();
    let half = 0.5 * grid.count as f64;
    let f = &segment.frame;
    let corner: DVec3 = (f.x + f.y) * (half * grid.pixel) + f.tangent * (half * spacing);
    let (mut rings, mut zones, mut colours) = (Vec::new(), Vec::new(), Vec::new());
    for slice in slices {
        rings.push(slice.ring);
        zones.push(slice.zone);
        colours.push(slice.colour);
    }
    let array = |name: &str, components, number, slices| ImageArray {
        name: name.to_owned(),
        components,
        number,
        slices,
    };
    let number = if work.anatomy.rings > 255 {
        ImageNumber::U16
    } else {
        ImageNumber::U8
    };
    Image {
        counts: [grid.count; 3],
        origin: f.origin - corner,
        spacing: [grid.pixel, grid.pixel, spacing],
        directions: [f.x, f.y, f.tangent],
        arrays: vec![
            array("ring", 1, number, rings),
            array("zone", 1, ImageNumber::U8, zones),
            array("colour", 3, ImageNumber::U8, colours),
        ],
    }
}

fn report(work: &Work, segment: &Segment, slices: &[Slice], name: &str) -> SegmentReport {
    let grid = &work.anatomy.grid;
    let voxel = grid.pixel * grid.pixel * work.anatomy.spacing();
    let voxels: usize = slices.iter().map(|s| s.voxels).sum();
    SegmentReport {
        file: name.to_owned(),
        range_m: [segment.range.0, segment.range.1],
        voxels: grid.count,
        voxel_m: [grid.pixel, grid.pixel, work.anatomy.spacing()],
        volume_m3: voxels as f64 * voxel,
        off_straight_m: segment.sagitta,
        sections_with_holes: slices.iter().filter(|s| s.guessed > 0.0).count(),
        sections_without_wood: slices.iter().filter(|s| s.voxels == 0).count(),
        girth_guessed: slices.iter().map(|s| s.guessed).fold(0.0, f64::max),
    }
}
