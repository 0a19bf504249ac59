//! Courses and openings of planned cracks against the formulas.

use greenstick_fracture::cracks::{CrackPlan, plan, relative_depth, relative_opening};
use greenstick_fracture::parameters::{Crack, CrackKind, CrackParameters};
use greenstick_schema::{Parameters, Value};

fn single(kind: CrackKind, settings: &[(&str, f64)]) -> CrackPlan {
    let mut parameters = CrackParameters::default();
    parameters.settings.distortion = 0.0;
    let mut crack = Crack::new(kind);
    for (key, value) in settings {
        crack.set(key, &Value::Number(*value)).unwrap();
    }
    parameters.cracks.push(crack);
    plan(&parameters, (0.06, 0.03), 7)
}

#[test]
fn cracks_are_widest_in_the_middle_and_closed_at_their_ends() {
    assert_eq!(
        [0.0, 0.5, 1.0].map(|t| relative_opening(t, false)),
        [0.0, 1.0, 0.0]
    );
    assert_eq!(
        [0.0, 0.5, 1.0].map(|t| relative_opening(t, true)),
        [0.0, 0.5, 1.0]
    );
    assert_eq!([relative_depth(0.0), relative_depth(1.0)], [0.0, 1.0]);
    let plan = single(
        CrackKind::Radial,
        &[("begin", 0.2), ("end", 0.8), ("range", 60.0)],
    );
    let crack = &plan.cracks[0];
    assert!(!crack.open_at_bark);
    // Strain 0.06 at the flanks falling to 0 at 60° on both sides, at half the radius.
    let expected = 0.06 * std::f64::consts::FRAC_PI_3 * 0.5;
    assert!((crack.width(0.5, 0.5) - expected).abs() < 1e-15);
    assert!(single(CrackKind::Radial, &[("end", 1.0)]).cracks[0].open_at_bark);
}

#[test]
fn a_tangential_crack_runs_on_past_a_full_turn() {
    let settings = [("begin", 330.0), ("end", 40.0), ("ring", 0.5)];
    let plan = single(CrackKind::Tangential, &settings);
    let course = &plan.cracks[0].course;
    let (first, last) = (
        course[0].1.to_degrees(),
        course[course.len() - 1].1.to_degrees(),
    );
    assert!((first - 330.0).abs() < 1e-9 && (last - 400.0).abs() < 1e-9);
    assert!((plan.cracks[0].width(0.5, 0.9) - 0.03 * 0.15).abs() < 1e-15);
}

#[test]
fn cracks_that_would_cross_are_shortened_or_left_out() {
    let mut parameters = CrackParameters::default();
    parameters.settings.distortion = 0.0;
    for (kind, settings) in [
        (
            CrackKind::Tangential,
            [("begin", 300.0), ("end", 60.0), ("ring", 0.5)],
        ),
        (
            CrackKind::Radial,
            [("angle", 10.0), ("begin", 0.1), ("end", 0.9)],
        ),
        (
            CrackKind::Radial,
            [("angle", 30.0), ("begin", 0.45), ("end", 0.55)],
        ),
    ] {
        let mut crack = Crack::new(kind);
        for (key, value) in settings {
            crack.set(key, &Value::Number(value)).unwrap();
        }
        parameters.cracks.push(crack);
    }
    let plan = plan(&parameters, (0.06, 0.03), 7);
    assert_eq!((plan.cracks.len(), plan.shortened), (2, 1));
    assert_eq!(plan.skipped, 1);
    assert!(plan.cracks[1].course[0].0 > 0.5);
}
