//! Sections along a stem as the window needs them: outlines, and what their rings are made of.

use glam::DVec2;
use greenstick::geometry::Context;
use greenstick::session::BrokenWood;
use greenstick::skin::prepared::PreparedStem;
use greenstick::wood::anatomy::{AnatomyError, StemSections, TransverseSection};
use greenstick::wood::rings::{RingField, StemAddress};
use greenstick::wood::tissue::Zone;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Sections of a book, beside the one at the break: a step is less than a hundredth of the stem.
const SECTIONS: usize = 120;
/// Voxels along a segment; sections do not depend on them.
const RESOLUTION: usize = 64;
/// Steps of the ring coordinate between which mean radii are linear in a ring field.
const LEVELS: usize = 64;

/// What makes the rings of a section.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RingShape {
    /// The pith in the section, m.
    pub pith: [f64; 2],
    /// The ring coordinate from which on the stem is eccentric; none where rings are arcs about the pith, as in a board.
    pub onset: Option<f64>,
    /// Radius of the outermost ring where rings are arcs, m.
    pub outer: f64,
}

/// A section across a stem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StemSection {
    /// Length along the axis, m.
    pub length: f64,
    /// Its origin and the directions of its x and y, in the world, m.
    pub frame: [[f64; 3]; 3],
    /// Closed outlines in x and y, m: the stem's own first.
    pub loops: Vec<Vec<[f64; 2]>>,
    /// Area, m².
    pub area: f64,
    /// What makes its rings.
    pub rings: RingShape,
}

/// The sections of a stem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SectionBook {
    /// The number of the break.
    pub number: usize,
    /// Sections, rising in length.
    pub sections: Vec<StemSection>,
    /// Which of them is that of the break.
    pub at_break: usize,
    /// Whether it is a board or a dowel, whose rings are arcs.
    pub sawn: bool,
    /// Ring coordinates of the outer edges of the rings; none where an erosion makes them.
    pub edges: Vec<f64>,
    /// The tissue of each ring.
    pub tissues: Vec<u8>,
    /// Mean radii of the ring coordinates 0 to 1 in equal steps, in the section of the break, m.
    pub mean_radii: Vec<f64>,
}

/// The rings of a section, ready to be asked.
#[derive(Debug, Clone, PartialEq)]
pub enum SectionRings {
    /// Around the pith.
    Field(Box<RingField>),
    /// Arcs about a pith, the outermost of a radius, m.
    Arcs(DVec2, f64),
}

impl SectionRings {
    /// The pith, m.
    pub fn pith(&self) -> DVec2 {
        match self {
            SectionRings::Field(field) => field.pith(),
            SectionRings::Arcs(pith, _) => *pith,
        }
    }

    /// The ring coordinate from which on the stem is eccentric; none where rings are arcs.
    pub fn onset(&self) -> Option<f64> {
        match self {
            SectionRings::Field(field) => field.eccentricity_onset(),
            SectionRings::Arcs(..) => None,
        }
    }

    /// Ring coordinate and angle (rad) of a point, m.
    pub fn address(&self, p: DVec2) -> (f64, f64) {
        match self {
            SectionRings::Field(field) => field.address(p),
            SectionRings::Arcs(pith, outer) => {
                let d = p - *pith;
                (d.length() / outer, d.y.atan2(d.x))
            }
        }
    }

    /// The point (m) of a ring coordinate and an angle (rad).
    pub fn point(&self, rho: f64, angle: f64) -> DVec2 {
        match self {
            SectionRings::Field(field) => field.point(rho, angle),
            SectionRings::Arcs(pith, outer) => *pith + DVec2::from_angle(angle) * (rho * outer),
        }
    }

    /// Mean radius of a ring coordinate, m.
    pub fn mean_radius(&self, rho: f64) -> f64 {
        match self {
            SectionRings::Field(field) => field.mean_radius(rho),
            SectionRings::Arcs(_, outer) => rho * outer,
        }
    }
}

/// Diameters of a section, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diameters {
    /// That of the circle of the same area.
    pub mean: f64,
    /// The least and the greatest distance of two parallel lines that hold the outline between them.
    pub range: [f64; 2],
}

impl StemSection {
    fn new(section: &TransverseSection) -> Self {
        let (field, frame) = (&section.field, &section.frame);
        let points = |l: &Vec<DVec2>| l.iter().map(|p| p.to_array()).collect();
        StemSection {
            length: section.length,
            frame: [frame.origin, frame.x, frame.y].map(|v| v.to_array()),
            loops: section.outline.loops.iter().map(points).collect(),
            area: section.outline.area,
            rings: RingShape {
                pith: field.pith().to_array(),
                onset: field.eccentricity_onset(),
                outer: field.outer_radius(0.0),
            },
        }
    }

    /// The points of its own outline, m.
    pub fn outline(&self) -> impl Iterator<Item = DVec2> + Clone {
        let own = self.loops.first().map(Vec::as_slice).unwrap_or_default();
        own.iter().map(|p| DVec2::from_array(*p))
    }

