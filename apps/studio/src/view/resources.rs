//! Pipelines, layouts and textures of the viewport.

use crate::model::look::WoodLook;
use crate::model::materials::Wrap;
use crate::model::meshes::{DrawnScene, Vertex};
use greenstick::geometry::Pixels;
use wgpu::util::DeviceExt;

/// Format of the picture that is drawn: encoded colours, as the shader encodes them itself.
pub const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Formats of textures: of colours, and of what is no colour.
pub const COLORS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
pub const NUMBERS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Format of depths.
pub const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Samples of each pixel.
pub const SAMPLES: u32 = 4;
/// Side of the shadow map: a stem that fills the picture gets a texel for about each pixel.
pub const SHADOW_SIDE: u32 = 2048;
/// Largest side of a texture on the card; larger ones are halved.
const MAX_TEXTURE_SIDE: u32 = 4096;

/// What all drawing needs.
pub struct Pipelines {
    /// Layouts of the groups: everything, a wood, a material, and the copy to the window.
    pub globals: wgpu::BindGroupLayout,
    pub wood: wgpu::BindGroupLayout,
    pub material: wgpu::BindGroupLayout,
    pub copy: wgpu::BindGroupLayout,
    pub surface: wgpu::RenderPipeline,
    pub shadow: wgpu::RenderPipeline,
    pub distance: wgpu::RenderPipeline,
    /// The same for what has holes.
    pub surface_with_holes: wgpu::RenderPipeline,
    pub shadow_with_holes: wgpu::RenderPipeline,
    pub distance_with_holes: wgpu::RenderPipeline,
    pub lines: wgpu::RenderPipeline,
    pub background: wgpu::RenderPipeline,
    pub to_window: wgpu::RenderPipeline,
}

fn uniform(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

fn texture(binding: u32, sample_type: wgpu::TextureSampleType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
}

fn sampler(binding: u32, ty: wgpu::SamplerBindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Sampler(ty),
        count: None,
    }
}

const FILTERED: wgpu::TextureSampleType = wgpu::TextureSampleType::Float { filterable: true };
const EXACT: wgpu::TextureSampleType = wgpu::TextureSampleType::Float { filterable: false };

/// What differs between the pipelines.
struct Plan<'a> {
    layouts: &'a [Option<&'a wgpu::BindGroupLayout>],
    vertex: &'a str,
    fragment: Option<&'a str>,
    /// Whether there are vertices, and all their values or only positions.
    vertices: Option<bool>,
    topology: wgpu::PrimitiveTopology,
    /// Whether there is a depth, and whether it is written.
    depth: Option<bool>,
    target: Option<wgpu::TextureFormat>,
    samples: u32,
    blend: bool,
    /// Whether opacity is the part of the samples that are drawn.
    holes: bool,
}

const ALL_VALUES: [wgpu::VertexAttribute; 5] = wgpu::vertex_attr_array![
    0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Float32x4, 4 => Float32x2
];

fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    plan: &Plan,
) -> wgpu::RenderPipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: plan.layouts,
        immediate_size: 0,
    });
    let buffers = plan.vertices.map(|all| wgpu::VertexBufferLayout {
        array_stride: size_of::<Vertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: if all { &ALL_VALUES } else { &ALL_VALUES[..1] },
    });
    let buffers: Vec<_> = buffers.into_iter().map(Some).collect();
    let targets: Vec<_> = (plan.target)
        .map(|format| {
            Some(wgpu::ColorTargetState {
                format,
                blend: plan.blend.then_some(wgpu::BlendState::ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })
        })
        .into_iter()
        .collect();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(plan.vertex),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(plan.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: plan.topology,
            ..wgpu::PrimitiveState::default()
        },
        depth_stencil: plan.depth.map(|written| wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(written),
            depth_compare: Some(wgpu::CompareFunction::LessEqual),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState {
            count: plan.samples,
            alpha_to_coverage_enabled: plan.holes && plan.samples > 1,
            ..wgpu::MultisampleState::default()
        },
        fragment: plan.fragment.map(|entry| wgpu::FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// The layouts of the groups.
struct Layouts {
    globals: wgpu::BindGroupLayout,
    /// Of what draws the shadow map and the distances, which cannot read them.
    only_numbers: wgpu::BindGroupLayout,
    wood: wgpu::BindGroupLayout,
    material: wgpu::BindGroupLayout,
    copy: wgpu::BindGroupLayout,
}

impl Layouts {
    fn new(device: &wgpu::Device) -> Self {
        let layout = |entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries,
            })
        };
        let filtering = wgpu::SamplerBindingType::Filtering;
        Layouts {
            globals: layout(&[
                uniform(0),
                texture(1, wgpu::TextureSampleType::Depth),
                sampler(2, wgpu::SamplerBindingType::Comparison),
                texture(3, EXACT),
            ]),
            only_numbers: layout(&[uniform(0)]),
            wood: layout(&[uniform(0), texture(1, EXACT), texture(2, EXACT)]),
            material: layout(&[
                uniform(0),
                texture(1, FILTERED),
                sampler(2, filtering),
                texture(3, FILTERED),
                sampler(4, filtering),
            ]),
            copy: layout(&[texture(0, FILTERED), sampler(1, filtering)]),
        }
    }
}

