//! Pictures of the viewport, on whatever adapter there is. Without one these tests say that they did not run;
//! `.ci/run` sets GREENSTICK_NEEDS_ADAPTER, so that there they fail.

use glam::{DAffine3, DVec3, Vec3};
use greenstick::RequestFile;
use greenstick::geometry::{
    Attribute, Context, Image, ImageSource, Material, Mesh, Node, Scene, Texture, TextureReference,
};
use greenstick_studio::model::engine::{Engine, Haste, Job};
use greenstick_studio::model::input::Input;
use greenstick_studio::model::meshes::DrawnScene;
use greenstick_studio::model::section::{Plane, SectionFaces, section_faces};
use greenstick_studio::view::camera::{AxisView, Camera};
use greenstick_studio::view::frame::{Colours, View};
use greenstick_studio::view::renderer::Renderer;
use std::sync::Arc;

const SIDE: u32 = 256;

/// A card without a window.
struct Card {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

/// The adapter there is; without one, the test says that it did not run.
pub fn adapter(test: &str) -> Option<(wgpu::Instance, wgpu::Adapter)> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter =
        pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()));
    let Ok(adapter) = adapter else {
        assert!(
            std::env::var_os("GREENSTICK_NEEDS_ADAPTER").is_none(),
            "there is no graphics adapter"
        );
        eprintln!("{test} did not run: there is no graphics adapter; install mesa-vulkan-drivers");
        return None;
    };
    Some((instance, adapter))
}

fn card(test: &str) -> Option<Card> {
    let (_, adapter) = adapter(test)?;
    let asked = adapter.request_device(&wgpu::DeviceDescriptor::default());
    let (device, queue) = pollster::block_on(asked).unwrap();
    Some(Card { device, queue })
}

fn shown(settings: &[&str]) -> Arc<DrawnScene> {
    let file = RequestFile::resolve(&[], None, settings).unwrap();
    let job = Job {
        input: Input::built_in(),
        file,
        haste: Haste::Whole,
        sections_of: None,
    };
    let shown = Engine::default().work(&job, &mut |_| {}, &Context::quiet());
    Arc::new(shown.unwrap().unwrap().drawn)
}

impl Card {
    /// Draws a frame and reads it back: red, green, blue and 255 of each pixel.
    fn draw(&self, renderer: &mut Renderer, frame: &View) -> Vec<[u8; 4]> {
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        assert!(renderer.draw(&self.device, &self.queue, &mut encoder, frame));
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(4 * SIDE * SIDE),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let picture = renderer.picture().unwrap();
        encoder.copy_texture_to_buffer(
            picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(4 * SIDE),
                    rows_per_image: None,
                },
            },
            picture.size(),
        );
        self.queue.submit([encoder.finish()]);
        buffer
            .slice(..)
            .map_async(wgpu::MapMode::Read, |r| r.unwrap());
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .unwrap();
        let bytes = buffer.slice(..).get_mapped_range().unwrap().to_vec();
        bytes.as_chunks::<4>().0.to_vec()
    }
}

fn frame(shown: &Arc<DrawnScene>, colours: Colours) -> View {
    let at = shown.breaks[0];
    let mut camera = Camera {
        yaw: 1.2,
        pitch: 0.4,
        ..Camera::default()
    };
    let reach = 0.5 * (at.heights[1] - at.heights[0]);
    camera.frame(at.place, 3.0 * at.radius + reach, 1.0);
    View {
        shown: Some((1, shown.clone())),
        camera,
        size: [SIDE; 2],
        colours,
        wireframe: false,
        section: None,
        background: [0.0, 0.0, 1.0],
    }
}

fn is_background(p: &[u8; 4]) -> bool {
    p[0] == 0 && p[1] == 0 && p[2] > 150
}

#[test]
fn wood_is_drawn_in_the_colours_of_wood() {
    let Some(card) = card("wood_is_drawn_in_the_colours_of_wood") else {
        return;
    };
    let shown = shown(&["part=6cm"]);
    let mut renderer = Renderer::new(&card.device, &card.queue, wgpu::TextureFormat::Rgba8Unorm);
    let pixels = card.draw(&mut renderer, &frame(&shown, Colours::Wood));
    let stem: Vec<_> = pixels.iter().filter(|p| !is_background(p)).collect();
    let share = stem.len() as f64 / pixels.len() as f64;
    assert!((0.1..0.9).contains(&share), "{share}");
    // Wood and bark are warm: red over green over blue, at nearly every pixel.
    let warm = stem.iter().filter(|p| p[0] >= p[1] && p[1] >= p[2]).count();
    assert!(
        warm as f64 > 0.9 * stem.len() as f64,
        "{warm} of {}",
        stem.len()
    );
    let bright = stem.iter().filter(|p| p[0] > 120).count();
    assert!(bright > 300, "the broken face shows no pale wood: {bright}");
    // The same frame is not drawn again.
    let mut encoder = card
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    assert!(!renderer.draw(
        &card.device,
        &card.queue,
        &mut encoder,
        &frame(&shown, Colours::Wood)
    ));
}

