//! Why a mesh cannot be cut.

use glam::DVec3;
use greenstick_geometry::Cancelled;

/// Why a mesh could not be cut. Places are grain coordinates (x, y, s) in m; callers map them to the world.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CutError {
    /// The layout does not reach beyond the skin.
    #[error("the skin reaches beyond the break surface near {at:.5} (grain coordinates, m)")]
    OffLayout {
        /// Where.
        at: DVec3,
    },
    /// The outline on a triangle of the skin does not close.
    #[error(
        "the break's outline on triangle {triangle} does not close near {at:.5} (grain coordinates, m)"
    )]
    Outline {
        /// The triangle.
        triangle: u32,
        /// Where.
        at: DVec3,
    },
    /// A broken face cannot be closed: the skin has a hole or is not a manifold there.
    #[error(
        "the broken face cannot be closed near {at:.5} (grain coordinates, m): the mesh has a hole or is not a manifold there"
    )]
    Face {
        /// Where.
        at: DVec3,
    },
    /// The surface does not meet the skin.
    #[error("the break surface does not meet the mesh")]
    Misses,
    /// Both sides of the cut are joined elsewhere.
    #[error(
        "the two sides of the break are joined elsewhere by the mesh (at triangle {triangle}), so the cut would not part it"
    )]
    Joined {
        /// A triangle that belongs to both sides.
        triangle: u32,
    },
    /// The caller cancelled.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
