//! Closed loops: cracks with known parameters are painted, measured, and drawn again from what was measured.

use super::*;
use crate::cracks::{CrackPlan, plan};
use crate::presets::Preset;
use greenstick_wood::noise;

/// Side of the pictures and radius of their sections, pixels, and shrinkages.
const SIDE: usize = 360;
const RADIUS: f64 = 150.0;
const SHRINKAGE: (f64, f64) = (0.06, 0.03);

/// Paints a section with rings, grain and the openings of `plan` on a grey background, each pixel from four points.
fn painted(plan: &CrackPlan, pith: [f64; 2]) -> SectionPhotograph {
    painted_with(plan, pith, |_, _| 1.0)
}

/// The same with wood whose brightness is multiplied by `shade` of the distance from the pith in radii and the direction in rad.
fn painted_with(
    plan: &CrackPlan,
    pith: [f64; 2],
    shade: impl Fn(f64, f64) -> f64,
) -> SectionPhotograph {
    let cracks: Vec<(Vec<[f64; 3]>, [f64; 4])> = (plan.cracks.iter().map(course))
        .map(|c| {
            let bounds = c
                .iter()
                .fold([f64::INFINITY, f64::INFINITY, -1.0, -1.0], |b, p| {
                    let r = p[2];
                    [
                        b[0].min(p[0] - r),
                        b[1].min(p[1] - r),
                        b[2].max(p[0] + r),
                        b[3].max(p[1] + r),
                    ]
                });
            (c, bounds)
        })
        .collect();
    let within = |(course, [left, low, right, high]): &(Vec<[f64; 3]>, [f64; 4]), x, y| {
        x > *left && x < *right && y > *low && y < *high && within(course, x, y)
    };
    let at = |x: f64, y: f64| -> [f64; 3] {
        let (dx, dy) = ((x - pith[0]) / RADIUS, (pith[1] - y) / RADIUS);
        let r = dx.hypot(dy);
        if r > 1.0 {
            return [0.8, 0.8, 0.82];
        }
        if cracks.iter().any(|c| within(c, dx, dy)) {
            return [0.05, 0.04, 0.03];
        }
        let ring = 1.0 - 0.35 * (r * 9.0).fract();
        let bark = if r > 0.95 { 0.4 } else { 1.0 };
        let shade = shade(r, dy.atan2(dx));
        [0.55, 0.38, 0.22].map(|c| c * ring * bark * shade)
    };
    let pixel = |i: usize| {
        let (x, y) = ((i % SIDE) as f64, (i / SIDE) as f64);
        let grain = 0.9 + 0.2 * noise::unit(5, i as i64, 0, 0);
        let mut sum = [0.0; 3];
        for k in 0..4 {
            let (u, v) = (f64::from(k % 2) / 2.0, f64::from(k / 2) / 2.0);
            let colour = at(x + u + 0.25, y + v + 0.25);
            (0..3).for_each(|c| sum[c] += colour[c] / 4.0);
        }
        sum.map(|c| (c * grain) as f32)
    };
    SectionPhotograph::new(SIDE, SIDE, (0..SIDE * SIDE).map(pixel).collect()).unwrap()
}

/// Points of a crack with half its width there, radii.
fn course(crack: &crate::cracks::PlannedCrack) -> Vec<[f64; 3]> {
    let points = crack.course.iter().zip(&crack.fractions);
    points
        .map(|(&(rho, phi), &t)| [rho * phi.cos(), rho * phi.sin(), 0.5 * crack.width(t, rho)])
        .collect()
}

fn within(course: &[[f64; 3]], x: f64, y: f64) -> bool {
    course.windows(2).any(|pair| {
        let [[ax, ay, aw], [bx, by, bw]] = [pair[0], pair[1]];
        let (dx, dy) = (bx - ax, by - ay);
        let t = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy);
        let t = t.clamp(0.0, 1.0);
        let off = (x - ax - dx * t).hypot(y - ay - dy * t);
        off < aw + (bw - aw) * t
    })
}

fn measured(photograph: &SectionPhotograph) -> MeasuredCracks {
    measure_cracks(photograph, &photograph.find_section().unwrap()).unwrap()
}

