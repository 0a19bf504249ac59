//! Frayed breaks: splinters come loose as pieces of their own, and thorns bend.

mod bend;
mod levels;

pub use bend::{Bend, BendReport};
pub(crate) use levels::push_vertex_between;

use crate::broken::{BrokenFace, Cutter, FaceLayout, InnerWood};
use crate::error::BreakError;
use crate::prepared::PreparedStem;
use glam::{DAffine3, DQuat, DVec2, DVec3};
use greenstick_fracture::cut::{Cut, CutWorkspace};
use greenstick_fracture::heights::Heights;
use greenstick_fracture::splinters::{Loosened, SplinterOptions, loosen, splinter_solid};
use greenstick_fracture::surface::FractureSurface;
use greenstick_geometry::{Context, Mesh};
use greenstick_wood::noise;
use std::f64::consts::TAU;

/// Seeds of independent random numbers.
mod purpose {
    pub const CHOICE: u64 = 0xf4a1;
    pub const BEND: u64 = 0xf4a2;
    pub const THROW: u64 = 0xf4a3;
}

/// Greatest number of splinters that come loose.
const MAX_SPLINTERS: f64 = 12.0;
/// Least length of a splinter, radii.
const MIN_SPLINTER_LENGTH: f64 = 0.3;

/// A break that is to be frayed.
#[derive(Clone, Copy)]
pub struct FrayedBreak<'a> {
    /// The stem.
    pub stem: &'a PreparedStem,
    /// Its layout.
    pub layout: &'a FaceLayout,
    /// The heights of the face.
    pub heights: &'a Heights,
    /// What the face shows.
    pub inner: InnerWood<'a>,
    /// The pieces as they broke, the lower one first.
    pub pieces: [&'a Mesh; 2],
    /// How much it is frayed, 0 (not at all) to 1.
    pub amount: f64,
    /// How far the pieces are moved apart, m.
    pub separation: f64,
    /// Seed of the break.
    pub seed: u64,
    /// Asked whether to stop.
    pub context: &'a Context,
}

/// A frayed break. Meshes are in the coordinates of the node that was cut.
#[derive(Debug, Clone)]
pub struct Frayed {
    /// The lower and the upper piece without their splinters, their thorns bent.
    pub pieces: [Mesh; 2],
    /// How each of them was bent.
    pub bends: [BendReport; 2],
    /// The splinters where they stood in the wood, each with its motion in the world.
    pub splinters: Vec<(Mesh, DAffine3)>,
}

/// Pieces and splinters before anything moves, in the coordinates of the node that was cut.
#[derive(Debug, Clone)]
pub struct LoosenedPieces {
    /// The lower and the upper piece without the splinters.
    pub pieces: [Mesh; 2],
    /// The splinters.
    pub splinters: Vec<Splinter>,
}

/// A splinter before it falls.
#[derive(Debug, Clone)]
pub struct Splinter {
    /// Its mesh.
    pub mesh: Mesh,
    /// Its cell in the layout.
    pub cell: u32,
}

