//! The picture of a section: its wood ring by ring, its outline, angles about the pith, and a scale.

use super::colours::ACCENT;
use crate::model::look::WoodLook;
use crate::model::section_book::{SectionRings, StemSection};
use crate::model::units::{ShownUnit, round_length};
use eframe::egui::epaint::Vertex;
use eframe::egui::{
    Align2, Color32, ColorImage, FontId, Mesh, Painter, Pos2, Rect, Rgba, Shape, Stroke, Vec2,
};
use glam::DVec2;
use std::f64::consts::TAU;

/// Vertices of the wood, about, and the fewest and most directions in which they lie.
const VERTICES: usize = 60_000;
const DIRECTIONS: (usize, usize) = (64, 256);
/// Pixels along the longer side of a board's section.
const PIXELS: usize = 360;
/// Width of the picture over that of the section.
const ROOM: f64 = 1.24;
/// Part of the picture's width that a scale bar takes at most.
const BAR: f32 = 0.3;

/// How a section lies in the window.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lie {
    /// Its middle in the section, m, and in the window.
    centre: DVec2,
    middle: Pos2,
    /// Points for each metre.
    pub scale: f32,
}

impl Lie {
    /// A section in the middle of a rectangle, so many times nearer, and shifted.
    pub fn new(section: &StemSection, rect: Rect, zoom: f32, shift: Vec2) -> Self {
        let start = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = section
            .outline()
            .fold(start, |(a, b), p| (a.min(p), b.max(p)));
        let size = (high - low).max(DVec2::splat(1e-9)) * ROOM;
        let fits = f64::from(rect.width()) / size.x;
        let scale = fits.min(f64::from(rect.height()) / size.y) as f32 * zoom;
        Lie {
            centre: 0.5 * (low + high),
            middle: rect.center() + shift,
            scale,
        }
    }

    /// Where a point of the section is in the window.
    pub fn window(&self, p: DVec2) -> Pos2 {
        let d = (p - self.centre).as_vec2() * self.scale;
        self.middle + Vec2::new(d.x, -d.y)
    }

    /// The point of the section, m, at one of the window.
    pub fn section(&self, pos: Pos2) -> DVec2 {
        let d = (pos - self.middle) / self.scale;
        self.centre + DVec2::new(f64::from(d.x), f64::from(-d.y))
    }
}

fn color(c: [f32; 3]) -> Color32 {
    Rgba::from_rgb(c[0], c[1], c[2]).into()
}

/// A part of the radius with its colours: from a ring coordinate to another.
type Band = (f64, Color32, f64, Color32);

/// The bands of rings with these outer edges.
fn bands(look: &WoodLook, edges: &[f64]) -> Vec<Band> {
    let early = f64::from(look.earlywood());
    let tissues = look.tissue_edges().map(f64::from);
    let mut bands = Vec::new();
    let mut inner = 0.0;
    for &outer in edges {
        let width = outer - inner;
        let at = |f: f64| inner + width * f;
        let mut stops = vec![inner, at(early), at(0.5 * (1.0 + early)), outer];
        stops.extend(tissues.iter().filter(|t| **t > inner && **t < outer));
        stops.sort_by(f64::total_cmp);
        for pair in stops.windows(2) {
            let nearly = 1e-3 * (pair[1] - pair[0]);
            let (a, b) = (pair[0] + nearly, pair[1] - nearly);
            let colour = |rho: f64| {
                let fraction = (rho - inner) / width;
                color(look.end_grain(rho as f32, fraction as f32))
            };
            bands.push((pair[0], colour(a), pair[1], colour(b)));
        }
        inner = outer;
    }
    bands
}

/// Rings of a section, or one without years where their edges are not known.
fn known(edges: &[f64]) -> &[f64] {
    if edges.is_empty() { &[1.0] } else { edges }
}

/// The wood of a round section.
fn wood_mesh(lie: &Lie, rings: &SectionRings, look: &WoodLook, edges: &[f64]) -> Mesh {
    let bands = bands(look, known(edges));
    let directions = (VERTICES / (2 * bands.len().max(1))).clamp(DIRECTIONS.0, DIRECTIONS.1);
    let mut mesh = Mesh::default();
    mesh.vertices.reserve(2 * bands.len() * directions);
    for (from, inside, to, outside) in bands {
        let first = mesh.vertices.len() as u32;
        for k in 0..directions {
            let angle = TAU * k as f64 / directions as f64;
            for (rho, color) in [(from, inside), (to, outside)] {
                mesh.vertices.push(Vertex {
                    pos: lie.window(rings.point(rho, angle)),
                    uv: eframe::egui::epaint::WHITE_UV,
                    color,
                });
            }
            let (a, b) = (2 * k as u32, 2 * ((k + 1) % directions) as u32);
            mesh.indices
                .extend([a, a + 1, b, b, a + 1, b + 1].map(|i| first + i));
        }
    }
    mesh
}

/// The corners of the box about a section, m.
pub(super) fn corners(section: &StemSection) -> [DVec2; 2] {
    let start = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let (low, high) = section
        .outline()
        .fold(start, |(a, b), p| (a.min(p), b.max(p)));
    [low, high]
}

