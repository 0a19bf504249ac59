//! Parts of a sweep, which several processes or machines make in one folder.

use std::str::FromStr;

/// What the names of the journals of parts begin and end with.
const PREFIX: &str = "journal-";
const SUFFIX: &str = ".jsonl";

/// A part of a sweep: of every so many variants one.
///
/// ```
/// use greenstick_sweep::Part;
///
/// let second: Part = "2/3".parse()?;
/// let variants: Vec<u64> = (0..8).filter(|variant| second.contains(*variant)).collect();
/// assert_eq!(variants, [1, 4, 7]);
/// assert_eq!(second.count(8), 3);
/// let error = "4/3".parse::<Part>().unwrap_err();
/// assert_eq!(error.to_string(), "expected the number of a part and how many there are, such as 1/8");
/// # Ok::<(), greenstick_sweep::part::PartError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// Its number, from 1.
    number: u64,
    /// How many there are.
    of: u64,
}

/// A text that names no part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected the number of a part and how many there are, such as 1/8")]
pub struct PartError;

impl FromStr for Part {
    type Err = PartError;

    fn from_str(text: &str) -> Result<Self, PartError> {
        let (number, of) = text.split_once('/').ok_or(PartError)?;
        let read = |text: &str| text.trim().parse::<u64>().map_err(|_| PartError);
        let (number, of) = (read(number)?, read(of)?);
        if (1..=of).contains(&number) {
            Ok(Part { number, of })
        } else {
            Err(PartError)
        }
    }
}

impl Part {
    /// Whether a variant is in it.
    pub fn contains(self, variant: u64) -> bool {
        variant % self.of == self.number - 1
    }

    /// How many of all variants are in it.
    pub fn count(self, all: u64) -> u64 {
        all / self.of + u64::from(all % self.of >= self.number)
    }

    /// The name of its journal.
    pub(crate) fn journal_file(self) -> String {
        format!("{PREFIX}{:06}-of-{:06}{SUFFIX}", self.number, self.of)
    }
}

/// Whether a file is the journal of a part.
pub(crate) fn is_part_file(name: &str) -> bool {
    name.starts_with(PREFIX) && name.ends_with(SUFFIX)
}
