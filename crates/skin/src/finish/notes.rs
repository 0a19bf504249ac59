//! What is noted of the stages of a break.

use crate::report::BreakNote;
use crate::stages::BreakStages;
use greenstick_fracture::parameters::BreakParameters;

/// Returns the notes on the stages up to the cut.
pub(super) fn notes_up_to_the_cut(stages: &BreakStages, p: &BreakParameters) -> Vec<BreakNote> {
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
    if heights.limited > 0 || heights.scales != (1.0, 1.0) || heights.moved != 0.0 {
        notes.push(BreakNote::HeightsLimited {
            corners: heights.limited,
            scales: heights.scales,
            moved: heights.moved,
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
pub(super) fn notes_on_cracks(stages: &BreakStages) -> Vec<BreakNote> {
    let mut notes = Vec::new();
    if let Some(opened) = &stages.stem.opened {
        if opened.sawn_off {
            let fallen = opened.fallen;
            notes.push(BreakNote::EndSawnOff { fallen });
        }
        let face = if opened.far {
            "sawn end"
        } else {
            "end at the base"
        };
        notes.extend(BreakNote::on_grooves(face, &opened.grooves));
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
