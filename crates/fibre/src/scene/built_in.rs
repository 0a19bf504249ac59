//! Scenes that come with the program.

use super::{Scene, SceneError};
use greenstick_wood::species::nearest;

/// A scene that comes with the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BuiltIn {
    /// Its name.
    pub name: &'static str,
    /// Its file.
    pub text: &'static str,
}

/// All of them.
pub const BUILT_IN: &[BuiltIn] = &[
    BuiltIn {
        name: "oscillation",
        text: include_str!("../../scenes/oscillation.toml"),
    },
    BuiltIn {
        name: "three-blocks",
        text: include_str!("../../scenes/three-blocks.toml"),
    },
    BuiltIn {
        name: "bend",
        text: include_str!("../../scenes/bend.toml"),
    },
    BuiltIn {
        name: "twist",
        text: include_str!("../../scenes/twist.toml"),
    },
    BuiltIn {
        name: "pull",
        text: include_str!("../../scenes/pull.toml"),
    },
    BuiltIn {
        name: "fall",
        text: include_str!("../../scenes/fall.toml"),
    },
    BuiltIn {
        name: "snow",
        text: include_str!("../../scenes/snow.toml"),
    },
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
                nearest: nearest(name, BUILT_IN.iter().map(|b| b.name)),
            }),
        }
    }
}
