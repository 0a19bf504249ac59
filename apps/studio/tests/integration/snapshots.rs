//! The main states of the window as pictures, compared with those in `tests/snapshots`. They are drawn by whatever adapter there is;
//! without one the tests say that they did not run, and `.ci/run`, which sets GREENSTICK_NEEDS_ADAPTER, fails.
//!
//! `GREENSTICK_UPDATE_SNAPSHOTS=1 cargo test -p greenstick-studio --test integration snapshots` draws them anew: look at what changed.
//! GREENSTICK_WHOLE_SNAPSHOTS names a folder for the same pictures in their full size, as the documentation has them (`.ci/studio_pictures.py`);
//! nothing is compared then.

use crate::common::{Folder, drag, settle, studio_on};
use crate::picture::adapter;
use crate::simulation::{TORN, scene};
use eframe::egui::{self, Key, Modifiers, TexturesDelta};
use eframe::egui_wgpu::{RenderState, Renderer, RendererOptions, ScreenDescriptor};
use egui_kittest::kittest::Queryable;
use egui_kittest::{Harness, TestRenderer};
use greenstick::formats::photograph::{Photograph, read_photograph};
use greenstick::wood::colour::RgbImage;
use greenstick_studio::model::photograph::reduced;
use greenstick_studio::ui::studio::Studio;
use std::path::Path;
use std::sync::Arc;

/// Size of the window; rows of its pixels are a multiple of 256 bytes.
pub const SIZE: [u32; 2] = [1152, 720];
/// Pixels of the window along a side of one of a snapshot: edges of letters differ from card to card.
const BLOCK: u32 = 2;
/// How far a channel may be off on average, and by how much a pixel is off that counts as another one. Software drivers of two
/// versions differ by less than a tenth of this; a missing panel is off by ten times as much.
const MEAN: f64 = 1.5;
const OTHER: u8 = 40;
/// The part of all pixels that may be others.
const OTHERS: f64 = 0.012;

/// Draws what egui asks for on a card, as a window does.
pub struct CardRenderer(pub RenderState);

impl TestRenderer for CardRenderer {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        let state = &self.0;
        let mut renderer = state.renderer.write();
        for (id, images) in delta.set.drain() {
            for image in images {
                renderer.update_texture(&state.device, &state.queue, id, &image);
            }
        }
        for id in delta.free.drain() {
            renderer.free_texture(&id);
        }
    }
}

/// A card for a test, or a word that there is none.
pub fn card(test: &str) -> Option<RenderState> {
    let (instance, adapter) = adapter(test)?;
    let asked = adapter.request_device(&wgpu::DeviceDescriptor::default());
    let (device, queue) = pollster::block_on(asked).unwrap();
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let renderer = Renderer::new(&device, format, RendererOptions::PREDICTABLE);
    Some(RenderState {
        adapter,
        available_adapters: Vec::new(),
        instance,
        device,
        queue,
        target_format: format,
        renderer: Arc::new(egui::mutex::RwLock::new(renderer)),
    })
}

/// Draws the window and reads it back.
pub fn draw(harness: &Harness<'static, Studio>, state: &RenderState) -> Photograph {
    let (device, queue) = (&state.device, &state.queue);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let screen = ScreenDescriptor {
        pixels_per_point: 1.0,
        size_in_pixels: SIZE,
    };
    let shapes = harness.ctx.tessellate(harness.output().shapes.clone(), 1.0);
    let mut renderer = state.renderer.write();
    let before = renderer.update_buffers(device, queue, &mut encoder, &shapes, &screen);
    let size = wgpu::Extent3d {
        width: SIZE[0],
        height: SIZE[1],
        depth_or_array_layers: 1,
    };
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: state.target_format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    {
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Store,
                },
                depth_slice: None,
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        renderer.render(&mut pass.forget_lifetime(), &shapes, &screen);
    }
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(4 * SIZE[0] * SIZE[1]),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(4 * SIZE[0]),
        rows_per_image: None,
    };
    let copy = wgpu::TexelCopyBufferInfo {
        buffer: &buffer,
        layout,
    };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), copy, size);
    queue.submit(before.into_iter().chain([encoder.finish()]));
    buffer
        .slice(..)
        .map_async(wgpu::MapMode::Read, |r| r.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let bytes = buffer.slice(..).get_mapped_range().unwrap().to_vec();
    let rgb = bytes
        .as_chunks::<4>()
        .0
        .iter()
        .flat_map(|p| [p[0], p[1], p[2]]);
    Photograph {
        width: SIZE[0],
        height: SIZE[1],
        rgb: rgb.collect(),
    }
}

