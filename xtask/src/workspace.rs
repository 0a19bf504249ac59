//! The packages of the workspace as `cargo metadata` lists them, and their files.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A package of the workspace.
pub struct Package {
    pub name: String,
    /// Folder of its manifest.
    pub folder: PathBuf,
    /// Names of the packages it depends on, those outside the workspace included.
    pub dependencies: Vec<String>,
    /// Root file of its library, where it has one.
    pub library: Option<PathBuf>,
    /// Root files of all its targets: library, programs, tests, benches and examples.
    pub roots: Vec<PathBuf>,
}

impl Package {
    /// Whether the package lies in `apps/`.
    pub fn is_app(&self) -> bool {
        self.folder.parent().is_some_and(|p| p.ends_with("apps"))
    }
}

/// A rule that is broken at some place.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// What is wrong, where, and what would be right.
    pub message: String,
    /// The line that lets this fault pass for now, where `exceptions.txt` may hold one.
    pub exception: Option<String>,
}

impl From<String> for Fault {
    fn from(message: String) -> Self {
        Fault {
            message,
            exception: None,
        }
    }
}

/// Runs `cargo metadata` in the root of the workspace, for its own packages.
pub fn metadata(root: &Path) -> Result<Value, String> {
    metadata_of(root, "--no-deps")
}

/// Runs `cargo metadata` with an option in the folder of a workspace.
pub fn metadata_of(folder: &Path, option: &str) -> Result<Value, String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(cargo)
        .args(["metadata", "--format-version", "1", option])
        .current_dir(folder)
        .output()
        .map_err(|e| format!("cargo metadata did not start: {e}"))?;
    if !output.status.success() {
        return Err(format!(
            "cargo metadata in {} failed: {}",
            folder.display(),
            String::from_utf8_lossy(&output.stderr)
        ));
    }
    serde_json::from_slice(&output.stdout)
        .map_err(|e| format!("cargo metadata did not print JSON: {e}"))
}

/// Reads the packages from the output of `cargo metadata`.
pub fn packages(metadata: &Value) -> Result<Vec<Package>, String> {
    let text = |v: &Value, key: &str| {
        v[key]
            .as_str()
            .map(str::to_owned)
            .ok_or_else(|| format!("cargo metadata has a package without `{key}`"))
    };
    let list = metadata["packages"]
        .as_array()
        .ok_or("cargo metadata has no `packages`")?;
    list.iter()
        .map(|package| {
            let manifest = PathBuf::from(text(package, "manifest_path")?);
            let dependencies = package["dependencies"]
                .as_array()
                .map_or(&[][..], Vec::as_slice);
            let targets = package["targets"].as_array().map_or(&[][..], Vec::as_slice);
            let root = |t: &Value| t["src_path"].as_str().map(PathBuf::from);
            let is_library = |t: &&Value| {
                t["kind"]
                    .as_array()
                    .is_some_and(|k| k.iter().any(|k| k == "lib"))
            };
            Ok(Package {
                name: text(package, "name")?,
                folder: manifest.parent().map(PathBuf::from).unwrap_or_default(),
                dependencies: dependencies
                    .iter()
                    .map(|d| text(d, "name"))
                    .collect::<Result<_, _>>()?,
                library: targets.iter().find(is_library).and_then(root),
                roots: targets.iter().filter_map(root).collect(),
            })
        })
        .collect()
}

/// All files below a folder that `wanted` accepts, sorted. Build outputs, installed packages and hidden folders other
/// than `.ci` are left out.
pub fn files_below(folder: &Path, wanted: &dyn Fn(&Path) -> bool) -> Result<Vec<PathBuf>, String> {
    let failure = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).map_err(failure)? {
        let path = entry.map_err(failure)?.path();
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or("");
        if path.is_dir() {
            let hidden = name.starts_with('.') && name != ".ci";
            if !(hidden || name == "target" || name == "node_modules") {
                files.extend(files_below(&path, wanted)?);
            }
        } else if wanted(&path) {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

/// All Rust files below a folder, sorted.
pub fn rust_files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    files_below(folder, &|path| path.extension().is_some_and(|e| e == "rs"))
}

/// Reads a text file.
pub fn read(file: &Path) -> Result<String, String> {
    fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))
}

/// The path of a file relative to the root of the workspace, with `/` on every system.
pub fn relative(file: &Path, root: &Path) -> String {
    let root = root.canonicalize().unwrap_or_else(|_| root.to_owned());
    let file = file.canonicalize().unwrap_or_else(|_| file.to_owned());
    let inside = file.strip_prefix(&root).unwrap_or(&file);
    let parts: Vec<_> = inside
        .components()
        .map(|c| c.as_os_str().to_string_lossy())
        .collect();
    parts.join("/")
}

/// A folder of its own for a test, removed with everything in it when dropped.
#[cfg(test)]
pub struct TestFolder(pub PathBuf);

#[cfg(test)]
impl TestFolder {
    /// Makes the folder and writes the files, each given by its path and its text.
    pub fn new(name: &str, files: &[(&str, &str)]) -> Self {
        let folder =
            std::env::temp_dir().join(format!("greenstick-xtask-{name}-{}", std::process::id()));
        for (file, text) in files {
            let path = folder.join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        TestFolder(folder)
    }

    /// A package whose only root is the given file.
    pub fn package(&self, root: &str) -> Package {
        Package {
            name: "x".to_owned(),
            folder: self.0.clone(),
            dependencies: Vec::new(),
            library: Some(self.0.join(root)),
            roots: vec![self.0.join(root)],
        }
    }
}

#[cfg(test)]
impl Drop for TestFolder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap();
    }
}
