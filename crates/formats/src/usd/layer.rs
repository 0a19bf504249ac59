//! USD layers: prims with properties, for both the text and the binary form.

/// A value in a binary file, in the representation by which the file refers to it (`ValueRep`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Stored(pub u64);

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    /// A truth value.
    Bool(bool),
    /// A 64-bit integer.
    Int64(i64),
    /// A single-precision number.
    Float(f32),
    /// A double-precision number.
    Double(f64),
    /// A token.
    Token(String),
    /// A string.
    Text(String),
    /// The path of an asset.
    Asset(String),
    /// A vector of two numbers.
    Float2([f32; 2]),
    /// A vector of three numbers.
    Float3([f32; 3]),
    /// A vector of four numbers.
    Float4([f32; 4]),
    /// A vector of three double-precision numbers.
    Double3([f64; 3]),
    /// A quaternion: x, y, z, w.
    Quaternion([f32; 4]),
    /// A matrix for row vectors, in row-major order.
    Matrix([[f64; 4]; 4]),
    /// An array of tokens.
    Tokens(Vec<String>),
    /// A list of tokens that are prepended to those of other layers.
    Prepended(Vec<String>),
    /// An array of integers.
    Ints(Vec<i32>),
    /// An array of numbers.
    Floats(Vec<f32>),
    /// An array of double-precision numbers.
    Doubles(Vec<f64>),
    /// An array of pairs.
    Float2s(Vec<[f32; 2]>),
    /// An array of triples.
    Float3s(Vec<[f32; 3]>),
    /// An array of quadruples.
    Float4s(Vec<[f32; 4]>),
    /// A value that is in the binary file already.
    Stored(Stored),
}

/// Time samples, all of which are in the binary file already.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Samples {
    /// The list of times.
    pub times: Stored,
    /// One value for each time.
    pub values: Vec<Stored>,
}

/// The content of a property.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Content {
    /// An attribute.
    Attribute {
        /// Its type, as in the text form.
        kind: &'static str,
        /// Whether it cannot vary over time.
        uniform: bool,
        /// Whether no schema defines it.
        custom: bool,
        /// The value without time samples.
        value: Option<Value>,
        /// Time samples.
        samples: Option<Samples>,
        /// Path of the output that provides its value.
        connection: Option<String>,
    },
    /// A relationship, with the paths of its targets.
    Relationship(Vec<String>),
}

/// An entry of metadata.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Metadatum {
    /// Key.
    pub key: &'static str,
    /// Value.
    pub value: Value,
}

impl Metadatum {
    /// Creates an entry.
    pub fn new(key: &'static str, value: Value) -> Self {
        Metadatum { key, value }
    }
}

/// One operation of a transform.
pub(super) struct TransformOp {
    /// Name without its namespace.
    pub name: &'static str,
    /// Type of the value.
    pub kind: &'static str,
    /// Value.
    pub value: Value,
}

/// A property of a prim.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Property {
    /// Name with namespaces.
    pub name: String,
    /// Content.
    pub content: Content,
    /// Metadata.
    pub metadata: Vec<Metadatum>,
}

impl Property {
    /// An attribute, or, without a value, an output.
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

    /// An attribute that cannot vary over time.
    pub fn uniform(name: &str, kind: &'static str, value: Value) -> Self {
        let mut property = Property::new(name, kind, value);
        if let Content::Attribute { uniform, .. } = &mut property.content {
            *uniform = true;
        }
        property
    }

    /// An attribute that no schema defines.
    pub fn custom(name: String, kind: &'static str, value: Value) -> Self {
        let mut property = Property::new(name, kind, value);
        if let Content::Attribute { custom, .. } = &mut property.content {
            *custom = true;
        }
        property
    }

    /// An attribute whose value comes from an output.
    pub fn connected(name: &str, kind: &'static str, to: String) -> Self {
        let mut property = Property::new(name, kind, None);
        if let Content::Attribute { connection, .. } = &mut property.content {
            *connection = Some(to);
        }
        property
    }

    /// A relationship with one target.
    pub fn relationship(name: &str, target: String) -> Self {
        Property {
            name: name.to_owned(),
            content: Content::Relationship(vec![target]),
            metadata: Vec::new(),
        }
    }

    /// Adds metadata.
    pub fn with(mut self, key: &'static str, value: Value) -> Self {
        self.metadata.push(Metadatum { key, value });
        self
    }
}

/// The field of what is said about a layer, which text calls `doc`.
pub(super) const DOCUMENTATION: &str = "documentation";

/// A prim that is defined in the layer.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Prim {
    /// Name: letters, digits and `_`, not starting with a digit, and unique among its siblings.
    pub name: String,
    /// Type.
    pub kind: &'static str,
    /// Metadata.
    pub metadata: Vec<Metadatum>,
    /// Properties.
    pub properties: Vec<Property>,
    /// Child prims.
    pub children: Vec<Prim>,
}

impl Prim {
    /// Creates an empty prim.
    pub fn new(name: impl Into<String>, kind: &'static str) -> Self {
        Prim {
            name: name.into(),
            kind,
            metadata: Vec::new(),
            properties: Vec::new(),
            children: Vec::new(),
        }
    }

    /// Applies an API schema.
    pub fn apply(&mut self, schema: &str) {
        for Metadatum { key, value } in &mut self.metadata {
            if let ("apiSchemas", Value::Prepended(names)) = (*key, value) {
                names.push(schema.to_owned());
                return;
            }
        }
        let names = Value::Prepended(vec![schema.to_owned()]);
        self.metadata.push(Metadatum::new("apiSchemas", names));
    }

    /// Sets the transform to operations that are applied from the last to the first.
    pub fn set_transform(&mut self, ops: Vec<TransformOp>) {
        let mut order = Vec::new();
        for TransformOp { name, kind, value } in ops {
            let name = format!("xformOp:{name}");
            order.push(name.clone());
            self.properties.push(Property::new(name, kind, value));
        }
        let order = Value::Tokens(order);
        self.properties
            .push(Property::uniform("xformOpOrder", "token[]", order));
    }

    /// The property with a name.
    pub fn property(&mut self, name: &str) -> Option<&mut Property> {
        self.properties.iter_mut().find(|p| p.name == name)
    }
}

/// A layer with a single root prim, which is its default prim.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layer {
    /// Metadata.
    pub metadata: Vec<Metadatum>,
    /// The root prim.
    pub root: Prim,
}
