//! The broken faces of a stem: its mesh cut along a fracture surface, the face that results, and the pieces.

mod face;
mod inner_wood;
mod pieces;
mod spiral;

pub use crate::source::Source;
pub use face::Face;
pub use inner_wood::InnerWood;
pub use pieces::{FaceAddress, Patch, PatchVertex, lacks_material, smooth_normals};
pub use spiral::SpiralRepair;

use crate::error::BreakError;
use crate::prepared::PreparedStem;
use greenstick_fracture::cut::{Cut, CutWorkspace, FacetGrid, Skin, cut_again};
use greenstick_fracture::heights::{self, BreakSite, HeightCache, HeightSource, Heights};
use greenstick_fracture::layout::{self, FibreBundles, LayoutOptions};
use greenstick_fracture::parameters::{BreakParameters, SurfaceStyle as Style};
use greenstick_fracture::surface::FractureSurface;
use greenstick_geometry::{Context, Mesh};
use greenstick_wood::rings::StemRings;
use std::sync::Arc;

/// The layout of a section: its fibre bundles, and which of their facets lie near the skin.
#[derive(Debug, Clone)]
pub struct FaceLayout {
    /// The fibre bundles.
    pub bundles: Arc<FibreBundles>,
    /// The grid of their facets near the skin.
    pub facet_grid: FacetGrid,
}

/// Sectors of the layout of a board over those asked for: it fills a small part of the rings and rays that it lies in, and would
/// else break in pegs.
const BOARD_SECTORS: f64 = 1.6;

/// Everything that a layout depends on besides the stem.
#[derive(Debug, Clone, PartialEq)]
pub struct LayoutKey {
    style: Style,
    options: LayoutOptions,
}

impl LayoutKey {
    /// Returns what the layout of a break with these parameters in wood with these rings depends on.
    pub fn new(stem: &PreparedStem, p: &BreakParameters, rings: &StemRings) -> Self {
        let barked = stem.found.stem.kind.has_bark();
        LayoutKey {
            style: p.surface,
            options: LayoutOptions {
                rings: p.rings as usize,
                sectors: match (p.surface, stem.extent.arc) {
                    (Style::Fibrous, Some(_)) => (BOARD_SECTORS * f64::from(p.sectors)) as usize,
                    _ => p.sectors as usize,
                },
                reach: stem.extent.reach,
                radius: stem.extent.radius,
                arc: stem.extent.arc,
                bark: barked.then_some(stem.extent.bark),
                bark_below: if barked && p.surface == Style::Fibrous {
                    stem.extent.bark_below.to_vec()
                } else {
                    Vec::new()
                },
                ring_edges: match p.surface {
                    Style::Smooth => Vec::new(),
                    Style::Fibrous => rings.edges().to_vec(),
                },
                seed: match p.surface {
                    // The published grid is regular.
                    Style::Smooth => 0,
                    Style::Fibrous => p.seed,
                },
            },
        }
    }
}

impl FaceLayout {
    /// Lays out the section of a stem.
    pub fn new(stem: &PreparedStem, key: &LayoutKey) -> Self {
        let rings = &stem.found.stem.rings;
        let bundles = match key.style {
            Style::Smooth => FibreBundles {
                skin: Some(stem.skin_depth()),
                ..layout::smooth(rings, &key.options)
            },
            Style::Fibrous => layout::fibrous(rings, &key.options),
        };
        FaceLayout {
            facet_grid: FacetGrid::new(&stem.skin, &bundles.layout),
            bundles: Arc::new(bundles),
        }
    }

    /// Makes the heights of a face in this layout on a stem. `relief` is the factor of the species on the torn relief.
    pub fn heights(
        &self,
        (stem, relief): (&PreparedStem, f64),
        p: &BreakParameters,
        source: &HeightSource,
        cache: &mut HeightCache,
    ) -> Heights {
        heights::heights(
            &self.bundles,
            p,
            &break_site(stem, p, relief),
            source,
            cache,
        )
    }

    /// Returns the range of heights from the 5th to the 95th percentile over the corners of such a face, m.
    pub fn relief_range(
        &self,
        (stem, relief): (&PreparedStem, f64),
        p: &BreakParameters,
        cache: &mut HeightCache,
    ) -> f64 {
        heights::relief_range(&self.bundles, p, &break_site(stem, p, relief), cache)
    }
}

/// Returns the stem as heights are made for it. `relief` is the factor of the species on the torn relief.
fn break_site(stem: &PreparedStem, p: &BreakParameters, relief: f64) -> BreakSite {
    let found = &stem.found.stem;
    BreakSite {
        radius: found.radius,
        place: found.location,
        usable: found.usable,
        pith: found.rings.pith(),
        wedge: crate::hang::wedge(stem, p),
        relief,
    }
}

/// A stem cut along a fracture surface: everything visible that changes with the break.
///
/// Each piece consists of the skin that the break does not come near ([`BrokenFace::skin_below`] and
/// [`BrokenFace::skin_above`]), the skin about the break, whole triangles and parts of cut ones ([`BrokenFace::patch`]),
/// and the broken face, which the upper piece has turned over.
#[derive(Debug, Clone)]
pub struct BrokenFace {
    /// The cut.
    pub cut: Cut,
    /// The broken face.
    pub face: Face,
    /// The skin about the break.
    pub patch: Patch,
    /// Slivers that hung in the air on one side and were given to the other.
    pub chips: usize,
    /// What was done to keep a face in spiral grain from crossing itself.
    pub spiral: Option<SpiralRepair>,
}

