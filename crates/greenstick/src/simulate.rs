//! Simulation: a stem filled with rods, moved by a solver, written as it runs.
//!
//! A run owns a folder: `scene.toml`, `energy.csv`, `events.csv`, `frames.gsf` and `checkpoint.bin`. Tables and frames are
//! only appended to, and the checkpoint, which is written beside its place and renamed, says how long they were then. To
//! resume is to cut them to that length and to go on, so that a run that was stopped anywhere ends in the same bytes.

use crate::files::{self, FileError, Output};
use glam::DVec3;
use greenstick_fibre::SolverError;
use greenstick_fibre::bodies::{BodyError, Shape};
use greenstick_fibre::placement::{
    Arrangement, HowMany, Placement, PlacementError, WoodMaterial, place,
};
use greenstick_fibre::scene::{
    ArrangementWord, Scene as Setting, SceneError, SetUp, StemWord, TwistWord, set_up,
};
use greenstick_fibre::store::{
    Checkpoint, ENERGY_HEADER, EVENT_HEADER, EnergyRow, Frame, FrameReader, Progress, StoreError,
    checksum, event_row, write_header,
};
use greenstick_geometry::{Cancelled, Context, Mesh, Scene};
use greenstick_picture::{Chart, Line, Picture};
use greenstick_wood::moisture::Fallback;
use greenstick_wood::primitive::{self, BranchOptions};
use greenstick_wood::species::{Species, StrengthError, UnknownSpecies};
use greenstick_wood::stem::{Place, PlaceError, StemError, StemOptions, find};
use serde::Serialize;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Why a simulation stopped.
#[derive(Debug, thiserror::Error)]
pub enum SimulateError {
    /// The scene is wrong, or does not fit the stem.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The place on the input is wrong.
    #[error("stem.at: {0}")]
    Place(#[from] PlaceError),
    /// No stem was found.
    #[error(transparent)]
    Stem(#[from] StemError),
    /// A scene of an input without one.
    #[error(
        "the scene is of a mesh, and none was given; name one behind the scene, or choose another stem.kind"
    )]
    NoInput,
    /// The species is not known.
    #[error(transparent)]
    Species(#[from] UnknownSpecies),
    /// The species' strength is not known.
    #[error(transparent)]
    Strength(#[from] StrengthError),
    /// No rods.
    #[error(transparent)]
    Placement(#[from] PlacementError),
    /// The motion cannot go on.
    #[error("{error}; the checkpoint at {checkpoint} s is kept")]
    Solver {
        /// Why.
        error: SolverError,
        /// Time of the last checkpoint, s.
        checkpoint: f64,
    },
    /// A body's mesh file cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// Something stored is of another run, or damaged.
    #[error("{}: {error}", path.display())]
    Store {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: StoreError,
    },
    /// A checkpoint of bodies that are others.
    #[error(transparent)]
    Bodies(#[from] BodyError),
    /// The folder already holds a run.
    #[error("{}: already holds a simulation; resume it, or choose another folder", folder.display())]
    Taken {
        /// The folder.
        folder: PathBuf,
    },
    /// There is nothing to resume.
    #[error("{}: holds no checkpoint to resume from", folder.display())]
    NothingToResume {
        /// The folder.
        folder: PathBuf,
    },
    /// The checkpoint is of another simulation.
    #[error(
        "{}: is the checkpoint of another simulation: scene, input or seed differ; resume with those it was begun with",
        path.display()
    )]
    OtherRun {
        /// The checkpoint.
        path: PathBuf,
    },
    /// A file is shorter than the checkpoint says.
    #[error("{}: has {found} bytes, but the checkpoint was written when it had {expected}; it was changed since", path.display())]
    Short {
        /// The file.
        path: PathBuf,
        /// Its length.
        found: u64,
        /// What it must have at least.
        expected: u64,
    },
    /// The disk is full, or the like.
    #[error("{}: cannot be written: {source}; what the checkpoint holds is kept, and the run can be resumed", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The caller stopped the work; the checkpoint is there.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// What is to be simulated, and where it goes.
#[derive(Debug, Clone)]
pub struct SimulateRequest {
    /// The scene.
    pub scene: Setting,
    /// The folder that mesh files of bodies are named from.
    pub beside: PathBuf,
    /// The folder that takes everything.
    pub folder: PathBuf,
    /// Whether to go on from the folder's checkpoint.
    pub resume: bool,
}

/// What a simulation did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SimulateReport {
    /// What the scene shows.
    pub about: String,
    /// Rods at the start.
    pub rods: usize,
    /// Vertices at the start.
    pub vertices: usize,
    /// Bonds at the start.
    pub bonds: usize,
    /// Length of the stem, m.
    pub length_m: f64,
    /// Whether rods resist twist.
    pub twist: bool,
    /// Solver.
    pub solver: String,
    /// Its last step, s.
    pub step_s: f64,
    /// Largest stable step, s; none where there is no limit.
    pub limit_s: Option<f64>,
    /// Steps done.
    pub steps: u64,
    /// Time reached, s.
    pub time_s: f64,
    /// Frames written.
    pub frames: u64,
    /// Rods that broke, edges that yielded, bonds that broke.
    pub broke: [u64; 3],
    /// Time of the first break, s.
    pub first_break_s: Option<f64>,
    /// Energy that breaking took, J.
    pub fracture_loss_j: f64,
    /// Files written.
    pub files: Vec<String>,
}

impl std::fmt::Display for SimulateReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "scene    {}", self.about)?;
        let twist = if self.twist {
            "with twist"
        } else {
            "without twist"
        };
        writeln!(
            f,
            "wood     {} rods, {} vertices, {} bonds on {:.3} m, {twist}",
            self.rods, self.vertices, self.bonds, self.length_m
        )?;
        let limit = self
            .limit_s
            .map_or(String::new(), |l| format!(" of at most {:.3} µs", l * 1e6));
        writeln!(
            f,
            "solver   {}, {} steps of {:.3} µs{limit}",
            self.solver,
            self.steps,
            self.step_s * 1e6
        )?;
        let first = self
            .first_break_s
            .map_or(String::new(), |t| format!(", first at {t:.4} s"));
        let [rods, yields, bonds] = self.broke;
        writeln!(
            f,
            "broke    {rods} rods, {bonds} bonds; {yields} edges yielded{first}; {:.4} J lost",
            self.fracture_loss_j
        )?;
        writeln!(f, "time     {:.4} s in {} frames", self.time_s, self.frames)
    }
}