fn angle_between(a: f64, b: f64) -> f64 {
    ((a - b + 180.0).rem_euclid(360.0) - 180.0).abs()
}

/// Every planned crack that is wider than two pixels is measured, within 1.5° and 0.05 radii, its opening within a quarter.
fn assert_measured(plan: &CrackPlan, found: &MeasuredCracks, what: &str) -> usize {
    let mut compared = 0;
    for crack in &plan.cracks {
        let widest = course(crack).iter().map(|p| p[2]).fold(0.0, f64::max) * 2.0 * RADIUS;
        let (first, last) = (crack.course[0], crack.course[crack.course.len() - 1]);
        if widest < 2.0 || crack.kind != CrackKind::Radial {
            continue;
        }
        compared += 1;
        let weights = course(crack).into_iter().map(|p| p[2]);
        let (mut angle, mut sum) = (0.0, 0.0);
        for (place, weight) in crack.course.iter().zip(weights) {
            (angle, sum) = (angle + place.1.to_degrees() * weight, sum + weight);
        }
        let angle = angle / sum;
        let near = found.cracks.iter().filter(|c| c.kind == crack.kind);
        let nearest = near
            .min_by(|a, b| angle_between(a.angle, angle).total_cmp(&angle_between(b.angle, angle)));
        let nearest = nearest.unwrap_or_else(|| panic!("{what}: nothing at {angle}°"));
        let what = format!(
            "{what}: {angle:.1}°, {:.2} to {:.2}: {nearest:?}",
            first.0, last.0
        );
        assert!(angle_between(nearest.angle, angle) < 1.5, "{what}");
        assert!((nearest.begin - first.0).abs() < 0.05, "{what}");
        assert!((nearest.end - last.0).abs() < 0.05, "{what}");
        assert_eq!(nearest.open_at_bark, crack.open_at_bark, "{what}");
        let off = nearest.opening / (crack.shrinkage * crack.range) - 1.0;
        assert!(off.abs() < 0.25, "{what}: {off}");
    }
    compared
}

fn cracks_of(preset: &str) -> CrackParameters {
    let (mut face, mut cracks) = Default::default();
    Preset::find(preset)
        .unwrap()
        .apply(&mut face, &mut cracks)
        .unwrap();
    cracks
}

#[test]
fn single_cracks_are_measured_and_drawn_again_alike() {
    let mut parameters = cracks_of("fig20b");
    if let Crack::Radial(open) = &mut parameters.cracks[2] {
        (open.begin, open.end) = (0.3, 1.0);
    }
    let drawn = plan(&parameters, SHRINKAGE, 1);
    let first = measured(&painted(&drawn, [178.3, 181.9]));
    assert_eq!(first.cracks.len(), drawn.cracks.len(), "{:?}", first.cracks);
    assert_eq!(assert_measured(&drawn, &first, "drawn"), 3);
    // The crack along a ring, from 225° to 300° at 0.55 of the radius; its thin ends are lost among the grain.
    let ring = first.cracks.last().unwrap();
    assert_eq!(ring.kind, CrackKind::Tangential);
    assert!((ring.begin - 0.55).abs() < 0.02, "{ring:?}");
    assert!(
        angle_between(ring.angle, 225.0) < 12.0 && angle_between(ring.end, 300.0) < 12.0,
        "{ring:?}"
    );
    let off = ring.opening / (0.5 * SHRINKAGE.1) - 1.0;
    assert!(off.abs() < 0.25, "{ring:?}: {off}");
    let again = plan(&first.each(SHRINKAGE), SHRINKAGE, 1);
    let second = measured(&painted(&again, [178.3, 181.9]));
    assert_eq!(second.cracks.len(), first.cracks.len());
    assert_eq!(assert_measured(&again, &second, "drawn again"), 3);
    assert_eq!(assert_measured(&drawn, &second, "drawn and drawn again"), 3);
}

