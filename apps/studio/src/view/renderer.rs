//! Draws the viewport into a picture of its own, only when something changed, and copies it to the window.

use super::camera::Camera;
use super::frame::{Colours, View};
use super::globals::{Globals, globals, surface_numbers};
use super::resources::{
    COLOR, COLORS, DEPTH, NUMBERS, Pipelines, SAMPLES, SHADOW_SIDE, edges, entry, image_sampler,
    image_texture,
};
use super::section::LoadedSection;
use crate::model::look::WoodLook;
use crate::model::materials::{Texture, Wrap};
use crate::model::meshes::{Batch, DrawnScene, Shading};
use crate::model::section::Plane;
use eframe::egui;
use eframe::egui_wgpu::{self, CallbackResources, ScreenDescriptor};
use greenstick::geometry::Pixels;
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// What decides the pixels, to draw only where it changes.
#[derive(Debug, Clone, PartialEq)]
struct Drawn {
    id: u64,
    camera: Camera,
    size: [u32; 2],
    colours: Colours,
    wireframe: bool,
    section: Option<Plane>,
    background: [f32; 3],
}

/// A batch on the card.
struct LoadedBatch {
    /// Its indices.
    range: std::ops::Range<u32>,
    wood: usize,
    material: wgpu::BindGroup,
    /// Whether it may have holes.
    has_holes: bool,
}

/// A scene on the card.
struct Loaded {
    id: u64,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
    /// Two corners of each edge, made when they are first asked for.
    edges: Option<(wgpu::Buffer, u32)>,
    batches: Vec<LoadedBatch>,
    /// What it is loaded from, and on the card its woods and images: those that the next scene has too stay there.
    scene: Arc<DrawnScene>,
    woods: Vec<wgpu::BindGroup>,
    images: Vec<wgpu::TextureView>,
    reliefs: Vec<wgpu::TextureView>,
}

/// An image that is on the card.
fn known_image(
    images: &[Arc<Pixels>],
    views: &[wgpu::TextureView],
    image: &Arc<Pixels>,
) -> Option<wgpu::TextureView> {
    let at = images.iter().position(|i| Arc::ptr_eq(i, image))?;
    views.get(at).cloned()
}

impl Loaded {
    /// The wood on the card that looks so.
    fn wood(&self, look: &WoodLook) -> Option<wgpu::BindGroup> {
        let at = self.scene.woods.iter().position(|w| w == look)?;
        self.woods.get(at).cloned()
    }

    /// The ranges of indices of what has no holes: neighbours as one.
    fn solid_ranges(&self) -> Vec<std::ops::Range<u32>> {
        let mut ranges: Vec<std::ops::Range<u32>> = Vec::new();
        for batch in self.batches.iter().filter(|b| !b.has_holes) {
            match ranges.last_mut() {
                Some(last) if last.end == batch.range.start => last.end = batch.range.end,
                _ => ranges.push(batch.range.clone()),
            }
        }
        ranges
    }

    /// Draws everything by two pipelines: of what has no holes, and of what has, which needs its materials.
    fn draw_all(&self, pass: &mut wgpu::RenderPass, [solid, holes]: [&wgpu::RenderPipeline; 2]) {
        pass.set_pipeline(solid);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        for range in self.solid_ranges() {
            pass.draw_indexed(range, 0, 0..1);
        }
        let with_holes = self.batches.iter().filter(|b| b.has_holes);
        for (i, batch) in with_holes.enumerate() {
            if i == 0 {
                pass.set_pipeline(holes);
            }
            pass.set_bind_group(2, &batch.material, &[]);
            pass.draw_indexed(batch.range.clone(), 0, 0..1);
        }
    }
}

/// The picture that is drawn, of one size.
struct Target {
    size: [u32; 2],
    samples: wgpu::TextureView,
    depth: wgpu::TextureView,
    resolved: wgpu::TextureView,
    copy: wgpu::BindGroup,
    /// How far each pixel is into the picture, with the depth that it is drawn by.
    distance: [wgpu::TextureView; 2],
    /// What all shading reads.
    globals_group: wgpu::BindGroup,
    /// The same as a texture, to be read back.
    texture: wgpu::Texture,
}

