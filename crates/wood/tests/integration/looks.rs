//! What wood and bark look like close up: hairline splits, marks of the saw, bark by genus.

use glam::{DVec2, DVec3};
use greenstick_geometry::Context;
use greenstick_wood::appearance::{StemAppearance, SurfacePoint, WoodAppearance, WoodPoint};
use greenstick_wood::primitive;
use greenstick_wood::rings::{StemAddress, StemRings};
use greenstick_wood::species::Species;
use greenstick_wood::stem::{Stem, StemOptions, find_stem};
use greenstick_wood::tissue::Proportions;

fn brightness(color: [f64; 3]) -> f64 {
    color[0] * 0.2126 + color[1] * 0.7152 + color[2] * 0.0722
}

#[test]
fn splits_are_dark_thin_lines_along_the_grain() {
    let wood = WoodAppearance::softwood();
    let rings = wood.usual_rings();
    let look = |x: f64, along: f64| {
        let across = DVec2::new(x, 0.002);
        let address = StemAddress {
            rho: across.length() / wood.radius,
            angle: across.y.atan2(across.x),
            across,
            along,
        };
        let point = WoodPoint {
            address,
            end_grain: 0.0,
            facing: DVec2::Y,
        };
        brightness(wood.surface_at(&rings, &point, 1e-5).color)
    };
    let step = 2e-5;
    let is_dark = |i: i32, along: f64| {
        let at = |i: i32| look(0.006 + f64::from(i) * step, along);
        // Against what lies half a millimetre to either side.
        at(i) < 0.5 * at(i - 25).min(at(i + 25))
    };
    let (mut lines, mut go_on, mut points) = (0, 0, 0);
    for level in 0..25 {
        let along = f64::from(level) * 0.031;
        let mut last = -100;
        for i in 0..900 {
            points += 1;
            if is_dark(i, along) && i - last > 10 {
                last = i;
                lines += 1;
                // A millimetre further it is still there, a few hundredths to the side at most.
                go_on += usize::from((i - 8..=i + 8).any(|i| is_dark(i, along + 1e-3)));
            }
        }
    }
    assert!(lines >= 10 && lines * 30 < points, "{lines} of {points}");
    assert!(5 * go_on >= 4 * lines, "{go_on} of {lines}");
}

fn cylinder() -> Stem {
    let mesh = primitive::cylinder(0.05, 1.0, 48);
    let options = StemOptions::default();
    let found = find_stem(
        &[mesh],
        &"0.5".parse().unwrap(),
        &options,
        &Context::quiet(),
    );
    found.unwrap().stem
}

fn appearance(stem: &Stem, species: Option<&str>) -> StemAppearance {
    let species = species.map(|name| Species::find(name).unwrap());
    let wood = WoodAppearance::of_stem(stem, &Proportions::USUAL, 5, species, 0.95);
    let rings = wood.usual_rings();
    StemAppearance::new(stem, wood, StemRings::new(rings))
}

#[test]
fn an_end_shows_the_saw_and_the_inside_does_not() {
    let stem = cylinder();
    let look = appearance(&stem, None);
    // A face straight across the grain, at the end and in the middle of the stem.
    let slope = |along: f64, radius: f64, inside: bool| {
        let grain = DVec3::new(radius, 0.3 * radius, along);
        let frame = stem.grain.axis().frame(along);
        let point = SurfacePoint {
            position: frame.origin,
            normal: frame.tangent,
            geometric_normal: frame.tangent,
            grain: Some(grain),
            moved: false,
            grain_gradients: None,
            footprint: 1e-4,
        };
        match inside {
            true => look.wood_at(&stem, grain, &point).surface.slope,
            false => look.skin_at(&stem, &point).surface.slope,
        }
    };
    let places = (0..300).map(|i| 0.01 + f64::from(i) * 1e-4);
    // In the middle of the stem the two differ by what the saw left.
    let own: Vec<DVec3> = (places.clone())
        .map(|radius| slope(0.5, radius, false) - slope(0.5, radius, true))
        .collect();
    let steep = own.iter().map(|s| s.length()).sum::<f64>() / own.len() as f64;
    assert!(steep > 0.05 && own.iter().all(|s| s.z == 0.0), "{steep}");
    // Arcs a millimetre or two apart.
    let turns = (own.windows(2))
        .filter(|w| (w[0].x > 0.0) != (w[1].x > 0.0))
        .count();
    assert!((12..150).contains(&turns), "{turns}");
    // An end that was sawn off for its cracks shows the wood inside, with the same marks.
    for radius in places {
        let end = stem.length;
        assert_eq!(slope(end, radius, false), slope(end, radius, true));
    }
}

#[test]
fn bark_follows_the_genus_and_the_size() {
    let stem = cylinder();
    let depth = |name| appearance(&stem, Some(name)).bark.furrow_depth;
    assert!(depth("Fagus sylvatica") < 0.2 * depth("Quercus robur"));
    let lenticels = |name| appearance(&stem, Some(name)).bark.lenticels;
    assert!(lenticels("yellow birch") > 0.9 && lenticels("white oak") == 0.0);
    // Strings are long, plates short.
    let stretch = |name| appearance(&stem, Some(name)).bark.furrow_stretch;
    assert!(stretch("Thuja plicata") > 4.0 * stretch("Pinus strobus"));
    let thick = Stem {
        radius: 0.2,
        ..stem.clone()
    };
    let width = |stem: &Stem| appearance(stem, Some("Quercus robur")).bark.furrow_width;
    assert!(width(&thick) > 2.0 * width(&stem));
}
