//! Breaks the built-in branch, or a mesh given as the first argument, and takes a picture of it.
//!
//! `cargo run --release --example break_branch -- [INPUT] [PLACE] [KEY=VALUE | PRESET]…`

use greenstick::fracture::recipe::Recipe;
use greenstick::geometry::Context;
use greenstick::picture::PictureOptions;
use greenstick::wood::stem::Place;
use greenstick::{BreakRequest, break_scene, built_in_branch, formats, picture_of_break};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let input = arguments
        .iter()
        .position(|a| Path::new(a).exists())
        .map(|i| arguments.remove(i));
    let place = arguments
        .iter()
        .position(|a| a.starts_with("at="))
        .map(|i| arguments.remove(i));
    let unit = arguments
        .iter()
        .position(|a| a.starts_with("unit="))
        .map(|i| arguments.remove(i));
    let unit = match unit.as_deref() {
        Some("unit=mm") => Some(formats::LengthUnit::Millimetre),
        _ => None,
    };
    let scene = match &input {
        None => built_in_branch(),
        Some(file) => {
            let path = Path::new(file);
            let format = formats::Format::of_path(path).ok_or("unknown ending")?;
            let folder = path.parent().unwrap_or(Path::new("."));
            formats::read(format, &std::fs::read(path)?, file, unit, &|name| {
                std::fs::read(folder.join(name))
            })?
        }
    };
    let mut recipe = Recipe::default();
    for argument in &arguments {
        if argument.contains('=') {
            recipe.apply_setting(argument)?;
        } else {
            recipe.apply_preset(argument)?;
        }
    }
    let mut request = BreakRequest {
        recipe,
        ..BreakRequest::default()
    };
    if let Some(place) = place {
        request.place = Place::parse(&place[3..], 1.0)?;
    }
    if let Ok(part) = std::env::var("PART") {
        request.part = part.parse()?;
    }
    let started = std::time::Instant::now();
    let broken = break_scene(scene, &request, &Context::quiet())?;
    println!("{}broken in {:?}", broken.report, started.elapsed());
    if std::env::var("CHECK").is_ok() {
        for n in broken.scene.nodes.iter().take(2) {
            println!("{} {}", n.name, n.mesh.check());
        }
    }
    let files = formats::write(
        formats::Format::Glb,
        &broken.scene,
        "broken.glb",
        formats::LengthUnit::Metre,
    )?;
    std::fs::write("/tmp/broken.glb", &files[0].bytes)?;
    let options = PictureOptions {
        width: 1000,
        height: 1000,
        samples: 8,
        ..PictureOptions::default()
    };
    let picture = picture_of_break(&broken, &options, &Context::quiet())?;
    std::fs::write(
        std::env::var("OUT").unwrap_or("/tmp/broken.png".into()),
        picture.png(),
    )?;
    println!("picture after {:?}", started.elapsed());
    Ok(())
}
