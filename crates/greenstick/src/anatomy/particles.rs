//! Particles in layers, the table of them, and the surface rebuilt from them.

use super::{Bundles, MOST_PARTICLES, USUAL_LAYERS, Work, sections_at};
use crate::Error;
use glam::DAffine3;
use greenstick_geometry::{Column, Context, Material, Node, Scene, Table, Values};
use greenstick_wood::anatomy::{
    Grid, Layout, Particle, Section, SurfaceColours, field_particles, pixel_particles,
    rebuilt_surface,
};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Layers between two looks at whether to stop.
const BATCH: usize = 32;
/// Sections along the stem, at most, whose rings tell the numbers of equal-area sectors.
const COUNTED: u32 = 64;
/// Pixels along the side of a section that areas of a board's bundles are counted in, at least.
const FINE: usize = 512;

/// Sections with their particles, from the base on.
pub(super) struct Layers {
    pub layout: Layout,
    pub sections: Vec<Section>,
    pub particles: Vec<Vec<Particle>>,
    /// Distance of the layers, m.
    pub thickness: f64,
    /// Colour of each ring from the pith, sRGB.
    colours: Vec<[u8; 3]>,
}

pub(super) fn layers(work: &Work, context: &Context) -> Result<Layers, Error> {
    let (anatomy, request) = (work.anatomy, work.request);
    let stem = anatomy.stem();
    let (low, high) = anatomy.whole;
    let arc = TAU * stem.radius / f64::from(request.sectors);
    let usual = ((high - low) / arc)
        .round()
        .clamp(USUAL_LAYERS.0, USUAL_LAYERS.1) as u32;
    let count = request.layers.unwrap_or(usual);
    let rings = anatomy.rings;
    let thickness = (high - low) / f64::from(count);
    let layout = match request.bundles {
        Bundles::EqualArea => {
            let lengths: Vec<f64> = (0..count.min(COUNTED))
                .map(|k| low + (high - low) * (f64::from(k) + 0.5) / f64::from(count.min(COUNTED)))
                .collect();
            let sections = sections_at(work, &lengths);
            Layout::equal_area(sections.iter().map(|s| &s.field), rings, request.sectors)
        }
        Bundles::Fixed => Layout::fixed(rings, request.sectors),
    };
    let total = u64::from(count).saturating_mul(layout.particles());
    if total > MOST_PARTICLES {
        let found = format!("{total} particles; expected at most {MOST_PARTICLES}");
        return Err(Error::Amount(found));
    }
    let mut made: Vec<(Section, Vec<Particle>)> = Vec::new();
    for start in (0..count).step_by(BATCH) {
        context.report(f64::from(start) / f64::from(count))?;
        let batch: Vec<Option<(Section, Vec<Particle>)>> = (start..count.min(start + BATCH as u32))
            .into_par_iter()
            .map(|layer| {
                let section = anatomy.section(low + thickness * (f64::from(layer) + 0.5))?;
                let particles = layer_of(work, &section, layer, &layout);
                Some((section, particles))
            })
            .collect();
        made.extend(batch.into_iter().flatten());
    }
    let late = |ring: u16| usize::from(2 * (rings - ring) + 1);
    let (sections, particles) = made.into_iter().unzip();
    Ok(Layers {
        layout,
        sections,
        particles,
        thickness,
        colours: (1..=rings).map(|r| work.palette[late(r)]).collect(),
    })
}

fn layer_of(work: &Work, section: &Section, layer: u32, layout: &Layout) -> Vec<Particle> {
    let voxels = &work.anatomy.grid;
    if work.erosion.is_some() {
        let drawn = work.drawn(section, voxels);
        return pixel_particles(
            section,
            (voxels, &drawn.passes),
            &drawn.numbers,
            layout,
            layer,
        );
    }
    if !work.is_board() {
        return field_particles(section, layer, layout, &work.look.tissue);
    }
    // A board is thin: the voxels' own grid may be too coarse for areas.
    let count = voxels.count.max(FINE);
    let grid = Grid {
        count,
        pixel: voxels.pixel * voxels.count as f64 / count as f64,
    };
    let drawn = work.drawn(section, &grid);
    pixel_particles(
        section,
        (&grid, &drawn.passes),
        &drawn.numbers,
        layout,
        layer,
    )
}

