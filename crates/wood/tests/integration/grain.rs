//! The grain of wood as pictures show it: fine and sharp across, long along, no more than a tint from afar; and what faces show that
//! bark came off.

use glam::{DQuat, DVec2, DVec3, EulerRot};
use greenstick_geometry::Context;
use greenstick_wood::appearance::{
    BarkAppearance, BarkPoint, StemAppearance, SurfacePoint, WoodAppearance, WoodPoint,
};
use greenstick_wood::primitive;
use greenstick_wood::rings::{RingPosition, RingSource, StemAddress, StemRings};
use greenstick_wood::stem::{Stem, StemOptions, find_stem};
use greenstick_wood::tissue::Proportions;
use std::f64::consts::{FRAC_PI_2, PI};

/// Wood without rings: what is left is grain.
struct NoRings;

impl RingSource for NoRings {
    fn ring_count(&self) -> usize {
        0
    }

    fn ring_at(&self, _: &StemAddress) -> Option<RingPosition> {
        None
    }
}

/// Sapwood alone.
fn sapwood() -> WoodAppearance {
    WoodAppearance {
        heartwood: 0.0,
        pith: 0.0,
        phloem: 99.0,
        cork: 99.0,
        ray_contrast: 0.0,
        ..WoodAppearance::softwood()
    }
}

fn brightness(color: [f64; 3]) -> f64 {
    color[0] * 0.2126 + color[1] * 0.7152 + color[2] * 0.0722
}

/// The brightness of a face along the grain at a place across and along it, m.
fn grain(wood: &WoodAppearance, x: f64, along: f64, footprint: f64) -> f64 {
    let across = DVec2::new(0.012 + x, 0.006);
    let point = WoodPoint {
        address: StemAddress {
            rho: across.length() / wood.radius,
            angle: across.y.atan2(across.x),
            across,
            along,
        },
        end_grain: 0.0,
        facing: DVec2::Y,
    };
    brightness(wood.surface_at(&NoRings, &point, footprint).color)
}

/// The brightness along lines across the grain, one for each of several heights.
fn lines(wood: &WoodAppearance, step: f64, footprint: f64) -> Vec<Vec<f64>> {
    let line = |k: i32| {
        (0..400).map(move |i| grain(wood, f64::from(i) * step, f64::from(k) * 0.013, footprint))
    };
    (0..60).map(|k| line(k).collect()).collect()
}

/// Mean and standard deviation, relative to the mean.
fn spread(values: &[Vec<f64>]) -> (f64, f64) {
    let all: Vec<f64> = values.iter().flatten().copied().collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let square = all.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / all.len() as f64;
    (mean, square.sqrt() / mean)
}

/// How often a row of values crosses its mean, per step.
fn crossings(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let turns = values
        .windows(2)
        .filter(|w| (w[0] > mean) != (w[1] > mean))
        .count();
    turns as f64 / (values.len() - 1) as f64
}

#[test]
fn grain_is_finer_than_a_millimetre_across_and_long_along() {
    let wood = sapwood();
    let step = 0.02e-3;
    let across: f64 = lines(&wood, step, step)
        .iter()
        .map(|l| crossings(l))
        .sum::<f64>()
        / 60.0;
    let along: f64 = (0..60)
        .map(|k| {
            let x = f64::from(k) * 0.13e-3;
            let line: Vec<f64> = (0..400)
                .map(|i| grain(&wood, x, f64::from(i) * 10.0 * step, step))
                .collect();
            crossings(&line)
        })
        .sum::<f64>()
        / 60.0;
    // Per metre.
    let (across, along) = (across / step, along / (10.0 * step));
    assert!(across > 1500.0, "{across} crossings per metre");
    assert!(across > 8.0 * along, "across {across}, along {along}");
}

#[test]
fn grain_has_edges() {
    // A tenth of the steps holds a large part of all change: facets, not waves. Of waves it would hold a sixth.
    let mut steps: Vec<f64> = lines(&sapwood(), 0.02e-3, 0.02e-3)
        .iter()
        .flat_map(|l| {
            l.windows(2)
                .map(|w| (w[1] - w[0]).abs())
                .collect::<Vec<_>>()
        })
        .collect();
    steps.sort_by(f64::total_cmp);
    let all: f64 = steps.iter().sum();
    let largest: f64 = steps[steps.len() * 9 / 10..].iter().sum();
    assert!(largest > 0.33 * all, "{}", largest / all);
}

