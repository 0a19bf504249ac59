//! The work of a page: what its worker is asked, and what it answers, as bytes that both can read. Nothing here knows of browsers.

use super::engine::{Early, Engine, Failure, Haste, Job, Shown, export, unbroken};
use super::held::{HeldFile, last_name, main_name, read_input, read_project};
use super::input::{Input, Seen};
use super::meshes::DrawnScene;
use super::photograph::{PICTURE_SIDE, reduced};
use greenstick::RequestFile;
use greenstick::files::encode;
use greenstick::formats::LengthUnit;
use greenstick::formats::photograph::{Photograph, read_photograph};
use greenstick::geometry::Context;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// What is asked. Requests are in the form of project files; 0 is the number of the built-in branch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ask {
    /// To keep the files that come along as the input of a number; `unit` is a word that units are read by.
    Hold {
        /// The number.
        input: u64,
        /// The unit of length in them.
        unit: Option<String>,
    },
    /// What the viewport shows.
    Show {
        /// The number of the question.
        number: u64,
        /// The number of the input.
        input: u64,
        /// The request.
        request: String,
        /// How much of it is wanted.
        haste: Haste,
        /// The number of the break of whose stem sections are wanted, if they are.
        sections_of: Option<usize>,
    },
    /// What the files that come along are.
    Open {
        /// The unit of length in them.
        unit: Option<String>,
    },
    /// The photograph that comes along.
    Picture,
    /// The pieces of the files that come along, or of the built-in branch without any, as files.
    Export {
        /// The request.
        request: String,
        /// The name of the main file; its ending decides the format.
        path: String,
    },
}

/// What files are.
#[derive(Debug, Serialize, Deserialize)]
pub struct OpenedFiles {
    /// The name of the mesh or scan, and what the window needs to know of it; none for the built-in branch.
    pub input: Option<(String, Seen)>,
    /// The project or recipe among them, as its file.
    pub request: Option<String>,
    /// The name of the file that the project is about, where it did not come along.
    pub missing: Option<String>,
}

/// What is answered.
#[derive(Debug, Serialize, Deserialize)]
pub enum Answer {
    /// Questions can be asked now.
    Ready,
    /// How far the work is.
    Progress {
        /// The name of its stage.
        stage: String,
        /// 0 to 1.
        overall: f64,
    },
    /// The program has a fault: what it said before it ended.
    Fault(String),
    /// What the viewport shows before the answer is finished, with the number of the question.
    Drawn(u64, Box<DrawnScene>),
    /// The finished answer, with the number of the question; none where only what is drawn was wanted.
    Shown(u64, Result<Option<Box<Shown>>, Failure>),
    /// What files are.
    Opened(Result<Box<OpenedFiles>, Failure>),
    /// Width, height and colours, as of a [`Photograph`], of a photograph that is small enough to be shown.
    Pictured(Result<(u32, u32, Vec<u8>), Failure>),
    /// The names of the pieces' files, which come along.
    Exported(Result<Vec<String>, Failure>),
}

/// Writes a question or an answer.
///
/// # Errors
/// Where it cannot be written; that is a fault of the program.
pub fn to_bytes<T: Serialize>(value: &T) -> Result<Vec<u8>, String> {
    postcard::to_stdvec(value).map_err(|e| e.to_string())
}

/// Reads a question or an answer.
///
/// # Errors
/// Where the bytes are none.
pub fn from_bytes<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, String> {
    postcard::from_bytes(bytes).map_err(|e| e.to_string())
}

/// Where the work is done.
#[derive(Debug, Default)]
pub struct Desk {
    engine: Engine,
    /// The input that is kept.
    input: Option<Input>,
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
        let held = self.input.as_ref().filter(|i| i.id == input);
        let input = match held {
            Some(held) => held.clone(),
            None if input == 0 => Input::built_in(),
            None => {
                return Err(Failure::new(
                    "the file can no longer be read: open it again",
                ));
            }
        };
        let job = Job {
            input,
            file: request_of(request)?,
            haste,
            sections_of,
        };
        Ok(self.engine.work(&job, early, context)?)
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
