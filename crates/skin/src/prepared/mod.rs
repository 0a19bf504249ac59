//! A stem in a scene, brought to grain space and ready to be broken any number of times.

mod ends;
mod extent;
mod levels;
mod local_origin;
mod measured;
mod neighbours;
mod orientation;

pub use extent::SectionExtent;
pub use neighbours::Neighbours;
pub use orientation::unmirror;

use crate::error::BreakError;
use crate::source::{Source, SplitTriangles};
use crate::texture::SectionSquare;
use glam::{DAffine3, DVec2, DVec3};
use greenstick_fracture::cut::{Cut, CutError, Skin, Solid};
use greenstick_fracture::layout::{SkinDepth, SkinPoint};
use greenstick_fracture::recipe::Recipe;
use greenstick_geometry::mesh::NO_MATERIAL;
use greenstick_geometry::repair::{self, KnownPositions};
use greenstick_geometry::{Cancelled, Context, Mesh, Node, Scene};
use greenstick_wood::appearance::{EndSection, WoodAppearance};
use greenstick_wood::species::UnknownSpecies;
use greenstick_wood::stem::{
    FoundStem, LayeredGrain, StemError, StemLocation, StemOptions, find_stem_along,
};
use levels::LevelSplitter;
use measured::Measured;
use std::sync::Arc;

/// Length of the slices in which the depth of the skin is measured, radii.
const DEPTH_STEP: f64 = 0.1;

/// Triangles of a limb that are mapped between two checks for cancellation.
const CHECK_INTERVAL: usize = 1 << 10;

/// A scene with the stem found in it, and everything about the stem that no parameter of a break changes.
#[derive(Debug, Clone)]
pub struct PreparedStem {
    /// The scene as it was read, except that the mesh that will be cut may have more triangles near the break.
    pub scene: Scene,
    /// The stem, and the node and triangles that it consists of.
    pub found: FoundStem,
    /// The map between the world and the grain space that the stem is cut in.
    pub layers: LayeredGrain,
    /// Point of every vertex of the mesh that will be cut.
    pub points: Vec<u32>,
    /// Grain coordinates of every point of that mesh, m; NaN off the limb.
    pub grain: Vec<DVec3>,
    /// Points of the corners of its triangles.
    pub corners: Vec<[u32; 3]>,
    /// The extent of the limb's skin about the pith.
    pub extent: SectionExtent,
    /// The square of the section that holds the limb's skin.
    pub square: SectionSquare,
    /// Triangles of the skin that were split because the stem is bent there.
    pub split: usize,
    /// Which they are, and their parts.
    parts: SplitTriangles,
    /// The skin, sorted along the grain.
    pub skin: Skin,
    /// Triangles of the skin in that order.
    pub skin_triangles: Vec<[u32; 3]>,
    /// One vertex of each point.
    vertices: Vec<u32>,
    /// Grain space to the node's coordinates.
    chart: LayeredGrain,
    /// Lengths between which the map to grain space is affine, m.
    levels: Vec<f64>,
    /// Triangles of the shell that is cut, before any was split because the stem is bent or its grain spirals.
    pub shell_triangles: usize,
    measured: Measured,
}

impl PreparedStem {
    /// Finds the stem at `location` and maps it to grain space.
    ///
    /// # Errors
    /// [`StemError`] where there is no stem that can be broken.
    ///
    /// # Examples
    /// ```
    /// use greenstick_geometry::{Context, Node, Scene};
    /// use greenstick_skin::prepared::PreparedStem;
    /// use greenstick_wood::stem::{StemLocation, StemOptions};
    ///
    /// let mesh = greenstick_wood::primitive::cylinder(0.02, 0.3, 24);
    /// let mut scene = Scene::default();
    /// scene.nodes.push(Node::new("branch", glam::DAffine3::IDENTITY, mesh));
    /// let middle = StemLocation::Fraction(0.5);
    /// let stem =
    ///     PreparedStem::find(scene, &middle, &StemOptions::default(), &Context::quiet())?;
    /// assert!((stem.found.stem.radius - 0.02).abs() < 1e-3);
    /// # Ok::<(), greenstick_wood::stem::StemError>(())
    /// ```
    pub fn find(
        scene: Scene,
        location: &StemLocation,
        options: &StemOptions,
        context: &Context,
    ) -> Result<PreparedStem, StemError> {
        PreparedStem::find_between(scene, location, options, &Neighbours::default(), context)
    }

