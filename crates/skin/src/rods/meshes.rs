//! The open faces as meshes, one for each piece, with normals, texture coordinates, materials and the wood's address.

use super::bark::Bark;
use super::complex::Complex;
use super::earlier::{Before, earlier};
use super::faces::{Faces, Shows, Triangle, open_faces};
use super::gape::Gapes;
use super::history::History;
use super::hull::hull;
use super::joints::Joints;
use super::kerf::put;
use super::mend::mend;
use super::parting::{Part, Parting};
use super::section::columns;
use super::{Outline, RodSkinError, RodSkinOptions, Wood};
use crate::broken::side_grain;
use crate::texture::SectionSquare;
use glam::{DVec2, DVec3};
use greenstick_geometry::film::Extra;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::{Attribute, Binding, Earlier, Mesh, Skinned};
use rustc_hash::FxHashMap;

/// What faces are made of.
#[derive(Clone, Copy)]
pub struct Materials<'a> {
    /// Material of the wood inside.
    pub inner: u32,
    /// Material of bark that has none of its own.
    pub bark: u32,
    /// What is added to the materials of the bark's mesh.
    pub own: u32,
    /// The wood's texture.
    pub square: SectionSquare,
    /// Code of the tissue zone at a ring coordinate.
    pub zone: &'a dyn Fn(f64) -> u8,
}

/// The skin of a bundle.
#[derive(Debug, Clone, PartialEq)]
pub struct RodSkin {
    /// Pieces, the one with the most wood first.
    pub pieces: Vec<Skinned>,
    /// Joints that they follow.
    pub joints: Joints,
    /// The parts of rods that each piece consists of: rod of the unbroken bundle, and part.
    pub parts: Vec<Vec<(u32, Part)>>,
    /// Edges and vertices in which several sheets of skin met, and were parted.
    pub mended: (usize, usize),
    /// Places that a film with fixed weights shows apart before they are.
    pub gapes: Gapes,
}

/// Makes the skin of `wood` where `parting` is broken.
///
/// # Errors
/// [`RodSkinError`] for options out of range.
pub fn rod_skin(
    wood: &Wood,
    parting: &Parting,
    materials: &Materials,
    options: &RodSkinOptions,
) -> Result<RodSkin, RodSkinError> {
    skin_of(wood, parting, None, materials, options)
}

/// Makes the skin of `wood` where the last frame of `history` has it broken, with what vertices follow in the frames
/// before.
///
/// # Errors
/// [`RodSkinError`] for options out of range.
pub fn rod_skin_over_time(
    wood: &Wood,
    history: &History,
    materials: &Materials,
    options: &RodSkinOptions,
) -> Result<RodSkin, RodSkinError> {
    skin_of(wood, history.last(), Some(history), materials, options)
}

fn skin_of(
    wood: &Wood,
    parting: &Parting,
    history: Option<&History>,
    materials: &Materials,
    options: &RodSkinOptions,
) -> Result<RodSkin, RodSkinError> {
    if options.fibres == 0 || options.fibres > 1000 {
        return Err(RodSkinError::Value {
            what: "the number of fibre bundles for each rod",
            value: f64::from(options.fibres),
            right: "from 1 to 1000",
        });
    }
    let around = (options.outline == Outline::Hull).then(|| hull(wood));
    let wood = &match &around {
        Some((outline, cells)) => Wood {
            outline,
            cells,
            bark: None,
            ..*wood
        },
        None => *wood,
    };
    let section = columns(
        wood.cells,
        wood.outline,
        &wood.bonded(),
        options.fibres,
        wood.stem.rings.pith(),
        options.seed,
    );
    let joints = Joints::new(wood, parting);
    let mut complex = Complex::new(wood, &section, parting, options)?;
    let mut faces = open_faces(wood, &mut complex, parting, &joints, options);
    let mended = mend(&mut faces);
    // Both sides of a crack follow alike: before it is opened by a hair.
    let before = history.map_or_else(Before::default, |history| {
        earlier(&faces, &complex, history, &joints)
    });
    put(&mut faces, wood, section.spacing);
    let pieces = parting.pieces(wood);
    let slabs = complex.slabs();
    let mut of_piece = vec![(Vec::new(), Vec::new()); pieces.count];
    for (t, triangle) in faces.triangles.iter().enumerate() {
        let prism = triangle.prism as usize;
        let piece = pieces.of(section.columns[prism / slabs].rod, complex.parts[prism]);
        of_piece[piece as usize].0.push(t as u32);
    }
    for (rod, breaks) in parting.breaks.iter().enumerate() {
        for part in 0..=breaks.len() {
            let part = (rod as u32, part as Part);
            of_piece[pieces.of(part.0, part.1) as usize].1.push(part);
        }
    }
    let mut all: Vec<_> = of_piece
        .into_iter()
        .filter(|(triangles, _)| !triangles.is_empty())
        .map(|(triangles, parts): (Vec<u32>, Vec<(u32, Part)>)| {
            let made = mesh(wood, &faces, &before, &triangles, materials);
            let volume = made.mesh.volume();
            (made, parts, volume, triangles)
        })
        .collect();
    all.sort_by(|a, b| b.2.total_cmp(&a.2));
    let mut piece_of = vec![0; faces.vertices.len()];
    for (piece, (_, _, _, triangles)) in all.iter().enumerate() {
        for &t in triangles {
            for v in faces.triangles[t as usize].corners {
                piece_of[v as usize] = piece as u32;
            }
        }
    }
    let digits = all.len().saturating_sub(1).to_string().len().max(3);
    let mut skin = RodSkin {
        pieces: Vec::new(),
        joints,
        parts: Vec::new(),
        mended,
        gapes: gapes(&faces, &before, &piece_of),
    };
    for (number, (mut piece, parts, volume, _)) in all.into_iter().enumerate() {
        piece.name = format!("piece_{number:0digits$}");
        let mut rods: Vec<u32> = parts.iter().map(|p| p.0).collect();
        rods.dedup();
        piece
            .extras
            .insert("volume_m3".into(), Extra::Number(volume));
        piece
            .extras
            .insert("rods".into(), Extra::Integer(rods.len() as i64));
        skin.parts.push(parts);
        skin.pieces.push(piece);
    }
    Ok(skin)
}

