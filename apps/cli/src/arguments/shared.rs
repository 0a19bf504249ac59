//! Options that several commands share.

use super::UnitWord;
use crate::failure::Failure;
use crate::values;
use clap::{Args, ValueEnum};
use greenstick::anatomy::RingMethod;
use greenstick::wood::rings::{Erosion, ErosionSchedule, KernelSchedule};
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

/// Where rings come from.
#[derive(Debug, Args)]
#[command(next_help_heading = "Where rings come from")]
pub struct RingSource {
    /// Where rings come from
    #[arg(long, default_value = "field")]
    pub rings_by: RingsByWord,
    /// Kernels of the erosion [default: alternating]
    #[arg(long)]
    pub schedule: Option<ScheduleWord>,
    /// Kernels of one's own, from the bark inwards: rings parted by commas, in each latewood and earlywood by a slash, such
    /// as 4*3/5,3/7; a kernel is K or WxH pixels, then if wanted its offset +X+Y and tM, the threshold. The last ring repeats
    #[arg(long, value_name = "RINGS", conflicts_with = "schedule")]
    pub kernels: Option<KernelSchedule>,
    /// Also erode from a circle about the pith outwards, until both fronts meet: its radius as a share of the section's
    /// mean one, as in the publication's Fig. 7. With any kernels, eccentric ones included
    #[arg(long, value_name = "SHARE", value_parser = values::positive)]
    pub inner_circle: Option<f64>,
}

impl RingSource {
    /// The library's word for it. `counted` is the option, if any, that sets a number of rings, which an erosion makes itself.
    pub fn rings_by(&self, counted: Option<&str>) -> Result<RingMethod, Failure> {
        let of_erosion = [
            ("--schedule", self.schedule.is_some()),
            ("--kernels", self.kernels.is_some()),
            ("--inner-circle", self.inner_circle.is_some()),
        ];
        if self.rings_by == RingsByWord::Field {
            return match of_erosion.into_iter().find(|option| option.1) {
                Some((option, _)) => Err(Failure::request(format!(
                    "{option} is of an erosion; say --rings-by erosion with it"
                ))),
                None => Ok(RingMethod::Field),
            };
        }
        if let Some(option) = counted {
            return Err(Failure::request(format!(
                "{option}: an erosion makes its own number of rings, by its kernels and the --resolution; leave it out"
            )));
        }
        let word = self.schedule.unwrap_or(ScheduleWord::Alternating);
        Ok(RingMethod::Erosion(Erosion {
            schedule: match &self.kernels {
                Some(kernels) => ErosionSchedule::Kernels(kernels.clone()),
                None => word.into(),
            },
            inner_circle: self.inner_circle,
        }))
    }
}

/// Where rings come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum RingsByWord {
    #[value(help = "a continuous field, round at the pith and like the outline outside")]
    Field,
    #[value(help = "erosion of the section's pixels, as published")]
    Erosion,
}

/// Schedules of an erosion.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum ScheduleWord {
    #[value(help = "every pass takes a pixel, as in the publication's Fig. 5 and Table 1")]
    Alternating,
    #[value(
        name = "figure-6",
        help = "rings of different widths, as in its Fig. 6"
    )]
    Figure6,
    #[value(help = "twice as wide along one direction, as in its Fig. 8")]
    Eccentric,
}

impl From<ScheduleWord> for ErosionSchedule {
    fn from(word: ScheduleWord) -> Self {
        match word {
            ScheduleWord::Alternating => ErosionSchedule::Alternating,
            ScheduleWord::Figure6 => ErosionSchedule::Figure6,
            ScheduleWord::Eccentric => ErosionSchedule::Eccentric,
        }
    }
}
