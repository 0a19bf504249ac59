//! What tests of breaks share.

#[path = "../../../../../tests/support/data.rs"]
pub mod data;

use greenstick::fibre::placement::{
    EdgeLengths, PlacedRods, PlacementOptions, RodCount, WoodMaterial, fill_stem,
};
use greenstick::fracture::parameters::BreakParameters;
use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::{Context, Mesh, Node, Scene};
use greenstick::session::BreakStages;
use greenstick::skin::rods::Wood;
use greenstick::wood::moisture::Fallback;
use greenstick::wood::primitive;
use greenstick::wood::species::Species;
use greenstick::wood::stem::{Stem, StemLocation, StemOptions, find_stem};
use greenstick::{Break, BreakRequest, BreakSession};

/// A scene of one mesh, in metres times `scale`.
pub fn scene(mesh: Mesh, scale: f64) -> Scene {
    let transform = glam::DAffine3::from_scale(glam::DVec3::splat(scale));
    Scene {
        nodes: vec![Node::new("stem", transform, mesh)],
        ..Scene::default()
    }
}

/// A break with these parameters at a fraction of the length.
pub fn request(at: f64, face: &BreakParameters) -> BreakRequest {
    BreakRequest::single(Break {
        place: StemLocation::Fraction(at),
        recipe: Recipe {
            face: face.clone(),
            ..Recipe::default()
        },
        ..Break::default()
    })
}

/// A session that breaks one mesh.
pub fn session(mesh: Mesh) -> BreakSession {
    BreakSession::new(scene(mesh, 1.0))
}

/// The stages of a break with these parameters.
pub fn stages(session: &mut BreakSession, at: f64, face: &BreakParameters) -> BreakStages {
    let made = session.stages(&request(at, face), &Context::quiet());
    made.unwrap_or_else(|e| panic!("{e}"))
}

/// The lower and the upper piece.
pub fn pieces(stages: &BreakStages, face: &BreakParameters) -> [Mesh; 2] {
    [false, true].map(|upper| stages.piece(face, upper))
}

/// The scanned pole, which comes with the project, in metres.
pub fn scanned_pole() -> Scene {
    let unit = Some(greenstick::formats::LengthUnit::Millimetre);
    greenstick::files::read(&data::data("pole.ply"), unit).unwrap()
}

/// Rods of white oak in a cylinder that is known.
pub struct Grown {
    pub scene: Scene,
    pub stem: Stem,
    pub placed: PlacedRods,
}

impl Grown {
    /// A cylinder of this radius, 0.4 m long, with 150 rods whose edges have about this length (m).
    pub fn new(radius: f64, edge: f64) -> Self {
        let scene = scene(primitive::cylinder(radius, 0.4, 64), 1.0);
        let middle = StemLocation::Fraction(0.5);
        let (meshes, quiet) = ([(*scene.nodes[0].mesh).clone()], Context::quiet());
        let stem = find_stem(&meshes, &middle, &StemOptions::default(), &quiet)
            .unwrap()
            .stem;
        let oak = Species::find("white oak").unwrap();
        let wood = WoodMaterial::from_species(oak, 12.0, Fallback::Refuse).unwrap();
        let options = PlacementOptions {
            rods: RodCount::Number(150),
            edges: EdgeLengths {
                least: 0.9 * edge,
                greatest: 1.1 * edge,
            },
            ..PlacementOptions::default()
        };
        Grown {
            placed: fill_stem(&stem, &wood, &options, &quiet).unwrap(),
            stem,
            scene,
        }
    }

    /// The wood, whose breaks lie within `pull_out` of each other (radii).
    pub fn wood(&self, pull_out: f64) -> Wood<'_> {
        Wood {
            stem: &self.stem,
            stem_to_rods: glam::DAffine3::IDENTITY,
            bundle: &self.placed.bundle,
            along: &self.placed.along,
            cells: &self.placed.cells,
            outline: &self.placed.outline,
            bark: None,
            pull_out,
        }
    }
}
