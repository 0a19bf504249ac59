//! The keys of a scene file.

use super::choices::{
    ArrangementChoice, BondCriterionChoice, MotionChoice, NeighbourChoice, ShapeChoice,
    SolverChoice, StemChoice, TwistChoice, UpChoice,
};
use super::held_axes::{HELD_AXES, HeldAxes};
use crate::solvers::{IMPLICIT_STEP, INTERACTIVE_STEP, Solver};
use glam::DVec3;
use greenstick_schema::{
    Declaration, Format, Kind, ParameterError, Unit, choice, count, flag, length, list, number,
    parameters, text,
};
use greenstick_wood::anatomy::BreakRingParameters;
use greenstick_wood::rings::ONSET_RANGE;
use greenstick_wood::species::SPECIES_NAME;
use greenstick_wood::stem::{LOCATION, StemLocation};
use greenstick_wood::structure::GrainAngles;

/// Greatest seed: TOML's integers have 64 bits with a sign.
const MAX_SEED: i128 = i64::MAX as i128;

const PART: Kind = number(Unit::Fraction, 0.0, 1.0).kind;
const EDGE: Kind = length(1e-6, 1.0).kind;
const SPEED: Kind = number(Unit::MetrePerSecond, -1e3, 1e3).kind;
const STEM_SPEED: Kind = number(Unit::MetrePerSecond, -1e4, 1e4).kind;
const ANGULAR_SPEED: Kind = number(Unit::DegreePerSecond, -1e6, 1e6).kind;
const ACCELERATION: Kind = number(Unit::MetrePerSecondSquared, -1e4, 1e4).kind;
const FORCE: Kind = number(Unit::Newton, -1e9, 1e9).kind;
const MOMENT: Kind = number(Unit::NewtonMetre, -1e9, 1e9).kind;
const POSITION: Kind = length(-1e3, 1e3).kind;
const SIZE: Kind = length(1e-6, 1e3).kind;
const TURN: Kind = number(Unit::Degree, -180.0, 180.0).kind;
const DIRECTION: Kind = number(Unit::One, -1.0, 1.0).kind;

/// A vector.
const fn vector(component: &'static Kind) -> Declaration {
    list(component, 3, 3)
}

/// Two values, the second of which is not below the first.
const fn range(end: &'static Kind) -> Declaration {
    list(end, 2, 2)
}

/// Least and greatest length of a stem that a scene may be of, m.
pub(crate) const STEM_LENGTHS: (f64, f64) = (1e-3, 200.0);

/// A fraction of the stem's length.
const fn position_along() -> Declaration {
    number(Unit::Fraction, 0.0, 1.0)
}

/// A time after the start.
const fn time() -> Declaration {
    number(Unit::Second, 0.0, 1e6)
}

parameters! {
    /// The stem.
    pub struct StemKeys {
        "", "stem" {
            /// What the stem is; an input is a mesh file given with the scene.
            kind: StemChoice = StemChoice::Branch, choice(StemChoice::CHOICES);
            /// Length; an input has its own.
            length: f64 = 0.3, length(1e-3, 100.0);
            /// Diameter of a branch or cylinder.
            diameter: f64 = 0.02, length(1e-4, 10.0);
            /// Width of a board.
            width: f64 = 0.02, length(1e-4, 10.0);
            /// Thickness of a board.
            thickness: f64 = 0.02, length(1e-4, 10.0);
            /// Where on an input: a fraction of its length (0.4), a length from its base (12cm), or a point (x,y,z).
            at: StemLocation = StemLocation::Fraction(0.5), text(LOCATION);
            /// Part of the length that is filled with rods, from and to.
            part: [f64; 2] = [0.0, 1.0], range(&PART);
            /// Angle of the stem above the horizontal, from its base to its tip; gravity, snow and wind, which are given as for a
            /// level stem, act on it so. "auto" is that of an input as it stands; other stems lie level.
            inclination: Option<f64> = None, number(Unit::Degree, -90.0, 90.0).auto();
            /// Axis of an input that points up. "auto" is y for glTF and OBJ, z for other meshes and for point clouds.
            up: Option<UpChoice> = None, choice(UpChoice::CHOICES).auto();
            /// Share of the radius at which an eccentric stem began to lean; "auto" is the usual one of such an outline.
            eccentricity_onset: Option<f64> = None,
                number(Unit::Fraction, *ONSET_RANGE.start(), *ONSET_RANGE.end()).auto();
        }
    }
    check |keys| match keys.part {
        [from, to] if from >= to => Err(ParameterError::Conflict(format!(
            "part is from {from} to {to}, but the first must be below the second"
        ))),
        _ => Ok(()),
    };
}

impl StemKeys {
    /// The direction in an input that points up.
    pub fn up_of_input(&self) -> DVec3 {
        match self.up {
            Some(UpChoice::Z) => DVec3::Z,
            Some(UpChoice::Y) | None => DVec3::Y,
        }
    }
}