#[test]
fn groups_of_cracks_are_drawn_alike() {
    let parameters = cracks_of("fig21");
    let drawn = plan(&parameters, SHRINKAGE, 3);
    let first = measured(&painted(&drawn, [180.0, 180.0]));
    assert!(assert_measured(&drawn, &first, "fig21") >= 4);
    assert_eq!(first.groups.len(), 3);
    let large = &first.groups[0];
    assert_eq!(large.count, 4, "{:?}", first.groups);
    assert!((large.spacing - 90.0).abs() < 1.0 && large.angle_deviation < 0.3 * 90.0 / 2.0);
    assert!(large.length[0] > 0.7 && large.length[1] < 1.0, "{large:?}");
    let alike = plan(&first.alike(SHRINKAGE), SHRINKAGE, 9);
    let second = measured(&painted(&alike, [180.0, 180.0]));
    let count = |m: &MeasuredCracks| m.cracks.len() as f64;
    assert!(
        (count(&second) / count(&first) - 1.0).abs() < 0.25,
        "{} of {}",
        count(&second),
        count(&first)
    );
    let total = |m: &MeasuredCracks| m.cracks.iter().map(|c| c.width).sum::<f64>();
    assert!(
        (total(&second) / total(&first) - 1.0).abs() < 0.3,
        "{} of {}",
        total(&second),
        total(&first)
    );
}

#[test]
fn what_is_no_section_is_refused() {
    let flat = SectionPhotograph::new(60, 50, vec![[0.5; 3]; 3000]).unwrap();
    let message = flat.find_section().unwrap_err().to_string();
    assert!(message.contains("give its outline"), "{message}");
    let circle = PhotographedSection::circle([30.0, 25.0], 20.0);
    let message = measure_cracks(&flat, &circle).unwrap_err().to_string();
    assert!(message.contains("at least 40"), "{message}");
    let beside = PhotographedSection {
        pith: [200.0, 25.0],
        ..PhotographedSection::circle([30.0, 25.0], 90.0)
    };
    let message = measure_cracks(&flat, &beside).unwrap_err().to_string();
    assert!(message.contains("does not go around the pith"), "{message}");
    assert!(SectionPhotograph::new(2, 2, vec![[0.0; 3]; 3]).is_err());
    // Sound wood has no cracks.
    let sound = measured(&painted(&CrackPlan::default(), [180.0, 180.0]));
    assert!(sound.cracks.is_empty(), "{:?}", sound.cracks);
}

/// Brightness of 120 rays as wide as a pixel and a half, darker and lighter from cell to cell.
fn rays(r: f64, phi: f64) -> f64 {
    let place = (phi / std::f64::consts::TAU + 0.5) * 120.0;
    let ray = place.floor();
    let off = (place - ray - 0.5) / 120.0 * std::f64::consts::TAU * r;
    let cell = noise::unit(7, ray as i64, (r * 40.0) as i64, 0);
    if off.abs() * RADIUS < 0.75 && r < 0.93 {
        0.85 - 0.4 * cell
    } else {
        1.0
    }
}

#[test]
fn rays_are_no_cracks_and_hide_none_that_opens_more() {
    let pith = [178.3, 181.9];
    let none = measured(&painted_with(&CrackPlan::default(), pith, rays));
    assert!(none.cracks.is_empty(), "{:?}", none.cracks);
    assert!(none.is_texture && none.texture_lines > 20, "{none:?}");
    let drawn = plan(&cracks_of("fig20b"), SHRINKAGE, 1);
    let found = measured(&painted_with(&drawn, pith, rays));
    let radial = |m: &CrackPlan| {
        m.cracks
            .iter()
            .filter(|c| c.kind == CrackKind::Radial)
            .count()
    };
    let of_found = found.cracks.iter().filter(|c| c.kind == CrackKind::Radial);
    assert_eq!(of_found.count(), radial(&drawn), "{:?}", found.cracks);
    for crack in drawn.cracks.iter().filter(|c| c.kind == CrackKind::Radial) {
        let angle = crack.course[crack.course.len() / 2].1.to_degrees();
        let nearest = found.cracks.iter().map(|c| angle_between(c.angle, angle));
        assert!(
            nearest.fold(360.0, f64::min) < 2.0,
            "{angle}: {:?}",
            found.cracks
        );
    }
}
