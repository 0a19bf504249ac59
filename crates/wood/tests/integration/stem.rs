//! Stems found in made and real meshes.

use crate::support;
use crate::support::stem_at as at;
use glam::DVec3;
use greenstick_geometry::{Context, Mesh, Values};
use greenstick_wood::anatomy::{LimbReport, limb_table};
use greenstick_wood::primitive::{BranchOptions, branch, cylinder};
use greenstick_wood::stem::{
    StemError, StemKind, StemLocation, StemOptions, find_left_out, find_stem,
};
use std::f64::consts::TAU;

/// A tube about a curve with its own frames; `ends` closes it with fans.
fn tube(
    curve: impl Fn(f64) -> DVec3,
    radius: impl Fn(f64) -> f64,
    (rows, around): (usize, usize),
    ends: bool,
) -> Mesh {
    let mut mesh = Mesh::default();
    let mut x = DVec3::ZERO;
    for i in 0..=rows {
        let t = i as f64 / rows as f64;
        let tangent = (curve(t + 1e-5) - curve(t - 1e-5)).normalize();
        x = x
            .reject_from(tangent)
            .try_normalize()
            .unwrap_or(tangent.any_orthonormal_vector());
        let y = tangent.cross(x);
        for j in 0..around {
            let (sin, cos) = (TAU * j as f64 / around as f64).sin_cos();
            mesh.positions
                .push(curve(t) + (x * cos + y * sin) * radius(t));
        }
    }
    let n = around as u32;
    for i in 0..rows as u32 {
        for j in 0..n {
            let (a, b) = (i * n + j, i * n + (j + 1) % n);
            mesh.triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
        }
    }
    if ends {
        for (row, t, flip) in [(0, 0.0, true), (rows as u32, 1.0, false)] {
            let middle = mesh.positions.len() as u32;
            mesh.positions.push(curve(t));
            for j in 0..n {
                let (a, b) = (row * n + j, row * n + (j + 1) % n);
                mesh.triangles
                    .push(if flip { [middle, b, a] } else { [middle, a, b] });
            }
        }
    }
    mesh
}

#[test]
fn the_axis_of_a_tapered_helix_is_found() {
    // Radius of curvature 0.5 m · (1 + 0.3²) against a radius of 5 to 2.5 cm.
    let curve = |t: f64| {
        let a = 2.4 * t;
        DVec3::new(0.5 * a.cos(), 0.15 * a, 0.5 * a.sin())
    };
    let radius = |t: f64| 0.05 - 0.025 * t;
    let mesh = tube(curve, radius, (160, 32), true);
    let found = at(&[mesh], "0.4").unwrap();
    let length = 2.4 * (0.25_f64 + 0.0225).sqrt();
    assert!(
        (found.stem.length / length - 1.0).abs() < 4e-3,
        "{}",
        found.stem.length
    );
    for k in 1..20 {
        let t = f64::from(k) / 20.0;
        let p = found.stem.grain.to_grain(curve(t));
        let off = p.truncate().length() * found.stem.grain.scale(p.z);
        assert!(off < 0.01 * radius(t), "{t}: {off}");
        assert!((p.z / length - t).abs() < 3e-3, "{t}: {}", p.z);
        // The tube's wall is a straight line in grain space.
        let size = found.stem.grain.scale(p.z) / radius(t) * radius(0.4);
        assert!((size - 1.0).abs() < 0.01, "{t}: {size}");
    }
    // A polygon of 32 sides instead of a circle.
    let area = 0.5 * 32.0 / TAU * (TAU / 32.0).sin() * 2.0;
    assert!((found.stem.radius / (radius(0.4) * area.sqrt()) - 1.0).abs() < 2e-3);
    assert_eq!(
        (found.stem.kind, found.stem.ends),
        (StemKind::Round, (true, true))
    );
    assert!(found.stem.usable.0 < 0.03 && found.stem.usable.1 > length - 0.03);
}

