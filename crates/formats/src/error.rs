//! Errors of reading and writing files. Every message says where, what was found, and what would be right.

use greenstick_geometry::text::one_line;

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// The file is empty.
    #[error("{file}: the file is empty; expected a {format} file with at least one triangle", file = one_line(.file))]
    Empty {
        /// Name of the file.
        file: String,
        /// Name of the format.
        format: &'static str,
    },
    /// The content does not have the format.
    #[error("{file}: not a {format} file: {found}; expected {right}", file = one_line(.file), found = one_line(.found))]
    NotThisFormat {
        /// Name of the file.
        file: String,
        /// Name of the format.
        format: &'static str,
        /// What was found.
        found: String,
        /// What would be right.
        right: String,
    },
    /// An element violates the format.
    #[error("{file}: {place}: {found}; expected {right}", file = one_line(.file), place = one_line(.place), found = one_line(.found))]
    Malformed {
        /// Name of the file.
        file: String,
        /// The element or line.
        place: String,
        /// What was found.
        found: String,
        /// What would be right.
        right: String,
    },
    /// The data end within an element.
    #[error("{file}: {place}: the data end too early, {found}; expected {right} (is the file truncated?)", file = one_line(.file), place = one_line(.place), found = one_line(.found))]
    Truncated {
        /// Name of the file.
        file: String,
        /// The element or line.
        place: String,
        /// What was found.
        found: String,
        /// What would be right.
        right: String,
    },
    /// A count exceeds what the file can hold. No memory is allocated for it.
    #[error("{file}: {element} claims {claimed} entries, but the {available} bytes there are hold at most {possible}; \
         expected a count that matches the data", file = one_line(.file), element = one_line(.element))]
    CountTooLarge {
        /// Name of the file.
        file: String,
        /// The element.
        element: String,
        /// Number of entries that it claims.
        claimed: u64,
        /// Largest possible number.
        possible: u64,
        /// Bytes available.
        available: u64,
    },
    /// A coordinate is not finite.
    #[error("{file}: {element}: vertex {vertex} has the coordinate {value}; expected finite numbers", file = one_line(.file), element = one_line(.element))]
    NotFinite {
        /// Name of the file.
        file: String,
        /// The element that contains the vertex.
        element: String,
        /// Number of the vertex in that element, from 0.
        vertex: usize,
        /// The coordinate.
        value: f64,
    },
    /// A face refers to a vertex that does not exist.
    #[error("{file}: {element}: face {face} refers to vertex {index}; expected an index into a list of {count}", file = one_line(.file), element = one_line(.element))]
    IndexOutOfRange {
        /// Name of the file.
        file: String,
        /// The element that contains the face, and how vertices are counted.
        element: String,
        /// Number of the face in that element, from 0.
        face: usize,
        /// The index in the file.
        index: i64,
        /// Number of entries of the list.
        count: usize,
    },
    /// The file has points, but no faces.
    #[error("{file}: contains {points} points and no faces; expected a mesh with faces", file = one_line(.file))]
    PointCloud {
        /// Name of the file.
        file: String,
        /// Number of points.
        points: usize,
    },
    /// The file has no triangles.
    #[error("{file}: contains no triangles; expected a mesh with faces", file = one_line(.file))]
    NoTriangles {
        /// Name of the file.
        file: String,
    },
    /// A feature of the format that is not supported.
    #[error("{file}: uses {feature}, which is not supported; {right}", file = one_line(.file), feature = one_line(.feature))]
    Unsupported {
        /// Name of the file.
        file: String,
        /// The feature.
        feature: String,
        /// What to do instead.
        right: String,
    },
    /// A companion file cannot be read.
    #[error("{file}: refers to {companion}, which cannot be read ({source}); expected that file beside {file}", file = one_line(.file), companion = one_line(.companion))]
    Companion {
        /// Name of the file.
        file: String,
        /// The reference in the file.
        companion: String,
        /// Why.
        source: std::io::Error,
    },
    /// The scene is invalid, or the format cannot represent it.
    #[error("{file}: cannot be written: {found}; expected {right}", file = one_line(.file), found = one_line(.found))]
    Unwritable {
        /// Name of the file.
        file: String,
        /// What is in the scene.
        found: String,
        /// What would be right.
        right: String,
    },
}

/// A file for messages: creates errors with its name.
#[derive(Clone, Copy)]
pub(crate) struct InFile<'a>(pub &'a str);

impl InFile<'_> {
    pub fn malformed(
        self,
        place: impl ToString,
        found: impl ToString,
        right: impl ToString,
    ) -> FormatError {
        FormatError::Malformed {
            file: self.0.to_owned(),
            place: place.to_string(),
            found: found.to_string(),
            right: right.to_string(),
        }
    }

    pub fn truncated(
        self,
        place: impl ToString,
        found: impl ToString,
        right: impl ToString,
    ) -> FormatError {
        FormatError::Truncated {
            file: self.0.to_owned(),
            place: place.to_string(),
            found: found.to_string(),
            right: right.to_string(),
        }
    }

    pub fn unsupported(self, feature: impl ToString, right: impl ToString) -> FormatError {
        FormatError::Unsupported {
            file: self.0.to_owned(),
            feature: feature.to_string(),
            right: right.to_string(),
        }
    }

    pub fn unwritable(self, found: impl ToString, right: impl ToString) -> FormatError {
        FormatError::Unwritable {
            file: self.0.to_owned(),
            found: found.to_string(),
            right: right.to_string(),
        }
    }

    /// Refuses a table for a fault that it has.
    pub fn faulty_table(self, fault: String) -> FormatError {
        let right = "columns of equal length with distinct names of letters, digits and _";
        self.unwritable(fault, right)
    }

    /// Refuses `claimed` entries of at least `entry_size` bytes each if `available` bytes cannot hold them.
    pub fn check_count(
        self,
        element: &str,
        claimed: usize,
        entry_size: usize,
        available: usize,
    ) -> Result<(), FormatError> {
        let possible = available / entry_size.max(1);
        if claimed <= possible {
            return Ok(());
        }
        Err(FormatError::CountTooLarge {
            file: self.0.to_owned(),
            element: element.to_owned(),
            claimed: claimed as u64,
            possible: possible as u64,
            available: available as u64,
        })
    }

    /// Refuses coordinates that are NaN or infinite.
    pub fn check_finite(
        self,
        element: impl Fn() -> String,
        positions: &[glam::DVec3],
    ) -> Result<(), FormatError> {
        let Some(vertex) = positions.iter().position(|p| !p.is_finite()) else {
            return Ok(());
        };
        let p = positions[vertex].to_array();
        let value = p.into_iter().find(|v| !v.is_finite()).unwrap_or(f64::NAN);
        Err(FormatError::NotFinite {
            file: self.0.to_owned(),
            element: element(),
            vertex,
            value,
        })
    }
}
