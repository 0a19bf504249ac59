//! Fields of the wood that its skin can show.

/// A field of the wood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WoodField {
    /// Strain along the grain over that at failure: 1 where it tears, −1 where it is crushed.
    Strain,
    /// Share of the bonds that are broken, 0 to 1; 1 where the rod is.
    Damage,
}

impl WoodField {
    /// The name of the attribute that holds it.
    pub fn attribute(self) -> &'static str {
        match self {
            WoodField::Strain => "_STRAIN",
            WoodField::Damage => "_DAMAGE",
        }
    }
}
