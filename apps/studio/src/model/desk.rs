//! The work of a page: its worker does what is asked, and answers. Nothing here knows of browsers.

use super::engine::{Early, Engine, Failure, Haste, Job, Shown, export, unbroken};
use super::held::{HeldFile, last_name, main_name, read_input, read_project};
use super::input::{Input, Seen};
use super::messages::{Answer, Ask, OpenedFiles};
use super::photograph::{PICTURE_SIDE, reduced};
use super::simulation_desk::SimulationDesk;
use greenstick::RequestFile;
use greenstick::files::encode;
use greenstick::formats::LengthUnit;
use greenstick::formats::photograph::{Photograph, read_photograph};
use greenstick::geometry::Context;
use std::path::Path;

/// Where the work is done.
#[derive(Default)]
pub struct Desk {
    engine: Engine,
    /// The input that is kept.
    input: Option<Input>,
    simulations: SimulationDesk,
}

fn unit_of(word: Option<&str>) -> Option<LengthUnit> {
    word.and_then(|w| w.parse().ok())
}

fn request_of(text: &str) -> Result<RequestFile, Failure> {
    RequestFile::resolve(&[], Some(text), &[]).map_err(Failure::new)
}

impl Desk {
    /// Does what is asked with the files that come along. Returns the answer, if there is one, and the files that go with it;
    /// `early` is told what is answered before.
    pub fn answer(
        &mut self,
        ask: Ask,
        files: Vec<HeldFile>,
        early: &mut dyn FnMut(Answer),
        context: &Context,
    ) -> (Option<Answer>, Vec<HeldFile>) {
        let answer = match ask {
            Ask::Hold { input, unit } => {
                // It was read before, or the window would not know it; what is wrong with it now is said where it is shown.
                self.input = read_input(&files, unit_of(unit.as_deref())).ok();
                if let Some(held) = &mut self.input {
                    held.id = input;
                }
                return (None, Vec::new());
            }
            Ask::Show {
                number,
                input,
                request,
                haste,
                sections_of,
            } => {
                let draw = &mut |drawn| early(Answer::Drawn(number, Box::new(drawn)));
                let shown = self.show(input, (&request, haste, sections_of), draw, context);
                Answer::Shown(number, shown.map(|s| s.map(Box::new)))
            }
            Ask::Open { unit } => {
                let opened = open(&files, unit_of(unit.as_deref()));
                Answer::Opened(opened.map(Box::new))
            }
            Ask::Simulation(ask) => {
                let held = &self.input;
                let input = |number| held_input(held.as_ref(), number);
                return self.simulations.answer(ask, input, early, context);
            }
            Ask::Picture => Answer::Pictured(picture(&files)),
            Ask::Export { request, path } => match pieces(&files, &request, &path, context) {
                Ok(pieces) => {
                    let names = pieces.iter().map(|p| p.name.clone()).collect();
                    return (Some(Answer::Exported(Ok(names))), pieces);
                }
                Err(failure) => Answer::Exported(Err(failure)),
            },
        };
        (Some(answer), Vec::new())
    }

    fn show(
        &mut self,
        input: u64,
        (request, haste, sections_of): (&str, Haste, Option<usize>),
        early: Early,
        context: &Context,
    ) -> Result<Option<Shown>, Failure> {
        let input = held_input(self.input.as_ref(), input)?;
        let job = Job {
            input,
            file: request_of(request)?,
            haste,
            sections_of,
        };
        Ok(self.engine.work(&job, early, context)?)
    }
}

/// The input of a number: the one that is held, or the built-in branch.
fn held_input(held: Option<&Input>, number: u64) -> Result<Input, Failure> {
    match held.filter(|i| i.id == number) {
        Some(held) => Ok(held.clone()),
        None if number == 0 => Ok(Input::built_in()),
        None => Err(Failure::new(
            "the file can no longer be read: open it again",
        )),
    }
}

fn open(files: &[HeldFile], unit: Option<LengthUnit>) -> Result<OpenedFiles, Failure> {
    let project = read_project(files)?;
    let named = project.as_ref().and_then(|p| p.request.input.as_deref());
    let here = main_name(files);
    let missing = named.map(last_name).filter(|n| here != Some(*n));
    let wanted = project.is_none() || named.is_some() && missing.is_none();
    let unit = project.as_ref().map_or(unit, |p| p.request.unit);
    let input = if wanted {
        let input = read_input(files, unit)?;
        let seen = Seen {
            unbroken: unbroken(&input),
            has_z_up: input.has_z_up(),
            notes: input.notes.clone(),
        };
        Some((input.title().to_owned(), seen))
    } else {
        None
    };
    Ok(OpenedFiles {
        input,
        missing: missing.map(str::to_owned),
        request: project.map(|p| p.to_toml()),
    })
}

fn picture(files: &[HeldFile]) -> Result<(u32, u32, Vec<u8>), Failure> {
    let file = files.first();
    let file = file.ok_or_else(|| Failure::new("there is no photograph"))?;
    let whole = read_photograph(&file.bytes);
    let whole = whole.map_err(|e| Failure::new(format!("{}: {e}", file.name)))?;
    let Photograph { width, height, rgb } = reduced(&whole, PICTURE_SIDE);
    Ok((width, height, rgb))
}

fn pieces(
    files: &[HeldFile],
    request: &str,
    path: &str,
    context: &Context,
) -> Result<Vec<HeldFile>, Failure> {
    let file = request_of(request)?;
    let path = Path::new(path);
    greenstick::files::output_format(path).map_err(Failure::new)?;
    let input = if files.is_empty() {
        Input::built_in()
    } else {
        read_input(files, file.unit)?
    };
    let broken = export(&input, &file, |_| {}, context)?;
    let outputs = encode(&broken.scene, path, file.unit.unwrap_or_default());
    let held = |o: greenstick::files::Output| HeldFile {
        name: last_name(&o.path.to_string_lossy()).to_owned(),
        bytes: o.bytes,
    };
    Ok(outputs
        .map_err(Failure::new)?
        .into_iter()
        .map(held)
        .collect())
}
