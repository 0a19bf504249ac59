//! Breaks of rods that are known come back in the faces that are cut into the mesh: every rod's place, the step between
//! groups of rods, how the wood failed, and pieces that fill the input.

use crate::support::Grown;
use glam::{DVec2, DVec3};
use greenstick::fibre::scene::Scene as Setting;
use greenstick::fibre::store::Frame;
use greenstick::fibre::{Cause, Event, EventKind};
use greenstick::fracture::surface::FractureSurface;
use greenstick::geometry::Context;
use greenstick::simulated_faces::{
    ObservedRun, PartlyBroken, SimulatedFaces, SimulatedFacesError, WoodHolds, faces_of_wood,
};
use greenstick::wood::noise::unit;
use greenstick::{BreakSession, RequestFile};

const RADIUS: f64 = 0.02;
const LENGTH: f64 = 0.4;
/// Mean length of edges, m.
const EDGE: f64 = 0.006;
/// How far what lies beyond a break has moved, m.
const OPENING: f64 = 0.01;
/// When rods broke, s.
const BROKE: f64 = 0.2;

/// Where a rod breaks: lengths along the stem (m), ascending, and whether it was crushed before.
struct Broken {
    lengths: Vec<f64>,
    crushed: bool,
    /// Whether bonds hold both sides of the first break together all the same.
    held: bool,
}

/// What happens where a rod breaks, crushed before or not.
fn history(rod: usize, vertex: usize, crushed: bool) -> Vec<Event> {
    let event = |kind, time, cause| Event {
        time,
        kind,
        rod: rod as u32,
        vertex: vertex as u32,
        other: None,
        position: DVec3::ZERO,
        cause,
        demand: 1.0,
        energy: 0.0,
    };
    let mut events = Vec::new();
    if crushed {
        events.push(event(EventKind::RodYielded, 0.1, Cause::Compression));
    }
    events.push(event(EventKind::RodBroke, BROKE, Cause::Tension));
    events
}

/// The frame in which every rod is broken as `how` says of its middle (radii), and what lies beyond has moved on; and its
/// events. Bonds hold what lies on the same side of as many breaks.
fn broken(grown: &Grown, how: impl Fn(usize, DVec2) -> Broken) -> (Frame, Vec<Event>) {
    let wood = grown.wood(2.5);
    let mut frame = Frame {
        time: 1.0,
        step: 1,
        rod_offsets: vec![0],
        ..Frame::default()
    };
    let mut events = Vec::new();
    // For each vertex its number in the frame after its last break, and a number of what bonds hold together there.
    let mut numbers = vec![(0, 0); wood.bundle.vertices()];
    for rod in 0..wood.bundle.rods() {
        let at = wood.cells[rod].centroid;
        let how = how(rod, at / RADIUS);
        let range = wood.bundle.rod(rod);
        let mut place = |vertex: usize, along: f64, part: usize| {
            let p = wood
                .stem
                .grain
                .to_world(at.extend(along + OPENING * part as f64));
            frame.origin.push(vertex as u32);
            frame.position.push(p.as_vec3().to_array());
            // What a third break leaves is loose.
            let loose = how.lengths.len() > 2 && part > 0;
            let bonded = match part {
                _ if loose => usize::MAX - rod,
                part => part - usize::from(how.held && part > 0),
            };
            numbers[vertex] = (frame.origin.len() as u32 - 1, bonded);
        };
        let nearest = |&wanted: &f64| {
            let off = |v: &usize| (wood.along[*v] - wanted).abs();
            let inner = range.start + 2..range.end - 2;
            inner.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
        };
        let splits: Vec<usize> = how.lengths.iter().map(nearest).collect();
        let mut part = 0;
        for vertex in range.clone() {
            let split = splits.iter().position(|&s| s == vertex);
            let along = split.map_or(wood.along[vertex], |n| how.lengths[n]);
            place(vertex, along, part);
            if split.is_some() {
                part += 1;
                place(vertex, along, part);
            }
        }
        splits
            .iter()
            .for_each(|&v| events.extend(history(rod, v, how.crushed)));
        for part in 0..=splits.len() {
            let from = *frame.rod_offsets.last().unwrap() as usize;
            let end = splits.get(part).copied().unwrap_or(range.end);
            let vertices = &frame.origin[from..];
            let count = vertices.iter().take_while(|&&v| v as usize <= end).count();
            let twice = vertices.get(count.wrapping_sub(1)) == vertices.get(count.wrapping_sub(2));
            frame
                .rod_offsets
                .push((from + count - usize::from(twice)) as u32);
            frame.parent.push(rod as u32);
            frame.diameter.push(1e-3);
        }
    }
    let bonds = &wood.bundle.bonds;
    for (&v, &e) in bonds.vertex.iter().zip(&bonds.edge) {
        let (own, first, next) = (
            numbers[v as usize],
            numbers[e as usize],
            numbers[e as usize + 1],
        );
        if own.1 == first.1 && own.1 == next.1 {
            frame.bonds.push([own.0, first.0]);
        }
    }
    (frame, events)
}

