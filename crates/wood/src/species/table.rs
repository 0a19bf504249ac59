//! Reading the tables that are built into the library, and joining them by name.
//!
//! Table 5-3a gives the species and their order. Tables 4-1, 4-3 and 5-13 are joined to it by the
//! common name, case ignored. Table 5-13 names "douglas-fir" and "redwood" without saying which:
//! these join every row of that name. A name that matches nothing joins nothing, and the property
//! stays `None`.

use super::genus;
use super::record::{ElasticRow, Group, MechanicalProperties, Shrinkage, Species};

const MECHANICAL: &str = include_str!("../../data/usda_table_5_3a_mechanical.csv");
const SHRINKAGE: &str = include_str!("../../data/usda_table_4_3_shrinkage.csv");
const GREEN_MOISTURE: &str = include_str!("../../data/usda_table_4_1_green_moisture.csv");
const INTERSECTION: &str = include_str!("../../data/usda_table_5_13_intersection_moisture.csv");
const EUROPEAN: &str = include_str!("../../data/european_species.csv");
const ELASTICITY: &str = include_str!("../../data/usda_tables_5_1_and_5_2_elasticity.csv");
const YANG: &str = include_str!("../../data/yang_2019_table_1.csv");

/// Air-dry density over oven-dry mass per volume: wood at 12 % moisture holds 0.12 of its own mass in water.
const AIR_DRY_MASS: f64 = 1.12;
const WATER_DENSITY: f64 = 1000.0;
/// One kilogram-force per centimetre, N/m.
const KILOGRAM_FORCE_PER_CENTIMETRE: f64 = 980.665;

/// The rows below the header, split into columns; a column may be quoted and then hold commas.
fn rows(text: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    text.lines().skip(1).filter(|l| !l.is_empty()).map(|line| {
        let mut columns = Vec::new();
        let mut rest = line;
        loop {
            let (column, after) = match rest.strip_prefix('"').and_then(|q| q.split_once('"')) {
                Some((column, after)) => (column, after.strip_prefix(',')),
                None => match rest.split_once(',') {
                    Some((column, after)) => (column, Some(after)),
                    None => (rest, None),
                },
            };
            columns.push(column);
            match after {
                Some(after) => rest = after,
                None => return columns,
            }
        }
    })
}

/// The number in column `k` times `unit`; `None` where the table has none.
fn number(row: &[&str], k: usize, unit: f64) -> Option<f64> {
    row.get(k)?.parse::<f64>().ok().map(|x| x * unit)
}

fn text(row: &[&str], k: usize) -> String {
    row.get(k).copied().unwrap_or_default().to_owned()
}

fn percent(row: &[&str], k: usize) -> Option<f64> {
    row.get(k)?.parse::<f64>().ok().map(|x| x / 100.0)
}

fn mechanical(row: &[&str]) -> MechanicalProperties {
    MechanicalProperties {
        specific_gravity: number(row, 4, 1.0),
        modulus_of_rupture: number(row, 5, 1e3),
        modulus_of_elasticity: number(row, 6, 1e6),
        work_to_maximum_load: number(row, 7, 1e3),
        impact_height: number(row, 8, 1e-3),
        compression_parallel: number(row, 9, 1e3),
        compression_perpendicular: number(row, 10, 1e3),
        shear_parallel: number(row, 11, 1e3),
        tension_perpendicular: number(row, 12, 1e3),
        side_hardness: number(row, 13, 1.0),
    }
}

