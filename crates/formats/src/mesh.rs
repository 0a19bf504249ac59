//! Reading and writing meshes in any format.

use crate::check::check_scene;
use crate::companions::{Encoded, Resolve};
use crate::detect::detect;
use crate::error::FormatError;
use crate::format::{Format, OutputFormat};
use crate::unit::LengthUnit;
use crate::{gltf, obj, off, ply, stl};
use greenstick_geometry::Scene;
use greenstick_geometry::text::one_line;
use std::borrow::Cow;

/// Ending of the names of nodes that only add to the looks of others ([`greenstick_geometry::Node::is_detail`]): files have no
/// other place for it that all of them share.
const DETAIL_ENDING: &str = "_fuzz";

/// Reads a mesh file. If the content clearly has another format than `format`, the content decides, and a note says so.
///
/// `name` is the name of the file for messages. `unit` is the unit of length, metres if absent; for glTF, which is in
/// metres, another unit is applied as an additional scale, with a note. The unit affects the transforms of the nodes; the
/// meshes keep the numbers of the file.
///
/// ```
/// use greenstick_formats::{Format, LengthUnit, read};
///
/// let text = b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
/// let no_companions = |_: &str| Err(std::io::ErrorKind::NotFound.into());
/// let unit = Some(LengthUnit::Centimetre);
/// let scene = read(Format::Off, text, "triangle.off", unit, &no_companions)?;
/// assert_eq!(scene.nodes[0].mesh.triangles, [[0, 1, 2]]);
/// assert_eq!(scene.nodes[0].transform.matrix3.x_axis.x, 0.01);
/// # Ok::<(), greenstick_formats::FormatError>(())
/// ```
///
/// # Errors
/// [`FormatError`] if the bytes are not a valid file. No memory is allocated for a count that the bytes cannot hold.
pub fn read(
    format: Format,
    bytes: &[u8],
    name: &str,
    unit: Option<LengthUnit>,
    resolve: Resolve,
) -> Result<Scene, FormatError> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(FormatError::Empty {
            file: name.to_owned(),
            format: format.name(),
        });
    }
    let actual = detect(bytes).unwrap_or(format);
    let mut scene = match actual {
        Format::Gltf | Format::Glb => gltf::read(bytes, name, resolve)?,
        Format::Obj => obj::read(bytes, name, resolve)?,
        Format::Ply => ply::read(bytes, name)?,
        Format::Stl => stl::read(bytes, name)?,
        Format::Off => off::read(bytes, name)?,
    };
    if scene
        .nodes
        .iter()
        .all(|node| node.mesh.triangles.is_empty())
    {
        return Err(FormatError::NoTriangles {
            file: name.to_owned(),
        });
    }
    if actual != format {
        scene.notes.push(format!(
            "{name} has the extension of {} but holds {}; it was read as {1}.",
            format.name(),
            actual.name()
        ));
    }
    if let Some(unit) = unit.filter(|u| *u != LengthUnit::Metre) {
        let scale = glam::DAffine3::from_scale(glam::DVec3::splat(unit.metres()));
        for node in &mut scene.nodes {
            node.transform = scale * node.transform;
        }
        if actual.is_in_metres() {
            scene.notes.push(format!(
                "glTF is in metres by its standard; the unit {unit} was applied as an additional scale."
            ));
        }
    }
    for node in &mut scene.nodes {
        node.is_detail = node.name.ends_with(DETAIL_ENDING);
    }
    for note in &mut scene.notes {
        *note = one_line(note).into_owned();
    }
    Ok(scene)
}

/// Writes a scene in any format: as [`write()`] does, or as USD, which is in metres, too.
///
/// # Errors
/// As of [`write()`].
pub fn write_as(
    format: OutputFormat,
    scene: &Scene,
    name: &str,
    unit: LengthUnit,
) -> Result<Vec<Encoded>, FormatError> {
    match format {
        OutputFormat::Mesh(format) => write(format, scene, name, unit),
        #[cfg(feature = "usd")]
        OutputFormat::Usd(format) => crate::usd::write(format, scene, name),
    }
}

/// Writes a mesh file. Returns the main file, followed by its companions (`.bin`, `.mtl`, textures).
///
/// `name` is the name of the main file (`broken.glb`); companions are named after it. glTF is written in metres; `unit`
/// is the unit of length in the other formats.
///
/// ```
/// use glam::{DAffine3, DVec3};
/// use greenstick_formats::{Format, LengthUnit, write};
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
/// let files = write(Format::Gltf, &scene, "triangle.gltf", LengthUnit::Metre)?;
/// let names: Vec<&str> = files.iter().map(|f| f.name.as_str()).collect();
/// assert_eq!(names, ["triangle.gltf", "triangle.bin"]);
/// # Ok::<(), greenstick_formats::FormatError>(())
/// ```
///
/// # Errors
/// [`FormatError::Unwritable`] if the scene is invalid (an index out of range, a coordinate that is not finite), has no
/// triangles, or is too large for the format.
pub fn write(
    format: Format,
    scene: &Scene,
    name: &str,
    unit: LengthUnit,
) -> Result<Vec<Encoded>, FormatError> {
    check_scene(scene, name)?;
    match format {
        Format::Gltf => gltf::write(scene, name, false),
        Format::Glb => gltf::write(scene, name, true),
        Format::Obj => obj::write(scene, name, unit),
        Format::Ply => ply::write(&without_details(scene), name, unit),
        Format::Stl => stl::write(&without_details(scene), name, unit),
        Format::Off => off::write(&without_details(scene), name, unit),
    }
}

/// Returns a scene without the nodes that only add to the looks of others, for formats that hold all nodes as one mesh. They hold
/// no hierarchy either, so that parents are left as they are.
fn without_details(scene: &Scene) -> Cow<'_, Scene> {
    if scene.nodes.iter().all(|node| !node.is_detail) {
        return Cow::Borrowed(scene);
    }
    let mut solids = scene.clone();
    solids.nodes.retain(|node| !node.is_detail);
    Cow::Owned(solids)
}
