//! What a parameter's declaration says beside its key, type, default and documentation.

use crate::{Unit, Value};

/// A word that a parameter may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// The word.
    pub word: &'static str,
    /// What it means.
    pub doc: &'static str,
}

impl Choice {
    /// The word as a label for people: "poisson-disk" is "Poisson disk".
    pub fn label(&self) -> String {
        let spaced = self.word.replace(['-', '_'], " ");
        let mut letters = spaced.chars();
        let first = letters.next().map(|c| c.to_uppercase().to_string());
        first.unwrap_or_default() + letters.as_str()
    }
}

/// A format that a text must have.
#[derive(Debug, Clone, Copy)]
pub struct Format {
    /// Its name, as placeholders show it: "PLACE".
    pub name: &'static str,
    /// What is wrong with a text that does not have it.
    pub check: fn(&str) -> Result<(), String>,
}

impl Format {
    /// Any text.
    pub const ANY: Format = Format {
        name: "TEXT",
        check: |_| Ok(()),
    };
}

impl PartialEq for Format {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// What values a parameter takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A real number from `min` to `max`, both included.
    Number {
        /// Its unit.
        unit: Unit,
        /// Least value.
        min: f64,
        /// Greatest value.
        max: f64,
        /// Whether the least value itself is left out.
        above: bool,
    },
    /// A whole number from `min` to `max`, both included.
    Integer {
        /// Its unit.
        unit: Unit,
        /// Least value.
        min: i128,
        /// Greatest value.
        max: i128,
        /// What it is a multiple of, as are its bounds.
        step: i128,
    },
    /// True or false.
    Flag,
    /// One of a few words.
    Choice {
        /// The words.
        options: &'static [Choice],
    },
    /// A text.
    Text {
        /// Its format.
        format: Format,
    },
    /// A list of `min` to `max` values.
    List {
        /// What each of them is.
        of: &'static Kind,
        /// Least number.
        min: usize,
        /// Greatest number.
        max: usize,
    },
}

/// How a slider divides the range of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// By equal factors.
    Logarithmic,
}

/// The name of a file.
pub const FILE_NAME: Format = Format {
    name: "FILE",
    check: |name| {
        if name.trim().is_empty() {
            Err("the name is empty".to_owned())
        } else {
            Ok(())
        }
    },
};

/// What is declared of a parameter beside its key, type, default and documentation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Declaration {
    /// Values it takes.
    pub kind: Kind,
    /// Symbol in its source.
    pub symbol: &'static str,
    /// The stage of the work that it changes first; empty for that of its section.
    pub stage: &'static str,
    /// How a slider divides its range.
    pub scale: Scale,
    /// Whether the word "auto" may stand for a value that is worked out.
    pub auto: bool,
    /// Words that stand for numbers.
    pub words: &'static [(&'static str, f64)],
}

impl Declaration {
    const fn new(kind: Kind) -> Self {
        Declaration {
            kind,
            symbol: "",
            stage: "",
            scale: Scale::Linear,
            auto: false,
            words: &[],
        }
    }

    /// With the symbol of its source; a subscript stands after `_`.
    pub const fn symbol(mut self, symbol: &'static str) -> Self {
        self.symbol = symbol;
        self
    }

    /// With a stage other than that of its section.
    pub const fn stage(mut self, stage: &'static str) -> Self {
        self.stage = stage;
        self
    }

    /// With a logarithmic scale.
    pub const fn logarithmic(mut self) -> Self {
        self.scale = Scale::Logarithmic;
        self
    }

    /// With the word "auto" for a value that is worked out.
    pub const fn auto(mut self) -> Self {
        self.auto = true;
        self
    }

    /// With words that stand for numbers.
    pub const fn words(mut self, words: &'static [(&'static str, f64)]) -> Self {
        self.words = words;
        self
    }

    /// Without the least value itself.
    pub const fn above(mut self) -> Self {
        if let Kind::Number { unit, min, max, .. } = self.kind {
            let above = true;
            self.kind = Kind::Number {
                unit,
                min,
                max,
                above,
            };
        }
        self
    }

    /// A whole number in a unit.
    pub const fn unit(mut self, unit: Unit) -> Self {
        if let Kind::Integer { min, max, step, .. } = self.kind {
            self.kind = Kind::Integer {
                unit,
                min,
                max,
                step,
            };
        }
        self
    }

    /// A whole number that is a multiple of `step`, as are its bounds.
    pub const fn step(mut self, step: i128) -> Self {
        if let Kind::Integer { unit, min, max, .. } = self.kind {
            self.kind = Kind::Integer {
                unit,
                min,
                max,
                step,
            };
        }
        self
    }
}