#[test]
fn every_kind_of_colours_shows_something_else() {
    let Some(card) = card("every_kind_of_colours_shows_something_else") else {
        return;
    };
    let shown = shown(&["part=6cm"]);
    let mut renderer = Renderer::new(&card.device, &card.queue, wgpu::TextureFormat::Rgba8Unorm);
    let pictures = Colours::ALL.map(|colours| card.draw(&mut renderer, &frame(&shown, colours)));
    for (i, a) in pictures.iter().enumerate() {
        for b in &pictures[..i] {
            let differ = a.iter().zip(b).filter(|(p, q)| p != q).count();
            assert!(differ > 2000, "{i}: {differ} pixels differ");
        }
    }
    let mut wire = frame(&shown, Colours::Clay);
    wire.wireframe = true;
    let lines = card.draw(&mut renderer, &wire);
    let differ = lines
        .iter()
        .zip(&pictures[4])
        .filter(|(p, q)| p != q)
        .count();
    assert!(differ > 2000, "wireframe: {differ}");
    let mut open = frame(&shown, Colours::Clay);
    let at = shown.breaks[0];
    let normal = at.along.cross(Vec3::Y).normalize();
    let plane = Plane {
        normal,
        distance: normal.dot(at.place),
    };
    // Hollow, then with the faces that the plane opens.
    let faces = [SectionFaces::default(), section_faces(&shown, plane)];
    let [hollow, cut] = faces.map(|faces| {
        open.section = Some((plane, Arc::new(faces)));
        // Nothing is drawn anew where only the faces are others.
        open.camera.distance *= 1.0001;
        card.draw(&mut renderer, &open)
    });
    let unlike = |p: &[[u8; 4]], q: &[[u8; 4]]| p.iter().zip(q).filter(|(p, q)| p != q).count();
    assert!(unlike(&hollow, &pictures[4]) > 1000, "section");
    assert!(unlike(&hollow, &cut) > 1000, "faces of the section");
}
/// A floor, and with `wall` a wall that stands on it along x = 0.
fn floor(wall: bool) -> Arc<DrawnScene> {
    let mut mesh = Mesh::default();
    let mut quad = |corners: [[f64; 3]; 4]| {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners.map(DVec3::from_array));
        let triangles = [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| i + first));
        mesh.triangles.extend(triangles);
    };
    quad([
        [-1.0, 0.0, 1.0],
        [1.0, 0.0, 1.0],
        [1.0, 0.0, -1.0],
        [-1.0, 0.0, -1.0],
    ]);
    if wall {
        quad([
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
            [0.0, 0.1, -1.0],
            [0.0, 0.1, 1.0],
        ]);
    }
    let scene = Scene {
        nodes: vec![Node::new("floor", DAffine3::IDENTITY, mesh)],
        ..Scene::default()
    };
    Arc::new(DrawnScene::unbroken(&scene))
}

#[test]
fn a_wall_shades_the_floor_beside_it_and_no_farther() {
    let Some(card) = card("a_wall_shades_the_floor_beside_it_and_no_farther") else {
        return;
    };
    let mut renderer = Renderer::new(&card.device, &card.queue, wgpu::TextureFormat::Rgba8Unorm);
    // From the side that the wall faces, half from above; the key light comes from there, too, so that the wall's shadow lies behind it.
    let [bare, walled] = [(1, false), (2, true)].map(|(id, wall)| {
        let shown = floor(wall);
        let middle = shown.middle.as_vec3();
        let mut camera = Camera::default();
        camera.look(AxisView::Right, true);
        camera.pitch = 0.8;
        camera.frame(Vec3::new(-0.05, 0.0, 0.0) - middle, 0.15, 1.0);
        let foot = camera.seen_at(-middle, 1.0).unwrap();
        let row = ((0.5 - 0.5 * foot.y) * SIDE as f32) as usize;
        let view = View {
            shown: Some((id, shown)),
            camera,
            size: [SIDE; 2],
            colours: Colours::Clay,
            wireframe: false,
            section: None,
            background: [0.0, 0.0, 1.0],
        };
        let pixels = card.draw(&mut renderer, &view);
        // The mean over the middle of a row, so many rows before the wall's foot.
        move |off: usize| {
            let at = |column: usize| f64::from(pixels[(row + off) * SIDE as usize + column][1]);
            (100..156).map(at).sum::<f64>() / 56.0
        }
    });
    let darker = |off: usize| bare(off) - walled(off);
    println!(
        "darker by {:.1}, {:.1}, {:.1}, {:.1}",
        darker(3),
        darker(8),
        darker(14),
        darker(60)
    );
    assert!(darker(3) > 4.0 && darker(3) > 2.0 * darker(8) && darker(8) > darker(14));
    assert!(darker(60).abs() < 1.0, "{}", darker(60));
}

