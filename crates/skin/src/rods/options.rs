//! Options of a skin.

use greenstick_schema::{Unit, choice, choices, count, flag, number, parameters};

choices! {
    /// The outline of a skin's section.
    pub enum Outline {
        /// The stem's own contour, on the bark of its mesh.
        Contour = "contour",
        /// The convex hull of the rods, with a margin of half the distance between rods (Sutherland 2012 §5.1.1).
        Hull = "hull",
    }
}

parameters! {
    /// Options of a skin.
    pub struct RodSkinOptions {
        "Skin", "skin" {
            /// Approximate number of fibre bundles that each rod is split into; 1 for the rod's own cell.
            fibres: u32 = 4, count(1, 1000).logarithmic();
            /// Length of splinters over that of shear lag; 0 for flat ends at the broken vertices.
            splinters: f64 = 1.0, number(Unit::One, 0.0, 100.0);
            /// Slabs along the grain for each edge of a rod.
            slabs: f64 = 2.0, number(Unit::One, 0.25, 64.0).logarithmic();
            /// Keep the faces between bonded rods, so that every rod's mesh is closed by itself.
            keep_inner: bool = false, flag();
            /// Outline of the section.
            outline: Outline = Outline::Contour, choice(Outline::CHOICES);
        }
    }
    other {
        /// Seed of all random numbers.
        seed: u64 = 1;
    }
}
