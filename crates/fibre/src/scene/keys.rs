//! The keys of a scene file.

use super::declare::{Declared, KeyInfo, Length, Lengths, Numbers, declared, numbers};
use crate::solvers::{
    Explicit, IMPLICIT_STEP, INTERACTIVE_STEP, Implicit, Interactive, QuasiStatic, Solver,
};
use serde::{Deserialize, Serialize};

/// Declares enums whose values are written as words.
macro_rules! choices {
    ($($(#[doc = $enum_doc:literal])+ pub enum $name:ident {
        $($(#[doc = $doc:literal])+ $variant:ident,)+
    })+) => {
        $($(#[doc = $enum_doc])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum $name { $($(#[doc = $doc])+ $variant,)+ }

        numbers! { $name: _v => Vec::new(); })+
    };
}

choices! {
    /// Where the stem comes from.
    pub enum StemChoice {
        /// The built-in branch.
        Branch,
        /// A straight round stem.
        Cylinder,
        /// A board.
        Board,
        /// The mesh that is given with the scene.
        Input,
    }
    /// How rods are arranged in a cross-section.
    pub enum ArrangementChoice {
        /// A Poisson disk sample, as in the thesis.
        PoissonDisk,
        /// By ring and sector.
        Anatomy,
    }
    /// Whether rods resist twist.
    pub enum TwistChoice {
        /// Only where rods are curved.
        Auto,
        /// Always.
        On,
        /// Never, as in the thesis; rods must be straight.
        Off,
    }
    /// The solver.
    pub enum SolverChoice {
        /// Symplectic Euler, the reference.
        Explicit,
        /// Steps of animation at real stiffness, solved accurately.
        Implicit,
        /// One step per frame at real stiffness.
        Interactive,
        /// One equilibrium after another, without inertia.
        QuasiStatic,
    }
    /// When bonds break.
    pub enum BondCriterionChoice {
        /// Never.
        Never,
        /// At a threshold of energy, as in the thesis.
        Potential,
        /// At the fracture energy of their facet.
        Griffith,
        /// At the strength of their facet.
        Stress,
    }
    /// The shape of a body.
    pub enum ShapeChoice {
        /// Everything below a plane, whose normal is the body's z.
        HalfSpace,
        /// A box of the given size.
        Box,
        /// A ball of the given diameter.
        Sphere,
        /// A cylinder with round ends along the body's y.
        Capsule,
        /// A cylinder along the body's y.
        Cylinder,
        /// The hull of a mesh file's vertices.
        Hull,
        /// A closed mesh file.
        Mesh,
    }
    /// The motion of a body.
    pub enum MotionChoice {
        /// Prescribed: it stays, or moves by its velocity or key frames.
        Given,
        /// Free.
        Free,
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

    /// Returns the solver's name in files.
    pub fn name(self) -> &'static str {
        match self {
            SolverChoice::Explicit => "explicit",
            SolverChoice::Implicit => "implicit",
            SolverChoice::Interactive => "interactive",
            SolverChoice::QuasiStatic => "quasi-static",
        }
    }

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

const INF: f64 = f64::INFINITY;

declared! {
    /// The stem.
    pub struct StemKeys {
        /// What the stem is: branch, cylinder, board or input (a mesh file given with the scene).
        kind: StemChoice = StemChoice::Branch, (-INF, INF, "");
        /// Length; an input has its own.
        length: Length = Length(0.3), (1e-3, 100.0, "m");
        /// Diameter of a branch or cylinder.
        diameter: Length = Length(0.02), (1e-4, 10.0, "m");
        /// Width of a board.
        width: Length = Length(0.02), (1e-4, 10.0, "m");
        /// Thickness of a board.
        thickness: Length = Length(0.02), (1e-4, 10.0, "m");
        /// Where on an input: a fraction of its length (0.4), a length from its base (12cm), or a point (x,y,z).
        at: String = "0.5".to_owned(), (-INF, INF, "");
        /// Part of the length that is filled with rods, from and to.
        part: [f64; 2] = [0.0, 1.0], (0.0, 1.0, "");
    }
}

declared! {
    /// The wood.
    pub struct WoodKeys {
        /// Species, by common or scientific name.
        species: String = "white ash".to_owned(), (-INF, INF, "");
        /// Moisture content.
        moisture: f64 = 12.0, (0.0, 200.0, "% of the dry mass");
        /// Factor on all moduli of elasticity; strains at failure stay the same.
        stiffness: f64 = 1.0, (1e-6, 100.0, "");
    }
}

declared! {
    /// The rods.
    pub struct RodKeys {
        /// Number of rods in a cross-section, where no spacing is given.
        number: u32 = 100, (1.0, 1e6, "");
        /// Distance between rods, instead of their number.
        spacing: Option<Length> = None, (1e-6, 1.0, "m");
        /// How they are arranged in the cross-section: poisson-disk or anatomy.
        arrangement: ArrangementChoice = ArrangementChoice::PoissonDisk, (-INF, INF, "");
        /// Least and greatest length of edges.
        edge: [Length; 2] = [Length(4e-3), Length(6e-3)], (1e-6, 1.0, "m");
        /// Whether rods resist twist: auto, on or off.
        twist: TwistChoice = TwistChoice::Auto, (-INF, INF, "");
        /// Reach of bonds, in mean distances of rods.
        reach: f64 = 2.5, (1.0, 5.0, "");
        /// Weibull modulus of the scatter of strength; without it there is none.
        weibull: Option<f64> = None, (1.0, 1e6, "");
        /// Rings, at whose boundaries bonds are weaker.
        rings: u32 = 0, (0.0, 1000.0, "");
        /// Rays, across which bonds are weaker.
        rays: u32 = 0, (0.0, 1000.0, "");
        /// Strength across a ring boundary over that elsewhere.
        ring_strength: f64 = 0.7, (1e-3, 1.0, "");
        /// Strength across a ray over that elsewhere.
        ray_strength: f64 = 0.8, (1e-3, 1.0, "");
    }
}

declared! {
    /// The stem at the start.
    pub struct StartKeys {
        /// Angle by which it is bent about y into a circular arc.
        bend: f64 = 0.0, (-350.0, 350.0, "°");
        /// Velocity of the whole stem.
        velocity: [f64; 3] = [0.0; 3], (-1e4, 1e4, "m/s");
    }
}

declared! {
    /// Loads on the whole stem.
    pub struct LoadKeys {
        /// Acceleration of gravity.
        gravity: [f64; 3] = [0.0; 3], (-1e4, 1e4, "m/s²");
        /// Damping: the rate at which velocities decay.
        damping: f64 = 0.0, (0.0, 1e6, "1/s");
        /// Snow on the stem, weight per length.
        snow: f64 = 0.0, (0.0, 1e6, "N/m");
        /// Time over which the snow load grows; 0 for at once.
        snow_rise: f64 = 0.0, (0.0, 1e6, "s");
        /// Velocity of the wind.
        wind: [f64; 3] = [0.0; 3], (-1e3, 1e3, "m/s");
        /// Density of the air.
        air: f64 = 1.2, (0.0, 1e4, "kg/m³");
        /// Drag coefficient.
        drag: f64 = 1.0, (0.0, 100.0, "");
    }
}

declared! {
    /// When the wood fails.
    pub struct FailureKeys {
        /// Whether rods break in tension.
        rods: bool = true, (-INF, INF, "");
        /// Whether rods yield in compression.
        yielding: bool = true, (-INF, INF, "");
        /// When bonds break: never, potential, griffith or stress.
        bonds: BondCriterionChoice = BondCriterionChoice::Stress, (-INF, INF, "");
        /// Energy of a bond at which it breaks, for potential.
        threshold: f64 = 1e-3, (0.0, 1e6, "J");
        /// Weight of shear against transverse energy, for potential.
        shear_weight: f64 = 0.5, (0.0, 1.0, "");
        /// Steps of the explicit solver between two checks for failure.
        every: u32 = 1, (1.0, 1e6, "steps");
    }
}

declared! {
    /// Contact.
    pub struct ContactKeys {
        /// Whether rods that no bond connects collide.
        rods: bool = true, (-INF, INF, "");
        /// Restitution of rods that hit each other.
        restitution: f64 = 0.0, (0.0, 1.0, "");
    }
}

declared! {
    /// A pose of a clamp or body at a time.
    pub struct KeyFrame {
        /// Time of the pose.
        time: f64 = 0.0, (0.0, 1e6, "s");
        /// Displacement.
        move_by: Lengths = Lengths([0.0; 3]), (-1e3, 1e3, "m");
        /// Rotation vector: along the axis, as long as the angle.
        turn: [f64; 3] = [0.0; 3], (-180.0, 180.0, "°");
    }
}

declared! {
    /// A clamp: a length of the stem that is held or moved.
    pub struct ClampKeys {
        /// Start of the clamped length.
        from: f64 = 0.0, (0.0, 1.0, "of the length");
        /// End of the clamped length.
        to: f64 = 0.0, (0.0, 1.0, "of the length");
        /// Velocity.
        velocity: [f64; 3] = [0.0; 3], (-1e3, 1e3, "m/s");
        /// Angular velocity about its middle, as a vector along the axis.
        angular: [f64; 3] = [0.0; 3], (-1e6, 1e6, "°/s");
        /// Whether it also moves so that the wood between the clamps bends without being stretched or compressed; for a clamp
        /// with key frames, in a scene with two clamps.
        arc: bool = false, (-INF, INF, "");
        /// Which of x, y, z are held.
        axes: String = "xyz".to_owned(), (-INF, INF, "");
    }
    lists {
        /// Poses instead of velocities, in order of time.
        key: KeyFrame;
    }
}

declared! {
    /// A force or moment on a cross-section, shared by its rods.
    pub struct ForceKeys {
        /// Position along the stem.
        at: f64 = 1.0, (0.0, 1.0, "of the length");
        /// Force on the cross-section.
        force: [f64; 3] = [0.0; 3], (-1e9, 1e9, "N");
        /// Moment on the cross-section.
        moment: [f64; 3] = [0.0; 3], (-1e9, 1e9, "N m");
        /// Time over which they grow; 0 for at once.
        rise: f64 = 0.0, (0.0, 1e6, "s");
    }
}

declared! {
    /// A body.
    pub struct BodyKeys {
        /// Name, for messages.
        name: String = String::new(), (-INF, INF, "");
        /// Shape: half-space, box, sphere, capsule, cylinder, hull or mesh.
        shape: ShapeChoice = ShapeChoice::Box, (-INF, INF, "");
        /// Size of a box; length (y) of a capsule or cylinder.
        size: Lengths = Lengths([0.02; 3]), (1e-6, 1e3, "m");
        /// Diameter of a sphere, capsule or cylinder.
        diameter: Length = Length(0.02), (1e-6, 1e3, "m");
        /// Mesh file of a hull or mesh, relative to the scene.
        file: String = String::new(), (-INF, INF, "");
        /// Position along the stem from which the place is measured.
        at: f64 = 0.5, (0.0, 1.0, "of the length");
        /// Position relative to the axis there.
        place: Lengths = Lengths([0.0; 3]), (-1e3, 1e3, "m");
        /// Rotation vector: along the axis, as long as the angle.
        turn: [f64; 3] = [0.0; 3], (-180.0, 180.0, "°");
        /// Direction from which it is moved in until it touches the stem.
        touch: Option<[f64; 3]> = None, (-1.0, 1.0, "");
        /// Gap that is then left to the stem.
        gap: Length = Length(0.0), (0.0, 1e3, "m");
        /// Motion: given (by velocity or key frames) or free.
        motion: MotionChoice = MotionChoice::Given, (-INF, INF, "");
        /// Velocity of a given motion, or at the start of a free one.
        velocity: [f64; 3] = [0.0; 3], (-1e3, 1e3, "m/s");
        /// Angular velocity, likewise.
        angular: [f64; 3] = [0.0; 3], (-1e6, 1e6, "°/s");
        /// Density of a free body.
        density: f64 = 600.0, (1e-3, 1e5, "kg/m³");
        /// Restitution.
        restitution: f64 = 0.0, (0.0, 1.0, "");
        /// Coefficient of friction.
        friction: f64 = 0.4, (0.0, 100.0, "");
    }
    lists {
        /// Poses instead of velocities, in order of time.
        key: KeyFrame;
    }
}

declared! {
    /// A scene.
    pub struct Scene {
        /// What the scene shows, in a sentence.
        about: String = String::new(), (-INF, INF, "");
        /// Seed: which of all possible pieces of this wood.
        seed: u64 = 1, (0.0, i64::MAX as f64, "");
        /// Duration.
        duration: f64 = 1.0, (0.0, 1e6, "s");
        /// Frames that are recorded.
        frames_per_second: f64 = 25.0, (1e-3, 1e5, "1/s");
        /// Rows of the energy table; of solvers other than explicit at most one per step.
        rows_per_second: f64 = 500.0, (1e-3, 1e6, "1/s");
        /// Solver: explicit, implicit, interactive or quasi-static.
        solver: SolverChoice = SolverChoice::Explicit, (-INF, INF, "");
        /// Length of the stem for which the scene is written. On another stem the edges and spacing of rods, the sizes and places
        /// of bodies, and the displacements and velocities of moved bodies and clamps are scaled in proportion. Without it they
        /// are not.
        for_length: Option<Length> = None, (1e-3, 100.0, "m");
        /// Step of the solver; without it the solver chooses.
        step: Option<f64> = None, (1e-12, 1.0, "s");
    }
    tables {
        /// The stem.
        stem: StemKeys;
        /// The wood.
        wood: WoodKeys;
        /// The rods.
        rods: RodKeys;
        /// The start.
        start: StartKeys;
        /// Loads.
        loads: LoadKeys;
        /// FailureCriteria.
        failure: FailureKeys;
        /// Contact.
        contact: ContactKeys;
    }
    lists {
        /// Clamps.
        clamp: ClampKeys;
        /// Forces.
        force: ForceKeys;
        /// Bodies.
        body: BodyKeys;
    }
}

impl Scene {
    /// Returns the solver of the scene. Load steps of the quasi-static solver are a quarter of a frame where none are given.
    pub fn make_solver(&self) -> Box<dyn Solver> {
        let step = match self.solver {
            SolverChoice::QuasiStatic => Some(self.quasi_static_step()),
            _ => self.step,
        };
        self.solver.make(step)
    }

    /// Returns the rows per second of the tables: at most one per step, except for the explicit solver, whose steps are far
    /// shorter.
    pub fn table_rate(&self) -> f64 {
        let step = match self.solver {
            SolverChoice::Explicit => return self.rows_per_second,
            SolverChoice::Implicit => self.step.unwrap_or(IMPLICIT_STEP),
            SolverChoice::Interactive => self.step.unwrap_or(INTERACTIVE_STEP),
            SolverChoice::QuasiStatic => self.quasi_static_step(),
        };
        self.rows_per_second.min(1.0 / step)
    }

    fn quasi_static_step(&self) -> f64 {
        self.step.unwrap_or(0.25 / self.frames_per_second)
    }

    /// Returns every key that a scene may have.
    pub fn reference() -> Vec<KeyInfo> {
        Scene::keys("")
    }

    /// Returns the keys as a page in Markdown.
    pub fn reference_markdown() -> String {
        use std::fmt::Write;
        let mut text = String::from("# Keys of a scene\n");
        let mut table = None;
        for k in Scene::reference() {
            if table.as_ref() != Some(&k.table) {
                let name = if k.table.is_empty() {
                    "(top)"
                } else {
                    &k.table
                };
                let _ = write!(
                    text,
                    "\n## `{name}`\n\n| key | default | unit | range | meaning |\n|---|---|---|---|---|\n"
                );
                table = Some(k.table.clone());
            }
            let range = match k.range {
                (a, b) if a.is_finite() && b.is_finite() => format!("{a} to {b}"),
                _ => String::new(),
            };
            let default = if k.default.is_empty() {
                String::new()
            } else {
                format!("`{}`", k.default)
            };
            let _ = writeln!(
                text,
                "| `{}` | {default} | {} | {range} | {} |",
                k.key, k.unit, k.doc
            );
        }
        text
    }
}