/// Cuts a stem along fracture surfaces.
#[derive(Clone, Copy)]
pub struct Cutter<'a> {
    /// The stem.
    pub stem: &'a PreparedStem,
    /// Its sorted skin, within whose reach the surface lies.
    pub skin: &'a Skin,
    /// The grid of the facets of the surface near that skin.
    pub facet_grid: &'a FacetGrid,
    /// Whether parts of one piece that hang in the air are given to the other.
    pub absorb_chips: bool,
    /// Asked whether to stop.
    pub context: &'a Context,
}

impl Cutter<'_> {
    /// Cuts the stem along `surface`, and splits the broken face at the levels of the grain. Returns the cut, and how many
    /// chips changed sides.
    ///
    /// # Errors
    /// [`BreakError::Cut`] where the mesh is open or not a manifold at the break, and [`BreakError::Cancelled`].
    pub fn cut(
        &self,
        surface: &FractureSurface,
        workspace: &mut CutWorkspace,
    ) -> Result<(Cut, usize), BreakError> {
        let solid = self.stem.solid();
        let (skin, grid) = (self.skin, self.facet_grid);
        let cut = cut_again(&solid, skin, grid, surface, workspace, self.context);
        let mut cut = cut.map_err(|error| self.stem.locate(error))?;
        self.context.check()?;
        let chips = if self.absorb_chips {
            cut.absorb_chips(&solid, self.skin, self.facet_grid)
        } else {
            0
        };
        self.stem.split_at_levels(&mut cut);
        Ok((cut, chips))
    }

    /// Cuts the stem along `surface` and makes the broken face.
    ///
    /// # Errors
    /// As [`Cutter::cut`].
    pub fn break_along(
        &self,
        surface: &FractureSurface,
        inner: &InnerWood,
        workspace: &mut CutWorkspace,
    ) -> Result<BrokenFace, BreakError> {
        let (cut, chips) = self.cut(surface, workspace)?;
        Ok(self.face_of(cut, chips, None, inner))
    }

    /// Cuts a stem of spiral grain along `surface`, removes the self-intersections of the face, and makes it. Where they cannot
    /// be removed otherwise, the surface is levelled.
    ///
    /// # Errors
    /// As [`Cutter::cut`].
    pub fn break_spiral_grain(
        &self,
        surface: &FractureSurface,
        inner: &InnerWood,
        workspace: &mut CutWorkspace,
    ) -> Result<BrokenFace, BreakError> {
        let (source, transform) = (self.stem.source(), self.stem.transform());
        let layers = (&self.stem.layers, self.stem.found.stem.radius);
        let cut_along = |surface: &FractureSurface| {
            let (mut cut, chips) = self.cut(surface, workspace)?;
            let (repair, crossing) = spiral::repair_spiral_face(
                &source,
                &mut cut,
                self.skin,
                layers,
                transform,
                self.context,
            )?;
            Ok::<_, BreakError>(((cut, chips), repair, crossing))
        };
        let ((cut, chips), repair) = spiral::cut_and_level(surface, cut_along)?;
        // A levelled surface that could not be cut is left out, be it for that it was cancelled.
        self.context.check()?;
        Ok(self.face_of(cut, chips, Some(repair), inner))
    }

    fn face_of(
        &self,
        cut: Cut,
        chips: usize,
        spiral: Option<SpiralRepair>,
        inner: &InnerWood,
    ) -> BrokenFace {
        let source = self.stem.source();
        let face = face::face(&source, &cut, inner);
        let patch = pieces::patch(&source, &cut, self.skin, &face.places);
        BrokenFace {
            cut,
            face,
            patch,
            chips,
            spiral,
        }
    }
}

impl BrokenFace {
    /// The face of a cut that does not reach the skin, such as that of a splinter.
    pub(crate) fn within_the_wood(source: &Source, cut: Cut, inner: &InnerWood) -> Self {
        BrokenFace {
            face: face::face(source, &cut, inner),
            patch: Patch {
                first: source.mesh.positions.len() as u32,
                ..Patch::default()
            },
            cut,
            chips: 0,
            spiral: None,
        }
    }

    /// Where in the stem the vertices of the face lie.
    pub fn addresses(&self, inner: &InnerWood) -> Vec<FaceAddress> {
        pieces::face_addresses(&self.cut, &self.face, inner)
    }

    /// One piece as a mesh of its own, in the coordinates of the node that was cut.
    pub fn piece(&self, source: &Source, inner: &InnerWood, upper: bool) -> Mesh {
        pieces::piece(source, &self.cut, &self.patch, &self.face, inner, upper)
    }

    /// Triangles of the mesh that was cut that lie wholly below all that changes with the break.
    pub fn skin_below<'a>(&self, stem: &'a PreparedStem) -> &'a [[u32; 3]] {
        &stem.skin_triangles[..self.cut.sides.below]
    }

    /// Triangles of the mesh that was cut that lie wholly above all that changes with the break.
    pub fn skin_above<'a>(&self, stem: &'a PreparedStem) -> &'a [[u32; 3]] {
        &stem.skin_triangles[self.cut.sides.above..]
    }
}
