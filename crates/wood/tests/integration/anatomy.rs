//! Sections, voxels and surfaces of stems whose measures are known.

use crate::support;
#[allow(dead_code)]
use glam::DVec3;
use greenstick_geometry::{Context, Mesh};
use greenstick_wood::anatomy::{
    AddressMapping, Anatomy, AnatomyError, AnatomyOptions, GrainAddress, LayerOptions,
    MappingComparison, ParticleLayers, SectorDivision, SpringDirection, StemSections,
    SurfaceColouring,
};
use greenstick_wood::appearance::WoodAppearance;
use greenstick_wood::primitive::{BranchOptions, branch, cylinder};
use greenstick_wood::raster::fill_loops;
use greenstick_wood::rings::RingDivision;
use greenstick_wood::stem::{FoundStem, StemKind, StemOptions, find_stem};
use std::f64::consts::{PI, TAU};

fn found(mesh: &Mesh) -> FoundStem {
    found_at(mesh, "0.5", StemOptions::default())
}

fn found_at(mesh: &Mesh, place: &str, options: StemOptions) -> FoundStem {
    let place = place.parse().unwrap();
    let meshes = std::slice::from_ref(mesh);
    find_stem(meshes, &place, &options, &Context::quiet()).unwrap()
}

fn sections<'a>(
    found: &'a FoundStem,
    mesh: &Mesh,
    resolution: usize,
) -> Result<StemSections<'a>, AnatomyError> {
    StemSections::new(found, mesh, resolution, &Context::quiet())
}

/// Volume of all voxels, m³.
fn volume(found: &FoundStem, mesh: &Mesh, resolution: usize) -> f64 {
    let stem = sections(found, mesh, resolution).unwrap();
    let mut voxels = 0;
    for segment in &stem.segments {
        for k in 0..resolution {
            if let Some(outline) = stem.outline(stem.length_in_segment(segment, k)) {
                voxels += fill_loops(&stem.grid, &outline.loops).count();
            }
        }
    }
    voxels as f64 * stem.grid.pixel * stem.grid.pixel * stem.spacing()
}

/// A quarter of a torus, closed by fans: tube radius 0.05 m about a circle of radius 0.4 m.
fn bend() -> Mesh {
    let (rows, around) = (160_u32, 96_u32);
    let mut mesh = Mesh::default();
    for i in 0..=rows {
        let (s, c) = (0.5 * PI * f64::from(i) / f64::from(rows)).sin_cos();
        for j in 0..around {
            let (v, u) = (TAU * f64::from(j) / f64::from(around)).sin_cos();
            let r = 0.4 + 0.05 * u;
            mesh.positions.push(DVec3::new(r * c, r * s, 0.05 * v));
        }
    }
    for i in 0..rows {
        for j in 0..around {
            let (a, b) = (i * around + j, i * around + (j + 1) % around);
            mesh.triangles
                .extend([[a, b + around, b], [a, a + around, b + around]]);
        }
    }
    for (row, middle, flip) in [(0, DVec3::X * 0.4, false), (rows, DVec3::Y * 0.4, true)] {
        let m = mesh.positions.len() as u32;
        mesh.positions.push(middle);
        for j in 0..around {
            let (a, b) = (row * around + j, row * around + (j + 1) % around);
            mesh.triangles
                .push(if flip { [m, b, a] } else { [m, a, b] });
        }
    }
    if mesh.volume() < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    mesh
}

#[test]
fn voxel_volume_tends_to_the_mesh_volume() {
    let mesh = branch(&BranchOptions::default());
    let found = found(&mesh);
    let whole = mesh.volume();
    let errors: Vec<f64> = [32, 64, 128]
        .iter()
        .map(|&n| (volume(&found, &mesh, n) / whole - 1.0).abs())
        .collect();
    // Pixels at the border are in or out by their middle: the error falls at least as fast as the pixel's side.
    for (error, n) in errors.iter().zip([32.0, 64.0, 128.0]) {
        assert!(*error < 0.1 / n, "{errors:?}");
    }
}