/// A real number from `min` to `max`, both included.
pub const fn number(unit: Unit, min: f64, max: f64) -> Declaration {
    let above = false;
    Declaration::new(Kind::Number {
        unit,
        min,
        max,
        above,
    })
}

/// A length from `min` to `max` metres, both included; text must say its unit.
pub const fn length(min: f64, max: f64) -> Declaration {
    number(Unit::Metre, min, max)
}

/// A whole number from `min` to `max`, both included.
pub const fn count(min: i128, max: i128) -> Declaration {
    let unit = Unit::One;
    Declaration::new(Kind::Integer {
        unit,
        min,
        max,
        step: 1,
    })
}

/// True or false.
pub const fn flag() -> Declaration {
    Declaration::new(Kind::Flag)
}

/// One of a few words.
pub const fn choice(options: &'static [Choice]) -> Declaration {
    Declaration::new(Kind::Choice { options })
}

/// A text of a format.
pub const fn text(format: Format) -> Declaration {
    Declaration::new(Kind::Text { format })
}

/// A list of `min` to `max` values.
pub const fn list(of: &'static Kind, min: usize, max: usize) -> Declaration {
    Declaration::new(Kind::List { of, min, max })
}

impl Kind {
    /// Its unit.
    pub fn unit(&self) -> Unit {
        match self {
            Kind::Number { unit, .. } | Kind::Integer { unit, .. } => *unit,
            Kind::List { of, .. } => of.unit(),
            _ => Unit::One,
        }
    }

    /// Its range in words, with its unit; empty where it has none.
    pub fn range(&self) -> String {
        let unit = match self.unit().symbol() {
            "" => String::new(),
            symbol => format!(" {symbol}"),
        };
        match self {
            Kind::Number {
                min, max, above, ..
            } => {
                let from = if *above { "above" } else { "from" };
                match (min.is_finite(), max.is_finite()) {
                    (true, true) if *above => format!("above {min} and up to {max}{unit}"),
                    (true, true) => format!("from {min} to {max}{unit}"),
                    (true, false) => format!("{from} {min}{unit} on"),
                    (false, true) => format!("up to {max}{unit}"),
                    (false, false) => String::new(),
                }
            }
            Kind::Integer { min, max, step, .. } => {
                format!("{} from {min} to {max}{unit}", whole(*step))
            }
            Kind::Flag => "true or false".to_owned(),
            Kind::Choice { options } => format!("one of {}", words(options)),
            Kind::Text { .. } => String::new(),
            Kind::List { of, min, max } => {
                let each = of.range();
                let count = match (*min, *max) {
                    (a, b) if a == b => format!("{a} values"),
                    (a, usize::MAX) => format!("{a} values or more"),
                    (a, b) => format!("{a} to {b} values"),
                };
                if each.is_empty() {
                    count
                } else {
                    format!("{count}, each {each}")
                }
            }
        }
    }

    /// A placeholder for a value in help.
    pub fn placeholder(&self) -> String {
        let one = match self {
            Kind::Text { format } => format.name,
            Kind::Flag => "true|false",
            Kind::Choice { .. } => "WORD",
            Kind::Number { unit, .. } | Kind::Integer { unit, .. } => match unit {
                Unit::Metre | Unit::Centimetre => "LENGTH",
                Unit::Degree => "DEGREES",
                Unit::Percent => "PERCENT",
                Unit::Second => "SECONDS",
                Unit::Pixel => "PIXELS",
                _ => "NUMBER",
            },
            Kind::List { of, max, .. } => {
                let one = of.placeholder();
                return vec![one.as_str(); (*max).clamp(1, 3)].join(",");
            }
        };
        one.to_owned()
    }
}

/// What a multiple of `step` is called.
pub(crate) fn whole(step: i128) -> String {
    match step {
        1 => "a whole number".to_owned(),
        2 => "an even number".to_owned(),
        step => format!("a multiple of {step}"),
    }
}

/// The words of choices with commas between them.
pub(crate) fn words(options: &[Choice]) -> String {
    let words: Vec<&str> = options.iter().map(|o| o.word).collect();
    words.join(", ")
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        Value::Text(text.to_owned())
    }
}
