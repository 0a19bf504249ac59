//! Heights over the section as a grid of rings × sectors: the form in which simulated, reconstructed and painted breaks
//! reach the fracture surface.

use crate::slabs::SectionSpan;
use greenstick_schema::choices;
use std::f64::consts::TAU;

/// Heights along the grain on a grid of ring coordinates and angles and, where it is known, how the wood failed.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightField {
    span: SectionSpan,
    rings: usize,
    sectors: usize,
    heights: Vec<f64>,
    failures: Option<Vec<CellFailure>>,
    added: bool,
}

choices! {
    /// How the wood of a part of the section failed.
    pub enum FailureMode {
        /// Torn in tension: splinters.
        Torn = "torn",
        /// Crushed, then torn: short and blunt.
        Crushed = "crushed",
        /// Split off along the grain, and broken far from the wood beside it: slabs.
        Split = "split",
        /// Torn by twisting.
        Twisted = "twisted",
        /// Whole: the face is laid through it.
        Unbroken = "unbroken",
    }
}

impl FailureMode {
    /// All modes.
    pub const ALL: [FailureMode; 5] = [
        FailureMode::Torn,
        FailureMode::Crushed,
        FailureMode::Split,
        FailureMode::Twisted,
        FailureMode::Unbroken,
    ];
}

/// How the wood of a cell of the grid failed. It decides the relief that is finer than the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellFailure {
    /// The mode.
    pub mode: FailureMode,
    /// Factor on the torn relief that the parameters of the break describe; it takes the place of a species' factor, unless the
    /// field is added to what the parameters shape.
    pub splintering: f64,
}

impl CellFailure {
    /// Returns how much of the wood is torn rather than crushed, 0 to 1. Wood that was crushed and still splinters far was
    /// torn after all.
    fn torn(&self) -> f64 {
        match self.mode {
            FailureMode::Crushed => (CRUSHED_TEAR * self.splintering).min(MAX_CRUSHED_TEAR),
            _ => 1.0,
        }
    }
}

/// Share of crushed wood that is torn for each unit of its splintering, and the most of it.
const CRUSHED_TEAR: f64 = 0.5;
const MAX_CRUSHED_TEAR: f64 = 0.6;

/// The relief at a point of the section, between the cells of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LocalFailure {
    /// How much of the wood is torn rather than crushed, 0 to 1.
    pub torn: f64,
    /// Factor on the torn relief.
    pub splintering: f64,
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
    /// The part of the section that the grid lies over is empty.
    #[error(
        "the grid lies over ring coordinates {from} to {to}; expected a range from the pith outwards"
    )]
    Empty {
        /// Least ring coordinate.
        from: f64,
        /// Greatest ring coordinate.
        to: f64,
    },
    /// A factor on the relief is not a number from 0 on.
    #[error(
        "the splintering of ring {ring}, sector {sector} is {found}; factors must be 0 or more"
    )]
    Splintering {
        /// Ring, from 0 at the pith.
        ring: usize,
        /// Sector, from 0.
        sector: usize,
        /// The factor found.
        found: f64,
    },
}

/// A point between the middles of cells.
struct GridPoint {
    /// Numbers of the four cells about it, two of each ring.
    cells: [[usize; 2]; 2],
    /// Parts of the way from the first sector to the second, and from the first ring to the second.
    parts: (f64, f64),
}

