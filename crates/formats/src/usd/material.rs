//! Materials as UsdPreviewSurface with their textures (*UsdPreviewSurface Specification*). The origin of texture
//! coordinates is at the bottom in USD and at the top in glTF, so that the transform of a texture changes, too.

use super::layer::{Prim, Property, Value};
use super::names::{Names, set_display_name};
use crate::check::Surfaces;
use crate::companions::Encoded;
use crate::companions::{CompanionNames, image_type};
use greenstick_geometry::{ImageSource, Material, TextureReference};

/// The materials of a layer with their textures.
pub(super) struct Materials {
    /// The prim that contains the materials.
    pub prim: Prim,
    /// Path of each material.
    pub paths: Vec<String>,
    /// Texture files of embedded images.
    pub files: Vec<Encoded>,
}

/// Converts materials to prims under `root`. `coloured` says which of them take colours from vertices. Images other than
/// PNG and JPEG, which readers need not support, are left out, and in archives also images that are only referenced.
pub(super) fn write(
    surfaces: Surfaces,
    coloured: &[bool],
    root: &str,
    name: &str,
    is_archive: bool,
) -> Materials {
    let mut files = Vec::new();
    let images = image_paths(surfaces, name, is_archive, &mut files);
    let mut prim = Prim::new("materials", "Scope");
    let mut names = Names::default();
    let mut paths = Vec::new();
    for (m, material) in surfaces.materials.iter().enumerate() {
        let own = names.unique(&material.name, "material");
        let path = format!("{root}/materials/{own}");
        let mut shading = Shading {
            surfaces,
            images: &images,
            path: &path,
            nodes: Vec::new(),
        };
        let surface = shading.surface(material, coloured.get(m) == Some(&true));
        let mut out = Prim::new(own, "Material");
        set_display_name(&mut out, &material.name);
        let to = format!("{path}/surface.outputs:surface");
        out.properties
            .push(Property::connected("outputs:surface", "token", to));
        out.children.push(surface);
        out.children.append(&mut shading.nodes);
        prim.children.push(out);
        paths.push(path);
    }
    Materials { prim, paths, files }
}

/// The path of each image, if textures can use it.
fn image_paths(
    surfaces: Surfaces,
    name: &str,
    is_archive: bool,
    files: &mut Vec<Encoded>,
) -> Vec<Option<String>> {
    let mut names = CompanionNames::new(name);
    let mut out = Vec::new();
    for (number, image) in surfaces.images.iter().enumerate() {
        out.push(match &image.source {
            ImageSource::Reference(path) => {
                let extension = path.rsplit('.').next().map(str::to_ascii_lowercase);
                let known = matches!(extension.as_deref(), Some("png" | "jpg" | "jpeg"));
                // Asset paths are delimited by `@`.
                (known && !is_archive && !path.contains('@')).then(|| path.clone())
            }
            ImageSource::Bytes(bytes) => {
                let kind = image_type(&image.mime_type, bytes);
                matches!(kind.as_str(), "image/png" | "image/jpeg").then(|| {
                    let file = names.image(image, number, bytes);
                    files.push(Encoded {
                        name: file.clone(),
                        bytes: bytes.clone(),
                    });
                    file
                })
            }
        });
    }
    out
}

/// The shading network of one material.
struct Shading<'a> {
    surfaces: Surfaces<'a>,
    images: &'a [Option<String>],
    path: &'a str,
    nodes: Vec<Prim>,
}

/// Creates a shader prim.
fn shader(name: impl Into<String>, id: &str) -> Prim {
    let mut prim = Prim::new(name, "Shader");
    let id = Value::Token(id.to_owned());
    prim.properties
        .push(Property::uniform("info:id", "token", id));
    prim
}

/// Sets an input to a value.
fn set(prim: &mut Prim, name: &str, kind: &'static str, value: Value) {
    prim.properties
        .push(Property::new(format!("inputs:{name}"), kind, value));
}

/// Connects an input to an output.
fn connect(prim: &mut Prim, name: &str, kind: &'static str, to: String) {
    let name = format!("inputs:{name}");
    prim.properties.push(Property::connected(&name, kind, to));
}

