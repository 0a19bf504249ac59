//! Particles in layers along the stem, and what is made of them: a table, a surface, and the spread of bundles.

use super::error::AnatomyError;
use super::limits::MAX_PARTICLES;
use super::measures::SectionMeasures;
use super::model::Anatomy;
use super::particles::{Particle, particles_from_field, particles_from_raster};
use super::sections::{StemSections, TransverseSection};
use super::sectors::{SectorDivision, SectorLayout};
use super::surface::{SurfaceColouring, reconstruct_surface};
use glam::DAffine3;
use greenstick_geometry::{Cancelled, Column, Context, Material, Mesh, Node, Scene, Table, Values};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Fewest and most layers where their number is not given.
const DEFAULT_LAYER_RANGE: (f64, f64) = (16.0, 4096.0);
/// Layers between two reports of progress.
const LAYERS_PER_REPORT: u32 = 32;
/// Sections along the stem, at most, over which the numbers of equal-area sectors are averaged.
const MAX_AVERAGED_SECTIONS: u32 = 64;
/// Fewest pixels along the side of a section in which areas of a board's bundles are counted.
const MIN_BOARD_PIXELS: usize = 512;

/// How a stem is divided into particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LayerOptions {
    /// Sectors of every ring, or of the outermost.
    pub sectors: u32,
    /// Layers along the stem, at least two; as far apart as the outermost sectors are wide where absent.
    pub layers: Option<u32>,
    /// How rings are divided into sectors.
    pub division: SectorDivision,
}

impl Default for LayerOptions {
    fn default() -> Self {
        LayerOptions {
            sectors: 40,
            layers: None,
            division: SectorDivision::EqualAngle,
        }
    }
}

/// Areas of the bundles of a stem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BundleSpread {
    /// The smallest and the largest, m².
    pub range: [f64; 2],
    /// Standard deviation within a layer over the layer's mean: the mean of all layers.
    pub mean_deviation: f64,
    /// The greatest of all layers.
    pub max_deviation: f64,
}

/// A section with its particles.
#[derive(Debug, Clone, PartialEq)]
pub struct ParticleLayer {
    /// Measures of the section.
    pub section: SectionMeasures,
    /// Its particles, by ring and sector.
    pub particles: Vec<Particle>,
}

/// The particles of a stem.
#[derive(Debug, Clone, PartialEq)]
pub struct ParticleLayers {
    /// Numbers of sectors.
    pub layout: SectorLayout,
    /// Layers from the base on; those that miss the stem are left out.
    pub layers: Vec<ParticleLayer>,
    /// Distance of the layers, m.
    pub spacing: f64,
    /// Colour of each ring from the pith, sRGB.
    ring_colours: Vec<[u8; 3]>,
    /// Whether every ring goes round the pith, as it does not in a board.
    pub(super) closed_rings: bool,
}

impl ParticleLayers {
    /// Samples the particles of a stem where its sections are whole.
    ///
    /// # Errors
    /// [`AnatomyError::TooManyParticles`], [`AnatomyError::Cancelled`].
    pub fn sample(
        anatomy: &Anatomy,
        options: &LayerOptions,
        context: &Context,
    ) -> Result<Self, AnatomyError> {
        let sections = anatomy.sections();
        let (low, high) = sections.whole;
        let arc = TAU * sections.stem().radius / f64::from(options.sectors);
        let (fewest, most) = DEFAULT_LAYER_RANGE;
        let default_count = ((high - low) / arc).round().clamp(fewest, most) as u32;
        let count = options.layers.unwrap_or(default_count);
        let layout = layout(anatomy, options, count, context)?;
        let total = u64::from(count).saturating_mul(layout.particles());
        if total > MAX_PARTICLES {
            return Err(AnatomyError::TooManyParticles(total));
        }
        let spacing = (high - low) / f64::from(count);
        let mut layers: Vec<ParticleLayer> = Vec::new();
        for start in (0..count).step_by(LAYERS_PER_REPORT as usize) {
            context.report(f64::from(start) / f64::from(count))?;
            let batch: Vec<Option<ParticleLayer>> = (start..count.min(start + LAYERS_PER_REPORT))
                .into_par_iter()
                .map(|layer| {
                    context.check()?;
                    let length = low + spacing * (f64::from(layer) + 0.5);
                    let Some(section) = sections.section(length) else {
                        return Ok(None);
                    };
                    let particles = sample_layer(anatomy, &section, layer, &layout, context)?;
                    let section = anatomy.measure(&section, &particles);
                    Ok(Some(ParticleLayer { section, particles }))
                })
                .collect::<Result<_, Cancelled>>()?;
            layers.extend(batch.into_iter().flatten());
        }
        Ok(ParticleLayers {
            layout,
            layers,
            spacing,
            ring_colours: anatomy.ring_colours(),
            closed_rings: !anatomy.is_board(),
        })
    }