#[test]
fn a_bent_tube_has_the_volume_of_pappus() {
    let mesh = bend();
    let found = found(&mesh);
    let pappus = PI * 0.0025 * 0.4 * 0.5 * PI;
    assert!((mesh.volume() / pappus - 1.0).abs() < 2e-3);
    let stem = sections(&found, &mesh, 64).unwrap();
    assert!(stem.segments.len() >= 5);
    // Square to the centreline every section is the tube's circle; along a world axis none of most would be.
    let (low, high) = stem.whole;
    for k in 0..50 {
        let s = low + (high - low) * (f64::from(k) + 0.5) / 50.0;
        let section = stem.section(s).unwrap();
        assert!(
            (section.outline.area / (PI * 0.0025) - 1.0).abs() < 0.01,
            "{s}: {}",
            section.outline.area
        );
    }
    // All sections are the same circle, so the error of its pixels does not average out: at 256 it is about r^(2/3) of
    // πr², with r = 123 pixels 5e-4.
    let voxels = volume(&found, &mesh, 256);
    assert!(
        (voxels / mesh.volume() - 1.0).abs() < 1e-3,
        "{voxels} {}",
        mesh.volume()
    );
}

/// A board of 0.3 m × 0.9 m × 25 mm with a slot through it that leaves 50 mm at its sides.
fn slotted_board() -> Mesh {
    let (xs, ys, zs) = ([0.0, 0.05, 0.25, 0.3], [0.0, 0.2, 0.6, 0.9], [0.0, 0.025]);
    let mut mesh = Mesh::default();
    for k in 0..32 {
        let (x, y, z) = (xs[k % 4], ys[k / 4 % 4], zs[k / 16]);
        mesh.positions.push(DVec3::new(x, y, z));
    }
    let at = |x: i32, y: i32, z: i32| (x + 4 * y + 16 * z) as u32;
    let wood = |x: i32, y: i32| (0..3).contains(&x) && (0..3).contains(&y) && (x, y) != (1, 1);
    let mut quad = |c: [u32; 4]| {
        let halves = [[c[0], c[1], c[2]], [c[0], c[2], c[3]]];
        mesh.triangles.extend(halves);
    };
    for (x, y) in (0..9).map(|k| (k % 3, k / 3)).filter(|&(x, y)| wood(x, y)) {
        let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
        quad(corners.map(|(x, y)| at(x, y, 1)));
        let mut below = corners;
        below.reverse();
        quad(below.map(|(x, y)| at(x, y, 0)));
        for (k, beside) in [(x, y - 1), (x + 1, y), (x, y + 1), (x - 1, y)]
            .into_iter()
            .enumerate()
        {
            if !wood(beside.0, beside.1) {
                let (a, b) = (corners[k], corners[(k + 1) % 4]);
                quad([
                    at(a.0, a.1, 0),
                    at(b.0, b.1, 0),
                    at(b.0, b.1, 1),
                    at(a.0, a.1, 1),
                ]);
            }
        }
    }
    mesh
}

#[test]
fn both_sides_of_a_slot_are_wood() {
    let mesh = slotted_board();
    assert!(
        (mesh.volume() / (0.025 * (0.27 - 0.08)) - 1.0).abs() < 1e-12 && mesh.check().is_solid()
    );
    let kind = Some(StemKind::Board);
    let found = found_at(
        &mesh,
        "0.9",
        StemOptions {
            kind,
            slope_of_grain: 0.0,
            ..StemOptions::default()
        },
    );
    let stem = sections(&found, &mesh, 512).unwrap();
    let section = stem.section(0.4).unwrap();
    assert_eq!(section.outline.own_loops, 2);
    assert!((section.outline.area - 0.1 * 0.025).abs() < 1e-12);
    assert!((section.outline.girth - 0.3).abs() < 1e-12);
    let rhos = section.outline.points().map(|p| section.field.address(p).0);
    assert!((rhos.fold(0.0, f64::max) - 1.0).abs() < 1e-12);
    let voxels = volume(&found, &mesh, 256);
    assert!((voxels / mesh.volume() - 1.0).abs() < 0.05, "{voxels}");
}

#[test]
fn holes_are_bridged_and_reported() {
    let whole = cylinder(0.05, 0.6, 90);
    let found_whole = found(&whole);
    let reference = sections(&found_whole, &whole, 64).unwrap();
    // Every triangle with its middle in a window of the bark is taken out: 30° of the girth.
    let axis = found_whole.stem.grain.axis();
    let mut torn = whole.clone();
    let middle = |t: &[u32; 3]| {
        t.iter()
            .map(|&v| whole.positions[v as usize])
            .sum::<DVec3>()
            / 3.0
    };
    let from = middle(&whole.triangles[20]);
    let frame = axis.frame(axis.length_at(from));
    let side = (from - frame.origin).normalize();
    torn.triangles.retain(|t| {
        let m = middle(t);
        let f = axis.frame(axis.length_at(m));
        let across = (m - f.origin).reject_from(f.tangent);
        let end = across.length() < 0.045;
        end || across.normalize().dot(side) < (PI / 12.0).cos()
    });
    assert!(torn.triangles.len() < whole.triangles.len());
    let shell: Vec<u32> = (0..torn.triangles.len() as u32).collect();
    let found_torn = FoundStem {
        shell,
        ..found_whole.clone()
    };
    let stem = sections(&found_torn, &torn, 64).unwrap();
    let (a, b) = (reference.outline(0.3).unwrap(), stem.outline(0.3).unwrap());
    assert_eq!(a.bridged, 0.0);
    // The chord of 30° and a little: 2 sin 15° of the 2π radii, and r²/2 (θ − sin θ) of the area is cut off.
    assert!((b.bridged - 0.083).abs() < 0.015, "{}", b.bridged);
    let lost = 1.0 - b.area / a.area;
    assert!(lost > 1e-3 && lost < 8e-3, "{lost}");
}

