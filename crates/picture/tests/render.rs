//! Pictures: the same bits with any number of threads, their content, and invalid input.

use glam::{DAffine3, DVec3};
use greenstick_geometry::{Attribute, CancelToken, Context, Mesh};
use greenstick_picture::{
    CameraPlacement, Ground, Item, Picture, PictureError, PictureOptions, PlainShader, Sphere,
    View, render,
};

/// A unit cube around the origin with vertex colours, red at the top and blue at the bottom.
fn cube() -> Mesh {
    let positions: Vec<DVec3> = (0..8)
        .map(|i| {
            DVec3::from_array([i & 1, i >> 1 & 1, i >> 2 & 1].map(f64::from)) - DVec3::splat(0.5)
        })
        .collect();
    let colors = positions
        .iter()
        .flat_map(|p| {
            if p.y > 0.0 {
                [0.8, 0.05, 0.05]
            } else {
                [0.05, 0.05, 0.8]
            }
        })
        .collect();
    let mut mesh = Mesh {
        positions,
        triangles: vec![
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ],
        ..Mesh::default()
    };
    mesh.attributes.insert(
        "COLOR_0".to_owned(),
        Attribute {
            width: 3,
            data: colors,
        },
    );
    mesh
}

fn render_cube(options: &PictureOptions) -> Result<Picture, PictureError> {
    let mesh = cube();
    let shader = PlainShader::uniform([1.0; 3]);
    let items = [Item {
        mesh: &mesh,
        transform: DAffine3::IDENTITY,
        shader: &shader,
    }];
    render(&items, options, &Context::quiet())
}

fn small() -> PictureOptions {
    PictureOptions {
        width: 64,
        height: 48,
        samples: 8,
        ..PictureOptions::default()
    }
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| render_cube(&small()).unwrap())
    };
    let one = with(1);
    for threads in [2, 5] {
        assert_eq!(one, with(threads));
    }
}

#[test]
fn colours_and_shadows_appear_in_their_places() {
    // Perpendicular to a face, which fills the centre, red above blue.
    let view = View::Direction {
        azimuth: 0.0,
        elevation: 0.0,
    };
    let picture = render_cube(&PictureOptions {
        view,
        floor: false,
        ..small()
    })
    .unwrap();
    let at = |x: usize, y: usize| {
        let p = &picture.rgb[(y * 64 + x) * 3..][..3];
        [p[0], p[1], p[2]].map(i32::from)
    };
    let (upper, lower, corner) = (at(32, 8), at(32, 40), at(1, 1));
    assert!(upper[0] > upper[2] + 60, "upper {upper:?}");
    assert!(lower[2] > lower[0] + 60, "lower {lower:?}");
    assert!(
        corner
            .iter()
            .all(|&c| (c - corner[0]).abs() < 12 && c > 100),
        "corner {corner:?}"
    );
    // The floor is darker under the cube and unchanged far from it.
    let view = View::Direction {
        azimuth: 0.4,
        elevation: 0.4,
    };
    let with = render_cube(&PictureOptions { view, ..small() }).unwrap();
    let without = render_cube(&PictureOptions {
        view,
        floor: false,
        ..small()
    })
    .unwrap();
    let darker = |x: usize, y: usize| {
        i32::from(without.rgb[(y * 64 + x) * 3]) - i32::from(with.rgb[(y * 64 + x) * 3])
    };
    let darkest = (0..48)
        .flat_map(|y| (0..64).map(move |x| (x, y)))
        .map(|(x, y)| darker(x, y))
        .max();
    assert!(darkest > Some(40), "shadow {darkest:?}");
    assert!(darker(1, 1).abs() <= 2);
}

