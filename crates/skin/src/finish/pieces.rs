//! Separate pieces of a break: frayed, hung, and rounded to the precision of files.

use super::budget::added_triangles;
use super::notes::{notes_on_cracks, notes_up_to_the_cut};
use super::parting::{Parting, Separation};
use super::piece::{Piece, PieceRole, Pieces};
use crate::broken::InnerWood;
use crate::error::BreakError;
use crate::fray::FrayedBreak;
use crate::fuzz::{FuzzOptions, HingeOptions, fuzz};
use crate::hang::{hang, wedge};
use crate::lean::{LeanReport, LeaningPiece};
use crate::report::{BreakNote, PieceReport};
use crate::stages::{BreakStages, has_spiral_grain};
use glam::DAffine3;
use greenstick_fracture::parameters::{BreakParameters, SurfaceStyle};
use greenstick_geometry::repair::{Rounded, round_halves_to_f32, round_to_f32};
use greenstick_geometry::{Cancelled, Context, Mesh};
use rayon::prelude::*;
use std::sync::Arc;

/// Triangles up to which pieces are written at the same time: with more, the memory that it takes counts more than the time.
const MOST_AT_ONCE: usize = 2_000_000;

/// Mean lean of splinters (degrees), and the share of them that snap, where nothing else is requested.
const LEAN: f64 = 8.0;
const SNAPPED: f64 = 0.2;

/// How a break is finished.
#[derive(Debug, Clone, Copy)]
pub struct FinishOptions<'a> {
    /// Parameters of the face that was made, as requested.
    pub face: &'a BreakParameters,
    /// Those that were asked for, which may be finer.
    pub asked: &'a BreakParameters,
    /// How much thorns are bent and torn loose, from 0 (not at all) to 1.
    pub fray: f64,
    /// How far the pieces are moved apart.
    pub separation: Separation,
    /// The most triangles that the pieces may have beyond those of the stem, if there is a limit. Fuzz takes what they leave.
    pub most_triangles: Option<u32>,
}

/// Makes the pieces of a break from its stages up to the cut.
///
/// # Errors
/// [`BreakError`] where splinters cannot be cut loose, or the caller cancelled.
pub fn finish(
    stages: &BreakStages,
    options: &FinishOptions,
    context: &Context,
) -> Result<Pieces, BreakError> {
    let stem = stages.stem.stem();
    let p = &stages.stem.face;
    let inner = stages.inner_wood(p);
    // Reports need it; of a large mesh it takes as much memory as the pieces, which are not there yet.
    stages.stem.sound.closed_volume();
    let mut notes = notes_up_to_the_cut(stages, p);
    context.check()?;
    let plain = plain_pieces(stages, options, &mut notes);
    context.check()?;
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
    let parting = Parting::new(stages, context);
    context.check()?;
    let asked = options.separation;
    if options.fray > 0.0 {
        // Loose splinters lie between the pieces.
        let halves = [&lower, &upper];
        let way = parting.way(asked, halves).way;
        context.check()?;
        let made = frayed(stages, (options, way), inner, halves, context)?;
        notes.extend(made.notes);
        ([lower, upper], splinters) = (made.halves, made.splinters);
    }
    let leans = lean(stages, asked.way, &mut [&mut lower, &mut upper], context)?;
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
    let turn = turn.unwrap_or_default();
    let parted = parting.way(asked, [&lower, &upper]);
    context.check()?;
    notes.extend(parted.note);
    let moved = parting.after(parted.way) * turn;
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
    made.write_meshes(stages, meshes, context)?;
    context.check()?;
    for (report, lean) in made.reports.iter_mut().zip(leans.into_iter().flatten()) {
        report.lean = Some(lean);
    }
    let apart = asked.way > 0.0 || p.hang > 0.0;
    made.add_fuzz(stages, options.most_triangles, apart);
    made.notes.extend(notes_on_cracks(stages));
    Ok(made)
}

