//! Pictures: the same bits with any number of threads, their content, and invalid input.

use glam::{DAffine3, DVec3};
use greenstick_geometry::{Attribute, CancelToken, Context, Mesh};
use greenstick_picture::{
    Item, Picture, PictureError, PictureOptions, PlainShader, Sphere, View, render,
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
