//! Where the content of a file comes from and how it was made.

use serde::{Deserialize, Serialize};

/// Named texts that go into files whose formats have a place for them.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Metadata {
    /// The texts, in order.
    pub entries: Vec<MetadataEntry>,
}

/// A named text.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MetadataEntry {
    /// Name: letters, digits and `_`.
    pub name: String,
    /// Text on one line.
    pub text: String,
}

impl Metadata {
    /// Appends a text. Line breaks and other control characters in it become spaces.
    pub fn push(&mut self, name: &str, text: &str) {
        self.entries.push(MetadataEntry {
            name: name.to_owned(),
            text: text.replace(char::is_control, " "),
        });
    }

    /// Whether there are no texts.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The texts as lines `name: text`.
    pub fn lines(&self) -> impl Iterator<Item = String> {
        (self.entries.iter()).map(|entry| format!("{}: {}", entry.name, entry.text))
    }
}

/// Where a result comes from and how it was made.
///
/// ```
/// use greenstick_geometry::Provenance;
///
/// let provenance = Provenance {
///     program: "greenstick".into(),
///     origin_m: [477_000.0, 5_429_000.0, 310.0],
///     ..Provenance::default()
/// };
/// let lines: Vec<String> = provenance.metadata().lines().collect();
/// assert!(lines.contains(&"origin_m: 477000 5429000 310".to_owned()));
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the program.
    pub program: String,
    /// Its version.
    pub version: String,
    /// What it was told to do.
    pub command: String,
    /// Name of the input file; `None` for what is built in.
    pub input: Option<String>,
    /// Parameters that were not left at their defaults, `key=value`.
    pub parameters: Vec<String>,
    /// What random numbers were drawn from; `None` where nothing is random.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// `local`, less `origin_m`, or `input`, those of the input.
    pub coordinates: String,
    /// What was subtracted from the input's coordinates before the work, m.
    pub origin_m: [f64; 3],
    /// The share of the girth that a scan shows, 0 to 1; `None` of a mesh.
    pub coverage: Option<f64>,
    /// Standard deviation of a scan's points from the surface, m; `None` of a mesh.
    pub residual_m: Option<f64>,
}

impl Provenance {
    /// Returns the same as texts; what is not known is left out.
    pub fn metadata(&self) -> Metadata {
        let mut metadata = Metadata::default();
        let [x, y, z] = self.origin_m;
        let has_place = !self.coordinates.is_empty() || self.origin_m != [0.0; 3];
        let texts = [
            ("program", Some(self.program.clone())),
            ("version", Some(self.version.clone())),
            ("command", Some(self.command.clone())),
            ("input", self.input.clone()),
            ("parameters", Some(self.parameters.join(", "))),
            ("seed", self.seed.map(|seed| seed.to_string())),
            ("coordinates", Some(self.coordinates.clone())),
            ("origin_m", has_place.then(|| format!("{x} {y} {z}"))),
            ("coverage", self.coverage.map(|share| share.to_string())),
            (
                "residual_m",
                self.residual_m.map(|metres| metres.to_string()),
            ),
        ];
        for (name, text) in texts {
            if let Some(text) = text.filter(|t| !t.is_empty()) {
                metadata.push(name, &text);
            }
        }
        metadata
    }
}
