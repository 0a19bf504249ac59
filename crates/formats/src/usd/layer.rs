//! A USD layer: prims with properties, as both the text and the binary form write them.

/// Place of a value in a binary file, in the form in which that refers to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stored(pub u64);

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Yes or no.
    Bool(bool),
    /// A long whole number.
    Int64(i64),
    /// A number.
    Float(f32),
    /// A precise number.
    Double(f64),
    /// A word of the format.
    Token(String),
    /// Words of anybody.
    Text(String),
    /// A file.
    Asset(String),
    /// Two numbers.
    Float2([f32; 2]),
    /// Three.
    Float3([f32; 3]),
    /// Four.
    Float4([f32; 4]),
    /// Three precise ones.
    Double3([f64; 3]),
    /// A quaternion: x, y, z, w.
    Turn([f32; 4]),
    /// A matrix for row vectors, by rows.
    Matrix([[f64; 4]; 4]),
    /// Words, in an array.
    Tokens(Vec<String>),
    /// Words that go before those of other layers.
    Prepended(Vec<String>),
    /// Whole numbers.
    Ints(Vec<i32>),
    /// Numbers.
    Floats(Vec<f32>),
    /// Precise numbers.
    Doubles(Vec<f64>),
    /// Pairs.
    Float2s(Vec<[f32; 2]>),
    /// Triples.
    Float3s(Vec<[f32; 3]>),
    /// Quadruples.
    Float4s(Vec<[f32; 4]>),
    /// A value that a binary file holds already.
    Stored(Stored),
}

/// Values over time in a binary file: all that are asked for lie in it already.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    /// The list of times.
    pub times: Stored,
    /// A value for each.
    pub values: Vec<Stored>,
}

/// What a property holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// A value.
    Attribute {
        /// Its type, as the text form has it.
        kind: &'static str,
        /// Whether it may not change over time.
        uniform: bool,
        /// Whether no schema knows it.
        custom: bool,
        /// The value where there are no samples.
        value: Option<Value>,
        /// Values over time.
        samples: Option<Samples>,
        /// The output it takes its value from.
        connection: Option<String>,
    },
    /// Paths of other things.
    Relationship(Vec<String>),
}

/// A property of a prim.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    /// Name with namespaces.
    pub name: String,
    /// What it holds.
    pub content: Content,
    /// What is said of it.
    pub metadata: Vec<(&'static str, Value)>,
}

impl Property {
    /// An attribute; without a value an output.
    pub fn new(
        name: impl Into<String>,
        kind: &'static str,
        value: impl Into<Option<Value>>,
    ) -> Self {
        Property {
            name: name.into(),
            content: Content::Attribute {
                kind,
                uniform: false,
                custom: false,
                value: value.into(),
                samples: None,
                connection: None,
            },
            metadata: Vec::new(),
        }
    }

    /// An attribute that may not change over time.
    pub fn uniform(name: &str, kind: &'static str, value: Value) -> Self {
        let mut property = Property::new(name, kind, value);
        if let Content::Attribute { uniform, .. } = &mut property.content {
            *uniform = true;
        }
        property
    }

    /// An attribute that no schema knows.
    pub fn custom(name: String, kind: &'static str, value: Value) -> Self {
        let mut property = Property::new(name, kind, value);
        if let Content::Attribute { custom, .. } = &mut property.content {
            *custom = true;
        }
        property
    }

    /// An attribute that takes its value from an output.
    pub fn connected(name: &str, kind: &'static str, to: String) -> Self {
        let mut property = Property::new(name, kind, None);
        if let Content::Attribute { connection, .. } = &mut property.content {
            *connection = Some(to);
        }
        property
    }

    /// A path to something else.
    pub fn relationship(name: &str, target: String) -> Self {
        Property {
            name: name.to_owned(),
            content: Content::Relationship(vec![target]),
            metadata: Vec::new(),
        }
    }

    /// With something said of it.
    pub fn with(mut self, key: &'static str, value: Value) -> Self {
        self.metadata.push((key, value));
        self
    }
}

/// A prim that is defined here.
#[derive(Debug, Clone, PartialEq)]
pub struct Prim {
    /// Name: letters, digits and `_`, not a digit first; different from its siblings'.
    pub name: String,
    /// Type.
    pub kind: &'static str,
    /// What is said of it.
    pub metadata: Vec<(&'static str, Value)>,
    /// Properties.
    pub properties: Vec<Property>,
    /// Prims below it.
    pub children: Vec<Prim>,
}

impl Prim {
    /// A prim with nothing in it.
    pub fn new(name: impl Into<String>, kind: &'static str) -> Self {
        Prim {
            name: name.into(),
            kind,
            metadata: Vec::new(),
            properties: Vec::new(),
            children: Vec::new(),
        }
    }

    /// Applies a schema.
    pub fn apply(&mut self, schema: &str) {
        for (key, value) in &mut self.metadata {
            if let ("apiSchemas", Value::Prepended(names)) = (*key, value) {
                names.push(schema.to_owned());
                return;
            }
        }
        let names = Value::Prepended(vec![schema.to_owned()]);
        self.metadata.push(("apiSchemas", names));
    }

    /// The property of a name.
    pub fn property(&mut self, name: &str) -> Option<&mut Property> {
        self.properties.iter_mut().find(|p| p.name == name)
    }
}

/// A layer with one prim at its root, which is its default.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// What is said of all.
    pub metadata: Vec<(&'static str, Value)>,
    /// The prim.
    pub root: Prim,
}

/// Names that USD can take, different from one another.
#[derive(Default)]
pub struct Names {
    taken: std::collections::BTreeSet<String>,
}

impl Names {
    /// A name like `wanted`; `otherwise` where that is empty.
    pub fn unique(&mut self, wanted: &str, otherwise: &str) -> String {
        let keep = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let mut name: String = wanted.chars().map(keep).collect();
        if name.is_empty() {
            name = otherwise.to_owned();
        }
        if name.starts_with(|c: char| c.is_ascii_digit()) {
            name.insert(0, '_');
        }
        let mut unique = name.clone();
        let mut number = 1;
        while !self.taken.insert(unique.clone()) {
            number += 1;
            unique = format!("{name}_{number}");
        }
        unique
    }
}
