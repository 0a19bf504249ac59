//! The skin of a simulated run from its recording to its files (Sutherland 2012 §5).
//!
//! [`open_run`] grows the wood of a recorded run again, [`picture_of_run`] takes pictures of its stills and films, and
//! [`write_series`] writes it for ParaView. What is made of a run is in [`greenstick_skin::film`].

mod drawn;
mod error;
mod open;
mod series;

pub use drawn::{DrawnFilm, film_of_faces};
pub use error::FilmError;
pub use open::{open_run, picture_of_run};
pub use series::write_series;