    /// All particles, by layer, ring and sector.
    pub fn particles(&self) -> impl Iterator<Item = &Particle> {
        self.layers.iter().flat_map(|layer| &layer.particles)
    }

    /// The particles as a table, by layer, ring and sector.
    pub fn table(&self) -> Table {
        let counts = |name, meaning, value: &dyn Fn(&Particle) -> u32| {
            let values = self.particles().map(value).collect();
            Column::new(name, "", meaning, Values::U32(values))
        };
        let reals = |name, unit, meaning, value: &dyn Fn(&Particle) -> f64| {
            let values = self.particles().map(value).collect();
            Column::new(name, unit, meaning, Values::F64(values))
        };
        let bytes = |name, meaning, value: &dyn Fn(&Particle) -> u8| {
            let values = self.particles().map(value).collect();
            Column::new(name, "", meaning, Values::U8(values))
        };
        let colour = |p: &Particle| self.ring_colours[usize::from(p.ring) - 1];
        let tissues = "0 pith, 1 heartwood, 2 sapwood, 3 phloem, 4 bark";
        let latewood = "colour of the ring's latewood, sRGB";
        let rho = "ring coordinate, 0 at the pith to 1 at the bark";
        Table {
            columns: vec![
                reals("x", "m", "place in the world", &|p| p.position.x),
                reals("y", "m", "place in the world", &|p| p.position.y),
                reals("z", "m", "place in the world", &|p| p.position.z),
                counts("ring", "counted from 1 at the pith", &|p| p.ring.into()),
                counts("sector", "counted from 0 counter-clockwise", &|p| p.sector),
                counts("layer", "counted from 0 at the base", &|p| p.layer),
                bytes("zone", tissues, &|p| p.tissue.code()),
                bytes("red", latewood, &|p| colour(p)[0]),
                bytes("green", latewood, &|p| colour(p)[1]),
                bytes("blue", latewood, &|p| colour(p)[2]),
                reals("area", "m2", "cross-section of the bundle", &|p| p.area),
                reals("rho", "", rho, &|p| p.rho),
                reals("phi", "rad", "angle about the pith", &|p| p.angle),
                reals("s", "m", "length along the centreline", &|p| p.length),
            ],
            ..Table::default()
        }
    }

    /// Sectors times rings, summed over the layers: Eq. 1, where each section has its own number of rings. That is more
    /// than there are particles where a board's faces cut rings off or a sector of an eroded ring has no pixel.
    pub fn equation_1(&self) -> u64 {
        let of_layer = |layer: &ParticleLayer| -> u64 {
            let rings = layer.particles.chunk_by(|a, b| a.ring == b.ring);
            rings
                .map(|r| u64::from(self.layout.sectors[usize::from(r[0].ring) - 1]))
                .sum()
        };
        self.layers.iter().map(of_layer).sum()
    }