/// The files that grow.
const GROWING: [&str; 3] = ["energy.csv", "events.csv", "frames.gsf"];
const CHECKPOINT: &str = "checkpoint.bin";

/// The mesh of the scene's stem in the world, m, and where on it.
fn meshes(setting: &Setting, input: Option<&Scene>) -> Result<(Vec<Mesh>, Place), SimulateError> {
    let stem = &setting.stem;
    let mesh = match stem.kind {
        StemWord::Branch => primitive::branch(&BranchOptions {
            length: stem.length.0,
            diameter: stem.diameter.0,
            ..BranchOptions::default()
        }),
        StemWord::Cylinder => primitive::cylinder(0.5 * stem.diameter.0, stem.length.0, 48),
        StemWord::Board => primitive::board(stem.length.0, stem.width.0, stem.thickness.0),
        StemWord::Input => {
            let scene = input.ok_or(SimulateError::NoInput)?;
            let world = scene.nodes.iter().map(|n| Mesh {
                positions: (n.mesh.positions.iter())
                    .map(|&p| n.transform.transform_point3(p))
                    .collect(),
                triangles: n.mesh.triangles.clone(),
                ..Mesh::default()
            });
            return Ok((world.collect(), Place::parse(&stem.at, 1.0)?));
        }
    };
    Ok((vec![mesh], Place::parse("0.5", 1.0)?))
}

