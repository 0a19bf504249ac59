//! Particles (Forests 2023 §3.4): a section's bundles of fibres, each by its ring, sector and layer.
//!
//! A particle lies on its ring's outer contour, as published, so that those of the outermost ring are the bark.

use super::outline::Outline;
use super::section_raster::SectionRaster;
use super::sections::TransverseSection;
use super::sectors::{RingAreas, SectorDivision, SectorLayout};
use crate::rings::ConcentricRings;
use crate::tissue::Zone;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// A bundle of fibres in one layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Particle {
    /// Ring, counted from 1 at the pith.
    pub ring: u16,
    /// Sector, counted from 0 at the frame's x counter-clockwise.
    pub sector: u32,
    /// Layer, counted from 0 at the base.
    pub layer: u32,
    /// Position in the world, m.
    pub position: DVec3,
    /// Length along the centreline, m.
    pub length: f64,
    /// Ring coordinate of the ring's outer contour, 0 at the pith to 1 at the bark.
    pub rho: f64,
    /// Angle about the pith, rad, 0 to 2π.
    pub angle: f64,
    /// Tissue.
    pub tissue: Zone,
    /// Area of the bundle's cross-section, m².
    pub area: f64,
}

/// The particles of a round stem's section, ring by ring from the pith, sector by sector.
pub fn particles_from_field(
    section: &TransverseSection,
    layer: u32,
    layout: &SectorLayout,
    rings: &ConcentricRings,
) -> Vec<Particle> {
    let areas = RingAreas::new(&section.field, rings);
    let mut particles = Vec::with_capacity(layout.particles() as usize);
    for (k, &sectors) in layout.sectors.iter().enumerate() {
        let rho = rings.edges()[k];
        let share = areas.total(k) / f64::from(sectors);
        for sector in 0..sectors {
            let (angle, area) = match layout.division {
                SectorDivision::EqualArea => (areas.angle(k, share * f64::from(sector)), share),
                SectorDivision::EqualAngle => {
                    let step = TAU / f64::from(sectors);
                    let angle = step * f64::from(sector);
                    let area =
                        areas.up_to(k, angle + 0.5 * step) - areas.up_to(k, angle - 0.5 * step);
                    (angle, area)
                }
            };
            particles.push(Particle {
                ring: k as u16 + 1,
                sector,
                layer,
                position: section.world(section.field.point(rho, angle)),
                length: section.length,
                rho,
                angle,
                tissue: rings.tissues()[k],
                area,
            });
        }
    }
    particles
}

/// The particles of a section by its pixels, as after an erosion; also of boards, whose rings are cut off by their faces.
/// Rings that have no pixel have no particles.
///
/// As published, rays go out from the centre of what each pass left, at equal angles, and a particle is where the first
/// pixel beyond is met. Where the centre lies off the ring's own wood (a board) the sectors divide the angle which the
/// section subtends at the pith, and a particle is the middle of its bundle's pixels. Areas are those of the pixels.
pub fn particles_from_raster(
    section: &TransverseSection,
    raster: &SectionRaster,
    layout: &SectorLayout,
    layer: u32,
) -> Vec<Particle> {
    let bundles = PixelBundles::new(section, raster, layout);
    let pixel_area = raster.grid.pixel * raster.grid.pixel;
    let mut particles = Vec::new();
    for (k, bundles_of_ring) in bundles.sums.iter().enumerate() {
        for (sector, sum) in bundles_of_ring.iter().enumerate() {
            if sum.count == 0.0 {
                continue;
            }
            let at = if bundles.pith_inside {
                let angle = TAU * sector as f64 / bundles_of_ring.len() as f64;
                first_pixel_beyond(raster, bundles.centres[k], angle, k + 1)
            } else {
                sum.position / sum.count
            };
            let d = at - bundles.pith;
            particles.push(Particle {
                ring: k as u16 + 1,
                sector: sector as u32,
                layer,
                position: section.world(at),
                length: section.length,
                rho: (k + 1) as f64 / bundles.sums.len() as f64,
                angle: libm::atan2(d.y, d.x).rem_euclid(TAU),
                tissue: raster.legend.tissue_of_ring(k + 1),
                area: sum.count * pixel_area,
            });
        }
    }
    particles
}

/// Sum of the positions (m) of pixels, and their number.
#[derive(Debug, Clone, Copy, Default)]
struct PixelSum {
    position: DVec2,
    count: f64,
}

impl PixelSum {
    fn add(&mut self, position: DVec2, count: f64) {
        self.position += position;
        self.count += count;
    }
}

/// The pixels of a section by ring and sector.
struct PixelBundles {
    pith: DVec2,
    pith_inside: bool,
    /// For each ring the centre of what is left before it is taken: of its pixels and those within it, m.
    centres: Vec<DVec2>,
    /// By ring and sector.
    sums: Vec<Vec<PixelSum>>,
}

