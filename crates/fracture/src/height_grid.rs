//! Heights of a broken face as parameters: how a recipe holds those that were measured, simulated or painted.

use crate::field::{CellFailure, FailureMode, HeightField, HeightFieldError};
use crate::heights::HeightSource;
use crate::slabs::SectionSpan;
use greenstick_schema::{
    Kind, ParameterError, Unit, choice, count, flag, length, list, number, parameters,
};
use std::sync::Arc;

/// Most cells of a grid, and most sectors.
const MAX_CELLS: usize = 1 << 20;
/// Greatest height, m.
const MAX_HEIGHT: f64 = 1000.0;
/// Greatest factor on the relief.
const MAX_SPLINTERING: f64 = 1e6;
/// Greatest ring coordinate: boards lie far from their pith.
const MAX_COORDINATE: f64 = 1e6;
/// Greatest angle, rad: arcs may go on over the seam behind the pith.
const MAX_ANGLE: f64 = 20.0;

/// A height in a list.
const HEIGHT: Kind = length(-MAX_HEIGHT, MAX_HEIGHT).kind;
/// A mode in a list.
const MODE: Kind = choice(FailureMode::CHOICES).kind;
/// A factor in a list.
const SPLINTERING: Kind = number(Unit::One, 0.0, MAX_SPLINTERING).kind;
/// A ring coordinate of the part of the section.
const COORDINATE: Kind = number(Unit::One, 0.0, MAX_COORDINATE).kind;
/// An angle of the part of the section, rad.
const ANGLE: Kind = number(Unit::One, -MAX_ANGLE, MAX_ANGLE).kind;

parameters! {
    /// Heights of the broken face that were measured, simulated or painted, on a grid of rings × sectors. Without them the
    /// face is drawn by the parameters of the break alone.
    pub struct HeightGrid {
        "", "heights" {
            /// Sectors of the grid, counter-clockwise about the pith.
            sectors: u32 = 1, count(1, MAX_CELLS as i128);
            /// Height of each cell at its middle, from the place of the break up along the grain, ring by ring from the pith
            /// outwards. There are as many rings as it takes; none: the face is drawn.
            values: Vec<f64> = Vec::new(), list(&HEIGHT, 0, MAX_CELLS);
            /// How the wood of each cell failed, which decides the relief that is finer than the grid: slivers, fibres and
            /// strips of bark; none: only the fur of fine fibres.
            modes: Vec<FailureMode> = Vec::new(), list(&MODE, 0, MAX_CELLS);
            /// Factor on the torn relief of each cell, as many as modes; it takes the place of a species' factor.
            splintering: Vec<f64> = Vec::new(), list(&SPLINTERING, 0, MAX_CELLS);
            /// Ring coordinates that the grid lies between: 0 at the pith, 1 at the bark.
            between_rings: [f64; 2] = [0.0, 1.0], list(&COORDINATE, 2, 2);
            /// Angles about the pith that it lies between, rad, as for a board; none: all around.
            between_angles: Vec<f64> = Vec::new(), list(&ANGLE, 0, 2);
            /// Whether the values are added to the face that the parameters of the break shape, and splintering is a factor on
            /// its relief. Otherwise they take the place of inclination, layers, compression shelf and species.
            added: bool = false, flag();
        }
    }
    check |grid| grid.source().map(|_| ());
}

impl HeightGrid {
    /// Returns where the heights come from.
    ///
    /// # Errors
    /// Lists that do not fit together.
    ///
    /// ```
    /// use greenstick_fracture::height_grid::HeightGrid;
    /// use greenstick_fracture::heights::HeightSource;
    ///
    /// let painted = HeightGrid {
    ///     sectors: 4,
    ///     values: vec![0.01, 0.0, 0.0, 0.0],
    ///     ..HeightGrid::default()
    /// };
    /// assert!(matches!(painted.source()?, HeightSource::Field(_)));
    /// # Ok::<(), greenstick_schema::ParameterError>(())
    /// ```
    pub fn source(&self) -> Result<HeightSource, ParameterError> {
        if self.values.is_empty() {
            return match (self.modes.is_empty(), self.splintering.is_empty()) {
                (true, true) => Ok(HeightSource::Procedural),
                _ => Err(self.conflict("there are modes or splintering, but no values")),
            };
        }
        let field = self.field();
        field.map(|field| HeightSource::Field(Arc::new(field)))
    }

