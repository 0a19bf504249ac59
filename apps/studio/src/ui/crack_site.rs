//! Where cracks are placed by hand: on the broken face, or on the sawn end at the stem's tip.

use super::studio::Studio;
use crate::model::placed_cracks::{BARK, CrackFace, Polar};
use crate::view::pick::{Picked, pick};
use eframe::egui::{Pos2, Rect, Ui};
use greenstick::fracture::parameters::CrackEnd;
use std::sync::Arc;

/// How far below its rim bark counts as part of a sawn end, and wood in a crack of it, radii.
const RIM: f32 = 0.15;
const IN_CRACKS: f32 = 1.0;
/// How far below the rim a drag on the bark opens a crack of the end, where cracks are there, radii.
const BESIDE: f32 = 4.0;

/// A face, a place on it, and the height there over the face's, m.
pub(super) type Site = (Arc<CrackFace>, Polar, f32);

impl Studio {
    /// The sawn end as it is drawn.
    pub(super) fn end_face(&mut self) -> Option<Arc<CrackFace>> {
        let (id, drawn) = self.drawn.clone()?;
        let number = self.project.selected().unwrap_or(0);
        let known = self.cracks.end.as_ref();
        if known.is_none_or(|f| (f.0, f.1) != (id, number)) {
            let face = CrackFace::end(&drawn, number).map(Arc::new);
            self.cracks.end = Some((id, number, face));
        }
        self.cracks.end.as_ref().and_then(|f| f.2.clone())
    }

    /// Where the cracks of the selected break are, or the first is being placed.
    pub(super) fn site_end(&self) -> CrackEnd {
        let placing = match self.cracks.at_end {
            true => CrackEnd::Sawn,
            false => CrackEnd::Break,
        };
        self.project.crack_end().unwrap_or(placing)
    }

    /// The face that cracks are placed on.
    pub(super) fn crack_site(&mut self) -> Option<Arc<CrackFace>> {
        match self.site_end() {
            CrackEnd::Break => self.crack_face(),
            CrackEnd::Sawn => self.end_face(),
        }
    }

    /// The place in the section and the height over the site's, m, of what is under the pointer on the piece that the site is part of.
    pub(super) fn place_on_site(
        &self,
        rect: Rect,
        face: &CrackFace,
        pos: Pos2,
    ) -> Option<(Polar, f32)> {
        if self.site_end() == CrackEnd::Break {
            return self.place_on_face(rect, face, pos);
        }
        let drawn = &self.drawn.as_ref()?.1;
        let ray = self.ray_at(rect, pos);
        let picked = pick(drawn, ray, Some(drawn.last_piece()?));
        let place = picked.and_then(|picked| place_of(face, &picked));
        match place {
            Some((at, _)) if at.0 >= BARK && face.is_outside(at.1, ray.1) => place,
            _ => face.seen(ray).or(place),
        }
    }

    /// Decides where a crack is placed that begins at a point of the window, and where on it that is. None beside the wood.
    ///
    /// # Errors
    /// Why no crack can be placed there, and what to do.
    pub(super) fn choose_site(
        &mut self,
        rect: Rect,
        pos: Pos2,
    ) -> Result<Option<Site>, &'static str> {
        if let Some(why) = self.why_no_cracks() {
            return Err(why);
        }
        let on_end = self.is_on_end(rect, pos);
        match (self.project.crack_end(), on_end) {
            (Some(CrackEnd::Break), true) => {
                return Err(
                    "The cracks of this break are in its broken face, and all are in one place: the choice above brings them to the sawn end.",
                );
            }
            (Some(CrackEnd::Sawn), false) => {
                return Err(
                    "The cracks of this break are in the sawn end, and all are in one place: the choice above brings them to the broken face.",
                );
            }
            _ => {}
        }
        if on_end && !self.is_last_break() {
            return Err("The sawn end is that of the break nearest to it: select that one.");
        }
        if self.is_on_base(rect, pos) {
            return Err(
                "Cracks open in the broken face and in the end at the tip. The end at the base has none.",
            );
        }
        self.cracks.at_end = on_end;
        let Some(face) = self.crack_site() else {
            return Ok(None);
        };
        let place = self.place_on_site(rect, &face, pos);
        Ok(place.map(|(place, height)| (face, place, height)))
    }

    /// Whether the selected break is the one nearest to the tip.
    fn is_last_break(&self) -> bool {
        let number = self.project.selected().unwrap_or(0);
        let Some((_, drawn)) = &self.drawn else {
            return false;
        };
        let own = drawn.breaks.get(number).map(|b| b.length);
        own.is_some_and(|own| drawn.breaks.iter().all(|b| b.length <= own))
    }

    /// Whether a point of the window is on the sawn end at the tip.
    fn is_on_end(&mut self, rect: Rect, pos: Pos2) -> bool {
        let (Some(face), Some(picked)) = (self.end_face(), self.picked(rect, pos)) else {
            return false;
        };
        let drawn = self.drawn.as_ref().map(|d| d.1.clone());
        if drawn.and_then(|d| d.last_piece()) != Some(picked.piece) {
            return false;
        }
        let Some((place, height)) = place_of(&face, &picked) else {
            return false;
        };
        let reach = match place.0 {
            rho if rho < BARK => IN_CRACKS,
            _ if self.project.cracks_are_sawn() => BESIDE,
            _ => RIM,
        };
        height - face.height(place) > -reach * face.radius()
    }

    /// Whether a point of the window is on the end at the base.
    fn is_on_base(&mut self, rect: Rect, pos: Pos2) -> bool {
        let (Some(face), Some(picked)) = (self.crack_face(), self.picked(rect, pos)) else {
            return false;
        };
        let (Some(grain), Some((_, drawn))) = (picked.grain, &self.drawn) else {
            return false;
        };
        let on_stem = drawn.vertices.iter().filter(|v| v.grain[3] > 0.5);
        let lowest = on_stem.map(|v| v.grain[2]).fold(f32::INFINITY, f32::min);
        face.polar(grain.truncate()).0 < BARK && grain.z < lowest + RIM * face.radius()
    }

    /// The choice of where the cracks of the selected break are; before there are any, where they are placed says it.
    pub(super) fn crack_end_choice(&mut self, ui: &mut Ui, now: f64) {
        let before = self.project.crack_end();
        let mut end = before;
        ui.add_enabled_ui(before.is_some(), |ui| {
            for (choice, name, about) in [
                (CrackEnd::Break, "broken face", "Cracks open the broken face."),
                (
                    CrackEnd::Sawn,
                    "sawn end",
                    "Cracks open the end at the tip. One that is no flat face is sawn off straight first.",
                ),
            ] {
                ui.selectable_value(&mut end, Some(choice), name)
                    .on_hover_text(about)
                    .on_disabled_hover_text("The first crack decides: drag over the broken face, or over the sawn end.");
            }
        });
        if let (true, Some(end)) = (end != before, end) {
            let moved = self
                .project
                .change_cracks("place of cracks", false, |cracks| {
                    cracks.settings.end = end;
                });
            self.finish_step(moved, now);
        }
    }
}

/// The place in the section of a point of the stem, and its height over a face's, m.
fn place_of(face: &CrackFace, picked: &Picked) -> Option<(Polar, f32)> {
    let grain = picked.grain?;
    Some((face.polar(grain.truncate()), grain.z - face.length()))
}