fn png(picture: &Photograph) -> Vec<u8> {
    let image = RgbImage {
        width: picture.width,
        height: picture.height,
        rgb: picture.rgb.clone(),
    };
    image.png()
}

/// A picture of the window without the margin that tests draw around it.
fn inner(whole: &Photograph) -> Photograph {
    const MARGIN: u32 = 8;
    let row = |y: u32| {
        let from = 3 * (y * whole.width + MARGIN) as usize;
        let to = 3 * ((y + 1) * whole.width - MARGIN) as usize;
        whole.rgb[from..to].iter().copied()
    };
    Photograph {
        width: whole.width - 2 * MARGIN,
        height: whole.height - 2 * MARGIN,
        rgb: (MARGIN..whole.height - MARGIN).flat_map(row).collect(),
    }
}

/// Compares the window with the snapshot of a name.
fn check(harness: &mut Harness<'static, Studio>, state: &RenderState, name: &str) {
    // Away from what would show a tooltip.
    harness.hover_at(egui::pos2(-10.0, -10.0));
    check_with_pointer(harness, state, name);
}

/// The same with the pointer where it is.
fn check_with_pointer(harness: &mut Harness<'static, Studio>, state: &RenderState, name: &str) {
    harness.run_steps(30);
    let whole = draw(harness, state);
    if let Some(folder) = std::env::var_os("GREENSTICK_WHOLE_SNAPSHOTS") {
        let path = Path::new(&folder).join(format!("{name}.png"));
        std::fs::write(path, png(&inner(&whole))).unwrap();
        if std::env::var_os("GREENSTICK_UPDATE_SNAPSHOTS").is_none() {
            return;
        }
    }
    let now = reduced(&whole, SIZE[0] / BLOCK);
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/snapshots");
    let path = folder.join(format!("{name}.png"));
    if std::env::var_os("GREENSTICK_UPDATE_SNAPSHOTS").is_some() {
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(&path, png(&now)).unwrap();
        return;
    }
    let known = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let known = read_photograph(&known).unwrap();
    assert_eq!(
        (known.width, known.height),
        (now.width, now.height),
        "{name}"
    );
    let off: Vec<u8> = (known.rgb.iter().zip(&now.rgb))
        .map(|(a, b)| a.abs_diff(*b))
        .collect();
    let mean = off.iter().map(|o| f64::from(*o)).sum::<f64>() / off.len() as f64;
    let others = off
        .as_chunks::<3>()
        .0
        .iter()
        .filter(|p| p.iter().any(|o| *o > OTHER));
    let others = others.count() as f64 / (off.len() / 3) as f64;
    println!(
        "{name}: off by {mean:.3} on average, {:.3} % others",
        100.0 * others
    );
    if mean > MEAN || others > OTHERS {
        let seen = std::env::temp_dir().join(format!("greenstick-{name}.png"));
        std::fs::write(&seen, png(&now)).unwrap();
        panic!(
            "{name}: off by {mean:.2} on average, {:.2} % of the pixels are others; what was drawn is {}",
            100.0 * others,
            seen.display()
        );
    }
}

/// Turns the picture so that the broken face is seen from above, and goes nearer by some notches of the wheel.
fn from_above(harness: &mut Harness<'static, Studio>, notches: usize) {
    let corner = egui::pos2(640.0, 600.0);
    drag(harness, corner, corner + egui::vec2(0.0, 70.0));
    let face = harness.state_mut().face_place_at(0.0, 0.0).unwrap();
    harness.hover_at(face);
    for _ in 0..notches {
        harness.event(egui::Event::MouseWheel {
            unit: egui::MouseWheelUnit::Line,
            delta: egui::vec2(0.0, 1.0),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Unknown,
            modifiers: Modifiers::NONE,
        });
        harness.step();
    }
}