    /// Finds the stem at a location for one of several breaks.
    ///
    /// # Errors
    /// As [`PreparedStem::find`].
    pub fn find_between(
        mut scene: Scene,
        location: &StemLocation,
        options: &StemOptions,
        neighbours: &Neighbours,
        context: &Context,
    ) -> Result<PreparedStem, StemError> {
        scene.nodes.iter_mut().for_each(orientation::unmirror);
        let repairs = repair::repair_scene(&mut scene, context)?;
        context.check()?;
        let (meshes, along) = (scene.world_meshes(), neighbours.along());
        let mut found = find_stem_along(&meshes, location, options, along, context)?;
        // What is left of a stem that was broken before is no whole rod; it stays what it was taken for.
        if along.is_none()
            && options.kind.is_none()
            && has_plain_surface(&scene, found.node)
            && let Some(kind) = found.stem.plain_kind()
        {
            let options = StemOptions {
                kind: Some(kind),
                ..options.clone()
            };
            found = find_stem_along(&meshes, location, &options, along, context)?;
            found.notes.push(format!(
                "the stem is round, straight and of one thickness, without a texture: it was taken for a {} without bark; of \
                 the kind \"round\" it has bark",
                kind.word()
            ));
        }
        found.notes.splice(0..0, repairs);
        let (layers, free) = LayeredGrain::from_stem(&found.stem);
        found.stem.usable = free;
        let mut prepared = PreparedStem::from_found(scene, found, layers, context)?;
        neighbours.limit(&mut prepared.found);
        Ok(prepared)
    }

