//! Pictures of triangle meshes, ray-traced on the CPU with soft light, shadows and indirect light, of which one bounce is
//! traced, without a driver or a window. A [`Shader`] provides the appearance of surfaces, so that this crate knows no materials but the
//! plain ones of [`PlainShader`].
//!
//! A scene gives the same bits on every machine and with any number of threads.
#![deny(missing_docs)]

mod bvh;
mod camera;
mod chart;
mod coin;
mod denoise;
mod drawing;
mod enlarge;
mod error;
mod focus;
mod grain;
mod ground;
mod item;
mod layers;
mod lens;
mod light;
mod lighting;
mod outlines;
mod parameters;
mod picture;
mod plain;
mod render;
mod resolve;
mod sampling;
mod scale_bar;
mod scene;
mod shader;
mod sheet;
mod surface;
mod texture;

pub use camera::{CameraPlacement, Horizontal, Sphere, View, azimuth_of_view, horizontal};
pub use chart::{Chart, Series, SeriesStyle};
pub use error::{MAX_SAMPLES, MAX_SIDE, MAX_TRIANGLES, PictureError};
pub use ground::Ground;
pub use item::Item;
pub use parameters::{PictureParameters, PictureSize, ViewDirection};
pub use picture::Picture;
pub use plain::{PlainMaterial, PlainShader};
pub use render::{PictureOptions, render, render_scene};
pub use shader::{Appearance, Hit, Shader};
pub use sheet::{SheetCell, contact_sheet};
pub use texture::TexturedMaterial;
