//! Scenes that come with the program.

use super::{Scene, SceneError};
use greenstick_schema::closest_names;

/// A scene that comes with the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BuiltIn {
    /// Its name.
    pub name: &'static str,
    /// Its file.
    pub text: &'static str,
}

/// Scenes by their names, which are those of their files.
macro_rules! built_in {
    ($($name:literal),+) => {
        &[$(BuiltIn {
            name: $name,
            text: include_str!(concat!("../../scenes/", $name, ".toml")),
        }),+]
    };
}

/// All of them.
pub const BUILT_IN: &[BuiltIn] = built_in![
    "oscillation",
    "three-blocks",
    "bend",
    "twist",
    "pull",
    "fall",
    "snow"
];

impl BuiltIn {
    /// The scene.
    ///
    /// # Errors
    /// None for those that come with the program; a test reads them all.
    pub fn scene(&self) -> Result<Scene, SceneError> {
        Scene::read(self.text)
    }
}

impl Scene {
    /// The built-in scene of a name.
    ///
    /// # Errors
    /// [`SceneError::UnknownScene`] with the names that look like it.
    pub fn built_in(name: &str) -> Result<Scene, SceneError> {
        match BUILT_IN.iter().find(|b| b.name == name) {
            Some(found) => found.scene(),
            None => Err(SceneError::UnknownScene {
                name: name.to_owned(),
                nearest: closest_names(name, BUILT_IN.iter().map(|b| b.name)),
            }),
        }
    }
}
