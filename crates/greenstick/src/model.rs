//! A break with given parameters: surface, cut, and both pieces as meshes.

use crate::kept::Laid;
use crate::{Error, Prepared};
use glam::{DVec2, DVec3};
use greenstick_fracture::cut::{Cut, CutError, cut_again};
use greenstick_fracture::heights::{self, Heights, Setting};
use greenstick_fracture::layout::{Bundles, LayoutOptions};
use greenstick_fracture::parameters::{BreakParameters, Surface};
use greenstick_geometry::Mesh;
use greenstick_skin::face::{Face, face};
use greenstick_skin::pieces::{self, InnerWood, Patch, Source};
use greenstick_skin::wind::{Wound, unwind};
use greenstick_wood::stem::StemKind;
use greenstick_wood::tissue::Proportions;
use std::sync::Arc;

/// A broken stem.
#[derive(Debug, Clone)]
pub struct Model {
    /// The lower piece, in the coordinates of the node that was cut.
    pub lower: Mesh,
    /// The upper piece.
    pub upper: Mesh,
    /// Fibre bundles of the face.
    pub bundles: Arc<Bundles>,
    /// The surface, and what was done to fit it in.
    pub heights: Heights,
    /// Middle and side (m) of the square of the section that the inner wood's texture covers.
    pub square: (DVec2, f64),
    /// Slivers that hung in the air on one side and were given to the other.
    pub chips: usize,
    /// What was done to keep a face of winding grain from crossing itself.
    pub wound: Option<Wound>,
}

/// A broken stem as it is drawn: what the break changes, with the rest of the skin by reference.
///
/// Each piece consists of the skin that the break does not come near ([`Prepared::skin_below`] and
/// [`Prepared::skin_above`]), the skin about the break, whole triangles and parts of cut ones ([`Drawn::patch`]), and
/// the broken face, which the upper piece has turned over.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// The broken face.
    pub face: Face,
    /// The skin about the break.
    pub patch: Patch,
    /// Fibre bundles of the face.
    pub bundles: Arc<Bundles>,
    /// The surface, and what was done to fit it in.
    pub heights: Heights,
    /// Middle and side (m) of the square of the section that the inner wood's texture covers.
    pub square: (DVec2, f64),
    cut: Cut,
    proportions: Proportions,
    material: u32,
    smooth: bool,
    chips: usize,
    wound: Option<Wound>,
}

impl Prepared {
    /// Breaks the stem and makes meshes of both pieces. `relief` scales the torn relief (1 for none); `material` is that
    /// of the wood inside.
    ///
    /// # Errors
    /// [`Error::Cut`] where the mesh is open or not a manifold at the break.
    pub fn model(&self, p: &BreakParameters, relief: f64, material: u32) -> Result<Model, Error> {
        let broken = self.drawn(p, relief, material)?;
        Ok(Model {
            lower: self.piece(&broken, false),
            upper: self.piece(&broken, true),
            bundles: broken.bundles,
            heights: broken.heights,
            square: broken.square,
            chips: broken.chips,
            wound: broken.wound,
        })
    }

    /// Breaks the stem as [`Prepared::model`] does, up to what is drawn: no more is made anew than the break changes.
    ///
    /// # Errors
    /// [`Error::Cut`] where the mesh is open or not a manifold at the break.
    pub fn drawn(&self, p: &BreakParameters, relief: f64, material: u32) -> Result<Drawn, Error> {
        let smooth = p.surface == Surface::Smooth;
        let (laid, heights) = self.heights(p, relief);
        let mut cut = cut_again(
            &self.solid(),
            &self.kept.skin,
            &laid.ground,
            &heights.surface,
        )
        .map_err(|error| self.locate(error))?;
        let chips = cut.absorb_chips_again(&self.solid(), &self.kept.skin);
        cut.part_at(&self.grain, &self.kept.levels);
        let wound = self.layers.has_spiral_grain().then(|| {
            let transform = self.transform();
            let to_grain = |p| self.layers.to_grain(transform.transform_point3(p));
            unwind(&self.source(), &mut cut, &self.kept.skin, &to_grain)
        });
        let mut broken = Drawn {
            face: Face::default(),
            patch: Patch::default(),
            bundles: laid.bundles.clone(),
            heights,
            square: self.kept.square,
            cut,
            proportions: p.proportions(),
            material,
            smooth,
            chips,
            wound,
        };
        let source = self.source();
        let (face, patch) = self.with_inner(&broken, |inner| {
            let face = face(&source, &broken.cut, inner);
            let patch = pieces::patch(&source, &broken.cut, &self.kept.skin, &face.places);
            (face, patch)
        });
        (broken.face, broken.patch) = (face, patch);
        Ok(broken)
    }