#[test]
fn the_floor_is_dark_where_something_stands_on_it() {
    let view = View::Direction {
        azimuth: 0.0,
        elevation: 0.5,
    };
    let with = |floor| {
        render_cube(&PictureOptions {
            width: 320,
            height: 240,
            samples: 64,
            floor,
            view,
            ..PictureOptions::default()
        })
        .unwrap()
    };
    let [without, with] = [false, true].map(with);
    let red = |picture: &Picture, x: usize, y: usize| i32::from(picture.rgb[(y * 320 + x) * 3]);
    // In front of the side that faces the key light: darkest next to the cube, less so farther away.
    let darker = |x: usize| red(&without, x, 190) - red(&with, x, 190);
    let [near, aside, far] = [70, 40, 4].map(darker);
    assert!(near >= 13, "{near}");
    assert!(
        near > aside && aside > far && 3 * far <= 2 * near,
        "{near}, {aside}, {far}"
    );
}

/// The root of the mean square of the differences of two pictures, of 255.
fn difference(a: &Picture, b: &Picture) -> f64 {
    let squares = a.rgb.iter().zip(&b.rgb).map(|(a, b)| {
        let d = f64::from(*a) - f64::from(*b);
        d * d
    });
    (squares.sum::<f64>() / a.rgb.len() as f64).sqrt()
}

#[test]
fn few_samples_come_near_to_many() {
    let view = View::Direction {
        azimuth: 0.4,
        elevation: 0.4,
    };
    let with = |samples, draft| {
        render_cube(&PictureOptions {
            width: 160,
            height: 120,
            samples,
            draft,
            view,
            ..PictureOptions::default()
        })
        .unwrap()
    };
    let reference = with(512, false);
    let usual = difference(&with(16, false), &reference);
    let few = difference(&with(4, false), &reference);
    let draft = difference(&with(16, true), &reference);
    assert!(usual < 2.0, "16 samples differ by {usual}");
    assert!(usual < few && few < 3.5, "4 samples differ by {few}");
    assert!(few < draft && draft < 8.0, "a draft differs by {draft}");
}

#[test]
fn a_png_file_contains_the_pixels() {
    let picture = render_cube(&small()).unwrap();
    let bytes = picture.png();
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
        .read_info()
        .unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height, pixels), (64, 48, picture.rgb));
}

#[test]
fn invalid_options_are_refused() {
    for (width, height) in [(0, 48), (64, 0), (16_385, 48)] {
        let refused = render_cube(&PictureOptions {
            width,
            height,
            ..small()
        });
        assert_eq!(refused, Err(PictureError::Size { width, height }));
    }
    assert_eq!(
        render_cube(&PictureOptions {
            samples: 0,
            ..small()
        }),
        Err(PictureError::Samples { samples: 0 })
    );
    let tilted = View::Direction {
        azimuth: 0.0,
        elevation: 2.0,
    };
    assert!(matches!(
        render_cube(&PictureOptions {
            view: tilted,
            ..small()
        }),
        Err(PictureError::View(_))
    ));
    assert!(matches!(
        render_cube(&PictureOptions {
            zoom: Some(Sphere {
                centre: DVec3::ZERO,
                radius: 0.0,
            }),
            ..small()
        }),
        Err(PictureError::View(_))
    ));
}

#[test]
fn invalid_items_are_refused() {
    let quiet = Context::quiet();
    assert_eq!(
        render(&[], &small(), &quiet),
        Err(PictureError::Empty { items: 0 })
    );
    let shader = PlainShader::uniform([0.5; 3]);
    let shot = |mesh: &Mesh| {
        render(
            &[Item {
                mesh,
                transform: DAffine3::IDENTITY,
                shader: &shader,
            }],
            &small(),
            &quiet,
        )
    };
    let mut mesh = cube();
    mesh.positions[3].y = f64::NAN;
    assert!(matches!(
        shot(&mesh),
        Err(PictureError::Position {
            item: 0,
            vertex: 3,
            ..
        })
    ));
    let mut mesh = cube();
    mesh.triangles[5][1] = 8;
    let refused = PictureError::Vertex {
        item: 0,
        triangle: 5,
        vertex: 8,
        vertices: 8,
    };
    assert_eq!(shot(&mesh), Err(refused));
    // Three coincident vertices have no extent, but are a triangle.
    let point = Mesh {
        positions: vec![DVec3::ONE; 3],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    };
    assert!(shot(&point).is_ok());
}

