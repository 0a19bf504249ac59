//! A break with given parameters: surface, cut, and both pieces as meshes.

use crate::{Error, Prepared};
use glam::{DVec2, DVec3};
use greenstick_fracture::cut::{Cut, CutError, Solid, cut};
use greenstick_fracture::heights::{self, Heights, Setting};
use greenstick_fracture::layout::{self, Bundles, LayoutOptions};
use greenstick_fracture::parameters::{BreakParameters, Surface};
use greenstick_geometry::Mesh;
use greenstick_skin::pieces::{self, InnerWood, Source};
use greenstick_wood::stem::StemKind;

/// A broken stem.
#[derive(Debug, Clone)]
pub struct Model {
    /// The lower piece, in the coordinates of the node that was cut.
    pub lower: Mesh,
    /// The upper piece.
    pub upper: Mesh,
    /// Fibre bundles of the face.
    pub bundles: Bundles,
    /// The surface, and what was done to fit it in.
    pub heights: Heights,
    /// Middle and side (m) of the square of the section that the inner wood's texture covers.
    pub square: (DVec2, f64),
    /// Slivers that hung in the air on one side and were given to the other.
    pub chips: usize,
}

impl Prepared {
    /// Breaks the stem. `relief` scales the torn relief (1 for none); `material` is that of the wood inside.
    ///
    /// # Errors
    /// [`Error::Cut`] where the mesh is open or not a manifold at the break.
    pub fn model(&self, p: &BreakParameters, relief: f64, material: u32) -> Result<Model, Error> {
        let stem = &self.found.stem;
        let options = LayoutOptions {
            rings: p.rings as usize,
            sectors: p.sectors as usize,
            reach: self.extent.reach,
            radius: self.extent.radius,
            arc: self.extent.arc,
            bark: (stem.kind != StemKind::Board).then_some(self.extent.bark),
            seed: p.seed,
        };
        let setting = Setting {
            radius: stem.radius,
            place: stem.place,
            usable: stem.usable,
            relief,
        };
        let smooth = p.surface == Surface::Smooth;
        let (bundles, heights) = if smooth {
            let bundles = layout::smooth(&stem.rings, &options);
            let heights = heights::smooth(&bundles, p, &setting);
            (bundles, heights)
        } else {
            let bundles = layout::fibrous(&stem.rings, &options);
            let heights = heights::fibrous(&bundles, p, &setting);
            (bundles, heights)
        };
        let solid = Solid {
            triangles: &self.corners,
            points: &self.grain,
            shell: &self.found.shell,
            limb: &self.found.limb,
        };
        let level = self.level(heights.range, stem.radius / f64::from(p.rings));
        let mut cut = cut(&solid, &heights.surface, level).map_err(|error| self.locate(error))?;
        let chips = cut.absorb_chips(&solid);
        let node = &self.scene.nodes[self.found.node];
        let source = Source {
            mesh: &node.mesh,
            transform: &node.transform,
            points: &self.points,
            grain: &self.grain,
        };
        let square = self.square();
        let proportions = p.proportions();
        let zone = |rho: f64| proportions.zone_at(rho, 0.0).code();
        let inner = InnerWood {
            stem,
            bundles: &bundles,
            zone: &zone,
            material,
            square,
            smooth,
        };
        let (lower, upper) = self.pieces(&source, &cut, &inner);
        Ok(Model {
            lower,
            upper,
            bundles,
            heights,
            square,
            chips,
        })
    }

    pub(crate) fn pieces(&self, source: &Source, cut: &Cut, inner: &InnerWood) -> (Mesh, Mesh) {
        let positions = pieces::positions(source, cut, inner.stem);
        let cap = pieces::cap(source, cut, &positions, inner);
        let piece = |upper| pieces::piece(source, cut, &positions, &cap, inner, upper);
        (piece(false), piece(true))
    }

    /// Length (m) along the grain over which a line at the skin bends by no more than a fraction of a bundle's
    /// thickness (m), within the given range of heights (m from the place).
    pub(crate) fn level(&self, range: (f64, f64), thickness: f64) -> f64 {
        const SAG: f64 = 0.02;
        let stem = &self.found.stem;
        let at = |i: usize, s: f64| {
            let (sin, cos) = libm::sincos(i as f64 * std::f64::consts::FRAC_PI_2);
            stem.grain.to_world(DVec3::new(
                cos * stem.radius,
                sin * stem.radius,
                stem.place + s,
            ))
        };
        let mut level = range.1 - range.0;
        for _ in 0..8 {
            let steps = ((range.1 - range.0) / level).ceil() as usize;
            let sag = (0..steps * 4)
                .map(|n| {
                    let (i, s) = (n % 4, range.0 + level * (n / 4) as f64);
                    let chord = (at(i, s) + at(i, s + level)) / 2.0;
                    chord.distance(at(i, s + level / 2.0))
                })
                .fold(0.0, f64::max);
            if sag <= SAG * thickness {
                break;
            }
            level /= 2.0;
        }
        if level < range.1 - range.0 {
            level
        } else {
            f64::INFINITY
        }
    }

    /// The square of the section that holds the limb's skin.
    pub(crate) fn square(&self) -> (DVec2, f64) {
        let points = self
            .found
            .limb
            .iter()
            .flat_map(|&t| self.corners[t as usize])
            .map(|p| self.grain[p as usize]);
        let (low, high) = points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
            (low.min(p.truncate()), high.max(p.truncate()))
        });
        ((low + high) / 2.0, (high - low).max_element() * 1.02)
    }

    pub(crate) fn locate(&self, error: CutError) -> Error {
        let at = match &error {
            CutError::OffLayout { at } | CutError::Outline { at, .. } | CutError::Face { at } => {
                *at
            }
            CutError::Misses | CutError::Joined { .. } => {
                DVec3::new(0.0, 0.0, self.found.stem.place)
            }
        };
        Error::Cut {
            error,
            at: self.found.stem.grain.to_world(at),
        }
    }
}
