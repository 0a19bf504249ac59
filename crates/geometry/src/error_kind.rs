//! Kinds of errors.

/// Who can do something about an error. Every error of the libraries that reaches a caller has a kind: programs choose an
/// exit code or a status by it, and never by the variants or the text of an error.
///
/// ```
/// use greenstick_geometry::ErrorKind;
/// use greenstick_geometry::cloud::CleanError;
///
/// assert_eq!(CleanError::TooMany(1 << 40).kind(), ErrorKind::Request);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ErrorKind {
    /// The caller stopped the work.
    Cancelled,
    /// The request or its input is wrong: something in it must change.
    Request,
    /// The request is valid, but the work failed.
    Work,
}
