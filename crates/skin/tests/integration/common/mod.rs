//! Wood with rods for tests.

use glam::{DAffine3, DVec2};
use greenstick_fibre::placement::{
    EdgeLengths, PlacedRods, PlacementOptions, RodCount, WoodMaterial, fill_stem,
};
use greenstick_geometry::{Context, Mesh};
use greenstick_skin::rods::{Materials, Wood};
use greenstick_skin::texture::SectionSquare;
use greenstick_wood::moisture::Fallback;
use greenstick_wood::species::Species;
use greenstick_wood::stem::{Stem, StemOptions, find_stem};

pub struct Grown {
    pub stem: Stem,
    pub placed: PlacedRods,
    pub pull_out: f64,
}

pub fn grown(mesh: Mesh, rods: u32) -> Grown {
    let middle = "0.5".parse().unwrap();
    // As simulated wood is.
    let options = StemOptions {
        slope_of_grain: 0.0,
        ..StemOptions::default()
    };
    let found = find_stem(&[mesh], &middle, &options, &Context::quiet());
    let stem = found.unwrap().stem;
    let oak = Species::find("white oak").unwrap();
    let wood = WoodMaterial::from_species(oak, 12.0, Fallback::Refuse).unwrap();
    let options = PlacementOptions {
        rods: RodCount::Number(rods),
        edges: EdgeLengths {
            least: 0.008,
            greatest: 0.012,
        },
        ..PlacementOptions::default()
    };
    Grown {
        placed: fill_stem(&stem, &wood, &options, &Context::quiet()).unwrap(),
        pull_out: wood.tension / (4.0 * wood.shear),
        stem,
    }
}

pub fn wood(grown: &Grown) -> Wood<'_> {
    Wood {
        stem: &grown.stem,
        stem_to_rods: DAffine3::IDENTITY,
        bundle: &grown.placed.bundle,
        along: &grown.placed.along,
        cells: &grown.placed.cells,
        outline: &grown.placed.outline,
        bark: None,
        pull_out: grown.pull_out,
    }
}

pub const MATERIALS: Materials = Materials {
    inner: 0,
    bark: 1,
    bark_mesh_offset: 2,
    square: SectionSquare::round(DVec2::ZERO, 0.1),
    zone: &|_| 0,
};