parameters! {
    /// The wood.
    pub struct WoodKeys {
        "", "rods" {
            /// Species, by common or scientific name.
            species: String = "white ash".to_owned(), text(SPECIES_NAME);
            /// Moisture content, percent of the oven-dry mass.
            moisture: f64 = 12.0, number(Unit::Percent, 0.0, 200.0);
            /// Factor on all moduli of elasticity; strains at failure stay the same.
            stiffness: f64 = 1.0, number(Unit::One, 1e-6, 100.0).logarithmic();
            /// Fraction of the tensile strength along the grain that brash wood has lost, by decay for one; other strengths stay.
            brash: f64 = 0.0, number(Unit::Fraction, 0.0, 0.95);
            /// Whether rods and bonds differ as the wood does: earlywood and latewood, juvenile and mature wood, bark, and weak
            /// planes along rings and rays. Otherwise all of the section is the mean of the species' wood.
            structure: bool = true, flag();
            /// Strength of a ring boundary over the mean across the grain; "auto" is that of earlywood.
            ring_strength: Option<f64> = None, number(Unit::One, 1e-3, 1.0).auto();
            /// Strength of a plane along rays over that of one along rings; "auto" is 1/1.4.
            ray_strength: Option<f64> = None, number(Unit::One, 1e-3, 1.0).auto();
            /// Spiral grain: its angle at the outside of the stem.
            grain_spiral: f64 = 0.0, number(Unit::Degree, -45.0, 45.0);
            /// Wavy grain: its largest angle.
            grain_wave: f64 = 0.0, number(Unit::Degree, -45.0, 45.0);
            /// Length of a wave of the grain along the stem.
            grain_wave_length: f64 = 0.03, length(1e-4, 10.0);
            /// Interlocked grain: its largest angle, left and right in turn from the pith outwards.
            grain_interlock: f64 = 0.0, number(Unit::Degree, -45.0, 45.0);
            /// Annual rings from one turn of interlocked grain to the left to the next.
            grain_interlock_rings: f64 = 8.0, number(Unit::One, 0.1, 1000.0);
        }
    }
}

parameters! {
    /// The rods.
    pub struct RodKeys {
        "", "rods" {
            /// Number of rods in a cross-section, where no spacing is given.
            number: u32 = 100, count(1, 1_000_000).logarithmic();
            /// Distance between rods, instead of their number.
            spacing: Option<f64> = None, length(1e-6, 1.0).auto();
            /// How rods are arranged in the cross-section.
            arrangement: ArrangementChoice = ArrangementChoice::PoissonDisk, choice(ArrangementChoice::CHOICES);
            /// Least and greatest length of edges. Where both are equal, vertices are placed so that wood is free exactly from the
            /// ends of clamps.
            edge: [f64; 2] = [4e-3, 6e-3], range(&EDGE);
            /// Part of the stem's length on which edges are shorter, as fractions; "auto" is none.
            fine: Option<[f64; 2]> = None, range(&PART).auto();
            /// How many times shorter edges are there. Their scatter of strength is that of wood of the same length.
            fineness: f64 = 2.0, number(Unit::One, 1.0, 16.0);
            /// Whether rods resist twist.
            twist: TwistChoice = TwistChoice::Auto, choice(TwistChoice::CHOICES);
            /// Reach of bonds, in mean distances of rods.
            reach: f64 = 2.5, number(Unit::One, 1.0, 5.0);
            /// Which rods within reach are bonded.
            neighbours: NeighbourChoice = NeighbourChoice::Facets, choice(NeighbourChoice::CHOICES);
            /// Lloyd iterations, which move rods to the centroids of their cells; the thesis has none.
            lloyd: u32 = 3, count(0, 100);
            /// Weibull modulus of the scatter of strength; "auto" is no scatter.
            weibull: Option<f64> = None, number(Unit::One, 1.0, 1e6).logarithmic().auto();
        }
    }
    check |keys| match (keys.edge, keys.fine) {
        ([least, greatest], _) if least > greatest => Err(ParameterError::Conflict(format!(
            "edge is from {least} to {greatest} m, but the first must not be above the second"
        ))),
        (_, Some([from, to])) if from >= to => Err(ParameterError::Conflict(format!(
            "fine is from {from} to {to}, but the first must be below the second"
        ))),
        _ => Ok(()),
    };
}

parameters! {
    /// The stem at the start.
    pub struct StartKeys {
        "", "simulate" {
            /// Angle by which the stem is bent about y into a circular arc.
            bend: f64 = 0.0, number(Unit::Degree, -350.0, 350.0);
            /// Velocity of the whole stem.
            velocity: [f64; 3] = [0.0; 3], vector(&STEM_SPEED);
        }
    }
}