    fn field(&self) -> Result<HeightField, ParameterError> {
        let field = self.cells()?;
        Ok(if self.added { field.added() } else { field })
    }

    fn cells(&self) -> Result<HeightField, ParameterError> {
        let refused = |error: HeightFieldError| self.conflict(&error.to_string());
        let sectors = self.sectors as usize;
        let rings = self.values.len().div_ceil(sectors);
        let phi = match self.between_angles[..] {
            [] => None,
            [from, to] => Some((from, to)),
            _ => return Err(self.conflict("between_angles has 1 angle; expected none or 2")),
        };
        let span = SectionSpan {
            rho: self.between_rings.into(),
            phi,
        };
        let field =
            HeightField::over(span, rings, sectors, self.values.clone()).map_err(refused)?;
        if self.modes.len() != self.splintering.len() {
            return Err(self.conflict(&format!(
                "there are {} modes and {} values of splintering; expected as many",
                self.modes.len(),
                self.splintering.len()
            )));
        }
        if self.modes.is_empty() {
            return Ok(field);
        }
        let failures = self.modes.iter().zip(&self.splintering);
        let failures = failures.map(|(&mode, &splintering)| CellFailure { mode, splintering });
        field.with_failures(failures.collect()).map_err(refused)
    }

    fn conflict(&self, what: &str) -> ParameterError {
        ParameterError::Conflict(format!("heights: {what}"))
    }
}

impl From<&HeightField> for HeightGrid {
    fn from(field: &HeightField) -> Self {
        let SectionSpan { rho, phi } = field.span();
        HeightGrid {
            sectors: u32::try_from(field.sectors()).unwrap_or(u32::MAX),
            values: field.heights().to_vec(),
            modes: field.failures().iter().map(|f| f.mode).collect(),
            splintering: field.failures().iter().map(|f| f.splintering).collect(),
            between_rings: rho.into(),
            between_angles: phi.map_or_else(Vec::new, |(from, to)| vec![from, to]),
            added: field.is_added(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use greenstick_schema::{read_toml, write_toml};

    fn board() -> HeightField {
        let span = SectionSpan {
            rho: (0.8, 1.1),
            phi: Some((6.1, 6.5)),
        };
        let heights: Vec<f64> = (0..6).map(|i| 0.1 / (1.0 + f64::from(i))).collect();
        let failure = |i: usize| CellFailure {
            mode: FailureMode::ALL[i % 5],
            splintering: 1.0 / (1.0 + i as f64),
        };
        let field = HeightField::over(span, 2, 3, heights).unwrap();
        field.with_failures((0..6).map(failure).collect()).unwrap()
    }

    #[test]
    fn a_field_is_the_same_after_it_was_written_and_read() {
        let whole = HeightField::new(1, 2, vec![0.01, -0.3]).unwrap();
        for field in [whole, board(), board().added()] {
            let text = write_toml(&HeightGrid::from(&field));
            let mut grid = HeightGrid::default();
            read_toml(&mut grid, &text).unwrap();
            assert_eq!(
                grid.source().unwrap(),
                HeightSource::Field(Arc::new(field)),
                "{text}"
            );
        }
        assert_eq!(HeightGrid::default().source(), Ok(HeightSource::Procedural));
    }

    #[test]
    fn lists_that_do_not_fit_are_refused() {
        let refused = |change: fn(&mut HeightGrid)| {
            let mut grid = HeightGrid::from(&board());
            change(&mut grid);
            grid.source().unwrap_err().to_string()
        };
        assert!(refused(|g| g.values.truncate(5)).contains("2 × 3 grid cells"));
        assert!(refused(|g| g.modes.truncate(5)).contains("5 modes and 6 values"));
        assert!(refused(|g| g.values.clear()).contains("no values"));
        assert!(refused(|g| g.between_angles.truncate(1)).contains("1 angle"));
        assert!(refused(|g| g.between_rings = [1.0, 0.5]).contains("1 to 0.5"));
        assert!(refused(|g| g.values[4] = f64::NAN).contains("ring 1, sector 1"));
    }
}
