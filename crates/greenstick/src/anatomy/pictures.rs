//! Pictures of the inside as PNG files.

use super::request::AnatomyRequest;
use crate::Error;
use greenstick_formats::Encoded;
use greenstick_geometry::Context;
use greenstick_wood::anatomy::Anatomy;
use greenstick_wood::colour::RgbImage;

/// Contour, rings and tissues of the section at the location, and of others at equal distances.
pub(super) fn sections<E: From<Error>>(
    anatomy: &Anatomy,
    request: &AnatomyRequest,
    context: &Context,
    sink: &mut dyn FnMut(Encoded) -> Result<(), E>,
) -> Result<(), E> {
    let stem = anatomy.sections();
    let (low, high) = stem.whole;
    let others = request.sections - 1;
    let equidistant = |k: u32| low + (high - low) * (f64::from(k) + 0.5) / f64::from(others);
    let lengths = std::iter::once(stem.stem().location).chain((0..others).map(equidistant));
    let mut names: Vec<String> = Vec::new();
    for (i, length) in lengths.enumerate() {
        let done = i as f64 / f64::from(request.sections);
        context.report(done).map_err(Error::from)?;
        let Some(section) = stem.section(length) else {
            continue;
        };
        let name = format!("section_{:06.1}mm", section.length * 1e3);
        if names.contains(&name) {
            continue;
        }
        let pictures = anatomy
            .paint_section(&section, context)
            .map_err(Error::from)?;
        let kinds = [
            ("contour", pictures.contour),
            ("rings", pictures.rings),
            ("zones", pictures.tissues),
        ];
        for (kind, picture) in kinds {
            sink(png(picture, format!("{name}_{kind}.png")))?;
        }
        names.push(name);
    }
    Ok(())
}

/// The stem cut in half along its pith.
pub(super) fn longitudinal(anatomy: &Anatomy, context: &Context) -> Result<Encoded, Error> {
    let picture = anatomy.paint_longitudinal(context)?;
    Ok(png(picture, "longitudinal.png".to_owned()))
}

fn png(image: RgbImage, name: String) -> Encoded {
    Encoded {
        name,
        bytes: image.png(),
    }
}