/// The window on a card.
pub fn window(
    folder: &Folder,
    path: Option<&str>,
    state: &RenderState,
) -> Harness<'static, Studio> {
    let size = egui::vec2(SIZE[0] as f32, SIZE[1] as f32);
    let mut harness = studio_on(folder, path, size, CardRenderer(state.clone()));
    let ctx = harness.ctx.clone();
    harness.state_mut().use_card(&ctx, state);
    settle(&mut harness);
    harness
}

#[test]
fn the_built_in_branch_an_open_chapter_and_the_rings_look_as_they_did() {
    let test = "the_built_in_branch_an_open_chapter_and_the_rings_look_as_they_did";
    let Some(state) = card(test) else { return };
    let folder = Folder::new();
    let mut harness = window(&folder, None, &state);
    check(&mut harness, &state, "branch");
    harness.get_by_label("Where").click();
    harness.run_steps(20);
    harness.get_by_label("Annual rings").scroll_to_me();
    harness.run_steps(20);
    harness.get_by_label("Annual rings").click();
    check(&mut harness, &state, "chapter");
    harness.key_press(Key::S);
    settle(&mut harness);
    check(&mut harness, &state, "rings");
}

#[test]
fn placed_cracks_and_a_dragged_ring_look_as_they_did() {
    let Some(state) = card("placed_cracks_and_a_dragged_ring_look_as_they_did") else {
        return;
    };
    let folder = Folder::new();
    let mut harness = window(&folder, None, &state);
    harness.get_by_label("brash").click();
    settle(&mut harness);
    harness.key_press(Key::S);
    settle(&mut harness);
    let from = harness.state().ring_at(4, 0.0).unwrap();
    let to = harness.state().ring_at(5, 0.0).unwrap();
    drag(&mut harness, from, from + (to - from) * 0.6);
    check(&mut harness, &state, "dragged");
    harness.key_press(Key::S);
    harness.run_steps(5);
    from_above(&mut harness, 9);
    harness.key_press(Key::K);
    harness.run_steps(2);
    for (from, to) in [
        ((0.15, 0.7), (0.75, 0.7)),
        ((0.3, 2.7), (1.0, 2.7)),
        ((0.62, -2.2), (0.62, -0.9)),
    ] {
        let place = |harness: &mut Harness<'static, Studio>, (rho, angle)| {
            harness.state_mut().face_place_at(rho, angle).unwrap()
        };
        let (from, to) = (place(&mut harness, from), place(&mut harness, to));
        drag(&mut harness, from, to);
    }
    assert_eq!(harness.state().project.placed_cracks().len(), 3);
    check(&mut harness, &state, "cracks");
}

#[test]
fn a_simulation_looks_as_it_did() {
    let Some(state) = card("a_simulation_looks_as_it_did") else {
        return;
    };
    let folder = Folder::new();
    let mut harness = window(&folder, Some(&scene(&folder, TORN)), &state);
    harness.get_by_label("Rods").click();
    settle(&mut harness);
    check(&mut harness, &state, "simulation");
    harness.get_by_label("To the first frame").click();
    harness.run_steps(3);
    settle(&mut harness);
    let part = greenstick_studio::model::holds::HoldPart::ClampTo(0);
    let dot = harness.state().hold_dot(part).unwrap();
    harness.hover_at(dot);
    check_with_pointer(&mut harness, &state, "holds");
}

