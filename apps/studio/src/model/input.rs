//! What is broken: the built-in branch, a mesh or a scan.

use greenstick::built_in_branch;
use greenstick::formats::{CloudFile, Content};
use greenstick::geometry::Scene;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// An input as it was read.
#[derive(Debug, Clone)]
pub struct Input {
    /// Tells inputs apart, as the same file may be read twice.
    pub id: u64,
    /// The file's path; none for the built-in branch.
    pub path: Option<String>,
    /// What is in it.
    pub content: Arc<InputContent>,
    /// Whether the meshes have no textures because the files were not found, and other notes of the reader.
    pub notes: Vec<String>,
}

/// What is in an input.
#[derive(Debug)]
pub enum InputContent {
    /// Meshes.
    Mesh(Scene),
    /// A point cloud.
    Cloud(CloudFile),
}

static NEXT: AtomicU64 = AtomicU64::new(1);

impl Input {
    /// The branch that comes with the program.
    pub fn built_in() -> Self {
        Input {
            id: 0,
            path: None,
            content: Arc::new(InputContent::Mesh(built_in_branch())),
            notes: Vec::new(),
        }
    }

    /// The content of a file.
    pub fn read(path: String, content: Content) -> Self {
        let (content, notes) = match content {
            Content::Mesh(scene) => {
                let notes = scene.notes.clone();
                (InputContent::Mesh(scene), notes)
            }
            Content::Cloud(cloud) => {
                let notes = cloud.notes.clone();
                (InputContent::Cloud(cloud), notes)
            }
        };
        Input {
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            path: Some(path),
            content: Arc::new(content),
            notes,
        }
    }

    /// The name of the file without its folder; none for the built-in branch.
    pub fn file_name(&self) -> Option<&str> {
        let path = self.path.as_deref()?;
        path.rsplit(['/', '\\']).next()
    }

    /// Whether its vertical is z, as that of scans is; meshes have y up, as in glTF.
    pub fn has_z_up(&self) -> bool {
        matches!(&*self.content, InputContent::Cloud(_))
    }

    /// What titles and menus call it.
    pub fn title(&self) -> &str {
        self.file_name().unwrap_or("built-in branch")
    }
}
