//! A message to who uses the window.

use greenstick::wood::stem::StemLocation;

/// A message that stays until it is dismissed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Message {
    /// What it says.
    pub text: String,
    /// Whether something failed.
    pub is_error: bool,
    /// A place of the break that would work.
    pub place: Option<StemLocation>,
    /// Whether it asks for the unit of length in the file.
    pub asks_unit: bool,
}