parameters! {
    /// Loads on the whole stem.
    pub struct LoadKeys {
        "", "simulate" {
            /// Acceleration of gravity.
            gravity: [f64; 3] = [0.0; 3], vector(&ACCELERATION);
            /// Damping: the rate at which velocities decay.
            damping: f64 = 0.0, number(Unit::PerSecond, 0.0, 1e6);
            /// Snow on the stem, weight per length. It has the mass of its weight, and stays on what breaks off.
            snow: f64 = 0.0, number(Unit::NewtonPerMetre, 0.0, 1e6);
            /// Time over which the snow load grows; 0 for at once.
            snow_rise: f64 = 0.0, time();
            /// Velocity of the wind.
            wind: [f64; 3] = [0.0; 3], vector(&SPEED);
            /// Time over which the wind rises; 0 for at once.
            wind_rise: f64 = 0.0, time();
            /// Density of the air.
            air: f64 = 1.2, number(Unit::KilogramPerCubicMetre, 0.0, 1e4);
            /// Drag coefficient, about 1 for a bare stem. What twigs and leaves catch is added to it: 10 for nine times the area of the stem's
            /// own side.
            drag: f64 = 1.0, number(Unit::One, 0.0, 100.0);
        }
    }
}

parameters! {
    /// When the wood fails.
    pub struct FailureKeys {
        "", "simulate" {
            /// Whether rods break in tension and, where they resist twist, in torsion.
            rods: bool = true, flag();
            /// Whether rods break anywhere along their length, where stress over strength is greatest; otherwise at vertices.
            between_vertices: bool = true, flag();
            /// Whether rods yield in compression.
            yielding: bool = true, flag();
            /// When bonds break.
            bonds: BondCriterionChoice = BondCriterionChoice::Cohesive, choice(BondCriterionChoice::CHOICES);
            /// Energy of a bond at which it breaks, for potential.
            threshold: f64 = 1e-3, number(Unit::Joule, 0.0, 1e6);
            /// Weight of shear against transverse energy, for potential.
            shear_weight: f64 = 0.5, number(Unit::One, 0.0, 1.0);
            /// Steps of the explicit solver between two checks for failure.
            every: u32 = 1, count(1, 1_000_000).logarithmic();
        }
    }
}

parameters! {
    /// Contact.
    pub struct ContactKeys {
        "", "simulate" {
            /// Whether rods that no bond connects collide.
            rods: bool = true, flag();
            /// Restitution of rods that hit each other.
            restitution: f64 = 0.0, number(Unit::One, 0.0, 1.0);
        }
    }
}

parameters! {
    /// A pose of a clamp or body at a time.
    pub struct KeyFrame {
        "Pose", "simulate" {
            /// Time of the pose.
            time: f64 = 0.0, time();
            /// Displacement.
            move_by: [f64; 3] = [0.0; 3], vector(&POSITION);
            /// Rotation vector: along the axis, as long as the angle.
            turn: [f64; 3] = [0.0; 3], vector(&TURN);
        }
    }
}

parameters! {
    /// A clamp: a length of the stem that is held or moved.
    pub struct ClampKeys {
        "Clamp", "simulate" {
            /// Start of the clamped length, as a fraction of the stem.
            from: f64 = 0.0, position_along();
            /// End of the clamped length.
            to: f64 = 0.0, position_along();
            /// Velocity.
            velocity: [f64; 3] = [0.0; 3], vector(&SPEED);
            /// Angular velocity about its middle, as a vector along the axis.
            angular: [f64; 3] = [0.0; 3], vector(&ANGULAR_SPEED);
            /// Whether it also moves so that the wood between the clamps bends without being stretched or compressed; for a
            /// clamp with key frames, in a scene with two clamps.
            arc: bool = false, flag();
            /// Which of x, y, z are held.
            axes: HeldAxes = HeldAxes::ALL, text(HELD_AXES);
        }
    }
    lists {
        /// Poses instead of velocities, in order of time.
        key: KeyFrame;
    }
}

parameters! {
    /// A force or moment on a cross-section, shared by its rods.
    pub struct ForceKeys {
        "Force", "simulate" {
            /// Position along the stem, as a fraction of its length.
            at: f64 = 1.0, position_along();
            /// Force on the cross-section.
            force: [f64; 3] = [0.0; 3], vector(&FORCE);
            /// Moment on the cross-section.
            moment: [f64; 3] = [0.0; 3], vector(&MOMENT);
            /// Time over which they grow; 0 for at once.
            rise: f64 = 0.0, time();
        }
    }
}