#[test]
fn fractions_and_lengths_count_from_the_base() {
    let mesh = cylinder(0.1, 2.0, 48);
    for (place, s) in [
        ("0.25", 0.5),
        ("0.9", 1.8),
        ("70cm", 0.7),
        ("0.11,1.3,0.01", 1.3),
    ] {
        let found = at(std::slice::from_ref(&mesh), place).unwrap();
        assert!(
            (found.stem.location - s).abs() < 1e-3,
            "{place}: {}",
            found.stem.location
        );
        let origin = found.stem.grain.axis().frame(found.stem.location).origin;
        assert!(origin.distance(DVec3::new(0.0, s, 0.0)) < 1e-3);
        assert!(found.stem.rings.pith().length() < 1e-3);
        assert!((found.stem.rings.outer_radius(0.3) - 0.1).abs() < 1e-3);
        assert_eq!(found.shell.len(), mesh.triangles.len());
    }
    let error = at(std::slice::from_ref(&mesh), "3m").unwrap_err();
    assert!(matches!(error, StemError::OffStem { length, .. } if (length - 2.0).abs() < 1e-3));
    assert!(error.to_string().contains("nearest place"), "{error}");
    let error = at(&[mesh], "2,1,0").unwrap_err();
    assert!(matches!(error, StemError::FarFromWood { distance, .. } if distance > 1.8));
}

#[test]
fn an_open_tube_and_five_sides_have_smooth_axes() {
    let curve = |t: f64| DVec3::new(0.3 * (2.0 * t).sin(), 2.0 * t, 0.1 * t * t);
    let found = at(&[tube(curve, |_| 0.08, (12, 5), false)], "0.5").unwrap();
    let stem = &found.stem;
    assert_eq!((stem.kind, stem.ends), (StemKind::Round, (true, true)));
    let axis = stem.grain.axis();
    for k in 1..100 {
        let s = stem.length * f64::from(k) / 100.0;
        let h = 0.02;
        let turn = axis
            .frame(s + h)
            .tangent
            .angle_between(axis.frame(s - h).tangent)
            / (2.0 * h);
        assert!(
            turn * 0.08 * 1.5 < 1.0,
            "{s}: radius of curvature {}",
            1.0 / turn
        );
    }
    // The stem holds every vertex at the same ring coordinate.
    for (i, &p) in tube(curve, |_| 0.08, (12, 5), false)
        .positions
        .iter()
        .enumerate()
        .skip(10)
    {
        if i < 50 {
            let ring = stem.rings.address(stem.grain.to_grain(p).truncate()).0;
            assert!((ring - 1.0).abs() < 0.12, "{i}: {ring}");
        }
    }
}

/// The distance of a point from a tube with round ends, negative inside.
fn capsule(p: DVec3, a: DVec3, b: DVec3, r: f64) -> f64 {
    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a + (b - a) * t) - r
}

/// A welded fork: two tubes' worth of surface.
fn welded_fork() -> Mesh {
    let crotch = DVec3::new(0.0, 1.0, 0.0);
    surface_of(|p| {
        capsule(p, DVec3::ZERO, crotch, 0.12)
            .min(capsule(p, crotch, DVec3::new(0.6, 1.9, 0.0), 0.09))
            .min(capsule(p, crotch, DVec3::new(-0.5, 2.0, 0.0), 0.08))
    })
}