/// The scene as a world with bodies, and the hash of what it depends on.
fn prepare(
    request: &SimulateRequest,
    input: Option<&Scene>,
    context: &Context,
) -> Result<(SetUp, u64), SimulateError> {
    let setting = &request.scene;
    setting.check()?;
    let species = Species::find(&setting.wood.species)?;
    let mut wood = WoodMaterial::of(species, setting.wood.moisture, Fallback::TwelvePercent)?;
    let softer = setting.wood.stiffness;
    for modulus in [
        &mut wood.longitudinal,
        &mut wood.radial,
        &mut wood.tangential,
        &mut wood.shear_radial,
        &mut wood.shear_tangential,
        // Strains at failure stay as they are.
        &mut wood.tension,
        &mut wood.compression,
    ] {
        *modulus *= softer;
    }
    context.step("stem", 0.0)?;
    let (meshes, at) = meshes(setting, input)?;
    let found = find(&meshes, &at, &StemOptions::default(), context)?;
    let (from, to) = found.stem.usable;
    let part = setting.stem.part.map(|p| from + p * (to - from));
    context.step("rods", 0.0)?;
    let keys = &setting.rods;
    let placed = place(
        &found.stem,
        &wood,
        &Placement {
            seed: setting.seed,
            arrangement: match keys.arrangement {
                ArrangementWord::PoissonDisk => Arrangement::PoissonDisk,
                ArrangementWord::Anatomy => Arrangement::Anatomy,
            },
            rods: match keys.spacing {
                Some(spacing) => HowMany::Spacing(spacing.0),
                None => HowMany::Number(keys.number),
            },
            edges: (keys.edge[0].0, keys.edge[1].0),
            range: Some((part[0], part[1])),
            reach: keys.reach,
            twisting: match keys.twist {
                TwistWord::Auto => None,
                TwistWord::On => Some(true),
                TwistWord::Off => Some(false),
            },
            weibull: keys.weibull.unwrap_or(f64::INFINITY),
            rings: keys.rings,
            rays: keys.rays,
            ring_strength: keys.ring_strength,
            ray_strength: keys.ray_strength,
        },
    )?;
    let shapes = body_files(request)?;
    let made = set_up(setting, placed.bundle, &placed.along, &shapes)?;
    // The duration may grow when a run is resumed; everything else must be as it was.
    let lasting = Setting {
        duration: 0.0,
        ..setting.clone()
    };
    let mut all = lasting.to_toml().into_bytes();
    let position = &made.world.state.position;
    for part in [&position.x, &position.y, &position.z] {
        part.iter()
            .for_each(|v| all.extend(v.to_bits().to_le_bytes()));
    }
    Ok((made, checksum(&all)))
}

/// The meshes that bodies name.
fn body_files(request: &SimulateRequest) -> Result<Vec<Option<Shape>>, SimulateError> {
    let mut shapes = Vec::new();
    for body in &request.scene.body {
        if body.file.is_empty() {
            shapes.push(None);
            continue;
        }
        let scene = files::read(&request.beside.join(&body.file), None)?;
        let mut numbers = std::collections::BTreeMap::new();
        let (mut points, mut triangles): (Vec<DVec3>, Vec<[u32; 3]>) = Default::default();
        for node in &scene.nodes {
            for t in 0..node.mesh.triangles.len() {
                triangles.push(node.mesh.corners(t).map(|p| {
                    let p = node.transform.transform_point3(p) + DVec3::ZERO;
                    *numbers
                        .entry(p.to_array().map(f64::to_bits))
                        .or_insert_with(|| {
                            points.push(p);
                            points.len() as u32 - 1
                        })
                }));
            }
        }
        shapes.push(Some(match body.shape {
            greenstick_fibre::scene::ShapeWord::Hull => Shape::Hull { points },
            _ => Shape::Mesh { points, triangles },
        }));
    }
    Ok(shapes)
}

