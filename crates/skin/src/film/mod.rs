//! Stills and films of a simulated run: the skin of its rods through time (Sutherland 2012 §5).
//!
//! [`Run::new`] takes a run that was recorded, and the wood that it was made of. [`Run::still`] gives one frame as a scene, in
//! pieces as they are then, [`Run::at_rest`] the same pieces where they fit each other, and [`Run::film`] all frames as
//! one skinned film, in the pieces that the last frame leaves. [`Run::film_of_faces`] moves the mesh that was simulated, cut
//! along the faces that the run decided, as the rods do. Stills and films are in metres with y up. [`level`] makes levels of
//! detail of a film, [`collision`] collision shapes of its pieces.

mod carried;
mod collision;
mod drawn;
mod error;
mod frame_range;
mod level;
mod lines;
mod make_film;
mod make_still;
mod material_numbers;
mod materials;
mod motion;
mod nearby_rods;
mod options;
mod parameters;
mod part_still;
mod placement;
mod poses;
mod report;
mod rest;
mod rigid;
mod run;
mod separation;
mod skinned_film;
mod tracking;

pub use collision::{Collision, CollisionPiece, collision};
pub use drawn::DrawnScene;
pub use error::FilmError;
pub use frame_range::{FRAME_RANGE, FrameRange, FrameRangeError};
pub use level::{LevelReport, level};
pub use lines::{BondLines, RodLines};
pub use make_still::Still;
pub use motion::RunMotion;
pub use nearby_rods::{NearbyRods, shows_well};
pub use options::FilmOptions;
pub use parameters::FilmParameters;
pub use report::{CarriedPiece, FilmPiece, GapeReport, RestReport, SkinReport};
pub use run::{Run, RunWood};
pub use skinned_film::SkinnedFilm;