impl PixelBundles {
    fn new(section: &TransverseSection, raster: &SectionRaster, layout: &SectorLayout) -> Self {
        let rings = usize::from(raster.legend.rings);
        let pith = section.field.pith();
        let pith_inside = section.outline.contains(pith);
        let mut of_rings = vec![PixelSum::default(); rings];
        for_wood_pixels(raster, |at, ring| of_rings[ring].add(at, 1.0));
        let mut left = PixelSum::default();
        let centres: Vec<DVec2> = of_rings
            .iter()
            .map(|sum| {
                left.add(sum.position, sum.count);
                if pith_inside && left.count > 0.0 {
                    left.position / left.count
                } else {
                    pith
                }
            })
            .collect();
        let window = if pith_inside {
            Window {
                start: 0.0,
                width: TAU,
            }
        } else {
            Window::of_outline(&section.outline, pith)
        };
        // About the pith a sector lies to both sides of its ray; over a window they lie side by side.
        let offset = if pith_inside { 0.5 } else { 0.0 };
        let mut sums: Vec<Vec<PixelSum>> = layout
            .sectors
            .iter()
            .map(|&n| vec![PixelSum::default(); n as usize])
            .collect();
        for_wood_pixels(raster, |at, ring| {
            let Some(sectors) = sums.get_mut(ring).filter(|s| !s.is_empty()) else {
                return;
            };
            let d = at - centres[ring];
            let turn = (libm::atan2(d.y, d.x) - window.start).rem_euclid(TAU) / window.width;
            let sector = (turn * sectors.len() as f64 + offset) as usize % sectors.len();
            sectors[sector].add(at, 1.0);
        });
        PixelBundles {
            pith,
            pith_inside,
            centres,
            sums,
        }
    }
}

/// Visits the position (m) and the ring, counted from 0 at the pith, of every pixel that is wood.
fn for_wood_pixels(raster: &SectionRaster, mut visit: impl FnMut(DVec2, usize)) {
    let rings = usize::from(raster.legend.rings);
    let count = raster.grid.count;
    for (i, &pass) in raster.passes.iter().enumerate() {
        let Some(meaning) = raster.legend.passes.get(usize::from(pass)) else {
            continue;
        };
        if pass > 0 {
            let at = raster.grid.pixel_centre(i % count, i / count);
            visit(at, usize::from(meaning.ring).clamp(1, rings) - 1);
        }
    }
}

/// Where a ray from `centre` leaves the pixels of rings up to `ring`, m: the middle of the first pixel beyond, or of the
/// last one of the grid.
fn first_pixel_beyond(raster: &SectionRaster, centre: DVec2, angle: f64, ring: usize) -> DVec2 {
    let grid = &raster.grid;
    let within = |pass: u16| pass > 0 && usize::from(raster.legend.of(pass).ring) <= ring;
    let (sin, cos) = libm::sincos(angle);
    let direction = DVec2::new(cos, sin);
    let start = grid.to_pixels(centre);
    let mut last = (start.x as usize, start.y as usize);
    // Half pixels, so that no pixel is skipped but at its corner.
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
        if !within(raster.pass(x, y)) {
            break;
        }
    }
    grid.pixel_centre(last.0.min(grid.count - 1), last.1.min(grid.count - 1))
}

/// The angles under which something is seen from a point, rad.
struct Window {
    start: f64,
    width: f64,
}

