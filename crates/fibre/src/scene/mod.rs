//! Scenes: a TOML file that says what the wood is, how it is held, which loads act on it, and what is recorded.
//!
//! Positions along the stem are fractions of its length from its base. The scene's axes are those of the stem: x from the
//! middle of its base to that of its end, z up. Lengths carry their unit, angles are in degrees, everything else is in SI
//! units.
//!
//! [`Scene::read`] reads a scene, [`Scene::built_in`] returns one that comes with the crate, and [`assemble`] puts a bundle
//! into it.
//!
//! ```
//! use greenstick_fibre::scene::Scene;
//!
//! let scene = Scene::read("duration = 0.5\n[wood]\nspecies = \"white oak\"\n[[clamp]]\nto = 0.1")?;
//! assert_eq!((scene.wood.species.as_str(), scene.clamp.len()), ("white oak", 1));
//! let error = Scene::read("durration = 3").unwrap_err().to_string();
//! assert_eq!(error, "line 1, column 1: unknown parameter \"durration\"; did you mean \"duration\"?");
//! # Ok::<(), greenstick_fibre::SceneError>(())
//! ```

mod arc;
mod assemble;
mod built_in;
mod choices;
mod error;
mod former_keys;
mod held_axes;
mod keys;
mod read;
mod reference;
mod scale;
mod start;

pub use assemble::{AssembledScene, assemble};
pub use built_in::{BUILT_IN, BuiltIn};
pub use choices::{
    ArrangementChoice, BondCriterionChoice, MotionChoice, NeighbourChoice, ShapeChoice,
    SolverChoice, StemChoice, TwistChoice, UpChoice,
};
pub use error::SceneError;
pub use held_axes::{HELD_AXES, HeldAxes, HeldAxesError};
pub(crate) use keys::STEM_LENGTHS;
pub use keys::{
    BodyKeys, ClampKeys, ContactKeys, FailureKeys, ForceKeys, KeyFrame, LoadKeys, RodKeys, Scene,
    StartKeys, StemKeys, WoodKeys,
};
