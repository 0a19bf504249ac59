//! USD: `.usda` text and binary `.usdc` and `.usdz` of a still scene; binary films are in [`crate::film`].
//!
//! Every node lies below one prim, which is the default one, at its place in the world; metres, y upwards. Materials are
//! UsdPreviewSurfaces.

mod archive;
mod binary;
mod coding;
mod film;
mod layer;
mod material;
mod mesh;
mod text;

use crate::assemble::{Surfaces, check_scene};
use crate::error::{FormatError, InFile};
use crate::film::Sink;
use crate::{Encoded, stem};
use archive::{Archive, Fill};
use binary::Crate;
pub(crate) use film::write_film;
use glam::DAffine3;
use greenstick_geometry::{Node, Scene};
use layer::{Layer, Names, Prim, Property, Value};
use material::Looks;
use std::io::Cursor;
use std::path::Path;

/// A form of USD.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum UsdFormat {
    /// Text.
    Usda,
    /// Binary.
    Usdc,
    /// An archive of a binary layer and its textures.
    Usdz,
}

impl UsdFormat {
    /// Every one.
    pub const ALL: [UsdFormat; 3] = [UsdFormat::Usda, UsdFormat::Usdc, UsdFormat::Usdz];

    /// The format that the ending of `path` names, in either case.
    pub fn of_path(path: &Path) -> Option<UsdFormat> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        UsdFormat::ALL.into_iter().find(|f| f.ending() == ending)
    }

    /// The file name's ending, without the dot.
    pub fn ending(self) -> &'static str {
        match self {
            UsdFormat::Usda => "usda",
            UsdFormat::Usdc => "usdc",
            UsdFormat::Usdz => "usdz",
        }
    }
}

/// Writes a still scene: the main file first, then its textures, which a `.usdz` holds itself. Textures in other forms
/// than PNG and JPEG are left out.
///
/// # Errors
/// [`FormatError::Unwritable`] where the scene breaks its own rules, has no triangle, or is too large for the format.
pub fn write(format: UsdFormat, scene: &Scene, name: &str) -> Result<Vec<Encoded>, FormatError> {
    let file = InFile(name);
    check_scene(scene, name)?;
    let surfaces = Surfaces::of(scene);
    surfaces.check(scene.nodes.iter().map(|n| &*n.mesh), file)?;
    let archive = format == UsdFormat::Usdz;
    let mut stage = Stage::new(
        surfaces,
        scene.nodes.iter().map(|n| &*n.mesh),
        name,
        archive,
    );
    for node in &scene.nodes {
        if let Some(prim) = stage.still(node, file)? {
            stage.root.children.push(prim);
        }
    }
    let (layer, files) = stage.finish(Vec::new());
    let failed = |e: std::io::Error| file.unwritable(e, "a scene that fits the format");
    let bytes = match format {
        UsdFormat::Usda => text::write(&layer).into_bytes(),
        UsdFormat::Usdc => {
            let mut out = Cursor::new(Vec::new());
            let done = Crate::new(&mut out).and_then(|c| c.finish(&layer));
            done.map_err(failed)?;
            out.into_inner()
        }
        UsdFormat::Usdz => {
            let mut out = Cursor::new(Vec::new());
            let main = format!("{}.usdc", stem(name));
            let mut fill = |out: &mut dyn Sink| Crate::new(out)?.finish(&layer);
            pack(&mut out, &main, &mut fill, &files).map_err(failed)?;
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

/// Writes an archive of a layer and its textures; gives its length.
fn pack(out: &mut dyn Sink, main: &str, fill: Fill, files: &[Encoded]) -> std::io::Result<u64> {
    let mut archive = Archive::new(out)?;
    archive.add(main, fill)?;
    for file in files {
        let mut crc = flate2::Crc::new();
        crc.update(&file.bytes);
        archive.add(&file.name, &mut |out: &mut dyn Sink| {
            out.write_all(&file.bytes)?;
            Ok((file.bytes.len() as u64, crc.sum()))
        })?;
    }
    archive.finish()
}

/// A stage under construction.
struct Stage<'a> {
    root: Prim,
    names: Names,
    looks: Looks,
    surfaces: Surfaces<'a>,
}

impl<'a> Stage<'a> {
    fn new<'m>(
        surfaces: Surfaces<'a>,
        meshes: impl Iterator<Item = &'m greenstick_geometry::Mesh>,
        name: &str,
        archive: bool,
    ) -> Self {
        let root = Prim::new(Names::default().unique(&stem(name), "scene"), "Xform");
        let coloured = mesh::coloured(meshes, surfaces.materials.len());
        let path = format!("/{}", root.name);
        let looks = material::write(surfaces, &coloured, &path, name, archive);
        let mut names = Names::default();
        // The materials' own.
        names.unique("materials", "");
        Stage {
            root,
            names,
            looks,
            surfaces,
        }
    }

    /// A mesh as a prim below the root, without a place of its own; none where there is nothing to see.
    fn mesh(
        &mut self,
        mesh: &greenstick_geometry::Mesh,
        name: &str,
        file: InFile,
    ) -> Result<Option<mesh::Shape>, FormatError> {
        if mesh.triangles.is_empty() {
            return Ok(None);
        }
        let own = self.names.unique(name, "mesh");
        let mut shape = mesh::write(mesh, own, self.surfaces.materials, &self.looks, file)?;
        material::name_shown(&mut shape.prim, name);
        Ok(Some(shape))
    }

    /// A placed mesh that stands still.
    fn still(&mut self, node: &Node, file: InFile) -> Result<Option<Prim>, FormatError> {
        let Some(shape) = self.mesh(&node.mesh, &node.name, file)? else {
            return Ok(None);
        };
        let mut prim = shape.prim;
        if node.transform != DAffine3::IDENTITY {
            let matrix = Value::Matrix(glam::DMat4::from(node.transform).to_cols_array_2d());
            place(&mut prim, vec![("transform", "matrix4d", matrix)]);
        }
        Ok(Some(prim))
    }

    /// The layer and the files of its textures.
    fn finish(mut self, further: Vec<(&'static str, Value)>) -> (Layer, Vec<Encoded>) {
        if !self.looks.paths.is_empty() {
            self.root.children.push(self.looks.prim);
        }
        let mut metadata = vec![
            ("defaultPrim", Value::Token(self.root.name.clone())),
            ("metersPerUnit", Value::Double(1.0)),
            ("upAxis", Value::Token("Y".to_owned())),
        ];
        metadata.extend(further);
        let layer = Layer {
            metadata,
            root: self.root,
        };
        (layer, self.looks.files)
    }
}

/// Places a prim by steps that are applied from the last to the first: (name, type, value).
fn place(prim: &mut Prim, steps: Vec<(&'static str, &'static str, Value)>) {
    let mut order = Vec::new();
    for (name, kind, value) in steps {
        let name = format!("xformOp:{name}");
        order.push(name.clone());
        prim.properties.push(Property::new(name, kind, value));
    }
    let order = Value::Tokens(order);
    prim.properties
        .push(Property::uniform("xformOpOrder", "token[]", order));
}
