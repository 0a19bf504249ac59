//! Heights over the section as a grid of rings × sectors: the form in which simulated, reconstructed and painted breaks
//! reach the fracture surface.

use std::f64::consts::TAU;

/// Heights along the grain on a grid of ring coordinates and angles.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightField {
    rings: usize,
    sectors: usize,
    heights: Vec<f64>,
}

/// Why numbers are no height field.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HeightFieldError {
    /// The number of heights does not fit the grid.
    #[error(
        "{rings} × {sectors} grid cells need as many heights, but there are {found}; at least 1 × 1 is needed"
    )]
    Count {
        /// Rings of the grid.
        rings: usize,
        /// Sectors of the grid.
        sectors: usize,
        /// Heights found.
        found: usize,
    },
    /// A height is not finite.
    #[error("the height of ring {ring}, sector {sector} is {found} m; heights must be finite")]
    NotFinite {
        /// Ring, from 0 at the pith.
        ring: usize,
        /// Sector, from 0.
        sector: usize,
        /// The height found, m.
        found: f64,
    },
}

impl HeightField {
    /// A field of `heights` (m, from the place of the break, up along the grain), ring by ring from the pith outwards.
    /// The height of a cell is that at its middle: ring i of n lies at the ring coordinate (i + ½)/n, sector j of m at the
    /// angle (j + ½)·2π/m.
    ///
    /// # Errors
    /// [`HeightFieldError`] where the numbers do not fit.
    ///
    /// # Examples
    /// ```
    /// use greenstick_fracture::heights::HeightField;
    ///
    /// // One ring of four sectors, 1 cm higher in the first.
    /// let field = HeightField::new(1, 4, vec![0.01, 0.0, 0.0, 0.0])?;
    /// assert_eq!(field.at(0.5, std::f64::consts::FRAC_PI_4), 0.01);
    /// # Ok::<(), greenstick_fracture::heights::HeightFieldError>(())
    /// ```
    pub fn new(
        rings: usize,
        sectors: usize,
        heights: Vec<f64>,
    ) -> Result<HeightField, HeightFieldError> {
        if heights.is_empty() || rings.checked_mul(sectors) != Some(heights.len()) {
            let found = heights.len();
            return Err(HeightFieldError::Count {
                rings,
                sectors,
                found,
            });
        }
        match heights.iter().position(|h| !h.is_finite()) {
            Some(i) => Err(HeightFieldError::NotFinite {
                ring: i / sectors,
                sector: i % sectors,
                found: heights[i],
            }),
            None => Ok(HeightField {
                rings,
                sectors,
                heights,
            }),
        }
    }

    /// The height (m) at a ring coordinate and an angle (rad), linear between the middles of cells and constant beyond the
    /// innermost and the outermost.
    pub fn at(&self, rho: f64, phi: f64) -> f64 {
        let ring = (rho * self.rings as f64 - 0.5).clamp(0.0, (self.rings - 1) as f64);
        let turn = phi / TAU;
        let sector = (turn - turn.floor()) * self.sectors as f64 - 0.5;
        let (i, j) = (ring.floor(), sector.floor());
        let (u, v) = (ring - i, sector - j);
        let cell = |i: f64, j: f64| {
            let ring = (i as usize).min(self.rings - 1);
            let sector = (j + self.sectors as f64) as usize % self.sectors;
            self.heights[ring * self.sectors + sector]
        };
        let along = |i: f64| cell(i, j) + (cell(i, j + 1.0) - cell(i, j)) * v;
        along(i) + (along(i + 1.0) - along(i)) * u
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_is_what_it_was_made_of_and_linear_between() {
        let heights: Vec<f64> = (0..12).map(f64::from).collect();
        let field = HeightField::new(3, 4, heights).unwrap();
        let middle = |i: f64, j: f64| field.at((i + 0.5) / 3.0, (j + 0.5) * TAU / 4.0);
        for i in 0..3 {
            for j in 0..4 {
                let found = middle(f64::from(i), f64::from(j));
                assert!((found - f64::from(4 * i + j)).abs() < 1e-12);
            }
        }
        assert!((middle(0.5, 1.5) - 3.5).abs() < 1e-12);
        // Around the seam, the pith and the bark.
        assert!((middle(0.0, 3.5) - 1.5).abs() < 1e-12);
        assert!((middle(0.0, -0.5) - 1.5).abs() < 1e-12);
        assert_eq!(field.at(0.0, 0.4), field.at(0.1, 0.4));
        assert_eq!(field.at(1.3, 0.4), field.at(1.0, 0.4));
    }

    #[test]
    fn numbers_that_are_no_field_are_refused() {
        let new = |rings, sectors, heights| HeightField::new(rings, sectors, heights).unwrap_err();
        assert!(new(0, 4, vec![]).to_string().contains("0 × 4"));
        assert!(matches!(
            new(2, 2, vec![0.0; 3]),
            HeightFieldError::Count { found: 3, .. }
        ));
        assert!(matches!(
            new(usize::MAX, 2, vec![0.0]),
            HeightFieldError::Count { .. }
        ));
        let bad = new(1, 2, vec![0.0, f64::NAN]).to_string();
        assert!(bad.contains("sector 1 is NaN"), "{bad}");
    }
}
