//! Writes a film of a bending stick in every moving format, for foreign readers to judge: `film FOLDER [JOINTS] [RINGS]
//! [FRAMES]`.

#[path = "../tests/common/mod.rs"]
mod common;

use common::bundle::{Bend, film};
use greenstick_formats::film::{GlbOptions, write_glb};
use greenstick_geometry::Context;
use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, counts @ ..] = arguments.as_slice() else {
        return Err("expected: film FOLDER [JOINTS] [RINGS] [FRAMES]".into());
    };
    let count = |k: usize, normal| counts.get(k).map_or(Ok(normal), |t| t.parse::<usize>());
    let (joints, rings, frames) = (count(0, 30)?, count(1, 60)?, count(2, 90)?);
    let film = film(joints, rings, 6);
    let folder = Path::new(folder);
    for (name, max_joints) in [("film.glb", None), ("few.glb", Some(8))] {
        let options = GlbOptions {
            max_joints,
            ..GlbOptions::default()
        };
        let mut out = BufWriter::new(File::create(folder.join(name))?);
        let mut motion = Bend::of(&film, frames);
        let start = Instant::now();
        let context = Context::quiet();
        let report = write_glb(&film, &mut motion, name, &options, &mut out, &context)?;
        println!("{name}: {:.1?}; {report:?}", start.elapsed());
    }
    Ok(())
}
