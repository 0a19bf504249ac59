//! Cracks' statistics from a picture of a sawn end whose cracks are known, and from micrographs, which have none.

use crate::support::{data::data, request, scene};
use greenstick::files::{read_photograph, read_text};
use greenstick::fracture::cracks::measure::{
    MeasuredCracks, PhotographedSection, SectionPhotograph, measure_cracks,
};
use greenstick::fracture::parameters::{BreakParameters, Crack, CrackEnd, CrackKind};
use greenstick::geometry::Context;
use greenstick::picture::{Ground, PictureOptions, View};

use greenstick::schema::{Parameters, Value};
use greenstick::wood::colour::RgbImage;
use greenstick::wood::primitive;
use greenstick::wood::rings::SectionFile;
use greenstick::{BreakSession, picture_of_break};

/// Shrinkage along the rings that opens the cracks.
const SHRINKAGE: f64 = 0.06;
/// Direction (degrees), beginning and end (radii), and range (degrees) of each crack; the lengths all differ.
const CRACKS: [[f64; 4]; 6] = [
    [10.0, 0.1, 1.0, 40.0],
    [75.0, 0.35, 0.95, 60.0],
    [130.0, 0.2, 0.7, 70.0],
    [190.0, 0.4, 0.8, 70.0],
    [255.0, 0.5, 0.8, 80.0],
    [310.0, 0.15, 0.9, 50.0],
];

/// The cracked end of a round log from straight above, as our own picture shows it.
fn drawn() -> SectionPhotograph {
    let mut face = BreakParameters::default();
    for (key, value) in [("surface", "smooth"), ("rings", "12"), ("sectors", "24")] {
        face.set_text(key, value).unwrap();
    }
    let mut request = request(0.5, &face);
    // The picture looks at the end where it has gone.
    request.breaks[0].separation = 0.1;
    let recipe = &mut request.breaks[0].recipe;
    recipe.cracks.settings.end = CrackEnd::Sawn;
    recipe.cracks.settings.distortion = 0.0;
    recipe.cracks.cracks = CRACKS
        .iter()
        .map(|[angle, begin, end, range]| {
            let mut crack = Crack::new(CrackKind::Radial);
            for (key, value) in [
                ("angle", *angle),
                ("begin", *begin),
                ("end", *end),
                ("range", *range),
                ("depth", 0.6),
                ("shrinkage", SHRINKAGE),
            ] {
                crack.set(key, &Value::Number(value)).unwrap();
            }
            crack
        })
        .collect();
    let mut session = BreakSession::new(scene(primitive::cylinder(0.05, 0.4, 96), 1.0));
    let broken = session.broken(&request, &Context::quiet()).unwrap();
    let options = PictureOptions {
        width: 720,
        height: 720,
        samples: 4,
        // What is measured lies before a plain backdrop.
        ground: Some(Ground::Plain),
        view: View::Direction {
            azimuth: 0.0,
            elevation: std::f64::consts::FRAC_PI_2,
        },
        ..PictureOptions::default()
    };
    let picture = picture_of_break(&broken, &options, &Context::quiet()).unwrap();
    SectionPhotograph::from(&RgbImage {
        width: picture.width,
        height: picture.height,
        rgb: picture.rgb,
    })
}

#[test]
fn a_picture_of_known_cracks_gives_their_statistics() {
    let photograph = drawn();
    let found = measure_cracks(&photograph, &photograph.find_section().unwrap()).unwrap();
    assert_eq!(found.cracks.len(), CRACKS.len(), "{:#?}", found.cracks);
    assert!(!found.is_texture, "{} lines", found.texture_lines);
    let longest_first = |mut lengths: Vec<(f64, f64, f64)>| {
        lengths.sort_by(|a, b| b.0.total_cmp(&a.0));
        lengths
    };
    let wanted = longest_first(
        CRACKS
            .iter()
            .map(|[angle, begin, end, range]| {
                // The opening rises to the middle and falls again, or rises to the bark; its width grows with the radius.
                let open = *end > 0.999;
                let width = |t: f64| {
                    let rise = if open { t } else { 1.0 - (2.0 * t - 1.0).abs() };
                    SHRINKAGE * range.to_radians() * rise * (begin + (end - begin) * t)
                };
                let widest = (0..=100).map(|k| width(f64::from(k) / 100.0));
                (end - begin, *angle, widest.fold(0.0, f64::max))
            })
            .collect(),
    );
    let seen: Vec<_> = (found.cracks.iter())
        .map(|c| (c.length(), c.angle, c.width))
        .collect();
    let seen = longest_first(seen);
    // The picture is turned about the pith by an angle of its own.
    let turned = (seen[0].1 - wanted[0].1).rem_euclid(360.0);
    for (seen, wanted) in seen.iter().zip(&wanted) {
        assert!(
            (seen.0 - wanted.0).abs() < 0.06,
            "length {seen:?} {wanted:?}"
        );
        let off = (seen.1 - wanted.1 - turned + 180.0).rem_euclid(360.0) - 180.0;
        assert!(off.abs() < 2.0, "angle {seen:?} {wanted:?}");
        let off = seen.2 / wanted.2 - 1.0;
        // Beside the crack that is open at the bark the end is drawn darker, as it shares its corner there with the bark.
        let is_open = wanted.1 == CRACKS[0][0];
        assert!(is_open || off.abs() < 0.25, "width {seen:?} {wanted:?}");
    }
    let counted: usize = found.groups.iter().map(|g| g.count).sum();
    assert_eq!(counted, CRACKS.len());
    assert_eq!(found.groups[0].open_at_bark, 1, "{:?}", found.groups);
}

/// What is measured in one of the micrographs of young stems, whose rays and cells are dark.
fn micrograph(name: &str) -> MeasuredCracks {
    let image = read_photograph(&data(&format!("{name}.jpg"))).unwrap();
    let text = read_text(&data(&format!("{name}.json"))).unwrap();
    let file = SectionFile::parse(&text).unwrap();
    let outline = file.outline();
    let section = PhotographedSection {
        pith: outline.pith.unwrap().to_array(),
        outline: outline.points.iter().map(|p| p.to_array()).collect(),
    };
    measure_cracks(&SectionPhotograph::from(&image), &section).unwrap()
}

#[test]
fn rays_and_cells_of_micrographs_are_no_cracks() {
    for name in ["young_stem_1", "young_stem_2"] {
        let found = micrograph(name);
        assert!(found.cracks.is_empty(), "{name}: {:#?}", found.cracks);
        assert!(found.is_texture && found.texture_lines > 20, "{name}");
    }
}
