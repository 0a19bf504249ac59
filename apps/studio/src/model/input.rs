//! What is broken: the built-in branch, a mesh or a scan.

use super::meshes::DrawnScene;
use greenstick::built_in_branch;
use greenstick::formats::{CloudFile, Content};
use greenstick::geometry::Scene;
use serde::{Deserialize, Serialize};
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
    /// The file that it will be kept in, where it was made and has none yet.
    pub made: Option<Arc<Vec<u8>>>,
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
    /// Only what the window needs to know; the meshes or points are where the work is done.
    Elsewhere(Seen),
}

/// What the window needs to know of an input.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Seen {
    /// The meshes before anything is broken; none of a scan.
    pub unbroken: Option<DrawnScene>,
    /// Whether its vertical is z.
    pub has_z_up: bool,
    /// Notes of the reader.
    pub notes: Vec<String>,
}

static NEXT: AtomicU64 = AtomicU64::new(1);

impl Input {
    /// The branch that comes with the program.
    pub fn built_in() -> Self {
        Input {
            id: 0,
            path: None,
            made: None,
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
            made: None,
            content: Arc::new(content),
            notes,
        }
    }

    /// What was made, with the bytes of the GLB file that it will be kept in.
    pub fn made(content: Content, file: Vec<u8>) -> Self {
        Input {
            path: None,
            made: Some(Arc::new(file)),
            ..Input::read(String::new(), content)
        }
    }

    /// A file that is read where the work is done.
    pub fn elsewhere(name: String, seen: Seen) -> Self {
        Input {
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            path: Some(name),
            made: None,
            notes: seen.notes.clone(),
            content: Arc::new(InputContent::Elsewhere(seen)),
        }
    }

    /// What was made where the work is done, with the bytes of the GLB file that it will be kept in.
    pub fn made_elsewhere(seen: Seen, file: Vec<u8>) -> Self {
        Input {
            path: None,
            made: Some(Arc::new(file)),
            ..Input::elsewhere(String::new(), seen)
        }
    }

    /// Whether it is the branch that comes with the program.
    pub fn is_built_in(&self) -> bool {
        self.path.is_none() && self.made.is_none()
    }

    /// The name of the file without its folder; none for the built-in branch.
    pub fn file_name(&self) -> Option<&str> {
        let path = self.path.as_deref()?;
        path.rsplit(['/', '\\']).next()
    }

    /// Whether it is of meshes, not of the points of a scan.
    pub fn is_mesh(&self) -> bool {
        match &*self.content {
            InputContent::Mesh(_) => true,
            InputContent::Cloud(_) => false,
            InputContent::Elsewhere(seen) => seen.unbroken.is_some(),
        }
    }

    /// Whether its vertical is z, as that of scans is; meshes have y up, as in glTF.
    pub fn has_z_up(&self) -> bool {
        match &*self.content {
            InputContent::Mesh(_) => false,
            InputContent::Cloud(_) => true,
            InputContent::Elsewhere(seen) => seen.has_z_up,
        }
    }

    /// What titles and menus call it.
    pub fn title(&self) -> &str {
        let own = match self.made {
            Some(_) => "simulated stem",
            None => "built-in branch",
        };
        self.file_name().unwrap_or(own)
    }
}