/// The surface of a solid, given by its distance, by marching tetrahedra over a grid.
fn surface_of(solid: impl Fn(DVec3) -> f64) -> Mesh {
    let h = 0.031;
    let place = |i: [i32; 3]| DVec3::new(i[0] as f64, i[1] as f64, i[2] as f64) * h + 0.0071;
    let mut mesh = Mesh::default();
    let mut numbers = std::collections::BTreeMap::new();
    let corners = [
        [0, 0, 0],
        [1, 0, 0],
        [1, 1, 0],
        [0, 1, 0],
        [0, 0, 1],
        [1, 0, 1],
        [1, 1, 1],
        [0, 1, 1],
    ];
    let tetrahedra = [
        [0, 5, 1, 6],
        [0, 1, 2, 6],
        [0, 2, 3, 6],
        [0, 3, 7, 6],
        [0, 7, 4, 6],
        [0, 4, 5, 6],
    ];
    for x in -24..27 {
        for y in -6..70 {
            for z in -6..6 {
                for t in tetrahedra {
                    let nodes = t.map(|k: usize| [0, 1, 2].map(|d| [x, y, z][d] + corners[k][d]));
                    let value = nodes.map(|n| solid(place(n)));
                    let mut edge = |a: usize, b: usize| {
                        let (a, b) = if nodes[a] < nodes[b] { (a, b) } else { (b, a) };
                        *numbers.entry((nodes[a], nodes[b])).or_insert_with(|| {
                            let u = value[a] / (value[a] - value[b]);
                            mesh.positions
                                .push(place(nodes[a]).lerp(place(nodes[b]), u));
                            mesh.positions.len() as u32 - 1
                        })
                    };
                    let inner: Vec<usize> = (0..4).filter(|&k| value[k] < 0.0).collect();
                    let outer: Vec<usize> = (0..4).filter(|&k| value[k] >= 0.0).collect();
                    match (&inner[..], &outer[..]) {
                        (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => {
                            let t = [edge(a, b), edge(a, c), edge(a, d)];
                            mesh.triangles.push(t);
                        }
                        (&[a, b], &[c, d]) => {
                            let q = [edge(a, c), edge(a, d), edge(b, d), edge(b, c)];
                            mesh.triangles
                                .extend([[q[0], q[1], q[2]], [q[0], q[2], q[3]]]);
                        }
                        _ => {}
                    }
                }
            }
        }
    }
    // Outwards, where the solid's distance grows.
    for t in &mut mesh.triangles {
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let (middle, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a).normalize_or_zero());
        if solid(middle + normal * 1e-3) < solid(middle - normal * 1e-3) {
            t.swap(1, 2);
        }
    }
    mesh
}

#[test]
fn a_limb_has_its_place_direction_and_size() {
    // A trunk of 2 m with a limb of 0.07 m radius, 1 m above its middle line's base.
    let (top, tip) = (DVec3::new(0.0, 2.0, 0.0), DVec3::new(0.65, 1.45, 0.0));
    let socket = DVec3::new(0.0, 0.9, 0.0);
    let mesh =
        surface_of(|p| capsule(p, DVec3::ZERO, top, 0.12).min(capsule(p, socket, tip, 0.07)));
    let trunk = at(std::slice::from_ref(&mesh), "0.25").unwrap();
    let left_out = find_left_out(&mesh, &trunk, &Context::quiet()).unwrap();
    let left_out = left_out.unwrap();
    let [limb] = &left_out.limbs[..] else {
        panic!("{:?}", left_out.limbs)
    };
    let arm = (tip - socket).normalize();
    assert!(
        limb.direction.dot(arm) > 5f64.to_radians().cos(),
        "{limb:?}"
    );
    let angle = arm.angle_between(DVec3::Y);
    let turn = limb.angle.min(std::f64::consts::PI - limb.angle);
    assert!(
        (turn - angle).abs() < 5f64.to_radians(),
        "{limb:?}: {angle}"
    );
    assert!((limb.diameter_m / 0.14 - 1.0).abs() < 0.1, "{limb:?}");
    let end = tip + 0.07 * arm;
    let reach = (end - limb.mouth).dot(limb.direction);
    assert!(
        (limb.length_m / reach - 1.0).abs() < 0.02,
        "{limb:?}: {reach}"
    );
    // What is beyond the mouth, of the cylinder and the half ball at its end.
    let beyond = (tip - limb.mouth).dot(arm);
    let volume = std::f64::consts::PI * 0.0049 * (beyond + 2.0 / 3.0 * 0.07);
    assert!(
        (limb.volume_m3 / volume - 1.0).abs() < 0.05,
        "{limb:?}: {volume}"
    );

    let table = limb_table(&[LimbReport::from(limb)]);
    let columns: Vec<(&str, f64)> = (table.columns.iter())
        .map(|c| match &c.values {
            Values::F64(values) => (c.name.as_str(), values[0]),
            other => panic!("{}: {other:?}", c.name),
        })
        .collect();
    let [x, y, z] = limb.mouth.to_array();
    let [u, v, w] = limb.direction.to_array();
    assert_eq!(
        columns[..4],
        [
            ("at", limb.at_m),
            ("mouth_x", x),
            ("mouth_y", y),
            ("mouth_z", z)
        ]
    );
    assert_eq!(
        columns[4..7],
        [("direction_x", u), ("direction_y", v), ("direction_z", w)]
    );
    let size = [("angle", limb.angle), ("diameter", limb.diameter_m)];
    assert_eq!(columns[7..9], size);
    assert_eq!(
        columns[9..],
        [("length", limb.length_m), ("volume", limb.volume_m3)]
    );
}

