use super::shells; use super::surface::Surface; use super::polygon; use glam::*; use std::time::Instant;
#[path = "../../tests/support/mod.rs"] mod support;
#[test] fn probe() {
  let m = crate::primitive::branch(&crate::primitive::BranchOptions{around: 540, ..Default::default()});
  println!("{}", m.triangles.len());
  let t=Instant::now(); let p = shells::points(&m, 0.0); println!("points {:?}", t.elapsed());
  let t=Instant::now(); let s = shells::shells(0, &p); println!("shells {:?}", t.elapsed());
  let t=Instant::now(); let f = Surface::new(&p, &s[0]); println!("surface {:?}", t.elapsed());
  let t=Instant::now(); for i in 0..100 { f.slice(DVec3::new(0.0,0.05+0.005*i as f64,0.0), DVec3::Y); } println!("100 slices {:?}", t.elapsed());
  let t=Instant::now(); let tr = super::seed::main_stem(&f).unwrap(); println!("main {:?} {}", t.elapsed(), tr.cuts.len());
  let t=Instant::now(); let b = super::build::body(&f,&tr,50,None).unwrap(); println!("body {:?}", t.elapsed());
  let t=Instant::now(); let tu = super::attach::Tube::new(&b); println!("tube {:?}", t.elapsed());
  let t=Instant::now(); let l=tu.limb(&f,(0.1,0.4),&tr.cuts[50].triangles); println!("limb {:?} {}", t.elapsed(), l.len());
  let t=Instant::now(); let l=super::rings::likely_pith(&b.stations[50].1.as_ref().unwrap().contour); println!("pith {:?} {}", t.elapsed(), l);
  let t=Instant::now(); let _=super::rings::RingField::round(&b.stations[50].1.as_ref().unwrap().contour, l, 1.0); println!("rings {:?}", t.elapsed());
  for (name, m, n) in [("board", support::gltf("scans/homecart_cutting_board.gltf").unwrap(), DVec3::Z), ("stump", support::obj("scans/stump.obj").unwrap(), DVec3::Y)] {
    let p = shells::points(&m, 0.0); let s = shells::shells(0, &p); let f = Surface::new(&p, &s[0]);
    println!("{name} {} shells", s.len());
    let (lo,hi)=(s[0].low.dot(n), s[0].high.dot(n));
    for k in 1..40 { let o = n*(lo+(hi-lo)*k as f64/40.0);
      print!("{:.3}: ", o.dot(n));
      for l in f.slice(o,n) { let x=n.any_orthonormal_vector(); let y=n.cross(x); let fl:Vec<DVec2>=l.points.iter().map(|q| DVec2::new(q.dot(x),q.dot(y))).collect(); let (a,c)=polygon::area_and_centroid(&fl); if a.abs()>1e-4 || !l.closed { print!("[{} {:.5} n{} c{:.2}] ", l.closed, a, l.points.len(), c);} }
      println!();
    }
  }
}