/// The plans for what has holes: of surfaces, of the shadow map and of distances; the latter two read `layouts`.
fn with_holes<'a>(
    surface: &Plan<'a>,
    layouts: &'a [Option<&'a wgpu::BindGroupLayout>],
) -> [Plan<'a>; 3] {
    let of_one_sample = |vertex, fragment, target| Plan {
        layouts,
        vertex,
        fragment: Some(fragment),
        target,
        samples: 1,
        ..*surface
    };
    [
        Plan {
            holes: true,
            ..*surface
        },
        of_one_sample(
            "vertex_shadow_with_holes",
            "fragment_shadow_with_holes",
            None,
        ),
        of_one_sample(
            "vertex_distance_with_holes",
            "fragment_distance_with_holes",
            Some(COLOR),
        ),
    ]
}

impl Pipelines {
    /// The pipelines for a window of this format.
    pub fn new(device: &wgpu::Device, window: wgpu::TextureFormat) -> Self {
        let module = device.create_shader_module(wgpu::include_wgsl!("shader.wgsl"));
        let layouts = Layouts::new(device);
        let globals = [Some(&layouts.globals)];
        let only_numbers = [Some(&layouts.only_numbers)];
        let surface = Plan {
            layouts: &[globals[0], Some(&layouts.wood), Some(&layouts.material)],
            vertex: "vertex_main",
            fragment: Some("fragment_main"),
            vertices: Some(true),
            topology: wgpu::PrimitiveTopology::TriangleList,
            depth: Some(true),
            target: Some(COLOR),
            samples: SAMPLES,
            blend: false,
            holes: false,
        };
        let make = |plan: Plan| pipeline(device, &module, &plan);
        let numbers_and_material = [only_numbers[0], None, Some(&layouts.material)];
        let [surface_with_holes, shadow_with_holes, distance_with_holes] =
            with_holes(&surface, &numbers_and_material).map(make);
        let names = ["fragment_copy", "fragment_copy_linear"];
        let encoded = names[usize::from(window.is_srgb())];
        Pipelines {
            shadow: make(Plan {
                layouts: &only_numbers,
                vertex: "vertex_shadow",
                fragment: Some("fragment_shadow"),
                vertices: Some(false),
                target: None,
                samples: 1,
                ..surface
            }),
            distance: make(Plan {
                layouts: &only_numbers,
                vertex: "vertex_distance",
                fragment: Some("fragment_distance"),
                vertices: Some(false),
                samples: 1,
                ..surface
            }),
            surface_with_holes,
            shadow_with_holes,
            distance_with_holes,
            lines: make(Plan {
                layouts: &globals,
                vertex: "vertex_line",
                fragment: Some("fragment_line"),
                vertices: Some(false),
                topology: wgpu::PrimitiveTopology::LineList,
                depth: Some(false),
                blend: true,
                ..surface
            }),
            background: make(Plan {
                layouts: &globals,
                vertex: "vertex_screen",
                fragment: Some("fragment_background"),
                vertices: None,
                depth: Some(false),
                ..surface
            }),
            to_window: make(Plan {
                layouts: &[Some(&layouts.copy)],
                vertex: "vertex_screen",
                fragment: Some(encoded),
                vertices: None,
                depth: None,
                target: Some(window),
                samples: 1,
                ..surface
            }),
            surface: make(surface),
            globals: layouts.globals,
            wood: layouts.wood,
            material: layouts.material,
            copy: layouts.copy,
        }
    }

