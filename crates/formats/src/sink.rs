//! Destinations of files that are written piece by piece.

use std::io::{Seek, Write};

/// A destination that can be written to at any position.
pub(crate) trait Sink: Write + Seek {}

impl<T: Write + Seek> Sink for T {}