#[test]
fn the_other_limb_of_a_fork_is_as_thick_as_it_is() {
    let mesh = welded_fork();
    // The thicker limb is taken for the stem's; the other has a radius of 0.08 m.
    let stem = at(std::slice::from_ref(&mesh), "0.25").unwrap();
    let left_out = find_left_out(&mesh, &stem, &Context::quiet()).unwrap();
    let limb = left_out.unwrap().limbs[0];
    let diameter = if limb.centre.x < 0.0 { 0.16 } else { 0.18 };
    assert!((limb.diameter_m / diameter - 1.0).abs() < 0.05, "{limb:?}");
}

#[test]
fn a_welded_fork_is_refused_inside_and_limbs_are_told_apart() {
    let mesh = welded_fork();
    let inside = at(std::slice::from_ref(&mesh), "0.0,1.15,0.1").unwrap_err();
    let StemError::Unusable { nearest, found, .. } = &inside else {
        panic!("{inside}")
    };
    assert!(found.contains("fork"), "{inside}");
    let again = at(std::slice::from_ref(&mesh), &nearest.to_string());
    assert!(again.is_ok(), "{nearest}: {again:?}");
    // A limb, picked by a point: only its own triangles are to be cut.
    let limb = at(std::slice::from_ref(&mesh), "-0.3,1.6,0.08").unwrap();
    assert!(
        (limb.stem.radius - 0.08).abs() < 0.005,
        "{}",
        limb.stem.radius
    );
    assert_eq!(limb.shell.len(), mesh.triangles.len());
    // The other limb is left out, and said to be where it is.
    let left_out = find_left_out(&mesh, &limb, &Context::quiet())
        .unwrap()
        .unwrap();
    // The trunk and the thicker limb measure 0.045 and 0.026 m³, the thinner one 0.021 m³.
    assert!(left_out.limbs[0].centre.x > 0.0, "{left_out}");
    assert!((0.6..0.9).contains(&left_out.share), "{left_out}");
    assert!(
        left_out.to_string().contains("left out, about 0.0"),
        "{left_out}"
    );
    let pole = [cylinder(0.05, 2.0, 24)];
    let found = at(&pole, "0.5").unwrap();
    let nothing = find_left_out(&pole[0], &found, &Context::quiet()).unwrap();
    assert_eq!(nothing, None);
    assert!(limb.limb.len() > 200 && limb.limb.len() < mesh.triangles.len() / 3);
    for &t in &limb.limb {
        assert!(
            mesh.corners(t as usize)
                .iter()
                .all(|p| p.x < 0.1 && p.y > 0.9)
        );
    }
    let (low, high) = limb.stem.usable;
    assert!(low < limb.stem.location && limb.stem.location < high && high - low > 0.5);
    // The trunk, by a fraction of the main stem, which goes on into the thicker arm.
    let trunk = at(std::slice::from_ref(&mesh), "0.2").unwrap();
    assert!((trunk.stem.radius - 0.12).abs() < 0.005);
    assert!(!trunk.stem.ends.1 && trunk.stem.ends.0);
    let y = |s: f64| trunk.stem.grain.axis().frame(s).origin.y;
    assert!(y(trunk.stem.usable.1) < 1.17 && y(trunk.stem.usable.1) > 0.6);
}

