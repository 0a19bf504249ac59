//! Tests of recipes: round trips, layers, and messages that name the line.

use super::*;
use crate::parameters::{Crack, CrackKind, CrackSettings};
use crate::presets::PRESETS;
use greenstick_schema::Value;

#[test]
fn every_parameter_round_trips_through_toml_by_itself() {
    for info in BreakParameters::table() {
        let mut recipe = Recipe::default();
        recipe
            .face
            .set(&info.key, &info.neighbour().unwrap())
            .unwrap();
        assert_ne!(recipe, Recipe::default(), "{}", info.key);
        assert_eq!(
            Recipe::from_toml(&recipe.to_toml()).unwrap(),
            recipe,
            "{}",
            info.key
        );
    }
    for info in CrackSettings::table() {
        let mut recipe = Recipe::default();
        recipe
            .cracks
            .settings
            .set(&info.key, &info.neighbour().unwrap())
            .unwrap();
        // The least alone may be above the greatest, which is refused; then it is not a recipe.
        if recipe.check().is_ok() {
            assert_eq!(
                Recipe::from_toml(&recipe.to_toml()).unwrap(),
                recipe,
                "{}",
                info.key
            );
        }
    }
}

#[test]
fn presets_with_species_moisture_and_cracks_round_trip() {
    for preset in PRESETS {
        let mut recipe =
            Recipe::resolve(&[preset.name, "fig20"], None, &["species=Quercus alba"]).unwrap();
        recipe.moisture = Some(14.5);
        let mut crack = Crack::new(CrackKind::Tangential);
        crack.set("shrinkage", &Value::Number(0.1 + 0.2)).unwrap();
        recipe.cracks.cracks.push(crack);
        let text = recipe.to_toml();
        let back = Recipe::from_toml(&text).unwrap();
        assert_eq!(back, recipe, "{text}");
        assert_eq!(back.species.as_deref(), Some("Oak, white"));
    }
}

#[test]
fn layers_stand_over_each_other_in_order() {
    let text = "[break]\nslab_height = 1.25\n[[crack]]\nkind = 'radial'\nangle = 7\n";
    let with_preset = format!("preset = ['brash', 'fig21']\nmoisture = 9\n{text}");
    let recipe = Recipe::resolve(&[], Some(&with_preset), &["sliver_height=30 %"]).unwrap();
    // Default, preset, recipe, setting.
    let default = BreakParameters::default();
    assert_eq!(recipe.face.bark_strips, default.bark_strips);
    assert_ne!(recipe.face.bundle_aspect, default.bundle_aspect);
    assert_ne!(recipe.face.fibre_height, default.fibre_height);
    let brash = Recipe::resolve(&["brash"], None, &[]).unwrap().face;
    assert_eq!(recipe.face.fibre_height, brash.fibre_height);
    assert_eq!(recipe.face.slab_height, 1.25);
    assert_eq!(recipe.face.sliver_height, 0.3);
    assert_eq!(
        (
            recipe.cracks.cracks.len(),
            recipe.cracks.settings.small.count
        ),
        (1, 24)
    );
    // A preset given outside stands in place of the text's own.
    let recipe = Recipe::resolve(&["twist"], Some(&with_preset), &[]).unwrap();
    assert_eq!(
        (recipe.face.spiral_angle, recipe.face.slab_height),
        (25.0, 1.25)
    );
}

#[test]
fn nested_tables_dotted_keys_and_settings_mean_the_same() {
    let texts = [
        "[break.sapwood]\nperlin_amplitude = 0.5",
        "[break]\nsapwood.perlin_amplitude = 0.5",
        "break = { sapwood = { perlin_amplitude = '50 %' } }",
    ];
    let by_setting = Recipe::resolve(&[], None, &["break.sapwood.perlin_amplitude = 0.5"]).unwrap();
    assert_eq!(by_setting.face.sapwood.perlin_amplitude, 0.5);
    for text in texts {
        assert_eq!(Recipe::from_toml(text).unwrap(), by_setting);
    }
}

