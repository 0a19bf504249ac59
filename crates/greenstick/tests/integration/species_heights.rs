//! The height of a broken face that a species calls for is the height that is there.

use crate::support;
use greenstick::BreakSession;
use greenstick::built_in_branch;
use greenstick::fracture::recipe::apply_setting;
use greenstick::geometry::Context;

#[test]
fn a_face_is_as_high_as_its_species_says() {
    let mut session = BreakSession::new(built_in_branch());
    for (species, inclination) in [
        ("goldenrain tree", "0"),
        ("tree-of-heaven", "0"),
        ("tree-of-heaven", "10"),
    ] {
        for surface in ["smooth", "fibrous"] {
            let mut request = support::request(0.5, &Default::default());
            let settings = [
                format!("surface={surface}"),
                format!("species={species}"),
                format!("inclination={inclination}"),
            ];
            for setting in settings {
                apply_setting(&mut request.breaks[0].recipe, &setting).unwrap();
            }
            request.breaks[0].recipe.complete().unwrap();
            let stages = session.stages(&request, &Context::quiet()).unwrap();
            let wanted = stages.heights.relief.report.as_ref().unwrap().height_m;
            let surface_heights = &stages.heights.heights.surface.heights;
            let mut heights: Vec<f64> = surface_heights.iter().flatten().copied().collect();
            heights.sort_by(f64::total_cmp);
            let at = |share: f64| heights[(share * (heights.len() - 1) as f64) as usize];
            let found = at(0.95) - at(0.05);
            assert!(
                (found / wanted - 1.0).abs() < 0.01,
                "{species}, {surface}, {inclination}°: {found} m for {wanted} m"
            );
        }
    }
}

#[test]
fn the_report_says_where_the_corners_of_a_face_lie() {
    let mut session = BreakSession::new(built_in_branch());
    let mut request = support::request(0.5, &Default::default());
    for setting in ["surface=smooth", "species=Juniper, temple"] {
        apply_setting(&mut request.breaks[0].recipe, setting).unwrap();
    }
    request.breaks[0].recipe.complete().unwrap();
    let broken = session.broken(&request, &Context::quiet()).unwrap();
    let face = &broken.report.face;
    let [low, high] = face.percentiles_m;
    // The spikes of noise that is made so high reach far beyond the nine tenths that the species is about.
    assert!(face.range_m[0] < low && high < face.range_m[1], "{face:?}");
    let wanted = broken.report.species.as_ref().unwrap().height_m;
    let found = high - low;
    assert!(
        (found / wanted - 1.0).abs() < 0.01,
        "{found} m for {wanted} m"
    );
    let text = broken.report.to_string();
    assert!(text.contains("nine tenths of the corners from"), "{text}");
}
