//! Breaks as programs ask for them: from files, one or by the thousand.
//!
//! [`input`] loads what a request breaks: the meshes of a file, or the bark of a scanned stem. [`keys`] finds parameters by the
//! keys that people write. [`shown`] makes stills and films of recorded runs.
//!
//! A [`Sweep`] breaks, simulates or bends wood often, with parameters that vary. It knows every variant by its number alone
//! ([`plan`], [`variant`]), so that variants can be made in any order, by any number of threads, and again. A [`Worker`] makes
//! one ([`worker`]); a [`Journal`] keeps what came of each ([`journal`], [`figures`]); a table and a contact sheet are made of
//! the journal ([`table`], [`sheet`]). A [`Run`] does all that with several threads ([`run`]); several processes make the parts of
//! a sweep ([`part`]), as render farms do by a job ([`job`]). The variants of a [`forest`] are the trees of one scene, which is
//! written with the pieces of those that broke ([`forest_scene`]).
#![deny(missing_docs)]

pub mod axis;
mod error;
pub mod figures;
pub mod forest;
pub mod forest_scene;
pub mod input;
pub mod job;
pub mod journal;
pub mod keys;
mod making;
pub mod part;
pub mod plan;
pub mod run;
pub mod sheet;
pub mod shown;
pub mod sobol;
pub mod table;
mod trials;
pub mod variant;
pub mod worker;

pub use error::SweepError;
pub use forest::Forest;
pub use input::{Input, InputError};
pub use journal::{Journal, Record};
pub use part::Part;
pub use plan::{Sweep, SweepSettings};
pub use run::Run;
pub use variant::Variant;
pub use worker::Worker;
