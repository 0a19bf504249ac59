//! Reading the tables back. Columns are found by their names; rows that a killed run left incomplete are left out.

use super::forces::ForceRow;
use super::tables::{CAUSES, EnergyLedger, EnergyRow, KINDS};
use crate::energy::Energies;
use crate::event::Event;
use glam::DVec3;

/// A table with named columns.
struct Table<'a> {
    names: Vec<&'a str>,
    rows: Vec<Vec<&'a str>>,
}

impl<'a> Table<'a> {
    fn parse(text: &'a str) -> Self {
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().map_or(Vec::new(), |l| l.split(',').collect());
        let rows = lines.map(|line| line.split(',').collect::<Vec<_>>());
        Table {
            rows: rows.filter(|row| row.len() == names.len()).collect(),
            names,
        }
    }

    /// Returns what `read` makes of every row, given the cells by the names of their columns; a column that the table does
    /// not have is empty.
    fn read<T>(&self, read: impl Fn(&Cells<'_>) -> Option<T>) -> Vec<T> {
        let row = |cells| {
            read(&Cells {
                names: &self.names,
                cells,
            })
        };
        self.rows.iter().filter_map(|cells| row(cells)).collect()
    }
}

/// A row of a table.
struct Cells<'a> {
    names: &'a [&'a str],
    cells: &'a [&'a str],
}

impl Cells<'_> {
    fn text(&self, name: &str) -> &str {
        let column = self.names.iter().position(|n| *n == name);
        column.map_or("", |c| self.cells[c])
    }

    /// Returns a number: 0 where the table does not have the column, NaN where the cell is no number.
    fn number(&self, name: &str) -> f64 {
        let column = self.names.iter().position(|n| *n == name);
        column.map_or(0.0, |c| self.cells[c].parse().unwrap_or(f64::NAN))
    }

    /// Returns the vector of the columns `before`x`after`, `before`y`after` and `before`z`after`.
    fn vector(&self, before: &str, after: &str) -> DVec3 {
        DVec3::from_array(["x", "y", "z"].map(|a| self.number(&format!("{before}{a}{after}"))))
    }
}

/// Reads the rows of `energy.csv`.
pub fn parse_energies(text: &str) -> Vec<EnergyRow> {
    Table::parse(text).read(|row| {
        Some(EnergyRow {
            time: row.number("time_s"),
            rods: Energies {
                kinetic: row.number("kinetic_J"),
                stretch: row.number("stretch_J"),
                bend: row.number("bend_J"),
                twist: row.number("twist_J"),
                bond_transverse: row.number("bond_transverse_J"),
                bond_shear: row.number("bond_shear_J"),
            },
            bodies: row.number("body_J"),
            gravity: row.number("gravity_J"),
            momentum: row.vector("momentum_", "_Ns"),
            angular: row.vector("angular_", "_Nms"),
            fracture_loss: row.number("fracture_loss_J"),
            ledger: EnergyLedger {
                damped: row.number("damped_J"),
                dissipated: row.number("dissipated_J"),
                work: row.number("work_J"),
            },
            contact: row.number("contact_J"),
            contact_loss: row.number("contact_loss_J"),
            contact_work: row.number("contact_work_J"),
        })
    })
}

/// Reads the rows of `events.csv`. Events of unknown kinds and causes are left out.
pub fn parse_events(text: &str) -> Vec<Event> {
    Table::parse(text).read(|row| {
        let (kind, cause) = (row.text("kind"), row.text("cause"));
        Some(Event {
            time: row.number("time_s"),
            kind: KINDS.iter().find(|k| k.1 == kind)?.0,
            rod: row.text("rod").parse().ok()?,
            vertex: row.text("vertex").parse().ok()?,
            other: row.text("other_rod").parse().ok(),
            position: row.vector("", "_m"),
            cause: CAUSES.iter().find(|c| c.1 == cause)?.0,
            demand: row.number("demand"),
            energy: row.number("energy_J"),
        })
    })
}

/// Reads the rows of `forces.csv`.
pub fn parse_forces(text: &str) -> Vec<ForceRow> {
    Table::parse(text).read(|row| {
        Some(ForceRow {
            time: row.number("time_s"),
            holder: row.text("holder").to_owned(),
            displacement: row.vector("moved_", "_m"),
            rotation_degrees: row.vector("turned_", "_deg"),
            force: row.vector("force_", "_N"),
            moment: row.vector("moment_", "_Nm"),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::forces::FORCE_HEADER;
    use super::super::tables::{ENERGY_HEADER, EVENT_HEADER, event_line};
    use super::*;
    use crate::event::{Cause, EventKind};

    #[test]
    fn rows_are_read_as_they_were_written() {
        let mut n = 0.1;
        let mut next = || {
            n *= 1.7;
            n
        };
        let vector = |next: &mut dyn FnMut() -> f64| DVec3::new(next(), -next(), next());
        let energy = EnergyRow {
            time: next(),
            rods: Energies {
                kinetic: next(),
                stretch: next(),
                bend: next(),
                twist: next(),
                bond_transverse: next(),
                bond_shear: next(),
            },
            bodies: next(),
            gravity: next(),
            momentum: vector(&mut next),
            angular: vector(&mut next),
            fracture_loss: next(),
            ledger: EnergyLedger {
                damped: next(),
                dissipated: next(),
                work: next(),
            },
            contact: next(),
            contact_loss: next(),
            contact_work: next(),
        };
        let torn = "0.5,1,2";
        let text = format!("{ENERGY_HEADER}{}{torn}", energy.line());
        assert_eq!(parse_energies(&text), [energy]);
        let events = KINDS.iter().zip(CAUSES).map(|(kind, cause)| Event {
            time: next(),
            kind: kind.0,
            rod: 3,
            vertex: 17,
            other: (kind.0 == EventKind::BondBroke).then_some(4),
            position: DVec3::new(0.1, -0.2, 0.3),
            cause: cause.0,
            demand: 1.25,
            energy: 1e-9,
        });
        let events: Vec<Event> = events.collect();
        let lines: String = events.iter().map(event_line).collect();
        let unknown = "1,rod_melted,0,0,,0,0,0,heat,1,1\n";
        let text = format!("{EVENT_HEADER}{lines}{unknown}{torn}");
        assert_eq!(parse_events(&text), events);
        assert_eq!(events[1].cause, Cause::Compression);
        let force = ForceRow {
            time: 1.0 / 3.0,
            holder: "press".into(),
            displacement: DVec3::new(1e-3, 0.0, -1.0 / 7.0),
            rotation_degrees: DVec3::new(30.0, 0.1, 0.0),
            force: DVec3::new(1.5, -2.5, 1e10),
            moment: DVec3::new(0.0, -0.0, 3.0),
        };
        assert_eq!(
            parse_forces(&format!("{FORCE_HEADER}{}{torn}", force.line())),
            [force]
        );
    }

    #[test]
    fn columns_that_a_table_lacks_are_zero_and_cells_that_are_no_numbers_are_nan() {
        let rows = parse_energies("kinetic_J,time_s\n2,1\nx,2\n");
        assert_eq!(
            (rows[0].time, rows[0].rods.kinetic, rows[0].contact),
            (1.0, 2.0, 0.0)
        );
        assert!(rows[1].rods.kinetic.is_nan());
        assert!(parse_events("").is_empty());
    }
}
