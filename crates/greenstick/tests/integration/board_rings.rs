//! A board has the rings of the log it was sawn from: in its inside, wherever it breaks, on its broken faces and on its sides.

use crate::support::scene;
use glam::{DVec2, DVec3, Vec2};
use greenstick::geometry::{Context, ImageSource, Mesh};
use greenstick::schema::Parameters;
use greenstick::skin::texture::PlanedFaces;
use greenstick::wood::anatomy::AnatomyRequest;
use greenstick::wood::appearance::WoodAppearance;
use greenstick::wood::rings::{RingSource, StemAddress};
use greenstick::wood::stem::{PithPosition, Stem};
use greenstick::{BreakRequest, BreakSession, Broken, RequestFile};
use std::ops::Range;

/// Where the pith lies in the section, m: 50 mm below its middle and 8 mm beside it.
const PITH: DVec2 = DVec2::new(0.008, -0.05);

/// A board 50 cm long and 40 mm thick along z, whose width goes from the first to the second number, m.
fn board(widths: [f64; 2]) -> Mesh {
    const ROWS: u32 = 20;
    let mut mesh = Mesh::default();
    for row in 0..=ROWS {
        let part = f64::from(row) / f64::from(ROWS);
        let half = 0.5 * (widths[0] + (widths[1] - widths[0]) * part);
        for (x, y) in [(-half, -0.02), (half, -0.02), (half, 0.02), (-half, 0.02)] {
            mesh.positions.push(DVec3::new(x, y, 0.5 * part));
        }
    }
    for row in 0..ROWS {
        for k in 0..4 {
            let [a, b] = [4 * row + k, 4 * row + (k + 1) % 4];
            mesh.triangles.extend([[a, b, b + 4], [a, b + 4, a + 4]]);
        }
    }
    let end = 4 * ROWS;
    mesh.triangles.extend([
        [0, 2, 1],
        [0, 3, 2],
        [end, end + 1, end + 2],
        [end, end + 2, end + 3],
    ]);
    mesh
}

fn request(at: &str, surface: &str) -> BreakRequest {
    let mut file = RequestFile::default();
    let pith = format!("pith={},{}", PITH.x, PITH.y);
    let at = format!("at={at}");
    let surface = format!("surface={surface}");
    for setting in [
        &*at,
        &*surface,
        "kind=board",
        &*pith,
        "rings=16",
        "sectors=60",
    ] {
        file.apply_setting(setting).unwrap();
    }
    file.complete().unwrap();
    BreakRequest {
        texture_width: 1024,
        ..file.request()
    }
}

/// The address of a place in the section, m.
fn address(stem: &Stem, at: DVec2, along: f64) -> StemAddress {
    let (rho, angle) = stem.rings.address(at);
    StemAddress {
        rho,
        angle,
        across: at - stem.rings.pith(),
        along,
    }
}

#[test]
fn rings_run_along_a_board_whatever_its_width_and_wherever_it_breaks() {
    let context = Context::quiet();
    let scene = scene(board([0.06, 0.09]), 1.0);
    let mut seen = Vec::new();
    for at in ["0.2", "0.5", "0.8"] {
        let request = request(at, "smooth");
        let mut session = BreakSession::new(scene.clone());
        let stage = session.stem(&request, &context).unwrap();
        let found = &stage.sound.found;
        let face = &request.breaks[0].recipe.face;
        let wood = WoodAppearance::of_stem(&found.stem, &face.proportions(), face.seed, None, 0.95);
        let mesh = &scene.world_meshes()[found.node];
        let mut wanted = AnatomyRequest::default();
        wanted.set_text("resolution", "512").unwrap();
        let anatomy = wanted
            .anatomy(found, mesh, wood, face.proportions(), &context)
            .unwrap();
        let mut rings = Vec::new();
        for length in [0.05, 0.25, 0.45] {
            let section = anatomy.sections().section(length).unwrap();
            let grid = &anatomy.sections().grid;
            let raster = anatomy.rasterize(&section, grid, &context).unwrap();
            let pixel = 2.0 * section.field.extent() / 512.0;
            for i in 0..25 {
                for j in 0..13 {
                    let halfway = DVec2::new(f64::from(i - 12) * 2e-3, f64::from(j - 6) * 2e-3);
                    let fibre = found.stem.grain.from_section(halfway, 0.25);
                    let place = found.stem.grain.to_section(fibre, length);
                    let here = address(&found.stem, fibre, length);
                    assert!((section.field.address(place).0 - here.rho).abs() < 1e-12);
                    let of_break = stage.rings.ring_at(&here).unwrap();
                    let edge = of_break.fraction.min(1.0 - of_break.fraction) * of_break.width;
                    if edge * found.stem.rings.outer_radius(0.0) > 1.5 * pixel {
                        assert_eq!(raster.ring_at(&here).unwrap().ring, of_break.ring);
                    }
                    rings.push((of_break.ring, of_break.part));
                }
            }
        }
        // A fibre stays in its ring all along the board.
        let of_section = rings.len() / 3;
        assert!(rings.chunks(of_section).all(|r| r == &rings[..of_section]));
        seen.push(rings);
    }
    assert!(seen.iter().all(|rings| *rings == seen[0]));
    let numbers: std::collections::BTreeSet<i64> = seen[0].iter().map(|r| r.0).collect();
    assert!(numbers.len() > 10, "{numbers:?}");
}

