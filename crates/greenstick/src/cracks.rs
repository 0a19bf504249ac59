//! Cracks of drying wood at a break or at an end of the stem, as grooves in closed meshes.

use crate::model::Model;
use crate::{Error, Prepared};
use glam::DVec2;
use greenstick_fracture::cracks::{
    CrackPlan, Direction, EndFace, Grooved, PlannedCrack, Setting, Way, end_grooves, grooves,
};
use greenstick_fracture::cut::{Ground, Skin, cut_again};
use greenstick_fracture::layout::{self, Bundles, LayoutOptions};
use greenstick_fracture::parameters::{BreakParameters, Surface as SurfaceKind};
use greenstick_geometry::Mesh;
use greenstick_skin::face::face;
use greenstick_skin::pieces::{self, InnerWood};
use std::f64::consts::TAU;
use std::sync::Arc;

/// A break with cracks in both faces.
#[derive(Debug, Clone)]
pub struct CrackedBreak {
    /// The lower piece, in the coordinates of the node that was cut.
    pub lower: Mesh,
    /// The upper piece.
    pub upper: Mesh,
    /// The face of the lower piece, with what was made and limited.
    pub lower_face: Grooved,
    /// The face of the upper piece.
    pub upper_face: Grooved,
    /// Volume (m³, in the node's coordinates) of the cracks: what both pieces lack of the stem.
    pub void: f64,
}

/// A stem with cracks in one of its ends.
#[derive(Debug, Clone)]
pub struct CrackedEnd {
    /// The stem, in the coordinates of the node.
    pub stem: Mesh,
    /// The end that was found.
    pub end: EndFace,
    /// The surface cut along, with what was made and limited.
    pub face: Grooved,
    /// Volume (m³, in the node's coordinates) of the cracks.
    pub void: f64,
}

/// Sectors and rings of the layout of a sawn end; it is level, so few will do.
const END_SECTORS: usize = 48;
const END_RINGS: usize = 4;

/// How near the cracks of an end come to the break's place, as part of the way from there to the end: a break through
/// cracked wood would cross the cracks' walls.
pub(crate) const OF_THE_WAY: f64 = 0.5;

impl Prepared {
    fn crack_setting(&self) -> Setting {
        let stem = &self.found.stem;
        Setting {
            radius: stem.radius,
            usable: stem.usable,
            level: f64::INFINITY,
        }
    }

    /// Breaks the stem along the surface of `model`, with the cracks of `plan` in both faces. `material` is that of
    /// the wood inside.
    ///
    /// # Errors
    /// [`Error::Crack`] where cracks cannot be drawn into the face, [`Error::Cut`] as for the break itself.
    pub fn crack_break(
        &self,
        model: &Model,
        p: &BreakParameters,
        plan: &CrackPlan,
        material: u32,
    ) -> Result<CrackedBreak, Error> {
        let stem = &self.found.stem;
        let setting = self.crack_setting();
        let plan = self.fitted(plan);
        let smooth = p.surface == SurfaceKind::Smooth;
        let proportions = p.proportions();
        let zone = |rho: f64| proportions.zone_at(rho, 0.0).code();
        let face = |direction| -> Result<(Grooved, (Mesh, Mesh)), Error> {
            let surface = &model.heights.surface;
            let made = grooves(&plan, &stem.rings, surface, direction, &setting)?;
            let meshes = self.cut_along(&made, &model.bundles, &zone, material, (smooth, true))?;
            Ok((made, meshes))
        };
        let (lower_face, (lower, _)) = face(Direction::Down)?;
        let (upper_face, (_, upper)) = face(Direction::Up)?;
        let whole = model.lower.volume() + model.upper.volume();
        let void = whole - lower.volume() - upper.volume();
        Ok(CrackedBreak {
            lower,
            upper,
            lower_face,
            upper_face,
            void,
        })
    }