/// The three files that grow, open for appending.
struct Growing {
    paths: [PathBuf; 3],
    files: [BufWriter<File>; 3],
    bytes: [u64; 3],
}

impl Growing {
    fn open(folder: &Path, bytes: Option<[u64; 3]>) -> Result<Self, SimulateError> {
        let paths = GROWING.map(|name| folder.join(name));
        let mut opened = Vec::new();
        for (k, path) in paths.iter().enumerate() {
            let fail = |source| SimulateError::Unwritable {
                path: path.clone(),
                source,
            };
            let file = OpenOptions::new()
                .create(true)
                .append(true)
                .open(path)
                .map_err(fail)?;
            let expected = bytes.map_or(0, |b| b[k]);
            let found = file.metadata().map_err(fail)?.len();
            if found < expected {
                return Err(SimulateError::Short {
                    path: path.clone(),
                    found,
                    expected,
                });
            }
            file.set_len(expected).map_err(fail)?;
            opened.push(BufWriter::new(file));
        }
        let files = opened
            .try_into()
            .map_err(|_| SimulateError::NothingToResume {
                folder: folder.to_owned(),
            })?;
        Ok(Growing {
            paths,
            files,
            bytes: bytes.unwrap_or_default(),
        })
    }

    fn write(&mut self, which: usize, bytes: &[u8]) -> Result<(), SimulateError> {
        self.bytes[which] += bytes.len() as u64;
        self.files[which]
            .write_all(bytes)
            .map_err(|source| SimulateError::Unwritable {
                path: self.paths[which].clone(),
                source,
            })
    }

    fn flush(&mut self) -> Result<(), SimulateError> {
        for (file, path) in self.files.iter_mut().zip(&self.paths) {
            file.flush().map_err(|source| SimulateError::Unwritable {
                path: path.clone(),
                source,
            })?;
        }
        Ok(())
    }
}

/// A run between two ticks.
struct Run<'a> {
    request: &'a SimulateRequest,
    made: SetUp,
    hash: u64,
    progress: Progress,
    growing: Growing,
    saved: f64,
}

impl Run<'_> {
    fn start(&mut self) -> Result<(), SimulateError> {
        let scene = Output {
            path: self.request.folder.join("scene.toml"),
            bytes: self.request.scene.to_toml().into_bytes(),
        };
        files::write_all(&[scene])?;
        self.growing.write(0, ENERGY_HEADER.as_bytes())?;
        self.growing.write(1, EVENT_HEADER.as_bytes())?;
        let mut head = Vec::new();
        // Memory takes every byte.
        let _ = write_header(&mut head);
        self.growing.write(2, &head)?;
        self.record(true)?;
        self.save()
    }

    /// Writes what belongs to the present time.
    fn record(&mut self, frame: bool) -> Result<(), SimulateError> {
        let world = &mut self.made.world;
        for event in std::mem::take(&mut world.events) {
            self.growing.write(1, event_row(&event).as_bytes())?;
            self.progress.events += 1;
        }
        let row = EnergyRow::of(world, &self.made.bodies, &self.progress.ledger);
        self.growing.write(0, row.line().as_bytes())?;
        if frame {
            let bodies: Vec<_> = self.made.bodies.iter().map(|b| b.1).collect();
            let mut bytes = Vec::new();
            let _ = Frame::of(&world.bundle, &world.state, &bodies).write(&mut bytes);
            self.growing.write(2, &bytes)?;
            self.progress.frames += 1;
        }
        Ok(())
    }

    fn save(&mut self) -> Result<(), SimulateError> {
        self.growing.flush()?;
        self.progress.bytes = self.growing.bytes;
        let path = self.request.folder.join(CHECKPOINT);
        let point = Checkpoint {
            world: self.made.world.clone(),
            bodies: self.made.bodies.snapshot(),
            progress: self.progress,
        };
        let bytes = point
            .to_bytes(self.hash)
            .map_err(|error| SimulateError::Store {
                path: path.clone(),
                error,
            })?;
        files::write_all(&[Output { path, bytes }])?;
        self.saved = self.made.world.state.time;
        Ok(())
    }

    fn restore(&mut self, point: Checkpoint) -> Result<(), SimulateError> {
        self.made.world = point.world;
        let world = &self.made.world;
        self.made
            .bodies
            .restore(&point.bodies, &world.bundle, &world.loads)?;
        self.progress = point.progress;
        self.saved = world.state.time;
        Ok(())
    }
}

