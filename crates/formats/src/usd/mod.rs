//! USD: static scenes as text (`.usda`), binary (`.usdc`) and archive (`.usdz`); [`crate::film`] writes films.
//!
//! All nodes are children of one prim, the default prim, with their transforms to the world; lengths are in metres, y
//! points up. Materials are UsdPreviewSurfaces.

mod archive;
mod binary;
mod coding;
mod film;
mod format;
mod layer;
mod material;
mod mesh;
mod names;
mod paths;
mod stage;
mod text;

pub(crate) use film::write_film;
pub use format::UsdFormat;

use crate::check::{Surfaces, check_scene};
use crate::companions::{Encoded, stem};
use crate::error::{FormatError, InFile};
use crate::sink::Sink;
use archive::write_archive;
use binary::CrateWriter;
use greenstick_geometry::Scene;
use stage::Stage;
use std::io::Cursor;

/// Writes a static scene. Returns the main file, followed by its textures, unless it is a `.usdz`, which contains them.
/// Textures other than PNG and JPEG are left out.
///
/// ```
/// use glam::{DAffine3, DVec3};
/// use greenstick_formats::usd::{UsdFormat, write};
/// use greenstick_geometry::{Mesh, Node, Scene};
///
/// let mesh = Mesh {
///     positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
///     triangles: vec![[0, 1, 2]],
///     ..Mesh::default()
/// };
/// let scene = Scene {
///     nodes: vec![Node::new("triangle", DAffine3::IDENTITY, mesh)],
///     ..Scene::default()
/// };
/// let files = write(UsdFormat::Usda, &scene, "triangle.usda")?;
/// assert!(files[0].bytes.starts_with(b"#usda 1.0"));
/// # Ok::<(), greenstick_formats::FormatError>(())
/// ```
///
/// # Errors
/// [`FormatError::Unwritable`] if the scene is invalid, has no triangles, or is too large for the format.
pub fn write(format: UsdFormat, scene: &Scene, name: &str) -> Result<Vec<Encoded>, FormatError> {
    let file = InFile(name);
    check_scene(scene, name)?;
    let surfaces = Surfaces::from_scene(scene);
    surfaces.check(scene.nodes.iter().map(|n| &*n.mesh), file)?;
    let is_archive = format == UsdFormat::Usdz;
    let mut stage = Stage::new(
        surfaces,
        scene.nodes.iter().map(|n| &*n.mesh),
        name,
        is_archive,
    );
    for node in &scene.nodes {
        if let Some(prim) = stage.static_prim(node, file)? {
            stage.root.children.push(prim);
        }
    }
    let (layer, files) = stage.finish(Vec::new(), &scene.metadata);
    let failed = |e: std::io::Error| file.unwritable(e, "a scene that fits the format");
    let bytes = match format {
        UsdFormat::Usda => text::write(&layer).into_bytes(),
        UsdFormat::Usdc => {
            let mut out = Cursor::new(Vec::new());
            let done = CrateWriter::new(&mut out).and_then(|c| c.finish(&layer));
            done.map_err(failed)?;
            out.into_inner()
        }
        UsdFormat::Usdz => {
            let mut out = Cursor::new(Vec::new());
            let main = format!("{}.usdc", stem(name));
            let mut fill = |out: &mut dyn Sink| CrateWriter::new(out)?.finish(&layer);
            write_archive(&mut out, &main, &mut fill, &files).map_err(failed)?;
            let bytes = out.into_inner();
            return Ok(vec![Encoded {
                name: name.to_owned(),
                bytes,
            }]);
        }
    };
    let main = Encoded {
        name: name.to_owned(),
        bytes,
    };
    Ok(std::iter::once(main).chain(files).collect())
}