    /// Cracks an end of the stem: the far one (greater lengths) or the near one.
    ///
    /// # Errors
    /// [`Error::Crack`] where the end is not found, [`Error::Cut`] where the mesh is open there.
    pub fn crack_end(
        &self,
        p: &BreakParameters,
        plan: &CrackPlan,
        far: bool,
        material: u32,
    ) -> Result<CrackedEnd, Error> {
        let stem = &self.found.stem;
        let end = EndFace::fit(
            &self.corners,
            &self.found.limb,
            &self.grain,
            far,
            stem.radius,
        )?;
        let bundles = layout::smooth(&stem.rings, &self.end_layout(p));
        let mut setting = self.crack_setting();
        // The wood of the end itself may be cracked, though not broken.
        let beyond = end.at(stem.rings.pith());
        let (low, high) = setting.usable;
        let place = stem.location;
        setting.usable = if far {
            let half = place + OF_THE_WAY * (beyond - place);
            (low.max(half), high.max(beyond + end.clearance))
        } else {
            let half = place - OF_THE_WAY * (place - beyond);
            (low.min(beyond - end.clearance), high.min(half))
        };
        let plan = self.fitted(plan);
        let face = end_grooves(&plan, &stem.rings, &bundles.layout, &end, &setting)?;
        let proportions = p.proportions();
        let zone = |rho: f64| proportions.zone_at(rho, 0.0).code();
        let whole = self.shell_volume();
        let (lower, upper) = self.cut_along(&face, &bundles, &zone, material, (false, false))?;
        let stem = if far { lower } else { upper };
        let void = whole - stem.volume();
        Ok(CrackedEnd {
            stem,
            end,
            face,
            void,
        })
    }

    /// A plan whose rings and angles are those of the section: a board without its pith has but an arc of each ring, and
    /// none of the inner ones.
    pub(crate) fn fitted(&self, plan: &CrackPlan) -> CrackPlan {
        let Some((from, to)) = self.extent.arc else {
            return plan.clone();
        };
        let (turn, inner) = ((to - from) / TAU, self.extent.reach.0);
        let fit = |crack: &PlannedCrack| {
            let mut crack = crack.clone();
            let first = crack.course.first().map_or(0.0, |c| c.1);
            let start = from + (first / TAU).rem_euclid(1.0) * (to - from);
            for (rho, phi) in &mut crack.course {
                *rho = inner + *rho * (1.0 - inner);
                *phi = start + (*phi - first) * turn;
            }
            crack.range *= match crack.way {
                Way::Radial => turn,
                Way::Tangential => 1.0 - inner,
            };
            crack
        };
        CrackPlan {
            cracks: plan.cracks.iter().map(fit).collect(),
            ..plan.clone()
        }
    }

    pub(crate) fn end_layout(&self, p: &BreakParameters) -> LayoutOptions {
        LayoutOptions {
            rings: END_RINGS,
            sectors: END_SECTORS,
            reach: self.extent.reach,
            radius: self.extent.radius,
            arc: self.extent.arc,
            bark: None,
            seed: p.seed,
        }
    }

    fn shell_volume(&self) -> f64 {
        let mesh = &self.scene.nodes[self.found.node].mesh;
        self.found
            .shell
            .iter()
            .map(|&t| {
                let [a, b, c] = mesh.triangles[t as usize].map(|v| mesh.positions[v as usize]);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    pub(crate) fn cut_along(
        &self,
        made: &Grooved,
        bundles: &Bundles,
        zone: &dyn Fn(f64) -> u8,
        material: u32,
        (smooth, two_pieces): (bool, bool),
    ) -> Result<(Mesh, Mesh), Error> {
        let stem = &self.found.stem;
        let solid = self.solid();
        let (low, high) = made.surface.range();
        let skin = Skin::new(&solid, (low, high));
        let ground = Ground::new(&skin, &made.surface.layout);
        let mut cut =
            cut_again(&solid, &skin, &ground, &made.surface).map_err(|error| self.locate(error))?;
        // What is cut out of an end is nothing but chips.
        if two_pieces {
            cut.absorb_chips(&solid);
        }
        cut.part_at(&self.grain, &self.kept.levels);
        let source = self.source();
        let mut bundles = bundles.clone();
        let new = &made.surface.layout.nodes[made.first_node..];
        bundles
            .addresses
            .extend(new.iter().map(|&p: &DVec2| stem.rings.address(p)));
        bundles.layout = Arc::clone(&made.surface.layout);
        let inner = InnerWood {
            stem,
            bundles: &bundles,
            zone,
            material,
            square: self.kept.square,
            smooth,
        };
        let face = face(&source, &cut, &inner);
        let patch = pieces::patch(&source, &cut, &skin, &face.places);
        let piece = |upper| pieces::piece(&source, &cut, &patch, &face, &inner, upper);
        Ok((piece(false), piece(true)))
    }
}
