//! A stage under construction: the root prim with its materials and meshes.

use super::layer::{DOCUMENTATION, Layer, Metadatum, Prim, TransformOp, Value};
use super::material::{self, Materials};
use super::mesh::{self, MeshPrim};
use super::names::{Names, set_display_name};
use crate::check::Surfaces;
use crate::companions::{Encoded, stem};
use crate::error::{FormatError, InFile};
use glam::DAffine3;
use greenstick_geometry::{Mesh, Metadata, Node};

/// A stage under construction.
pub(super) struct Stage<'a> {
    pub root: Prim,
    names: Names,
    pub materials: Materials,
    surfaces: Surfaces<'a>,
}

impl<'a> Stage<'a> {
    /// Starts a stage with the materials of `meshes`. `name` is the name of the file; an archive has to contain all textures.
    pub fn new<'m>(
        surfaces: Surfaces<'a>,
        meshes: impl Iterator<Item = &'m Mesh>,
        name: &str,
        is_archive: bool,
    ) -> Self {
        let root = Prim::new(Names::default().unique(&stem(name), "scene"), "Xform");
        let coloured = mesh::coloured_materials(meshes, surfaces.materials.len());
        let path = format!("/{}", root.name);
        let materials = material::write(surfaces, &coloured, &path, name, is_archive);
        let mut names = Names::default();
        // The name of the scope of materials.
        names.unique("materials", "");
        Stage {
            root,
            names,
            materials,
            surfaces,
        }
    }

    /// Converts a mesh to a prim without a transform; `None` if it has no triangles.
    pub fn mesh(
        &mut self,
        mesh: &Mesh,
        name: &str,
        file: InFile,
    ) -> Result<Option<MeshPrim>, FormatError> {
        if mesh.triangles.is_empty() {
            return Ok(None);
        }
        let own = self.names.unique(name, "mesh");
        let mut shape = mesh::write(mesh, own, self.surfaces.materials, &self.materials, file)?;
        set_display_name(&mut shape.prim, name);
        Ok(Some(shape))
    }

    /// Converts a node that does not move to a prim; `None` if it has no triangles.
    pub fn static_prim(&mut self, node: &Node, file: InFile) -> Result<Option<Prim>, FormatError> {
        let Some(shape) = self.mesh(&node.mesh, &node.name, file)? else {
            return Ok(None);
        };
        let mut prim = shape.prim;
        if node.transform != DAffine3::IDENTITY {
            let matrix = Value::Matrix(glam::DMat4::from(node.transform).to_cols_array_2d());
            prim.set_transform(vec![TransformOp {
                name: "transform",
                kind: "matrix4d",
                value: matrix,
            }]);
        }
        Ok(Some(prim))
    }

    /// Finishes the stage, which comes from where `provenance` says. Returns the layer and the texture files.
    pub fn finish(
        mut self,
        further: Vec<Metadatum>,
        provenance: &Metadata,
    ) -> (Layer, Vec<Encoded>) {
        if !self.materials.paths.is_empty() {
            self.root.children.push(self.materials.prim);
        }
        let mut metadata = vec![
            Metadatum::new("defaultPrim", Value::Token(self.root.name.clone())),
            Metadatum::new("metersPerUnit", Value::Double(1.0)),
            Metadatum::new("upAxis", Value::Token("Y".to_owned())),
        ];
        metadata.extend(further);
        if !provenance.is_empty() {
            let lines: Vec<String> = provenance.lines().collect();
            let text = Value::Text(lines.join("; "));
            metadata.push(Metadatum::new(DOCUMENTATION, text));
        }
        let layer = Layer {
            metadata,
            root: self.root,
        };
        (layer, self.materials.files)
    }
}
