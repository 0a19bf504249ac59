//! The finish of a break: separate pieces, frayed, hung, and rounded to the precision of files.

use super::notes::BreakNote;
use super::stages::{BreakStages, has_spiral_grain};
use crate::Error;
use crate::report::PieceReport;
use crate::request::Break;
use glam::DAffine3;
use greenstick_fracture::parameters::BreakParameters;
use greenstick_geometry::Mesh;
use greenstick_geometry::repair::{KnownPositions, resolve_self_intersections, snap_to_f32};
use greenstick_skin::cracks::EndOfStem;
use greenstick_skin::fray::FrayedBreak;
use greenstick_skin::hang::{HangReport, hang};
use rayon::prelude::*;
use std::sync::Arc;

/// The part that a piece has in a broken stem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PieceRole {
    /// What stays at the base.
    Lower,
    /// What lies beyond the break.
    Upper,
    /// The piece of this number, counted from 0 at the base, of a stem that is broken at several locations.
    Segment(usize),
    /// A splinter that came loose.
    Splinter(usize),
}

impl PieceRole {
    /// Name of the piece's node.
    pub fn name(self) -> String {
        match self {
            PieceRole::Lower => "lower".to_owned(),
            PieceRole::Upper => "upper".to_owned(),
            PieceRole::Segment(number) => format!("piece_{number}"),
            PieceRole::Splinter(number) => format!("splinter_{number:03}"),
        }
    }
}

/// A piece of a break.
#[derive(Debug, Clone)]
pub struct Piece {
    /// Its role.
    pub role: PieceRole,
    /// Its mesh, in the coordinates of the node that was cut.
    pub mesh: Arc<Mesh>,
    /// Its motion in the world from where it was in the unbroken stem.
    pub motion: DAffine3,
}

/// The pieces of a break.
#[derive(Debug, Clone)]
pub struct Pieces {
    /// The lower piece, the upper one, then splinters.
    pub pieces: Vec<Piece>,
    /// A report on each of them.
    pub reports: Vec<PieceReport>,
    /// How the upper piece hangs, if it does.
    pub hang: Option<HangReport>,
    /// Volume of the cracks, m³; none if there are no cracks.
    pub crack_volume_m3: Option<f64>,
    /// The sawn end that has cracks, if any.
    pub end: Option<EndOfStem>,
    /// What was assumed, limited or repaired.
    pub notes: Vec<BreakNote>,
}

/// One break of a request, with its stages and pieces.
#[derive(Debug, Clone)]
pub struct BreakPieces {
    /// Its index in the request.
    pub number: usize,
    /// The break that was requested; if the request has several, its location is a point.
    pub requested: Break,
    /// Its stages up to the cut.
    pub stages: BreakStages,
    /// Its pieces.
    pub pieces: Arc<Pieces>,
}

/// Makes the pieces of a break from its stages up to the cut.
pub(super) fn finish(stages: &BreakStages, requested: &Break) -> Result<Pieces, Error> {
    let stem = stages.stem.stem();
    let p = &requested.recipe.face;
    let inner = stages.inner_wood(p);
    let mut notes = notes_up_to_the_cut(stages, requested);
    let (lower, upper) = rayon::join(|| stages.piece(p, false), || stages.piece(p, true));
    let plain = [lower, upper];
    let mut crack_volume = stages.stem.opened.as_ref().map(|opened| opened.void);
    let [mut lower, mut upper] = match &stages.cut.cracked {
        None => plain,
        Some(faces) => {
            let cracked =
                [false, true].map(|upper| faces[usize::from(upper)].piece(stem, &inner, upper));
            let volume = |pieces: &[Mesh; 2]| (pieces[0].volume(), pieces[1].volume());
            let ((a, b), (c, d)) = (volume(&plain), volume(&cracked));
            crack_volume = Some((a + b - c - d) * stem.volume_scale());
            cracked
        }
    };
    let mut splinters = Vec::new();
    if requested.fray > 0.0 {
        let amount = requested.fray.min(1.0);
        let made = FrayedBreak {
            stem,
            layout: &stages.layout,
            heights: &stages.heights.heights,
            inner,
            pieces: [&lower, &upper],
            amount,
            separation: requested.separation,
            seed: p.seed,
        }
        .fray()?;
        [lower, upper] = made.pieces;
        for (role, report) in [PieceRole::Lower, PieceRole::Upper].iter().zip(made.bends) {
            notes.push(BreakNote::Bent {
                piece: role.name(),
                report,
                requested: amount,
            });
        }
        splinters = made.splinters;
        if splinters.is_empty() {
            notes.push(BreakNote::NoSplinters);
        }
    }
    if p.spiral_angle != 0.0 && !has_spiral_grain(stem, p) {
        notes.push(BreakNote::NoSpiralGrain);
    }
    let range = stages.heights.heights.range;
    let (turn, hang) = hang(stem, p, [&lower, &upper], range).unzip();
    if let Some(h) = hang.as_ref().filter(|h| h.angle_degrees > p.hang) {
        notes.push(BreakNote::HangsWider {
            angle: h.angle_degrees,
            requested: p.hang,
        });
    }
    let moved =
        DAffine3::from_translation(along(stages) * requested.separation) * turn.unwrap_or_default();
    let mut meshes = vec![
        (PieceRole::Lower, lower, DAffine3::IDENTITY),
        (PieceRole::Upper, upper, moved),
    ];
    let splinters = splinters.into_iter().enumerate();
    meshes.extend(splinters.map(|(i, (mesh, motion))| (PieceRole::Splinter(i), mesh, motion)));
    let mut made = Pieces {
        pieces: Vec::new(),
        reports: Vec::new(),
        hang,
        crack_volume_m3: crack_volume,
        end: stages.stem.opened.as_ref().map(|opened| opened.end),
        notes,
    };
    made.write_meshes(stages, meshes);
    made.notes.extend(notes_on_cracks(stages));
    Ok(made)
}

