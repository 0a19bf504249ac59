//! What can go wrong with a mesh file: every message says where, what was found and what would be right.

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// No bytes at all.
    #[error("{file}: the file is empty; expected a {format} file with at least one triangle")]
    Empty {
        /// Name of the file.
        file: String,
        /// Name of the format.
        format: &'static str,
    },
    /// The content is something else than the name promises.
    #[error("{file}: not a {format} file: {found}; expected {right}")]
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
    /// One element breaks the rules of the format.
    #[error("{file}: {place}: {found}; expected {right}")]
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
    /// The data end before the element does.
    #[error(
        "{file}: {place}: the data end too early, {found}; expected {right} (was the file cut off?)"
    )]
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
    /// A count that the file cannot hold; refused before anything is allocated.
    #[error(
        "{file}: {element} claims {claimed} entries, but there is room for {possible} at most in the {available} bytes there are; \
         expected a count that matches the data"
    )]
    CountTooLarge {
        /// Name of the file.
        file: String,
        /// The element that claims.
        element: String,
        /// How many entries it claims.
        claimed: u64,
        /// How many there could be.
        possible: u64,
        /// Bytes that are left for them.
        available: u64,
    },
    /// A coordinate that is no finite number.
    #[error(
        "{file}: {element}: vertex {vertex} has the coordinate {value}; expected finite numbers"
    )]
    NotFinite {
        /// Name of the file.
        file: String,
        /// The element that holds the vertex.
        element: String,
        /// Number of the vertex in that element, from 0.
        vertex: usize,
        /// The coordinate found.
        value: f64,
    },
    /// A face that names a vertex which does not exist.
    #[error(
        "{file}: {element}: face {face} names vertex {index}; expected a number in a list of {count}"
    )]
    IndexOutOfRange {
        /// Name of the file.
        file: String,
        /// The element that holds the face, with the rule of numbering where there could be doubt.
        element: String,
        /// Number of the face in that element, from 0.
        face: usize,
        /// The number found, as it stands in the file.
        index: i64,
        /// How many entries the list has.
        count: usize,
    },
    /// Points without faces.
    #[error("{file}: holds {points} points and no faces; expected a mesh with faces")]
    PointCloud {
        /// Name of the file.
        file: String,
        /// Number of points.
        points: usize,
    },
    /// Nothing that could be broken.
    #[error("{file}: holds no triangles; expected a mesh with faces")]
    NoTriangles {
        /// Name of the file.
        file: String,
    },
    /// Something the format allows and this reader does not know.
    #[error("{file}: uses {feature}, which is not read; {right}")]
    Unsupported {
        /// Name of the file.
        file: String,
        /// What is used.
        feature: String,
        /// What to do instead.
        right: String,
    },
    /// A file that the main file needs could not be fetched.
    #[error(
        "{file}: refers to {companion}, which cannot be read ({source}); expected that file beside {file}"
    )]
    Companion {
        /// Name of the file.
        file: String,
        /// The reference as it stands in the file.
        companion: String,
        /// Why it could not be fetched.
        source: std::io::Error,
    },
    /// The scene does not fit the format.
    #[error("{file}: cannot be written: {found}; expected {right}")]
    Unwritable {
        /// Name of the file.
        file: String,
        /// What is in the scene.
        found: String,
        /// What would be right.
        right: String,
    },
}

/// Builds errors that name one file.
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

    /// Refuses `claimed` entries of at least `least_size` bytes each where `available` bytes cannot hold them.
    pub fn check_count(
        self,
        element: &str,
        claimed: usize,
        least_size: usize,
        available: usize,
    ) -> Result<(), FormatError> {
        let possible = available / least_size.max(1);
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
