//! The names and the order of the stages of a break.

/// The stages of a break, in the order in which each is made from the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BreakStage {
    /// The scene that is broken.
    Input,
    /// The stem in it, brought to grain space.
    Stem,
    /// The fibre bundles of the section.
    Layout,
    /// The heights of the fracture surface.
    Heights,
    /// The stem cut along it: what is drawn.
    Cut,
    /// Separate pieces, and the scene with its materials and textures: what files hold.
    Finish,
}

impl BreakStage {
    /// All stages in their order.
    pub const ALL: [BreakStage; 6] = [
        BreakStage::Input,
        BreakStage::Stem,
        BreakStage::Layout,
        BreakStage::Heights,
        BreakStage::Cut,
        BreakStage::Finish,
    ];

    /// Returns the stage's name, as progress and tables show it.
    pub const fn name(self) -> &'static str {
        match self {
            BreakStage::Input => "input",
            BreakStage::Stem => "stem",
            BreakStage::Layout => "layout",
            BreakStage::Heights => "heights",
            BreakStage::Cut => "cut",
            BreakStage::Finish => "finish",
        }
    }
}