impl FrayedBreak<'_> {
    /// Frays the break.
    ///
    /// # Errors
    /// [`BreakError::Cut`] as for the break itself.
    pub fn fray(&self) -> Result<Frayed, BreakError> {
        let LoosenedPieces { pieces, splinters } = self.loosened()?;
        let bend = |upper: bool| {
            let mesh = &pieces[usize::from(upper)];
            let (bent, mut report) = self.bend(upper).apply(mesh, self.context)?;
            self.context.check()?;
            report.volume_change = bent.volume() / mesh.volume() - 1.0;
            Ok::<_, BreakError>((bent, report))
        };
        let ((lower, of_lower), (upper, of_upper)) = (bend(false)?, bend(true)?);
        // Around the stem in the order in which they stood, so that they do not fall on each other.
        let bundles = &self.layout.bundles.bundles;
        let angle = |s: &Splinter| bundles[s.cell as usize].phi.rem_euclid(TAU);
        let angles: Vec<f64> = splinters.iter().map(angle).collect();
        let thrown = splinters.into_iter().enumerate().map(|(i, splinter)| {
            let before = |&(j, a): &(usize, &f64)| *a < angles[i] || (*a == angles[i] && j < i);
            let rank = angles.iter().enumerate().filter(before).count();
            let side = (rank as f64 + 0.5) / angles.len() as f64;
            let motion = self.throw(&splinter, side);
            (splinter.mesh, motion)
        });
        Ok(Frayed {
            splinters: thrown.collect(),
            pieces: [lower, upper],
            bends: [of_lower, of_upper],
        })
    }

    fn cut_along(
        &self,
        surface: &FractureSurface,
        workspace: &mut CutWorkspace,
    ) -> Result<Cut, BreakError> {
        let cutter = self.cutter();
        cutter.cut(surface, workspace).map(|(cut, _)| cut)
    }

    fn cutter(&self) -> Cutter<'_> {
        Cutter {
            stem: self.stem,
            skin: &self.stem.skin,
            facet_grid: &self.layout.facet_grid,
            absorb_chips: true,
            context: self.context,
        }
    }

    /// The bend of the lower or the upper piece.
    pub fn bend(&self, upper: bool) -> Bend<'_> {
        Bend::new(
            self.stem,
            &self.heights.surface,
            self.amount,
            self.seed ^ purpose::BEND,
            upper,
        )
    }

    /// Takes splinters off both pieces, without moving anything.
    ///
    /// # Errors
    /// As [`FrayedBreak::fray`].
    pub fn loosened(&self) -> Result<LoosenedPieces, BreakError> {
        let surface = &self.heights.surface;
        let mut workspace = CutWorkspace::default();
        let whole = self.cut_along(surface, &mut workspace)?;
        self.context.check()?;
        let loose = self.loose_cells(&whole);
        let options = SplinterOptions {
            max_count: (self.amount.clamp(0.0, 1.0) * MAX_SPLINTERS).ceil() as usize,
            min_length: MIN_SPLINTER_LENGTH * self.stem.found.stem.radius,
            seed: self.seed ^ purpose::CHOICE,
        };
        let bundles = &self.layout.bundles;
        let loosened = loosen(surface, bundles, &|c| loose[c as usize], &options);
        let Loosened {
            lower,
            upper,
            splinters,
        } = &loosened;
        let source = self.stem.source();
        self.context.check()?;
        let mut piece = |own: &FractureSurface, side: bool| {
            let as_it_is = self.pieces[usize::from(side)];
            if splinters.iter().all(|s| s.upper != side) {
                return Ok(as_it_is.clone());
            }
            let face = self
                .cutter()
                .break_along(own, &self.inner, &mut workspace)?;
            Ok::<_, BreakError>(face.piece(&source, &self.inner, side))
        };
        let pieces = [piece(lower, false)?, piece(upper, true)?];
        let splinters = splinters.iter().map(|s| {
            let faces = if s.upper {
                [surface, upper]
            } else {
                [lower, surface]
            };
            let skin = &self.stem.skin;
            let mut cut = splinter_solid(&self.stem.solid(), skin, &whole, faces, s.cell);
            self.stem.split_at_levels(&mut cut);
            let face = BrokenFace::within_the_wood(&source, cut, &self.inner);
            Splinter {
                mesh: face.piece(&source, &self.inner, false),
                cell: s.cell,
            }
        });
        Ok(LoosenedPieces {
            splinters: splinters.collect(),
            pieces,
        })
    }

    /// For each cell of the layout whether its bundle can come loose: it lies away from the skin and is part of the
    /// broken face.
    fn loose_cells(&self, cut: &Cut) -> Vec<bool> {
        let mut loose = vec![false; self.layout.bundles.bundles.len()];
        for face in cut.faces.iter().filter(|f| f.top) {
            loose[face.cell as usize] = true;
        }
        let cells = &self.heights.surface.layout.cells;
        for (f, &cell) in cells.iter().enumerate() {
            if self.layout.facet_grid.is_near(f as u32) {
                loose[cell as usize] = false;
            }
        }
        loose
    }
}

