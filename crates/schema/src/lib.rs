//! Parameters, declared once.
//!
//! A declaration gives a parameter's key, type, unit, range, default, scale, choices, the stage of the work that it
//! changes, and its documentation. Struct field, default, range check, reading from text and TOML, writing, JSON Schema
//! and reference page all follow from it.
//!
//! ```
//! use greenstick_schema::{Parameters, Unit, count, length, number, parameters};
//!
//! parameters! {
//!     /// A plank.
//!     pub struct Plank {
//!         "size", "cut" {
//!             /// Length of the plank.
//!             length: f64 = 2.0, length(0.01, 20.0);
//!             /// Slope of its grain.
//!             slope: f64 = 0.0, number(Unit::Degree, 0.0, 90.0).symbol("α");
//!             /// Planks in a stack.
//!             number: u32 = 12, count(1, 1000);
//!         }
//!     }
//! }
//!
//! let mut plank = Plank::default();
//! plank.set_text("length", "180 cm")?;
//! assert_eq!(plank.length, 1.8);
//! let error = plank.set_text("slope", "91").unwrap_err();
//! assert_eq!(error.to_string(), "slope is 91, but it must be from 0 to 90 °");
//! greenstick_schema::read_toml(&mut plank, "number = 7\nlength = \"2.5 m\"\n").unwrap();
//! assert_eq!((plank.number, plank.length), (7, 2.5));
//! # Ok::<(), greenstick_schema::ParameterError>(())
//! ```
#![deny(missing_docs)]

mod declaration;
mod declare;
mod document;
mod error;
mod field;
mod hash;
mod info;
mod json_schema;
mod parameters;
mod reference;
mod spelling;
mod unit;
mod value;

pub use declaration::{
    Choice, Declaration, FILE_NAME, Format, Kind, Scale, choice, count, flag, length, list, number,
    text,
};
pub use document::{
    DocumentError, Problem, line_and_column, read_table, read_toml, read_toml_with_former_keys,
    syntax_error, write_toml,
};
pub use error::ParameterError;
pub use field::Field;
pub use hash::content_hash;
pub use info::{ListInfo, ParameterInfo};
pub use json_schema::{document_schema, object_schema};
pub use parameters::Parameters;
pub use reference::markdown_tables;
pub use spelling::{MAX_SUGGESTIONS, MIN_SIMILARITY, closest_names, did_you_mean, normalise};
pub use unit::{LengthError, Unit, parse_length};
pub use value::Value;

/// What the macros of this crate expand to; not for use elsewhere.
#[doc(hidden)]
pub mod macro_support {
    pub use crate::declare::{heading, join, paragraph, subscript};
}
