//! Cutting tubes along random surfaces: closed, oriented, volumes add up.

use glam::{DVec2, DVec3};
use greenstick_fracture::cut::{
    Cut, CutWorkspace, FacetGrid, Host, Side, Skin, Solid, cut, cut_again,
};
use greenstick_fracture::surface::{FractureSurface, SectionLayout};
use greenstick_geometry::Context;
use std::collections::HashMap;
use std::sync::Arc;

fn hash(a: u64, b: u64) -> f64 {
    let mut x = a.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ b.wrapping_mul(0xD1B5_4A32_D192_ED03);
    x ^= x >> 31;
    x = x.wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^= x >> 29;
    (x >> 11) as f64 / (1u64 << 53) as f64
}

/// A closed rough tube of radius about 1 along z from 0 to 10.
fn tube(around: usize, along: usize, rough: f64) -> (Vec<[u32; 3]>, Vec<DVec3>) {
    let mut points = Vec::new();
    for k in 0..=along {
        for i in 0..around {
            let a = std::f64::consts::TAU * (i as f64 + 0.3 * hash(1, (k * around + i) as u64))
                / around as f64;
            let r = 1.0 + rough * (hash(2, (k * around + i) as u64) - 0.5);
            points.push(DVec3::new(
                r * a.cos(),
                r * a.sin(),
                10.0 * k as f64 / along as f64,
            ));
        }
    }
    let (low, high) = (points.len() as u32, points.len() as u32 + 1);
    points.extend([DVec3::new(0.01, 0.02, 0.0), DVec3::new(0.013, -0.007, 10.0)]);
    let id = |k: usize, i: usize| (k * around + i % around) as u32;
    let mut triangles = Vec::new();
    for i in 0..around {
        for k in 0..along {
            let [a, b, c, d] = [id(k, i), id(k, i + 1), id(k + 1, i + 1), id(k + 1, i)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([low, id(0, i + 1), id(0, i)]);
        triangles.push([high, id(along, i), id(along, i + 1)]);
    }
    (triangles, points)
}

/// Bricks of rings and sectors with random corner heights: cells of four-sided fans.
fn bricks(rings: usize, sectors: usize, rough: f64, smooth: bool, seed: u64) -> FractureSurface {
    let (mut nodes, mut facets, mut cells) = (vec![DVec2::ZERO], Vec::new(), Vec::new());
    for r in 0..rings {
        for j in 0..2 * sectors {
            let a = std::f64::consts::TAU * (j as f64 + 0.37 * r as f64) / (2 * sectors) as f64;
            let radius = if r == rings - 1 {
                1.6
            } else {
                (r + 1) as f64 / rings as f64
            };
            nodes.push(radius * DVec2::new(a.cos(), a.sin()));
        }
    }
    let id = |r: usize, j: usize| (1 + r * 2 * sectors + j % (2 * sectors)) as u32;
    for j in 0..2 * sectors {
        facets.push([0, id(0, j), id(0, j + 1)]);
        cells.push(0);
        for r in 1..rings {
            // Bricks of two sectors, offset by one from ring to ring.
            let cell = 1 + r * sectors + ((j + r) / 2) % sectors;
            facets.push([id(r - 1, j), id(r, j), id(r, j + 1)]);
            facets.push([id(r - 1, j), id(r, j + 1), id(r - 1, j + 1)]);
            cells.extend([cell as u32; 2]);
        }
    }
    let heights = facets
        .iter()
        .zip(&cells)
        .map(|(f, &c)| {
            f.map(|n| {
                let step = if smooth {
                    0.0
                } else {
                    3.0 * hash(seed, u64::from(c))
                };
                4.0 + step
                    + rough * hash(seed + 1, u64::from(n))
                    + rough * hash(u64::from(n), u64::from(if smooth { 0 } else { c }))
            })
        })
        .collect();
    FractureSurface {
        layout: Arc::new(SectionLayout::new(nodes, facets, cells)),
        heights,
    }
}

fn place(cut: &Cut, points: &[DVec3], triangles: &[[u32; 3]], id: u32) -> DVec3 {
    match cut.host(id) {
        Host::Point(p) => points[p as usize],
        Host::Edge { ends, t } => points[ends[0] as usize].lerp(points[ends[1] as usize], t),
        Host::Face { triangle, weights } => {
            let c = triangles[triangle as usize];
            (0..3).map(|i| points[c[i] as usize] * weights[i]).sum()
        }
        Host::Inside => cut.grain(points, id),
    }
}

fn check_closed(triangles: &[[u32; 3]], what: &str) {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for t in triangles {
        assert!(
            t[0] != t[1] && t[1] != t[2] && t[0] != t[2],
            "{what}: degenerate {t:?}"
        );
        for k in 0..3 {
            *edges.entry((t[k], t[(k + 1) % 3])).or_default() += 1;
        }
    }
    for (&(a, b), &n) in &edges {
        assert!(
            n == 1 && edges.get(&(b, a)) == Some(&1),
            "{what}: edge {a}–{b} used {n} times, back {:?}",
            edges.get(&(b, a))
        );
    }
}

fn volume(triangles: &[[u32; 3]], at: impl Fn(u32) -> DVec3) -> f64 {
    triangles
        .iter()
        .map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2]))))
        .sum::<f64>()
        / 6.0
}

