//! Particles (forests-2023 §3.4): a section's bundles of fibres, each by its ring, sector and layer.
//!
//! As published every ring is parted into the same number of sectors, and Eq. 1 counts the particles; outer bundles are
//! then many times larger than inner ones, as its authors deplore. Equal-area bundles have sectors in proportion to each
//! ring's area, and within a ring the sectors' borders lie so that all have the same share of it.
//!
//! A particle lies on its ring's outer contour, as published, so that those of the outermost ring are the bark.

use super::fill::Grid;
use super::outline::Outline;
use super::rings::RingNumbers;
use super::sections::Section;
use crate::rings::RingField;
use crate::tissue::{Proportions, Zone};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// How rings are parted into sectors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bundles {
    /// The same number of sectors in every ring, at equal angles.
    #[default]
    Fixed,
    /// As many sectors as make the cross-sections of bundles equal.
    EqualArea,
}

/// Numbers of sectors by ring; the same in all layers, so that particles of one address follow each other along the
/// grain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// How sectors are bounded.
    pub bundles: Bundles,
    /// Sectors of each ring, from the pith outwards.
    pub sectors: Vec<u32>,
}

/// A bundle of fibres in one layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Particle {
    /// Ring, counted from 1 at the pith.
    pub ring: u16,
    /// Sector, counted from 0 at the frame's x counter-clockwise.
    pub sector: u32,
    /// Layer, counted from 0 at the base.
    pub layer: u32,
    /// Place in the world, m.
    pub position: DVec3,
    /// Length along the centreline, m.
    pub length: f64,
    /// Ring coordinate of the ring's outer contour, 0 at the pith to 1 at the bark.
    pub rho: f64,
    /// Angle about the pith, rad, 0 to 2π.
    pub angle: f64,
    /// Tissue.
    pub zone: Zone,
    /// Area of the bundle's cross-section, m².
    pub area: f64,
}

/// Directions in which a ring's area is summed.
const ANGLES: usize = 720;

/// Squared radii and areas of rings, direction by direction.
struct Areas {
    /// For each ring from the pith: its area (m²) from angle 0 up to direction j of [`ANGLES`], which comes with τ.
    sums: Vec<Vec<f64>>,
}

impl Areas {
    fn of(field: &RingField, rings: u16) -> Self {
        let half_step = 0.5 * TAU / ANGLES as f64;
        let squares = |ring: u16| -> Vec<f64> {
            (0..ANGLES)
                .map(|j| {
                    let angle = TAU * j as f64 / ANGLES as f64;
                    let p = field.point(f64::from(ring) / f64::from(rings), angle);
                    p.distance_squared(field.pith())
                })
                .collect()
        };
        let mut inner = vec![0.0; ANGLES];
        let sums = (1..=rings)
            .map(|ring| {
                let outer = squares(ring);
                let width = |j: usize| outer[j % ANGLES] - inner[j % ANGLES];
                let mut sum = vec![0.0; ANGLES + 1];
                for j in 0..ANGLES {
                    // Half the squared radius is the area by angle; the trapezoidal rule.
                    sum[j + 1] = sum[j] + half_step * 0.5 * (width(j) + width(j + 1));
                }
                inner = outer;
                sum
            })
            .collect();
        Areas { sums }
    }

    fn total(&self, ring: usize) -> f64 {
        self.sums[ring][ANGLES]
    }

    /// Area of a ring from angle 0 to `angle`, rad.
    fn up_to(&self, ring: usize, angle: f64) -> f64 {
        let u = angle / TAU;
        let whole = u.floor();
        let v = (u - whole) * ANGLES as f64;
        let j = (v as usize).min(ANGLES - 1);
        let sum = &self.sums[ring];
        whole * self.total(ring) + sum[j] + (sum[j + 1] - sum[j]) * (v - j as f64)
    }

    /// The angle, 0 to 2π rad, up to which a ring has so much area.
    fn angle(&self, ring: usize, area: f64) -> f64 {
        let sum = &self.sums[ring];
        let j = sum.partition_point(|&a| a <= area).clamp(1, ANGLES) - 1;
        let part = (area - sum[j]) / (sum[j + 1] - sum[j]).max(f64::MIN_POSITIVE);
        (j as f64 + part.clamp(0.0, 1.0)) * TAU / ANGLES as f64
    }
}

impl Layout {
    /// `sectors` in every ring.
    pub fn fixed(rings: u16, sectors: u32) -> Self {
        Layout {
            bundles: Bundles::Fixed,
            sectors: vec![sectors; rings.into()],
        }
    }