fn faces(
    grown: &Grown,
    broken: &(Frame, Vec<Event>),
) -> Result<SimulatedFaces, SimulatedFacesError> {
    let wood = grown.wood(2.5);
    let observed = ObservedRun::new(&wood, &broken.0, &broken.1).unwrap();
    let mut setting = Setting::built_in("bend").unwrap();
    setting.wood.species = "Oak, white".into();
    faces_of_wood(
        (&wood, observed),
        (&grown.scene, &setting),
        PartlyBroken::Separated,
        &Context::quiet(),
    )
}

/// The length along the axis of the surface over a point of the section, m.
fn height_over(surface: &FractureSurface, at: DVec2) -> f64 {
    let layout = &surface.layout;
    let facet = layout.facets.iter().position(|f| {
        let [a, b, c] = f.map(|n| layout.nodes[n as usize]);
        [(a, b), (b, c), (c, a)]
            .iter()
            .all(|(p, q)| (*q - *p).perp_dot(at - *p) >= 0.0)
    });
    surface.heights[facet.unwrap()].iter().sum::<f64>() / 3.0
}

/// Two groups of rods that broke 2.4 radii from each other, each within 0.3 radii, some of them crushed before.
fn two_groups(rod: usize, at: DVec2) -> Broken {
    let level = if at.x > 0.0 { 1.4 } else { -1.0 };
    let scatter = 0.3 * (unit(7, rod as i64, 0, 0) - 0.5);
    Broken {
        lengths: vec![0.45 * LENGTH + RADIUS * (level + scatter)],
        crushed: at.y < -0.4,
        held: false,
    }
}

#[test]
fn the_face_lies_where_the_rods_broke_and_the_pieces_fill_the_input() {
    let grown = Grown::new(RADIUS, EDGE);
    let mut faces = faces(&grown, &broken(&grown, two_groups)).unwrap();
    let [report] = &faces.reports[..] else {
        panic!("{:?}", faces.reports);
    };
    assert!(report.parted && report.broken == 150 && report.further_breaks == 0);
    let crushed = report.modes.iter().find(|m| m.mode == "crushed").unwrap();
    let cells = &grown.placed.cells;
    let low = cells
        .iter()
        .filter(|c| c.centroid.y < -0.4 * RADIUS)
        .count();
    assert_eq!(crushed.rods, low);
    let stages = faces
        .session
        .stages(&faces.request, &Context::quiet())
        .unwrap();
    let surface = &stages.heights.heights.surface;
    let mut errors: Vec<f64> = Vec::new();
    for (rod, cell) in cells.iter().enumerate() {
        let wanted = two_groups(rod, cell.centroid / RADIUS).lengths[0];
        errors.push((height_over(surface, cell.centroid) - wanted).abs());
    }
    errors.sort_by(f64::total_cmp);
    let part = |share: f64| errors[(share * (errors.len() - 1) as f64) as usize];
    assert!(part(0.5) < 0.5 * report.splinters_m, "{errors:?}");
    assert!(part(0.9) < 2.0 * report.splinters_m, "{errors:?}");
    // The step between the groups is one step.
    let step = 2.4 * RADIUS;
    let beyond = errors.iter().filter(|&&e| e > 0.5 * step).count();
    assert!(beyond <= 6, "{errors:?}");
    let made = faces.broken(&Context::quiet()).unwrap();
    let whole = made.report.input.volume_m3.unwrap();
    let volumes = made.report.pieces.iter().map(|p| p.volume_m3.unwrap());
    assert!((volumes.sum::<f64>() / whole - 1.0).abs() < 1e-6);
    // A recipe holds the face, to the last bit.
    let file = RequestFile::default().with_request(&faces.request);
    let read = RequestFile::resolve(&[], Some(&file.to_toml()), &[]).unwrap();
    assert_eq!(read.request(), faces.request);
    let mut fresh = BreakSession::new(grown.scene.clone());
    let again = fresh.broken(&read.request(), &Context::quiet()).unwrap();
    for (made, again) in made.scene.nodes.iter().zip(&again.scene.nodes) {
        assert_eq!(made.mesh, again.mesh);
    }
}