#[test]
fn both_halves_of_a_board_show_its_rings_where_they_are() {
    // Where grain slopes, its waves are followed in straight steps.
    for (slope, tolerance) in [(0.0, 1e-4), (0.02, 2e-3)] {
        let mut request = request("0.5", "fibrous");
        request.stem.slope_of_grain = slope;
        halves_show_rings(&request, tolerance);
    }
}

/// Both halves of a board show its rings within a tolerance of the ring coordinate, at their vertices and in their texture.
fn halves_show_rings(request: &BreakRequest, tolerance: f64) {
    let mut session = BreakSession::new(scene(board([0.06, 0.09]), 1.0));
    let stage = session.stem(request, &Context::quiet()).unwrap();
    let square = stage.sound.square;
    let stem = &stage.sound.found.stem;
    let broken = session.broken(request, &Context::quiet()).unwrap();
    for node in broken.scene.nodes.iter().filter(|n| !n.is_detail) {
        let mesh = &node.mesh;
        let [rings, uvs] = ["_RING", "TEXCOORD_0"].map(|name| mesh.attributes.get(name).unwrap());
        let mut inner = vec![false; mesh.positions.len()];
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let material = &broken.scene.materials[mesh.materials[t] as usize].name;
            for &v in corners {
                inner[v as usize] |= material == "inner_wood";
            }
        }
        let (mut of_face, mut compared) = (0, 0);
        for v in (0..inner.len()).filter(|&v| inner[v]) {
            of_face += 1;
            let rho = f64::from(rings.at(v)[0]);
            let grain = stem
                .grain
                .to_grain(node.transform.transform_point3(mesh.positions[v]));
            let here = stem.rings.address(grain.truncate()).0;
            assert!(
                (here - rho).abs() < tolerance,
                "{}: {here} for {rho}",
                node.name
            );
            let uv = Vec2::from_slice(uvs.at(v)).as_dvec2();
            let shown = uv - DVec2::splat(square.side / 2.0) + square.middle;
            if uv.x < square.side {
                let there = stem.rings.address(shown).0;
                assert!(
                    (there - rho).abs() < tolerance,
                    "{}: {there} for {rho}",
                    node.name
                );
                compared += 1;
            }
        }
        assert!(of_face > 500 && compared > 300, "{of_face} {compared}");
    }
}

/// The texture of the sides of a board.
struct Sides {
    width: usize,
    height: usize,
    pixels: Vec<u8>,
}

impl Sides {
    fn of(broken: &Broken) -> Self {
        let images = &broken.scene.images;
        let color = images
            .iter()
            .find(|i| i.name == "planed_wood_color")
            .unwrap();
        let ImageSource::Bytes(bytes) = &color.source else {
            panic!("the texture is in memory");
        };
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        Sides {
            width: info.width as usize,
            height: info.height as usize,
            pixels,
        }
    }

    /// Mean brightness of a column over some rows.
    fn brightness(&self, column: usize, rows: Range<usize>) -> f64 {
        let count = rows.len() as f64;
        let pixels = rows.map(|row| &self.pixels[3 * (row * self.width + column)..][..3]);
        pixels.flatten().map(|&c| f64::from(c)).sum::<f64>() / count
    }
}

