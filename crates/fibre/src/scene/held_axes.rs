//! The directions in which a clamp holds the wood.

use greenstick_schema::text_field;
use std::fmt;
use std::str::FromStr;

const NAMES: [char; 3] = ['x', 'y', 'z'];

/// The directions in which a clamp holds the wood: for x, y and z whether it does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HeldAxes(pub [bool; 3]);

impl HeldAxes {
    /// All three.
    pub const ALL: HeldAxes = HeldAxes([true; 3]);
}

/// A text that names no directions.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0:?} does not name directions; expected one or more of x, y and z")]
pub struct HeldAxesError(String);

impl FromStr for HeldAxes {
    type Err = HeldAxesError;

    fn from_str(text: &str) -> Result<Self, HeldAxesError> {
        if text.is_empty() || text.chars().any(|c| !NAMES.contains(&c)) {
            return Err(HeldAxesError(text.to_owned()));
        }
        Ok(HeldAxes(NAMES.map(|name| text.contains(name))))
    }
}

impl fmt::Display for HeldAxes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, held) in NAMES.iter().zip(self.0) {
            if held {
                write!(f, "{name}")?;
            }
        }
        Ok(())
    }
}

text_field! {
    HeldAxes, "AXES", |axes| axes.to_string();
    /// One or more of x, y and z.
    pub const HELD_AXES
}
