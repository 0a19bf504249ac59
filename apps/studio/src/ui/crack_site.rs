//! Where cracks are placed by hand: on the broken face, or on a sawn end, at the stem's tip or base.

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
    /// The sawn end at the tip, or that at the base, as it is drawn.
    pub(super) fn end_face(&mut self, far: bool) -> Option<Arc<CrackFace>> {
        let (id, drawn) = self.drawn.clone()?;
        let number = self.project.selected().unwrap_or(0);
        let known = &mut self.cracks.ends[usize::from(far)];
        if known.as_ref().is_none_or(|f| (f.0, f.1) != (id, number)) {
            let face = CrackFace::end(&drawn, number, far).map(Arc::new);
            *known = Some((id, number, face));
        }
        known.as_ref().and_then(|f| f.2.clone())
    }

    /// Where the cracks of the selected break are, or the first is being placed.
    pub(super) fn site_end(&self) -> CrackEnd {
        let own = self.project.crack_end();
        own.or(self.cracks.at).unwrap_or(CrackEnd::Break)
    }

    /// The face that cracks are placed on.
    pub(super) fn crack_site(&mut self) -> Option<Arc<CrackFace>> {
        match self.site_end() {
            CrackEnd::Break => self.crack_face(),
            CrackEnd::Sawn => self.end_face(true),
            CrackEnd::Base => self.end_face(false),
        }
    }

    /// The place in the section and the height over the site's, m, of what is under the pointer on the piece that the site is part of.
    pub(super) fn place_on_site(
        &self,
        rect: Rect,
        face: &CrackFace,
        pos: Pos2,
    ) -> Option<(Polar, f32)> {
        let drawn = &self.drawn.as_ref()?.1;
        let piece = match self.site_end() {
            CrackEnd::Break => return self.place_on_face(rect, face, pos),
            CrackEnd::Sawn => drawn.last_piece()?,
            CrackEnd::Base => drawn.first_piece()?,
        };
        let ray = self.ray_at(rect, pos);
        let picked = pick(drawn, ray, Some(piece));
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
        let at = self.end_at(rect, pos);
        match self.project.crack_end() {
            Some(CrackEnd::Break) if at != CrackEnd::Break => {
                return Err(
                    "The cracks of this break are in its broken face, and all are in one place: the choice above brings them to an end.",
                );
            }
            Some(CrackEnd::Sawn) if at != CrackEnd::Sawn => {
                return Err(
                    "The cracks of this break are in the end at the tip, and all are in one place: the choice above brings them elsewhere.",
                );
            }
            Some(CrackEnd::Base) if at != CrackEnd::Base => {
                return Err(
                    "The cracks of this break are in the end at the base, and all are in one place: the choice above brings them elsewhere.",
                );
            }
            _ => {}
        }
        if at != CrackEnd::Break && !self.is_nearest_break(at == CrackEnd::Sawn) {
            return Err(
                "The cracks of an end are those of the break nearest to it: select that one.",
            );
        }
        self.cracks.at = Some(at);
        let Some(face) = self.crack_site() else {
            return Ok(None);
        };
        let place = self.place_on_site(rect, &face, pos);
        Ok(place.map(|(place, height)| (face, place, height)))
    }

    /// Whether the selected break is the one nearest to the tip, or to the base.
    fn is_nearest_break(&self, far: bool) -> bool {
        let number = self.project.selected().unwrap_or(0);
        let Some((_, drawn)) = &self.drawn else {
            return false;
        };
        let own = drawn.breaks.get(number).map(|b| b.length);
        let is_nearer = |own: f32, other: f32| if far { own >= other } else { own <= other };
        own.is_some_and(|own| drawn.breaks.iter().all(|b| is_nearer(own, b.length)))
    }

    /// The end that a point of the window is on; the broken face where it is on none.
    fn end_at(&mut self, rect: Rect, pos: Pos2) -> CrackEnd {
        for (end, far) in [(CrackEnd::Sawn, true), (CrackEnd::Base, false)] {
            if self.is_on_end(rect, pos, (end, far)) {
                return end;
            }
        }
        CrackEnd::Break
    }

    /// Whether a point of the window is on an end.
    fn is_on_end(&mut self, rect: Rect, pos: Pos2, (end, far): (CrackEnd, bool)) -> bool {
        let (Some(face), Some(picked)) = (self.end_face(far), self.picked(rect, pos)) else {
            return false;
        };
        let piece = (self.drawn.as_ref()).and_then(|(_, drawn)| match far {
            true => drawn.last_piece(),
            false => drawn.first_piece(),
        });
        if piece != Some(picked.piece) {
            return false;
        }
        let Some((place, height)) = place_of(&face, &picked) else {
            return false;
        };
        let reach = match place.0 {
            rho if rho < BARK => IN_CRACKS,
            _ if self.project.crack_end() == Some(end) => BESIDE,
            _ => RIM,
        };
        height - face.height(place) > -reach * face.radius()
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
                    "end at the tip",
                    "Cracks open the end at the tip. One that is no flat face is sawn off straight first.",
                ),
                (
                    CrackEnd::Base,
                    "end at the base",
                    "Cracks open the end at the base. One that is no flat face is sawn off straight first; a limb that grows on a trunk has none.",
                ),
            ] {
                ui.selectable_value(&mut end, Some(choice), name)
                    .on_hover_text(about)
                    .on_disabled_hover_text("The first crack decides: drag over the broken face, or over an end.");
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
    Some((face.polar(grain.truncate()), face.height_of(grain.z)))
}
