//! The rings of the inside, of the broken faces and of the textures are the same.

use glam::{DVec2, Vec2};
use greenstick::fracture::layout::wrap_angle;
use greenstick::geometry::{Context, ImageSource, Scene};
use greenstick::wood::anatomy::{Anatomy, AnatomyRequest};
use greenstick::wood::appearance::WoodAppearance;
use greenstick::wood::rings::{RingSource, StemAddress};
use greenstick::wood::stem::Stem;
use greenstick::{BreakRequest, BreakSession, built_in_branch};
use std::f64::consts::{PI, TAU};

/// Width of the texture, pixels.
const TEXTURE: u32 = 1024;

/// Parameters and their values.
type Settings = &'static [(&'static str, &'static str)];

/// Ways to ask for rings: settings of a break, and of an inside.
const RINGS: [(Settings, Settings); 4] = [
    (&[], &[]),
    (&[("annual_rings", "7")], &[("rings", "7")]),
    (
        &[("ring_widths", "1 mm, 3 mm, 2 mm, 5 mm")],
        &[("ring_widths", "1 mm, 3 mm, 2 mm, 5 mm")],
    ),
    (
        &[("rings_by", "erosion"), ("kernels", "6*5/7")],
        &[("rings_by", "erosion"), ("kernels", "6*5/7")],
    ),
];

fn request(rings: Settings, style: &str) -> BreakRequest {
    let mut file = greenstick::RequestFile::default();
    for setting in [&format!("surface={style}"), "rings=16", "sectors=60"] {
        file.apply_setting(setting).unwrap();
    }
    for (key, value) in rings {
        file.apply_setting(&format!("{key}={value}")).unwrap();
    }
    file.complete().unwrap();
    BreakRequest {
        texture_width: TEXTURE,
        ..file.request()
    }
}

/// Calls `check` with the rings of the inside at the break, of every way to ask for them, and the request of the break.
fn with_inside(check: impl Fn(&dyn RingSource, &mut BreakSession, &BreakRequest)) {
    use greenstick::schema::Parameters;
    let context = Context::quiet();
    for (of_break, of_inside) in RINGS {
        let request = request(of_break, "smooth");
        let mut session = BreakSession::new(built_in_branch());
        let prepared = session.stem(&request, &context).unwrap();
        let found = &prepared.sound.found;
        let mut wanted = AnatomyRequest::default();
        for (key, value) in of_inside {
            wanted.set_text(key, value).unwrap();
        }
        let face = &request.breaks[0].recipe.face;
        let proportions = face.proportions();
        let wood = WoodAppearance::of_stem(&found.stem, &proportions, face.seed, None, 0.95);
        let scene: Scene = built_in_branch();
        let mesh = &scene.world_meshes()[found.node];
        let anatomy: Anatomy = (wanted.anatomy(found, mesh, wood, proportions, &context)).unwrap();
        let section = anatomy.sections().section(found.stem.location).unwrap();
        let raster = anatomy.rasterize(&section, &anatomy.sections().grid, &context);
        check(&raster.unwrap(), &mut session, &request);
    }
}

/// Addresses all over the wood of a section.
fn addresses(stem: &Stem) -> Vec<StemAddress> {
    let mut addresses = Vec::new();
    for i in 0..72 {
        for k in 1..200 {
            let (rho, angle) = (f64::from(k) / 214.0, f64::from(i) * 5f64.to_radians() - 3.1);
            addresses.push(StemAddress {
                rho,
                angle,
                across: stem.rings.point(rho, angle) - stem.rings.pith(),
                along: stem.location,
            });
        }
    }
    addresses
}

/// Moves an address along its ray by a length, m.
fn outwards(stem: &Stem, at: StemAddress, by: f64) -> StemAddress {
    let across = at.across + at.across.normalize_or_zero() * by;
    let (rho, angle) = stem.rings.address(across + stem.rings.pith());
    StemAddress {
        rho,
        angle,
        across,
        ..at
    }
}

#[test]
fn a_broken_stem_has_the_rings_of_its_inside() {
    with_inside(|inside, session, request| {
        let stage = session.stem(request, &Context::quiet()).unwrap();
        let stem = &stage.sound.found.stem;
        assert_eq!(stage.rings.ring_count(), inside.ring_count());
        // The inside is a raster of 128 pixels across.
        let pixel = 2.2 * stem.rings.extent() / 128.0;
        let mut compared = 0;
        for at in addresses(stem) {
            let ring = |rings: &dyn RingSource, at| rings.ring_at(&at).map(|r| (r.ring, r.part));
            let here = ring(&*stage.rings, at);
            let clear = [-pixel, pixel]
                .iter()
                .all(|&by| ring(&*stage.rings, outwards(stem, at, by)) == here);
            if clear {
                assert_eq!(ring(inside, at), here, "{:?} at {at:?}", stage.rings);
                compared += 1;
            }
        }
        assert!(compared > 4_000, "{:?}: {compared}", stage.rings);
    });
}

/// Brightness of the end grain in a PNG of textures, and its width, texels.
fn end_grain(bytes: &[u8]) -> (usize, Vec<f64>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
        .read_info()
        .unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    let (width, half) = (info.width as usize, info.height as usize);
    let texel = |i: usize| {
        let at = 3 * (i / half * width + i % half);
        pixels[at..at + 3]
            .iter()
            .map(|&c| f64::from(c))
            .sum::<f64>()
    };
    (half, (0..half * half).map(texel).collect())
}