parameters! {
    /// A body.
    pub struct BodyKeys {
        "Body", "simulate" {
            /// Name, for messages.
            name: String = String::new(), text(Format::ANY);
            /// Shape.
            shape: ShapeChoice = ShapeChoice::Box, choice(ShapeChoice::CHOICES);
            /// Size of a box or wedge; length (y) of a capsule or cylinder.
            size: [f64; 3] = [0.02; 3], vector(&SIZE);
            /// Diameter of a sphere, capsule or cylinder.
            diameter: f64 = 0.02, length(1e-6, 1e3);
            /// Mesh file of a hull or mesh, relative to the scene.
            file: String = String::new(), text(Format::ANY);
            /// Position along the stem, as a fraction of its length, from which the place is measured.
            at: f64 = 0.5, position_along();
            /// Position relative to the axis there.
            place: [f64; 3] = [0.0; 3], vector(&POSITION);
            /// Rotation vector: along the axis, as long as the angle.
            turn: [f64; 3] = [0.0; 3], vector(&TURN);
            /// Direction from which it is moved in until it touches the stem; "auto" leaves it at its place.
            touch: Option<[f64; 3]> = None, vector(&DIRECTION).auto();
            /// Gap that is then left to the stem.
            gap: f64 = 0.0, length(0.0, 1e3);
            /// Motion: given by velocity or key frames, or free.
            motion: MotionChoice = MotionChoice::Given, choice(MotionChoice::CHOICES);
            /// Velocity of a given motion, or at the start of a free one.
            velocity: [f64; 3] = [0.0; 3], vector(&SPEED);
            /// Angular velocity, likewise.
            angular: [f64; 3] = [0.0; 3], vector(&ANGULAR_SPEED);
            /// Density of a free body.
            density: f64 = 600.0, number(Unit::KilogramPerCubicMetre, 1e-3, 1e5).logarithmic();
            /// Restitution.
            restitution: f64 = 0.0, number(Unit::One, 0.0, 1.0);
            /// Coefficient of friction.
            friction: f64 = 0.4, number(Unit::One, 0.0, 100.0);
        }
    }
    lists {
        /// Poses instead of velocities, in order of time.
        key: KeyFrame;
    }
}

parameters! {
    /// A scene.
    pub struct Scene {
        "Scene", "simulate" {
            /// What the scene shows, in a sentence.
            about: String = String::new(), text(Format::ANY);
            /// Seed: which of all possible pieces of this wood.
            seed: u64 = 1, count(0, MAX_SEED).stage("rods");
            /// Duration.
            duration: f64 = 1.0, time();
            /// Frames that are recorded.
            frames_per_second: f64 = 25.0, number(Unit::PerSecond, 1e-3, 1e5).logarithmic();
            /// How many times slower a film runs while rods break, with as many times the frames; 1 for constant speed.
            slow: f64 = 1.0, number(Unit::One, 1.0, 1e4).logarithmic();
            /// Rows of the energy table; of solvers other than explicit at most one per step.
            rows_per_second: f64 = 500.0, number(Unit::PerSecond, 1e-3, 1e6).logarithmic();
            /// Solver.
            solver: SolverChoice = SolverChoice::Explicit, choice(SolverChoice::CHOICES);
            /// Length of the stem for which the scene is written. On another stem the edges and spacing of rods, the sizes and
            /// places of bodies, and the displacements and velocities of moved bodies and clamps are scaled in proportion.
            /// With "auto" they are not.
            for_length: Option<f64> = None, length(STEM_LENGTHS.0, STEM_LENGTHS.1).auto().stage("rods");
            /// Step of the solver; with "auto" the solver chooses.
            step: Option<f64> = None, number(Unit::Second, 1e-12, 1.0).logarithmic().auto();
        }
    }
    include {
        /// The annual rings.
        rings: BreakRingParameters = BreakRingParameters::default();
    }
    tables {
        /// The stem.
        stem: StemKeys = StemKeys::default();
        /// The wood.
        wood: WoodKeys = WoodKeys::default();
        /// The rods.
        rods: RodKeys = RodKeys::default();
        /// The start.
        start: StartKeys = StartKeys::default();
        /// Loads.
        loads: LoadKeys = LoadKeys::default();
        /// Failure.
        failure: FailureKeys = FailureKeys::default();
        /// Contact.
        contact: ContactKeys = ContactKeys::default();
    }
    lists {
        /// Clamps: lengths of the stem that are held or moved.
        clamp: ClampKeys;
        /// Forces and moments on cross-sections, shared by their rods.
        force: ForceKeys;
        /// Bodies.
        body: BodyKeys;
    }
}

impl WoodKeys {
    /// Returns the angles of the grain.
    pub(crate) fn grain(&self) -> GrainAngles {
        GrainAngles {
            spiral: self.grain_spiral.to_radians(),
            wave: self.grain_wave.to_radians(),
            wave_length: self.grain_wave_length,
            interlock: self.grain_interlock.to_radians(),
            interlock_rings: self.grain_interlock_rings,
        }
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
}
