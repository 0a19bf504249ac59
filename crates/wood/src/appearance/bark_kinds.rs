//! Bark by genus: smooth, furrowed, plated, scaly, stringy or with lenticels (after the field descriptions of Hoadley,
//! *Identifying Wood*, and of the *Silvics of North America*, USDA Forest Service Agriculture Handbook 654).

use super::bark::BarkAppearance;
use crate::colour::linear_from_srgb as srgb;

/// How the bark of a genus differs from that of an unknown tree of the same size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BarkKind {
    /// Colours of ridges and of furrows, sRGB.
    ridge: [u8; 3],
    furrow: [u8; 3],
    /// Factor on the distance between furrows.
    width: f64,
    /// Factor on their depth.
    depth: f64,
    /// Factor on the length of ridges over their width.
    stretch: f64,
    /// How many lenticels show, 0 to 1.
    lenticels: f64,
}

const fn kind(
    ridge: [u8; 3],
    furrow: [u8; 3],
    [width, depth, stretch]: [f64; 3],
    lenticels: f64,
) -> BarkKind {
    BarkKind {
        ridge,
        furrow,
        width,
        depth,
        stretch,
        lenticels,
    }
}

/// Grey and smooth.
const SMOOTH: BarkKind = kind([152, 150, 142], [122, 118, 108], [1.6, 0.12, 0.6], 0.25);
/// Long ridges between deep furrows.
const FURROWED: BarkKind = kind([126, 116, 104], [62, 50, 42], [1.15, 1.5, 1.3], 0.0);
/// Fibrous strips.
const STRINGY: BarkKind = kind([142, 104, 80], [84, 54, 40], [0.7, 0.9, 3.0], 0.0);
/// Thin scales.
const SCALY: BarkKind = kind([128, 108, 94], [88, 66, 54], [0.75, 0.7, 0.35], 0.0);
/// Bands of lenticels about a thin, smooth skin.
const BANDED: BarkKind = kind([112, 74, 58], [74, 46, 38], [1.3, 0.2, 0.7], 1.0);

/// Kinds by genus.
const KINDS: &[(&str, BarkKind)] = &[
    ("Abies", SMOOTH),
    (
        "Acer",
        kind([128, 120, 110], [82, 72, 64], [1.0, 0.8, 1.0], 0.1),
    ),
    (
        "Alnus",
        kind([130, 122, 112], [86, 76, 68], [1.2, 0.4, 0.8], 0.6),
    ),
    (
        "Betula",
        kind([218, 210, 196], [96, 82, 72], [1.7, 0.18, 0.6], 1.0),
    ),
    ("Calocedrus", STRINGY),
    ("Carpinus", SMOOTH),
    ("Carya", FURROWED),
    ("Castanea", FURROWED),
    ("Celtis", SMOOTH),
    ("Chamaecyparis", STRINGY),
    ("Fagus", SMOOTH),
    ("Fraxinus", FURROWED),
    ("Juglans", FURROWED),
    ("Juniperus", STRINGY),
    (
        "Larix",
        kind([146, 108, 88], [92, 58, 48], [1.2, 1.1, 0.5], 0.0),
    ),
    ("Liriodendron", FURROWED),
    ("Magnolia", SMOOTH),
    ("Picea", SCALY),
    (
        "Pinus",
        kind([150, 112, 86], [78, 50, 38], [1.5, 1.2, 0.55], 0.0),
    ),
    (
        "Populus",
        kind([148, 148, 132], [88, 84, 72], [1.3, 0.5, 1.0], 0.5),
    ),
    ("Prunus", BANDED),
    ("Pseudotsuga", FURROWED),
    ("Quercus", FURROWED),
    ("Robinia", FURROWED),
    ("Salix", FURROWED),
    ("Sequoia", STRINGY),
    ("Taxodium", STRINGY),
    ("Thuja", STRINGY),
    (
        "Tilia",
        kind([128, 122, 114], [82, 74, 68], [0.9, 0.7, 1.4], 0.0),
    ),
    ("Ulmus", FURROWED),
];

impl BarkKind {
    /// Returns the kind of bark of a species by its scientific name, `None` for a genus that is not in the table.
    ///
    /// ```
    /// use greenstick_wood::appearance::BarkKind;
    ///
    /// assert_ne!(BarkKind::of("Fagus sylvatica"), BarkKind::of("Quercus robur"));
    /// assert_eq!(BarkKind::of("Zelkova serrata"), None);
    /// ```
    pub fn of(scientific_name: &str) -> Option<BarkKind> {
        let genus = scientific_name.split(' ').next()?;
        KINDS.iter().find(|k| k.0 == genus).map(|k| k.1)
    }

    /// Returns bark of a stem's size as it is in this kind.
    #[must_use]
    pub fn apply(&self, bark: BarkAppearance) -> BarkAppearance {
        BarkAppearance {
            ridge_color: srgb(self.ridge),
            furrow_color: srgb(self.furrow),
            furrow_width: bark.furrow_width * self.width,
            furrow_depth: bark.furrow_depth * self.depth,
            furrow_stretch: self.stretch,
            lenticels: self.lenticels,
            ..bark
        }
    }
}
