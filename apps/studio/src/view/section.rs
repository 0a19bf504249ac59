//! The faces of pieces that are cut open, on the card.

use super::renderer::{Loaded, Renderer, surface_numbers};
use super::resources::entry;
use crate::model::meshes::{Batch, Shading};
use crate::model::section::SectionFaces;
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// Faces on the card.
pub(super) struct LoadedSection {
    faces: Arc<SectionFaces>,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    material: wgpu::BindGroup,
}

impl LoadedSection {
    pub(super) fn is_of(&self, faces: &Arc<SectionFaces>) -> bool {
        Arc::ptr_eq(&self.faces, faces)
    }
}

/// Wood without a texture.
const WOOD: Batch = Batch {
    material: 0,
    first: 0,
    count: 0,
    shading: Shading::Wood(0),
    base: [0.5, 0.35, 0.2, 1.0],
    metal_rough: [0.0, 0.8],
    texture: None,
};

impl Renderer {
    /// Puts faces on the card; none where there are none.
    pub(super) fn load_section(
        &self,
        device: &wgpu::Device,
        faces: &Arc<SectionFaces>,
    ) -> Option<LoadedSection> {
        if faces.indices.is_empty() {
            return None;
        }
        let buffer = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("section"),
                contents,
                usage,
            })
        };
        let numbers = surface_numbers(&WOOD);
        let numbers = buffer(bytemuck::bytes_of(&numbers), wgpu::BufferUsages::UNIFORM);
        Some(LoadedSection {
            vertices: buffer(
                bytemuck::cast_slice(&faces.vertices),
                wgpu::BufferUsages::VERTEX,
            ),
            indices: buffer(
                bytemuck::cast_slice(&faces.indices),
                wgpu::BufferUsages::INDEX,
            ),
            material: device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("section"),
                layout: &self.pipelines.material,
                entries: &[
                    entry(0, numbers.as_entire_binding()),
                    entry(1, wgpu::BindingResource::TextureView(&self.blank)),
                    entry(2, wgpu::BindingResource::Sampler(&self.linear)),
                ],
            }),
            faces: faces.clone(),
        })
    }

    /// Draws the faces that are loaded, after the surfaces.
    pub(super) fn draw_section(&self, pass: &mut wgpu::RenderPass<'_>, loaded: &Loaded) {
        let (Some(section), Some(wood)) = (&self.section, loaded.woods.first()) else {
            return;
        };
        pass.set_bind_group(1, wood, &[]);
        pass.set_bind_group(2, &section.material, &[]);
        pass.set_vertex_buffer(0, section.vertices.slice(..));
        pass.set_index_buffer(section.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..section.faces.indices.len() as u32, 0, 0..1);
        pass.set_vertex_buffer(0, loaded.vertices.slice(..));
    }
}
