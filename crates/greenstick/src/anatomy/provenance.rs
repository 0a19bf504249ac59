//! Where the files of a stem's inside come from.

use super::AnatomyFile;
use crate::scanning::ScannedReport;
use greenstick_geometry::Provenance;
use greenstick_schema::Parameters;

/// The key of the input, which has a place of its own.
const INPUT_KEY: &str = "input";

impl AnatomyFile {
    /// Returns where the files of this request come from; `scan` is the report of the scan that the input is.
    pub fn provenance(&self, scan: Option<&ScannedReport>) -> Provenance {
        let bark = scan.and_then(|s| s.bark.as_ref());
        Provenance {
            program: "greenstick".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            command: "anatomy".to_owned(),
            input: self.input.clone(),
            parameters: changed_parameters(self),
            coordinates: self.request.coordinates.word().to_owned(),
            origin_m: scan.map_or([0.0; 3], |s| s.origin_m),
            coverage: bark.map(|b| b.mean_coverage),
            residual_m: bark.map(|b| b.noise_m),
        }
    }
}

/// The parameters that are not at their defaults, as `key=value` in SI units.
fn changed_parameters(parameters: &dyn Parameters) -> Vec<String> {
    let list = parameters.list();
    let changed = list
        .iter()
        .filter(|p| p.value != p.default && p.key != INPUT_KEY);
    changed.map(|p| format!("{}={}", p.key, p.value)).collect()
}
