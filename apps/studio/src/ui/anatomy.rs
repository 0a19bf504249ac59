//! The section browser: a section across the stem at a height that is dragged, its rings, and rings that are dragged to where they
//! truly are.

use super::anatomy_view::AnatomyView;
use super::colours::ACCENT;
use super::pith::paint_pith_and_onset;
use super::section_picture::{
    Lie, board_picture, paint_angles, paint_pin, paint_ring, paint_scale, paint_wood,
};
use super::studio::Studio;
use crate::model::look::WoodLook;
use crate::model::placed_cracks::{course, depth};
use crate::model::rings::{are_eroded, dragged};
use crate::model::section_book::{SectionBook, SectionRings, StemSection};
use crate::model::units::ShownUnit;
use eframe::egui::{
    self, Color32, CursorIcon, Grid, PointerButton, Pos2, Rect, RichText, Sense, Stroke,
    TextureOptions, Ui, Vec2,
};
use greenstick::fracture::parameters::CrackEnd;
use greenstick::wood::tissue::Zone;
use std::collections::BTreeSet;
use std::sync::Arc;

/// How near the pointer has to be to a ring to take hold of it, points.
const HOLD: f32 = 6.0;
/// How much nearer one point of the wheel goes, and how near at most.
const WHEEL: f32 = 0.004;
const NEAREST: f32 = 40.0;
/// Height of the chart of ring widths, points.
const CHART: f32 = 62.0;

/// What is drawn of a section.
struct Scene {
    book: Arc<SectionBook>,
    number: u64,
    index: usize,
    rings: Arc<SectionRings>,
    edges: Vec<f64>,
    look: WoodLook,
}

impl Scene {
    fn section(&self) -> &StemSection {
        &self.book.sections[self.index]
    }

    /// The mean radii of a ring in this section: its inner and outer edge, m.
    fn radii(&self, ring: usize) -> [f64; 2] {
        let inner = if ring == 0 { 0.0 } else { self.edges[ring - 1] };
        [inner, self.edges[ring]].map(|rho| self.rings.mean_radius(rho))
    }

    /// Rings that are wood or pith: bark is none.
    fn count(&self) -> usize {
        let tissues = self.book.tissues.iter().map(|t| Zone::from_code(*t));
        let wood = tissues.filter(|t| t.is_some_and(|t| t <= Zone::Sapwood));
        wood.count().min(self.edges.len())
    }
}

impl Studio {
    /// The break of whose stem sections are wanted, if they are.
    pub(super) fn sections_wanted(&self) -> Option<usize> {
        self.anatomy
            .open
            .then(|| self.project.selected().unwrap_or(0))
    }

    /// Opens or closes the section browser.
    pub(super) fn toggle_anatomy(&mut self) {
        self.anatomy.open ^= true;
        if self.anatomy.open {
            self.changed_view(false);
        }
    }

    /// Takes the sections of an answer.
    pub(super) fn take_sections(&mut self, sections: Option<Result<SectionBook, String>>) {
        let Some(sections) = sections else { return };
        self.numbers += 1;
        let number = self.numbers;
        self.anatomy.book = Some(sections.map(|book| (number, Arc::new(book))));
        if self.anatomy.held.is_none() && self.anatomy.pith_held.is_none() {
            self.anatomy.edges = None;
        }
    }

    /// Forgets the sections of another stem.
    pub(super) fn forget_sections(&mut self) {
        self.anatomy = AnatomyView {
            open: self.anatomy.open,
            ..AnatomyView::default()
        };
    }

    /// Where a ring's outer edge is in the window, at an angle (rad); `ring` counts from 0.
    pub fn ring_at(&self, ring: usize, angle: f64) -> Option<Pos2> {
        let (_, lie) = self.anatomy.lie?;
        let (_, _, rings) = self.anatomy.rings.as_ref()?;
        let rho = *self.ring_edges().get(ring)?;
        Some(lie.window(rings.point(rho, angle)))
    }

    /// The outer edges of the rings that the browser shows, in ring coordinates.
    pub fn ring_edges(&self) -> Vec<f64> {
        match (&self.anatomy.edges, &self.anatomy.book) {
            (Some(edges), _) => edges.clone(),
            (None, Some(Ok((_, book)))) => book.edges.clone(),
            _ => Vec::new(),
        }
    }

