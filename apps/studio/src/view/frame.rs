//! What one frame of the viewport shows.

use super::camera::Camera;
use crate::model::meshes::DrawnScene;
use crate::model::section::{Plane, SectionFaces};
use std::sync::Arc;

/// What colours show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Colours {
    /// Wood, bark and materials.
    #[default]
    Wood,
    /// Tissues.
    Zones,
    /// Annual rings.
    Rings,
    /// Pieces.
    Pieces,
    /// Clay: the shape alone.
    Clay,
}

impl Colours {
    /// All of them.
    pub const ALL: [Colours; 5] = [
        Colours::Wood,
        Colours::Zones,
        Colours::Rings,
        Colours::Pieces,
        Colours::Clay,
    ];

    /// Name and what it shows.
    pub fn label(self) -> (&'static str, &'static str) {
        match self {
            Colours::Wood => ("Wood", "Wood, bark and the materials of the input."),
            Colours::Zones => (
                "Zones",
                "Tissues: pith, heartwood, sapwood, phloem and bark.",
            ),
            Colours::Rings => ("Rings", "Annual rings, each in a colour of its own."),
            Colours::Pieces => ("Pieces", "Pieces, each in a colour of its own."),
            Colours::Clay => ("Clay", "The shape alone, as of clay."),
        }
    }
}

/// One frame of the viewport.
#[derive(Debug, Clone)]
pub struct View {
    /// What is drawn, and a number that tells results apart.
    pub shown: Option<(u64, Arc<DrawnScene>)>,
    /// From where.
    pub camera: Camera,
    /// Size of the picture, pixels.
    pub size: [u32; 2],
    /// What colours show.
    pub colours: Colours,
    /// Whether the edges of triangles are drawn.
    pub wireframe: bool,
    /// Plane beyond which nothing is drawn, and the faces that it opens.
    pub section: Option<(Plane, Arc<SectionFaces>)>,
    /// Linear colour of the background.
    pub background: [f32; 3],
}