    /// Maps a stem that was found in a scene to grain space.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn from_found(
        mut scene: Scene,
        mut found: FoundStem,
        layers: LayeredGrain,
        context: &Context,
    ) -> Result<PreparedStem, Cancelled> {
        let shell_triangles = found.shell.len();
        let transform = scene.nodes[found.node].transform;
        let mesh = std::mem::take(&mut scene.nodes[found.node].mesh);
        let mut mesh = Arc::unwrap_or_clone(mesh);
        context.check()?;
        let (points, count) = mesh.points();
        context.check()?;
        let grain = grain_of_limb(
            &mesh,
            (&points, count),
            &found.limb,
            (&transform, &layers),
            context,
        )?;
        context.check()?;
        orientation::orient_outwards(&mut mesh, &points, &grain, &mut found);
        let mut splitter = LevelSplitter {
            mesh,
            points,
            grain,
            limb: std::mem::take(&mut found.limb),
            split: 0,
            parts: SplitTriangles::default(),
        };
        context.check()?;
        let (levels, new) = splitter.split(&layers, &transform, &found);
        context.check()?;
        found.limb = std::mem::take(&mut splitter.limb);
        found.shell.extend(new);
        let LevelSplitter {
            mesh,
            points,
            grain,
            split,
            parts,
            ..
        } = splitter;
        let corner = |t: &[u32; 3]| t.map(|v| points[v as usize]);
        let corners: Vec<[u32; 3]> = mesh.triangles.iter().map(corner).collect();
        let solid = Solid {
            triangles: &corners,
            points: &grain,
            shell: &found.shell,
            limb: &found.limb,
        };
        context.check()?;
        let skin = Skin::new(&solid, found.stem.usable);
        context.check()?;
        let vertices = vertex_of_points(&points, grain.len());
        context.check()?;
        let extent = SectionExtent::new(&found, &corners, &grain);
        Ok(PreparedStem {
            square: extent::square_about(&found, extent.reach.0, &corners, &grain),
            extent,
            skin_triangles: (skin.order.iter().map(|&t| mesh.triangles[t as usize])).collect(),
            skin,
            vertices,
            chart: layers.transformed(&transform.inverse()),
            levels,
            shell_triangles,
            scene: {
                scene.nodes[found.node].mesh = mesh.into();
                scene
            },
            found,
            layers,
            points,
            grain,
            corners,
            split,
            parts,
            measured: Measured::default(),
        })
    }

    /// The same stem with grain that spirals about its axis by `turn` (rad per m) between two lengths (m), by `per_level` (rad)
    /// at most from one level to the next. The origin of the node that will be cut moves to the break: closely wound walls are
    /// parted by little more than the spacing of positions in files.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn with_spiral_grain(
        &self,
        turn: f64,
        between: (f64, f64),
        per_level: f64,
        context: &Context,
    ) -> Result<PreparedStem, Cancelled> {
        let mut corners: Vec<f64> = self.grain.iter().map(|g| g.z).collect();
        corners.retain(|s| !s.is_nan());
        corners.sort_unstable_by(f64::total_cmp);
        let layers = (self.layers.clone()).with_spiral(turn, between, per_level, &corners);
        let mut scene = self.scene.clone();
        let stem = &self.found.stem;
        let at = stem.grain.axis().frame(stem.location).origin;
        local_origin::move_origin(&mut scene.nodes[self.found.node], at);
        let mut made = PreparedStem::from_found(scene, self.found.clone(), layers, context)?;
        made.shell_triangles = self.shell_triangles;
        made.parts = made.parts.after(&self.parts);
        Ok(made)
    }

    /// Returns what the wood of a recipe looks like in it.
    ///
    /// # Errors
    /// A name that is no species.
    pub fn wood_appearance(&self, recipe: &Recipe) -> Result<WoodAppearance, UnknownSpecies> {
        let (face, bark) = (&recipe.face, self.extent.bark);
        let (tissues, species) = (face.proportions(), recipe.species()?);
        let stem = &self.found.stem;
        let mut wood = WoodAppearance::of_stem(stem, &tissues, face.seed, species, bark);
        recipe.colours.apply(&mut wood);
        Ok(wood)
    }

    /// The node that will be cut.
    pub fn node(&self) -> &Node {
        &self.scene.nodes[self.found.node]
    }

    /// The transform of the node that will be cut.
    pub fn transform(&self) -> &DAffine3 {
        &self.node().transform
    }

    /// Cubic metres per cubic unit of the node's coordinates.
    pub fn volume_scale(&self) -> f64 {
        volume_scale(self.node())
    }

    /// The mesh as it will be cut.
    pub fn solid(&self) -> Solid<'_> {
        Solid {
            triangles: &self.corners,
            points: &self.grain,
            shell: &self.found.shell,
            limb: &self.found.limb,
        }
    }

    /// Splits the broken face of a cut of this stem at the levels of the grain.
    pub fn split_at_levels(&self, cut: &mut Cut) {
        cut.split_at_levels(&self.grain, &self.levels, levels::near(&self.found));
    }

    /// Returns the mesh as the source of pieces.
    pub fn source(&self) -> Source<'_> {
        Source {
            mesh: &self.node().mesh,
            points: &self.points,
            vertices: &self.vertices,
            grain: &self.grain,
            chart: &self.chart,
            splits: None,
        }
    }

    /// Returns the mesh as the source of pieces with as few triangles as there can be.
    pub fn source_put_together(&self) -> Source<'_> {
        Source {
            splits: Some(&self.parts),
            ..self.source()
        }
    }

    /// Returns the sections at the ends of a round stem. An end is left out where the stem has none, or where it is so
    /// torn that no outline parallel to its face is closed.
    pub fn end_sections(&self) -> &[EndSection] {
        self.measured.ends.get_or_init(|| self.find_end_sections())
    }

    /// Returns whether the shell that is cut is closed, and the volume that it encloses if it is oriented too, m³.
    pub(crate) fn closed_volume(&self) -> (bool, Option<f64>) {
        *self.measured.closed_volume.get_or_init(|| {
            let shell = self.found.shell.iter().map(|&t| t as usize);
            let (closed, volume) = self.node().mesh.submesh(shell).closed_volume();
            (closed, volume.map(|v| v * self.volume_scale()))
        })
    }

    /// Returns the positions of the mesh that is cut, whose own faults breaks leave as they are.
    pub(crate) fn known_positions(&self) -> &KnownPositions {
        self.measured
            .positions
            .get_or_init(|| KnownPositions::from_mesh(&self.node().mesh))
    }

    /// Returns how deep the skin lies along the part that can be broken.
    pub(crate) fn skin_depth(&self) -> Arc<SkinDepth> {
        let depth = || Arc::new(self.find_skin_depth());
        self.measured.skin_depth.get_or_init(depth).clone()
    }

    fn find_skin_depth(&self) -> SkinDepth {
        let stem = &self.found.stem;
        let mut depth = SkinDepth::new(stem.usable, DEPTH_STEP * stem.radius);
        for &t in &self.found.limb {
            depth.add(self.corners[t as usize].map(|p| {
                let point = self.grain[p as usize];
                let (rho, phi) = stem.rings.address(point.truncate());
                SkinPoint {
                    rho,
                    phi,
                    length: point.z,
                }
            }));
        }
        depth
    }

    /// Distance of the farthest limb point near the break from the pith, in the direction `toward` (unit, across the
    /// grain), with the sign turned: the least of `dot(toward)` over the points within `reach` (m) of the break. Infinite
    /// where there is none.
    pub(crate) fn least_along(&self, toward: DVec2, reach: f64) -> f64 {
        let place = self.found.stem.location;
        (self.found.limb.iter())
            .flat_map(|&t| self.corners[t as usize])
            .map(|point| self.grain[point as usize])
            .filter(|g| (g.z - place).abs() < reach)
            .map(|g| g.truncate().dot(toward))
            .fold(f64::INFINITY, f64::min)
    }

    /// Adds where in the world a cut failed.
    pub fn locate(&self, error: CutError) -> BreakError {
        let at = match &error {
            CutError::OffLayout { at } | CutError::Outline { at, .. } | CutError::Face { at } => {
                *at
            }
            CutError::Misses | CutError::Joined { .. } => {
                DVec3::new(0.0, 0.0, self.found.stem.location)
            }
            CutError::Cancelled(cancelled) => return BreakError::Cancelled(*cancelled),
        };
        BreakError::Cut {
            error,
            at: self.layers.to_world(at),
        }
    }
}