#[test]
fn grain_fades_to_the_same_mean_from_afar() {
    let wood = sapwood();
    // Steps of the size of a pixel: what they pick up would be seen as noise.
    let (near, rough) = spread(&lines(&wood, 0.05e-3, 0.02e-3));
    assert!(rough > 0.12, "{rough}");
    let mut last = rough;
    for (footprint, most) in [
        (0.25e-3f64, 0.22),
        (0.6e-3, 0.16),
        (1.5e-3, 0.10),
        (8e-3, 0.005),
    ] {
        let (mean, rough) = spread(&lines(&wood, footprint.min(1e-3), footprint));
        assert!(rough < most && rough < last, "{rough} over {footprint} m");
        assert!((mean / near - 1.0).abs() < 0.03, "{mean} is not {near}");
        last = rough;
    }
    // The colour of the species is the mean, less the splits.
    let sapwood = brightness(wood.sapwood_color);
    assert!((near / sapwood - 1.0).abs() < 0.06, "{near} of {sapwood}");
}

#[test]
fn bark_does_not_glitter_from_afar() {
    for radius in [0.02, 0.056, 0.2] {
        let bark = match radius > 0.06 {
            true => BarkAppearance::furrowed(radius),
            false => BarkAppearance::young(radius),
        };
        // The relief that is left turns the normal of one pixel against the next by no more than it can show as a form.
        for pixels in [2.0, 4.0, 8.0] {
            let pixel = bark.furrow_width / pixels;
            let slope = |i: i32, j: i32| {
                let at = BarkPoint {
                    angle: f64::from(i) * pixel / radius,
                    along: f64::from(j) * pixel,
                    radius,
                };
                bark.surface_at(&at, pixel).slope.z
            };
            let (mut turned, mut steep, mut number) = (0.0, 0.0, 0.0);
            for i in 0..60 {
                for j in 0..60 {
                    turned += (slope(i, j + 1) - slope(i, j)).powi(2);
                    steep += slope(i, j).powi(2);
                    number += 1.0;
                }
            }
            let (turned, steep) = (f64::sqrt(turned / number), f64::sqrt(steep / number));
            assert!(
                turned < 0.25,
                "{turned} of {steep} at {pixels} pixels, {radius} m"
            );
        }
    }
}

/// A stem, what it looks like, and a point in its inner bark.
fn stem_with_bark() -> (Stem, StemAppearance) {
    let mesh = primitive::cylinder(0.05, 1.0, 48);
    let at = "0.5".parse().unwrap();
    let found = find_stem(&[mesh], &at, &StemOptions::default(), &Context::quiet()).unwrap();
    let wood = WoodAppearance::of_stem(&found.stem, &Proportions::USUAL, 5, None, 0.95);
    let rings = StemRings::new(wood.usual_rings());
    let look = StemAppearance::new(&found.stem, wood, rings);
    (found.stem, look)
}

/// The surface at a place of the grain, facing a direction across it, where it grew; and the gradients of the grain along it.
fn surface_point(stem: &Stem, grain: DVec3, facing: DVec2) -> (SurfacePoint, [DVec3; 3]) {
    let frame = stem.grain.axis().frame(grain.z);
    let normal = frame.x * facing.x + frame.y * facing.y;
    let point = SurfacePoint {
        position: frame.origin + frame.x * grain.x + frame.y * grain.y,
        normal,
        geometric_normal: normal,
        grain: Some(grain),
        moved: false,
        grain_gradients: None,
        footprint: 1e-4,
    };
    let along = [frame.x, frame.y, frame.tangent].map(|d| d - normal * normal.dot(d));
    (point, along)
}