/// The checkpoint in a folder, if it is one of the simulation `hash`.
fn checkpoint(folder: &Path, hash: u64) -> Result<Checkpoint, SimulateError> {
    let path = folder.join(CHECKPOINT);
    let bytes = fs::read(&path).map_err(|source| FileError::Unreadable {
        path: path.clone(),
        source,
    })?;
    let (point, of) = Checkpoint::from_bytes(&bytes).map_err(|error| SimulateError::Store {
        path: path.clone(),
        error,
    })?;
    if of == hash {
        Ok(point)
    } else {
        Err(SimulateError::OtherRun { path })
    }
}

/// Simulates a scene, on the mesh `input` where the scene is of one, and writes everything into the request's folder.
/// `energy.csv` and `events.csv` can be read while it runs.
///
/// # Errors
/// [`SimulateError`]. Whatever happens, the last checkpoint is kept and can be resumed from.
pub fn simulate(
    input: Option<&Scene>,
    request: &SimulateRequest,
    context: &Context,
) -> Result<SimulateReport, SimulateError> {
    let (made, hash) = prepare(request, input, context)?;
    let folder = &request.folder;
    let taken = folder.join(CHECKPOINT).exists();
    if taken && !request.resume {
        return Err(SimulateError::Taken {
            folder: folder.clone(),
        });
    }
    if request.resume && !taken {
        return Err(SimulateError::NothingToResume {
            folder: folder.clone(),
        });
    }
    fs::create_dir_all(folder).map_err(|source| SimulateError::Unwritable {
        path: folder.clone(),
        source,
    })?;
    let mut report = begin_report(request, &made);
    // Of a run that is resumed nothing is cut before its checkpoint is known to be good.
    let point = if taken {
        Some(checkpoint(folder, hash)?)
    } else {
        None
    };
    let growing = Growing::open(folder, point.as_ref().map(|p| p.progress.bytes))?;
    let mut run = Run {
        request,
        made,
        hash,
        progress: Progress::default(),
        growing,
        saved: 0.0,
    };
    match point {
        Some(point) => run.restore(point)?,
        None => run.start()?,
    }
    advance(&mut run, &mut report, context)?;
    run.save()?;
    finish_report(&mut report, &run)?;
    Ok(report)
}

/// Moves the run on to its end.
fn advance(
    run: &mut Run,
    report: &mut SimulateReport,
    context: &Context,
) -> Result<(), SimulateError> {
    let scene = &run.request.scene;
    let mut solver = scene.solver.make(scene.step);
    let rows = scene.rows_per_second;
    let ticks = (scene.duration * rows).round() as u64;
    let frame_of = |tick: u64| (tick as f64 * scene.frames_per_second / rows + 1e-9).floor() as u64;
    while run.progress.ticks < ticks {
        let done = run.progress.ticks as f64 / ticks as f64;
        if let Err(stop) = context.step("simulate", done) {
            run.save()?;
            return Err(stop.into());
        }
        let next = run.progress.ticks + 1;
        let left = next as f64 / rows - run.made.world.state.time;
        let moved = solver
            .advance(&mut run.made.world, &mut run.made.bodies, left.max(0.0))
            .map_err(|error| SimulateError::Solver {
                error,
                checkpoint: run.saved,
            })?;
        run.progress.ledger.add(&moved);
        run.progress.ticks = next;
        report.step_s = moved.step;
        report.limit_s = moved.limit.is_finite().then_some(moved.limit);
        let frame = frame_of(next) > frame_of(next - 1);
        run.record(frame)?;
        if frame {
            run.save()?;
        }
    }
    Ok(())
}