#[test]
fn messages_say_the_line_and_what_would_be_right() {
    let message = |text: &str| Recipe::from_toml(text).unwrap_err().to_string();
    for (text, expected) in [
        (
            "[break]\nrings = 20\nslab_hight = 1",
            "line 3, column 1: unknown parameter \"break.slab_hight\"; did you mean \"break.slab_height\"",
        ),
        (
            "[break]\n\nslab_height = 21",
            "line 3, column 15: break.slab_height is 21, but it must be from 0 to 20 radius",
        ),
        (
            "[break]\nslab_height = nan",
            "line 2, column 15: break.slab_height is NaN, but it must be",
        ),
        (
            "[break]\nlow.height = 1",
            "line 2, column 14: break.low.height is 1, but it must be from -20",
        ),
        (
            "[break]\nrings = -4",
            "line 2, column 9: break.rings is -4, but it must be a whole number",
        ),
        (
            "[break]\nrings = true",
            "line 2, column 9: break.rings is true, but it must be a whole num",
        ),
        (
            "species = 'whit oak'",
            "line 1, column 11: species: unknown species \"whit oak\"; did you mean",
        ),
        (
            "moisture = 0",
            "line 1, column 12: moisture is 0, but it must be above 0 and up to 200 %",
        ),
        (
            "presett = 'brash'",
            "line 1, column 1: unknown parameter \"presett\"; did you mean \"preset\"",
        ),
        (
            "slab_height = 1",
            "line 1, column 1: unknown parameter \"slab_height\"; did you mean \"[break]",
        ),
        (
            "preset = ['brash', 'brsh']",
            "line 1, column 20: unknown preset \"brsh\"",
        ),
        (
            "[[crack]]\nangle = 3",
            "line 1, column 1: kind is missing, but it must be one of radial",
        ),
        (
            "[[crack]]\nkind = 'radial'\nring = 0.5",
            "line 3, column 1: unknown parameter \"ring\"",
        ),
        (
            "[[crack]]\nkind = 'radial'\nbegin = 0.5\nend = 0.4",
            "line 1, column 1: begin is 0.5 and end is 0.4",
        ),
        (
            "moisture = 9\n[break]\npith_proportion = 0.9",
            "line 2, column 1: pith 0.9, heartwood 0.4 and phloem 0.05 are together more than 1",
        ),
        ("[break\n", "line 1, column"),
    ] {
        let found = message(text);
        assert!(found.starts_with(expected), "{text:?} gave {found:?}");
    }
}

#[test]
fn settings_that_are_wrong_are_named() {
    let message = |s: &str| Recipe::resolve(&[], None, &[s]).unwrap_err().to_string();
    assert_eq!(
        message("rings"),
        "setting \"rings\": a setting is written key=value"
    );
    assert!(message("rings=many").starts_with("setting \"rings=many\": rings is many"));
    assert!(message("moisture=wet").contains("must be a number, with or without a unit: %"));
    assert!(
        message("crack_groups.large.cuont=2").contains("did you mean \"crack_groups.large.count\"")
    );
    assert_eq!(
        Recipe::resolve(&[], None, &["moisture=12%"])
            .unwrap()
            .moisture,
        Some(12.0)
    );
    assert!(message("pith_proportion=1").contains("together more than 1"));
}

#[test]
fn crack_shrinkage_is_the_species_dried_to_its_moisture() {
    let of = |settings: &[&str]| {
        Recipe::resolve(&[], None, settings)
            .unwrap()
            .crack_shrinkage()
    };
    // White oak: 10.5 % and 5.6 %, times (30 − 15)/30.
    let oak = of(&["species=white oak", "moisture=15"]).unwrap();
    assert!((oak.tangential - 0.0525).abs() < 1e-12 && (oak.radial - 0.028).abs() < 1e-12);
    assert!(oak.basis.starts_with("shrinkage of Oak, white"));
    let tamarack = of(&["species=tamarack"]).unwrap();
    assert!((tamarack.tangential - 0.08 * 0.6).abs() < 1e-12);
    assert!(tamarack.basis.contains("lack that of Tamarack"));
}

/// The example that stands in the module's documentation.
fn documented_example() -> String {
    include_str!("../recipe.rs")
        .lines()
        .skip_while(|l| !l.contains("```toml"))
        .skip(1)
        .take_while(|l| !l.contains("```"))
        .map(|l| l.trim_start_matches("//!").trim_start().to_owned() + "\n")
        .collect()
}

#[test]
fn the_documented_example_means_what_it_says() {
    let recipe = Recipe::from_toml(&documented_example()).unwrap();
    let preset = Recipe::resolve(&["splintering-tension"], None, &[]).unwrap();
    assert_eq!(recipe.face.slab_height, 1.5);
    assert_eq!(recipe.face.split, preset.face.split);
    assert_ne!(preset.face.split, BreakParameters::default().split);
    assert!((recipe.face.diameter - 1.2).abs() < 1e-12);
    assert_eq!(recipe.face.sapwood.perlin_amplitude, 0.1);
    assert_eq!(
        (
            recipe.cracks.settings.large.count,
            recipe.cracks.cracks.len()
        ),
        (4, 1)
    );
}

#[test]
fn a_text_cut_off_anywhere_is_read_or_refused_with_a_place_inside_it() {
    let text = documented_example();
    for end in (0..text.len()).filter(|&e| text.is_char_boundary(e)) {
        let part = &text[..end];
        match Recipe::from_toml(part) {
            Ok(_) => {}
            Err(RecipeError::At { line, column, .. }) => {
                assert!(
                    line <= part.matches('\n').count() + 1 && column >= 1,
                    "{part}"
                );
            }
            Err(other) => panic!("{part}: {other}"),
        }
    }
}
