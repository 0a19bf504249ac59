//! The skin of a bundle: open faces made, closed up, and collected into one mesh for each piece.

use super::closed_cracks::ClosedCracks;
use super::columns::{Columns, columns};
use super::crack_gap::open_cracks;
use super::error::RodSkinError;
use super::fracture_state::{FractureState, Pieces, RodPart};
use super::history::BreakHistory;
use super::hull::hull;
use super::joints::Joints;
use super::manifold::{NonmanifoldSplits, split_nonmanifold_vertices};
use super::materials::Materials;
use super::open_faces::{OpenFaces, open_faces};
use super::options::{Outline, RodSkinOptions};
use super::piece_mesh::piece_mesh;
use super::prisms::PrismComplex;
use super::weight_history::{WeightHistory, weight_history};
use super::wood::Wood;
use greenstick_geometry::SkinnedMesh;
use greenstick_geometry::film::Extra;
use greenstick_schema::Parameters;
use rustc_hash::FxHashMap;

/// The skin of a bundle.
#[derive(Debug, Clone, PartialEq)]
pub struct RodSkin {
    /// Pieces, the one with the most wood first.
    pub pieces: Vec<SkinnedMesh>,
    /// Joints that they follow.
    pub joints: Joints,
    /// The parts of rods that each piece consists of: rod of the unbroken bundle, and part.
    pub parts: Vec<Vec<(u32, RodPart)>>,
    /// Edges and vertices in which several sheets of skin met, and were separated.
    pub nonmanifold_splits: NonmanifoldSplits,
    /// Vertices on cracks that open later, which a film with fixed weights shows open too early.
    pub closed_cracks: ClosedCracks,
}

/// Makes the skin of `wood` in one state of fracture.
///
/// # Errors
/// [`RodSkinError`] for options out of range.
///
/// # Examples
/// The skin of an unbroken branch is one closed piece:
/// ```
/// use greenstick_fibre::placement::{PlacementOptions, RodCount, WoodMaterial, fill_stem};
/// use greenstick_geometry::Context;
/// use greenstick_skin::rods::{FractureState, Materials, RodSkinOptions, Wood, rod_skin};
/// use greenstick_skin::texture::SectionSquare;
/// use greenstick_wood::moisture::Fallback;
/// use greenstick_wood::species::Species;
/// use greenstick_wood::stem::{StemLocation, StemOptions, find_stem};
///
/// let mesh = greenstick_wood::primitive::cylinder(0.02, 0.3, 24);
/// let middle = StemLocation::Fraction(0.5);
/// let stem = find_stem(&[mesh], &middle, &StemOptions::default(), &Context::quiet())?.stem;
/// let oak = WoodMaterial::from_species(Species::find("white oak")?, 12.0, Fallback::Refuse)?;
/// let options = PlacementOptions { rods: RodCount::Number(12), ..PlacementOptions::default() };
/// let rods = fill_stem(&stem, &oak, &options, &Context::quiet())?;
/// let wood = Wood {
///     stem: &stem,
///     stem_to_rods: glam::DAffine3::IDENTITY,
///     bundle: &rods.bundle,
///     along: &rods.along,
///     cells: &rods.cells,
///     outline: &rods.outline,
///     bark: None,
///     pull_out: oak.tension / (4.0 * oak.shear),
/// };
/// let square = SectionSquare::round(glam::DVec2::ZERO, 0.04);
/// let materials =
///     Materials { inner: 0, bark: 1, bark_mesh_offset: 2, square, zone: &|_| 0 };
/// let whole = FractureState::unbroken(&wood);
/// let skin = rod_skin(&wood, &whole, &materials, &RodSkinOptions::default())?;
/// assert_eq!(skin.pieces.len(), 1);
/// assert!(skin.pieces[0].mesh.volume() > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn rod_skin(
    wood: &Wood,
    state: &FractureState,
    materials: &Materials,
    options: &RodSkinOptions,
) -> Result<RodSkin, RodSkinError> {
    make_skin(wood, state, None, materials, options)
}

/// Makes the skin of `wood` in the last state of `history`, with the weights that vertices have in the frames before.
///
/// # Errors
/// [`RodSkinError`] for options out of range.
pub fn rod_skin_over_time(
    wood: &Wood,
    history: &BreakHistory,
    materials: &Materials,
    options: &RodSkinOptions,
) -> Result<RodSkin, RodSkinError> {
    make_skin(
        wood,
        history.last_state(),
        Some(history),
        materials,
        options,
    )
}

