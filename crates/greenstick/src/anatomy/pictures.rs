//! Pictures of the inside as PNG files.

use super::outputs::Outputs;
use crate::Error;
use greenstick_geometry::Context;
use greenstick_wood::anatomy::{Anatomy, AnatomyRequest, PicturedSection, ScaledImage};

/// Contour, rings and tissues of the section at the location, and of others at equal distances.
pub(super) fn sections<E: From<Error>>(
    anatomy: &Anatomy,
    request: &AnatomyRequest,
    context: &Context,
    outputs: &mut Outputs<E>,
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
            outputs.picture(scaled, format!("{name}_{kind}.png"))?;
        }
    }
    Ok(())
}

/// The stem cut in half along its pith, in strips from the base on.
pub(super) fn longitudinal<E: From<Error>>(
    anatomy: &Anatomy,
    context: &Context,
    outputs: &mut Outputs<E>,
) -> Result<(), E> {
    let picture = anatomy.paint_longitudinal(context).map_err(Error::from)?;
    outputs.picture(picture, "longitudinal.png".to_owned())
}
