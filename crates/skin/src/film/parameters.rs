//! Parameters of stills and films of a run.

use super::{FRAME_RANGE, FilmOptions, FrameRange};
use crate::rods::RodSkinOptions;
use greenstick_geometry::ConvexOptions;
use greenstick_schema::{Kind, Unit, count, flag, list, number, parameters, text};

/// Greatest number of a frame: more than a run has.
const MAX_FRAME: i128 = u32::MAX as i128;
/// Most levels of detail: each is a file.
const MAX_LEVELS: usize = 64;
/// A share of the triangles.
const SHARE: Kind = number(Unit::One, 0.0, 1.0).above().kind;

parameters! {
    /// Parameters of stills and films of a run, and of their files for game engines.
    pub struct FilmParameters {
        "Skin", "skin" {
            /// Leave out the bodies that act on the wood.
            no_bodies: bool = false, flag();
            /// Leave out what the rods do not fill: the mesh beyond their ends, and twigs that hang on them.
            only_rods: bool = false, flag();
            /// Width of the baked textures.
            texture_size: u32 = 1024, count(8, 16_384).step(2).unit(Unit::Pixel).logarithmic().stage("textures");
        }
        "Film", "write" {
            /// One frame in place of a film, counted from 0; negative from the end.
            frame: Option<i64> = None, count(-MAX_FRAME, MAX_FRAME).auto().stage("skin");
            /// Frames of the film, from the first to before the last; "auto" is all.
            frames: Option<FrameRange> = None, text(FRAME_RANGE).auto().stage("skin");
            /// Most joints of a piece in a film; "auto" is as many as there are. The report says what error that makes.
            max_joints: Option<u32> = None, count(1, u32::MAX as i128).logarithmic().auto();
            /// Most joints that a vertex of a film follows; many viewers support no more than 4.
            influences: u32 = 4, count(1, 8);
        }
        "For engines", "for engines" {
            /// Most convex collision shapes of a piece.
            collision_shapes: u32 = 16, count(1, 1024).logarithmic();
            /// Most vertices of a convex collision shape.
            collision_vertices: u32 = 32, count(4, 255).logarithmic();
            /// Levels of detail: shares of the triangles, in files beside the film, film_lod1.glb and so on.
            lod: Vec<f64> = Vec::new(), list(&SHARE, 0, MAX_LEVELS);
            /// Most pixels in a row of a vertex animation texture.
            vat_width: u32 = 8192, count(1, 16_384).unit(Unit::Pixel).logarithmic();
        }
    }
    include {
        /// The skin of the rods.
        skin: RodSkinOptions = RodSkinOptions::default();
    }
}

impl FilmParameters {
    /// Returns the options of a still or film; `seed` is that of the wood.
    pub fn film_options(&self, seed: u64) -> FilmOptions {
        FilmOptions {
            skin: RodSkinOptions {
                seed,
                ..self.skin.clone()
            },
            texture_width: self.texture_size,
            bodies: !self.no_bodies,
            rest: !self.only_rods,
        }
    }

    /// Returns the options of collision shapes.
    pub fn convex_options(&self) -> ConvexOptions {
        ConvexOptions {
            shapes: self.collision_shapes as usize,
            vertices: self.collision_vertices as usize,
            ..ConvexOptions::default()
        }
    }
}

impl Default for FilmOptions {
    fn default() -> Self {
        FilmParameters::default().film_options(RodSkinOptions::default().seed)
    }
}
