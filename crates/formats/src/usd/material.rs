//! Materials as UsdPreviewSurface with their textures (*UsdPreviewSurface Specification*). Texture coordinates have their
//! origin at the bottom here and at the top in glTF, so that a texture's own transform changes too.

use super::layer::{Names, Prim, Property, Value};
use crate::Encoded;
use crate::assemble::{CompanionNames, Surfaces, image_type};
use greenstick_geometry::{ImageSource, Material, TextureReference};

/// Where materials and images of a file are.
pub struct Looks {
    /// The prim that holds the materials.
    pub prim: Prim,
    /// Path of each material.
    pub paths: Vec<String>,
    /// Files of the images that carry their bytes.
    pub files: Vec<Encoded>,
}

/// Whether colours come from the vertices of what a material is on.
pub type Coloured<'a> = &'a [bool];

/// Writes materials below `root`. Images in other forms than PNG and JPEG are left out, which nothing has to know; those
/// that are not at hand too where everything has to be in one file.
pub fn write(
    surfaces: Surfaces,
    coloured: Coloured,
    root: &str,
    name: &str,
    archive: bool,
) -> Looks {
    let mut files = Vec::new();
    let images = images(surfaces, name, archive, &mut files);
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
        name_shown(&mut out, &material.name);
        let to = format!("{path}/surface.outputs:surface");
        out.properties
            .push(Property::connected("outputs:surface", "token", to));
        out.children.push(surface);
        out.children.append(&mut shading.nodes);
        prim.children.push(out);
        paths.push(path);
    }
    Looks { prim, paths, files }
}

/// Keeps a name that USD cannot take as the one to be shown.
pub fn name_shown(prim: &mut Prim, name: &str) {
    if !name.is_empty() && prim.name != name {
        let name = Value::Text(name.to_owned());
        prim.metadata.push(("displayName", name));
    }
}