/// The vertices that are at one place before a frame, with what they follow in the end.
fn gapes(faces: &Faces, before: &Before, piece_of: &[u32]) -> Gapes {
    let mut made = Gapes::default();
    let mut known: FxHashMap<u32, u32> = FxHashMap::default();
    for &(of, until) in &before.together {
        let of = of.map(|v| {
            *known.entry(v).or_insert_with(|| {
                let vertex = &faces.vertices[v as usize];
                made.vertex(vertex.closed, &vertex.follows, piece_of[v as usize])
            })
        });
        made.pair(of, until);
    }
    made
}

/// Cosine of the angle between a face's normal and the grain above which it shows end grain.
const END_GRAIN: f64 = 0.5;

/// Which vertices of a mesh are one: the same vertex of the skin, on faces that are smooth together and show the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Key {
    vertex: u32,
    smooth: u32,
    end: bool,
    /// Bits of the texture coordinates of bark.
    coordinates: [u64; 2],
}

/// Faces of the outside are smooth together, those of the ends are; tips are by their flanks.
const BARK: u32 = u32::MAX;
const END: u32 = u32::MAX - 1;

fn mesh(
    wood: &Wood,
    faces: &Faces,
    before: &Before,
    triangles: &[u32],
    materials: &Materials,
) -> Skinned {
    let mut made = Mesh::default();
    let mut earlier = Earlier::default();
    let mut binding = Binding::default();
    let mut known: FxHashMap<Key, u32> = FxHashMap::default();
    let mut normals: Vec<DVec3> = Vec::new();
    let (mut coordinates, mut ring, mut zone, mut grain) = (
        Vec::<f32>::new(),
        Vec::<f32>::new(),
        Vec::<f32>::new(),
        Vec::<f32>::new(),
    );
    let rings = &wood.stem.rings;
    let own = Bark::of(wood);
    let mut colors: Vec<f32> = Vec::new();
    for &t in triangles {
        let triangle: Triangle = faces.triangles[t as usize];
        let corners = triangle.corners.map(|v| &faces.vertices[v as usize]);
        let [a, b, c] = corners.map(|v| v.rest);
        let normal = (b - a).cross(c - a);
        let bark = triangle.shows == Shows::Bark;
        let smooth = match triangle.shows {
            Shows::Bark => BARK,
            Shows::End => END,
            Shows::Side(number) => 2 * number,
            Shows::Tip(number) => 2 * number + 1,
        };
        let looks = own
            .as_ref()
            .filter(|_| bark)
            .and_then(|o| o.face([a, b, c]));
        let (coordinate, end) = texture(wood, materials, corners.map(|v| v.grain), bark);
        let corners = [0, 1, 2].map(|k| {
            let look = looks.map(|(_, looks)| looks[k]);
            let uv = look.map_or(coordinate[k], |l| l.coordinates);
            let key = Key {
                vertex: triangle.corners[k],
                smooth,
                end,
                coordinates: if bark {
                    uv.to_array().map(f64::to_bits)
                } else {
                    [0; 2]
                },
            };
            let at = *known.entry(key).or_insert_with(|| {
                let v = corners[k];
                let (rho, _) = rings.address(v.grain.truncate());
                made.positions.push(v.rest);
                binding.push(v.follows.iter().copied());
                let own = made.positions.len() as u32 - 1;
                let versions = before.versions.get(triangle.corners[k] as usize);
                for version in versions.into_iter().flatten() {
                    let rest = if version.closed { v.closed } else { v.rest };
                    let follows = version.follows.iter().copied();
                    earlier.push(own, version.until, rest, follows);
                }
                normals.push(DVec3::ZERO);
                coordinates.extend(uv.as_vec2().to_array());
                ring.push(rho as f32);
                zone.push(f32::from((materials.zone)(rho)));
                grain.extend(v.grain.as_vec3().to_array());
                colors.extend(look.and_then(|l| l.color).unwrap_or([1.0; 4]));
                made.positions.len() as u32 - 1
            });
            normals[at as usize] += normal;
            at
        });
        made.triangles.push(corners);
        made.materials.push(match looks {
            Some((material, _)) if material != NO_MATERIAL => materials.own + material,
            _ if bark => materials.bark,
            _ => materials.inner,
        });
    }
    let normals: Vec<DVec3> = normals.iter().map(|n| n.normalize_or(DVec3::Z)).collect();
    let tangents = tangents(&made, &normals, &coordinates);
    let normals = normals
        .iter()
        .flat_map(|n| n.as_vec3().to_array())
        .collect();
    for (name, width, data) in [
        ("NORMAL", 3, normals),
        ("TANGENT", 4, tangents),
        ("TEXCOORD_0", 2, coordinates),
        ("_RING", 1, ring),
        ("_ZONE", 1, zone),
        ("_GRAIN", 3, grain),
    ] {
        made.attributes
            .insert(name.into(), Attribute { width, data });
    }
    if own.is_some_and(|o| o.has_colors()) {
        let color = Attribute {
            width: 4,
            data: colors,
        };
        made.attributes.insert("COLOR_0".into(), color);
    }
    Skinned {
        mesh: made,
        binding,
        earlier,
        ..Skinned::default()
    }
}

