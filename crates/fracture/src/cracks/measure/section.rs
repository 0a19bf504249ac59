//! The photograph of a section, and where the section lies in it.

use super::error::MeasureError;
use glam::DVec2;
use greenstick_wood::colour::{RgbImage, linear_from_srgb};
use serde::Serialize;
use std::f64::consts::TAU;

/// Directions of an outline that is found.
const DIRECTIONS: usize = 360;
/// Share of the photograph's pixels that a section takes at least.
const MIN_SHARE: f64 = 0.02;

/// A photograph of a section by its brightness.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionPhotograph {
    width: usize,
    height: usize,
    /// Linear red, green and blue, row by row from the top.
    colours: Vec<[f32; 3]>,
}

/// A section in a photograph, in pixels from its upper left corner.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhotographedSection {
    /// Pith.
    pub pith: [f64; 2],
    /// Outline, closed.
    pub outline: Vec<[f64; 2]>,
}

impl PhotographedSection {
    /// Returns a round section.
    pub fn circle(pith: [f64; 2], radius: f64) -> Self {
        let at = |k: usize| {
            let (sin, cos) = libm::sincos(TAU * k as f64 / DIRECTIONS as f64);
            [pith[0] + radius * cos, pith[1] + radius * sin]
        };
        PhotographedSection {
            pith,
            outline: (0..DIRECTIONS).map(at).collect(),
        }
    }
}

impl From<&RgbImage> for SectionPhotograph {
    fn from(image: &RgbImage) -> Self {
        let linear = |c: &[u8; 3]| linear_from_srgb(*c).map(|v| v as f32);
        SectionPhotograph {
            width: image.width as usize,
            height: image.height as usize,
            colours: image.rgb.as_chunks().0.iter().map(linear).collect(),
        }
    }
}

impl SectionPhotograph {
    /// Returns a photograph of linear red, green and blue, row by row from the top.
    ///
    /// # Errors
    /// [`MeasureError::Size`] where the colours are not as many as the pixels.
    pub fn new(width: usize, height: usize, colours: Vec<[f32; 3]>) -> Result<Self, MeasureError> {
        if width == 0 || height == 0 || colours.len() != width * height {
            return Err(MeasureError::Size {
                width,
                height,
                found: colours.len(),
            });
        }
        Ok(SectionPhotograph {
            width,
            height,
            colours,
        })
    }

    /// Returns the width and height, pixels.
    pub fn size(&self) -> (usize, usize) {
        (self.width, self.height)
    }

    /// Returns the brightness at a point, pixels from the upper left corner, between the nearest pixels.
    pub(super) fn brightness(&self, at: DVec2) -> f32 {
        let (x, y) = (at.x - 0.5, at.y - 0.5);
        let x = x.clamp(0.0, (self.width - 1) as f64);
        let y = y.clamp(0.0, (self.height - 1) as f64);
        let (i, j) = (x as usize, y as usize);
        let (u, v) = ((x - i as f64) as f32, (y - j as f64) as f32);
        let (right, down) = ((i + 1).min(self.width - 1), (j + 1).min(self.height - 1));
        let grey = |i: usize, j: usize| self.colours[j * self.width + i].iter().sum::<f32>() / 3.0;
        let top = grey(i, j) * (1.0 - u) + grey(right, j) * u;
        let bottom = grey(i, down) * (1.0 - u) + grey(right, down) * u;
        top * (1.0 - v) + bottom * v
    }

    /// Finds a section that stands out from the background at the border of the photograph. The pith is taken to be at its
    /// centroid.
    ///
    /// # Errors
    /// [`MeasureError::NoSection`] where nothing stands out, or what does reaches the border.
    pub fn find_section(&self) -> Result<PhotographedSection, MeasureError> {
        let apart = self.distances_from_background();
        let threshold = between_classes(&apart);
        let part = self.largest_part(|i| apart[i] > threshold);
        let count = part.iter().filter(|&&p| p).count();
        let none = |problem: String| MeasureError::NoSection { problem };
        if (count as f64) < MIN_SHARE * part.len() as f64 {
            let share = 100.0 * count as f64 / part.len() as f64;
            return Err(none(format!(
                "what stands out most from the colour of the border is {share:.1} % of the pixels"
            )));
        }
        let on_border = (0..part.len())
            .filter(|&i| part[i])
            .any(|i| self.is_border(i));
        if on_border {
            return Err(none(
                "what stands out from the background reaches the border".to_owned(),
            ));
        }
        let place = |i: usize| DVec2::new((i % self.width) as f64, (i / self.width) as f64) + 0.5;
        let pixels = (0..part.len()).filter(|&i| part[i]);
        let centre = pixels.map(place).sum::<DVec2>() / count as f64;
        let reach = self.width.max(self.height) as f64;
        let outline = (0..DIRECTIONS).map(|k| {
            let (sin, cos) = libm::sincos(TAU * k as f64 / DIRECTIONS as f64);
            let direction = DVec2::new(cos, sin);
            // From the outside in, so that a crack that is open at the bark is no end of the section.
            let steps = (0..(2.0 * reach) as usize).rev().map(|s| 0.5 * s as f64);
            let inside = |r: &f64| {
                let p = centre + direction * *r;
                let (x, y) = (p.x.floor(), p.y.floor());
                x >= 0.0
                    && y >= 0.0
                    && (x as usize) < self.width
                    && (y as usize) < self.height
                    && part[y as usize * self.width + x as usize]
            };
            let radius = steps.into_iter().find(inside).unwrap_or(0.0);
            (centre + direction * radius).to_array()
        });
        Ok(PhotographedSection {
            pith: centre.to_array(),
            outline: outline.collect(),
        })
    }

