//! What tests of breaks share.
#![allow(dead_code)] // Each test file uses a part of it.

#[path = "../../../../tests/support/data.rs"]
mod data;

use greenstick::fracture::parameters::BreakParameters;
use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::{Context, Mesh, Node, Scene};
use greenstick::session::BreakStages;
use greenstick::wood::stem::StemLocation;
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
