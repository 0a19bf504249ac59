//! Charts: lines over two axes with a legend, drawn into a [`Picture`].

use crate::Picture;

/// A line of a chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Its name in the legend.
    pub name: String,
    /// Its points, in the axes' units; those that are not finite are left out.
    pub points: Vec<[f64; 2]>,
}

/// Lines over two axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// Above the chart, ASCII.
    pub title: String,
    /// Names of the axes with their units, ASCII.
    pub axes: [String; 2],
    /// The lines; each has a colour of its own up to eight.
    pub lines: Vec<Line>,
}

/// Colours that the colour-blind can tell apart (Okabe and Ito 2008), dark ones first.
const COLOURS: [[u8; 3]; 8] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [40, 40, 40],
    [86, 180, 233],
    [150, 140, 20],
];
const GRID: [u8; 3] = [225, 225, 225];
const INK: [u8; 3] = [50, 50, 50];
/// Pixels of a letter's side.
const LETTER: i64 = 16;
/// Margins left, right, above and below, pixels.
const MARGINS: [i64; 4] = [130, 30, 56, 70];
/// About so many marks on an axis.
const MARKS: f64 = 6.0;

impl Chart {
    /// The chart as a picture of `width` × `height` pixels, at least 300 × 200.
    pub fn draw(&self, width: u32, height: u32) -> Picture {
        let (width, height) = (width.clamp(300, 8192), height.clamp(200, 8192));
        let mut to = Picture {
            width,
            height,
            rgb: vec![255; 3 * width as usize * height as usize],
        };
        let [left, right, above, below] = MARGINS;
        let frame = [
            left,
            above,
            i64::from(width) - right,
            i64::from(height) - below,
        ];
        let [x, y] = [0, 1].map(|a| self.range(a));
        let at = |p: [f64; 2]| {
            let part = |v: f64, [low, high]: [f64; 2]| (v - low) / (high - low);
            [
                frame[0] as f64 + part(p[0], x) * (frame[2] - frame[0]) as f64,
                frame[3] as f64 - part(p[1], y) * (frame[3] - frame[1]) as f64,
            ]
        };
        for v in marks(x) {
            let px = at([v, y[0]])[0].round();
            stroke(
                &mut to,
                [px, frame[1] as f64],
                [px, frame[3] as f64],
                1,
                GRID,
            );
            let label = number(v);
            let half = label.len() as i64 * LETTER / 2;
            text(&mut to, px as i64 - half, frame[3] + 8, &label);
        }
        for v in marks(y) {
            let py = at([x[0], v])[1].round();
            stroke(
                &mut to,
                [frame[0] as f64, py],
                [frame[2] as f64, py],
                1,
                GRID,
            );
            let label = number(v);
            let wide = label.len() as i64 * LETTER;
            text(&mut to, frame[0] - 8 - wide, py as i64 - LETTER / 2, &label);
        }
        for (k, line) in self.lines.iter().enumerate() {
            let colour = COLOURS[k % COLOURS.len()];
            let points: Vec<[f64; 2]> = line
                .points
                .iter()
                .filter(|p| p[0].is_finite() && p[1].is_finite())
                .map(|&p| at(p))
                .collect();
            for pair in points.windows(2) {
                stroke(&mut to, pair[0], pair[1], 3, colour);
            }
        }
        let mut at = frame[0];
        for (k, line) in self.lines.iter().enumerate() {
            let y = 12 + LETTER + LETTER / 2;
            let (from, to_x) = (at as f64, (at + 24) as f64);
            stroke(
                &mut to,
                [from, y as f64],
                [to_x, y as f64],
                5,
                COLOURS[k % COLOURS.len()],
            );
            text(&mut to, at + 30, y - LETTER / 2, &line.name);
            at += 30 + (line.name.len() as i64 + 1) * LETTER;
        }
        text(
            &mut to,
            frame[0],
            6,
            &format!("{}: {}", self.title, self.axes[1]),
        );
        let wide = self.axes[0].len() as i64 * LETTER;
        text(
            &mut to,
            (frame[0] + frame[2] - wide) / 2,
            frame[3] + 12 + 2 * LETTER - LETTER / 2,
            &self.axes[0],
        );
        to
    }

