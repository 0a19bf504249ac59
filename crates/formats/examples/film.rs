//! Writes a film of a bending stick in every moving format, for foreign readers to judge: `film FOLDER [JOINTS] [RINGS]
//! [FRAMES]`.

#[path = "../tests/common/mod.rs"]
mod common;

use common::bundle::{Bend, film};
use greenstick_formats::Encoded;
use greenstick_formats::film::{GlbOptions, write_glb, write_usd};
use greenstick_formats::usd::{self, UsdFormat};
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
    for (name, format) in [
        ("film.usdc", UsdFormat::Usdc),
        ("film.usdz", UsdFormat::Usdz),
    ] {
        let mut out = BufWriter::new(File::create(folder.join(name))?);
        let mut motion = Bend::of(&film, frames);
        let start = Instant::now();
        let context = Context::quiet();
        let (report, files) = write_usd(format, &film, &mut motion, name, &mut out, &context)?;
        println!("{name}: {:.1?}; {report:?}", start.elapsed());
        save(folder, files)?;
    }
    let mut still = common::two_cubes();
    // What a reference names is to be there.
    still.textures.truncate(1);
    still.materials[0].normal_texture = None;
    for name in ["still.usda", "still.usdc", "still.usdz"] {
        let format = UsdFormat::of_path(Path::new(name)).ok_or("an ending of USD")?;
        save(folder, usd::write(format, &still, name)?)?;
    }
    Ok(())
}

fn save(folder: &Path, files: Vec<Encoded>) -> std::io::Result<()> {
    let mut files = files.iter();
    files.try_for_each(|f| std::fs::write(folder.join(&f.name), &f.bytes))
}
