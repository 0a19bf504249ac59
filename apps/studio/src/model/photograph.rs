//! A photograph of a real break, laid over the viewport or beside it, to match it.

use greenstick::formats::photograph::Photograph;
use greenstick::schema::{FILE_NAME, Unit, flag, number, parameters, text};

/// Farthest shift, in heights of the viewport.
const FARTHEST: f64 = 4.0;

parameters! {
    /// A photograph, and how it lies in the viewport.
    pub struct Overlay {
        "Photograph", "photograph" {
            /// The picture file, PNG or JPEG. A relative name starts from the folder of the project.
            file: Option<String> = None, text(FILE_NAME).auto();
            /// Whether it is shown beside the stem and not over it.
            beside: bool = false, flag();
            /// How much of it covers what is below: 0 nothing, 1 all.
            opacity: f64 = 0.5, number(Unit::One, 0.0, 1.0);
            /// Its height over that of the viewport.
            scale: f64 = 0.9, number(Unit::One, 0.02, 50.0).logarithmic();
            /// By how much it is turned, clockwise.
            turn: f64 = 0.0, number(Unit::Degree, -180.0, 180.0);
            /// By how much it is shifted to the right, in heights of the viewport.
            right: f64 = 0.0, number(Unit::One, -FARTHEST, FARTHEST);
            /// By how much it is shifted upwards, in heights of the viewport.
            up: f64 = 0.0, number(Unit::One, -FARTHEST, FARTHEST);
        }
    }
}

impl Overlay {
    /// Its corners in a viewport with the middle `middle` and this height: the top left one, and on clockwise. Coordinates grow to
    /// the right and downwards; `aspect` is the width of the photograph over its height.
    pub fn corners(&self, middle: [f64; 2], height: f64, aspect: f64) -> [[f64; 2]; 4] {
        let half = 0.5 * self.scale * height;
        let (sin, cos) = self.turn.to_radians().sin_cos();
        let centre = [
            middle[0] + self.right * height,
            middle[1] - self.up * height,
        ];
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| {
            let (x, y) = (x * half * aspect, y * half);
            [centre[0] + x * cos - y * sin, centre[1] + x * sin + y * cos]
        })
    }

    /// Shifts it by a movement of the pointer in a viewport of this height, points.
    pub fn shift(&mut self, by: [f64; 2], height: f64) {
        self.right = (self.right + by[0] / height).clamp(-FARTHEST, FARTHEST);
        self.up = (self.up - by[1] / height).clamp(-FARTHEST, FARTHEST);
    }

    /// Scales it about a point of the viewport (from its middle, in heights of the viewport, right and up), which stays where it is.
    pub fn zoom(&mut self, factor: f64, about: [f64; 2]) {
        let scale = (self.scale * factor).clamp(0.02, 50.0);
        let factor = scale / self.scale;
        self.scale = scale;
        let moved = |from: f64, at: f64| (at + (from - at) * factor).clamp(-FARTHEST, FARTHEST);
        self.right = moved(self.right, about[0]);
        self.up = moved(self.up, about[1]);
    }

    /// Turns it, degrees clockwise.
    pub fn turn_by(&mut self, degrees: f64) {
        self.turn = (self.turn + degrees + 180.0).rem_euclid(360.0) - 180.0;
    }
}

/// Most pixels of a photograph a side: what every card takes.
pub const PICTURE_SIDE: u32 = 2048;

/// A photograph with at most `side` pixels a side: blocks of pixels become their mean.
pub fn reduced(photograph: &Photograph, side: u32) -> Photograph {
    let (width, height) = (photograph.width, photograph.height);
    let block = width.max(height).div_ceil(side.max(1)).max(1);
    let (w, h) = (width.div_ceil(block), height.div_ceil(block));
    let mut rgb = Vec::with_capacity((w * h * 3) as usize);
    for row in 0..h {
        for column in 0..w {
            let mut sum = [0u32; 3];
            let mut count = 0;
            for y in row * block..((row + 1) * block).min(height) {
                for x in column * block..((column + 1) * block).min(width) {
                    let at = 3 * (y as usize * width as usize + x as usize);
                    for (sum, c) in sum.iter_mut().zip(&photograph.rgb[at..at + 3]) {
                        *sum += u32::from(*c);
                    }
                    count += 1;
                }
            }
            rgb.extend(sum.map(|s| ((s + count / 2) / count) as u8));
        }
    }
    Photograph {
        width: w,
        height: h,
        rgb,
    }
}

/// Whether a file is a picture, by its name.
pub fn is_picture(path: &str) -> bool {
    let name = path.to_lowercase();
    PICTURE_ENDINGS.iter().any(|ending| name.ends_with(ending))
}

/// Endings of pictures.
pub const PICTURE_ENDINGS: [&str; 3] = [".png", ".jpg", ".jpeg"];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_keep_right_angles_and_zoom_keeps_its_point() {
        let mut overlay = Overlay {
            turn: 30.0,
            right: 0.25,
            up: -0.125,
            scale: 0.5,
            ..Overlay::default()
        };
        let aspect = 1.5;
        let [a, b, c, d] = overlay.corners([400.0, 300.0], 600.0, aspect);
        let to = |p: [f64; 2], q: [f64; 2]| [q[0] - p[0], q[1] - p[1]];
        let length = |v: [f64; 2]| v[0].hypot(v[1]);
        let (across, down) = (to(a, b), to(a, d));
        assert!((length(across) - 450.0).abs() < 1e-9 && (length(down) - 300.0).abs() < 1e-9);
        assert!((across[0] * down[0] + across[1] * down[1]).abs() < 1e-9);
        let middle = [0.5 * (a[0] + c[0]), 0.5 * (a[1] + c[1])];
        assert!((middle[0] - 550.0).abs() < 1e-9 && (middle[1] - 375.0).abs() < 1e-9);
        // Clockwise: the top right corner lies lower than the top left one.
        assert!(b[1] > a[1]);
        // What is under the pointer stays there.
        let about = [(a[0] - 400.0) / 600.0, (300.0 - a[1]) / 600.0];
        overlay.zoom(1.7, about);
        let after = overlay.corners([400.0, 300.0], 600.0, aspect)[0];
        assert!(length(to(a, after)) < 1e-9, "{after:?}");
        overlay.turn_by(170.0);
        assert!((overlay.turn + 160.0).abs() < 1e-9, "{}", overlay.turn);
    }

    #[test]
    fn a_reduced_photograph_keeps_its_mean() {
        let (width, height) = (64u32, 32u32);
        let colour = |i: u32| [(i % 251) as u8, (i % 17) as u8, 40];
        let whole = Photograph {
            width,
            height,
            rgb: (0..width * height).flat_map(colour).collect(),
        };
        assert_eq!(reduced(&whole, 64), whole);
        let small = reduced(&whole, 20);
        assert_eq!((small.width, small.height), (16, 8));
        let mean = |p: &Photograph, k: usize| {
            let all = p.rgb.iter().skip(k).step_by(3).map(|c| f64::from(*c));
            all.sum::<f64>() / f64::from(p.width * p.height)
        };
        for k in 0..3 {
            assert!((mean(&whole, k) - mean(&small, k)).abs() < 0.51);
        }
    }
}
