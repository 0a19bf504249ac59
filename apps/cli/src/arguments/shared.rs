//! Options that several commands share.

use super::unit::UnitChoice;
use clap::Args;
use std::path::PathBuf;

/// What is printed about the work, and the threads that do it.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Reporting")]
pub struct ReportingOptions {
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

impl ReportingOptions {
    /// Returns whether a report is printed.
    pub fn prints_report(&self) -> bool {
        !self.quiet || self.json
    }
}

/// The mesh that is simulated.
#[derive(Debug, Args)]
pub struct MeshOptions {
    /// Mesh that is simulated instead of the scene's stem; the mesh of a run is found again if it has not moved
    pub input: Option<PathBuf>,
    /// Unit of length in the mesh, if its format has none; also of a mesh that is written
    #[arg(long)]
    pub unit: Option<UnitChoice>,
}
