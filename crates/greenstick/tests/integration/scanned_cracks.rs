//! Cracks in a stem that came from a scan lie on the boundaries of the rings that its scanned bark gives it, and on rays.

use crate::support::{pieces, request};
use glam::{DVec2, DVec3};
use greenstick::fracture::cracks::plan;
use greenstick::fracture::parameters::{BreakParameters, Crack, CrackKind, CrackParameters};
use greenstick::geometry::{Context, Mesh, PointCloud};
use greenstick::scanning::{ScanRequest, scan_to_scene};
use greenstick::schema::{Parameters, Value};
use greenstick::skin::cracks::crack_faces;
use greenstick::skin::prepared::PreparedStem;
use greenstick::wood::{noise, stem};
use greenstick::{BreakSession, formats::CloudFile};
use std::collections::BTreeSet;

const RINGS: u32 = 16;

/// A session with a scanned log of fluted, eccentric section, and where it is broken.
fn scanned() -> (BreakSession, stem::StemLocation) {
    let points = (0..40_000i64)
        .map(|i| {
            let chance = |k: u64| noise::unit(k, i, 0, 0);
            let angle = std::f64::consts::TAU * chance(1);
            let fluted = 1.0 + 0.05 * libm::cos(3.0 * angle) + 0.03 * libm::sin(2.0 * angle);
            let radius = 0.1 * fluted + 0.0005 * (chance(2) - 0.5);
            DVec3::new(
                radius * libm::cos(angle),
                radius * libm::sin(angle),
                1.5 * chance(3),
            )
        })
        .collect();
    let file = CloudFile {
        cloud: PointCloud {
            points,
            ..PointCloud::default()
        },
        origin: DVec3::ZERO,
        notes: Vec::new(),
    };
    let place = stem::StemLocation::Fraction(0.5);
    let context = Context::quiet();
    let made = scan_to_scene(&file, &place, &ScanRequest::default(), &context).unwrap();
    (BreakSession::new(made.scene), made.location)
}

fn crack(kind: CrackKind, values: &[(&str, f64)]) -> Crack {
    let mut crack = Crack::new(kind);
    for (key, value) in values {
        crack.set(key, &Value::Number(*value)).unwrap();
    }
    crack
}

/// Vertices of `cracked` that `plain` has not, as height over the place, ring coordinate and angle.
fn new_vertices(prepared: &PreparedStem, cracked: &Mesh, plain: &Mesh) -> Vec<(f64, f64, f64)> {
    let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
    let old: BTreeSet<_> = plain.positions.iter().map(bits).collect();
    let stem = &prepared.found.stem;
    let frame = stem.grain.axis().frame(stem.location);
    let fresh = cracked.positions.iter().filter(|p| !old.contains(&bits(p)));
    fresh
        .map(|p| {
            let d = *p - frame.origin;
            let (rho, angle) = stem
                .rings
                .address(DVec2::new(d.dot(frame.x), d.dot(frame.y)));
            (
                d.dot(frame.tangent),
                rho,
                angle.rem_euclid(std::f64::consts::TAU),
            )
        })
        .collect()
}

#[test]
fn cracks_of_a_scan_follow_its_rings_and_its_rays() {
    let (mut session, place) = scanned();
    let mut cracks = CrackParameters::default();
    cracks.settings.distortion = 0.0;
    for group in ["large.count", "medium.count", "small.count"] {
        cracks.settings.set_text(group, "0").unwrap();
    }
    // 0.66 is no boundary of 16 rings; the nearest is 11/16.
    let tangential = [
        ("ring", 0.66),
        ("begin", 30.0),
        ("end", 150.0),
        ("depth", 1.5),
    ];
    let radial = [
        ("angle", 240.0),
        ("begin", 0.3),
        ("end", 0.9),
        ("depth", 1.5),
        ("range", 20.0),
    ];
    cracks.cracks = vec![
        crack(CrackKind::Tangential, &tangential),
        crack(CrackKind::Radial, &radial),
    ];
    assert_eq!(cracks.follow_rings(RINGS), 1);
    assert_eq!(cracks.follow_rings(RINGS), 0);
    let plan = plan(&cracks, (0.06, 0.03), 1);
    let half_of = |kind: CrackKind| {
        let crack = plan.cracks.iter().find(|c| c.kind == kind).unwrap();
        let width = |i: usize| crack.width(crack.fractions[i], crack.course[i].0);
        (0..crack.fractions.len()).map(width).fold(0.0, f64::max) / 2.0
    };
    let mut p = BreakParameters::default();
    p.set_text("surface", "smooth").unwrap();
    p.set_text("rings", &RINGS.to_string()).unwrap();
    let mut request = request(0.5, &p);
    request.breaks[0].place = place;
    let stages = session.stages(&request, &Context::quiet()).unwrap();
    let (stem, inner) = (stages.stem.stem(), stages.inner_wood(&p));
    let heights = &stages.heights.heights;
    let [lower, _] = crack_faces(stem, &heights.surface, &plan, &inner, &Context::quiet()).unwrap();
    assert_eq!(lower.grooves.cracks, 2);
    let radius = stem.found.stem.radius;
    // Below all of the face there are only the cracks' walls.
    let below = heights.range.0 - 0.05 * radius;
    let cracked = lower.piece(stem, &inner, false);
    let walls = new_vertices(stem, &cracked, &pieces(&stages, &p)[0]);
    let walls: Vec<_> = walls.into_iter().filter(|w| w.0 < below).collect();
    let (on_ring, on_ray): (Vec<_>, Vec<_>) =
        walls.into_iter().partition(|w| w.2.to_degrees() < 200.0);
    assert!(
        on_ring.len() > 20 && on_ray.len() > 20,
        "{} {}",
        on_ring.len(),
        on_ray.len()
    );
    // The section is fluted, so that a circle, or the contour scaled, would leave the boundary by several times that.
    let ring = 11.0 / f64::from(RINGS);
    let allowed = half_of(CrackKind::Tangential) + 0.004;
    for (height, rho, angle) in &on_ring {
        assert!((rho - ring).abs() < allowed, "{rho} at {angle}, {height}");
    }
    let deepest = on_ring.iter().map(|w| w.0).fold(0.0, f64::min);
    for (height, rho, angle) in on_ring.iter().filter(|w| w.0 < 0.97 * deepest) {
        assert!((rho - ring).abs() < 0.004, "{rho} at {angle}, {height}");
    }
    for (height, rho, angle) in &on_ray {
        let off = (angle - 240f64.to_radians()) * rho;
        assert!(
            off.abs() < half_of(CrackKind::Radial) + 0.004,
            "{off} at {rho}, {height}"
        );
    }
}
