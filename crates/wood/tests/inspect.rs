mod support;
use greenstick_geometry::{Context, Mesh};
use greenstick_wood::primitive;
use greenstick_wood::stem::*;
fn show(name: &str, meshes: &[Mesh], place: &str) {
    let t = std::time::Instant::now();
    let r = find(
        meshes,
        &place.parse().unwrap(),
        &StemOptions::default(),
        &Context::quiet(),
    );
    let dt = t.elapsed().as_secs_f64();
    match r {
        Err(e) => println!("{name} @{place}: ERROR {e} [{dt:.3}s]"),
        Ok(f) => println!(
            "{name} @{place}: {:?} L={:.4} s={:.4} r={:.4} usable=({:.4},{:.4}) ends={:?} sections={} shell={} limb={} carried={} pith={:.4} extent={:.4} scale at usable {:.3} {:.3} origin {:.3} t {:.3} notes={:?} [{dt:.3}s]",
            f.stem.kind,
            f.stem.length,
            f.stem.place,
            f.stem.radius,
            f.stem.usable.0,
            f.stem.usable.1,
            f.stem.ends,
            f.stem.sections.len(),
            f.shell.len(),
            f.limb.len(),
            f.carried.len(),
            f.stem.rings.pith(),
            f.stem.rings.extent(),
            f.stem.grain.scale(f.stem.usable.0),
            f.stem.grain.scale(f.stem.usable.1),
            f.stem.grain.axis().frame(f.stem.place).origin,
            f.stem.grain.axis().frame(f.stem.place).tangent,
            f.notes
        ),
    }
}
#[test]
fn inspect() {
    let b = primitive::branch(&Default::default());
    println!("branch tris {} bounds {:?}", b.triangles.len(), b.bounds());
    for p in ["0.1", "0.5", "0.9", "12cm"] {
        show("branch", std::slice::from_ref(&b), p);
    }
    let big = primitive::branch(&primitive::BranchOptions {
        around: 700,
        ..Default::default()
    });
    println!("big {}", big.triangles.len());
    show("big", std::slice::from_ref(&big), "0.5");
    let q = big.positions[big.positions.len() / 2];
    show(
        "big point",
        std::slice::from_ref(&big),
        &format!("{},{},{}", q.x, q.y, q.z),
    );
    if let Some(m) = support::ply("scans/pole.ply", 1e-3) {
        for p in ["0.1", "0.5", "0.0", "1.5m", "5m"] {
            show("pole", std::slice::from_ref(&m), p);
        }
    }
    if let Some(m) = support::obj("scans/stump.obj") {
        println!("{:?}", m.bounds());
        for p in ["0.1", "0.3", "0.5", "0.7", "0.9"] {
            show("stump", std::slice::from_ref(&m), p);
        }
        show("stump", std::slice::from_ref(&m), "0.25,0.25,0.05");
    }
    if let Some(m) = support::gltf("scans/homecart_cutting_board.gltf") {
        for p in ["0.5", "0.2", "10cm", "0.34,0,0.1"] {
            show("board", std::slice::from_ref(&m), p);
        }
    }
    if let Some(m) = support::gltf("trees/quaternius_DeadTree_1.gltf") {
        for p in [
            "0.05",
            "0.1",
            "0.2",
            "0.3",
            "0.4",
            "0.5",
            "0.7",
            "0.9",
            "2.5,6.0,1.0",
            "-1.5,5,0.5",
            "0,8,0",
        ] {
            show("quat", std::slice::from_ref(&m), p);
        }
        // every limb by the middle of shells
    }
    for k in 1..=2 {
        if let Some(m) = support::obj(&format!("trees/kaykit_Tree_Bare_{k}_C_Color1.obj")) {
            println!("{:?}", m.bounds());
            for p in [
                "0.1",
                "0.3",
                "0.4",
                "0.5",
                "0.6",
                "0.8",
                "0.5,2,0",
                "-0.5,2,0.2",
            ] {
                show("kay", std::slice::from_ref(&m), p);
            }
        }
    }
}
