//! Pictures of the inside as PNG files.

use crate::Error;
use greenstick_formats::Encoded;
use greenstick_geometry::Context;
use greenstick_wood::anatomy::{Anatomy, AnatomyRequest, PicturedSection};
use greenstick_wood::colour::RgbImage;

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
        sink(png(&pictures.contour, format!("{name}_contour.png")))?;
        sink(png(&pictures.rings, format!("{name}_rings.png")))?;
        sink(png(&pictures.tissues, format!("{name}_zones.png")))?;
    }
    Ok(())
}

/// The stem cut in half along its pith.
pub(super) fn longitudinal(anatomy: &Anatomy, context: &Context) -> Result<Encoded, Error> {
    let picture = anatomy.paint_longitudinal(context)?;
    Ok(png(&picture, "longitudinal.png".to_owned()))
}

fn png(image: &RgbImage, name: String) -> Encoded {
    Encoded::new(name, image.png())
}