    /// How the areas of bundles differ.
    pub fn bundle_spread(&self) -> BundleSpread {
        let areas = || self.particles().map(|p| p.area);
        let least = areas().fold(f64::INFINITY, f64::min);
        let most = areas().fold(0.0, f64::max);
        let deviations: Vec<f64> = self
            .layers
            .iter()
            .filter(|layer| !layer.particles.is_empty())
            .map(|layer| relative_deviation(&layer.particles))
            .collect();
        BundleSpread {
            range: [least.min(most), most],
            mean_deviation: deviations.iter().sum::<f64>() / deviations.len().max(1) as f64,
            max_deviation: deviations.iter().copied().fold(0.0, f64::max),
        }
    }

    /// The closed surface over a ring's particles. `None` for a board, of fewer than two layers, and where the ring has fewer
    /// than three sectors or is not whole in every layer.
    pub fn surface(&self, ring: u16, colouring: SurfaceColouring) -> Option<Mesh> {
        if !self.closed_rings {
            return None;
        }
        let particles: Vec<&[Particle]> = self.layers.iter().map(|l| &*l.particles).collect();
        let piths = [
            self.layers.first()?.section.pith,
            self.layers.last()?.section.pith,
        ];
        reconstruct_surface(&particles, &self.layout, ring, piths, colouring)
    }

    /// Returns the same surface as a scene with one node, `ring_` and the ring's number. `None` as for
    /// [`ParticleLayers::surface`].
    pub fn surface_scene(&self, ring: u16, colouring: SurfaceColouring) -> Option<Scene> {
        let mut mesh = self.surface(ring, colouring)?;
        mesh.materials = vec![0; mesh.triangles.len()];
        Some(Scene {
            nodes: vec![Node::new(format!("ring_{ring}"), DAffine3::IDENTITY, mesh)],
            materials: vec![Material {
                name: "particles".into(),
                ..Material::default()
            }],
            ..Scene::default()
        })
    }
}

/// Numbers of sectors for `count` layers.
fn layout(
    anatomy: &Anatomy,
    options: &LayerOptions,
    count: u32,
    context: &Context,
) -> Result<SectorLayout, Cancelled> {
    if options.division == SectorDivision::EqualAngle {
        return Ok(SectorLayout::equal_angle(
            anatomy.ring_count(),
            options.sectors,
        ));
    }
    let lengths = averaged_lengths(anatomy.sections(), count.min(MAX_AVERAGED_SECTIONS));
    let sections = anatomy.sections().sections_at(&lengths, context)?;
    Ok(SectorLayout::equal_area(
        sections.iter().map(|s| &s.field),
        anatomy.rings(),
        options.sectors,
    ))
}

/// `count` lengths at equal distances where sections are whole, m.
fn averaged_lengths(sections: &StemSections, count: u32) -> Vec<f64> {
    let (low, high) = sections.whole;
    (0..count)
        .map(|k| low + (high - low) * (f64::from(k) + 0.5) / f64::from(count))
        .collect()
}

/// The particles of a section.
fn sample_layer(
    anatomy: &Anatomy,
    section: &TransverseSection,
    layer: u32,
    layout: &SectorLayout,
    context: &Context,
) -> Result<Vec<Particle>, Cancelled> {
    let voxels = anatomy.sections().grid;
    let grid = if anatomy.is_eroded() {
        voxels
    } else if anatomy.is_board() {
        // A board is thin: the voxels' own grid may be too coarse for areas.
        voxels.resampled(voxels.count.max(MIN_BOARD_PIXELS))
    } else {
        return Ok(particles_from_field(
            section,
            layer,
            layout,
            anatomy.rings(),
        ));
    };
    let raster = anatomy.rasterize(section, &grid, context)?;
    Ok(particles_from_raster(section, &raster, layout, layer))
}

/// Standard deviation of the bundles' areas over their mean.
fn relative_deviation(particles: &[Particle]) -> f64 {
    let count = particles.len() as f64;
    let mean = particles.iter().map(|p| p.area).sum::<f64>() / count;
    let squares: f64 = particles.iter().map(|p| (p.area - mean).powi(2)).sum();
    (squares / count).sqrt() / mean
}