/// Both halves with their splinters bent, the splinters that came loose with their motions, and what is to be said of them.
struct FrayedHalves {
    halves: [Mesh; 2],
    splinters: Vec<(Mesh, DAffine3)>,
    notes: Vec<BreakNote>,
}

/// Frays both halves of a break whose pieces move apart by `way` (m).
fn frayed(
    stages: &BreakStages,
    (options, way): (&FinishOptions, f64),
    inner: InnerWood,
    pieces: [&Mesh; 2],
    context: &Context,
) -> Result<FrayedHalves, BreakError> {
    let amount = options.fray.min(1.0);
    let made = FrayedBreak {
        stem: stages.stem.stem(),
        layout: &stages.layout,
        heights: &stages.heights.heights,
        inner,
        pieces,
        amount,
        separation: way,
        seed: stages.stem.face.seed,
        context,
    }
    .fray()?;
    let mut notes = Vec::new();
    for (role, report) in [PieceRole::Lower, PieceRole::Upper].iter().zip(made.bends) {
        notes.push(BreakNote::Bent {
            piece: role.name(),
            report,
            requested: amount,
        });
    }
    if made.splinters.is_empty() {
        notes.push(BreakNote::NoSplinters);
    }
    Ok(FrayedHalves {
        halves: made.pieces,
        splinters: made.splinters,
        notes,
    })
}

/// Makes the splinters of both halves, which move apart by `way` (m), lean, and returns how they do.
fn lean(
    stages: &BreakStages,
    way: f64,
    halves: &mut [&mut Mesh; 2],
    context: &Context,
) -> Result<Option<[LeanReport; 2]>, Cancelled> {
    let p = &stages.stem.face;
    // Halves that lie in each other have had no room to spring apart.
    let (lean, snap) = if way > 0.0 || p.hang > 0.0 {
        (LEAN, SNAPPED)
    } else {
        (0.0, 0.0)
    };
    let degrees = p.splinter_lean.unwrap_or(lean);
    let snapped = p.splinter_snap.unwrap_or(snap);
    if (degrees == 0.0 && snapped == 0.0) || p.surface == SurfaceStyle::Smooth {
        return Ok(None);
    }
    let stem = stages.stem.stem();
    let bend = |mesh: &Mesh, upper: bool| {
        let straight = mesh.volume() * stem.volume_scale();
        context.check()?;
        let mut leaned = LeaningPiece {
            stem,
            surface: &stages.heights.heights.surface,
            cells: stages.layout.bundles.bundles.len(),
            upper,
            degrees,
            snapped,
            seed: p.seed,
            context,
        }
        .bend(mesh)?;
        leaned.report.straight_volume_m3 = stem.closed_volume().0.then_some(straight);
        Ok::<_, Cancelled>(leaned)
    };
    let [lower, upper] = halves;
    let (below, above) = rayon::join(|| bend(lower, false), || bend(upper, true));
    let (below, above) = (below?, above?);
    (**lower, **upper) = (below.mesh, above.mesh);
    Ok(Some([below.report, above.report]))
}

/// The pieces without cracks. A face that is coarser than asked for is noted, and with it the skin has as few triangles as there
/// can be.
fn plain_pieces(
    stages: &BreakStages,
    options: &FinishOptions,
    notes: &mut Vec<BreakNote>,
) -> [Mesh; 2] {
    let p = &stages.stem.face;
    let [made, asked] = [options.face, options.asked].map(|p| [p.rings, p.sectors]);
    if made != asked {
        notes.push(BreakNote::Coarser { made, asked });
    }
    // Bending takes the parts of split triangles.
    let together = made != asked && options.fray == 0.0;
    let piece = |upper| match together {
        true => stages.piece_put_together(p, upper),
        false => stages.piece(p, upper),
    };
    let (lower, upper) = rayon::join(|| piece(false), || piece(true));
    [lower, upper]
}