/// Across a sawn end inner bark is here wide and there narrow, and tan next to the wood, red-brown next to the outer bark.
#[test]
fn inner_bark_is_of_no_even_width() {
    let (stem, look) = stem_with_bark();
    let wood = &look.wood;
    let colour = |angle: f64, rho: f64| {
        let across = DVec2::from_angle(angle) * (rho * 0.05);
        let address = StemAddress {
            rho,
            angle,
            across,
            along: 0.3,
        };
        let at = WoodPoint {
            address,
            end_grain: 1.0,
            facing: DVec2::ZERO,
        };
        DVec3::from_array(wood.surface_at(&wood.usual_rings(), &at, 1e-4).color)
    };
    assert!(stem.kind.has_bark());
    let (mut widths, mut inner, mut outer) = (Vec::new(), DVec3::ZERO, DVec3::ZERO);
    for i in 0..180 {
        let angle = f64::from(i) * 0.035;
        // The cambium is the palest of a row outwards; the outer bark begins where it is as dark as cork.
        let rho = |k: usize| wood.phloem - 0.05 + (1.05 - wood.phloem) * k as f64 / 400.0;
        let row: Vec<f64> = (0..400)
            .map(|k| brightness(colour(angle, rho(k)).to_array()))
            .collect();
        let start = (0..400).max_by(|&j, &k| row[j].total_cmp(&row[k])).unwrap();
        let cork = 1.5 * brightness(wood.cork_color);
        let end = (start..400).find(|&k| row[k] < cork).unwrap_or(399);
        widths.push(rho(end) - rho(start));
        let thick = wood.drawn_inner_bark_end() - wood.phloem;
        inner += colour(angle, wood.phloem + 0.3 * thick);
        outer += colour(angle, wood.phloem + 0.8 * thick);
    }
    let mean = widths.iter().sum::<f64>() / widths.len() as f64;
    let scatter = widths.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / widths.len() as f64;
    assert!(scatter.sqrt() > 0.25 * mean, "{} of {mean}", scatter.sqrt());
    let red = |c: DVec3| c.x / c.z;
    assert!(red(outer) > 1.2 * red(inner), "{inner} {outer}");
}

#[test]
fn skin_that_moved_is_bark_and_that_of_a_bore_is_not() {
    let (stem, look) = stem_with_bark();
    let (mut bark, mut bore) = (0.0, 0.0);
    for i in 0..300 {
        let angle = f64::from(i) * 0.0211;
        for (radius, inwards) in [(0.05, 1.0), (0.03, -1.0)] {
            let grain = (DVec2::from_angle(angle) * radius).extend(0.3 + f64::from(i) * 1e-3);
            let (grown, along) = surface_point(&stem, grain, DVec2::from_angle(angle) * inwards);
            let turn = DQuat::from_euler(EulerRot::XYZ, 0.7, angle, -1.1);
            let moved = SurfacePoint {
                position: turn * grown.position,
                normal: turn * grown.normal,
                geometric_normal: turn * grown.normal,
                moved: true,
                grain_gradients: Some(along.map(|gradient| turn * gradient)),
                ..grown
            };
            let [a, b] = [grown, moved]
                .map(|point| DVec3::from_array(look.skin_at(&stem, &point).surface.color));
            assert!(a.distance(b) < 1e-6, "{a} is not {b} at {grain}");
            match inwards > 0.0 {
                true => bark += brightness(b.to_array()),
                false => bore += brightness(b.to_array()),
            }
        }
    }
    assert!(bore > 1.5 * bark, "{bore}, {bark}");
}