fn begin_report(request: &SimulateRequest, made: &SetUp) -> SimulateReport {
    let bundle = &made.world.bundle;
    SimulateReport {
        about: request.scene.about.clone(),
        rods: bundle.rods(),
        vertices: bundle.vertices(),
        bonds: bundle.bonds.len(),
        length_m: made.length,
        twist: bundle.twisting,
        solver: request.scene.solver.name().to_owned(),
        step_s: 0.0,
        limit_s: None,
        steps: 0,
        time_s: 0.0,
        frames: 0,
        broke: [0; 3],
        first_break_s: None,
        fracture_loss_j: 0.0,
        files: Vec::new(),
    }
}

/// Takes counts from the files, so that those of a resumed run are of all of it.
fn finish_report(report: &mut SimulateReport, run: &Run) -> Result<(), SimulateError> {
    let world = &run.made.world;
    (report.steps, report.time_s) = (world.state.step, world.state.time);
    report.frames = run.progress.frames;
    report.fracture_loss_j = world.fracture_loss;
    let path = run.request.folder.join(GROWING[1]);
    let text =
        fs::read_to_string(&path).map_err(|source| FileError::Unreadable { path, source })?;
    for line in text.lines().skip(1) {
        let mut cells = line.split(',');
        let time = cells.next().and_then(|t| t.parse().ok());
        match cells.next() {
            Some("rod_broke") => report.broke[0] += 1,
            Some("rod_yielded") => report.broke[1] += 1,
            Some("bond_broke") => report.broke[2] += 1,
            _ => {}
        }
        if !line.contains("rod_yielded") && report.first_break_s.is_none() {
            report.first_break_s = time;
        }
    }
    report.files = GROWING
        .iter()
        .chain(&[CHECKPOINT, "scene.toml"])
        .map(|n| run.request.folder.join(n).display().to_string())
        .collect();
    Ok(())
}

/// The frames of a run, in order.
///
/// # Errors
/// [`SimulateError`] where they are not there or damaged.
pub fn frames(folder: &Path) -> Result<Vec<Frame>, SimulateError> {
    let path = folder.join(GROWING[2]);
    let wrong = |error| SimulateError::Store {
        path: path.clone(),
        error,
    };
    let file = File::open(&path).map_err(|e| wrong(e.into()))?;
    FrameReader::new(BufReader::new(file))
        .map_err(wrong)?
        .collect::<Result<_, _>>()
        .map_err(wrong)
}

/// Upwards in a scene.
pub const UP: DVec3 = DVec3::Z;

/// Energies over time, from the table of a run.
///
/// # Errors
/// [`SimulateError`] where the table is not there.
pub fn energy_chart(folder: &Path) -> Result<Picture, SimulateError> {
    let path = folder.join(GROWING[0]);
    let text =
        fs::read_to_string(&path).map_err(|source| FileError::Unreadable { path, source })?;
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|l| l.split(',').filter_map(|c| c.parse().ok()).collect())
        .filter(|r: &Vec<f64>| r.len() == 20)
        .collect();
    // What an energy of the table is in the picture: columns that are added.
    let curves: [(&str, &[usize]); 6] = [
        ("kinetic", &[1]),
        ("stretch", &[2]),
        ("bend, twist", &[3, 4]),
        ("bonds", &[5, 6]),
        ("fracture", &[14]),
        ("rods in all", &[1, 2, 3, 4, 5, 6]),
    ];
    let lines = curves.map(|(name, columns)| Line {
        name: name.to_owned(),
        points: rows
            .iter()
            .map(|r| [r[0], columns.iter().map(|&c| r[c]).sum()])
            .collect(),
    });
    Ok(Chart {
        title: "Energies".to_owned(),
        axes: ["time (s)".to_owned(), "energy (J)".to_owned()],
        lines: lines.to_vec(),
    }
    .draw(1200, 700))
}