    /// Sectors of equal area: `sectors` in the outermost ring, and in each other as many as make bundles of
    /// nearly that area, on average over the sections whose `fields` are given: how much of a section a ring has differs
    /// along a stem, as the outermost takes in the bark's relief, and the numbers are the same in all layers.
    pub fn equal_area<'a>(
        fields: impl IntoIterator<Item = &'a RingField>,
        rings: u16,
        sectors: u32,
    ) -> Self {
        let mut shares = vec![0.0; rings.into()];
        for field in fields {
            let areas = Areas::of(field, rings);
            let whole: f64 = (0..shares.len()).map(|ring| areas.total(ring)).sum();
            for (ring, share) in shares.iter_mut().enumerate() {
                *share += areas.total(ring) / whole;
            }
        }
        let most = shares.last().copied().unwrap_or(0.0);
        let count = |share: &f64| {
            let wanted = f64::from(sectors) * share / most;
            (wanted.round() as u32).clamp(1, sectors.max(1))
        };
        Layout {
            bundles: Bundles::EqualArea,
            sectors: shares.iter().map(count).collect(),
        }
    }

    /// Number of rings.
    pub fn rings(&self) -> u16 {
        self.sectors.len() as u16
    }

    /// Particles in a layer: one term of Eq. 1's sum.
    pub fn particles(&self) -> u64 {
        self.sectors.iter().map(|&n| u64::from(n)).sum()
    }
}

/// The particles of a round stem's section, ring by ring from the pith, sector by sector.
pub fn field_particles(
    section: &Section,
    layer: u32,
    layout: &Layout,
    tissue: &Proportions,
) -> Vec<Particle> {
    let rings = layout.rings();
    let areas = Areas::of(&section.field, rings);
    let mut particles = Vec::with_capacity(layout.particles() as usize);
    for (k, &sectors) in layout.sectors.iter().enumerate() {
        let ring = k as u16 + 1;
        let rho = f64::from(ring) / f64::from(rings);
        let zone = tissue.zone_of_ring(ring.into(), rings.into());
        let share = areas.total(k) / f64::from(sectors);
        for sector in 0..sectors {
            let (angle, area) = match layout.bundles {
                Bundles::EqualArea => (areas.angle(k, share * f64::from(sector)), share),
                Bundles::Fixed => {
                    let step = TAU / f64::from(sectors);
                    let angle = step * f64::from(sector);
                    let area =
                        areas.up_to(k, angle + 0.5 * step) - areas.up_to(k, angle - 0.5 * step);
                    (angle, area)
                }
            };
            particles.push(Particle {
                ring,
                sector,
                layer,
                position: section.world(section.field.point(rho, angle)),
                length: section.length,
                rho,
                angle,
                zone,
                area,
            });
        }
    }
    particles
}

/// The particles of a section whose rings are given as passes, as after an erosion; also of boards, whose rings are cut
/// off by their faces. Rings that have no pixel have no particles.
///
/// As published, rays go out from the centre of what each pass left, at equal angles, and a particle is where the first
/// pixel beyond is met. Where the centre lies off the ring's own wood (a board) the sectors part the angle under which
/// the pith sees the section, and a particle is the middle of its bundle's pixels. Areas are those of the pixels.
pub fn pixel_particles(
    section: &Section,
    (grid, passes): (&Grid, &[u16]),
    numbers: &RingNumbers,
    layout: &Layout,
    layer: u32,
) -> Vec<Particle> {
    let rings = usize::from(numbers.rings);
    let pixels = || {
        passes
            .iter()
            .enumerate()
            .filter(|(_, p)| **p > 0 && usize::from(**p) < numbers.ring.len())
            .map(|(i, &p)| {
                let at = grid.middle(i % grid.count, i / grid.count);
                (
                    at,
                    usize::from(numbers.ring[usize::from(p)]).clamp(1, rings) - 1,
                )
            })
    };
    let pith = section.field.pith();
    let inside = section.outline.holds(pith);
    // The centre of what is left before each ring is taken: all pixels of that ring and of those within it.
    let mut sums = vec![(DVec2::ZERO, 0.0); rings];
    for (at, ring) in pixels() {
        sums[ring].0 += at;
        sums[ring].1 += 1.0;
    }
    let mut left = (DVec2::ZERO, 0.0);
    let centres: Vec<DVec2> = sums
        .iter()
        .map(|&(sum, count)| {
            left = (left.0 + sum, left.1 + count);
            if inside && left.1 > 0.0 {
                left.0 / left.1
            } else {
                pith
            }
        })
        .collect();
    let window = if inside {
        (0.0, TAU)
    } else {
        seen_from(&section.outline, pith)
    };
    let mut cells: Vec<Vec<(DVec2, f64)>> = layout
        .sectors
        .iter()
        .map(|&n| vec![(DVec2::ZERO, 0.0); n as usize])
        .collect();
    for (at, ring) in pixels() {
        let Some(cells) = cells.get_mut(ring).filter(|c| !c.is_empty()) else {
            continue;
        };
        let d = at - centres[ring];
        let turn = (libm::atan2(d.y, d.x) - window.0).rem_euclid(TAU) / window.1;
        // About the pith a sector lies to both sides of its ray; over a window they lie side by side.
        let offset = if inside { 0.5 } else { 0.0 };
        let sector = (turn * cells.len() as f64 + offset) as usize % cells.len();
        cells[sector].0 += at;
        cells[sector].1 += 1.0;
    }
    let pixel_area = grid.pixel * grid.pixel;
    let mut particles = Vec::new();
    for (k, cells) in cells.iter().enumerate() {
        for (sector, &(sum, count)) in cells.iter().enumerate() {
            if count == 0.0 {
                continue;
            }
            let at = if inside {
                let angle = TAU * sector as f64 / cells.len() as f64;
                let within = |p: u16| p > 0 && usize::from(numbers.ring[usize::from(p)]) <= k + 1;
                first_beyond(grid, passes, centres[k], angle, within)
            } else {
                sum / count
            };
            let d = at - pith;
            particles.push(Particle {
                ring: k as u16 + 1,
                sector: sector as u32,
                layer,
                position: section.world(at),
                length: section.length,
                rho: (k + 1) as f64 / rings as f64,
                angle: libm::atan2(d.y, d.x).rem_euclid(TAU),
                zone: zone_of(numbers, k + 1),
                area: count * pixel_area,
            });
        }
    }
    particles
}