/// What each image is called where a texture can use it.
fn images(
    surfaces: Surfaces,
    name: &str,
    archive: bool,
    files: &mut Vec<Encoded>,
) -> Vec<Option<String>> {
    let mut names = CompanionNames::new(name);
    let mut out = Vec::new();
    for (number, image) in surfaces.images.iter().enumerate() {
        out.push(match &image.source {
            ImageSource::Reference(path) => {
                let ending = path.rsplit('.').next().map(str::to_ascii_lowercase);
                let known = matches!(ending.as_deref(), Some("png" | "jpg" | "jpeg"));
                // What stands between the signs of a file may not hold them.
                (known && !archive && !path.contains('@')).then(|| path.clone())
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

/// The nodes of one material.
struct Shading<'a> {
    surfaces: Surfaces<'a>,
    images: &'a [Option<String>],
    path: &'a str,
    nodes: Vec<Prim>,
}

fn shader(name: impl Into<String>, id: &str) -> Prim {
    let mut prim = Prim::new(name, "Shader");
    let id = Value::Token(id.to_owned());
    prim.properties
        .push(Property::uniform("info:id", "token", id));
    prim
}

fn set(prim: &mut Prim, name: &str, kind: &'static str, value: Value) {
    prim.properties
        .push(Property::new(format!("inputs:{name}"), kind, value));
}

fn connect(prim: &mut Prim, name: &str, kind: &'static str, to: String) {
    let name = format!("inputs:{name}");
    prim.properties.push(Property::connected(&name, kind, to));
}

fn output(prim: &mut Prim, name: &str, kind: &'static str) {
    let name = format!("outputs:{name}");
    prim.properties.push(Property::new(name, kind, None));
}

/// How a texture's numbers become an input: times, plus.
type Change = ([f32; 4], [f32; 4]);

impl Shading<'_> {
    fn surface(&mut self, material: &Material, coloured: bool) -> Prim {
        let mut out = shader("surface", "UsdPreviewSurface");
        let unit = |v: f32| if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) };
        let color = material.base_color.map(unit);
        let [r, g, b, a] = color;
        let clear = matches!(material.alpha_mode.as_str(), "MASK" | "BLEND");
        let plain = [0.0; 4];
        match self.texture(
            &material.base_color_texture,
            "color",
            "sRGB",
            (color, plain),
        ) {
            Some((from, mut node)) => {
                output(&mut node, "rgb", "float3");
                connect(
                    &mut out,
                    "diffuseColor",
                    "color3f",
                    format!("{from}.outputs:rgb"),
                );
                if clear {
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
                if clear {
                    set(&mut out, "opacity", "float", Value::Float(a));
                }
            }
        }
        if material.alpha_mode == "MASK" {
            let least = Value::Float(unit(material.alpha_cutoff));
            set(&mut out, "opacityThreshold", "float", least);
        }
        let (roughness, metallic) = (unit(material.roughness), unit(material.metallic));
        let scale = ([1.0, roughness, metallic, 1.0], plain);
        match self.texture(&material.metallic_roughness_texture, "finish", "raw", scale) {
            Some((from, mut node)) => {
                for (name, part) in [("roughness", "g"), ("metallic", "b")] {
                    output(&mut node, part, "float");
                    connect(&mut out, name, "float", format!("{from}.outputs:{part}"));
                }
                self.nodes.push(node);
            }
            None => {
                set(&mut out, "roughness", "float", Value::Float(roughness));
                set(&mut out, "metallic", "float", Value::Float(metallic));
            }
        }
        self.relief(material, &mut out);
        output(&mut out, "surface", "token");
        out
    }

    /// Normals, occlusion and light.
    fn relief(&mut self, material: &Material, out: &mut Prim) {
        let strength = |t: &Option<TextureReference>| t.as_ref().map_or(1.0, |t| t.strength);
        let s = strength(&material.normal_texture);
        let bumps = ([2.0 * s, 2.0 * s, 2.0, 1.0], [-s, -s, -1.0, 0.0]);
        if let Some((from, mut node)) =
            self.texture(&material.normal_texture, "bumps", "raw", bumps)
        {
            output(&mut node, "rgb", "float3");
            connect(out, "normal", "normal3f", format!("{from}.outputs:rgb"));
            self.nodes.push(node);
        }
        let s = strength(&material.occlusion_texture);
        let shade = ([s; 4], [1.0 - s; 4]);
        let occlusion = self.texture(&material.occlusion_texture, "shade", "raw", shade);
        if let Some((from, mut node)) = occlusion {
            output(&mut node, "r", "float");
            connect(out, "occlusion", "float", format!("{from}.outputs:r"));
            self.nodes.push(node);
        }
        let light = material
            .emissive
            .map(|v| if v.is_finite() { v } else { 0.0 });
        let [r, g, b] = light;
        let scale = ([r, g, b, 1.0], [0.0; 4]);
        match self.texture(&material.emissive_texture, "light", "sRGB", scale) {
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
            None if light != [0.0; 3] => {
                set(out, "emissiveColor", "color3f", Value::Float3(light));
            }
            None => {}
        }
    }

    /// A node that reads colours of vertices.
    fn vertex_colours(&mut self, otherwise: [f32; 3]) -> String {
        let mut node = shader("colours", "UsdPrimvarReader_float3");
        let name = Value::Text("displayColor".to_owned());
        set(&mut node, "varname", "string", name);
        set(&mut node, "fallback", "float3", Value::Float3(otherwise));
        output(&mut node, "result", "float3");
        self.nodes.push(node);
        format!("{}/colours.outputs:result", self.path)
    }

    /// A node that reads a texture, with its path; nodes it needs go before it.
    fn texture(
        &mut self,
        reference: &Option<TextureReference>,
        name: &str,
        space: &str,
        (scale, bias): Change,
    ) -> Option<(String, Prim)> {
        let reference = reference.as_ref()?;
        let texture = self.surfaces.textures.get(reference.texture)?;
        let file = self.images.get(texture.image?)?.clone()?;
        let place = self.place(reference, name);
        let mut node = shader(name, "UsdUVTexture");
        set(&mut node, "file", "asset", Value::Asset(file));
        connect(&mut node, "st", "float2", place);
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

    /// The output that says where in a texture to look.
    fn place(&mut self, reference: &TextureReference, name: &str) -> String {
        let set_name = coordinates(reference.coordinates);
        let reader = format!("place_{set_name}");
        if !self.nodes.iter().any(|n| n.name == reader) {
            let mut node = shader(reader.as_str(), "UsdPrimvarReader_float2");
            set(&mut node, "varname", "string", Value::Text(set_name));
            output(&mut node, "result", "float2");
            self.nodes.push(node);
        }
        let from = format!("{}/{reader}.outputs:result", self.path);
        let Some((offset, turn, scale)) = reference.transform else {
            return from;
        };
        // Both turn counter-clockwise seen with v upwards; the origin is the other corner.
        let (sin, cos) = (libm::sinf(turn), libm::cosf(turn));
        let offset = [offset[0] + sin * scale[1], 1.0 - offset[1] - cos * scale[1]];
        let own = format!("{name}_transform");
        let mut node = shader(own.as_str(), "UsdTransform2d");
        connect(&mut node, "in", "float2", from);
        set(
            &mut node,
            "rotation",
            "float",
            Value::Float(turn.to_degrees()),
        );
        set(&mut node, "scale", "float2", Value::Float2(scale));
        set(&mut node, "translation", "float2", Value::Float2(offset));
        output(&mut node, "result", "float2");
        self.nodes.push(node);
        format!("{}/{own}.outputs:result", self.path)
    }
}

/// What a set of texture coordinates is called.
pub fn coordinates(set: u32) -> String {
    if set == 0 {
        "st".to_owned()
    } else {
        format!("st{set}")
    }
}
