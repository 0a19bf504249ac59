//! The program `greenstick`: arguments, files, progress and messages. What it does to wood is in the libraries.

mod anatomy;
mod arguments;
mod bend_test;
mod break_files;
mod break_run;
mod break_simulated;
mod break_wood;
mod cracks;
#[cfg(test)]
mod documented_commands;
mod failure;
mod fit;
mod fracture_test;
mod inspect;
mod installing;
mod list;
mod outcome;
mod progress;
mod rings;
mod simulate;
mod skin;
mod species;
mod sweep;
mod test_output;
mod values;
mod video;

use arguments::{Arguments, Command};
use clap::Parser;
use failure::Failure;
use std::process::ExitCode;

fn main() -> ExitCode {
    hold_back_file_size_signal();
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        // Help and version are no errors: they go to stdout with code 0, everything else to stderr with code 2.
        Err(message) => {
            let _ = failure::print_usage(&message);
            return ExitCode::from(if message.use_stderr() { 2 } else { 0 });
        }
    };
    let result = match &arguments.command {
        Command::Break(options) => match (&options.simulate, &options.from_run) {
            (Some(scene), _) => break_simulated::run(options, scene),
            (None, Some(folder)) => break_run::run(options, folder),
            (None, None) => break_wood::run(options),
        },
        Command::Sweep(options) => sweep::run(options),
        Command::Anatomy(options) => anatomy::run(options),
        Command::BendTest(options) => bend_test::run(options),
        Command::FractureTest(options) => fracture_test::run(options),
        Command::Check(options) => inspect::check(options),
        Command::Picture(options) => inspect::picture(options),
        Command::Simulate(options) => simulate::run(options),
        Command::Skin(options) => skin::run(options),
        Command::Fit(options) => fit::run(options),
        Command::Parameters(options) => list::parameters(options),
        Command::Schema(options) => list::schema(options),
        Command::Presets(options) => list::presets(options),
        Command::Rings(options) => rings::run(options),
        Command::Cracks(options) => cracks::run(options),
        Command::Species(options) => species::run(options),
        Command::Completions(options) => installing::completions(options),
        Command::Manual(options) => installing::manual(options),
    };
    result.unwrap_or_else(Failure::report)
}

/// Makes a write beyond the greatest size of files (`ulimit -f`) an error like any other, after which what was begun is
/// removed; the signal would end the program at once. Threads started later hold it back, too.
fn hold_back_file_size_signal() {
    #[cfg(unix)]
    {
        use nix::sys::signal::{SigSet, Signal};
        // Where it cannot be held back, the program ends there as others do.
        let _ = SigSet::from(Signal::SIGXFSZ).thread_block();
    }
}