#[test]
fn the_surface_of_particles_is_closed_and_holds_the_stem() {
    let mesh = branch(&BranchOptions::default());
    let found = found(&mesh);
    let options = AnatomyOptions {
        resolution: 32,
        division: RingDivision::Even(12),
        ..AnatomyOptions::default()
    };
    let wood = WoodAppearance::default();
    let anatomy = Anatomy::new(&found, &mesh, &options, wood, &Context::quiet()).unwrap();
    let (low, high) = anatomy.sections().whole;
    let count = 150;
    for division in [SectorDivision::EqualAngle, SectorDivision::EqualArea] {
        let options = LayerOptions {
            sectors: 120,
            layers: Some(count),
            division,
        };
        let layers = ParticleLayers::sample(&anatomy, &options, &Context::quiet()).unwrap();
        assert_eq!(layers.equation_1(), layers.particles().count() as u64);
        let mut volumes = Vec::new();
        for ring in [6, 12] {
            let surface = layers.surface(ring, SurfaceColouring::Ring).unwrap();
            let report = surface.check();
            assert!(report.is_solid(), "ring {ring}: {report}");
            volumes.push(surface.volume());
        }
        // A slab of the end's half layer is missing on either side.
        let between = 1.0 - 1.0 / f64::from(count);
        let part = volumes[1] / (mesh.volume() * (high - low) / found.stem.length * between);
        assert!((part - 1.0).abs() < 0.01, "{part}");
        assert!(
            (0.2..0.3).contains(&(volumes[0] / volumes[1])),
            "{volumes:?}"
        );
    }
}

#[test]
fn odd_requests_are_refused() {
    let mesh = cylinder(0.05, 0.6, 24);
    let found = found(&mesh);
    for resolution in [0, 31, 513, usize::MAX] {
        let made = sections(&found, &mesh, resolution);
        assert_eq!(made.err(), Some(AnatomyError::Resolution(resolution)));
    }
    let nothing = FoundStem {
        shell: vec![u32::MAX],
        ..found
    };
    assert!(matches!(
        sections(&nothing, &mesh, 32),
        Err(AnatomyError::NoSections(_))
    ));
}

#[test]
fn scans_have_sections_all_along() {
    let mesh = support::ply(&support::data::data("pole.ply"), 1e-3);
    let found = found(&mesh);
    let voxels = volume(&found, &mesh, 32);
    assert!(
        (voxels / mesh.volume() - 1.0).abs() < 0.01,
        "{voxels} {}",
        mesh.volume()
    );
}

/// An anatomy with `rings` rings, and its layers.
fn with_layers<'a>(
    found: &'a FoundStem,
    mesh: &Mesh,
    rings: u16,
    options: &LayerOptions,
) -> (Anatomy<'a>, ParticleLayers) {
    let division = RingDivision::Even(rings);
    let anatomy_options = AnatomyOptions {
        resolution: 64,
        division,
        ..AnatomyOptions::default()
    };
    let look = WoodAppearance::softwood();
    let anatomy = Anatomy::new(found, mesh, &anatomy_options, look, &Context::quiet()).unwrap();
    let layers = ParticleLayers::sample(&anatomy, options, &Context::quiet()).unwrap();
    (anatomy, layers)
}

