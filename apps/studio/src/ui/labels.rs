//! Labels beside what is dragged in the picture: they stay within it.

use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Vec2};

/// Between what is dragged and its label, points across and up or down.
const BESIDE: Vec2 = Vec2::new(14.0, 14.0);
/// Around the text of a label, points.
const MARGIN: f32 = 3.0;
/// Size of the text, points.
const TEXT: f32 = 13.0;

/// Where a label of a size stands beside a point within an area: on the right and above where there is room, else on the side that has
/// it, and where none has, as near to there as the area lets it.
pub(super) fn label_place(area: Rect, at: Pos2, size: Vec2) -> Rect {
    let sides = [
        (Align2::LEFT_BOTTOM, Vec2::new(1.0, -1.0)),
        (Align2::RIGHT_BOTTOM, Vec2::new(-1.0, -1.0)),
        (Align2::LEFT_TOP, Vec2::new(1.0, 1.0)),
        (Align2::RIGHT_TOP, Vec2::new(-1.0, 1.0)),
    ];
    let places = sides.map(|(anchor, side)| anchor.anchor_size(at + side * BESIDE, size));
    let inside = places.into_iter().find(|place| area.contains_rect(*place));
    inside.unwrap_or_else(|| {
        let most = (area.size() - size).max(Vec2::ZERO);
        let from = (places[0].min - area.min).clamp(Vec2::ZERO, most);
        Rect::from_min_size(area.min + from, size)
    })
}

/// Draws a label beside a point of the picture, within what the painter draws on; a text that is too wide for that is broken into
/// lines.
pub(super) fn paint_label(painter: &Painter, at: Pos2, text: String, color: Color32) {
    let area = painter.clip_rect().shrink(MARGIN);
    let widest = (area.width() - 2.0 * MARGIN).max(0.0);
    let galley = painter.layout(text, FontId::proportional(TEXT), color, widest);
    let size = galley.size() + Vec2::splat(2.0 * MARGIN);
    let place = label_place(area, at, size);
    painter.rect_filled(place, 3.0, Color32::from_black_alpha(150));
    painter.galley(place.shrink(MARGIN).min, galley, color);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_stands_beside_its_point_and_within_the_area() {
        let area = Rect::from_min_max(Pos2::new(10.0, 20.0), Pos2::new(410.0, 320.0));
        let size = Vec2::new(120.0, 18.0);
        for x in (0..=84).map(|i| 5.0 * i as f32) {
            for y in (0..=68).map(|i| 5.0 * i as f32) {
                let at = Pos2::new(x, y);
                let place = label_place(area, at, size);
                assert!(area.contains_rect(place), "{at} {place}");
                assert_eq!(place.size(), size);
                // What is in the area is not covered.
                assert!(!area.contains(at) || !place.contains(at), "{at} {place}");
            }
        }
        // With room on all sides it is on the right and above.
        let place = label_place(area, area.center(), size);
        assert!(place.left() > area.center().x && place.bottom() < area.center().y);
        // What is larger than the area begins in its corner.
        let place = label_place(area, area.center(), Vec2::new(600.0, 18.0));
        assert_eq!(place.left(), area.left());
    }
}
