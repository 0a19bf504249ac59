//! Where the files of a request come from.

use crate::anatomy::AnatomyFile;
use crate::request::RequestFile;
use crate::scanning::ScannedReport;
use greenstick_geometry::Provenance;
use greenstick_schema::{Parameters, Value};
use greenstick_wood::scan::with_scan;

/// The key of the input, which has a place of its own.
const INPUT_KEY: &str = "input";

/// Whether a key is that of what random numbers are drawn from, at the top or in a table.
fn is_seed(key: &str) -> bool {
    key.rsplit('.').next() == Some("seed") && !key.contains('[')
}

/// Returns where a result of a command comes from: an input, by its name, and parameters, of which those that are not at
/// their defaults are named. `None` as input is what is built in.
///
/// ```
/// use greenstick::{RequestFile, provenance};
///
/// let request = RequestFile::resolve(&[], None, &["seed=7", "rings=12"])?;
/// let made = provenance("break", Some("tree.glb"), &request);
/// assert_eq!((made.seed, made.parameters), (Some(7), vec!["break.rings=12".to_owned()]));
/// # Ok::<(), greenstick::RequestFileError>(())
/// ```
pub fn provenance(command: &str, input: Option<&str>, parameters: &dyn Parameters) -> Provenance {
    let seed = parameters.list().iter().find_map(|p| match p.value {
        Value::Integer(seed) if is_seed(&p.key) => u64::try_from(seed).ok(),
        _ => None,
    });
    let changed = parameters.changed().into_iter();
    let changed = changed.filter(|p| p.key != INPUT_KEY && !is_seed(&p.key));
    Provenance {
        program: "greenstick".to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        command: command.to_owned(),
        input: input.map(str::to_owned),
        parameters: changed.map(|p| format!("{}={}", p.key, p.value)).collect(),
        seed,
        ..Provenance::default()
    }
}

impl AnatomyFile {
    /// Returns where the files of this request come from; `scan` is the report of the scan that the input is.
    pub fn provenance(&self, scan: Option<&ScannedReport>) -> Provenance {
        let own = provenance("anatomy", self.input.as_deref(), self);
        Provenance {
            coordinates: self.request.coordinates.word().to_owned(),
            ..with_scan(own, scan)
        }
    }
}

impl RequestFile {
    /// Returns where the pieces of this request come from, whose input has a name; `scan` is the report of the scan that the
    /// input is.
    pub fn provenance(&self, input: Option<&str>, scan: Option<&ScannedReport>) -> Provenance {
        let own = provenance("break", input, self);
        Provenance {
            coordinates: if scan.is_some() { "local" } else { "input" }.to_owned(),
            ..with_scan(own, scan)
        }
    }
}
