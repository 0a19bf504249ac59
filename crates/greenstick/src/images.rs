//! Images of the wood crate as pictures that can be encoded.

use greenstick_picture::Picture;
use greenstick_wood::colour::RgbImage;

/// The image as a picture.
pub(crate) fn picture(image: RgbImage) -> Picture {
    Picture {
        width: image.width,
        height: image.height,
        rgb: image.rgb,
    }
}
