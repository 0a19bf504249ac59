//! Breaks as programs ask for them: from files, one or by the thousand.
//!
//! [`input`] loads what a request breaks: the meshes of a file, or the bark of a scanned stem. [`keys`] finds parameters by the
//! keys that people write.
#![deny(missing_docs)]

pub mod input;
pub mod keys;

pub use input::{Input, InputError};