    /// Its rings.
    pub fn section_rings(&self) -> SectionRings {
        self.rings_of(&self.rings)
    }

    /// The rings that it would have of another shape.
    pub fn rings_of(&self, shape: &RingShape) -> SectionRings {
        let pith = DVec2::from_array(shape.pith);
        let outline: Vec<DVec2> = self.outline().collect();
        let field = shape
            .onset
            .and_then(|onset| RingField::with_eccentricity_onset(&outline, pith, Some(onset)).ok());
        match field {
            Some(field) => SectionRings::Field(Box::new(field)),
            None => SectionRings::Arcs(pith, shape.outer.max(1e-9)),
        }
    }

    /// A point of the section in the world, m.
    pub fn world(&self, p: DVec2) -> glam::DVec3 {
        let [origin, x, y] = self.frame.map(glam::DVec3::from_array);
        origin + x * p.x + y * p.y
    }

    /// Its diameters, in steps of two degrees.
    pub fn diameters(&self) -> Diameters {
        let (mut least, mut greatest) = (f64::INFINITY, 0.0f64);
        for k in 0..90 {
            let direction = DVec2::from_angle(PI * f64::from(k) / 90.0);
            let along = self.outline().map(|p| p.dot(direction));
            let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
                (a.min(x), b.max(x))
            });
            (least, greatest) = (least.min(high - low), greatest.max(high - low));
        }
        Diameters {
            mean: 2.0 * (self.area / PI).sqrt(),
            range: [least, greatest],
        }
    }

    /// Whether a point lies in the wood: inside an odd number of its outlines.
    pub fn contains(&self, p: DVec2) -> bool {
        let mut inside = false;
        for points in &self.loops {
            let mut before = points.last().copied().unwrap_or_default();
            for &at in points {
                let crosses = (at[1] > p.y) != (before[1] > p.y);
                let x = || at[0] + (p.y - at[1]) / (before[1] - at[1]) * (before[0] - at[0]);
                inside ^= crosses && p.x < x();
                before = at;
            }
        }
        inside
    }
}

/// The sections of a stem, at equal distances where they are whole and at the break.
///
/// # Errors
/// [`AnatomyError`] where none can be made.
pub fn sections_of(
    stem: &PreparedStem,
    context: &Context,
) -> Result<Vec<StemSection>, AnatomyError> {
    let found = &stem.found;
    let mesh = stem.scene.world_meshes().swap_remove(found.node);
    let sections = StemSections::new(found, &mesh, RESOLUTION, context)?;
    let (low, high) = sections.whole;
    let step = |k: usize| low + (high - low) * (k as f64 + 0.5) / SECTIONS as f64;
    let mut lengths: Vec<f64> = (0..SECTIONS).map(step).collect();
    lengths.push(found.stem.location);
    lengths.sort_by(f64::total_cmp);
    let made = sections.sections_at(&lengths, context)?;
    if made.is_empty() {
        return Err(AnatomyError::NoSections(lengths.len()));
    }
    Ok(made.iter().map(StemSection::new).collect())
}

impl SectionBook {
    /// The book of sections of the stem of a break.
    pub fn new(sections: Vec<StemSection>, number: usize, wood: &BrokenWood) -> Self {
        let (stem, rings) = (&wood.stem, &wood.appearance.rings);
        let off = |s: &StemSection| (s.length - stem.location).abs();
        let at_break = (0..sections.len())
            .min_by(|a, b| off(&sections[*a]).total_cmp(&off(&sections[*b])))
            .unwrap_or(0);
        let edges = rings.edges().to_vec();
        let mut inner = 0.0;
        let tissue = |edge: &f64| {
            let rho = 0.5 * (inner + edge);
            inner = *edge;
            let address = StemAddress {
                rho,
                angle: 0.0,
                across: DVec2::X * stem.rings.mean_radius(rho),
                along: stem.location,
            };
            rings
                .ring_at(&address)
                .map_or(Zone::Sapwood, |r| r.tissue)
                .code()
        };
        let tissues = edges.iter().map(tissue).collect();
        let radius = |k| stem.rings.mean_radius(k as f64 / LEVELS as f64);
        SectionBook {
            number,
            at_break,
            sawn: stem.kind.is_sawn(),
            edges,
            tissues,
            mean_radii: (0..=LEVELS).map(radius).collect(),
            sections,
        }
    }

    /// Mean radius of a ring coordinate in the section of the break, m: that of its ring field.
    pub fn mean_radius(&self, rho: f64) -> f64 {
        let last = self.mean_radii.len().saturating_sub(1);
        let level = rho.clamp(0.0, 1.0) * last as f64;
        let k = (level as usize).min(last.saturating_sub(1));
        let (a, b) = (self.mean_radii[k], self.mean_radii[(k + 1).min(last)]);
        a + (b - a) * (level - k as f64)
    }
}
