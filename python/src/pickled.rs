//! What pickles of this library have in common: bytes that say which version wrote them and whether they are whole.

use crate::failure::Failure;
use greenstick::ErrorKind;
use greenstick::fibre::store::checksum;
use greenstick::geometry::Mesh;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::fmt::Display;

/// What sealed bytes begin with. The length of the version's name (`u8`), its name, the content, and the checksum (`u64`, of all
/// that is before it) follow.
const MAGIC: &[u8; 8] = b"GSPICKLE";
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Seals the content of a pickle.
pub fn seal(content: &[u8]) -> Vec<u8> {
    let mut sealed = Vec::with_capacity(MAGIC.len() + 1 + VERSION.len() + content.len() + 8);
    sealed.extend(MAGIC);
    sealed.push(VERSION.len() as u8);
    sealed.extend(VERSION.as_bytes());
    sealed.extend(content);
    sealed.extend(checksum(&sealed).to_le_bytes());
    sealed
}

/// Returns the content of sealed bytes; `what` was pickled.
pub fn unseal<'a>(what: &str, sealed: &'a [u8]) -> Result<&'a [u8], Failure> {
    let unknown = || {
        failure(format!(
            "the pickle of {what} is damaged, or of a version of greenstick that pickles otherwise than {VERSION}; make it again \
             with this version"
        ))
    };
    let rest = sealed.strip_prefix(MAGIC).ok_or_else(unknown)?;
    let (_, sum) = sealed.split_last_chunk().ok_or_else(unknown)?;
    let body = &sealed[..sealed.len() - sum.len()];
    if checksum(body) != u64::from_le_bytes(*sum) {
        return Err(damaged(what, "its checksum is wrong"));
    }
    let rest = rest.strip_suffix(sum).ok_or_else(unknown)?;
    let (length, rest) = rest.split_first().ok_or_else(unknown)?;
    let (version, content) = rest
        .split_at_checked(usize::from(*length))
        .ok_or_else(unknown)?;
    if version != VERSION.as_bytes() {
        let version = String::from_utf8_lossy(version);
        return Err(failure(format!(
            "the pickle of {what} was made by greenstick {version}, and this is {VERSION}; unpickle it with {version}, or make it \
             again with this version"
        )));
    }
    Ok(content)
}

/// A seal over nothing: for what is made again when it is unpickled, which other versions may make otherwise.
pub fn version_seal(py: Python<'_>) -> Bound<'_, PyBytes> {
    PyBytes::new(py, &seal(&[]))
}

/// A pickle that cannot be read.
pub fn damaged(what: &str, problem: impl Display) -> Failure {
    failure(format!(
        "the pickle of {what} is damaged: {problem}; make it again, or use another copy of it"
    ))
}

fn failure(message: String) -> Failure {
    Failure::new("PickleError", ErrorKind::Request, message)
}

/// A checksum of all that a mesh has.
pub fn mesh_checksum(mesh: &Mesh) -> u64 {
    let mut sums = vec![
        checksum(bytemuck::cast_slice(&mesh.positions)),
        checksum(bytemuck::cast_slice(&mesh.triangles)),
        checksum(bytemuck::cast_slice(&mesh.materials)),
    ];
    for (name, attribute) in &mesh.attributes {
        sums.push(checksum(name.as_bytes()));
        sums.push(attribute.width as u64);
        sums.push(checksum(bytemuck::cast_slice(&attribute.data)));
    }
    checksum(bytemuck::cast_slice(&sums))
}
