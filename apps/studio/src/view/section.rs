//! The faces of pieces that are cut open, on the card.

use super::resources::{Pipelines, entry};
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
    /// Puts faces on the card, none where there are none; `numbers` are those of their surface, which has no texture but `blank`.
    pub fn new(
        device: &wgpu::Device,
        pipelines: &Pipelines,
        (blank, linear): (&wgpu::TextureView, &wgpu::Sampler),
        numbers: &[u8],
        faces: &Arc<SectionFaces>,
    ) -> Option<Self> {
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
        let numbers = buffer(numbers, wgpu::BufferUsages::UNIFORM);
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
                layout: &pipelines.material,
                entries: &[
                    entry(0, numbers.as_entire_binding()),
                    entry(1, wgpu::BindingResource::TextureView(blank)),
                    entry(2, wgpu::BindingResource::Sampler(linear)),
                    entry(3, wgpu::BindingResource::TextureView(blank)),
                    entry(4, wgpu::BindingResource::Sampler(linear)),
                ],
            }),
            faces: faces.clone(),
        })
    }

    /// Whether these are the faces.
    pub fn is_of(&self, faces: &Arc<SectionFaces>) -> bool {
        Arc::ptr_eq(&self.faces, faces)
    }

    /// Draws where the faces are, by a pipeline that takes positions alone.
    pub fn draw_positions(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.faces.indices.len() as u32, 0, 0..1);
    }

    /// Draws the faces by the pipeline of surfaces.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, wood: &wgpu::BindGroup) {
        pass.set_bind_group(1, wood, &[]);
        pass.set_bind_group(2, &self.material, &[]);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.faces.indices.len() as u32, 0, 0..1);
    }
}