fn zone_of(numbers: &RingNumbers, ring: usize) -> Zone {
    let pass = numbers.ring.iter().position(|&r| usize::from(r) == ring);
    pass.map_or(Zone::Bark, |p| numbers.zone[p])
}

/// Where a ray from `centre` leaves the pixels that are `within`, m: the middle of the first pixel beyond, or of the last
/// one of the picture.
fn first_beyond(
    grid: &Grid,
    passes: &[u16],
    centre: DVec2,
    angle: f64,
    within: impl Fn(u16) -> bool,
) -> DVec2 {
    let (sin, cos) = libm::sincos(angle);
    let direction = DVec2::new(cos, sin);
    let half = 0.5 * grid.count as f64;
    let start = centre / grid.pixel + half;
    let mut last = (start.x as usize, start.y as usize);
    // Half pixels, so that no pixel is passed over but at its corner.
    for step in 0..4 * grid.count {
        let p = start + direction * (0.5 * step as f64);
        if p.x < 0.0 || p.y < 0.0 {
            break;
        }
        let (x, y) = (p.x as usize, p.y as usize);
        if x >= grid.count || y >= grid.count {
            break;
        }
        last = (x, y);
        if !within(passes[y * grid.count + x]) {
            break;
        }
    }
    grid.middle(last.0.min(grid.count - 1), last.1.min(grid.count - 1))
}

