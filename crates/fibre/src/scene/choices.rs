//! The words of a scene file.

use crate::solvers::{Explicit, Implicit, Interactive, QuasiStatic, Solver};
use greenstick_schema::choices;

choices! {
    /// Where the stem comes from.
    pub enum StemChoice {
        /// The built-in branch.
        Branch = "branch",
        /// A straight round stem.
        Cylinder = "cylinder",
        /// A board.
        Board = "board",
        /// The mesh that is given with the scene.
        Input = "input",
    }
    /// The axis of an input that points up.
    pub enum UpChoice {
        /// y, as glTF has it.
        Y = "y",
        /// z, as surveys have it.
        Z = "z",
    }
    /// How rods are arranged in a cross-section.
    pub enum ArrangementChoice {
        /// A Poisson disk sample, as in the thesis.
        PoissonDisk = "poisson-disk",
        /// By ring and sector.
        Anatomy = "anatomy",
    }
    /// Which rods are bonded.
    pub enum NeighbourChoice {
        /// Rods whose cells meet in a facet.
        Facets = "facets",
        /// All rods within reach of each other, as in the thesis.
        WithinReach = "within-reach",
    }
    /// Whether rods resist twist.
    pub enum TwistChoice {
        /// Only where rods are curved.
        Auto = "auto",
        /// Always.
        On = "on",
        /// Never, as in the thesis; rods must be straight.
        Off = "off",
    }
    /// The solver.
    pub enum SolverChoice {
        /// Symplectic Euler, the reference.
        Explicit = "explicit",
        /// Steps of animation at real stiffness, solved accurately.
        Implicit = "implicit",
        /// One step per frame at real stiffness.
        Interactive = "interactive",
        /// One equilibrium after another, without inertia.
        QuasiStatic = "quasi-static",
    }
    /// When bonds break.
    pub enum BondCriterionChoice {
        /// Never.
        Never = "never",
        /// At a threshold of energy, as in the thesis.
        Potential = "potential",
        /// At the fracture energy of their facet.
        Griffith = "griffith",
        /// At the strength of their facet.
        Stress = "stress",
        /// By softening from the strength of their facet on, until its energy of fracture is spent.
        Cohesive = "cohesive",
    }
    /// The shape of a body.
    pub enum ShapeChoice {
        /// Everything below a plane, whose normal is the body's z.
        HalfSpace = "half-space",
        /// A box of the given size.
        Box = "box",
        /// A ball of the given diameter.
        Sphere = "sphere",
        /// A cylinder with round ends along the body's y.
        Capsule = "capsule",
        /// A cylinder along the body's y.
        Cylinder = "cylinder",
        /// A wedge of the given size, whose edge is along y and points to −x.
        Wedge = "wedge",
        /// The hull of a mesh file's vertices.
        Hull = "hull",
        /// A closed mesh file.
        Mesh = "mesh",
    }
    /// The motion of a body.
    pub enum MotionChoice {
        /// Prescribed: it stays, or moves by its velocity or key frames.
        Given = "given",
        /// Free.
        Free = "free",
    }
}

impl SolverChoice {
    /// All solvers.
    pub const ALL: [SolverChoice; 4] = [
        SolverChoice::Explicit,
        SolverChoice::Implicit,
        SolverChoice::Interactive,
        SolverChoice::QuasiStatic,
    ];

    /// Returns how far its velocities lag behind positions, in steps: those of symplectic Euler belong to the middle of the last
    /// step.
    pub fn velocity_lag(self) -> f64 {
        if self == SolverChoice::Explicit {
            0.5
        } else {
            0.0
        }
    }

    /// Returns the solver, with a step (s) where one is given.
    pub fn make(self, step: Option<f64>) -> Box<dyn Solver> {
        match self {
            SolverChoice::Explicit => Box::new(Explicit::new(step)),
            SolverChoice::Implicit => Box::new(Implicit::new(step)),
            SolverChoice::Interactive => Box::new(Interactive::new(step)),
            SolverChoice::QuasiStatic => Box::new(QuasiStatic::stateless(step)),
        }
    }
}
