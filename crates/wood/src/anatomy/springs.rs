//! The spring network of a stem's particles: each is joined to its six neighbours, two along the radius, two along the ring and
//! two along the grain, as a mass-spring model of wood has it (Forests 2023 §2.2 and Fig. 5).

use super::layers::ParticleLayers;
use super::particles::Particle;
use crate::tissue::Zone;
use greenstick_geometry::{Column, Table, Values};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// The direction in which a spring runs through the wood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpringDirection {
    /// Across the rings.
    Radial = 0,
    /// Along a ring.
    Tangential = 1,
    /// Along the grain.
    Longitudinal = 2,
}

/// A spring between two particles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// Indices of the particles in the order of [`ParticleLayers::particles`], the first below the second.
    pub particles: [u32; 2],
    /// The direction in which it runs.
    pub direction: SpringDirection,
    /// Distance of the particles, m.
    pub rest_length: f64,
    /// The tissue that it runs through. A radial one runs through the ring of its outer particle, which lies on that ring's
    /// outer contour.
    pub tissue: Zone,
}

impl ParticleLayers {
    /// Returns the springs, by the layer, ring and sector of their first particles.
    ///
    /// Where all rings have the same number of sectors a particle has the neighbours of its own sector. Where bundles have
    /// equal areas outer rings have more sectors: each particle is joined to the one of the next ring inwards that is nearest
    /// by its angle. Particles that a section lacks leave gaps, and the rings of a board are open.
    pub fn springs(&self) -> Vec<Spring> {
        let mut springs = Vec::new();
        let mut first = 0;
        let mut below: Option<(&[Particle], u32)> = None;
        for layer in &self.layers {
            let particles = &layer.particles[..];
            if let Some((lower, start)) = below
                && follows(lower, particles)
            {
                join_layers(&mut springs, (lower, start), (particles, first));
            }
            self.join_rings(&mut springs, particles, first);
            below = Some((particles, first));
            first += particles.len() as u32;
        }
        springs.sort_by_key(|s| s.particles);
        springs
    }

    /// Joins the particles of a layer, the first of which has the index `first`.
    fn join_rings(&self, springs: &mut Vec<Spring>, particles: &[Particle], first: u32) {
        let mut inner: Option<Range<usize>> = None;
        for ring in rings(particles) {
            let members = &particles[ring.clone()];
            let index = |k: usize| first + (ring.start + k) as u32;
            let sectors = self.layout.sectors[usize::from(members[0].ring) - 1];
            for (k, p) in members.iter().enumerate() {
                let next = (k + 1) % members.len();
                let wraps = next == 0;
                // Two in a ring are joined once, and the last to the first only where the ring goes round.
                let is_next = (p.sector + 1) % sectors == members[next].sector
                    && (!wraps || (self.closed_rings && members.len() > 2));
                if is_next {
                    let tangential = SpringDirection::Tangential;
                    springs.push(spring(
                        [(p, index(k)), (&members[next], index(next))],
                        tangential,
                    ));
                }
            }
            let neighbours = inner.filter(|r| particles[r.start].ring + 1 == members[0].ring);
            if let Some(inner) = neighbours {
                let inwards = &particles[inner.clone()];
                for (k, p) in members.iter().enumerate() {
                    if let Some(j) = self.inward_neighbour(p, inwards) {
                        let inside = (&inwards[j], first + (inner.start + j) as u32);
                        springs.push(spring([inside, (p, index(k))], SpringDirection::Radial));
                    }
                }
            }
            inner = Some(ring);
        }
    }

    /// The particle of the next ring inwards that a particle is joined to.
    fn inward_neighbour(&self, p: &Particle, inwards: &[Particle]) -> Option<usize> {
        let sectors = |p: &Particle| self.layout.sectors[usize::from(p.ring) - 1];
        if sectors(p) == sectors(inwards.first()?) {
            return inwards.binary_search_by_key(&p.sector, |q| q.sector).ok();
        }
        nearest_angle(inwards, p.angle)
    }

    /// The springs as a table; particles are numbered like the rows of [`ParticleLayers::table`].
    pub fn spring_table(springs: &[Spring]) -> Table {
        let numbers = |name, meaning, value: &dyn Fn(&Spring) -> u32| {
            Column::new(
                name,
                "",
                meaning,
                Values::U32(springs.iter().map(value).collect()),
            )
        };
        let bytes = |name, meaning, value: &dyn Fn(&Spring) -> u8| {
            Column::new(
                name,
                "",
                meaning,
                Values::U8(springs.iter().map(value).collect()),
            )
        };
        let lengths = springs.iter().map(|s| s.rest_length).collect();
        let row = "row of a particle in the table of particles, from 0";
        let directions = "0 radial, 1 tangential, 2 longitudinal";
        let tissues = "0 pith, 1 heartwood, 2 sapwood, 3 phloem, 4 bark";
        Table {
            columns: vec![
                numbers("particle_a", row, &|s| s.particles[0]),
                numbers("particle_b", row, &|s| s.particles[1]),
                Column::new("rest_length", "m", "distance at rest", Values::F64(lengths)),
                bytes("direction", directions, &|s| s.direction as u8),
                bytes("zone", tissues, &|s| s.tissue.code()),
            ],
            ..Table::default()
        }
    }
}

/// The particle whose angle is nearest to `angle` (rad, 0 to 2π).
pub(super) fn nearest_angle(particles: &[Particle], angle: f64) -> Option<usize> {
    let apart = |p: &Particle| {
        let turn = (p.angle - angle).rem_euclid(TAU);
        PI - (turn - PI).abs()
    };
    (0..particles.len()).min_by(|&a, &b| apart(&particles[a]).total_cmp(&apart(&particles[b])))
}

/// The spring between two particles with their indices. Its tissue is that of the second.
fn spring([(a, i), (b, j)]: [(&Particle, u32); 2], direction: SpringDirection) -> Spring {
    Spring {
        particles: if i < j { [i, j] } else { [j, i] },
        direction,
        rest_length: a.position.distance(b.position),
        tissue: b.tissue,
    }
}

/// Whether one layer comes right after another: sections that miss the stem are left out.
fn follows(lower: &[Particle], upper: &[Particle]) -> bool {
    match (lower.first(), upper.first()) {
        (Some(a), Some(b)) => a.layer + 1 == b.layer,
        _ => false,
    }
}

/// The runs of particles that have the same ring.
fn rings(particles: &[Particle]) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    particles
        .chunk_by(|a, b| a.ring == b.ring)
        .map(move |ring| {
            let range = start..start + ring.len();
            start = range.end;
            range
        })
}

/// Joins particles of the same ring and sector in two layers, given with the indices of their first ones.
fn join_layers(
    springs: &mut Vec<Spring>,
    (lower, lower_first): (&[Particle], u32),
    (upper, upper_first): (&[Particle], u32),
) {
    let address = |p: &Particle| (p.ring, p.sector);
    let mut j = 0;
    for (i, p) in lower.iter().enumerate() {
        while upper.get(j).is_some_and(|q| address(q) < address(p)) {
            j += 1;
        }
        if let Some(q) = upper.get(j).filter(|q| address(q) == address(p)) {
            let ends = [(q, upper_first + j as u32), (p, lower_first + i as u32)];
            springs.push(spring(ends, SpringDirection::Longitudinal));
        }
    }
}
