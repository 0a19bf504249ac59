//! The numbers of a stem's inside: `anatomy.json`, and a few lines for people.

use super::Work;
use super::particles::Layers;
use crate::report::closed_volume;
use greenstick_geometry::Mesh;
use greenstick_wood::anatomy::Section;
use greenstick_wood::stem::{Found, StemKind};
use greenstick_wood::tissue::Zone;
use serde::Serialize;
use std::fmt;

/// Directions over which a ring's radius is averaged.
const DIRECTIONS: usize = 72;

/// Difference of the voxels' volume from the mesh's that is told, %: a board may be a few voxels thick.
const COARSE: f64 = 2.0;

/// Everything that is worth knowing about a stem's inside. Lengths are in m along the centreline or in the world, as their
/// names say; every name ends with its unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnatomyReport {
    /// `greenstick-anatomy`.
    pub schema: &'static str,
    /// Version of the schema: it rises when a name changes or goes.
    pub version: u32,
    /// `round` or `board`.
    pub kind: &'static str,
    /// Species, where one was named.
    pub species: Option<String>,
    /// Length of the centreline, m.
    pub length_m: f64,
    /// Radius of the circle as large as the section at the place, m.
    pub radius_m: f64,
    /// Volume of the stem's mesh, m³; none where it is not closed.
    pub mesh_volume_m3: Option<f64>,
    /// Volume of all voxels that are wood, m³; none where none were made.
    pub voxel_volume_m3: Option<f64>,
    /// Number of rings; by erosion that of the section with most.
    pub rings: u16,
    /// Where rings come from: `field`, or `erosion` with its schedule and its inner circle.
    pub rings_by: String,
    /// Sectors of each ring, from the pith outwards.
    pub sectors: Vec<u32>,
    /// Number of layers.
    pub layers: usize,
    /// Distance of the layers, m.
    pub layer_distance_m: f64,
    /// Number of particles.
    pub particles: usize,
    /// Sum over the layers of sectors times rings (Eq. 1); more than `particles` where a board's faces
    /// cut rings off or a sector of an eroded ring has no pixel.
    pub equation_1: u64,
    /// Area of the smallest and the largest bundle, m².
    pub bundle_area_m2: [f64; 2],
    /// Standard deviation of the bundles' areas within a layer over their mean: the mean over all layers, and the most.
    pub bundle_spread: [f64; 2],
    /// What the numbers of zones stand for.
    pub zones: Vec<String>,
    /// Points of the centreline in the world, m.
    pub centreline_m: Vec<[f64; 3]>,
    /// Voxelised segments.
    pub segments: Vec<SegmentReport>,
    /// The section of every layer.
    pub sections: Vec<SectionReport>,
    /// What was assumed, repaired or could not be done, one sentence each.
    pub notes: Vec<String>,
}

/// A voxelised segment.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
    /// How far the centreline leaves the straight line that the image is placed along, at most, m.
    pub off_straight_m: f64,
    /// Sections whose outline was closed across holes of the mesh.
    pub sections_with_holes: usize,
    /// Sections with no voxel of wood.
    pub sections_without_wood: usize,
    /// The largest part of a section's girth that was guessed across holes, 0 to 1.
    pub girth_guessed: f64,
}

/// A section.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SectionReport {
    /// Length along the centreline, m.
    pub length_m: f64,
    /// The centreline there, m.
    pub centre_m: [f64; 3],
    /// The pith, m.
    pub pith_m: [f64; 3],
    /// Direction of the centreline.
    pub direction: [f64; 3],
    /// Direction from which angles count.
    pub x: [f64; 3],
    /// Area, m².
    pub area_m2: f64,
    /// Girth, m.
    pub girth_m: f64,
    /// Part of the girth that was guessed across holes of the mesh, 0 to 1.
    pub girth_guessed: f64,
    /// Its rings, from the pith outwards.
    pub rings: RingRows,
}

/// Rings of a section, column by column.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RingRows {
    /// Mean distance of the ring's outer contour from the pith, m; of an eroded ring the radius of the circle as large.
    pub radius_m: Vec<f64>,
    /// Mean width, m.
    pub width_m: Vec<f64>,
    /// Area within the section, m².
    pub area_m2: Vec<f64>,
    /// Number of the tissue.
    pub zone: Vec<u8>,
}

