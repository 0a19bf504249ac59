//! Charts of lines and points with two axes and a legend, drawn into a [`Picture`].

use crate::drawing::{CHARACTER_SIZE, Pen, draw_text};
use crate::picture::Picture;

/// How the points of a series are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeriesStyle {
    /// Joined by a line, in their order.
    Line,
    /// Each as a mark.
    Points,
}

/// A series of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Points in the units of the axes. Points that are not finite are left out.
    pub points: Vec<[f64; 2]>,
    /// How they are drawn.
    pub style: SeriesStyle,
}

/// A chart of lines and points.
///
/// ```
/// use greenstick_picture::{Chart, Series, SeriesStyle};
///
/// let points = vec![[0.0, 0.0], [1.0, 20.0], [2.0, 15.0]];
/// let load = Series { name: "load".into(), points, style: SeriesStyle::Line };
/// let axes = ["deflection (mm)".into(), "load (N)".into()];
/// let picture = Chart { title: "bending".into(), axes, series: vec![load] }.draw(400, 300);
/// assert_eq!((picture.width, picture.height), (400, 300));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Title, ASCII.
    pub title: String,
    /// Names of the axes with units, ASCII.
    pub axes: [String; 2],
    /// The series, later ones above earlier ones. Up to eight have distinct colours. The vertical axis of lines begins at 0,
    /// that of points where they do.
    pub series: Vec<Series>,
}

/// Colours that are distinguishable with colour blindness (Okabe and Ito 2008), dark ones first.
const SERIES_COLOURS: [[u8; 3]; 8] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [40, 40, 40],
    [86, 180, 233],
    [150, 140, 20],
];
/// Width of lines, and width and height of marks, pixels.
const LINE_WIDTH: i64 = 3;
const MARK_SIZE: i64 = 7;
/// Colour of grid lines.
const GRID_COLOUR: [u8; 3] = [225, 225, 225];
/// Margins around the plot, pixels.
const LEFT_MARGIN: i64 = 130;
const RIGHT_MARGIN: i64 = 30;
const TOP_MARGIN: i64 = 56;
const BOTTOM_MARGIN: i64 = 70;
/// Approximate number of ticks on an axis.
const TICKS: f64 = 6.0;

impl Chart {
    /// Draws the chart as a picture of `width` × `height` pixels, at least 300 × 200.
    pub fn draw(&self, width: u32, height: u32) -> Picture {
        let (width, height) = (width.clamp(300, 8192), height.clamp(200, 8192));
        let mut to = Picture {
            width,
            height,
            rgb: vec![255; 3 * width as usize * height as usize],
        };
        let plot = Plot {
            left: LEFT_MARGIN,
            top: TOP_MARGIN,
            right: i64::from(width) - RIGHT_MARGIN,
            bottom: i64::from(height) - BOTTOM_MARGIN,
            ranges: [self.range(0), self.range(1)],
        };
        plot.draw_grid(&mut to);
        for (k, series) in self.series.iter().enumerate() {
            let points: Vec<[f64; 2]> = series
                .points
                .iter()
                .filter(|p| p[0].is_finite() && p[1].is_finite())
                .map(|&p| plot.pixel(p))
                .collect();
            let width = match series.style {
                SeriesStyle::Line => LINE_WIDTH,
                SeriesStyle::Points => MARK_SIZE,
            };
            let pen = Pen {
                width,
                colour: SERIES_COLOURS[k % SERIES_COLOURS.len()],
            };
            match series.style {
                SeriesStyle::Line => points
                    .windows(2)
                    .for_each(|pair| pen.draw(&mut to, pair[0], pair[1])),
                SeriesStyle::Points => points.iter().for_each(|&p| pen.draw(&mut to, p, p)),
            }
        }
        self.draw_legend(&plot, &mut to);
        self.draw_titles(&plot, &mut to);
        to
    }

    /// Draws the names of the series above the plot.
    fn draw_legend(&self, plot: &Plot, to: &mut Picture) {
        let mut x = plot.left;
        let y = 12 + CHARACTER_SIZE + CHARACTER_SIZE / 2;
        for (k, series) in self.series.iter().enumerate() {
            let colour = SERIES_COLOURS[k % SERIES_COLOURS.len()];
            let (width, from, to_x) = match series.style {
                SeriesStyle::Line => (5, x, x + 24),
                SeriesStyle::Points => (MARK_SIZE, x + 12, x + 12),
            };
            let pen = Pen { width, colour };
            pen.draw(to, [from as f64, y as f64], [to_x as f64, y as f64]);
            draw_text(to, x + 30, y - CHARACTER_SIZE / 2, &series.name);
            x += 30 + (series.name.len() as i64 + 1) * CHARACTER_SIZE;
        }
    }

    /// Draws the title and the names of the axes.
    fn draw_titles(&self, plot: &Plot, to: &mut Picture) {
        let title = format!("{}: {}", self.title, self.axes[1]);
        draw_text(to, plot.left, 6, &title);
        let width = self.axes[0].len() as i64 * CHARACTER_SIZE;
        draw_text(
            to,
            (plot.left + plot.right - width) / 2,
            plot.bottom + 12 + 2 * CHARACTER_SIZE - CHARACTER_SIZE / 2,
            &self.axes[0],
        );
    }

