//! Notes on a break beside its figures.

use crate::broken::SpiralRepair;
use crate::fray::BendReport;
use greenstick_fracture::cracks::{CrackPlan, GroovedSurface};
use greenstick_fracture::recipe::CrackShrinkage;
use greenstick_geometry::repair::Collapsed;
use std::fmt;

/// Something that was assumed, limited, repaired or not possible. Its text is a sentence without a full stop.
#[derive(Debug, Clone, PartialEq)]
pub enum BreakNote {
    /// The height of the face does not follow the species, for this reason.
    NoSpeciesHeight(String),
    /// The shrinkage that opens the cracks.
    CrackShrinkage(CrackShrinkage),
    /// Tangential cracks were moved to ring boundaries.
    CracksMoved {
        /// How many.
        moved: usize,
        /// Rings of the section.
        rings: u32,
    },
    /// Heights were brought into the length that is free.
    HeightsLimited {
        /// Corners of the face that are limited further than in proportion.
        corners: usize,
        /// Factors on heights below and above the location of the break.
        scales: (f64, f64),
        /// How far the face was moved up, m.
        moved: f64,
        /// Lowest and highest height without a limit, m from the location of the break.
        wanted: (f64, f64),
        /// Lowest and highest height that fits, m from the location of the break.
        free: (f64, f64),
    },
    /// Slivers that would have been loose stay with the other piece.
    ChipsMoved(usize),
    /// A face in spiral grain intersected itself.
    SpiralRepaired {
        /// The repair.
        repair: SpiralRepair,
        /// Length of the longest edge collapsed, m.
        longest_m: f64,
    },
    /// The face is coarser than asked for, so that the pieces have no more triangles than they may.
    Coarser {
        /// Its rings and sectors.
        made: [u32; 2],
        /// The rings and sectors asked for.
        asked: [u32; 2],
    },
    /// A piece was bent.
    Bent {
        /// Name of the piece.
        piece: String,
        /// The bending.
        report: BendReport,
        /// How much was requested, 0 to 1.
        requested: f64,
    },
    /// Splinters were requested, but none came loose.
    NoSplinters,
    /// Spiral grain was requested where there can be none.
    NoSpiralGrain,
    /// The upper piece hangs at a greater angle than requested.
    HangsWider {
        /// The angle, degrees.
        angle: f64,
        /// The angle requested, degrees.
        requested: f64,
    },
    /// A piece that hangs on was not moved apart from the other.
    HangsOn {
        /// The way requested, m.
        requested_m: f64,
    },
    /// Pieces were moved apart farther than requested: on a shorter way they lie in each other.
    PartedFarther {
        /// The way, m.
        way_m: f64,
        /// The way requested, m.
        requested_m: f64,
    },
    /// Pieces that were moved apart lie in each other on every way.
    PartsOverlap {
        /// The volume that they share near the face, m³.
        shared_m3: f64,
    },
    /// A piece intersected itself at the precision of files.
    SelfIntersectionsResolved {
        /// Name of the piece.
        piece: String,
        /// The repair.
        collapsed: Collapsed,
        /// Length of the longest edge collapsed, m.
        longest_m: f64,
    },
    /// The end was sawn off straight before it was cracked.
    EndSawnOff {
        /// Triangles of other shells that fell with it.
        fallen: usize,
    },
    /// The cracks that a face has.
    CracksMade {
        /// Name of the face.
        face: &'static str,
        /// How many.
        cracks: usize,
        /// The widest opening, m.
        widest_m: f64,
        /// The greatest depth, m.
        deepest_m: f64,
    },
    /// Cracks of a face were left out.
    CracksLeftOut {
        /// Name of the face.
        face: &'static str,
        /// How many.
        cracks: usize,
    },
    /// Cracks of a face were made shallower.
    CracksShallower {
        /// Name of the face.
        face: &'static str,
        /// At how many places.
        places: usize,
    },
    /// Cracks were changed so that none cross.
    CracksSeparated {
        /// How many were shortened.
        shortened: usize,
        /// How many were left out.
        left_out: usize,
    },
    /// The stem is not broken at some multiples of a length, as it is not free there, m from its base.
    PlacesLeftOut(Vec<f64>),
    /// A place at a regular distance where no break could be made.
    PlaceFailed {
        /// Length along the stem, m.
        at_m: f64,
        /// Why.
        problem: String,
    },
    /// A note of the caller's own.
    Other(String),
}