#[test]
fn a_stem_that_broke_twice_is_in_three_and_a_splinter_is_no_piece_of_it() {
    let grown = Grown::new(RADIUS, EDGE);
    // All rods break at 0.3 and at 0.7 of the length; a few again in between, and are loose from there on.
    let made = broken(&grown, |rod, _| Broken {
        lengths: match rod % 25 {
            0 => vec![0.3 * LENGTH, 0.36 * LENGTH, 0.7 * LENGTH],
            _ => vec![0.3 * LENGTH, 0.7 * LENGTH],
        },
        crushed: false,
        held: false,
    });
    let mut faces = faces(&grown, &made).unwrap();
    let places: Vec<f64> = faces.reports.iter().map(|r| r.place_m / LENGTH).collect();
    assert!(places.len() == 2, "{places:?}");
    let off = (places[0] - 0.3).abs().max((places[1] - 0.7).abs());
    assert!(off < 0.01, "{:?}", faces.reports);
    assert!(faces.reports.iter().all(|r| r.parted && r.broken == 150));
    let made = faces.broken(&Context::quiet()).unwrap();
    assert_eq!(made.report.pieces.len(), 3);
}

#[test]
fn what_broke_and_holds_has_a_face_beside_one_that_parted() {
    let grown = Grown::new(RADIUS, EDGE);
    // All rods break at 0.7 of the length; those on one side at 0.3, too, where bonds hold them.
    for (share, faces_there) in [(-0.4, 2), (0.4, 1)] {
        let made = broken(&grown, |_, at| Broken {
            lengths: match at.x > share {
                true => vec![0.3 * LENGTH, 0.7 * LENGTH],
                false => vec![0.7 * LENGTH],
            },
            crushed: false,
            held: at.x > share,
        });
        let mut faces = faces(&grown, &made).unwrap();
        let last = faces.reports.len() - 1;
        assert_eq!(faces.reports.len(), faces_there, "{:?}", faces.reports);
        assert!(faces.reports[last].parted);
        assert!(faces.reports[..last].iter().all(|r| !r.parted));
        let made = faces.broken(&Context::quiet()).unwrap();
        assert_eq!(made.report.pieces.len(), faces_there + 1);
    }
}

#[test]
fn wood_that_holds_has_no_face() {
    let grown = Grown::new(RADIUS, EDGE);
    let none = broken(&grown, |_, _| Broken {
        lengths: Vec::new(),
        crushed: false,
        held: false,
    });
    let error = faces(&grown, &none).unwrap_err();
    assert!(matches!(
        error,
        SimulatedFacesError::Holds(WoodHolds::NoBreak { time: 1.0 })
    ));
    let some = broken(&grown, |_, at| Broken {
        lengths: if at.x > 0.6 {
            vec![0.5 * LENGTH]
        } else {
            Vec::new()
        },
        crushed: false,
        held: false,
    });
    let error = faces(&grown, &some).unwrap_err().to_string();
    assert!(error.contains("the wood holds"), "{error}");
}