    /// The smallest and the largest value on an axis, which always differ.
    fn range(&self, axis: usize) -> [f64; 2] {
        let values = self
            .series
            .iter()
            .flat_map(|s| &s.points)
            .filter(|p| p.iter().all(|v| v.is_finite()))
            .map(|p| p[axis]);
        let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| {
            [l.min(v), h.max(v)]
        });
        if !(low.is_finite() && high.is_finite() && (high - low).is_finite()) {
            return [0.0, 1.0];
        }
        let has_points = (self.series.iter()).any(|s| s.style == SeriesStyle::Points);
        if has_points && high > low {
            let margin = 0.05 * (high - low);
            return [low - margin, high + margin];
        }
        // Energies and loads are measured from 0.
        let low = if axis == 1 { low.min(0.0) } else { low };
        let extent = high - low;
        if extent <= 1e-300 {
            return [low - 0.5, low + 0.5];
        }
        [
            low,
            if axis == 1 {
                high + 0.05 * extent
            } else {
                high
            },
        ]
    }
}

/// Round numbers within a range.
fn ticks([low, high]: [f64; 2]) -> Vec<f64> {
    let raw = (high - low) / TICKS;
    let power = libm::pow(10.0, libm::floor(libm::log10(raw)));
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|f| f * power)
        .into_iter()
        .find(|s| *s >= raw)
        .unwrap_or(raw);
    let first = (low / step).ceil();
    (0..=(2.0 * TICKS) as i64)
        .map(|k| (first + k as f64) * step)
        .take_while(|v| *v <= high + 1e-9 * step)
        .collect()
}

/// The label of a tick.
fn label(v: f64) -> String {
    if v == 0.0 {
        return "0".to_owned();
    }
    if (1e-3..1e5).contains(&v.abs()) {
        let text = format!("{v:.5}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    format!("{v:.1e}").replace(".0e", "e")
}

/// The area between the axes.
struct Plot {
    left: i64,
    top: i64,
    right: i64,
    bottom: i64,
    /// Ranges of the axes.
    ranges: [[f64; 2]; 2],
}

impl Plot {
    /// The pixel of a point in the units of the axes.
    fn pixel(&self, p: [f64; 2]) -> [f64; 2] {
        let fraction = |v: f64, [low, high]: [f64; 2]| (v - low) / (high - low);
        let [x, y] = self.ranges;
        [
            self.left as f64 + fraction(p[0], x) * (self.right - self.left) as f64,
            self.bottom as f64 - fraction(p[1], y) * (self.bottom - self.top) as f64,
        ]
    }

    /// Draws grid lines with their labels.
    fn draw_grid(&self, to: &mut Picture) {
        let pen = Pen {
            width: 1,
            colour: GRID_COLOUR,
        };
        let [x, y] = self.ranges;
        for v in ticks(x) {
            let px = self.pixel([v, y[0]])[0].round();
            pen.draw(to, [px, self.top as f64], [px, self.bottom as f64]);
            let label = label(v);
            let half_width = label.len() as i64 * CHARACTER_SIZE / 2;
            draw_text(to, px as i64 - half_width, self.bottom + 8, &label);
        }
        for v in ticks(y) {
            let py = self.pixel([x[0], v])[1].round();
            pen.draw(to, [self.left as f64, py], [self.right as f64, py]);
            let label = label(v);
            let width = label.len() as i64 * CHARACTER_SIZE;
            let top = py as i64 - CHARACTER_SIZE / 2;
            draw_text(to, self.left - 8 - width, top, &label);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_pass_through_their_points() {
        let chart = Chart {
            title: "t".into(),
            axes: ["x (s)".into(), "y (J)".into()],
            series: vec![Series {
                name: "a".into(),
                points: vec![[0.0, 0.0], [10.0, 1.0], [f64::NAN, 3.0]],
                style: SeriesStyle::Line,
            }],
        };
        let picture = chart.draw(800, 600);
        let is_line = |x: i64, y: i64| {
            let at = 3 * (y as usize * 800 + x as usize);
            picture.rgb[at..at + 3] == SERIES_COLOURS[0]
        };
        // The axes range from 0 to 10 and from 0 to 1.05.
        for part in [0.1f64, 0.5, 0.9] {
            let x = 130.0 + part * 640.0;
            let y = 530.0 - part / 1.05 * 474.0;
            assert!(is_line(x.round() as i64, y.round() as i64), "{part}");
            assert!(!is_line(x.round() as i64, y.round() as i64 - 20), "{part}");
        }
        assert_eq!(ticks([0.0, 10.0]), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(label(0.02), "0.02");
        assert_eq!(label(2e-5), "2e-5");
        // No points, and no finite points.
        for points in [vec![], vec![[f64::INFINITY, f64::NAN]]] {
            let series = vec![Series {
                name: String::new(),
                points,
                style: SeriesStyle::Points,
            }];
            Chart {
                series,
                ..chart.clone()
            }
            .draw(0, 0);
        }
    }

    #[test]
    fn points_are_marks_within_their_own_range() {
        let chart = Chart {
            title: "t".into(),
            axes: ["x".into(), "y".into()],
            series: vec![Series {
                name: "a".into(),
                points: vec![[400.0, 50.0], [600.0, 150.0]],
                style: SeriesStyle::Points,
            }],
        };
        let picture = chart.draw(800, 600);
        let is_mark = |x: f64, y: f64| {
            let at = 3 * (y.round() as usize * 800 + x.round() as usize);
            picture.rgb[at..at + 3] == SERIES_COLOURS[0]
        };
        // The axes range from 390 to 610 and from 45 to 155.
        for part in [1.0 / 22.0, 21.0 / 22.0] {
            assert!(
                is_mark(130.0 + part * 640.0, 530.0 - part * 474.0),
                "{part}"
            );
        }
        assert!(!is_mark(450.0, 293.0));
    }
}
