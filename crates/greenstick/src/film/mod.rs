//! The skin of a simulated run: stills and films of it (Sutherland 2012 §5).
//!
//! [`Run::open`] takes a run that was recorded; [`Run::still`] gives one frame as a scene, in pieces as they are then, and
//! [`Run::film`] all frames as one skinned film, in the pieces that the last frame leaves. Both are in metres with y up.

mod carried;
mod collision;
mod error;
mod level;
mod make_film;
mod make_still;
mod material_numbers;
mod materials;
mod motion;
mod opening;
mod options;
mod parameters;
mod pieces;
mod poses;
mod report;
mod rest;
mod rigid;
mod run;
mod series;
mod skinned_film;

pub use collision::{Collision, CollisionPiece, collision};
pub use error::FilmError;
pub use level::{LevelReport, level};
pub use make_still::Still;
pub use motion::RunMotion;
pub use options::FilmOptions;
pub use parameters::FilmParameters;
pub use report::{CarriedPiece, FilmPiece, GapeReport, RestReport, SkinReport};
pub use run::Run;
pub use skinned_film::SkinnedFilm;
