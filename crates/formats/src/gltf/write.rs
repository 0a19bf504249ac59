//! Writing glTF and GLB.

use super::builder::{Builder, Finished};
use super::write_node::write_nodes;
use super::{container, write_material};
use crate::check::Surfaces;
use crate::companions::{CompanionNames, Encoded};
use crate::error::{FormatError, InFile};
use crate::uri::escape;
use greenstick_geometry::Scene;
use serde_json::json;

/// Writes a `.glb`, or a `.gltf` with its companions.
pub(crate) fn write(scene: &Scene, name: &str, glb: bool) -> Result<Vec<Encoded>, FormatError> {
    let file = InFile(name);
    let surfaces = Surfaces::from_scene(scene);
    surfaces.check(scene.nodes.iter().map(|n| &*n.mesh), file)?;
    let mut builder = Builder::with_metadata(scene.metadata.clone());
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
