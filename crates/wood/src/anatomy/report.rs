//! The numbers of a stem's inside: `anatomy.json`, and a few lines for people.

use super::hexahedra::StemElements;
use super::layers::ParticleLayers;
use super::limb_report::LimbReport;
use super::measures::SectionMeasures;
use super::mensuration::{MassReport, MensurationReport, StemMeasures};
use super::model::{Anatomy, RingMethod};
use super::segment_report::SegmentReport;
use crate::stem::{FoundStem, LeftOut};
use crate::tissue::Zone;
use glam::DVec3;
use greenstick_geometry::{CheckOptions, Mesh, Provenance};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::fmt;

/// Largest difference of the voxels' volume from the mesh's that is not reported, %: a board may be a few voxels thick.
const MAX_VOLUME_DIFFERENCE: f64 = 2.0;

/// What is known of a stem's inside. Lengths are in m along the centreline or in the world, as their
/// names say; every name ends with its unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AnatomyReport {
    /// `greenstick-anatomy`.
    pub schema: Cow<'static, str>,
    /// Version of the schema, which rises when a name changes or is removed.
    pub version: u32,
    /// Where it comes from.
    pub provenance: Provenance,
    /// `round` or `board`.
    pub kind: Cow<'static, str>,
    /// Species, where one was named.
    pub species: Option<String>,
    /// Length of the centreline, m.
    pub length_m: f64,
    /// Radius of the circle of the same area as the section at the location, m.
    pub radius_m: f64,
    /// Volume of the stem's mesh, m³; `None` where it is not closed.
    pub mesh_volume_m3: Option<f64>,
    /// Volume of limbs of that mesh that are not the stem's and were left out, m³.
    #[serde(default)]
    pub left_out_volume_m3: f64,
    /// Volume of all voxels that are wood, m³; `None` where none were made.
    pub voxel_volume_m3: Option<f64>,
    /// Number of rings; by erosion that of the section with most.
    pub rings: u16,
    /// The one of them, counted from 1, that is no year but wood whose rings were not measured, below the bark.
    #[serde(default)]
    pub unmeasured_ring: Option<u16>,
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
    /// The tissues that the numbers of zones stand for.
    pub zones: Vec<String>,
    /// Points of the centreline in the world, m.
    pub centreline_m: Vec<[f64; 3]>,
    /// Breast height, volumes and logs.
    pub measures: MensurationReport,
    /// What its wood weighs; `None` where no species was named or the tables have no density.
    pub mass: Option<MassReport>,
    /// Limbs that were left out, the largest first.
    pub limbs: Vec<LimbReport>,
    /// Finite elements, where they were made.
    pub elements: Option<ElementsReport>,
    /// Voxelised segments.
    pub segments: Vec<SegmentReport>,
    /// The section of every layer.
    pub sections: Vec<SectionReport>,
    /// What was assumed, repaired or could not be done, one sentence each.
    pub notes: Vec<String>,
}

/// The finite elements of a stem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElementsReport {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of hexahedra.
    pub hexahedra: usize,
    /// Sum of their volumes, m³.
    pub volume_m3: f64,
    /// Volume of the stem's sections over the same length, m³.
    pub sections_volume_m3: f64,
    /// Sum of the volumes of those that are wood, m³.
    pub wood_volume_m3: f64,
}

impl ElementsReport {
    /// Returns the report on the elements of a stem beside its measures.
    pub fn new(stem: &StemElements, anatomy: &Anatomy, measures: &StemMeasures) -> Self {
        let (low, high) = anatomy.sections().whole;
        ElementsReport {
            nodes: stem.nodes.len(),
            hexahedra: stem.elements.len(),
            volume_m3: stem.volume(|_| true),
            sections_volume_m3: measures.volume_between(low, high),
            wood_volume_m3: stem.volume(|e| e.tissue <= Zone::Sapwood),
        }
    }
}

/// A section.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    /// Part of the girth that was bridged across holes of the mesh, 0 to 1.
    pub girth_guessed: f64,
    /// Root mean square distance by which the outline was smoothed, m.
    #[serde(default)]
    pub smoothing_residual_m: f64,
    /// Its rings, from the pith outwards.
    pub rings: RingRows,
}

/// Rings of a section, column by column.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RingRows {
    /// Mean distance of the ring's outer contour from the pith, m; of an eroded ring the radius of the circle of equal area.
    pub radius_m: Vec<f64>,
    /// Mean width, m.
    pub width_m: Vec<f64>,
    /// Area within the section, m².
    pub area_m2: Vec<f64>,
    /// Number of the tissue.
    pub zone: Vec<u8>,
}