#[test]
fn rendering_reports_progress_and_can_be_cancelled() {
    let token = CancelToken::default();
    let token_of_caller = token.clone();
    let context = Context::new(token, move |progress| {
        if progress.overall > 0.4 {
            token_of_caller.cancel();
        }
    });
    let mesh = cube();
    let shader = PlainShader::uniform([1.0; 3]);
    let items = [Item {
        mesh: &mesh,
        transform: DAffine3::IDENTITY,
        shader: &shader,
    }];
    let stopped = render(&items, &small(), &context);
    assert!(matches!(stopped, Err(PictureError::Cancelled(_))));
}

#[test]
fn a_coin_has_the_size_of_a_euro() {
    // A slab of 6 cm seen from straight above, once with a coin in front of it.
    let mesh = cube();
    let shader = PlainShader::uniform([0.02; 3]);
    let items = [Item {
        mesh: &mesh,
        transform: DAffine3::from_scale(DVec3::new(0.06, 0.002, 0.06)),
        shader: &shader,
    }];
    let with = |coin: bool| {
        let options = PictureOptions {
            width: 240,
            height: 240,
            view: View::Direction {
                azimuth: 0.0,
                elevation: std::f64::consts::FRAC_PI_2,
            },
            zoom: Some(Sphere {
                centre: DVec3::ZERO,
                radius: 0.08,
            }),
            coin,
            ..small()
        };
        render(&items, &options, &Context::quiet()).unwrap()
    };
    let (bare, shown) = (with(false), with(true));
    // The yellow of its outer part, which nothing else has, spans its width.
    let is_yellow = |x: usize, y: usize| {
        let p = &shown.rgb[(y * 240 + x) * 3..][..3];
        i32::from(p[0]) - i32::from(p[2]) > 40
    };
    let columns: Vec<usize> = (0..240)
        .filter(|&x| (0..240).any(|y| is_yellow(x, y)))
        .collect();
    let wide = (columns[columns.len() - 1] - columns[0] + 1) as f64;
    // The sphere of 16 cm fills the height; perspective changes that by its sine, 2 %.
    let expected = 240.0 * 23.25 / 160.0;
    assert!((wide / expected - 1.0).abs() < 0.08, "{wide}, {expected}");
    assert!(difference(&bare, &shown) > 1.0);
}

#[test]
fn what_is_out_of_focus_is_blurred_and_the_rest_is_not() {
    // Two cubes of the same look, of which one is twice as far.
    let mesh = cube();
    let shader = PlainShader::uniform([1.0; 3]);
    let at = |x: f64, z: f64| Item {
        mesh: &mesh,
        transform: DAffine3::from_translation(DVec3::new(x, 0.0, z)),
        shader: &shader,
    };
    let items = [at(-1.0, 0.0), at(1.4, -8.0)];
    let with = |depth_of_field: f64| {
        let options = PictureOptions {
            width: 160,
            height: 120,
            view: View::Direction {
                azimuth: 0.0,
                elevation: 0.0,
            },
            zoom: Some(Sphere {
                centre: DVec3::new(0.0, 0.0, 0.0),
                radius: 2.0,
            }),
            floor: false,
            depth_of_field: Some(depth_of_field),
            ..small()
        };
        render(&items, &options, &Context::quiet()).unwrap()
    };
    let (sharp, soft) = (with(0.0), with(1.0));
    // The steepest step between neighbours in a range of columns: at the border between red and blue.
    let step = |picture: &Picture, columns: std::ops::Range<usize>| {
        let level = |x: usize, y: usize| i32::from(picture.rgb[(y * 160 + x) * 3]);
        let steps = columns.flat_map(|x| (1..120).map(move |y| (x, y)));
        steps
            .map(|(x, y)| (level(x, y) - level(x, y - 1)).abs())
            .max()
    };
    let (near, far) = (30..60, 95..125);
    let [before, after] = [&sharp, &soft].map(|p| step(p, near.clone()).unwrap());
    assert!(10 * after >= 9 * before, "{before} {after}");
    let [before, after] = [&sharp, &soft].map(|p| step(p, far.clone()).unwrap());
    assert!(2 * after < before, "{before} {after}");
}