    /// The layout of the section and the heights of its break.
    pub(crate) fn heights(&self, p: &BreakParameters, relief: f64) -> (Arc<Laid>, Heights) {
        let smooth = p.surface == Surface::Smooth;
        let laid = self.kept.laid(self, &self.layout_options(p), smooth);
        let setting = self.setting(p, relief);
        let heights = if smooth {
            heights::smooth(&laid.bundles, p, &setting)
        } else {
            heights::fibrous(&laid.bundles, p, &setting)
        };
        (laid, heights)
    }

    /// Height between the 5th and the 95th hundredth of the face that [`Prepared::drawn`] makes with no more relief than
    /// the parameters say, before limiting, m.
    pub fn relief_range(&self, p: &BreakParameters) -> f64 {
        let smooth = p.surface == Surface::Smooth;
        let laid = self.kept.laid(self, &self.layout_options(p), smooth);
        heights::relief_range(&laid.bundles, p, &self.setting(p, 1.0))
    }

    fn setting(&self, p: &BreakParameters, relief: f64) -> Setting {
        let stem = &self.found.stem;
        Setting {
            radius: stem.radius,
            place: stem.location,
            usable: stem.usable,
            pith: stem.rings.pith(),
            wedge: self.wedge(p),
            relief,
        }
    }

    /// One piece of a broken stem as a mesh of its own, in the coordinates of the node that was cut.
    pub fn piece(&self, broken: &Drawn, upper: bool) -> Mesh {
        self.with_inner(broken, |inner| {
            pieces::piece(
                &self.source(),
                &broken.cut,
                &broken.patch,
                &broken.face,
                inner,
                upper,
            )
        })
    }

    /// Triangles of the cut node's mesh that lie wholly below all that changes with the break.
    pub fn skin_below(&self, broken: &Drawn) -> &[[u32; 3]] {
        &self.kept.triangles[..broken.cut.sides.below]
    }

    /// Triangles of the cut node's mesh that lie wholly above all that changes with the break.
    pub fn skin_above(&self, broken: &Drawn) -> &[[u32; 3]] {
        &self.kept.triangles[broken.cut.sides.above..]
    }

    fn layout_options(&self, p: &BreakParameters) -> LayoutOptions {
        LayoutOptions {
            rings: p.rings as usize,
            sectors: p.sectors as usize,
            reach: self.extent.reach,
            radius: self.extent.radius,
            arc: self.extent.arc,
            bark: (self.found.stem.kind != StemKind::Board).then_some(self.extent.bark),
            seed: p.seed,
        }
    }

    pub(crate) fn source(&self) -> Source<'_> {
        Source {
            mesh: &self.scene.nodes[self.found.node].mesh,
            points: &self.points,
            vertices: &self.kept.vertices,
            grain: &self.grain,
            chart: &self.kept.chart,
        }
    }

    fn with_inner<T>(&self, broken: &Drawn, then: impl FnOnce(&InnerWood) -> T) -> T {
        let zone = |rho: f64| broken.proportions.zone_at(rho, 0.0).code();
        then(&InnerWood {
            stem: &self.found.stem,
            bundles: &broken.bundles,
            zone: &zone,
            material: broken.material,
            square: broken.square,
            smooth: broken.smooth,
        })
    }

    pub(crate) fn locate(&self, error: CutError) -> Error {
        let at = match &error {
            CutError::OffLayout { at } | CutError::Outline { at, .. } | CutError::Face { at } => {
                *at
            }
            CutError::Misses | CutError::Joined { .. } => {
                DVec3::new(0.0, 0.0, self.found.stem.location)
            }
        };
        Error::Cut {
            error,
            at: self.layers.to_world(at),
        }
    }
}
