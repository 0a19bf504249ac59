//! Pictures of the inside as PNG files.

use crate::Error;
use greenstick_formats::Encoded;
use greenstick_geometry::Context;
use greenstick_picture::Picture;
use greenstick_wood::anatomy::{Anatomy, AnatomyRequest, PicturedSection, ScaledImage};

/// Contour, rings and tissues of the section at the location, and of others at equal distances.
pub(super) fn sections<E: From<Error>>(
    anatomy: &Anatomy,
    request: &AnatomyRequest,
    context: &Context,
    sink: &mut dyn FnMut(Encoded) -> Result<(), E>,
) -> Result<(), E> {
    let sections = anatomy
        .pictured_sections(request.sections, context)
        .map_err(Error::from)?;
    for (i, PicturedSection { name, section }) in sections.iter().enumerate() {
        let pictures = context
            .report(i as f64 / sections.len() as f64)
            .and_then(|()| anatomy.paint_section(section, context))
            .map_err(Error::from)?;
        for (image, kind) in [
            (pictures.contour, "contour"),
            (pictures.rings, "rings"),
            (pictures.tissues, "zones"),
        ] {
            let scaled = ScaledImage {
                image,
                pixel: pictures.pixel,
            };
            sink(png(scaled, format!("{name}_{kind}.png")))?;
        }
    }
    Ok(())
}

/// The stem cut in half along its pith, in strips from the base on.
pub(super) fn longitudinal(anatomy: &Anatomy, context: &Context) -> Result<Encoded, Error> {
    let picture = anatomy.paint_longitudinal(context)?;
    Ok(png(picture, "longitudinal.png".to_owned()))
}

/// Encodes a picture with a scale bar below it.
fn png(scaled: ScaledImage, name: String) -> Encoded {
    let mut picture = Picture {
        width: scaled.image.width,
        height: scaled.image.height,
        rgb: scaled.image.rgb,
    };
    picture.add_scale_bar(scaled.pixel);
    Encoded::new(name, picture.png())
}
