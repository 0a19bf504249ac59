//! The bending test against the tables from which the wood's properties come.

use greenstick_fibre::bend_test::{BendRequest, bend};
use greenstick_fibre::{BendError, BendSection, BendTest, EventKind, RodCount, WoodMaterial};
use greenstick_geometry::Context;
use greenstick_wood::moisture::Fallback;
use greenstick_wood::species::Species;

fn coarse() -> BendTest {
    BendTest {
        rods: RodCount::Number(16),
        edge: 0.03,
        end: 0.97,
        ..BendTest::default()
    }
}

#[test]
fn bending_returns_the_modulus_and_strength_of_the_table() {
    // Stiff and strong; light and weak in compression.
    for name in ["white oak", "Atlantic white cedar"] {
        let species = Species::find(name).unwrap();
        let wood = WoodMaterial::from_species(species, 12.0, Fallback::Refuse).unwrap();
        let out = coarse().run(&wood, &Context::quiet()).unwrap();
        let modulus = out.modulus_of_elasticity / species.dry.modulus_of_elasticity.unwrap();
        let rupture = out.modulus_of_rupture / species.dry.modulus_of_rupture.unwrap();
        println!("{name}: modulus {modulus}, rupture {rupture}");
        assert!((modulus - 1.0).abs() < 0.05, "{name}: {modulus}");
        assert!((rupture - 1.0).abs() < 0.10, "{name}: {rupture}");
        // Wood yields in compression before it breaks in tension.
        assert_eq!(out.events[0].kind, EventKind::RodYielded);
        assert!(out.events[0].height > 0.0, "{:?}", out.events[0]);
        assert!(out.events.iter().any(|e| e.kind == EventKind::RodBroke));
    }
}

#[test]
fn european_wood_bends_as_its_sources_have_it_dry_and_as_estimated_green() {
    for name in [
        "Picea abies",
        "Fagus sylvatica",
        "Quercus robur",
        "Pinus sylvestris",
        "Larix decidua",
        "Fraxinus excelsior",
        "Abies alba",
        "Betula pendula",
        "Acer pseudoplatanus",
    ] {
        for moisture in [12.0, 60.0] {
            let bent = bend(
                &BendRequest {
                    species: name.to_owned(),
                    moisture,
                    test: coarse(),
                },
                &Context::quiet(),
            )
            .unwrap();
            let [modulus, rupture] = [
                bent.report.modulus_of_elasticity_pa,
                bent.report.modulus_of_rupture_pa,
            ]
            .map(|c| c.ratio.unwrap());
            println!("{name} at {moisture} %: modulus {modulus}, rupture {rupture}");
            assert!((modulus - 1.0).abs() < 0.05, "{name}: {modulus}");
            assert!((rupture - 1.0).abs() < 0.03, "{name}: {rupture}");
            let is_green = moisture > 12.0;
            let estimated = |note: &String| note.contains("mean ratio of green to dry wood");
            assert_eq!(bent.report.notes.iter().any(estimated), is_green, "{name}");
        }
    }
}

#[test]
fn half_the_spacing_and_half_the_edges_give_the_same_strength() {
    let species = Species::find("white oak").unwrap();
    let wood = WoodMaterial::from_species(species, 12.0, Fallback::Refuse).unwrap();
    let rupture = [(9, 0.04), (36, 0.02)].map(|(rods, edge)| {
        let test = BendTest {
            rods: RodCount::Number(rods),
            edge,
            end: 0.97,
            ..BendTest::default()
        };
        let out = test.run(&wood, &Context::quiet()).unwrap();
        assert_eq!(out.rods, rods as usize);
        out.modulus_of_rupture
    });
    let change = rupture[1] / rupture[0] - 1.0;
    println!("rupture changes by {:.2} %", 100.0 * change);
    assert!(change.abs() < 0.10, "{rupture:?}");
}