/// What the report of a stem's inside is made from.
#[derive(Debug, Clone)]
pub struct AnatomyFindings<'a> {
    /// Where the input comes from.
    pub provenance: Provenance,
    /// Species, where one was named.
    pub species: Option<String>,
    /// Where rings come from.
    pub ring_method: RingMethod,
    /// The mesh that the stem was found in, in world metres.
    pub mesh: &'a Mesh,
    /// The stem.
    pub found: &'a FoundStem,
    /// Its sections and rings.
    pub anatomy: &'a Anatomy<'a>,
    /// Its particles.
    pub layers: &'a ParticleLayers,
    /// What was measured along it.
    pub measures: MensurationReport,
    /// What its wood weighs.
    pub mass: Option<MassReport>,
    /// Its finite elements, where they were made.
    pub elements: Option<ElementsReport>,
    /// What of its shell is not the stem's.
    pub left_out: Option<LeftOut>,
    /// Its segments, where they were voxelised.
    pub segments: Vec<SegmentReport>,
    /// What was assumed, repaired or could not be done, one sentence each.
    pub notes: Vec<String>,
}

impl AnatomyFindings<'_> {
    /// Returns the report.
    pub fn report(self) -> AnatomyReport {
        let stem = &self.found.stem;
        let axis = stem.grain.axis();
        let check = CheckOptions {
            self_intersections: false,
        };
        // The mesh may be inside out.
        let mesh_volume = self.shell().check_with(check).volume_m3.map(f64::abs);
        let voxel_volume =
            (!self.segments.is_empty()).then(|| self.segments.iter().map(|s| s.volume_m3).sum());
        let spread = self.layers.bundle_spread();
        let mut notes = self.notes.clone();
        notes.extend(self.note_on_holes());
        notes.extend(self.note_on_ends());
        notes.extend(self.note_on_smoothing());
        let left_out = self.left_out.as_ref();
        let left_out_volume = left_out.map_or(0.0, |l| l.volume_m3);
        notes.extend(left_out.map(ToString::to_string));
        let limbs = left_out.map_or(&[][..], |l| &l.limbs);
        let stem_volume = mesh_volume.map(|v| v - left_out_volume);
        notes.extend(self.note_on_coarseness(stem_volume, voxel_volume));
        AnatomyReport {
            schema: "greenstick-anatomy".into(),
            version: 1,
            provenance: self.provenance,
            kind: stem.kind.word().into(),
            species: self.species,
            length_m: axis.length(),
            radius_m: stem.radius,
            mesh_volume_m3: mesh_volume,
            left_out_volume_m3: left_out_volume,
            voxel_volume_m3: voxel_volume,
            rings: self.anatomy.ring_count(),
            unmeasured_ring: self.anatomy.rings().unfinished().map(|k| k as u16 + 1),
            rings_by: self.ring_method.to_string(),
            sectors: self.layers.layout.sectors.clone(),
            layers: self.layers.layers.len(),
            layer_distance_m: self.layers.spacing,
            particles: self.layers.particles().count(),
            equation_1: self.layers.equation_1(),
            bundle_area_m2: spread.range,
            bundle_spread: [spread.mean_deviation, spread.max_deviation],
            zones: Zone::ALL.iter().map(ToString::to_string).collect(),
            centreline_m: axis.points().iter().map(|p| p.to_array()).collect(),
            sections: self
                .layers
                .layers
                .iter()
                .map(|layer| SectionReport::new(&layer.section))
                .collect(),
            measures: self.measures,
            mass: self.mass,
            limbs: limbs.iter().map(LimbReport::from).collect(),
            elements: self.elements,
            segments: self.segments,
            notes,
        }
    }

    /// The stem's own triangles.
    fn shell(&self) -> Mesh {
        let triangles = self.found.shell.iter();
        Mesh {
            positions: self.mesh.positions.clone(),
            triangles: triangles
                .filter_map(|&t| self.mesh.triangles.get(t as usize))
                .copied()
                .collect(),
            ..Mesh::default()
        }
    }

    fn note_on_holes(&self) -> Option<String> {
        let holes: usize = self.segments.iter().map(|s| s.sections_with_holes).sum();
        let most = self.segments.iter().map(|s| s.girth_guessed);
        (holes > 0).then(|| {
            format!(
                "{holes} of {} sections were closed across holes of the mesh, {:.1} % of the girth at most",
                self.segments.len() * self.anatomy.sections().grid.count,
                100.0 * most.fold(0.0, f64::max)
            )
        })
    }

    fn note_on_ends(&self) -> Option<String> {
        let (low, high) = self.anatomy.sections().whole;
        (low > 0.0 || high < self.anatomy.sections().length()).then(|| {
            format!("particles lie between {low:.3} and {high:.3} m, where sections are whole")
        })
    }

    fn note_on_smoothing(&self) -> Option<String> {
        let residuals = self
            .layers
            .layers
            .iter()
            .map(|l| l.section.smoothing_residual);
        let count = residuals.clone().filter(|r| *r > 0.0).count();
        let (sum, most) = residuals.fold((0.0, 0.0_f64), |(sum, most), r| (sum + r, most.max(r)));
        (count > 0).then(|| {
            format!(
                "the outlines of {count} of {} sections were smoothed, by {:.2} mm on average and {:.2} mm at most (root mean square)",
                self.layers.layers.len(),
                1e3 * sum / count as f64,
                1e3 * most
            )
        })
    }

    fn note_on_coarseness(&self, stem: Option<f64>, voxels: Option<f64>) -> Option<String> {
        let difference = 100.0 * (voxels? / stem? - 1.0);
        (difference.abs() > MAX_VOLUME_DIFFERENCE).then(|| {
            let pixel = 1e3 * self.anatomy.sections().grid.pixel;
            if self.left_out.is_some() {
                // Where a limb ends and the stem begins is a matter of some per cent.
                return format!(
                    "the voxels' volume is {difference:+.1} % off what remains of the mesh's without the limbs left out; \
                     voxels measure {pixel:.2} mm"
                );
            }
            format!(
                "voxels of {pixel:.2} mm are coarse for this stem: their volume is {difference:+.1} % off the mesh's; a higher \
                 resolution brings it nearer"
            )
        })
    }
}

