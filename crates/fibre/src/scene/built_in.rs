//! Scenes that come with the crate.

use super::error::SceneError;
use super::keys::Scene;
use greenstick_schema::closest_names;

/// A scene that comes with the crate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BuiltIn {
    /// Its name.
    pub name: &'static str,
    /// Its TOML.
    pub text: &'static str,
}

/// Lists scenes by their names, which are those of their files.
macro_rules! built_in {
    ($($name:literal),+) => {
        &[$(BuiltIn {
            name: $name,
            text: include_str!(concat!("../../scenes/", $name, ".toml")),
        }),+]
    };
}

/// All built-in scenes.
pub const BUILT_IN: &[BuiltIn] = built_in![
    "oscillation",
    "three-blocks",
    "bend",
    "twist",
    "pull",
    "strip",
    "fall",
    "falling-trunk",
    "snow",
    "gust",
    "knee",
    "short-beam",
    "green-twig",
    "wedge",
    "as-published"
];

impl BuiltIn {
    /// Reads the scene.
    ///
    /// # Errors
    /// None for those of the crate; a test reads them all.
    pub fn scene(&self) -> Result<Scene, SceneError> {
        Scene::read(self.text)
    }
}

impl Scene {
    /// Returns the built-in scene of a name.
    ///
    /// # Errors
    /// [`SceneError::UnknownScene`] with similar names.
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