/// A PNG file of these pixels, not compressed (RFC 2083, RFC 1950).
fn encode_png(width: u32, height: u32, rgba: &[u8]) -> Vec<u8> {
    let crc = |bytes: &[u8]| {
        let step = |crc: u32, byte: &u8| {
            (0..8).fold(crc ^ u32::from(*byte), |c, _| {
                (c >> 1) ^ (0xedb8_8320 & (c & 1).wrapping_neg())
            })
        };
        !bytes.iter().fold(!0, step)
    };
    let mut rows = Vec::new();
    for row in rgba.chunks(4 * width as usize) {
        rows.push(0);
        rows.extend(row);
    }
    let (a, b) = rows.iter().fold((1u32, 0u32), |(a, b), &x| {
        let a = (a + u32::from(x)) % 65_521;
        (a, (b + a) % 65_521)
    });
    let length = rows.len() as u16;
    let mut packed = vec![0x78, 0x01, 0x01];
    packed.extend(length.to_le_bytes());
    packed.extend((!length).to_le_bytes());
    packed.extend(rows);
    packed.extend((b << 16 | a).to_be_bytes());
    let mut head = Vec::new();
    head.extend(width.to_be_bytes());
    head.extend(height.to_be_bytes());
    head.extend([8, 6, 0, 0, 0]);
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    for (name, content) in [(b"IHDR", &head), (b"IDAT", &packed), (b"IEND", &Vec::new())] {
        file.extend((content.len() as u32).to_be_bytes());
        let mut chunk = name.to_vec();
        chunk.extend(content);
        file.extend(&chunk);
        file.extend(crc(&chunk).to_be_bytes());
    }
    file
}

/// A square that fills the picture, of a material with 8 × 8 pixels of colour and, where given, of a relief.
fn board(
    material: Material,
    color: impl Fn(u8, u8) -> [u8; 4],
    relief: Option<[u8; 4]>,
) -> Arc<DrawnScene> {
    Arc::new(DrawnScene::unbroken(&board_scene(material, color, relief)))
}

fn board_scene(
    material: Material,
    color: impl Fn(u8, u8) -> [u8; 4],
    relief: Option<[u8; 4]>,
) -> Scene {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mut mesh = Mesh {
        positions: corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        materials: vec![0; 2],
        ..Mesh::default()
    };
    let uv = corners
        .iter()
        .flat_map(|[x, y]| [0.5 + 0.5 * *x as f32, 0.5 - 0.5 * *y as f32]);
    let uv = Attribute {
        width: 2,
        data: uv.collect(),
    };
    mesh.attributes.insert("TEXCOORD_0".to_owned(), uv);
    let image = |value: &dyn Fn(u8, u8) -> [u8; 4]| {
        let rgba: Vec<u8> = (0..64).flat_map(|i| value(i % 8, i / 8)).collect();
        Image {
            name: String::new(),
            mime_type: "image/png".to_owned(),
            source: ImageSource::Bytes(encode_png(8, 8, &rgba)),
        }
    };
    let reference = |texture| {
        Some(TextureReference {
            texture,
            coordinates: 0,
            transform: None,
            strength: 1.0,
        })
    };
    let texture = |image| Texture {
        image: Some(image),
        alternatives: Vec::new(),
        sampler: [None; 4],
    };
    let normal = relief.unwrap_or_default();
    Scene {
        nodes: vec![Node::new("board", DAffine3::IDENTITY, mesh)],
        materials: vec![Material {
            base_color_texture: reference(0),
            normal_texture: reference(1).filter(|_| relief.is_some()),
            ..material
        }],
        textures: vec![texture(0), texture(1)],
        images: vec![image(&color), image(&|_, _| normal)],
        ..Scene::default()
    }
}

/// Draws a scene from the front; returns the mean red and blue of a square within the left, and within the right half.
fn draw_halves(
    card: &Card,
    renderer: &mut Renderer,
    shown: (u64, Arc<DrawnScene>),
) -> [[f64; 2]; 2] {
    let mut camera = Camera::default();
    camera.look(AxisView::Front, false);
    camera.frame(Vec3::ZERO, 0.8, 1.0);
    let view = View {
        shown: Some(shown),
        camera,
        size: [SIDE; 2],
        colours: Colours::Wood,
        wireframe: false,
        section: None,
        background: [0.0, 0.0, 1.0],
    };
    let pixels = card.draw(renderer, &view);
    [60, 160].map(|left| {
        let square = (100..140).flat_map(|y| (left..left + 36).map(move |x| y * SIDE as usize + x));
        let (mut red, mut blue, mut count) = (0.0, 0.0, 0.0);
        for at in square {
            let [r, _, b, _] = pixels[at];
            (red, blue, count) = (red + f64::from(r), blue + f64::from(b), count + 1.0);
        }
        [red / count, blue / count]
    })
}