#[test]
fn both_pieces_are_closed_and_their_volumes_add_up() {
    for seed in 0..40u64 {
        let (around, along) = (7 + (seed as usize * 5) % 40, 2 + (seed as usize * 7) % 60);
        let (triangles, points) = tube(around, along, 0.25 * hash(9, seed));
        let smooth = seed % 3 == 0;
        let rings = 2 + seed as usize % 6;
        let surface = bricks(
            rings,
            5 + seed as usize % 20,
            2.0 * hash(4, seed),
            smooth,
            seed,
        );
        let all: Vec<u32> = (0..triangles.len() as u32).collect();
        let solid = Solid {
            triangles: &triangles,
            points: &points,
            shell: &all,
            limb: &all,
        };
        let cut = cut(&solid, &surface).unwrap_or_else(|e| panic!("seed {seed}: {e}"));
        let whole = volume(&triangles, |i| points[i as usize]);
        let mut sum = 0.0;
        for upper in [false, true] {
            let side = if upper { Side::Upper } else { Side::Lower };
            let mut piece: Vec<[u32; 3]> = (0..triangles.len())
                .filter(|&t| cut.sides[t] == side)
                .map(|t| triangles[t])
                .collect();
            piece.extend(
                cut.skin
                    .iter()
                    .filter(|s| s.upper == upper)
                    .map(|s| s.corners),
            );
            piece.extend(
                cut.cap
                    .iter()
                    .map(|&[a, b, c]| if upper { [a, c, b] } else { [a, b, c] }),
            );
            check_closed(&piece, &format!("seed {seed} upper {upper}"));
            let v = volume(&piece, |id| place(&cut, &points, &triangles, id));
            assert!(v > 0.0, "seed {seed}: volume {v}");
            sum += v;
        }
        assert!(
            (sum / whole - 1.0).abs() < 1e-12,
            "seed {seed}: {sum} against {whole}"
        );
    }
}

#[test]
fn a_cut_does_not_depend_on_those_made_before_on_the_same_ground() {
    let (triangles, points) = tube(30, 40, 0.2);
    let all: Vec<u32> = (0..triangles.len() as u32).collect();
    let solid = Solid {
        triangles: &triangles,
        points: &points,
        shell: &all,
        limb: &all,
    };
    let skin = Skin::new(&solid, (0.0, 10.0));
    for smooth in [false, true] {
        let surface = bricks(5, 14, 1.5, smooth, 3);
        let grid = FacetGrid::new(&skin, &surface.layout);
        let made = |heights: Vec<[f64; 3]>, workspace: &mut CutWorkspace| {
            let surface = FractureSurface {
                layout: surface.layout.clone(),
                heights,
            };
            let cut = cut_again(&solid, &skin, &grid, &surface, workspace, &Context::quiet())
                .expect("cuts");
            (cut.vertices, cut.inside, cut.skin, cut.cap, cut.walls)
        };
        let mut workspace = CutWorkspace::default();
        for shift in [0.0, 0.8, -0.4] {
            let tilted = |h: f64, n: u32| h * 0.9 + shift * surface.layout.nodes[n as usize].x;
            let heights: Vec<[f64; 3]> = (surface.heights.iter().zip(&surface.layout.facets))
                .map(|(h, f)| [0, 1, 2].map(|k| tilted(h[k], f[k])))
                .collect();
            let fresh = made(heights.clone(), &mut CutWorkspace::default());
            assert!(made(heights, &mut workspace) == fresh, "shift {shift}");
        }
    }
}
