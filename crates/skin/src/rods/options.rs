//! Options of a skin.

/// Options of a skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RodSkinOptions {
    /// Approximate number of fibre bundles that a rod's cell is split into; 1 for the cell itself.
    pub fibres: u32,
    /// Length of splinters over that of shear lag; 0 for flat ends at the broken vertices, as in the thesis.
    pub splinters: f64,
    /// Slabs for each edge of a rod.
    pub slabs: f64,
    /// Whether to keep faces between bonded rods, so that every rod's mesh is closed by itself.
    pub keep_inner: bool,
    /// The outline of the section.
    pub outline: Outline,
    /// Seed of all random numbers.
    pub seed: u64,
}

/// The outline of a skin's section.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Outline {
    /// The stem's own contour, on the bark of its mesh.
    #[default]
    Contour,
    /// The convex hull of the rods, with a margin of half the distance between rods (Sutherland 2012 §5.1.1).
    Hull,
}

impl Default for RodSkinOptions {
    fn default() -> Self {
        RodSkinOptions {
            fibres: 4,
            splinters: 1.0,
            slabs: 2.0,
            keep_inner: false,
            outline: Outline::Contour,
            seed: 1,
        }
    }
}