#[test]
fn a_placed_camera_stays_whatever_is_to_fit_into_the_picture() {
    // A sphere of radius 1 fills the view from +Z; 25° across the shorter side is the default of both.
    let zoomed = PictureOptions {
        view: View::Direction {
            azimuth: 0.0,
            elevation: 0.0,
        },
        zoom: Some(Sphere {
            centre: DVec3::ZERO,
            radius: 1.0,
        }),
        ..small()
    };
    let distance = 1.0 / 12.5f64.to_radians().sin();
    let placed = PictureOptions {
        camera: Some(CameraPlacement {
            place: DVec3::Z * distance,
            target: DVec3::ZERO,
            field_of_view: 25f64.to_radians(),
        }),
        ..small()
    };
    let difference = |a: &Picture, b: &Picture| {
        let pairs = a.rgb.iter().zip(&b.rgb);
        pairs.map(|(a, b)| a.abs_diff(*b)).max()
    };
    let picture = render_cube(&placed).unwrap();
    let same = render_cube(&zoomed).unwrap();
    assert!(difference(&picture, &same) <= Some(2));
    let other = PictureOptions {
        shown: vec![DVec3::splat(-0.5), DVec3::splat(20.0)],
        zoom: Some(Sphere {
            centre: DVec3::X,
            radius: 9.0,
        }),
        view: View::Automatic,
        ..placed
    };
    assert_eq!(render_cube(&other).unwrap(), picture);
}

#[test]
fn a_ground_has_figure_and_shadows_and_is_blurred_far_away() {
    let mesh = cube();
    let shader = PlainShader::uniform([1.0; 3]);
    let items = [Item {
        mesh: &mesh,
        transform: DAffine3::from_scale(DVec3::splat(0.1)),
        shader: &shader,
    }];
    let with_all = |ground, floor, depth_of_field, film_grain, lens_softness| {
        let options = PictureOptions {
            width: 320,
            height: 240,
            samples: 4,
            ground: Some(ground),
            floor,
            depth_of_field,
            film_grain,
            lens_softness,
            view: View::Direction {
                azimuth: 0.5,
                elevation: 0.35,
            },
            zoom: Some(Sphere {
                centre: DVec3::ZERO,
                radius: 0.2,
            }),
            ..small()
        };
        render(&items, &options, &Context::quiet()).unwrap()
    };
    let with = |ground, floor, depth| with_all(ground, floor, depth, Some(0.0), Some(0.0));
    let row = |picture: &Picture, y: usize| -> Vec<i32> {
        let at = |x: usize| i32::from(picture.rgb[(y * 320 + x) * 3 + 1]);
        (0..320).map(at).collect()
    };
    let roughness = |picture: &Picture, y: usize| -> i32 {
        let row = row(picture, y);
        row.windows(3).map(|p| (p[2] - p[0]).pow(2)).sum()
    };
    for ground in [Ground::Bench, Ground::Concrete, Ground::Litter] {
        let sharp = with(ground, true, Some(0.0));
        let plain = with(Ground::Plain, true, Some(0.0));
        assert!(
            roughness(&sharp, 232) > 3 * roughness(&plain, 232),
            "{ground:?}: {} {}",
            roughness(&sharp, 232),
            roughness(&plain, 232)
        );
        let soft = with(ground, true, Some(0.6));
        assert!(
            2 * roughness(&soft, 16) < roughness(&sharp, 16),
            "{ground:?}: {} {}",
            roughness(&soft, 16),
            roughness(&sharp, 16)
        );
        // There is a ground only where there is a floor.
        let none = [ground, Ground::Plain].map(|g| with(g, false, Some(0.0)));
        assert_eq!(none[0], none[1]);
        // Where nothing is said about grain and the lens, a ground has them and the plain backdrop has none.
        let (no, full) = (Some(0.0), Some(1.0));
        assert_ne!(with_all(ground, true, no, None, no), sharp);
        assert_ne!(with_all(ground, true, no, no, None), sharp);
        assert_eq!(with_all(Ground::Plain, true, no, None, None), plain);
        let grained = with_all(Ground::Plain, true, no, full, no);
        assert!(roughness(&grained, 232) > 3 * roughness(&plain, 232));
        let softened = with_all(ground, true, no, no, full);
        assert!(20 * roughness(&softened, 232) < 19 * roughness(&sharp, 232));
    }
}

