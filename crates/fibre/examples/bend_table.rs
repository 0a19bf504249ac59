//! Bending tests of species against their rows in the Wood Handbook:
//! `cargo run --release -p greenstick-fibre --example bend_table -- RODS EDGE_M [SPECIES…]`, all 112 without names.
//! Ratios are what the test returned over what the table has.

use greenstick_fibre::{BendTest, WoodMaterial};
use greenstick_geometry::Context;
use greenstick_wood::moisture::Fallback;
use greenstick_wood::species::Species;
use rayon::prelude::*;

fn row(species: &Species, test: &BendTest) -> Result<[f64; 3], String> {
    let wood = WoodMaterial::of(species, 12.0, Fallback::Refuse).map_err(|e| e.to_string())?;
    let out = test
        .run(&wood, &Context::quiet())
        .map_err(|e| e.to_string())?;
    let table = |v: Option<f64>| v.unwrap_or(f64::NAN);
    let dry = &species.dry;
    Ok([
        out.modulus_of_elasticity / table(dry.modulus_of_elasticity),
        out.modulus_of_rupture / table(dry.modulus_of_rupture),
        out.work_to_maximum_load / table(dry.work_to_maximum_load),
    ])
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let mut test = BendTest {
        // The first break is the peak; what comes after is of no use here.
        end: 0.96,
        ..BendTest::default()
    };
    if let [rods, edge, ..] = given.as_slice() {
        (test.rods, test.edge) = (rods.parse()?, edge.parse()?);
    }
    let named = given.iter().skip(2).map(|name| Species::find(name));
    let mut species = named.collect::<Result<Vec<_>, _>>()?;
    if species.is_empty() {
        species = Species::all()[..112].iter().collect();
    }
    let rows: Vec<_> = species.par_iter().map(|s| row(s, &test)).collect();
    println!("{:32} elasticity  rupture  work", "over the table's:");
    for (s, row) in species.iter().zip(rows) {
        match row {
            Ok([e, r, w]) => println!("{:32} {e:10.3} {r:8.3} {w:5.2}", s.name),
            Err(error) => println!("{:32} {error}", s.name),
        }
    }
    Ok(())
}
