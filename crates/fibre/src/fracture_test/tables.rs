//! Fracture tests as tables and curves.

use super::species::FractureTested;
use super::specimen::FractureTestKind;
use crate::curve::Curve;
use std::fmt::Write;

const LOAD_HEADER: &str = "deflection_m,load_N,compliance_m_per_N,crack_m,process_zone_end_m,work_J,stored_J,dissipated_J,\
dissipated_by_bonds_J,beam_theory_energy_release_rate_J_per_m2,bonds_broken\n";
/// Part of the ligament in which it is drawn: at the end the deflection is infinite.
const DRAWN_LIGAMENT: f64 = 0.8;
/// Points of the curve of beam theory while the crack grows.
const THEORY_POINTS: usize = 40;

impl FractureTested {
    /// Returns every point, as CSV.
    pub fn load_table(&self) -> String {
        let mut text = LOAD_HEADER.to_owned();
        for p in &self.outcome.points {
            let rate = self.theory.energy_release_rate(p.load, p.crack);
            let rate = if rate.is_finite() {
                rate.to_string()
            } else {
                String::new()
            };
            let compliance = if p.load > 0.0 {
                (p.deflection / p.load).to_string()
            } else {
                String::new()
            };
            let _ = writeln!(
                text,
                "{},{},{compliance},{},{},{},{},{},{},{},{}",
                p.deflection,
                p.load,
                p.crack,
                p.zone_end,
                p.work,
                p.stored,
                p.dissipated(),
                p.dissipated_by_bonds,
                rate,
                p.bonds_broken
            );
        }
        text
    }

    /// Returns load (N) over deflection (mm), beside that of a sharp crack in beam theory with the energy that went in.
    pub fn load_curves(&self) -> Vec<Curve> {
        let points = &self.outcome.points;
        let path = points
            .iter()
            .map(|p| [1e3 * p.deflection, p.load])
            .collect();
        let start = points.first().map_or(self.test.crack, |p| p.crack);
        let growth = match self.test.kind {
            FractureTestKind::SingleEdgeNotchedBeam => DRAWN_LIGAMENT * (self.test.height - start),
            _ => self.test.growth,
        };
        let energy = self.report.put_in_j_per_m2;
        let growing = (0..=THEORY_POINTS).map(|k| {
            let crack = start + growth * k as f64 / THEORY_POINTS as f64;
            let load = self.theory.load(energy, crack);
            [1e3 * load * self.theory.compliance(crack), load]
        });
        let curve = |name: &str, points: Vec<[f64; 2]>| Curve {
            name: name.to_owned(),
            points,
        };
        vec![
            curve("test", path),
            curve(
                self.test.kind.theory(),
                [[0.0, 0.0]].into_iter().chain(growing).collect(),
            ),
        ]
    }
}