#[test]
fn a_test_continues_through_splinters_to_its_end() {
    let test = BendTest {
        rods: RodCount::Number(9),
        edge: 0.06,
        end: 0.3,
        ..BendTest::default()
    };
    for name in ["white oak", "Sitka spruce", "nutmeg hickory"] {
        let wood = WoodMaterial::from_species(Species::find(name).unwrap(), 12.0, Fallback::Refuse)
            .unwrap();
        let out = test.run(&wood, &Context::quiet()).unwrap();
        let last = out.points.last().unwrap();
        assert!(!out.came_apart, "{name}: {last:?}");
        assert!(last.load < 0.3 * out.maximum.load, "{name}: {last:?}");
        // Every event is counted, at the point of the curve where it happened.
        assert_eq!(
            (last.yielded + last.broken()) as usize,
            out.events.len(),
            "{name}"
        );
        for e in &out.events {
            let on_the_curve =
                |p: &greenstick_fibre::BendPoint| p.deflection == e.deflection && p.load == e.load;
            assert!(out.points.iter().any(on_the_curve), "{name}: {e:?}");
        }
        // Energy comes from the load only: breaks cannot take more than its work.
        let work: f64 = out
            .points
            .windows(2)
            .map(|p| 0.5 * (p[0].load + p[1].load) * (p[1].deflection - p[0].deflection))
            .sum();
        let taken: f64 = out.events.iter().map(|e| e.energy).sum();
        assert!(taken > 0.0 && taken < work, "{name}: {taken} J of {work} J");
    }
}

#[test]
fn specimens_that_cannot_be_tested_are_refused() {
    let species = Species::find("white oak").unwrap();
    let wood = WoodMaterial::from_species(species, 12.0, Fallback::Refuse).unwrap();
    let bad = [
        BendTest {
            span: 0.8,
            ..coarse()
        },
        BendTest {
            section: BendSection::Round { diameter: f64::NAN },
            ..coarse()
        },
        BendTest {
            edge: 0.0,
            ..coarse()
        },
        BendTest {
            rods: RodCount::Number(0),
            ..coarse()
        },
        BendTest {
            rods: RodCount::Spacing(0.06),
            ..coarse()
        },
        BendTest {
            weibull: f64::NAN,
            ..coarse()
        },
    ];
    for test in bad {
        let refused = test.run(&wood, &Context::quiet());
        assert!(matches!(refused, Err(BendError::Value { .. })), "{test:?}");
    }
    let huge = BendTest {
        rods: RodCount::Number(u32::MAX),
        ..coarse()
    };
    assert!(matches!(huge.check(), Err(BendError::TooFine { .. })));
}

#[test]
fn sloping_grain_bends_and_breaks_as_hankinson_has_it() {
    let bent = |degrees: f64| {
        let test = BendTest {
            grain_angle: degrees.to_radians(),
            ..coarse()
        };
        let request = BendRequest {
            test,
            ..BendRequest::of("white oak")
        };
        bend(&request, &Context::quiet()).unwrap().report
    };
    let straight = bent(0.0).modulus_of_elasticity_pa.test;
    let wood = {
        let oak = Species::find("white oak").unwrap();
        WoodMaterial::from_species(oak, 12.0, Fallback::Refuse).unwrap()
    };
    for degrees in [5.0, 15.0, 30.0] {
        let report = bent(degrees);
        let expected = report.sloped_grain.unwrap();
        // Deflection by shear is that of straight grain: bending alone follows the formula.
        let shear = 1.0 / straight - 1.0 / wood.longitudinal;
        let ratio =
            expected.modulus_of_elasticity_pa / report.modulus_of_elasticity_pa.table.unwrap();
        let modulus = 1.0 / (1.0 / (ratio * wood.longitudinal) + shear);
        let off = report.modulus_of_elasticity_pa.test / modulus - 1.0;
        assert!(off.abs() < 0.02, "{degrees}: modulus off by {off}");
        let [low, high] = expected.modulus_of_rupture_pa;
        let rupture = report.modulus_of_rupture_pa.test;
        println!("{degrees}: rupture {rupture} of {low} to {high}");
        assert!(
            (0.9 * low..1.1 * high).contains(&rupture),
            "{degrees}: {rupture} {low} {high}"
        );
    }
}
