//! A film for tests: a bent stick whose skin follows joints along it, a half that breaks off and flies away, a hammer that
//! moves, and an anvil that does not.

use glam::{DAffine3, DQuat, DVec3};
use greenstick_geometry::{
    Attribute, Binding, Extra, Film, Image, ImageSource, Joint, Material, Mesh, Motion, Node, Pose,
    RigidBody, SkinnedMesh, Texture, TextureReference,
};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::f64::consts::TAU;

/// Vertices around the stick.
const AROUND: usize = 12;

/// Half the stick's thickness, m.
const RADIUS: f64 = 0.02;

/// The film. The joints are those along the stick, that of the half, that of the hammer, and one that nothing follows.
pub fn film(joints: usize, rings: usize, influences: usize) -> Film {
    let stick = tube(rings);
    let mut binding = Binding::default();
    for p in &stick.positions {
        binding.push(hats(p.y, joints, influences));
    }
    let mut half = tube(8);
    half.positions.iter_mut().for_each(|p| p.x += 0.1);
    let rigid = Binding::rigid(half.positions.len(), joints as u32);
    let extras = BTreeMap::from([
        ("rods".to_owned(), Extra::Integer(7)),
        ("mode".to_owned(), Extra::Text("tension".to_owned())),
    ]);
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.05),
        DQuat::from_rotation_z(0.3),
        DVec3::new(0.3, 0.5, 0.0),
    );
    let node = |name: &str, transform| Node {
        name: name.to_owned(),
        transform,
        mesh: super::cube().into(),
        parent: None,
        is_detail: false,
    };
    Film {
        joints: rest_joints(joints),
        pieces: vec![
            SkinnedMesh {
                name: "stick".to_owned(),
                mesh: stick,
                binding,
                extras,
                ..SkinnedMesh::default()
            },
            SkinnedMesh {
                name: "half".to_owned(),
                mesh: half,
                binding: rigid,
                ..SkinnedMesh::default()
            },
        ],
        fixed: vec![node(
            "anvil",
            DAffine3::from_translation(DVec3::new(0.0, -1.5, 0.0)),
        )],
        bodies: vec![RigidBody {
            node: node("hammer", place),
            joint: joints as u32 + 1,
        }],
        materials: materials(),
        textures: vec![Texture {
            image: Some(0),
            alternatives: Vec::new(),
            sampler: [Some(9729), Some(9987), None, None],
        }],
        images: vec![Image {
            name: "grain".to_owned(),
            mime_type: "image/png".to_owned(),
            source: ImageSource::Bytes(super::png_pixel()),
        }],
        frames_per_second: 30.0,
        ..Film::default()
    }
}

/// The joints at rest.
fn rest_joints(joints: usize) -> Vec<Joint> {
    let rest = |k: usize| Joint {
        name: format!("j{k}"),
        rest: Pose {
            translation: DVec3::new(0.0, along(k, joints), 0.0),
            rotation: DQuat::from_rotation_y(0.1 * k as f64),
        },
    };
    let named = |name: &str, translation| Joint {
        name: name.to_owned(),
        rest: Pose {
            translation,
            rotation: DQuat::from_rotation_x(0.4),
        },
    };
    let mut all: Vec<Joint> = (0..joints).map(rest).collect();
    all.push(named("flight", DVec3::new(0.1, 1.0, 0.0)));
    all.push(named("hammer", DVec3::new(0.3, 0.5, 0.0)));
    all.push(named("nothing", DVec3::ZERO));
    all
}

fn materials() -> Vec<Material> {
    vec![
        Material {
            name: "bark".to_owned(),
            base_color_texture: Some(TextureReference {
                texture: 0,
                coordinates: 0,
                transform: None,
                strength: 1.0,
            }),
            roughness: 0.9,
            ..Material::default()
        },
        Material {
            name: "wood inside".to_owned(),
            base_color: [0.8, 0.6, 0.4, 1.0],
            double_sided: true,
            ..Material::default()
        },
    ]
}

fn along(k: usize, joints: usize) -> f64 {
    k as f64 / (joints - 1).max(1) as f64
}