fn joined(table: &'static str, name: &str) -> Option<Vec<&'static str>> {
    rows(table).find(|r| r[0].eq_ignore_ascii_case(name))
}

fn intersection(name: &str) -> Option<f64> {
    let kind = name.split(',').next().unwrap_or(name);
    let row = joined(INTERSECTION, name).or_else(|| joined(INTERSECTION, kind))?;
    number(&row, 1, 1.0)
}

fn group(name: &str) -> Group {
    if name == "softwood" {
        Group::Softwood
    } else {
        Group::Hardwood
    }
}

fn handbook(row: &[&str]) -> String {
    format!("Wood Handbook, {}", text(row, 14))
}

fn from_handbook(row: &[&str]) -> Species {
    let name = text(row, 0);
    let green = rows(MECHANICAL).find(|r| r[0] == name && r[3] == "green");
    let shrinkage = joined(SHRINKAGE, &name);
    let shrinkage = shrinkage.as_ref().map(|r| Shrinkage {
        radial: percent(r, 1),
        tangential: percent(r, 2),
        volumetric: percent(r, 3),
    });
    let moisture = joined(GREEN_MOISTURE, &name);
    let anatomy = genus::ring_character_and_heartwood(&text(row, 1));
    let dry = mechanical(row);
    Species {
        scientific_name: text(row, 1),
        group: group(row.get(2).copied().unwrap_or_default()),
        source: handbook(row),
        air_dry_density: dry
            .specific_gravity
            .map(|g| g * AIR_DRY_MASS * WATER_DENSITY),
        dry,
        green_source: green.as_ref().map(|r| handbook(r)),
        green: green.as_ref().map(|r| mechanical(r)),
        end_hardness: None,
        splitting_resistance: None,
        shrinkage: shrinkage.unwrap_or_default(),
        green_heartwood_percent: moisture.as_ref().and_then(|r| number(r, 1, 1.0)),
        green_sapwood_percent: moisture.as_ref().and_then(|r| number(r, 2, 1.0)),
        intersection_percent: intersection(&name),
        ring_character: anatomy.map(|a| a.0),
        heartwood_colour: anatomy.map(|a| a.1),
        name,
    }
}

fn from_yang(row: &[&str]) -> Species {
    let anatomy = genus::ring_character_and_heartwood(&text(row, 1));
    let density = number(row, 3, WATER_DENSITY);
    Species {
        name: text(row, 0),
        scientific_name: text(row, 1),
        group: group(row.get(2).copied().unwrap_or_default()),
        source: "Yang, Yang, Yang 2019, Table 1".to_owned(),
        air_dry_density: density,
        dry: MechanicalProperties {
            // The paper gives the air-dry density, which holds the water too.
            specific_gravity: density.map(|d| d / (AIR_DRY_MASS * WATER_DENSITY)),
            modulus_of_rupture: number(row, 7, 1e6),
            modulus_of_elasticity: number(row, 8, 1e9),
            compression_parallel: number(row, 6, 1e6),
            ..MechanicalProperties::default()
        },
        green_source: None,
        green: None,
        end_hardness: number(row, 9, 1.0),
        splitting_resistance: number(row, 10, KILOGRAM_FORCE_PER_CENTIMETRE),
        shrinkage: Shrinkage {
            radial: percent(row, 4),
            tangential: percent(row, 5),
            volumetric: None,
        },
        green_heartwood_percent: None,
        green_sapwood_percent: None,
        intersection_percent: None,
        ring_character: anatomy.map(|a| a.0),
        heartwood_colour: anatomy.map(|a| a.1),
    }
}

fn from_european(row: &[&str]) -> Species {
    let anatomy = genus::ring_character_and_heartwood(&text(row, 1));
    let density = number(row, 3, 1.0);
    Species {
        name: text(row, 0),
        scientific_name: text(row, 1),
        group: group(row.get(2).copied().unwrap_or_default()),
        source: text(row, 11),
        air_dry_density: density,
        dry: MechanicalProperties {
            specific_gravity: density.map(|d| d / (AIR_DRY_MASS * WATER_DENSITY)),
            modulus_of_rupture: number(row, 7, 1e6),
            modulus_of_elasticity: number(row, 8, 1e6),
            compression_parallel: number(row, 9, 1e6),
            shear_parallel: number(row, 10, 1e6),
            ..MechanicalProperties::default()
        },
        green_source: None,
        green: None,
        end_hardness: None,
        splitting_resistance: None,
        shrinkage: Shrinkage {
            radial: percent(row, 4),
            tangential: percent(row, 5),
            volumetric: percent(row, 6),
        },
        green_heartwood_percent: None,
        green_sapwood_percent: None,
        intersection_percent: None,
        ring_character: anatomy.map(|a| a.0),
        heartwood_colour: anatomy.map(|a| a.1),
    }
}

/// Reads all species, in the order of their tables.
pub(super) fn read() -> Vec<Species> {
    let handbook = rows(MECHANICAL)
        .filter(|r| r.get(3) == Some(&"12%"))
        .map(|r| from_handbook(&r));
    handbook
        .chain(rows(EUROPEAN).map(|r| from_european(&r)))
        .chain(rows(YANG).map(|r| from_yang(&r)))
        .collect()
}

/// Reads the elastic ratios.
pub(super) fn read_elastic() -> Vec<ElasticRow> {
    let row = |r: Vec<&'static str>| ElasticRow {
        name: r[0],
        group: group(r.get(1).copied().unwrap_or_default()),
        ratios: std::array::from_fn(|k| number(&r, 2 + k, 1.0)),
    };
    rows(ELASTICITY).map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_of_every_table_is_read() {
        // Species, then how many columns, then the columns that are words.
        for (table, columns, words) in [
            (MECHANICAL, 15, &[0, 1, 2, 3, 14][..]),
            (SHRINKAGE, 5, &[0, 4][..]),
            (GREEN_MOISTURE, 3, &[0][..]),
            (INTERSECTION, 2, &[0][..]),
            (EUROPEAN, 12, &[0, 1, 2, 11][..]),
            (ELASTICITY, 10, &[0, 1][..]),
            (YANG, 11, &[0, 1, 2][..]),
        ] {
            for row in rows(table) {
                assert_eq!(row.len(), columns, "{row:?}");
                for (k, cell) in row.iter().enumerate() {
                    let good = words.contains(&k) || cell.is_empty() || cell.parse::<f64>().is_ok();
                    assert!(good, "{row:?}: {cell}");
                }
            }
        }
    }

    #[test]
    fn names_of_the_joined_tables_are_species_or_known_to_be_left_out() {
        let left_out: Vec<_> = rows(SHRINKAGE)
            .map(|r| r[0])
            .filter(|n| !rows(MECHANICAL).any(|m| m[0].eq_ignore_ascii_case(n)))
            .collect();
        let expected = [
            "Ash, pumpkin",
            "Birch, Alaska paper",
            "Birch, gray",
            "Birch, river",
            "Buckeye, yellow",
            "Elm, cedar",
            "Elm, winged",
            "Persimmon, common",
            "Tanoak",
        ];
        assert_eq!(left_out, expected);
        for row in rows(GREEN_MOISTURE) {
            assert!(
                rows(MECHANICAL).any(|m| m[0].eq_ignore_ascii_case(row[0])),
                "{row:?}"
            );
        }
    }
}