impl SectionReport {
    fn new(section: &SectionMeasures) -> Self {
        let rings = &section.rings;
        SectionReport {
            length_m: section.length,
            centre_m: section.frame.origin.to_array(),
            pith_m: section.pith.to_array(),
            direction: section.frame.tangent.to_array(),
            x: section.frame.x.to_array(),
            area_m2: section.area,
            girth_m: section.girth,
            girth_guessed: section.bridged,
            smoothing_residual_m: section.smoothing_residual,
            rings: RingRows {
                radius_m: rings.radii.clone(),
                width_m: rings.widths.clone(),
                area_m2: rings.areas.clone(),
                zone: rings.tissues.iter().map(|tissue| tissue.code()).collect(),
            },
        }
    }
}

impl AnatomyReport {
    /// Mean radii of the rings as shares of the section's, from the pith outwards, in the middle one of its sections: what
    /// another stem takes of them. They end where wood begins whose rings were not measured. `None` where there are none.
    pub fn ring_shares(&self) -> Option<Vec<f64>> {
        let radii = &self.sections.get(self.sections.len() / 2)?.rings.radius_m;
        let outer = radii.last().copied().filter(|&r| r > 0.0)?;
        let measured = self.unmeasured_ring.map_or(radii.len(), |ring| {
            usize::from(ring.saturating_sub(1)).min(radii.len())
        });
        let mut shares: Vec<f64> = Vec::with_capacity(measured);
        for share in radii[..measured].iter().map(|r| r / outer) {
            // An erosion may leave a ring out of a section.
            if share > shares.last().copied().unwrap_or(0.0) {
                shares.push(share);
            }
        }
        Some(shares)
    }

    /// Adds an offset (m) to all coordinates.
    pub fn translate(&mut self, offset: DVec3) {
        let sections = self.sections.iter_mut();
        let places = sections.flat_map(|s| [&mut s.centre_m, &mut s.pith_m]);
        let mouths = self.limbs.iter_mut().map(|l| &mut l.mouth_m);
        for place in places.chain(&mut self.centreline_m).chain(mouths) {
            *place = (DVec3::from(*place) + offset).to_array();
        }
    }

    /// Returns the report as JSON.
    ///
    /// # Errors
    /// [`serde_json::Error`] where it cannot be converted.
    pub fn to_json(&self) -> Result<Vec<u8>, serde_json::Error> {
        serde_json::to_vec(self)
    }
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
        write!(f, "{}", self.measures)?;
        if let Some(mass) = &self.mass {
            writeln!(
                f,
                "mass      {:.3} kg of wood at {:.0} % moisture, {:.3} kg oven-dry; {:.0} kg/m³",
                mass.mass_kg, mass.moisture_percent, mass.dry_mass_kg, mass.density_kg_m3
            )?;
        }
        if let Some(e) = &self.elements {
            writeln!(
                f,
                "elements  {} hexahedra, {:.6} m³, {:+.3} % of the sections'",
                e.hexahedra,
                e.volume_m3,
                100.0 * (e.volume_m3 / e.sections_volume_m3 - 1.0)
            )?;
        }
        for note in &self.notes {
            writeln!(f, "note      {note}")?;
        }
        Ok(())
    }
}