/// The angle (rad) at which an outline begins as seen from a point outside of it, and how wide it looks.
fn seen_from(outline: &Outline, from: DVec2) -> (f64, f64) {
    let middle = outline.centroid - from;
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    for p in outline.points() {
        let d = p - from;
        let angle = libm::atan2(middle.perp_dot(d), middle.dot(d));
        (low, high) = (low.min(angle), high.max(angle));
    }
    let width = (high - low).clamp(1e-9, 2.0 * PI);
    (libm::atan2(middle.y, middle.x) + low, width)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anatomy::{field_passes, fill};
    use crate::stem::Frame;

    const TISSUE: Proportions = Proportions {
        pith: 0.1,
        heartwood: 0.4,
        phloem: 0.1,
    };

    /// A lobed section of known area with its pith off the middle.
    fn section() -> (Section, f64) {
        let radius = |a: f64| 0.05 * (1.0 + 0.1 * (3.0 * a).cos());
        let own: Vec<DVec2> = (0..720)
            .map(|i| TAU * f64::from(i) / 720.0)
            .map(|a| DVec2::from_angle(a) * radius(a))
            .collect();
        // ½∫r² dφ = π r0² (1 + 0.1²/2)
        let area = PI * 0.0025 * 1.005;
        let field = RingField::round(&own, DVec2::new(0.006, -0.003), 0.07);
        let outline = Outline {
            area,
            centroid: DVec2::ZERO,
            girth: 0.33,
            guessed: 0.0,
            parts: 1,
            loops: vec![own],
        };
        let frame = Frame {
            origin: DVec3::new(1.0, 2.0, 3.0),
            x: DVec3::Y,
            y: DVec3::Z,
            tangent: DVec3::X,
        };
        (
            Section {
                length: 0.5,
                frame,
                outline,
                field,
            },
            area,
        )
    }

    #[test]
    fn equation_1_counts_the_particles_and_their_areas_make_the_section() {
        let (section, area) = section();
        let layout = Layout::fixed(20, 40);
        let particles = field_particles(&section, 7, &layout, &TISSUE);
        // One layer of Eq. 1's sum: N_sec · N_ring.
        assert_eq!(particles.len(), 800);
        let sum: f64 = particles.iter().map(|p| p.area).sum();
        assert!((sum / area - 1.0).abs() < 1e-4, "{sum} of {area}");
        // The outermost ring's particles are on the bark, the frame's x axis first.
        let bark = particles.iter().filter(|p| p.ring == 20);
        for (k, p) in bark.enumerate() {
            assert_eq!((p.sector, p.layer, p.zone), (k as u32, 7, Zone::Bark));
            let d = p.position - section.frame.origin;
            let (x, y) = (d.dot(DVec3::Y), d.dot(DVec3::Z));
            let r = 0.05 * (1.0 + 0.1 * (3.0 * y.atan2(x)).cos());
            assert!((x.hypot(y) - r).abs() < 1e-5 && d.x == 0.0, "{k}");
        }
    }

    #[test]
    fn equal_area_bundles_are_equal_where_fixed_ones_differ_tens_of_times() {
        let (section, area) = section();
        let spread = |layout: &Layout| {
            let particles = field_particles(&section, 0, layout, &TISSUE);
            assert_eq!(particles.len() as u64, layout.particles());
            let sum: f64 = particles.iter().map(|p| p.area).sum();
            assert!((sum / area - 1.0).abs() < 1e-4);
            let most = particles.iter().map(|p| p.area).fold(0.0, f64::max);
            most / particles
                .iter()
                .map(|p| p.area)
                .fold(f64::INFINITY, f64::min)
        };
        let fixed = spread(&Layout::fixed(20, 40));
        let layout = Layout::equal_area([&section.field], 20, 40);
        let equal = spread(&layout);
        // Rounding to whole sectors is all that is left: half a sector of the innermost rings' one or two.
        assert!(fixed > 30.0 && equal < 2.0, "{fixed} {equal}");
        assert!(
            layout.sectors.windows(2).all(|w| w[0] <= w[1]),
            "{:?}",
            layout.sectors
        );
    }

    #[test]
    fn sectors_of_equal_area_suit_all_sections_of_a_stem() {
        // Two sections, one between roots, whose lobes are the outer rings'.
        let outline = |wave: f64| -> Vec<DVec2> {
            (0..720)
                .map(|i| TAU * f64::from(i) / 720.0)
                .map(|a| DVec2::from_angle(a) * 0.05 * (1.0 + wave * (7.0 * a).cos()))
                .collect()
        };
        let fields =
            [0.0, 0.25].map(|wave| RingField::round(&outline(wave), DVec2::new(0.004, 0.0), 0.1));
        // Shares of the outermost of 30 rings in bundles of 60 sectors, over the mean bundle of the section.
        let worst = |layout: &Layout| {
            fields
                .iter()
                .map(|field| {
                    let areas = Areas::of(field, 30);
                    let whole: f64 = (0..30).map(|k| areas.total(k)).sum();
                    let mean = whole / layout.particles() as f64;
                    let outer = areas.total(29) / f64::from(layout.sectors[29]);
                    (outer / mean - 1.0).abs()
                })
                .fold(0.0, f64::max)
        };
        let of_one = worst(&Layout::equal_area([&fields[0]], 30, 60));
        let of_both = worst(&Layout::equal_area(&fields, 30, 60));
        assert!(of_one > 0.1 && of_both < 0.7 * of_one, "{of_one} {of_both}");
    }

    #[test]
    fn particles_of_pixels_agree_with_those_of_the_field_they_were_drawn_from() {
        let (section, area) = section();
        let grid = Grid {
            count: 512,
            pixel: 0.12 / 512.0,
        };
        let map = fill(&grid, &section.outline.loops);
        let passes = field_passes(&grid, &map, &section.field, 10);
        let numbers = RingNumbers::alternating(20, &TISSUE);
        let layout = Layout::fixed(10, 24);
        let particles = pixel_particles(&section, (&grid, &passes), &numbers, &layout, 3);
        assert_eq!(particles.len(), 240);
        let sum: f64 = particles.iter().map(|p| p.area).sum();
        assert!((sum / area - 1.0).abs() < 2e-3, "{sum} of {area}");
        for p in &particles {
            let d = p.position - section.frame.origin;
            let rho = section
                .field
                .address(DVec2::new(d.dot(DVec3::Y), d.dot(DVec3::Z)))
                .0;
            // A pixel or so beyond the ring's outer contour, which is 0.05 m at ρ = 1.
            assert!(
                (rho - p.rho).abs() < 2.5 * grid.pixel / 0.044,
                "{p:?}: {rho}"
            );
        }
    }
}
