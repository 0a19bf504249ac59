use greenstick::fracture::parameters::BreakParameters;
use greenstick::geometry::{Bvh, Context, Node, Scene};
use greenstick::wood::{primitive, stem};
#[test]
fn dbg() {
    let mesh = primitive::branch(&Default::default());
    let node = Node { name: "stem".into(), transform: glam::DAffine3::IDENTITY, mesh, parent: None };
    let sc = Scene { nodes: vec![node], ..Scene::default() };
    let prepared = greenstick::prepare(sc, &stem::Place::Fraction(0.5), &Default::default(), 0.0, &Context::quiet()).unwrap();
    let p = BreakParameters { seed: 0, ..Default::default() };
    let model = prepared.model(&p, 1.0, 1).unwrap();
    let m = &model.lower;
    let tree = Bvh::of_triangles(m);
    let mut n = 0;
    greenstick::geometry::intersect::self_contacts(m, &tree, |i, j, c| {
        if c != greenstick::geometry::intersect::Contact::Crossing { return; }
        n += 1;
        if n > 6 { return; }
        for t in [i, j] {
            println!("{t} material {:?}", m.materials[t]);
            for v in m.triangles[t] { let v = v as usize; println!("    grain {:?} ring {} sector {} pos {:?} n {:?}", m.attributes["_GRAIN"].at(v), m.attributes["_RING"].at(v)[0], m.attributes["_SECTOR"].at(v)[0], m.positions[v], m.attributes["NORMAL"].at(v)); }
        }
        println!();
    });
}
