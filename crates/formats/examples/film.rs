//! Writes a film of a bending stick in every moving format, for foreign readers to judge: `film FOLDER [JOINTS] [RINGS]
//! [FRAMES] [MOST_JOINTS]`.

#[allow(dead_code)] // Tests use the rest.
#[path = "../tests/integration/common/mod.rs"]
mod common;

use common::bundle::{Bend, film};
use glam::DVec3;
use greenstick_formats::Encoded;
use greenstick_formats::film::{GlbOptions, write_glb, write_usd};
use greenstick_formats::usd::{self, UsdFormat};
use greenstick_formats::vtk::{self, Field, Polylines, TimedFile};
use greenstick_geometry::{Context, Film, Motion, Pose, Values};
use std::error::Error;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, counts @ ..] = arguments.as_slice() else {
        return Err("expected: film FOLDER [JOINTS] [RINGS] [FRAMES] [MOST_JOINTS]".into());
    };
    let count = |k: usize, normal| counts.get(k).map_or(Ok(normal), |t| t.parse::<usize>());
    let (joints, rings, frames) = (count(0, 30)?, count(1, 60)?, count(2, 90)?);
    let film = film(joints, rings, 6);
    let folder = Path::new(folder);
    for (name, max_joints) in [("film.glb", None), ("few.glb", Some(count(3, 8)?))] {
        let options = GlbOptions {
            max_joints,
            ..GlbOptions::default()
        };
        let mut out = BufWriter::new(File::create(folder.join(name))?);
        let mut motion = Bend::new(&film, frames);
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
        let mut motion = Bend::new(&film, frames);
        let start = Instant::now();
        let context = Context::quiet();
        let (report, files) = write_usd(format, &film, &mut motion, name, &mut out, &context)?;
        println!("{name}: {:.1?}; {report:?}", start.elapsed());
        save(folder, files)?;
    }
    series(folder, &film, frames)?;
    let mut still = common::two_cubes();
    // What a reference names is to be there.
    still.textures.truncate(1);
    still.materials[0].normal_texture = None;
    for name in ["still.usda", "still.usdc", "still.usdz"] {
        let format = UsdFormat::from_path(Path::new(name)).ok_or("an ending of USD")?;
        save(folder, usd::write(format, &still, name)?)?;
    }
    Ok(())
}

/// The joints of the stick as a rod, with bonds from each to the ground.
fn series(folder: &Path, film: &Film, frames: usize) -> Result<(), Box<dyn Error>> {
    let mut motion = Bend::new(film, frames);
    let mut poses = vec![Pose::IDENTITY; film.joints.len()];
    let mut files = Vec::new();
    for frame in 0..frames {
        motion.poses(frame, &mut poses)?;
        let rod: Vec<DVec3> = poses[..motion.joints]
            .iter()
            .map(|p| p.translation)
            .collect();
        let count = rod.len() as u32;
        let order: Vec<u32> = (0..count).collect();
        let away: Vec<f64> = rod.iter().map(|p| p.x).collect();
        let name = format!("rods_{frame:04}.vtp");
        let rods = Polylines {
            points: &rod,
            corners: &order,
            ends: &[count],
            point_data: &[
                Field::scalar("deflection_m", Values::F64(away)),
                Field::vectors("place_m", &rod),
            ],
            line_data: &[Field::scalar("rod", Values::U32(vec![7]))],
            metadata: None,
        };
        let rods = vtk::write_lines(&rods, &name)?;
        let ground = rod.iter().map(|p| DVec3::new(p.x, -1.0, p.z));
        let ends: Vec<DVec3> = rod.iter().copied().chain(ground).collect();
        let corners: Vec<u32> = (0..count).flat_map(|k| [k, k + count]).collect();
        let after: Vec<u32> = (1..=count).map(|k| 2 * k).collect();
        let name = format!("bonds_{frame:04}.vtp");
        let bonds = Polylines {
            points: &ends,
            corners: &corners,
            ends: &after,
            point_data: &[],
            line_data: &[Field::scalar("broken", Values::U8(vec![0; count as usize]))],
            metadata: None,
        };
        let bonds = vtk::write_lines(&bonds, &name)?;
        let time = motion.time(frame);
        for file in [&rods, &bonds] {
            let file = file.name.clone();
            files.push(TimedFile { time, file });
        }
        save(folder, vec![rods, bonds])?;
    }
    std::fs::write(folder.join("film.pvd"), vtk::collection(&files))?;
    Ok(())
}

fn save(folder: &Path, files: Vec<Encoded>) -> std::io::Result<()> {
    let mut files = files.iter();
    files.try_for_each(|f| std::fs::write(folder.join(&f.name), &f.bytes))
}