/// The wood of a section whose rings are arcs, pixel by pixel over its box.
pub(super) fn board_picture(
    section: &StemSection,
    rings: &SectionRings,
    look: &WoodLook,
    edges: &[f64],
) -> ColorImage {
    let [low, high] = corners(section);
    let size = high - low;
    let pixel = size.max_element() / PIXELS as f64;
    let [w, h] = (size / pixel)
        .ceil()
        .max(DVec2::ONE)
        .to_array()
        .map(|n| n as usize);
    let edges = known(edges);
    let mut image = ColorImage::filled([w, h], Color32::TRANSPARENT);
    for y in 0..h {
        for x in 0..w {
            let at = DVec2::new(x as f64 + 0.5, (h - y) as f64 - 0.5) * pixel;
            let p = low + at;
            if !section.contains(p) {
                continue;
            }
            let rho = rings.address(p).0.min(1.0);
            let ring = edges.partition_point(|e| *e < rho).min(edges.len() - 1);
            let inner = if ring == 0 { 0.0 } else { edges[ring - 1] };
            let fraction = (rho - inner) / (edges[ring] - inner).max(1e-9);
            image[(x, y)] = color(look.end_grain(rho as f32, fraction as f32));
        }
    }
    image
}

/// Draws the wood of a section and its outline; `board` is the picture of one whose rings are arcs.
pub(super) fn paint_wood(
    painter: &Painter,
    lie: &Lie,
    (section, rings): (&StemSection, &SectionRings),
    (look, edges): (&WoodLook, &[f64]),
    board: Option<eframe::egui::TextureId>,
) {
    match board {
        Some(board) => {
            let corners = corners(section).map(|p| lie.window(p));
            let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            let rect = Rect::from_two_pos(corners[0], corners[1]);
            painter.image(board, rect, whole, Color32::WHITE);
        }
        None => {
            painter.add(Shape::mesh(wood_mesh(lie, rings, look, edges)));
        }
    }
    for points in &section.loops {
        let line = points.iter().map(|p| lie.window(DVec2::from_array(*p)));
        let stroke = Stroke::new(1.5, Color32::from_rgb(40, 30, 22));
        painter.add(Shape::closed_line(line.collect(), stroke));
    }
}

/// Draws the line of a ring coordinate where it lies in the wood.
pub(super) fn paint_ring(
    painter: &Painter,
    lie: &Lie,
    (section, rings): (&StemSection, &SectionRings),
    rho: f64,
    stroke: Stroke,
) {
    let is_arc = matches!(rings, SectionRings::Arcs(..));
    let point = |k: i32| rings.point(rho, TAU * f64::from(k) / 240.0);
    if !is_arc {
        let line = (0..240).map(|k| lie.window(point(k))).collect();
        painter.add(Shape::closed_line(line, stroke));
        return;
    }
    for k in 0..240 {
        let (a, b) = (point(k), point(k + 1));
        if section.contains(0.5 * (a + b)) {
            painter.line_segment([lie.window(a), lie.window(b)], stroke);
        }
    }
}

/// Draws the angles about the pith that parameters are counted by.
pub(super) fn paint_angles(
    painter: &Painter,
    lie: &Lie,
    section: &StemSection,
    rings: &SectionRings,
    color: Color32,
) {
    let pith = rings.pith();
    for (angle, text) in [
        (0.0f64, "0°"),
        (90.0, "90°"),
        (180.0, "180°"),
        (270.0, "270°"),
    ] {
        let direction = DVec2::from_angle(angle.to_radians());
        let reach = section
            .outline()
            .map(|p| (p - pith).dot(direction))
            .fold(0.0, f64::max);
        let out = Vec2::new(direction.x as f32, -direction.y as f32);
        let edge = lie.window(pith + direction * reach);
        painter.line_segment(
            [edge + out * 4.0, edge + out * 10.0],
            Stroke::new(1.0, color),
        );
        let font = FontId::proportional(11.0);
        painter.text(edge + out * 21.0, Align2::CENTER_CENTER, text, font, color);
    }
}

/// Draws a scale bar in the lower left corner.
pub(super) fn paint_scale(
    painter: &Painter,
    rect: Rect,
    lie: &Lie,
    unit: ShownUnit,
    color: Color32,
) {
    let length = round_length(f64::from(BAR * rect.width() / lie.scale), unit);
    let width = length as f32 * lie.scale;
    let at = rect.left_bottom() + Vec2::new(10.0, -10.0);
    let end = at + Vec2::new(width, 0.0);
    let stroke = Stroke::new(2.0, color);
    painter.line_segment([at, end], stroke);
    for p in [at, end] {
        painter.line_segment([p - Vec2::new(0.0, 4.0), p + Vec2::new(0.0, 4.0)], stroke);
    }
    let shown = length * unit.per_metre();
    let text = format!("{} {}", (shown * 1e6).round() / 1e6, unit.symbol());
    let font = FontId::proportional(12.0);
    let above = at + Vec2::new(0.5 * width, -5.0);
    painter.text(above, Align2::CENTER_BOTTOM, text, font, color);
}

/// Draws a dot where a ring was pinned.
pub(super) fn paint_pin(painter: &Painter, at: Pos2) {
    painter.circle(at, 4.0, ACCENT, Stroke::new(1.0, Color32::BLACK));
}