impl Pieces {
    /// Rounds meshes to the precision of files and adds them.
    fn write_meshes(
        &mut self,
        stages: &BreakStages,
        meshes: Vec<(PieceRole, Mesh, DAffine3)>,
        context: &Context,
    ) -> Result<(), Cancelled> {
        let inner = stages.stem.inner_material;
        // Self-intersections of the input are left as they are.
        let known = stages.stem.sound.known_positions();
        let scale = stages.stem.sound.volume_scale();
        let report = |role: PieceRole, mesh: &Mesh, rounded: &Rounded| PieceReport {
            name: role.name(),
            triangles: mesh.triangles.len(),
            volume_m3: rounded.volume.map(|v| v * scale),
            closed: rounded.closed,
            fuzz_triangles: 0,
            lean: None,
        };
        let mut meshes = meshes;
        let triangles: usize = meshes.iter().map(|(_, mesh, _)| mesh.triangles.len()).sum();
        let round = |(_, mesh, _): &mut (PieceRole, Mesh, DAffine3)| {
            round_to_f32(mesh, inner, known, context)
        };
        let rounded: Result<Vec<Rounded>, Cancelled> = match &mut meshes[..] {
            all if triangles > MOST_AT_ONCE => all.iter_mut().map(round).collect(),
            [lower, upper, splinters @ ..] => {
                let halves = [&mut lower.1, &mut upper.1];
                let (halves, splinters) = rayon::join(
                    || round_halves_to_f32(halves, inner, known, context),
                    || splinters.par_iter_mut().map(round).collect::<Vec<_>>(),
                );
                halves?.into_iter().map(Ok).chain(splinters).collect()
            }
            few => few.iter_mut().map(round).collect(),
        };
        for ((role, mesh, motion), rounded) in meshes.into_iter().zip(rounded?) {
            let (report, collapsed) = (report(role, &mesh, &rounded), rounded.collapsed);
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
                fuzz: None,
                motion,
            });
        }
        Ok(())
    }

    /// Adds the fuzz of both halves, as far as `most` triangles beyond those of the stem leave room for it. `apart` says whether the
    /// halves were moved off each other.
    fn add_fuzz(&mut self, stages: &BreakStages, most: Option<u32>, apart: bool) {
        let (stem, p) = (stages.stem.stem(), &stages.stem.face);
        if p.fuzz == 0.0 || p.surface == SurfaceStyle::Smooth {
            return;
        }
        let room = most.map_or(usize::MAX, |most| {
            (most as usize).saturating_sub(added_triangles(stages, self))
        });
        let upper = self
            .pieces
            .iter()
            .find(|piece| piece.role == PieceRole::Upper);
        let hinge = (self.hang.as_ref())
            .and_then(|_| wedge(stem, p))
            .zip(upper.map(|piece| piece.motion));
        let of_half = |piece: &Piece| {
            let upper = match piece.role {
                PieceRole::Lower => false,
                PieceRole::Upper => true,
                PieceRole::Segment(_) | PieceRole::Splinter(_) => return None,
            };
            let options = FuzzOptions {
                amount: p.fuzz,
                most_triangles: room / 2,
                apart,
                upper,
                material: stages.stem.inner_material,
                stem: &stem.found.stem,
                square: stem.square,
                units_per_metre: 1.0 / stem.volume_scale().cbrt(),
                seed: p.seed,
            };
            let hinge = hinge
                .filter(|_| !upper)
                .map(|(wedge, motion)| HingeOptions {
                    fuzz: options,
                    layers: &stem.layers,
                    transform: *stem.transform(),
                    surface: &stages.heights.heights.surface,
                    toward: wedge.toward,
                    from: wedge.from,
                    motion,
                });
            let made = fuzz(&piece.mesh, &options, hinge.as_ref());
            (!made.triangles.is_empty()).then(|| Arc::new(made))
        };
        let made: Vec<_> = self.pieces.par_iter().map(of_half).collect();
        for ((piece, report), fuzz) in self.pieces.iter_mut().zip(&mut self.reports).zip(made) {
            report.fuzz_triangles = fuzz.as_ref().map_or(0, |mesh| mesh.triangles.len());
            piece.fuzz = fuzz;
        }
    }
}
