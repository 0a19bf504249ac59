//! The materials of a film: its own, then those of the input.

use super::error::FilmError;
use super::options::FilmOptions;
use super::run::Run;
use crate::broken::lacks_material;
use crate::materials;
use crate::rods_scene::body_material;
use greenstick_geometry::{Context, Scene};
use greenstick_wood::branch::bark_material;

impl Run {
    /// Returns the materials of all that is shown.
    pub(super) fn materials(
        &self,
        options: &FilmOptions,
        context: &Context,
    ) -> Result<Scene, FilmError> {
        let mut out = Scene::default();
        if options.texture_width > 0 {
            let width = options.texture_width;
            let stem = &self.wood.stem;
            let [inside, outside] = [0, 1].map(|at| context.item(at, 2));
            let baked = materials::bake(stem, self.square, &self.appearance, width, &inside)?;
            materials::add_inner_wood(&mut out, self.square, &baked);
            if stem.kind.has_bark() && lacks_material(&self.bark) {
                let baked = materials::bake_bark(stem, &self.appearance, width, &outside)?;
                materials::add_bark(&mut out, &baked);
            } else {
                out.materials.push(bark_material());
            }
        } else {
            materials::add_plain_inner_wood(&mut out, &self.appearance);
            out.materials.push(bark_material());
        }
        out.materials.push(body_material());
        // Then those of the input.
        let input = &self.wood.input;
        let (textures, images) = (out.textures.len(), out.images.len());
        out.images.extend(input.images.iter().cloned());
        out.textures.extend(input.textures.iter().map(|texture| {
            let mut texture = texture.clone();
            texture.image = texture.image.map(|i| i + images);
            texture.alternatives.iter_mut().for_each(|a| a.1 += images);
            texture
        }));
        out.materials.extend(input.materials.iter().map(|material| {
            let mut material = material.clone();
            for reference in [
                &mut material.base_color_texture,
                &mut material.metallic_roughness_texture,
                &mut material.normal_texture,
                &mut material.occlusion_texture,
                &mut material.emissive_texture,
            ] {
                reference.iter_mut().for_each(|r| r.texture += textures);
            }
            material
        }));
        Ok(out)
    }
}