#[test]
fn textures_go_on_beyond_their_edges_as_their_samplers_say() {
    let Some(card) = card("textures_go_on_beyond_their_edges_as_their_samplers_say") else {
        return;
    };
    let mut renderer = Renderer::new(&card.device, &card.queue, wgpu::TextureFormat::Rgba8Unorm);
    // Red, then blue, and a last column of both.
    let color = |x: u8, _: u8| match x {
        0..4 => [200, 0, 0, 255],
        4..7 => [0, 0, 200, 255],
        _ => [200, 0, 200, 255],
    };
    let mut seen = |number: u64, down: bool, code: Option<u32>| {
        let turned = |x, y| if down { color(7 - y, x) } else { color(x, y) };
        let mut scene = board_scene(Material::default(), turned, None);
        let reference = scene.materials[0].base_color_texture.as_mut().unwrap();
        // Twice the image across the picture; turned by a quarter, what is down in the image is across.
        let quarter = std::f32::consts::FRAC_PI_2;
        let turn = if down { quarter } else { 0.0 };
        reference.transform = Some(([0.0, if down { 1.0 } else { 0.0 }], turn, [2.0, 1.0]));
        scene.textures[0].sampler[if down { 3 } else { 2 }] = code;
        let shown = (number, Arc::new(DrawnScene::unbroken(&scene)));
        draw_halves(&card, &mut renderer, shown).map(|square| square.map(|v| v > 60.0))
    };
    let (red, blue, both) = ([true, false], [false, true], [true, true]);
    // Across, the left square shows the second half of the image. Down, v falls from 1 to −1 to the right.
    for (number, down) in [(1, false), (5, true)] {
        assert_eq!(seen(number, down, None), [blue, red]);
        assert_eq!(seen(number + 1, down, Some(10_497)), [blue, red]);
        assert_eq!(seen(number + 2, down, Some(33_071)), [blue, both]);
        assert_eq!(seen(number + 3, down, Some(33_648)), [blue, blue]);
    }
}

#[test]
fn holes_opacity_and_relief_of_materials_are_seen() {
    let Some(card) = card("holes_opacity_and_relief_of_materials_are_seen") else {
        return;
    };
    let mut renderer = Renderer::new(&card.device, &card.queue, wgpu::TextureFormat::Rgba8Unorm);
    let mut number = 0;
    let mut draw = |shown: Arc<DrawnScene>| {
        number += 1;
        draw_halves(&card, &mut renderer, (number, shown))
    };
    // Red, the right half clear.
    let half = |x: u8, _: u8| [200, 0, 0, if x < 4 { 255 } else { 40 }];
    let of = |mode: &str| Material {
        alpha_mode: mode.to_owned(),
        ..Material::default()
    };
    let [left, right] = draw(board(of("OPAQUE"), half, None));
    assert!(left[0] > 60.0 && (left[0] - right[0]).abs() < 25.0 && right[1] < 60.0);
    let [left, right] = draw(board(of("MASK"), half, None));
    assert!(left[0] > 60.0 && left[1] < 60.0, "{left:?}");
    assert!(right[0] < 5.0 && right[1] > 100.0, "a hole: {right:?}");
    // Below the cutoff nothing is clear.
    let lower = Material {
        alpha_cutoff: 0.1,
        ..of("MASK")
    };
    assert!(draw(board(lower, half, None))[1][1] < 60.0);
    // Half clear: both are seen.
    let glass = |_: u8, _: u8| [200, 0, 0, 128];
    let [_, through] = draw(board(of("BLEND"), glass, None));
    assert!(through[0] > 25.0 && through[1] > 60.0, "{through:?}");
    assert!(through[0] < left[0] && through[1] < right[1], "{through:?}");
    // A relief that leans to the key light, on the left and above, is brighter than one that leans away; one that is flat changes nothing.
    let grey = |_: u8, _: u8| [150, 150, 150, 255];
    let leans = |x: u8| Some([x, 128, 220, 255]);
    let [to, away] = [50, 206].map(|x| draw(board(of("OPAQUE"), grey, leans(x)))[0][0]);
    assert!(to > away + 20.0, "{to} {away}");
    let [flat, none] =
        [Some([128, 128, 255, 255]), None].map(|r| draw(board(of("OPAQUE"), grey, r))[0][0]);
    assert!((flat - none).abs() < 2.0, "{flat} {none}");
}
