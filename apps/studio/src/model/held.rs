//! Files that are held as bytes with their names alone, as a browser hands them over.

use super::engine::Failure;
use super::input::Input;
use super::project_file::ProjectFile;
use greenstick::formats::{
    CloudFormat, Content, Format, InputFormat, LengthUnit, embed_images, read_content,
};
use std::io;
use std::path::Path;

/// A file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HeldFile {
    /// Its name.
    pub name: String,
    /// Its content.
    pub bytes: Vec<u8>,
}

/// The last part of a path.
pub fn last_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// Whether a file is a project or a recipe, by its name.
pub fn is_project(name: &str) -> bool {
    name.to_lowercase().ends_with(".toml")
}

/// The mesh or scan among files; the others are what it refers to.
fn main_file(files: &[HeldFile]) -> Option<&HeldFile> {
    let known = |f: &&HeldFile| InputFormat::from_path(Path::new(&f.name)).is_some();
    let other = |f: &&HeldFile| !is_project(&f.name);
    files
        .iter()
        .find(known)
        .or_else(|| files.iter().find(other))
}

/// The name of the mesh or scan among files.
pub fn main_name(files: &[HeldFile]) -> Option<&str> {
    main_file(files).map(|f| f.name.as_str())
}

/// Reads the mesh or scan among files, with the textures that are there.
///
/// # Errors
/// What is wrong with it.
pub fn read_input(files: &[HeldFile], unit: Option<LengthUnit>) -> Result<Input, Failure> {
    let main = main_file(files).ok_or_else(|| Failure::new("there is no file to open"))?;
    let format = InputFormat::from_path(Path::new(&main.name)).ok_or_else(|| {
        let clouds = CloudFormat::ALL.iter().flat_map(|f| f.extensions());
        let meshes = Format::ALL.map(Format::extension).into_iter();
        let endings: Vec<&str> = meshes.chain(clouds.copied()).collect();
        Failure::new(format!(
            "{}: neither a mesh, a point cloud nor a project; expected one of the endings {} or toml",
            main.name,
            endings.join(", ")
        ))
    })?;
    let find = |reference: &str| {
        let name = last_name(reference);
        let found = files.iter().find(|f| f.name == name);
        found.map(|f| f.bytes.clone()).ok_or_else(|| {
            let message = format!("choose {name} together with {}", main.name);
            io::Error::new(io::ErrorKind::NotFound, message)
        })
    };
    let mut content =
        read_content(format, &main.bytes, &main.name, unit, &find).map_err(Failure::new)?;
    if let Content::Mesh(scene) = &mut content {
        embed_images(scene, &find);
        if let Some(unit) = unit.filter(|u| *u != LengthUnit::Metre) {
            scene.move_scale_into_meshes(unit.metres());
        }
    }
    Ok(Input::read(main.name.clone(), content))
}

/// Reads the project or recipe among files, if there is one.
///
/// # Errors
/// What is wrong with it.
pub fn read_project(files: &[HeldFile]) -> Result<Option<ProjectFile>, Failure> {
    let Some(file) = files.iter().find(|f| is_project(&f.name)) else {
        return Ok(None);
    };
    let text = std::str::from_utf8(&file.bytes)
        .map_err(|e| Failure::new(format!("{}: not text: {e}", file.name)))?;
    let project = ProjectFile::read(text);
    let project = project.map_err(|e| Failure::new(format!("{}: {e}", file.name)))?;
    Ok(Some(project))
}
