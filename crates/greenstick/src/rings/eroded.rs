//! Rings of a section by the published erosion (Forests 2023 §3.3), in the layout of its file.

use super::{
    AROUND, EARLYWOOD, LATEWOOD, POINTS, RingComparison, RingsError, Section, comparison, radii,
};
use crate::erosion::Erosion;
use glam::DVec2;
use greenstick_geometry::Bitmap;
use greenstick_picture::Picture;
use greenstick_wood::anatomy::{Grid, fill};
use greenstick_wood::rings::{Kind, rings_of};

/// Width of the picture that is eroded over the section's.
const MARGIN: f64 = 1.04;

/// A section with the rings of an erosion.
#[derive(Debug, Clone, PartialEq)]
pub struct ErodedRings {
    /// The pith, in the file's coordinates. An erosion from the contour takes no notice of it.
    pub pith: DVec2,
    /// Whether it was guessed from the outline.
    pub guessed: bool,
    /// Outer contours of the rings from the innermost on, the largest where a ring is in several parts, in the file's
    /// coordinates.
    pub contours: Vec<Vec<DVec2>>,
    /// What passes take off, from the contour inwards.
    pub kinds: Vec<Kind>,
    section: Section,
    grid: Grid,
    middle: DVec2,
    passes: Vec<u16>,
}

impl Section {
    /// Its rings by an erosion on a picture of `resolution` × `resolution` pixels; `pith` or the file's pith or a guessed
    /// one is where an inner circle lies.
    ///
    /// # Errors
    /// [`RingsError`] where the outline or the pith is wrong, or no pass takes anything off.
    pub fn eroded(
        self,
        erosion: &Erosion,
        resolution: usize,
        pith: Option<DVec2>,
    ) -> Result<ErodedRings, RingsError> {
        let fronts = erosion.fronts(resolution)?;
        let (field, guessed) = self.field(pith)?;
        let (low, high) = self.reach();
        let middle = 0.5 * (low + high);
        let grid = Grid {
            count: resolution,
            pixel: MARGIN * (high - low).max_element() / resolution as f64,
        };
        let outline: Vec<DVec2> = self.outline.iter().map(|p| *p - middle).collect();
        let map = fill(&grid, &[outline]);
        let edge = DVec2::splat(0.5 * resolution as f64 - 0.5);
        let in_pixels = (field.pith() - middle) / grid.pixel + edge;
        let mean_radius = (map.count() as f64 / std::f64::consts::PI).sqrt();
        let (passes, kinds) = fronts.passes(&map, in_pixels, mean_radius);
        if kinds.is_empty() {
            return Err(RingsError::Uneroded { resolution });
        }
        let mut made = ErodedRings {
            pith: field.pith(),
            guessed,
            contours: Vec::new(),
            kinds,
            section: self,
            grid,
            middle,
            passes,
        };
        let rings = rings_of(made.kinds.iter().copied());
        let firsts = (1..rings.len()).filter(|&n| rings[n] > rings[n - 1]);
        made.contours = firsts
            .rev()
            .map(|n| made.left_after(n - 1))
            .filter(|contour| !contour.is_empty())
            .collect();
        Ok(made)
    }
}

impl ErodedRings {
    /// The contour of what is left after a number of passes, of the largest part of it; [`POINTS`] points at equal
    /// distances, from the middles of pixels' edges.
    fn left_after(&self, passes: usize) -> Vec<DVec2> {
        let count = self.grid.count;
        let mut left = Bitmap::new(count, count);
        for (i, &pass) in self.passes.iter().enumerate() {
            if usize::from(pass) > passes {
                left.set(i % count, i / count, true);
            }
        }
        let twice_area = |border: &Vec<[usize; 2]>| -> i64 {
            let next = border.iter().cycle().skip(1);
            let parts = border.iter().zip(next);
            parts
                .map(|([x, y], [u, v])| (x * v) as i64 - (u * y) as i64)
                .sum()
        };
        let Some(border) = left.borders().into_iter().max_by_key(twice_area) else {
            return Vec::new();
        };
        let corner = |i: usize| {
            let [x, y] = border[i % border.len()];
            DVec2::new(x as f64, y as f64)
        };
        let half = 0.5 * count as f64;
        (0..POINTS)
            .map(|k| {
                // Between the middles of an edge and the next one.
                let place = k as f64 / POINTS as f64 * border.len() as f64;
                let i = place as usize;
                let middle = |i: usize| 0.5 * (corner(i) + corner(i + 1));
                let p = middle(i).lerp(middle(i + 1), place.fract());
                (p - half) * self.grid.pixel + self.middle
            })
            .collect()
    }

    /// The section's file with these rings in place of its own.
    pub fn json(&self) -> String {
        let rings = self.contours.iter().map(|contour| {
            let mean = radii(contour, self.pith).iter().sum::<f64>() / POINTS as f64;
            (mean, contour.clone())
        });
        let how = "rings by erosion, from the outline";
        self.section.json(how, self.pith, self.guessed, rings)
    }

    /// The file's own rings, each beside what is left after the pass whose mean radius is nearest.
    ///
    /// # Errors
    /// [`RingsError::Nothing`] where the file has none.
    pub fn compare(&self) -> Result<Vec<RingComparison>, RingsError> {
        let left: Vec<Vec<f64>> = (0..self.kinds.len())
            .map(|passes| radii(&self.left_after(passes), self.pith))
            // Seen from the pith it must be all round.
            .filter(|radii| radii.iter().all(|r| *r > 0.0))
            .collect();
        comparison(&self.section, self.pith, |mean| {
            let off = |radii: &Vec<f64>| (radii.iter().sum::<f64>() / POINTS as f64 - mean).abs();
            left.iter()
                .min_by(|a, b| off(a).total_cmp(&off(b)))
                .cloned()
                .unwrap_or_else(|| vec![mean; POINTS])
        })
    }

    /// A picture, `size` pixels wide and high, as it lies in the file.
    pub fn picture(&self, size: u32) -> Picture {
        self.section.picture(size, |p| {
            let count = self.grid.count as f64;
            let at = ((p - self.middle) / self.grid.pixel + 0.5 * count).floor();
            if at.min_element() < 0.0 || at.max_element() >= count {
                return AROUND;
            }
            let pass = self.passes[at.y as usize * self.grid.count + at.x as usize];
            match (pass, self.kinds.get(usize::from(pass).wrapping_sub(1))) {
                (0, _) => AROUND,
                (_, Some(Kind::Latewood)) => LATEWOOD,
                _ => EARLYWOOD,
            }
        })
    }
}