#[test]
fn rings_lie_in_the_texture_where_they_lie_in_the_wood() {
    let request = request(RINGS[1].0, "smooth");
    let mut session = BreakSession::new(built_in_branch());
    let stage = session.stem(&request, &Context::quiet()).unwrap();
    let (stem, square) = (&stage.sound.found.stem, stage.sound.square);
    let broken = session.broken(&request, &Context::quiet()).unwrap();
    let color = broken
        .scene
        .images
        .iter()
        .find(|i| i.name == "inner_wood_color");
    let ImageSource::Bytes(bytes) = &color.unwrap().source else {
        panic!("the texture is in memory");
    };
    let (half, brightness) = end_grain(bytes);
    let texel = square.side / half as f64;
    // Mean brightness of a ring coordinate over all angles.
    let mean = |rho: f64| {
        let directions = (0..360).map(|i| f64::from(i).to_radians());
        let sum: f64 = directions
            .map(|angle| {
                let p =
                    stem.rings.point(rho, angle) - square.middle + DVec2::splat(square.side / 2.0);
                let at = (p / texel).floor();
                brightness[at.y as usize * half + at.x as usize]
            })
            .sum();
        sum / 360.0
    };
    let radius = stem.rings.mean_radius(1.0);
    let step = texel / radius;
    let edges = stage.rings.edges().to_vec();
    assert_eq!(edges.len(), 7);
    for edge in &edges[1..6] {
        // Latewood ends and earlywood begins: the steepest rise within half a ring to either side.
        let rise = |rho: f64| mean(rho + 1.5 * step) - mean(rho - 1.5 * step);
        let count = (0.5 / 7.0 / step) as i32;
        let found = (-count..=count)
            .map(|i| edge + f64::from(i) * step)
            .max_by(|&a, &b| rise(a).total_cmp(&rise(b)))
            .unwrap();
        let off = (found - edge) / step;
        assert!(off.abs() <= 1.5, "{edge}: {off} texels away");
        assert!(rise(found) > 10.0, "{edge}: a rise of {}", rise(found));
    }
}

#[test]
fn both_halves_show_a_ring_at_the_same_place() {
    let request = request(RINGS[1].0, "fibrous");
    let mut session = BreakSession::new(built_in_branch());
    let stage = session.stem(&request, &Context::quiet()).unwrap();
    let (stem, square) = (&stage.sound.found.stem, stage.sound.square);
    let broken = session.broken(&request, &Context::quiet()).unwrap();
    for node in &broken.scene.nodes[..2] {
        let mesh = &node.mesh;
        let attribute = |name: &str| {
            mesh.attributes
                .get(name)
                .unwrap_or_else(|| panic!("{name}"))
        };
        let (rings, uvs) = (attribute("_RING"), attribute("TEXCOORD_0"));
        let mut compared = 0;
        for v in 0..mesh.positions.len() {
            let (rho, uv) = (
                f64::from(rings.at(v)[0]),
                Vec2::from_slice(uvs.at(v)).as_dvec2(),
            );
            let p = uv - DVec2::splat(square.side / 2.0) + square.middle;
            // End grain of the broken face. Side grain begins with the pith at the square's far edge, whose coordinate is
            // rounded as in the file: rounding keeps the order. The bark has ring coordinates of 1.
            let is_end_grain = uvs.at(v)[0] < square.side as f32;
            if uv.x > 0.0 && is_end_grain && rho < 0.97 {
                let there = stem.rings.address(p).0;
                assert!(
                    (there - rho).abs() < 1e-4,
                    "{}: {there} for {rho}",
                    node.name
                );
                compared += 1;
            }
        }
        assert!(compared > 500, "{}: {compared}", node.name);
    }
}

#[test]
fn bundles_of_the_broken_face_part_at_the_edges_of_rings() {
    for (settings, most) in [(RINGS[1].0, 0.012), (RINGS[0].0, 0.012)] {
        let request = request(settings, "fibrous");
        let mut session = BreakSession::new(built_in_branch());
        let stages = session.stages(&request, &Context::quiet()).unwrap();
        let bundles = &stages.layout.bundles;
        let edges = stages.stem.rings.edges();
        let extent = stages.stem.stem().extent;
        let bark = extent.bark;
        // Where the skin dips below a ring there is no wood of it.
        let sectors = extent.bark_below.len();
        let skin = |angle: f64| {
            let place = (wrap_angle(angle) + PI) / TAU * sectors as f64;
            let beside = [sectors - 1, 0, 1].map(|k| (place as usize + k) % sectors);
            beside
                .iter()
                .fold(1.0, |least: f64, &k| least.min(extent.bark_below[k]))
        };
        let (mut crossing, mut whole, mut below_dips) = (0, 0, 0);
        for &edge in edges.iter().filter(|&&e| e < bark - 0.02) {
            for (facet, &cell) in bundles.layout.facets.iter().zip(&bundles.layout.cells) {
                let rho = facet.map(|n| bundles.addresses[n as usize].0);
                let (low, high) = (
                    rho.iter().fold(1.0, |a: f64, &b| a.min(b)),
                    rho.iter().fold(0.0, |a: f64, &b| a.max(b)),
                );
                let bundle = &bundles.bundles[cell as usize];
                let skins = facet.map(|n| skin(bundles.addresses[n as usize].1));
                if skins.iter().any(|&skin| skin < edge) {
                    below_dips += 1;
                    continue;
                }
                whole += 1;
                crossing += usize::from(!bundle.bark && low < edge - most && high > edge + most);
            }
        }
        assert_eq!(crossing, 0, "{} rings", edges.len());
        assert!(10 * below_dips < whole, "{below_dips} beside {whole}");
    }
}
