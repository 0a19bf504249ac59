//! Scenes: a TOML file that says what wood, how it is held, what acts on it, and what is written down.
//!
//! Places along the stem are fractions of its length from its base. The scene's axes are those of the stem: x from the
//! middle of its base to that of its end, z up. Lengths carry their unit, angles are degrees, all else is SI.
//!
//! [`Scene::read`] reads one, [`Scene::built_in`] has those that come with the program, [`set_up`] puts a bundle into it.

mod arc;
mod built_in;
pub(crate) mod declare;
mod read;
mod scale;
mod set_up;
mod start;

pub use built_in::{BUILT_IN, BuiltIn};
pub use declare::{Declared, KeyInfo, Length, Lengths};
pub use read::SceneError;
pub use set_up::{SetUp, set_up};

use crate::explicit::Explicit;
use crate::solver::Solver;
use crate::solvers::{Implicit, Interactive, QuasiStatic, implicit, interactive};
use declare::{Numbers, declared, numbers};
use serde::{Deserialize, Serialize};

/// Declares an enum of words.
macro_rules! words {
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

words! {
    /// What the stem is.
    pub enum StemWord {
        /// The branch that comes with the program.
        Branch,
        /// A straight round stem.
        Cylinder,
        /// A board.
        Board,
        /// The mesh that is given.
        Input,
    }
    /// How rods are arranged in a section.
    pub enum ArrangementWord {
        /// Poisson disk, as in the thesis.
        PoissonDisk,
        /// By ring and sector.
        Anatomy,
    }
    /// Whether rods resist twist.
    pub enum TwistWord {
        /// Where rods are curved.
        Auto,
        /// Always.
        On,
        /// Never, as in the thesis; rods must be straight.
        Off,
    }
    /// Which solver.
    pub enum SolverWord {
        /// Symplectic Euler, the reference.
        Explicit,
        /// Steps of animation at real stiffness, solved to the end.
        Implicit,
        /// A step a picture at real stiffness.
        Interactive,
        /// Equilibrium after equilibrium, without inertia.
        QuasiStatic,
    }
    /// When bonds break.
    pub enum BondWord {
        /// Never.
        Never,
        /// At an energy, as in the thesis.
        Potential,
        /// At the energy of fracture of their facet.
        Griffith,
        /// At the strength of their facet.
        Stress,
    }
    /// Shape of a body.
    pub enum ShapeWord {
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
    /// How a body moves.
    pub enum MotionWord {
        /// It stays, or is moved by its key frames.
        Given,
        /// Freely.
        Free,
    }
}

impl SolverWord {
    /// All solvers.
    pub const ALL: [SolverWord; 4] = [
        SolverWord::Explicit,
        SolverWord::Implicit,
        SolverWord::Interactive,
        SolverWord::QuasiStatic,
    ];

    /// The solver's name in files.
    pub fn name(self) -> &'static str {
        match self {
            SolverWord::Explicit => "explicit",
            SolverWord::Implicit => "implicit",
            SolverWord::Interactive => "interactive",
            SolverWord::QuasiStatic => "quasi-static",
        }
    }

    /// How far behind positions its velocities are, in steps: those of symplectic Euler are of the middle of the last step.
    pub fn lag(self) -> f64 {
        if self == SolverWord::Explicit {
            0.5
        } else {
            0.0
        }
    }

    /// The solver, with a step (s) where one is given. The one place that knows all solvers.
    pub fn make(self, step: Option<f64>) -> Box<dyn Solver> {
        match self {
            SolverWord::Explicit => Box::new(Explicit::new(step)),
            SolverWord::Implicit => Box::new(Implicit::new(step)),
            SolverWord::Interactive => Box::new(Interactive::new(step)),
            SolverWord::QuasiStatic => Box::new(QuasiStatic::forgetful(step)),
        }
    }
}

const INF: f64 = f64::INFINITY;

declared! {
    /// The stem.
    pub struct StemKeys {
        /// What it is: branch, cylinder, board or input (a mesh file given with the scene).
        kind: StemWord = StemWord::Branch, (-INF, INF, "");
        /// Length, of all but an input.
        length: Length = Length(0.3), (1e-3, 100.0, "m");
        /// Diameter, of a branch or cylinder.
        diameter: Length = Length(0.02), (1e-4, 10.0, "m");
        /// Width of a board.
        width: Length = Length(0.02), (1e-4, 10.0, "m");
        /// Thickness of a board.
        thickness: Length = Length(0.02), (1e-4, 10.0, "m");
        /// Place in an input: a fraction of the stem (0.4), a length from its base (12cm) or a point (x,y,z).
        at: String = "0.5".to_owned(), (-INF, INF, "");
        /// Part of the length that is filled with rods, from and to.
        part: [f64; 2] = [0.0, 1.0], (0.0, 1.0, "");
    }
}

declared! {
    /// What wood it is.
    pub struct WoodKeys {
        /// Species, by common or scientific name.
        species: String = "white ash".to_owned(), (-INF, INF, "");
        /// Moisture content.
        moisture: f64 = 12.0, (0.0, 200.0, "% of the dry mass");
        /// Factor on all moduli of elasticity, with strains at failure as they are.
        stiffness: f64 = 1.0, (1e-6, 100.0, "");
    }
}

declared! {
    /// The rods.
    pub struct RodKeys {
        /// How many rods in a section, where no spacing is given.
        number: u32 = 100, (1.0, 1e6, "");
        /// Distance between rods, in place of their number.
        spacing: Option<Length> = None, (1e-6, 1.0, "m");
        /// How they are arranged in the section: poisson-disk or anatomy.
        arrangement: ArrangementWord = ArrangementWord::PoissonDisk, (-INF, INF, "");
        /// Least and greatest length of edges.
        edge: [Length; 2] = [Length(4e-3), Length(6e-3)], (1e-6, 1.0, "m");
        /// Whether rods resist twist: auto, on or off.
        twist: TwistWord = TwistWord::Auto, (-INF, INF, "");
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
    /// How the stem is at the start.
    pub struct StartKeys {
        /// Angle by which it is bent about y into a circular arc.
        bend: f64 = 0.0, (-350.0, 350.0, "°");
        /// Velocity of all of it.
        velocity: [f64; 3] = [0.0; 3], (-1e4, 1e4, "m/s");
    }
}

declared! {
    /// What acts on all of it.
    pub struct LoadKeys {
        /// Acceleration of gravity.
        gravity: [f64; 3] = [0.0; 3], (-1e4, 1e4, "m/s²");
        /// Damping, a rate at which velocities decay.
        damping: f64 = 0.0, (0.0, 1e6, "1/s");
        /// Snow on the stem, weight per length.
        snow: f64 = 0.0, (0.0, 1e6, "N/m");
        /// Time over which the snow grows to that; 0 for at once.
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
    /// When it breaks.
    pub struct FailureKeys {
        /// Whether rods break in tension.
        rods: bool = true, (-INF, INF, "");
        /// Whether rods yield in compression.
        yielding: bool = true, (-INF, INF, "");
        /// When bonds break: never, potential, griffith or stress.
        bonds: BondWord = BondWord::Stress, (-INF, INF, "");
        /// Energy of a bond at which it breaks, for potential.
        threshold: f64 = 1e-3, (0.0, 1e6, "J");
        /// Weight of shear against transverse energy, for potential.
        shear_weight: f64 = 0.5, (0.0, 1.0, "");
        /// Steps of the explicit solver from one look for what fails to the next.
        every: u32 = 1, (1.0, 1e6, "steps");
    }
}

declared! {
    /// How things touch.
    pub struct ContactKeys {
        /// Whether rods that no bond joins collide.
        rods: bool = true, (-INF, INF, "");
        /// Restitution of rods that hit each other.
        restitution: f64 = 0.0, (0.0, 1.0, "");
    }
}

declared! {
    /// A pose of a clamp or body at a time.
    pub struct KeyFrame {
        /// When.
        time: f64 = 0.0, (0.0, 1e6, "s");
        /// Displacement.
        move_by: Lengths = Lengths([0.0; 3]), (-1e3, 1e3, "m");
        /// Rotation: along its axis, as long as its angle.
        turn: [f64; 3] = [0.0; 3], (-180.0, 180.0, "°");
    }
}

declared! {
    /// A stretch of the stem that is held or moved.
    pub struct ClampKeys {
        /// From where.
        from: f64 = 0.0, (0.0, 1.0, "of the length");
        /// To where.
        to: f64 = 0.0, (0.0, 1.0, "of the length");
        /// Velocity.
        velocity: [f64; 3] = [0.0; 3], (-1e3, 1e3, "m/s");
        /// Angular velocity about its middle: along its axis.
        angular: [f64; 3] = [0.0; 3], (-1e6, 1e6, "°/s");
        /// Whether it also moves so that the wood between it and the other clamp is bent and keeps its length; of key
        /// frames, in a scene with two clamps.
        arc: bool = false, (-INF, INF, "");
        /// Which of x, y, z are held.
        axes: String = "xyz".to_owned(), (-INF, INF, "");
    }
    lists {
        /// Poses in place of velocities, in order of time.
        key: KeyFrame;
    }
}

declared! {
    /// A force or moment on the section at a place, shared by its rods.
    pub struct ForceKeys {
        /// Where.
        at: f64 = 1.0, (0.0, 1.0, "of the length");
        /// Force on the section.
        force: [f64; 3] = [0.0; 3], (-1e9, 1e9, "N");
        /// Moment on the section.
        moment: [f64; 3] = [0.0; 3], (-1e9, 1e9, "N m");
        /// Time over which it grows to that; 0 for at once.
        rise: f64 = 0.0, (0.0, 1e6, "s");
    }
}

declared! {
    /// A body.
    pub struct BodyKeys {
        /// Name, for messages.
        name: String = String::new(), (-INF, INF, "");
        /// Shape: half-space, box, sphere, capsule, cylinder, hull or mesh.
        shape: ShapeWord = ShapeWord::Box, (-INF, INF, "");
        /// Size of a box; length (y) of a capsule or cylinder.
        size: Lengths = Lengths([0.02; 3]), (1e-6, 1e3, "m");
        /// Diameter of a sphere, capsule or cylinder.
        diameter: Length = Length(0.02), (1e-6, 1e3, "m");
        /// Mesh file of a hull or mesh, beside the scene.
        file: String = String::new(), (-INF, INF, "");
        /// Where along the stem its place is counted from.
        at: f64 = 0.5, (0.0, 1.0, "of the length");
        /// Place from the axis there.
        place: Lengths = Lengths([0.0; 3]), (-1e3, 1e3, "m");
        /// Rotation: along its axis, as long as its angle.
        turn: [f64; 3] = [0.0; 3], (-180.0, 180.0, "°");
        /// Where it comes from: it is moved in from there until it touches the stem.
        touch: Option<[f64; 3]> = None, (-1.0, 1.0, "");
        /// Distance from the stem that is left then.
        gap: Length = Length(0.0), (0.0, 1e3, "m");
        /// Whether its motion is given, or free.
        motion: MotionWord = MotionWord::Given, (-INF, INF, "");
        /// Velocity, of a given or the start of a free motion.
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
        /// Poses in place of velocities, in order of time.
        key: KeyFrame;
    }
}

declared! {
    /// A scene.
    pub struct Scene {
        /// What it shows, in a sentence.
        about: String = String::new(), (-INF, INF, "");
        /// Which of all the pieces of wood like this.
        seed: u64 = 1, (0.0, i64::MAX as f64, "");
        /// How long it lasts.
        duration: f64 = 1.0, (0.0, 1e6, "s");
        /// Frames that are written.
        frames_per_second: f64 = 25.0, (1e-3, 1e5, "1/s");
        /// Rows of the energy table; of solvers other than explicit no more than one a step.
        rows_per_second: f64 = 500.0, (1e-3, 1e6, "1/s");
        /// Solver: explicit, implicit, interactive or quasi-static.
        solver: SolverWord = SolverWord::Explicit, (-INF, INF, "");
        /// Length of the stem that the scene's lengths are for: on another, edges and spacing of rods, sizes and places of
        /// bodies, and ways and velocities of moved bodies and clamps are as much longer. Without it they are as they are.
        for_length: Option<Length> = None, (1e-3, 100.0, "m");
        /// Its step; else it chooses.
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
        /// Failure.
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
    /// The solver of the scene. Load steps of the quasi-static one are a quarter of a frame where none are given.
    pub fn make_solver(&self) -> Box<dyn Solver> {
        let step = match self.solver {
            SolverWord::QuasiStatic => Some(self.step.unwrap_or(0.25 / self.frames_per_second)),
            _ => self.step,
        };
        self.solver.make(step)
    }

    /// Rows a second that tables get: no more than one a step, but of the explicit solver, whose steps are far shorter.
    pub fn rows(&self) -> f64 {
        let step = match self.solver {
            SolverWord::Explicit => return self.rows_per_second,
            SolverWord::Implicit => self.step.unwrap_or(implicit::STEP),
            SolverWord::Interactive => self.step.unwrap_or(interactive::STEP),
            SolverWord::QuasiStatic => self.step.unwrap_or(0.25 / self.frames_per_second),
        };
        self.rows_per_second.min(1.0 / step)
    }

    /// Every key that a scene may have.
    pub fn reference() -> Vec<KeyInfo> {
        Scene::keys("")
    }

    /// The keys as a page in Markdown.
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