/// Weights of the nearest joints, which decrease with the distance.
fn hats(y: f64, joints: usize, influences: usize) -> Vec<(u32, f64)> {
    let mut near: Vec<(f64, u32)> = (0..joints)
        .map(|k| ((y - along(k, joints)).abs(), k as u32))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.truncate(influences);
    let raw = near.iter().map(|(d, k)| (*k, 1.0 / (0.1 + d)));
    let sum: f64 = raw.clone().map(|e| e.1).sum();
    raw.map(|(k, w)| (k, w / sum)).collect()
}

/// A closed tube of radius [`RADIUS`] from y = 0 to 1 with another material at its ends.
fn tube(rings: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let (mut normals, mut places) = (Vec::new(), Vec::new());
    for r in 0..rings {
        for a in 0..AROUND {
            let (angle, y) = (TAU * a as f64 / AROUND as f64, along(r, rings));
            let out = DVec3::new(angle.sin(), 0.0, angle.cos());
            mesh.positions.push(out * RADIUS + DVec3::Y * y);
            normals.extend(out.as_vec3().to_array());
            places.extend([a as f32 / AROUND as f32, y as f32]);
        }
    }
    let at = |r: usize, a: usize| (r * AROUND + a % AROUND) as u32;
    for r in 1..rings {
        for a in 0..AROUND {
            let [b, c, d, e] = [at(r - 1, a), at(r - 1, a + 1), at(r, a + 1), at(r, a)];
            mesh.triangles.extend([[b, c, d], [b, d, e]]);
            mesh.materials.extend([0, 0]);
        }
    }
    for a in 1..AROUND - 1 {
        mesh.triangles.push([at(0, 0), at(0, a + 1), at(0, a)]);
        let top = rings - 1;
        mesh.triangles
            .push([at(top, 0), at(top, a), at(top, a + 1)]);
        mesh.materials.extend([1, 1]);
    }
    for (name, width, data) in [("NORMAL", 3, normals), ("TEXCOORD_0", 2, places)] {
        mesh.attributes
            .insert(name.to_owned(), Attribute { width, data });
    }
    mesh
}

/// The stick bends more and more, the half tumbles, the hammer slides along x.
pub struct Bend {
    pub joints: usize,
    pub frames: usize,
    pub rest: Vec<Joint>,
}

impl Bend {
    pub fn new(film: &Film, frames: usize) -> Self {
        Bend {
            joints: film.joints.len() - 3,
            frames,
            rest: film.joints.clone(),
        }
    }
}

impl Motion for Bend {
    type Error = Infallible;

    fn frames(&self) -> usize {
        self.frames
    }

    fn time(&self, frame: usize) -> f64 {
        frame as f64 / 30.0
    }

    fn poses(&mut self, frame: usize, poses: &mut [Pose]) -> Result<(), Infallible> {
        let t = self.time(frame);
        for (k, pose) in poses.iter_mut().enumerate() {
            let rest = self.rest[k].rest;
            // The stick lies on an arc; its first joint does not move.
            let (s, bend) = (along(k, self.joints), 0.6 * t);
            let (turn, place) = match k.checked_sub(self.joints) {
                None if bend > 0.0 => {
                    let round = DVec3::new((bend * s).cos() - 1.0, (bend * s).sin(), 0.0) / bend;
                    (DQuat::from_rotation_z(bend * s), round)
                }
                None => (DQuat::IDENTITY, DVec3::Y * s),
                // More than a full turn, so that the signs of quaternions flip.
                Some(0) => (
                    DQuat::from_rotation_z(3.0 * t),
                    rest.translation + DVec3::new(t, -0.5 * t * t, 0.0),
                ),
                Some(1) => (DQuat::IDENTITY, rest.translation + DVec3::X * -0.1 * t),
                Some(_) => (DQuat::IDENTITY, rest.translation),
            };
            let sign = if frame.is_multiple_of(2) { 1.0 } else { -1.0 };
            *pose = Pose {
                translation: place,
                rotation: turn * rest.rotation * sign,
            };
        }
        Ok(())
    }
}
