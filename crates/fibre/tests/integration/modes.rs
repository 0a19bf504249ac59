//! The modes in which wood breaks, each from what is done to what wood: nothing in a scene names them.

use greenstick_fibre::outcome::{Mode, Outcome};
use greenstick_fibre::scene::{Scene, StemChoice};
use greenstick_fibre::simulate::{SimulateRequest, simulate};
use greenstick_fibre::store::MemoryRun;
use greenstick_geometry::Context;

/// What becomes of the wood of a built-in scene with few rods and other keys.
fn outcome(name: &str, rods: u32, change: impl FnOnce(&mut Scene)) -> Outcome {
    let mut scene = Scene::built_in(name).unwrap();
    scene.rods.number = rods;
    change(&mut scene);
    let request = SimulateRequest {
        scene,
        ..Default::default()
    };
    let report = simulate(&request, &mut MemoryRun::default(), &Context::quiet()).unwrap();
    report.outcome.unwrap()
}

/// A thin stick with cross-sections in which all rods have vertices, so that places are as even as can be.
fn stick(scene: &mut Scene) {
    scene.stem.kind = StemChoice::Cylinder;
    (scene.stem.length, scene.stem.diameter) = (0.15, 0.012);
    scene.rods.edge = [0.005, 0.005];
}

#[test]
fn sound_wood_tears_raggedly_and_brash_wood_snaps_flat_in_however_many_places() {
    let sound = outcome("pull", 14, stick);
    assert_eq!(sound.mode, Mode::SimpleTension, "{sound}");
    let brash = outcome("pull", 14, |scene| {
        stick(scene);
        scene.wood.brash = 0.7;
    });
    // It shatters: twice as many breaks lie away from the face as in it.
    assert_eq!(brash.mode, Mode::BrashTension, "{brash}");
    assert!(brash.further_breaks > 2 * 14, "{brash}");
    assert!(brash.spread_m < sound.spread_m, "{brash}{sound}");
}

#[test]
fn bent_as_far_dry_wood_parts_in_splinters_and_green_wood_hinges() {
    let bend = |moisture: f64| {
        outcome("bend", 16, |scene| {
            scene.wood.moisture = moisture;
            scene.duration = 0.16;
        })
    };
    let (dry, green) = (bend(12.0), bend(80.0));
    assert_eq!(dry.mode, Mode::SplinteringTension, "{dry}");
    assert_eq!(green.mode, Mode::Greenstick, "{green}");
    assert!(green.tension_left.unwrap() > 0.2, "{green}");
}

#[test]
fn along_the_grain_wood_is_crushed_and_twisted() {
    let crushed = outcome("pull", 14, |scene| {
        stick(scene);
        scene.clamp[1].key.clear();
        scene.clamp[1].velocity = [-0.005, 0.0, 0.0];
    });
    assert_eq!(crushed.mode, Mode::Compression, "{crushed}");
    let twisted = outcome("twist", 16, |scene| scene.duration = 0.34);
    assert_eq!(twisted.mode, Mode::Torsion, "{twisted}");
}
