//! Tables: rows of numbers in named columns with units.

use crate::provenance::Metadata;
use glam::DVec3;

/// Endings of the names of columns that hold coordinates.
const AXES: [&str; 3] = ["x", "y", "z"];

/// The values of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Small integers and codes.
    U8(Vec<u8>),
    /// Integers.
    U32(Vec<u32>),
    /// Numbers; NaN where one is missing.
    F64(Vec<f64>),
    /// Texts.
    Text(Vec<String>),
}

impl Values {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Values::U8(v) => v.len(),
            Values::U32(v) => v.len(),
            Values::F64(v) => v.len(),
            Values::Text(v) => v.len(),
        }
    }

    /// Whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name: letters, digits and `_`.
    pub name: String,
    /// Unit, such as `m`, `m2` or `rad`; empty for counts and codes.
    pub unit: String,
    /// What the values mean, in a few words.
    pub meaning: String,
    /// The values.
    pub values: Values,
}

impl Column {
    /// Creates a column.
    pub fn new(name: &str, unit: &str, meaning: &str, values: Values) -> Self {
        Column {
            name: name.to_owned(),
            unit: unit.to_owned(),
            meaning: meaning.to_owned(),
            values,
        }
    }

    /// The name with the unit, as in a header line: `area_m2`.
    pub fn heading(&self) -> String {
        if self.unit.is_empty() {
            self.name.clone()
        } else {
            format!("{}_{}", self.name, self.unit)
        }
    }
}

/// Columns of equal length.
///
/// ```
/// use greenstick_geometry::{Column, Table, Values};
///
/// let radii = Column::new("radius", "m", "radius of the ring", Values::F64(vec![0.01, 0.02]));
/// let table = Table { columns: vec![radii], ..Table::default() };
/// assert_eq!((table.rows(), table.fault()), (2, None));
/// assert_eq!(table.columns[0].heading(), "radius_m");
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// The columns; all must be as long as the first.
    pub columns: Vec<Column>,
    /// Where it comes from; CSV has no place for it.
    pub metadata: Metadata,
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |c| c.values.len())
    }

    /// The column with a name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|c| c.name == name)
    }

    /// Adds an offset (m) to the coordinates: the columns `x`, `y` and `z` in metres, and those that end in `_x`, `_y` and `_z`.
    pub fn translate(&mut self, offset: DVec3) {
        if offset == DVec3::ZERO {
            return;
        }
        for column in &mut self.columns {
            let axis = column.name.rsplit('_').next().unwrap_or_default();
            let place = AXES.iter().position(|a| *a == axis);
            if let (Some(k), "m", Values::F64(values)) =
                (place, column.unit.as_str(), &mut column.values)
            {
                values.iter_mut().for_each(|v| *v += offset[k]);
            }
        }
    }

    /// Describes the first fault: a column of another length than the first, a name or unit that is not made of letters,
    /// digits and `_`, or a name that occurs twice.
    pub fn fault(&self) -> Option<String> {
        let rows = self.rows();
        for (k, c) in self.columns.iter().enumerate() {
            if c.values.len() != rows {
                return Some(format!(
                    "column {} has {} values, but the table has {rows} rows",
                    c.name,
                    c.values.len()
                ));
            }
            let is_plain = |b: u8| b.is_ascii_alphanumeric() || b == b'_';
            if c.name.is_empty() || !c.name.bytes().all(is_plain) || !c.unit.bytes().all(is_plain) {
                return Some(format!(
                    "column {k} has the name {:?} and the unit {:?}; expected letters, digits and _",
                    c.name, c.unit
                ));
            }
            if self.columns[..k].iter().any(|d| d.name == c.name) {
                return Some(format!("two columns are named {}", c.name));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_moved_and_nothing_else() {
        let column = |name: &str, unit: &str| Column::new(name, unit, "", Values::F64(vec![1.0]));
        let mut table = Table {
            columns: vec![
                column("x", "m"),
                column("pith_y", "m"),
                column("direction_z", ""),
                column("length", "m"),
            ],
            ..Table::default()
        };
        table.translate(DVec3::new(10.0, 20.0, 30.0));
        let values: Vec<&Values> = table.columns.iter().map(|c| &c.values).collect();
        let expected = [11.0, 21.0, 1.0, 1.0].map(|x| Values::F64(vec![x]));
        assert_eq!(values, expected.iter().collect::<Vec<_>>());
    }
}