#[test]
fn particles_have_six_neighbours_and_springs_their_distances() {
    // A cylinder of 2 cm about z: spacing 1 cm, rings 2 mm apart, 24 sectors.
    let mesh = cylinder(0.02, 0.2, 96);
    let found = found(&mesh);
    let options = LayerOptions {
        sectors: 24,
        layers: Some(10),
        ..LayerOptions::default()
    };
    let (_, layers) = with_layers(&found, &mesh, 10, &options);
    let springs = layers.springs();
    let count = |d| springs.iter().filter(|s| s.direction == d).count();
    assert_eq!(count(SpringDirection::Tangential), 10 * 24 * 10);
    assert_eq!(count(SpringDirection::Radial), 9 * 24 * 10);
    assert_eq!(count(SpringDirection::Longitudinal), 10 * 24 * 9);
    // Symmetric: each pair once, and every particle within has two neighbours in each direction.
    let particles: Vec<_> = layers.particles().collect();
    let mut neighbours = vec![[0; 3]; particles.len()];
    let mut pairs: Vec<[u32; 2]> = springs.iter().map(|s| s.particles).collect();
    pairs.dedup();
    assert_eq!(pairs.len(), springs.len());
    for s in &springs {
        let [a, b] = s.particles.map(|i| i as usize);
        assert!(a < b);
        neighbours[a][s.direction as usize] += 1;
        neighbours[b][s.direction as usize] += 1;
        let (p, q) = (particles[a], particles[b]);
        assert_eq!(s.rest_length, p.position.distance(q.position));
        // Chord of the ring, width of the ring, distance of the layers.
        let expected = match s.direction {
            SpringDirection::Tangential => 0.004 * f64::from(p.ring) * (PI / 24.0).sin(),
            SpringDirection::Radial => 0.002,
            SpringDirection::Longitudinal => layers.spacing,
        };
        assert!(
            (s.rest_length / expected - 1.0).abs() < 5e-3,
            "{s:?}: {expected}"
        );
        let outer = if p.ring > q.ring { p } else { q };
        assert_eq!(s.tissue, outer.tissue);
    }
    for (p, found) in particles.iter().zip(&neighbours) {
        let ends = |inner: bool| if inner { 2 } else { 1 };
        let expected = [
            ends((2..10).contains(&p.ring)),
            2,
            ends((1..9).contains(&p.layer)),
        ];
        assert_eq!(found, &expected, "{p:?}");
    }
    // Where outer rings have more sectors, each particle beyond the first ring still has one neighbour inwards.
    let equal_area = LayerOptions {
        division: SectorDivision::EqualArea,
        ..options
    };
    let (_, layers) = with_layers(&found, &mesh, 10, &equal_area);
    let per_layer: u32 = layers.layout.sectors.iter().sum();
    let radial = layers.springs();
    let radial = radial
        .iter()
        .filter(|s| s.direction == SpringDirection::Radial);
    assert_eq!(
        radial.count() as u32,
        10 * (per_layer - layers.layout.sectors[0])
    );
}

#[test]
fn the_published_mapping_is_within_half_a_cell_of_the_continuous_one() {
    let mesh = branch(&BranchOptions::default());
    let found = found(&mesh);
    for division in [SectorDivision::EqualAngle, SectorDivision::EqualArea] {
        let options = LayerOptions {
            sectors: 48,
            layers: Some(60),
            division,
        };
        let (anatomy, layers) = with_layers(&found, &mesh, 12, &options);
        let continuous = AddressMapping::Continuous(&anatomy);
        let discrete = AddressMapping::Discrete(&layers);
        let (low, high) = anatomy.sections().whole;
        let mut greatest = 0.0_f64;
        for k in 0..400_u32 {
            // Points that fill the box evenly (golden-ratio lattice in three dimensions).
            let part = |a: f64| (f64::from(k) * a + 0.5).fract();
            let at = GrainAddress {
                rho: 0.08 + 0.92 * part(0.819_172_513_396_164_4),
                angle: TAU * part(0.671_043_606_703_789_3),
                along: low + (high - low) * part(0.549_700_477_901_970_3),
            };
            let p = layers.particle_at(&at).unwrap();
            let sectors = layers.layout.sectors[usize::from(p.ring) - 1];
            assert!((p.rho - at.rho).abs() <= 0.5 / 12.0 + 1e-9, "{at:?} {p:?}");
            assert!(
                (p.length - at.along).abs() <= 0.5 * layers.spacing + 1e-9,
                "{at:?} {p:?}"
            );
            let turn = (p.angle - at.angle).rem_euclid(TAU);
            // Sectors of equal area are not of equal angle.
            let widest = if division == SectorDivision::EqualAngle {
                0.5
            } else {
                0.8
            };
            let apart = PI - (turn - PI).abs();
            assert!(
                apart <= widest * TAU / f64::from(sectors) + 1e-9,
                "{at:?} {p:?}"
            );
            // In space: half the cell's diagonal, of which the ring's width is on average a twelfth of the radius.
            let [a, b] = [&continuous, &discrete].map(|m| m.position(&at).unwrap());
            let radius = found.stem.radius * 1.6;
            let cell = DVec3::new(
                radius / 12.0,
                TAU * radius * at.rho / f64::from(sectors) * 2.0 * widest,
                layers.spacing,
            );
            greatest = greatest.max(a.distance(b) / (0.5 * cell.length()));
        }
        println!("{division:?}: {greatest:.2} of half a cell's diagonal at most");
        assert!(greatest <= 1.0, "{greatest}");
        let beyond = GrainAddress {
            rho: 0.5,
            angle: 0.0,
            along: high + layers.spacing,
        };
        assert!(layers.particle_at(&beyond).is_none());
    }
}