impl BreakNote {
    /// Returns the note on a place, a length along the stem in m, where no break could be made.
    pub fn place_failed(at_m: f64, error: &dyn std::error::Error) -> BreakNote {
        BreakNote::PlaceFailed {
            at_m,
            problem: error.to_string(),
        }
    }

    /// Returns the notes on the cracks of a face.
    pub(crate) fn on_grooves(face: &'static str, made: &GroovedSurface) -> Vec<BreakNote> {
        let mut notes = vec![BreakNote::CracksMade {
            face,
            cracks: made.cracks,
            widest_m: made.widest,
            deepest_m: made.deepest,
        }];
        let cracks = made.outside + made.undrawn + made.closed;
        if cracks > 0 {
            notes.push(BreakNote::CracksLeftOut { face, cracks });
        }
        if made.limited > 0 {
            let places = made.limited;
            notes.push(BreakNote::CracksShallower { face, places });
        }
        notes
    }

    /// Returns the note on cracks that would have crossed, if there were any.
    pub(crate) fn on_plan(plan: &CrackPlan) -> Option<BreakNote> {
        let (shortened, left_out) = (plan.shortened, plan.skipped);
        (shortened + left_out > 0).then_some(BreakNote::CracksSeparated {
            shortened,
            left_out,
        })
    }
}

impl fmt::Display for BreakNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BreakNote::NoSpeciesHeight(why) => {
                write!(f, "the height of the face does not follow the species: {why}")
            }
            BreakNote::CrackShrinkage(s) => write!(
                f,
                "cracks open by a shrinkage of {:.1} % along the rings and {:.1} % across ({})",
                s.tangential * 100.0,
                s.radial * 100.0,
                s.basis
            ),
            BreakNote::CracksMoved { moved, rings } => write!(
                f,
                "{moved} tangential cracks were moved to the nearest boundary between two of the {rings} rings"
            ),
            BreakNote::HeightsLimited {
                corners,
                scales,
                moved,
                wanted,
                free,
            } => write!(
                f,
                "the break would have reached from {:.1} to {:.1} mm, but only {:.1} to {:.1} mm along the stem are free: \
                 it was moved by {:.1} mm, heights below were scaled by {:.2}, above by {:.2}, and {corners} corners of the \
                 face limited further",
                wanted.0 * 1e3,
                wanted.1 * 1e3,
                free.0 * 1e3,
                free.1 * 1e3,
                moved * 1e3,
                scales.0,
                scales.1
            ),
            BreakNote::ChipsMoved(chips) => write!(
                f,
                "{chips} slivers that would have been loose stay with the other piece"
            ),
            BreakNote::SpiralRepaired { repair, longest_m } => spiral(f, repair, *longest_m),
            BreakNote::Bent {
                piece,
                report,
                requested,
            } => bent(f, piece, report, *requested),
            BreakNote::NoSplinters => f.write_str(
                "no splinter came loose: no fibre bundle away from the skin stands alone over enough length",
            ),
            BreakNote::Coarser { made, asked } => write!(
                f,
                "{} rings and {} sectors instead of {} and {} keep the break within its triangles",
                made[0], made[1], asked[0], asked[1]
            ),
            BreakNote::NoSpiralGrain => f.write_str(
                "the spiral angle was left out: only the fibrous face of a round stem has spiral grain",
            ),
            hanging @ (BreakNote::HangsWider { .. } | BreakNote::HangsOn { .. }) => {
                on_hanging(f, hanging)
            }
            BreakNote::PartedFarther { way_m, requested_m } => parted(f, *way_m, *requested_m),
            BreakNote::PartsOverlap { shared_m3 } => overlap(f, *shared_m3),
            BreakNote::SelfIntersectionsResolved {
                piece,
                collapsed,
                longest_m,
            } => resolved(f, piece, collapsed, *longest_m),
            BreakNote::PlacesLeftOut(places) => {
                let places: Vec<String> = places.iter().map(|at| format!("{at:.3}")).collect();
                let places = places.join(", ");
                write!(f, "no break at {places} m, where the stem is not free: an end, a fork or another limb is there")
            }
            BreakNote::PlaceFailed { at_m, problem } => {
                write!(f, "no break at {at_m:.3} m: {problem}")
            }
            BreakNote::Other(text) => f.write_str(text),
            cracks => on_cracks(f, cracks),
        }
    }
}