    /// Length along the stem of the section that is shown, m.
    pub fn section_length(&self) -> Option<f64> {
        let book = self.section_book()?;
        book.sections
            .get(self.section_index(&book))
            .map(|s| s.length)
    }

    /// The sections, where there are any.
    pub(super) fn section_book(&self) -> Option<Arc<SectionBook>> {
        let (_, book) = self.anatomy.book.as_ref()?.as_ref().ok()?;
        Some(book.clone())
    }

    /// Which section is shown.
    pub(super) fn section_index(&self, book: &SectionBook) -> usize {
        let last = book.sections.len().saturating_sub(1);
        self.anatomy.at.unwrap_or(book.at_break).min(last)
    }

    /// Shows one of the sections, or that of the break.
    pub(super) fn show_section(&mut self, index: Option<usize>) {
        self.anatomy.at = index;
    }

    fn section_scene(&mut self) -> Option<Scene> {
        let (number, book) = self.anatomy.book.as_ref()?.as_ref().ok()?.clone();
        let index = self.section_index(&book);
        let known = self.anatomy.rings.take();
        let rings = match known {
            // What is held is where the hand has it, whatever answers come.
            Some((of, at, rings))
                if at == index && (of == number || self.anatomy.pith_held.is_some()) =>
            {
                rings
            }
            _ => Arc::new(book.sections[index].section_rings()),
        };
        self.anatomy.rings = Some((number, index, rings.clone()));
        let selected = self.project.selected().unwrap_or(0);
        let look = self.drawn.as_ref()?.1.woods.get(selected)?.clone();
        Some(Scene {
            edges: self.ring_edges(),
            book,
            number,
            index,
            rings,
            look,
        })
    }