impl Window {
    /// The angles under which an outline is seen from a point outside of it.
    fn of_outline(outline: &Outline, from: DVec2) -> Self {
        let middle = outline.centroid - from;
        let (mut low, mut high) = (0.0_f64, 0.0_f64);
        for p in outline.points() {
            let d = p - from;
            let angle = libm::atan2(middle.perp_dot(d), middle.dot(d));
            (low, high) = (low.min(angle), high.max(angle));
        }
        Window {
            start: libm::atan2(middle.y, middle.x) + low,
            width: (high - low).clamp(1e-9, TAU),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anatomy::outline::Outline;
    use crate::anatomy::passes::PassLegend;
    use crate::anatomy::passes::passes_of_rings;
    use crate::raster::PixelGrid;
    use crate::raster::fill_loops;
    use crate::rings::RingField;
    use crate::stem::Frame;
    use crate::tissue::{Proportions, Zone};
    use std::borrow::Cow;
    use std::f64::consts::PI;

    const TISSUE: Proportions = Proportions {
        pith: 0.1,
        heartwood: 0.4,
        phloem: 0.1,
    };

    fn rings(count: u16) -> ConcentricRings {
        ConcentricRings::even(count, &TISSUE)
    }

    /// A lobed section of known area with its pith off the middle.
    fn section() -> (TransverseSection, f64) {
        let radius = |a: f64| 0.05 * (1.0 + 0.1 * (3.0 * a).cos());
        let own: Vec<DVec2> = (0..720)
            .map(|i| TAU * f64::from(i) / 720.0)
            .map(|a| DVec2::from_angle(a) * radius(a))
            .collect();
        // ½∫r² dφ = π r0² (1 + 0.1²/2)
        let area = PI * 0.0025 * 1.005;
        let field = RingField::round(&own, DVec2::new(0.006, -0.003), 0.07, None);
        let outline = Outline {
            area,
            centroid: DVec2::ZERO,
            girth: 0.33,
            bridged: 0.0,
            smoothing_residual: 0.0,
            own_loops: 1,
            loops: vec![own],
        };
        let frame = Frame {
            origin: DVec3::new(1.0, 2.0, 3.0),
            x: DVec3::Y,
            y: DVec3::Z,
            tangent: DVec3::X,
        };
        (
            TransverseSection {
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
        let layout = SectorLayout::equal_angle(20, 40);
        let particles = particles_from_field(&section, 7, &layout, &rings(20));
        // One layer of Eq. 1's sum: N_sec · N_ring.
        assert_eq!(particles.len(), 800);
        let sum: f64 = particles.iter().map(|p| p.area).sum();
        assert!((sum / area - 1.0).abs() < 1e-4, "{sum} of {area}");
        // The outermost ring's particles are on the bark, the frame's x axis first.
        let bark = particles.iter().filter(|p| p.ring == 20);
        for (k, p) in bark.enumerate() {
            assert_eq!((p.sector, p.layer, p.tissue), (k as u32, 7, Zone::Bark));
            let d = p.position - section.frame.origin;
            let (x, y) = (d.dot(DVec3::Y), d.dot(DVec3::Z));
            let r = 0.05 * (1.0 + 0.1 * (3.0 * y.atan2(x)).cos());
            assert!((x.hypot(y) - r).abs() < 1e-5 && d.x == 0.0, "{k}");
        }
    }

    #[test]
    fn equal_area_bundles_are_equal_where_fixed_ones_differ_tens_of_times() {
        let (section, area) = section();
        let spread = |layout: &SectorLayout| {
            let particles = particles_from_field(&section, 0, layout, &rings(20));
            assert_eq!(particles.len() as u64, layout.particles());
            let sum: f64 = particles.iter().map(|p| p.area).sum();
            assert!((sum / area - 1.0).abs() < 1e-4);
            let most = particles.iter().map(|p| p.area).fold(0.0, f64::max);
            most / particles
                .iter()
                .map(|p| p.area)
                .fold(f64::INFINITY, f64::min)
        };
        let fixed = spread(&SectorLayout::equal_angle(20, 40));
        let layout = SectorLayout::equal_area([&section.field], &rings(20), 40);
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
        // Two sections, one between roots, whose lobes belong to the outer rings.
        let outline = |wave: f64| -> Vec<DVec2> {
            (0..720)
                .map(|i| TAU * f64::from(i) / 720.0)
                .map(|a| DVec2::from_angle(a) * 0.05 * (1.0 + wave * (7.0 * a).cos()))
                .collect()
        };
        let fields = [0.0, 0.25]
            .map(|wave| RingField::round(&outline(wave), DVec2::new(0.004, 0.0), 0.1, None));
        // Shares of the outermost of 30 rings in bundles of 60 sectors, over the mean bundle of the section.
        let worst = |layout: &SectorLayout| {
            fields
                .iter()
                .map(|field| {
                    let areas = RingAreas::new(field, &rings(30));
                    let whole: f64 = (0..30).map(|k| areas.total(k)).sum();
                    let mean = whole / layout.particles() as f64;
                    let outer = areas.total(29) / f64::from(layout.sectors[29]);
                    (outer / mean - 1.0).abs()
                })
                .fold(0.0, f64::max)
        };
        let of_one = worst(&SectorLayout::equal_area([&fields[0]], &rings(30), 60));
        let of_both = worst(&SectorLayout::equal_area(&fields, &rings(30), 60));
        assert!(of_one > 0.1 && of_both < 0.7 * of_one, "{of_one} {of_both}");
    }

    #[test]
    fn particles_of_pixels_agree_with_those_of_the_field() {
        let (section, area) = section();
        let grid = PixelGrid {
            count: 512,
            pixel: 0.12 / 512.0,
        };
        let wood = fill_loops(&grid, &section.outline.loops);
        let legend = PassLegend::of_rings(&rings(10));
        let raster = SectionRaster {
            grid,
            passes: passes_of_rings(&grid, &wood, &section.field, &rings(10)),
            wood,
            palette: Cow::Owned(vec![[0; 3]; legend.passes.len()]),
            legend: Cow::Owned(legend),
            pith: section.field.pith(),
        };
        let layout = SectorLayout::equal_angle(10, 24);
        let particles = particles_from_raster(&section, &raster, &layout, 3);
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