fn make_skin(
    wood: &Wood,
    state: &FractureState,
    history: Option<&BreakHistory>,
    materials: &Materials,
    options: &RodSkinOptions,
) -> Result<RodSkin, RodSkinError> {
    options.check()?;
    let convex = (options.outline == Outline::Hull).then(|| hull(wood));
    let wood = &match &convex {
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
        &wood.bonded_rods(),
        options.fibres,
        wood.stem.rings.pith(),
        options.seed,
    );
    let joints = Joints::new(wood, state);
    let mut complex = PrismComplex::new(wood, &section, state, options)?;
    let mut faces = open_faces(wood, &mut complex, state, &joints, options);
    let nonmanifold_splits = split_nonmanifold_vertices(&mut faces);
    // While a crack is closed both its sides have the same weights, so they are traced before the gap separates them.
    let earlier = history.map_or_else(WeightHistory::default, |history| {
        weight_history(&faces, &complex, history, &joints)
    });
    open_cracks(&mut faces, wood, section.spacing);
    let groups = group_by_piece(&faces, &complex, &section, state, &state.pieces(wood));
    let mut pieces: Vec<Piece> = (groups.into_iter())
        .filter(|group| !group.triangles.is_empty())
        .map(|group| {
            let skinned = piece_mesh(wood, &faces, &earlier, &group.triangles, materials);
            let volume = skinned.mesh.volume();
            Piece {
                skinned,
                volume,
                group,
            }
        })
        .collect();
    pieces.sort_by(|a, b| b.volume.total_cmp(&a.volume));
    let closed_cracks = closed_cracks(&faces, &earlier, &pieces);
    let digits = pieces.len().saturating_sub(1).to_string().len().max(3);
    let (pieces, parts) = (pieces.into_iter().enumerate())
        .map(|(number, piece)| piece.finish(format!("piece_{number:0digits$}")))
        .unzip();
    Ok(RodSkin {
        pieces,
        joints,
        parts,
        nonmanifold_splits,
        closed_cracks,
    })
}

/// What belongs to one piece.
#[derive(Debug, Clone, Default)]
struct PieceGroup {
    /// Its triangles among the open faces.
    triangles: Vec<u32>,
    /// Its parts of rods.
    parts: Vec<(u32, RodPart)>,
}

/// A piece before it has a name.
struct Piece {
    skinned: SkinnedMesh,
    /// Volume, m³.
    volume: f64,
    group: PieceGroup,
}

impl Piece {
    /// Names the piece and notes its volume and number of rods. Returns it with its parts of rods.
    fn finish(self, name: String) -> (SkinnedMesh, Vec<(u32, RodPart)>) {
        let Piece {
            mut skinned,
            volume,
            group,
        } = self;
        let mut rods: Vec<u32> = group.parts.iter().map(|p| p.0).collect();
        rods.dedup();
        let count = Extra::Integer(rods.len() as i64);
        skinned.name = name;
        skinned
            .extras
            .insert("volume_m3".into(), Extra::Number(volume));
        skinned.extras.insert("rods".into(), count);
        (skinned, group.parts)
    }
}

/// Assigns triangles and parts of rods to their pieces.
fn group_by_piece(
    faces: &OpenFaces,
    complex: &PrismComplex,
    section: &Columns,
    state: &FractureState,
    pieces: &Pieces,
) -> Vec<PieceGroup> {
    let mut groups = vec![PieceGroup::default(); pieces.count];
    for (t, triangle) in faces.triangles.iter().enumerate() {
        let prism = triangle.prism as usize;
        let rod = section.columns[prism / complex.slabs()].rod;
        let piece = pieces.piece_of(rod, complex.parts[prism]);
        groups[piece as usize].triangles.push(t as u32);
    }
    for (rod, breaks) in state.breaks.iter().enumerate() {
        for part in 0..=breaks.len() {
            let (rod, part) = (rod as u32, part as RodPart);
            let piece = pieces.piece_of(rod, part);
            groups[piece as usize].parts.push((rod, part));
        }
    }
    groups
}

/// Collects the pairs of vertices that coincide until a crack opens, with the weights that they have in the end.
fn closed_cracks(faces: &OpenFaces, earlier: &WeightHistory, pieces: &[Piece]) -> ClosedCracks {
    let mut piece_of = vec![0; faces.vertices.len()];
    for (number, piece) in pieces.iter().enumerate() {
        for &t in &piece.group.triangles {
            for v in faces.triangles[t as usize].corners {
                piece_of[v as usize] = number as u32;
            }
        }
    }
    let mut cracks = ClosedCracks::default();
    let mut known: FxHashMap<u32, u32> = FxHashMap::default();
    for &(pair, until) in &earlier.coincident {
        let pair = pair.map(|v| {
            *known.entry(v).or_insert_with(|| {
                let vertex = &faces.vertices[v as usize];
                cracks.add_vertex(vertex.closed_rest, &vertex.weights, piece_of[v as usize])
            })
        });
        cracks.add_pair(pair, until);
    }
    cracks
}