/// Returns whether a node has neither colours nor textures: nothing by which it could show bark.
fn has_plain_surface(scene: &Scene, node: usize) -> bool {
    let mesh = &scene.nodes[node].mesh;
    let is_plain = |&number: &u32| {
        let material = scene.materials.get(number as usize);
        number == NO_MATERIAL || material.is_some_and(|m| m.base_color_texture.is_none())
    };
    !mesh.attributes.contains_key("COLOR_0") && mesh.materials.iter().all(is_plain)
}

/// Cubic metres per cubic unit of a node's coordinates.
pub fn volume_scale(node: &Node) -> f64 {
    node.transform.matrix3.determinant().abs()
}

/// Returns where the points (`points` of the vertices, `count` in all) of a limb's triangles lie in grain space; NaN for all others.
fn grain_of_limb(
    mesh: &Mesh,
    (points, count): (&[u32], usize),
    limb: &[u32],
    (transform, layers): (&DAffine3, &LayeredGrain),
    context: &Context,
) -> Result<Vec<DVec3>, Cancelled> {
    let mut grain = vec![DVec3::NAN; count];
    for (i, &t) in limb.iter().enumerate() {
        if i % CHECK_INTERVAL == 0 {
            context.check()?;
        }
        for v in mesh.triangles[t as usize] {
            let p = points[v as usize] as usize;
            if grain[p].is_nan() {
                let world = transform.transform_point3(mesh.positions[v as usize]);
                grain[p] = layers.to_grain(world);
            }
        }
    }
    Ok(grain)
}

/// Returns the last vertex at each of `count` points, which are those of the vertices.
fn vertex_of_points(points: &[u32], count: usize) -> Vec<u32> {
    let mut vertices = vec![0; count];
    for (vertex, &point) in points.iter().enumerate() {
        vertices[point as usize] = vertex as u32;
    }
    vertices
}