#[test]
fn mappings_differ_by_what_cells_of_a_cylinder_leave() {
    // A cylinder of 2 cm about z: rings 2 mm apart, 24 sectors, layers 5 mm apart. In a cell points are off its particle evenly.
    let (radius, width, turn, spacing) = (0.02_f64, 0.002_f64, TAU / 24.0, 0.005_f64);
    let mesh = cylinder(radius, 0.2, 256);
    let found = found(&mesh);
    let options = LayerOptions {
        sectors: 24,
        layers: Some((0.2 / spacing).round() as u32),
        division: SectorDivision::EqualAngle,
    };
    let (anatomy, layers) = with_layers(&found, &mesh, 10, &options);
    assert!((layers.spacing / spacing - 1.0).abs() < 0.01);
    let compared = MappingComparison::new(&anatomy, &layers, &Context::quiet()).unwrap();
    let count = compared.addresses.len();
    assert!(count > 9_900, "{count}");
    let squares: f64 = compared
        .addresses
        .iter()
        .map(|m| m.distance().powi(2))
        .sum();
    let arc = 0.5 * radius.powi(2) * turn.powi(2);
    let expected = ((width.powi(2) + arc + spacing.powi(2)) / 12.0).sqrt();
    let found = (squares / count as f64).sqrt();
    assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
    assert_eq!(compared.table().rows(), count);
}

#[test]
fn the_table_of_rings_has_the_widths_of_the_years() {
    let mesh = cylinder(0.02, 0.2, 256);
    let found = found(&mesh);
    let options = AnatomyOptions {
        resolution: 64,
        division: RingDivision::Grown { count: 20, seed: 3 },
        ..AnatomyOptions::default()
    };
    let look = WoodAppearance::softwood();
    let anatomy = Anatomy::new(&found, &mesh, &options, look, &Context::quiet()).unwrap();
    let few = LayerOptions {
        layers: Some(2),
        ..LayerOptions::default()
    };
    let layers = ParticleLayers::sample(&anatomy, &few, &Context::quiet()).unwrap();
    let rings = &layers.layers[0].section.rings;
    // Years differ, and areas, which are those of the particles, are those of rings with these radii.
    let (narrow, wide) = rings
        .widths
        .iter()
        .fold((1.0, 0.0), |(low, high): (f64, f64), w| {
            (low.min(*w), high.max(*w))
        });
    assert!(wide > 1.5 * narrow, "{:?}", rings.widths);
    let mut inner = 0.0;
    for (radius, area) in rings.radii.iter().zip(&rings.areas) {
        let ring = PI * (radius * radius - inner * inner);
        assert!((area / ring - 1.0).abs() < 2e-3, "{radius}: {area} {ring}");
        inner = *radius;
    }
    assert!((inner / 0.02 - 1.0).abs() < 1e-3);
}

#[test]
fn a_scan_of_few_cells_has_smooth_sections_of_the_same_area() {
    let mesh = cylinder(0.1, 1.0, 16);
    let found = found(&mesh);
    let plain = sections(&found, &mesh, 64).unwrap();
    let smooth = plain.clone().smoothed(Some(2e-3));
    let [a, b] = [&plain, &smooth].map(|s| s.outline(0.5).unwrap());
    assert!((a.area / b.area - 1.0).abs() < 1e-12);
    assert!(b.smoothing_residual > 1e-4 && b.smoothing_residual <= 2e-3);
    // The circle through the corners has 16 · sin(π/16) · 2r of girth as a polygon, and its area's circle less than that.
    let circle = TAU * b.mean_radius();
    assert!(
        b.girth < a.girth && (b.girth / circle - 1.0).abs() < 1e-3,
        "{} {circle}",
        b.girth
    );
    assert!(b.loops[0].len() > 100);
}
