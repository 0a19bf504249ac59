//! Prints how long frames of the viewport take on the graphics adapter at hand while the picture is turned, and the first one of a face
//! that is not on the card yet, for faces of several finenesses and pictures of several sizes.

use glam::Vec2;
use greenstick::RequestFile;
use greenstick::geometry::Context;
use greenstick_studio::model::engine::{Engine, Haste, Job};
use greenstick_studio::model::input::Input;
use greenstick_studio::model::meshes::DrawnScene;
use greenstick_studio::view::camera::Camera;
use greenstick_studio::view::frame::{Colours, View};
use greenstick_studio::view::renderer::Renderer;
use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

/// Frames of each case.
const FRAMES: usize = 120;
/// Width and height of a laptop's, a desktop's and a 4K screen, pixels.
const SIZES: [[u32; 2]; 3] = [[1280, 800], [1920, 1080], [3840, 2160]];

/// A card without a window.
struct Card {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

impl Card {
    fn new() -> Result<Self, Box<dyn Error>> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..wgpu::RequestAdapterOptions::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options))?;
        let about = adapter.get_info();
        println!(
            "{} ({:?}, {})",
            about.name, about.backend, about.driver_info
        );
        let asked = adapter.request_device(&wgpu::DeviceDescriptor::default());
        let (device, queue) = pollster::block_on(asked)?;
        Ok(Card { device, queue })
    }

    /// Draws a frame, waits until the card has done it, and returns how long that took, ms.
    fn draw(&self, renderer: &mut Renderer, frame: &View) -> Result<f64, Box<dyn Error>> {
        let start = Instant::now();
        let mut encoder = (self.device).create_command_encoder(&Default::default());
        renderer.draw(&self.device, &self.queue, &mut encoder, frame);
        self.queue.submit([encoder.finish()]);
        self.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(1e3 * start.elapsed().as_secs_f64())
    }
}

/// The built-in branch, broken with a face of n × n.
fn broken(n: u32) -> Result<Arc<DrawnScene>, Box<dyn Error>> {
    let settings = [format!("break.rings={n}"), format!("break.sectors={n}")];
    let settings = settings.each_ref().map(String::as_str);
    let job = Job {
        input: Input::built_in(),
        file: RequestFile::resolve(&[], None, &settings)?,
        haste: Haste::Whole,
        sections_of: None,
    };
    let shown = Engine::default().work(&job, &mut |_| {}, &Context::quiet())?;
    Ok(Arc::new(shown.ok_or("nothing is shown")?.drawn))
}

fn main() -> Result<(), Box<dyn Error>> {
    let card = Card::new()?;
    println!("face       triangles  picture       first ms  median ms  slowest of 100 ms");
    for (id, n) in [40, 100, 200].into_iter().enumerate() {
        let shown = broken(n)?;
        let at = *shown.breaks.first().ok_or("nothing is broken")?;
        for size in SIZES {
            let mut renderer =
                Renderer::new(&card.device, &card.queue, wgpu::TextureFormat::Rgba8Unorm);
            let mut camera = Camera::default();
            let aspect = size[0] as f32 / size[1] as f32;
            let reach = 0.5 * (at.heights[1] - at.heights[0]);
            camera.frame(at.place, 3.0 * at.radius + reach, aspect);
            let mut times = Vec::with_capacity(FRAMES);
            for _ in 0..FRAMES {
                camera.orbit(Vec2::new(2.0, 0.0));
                let frame = View {
                    shown: Some((id as u64 + 1, shown.clone())),
                    camera,
                    size,
                    colours: Colours::Wood,
                    wireframe: false,
                    section: None,
                    background: [0.1, 0.1, 0.1],
                };
                times.push(card.draw(&mut renderer, &frame)?);
            }
            let first = times.remove(0);
            times.sort_by(f64::total_cmp);
            println!(
                "{n:3} × {n:3}  {:9}  {:4} × {:4}  {first:8.1}  {:9.2}  {:17.2}",
                shown.indices.len() / 3,
                size[0],
                size[1],
                times[times.len() / 2],
                times[times.len() * 99 / 100]
            );
        }
    }
    Ok(())
}
