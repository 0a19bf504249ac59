//! A range of the frames of a run, as people write it.

use greenstick_schema::text_field;
use std::ops::Range;
use std::str::FromStr;

/// Frames of a run, from the first to before the last.
///
/// ```
/// use greenstick_skin::film::FrameRange;
///
/// assert_eq!("30..60".parse(), Ok(FrameRange { from: 30, to: 60 }));
/// assert_eq!("..2".parse(), Ok(FrameRange { from: 0, to: 2 }));
/// assert!(["7..3", "3", "a..b", "2..2"].iter().all(|text| text.parse::<FrameRange>().is_err()));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameRange {
    /// The first one.
    pub from: usize,
    /// The one after the last.
    pub to: usize,
}

/// A text that is no range of frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected two whole numbers, the first below the second, such as 30..60")]
pub struct FrameRangeError;

impl FromStr for FrameRange {
    type Err = FrameRangeError;

    fn from_str(text: &str) -> Result<Self, FrameRangeError> {
        let (from, to) = text.split_once("..").ok_or(FrameRangeError)?;
        let number = |text: &str| text.parse::<usize>().map_err(|_| FrameRangeError);
        let from = if from.is_empty() { 0 } else { number(from)? };
        let to = number(to)?;
        if from < to {
            Ok(FrameRange { from, to })
        } else {
            Err(FrameRangeError)
        }
    }
}

impl From<FrameRange> for Range<usize> {
    fn from(range: FrameRange) -> Self {
        range.from..range.to
    }
}

text_field! {
    FrameRange, "FROM..TO", |range| format!("{}..{}", range.from, range.to);
    /// A range of frames.
    pub const FRAME_RANGE
}
