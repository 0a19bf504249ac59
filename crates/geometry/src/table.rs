//! Tables: rows of numbers in named columns with units, as measurements are kept.

/// Numbers of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Small whole numbers and codes.
    U8(Vec<u8>),
    /// Whole numbers.
    U32(Vec<u32>),
    /// Numbers.
    F64(Vec<f64>),
}

impl Values {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Values::U8(v) => v.len(),
            Values::U32(v) => v.len(),
            Values::F64(v) => v.len(),
        }
    }

    /// Whether there are none.
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
    /// What it says, in a few words.
    pub meaning: String,
    /// The numbers.
    pub values: Values,
}

impl Column {
    /// A column.
    pub fn new(name: &str, unit: &str, meaning: &str, values: Values) -> Self {
        Column {
            name: name.to_owned(),
            unit: unit.to_owned(),
            meaning: meaning.to_owned(),
            values,
        }
    }

    /// Name with the unit, as a heading: `area_m2`.
    pub fn heading(&self) -> String {
        if self.unit.is_empty() {
            self.name.clone()
        } else {
            format!("{}_{}", self.name, self.unit)
        }
    }
}

/// Columns of one length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// The columns; all should be as long as the first.
    pub columns: Vec<Column>,
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |c| c.values.len())
    }

    /// The column of a name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|c| c.name == name)
    }

    /// The first column that is not as long as the others or whose name another one has, with what is wrong.
    pub fn fault(&self) -> Option<String> {
        let rows = self.rows();
        for (k, c) in self.columns.iter().enumerate() {
            if c.values.len() != rows {
                return Some(format!(
                    "column {} has {} values where there are {rows} rows",
                    c.name,
                    c.values.len()
                ));
            }
            let plain = |b: u8| b.is_ascii_alphanumeric() || b == b'_';
            if c.name.is_empty() || !c.name.bytes().all(plain) || !c.unit.bytes().all(plain) {
                return Some(format!("column {k} is named {:?} in {:?}", c.name, c.unit));
            }
            if self.columns[..k].iter().any(|d| d.name == c.name) {
                return Some(format!("two columns are named {}", c.name));
            }
        }
        None
    }
}