/// Texture coordinates of a face's corners, and whether it is end grain.
fn texture(
    wood: &Wood,
    materials: &Materials,
    grain: [DVec3; 3],
    bark: bool,
) -> ([DVec2; 3], bool) {
    // All corners of a face read the texture on one side of the seam behind the pith.
    let middle = (grain[0] + grain[1] + grain[2]) / 3.0;
    if bark {
        return (grain.map(|g| bark_coordinates(wood, g, middle)), false);
    }
    let across = (grain[1] - grain[0]).cross(grain[2] - grain[0]);
    let end = across.z * across.z > END_GRAIN * END_GRAIN * across.length_squared();
    let SectionSquare {
        middle: square,
        side,
    } = materials.square;
    let pith = wood.stem.rings.pith();
    let one = |g: DVec3| {
        if end {
            g.truncate() - square + 0.5 * side
        } else {
            side_grain(g, middle.truncate(), pith, side)
        }
    };
    (grain.map(one), end)
}

/// Tangents of all vertices as glTF has them: along the first texture coordinate, and the sign of the second's direction.
fn tangents(mesh: &Mesh, normals: &[DVec3], coordinates: &[f32]) -> Vec<f32> {
    let mut sums = vec![[DVec3::ZERO; 2]; normals.len()];
    let at = |v: u32| {
        let k = 2 * v as usize;
        DVec2::new(coordinates[k].into(), coordinates[k + 1].into())
    };
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        let [p, q, r] = mesh.corners(t);
        let (e, f) = (q - p, r - p);
        let (u, v) = (at(b) - at(a), at(c) - at(a));
        let sign = u.perp_dot(v).signum();
        for corner in [a, b, c] {
            let sum = &mut sums[corner as usize];
            sum[0] += (e * v.y - f * u.y) * sign;
            sum[1] += (f * u.x - e * v.x) * sign;
        }
    }
    (sums.iter().zip(normals))
        .flat_map(|(&[along, other], &n)| {
            let t = along.reject_from_normalized(n);
            let t = t
                .try_normalize()
                .unwrap_or_else(|| n.any_orthonormal_vector());
            let sign = if n.cross(t).dot(other) < 0.0 {
                -1.0
            } else {
                1.0
            };
            let [x, y, z] = t.as_vec3().to_array();
            [x, y, z, sign]
        })
        .collect()
}

/// Texture coordinates of bark: turns about the pith, and as many along as make them square.
fn bark_coordinates(wood: &Wood, grain: DVec3, middle: DVec3) -> DVec2 {
    let pith = wood.stem.rings.pith();
    let angle = |p: DVec3| libm::atan2(p.y - pith.y, p.x - pith.x);
    let turn = std::f64::consts::TAU;
    let (own, face) = (angle(grain), angle(middle));
    let near = face + (own - face + 1.5 * turn).rem_euclid(turn) - 0.5 * turn;
    DVec2::new(near / turn, grain.z / (turn * wood.stem.radius))
}
