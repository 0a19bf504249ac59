//! The bending test against the tables that the wood's numbers are from.

use greenstick_fibre::{BendError, BendSection, BendTest, EventKind, HowMany, WoodMaterial};
use greenstick_geometry::Context;
use greenstick_wood::moisture::Fallback;
use greenstick_wood::species::Species;

fn coarse() -> BendTest {
    BendTest {
        rods: HowMany::Number(16),
        edge: 0.03,
        end: 0.97,
        ..BendTest::default()
    }
}

#[test]
fn bending_returns_the_tables_modulus_and_strength() {
    // Stiff and strong; light and weak in compression.
    for name in ["white oak", "Atlantic white cedar"] {
        let species = Species::find(name).unwrap();
        let wood = WoodMaterial::of(species, 12.0, Fallback::Refuse).unwrap();
        let out = coarse().run(&wood, &Context::quiet()).unwrap();
        let modulus = out.modulus_of_elasticity / species.dry.modulus_of_elasticity.unwrap();
        let rupture = out.modulus_of_rupture / species.dry.modulus_of_rupture.unwrap();
        println!("{name}: modulus {modulus}, rupture {rupture}");
        assert!((modulus - 1.0).abs() < 0.05, "{name}: {modulus}");
        assert!((rupture - 1.0).abs() < 0.15, "{name}: {rupture}");
        // Wood yields in compression before it breaks in tension.
        assert_eq!(out.events[0].kind, EventKind::RodYielded);
        assert!(out.events.iter().any(|e| e.kind == EventKind::RodBroke));
    }
}

#[test]
fn specimens_that_cannot_be_tested_are_refused() {
    let species = Species::find("white oak").unwrap();
    let wood = WoodMaterial::of(species, 12.0, Fallback::Refuse).unwrap();
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
            rods: HowMany::Number(0),
            ..coarse()
        },
    ];
    for test in bad {
        let refused = test.run(&wood, &Context::quiet());
        assert!(matches!(refused, Err(BendError::Value { .. })), "{test:?}");
    }
}