    /// The group of a wood.
    pub fn wood_group(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        look: &WoodLook,
    ) -> wgpu::BindGroup {
        let numbers = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("wood"),
            contents: bytemuck::bytes_of(&look.numbers),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let field = exact_texture(device, queue, &look.field, look.field_side);
        let years = exact_texture(device, queue, &look.years, look.years.len() as u32);
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("wood"),
            layout: &self.wood,
            entries: &[
                entry(0, numbers.as_entire_binding()),
                entry(1, wgpu::BindingResource::TextureView(&field)),
                entry(2, wgpu::BindingResource::TextureView(&years)),
            ],
        })
    }
}

/// A sampler of images with halved levels, which reads coordinates beyond 0 to 1 so across and down.
pub fn image_sampler(device: &wgpu::Device, wraps: [Wrap; 2]) -> wgpu::Sampler {
    let [across, down] = wraps.map(|wrap| match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::ClampToEdge => wgpu::AddressMode::ClampToEdge,
        Wrap::MirroredRepeat => wgpu::AddressMode::MirrorRepeat,
    });
    device.create_sampler(&wgpu::SamplerDescriptor {
        address_mode_u: across,
        address_mode_v: down,
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..wgpu::SamplerDescriptor::default()
    })
}

/// An entry of a group.
pub fn entry(binding: u32, resource: wgpu::BindingResource<'_>) -> wgpu::BindGroupEntry<'_> {
    wgpu::BindGroupEntry { binding, resource }
}

/// A texture whose numbers are read as they are, `width` texels in a row.
fn exact_texture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texels: &[[f32; 4]],
    width: u32,
) -> wgpu::TextureView {
    let texture = device.create_texture_with_data(
        queue,
        &wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d {
                width,
                height: texels.len() as u32 / width,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        bytemuck::cast_slice(texels),
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// A texture with its halved levels; of colours by the format of encoded ones.
pub fn image_texture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    image: &Pixels,
    format: wgpu::TextureFormat,
) -> wgpu::TextureView {
    let mut level = Level {
        width: image.width.max(1),
        height: image.height.max(1),
        rgba: image.rgba.as_chunks::<4>().0.to_vec(),
    };
    while level.width.max(level.height) > MAX_TEXTURE_SIDE {
        level = level.halved();
    }
    let size = wgpu::Extent3d {
        width: level.width,
        height: level.height,
        depth_or_array_layers: 1,
    };
    let count = level.width.max(level.height).ilog2() + 1;
    let mut data = level.rgba.concat();
    for _ in 1..count {
        level = level.halved();
        data.extend(level.rgba.concat());
    }
    let texture = device.create_texture_with_data(
        queue,
        &wgpu::TextureDescriptor {
            label: None,
            size,
            mip_level_count: count,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        wgpu::util::TextureDataOrder::LayerMajor,
        &data,
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

struct Level {
    width: u32,
    height: u32,
    rgba: Vec<[u8; 4]>,
}

impl Level {
    /// Half as wide and high, each pixel the mean of those that it stands for.
    fn halved(&self) -> Level {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let at = |x: u32, y: u32| {
            let (x, y) = (x.min(self.width - 1), y.min(self.height - 1));
            self.rgba[(y * self.width + x) as usize].map(u32::from)
        };
        let mut rgba = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                let four = [
                    at(2 * x, 2 * y),
                    at(2 * x + 1, 2 * y),
                    at(2 * x, 2 * y + 1),
                    at(2 * x + 1, 2 * y + 1),
                ];
                rgba.push([0, 1, 2, 3].map(|c| {
                    let sum: u32 = four.iter().map(|p| p[c]).sum();
                    ((sum + 2) / 4) as u8
                }));
            }
        }
        Level {
            width,
            height,
            rgba,
        }
    }
}

/// The edges of all triangles, each once.
pub fn edges(device: &wgpu::Device, scene: &DrawnScene) -> (wgpu::Buffer, u32) {
    let mut list: Vec<[u32; 2]> = Vec::with_capacity(scene.indices.len());
    for &[a, b, c] in scene.indices.as_chunks::<3>().0 {
        list.extend([[a, b], [b, c], [c, a]].map(|[i, j]| [i.min(j), i.max(j)]));
    }
    list.sort_unstable();
    list.dedup();
    let buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("edges"),
        contents: bytemuck::cast_slice(&list),
        usage: wgpu::BufferUsages::INDEX,
    });
    (buffer, 2 * list.len() as u32)
}