fn on_hanging(f: &mut fmt::Formatter<'_>, note: &BreakNote) -> fmt::Result {
    match note {
        BreakNote::HangsWider { angle, requested } => write!(
            f,
            "the upper piece hangs at {angle:.1}° instead of {requested:.1}°, the least angle at which it is clear of \
             the lower one"
        ),
        BreakNote::HangsOn { requested_m } => write!(
            f,
            "the upper piece hangs on, so the pieces were not moved apart by {:.1} cm; with hang=0 they would be",
            requested_m * 1e2
        ),
        _ => Ok(()),
    }
}

fn on_cracks(f: &mut fmt::Formatter<'_>, note: &BreakNote) -> fmt::Result {
    match note {
        BreakNote::EndSawnOff { fallen } => {
            f.write_str(
                "cracks cannot be cut into the end as it is: it was sawn off straight first, and what was sawn off is \
                 left out",
            )?;
            if *fallen > 0 {
                write!(f, ", with {fallen} triangles of what was attached to it")?;
            }
            Ok(())
        }
        BreakNote::CracksMade {
            face,
            cracks,
            widest_m,
            deepest_m,
        } => write!(
            f,
            "{face}: {cracks} cracks, the widest {:.2} mm, the deepest {:.1} mm",
            widest_m * 1e3,
            deepest_m * 1e3
        ),
        BreakNote::CracksLeftOut { face, cracks } => write!(
            f,
            "{face}: {cracks} cracks were left out: closed, outside the wood, or too fine to draw"
        ),
        BreakNote::CracksShallower { face, places } => write!(
            f,
            "{face}: cracks were made shallower at {places} places to stay in the stem"
        ),
        BreakNote::CracksSeparated {
            shortened,
            left_out,
        } => write!(
            f,
            "{shortened} cracks were shortened and {left_out} left out so that none cross"
        ),
        _ => Ok(()),
    }
}

fn parted(f: &mut fmt::Formatter<'_>, way: f64, requested: f64) -> fmt::Result {
    write!(
        f,
        "the pieces were moved apart by {:.1} cm instead of {:.1} cm, so that their splinters are clear of each other",
        way * 1e2,
        requested * 1e2
    )
}

fn overlap(f: &mut fmt::Formatter<'_>, shared: f64) -> fmt::Result {
    write!(
        f,
        "the pieces lie in each other by {:.3} cm³ however far they are moved apart: parts of the input may overlap",
        shared * 1e6
    )
}

fn spiral(f: &mut fmt::Formatter<'_>, repair: &SpiralRepair, longest_m: f64) -> fmt::Result {
    write!(
        f,
        "{} pairs of triangles of the face in spiral grain crossed; {} edges were split and {} vertices moved by at most {:.0} µm",
        repair.crossed,
        repair.bisected,
        repair.moved,
        longest_m * 1e6
    )?;
    if repair.levelled > 0 {
        write!(
            f,
            ", and {} fibre bundles about them were levelled",
            repair.levelled
        )?;
    }
    if repair.remaining > 0 {
        write!(f, ", {} pairs still cross", repair.remaining)?;
    }
    Ok(())
}

fn bent(
    f: &mut fmt::Formatter<'_>,
    piece: &str,
    report: &BendReport,
    requested: f64,
) -> fmt::Result {
    write!(
        f,
        "{piece}: bending changed the volume by {:+.3} %",
        report.volume_change * 100.0
    )?;
    if report.crossed > 0 {
        write!(
            f,
            "; {} pairs of triangles crossed when bent, and {} edges were split",
            report.crossed, report.bisected
        )?;
    }
    if report.amount < requested {
        write!(
            f,
            "; it was bent by {:.2} instead of {requested:.2}, as more would have made it cross itself",
            report.amount
        )?;
    }
    if report.remaining > 0 {
        write!(f, "; {} pairs still cross", report.remaining)?;
    }
    Ok(())
}

fn resolved(
    f: &mut fmt::Formatter<'_>,
    piece: &str,
    collapsed: &Collapsed,
    longest_m: f64,
) -> fmt::Result {
    write!(
        f,
        "{piece}: {} pairs of triangles crossed or met where the wood is too thin for a file's precision; {} edges of at \
         most {:.2} µm were collapsed",
        collapsed.faults,
        collapsed.edges,
        longest_m * 1e6
    )?;
    if collapsed.remaining > 0 {
        write!(f, ", {} pairs are left", collapsed.remaining)?;
    }
    Ok(())
}