/// Draws the viewport.
pub struct Renderer {
    pipelines: Pipelines,
    globals: wgpu::Buffer,
    shadow_map: wgpu::TextureView,
    comparing: wgpu::Sampler,
    shadow_group: wgpu::BindGroup,
    /// Samplers of images, by how coordinates beyond them are read across and down.
    samplers: [[wgpu::Sampler; Wrap::ALL.len()]; Wrap::ALL.len()],
    blank: wgpu::TextureView,
    loaded: Option<Loaded>,
    section: Option<LoadedSection>,
    target: Option<Target>,
    drawn: Option<Drawn>,
}

fn texture(
    device: &wgpu::Device,
    size: [u32; 2],
    format: wgpu::TextureFormat,
    samples: u32,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: size[0],
            height: size[1],
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

const DRAWN_AND_READ: wgpu::TextureUsages =
    wgpu::TextureUsages::RENDER_ATTACHMENT.union(wgpu::TextureUsages::TEXTURE_BINDING);

impl Renderer {
    /// A renderer for a window of this format.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, window: wgpu::TextureFormat) -> Self {
        let pipelines = Pipelines::new(device, window);
        let globals = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("globals"),
            size: size_of::<Globals>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let side = [SHADOW_SIDE; 2];
        let shadow_map = view(&texture(device, side, DEPTH, 1, DRAWN_AND_READ));
        let comparing = device.create_sampler(&wgpu::SamplerDescriptor {
            compare: Some(wgpu::CompareFunction::LessEqual),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..wgpu::SamplerDescriptor::default()
        });
        let shadow_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("shadow"),
            layout: &pipelines.shadow.get_bind_group_layout(0),
            entries: &[entry(0, globals.as_entire_binding())],
        });
        let white = Pixels {
            width: 1,
            height: 1,
            rgba: vec![255; 4],
        };
        Renderer {
            blank: image_texture(device, queue, &white, COLORS),
            pipelines,
            globals,
            shadow_map,
            comparing,
            shadow_group,
            samplers: Wrap::ALL.map(|u| Wrap::ALL.map(|v| image_sampler(device, [u, v]))),
            loaded: None,
            section: None,
            target: None,
            drawn: None,
        }
    }

    /// Draws a frame, unless it is the one that was drawn last. Returns whether it drew.
    pub fn draw(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        frame: &View,
    ) -> bool {
        let wanted = Drawn {
            id: frame.shown.as_ref().map_or(0, |s| s.0),
            camera: frame.camera,
            size: frame.size,
            colours: frame.colours,
            wireframe: frame.wireframe,
            section: frame.section.as_ref().map(|s| s.0),
            background: frame.background,
        };
        if self.drawn.as_ref() == Some(&wanted) {
            return false;
        }
        if self.target.as_ref().is_none_or(|t| t.size != frame.size) {
            self.target = Some(self.make_target(device, frame.size));
        }
        if let Some((id, shown)) = &frame.shown
            && self.loaded.as_ref().is_none_or(|l| l.id != *id)
        {
            self.loaded = Some(self.load(device, queue, *id, shown));
        }
        if frame.wireframe
            && let (Some(loaded), Some((_, shown))) = (&mut self.loaded, &frame.shown)
            && loaded.edges.is_none()
        {
            loaded.edges = Some(edges(device, shown));
        }
        let faces = frame.section.as_ref().map(|s| &s.1);
        self.section = match (faces, self.section.take()) {
            (Some(faces), Some(loaded)) if loaded.is_of(faces) => Some(loaded),
            (Some(faces), _) => {
                let (numbers, blank) = (
                    surface_numbers(&Batch::OPENED_WOOD),
                    (&self.blank, self.sampler([Wrap::Repeat; 2])),
                );
                let numbers = bytemuck::bytes_of(&numbers);
                LoadedSection::new(device, &self.pipelines, blank, numbers, faces)
            }
            (None, _) => None,
        };
        let numbers = globals(frame);
        queue.write_buffer(&self.globals, 0, bytemuck::bytes_of(&numbers));
        self.draw_shadow(encoder);
        self.draw_distance(encoder);
        self.draw_picture(encoder, frame);
        self.drawn = Some(wanted);
        true
    }

    fn sampler(&self, wraps: [Wrap; 2]) -> &wgpu::Sampler {
        let [across, down] = wraps.map(|wrap| wrap as usize);
        &self.samplers[across][down]
    }

    fn make_target(&self, device: &wgpu::Device, size: [u32; 2]) -> Target {
        let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let samples = view(&texture(device, size, COLOR, SAMPLES, drawn));
        let depth = view(&texture(device, size, DEPTH, SAMPLES, drawn));
        let usage = DRAWN_AND_READ | wgpu::TextureUsages::COPY_SRC;
        let texture = texture(device, size, COLOR, 1, usage);
        let resolved = view(&texture);
        let copy = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("copy"),
            layout: &self.pipelines.copy,
            entries: &[
                entry(0, wgpu::BindingResource::TextureView(&resolved)),
                entry(
                    1,
                    wgpu::BindingResource::Sampler(self.sampler([Wrap::Repeat; 2])),
                ),
            ],
        });
        let distance = [COLOR, DEPTH].map(|format| {
            let made = self::texture(device, size, format, 1, DRAWN_AND_READ);
            view(&made)
        });
        let globals_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("globals"),
            layout: &self.pipelines.globals,
            entries: &[
                entry(0, self.globals.as_entire_binding()),
                entry(1, wgpu::BindingResource::TextureView(&self.shadow_map)),
                entry(2, wgpu::BindingResource::Sampler(&self.comparing)),
                entry(3, wgpu::BindingResource::TextureView(&distance[0])),
            ],
        });
        Target {
            size,
            samples,
            depth,
            resolved,
            copy,
            distance,
            globals_group,
            texture,
        }
    }

    fn load(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        id: u64,
        scene: &Arc<DrawnScene>,
    ) -> Loaded {
        let buffer = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: None,
                contents,
                usage,
            })
        };
        let before = self.loaded.as_ref();
        let view = |image, known: Option<wgpu::TextureView>, format| {
            known.unwrap_or_else(|| image_texture(device, queue, image, format))
        };
        let known = |i| before.and_then(|l| known_image(&l.scene.images, &l.images, i));
        let images = scene.images.iter().map(|i| view(i, known(i), COLORS));
        let images: Vec<wgpu::TextureView> = images.collect();
        let known = |i| before.and_then(|l| known_image(&l.scene.reliefs, &l.reliefs, i));
        let reliefs = scene.reliefs.iter().map(|i| view(i, known(i), NUMBERS));
        let reliefs: Vec<wgpu::TextureView> = reliefs.collect();
        let woods: Vec<_> = (scene.woods.iter())
            .map(|look| {
                let known = self.loaded.as_ref().and_then(|l| l.wood(look));
                known.unwrap_or_else(|| self.pipelines.wood_group(device, queue, look))
            })
            .collect();
        let batches = scene.batches.iter();
        let batches = batches.map(|batch| self.load_batch(device, batch, [&images, &reliefs]));
        Loaded {
            id,
            vertices: buffer(
                bytemuck::cast_slice(&scene.vertices),
                wgpu::BufferUsages::VERTEX,
            ),
            indices: buffer(
                bytemuck::cast_slice(&scene.indices),
                wgpu::BufferUsages::INDEX,
            ),
            count: scene.indices.len() as u32,
            edges: None,
            batches: batches.collect(),
            scene: scene.clone(),
            woods,
            images,
            reliefs,
        }
    }

    /// Puts a batch on the card; `images` and `reliefs` are there.
    fn load_batch(
        &self,
        device: &wgpu::Device,
        batch: &Batch,
        [images, reliefs]: [&[wgpu::TextureView]; 2],
    ) -> LoadedBatch {
        let numbers = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::bytes_of(&surface_numbers(batch)),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let image = batch.texture.and_then(|t| images.get(t.image));
        let relief = batch.relief.and_then(|t| reliefs.get(t.image));
        let view = wgpu::BindingResource::TextureView;
        let sampler = |of: Option<Texture>| {
            let wraps = of.map_or([Wrap::Repeat; 2], |t| t.wraps);
            wgpu::BindingResource::Sampler(self.sampler(wraps))
        };
        let material = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("material"),
            layout: &self.pipelines.material,
            entries: &[
                entry(0, numbers.as_entire_binding()),
                entry(1, view(image.unwrap_or(&self.blank))),
                entry(2, sampler(batch.texture)),
                entry(3, view(relief.unwrap_or(&self.blank))),
                entry(4, sampler(batch.relief)),
            ],
        });
        let wood = match batch.shading {
            Shading::Wood(wood) => wood,
            Shading::Material | Shading::Skin => 0,
        };
        LoadedBatch {
            range: batch.first..batch.first + batch.count,
            wood,
            material,
            has_holes: batch.has_holes(),
        }
    }

    fn draw_shadow(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadow"),
            depth_stencil_attachment: Some(depth_attachment(&self.shadow_map)),
            ..wgpu::RenderPassDescriptor::default()
        });
        let Some(loaded) = self.loaded.as_ref().filter(|l| l.count > 0) else {
            return;
        };
        let Pipelines {
            shadow,
            shadow_with_holes,
            ..
        } = &self.pipelines;
        pass.set_bind_group(0, &self.shadow_group, &[]);
        loaded.draw_all(&mut pass, [shadow, shadow_with_holes]);
    }

    fn draw_distance(&self, encoder: &mut wgpu::CommandEncoder) {
        let Some(target) = &self.target else { return };
        let [distance, depth] = &target.distance;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("distance"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: distance,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(depth_attachment(depth)),
            ..wgpu::RenderPassDescriptor::default()
        });
        let Some(loaded) = self.loaded.as_ref().filter(|l| l.count > 0) else {
            return;
        };
        let Pipelines {
            distance,
            distance_with_holes,
            ..
        } = &self.pipelines;
        pass.set_bind_group(0, &self.shadow_group, &[]);
        loaded.draw_all(&mut pass, [distance, distance_with_holes]);
        if let Some(section) = &self.section {
            pass.set_pipeline(distance);
            section.draw_positions(&mut pass);
        }
    }

    fn draw_picture(&self, encoder: &mut wgpu::CommandEncoder, frame: &View) {
        let Some(target) = &self.target else { return };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target.samples,
                depth_slice: None,
                resolve_target: Some(&target.resolved),
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            depth_stencil_attachment: Some(depth_attachment(&target.depth)),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &target.globals_group, &[]);
        pass.set_pipeline(&self.pipelines.background);
        pass.draw(0..3, 0..1);
        let Some(loaded) = self.loaded.as_ref().filter(|l| l.count > 0) else {
            return;
        };
        pass.set_vertex_buffer(0, loaded.vertices.slice(..));
        pass.set_index_buffer(loaded.indices.slice(..), wgpu::IndexFormat::Uint32);
        let (holes, solid): (Vec<_>, Vec<_>) = loaded.batches.iter().partition(|b| b.has_holes);
        // Only materials and wood have holes: the other colours show the triangles.
        let with_holes = match frame.colours {
            Colours::Wood => &self.pipelines.surface_with_holes,
            _ => &self.pipelines.surface,
        };
        for (pipeline, batches) in [(with_holes, holes), (&self.pipelines.surface, solid)] {
            pass.set_pipeline(pipeline);
            for batch in batches {
                let Some(wood) = loaded.woods.get(batch.wood) else {
                    continue;
                };
                pass.set_bind_group(1, wood, &[]);
                pass.set_bind_group(2, &batch.material, &[]);
                pass.draw_indexed(batch.range.clone(), 0, 0..1);
            }
        }
        if let (Some(section), Some(wood)) = (&self.section, loaded.woods.first()) {
            section.draw(&mut pass, wood);
            pass.set_vertex_buffer(0, loaded.vertices.slice(..));
        }
        if let (true, Some((edges, count))) = (frame.wireframe, &loaded.edges) {
            pass.set_pipeline(&self.pipelines.lines);
            pass.set_index_buffer(edges.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..*count, 0, 0..1);
        }
    }

    /// The picture that was drawn last.
    pub fn picture(&self) -> Option<&wgpu::Texture> {
        self.target.as_ref().map(|t| &t.texture)
    }
}

fn depth_attachment(view: &wgpu::TextureView) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Clear(1.0),
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    }
}

impl egui_wgpu::CallbackTrait for View {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _: &ScreenDescriptor,
        encoder: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(renderer) = resources.get_mut::<Renderer>() {
            renderer.draw(device, queue, encoder, self);
        }
        Vec::new()
    }

    fn paint(
        &self,
        _: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        let Some(renderer) = resources.get::<Renderer>() else {
            return;
        };
        if let Some(target) = &renderer.target {
            pass.set_pipeline(&renderer.pipelines.to_window);
            pass.set_bind_group(0, &target.copy, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}