impl Layers {
    /// The particles as a table, by layer, ring and sector.
    pub fn table(&self) -> Table {
        let all = || self.particles.iter().flatten();
        let whole = |name, meaning, value: &dyn Fn(&Particle) -> u32| {
            Column::new(name, "", meaning, Values::U32(all().map(value).collect()))
        };
        let real = |name, unit, meaning, value: &dyn Fn(&Particle) -> f64| {
            Column::new(name, unit, meaning, Values::F64(all().map(value).collect()))
        };
        let byte = |name, meaning, value: &dyn Fn(&Particle) -> u8| {
            Column::new(name, "", meaning, Values::U8(all().map(value).collect()))
        };
        let colour = |p: &Particle| self.colours[usize::from(p.ring) - 1];
        Table {
            columns: vec![
                real("x", "m", "place in the world", &|p| p.position.x),
                real("y", "m", "place in the world", &|p| p.position.y),
                real("z", "m", "place in the world", &|p| p.position.z),
                whole("ring", "counted from 1 at the pith", &|p| p.ring.into()),
                whole("sector", "counted from 0 counter-clockwise", &|p| p.sector),
                whole("layer", "counted from 0 at the base", &|p| p.layer),
                byte(
                    "zone",
                    "0 pith, 1 heartwood, 2 sapwood, 3 phloem, 4 bark",
                    &|p| p.zone.code(),
                ),
                byte("red", "colour of the ring's latewood, sRGB", &|p| {
                    colour(p)[0]
                }),
                byte("green", "colour of the ring's latewood, sRGB", &|p| {
                    colour(p)[1]
                }),
                byte("blue", "colour of the ring's latewood, sRGB", &|p| {
                    colour(p)[2]
                }),
                real("area", "m2", "cross-section of the bundle", &|p| p.area),
                real(
                    "rho",
                    "",
                    "ring coordinate, 0 at the pith to 1 at the bark",
                    &|p| p.rho,
                ),
                real("phi", "rad", "angle about the pith", &|p| p.angle),
                real("s", "m", "length along the centreline", &|p| p.length),
            ],
        }
    }

    /// Sectors times rings, summed over the layers: Eq. 1, where each section has its own number of rings.
    pub fn equation_1(&self) -> u64 {
        let of_layer = |particles: &Vec<Particle>| -> u64 {
            let runs = particles.chunk_by(|a, b| a.ring == b.ring);
            runs.map(|r| u64::from(self.layout.sectors[usize::from(r[0].ring) - 1]))
                .sum()
        };
        self.particles.iter().map(of_layer).sum()
    }

    /// The surface over a ring's particles as a scene.
    pub fn surface(&self, work: &Work, ring: u16, colours: SurfaceColours) -> Option<Scene> {
        if work.is_board() {
            return None;
        }
        let layers: Vec<&[Particle]> = self.particles.iter().map(Vec::as_slice).collect();
        let pith = |s: &Section| s.world(s.field.pith());
        let piths = [pith(self.sections.first()?), pith(self.sections.last()?)];
        let mut mesh = rebuilt_surface(&layers, &self.layout, ring, piths, colours)?;
        mesh.materials = vec![0; mesh.triangles.len()];
        Some(Scene {
            nodes: vec![Node {
                name: format!("ring_{ring}"),
                transform: DAffine3::IDENTITY,
                mesh: mesh.into(),
                parent: None,
            }],
            materials: vec![Material {
                name: "particles".into(),
                ..Material::default()
            }],
            ..Scene::default()
        })
    }
}