#[test]
fn bark_comes_off_at_the_cambium() {
    let (stem, look) = stem_with_bark();
    let wood = &look.wood;
    let radius = 0.5 * (wood.phloem + wood.cork) * 0.05;
    // Faces in the inner bark that look outwards, and others that look sideways.
    let mean_at = |radius: f64, turn: f64| -> f64 {
        let colour = |i: i32| {
            let angle = f64::from(i) * 0.0157;
            let grain = (DVec2::from_angle(angle) * radius).extend(0.3 + f64::from(i) * 1e-3);
            let (point, along_face) = surface_point(&stem, grain, DVec2::from_angle(angle + turn));
            let shown = look.wood_at(&stem, grain, &point);
            // Wood that moved without being deformed looks the same, by the rise of its coordinates along the face.
            let moved = SurfacePoint {
                moved: true,
                grain_gradients: Some(along_face),
                ..point
            };
            let again = look.wood_at(&stem, grain, &moved);
            let [a, b] = [shown, again].map(|s| DVec3::from_array(s.surface.color));
            assert!(a.distance(b) < 1e-6, "{a} is not {b}");
            brightness(shown.surface.color)
        };
        (0..400).map(colour).sum::<f64>() / 400.0
    };
    let [outwards, sideways, inwards] = [0.0, FRAC_PI_2, PI].map(|turn| mean_at(radius, turn));
    // The side of a plate of dead bark is bark, wherever it looks.
    let outer = 0.05 * (wood.cork + 0.6 * (1.0 - wood.cork));
    let [side, front] = [FRAC_PI_2, 0.0].map(|turn| mean_at(outer, turn));
    assert!((front / side - 1.0).abs() < 0.1, "{front}, {side}");
    // Torn inner bark is bark, wherever it looks.
    let sapwood = brightness(wood.sapwood_color);
    for (name, mean) in [("outwards", outwards), ("inwards", inwards)] {
        assert!(
            (mean / sideways - 1.0).abs() < 0.1,
            "{name} {mean}, {sideways}"
        );
    }
    assert!(outwards < 0.6 * sapwood, "{outwards} of {sapwood}");
    // At the cambium, wood that bark came off is bare but for strings, beside a tear through both.
    let cambium = 0.05 * (wood.phloem + 0.004);
    let [bare, torn] = [0.0, FRAC_PI_2].map(|turn| mean_at(cambium, turn));
    assert!(bare > torn, "{bare}, {torn}");
    assert!(
        bare < 0.97 * sapwood && bare > 0.6 * sapwood,
        "{bare} of {sapwood}"
    );
}

/// Where bark came off at the cambium, inner bark stays in strings of many lengths beside bare wood, and all of it farther out.
#[test]
fn inner_bark_tears_off_in_strings() {
    let (stem, look) = stem_with_bark();
    let wood = &look.wood;
    let bark_end = wood.drawn_inner_bark_end();
    // Lengths of strings and of bare places along the grain, m, so far from the cambium, in ring coordinates.
    let lengths = |from_cambium: f64| {
        const STEP: f64 = 0.5e-3;
        let radius = 0.05 * (wood.phloem + from_cambium);
        let mut runs: [Vec<f64>; 2] = Default::default();
        for line in 0..120 {
            let out = DVec2::from_angle(0.0523 * f64::from(line));
            let (mut last, mut length) = (false, 0.0);
            for i in 0..400 {
                let grain = (out * radius).extend(0.3 + STEP * f64::from(i));
                let (point, _) = surface_point(&stem, grain, out);
                let shown = brightness(look.wood_at(&stem, grain, &point).surface.color);
                let is_bark = shown < 0.72 * brightness(wood.sapwood_color);
                if is_bark != last && i > 0 {
                    runs[usize::from(last)].push(length);
                    length = 0.0;
                }
                (last, length) = (is_bark, length + STEP);
            }
            runs[usize::from(last)].push(length);
        }
        runs
    };
    let share = |[bare, bark]: &[Vec<f64>; 2]| {
        let [bare, bark] = [bare, bark].map(|runs| runs.iter().sum::<f64>());
        bark / (bare + bark)
    };
    let [within, at_cambium] = [0.0, 0.004].map(lengths);
    let middle = lengths(0.5 * (bark_end - wood.phloem));
    assert!(share(&middle) > 0.95, "{}", share(&middle));
    assert!(
        (0.2..0.9).contains(&share(&at_cambium)),
        "{}",
        share(&at_cambium)
    );
    assert!(
        share(&at_cambium) > 1.4 * share(&within),
        "{}",
        share(&within)
    );
    for mut runs in at_cambium {
        runs.sort_unstable_by(f64::total_cmp);
        let (short, long) = (runs[runs.len() / 4], runs[runs.len() * 9 / 10]);
        assert!(long > 4.0 * short && long > 6e-3, "{short} {long}");
    }
}