#[test]
fn twigs_stuck_into_a_stem_keep_the_break_away_and_move_with_it() {
    let trunk = tube(
        |t| DVec3::Y * (2.0 * t),
        |t| 0.1 - 0.03 * t,
        (30, 16),
        false,
    );
    let twig = |y: f64| {
        tube(
            move |t| DVec3::new(0.6 * t, y + 0.4 * t, 0.0),
            |t| 0.03 - 0.01 * t,
            (20, 8),
            false,
        )
    };
    let leaf = tube(
        |t| DVec3::new(0.5 + 0.1 * t, 1.855 + 0.1 * t, 0.0),
        |_| 0.004,
        (3, 4),
        false,
    );
    let meshes = [trunk, twig(0.5), twig(1.5), leaf];
    let found = at(&meshes, "0.5").unwrap();
    assert_eq!(found.node, 0);
    assert_eq!(
        found.carried.iter().map(|c| c.node).collect::<Vec<_>>(),
        [2, 3]
    );
    assert!(
        found.stem.usable.0 > 0.5 && found.stem.usable.1 < 1.5,
        "{:?}",
        found.stem.usable
    );
    let error = at(&meshes, "50cm").unwrap_err();
    assert!(error.to_string().contains("stuck in it"), "{error}");
    let found = at(&meshes, "0.4,1.8,0.0").unwrap();
    assert_eq!((found.node, found.carried.len()), (2, 1));
    assert!(found.stem.usable.0 > 0.07, "{:?}", found.stem.usable);
}

