//! Charts of lines.

use crate::model::simulation::Chart;
use eframe::egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2};

/// Colours of lines, told apart by those who see few colours too (Okabe and Ito).
const COLOURS: [Color32; 7] = [
    Color32::from_rgb(86, 180, 233),
    Color32::from_rgb(230, 159, 0),
    Color32::from_rgb(0, 158, 115),
    Color32::from_rgb(240, 228, 66),
    Color32::from_rgb(213, 94, 0),
    Color32::from_rgb(204, 121, 167),
    Color32::from_rgb(160, 160, 160),
];
/// Height of a line of text, and room for numbers at the left, points.
const TEXT: f32 = 13.0;
const LEFT: f32 = 46.0;

/// A number of three digits or so.
pub fn short(x: f64) -> String {
    let size = x.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if !(1e-3..1e5).contains(&size) {
        format!("{x:.1e}")
    } else {
        let digits = (2 - size.log10().floor() as i32).clamp(0, 5) as usize;
        let text = format!("{x:.digits$}");
        match text.contains('.') {
            true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
            false => text,
        }
    }
}

/// Draws a chart of this height, with a line across at `at`.
pub fn chart(ui: &mut Ui, chart: &Chart, height: f32, at: Option<f64>) {
    let legend = chart.lines.len().div_ceil(3) as f32 * TEXT;
    let size = Vec2::new(ui.available_width(), height + legend + 3.0 * TEXT);
    let (all, _) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(all);
    let weak = ui.visuals().weak_text_color();
    let font = FontId::proportional(10.5);
    let area = Rect::from_min_max(
        all.min + Vec2::new(LEFT, 1.8 * TEXT),
        Pos2::new(all.max.x - 6.0, all.max.y - legend - TEXT),
    );
    painter.rect_filled(area, 2.0, ui.visuals().extreme_bg_color);
    let [across, up] = &chart.axes;
    painter.text(all.min, Align2::LEFT_TOP, up, font.clone(), weak);
    let Some([low, high]) = chart.bounds() else {
        painter.text(
            area.center(),
            Align2::CENTER_CENTER,
            "nothing yet",
            font,
            weak,
        );
        return;
    };
    let place = |p: [f64; 2]| {
        let part = |k: usize| ((p[k] - low[k]) / (high[k] - low[k])) as f32;
        area.left_bottom() + Vec2::new(part(0) * area.width(), -part(1) * area.height())
    };
    let text = |pos: Pos2, align: Align2, text: String| {
        painter.text(pos, align, text, font.clone(), weak);
    };
    let left = Vec2::new(-4.0, 0.0);
    text(area.left_top() + left, Align2::RIGHT_CENTER, short(high[1]));
    text(
        area.left_bottom() + left,
        Align2::RIGHT_CENTER,
        short(low[1]),
    );
    text(area.left_bottom(), Align2::LEFT_TOP, short(low[0]));
    text(area.right_bottom(), Align2::RIGHT_TOP, short(high[0]));
    text(area.center_bottom(), Align2::CENTER_TOP, across.clone());
    let zero = place([low[0], 0.0]).y;
    painter.hline(area.x_range(), zero, Stroke::new(0.5, weak));
    if let Some(at) = at.filter(|x| (low[0]..=high[0]).contains(x)) {
        let line = Stroke::new(1.0, ui.visuals().text_color());
        painter.vline(place([at, 0.0]).x, area.y_range(), line);
    }
    for (i, line) in chart.lines.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        let finite = line
            .points
            .iter()
            .filter(|p| p[0].is_finite() && p[1].is_finite());
        let points: Vec<Pos2> = finite.map(|p| place(*p)).collect();
        painter.add(Shape::line(points, Stroke::new(1.4, colour)));
        let column = (i % 3) as f32 * (all.width() - 8.0) / 3.0;
        let row = area.max.y + TEXT + (i / 3) as f32 * TEXT;
        let pos = Pos2::new(all.min.x + column + 4.0, row);
        painter.hline(
            pos.x..=pos.x + 10.0,
            pos.y + 0.5 * TEXT,
            Stroke::new(2.0, colour),
        );
        let name = pos + Vec2::new(14.0, 0.0);
        text(name, Align2::LEFT_TOP, line.name.clone());
    }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_are_short() {
        let pairs = [
            (0.0, "0"),
            (1234.4, "1234"),
            (12.345, "12.3"),
            (0.5, "0.5"),
            (-0.01234, "-0.0123"),
            (2.5e-7, "2.5e-7"),
            (100.0, "100"),
        ];
        for (x, text) in pairs {
            assert_eq!(short(x), text);
        }
    }
}