pub(super) fn report(
    work: &Work,
    layers: &Layers,
    (mesh, found): (&Mesh, &Found),
    segments: Vec<SegmentReport>,
    mut notes: Vec<String>,
) -> AnatomyReport {
    let stem = &found.stem;
    let axis = stem.grain.axis();
    let shell = Mesh {
        positions: mesh.positions.clone(),
        triangles: found
            .shell
            .iter()
            .filter_map(|&t| mesh.triangles.get(t as usize))
            .copied()
            .collect(),
        ..Mesh::default()
    };
    let all = || layers.particles.iter().flatten();
    let least = all().map(|p| p.area).fold(f64::INFINITY, f64::min);
    let most = all().map(|p| p.area).fold(0.0, f64::max);
    let holes: usize = segments.iter().map(|s| s.sections_with_holes).sum();
    if holes > 0 {
        let worst = segments.iter().map(|s| s.girth_guessed).fold(0.0, f64::max);
        notes.push(format!(
            "{holes} of {} sections were closed across holes of the mesh, {:.1} % of the girth at most",
            segments.len() * work.anatomy.grid.count,
            100.0 * worst
        ));
    }
    let (low, high) = work.anatomy.whole;
    if low > 0.0 || high < axis.length() {
        notes.push(format!(
            "particles lie between {low:.3} and {high:.3} m, where sections are whole"
        ));
    }
    // Of a mesh that is inside out, too.
    let mesh_volume = closed_volume(&shell).1.map(f64::abs);
    let voxel_volume = (!segments.is_empty()).then(|| segments.iter().map(|s| s.volume_m3).sum());
    if let (Some(mesh), Some(voxels)) = (mesh_volume, voxel_volume) {
        let off: f64 = 100.0 * (voxels / mesh - 1.0);
        if off.abs() > COARSE {
            notes.push(format!(
                "voxels of {:.2} mm are coarse for this stem: their volume is {off:+.1} % off the mesh's; a higher \
                 resolution brings it nearer",
                1e3 * work.anatomy.grid.pixel
            ));
        }
    }
    AnatomyReport {
        schema: "greenstick-anatomy",
        version: 1,
        kind: match stem.kind {
            StemKind::Round => "round",
            StemKind::Board => "board",
        },
        species: work.request.species.clone(),
        length_m: axis.length(),
        radius_m: stem.radius,
        mesh_volume_m3: mesh_volume,
        voxel_volume_m3: voxel_volume,
        rings: work.anatomy.rings,
        rings_by: work.request.rings_by.name(),
        sectors: layers.layout.sectors.clone(),
        layers: layers.sections.len(),
        layer_distance_m: layers.thickness,
        particles: all().count(),
        equation_1: layers.equation_1(),
        bundle_area_m2: [least.min(most), most],
        bundle_spread: spread(layers),
        zones: Zone::ALL.iter().map(ToString::to_string).collect(),
        centreline_m: axis.points().iter().map(|p| p.to_array()).collect(),
        segments,
        sections: layers
            .sections
            .iter()
            .zip(&layers.particles)
            .map(|(section, particles)| {
                let rings = usize::from(work.anatomy.rings);
                let mut areas = vec![0.0; rings];
                let mut zones: Vec<u8> = (1..=rings)
                    .map(|ring| work.numbers.zone[2 * (rings - ring) + 2].code())
                    .collect();
                for p in particles {
                    let ring = usize::from(p.ring) - 1;
                    areas[ring] += p.area;
                    zones[ring] = p.zone.code();
                }
                section_report(work, section, areas, zones)
            })
            .collect(),
        notes,
    }
}

fn section_report(
    work: &Work,
    section: &Section,
    areas: Vec<f64>,
    zones: Vec<u8>,
) -> SectionReport {
    let rings = work.anatomy.rings;
    let pith = section.field.pith();
    let mean = |ring: u16| {
        let rho = f64::from(ring) / f64::from(rings);
        let angle = |j: usize| std::f64::consts::TAU * j as f64 / DIRECTIONS as f64;
        let sum: f64 = (0..DIRECTIONS)
            .map(|j| section.field.point(rho, angle(j)).distance(pith))
            .sum();
        sum / DIRECTIONS as f64
    };
    let radii: Vec<f64> = if work.erosion.is_some() {
        // Of eroded rings those of circles as large.
        let mut sum = 0.0;
        let circles = areas.iter().map(|a| {
            sum += a;
            (sum / std::f64::consts::PI).sqrt()
        });
        std::iter::once(0.0).chain(circles).collect()
    } else {
        (0..=rings).map(mean).collect()
    };
    SectionReport {
        length_m: section.length,
        centre_m: section.frame.origin.to_array(),
        pith_m: section.world(pith).to_array(),
        direction: section.frame.tangent.to_array(),
        x: section.frame.x.to_array(),
        area_m2: section.outline.area,
        girth_m: section.outline.girth,
        girth_guessed: section.outline.guessed,
        rings: RingRows {
            width_m: radii.windows(2).map(|w| w[1] - w[0]).collect(),
            radius_m: radii[1..].to_vec(),
            area_m2: areas,
            zone: zones,
        },
    }
}

/// Spread of the bundles' areas within layers: mean and greatest.
fn spread(layers: &Layers) -> [f64; 2] {
    let spreads: Vec<f64> = layers
        .particles
        .iter()
        .filter(|layer| !layer.is_empty())
        .map(|layer| {
            let count = layer.len() as f64;
            let mean = layer.iter().map(|p| p.area).sum::<f64>() / count;
            let squares: f64 = layer.iter().map(|p| (p.area - mean).powi(2)).sum();
            (squares / count).sqrt() / mean
        })
        .collect();
    let mean = spreads.iter().sum::<f64>() / spreads.len().max(1) as f64;
    [mean, spreads.iter().copied().fold(0.0, f64::max)]
}

impl fmt::Display for AnatomyReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "stem      {}, {:.4} m long, radius {:.4} m at the place",
            self.kind, self.length_m, self.radius_m
        )?;
        writeln!(f, "rings     {}", self.rings)?;
        writeln!(
            f,
            "particles {} in {} layers, bundles from {:.3} to {:.3} mm², ±{:.0} % within a layer",
            self.particles,
            self.layers,
            self.bundle_area_m2[0] * 1e6,
            self.bundle_area_m2[1] * 1e6,
            self.bundle_spread[0] * 100.0
        )?;
        if let (Some(s), Some(v)) = (self.segments.first(), self.voxel_volume_m3) {
            write!(
                f,
                "voxels    {} segments of {}³, {:.3} × {:.3} × {:.3} mm, {v:.6} m³",
                self.segments.len(),
                s.voxels,
                s.voxel_m[0] * 1e3,
                s.voxel_m[1] * 1e3,
                s.voxel_m[2] * 1e3
            )?;
            match self.mesh_volume_m3 {
                Some(m) => writeln!(f, ", {:+.2} % of the mesh's", 100.0 * (v / m - 1.0))?,
                None => writeln!(f)?,
            }
        }
        for note in &self.notes {
            writeln!(f, "note      {note}")?;
        }
        Ok(())
    }
}
