//! How a film is written, and what was written.

/// Options of glTF films.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GlbOptions {
    /// Most joints of a skin; `None` for no limit. Of skins with more, the joints whose motion differs least from that of
    /// others are removed, and the vertices that followed them follow a blend of two others.
    pub max_joints: Option<usize>,
    /// Most joints that a vertex follows, 1 to 8. Many viewers support no more than 4.
    pub max_influences: usize,
}

impl Default for GlbOptions {
    fn default() -> Self {
        GlbOptions {
            max_joints: None,
            max_influences: 8,
        }
    }
}

/// A piece that was written with fewer joints or influences than it has.
#[derive(Debug, Clone, PartialEq)]
pub struct Reduction {
    /// Index of the piece in [`Film::pieces`](greenstick_geometry::Film::pieces).
    pub piece: usize,
    /// Its name.
    pub name: String,
    /// Number of joints that it follows, and how many of them were written.
    pub joints: [usize; 2],
    /// Number of vertices that still followed too many joints after the number of joints was reduced.
    pub capped: usize,
    /// Largest error of a vertex position over all frames, m.
    pub error: f64,
    /// The frame with that error.
    pub frame: usize,
}

/// Statistics of a film that was written.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FilmReport {
    /// Length of the file, bytes.
    pub bytes: u64,
    /// Number of frames.
    pub frames: usize,
    /// Number of pieces that follow several joints.
    pub skinned: usize,
    /// Number of pieces and bodies that move rigidly.
    pub rigid: usize,
    /// Total number of joints of all skins.
    pub joints: usize,
    /// Number of values over time (translation or rotation of a node, points of a mesh).
    pub channels: usize,
    /// Number of those that never change.
    pub constant: usize,
    /// Pieces that deviate from the film. Only glTF needs them.
    pub reductions: Vec<Reduction>,
}

impl FilmReport {
    /// Largest error of a vertex position, m.
    pub fn error(&self) -> f64 {
        self.reductions.iter().map(|r| r.error).fold(0.0, f64::max)
    }
}