#[test]
fn a_hand_that_pulls_looks_as_it_did() {
    let Some(state) = card("a_hand_that_pulls_looks_as_it_did") else {
        return;
    };
    let folder = Folder::new();
    let mut harness = window(&folder, None, &state);
    settle(&mut harness);
    harness.key_press(Key::L);
    harness.run_steps(2);
    settle(&mut harness);
    let from = harness.state().stem_place(0.85).unwrap();
    harness.hover_at(from);
    harness.step();
    harness.drag_at(from);
    harness.step();
    for i in 1..=6 {
        harness.hover_at(from + egui::vec2(4.0, 22.0) * i as f32);
        harness.step();
    }
    check_with_pointer(&mut harness, &state, "pulling");
}

#[test]
fn the_list_of_keys_looks_as_it_did() {
    let Some(state) = card("the_list_of_keys_looks_as_it_did") else {
        return;
    };
    let folder = Folder::new();
    let mut harness = window(&folder, None, &state);
    harness.key_press_modifiers(Modifiers::NONE, Key::F1);
    check(&mut harness, &state, "keys");
}

#[test]
fn the_handles_of_the_zones_look_as_they_did() {
    let test = "the_handles_of_the_zones_look_as_they_did";
    let Some(state) = card(test) else { return };
    let folder = Folder::new();
    let project = folder.0.join("layers.greenstick.toml");
    let settings = [
        "break.high.height=1.2",
        "break.high.direction=250",
        "break.high.angle=100",
        "break.high.rings=0.45",
        "break.ductile.direction=300",
    ];
    let file = greenstick::RequestFile::resolve(&[], None, &settings).unwrap();
    std::fs::write(&project, file.to_toml()).unwrap();
    let mut harness = window(&folder, project.to_str(), &state);
    from_above(&mut harness, 7);
    for name in ["ductile", "high"] {
        harness.key_press_modifiers(Modifiers::SHIFT, Key::H);
        harness.step();
        let part = greenstick_studio::model::fan::FanPart::End;
        let dot = harness.state_mut().fan_dot(part).unwrap();
        harness.hover_at(dot);
        check_with_pointer(&mut harness, &state, name);
    }
}

#[test]
fn a_painted_face_looks_as_it_did() {
    let Some(state) = card("a_painted_face_looks_as_it_did") else {
        return;
    };
    let folder = Folder::new();
    let mut harness = window(&folder, None, &state);
    harness.get_by_label("brash").click();
    settle(&mut harness);
    from_above(&mut harness, 9);
    harness.key_press(Key::B);
    harness.run_steps(2);
    harness.state_mut().paint.brush.strength = 1.0;
    // Single dabs on a face that has settled: what a stroke meets depends on how fast its answers come.
    let mut dab = |label: &str, place: (f32, f32)| {
        harness.get_by_label(label).click();
        harness.run_steps(2);
        let at = harness.state_mut().face_place_at(place.0, place.1).unwrap();
        drag(&mut harness, at, at);
        at
    };
    for k in 0..6 {
        dab("Stay", (0.75, 2.4 + 0.24 * k as f32));
    }
    let mut end = dab("Splinter", (0.6, 6.6));
    for k in 0..6 {
        end = dab("Splinter", (0.6, 6.4 - 0.24 * k as f32));
    }
    harness.hover_at(end);
    check_with_pointer(&mut harness, &state, "painted");
}

#[test]
fn several_breaks_colours_and_a_photograph_look_as_they_did() {
    let test = "several_breaks_colours_and_a_photograph_look_as_they_did";
    let Some(state) = card(test) else { return };
    let folder = Folder::new();
    let mut harness = window(&folder, None, &state);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let photograph = root.join("docs/pictures/presets/splintering-tension.png");
    harness.state_mut().open(photograph.to_str().unwrap());
    settle(&mut harness);
    harness.get_by_label("beside").click();
    check(&mut harness, &state, "photograph");
    harness.get_by_label("Remove").click();
    harness.run_steps(2);
    for _ in 0..2 {
        harness.key_press(Key::A);
        settle(&mut harness);
    }
    harness.key_press(Key::Home);
    check(&mut harness, &state, "several");
    let folder = Folder::new();
    let mut harness = window(&folder, None, &state);
    from_above(&mut harness, 7);
    harness.key_press(Key::C);
    harness.key_press(Key::C);
    check(&mut harness, &state, "colours");
}