    /// Least and greatest value on an axis, never the same.
    fn range(&self, axis: usize) -> [f64; 2] {
        let values = self
            .lines
            .iter()
            .flat_map(|l| &l.points)
            .filter(|p| p.iter().all(|v| v.is_finite()))
            .map(|p| p[axis]);
        let [low, high] = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| {
            [l.min(v), h.max(v)]
        });
        if !(low.is_finite() && high.is_finite() && (high - low).is_finite()) {
            return [0.0, 1.0];
        }
        // Energies and loads are told from nothing.
        let low = if axis == 1 { low.min(0.0) } else { low };
        let wide = high - low;
        if wide <= 1e-300 {
            return [low - 0.5, low + 0.5];
        }
        [low, if axis == 1 { high + 0.05 * wide } else { high }]
    }
}

/// Round numbers over a range.
fn marks([low, high]: [f64; 2]) -> Vec<f64> {
    let raw = (high - low) / MARKS;
    let power = libm::pow(10.0, libm::floor(libm::log10(raw)));
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|f| f * power)
        .into_iter()
        .find(|s| *s >= raw)
        .unwrap_or(raw);
    let first = (low / step).ceil();
    (0..=(2.0 * MARKS) as i64)
        .map(|k| (first + k as f64) * step)
        .take_while(|v| *v <= high + 1e-9 * step)
        .collect()
}

/// A mark's number, short.
fn number(v: f64) -> String {
    if v == 0.0 {
        return "0".to_owned();
    }
    if (1e-3..1e5).contains(&v.abs()) {
        let text = format!("{v:.5}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    format!("{v:.1e}").replace(".0e", "e")
}

fn dot(to: &mut Picture, x: i64, y: i64, colour: [u8; 3]) {
    if x < 0 || y < 0 || x >= i64::from(to.width) || y >= i64::from(to.height) {
        return;
    }
    let at = 3 * (y as usize * to.width as usize + x as usize);
    to.rgb[at..at + 3].copy_from_slice(&colour);
}

fn stroke(to: &mut Picture, from: [f64; 2], end: [f64; 2], wide: i64, colour: [u8; 3]) {
    let (dx, dy) = (end[0] - from[0], end[1] - from[1]);
    let steps = dx.abs().max(dy.abs()).ceil().clamp(1.0, 20_000.0);
    for k in 0..=steps as i64 {
        let part = k as f64 / steps;
        let (x, y) = (from[0] + dx * part, from[1] + dy * part);
        for a in 0..wide {
            for b in 0..wide {
                let half = (wide - 1) / 2;
                dot(
                    to,
                    x.round() as i64 + a - half,
                    y.round() as i64 + b - half,
                    colour,
                );
            }
        }
    }
}

fn text(to: &mut Picture, x: i64, y: i64, words: &str) {
    for (k, c) in words.chars().enumerate() {
        let glyph = font8x8::legacy::BASIC_LEGACY
            .get(c as usize)
            .copied()
            .unwrap_or_default();
        for row in 0..LETTER {
            for column in 0..LETTER {
                if glyph[(row * 8 / LETTER) as usize] >> (column * 8 / LETTER) & 1 == 1 {
                    dot(to, x + k as i64 * LETTER + column, y + row, INK);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_runs_where_its_numbers_are() {
        let chart = Chart {
            title: "t".into(),
            axes: ["x (s)".into(), "y (J)".into()],
            lines: vec![Line {
                name: "a".into(),
                points: vec![[0.0, 0.0], [10.0, 1.0], [f64::NAN, 3.0]],
            }],
        };
        let picture = chart.draw(800, 600);
        let is_line = |x: i64, y: i64| {
            let at = 3 * (y as usize * 800 + x as usize);
            picture.rgb[at..at + 3] == COLOURS[0]
        };
        // From the axes' range 0 to 10 and 0 to 1.05.
        for part in [0.1f64, 0.5, 0.9] {
            let x = 130.0 + part * 640.0;
            let y = 530.0 - part / 1.05 * 474.0;
            assert!(is_line(x.round() as i64, y.round() as i64), "{part}");
            assert!(!is_line(x.round() as i64, y.round() as i64 - 20), "{part}");
        }
        assert_eq!(marks([0.0, 10.0]), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(number(0.02), "0.02");
        assert_eq!(number(2e-5), "2e-5");
        // Nothing, and nothing but nonsense.
        for points in [vec![], vec![[f64::INFINITY, f64::NAN]]] {
            let lines = vec![Line {
                name: String::new(),
                points,
            }];
            Chart {
                lines,
                ..chart.clone()
            }
            .draw(0, 0);
        }
    }
}
