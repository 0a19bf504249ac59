//! What a page asks its worker, and what that answers, as bytes that both can read.

use super::engine::{Failure, Haste, Shown};
use super::holds::Moved;
use super::input::{Input, Seen};
use super::meshes::DrawnScene;
use super::simulation::{Look, News, Source, Taken};
use greenstick::RequestFile;
use greenstick::wood::stem::StemLocation;
use serde::{Deserialize, Serialize};

/// What is asked. Requests are in the form of project files; 0 is the number of the built-in branch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    /// Something about simulations.
    Simulation(SimulationAsk),
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
    /// Width and height, pixels, and red, green and blue (0 to 255) of each, of a photograph that is small enough to be shown.
    Pictured(Result<(u32, u32, Vec<u8>), Failure>),
    /// The names of the pieces' files, which come along.
    Exported(Result<Vec<String>, Failure>),
    /// News of the simulation of a number.
    Simulated(u64, Box<News>),
    /// The simulation of a number waits to be gone on with, or, with true, is over.
    Rested(u64, bool),
    /// The break that the simulation of a number left; the file of its stem comes along.
    Taken(u64, Result<Box<TakenFile>, Failure>),
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

/// A simulation that is asked for, as it crosses to the worker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AskedSimulation {
    /// Its number, by which it is told of.
    pub number: u64,
    /// What is simulated.
    pub source: Source,
    /// The number of the input at hand.
    pub input: u64,
    /// The place of its break.
    #[serde(with = "super::wire::place")]
    pub place: Option<StemLocation>,
    /// Whether the scene is put on that stem in place of its own.
    pub own: bool,
    /// Parts of the scene that are elsewhere along its stem, and the hand that pulls on it.
    pub moved: Vec<Moved>,
}

/// What is asked of simulations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum SimulationAsk {
    /// To begin one; that before is given up.
    Begin(AskedSimulation),
    /// To move the wood to its next frame, or, after the last one, to cut it as its end decided.
    GoOn,
    /// To have the hand pull elsewhere from the last frame on: so many parts of the stem's length along the axes of the scene.
    Steer([f64; 3]),
    /// To draw a frame.
    Draw(usize, Look),
    /// To take the break that the run left, where the input of this number is at hand.
    Take(u64),
}

/// A break that was taken, as it crosses from the worker; the stem's file comes along where the scene made the stem.
#[derive(Debug, Serialize, Deserialize)]
pub struct TakenFile {
    /// The request that breaks the stem along the faces of the run, as a file.
    pub request: String,
    /// What the window needs to know of the stem; none where it is the one at hand.
    pub stem: Option<Seen>,
}

impl TakenFile {
    /// What the window takes of it, with the stem's file.
    ///
    /// # Errors
    /// Where the request cannot be read.
    pub fn taken(self, file: Vec<u8>) -> Result<Taken, Failure> {
        let read = RequestFile::resolve(&[], Some(&self.request), &[]);
        let request = read.map_err(Failure::new)?.request();
        let input = self.stem.map(|seen| Input::made_elsewhere(seen, file));
        Ok(Taken {
            request,
            input,
            unit: None,
        })
    }
}
