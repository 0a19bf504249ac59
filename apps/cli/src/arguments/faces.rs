//! The faces of simulated breaks.

use clap::ValueEnum;
use greenstick_sweep::shown::Faces;

/// What the faces of a simulated break are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FacesChoice {
    #[value(help = "the mesh itself, cut where rods broke, in fibres finer than rods")]
    Drawn,
    #[value(help = "prisms about the rods, as in Sutherland's thesis")]
    Rods,
}

impl From<FacesChoice> for Faces {
    fn from(choice: FacesChoice) -> Self {
        match choice {
            FacesChoice::Drawn => Faces::Drawn,
            FacesChoice::Rods => Faces::Rods,
        }
    }
}