#[test]
fn a_soup_with_small_gaps_is_welded_and_said_to_be() {
    let mut mesh = Mesh::default();
    let whole = cylinder(0.1, 1.0, 24);
    for (i, t) in whole.triangles.iter().enumerate() {
        let first = mesh.positions.len() as u32;
        let off = DVec3::new((i % 7) as f64, (i % 5) as f64, (i % 3) as f64) * 1e-8;
        mesh.positions
            .extend(t.map(|v| whole.positions[v as usize] + off));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    let found = at(&[mesh], "0.5").unwrap();
    assert!((found.stem.length - 1.0).abs() < 1e-3);
    assert!(
        found.notes.iter().any(|n| n.contains("welded")),
        "{:?}",
        found.notes
    );
}

#[test]
fn nonsense_is_refused_with_its_place() {
    assert_eq!(at(&[], "0.5"), Err(StemError::Empty));
    let mut mesh = cylinder(0.1, 1.0, 12);
    mesh.positions[3].y = f64::NAN;
    let text = at(&[mesh.clone()], "0.5").unwrap_err().to_string();
    assert!(text.contains("vertex 3"), "{text}");
    mesh.positions[3].y = 0.0;
    mesh.triangles[5][1] = 1_000_000;
    assert!(
        at(&[mesh.clone()], "0.5")
            .unwrap_err()
            .to_string()
            .contains("triangle 5")
    );
    mesh.triangles = vec![[0, 0, 0]; 4];
    assert!(at(&[mesh], "0.5").is_err());
}

#[test]
fn a_scanned_pole_has_a_stem() {
    let pole = support::ply(&support::data::data("pole.ply"), 1e-3);
    let stem = at(&[pole], "0.5").unwrap().stem;
    assert!((stem.length - 1.98).abs() < 0.02 && stem.ends == (true, true));
    assert!(
        stem.usable.0 < 0.05 && stem.usable.1 > 1.93,
        "{:?}",
        stem.usable
    );
    assert!((stem.radius - 0.056).abs() < 0.004);
}

#[test]
fn a_tree_of_many_limbs_has_a_stem() {
    let tree = support::gltf(&support::data::data("quaternius_DeadTree_1.gltf"));
    let meshes = std::slice::from_ref(&tree);
    let found = at(meshes, "0.1").unwrap();
    assert_eq!(found.carried.len(), 47);
    assert!(found.stem.grain.axis().frame(1.0).tangent.y > 0.9);
    // Limbs by a point on each: all but a few are free there, and none takes the trunk along.
    let (mut free, mut hopeless) = (0, 0);
    for k in 0..48 {
        let p = tree.positions[(2 * k + 1) * tree.positions.len() / 96];
        let location = StemLocation::Point(p);
        match find_stem(
            meshes,
            &location,
            &StemOptions::default(),
            &Context::quiet(),
        ) {
            Ok(found) => {
                free += 1;
                assert!(found.carried.iter().all(|c| c.triangles != found.shell));
            }
            Err(StemError::Unusable { nearest, .. }) => {
                let again = at(meshes, &nearest.to_string());
                assert!(again.is_ok(), "{p} → {nearest}: {}", again.unwrap_err());
            }
            Err(StemError::NowhereFree { .. }) => hopeless += 1,
            Err(other) => panic!("{p}: {other}"),
        }
    }
    assert!(
        free >= 30 && hopeless <= 2,
        "{free} free, {hopeless} hopeless of 48"
    );
}

#[track_caller]
fn assert_bare_tree(tree: Mesh) {
    let found = at(&[tree], "0.1").unwrap();
    assert_eq!((found.carried.len(), found.stem.kind), (6, StemKind::Round));
}

#[test]
fn a_bare_tree_has_a_stem() {
    assert_bare_tree(support::obj(&support::data::data(
        "kaykit_Tree_Bare_1_C_Color1.obj",
    )));
}

#[test]
fn a_point_in_the_middle_of_a_stem_is_of_the_stem_and_not_of_a_limb_stuck_in_it() {
    let tree = support::obj(&support::data::data("kaykit_Tree_Bare_1_C_Color1.obj"));
    let meshes = [tree];
    // The root of a limb ends near the middle of the stem, which is free there.
    let trunk = at(&meshes, "5m").unwrap();
    let middle = trunk.stem.grain.axis().frame(5.0).origin;
    let found = find_stem(
        &meshes,
        &StemLocation::Point(middle),
        &StemOptions::default(),
        &Context::quiet(),
    )
    .unwrap();
    assert_eq!(found.shell, trunk.shell);
    assert!((found.stem.location - 5.0).abs() < 0.01);
}

#[test]
#[ignore = "needs GREENSTICK_DATA"]
fn another_bare_tree_has_a_stem() {
    assert_bare_tree(support::obj(&support::data::outside_data(
        "trees/kaykit_Tree_Bare_2_C_Color1.obj",
    )));
}

#[test]
#[ignore = "needs GREENSTICK_DATA"]
fn a_scanned_stump_has_a_stem() {
    let stump = support::obj(&support::data::outside_data("scans/stump.obj"));
    let stem = at(&[stump], "0.5").unwrap().stem;
    assert!(stem.grain.axis().frame(stem.location).tangent.y > 0.9);
    assert!(stem.usable.1 - stem.usable.0 > 0.15, "{:?}", stem.usable);
}

#[test]
fn the_same_stem_every_time() {
    let mesh = branch(&BranchOptions::default());
    let found = at(std::slice::from_ref(&mesh), "0.4").unwrap();
    assert_eq!(found, at(std::slice::from_ref(&mesh), "0.4").unwrap());
    assert!(found.stem.usable.0 < 0.005 && found.stem.usable.1 > 0.595);
    assert_eq!(found.limb.len(), mesh.triangles.len());
    // The bark lies about the ring coordinate 1 along the whole branch.
    for p in mesh.positions.iter().step_by(37) {
        let q = found.stem.grain.to_grain(*p);
        if q.truncate().length() > 0.8 * found.stem.radius && q.z > 0.01 && q.z < 0.59 {
            let ring = found.stem.rings.address(q.truncate()).0;
            assert!((0.8..1.25).contains(&ring), "{p}: {ring}");
        }
    }
}