/// Returns the direction of the stem at the break.
fn along(stages: &BreakStages) -> glam::DVec3 {
    let stem = &stages.stem.stem().found.stem;
    stem.grain.axis().frame(stem.location).tangent
}

impl Pieces {
    /// Rounds meshes to the precision of files and adds them.
    fn write_meshes(&mut self, stages: &BreakStages, meshes: Vec<(PieceRole, Mesh, DAffine3)>) {
        let inner = stages.stem.inner_material;
        // Self-intersections of the input are left as they are.
        let known = KnownPositions::from_mesh(&stages.stem.sound.node().mesh);
        let scale = stages.stem.sound.volume_scale();
        let meshes = meshes.into_par_iter().map(|(role, mut mesh, motion)| {
            snap_to_f32(&mut mesh, inner);
            let collapsed = resolve_self_intersections(&mut mesh, &known);
            let report = PieceReport::new(&role.name(), &mesh, scale);
            (role, mesh, motion, collapsed, report)
        });
        let meshes: Vec<_> = meshes.collect();
        for (role, mesh, motion, collapsed, report) in meshes {
            if collapsed.faults > 0 {
                self.notes.push(BreakNote::SelfIntersectionsResolved {
                    piece: role.name(),
                    collapsed,
                    longest_m: collapsed.longest * scale.cbrt(),
                });
            }
            self.reports.push(report);
            self.pieces.push(Piece {
                role,
                mesh: mesh.into(),
                motion,
            });
        }
    }
}

/// Returns the notes on the stages up to the cut.
fn notes_up_to_the_cut(stages: &BreakStages, requested: &Break) -> Vec<BreakNote> {
    let p: &BreakParameters = &requested.recipe.face;
    let heights = &stages.heights.heights;
    let stem = &stages.stem.stem().found.stem;
    let mut notes: Vec<BreakNote> = stages.heights.relief.note.iter().cloned().collect();
    if let Some(cracks) = &stages.cracks {
        notes.push(BreakNote::CrackShrinkage(cracks.shrinkage.clone()));
        if cracks.moved > 0 {
            notes.push(BreakNote::CracksMoved {
                moved: cracks.moved,
                rings: p.rings,
            });
        }
    }
    if heights.limited > 0 {
        notes.push(BreakNote::HeightsLimited {
            corners: heights.limited,
            wanted: heights.wanted,
            free: (stem.usable.0 - stem.location, stem.usable.1 - stem.location),
        });
    }
    let face = &stages.cut.face;
    if face.chips > 0 {
        notes.push(BreakNote::ChipsMoved(face.chips));
    }
    if let Some(repair) = face.spiral.filter(|r| r.crossed > 0) {
        notes.push(BreakNote::SpiralRepaired {
            repair,
            longest_m: repair.longest * stages.stem.stem().volume_scale().cbrt(),
        });
    }
    notes
}

/// Returns the notes on the cracks.
fn notes_on_cracks(stages: &BreakStages) -> Vec<BreakNote> {
    let mut notes = Vec::new();
    if let Some(opened) = &stages.stem.opened {
        if opened.sawn_off {
            let fallen = opened.fallen;
            notes.push(BreakNote::EndSawnOff { fallen });
        }
        notes.extend(BreakNote::on_grooves("sawn end", &opened.grooves));
    }
    if let Some(faces) = &stages.cut.cracked {
        let [lower, upper] = &**faces;
        notes.extend(BreakNote::on_grooves("lower face", &lower.grooves));
        notes.extend(BreakNote::on_grooves("upper face", &upper.grooves));
    }
    notes.extend(
        stages
            .cracks
            .as_ref()
            .and_then(|c| BreakNote::on_plan(&c.plan)),
    );
    notes
}