#[test]
fn rings_go_over_the_sides_of_a_board_as_its_grain_slopes() {
    let mut request = request("0.5", "smooth");
    request.stem.slope_of_grain = 0.04;
    // Straight below, so that fibres run out straight up.
    request.stem.pith = Some(PithPosition::Section(DVec2::new(0.0, -0.05)));
    let mut session = BreakSession::new(scene(board([0.06, 0.06]), 1.0));
    let stage = session.stem(&request, &Context::quiet()).unwrap();
    let (stem, square) = (&stage.sound.found.stem, stage.sound.square);
    let broken = session.broken(&request, &Context::quiet()).unwrap();
    let sides = Sides::of(&broken);
    let faces = PlanedFaces::of_stem(stem, square);
    assert_eq!(faces.length, stem.length);
    let texel = square.perimeter() / sides.width as f64;
    // The left side, whose columns lie along the thickness, in bands of rows.
    let low = square.middle - 0.5 * square.size;
    let start = faces.coordinates(low.extend(stem.location), DVec2::NEG_X).x;
    let start = (start * sides.width as f64).round() as usize;
    let count = (square.size.y / texel) as usize;
    let band = |middle: f64| {
        let row = (middle * sides.height as f64) as usize;
        let brightness = |k| sides.brightness(start + k, row - 4..row + 4);
        (0..count).map(brightness).collect::<Vec<f64>>()
    };
    let here = band(0.5);
    for part in [0.3, 0.42, 0.61, 0.75] {
        let there = band(part);
        let mean_difference = |shift: i64| {
            let pairs = (0..count as i64).filter_map(|k| {
                let other = usize::try_from(k + shift).ok()?;
                Some((here[k as usize] - there.get(other)?).abs())
            });
            let differences: Vec<f64> = pairs.collect();
            differences.iter().sum::<f64>() / differences.len() as f64
        };
        let most = count as i64 / 2;
        let best = (-most..=most)
            .min_by(|&a, &b| mean_difference(a).total_cmp(&mean_difference(b)))
            .unwrap();
        let (from, to) = (0.5 * stem.length, part * stem.length);
        let moved = (stem.grain.offset(to) - stem.grain.offset(from)).y;
        let found = best as f64 * texel;
        assert!(
            (found - moved).abs() < 2.0 * texel,
            "{part}: {found} m for {moved} m"
        );
    }
}

#[test]
fn the_sides_of_a_board_show_the_rings_that_end_there() {
    let mut request = request("0.5", "smooth");
    request.stem.slope_of_grain = 0.0;
    let mut session = BreakSession::new(scene(board([0.06, 0.06]), 1.0));
    let stage = session.stem(&request, &Context::quiet()).unwrap();
    let (stem, square) = (&stage.sound.found.stem, stage.sound.square);
    let broken = session.broken(&request, &Context::quiet()).unwrap();
    let sides = Sides::of(&broken);
    let (width, height) = (sides.width, sides.height);
    // Mean brightness of each column: the grain runs along the columns.
    let brightness = |column: usize| sides.brightness(column, 0..height);
    let faces = PlanedFaces::of_stem(stem, square);
    let texel = square.perimeter() / width as f64;
    let (mut edges, mut missed) = (0, 0);
    // Up the narrow sides rings are crossed almost at right angles.
    for normal in [DVec2::NEG_X, DVec2::X] {
        let low = square.middle - 0.5 * square.size;
        let x = if normal.x < 0.0 {
            low.x
        } else {
            low.x + square.size.x
        };
        let place = |k: usize| DVec2::new(x, low.y + (k as f64 + 0.5) * texel);
        let count = (square.size.y / texel) as usize;
        let ring = |k: usize| stage.rings.ring_at(&address(stem, place(k), 0.0)).unwrap();
        let first = faces.coordinates(place(0).extend(0.0), normal).x;
        let first = (first * width as f64) as usize;
        for k in 4..count - 4 {
            let (here, next) = (ring(k), ring(k + 1));
            // Rings that are a few texels wide are a blur.
            if here.ring == next.ring || here.width * stem.rings.outer_radius(0.0) < 8.0 * texel {
                continue;
            }
            // Seen from the pith, dark latewood ends where light earlywood begins.
            let sign = (next.ring - here.ring) as f64;
            let rise = |k: usize| sign * (brightness(first + k + 2) - brightness(first + k));
            let steepest = (k - 4..=k + 4).max_by(|&a, &b| rise(a).total_cmp(&rise(b)));
            edges += 1;
            missed += usize::from(steepest.unwrap().abs_diff(k) > 1 || rise(k) < 5.0);
        }
    }
    assert!(edges > 15, "{edges}");
    assert_eq!(missed, 0, "of {edges}");
}
