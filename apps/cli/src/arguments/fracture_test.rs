//! Options of `greenstick fracture-test`.

use super::{Declared, OptionSet, ReportingOptions};
use clap::{Arg, Args};
use greenstick::toughness::FractureParameters;
use std::path::PathBuf;

const FRACTURE_EXAMPLES: &str = "\
A crack runs along the grain in the middle plane of a small beam, and the test measures how much energy
it takes per area, as a laboratory does. Beside it stands the energy that was put into the bonds between
the rods.

  double-cantilever-beam  two arms are pulled apart at the end (mode I, opening)
  end-notched-flexure     the beam is bent over two supports, and its halves slide past each other
                          (mode II, sliding); the crack starts at 0.7 of half the span or more, where it
                          grows no faster than the load lets it; nothing rubs
  single-edge-notched-beam  a beam whose middle block stands upright, between stiff arms, is notched from
                          below and bent over two supports until it is broken through (mode I; NT BUILD 422)

The energy is measured in two ways that do not use what was put in: by the work of the load that is no
longer stored, over the area of the crack, and by the change of the compliance C = deflection/load with
the crack's length a, P^2/(2B) dC/da. Beam theory stands beside them, with its correction of the root:
of a sharp crack, which leaves out the zone in which bonds soften, and of the crack that the compliance
tells. All bonds of the specimen may soften and break, not only those of the middle plane. A notched beam
is measured by its work alone, over the area of its ligament, as its process zone is nearly as long.

Bonds have the strength and the energy of fracture of the species: tension and shear from the tables, the
energy from density (Larsen and Gustafsson 1990), three times as much in sliding.

--arrangement scattered puts rods where scenes put them, at random. The crack then follows the facets of
their cells, whose area is about 1.3 times that of its plane, and takes so much more energy.

Files in the folder of -o
  load-deflection.csv  deflection (m), load (N), compliance (m/N), crack (m), energies (J)
  load-deflection.png  the same as a chart, beside beam theory of a sharp crack
  fracture-test.json   the report

Examples
  greenstick fracture-test --species \"Norway spruce\"
  greenstick fracture-test --species \"Norway spruce\" --test end-notched-flexure -o sliding
  greenstick fracture-test --species \"Norway spruce\" --test single-edge-notched-beam -o notched
  greenstick fracture-test --species \"white oak\" --system rl --moisture green
  greenstick fracture-test --species \"white oak\" --height 3cm --crack 12cm
  greenstick fracture-test --species \"Norway spruce\" --spacing 1.25mm --edge 2mm     finer: 10 s
  greenstick fracture-test --species \"Norway spruce\" --arrangement scattered --width 1cm    minutes";

#[derive(Debug, Args)]
#[command(after_help = FRACTURE_EXAMPLES)]
pub struct FractureTestOptions {
    /// Species, by common or scientific name
    #[arg(long, value_name = "NAME")]
    pub species: String,
    /// Folder for all files, created if it does not exist; without it no files are written
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub parameters: Declared<FractureParameters>,

    #[command(flatten)]
    pub reporting: ReportingOptions,
}

impl OptionSet for FractureParameters {
    fn adjust(option: Arg) -> Arg {
        match option.get_id().as_str() {
            "moisture" | "test" | "system" => option.help_heading(None::<&str>),
            _ => option,
        }
    }
}
