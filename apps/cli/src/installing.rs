//! `greenstick completions` and `greenstick manual`: what a package installs beside the program, from its own arguments.

use crate::arguments::{Arguments, CompletionsOptions, ManualOptions};
use crate::failure::{Failure, print};
use clap::{Command, CommandFactory};
use greenstick::files;
use greenstick::formats::Encoded;
use greenstick::geometry::text::one_line;
use std::process::ExitCode;

/// The name of the program.
const PROGRAM: &str = "greenstick";

pub fn completions(options: &CompletionsOptions) -> Result<ExitCode, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(
        options.shell,
        &mut Arguments::command(),
        PROGRAM,
        &mut script,
    );
    print(&String::from_utf8_lossy(&script))?;
    Ok(ExitCode::SUCCESS)
}

pub fn manual(options: &ManualOptions) -> Result<ExitCode, Failure> {
    let mut program = Arguments::command().name(PROGRAM);
    program.build();
    let mut pages = vec![page(&program, PROGRAM)?];
    for command in program.get_subcommands() {
        if command.get_name() != "help" {
            let name = format!("{PROGRAM}-{}", command.get_name());
            pages.push(page(command, &name)?);
        }
    }
    let written = files::write_folder(&options.output, pages)?;
    print(&format!(
        "{} pages in {}; `man -l {}` shows one\n",
        written.len(),
        one_line(&options.output.display().to_string()),
        one_line(
            &options
                .output
                .join(format!("{PROGRAM}.1"))
                .display()
                .to_string()
        )
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// Makes the page of a command.
fn page(command: &Command, name: &str) -> Result<Encoded, Failure> {
    let mut bytes = Vec::new();
    let command = command.clone().name(name.to_owned());
    clap_mangen::Man::new(command)
        .manual("Greenstick")
        .render(&mut bytes)
        .map_err(|error| Failure::work(format!("the page of {name}: {error}")))?;
    Ok(Encoded::new(format!("{name}.1"), bytes))
}