/// Adds an output.
fn output(prim: &mut Prim, name: &str, kind: &'static str) {
    let name = format!("outputs:{name}");
    prim.properties.push(Property::new(name, kind, None));
}

/// The linear map from the values of a texture to an input.
struct LinearMap {
    scale: [f32; 4],
    bias: [f32; 4],
}

impl Shading<'_> {
    /// Creates the surface shader.
    fn surface(&mut self, material: &Material, coloured: bool) -> Prim {
        let mut out = shader("surface", "UsdPreviewSurface");
        let unit = |v: f32| if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) };
        let color = material.base_color.map(unit);
        let [r, g, b, a] = color;
        let has_opacity = matches!(material.alpha_mode.as_str(), "MASK" | "BLEND");
        let scaled = |scale: [f32; 4]| LinearMap {
            scale,
            bias: [0.0; 4],
        };
        match self.texture(&material.base_color_texture, "color", "sRGB", scaled(color)) {
            Some((from, mut node)) => {
                output(&mut node, "rgb", "float3");
                connect(
                    &mut out,
                    "diffuseColor",
                    "color3f",
                    format!("{from}.outputs:rgb"),
                );
                if has_opacity {
                    output(&mut node, "a", "float");
                    connect(&mut out, "opacity", "float", format!("{from}.outputs:a"));
                }
                self.nodes.push(node);
            }
            None => {
                if coloured {
                    let from = self.vertex_colours([r, g, b]);
                    connect(&mut out, "diffuseColor", "color3f", from);
                } else {
                    set(
                        &mut out,
                        "diffuseColor",
                        "color3f",
                        Value::Float3([r, g, b]),
                    );
                }
                if has_opacity {
                    set(&mut out, "opacity", "float", Value::Float(a));
                }
            }
        }
        if material.alpha_mode == "MASK" {
            let least = Value::Float(unit(material.alpha_cutoff));
            set(&mut out, "opacityThreshold", "float", least);
        }
        let (roughness, metallic) = (unit(material.roughness), unit(material.metallic));
        let map = scaled([1.0, roughness, metallic, 1.0]);
        match self.texture(&material.metallic_roughness_texture, "finish", "raw", map) {
            Some((from, mut node)) => {
                for (name, channel) in [("roughness", "g"), ("metallic", "b")] {
                    output(&mut node, channel, "float");
                    connect(&mut out, name, "float", format!("{from}.outputs:{channel}"));
                }
                self.nodes.push(node);
            }
            None => {
                set(&mut out, "roughness", "float", Value::Float(roughness));
                set(&mut out, "metallic", "float", Value::Float(metallic));
            }
        }
        self.other_textures(material, &mut out);
        output(&mut out, "surface", "token");
        out
    }

    /// Adds normals, occlusion and emission.
    fn other_textures(&mut self, material: &Material, out: &mut Prim) {
        let strength = |t: &Option<TextureReference>| t.as_ref().map_or(1.0, |t| t.strength);
        let s = strength(&material.normal_texture);
        let map = LinearMap {
            scale: [2.0 * s, 2.0 * s, 2.0, 1.0],
            bias: [-s, -s, -1.0, 0.0],
        };
        if let Some((from, mut node)) = self.texture(&material.normal_texture, "bumps", "raw", map)
        {
            output(&mut node, "rgb", "float3");
            connect(out, "normal", "normal3f", format!("{from}.outputs:rgb"));
            self.nodes.push(node);
        }
        let s = strength(&material.occlusion_texture);
        let map = LinearMap {
            scale: [s; 4],
            bias: [1.0 - s; 4],
        };
        let occlusion = self.texture(&material.occlusion_texture, "shade", "raw", map);
        if let Some((from, mut node)) = occlusion {
            output(&mut node, "r", "float");
            connect(out, "occlusion", "float", format!("{from}.outputs:r"));
            self.nodes.push(node);
        }
        let emissive = material
            .emissive
            .map(|v| if v.is_finite() { v } else { 0.0 });
        let [r, g, b] = emissive;
        let map = LinearMap {
            scale: [r, g, b, 1.0],
            bias: [0.0; 4],
        };
        match self.texture(&material.emissive_texture, "light", "sRGB", map) {
            Some((from, mut node)) => {
                output(&mut node, "rgb", "float3");
                connect(
                    out,
                    "emissiveColor",
                    "color3f",
                    format!("{from}.outputs:rgb"),
                );
                self.nodes.push(node);
            }
            None if emissive != [0.0; 3] => {
                set(out, "emissiveColor", "color3f", Value::Float3(emissive));
            }
            None => {}
        }
    }

    /// Adds a shader that reads vertex colours. Returns the path of its output.
    fn vertex_colours(&mut self, fallback: [f32; 3]) -> String {
        let mut node = shader("colours", "UsdPrimvarReader_float3");
        let name = Value::Text("displayColor".to_owned());
        set(&mut node, "varname", "string", name);
        set(&mut node, "fallback", "float3", Value::Float3(fallback));
        output(&mut node, "result", "float3");
        self.nodes.push(node);
        format!("{}/colours.outputs:result", self.path)
    }

    /// Creates a shader that reads a texture. Returns its path and its prim; the shaders that it needs are added before it.
    fn texture(
        &mut self,
        reference: &Option<TextureReference>,
        name: &str,
        space: &str,
        map: LinearMap,
    ) -> Option<(String, Prim)> {
        let reference = reference.as_ref()?;
        let texture = self.surfaces.textures.get(reference.texture)?;
        let file = self.images.get(texture.image?)?.clone()?;
        let LinearMap { scale, bias } = map;
        let coordinates = self.coordinates(reference, name);
        let mut node = shader(name, "UsdUVTexture");
        set(&mut node, "file", "asset", Value::Asset(file));
        connect(&mut node, "st", "float2", coordinates);
        for (key, code) in [("wrapS", texture.sampler[2]), ("wrapT", texture.sampler[3])] {
            let word = match code {
                Some(33071) => "clamp",
                Some(33648) => "mirror",
                _ => "repeat",
            };
            set(&mut node, key, "token", Value::Token(word.to_owned()));
        }
        let space = Value::Token(space.to_owned());
        set(&mut node, "sourceColorSpace", "token", space);
        if scale != [1.0; 4] {
            set(&mut node, "scale", "float4", Value::Float4(scale));
        }
        if bias != [0.0; 4] {
            set(&mut node, "bias", "float4", Value::Float4(bias));
        }
        Some((format!("{}/{name}", self.path), node))
    }

    /// Adds shaders that compute texture coordinates. Returns the path of their output.
    fn coordinates(&mut self, reference: &TextureReference, name: &str) -> String {
        let set_name = coordinate_set(reference.coordinates);
        let reader = format!("place_{set_name}");
        if !self.nodes.iter().any(|n| n.name == reader) {
            let mut node = shader(reader.as_str(), "UsdPrimvarReader_float2");
            set(&mut node, "varname", "string", Value::Text(set_name));
            output(&mut node, "result", "float2");
            self.nodes.push(node);
        }
        let from = format!("{}/{reader}.outputs:result", self.path);
        let Some((offset, rotation, scale)) = reference.transform else {
            return from;
        };
        // Both rotate counter-clockwise with v pointing up, but about different corners.
        let (sin, cos) = (libm::sinf(rotation), libm::cosf(rotation));
        let offset = [offset[0] + sin * scale[1], 1.0 - offset[1] - cos * scale[1]];
        let own = format!("{name}_transform");
        let mut node = shader(own.as_str(), "UsdTransform2d");
        connect(&mut node, "in", "float2", from);
        set(
            &mut node,
            "rotation",
            "float",
            Value::Float(rotation.to_degrees()),
        );
        set(&mut node, "scale", "float2", Value::Float2(scale));
        set(&mut node, "translation", "float2", Value::Float2(offset));
        output(&mut node, "result", "float2");
        self.nodes.push(node);
        format!("{}/{own}.outputs:result", self.path)
    }
}

/// The name of a set of texture coordinates.
pub(super) fn coordinate_set(set: u32) -> String {
    if set == 0 {
        "st".to_owned()
    } else {
        format!("st{set}")
    }
}