    /// The panel with the section.
    pub(super) fn anatomy_panel(&mut self, ui: &mut Ui) {
        let panel = egui::Panel::left("anatomy").default_size(400.0);
        panel.size_range(300.0..=720.0).show(ui, |ui| {
            ui.add_space(4.0);
            ui.horizontal(|ui| {
                ui.strong("Section across the stem");
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    if ui.button("Close").clicked() {
                        self.anatomy.open = false;
                    }
                });
            });
            if let Some(Err(problem)) = &self.anatomy.book {
                ui.label(format!("There is no section of this stem: {problem}."));
                return;
            }
            let Some(scene) = self.section_scene() else {
                ui.weak("The stem is being cut…");
                return;
            };
            if self.sections_wanted() != Some(scene.book.number) && !self.is_busy() {
                self.changed_view(false);
            }
            self.height_row(ui, &scene);
            let size = (ui.available_height() - 3.0 * CHART - 60.0).max(160.0);
            let size = Vec2::new(ui.available_width(), size.min(ui.available_width()));
            let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
            self.section_picture(ui, &scene, rect, &response);
            self.about_section(ui, &scene);
            self.ring_chart(ui, &scene);
            self.ring_buttons(ui, &scene);
        });
    }

    fn height_row(&mut self, ui: &mut Ui, scene: &Scene) {
        let unit = self.settings.unit;
        ui.horizontal(|ui| {
            let mut index = scene.index;
            ui.label("Height");
            ui.spacing_mut().slider_width = (ui.available_width() - 190.0).max(60.0);
            let last = scene.book.sections.len() - 1;
            let slider = egui::Slider::new(&mut index, 0..=last).show_value(false);
            let response = ui.add(slider).on_hover_text(
                "Where the section lies along the stem, from its base. The line on the stem is dragged to the same effect.",
            );
            response.widget_info(|| {
                egui::WidgetInfo::slider(true, index as f64, "Height of the section")
            });
            if index != scene.index {
                self.anatomy.at = Some(index);
            }
            ui.label(unit.text(scene.section().length));
            let away = scene.index != scene.book.at_break;
            let button = ui.add_enabled(away, egui::Button::new("At the break"));
            if button.clicked() {
                self.anatomy.at = None;
            }
        });
    }

    fn section_picture(&mut self, ui: &Ui, scene: &Scene, rect: Rect, response: &egui::Response) {
        let (zoom, shift) = self.anatomy.near.unwrap_or((1.0, Vec2::ZERO));
        let lie = Lie::new(scene.section(), rect, zoom, shift);
        self.anatomy.lie = Some((rect, lie));
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 4.0, ui.visuals().extreme_bg_color);
        let board = self.board_texture(ui, scene);
        let both = (scene.section(), &*scene.rings);
        paint_wood(&painter, &lie, both, (&scene.look, &scene.edges), board);
        self.paint_section_cracks(&painter, scene, &lie);
        let takes_pith = self.drag_pith(ui, &scene.book, scene.index, &lie, response);
        let over = match takes_pith {
            true => None,
            false => self.drag_ring(ui, scene, (rect, lie), response),
        };
        for pin in self.project.pins() {
            if let Some(rho) = scene.edges.get(pin) {
                let stroke = Stroke::new(1.0, ACCENT.gamma_multiply(0.6));
                paint_ring(&painter, &lie, both, *rho, stroke);
                paint_pin(&painter, lie.window(scene.rings.point(*rho, 0.0)));
            }
        }
        if let Some(rho) = over.and_then(|ring| scene.edges.get(ring)) {
            paint_ring(&painter, &lie, both, *rho, Stroke::new(2.0, ACCENT));
        }
        paint_pith_and_onset(&painter, &lie, both.1, response.hover_pos());
        let color = ui.visuals().weak_text_color();
        paint_angles(&painter, &lie, both.0, both.1, color);
        paint_scale(
            &painter,
            rect,
            &lie,
            self.settings.unit,
            ui.visuals().text_color(),
        );
    }

    fn board_texture(&mut self, ui: &Ui, scene: &Scene) -> Option<egui::TextureId> {
        if !scene.book.sawn && matches!(*scene.rings, SectionRings::Field(_)) {
            return None;
        }
        let key = (scene.number, scene.index);
        let known = self.anatomy.board.as_ref();
        let fits = known.is_some_and(|b| (b.0, b.1) == key && b.2 == scene.edges);
        if !fits {
            let image = board_picture(scene.section(), &scene.rings, &scene.look, &scene.edges);
            let texture = ui.load_texture("section", image, TextureOptions::LINEAR);
            self.anatomy.board = Some((key.0, key.1, scene.edges.clone(), texture));
        }
        self.anatomy.board.as_ref().map(|b| b.3.id())
    }

    /// The placed cracks that reach this section.
    fn paint_section_cracks(&self, painter: &egui::Painter, scene: &Scene, lie: &Lie) {
        let at_break = self.project.crack_end() == Some(CrackEnd::Break);
        if !at_break || scene.book.sawn {
            return;
        }
        let at_break = &scene.book.sections[scene.book.at_break];
        let radius = (at_break.area / std::f64::consts::PI).sqrt();
        let off = (scene.section().length - at_break.length).abs();
        for crack in self.project.placed_cracks() {
            if off > depth(crack) * radius {
                continue;
            }
            let point =
                |(rho, angle): (f32, f32)| lie.window(scene.rings.point(rho.into(), angle.into()));
            let line: Vec<Pos2> = course(crack).into_iter().map(point).collect();
            painter.line(line, Stroke::new(2.5, Color32::from_rgb(24, 14, 8)));
        }
    }

    /// Moves the section and drags rings; returns the ring whose outer edge is under the pointer.
    fn drag_ring(
        &mut self,
        ui: &Ui,
        scene: &Scene,
        (rect, lie): (Rect, Lie),
        response: &egui::Response,
    ) -> Option<usize> {
        self.move_section(ui, rect, response);
        let now = ui.input(|i| i.time);
        let pos = response.interact_pointer_pos().or(response.hover_pos());
        let Some(pos) = pos else {
            self.anatomy.over = None;
            return None;
        };
        let at = lie.section(pos);
        let (rho, _) = scene.rings.address(at);
        let inside = scene.section().contains(at);
        let ring = scene.edges.partition_point(|e| *e < rho);
        self.anatomy.over = (inside && ring < scene.edges.len()).then_some(ring);
        if let Some((number, before)) = self.anatomy.held.clone() {
            if !response.dragged_by(PointerButton::Primary) {
                self.anatomy.held = None;
                self.rest(now);
                return None;
            }
            self.drag_edge(scene, number, &before, rho, ui);
            self.anatomy.over = Some(number);
            return Some(number);
        }
        let near = self.edge_at(scene, &lie, pos);
        if near.is_some() {
            ui.set_cursor_icon(CursorIcon::Grab);
        }
        if response.double_clicked() {
            match near {
                Some(number) => drop(self.project.pinned.remove(&number)),
                None => self.anatomy.near = None,
            }
        }
        let pressed = ui.input(|i| i.pointer.press_origin());
        if response.drag_started_by(PointerButton::Primary)
            && let Some(number) = pressed.and_then(|p| self.edge_at(scene, &lie, p))
        {
            self.anatomy.held = Some((number, scene.edges.clone()));
        }
        near
    }

    fn drag_edge(&mut self, scene: &Scene, number: usize, before: &[f64], to: f64, ui: &Ui) {
        let (alone, now) = ui.input(|i| (i.modifiers.command, i.time));
        let mut pins = self.project.pins();
        if alone {
            pins = BTreeSet::from_iter(0..before.len());
        }
        pins.remove(&number);
        let next = dragged(before, number, to, &pins);
        if next == scene.edges {
            return;
        }
        let book = scene.book.clone();
        match self
            .project
            .set_ring_edges(&next, number, |rho| book.mean_radius(rho))
        {
            Ok(changed) => {
                self.anatomy.edges = Some(next);
                if changed {
                    self.changed(true, now);
                }
            }
            Err(problem) => self.said = problem,
        }
    }

    /// The ring whose outer edge is at a point of the window and can be dragged.
    fn edge_at(&self, scene: &Scene, lie: &Lie, pos: Pos2) -> Option<usize> {
        if are_eroded(&self.project.file) {
            return None;
        }
        let at = lie.section(pos);
        let angle = scene.rings.address(at).1;
        let distance = |rho: f64| {
            let edge = lie.window(scene.rings.point(rho, angle));
            edge.distance(pos)
        };
        (0..self.project.movable_edges(&scene.edges))
            .map(|i| (i, distance(scene.edges[i])))
            .filter(|(_, off)| *off <= HOLD)
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(i, _)| i)
    }

    /// Shifts the section by a drag, and scales it by the wheel about the pointer.
    fn move_section(&mut self, ui: &Ui, rect: Rect, response: &egui::Response) {
        let (mut zoom, mut shift) = self.anatomy.near.unwrap_or((1.0, Vec2::ZERO));
        let before = (zoom, shift);
        if response.dragged() && self.anatomy.held.is_none() {
            shift += response.drag_delta();
        }
        if let Some(pos) = response.hover_pos() {
            let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
            let wanted = zoom * (scroll * WHEEL).exp() * pinch;
            let next = wanted.clamp(1.0, NEAREST);
            let from_middle = pos - rect.center();
            shift = from_middle - (from_middle - shift) * (next / zoom);
            zoom = next;
        }
        if (zoom, shift) != before {
            self.anatomy.near = Some((zoom, shift));
        }
    }

    fn about_section(&self, ui: &mut Ui, scene: &Scene) {
        let unit = self.settings.unit;
        let section = scene.section();
        let count = scene.count();
        let wood = match count {
            0 => 0.0,
            count => scene.radii(count - 1)[1],
        };
        Grid::new("section").num_columns(2).spacing([12.0, 2.0]).show(ui, |ui| {
            let diameters = section.diameters();
            let [least, greatest] = diameters.range.map(|d| unit.text(d));
            ui.label("Diameter here").on_hover_text(
                "At the height of this section, over bark: that of the circle of the same area; then the least and the greatest that a \
                 calliper finds. The line at the bottom of the window has the diameter at the break.",
            );
            let mean = unit.text(diameters.mean);
            ui.label(format!("{mean}  ({least} to {greatest})"));
            ui.end_row();
            ui.label("Rings").on_hover_text("Annual rings from the pith to the bark.");
            if scene.edges.is_empty() {
                ui.label("eroded: they are seen in the viewport");
            } else {
                let mean = unit.of_rings().text(wood / count.max(1) as f64);
                ui.label(format!("{count}, {mean} wide on average"));
            }
            ui.end_row();
            ui.label("Under the pointer");
            ui.label(self.about_ring(scene));
            ui.end_row();
        });
    }

    fn about_ring(&self, scene: &Scene) -> String {
        let Some(ring) = self.anatomy.over.filter(|r| *r < scene.edges.len()) else {
            return "–".to_owned();
        };
        let unit = self.settings.unit;
        let tissue = scene
            .book
            .tissues
            .get(ring)
            .copied()
            .and_then(Zone::from_code);
        let [inner, outer] = scene.radii(ring);
        let (width, radius) = (unit.text(outer - inner), unit.text(outer));
        match tissue {
            Some(Zone::Phloem) => format!("inner bark, {width}"),
            Some(Zone::Bark) => format!("bark, {width}"),
            _ => format!("ring {}, {width} wide, ends at {radius}", ring + 1),
        }
    }

    /// The mean width of each ring, as bars.
    fn ring_chart(&self, ui: &mut Ui, scene: &Scene) {
        let count = scene.count();
        if count == 0 {
            return;
        }
        let widths: Vec<f64> = (0..count)
            .map(|ring| {
                let [inner, outer] = scene.radii(ring);
                outer - inner
            })
            .collect();
        let most = widths.iter().copied().fold(1e-9, f64::max);
        let size = Vec2::new(ui.available_width(), CHART);
        let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
        let bar = rect.width() / count as f32;
        let pins = self.project.pins();
        for (ring, width) in widths.iter().enumerate() {
            let left = rect.left() + bar * ring as f32;
            let top = rect.bottom() - (rect.height() - 14.0) * (width / most) as f32;
            let gap = (0.12 * bar).min(1.5);
            let corners = (
                Pos2::new(left + gap, top),
                Pos2::new(left + bar - gap, rect.bottom()),
            );
            let color = if self.anatomy.over == Some(ring) || pins.contains(&ring) {
                ACCENT
            } else {
                Color32::from_rgb(176, 132, 84)
            };
            painter.rect_filled(Rect::from_min_max(corners.0, corners.1), 0.0, color);
        }
        let text = format!(
            "ring widths, pith to bark; widest {}",
            self.settings.unit.of_rings().text(most)
        );
        let font = egui::FontId::proportional(10.5);
        let at = rect.left_top() + Vec2::new(4.0, 1.0);
        painter.text(
            at,
            egui::Align2::LEFT_TOP,
            text,
            font,
            ui.visuals().weak_text_color(),
        );
        if let Some(pos) = response.hover_pos() {
            let ring = (((pos.x - rect.left()) / bar) as usize).min(count - 1);
            let width = self.settings.unit.of_rings().text(widths[ring]);
            response.on_hover_text(format!("ring {}: {width}", ring + 1));
        }
    }

    fn ring_buttons(&mut self, ui: &mut Ui, scene: &Scene) {
        let now = ui.input(|i| i.time);
        ui.horizontal_wrapped(|ui| {
            let listed = self.project.listed_rings().is_some();
            let free = ui.add_enabled(listed, egui::Button::new("Rings worked out"));
            let free = free.on_hover_text("Leaves the rings to the program again.");
            if free.clicked() {
                let freed = self.project.free_rings();
                self.finish_step(freed, now);
            }
            let copy = ui.add_enabled(!scene.edges.is_empty(), egui::Button::new("Copy widths"));
            let copy = copy.on_hover_text(
                "Copies the mean widths of the rings in this section, from the pith outwards, as --set ring_widths takes them.",
            );
            if copy.clicked() {
                ui.copy_text(widths_text(scene));
            }
        });
        let text = if are_eroded(&self.project.file) {
            "Rings that come from an erosion cannot be dragged."
        } else {
            "Drag a ring's edge to where it is: the others follow, but for those that were dragged before (with Ctrl all others stay). \
             The cross is dragged to the pith, the dot of the dashed ring to where an eccentric stem began to lean. A double click \
             leaves each to the program again."
        };
        ui.label(RichText::new(text).weak());
    }
}

/// The mean widths of a section's rings, as a setting takes them.
fn widths_text(scene: &Scene) -> String {
    let widths = (0..scene.count()).map(|ring| {
        let [inner, outer] = scene.radii(ring);
        let millimetres = (outer - inner) * ShownUnit::Millimetre.per_metre();
        format!("{millimetres:.4} mm")
    });
    widths.collect::<Vec<_>>().join(", ")
}