    fn is_border(&self, i: usize) -> bool {
        let (x, y) = (i % self.width, i / self.width);
        x == 0 || y == 0 || x + 1 == self.width || y + 1 == self.height
    }

    /// Returns how far each pixel's colour is from the border's, to which a plane over the photograph is fitted.
    fn distances_from_background(&self) -> Vec<f32> {
        let border: Vec<usize> = (0..self.colours.len())
            .filter(|&i| self.is_border(i))
            .collect();
        let scale = 1.0 / self.width.max(self.height) as f64;
        let place = |i: usize| {
            let x = (i % self.width) as f64 - 0.5 * self.width as f64;
            let y = (i / self.width) as f64 - 0.5 * self.height as f64;
            DVec2::new(x, y) * scale
        };
        // The border is symmetrical about the middle, so that mean and slopes are independent.
        let (mut mean, mut slope, mut square) = ([0.0; 3], [DVec2::ZERO; 3], DVec2::ZERO);
        for &i in &border {
            let p = place(i);
            square += p * p;
            for (c, &value) in self.colours[i].iter().enumerate() {
                mean[c] += f64::from(value) / border.len() as f64;
                slope[c] += p * f64::from(value);
            }
        }
        let slope = slope.map(|s| s / square.max(DVec2::splat(1e-12)));
        (0..self.colours.len())
            .map(|i| {
                let p = place(i);
                let off = |c: usize| f64::from(self.colours[i][c]) - mean[c] - slope[c].dot(p);
                (0..3).map(|c| off(c) * off(c)).sum::<f64>().sqrt() as f32
            })
            .collect()
    }

    /// Returns the largest part of connected pixels of those `chosen`.
    fn largest_part(&self, chosen: impl Fn(usize) -> bool) -> Vec<bool> {
        const NONE: u32 = u32::MAX;
        let mut label = vec![NONE; self.colours.len()];
        let (mut largest, mut parts) = ((0, NONE), 0);
        for start in 0..label.len() {
            if label[start] != NONE || !chosen(start) {
                continue;
            }
            let (mut open, mut count) = (vec![start], 0);
            label[start] = parts;
            while let Some(i) = open.pop() {
                count += 1;
                let (x, y) = (i % self.width, i / self.width);
                let sides = [
                    (x > 0).then(|| i - 1),
                    (x + 1 < self.width).then(|| i + 1),
                    (y > 0).then(|| i - self.width),
                    (y + 1 < self.height).then(|| i + self.width),
                ];
                for j in sides.into_iter().flatten() {
                    if label[j] == NONE && chosen(j) {
                        label[j] = parts;
                        open.push(j);
                    }
                }
            }
            if count > largest.0 {
                largest = (count, parts);
            }
            parts += 1;
        }
        label.iter().map(|&l| l != NONE && l == largest.1).collect()
    }
}

/// Returns the value that separates two classes of values best (Otsu 1979).
fn between_classes(values: &[f32]) -> f32 {
    const BINS: usize = 256;
    let most = values.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
    let mut counts = [0.0; BINS];
    for v in values {
        counts[((v / most * BINS as f32) as usize).min(BINS - 1)] += 1.0;
    }
    let total: f64 = counts.iter().sum();
    let sum: f64 = counts.iter().enumerate().map(|(i, c)| i as f64 * c).sum();
    let (mut below, mut sum_below, mut best) = (0.0, 0.0, (0.0, 0));
    for (i, c) in counts.iter().enumerate() {
        below += c;
        sum_below += i as f64 * c;
        if below > 0.0 && below < total {
            let off = sum_below / below - (sum - sum_below) / (total - below);
            let between = below * (total - below) * off * off;
            if between > best.0 {
                best = (between, i + 1);
            }
        }
    }
    best.1 as f32 / BINS as f32 * most
}
