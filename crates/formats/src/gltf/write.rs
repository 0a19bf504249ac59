//! Writing glTF and GLB.

use super::builder::{Builder, Finished};
use super::write_node::write_nodes;
use super::{container, write_material};
use crate::check::Surfaces;
use crate::companions::{CompanionNames, Encoded};
use crate::error::{FormatError, InFile};
use crate::uri::escape;
use greenstick_geometry::{ImageSource, Mesh, Scene};
use serde_json::json;
use std::sync::Arc;

/// Writes a `.glb`, or a `.gltf` with its companions.
pub(crate) fn write(scene: &Scene, name: &str, glb: bool) -> Result<Vec<Encoded>, FormatError> {
    let file = InFile(name);
    let surfaces = Surfaces::from_scene(scene);
    surfaces.check(scene.nodes.iter().map(|n| &*n.mesh), file)?;
    let mut builder = Builder::with_metadata(scene.metadata.clone());
    builder.reserve(expected_bytes(scene));
    let roots = write_nodes(&scene.nodes, scene.materials.as_slice(), &mut builder, file)?;
    builder.push("scenes", json!({ "nodes": roots }));
    let mut names = CompanionNames::new(name);
    let binary_name = names.with_extension("bin");
    write_material::write(surfaces, &mut builder, (!glb).then_some(names));
    let uri = (!glb).then(|| escape(&binary_name));
    let Finished {
        json,
        binary,
        mut companions,
    } = builder.finish(uri, 0);
    if glb {
        let bytes = container::join(json, binary, file)?;
        return Ok(vec![Encoded {
            name: name.to_owned(),
            bytes,
        }]);
    }
    let mut files = vec![
        Encoded {
            name: name.to_owned(),
            bytes: json,
        },
        Encoded {
            name: binary_name,
            bytes: binary,
        },
    ];
    files.append(&mut companions);
    Ok(files)
}

/// About the bytes of a scene's meshes and images, and of the JSON before them.
fn expected_bytes(scene: &Scene) -> usize {
    const JSON: usize = 32 * 1024;
    let mut meshes: Vec<_> = scene.nodes.iter().map(|node| &node.mesh).collect();
    meshes.sort_unstable_by_key(|mesh| Arc::as_ptr(mesh));
    meshes.dedup_by_key(|mesh| Arc::as_ptr(mesh));
    let of_mesh = |mesh: &Arc<Mesh>| {
        let widths: usize = mesh.attributes.values().map(|a| a.width).sum();
        4 * mesh.positions.len() * (3 + widths) + 12 * mesh.triangles.len()
    };
    let images = scene.images.iter().map(|image| match &image.source {
        ImageSource::Bytes(bytes) => bytes.len(),
        ImageSource::Reference(_) => 0,
    });
    meshes.into_iter().map(of_mesh).sum::<usize>() + images.sum::<usize>() + JSON
}