/// Distance from the section's middle at which thrown splinters begin, as part of the section's reach.
const THROW_CLEARANCE: f64 = 1.12;
/// How much farther they may lie, radii.
const THROW_SPREAD: f64 = 0.8;
/// Length of skin beyond the break that they keep clear of, radii.
const SKIN_BEYOND: f64 = 4.0;

impl FrayedBreak<'_> {
    /// How far the skin about the break reaches from `middle` in a direction, m.
    fn skin_reach(&self, middle: DVec2, direction: DVec2) -> f64 {
        let stem = &self.stem.found.stem;
        let (low, high) = self.heights.range;
        let near = (low - SKIN_BEYOND * stem.radius)..(high + SKIN_BEYOND * stem.radius);
        let points = self.stem.grain.iter();
        points
            .filter(|p| near.contains(&(p.z - stem.location)))
            .map(|p| (p.truncate() - middle).dot(direction))
            .fold(stem.radius, f64::max)
    }

    /// Where a splinter falls: out of the break, on a side of the stem (0 to 1 around it), turned over in the air.
    fn throw(&self, splinter: &Splinter, side: f64) -> DAffine3 {
        let stem = &self.stem.found.stem;
        let frame = stem.grain.axis().frame(stem.location);
        let seed = self.seed ^ purpose::THROW;
        let random = |i: i64| noise::unit(seed, i64::from(splinter.cell), i, 0);
        // A picture shows the upper piece set aside along x: no splinter falls there.
        let open = TAU / 6.0;
        let angle = open + (TAU - 2.0 * open) * (side + 0.04 * (random(0) - 0.5)).clamp(0.0, 1.0);
        let across = |angle: f64| {
            let (sin, cos) = libm::sincos(angle);
            frame.x * cos + frame.y * sin
        };
        let (out, beside) = (across(angle), across(angle + TAU / 4.0));
        // Pointing up and outwards, between standing and lying, and rolled about itself.
        let lean = DQuat::from_axis_angle(beside, 0.35 + 0.9 * random(1));
        let swing = DQuat::from_axis_angle(out, 1.2 * (random(2) - 0.5));
        let roll = DQuat::from_axis_angle(frame.tangent, TAU * random(3));
        let turn = swing * lean * roll;
        let transform = self.stem.transform();
        let positions: Vec<DVec3> = (splinter.mesh.positions.iter())
            .map(|&p| transform.transform_point3(p))
            .collect();
        let (low, high) = positions
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| {
                (low.min(p), high.max(p))
            });
        let centre = (low + high) / 2.0;
        // So far out that all of it is clear of the stem; less far where the gap has room for it.
        let inmost = positions
            .iter()
            .map(|&p| (turn * (p - centre)).dot(out))
            .fold(f64::INFINITY, f64::min);
        let middle = self.stem.square.middle;
        let (sin, cos) = libm::sincos(angle);
        let reach = self.skin_reach(middle, DVec2::new(cos, sin));
        let (bottom, top) = self.heights.range;
        let gap = (self.separation - (top - bottom)) / (2.0 * stem.radius);
        let aside = THROW_CLEARANCE * reach * (1.0 - 0.6 * gap.clamp(0.0, 1.0))
            + THROW_SPREAD * stem.radius * random(4)
            - inmost;
        let along =
            (bottom + top + self.separation) / 2.0 + (top - bottom) * 0.6 * (random(5) - 0.5);
        let to = frame.origin
            + frame.x * middle.x
            + frame.y * middle.y
            + out * aside
            + frame.tangent * along;
        DAffine3::from_translation(to)
            * DAffine3::from_quat(turn)
            * DAffine3::from_translation(-centre)
    }
}
