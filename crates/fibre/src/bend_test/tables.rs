//! Bending tests as tables and curves.

use super::all_species::BendTable;
use super::species::Bent;
use super::specimens_report::SpecimensReport;
use crate::curve::Curve;
use crate::event::EventKind;
use crate::store::{cause_name, kind_name};
use std::fmt::Write;

const LOAD_HEADER: &str =
    "deflection_m,load_N,fibre_stress_Pa,work_J,edges_yielded,rods_broken,bonds_broken\n";
const EVENT_HEADER: &str =
    "deflection_m,load_N,kind,rod,other_rod,along_m,height_m,across_m,cause,demand,energy_J\n";
const SPECIES_HEADER: &str = "species,scientific_name,moisture_percent,\
modulus_of_elasticity_Pa,table_modulus_of_elasticity_Pa,modulus_of_elasticity_ratio,\
modulus_of_rupture_Pa,table_modulus_of_rupture_Pa,modulus_of_rupture_ratio,\
work_to_maximum_load_J_per_m3,table_work_to_maximum_load_J_per_m3,work_to_maximum_load_ratio,\
stress_at_first_break_Pa,maximum_load_N,deflection_at_maximum_load_m,notes,not_tested_because\n";

const SPECIMENS_HEADER: &str = "specimen,density_kg_per_m3,modulus_of_elasticity_Pa,modulus_of_rupture_Pa,\
work_to_maximum_load_J_per_m3,stress_at_first_break_Pa,maximum_load_N,deflection_at_maximum_load_m,not_tested_because\n";

/// A cell of words, quoted.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

impl Bent {
    /// Returns every point with its stress and the work up to it, as CSV.
    pub fn load_table(&self) -> String {
        let mut text = LOAD_HEADER.to_owned();
        let mut work = 0.0;
        for (k, p) in self.outcome.points.iter().enumerate() {
            if let Some(before) = k.checked_sub(1).map(|b| self.outcome.points[b]) {
                work += 0.5 * (before.load + p.load) * (p.deflection - before.deflection);
            }
            let _ = writeln!(
                text,
                "{},{},{},{work},{},{},{}",
                p.deflection,
                p.load,
                self.test.fibre_stress(p.load),
                p.yielded,
                p.rods_broken,
                p.bonds_broken
            );
        }
        text
    }

    /// Returns every event, as CSV.
    pub fn event_table(&self) -> String {
        let mut text = EVENT_HEADER.to_owned();
        for e in &self.outcome.events {
            let other = e.other.map_or(String::new(), |o| o.to_string());
            let _ = writeln!(
                text,
                "{},{},{},{},{other},{},{},{},{},{},{}",
                e.deflection,
                e.load,
                kind_name(e.kind),
                e.rod,
                e.along,
                e.height,
                e.across,
                cause_name(e.cause),
                e.demand,
                e.energy
            );
        }
        text
    }

    /// Returns load (kN) over deflection (mm), with where the table has stiffness and largest load, and the first break.
    pub fn load_curves(&self) -> Vec<Curve> {
        let (r, points) = (&self.report, &self.outcome.points);
        let (mm, kn) = (1e3, 1e-3);
        let curve = |name: &str, points: Vec<[f64; 2]>| Curve {
            name: name.to_owned(),
            points,
        };
        let path = points.iter().map(|p| [mm * p.deflection, kn * p.load]);
        let mut curves = vec![curve("test", path.collect())];
        let farthest = points.iter().fold(0.0, |m, p| f64::max(m, p.deflection));
        if let (Some(e), Some(rupture)) = (
            r.modulus_of_elasticity_pa.table,
            r.modulus_of_rupture_pa.table,
        ) {
            let load = rupture / self.test.fibre_stress(1.0);
            let inertia = self.test.section.inertia();
            let bent = load * self.test.span.powi(3) / (48.0 * e * inertia);
            let elastic = vec![[0.0, 0.0], [mm * bent, kn * load]];
            curves.push(curve("table: elastic", elastic));
            let level = vec![[0.0, kn * load], [mm * farthest, kn * load]];
            curves.push(curve("table: rupture", level));
        }
        let mut events = self.outcome.events.iter();
        if let Some(e) = events.find(|e| e.kind != EventKind::RodYielded) {
            let [x, y] = [mm * e.deflection, kn * e.load];
            let tall = 0.04 * kn * self.outcome.maximum.load;
            curves.push(curve("first break", vec![[x, y - tall], [x, y + tall]]));
        }
        curves
    }
}

impl BendTable {
    /// Returns the rows, as CSV.
    pub fn csv(&self) -> String {
        let mut text = SPECIES_HEADER.to_owned();
        let number = |x: Option<f64>| x.map_or(String::new(), |x| x.to_string());
        for row in &self.rows {
            let mut cells = vec![
                quoted(&row.species),
                quoted(&row.scientific_name),
                self.moisture_percent.to_string(),
            ];
            match &row.report {
                Some(r) => {
                    for c in [
                        &r.modulus_of_elasticity_pa,
                        &r.modulus_of_rupture_pa,
                        &r.work_to_maximum_load_j_per_m3,
                    ] {
                        cells.extend([c.test.to_string(), number(c.table), number(c.ratio)]);
                    }
                    cells.push(number(row.stress_at_first_break_pa));
                    cells.push(r.maximum.load_n.to_string());
                    cells.push(r.maximum.deflection_m.to_string());
                    cells.push(quoted(&r.notes.join("; ")));
                    cells.push(String::new());
                }
                None => {
                    cells.extend(vec![String::new(); 13]);
                    cells.push(quoted(row.not_tested_because.as_deref().unwrap_or("")));
                }
            }
            text += &(cells.join(",") + "\n");
        }
        text
    }
}

impl SpecimensReport {
    /// Returns the specimens, as CSV.
    pub fn csv(&self) -> String {
        let mut text = SPECIMENS_HEADER.to_owned();
        for row in &self.rows {
            let mut cells = vec![row.specimen.to_string(), row.density_kg_per_m3.to_string()];
            match &row.result {
                Some(r) => {
                    let first_break = r.stress_at_first_break_pa;
                    cells.extend([
                        r.modulus_of_elasticity_pa.to_string(),
                        r.modulus_of_rupture_pa.to_string(),
                        r.work_to_maximum_load_j_per_m3.to_string(),
                        first_break.map_or(String::new(), |stress| stress.to_string()),
                        r.maximum_load_n.to_string(),
                        r.deflection_at_maximum_load_m.to_string(),
                    ]);
                }
                None => cells.extend(vec![String::new(); 6]),
            }
            cells.push((row.not_tested_because.as_deref()).map_or(String::new(), quoted));
            text += &(cells.join(",") + "\n");
        }
        text
    }
}