impl GridPoint {
    /// Returns the value at the point: linear between the cells.
    fn blend(&self, value: impl Fn(usize) -> f64) -> f64 {
        let (across, out) = self.parts;
        let along = |[a, b]: [usize; 2]| value(a) + (value(b) - value(a)) * across;
        let (inner, outer) = (along(self.cells[0]), along(self.cells[1]));
        inner + (outer - inner) * out
    }
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
        HeightField::over(SectionSpan::WHOLE, rings, sectors, heights)
    }

    /// A field over a part of the section, such as that of a board, whose pith lies far off. Cells divide the part evenly.
    ///
    /// # Errors
    /// As [`HeightField::new`], and for an empty part.
    pub fn over(
        span: SectionSpan,
        rings: usize,
        sectors: usize,
        heights: Vec<f64>,
    ) -> Result<HeightField, HeightFieldError> {
        let (from, to) = span.rho;
        if !(from < to && span.phi.is_none_or(|(a, b)| a < b)) {
            return Err(HeightFieldError::Empty { from, to });
        }
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
                span,
                rings,
                sectors,
                heights,
                failures: None,
                added: false,
            }),
        }
    }

    /// The same field with how the wood failed in each cell. With it the procedural model adds slivers, fibres and strips
    /// of bark to the heights; without it only the fur of fine fibres.
    ///
    /// # Errors
    /// [`HeightFieldError`] where the numbers do not fit.
    pub fn with_failures(mut self, failures: Vec<CellFailure>) -> Result<Self, HeightFieldError> {
        let (rings, sectors) = (self.rings, self.sectors);
        if failures.len() != self.heights.len() {
            let found = failures.len();
            return Err(HeightFieldError::Count {
                rings,
                sectors,
                found,
            });
        }
        let wrong = |f: &CellFailure| !f.splintering.is_finite() || f.splintering < 0.0;
        if let Some(i) = failures.iter().position(wrong) {
            return Err(HeightFieldError::Splintering {
                ring: i / sectors,
                sector: i % sectors,
                found: failures[i].splintering,
            });
        }
        self.failures = Some(failures);
        Ok(self)
    }

    /// The same field as an addition: its heights are over those that the parameters of the break shape, and its splintering is
    /// over theirs.
    #[must_use]
    pub fn added(self) -> Self {
        HeightField {
            added: true,
            ..self
        }
    }

    /// Whether it is added to what the parameters of the break shape, rather than taking its place.
    pub fn is_added(&self) -> bool {
        self.added
    }

    /// The part of the section that it lies over.
    pub fn span(&self) -> SectionSpan {
        self.span
    }

    /// Number of sectors of the grid.
    pub fn sectors(&self) -> usize {
        self.sectors
    }

    /// The height of each cell, m, ring by ring.
    pub fn heights(&self) -> &[f64] {
        &self.heights
    }

    /// Whether it is known how the wood failed.
    pub fn has_failures(&self) -> bool {
        self.failures.is_some()
    }

    /// How the wood failed in each cell, ring by ring; empty where that is not known.
    pub fn failures(&self) -> &[CellFailure] {
        self.failures.as_deref().unwrap_or_default()
    }

    /// The ring coordinate and the angle (rad) of the middle of a cell, by its number, ring by ring.
    pub fn middle(&self, cell: usize) -> (f64, f64) {
        grid_middle(&self.span, (self.rings, self.sectors), cell)
    }

    /// The height (m) at a ring coordinate and an angle (rad), linear between the middles of cells and constant beyond the
    /// innermost and the outermost.
    pub fn at(&self, rho: f64, phi: f64) -> f64 {
        self.grid_point(rho, phi).blend(|cell| self.heights[cell])
    }

    /// How the wood failed at a ring coordinate and an angle (rad), where that is known; between cells as heights are.
    pub(crate) fn failure_at(&self, rho: f64, phi: f64) -> Option<LocalFailure> {
        let failures = self.failures.as_ref()?;
        let point = self.grid_point(rho, phi);
        Some(LocalFailure {
            torn: point.blend(|cell| failures[cell].torn()),
            splintering: point.blend(|cell| failures[cell].splintering),
        })
    }

    fn grid_point(&self, rho: f64, phi: f64) -> GridPoint {
        let SectionSpan {
            rho: (low, high),
            phi: arc,
        } = self.span;
        let rho = (rho - low) / (high - low);
        let ring = (rho * self.rings as f64 - 0.5).clamp(0.0, (self.rings - 1) as f64);
        let sectors = self.sectors as f64;
        let sector = match arc {
            None => {
                let turn = phi / TAU;
                (turn - turn.floor()) * sectors - 0.5
            }
            Some((from, to)) => {
                // The turn of the angle that is nearest to the arc.
                let off = phi - 0.5 * (from + to);
                let off = off - TAU * (off / TAU).round();
                ((0.5 + off / (to - from)) * sectors - 0.5).clamp(0.0, sectors - 1.0)
            }
        };
        let (i, j) = (ring.floor(), sector.floor());
        let cell = |i: f64, j: f64| {
            let ring = (i as usize).min(self.rings - 1);
            let sector = (j + sectors) as usize % self.sectors;
            ring * self.sectors + sector
        };
        let pair = |i: f64| [cell(i, j), cell(i, j + 1.0)];
        GridPoint {
            cells: [pair(i), pair(i + 1.0)],
            parts: (sector - j, ring - i),
        }
    }
}

/// The ring coordinate and the angle (rad) of the middle of a cell of a grid of rings × sectors over a part of the section,
/// by its number, ring by ring.
pub fn grid_middle(
    span: &SectionSpan,
    (rings, sectors): (usize, usize),
    cell: usize,
) -> (f64, f64) {
    let part = |i: usize, of: usize, (from, to): (f64, f64)| {
        from + (to - from) * (i as f64 + 0.5) / of as f64
    };
    (
        part(cell / sectors, rings, span.rho),
        part(cell % sectors, sectors, span.phi.unwrap_or((0.0, TAU))),
    )
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
    fn a_field_over_a_board_has_all_its_cells_there() {
        let span = SectionSpan {
            rho: (0.8, 1.0),
            phi: Some((6.1, 6.5)),
        };
        let heights: Vec<f64> = (0..6).map(f64::from).collect();
        let crushed = |cell: usize| CellFailure {
            mode: FailureMode::ALL[cell % 2],
            splintering: cell as f64,
        };
        let field = HeightField::over(span, 2, 3, heights).unwrap();
        let field = field.with_failures((0..6).map(crushed).collect()).unwrap();
        for cell in 0..6 {
            let (rho, phi) = field.middle(cell);
            assert!((0.8..1.0).contains(&rho) && (6.1..6.5).contains(&phi));
            for turn in [-TAU, 0.0, TAU] {
                assert!((field.at(rho, phi + turn) - cell as f64).abs() < 1e-9);
                let local = field.failure_at(rho, phi + turn).unwrap();
                let torn = [1.0, (0.5 * cell as f64).min(0.6)][cell % 2];
                assert!((local.torn - torn).abs() < 1e-9);
                assert!((local.splintering - cell as f64).abs() < 1e-9);
            }
        }
        // Beyond its ends it does not wrap around.
        assert_eq!(field.at(0.85, 6.0), 0.0);
        assert_eq!(field.at(0.85, 6.6), 2.0);
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
        let whole = HeightField::new(1, 2, vec![0.0; 2]).unwrap();
        let torn = |splintering| CellFailure {
            mode: FailureMode::Torn,
            splintering,
        };
        let few = whole.clone().with_failures(vec![torn(1.0)]).unwrap_err();
        assert!(matches!(few, HeightFieldError::Count { found: 1, .. }));
        let below = whole.with_failures(vec![torn(1.0), torn(-1.0)]);
        assert!(below.unwrap_err().to_string().contains("sector 1 is -1"));
        let nothing = SectionSpan {
            rho: (1.0, 1.0),
            phi: None,
        };
        let empty = HeightField::over(nothing, 1, 1, vec![0.0]).unwrap_err();
        assert!(matches!(empty, HeightFieldError::Empty { .. }));
    }
}
