//! Options that several commands share.

use super::UnitWord;
use clap::Args;
use std::path::PathBuf;

/// How work is told, and with how many threads it is done.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "How it is told")]
pub struct Telling {
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Threads to use [default: as many as the machine offers]; the output is the same
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

impl Telling {
    /// Whether a report is printed.
    pub fn reports(&self) -> bool {
        !self.quiet || self.json
    }
}

/// The mesh that a simulation is of.
#[derive(Debug, Args)]
pub struct MeshOf {
    /// Mesh that is simulated in place of the scene's stem; that of a run is found again where it still is
    pub input: Option<PathBuf>,
    /// Unit of length in the mesh, where its format has none; also of a mesh that is written
    #[arg(long)]
    pub unit: Option<UnitWord>,
}