/// A picture of a black hair, a share of a pixel wide, that runs slantwise across it, or past the camera, before the background or a wall
/// far behind it.
fn hair(width: f64, samples: u32, is_seen: bool, has_wall: bool) -> Picture {
    let options = PictureOptions {
        width: 120,
        height: 80,
        samples,
        floor: false,
        camera: Some(CameraPlacement {
            place: DVec3::Z * 10.0,
            target: DVec3::ZERO,
            field_of_view: 25f64.to_radians(),
        }),
        ..PictureOptions::default()
    };
    let pixel = 2.0 * 12.5f64.to_radians().tan() * 10.0 / f64::from(options.height);
    let (reach, half) = (45.0 * pixel, 0.5 * width * pixel);
    let strip = |[reach, half]: [f64; 2], depth: f64| {
        let corner = |x: f64, y: f64| DVec3::new(x, 0.31 * x + y, depth);
        Mesh {
            positions: vec![
                corner(-reach, -half),
                corner(reach, -half),
                corner(reach, half),
                corner(-reach, half),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }
    };
    let hair = strip([reach, half], if is_seen { 0.0 } else { 20.0 });
    let wall = strip([10.0, 10.0], if has_wall { -3.0 } else { 30.0 });
    let [black, white] = [0.0, 0.9].map(|color| PlainShader::uniform([color; 3]));
    let items = [(&hair, &black), (&wall, &white)].map(|(mesh, shader)| Item {
        mesh,
        transform: DAffine3::IDENTITY,
        shader,
    });
    render(&items, &options, &Context::quiet()).unwrap()
}

#[test]
fn hairs_thinner_than_a_pixel_are_lines_and_not_dots() {
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    let widths = [0.2, 0.4, 0.8].into_iter();
    for (width, has_wall) in widths.flat_map(|width| [(width, false), (width, true)]) {
        // How dark the hair makes each column but those at its ends.
        let darkness = |samples: u32| -> Vec<f64> {
            let [with, without] =
                [true, false].map(|is_seen| hair(width, samples, is_seen, has_wall));
            let green = |picture: &Picture, i: u32| f64::from(picture.rgb[3 * i as usize + 1]);
            let column = |x: u32| {
                let pixels = (0..with.height).map(|y| y * with.width + x);
                pixels.map(|i| green(&without, i) - green(&with, i)).sum()
            };
            (20..with.width - 20).map(column).collect()
        };
        let (found, truth) = (darkness(16), mean(&darkness(256)));
        let error = mean(&found) / truth - 1.0;
        assert!(
            error.abs() < 0.1,
            "{width}, {has_wall}: {found:?}, not {truth}"
        );
        // Few are missed by all rays of their pixels.
        let missed = found.iter().filter(|dark| **dark < 0.3 * truth).count();
        assert!(
            missed <= found.len() / 20,
            "{width}, {has_wall}: {found:?}, not {truth}"
        );
    }
}
