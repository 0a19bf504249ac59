//! Files of bending tests: tables, chart and report.

use super::{BendTable, BendingError, Bent};
use greenstick_fibre::EventKind;
use greenstick_formats::Encoded;
use greenstick_picture::{Chart, Line, Picture};
use serde::Serialize;
use std::fmt::Write;

const LOADS: &str =
    "deflection_m,load_N,fibre_stress_Pa,work_J,edges_yielded,rods_broken,bonds_broken\n";
const EVENTS: &str =
    "deflection_m,load_N,kind,rod,other_rod,along_m,height_m,across_m,cause,demand,energy_J\n";
const SPECIES: &str = "species,scientific_name,moisture_percent,\
modulus_of_elasticity_Pa,table_modulus_of_elasticity_Pa,modulus_of_elasticity_ratio,\
modulus_of_rupture_Pa,table_modulus_of_rupture_Pa,modulus_of_rupture_ratio,\
work_to_maximum_load_J_per_m3,table_work_to_maximum_load_J_per_m3,work_to_maximum_load_ratio,\
stress_at_first_break_Pa,maximum_load_N,deflection_at_maximum_load_m,notes,not_tested_because\n";

/// A cell of words, quoted.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

fn word(kind: impl Serialize) -> String {
    match serde_json::to_value(kind) {
        Ok(serde_json::Value::String(word)) => word,
        _ => String::new(),
    }
}

fn json(value: &impl Serialize) -> Result<Vec<u8>, BendingError> {
    let text =
        serde_json::to_string_pretty(value).map_err(|e| BendingError::Report(e.to_string()))?;
    Ok((text + "\n").into_bytes())
}

impl Bent {
    /// The name of the report's file.
    pub const REPORT: &'static str = "bend-test.json";

    /// `load-deflection.csv`, `load-deflection.png`, `events.csv` and `bend-test.json`.
    ///
    /// # Errors
    /// [`BendingError::Report`].
    pub fn files(&self) -> Result<Vec<Encoded>, BendingError> {
        let file = |name: &str, bytes| Encoded {
            name: name.to_owned(),
            bytes,
        };
        Ok(vec![
            file(Bent::REPORT, json(&self.report)?),
            file("load-deflection.csv", self.loads().into_bytes()),
            file("load-deflection.png", self.chart().png()),
            file("events.csv", self.events().into_bytes()),
        ])
    }

    /// The stress in the outermost fibre under a load (N), as if linear, Pa.
    fn stress(&self, load: f64) -> f64 {
        let section = self.test.section;
        load * self.test.span * section.height() / (8.0 * section.inertia())
    }

    fn loads(&self) -> String {
        let mut text = LOADS.to_owned();
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
                self.stress(p.load),
                p.yielded,
                p.rods_broken,
                p.bonds_broken
            );
        }
        text
    }

    fn events(&self) -> String {
        let mut text = EVENTS.to_owned();
        for e in &self.outcome.events {
            let other = e.other.map_or(String::new(), |o| o.to_string());
            let _ = writeln!(
                text,
                "{},{},{},{},{other},{},{},{},{},{},{}",
                e.deflection,
                e.load,
                word(e.kind),
                e.rod,
                e.along,
                e.height,
                e.across,
                word(e.cause),
                e.demand,
                e.energy
            );
        }
        text
    }

    /// Load over deflection, with where the table has stiffness and largest load.
    pub fn chart(&self) -> Picture {
        let (r, points) = (&self.report, &self.outcome.points);
        let (mm, kn) = (1e3, 1e-3);
        let curve = points.iter().map(|p| [mm * p.deflection, kn * p.load]);
        let mut lines = vec![Line {
            name: "test".to_owned(),
            points: curve.collect(),
        }];
        let section = self.test.section;
        let far = points.iter().fold(0.0, |m, p| f64::max(m, p.deflection));
        if let (Some(e), Some(rupture)) = (
            r.modulus_of_elasticity_pa.table,
            r.modulus_of_rupture_pa.table,
        ) {
            let load = rupture / self.stress(1.0);
            let bent = load * self.test.span.powi(3) / (48.0 * e * section.inertia());
            lines.push(Line {
                name: "table: elastic".to_owned(),
                points: vec![[0.0, 0.0], [mm * bent, kn * load]],
            });
            lines.push(Line {
                name: "table: rupture".to_owned(),
                points: vec![[0.0, kn * load], [mm * far, kn * load]],
            });
        }
        let mut broke = self.outcome.events.iter();
        let broke = broke.find(|e| e.kind != EventKind::RodYielded);
        if let Some(e) = broke {
            let [x, y] = [mm * e.deflection, kn * e.load];
            let tall = 0.04 * kn * self.outcome.maximum.load;
            lines.push(Line {
                name: "first break".to_owned(),
                points: vec![[x, y - tall], [x, y + tall]],
            });
        }
        Chart {
            title: format!("{}, {} % moisture", r.species, r.moisture_percent),
            axes: ["deflection (mm)".to_owned(), "load (kN)".to_owned()],
            lines,
        }
        .draw(1600, 900)
    }
}

impl BendTable {
    /// The name of the table's file.
    pub const TABLE: &'static str = "species.csv";

    /// `species.csv` and `species.json`, with the summary.
    ///
    /// # Errors
    /// [`BendingError::Report`].
    pub fn files(&self) -> Result<Vec<Encoded>, BendingError> {
        Ok(vec![
            Encoded {
                name: BendTable::TABLE.to_owned(),
                bytes: self.csv().into_bytes(),
            },
            Encoded {
                name: "species.json".to_owned(),
                bytes: json(self)?,
            },
        ])
    }

    fn csv(&self) -> String {
        let mut text = SPECIES.to_owned();
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
