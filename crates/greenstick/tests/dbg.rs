use greenstick::fracture::parameters::{BreakParameters, Kind, Parameters, Value};
use greenstick::geometry::{Context, Node, Scene};
use greenstick::wood::{noise, primitive, stem};
fn random_parameters(set: usize) -> BreakParameters {
    let mut p = BreakParameters::default();
    let unit = |i: usize| noise::unit(0xd1ce, set as i64, i as i64, 0);
    for (i, info) in BreakParameters::table().into_iter().enumerate() {
        let u = unit(i);
        let kept = if info.key == "spiral_angle" { 0.9 } else { 0.33 };
        if unit(i + 1000) < kept && info.key != "seed" { continue; }
        let value = match info.kind {
            Kind::Number { min, max, .. } if max / min.max(1e-9) >= 1000.0 && min > 0.0 => Value::Number(min * (max / min).powf(u)),
            Kind::Number { min, max, .. } => Value::Number(min + (max - min) * u),
            Kind::Integer { min, max } if max <= 1000 && min > 0 => { let (min, max) = (min as f64, max as f64); Value::Integer((min * (max / min).powf(u)).round() as u64) }
            Kind::Integer { min, max } => Value::Integer(min + ((max - min) as f64 * u) as u64),
            Kind::Choice { options } => Value::Text(options[(u * options.len() as f64) as usize % options.len()].to_owned()),
        };
        p.set(&info.key, &value).unwrap();
    }
    let sum = p.pith_proportion + p.heartwood_proportion + p.phloem_proportion;
    if sum > 1.0 { p.pith_proportion /= sum * 1.001; p.heartwood_proportion /= sum * 1.001; p.phloem_proportion /= sum * 1.001; }
    p
}
#[test]
fn dbg() {
    let mesh = primitive::branch(&Default::default());
    let node = Node { name: "stem".into(), transform: glam::DAffine3::IDENTITY, mesh, parent: None };
    let sc = Scene { nodes: vec![node], ..Scene::default() };
    let prepared = greenstick::prepare(sc, &stem::Place::Fraction(0.45), &Default::default(), &Context::quiet()).unwrap();
    let p = random_parameters(0);
    let model = prepared.model(&p, 1.0, 1).unwrap();
    println!("chips {} bark {:?}", model.chips, prepared.extent);
    let m = &model.lower;
    let (points, _) = m.points();
    let mut edges: std::collections::BTreeMap<(u32, u32), Vec<usize>> = Default::default();
    for (t, c) in m.triangles.iter().enumerate() { for k in 0..3 { let (a, b) = (points[c[k] as usize], points[c[(k + 1) % 3] as usize]); edges.entry((a.min(b), a.max(b))).or_default().push(t); } }
    for (e, l) in edges.iter().filter(|(_, l)| l.len() != 2).take(3) {
        println!("edge {e:?}");
        for &t in l { println!("  {t} mat {} ", m.materials[t]); for v in m.triangles[t] { let v = v as usize; println!("    p{} {:?} ring {:?} sector {:?}", points[v], m.attributes["_GRAIN"].at(v), m.attributes["_RING"].at(v), m.attributes["_SECTOR"].at(v)); } }
    }
}
