//! A project as it is written: a recipe, and after it, in comments, what only the studio needs.

use super::photograph::Overlay;
use crate::view::camera::Camera;
use glam::{DVec3, Vec3};
use greenstick::RequestFile;
use greenstick::schema::{
    Kind, Unit, count, flag, list, number, parameters, read_toml, write_toml,
};
use greenstick::wood::rings::MAX_RINGS;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Largest coordinate of what is looked at, m.
const FAR: f64 = 1e7;

parameters! {
    /// From where the stem is seen.
    pub struct SavedView {
        "View", "view" {
            /// Whether a view was saved.
            saved: bool = false, flag();
            /// The point that is looked at.
            x: f64 = 0.0, number(Unit::One, -FAR, FAR);
            /// Its second coordinate.
            y: f64 = 0.0, number(Unit::One, -FAR, FAR);
            /// Its third coordinate.
            z: f64 = 0.0, number(Unit::One, -FAR, FAR);
            /// Distance from it.
            distance: f64 = 1.0, number(Unit::One, 0.0, FAR).above();
            /// Turn about the vertical.
            yaw: f64 = 0.0, number(Unit::One, -FAR, FAR);
            /// How steeply it looks down.
            pitch: f64 = 0.0, number(Unit::One, -2.0, 2.0);
            /// Whether there is no perspective.
            parallel: bool = false, flag();
            /// Whether z is up and not y.
            z_up: bool = false, flag();
        }
    }
}

/// The number of a ring, from 1 at the pith.
const RING: Kind = count(1, MAX_RINGS as i128).kind;

parameters! {
    /// What was done with the rings of the request.
    pub struct SavedRings {
        "Rings", "rings" {
            /// Rings that were dragged to where they are.
            pinned: Vec<u32> = Vec::new(), list(&RING, 0, MAX_RINGS);
        }
    }
}

impl SavedRings {
    /// Those of pins, from 0.
    pub fn new(pins: &BTreeSet<usize>) -> Self {
        SavedRings {
            pinned: pins.iter().map(|p| *p as u32 + 1).collect(),
        }
    }

    /// The pins, from 0.
    pub fn pins(&self) -> BTreeSet<usize> {
        self.pinned.iter().map(|n| *n as usize - 1).collect()
    }
}

parameters! {
    /// What only the studio needs of a project.
    pub struct StudioFile {
        "Studio", "studio" {
            /// The form of these lines.
            version: f64 = 1.0, number(Unit::One, 1.0, 1.0);
        }
    }
    tables {
        /// The photograph of a real break.
        photograph: Overlay = Overlay::default();
        /// From where the stem is seen.
        view: SavedView = SavedView::default();
        /// What was done with the rings.
        rings: SavedRings = SavedRings::default();
    }
}

impl SavedView {
    /// That of a camera, in a scene whose middle is at `middle`.
    pub fn new(camera: &Camera, middle: DVec3) -> Self {
        let [x, y, z] = (camera.target.as_dvec3() + middle).to_array();
        SavedView {
            saved: true,
            x,
            y,
            z,
            distance: camera.distance.into(),
            yaw: camera.yaw.into(),
            pitch: camera.pitch.into(),
            parallel: camera.parallel,
            z_up: camera.z_up,
        }
    }

    /// The camera; none where no view was saved.
    pub fn camera(&self, middle: DVec3) -> Option<Camera> {
        let target: Vec3 = (DVec3::new(self.x, self.y, self.z) - middle).as_vec3();
        self.saved.then_some(Camera {
            target,
            distance: self.distance as f32,
            yaw: self.yaw as f32,
            pitch: self.pitch as f32,
            parallel: self.parallel,
            z_up: self.z_up,
        })
    }
}

/// Begins each line that only the studio reads. To readers of recipes it is a comment.
const MARK: &str = "#studio ";

/// A project as it is written.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ProjectFile {
    /// The request; its key `input` names what is broken.
    pub request: RequestFile,
    /// What only the studio needs.
    pub studio: StudioFile,
    /// A stem that has no file yet, as GLB: it is written beside the project.
    pub stem: Option<Arc<Vec<u8>>>,
}

impl From<RequestFile> for ProjectFile {
    fn from(request: RequestFile) -> Self {
        ProjectFile {
            request,
            studio: StudioFile::default(),
            stem: None,
        }
    }
}

impl ProjectFile {
    /// The path of the stem that is written beside a project at `path`.
    pub fn stem_path(path: &str) -> String {
        let base = path.strip_suffix(".toml").unwrap_or(path);
        let base = base.strip_suffix(".greenstick").unwrap_or(base);
        format!("{base}_stem.glb")
    }

    /// Reads a project or a recipe.
    ///
    /// # Errors
    /// What is wrong with it, and where.
    pub fn read(text: &str) -> Result<Self, String> {
        let request = RequestFile::resolve(&[], Some(text), &[]).map_err(|e| e.to_string())?;
        // Other lines become empty, so that errors name lines of the file.
        let own: Vec<&str> = text
            .lines()
            .map(|line| line.strip_prefix(MARK).unwrap_or_default())
            .collect();
        let mut studio = StudioFile::default();
        read_toml(&mut studio, &own.join("\n")).map_err(|e| e.to_string())?;
        Ok(ProjectFile {
            request,
            studio,
            stem: None,
        })
    }

    /// Writes it: the recipe with every value, and what only the studio needs where there is anything.
    pub fn to_toml(&self) -> String {
        let mut text = self.request.to_toml();
        if self.studio == StudioFile::default() {
            return text;
        }
        text.push_str(
            "\n# What only the studio reads: the photograph, the view of it, and the rings that were dragged.\n",
        );
        for line in write_toml(&self.studio).lines().filter(|l| !l.is_empty()) {
            text.push_str(MARK);
            text.push_str(line);
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_project_with_a_photograph_is_a_recipe_still() {
        let mut file = ProjectFile::from(
            RequestFile::resolve(&["brash"], Some("[[breaks]]\nat = 0.3\n"), &[]).unwrap(),
        );
        assert!(!file.to_toml().contains("studio"));
        file.studio.photograph.file = Some("täg \"x\"/a b.jpg".to_owned());
        file.studio.photograph.turn = -12.5;
        file.studio.photograph.beside = true;
        file.studio.rings = SavedRings::new(&BTreeSet::from([0, 6]));
        let camera = Camera {
            target: Vec3::new(0.25, -0.5, 2.0),
            yaw: 9.5,
            ..Camera::default()
        };
        let middle = DVec3::new(4.0, 0.0, -1.0);
        file.studio.view = SavedView::new(&camera, middle);
        let text = file.to_toml();
        assert_eq!(ProjectFile::read(&text).unwrap(), file);
        assert_eq!(file.studio.view.camera(middle), Some(camera));
        // What reads recipes reads the same request.
        let recipe = RequestFile::resolve(&[], Some(&text), &[]).unwrap();
        assert_eq!(recipe, file.request);
        let wrong = text.replace("#studio turn = -12.5", "#studio turn = 720");
        let line = 1 + text
            .lines()
            .position(|l| l.contains("turn = -12.5"))
            .unwrap();
        let message = ProjectFile::read(&wrong).unwrap_err();
        assert!(message.contains(&format!("line {line},")), "{message}");
        assert!(message.contains("turn is 720"), "{message}");
    }
}
