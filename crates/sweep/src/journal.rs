//! The journal of a sweep: a line of JSON for every variant that is done, in the order in which they were done. It is the truth
//! of what is done; tables are made of it.

use crate::error::SweepError;
use crate::figures::Figures;
use crate::part::{Part, is_part_file};
use crate::plan::Sweep;
use greenstick::files::FileError;
use serde::{Deserialize, Serialize};
use std::fs::{self, File, TryLockError};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Name of the journal in the folder of a sweep.
pub const JOURNAL_FILE: &str = "journal.jsonl";

/// What came of a variant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Its number, from 0.
    pub variant: u64,
    /// The time it took, s.
    pub seconds: f64,
    /// The file of its pieces, relative to the folder of the sweep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The figures of its report; none where it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub figures: Option<Figures>,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

/// The first line: whose journal it is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Heading {
    /// Hash of the sweep.
    sweep: String,
    /// Version of the library: others may make other bytes.
    version: String,
    /// Number of variants.
    variants: u64,
}

/// A set of numbers of variants, a bit each.
#[derive(Debug, Clone, Default)]
pub struct Done {
    words: Vec<u64>,
    count: u64,
}

impl Done {
    /// Whether a variant is in it.
    pub fn contains(&self, number: u64) -> bool {
        let word = self.words.get((number / 64) as usize);
        word.is_some_and(|w| w >> (number % 64) & 1 == 1)
    }

    /// How many there are.
    pub fn count(&self) -> u64 {
        self.count
    }

    fn insert(&mut self, number: u64) {
        if !self.contains(number) {
            let word = (number / 64) as usize;
            self.words.resize(self.words.len().max(word + 1), 0);
            self.words[word] |= 1 << (number % 64);
            self.count += 1;
        }
    }
}

/// The journal of a sweep in its folder. Only one process at a time has it open.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Its length, bytes; all of it is whole lines.
    length: u64,
    variants: u64,
    done: Done,
    failed: u64,
}

impl Journal {
    /// Opens the journal of a sweep in a folder, or begins one. What a process that was killed left of its last line is taken
    /// away.
    ///
    /// # Errors
    /// [`SweepError`] where the folder holds another sweep, another process is at work there, or the journal cannot be read
    /// or written.
    pub fn open(folder: &Path, sweep: &Sweep) -> Result<Self, SweepError> {
        Journal::open_file(folder, sweep, JOURNAL_FILE)
    }

    /// Opens the journal of a part of a sweep, which other processes make the rest of in the same folder. The journal of the
    /// whole takes over what is in it ([`Journal::take_parts`]).
    ///
    /// # Errors
    /// As [`Journal::open`].
    pub fn open_part(folder: &Path, sweep: &Sweep, part: Part) -> Result<Self, SweepError> {
        Journal::open_file(folder, sweep, &part.journal_file())
    }

    /// Takes over what the journals of parts in the folder have and this one does not.
    ///
    /// # Errors
    /// As [`Journal::open`]; [`SweepError::AtWork`] where a process is at work on a part.
    pub fn take_parts(&mut self, folder: &Path, sweep: &Sweep) -> Result<(), SweepError> {
        let io = SweepError::io(folder);
        let mut names: Vec<String> = Vec::new();
        for entry in fs::read_dir(folder).map_err(&io)? {
            let name = entry.map_err(&io)?.file_name();
            names.extend(name.to_str().filter(|n| is_part_file(n)).map(str::to_owned));
        }
        names.sort();
        for name in names {
            let part = Journal::open_file(folder, sweep, &name)?;
            let mut records = Vec::new();
            part.each_line(|line, number, _| {
                if number > 1 {
                    let record: Record = serde_json::from_str(line).map_err(|e| e.to_string())?;
                    records.extend((!self.done.contains(record.variant)).then_some(record));
                }
                Ok(())
            })?;
            records.iter().try_for_each(|record| self.add(record))?;
        }
        Ok(())
    }

    fn open_file(folder: &Path, sweep: &Sweep, name: &str) -> Result<Self, SweepError> {
        let path = folder.join(name);
        fs::create_dir_all(folder).map_err(|source| FileError::Unwritable {
            path: folder.to_owned(),
            source,
        })?;
        let failed = SweepError::io(&path);
        let file = File::options()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(&failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(SweepError::AtWork {
                    path: folder.to_owned(),
                });
            }
            // A file system without locks.
            Err(TryLockError::Error(_)) => {}
        }
        let mut journal = Journal {
            path,
            file,
            length: 0,
            variants: sweep.count(),
            done: Done::default(),
            failed: 0,
        };
        journal.load(folder, sweep)?;
        Ok(journal)
    }

    /// Reads what is there, or writes the heading.
    fn load(&mut self, folder: &Path, sweep: &Sweep) -> Result<(), SweepError> {
        let heading = Heading {
            sweep: sweep.hash(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            variants: sweep.count(),
        };
        let mut found = false;
        let (mut done, mut failed) = (Done::default(), 0);
        let length = self.each_line(|line, number, _| {
            if number == 1 {
                found = true;
                return check_heading(folder, line, &heading);
            }
            let record: Record = serde_json::from_str(line).map_err(|e| e.to_string())?;
            if record.variant >= heading.variants {
                return Err(format!("there is no variant {}", record.variant).into());
            }
            failed += u64::from(record.error.is_some() && !done.contains(record.variant));
            done.insert(record.variant);
            Ok(())
        })?;
        (self.done, self.failed, self.length) = (done, failed, length);
        let io = SweepError::io(&self.path);
        self.file.set_len(length).map_err(&io)?;
        self.file.seek(SeekFrom::End(0)).map_err(&io)?;
        if found {
            return Ok(());
        }
        self.append_line(&heading)
    }

    /// Calls `read` with every whole line, its number from 1 and its first byte. Returns where the last of them ends.
    fn each_line(
        &self,
        mut read: impl FnMut(&str, u64, u64) -> Result<(), LineError>,
    ) -> Result<u64, SweepError> {
        let io = SweepError::io(&self.path);
        let mut file = &self.file;
        file.seek(SeekFrom::Start(0)).map_err(&io)?;
        let mut lines = BufReader::new(file);
        let (mut number, mut start) = (0, 0);
        let mut line = Vec::new();
        loop {
            line.clear();
            let bytes = lines.read_until(b'\n', &mut line).map_err(&io)?;
            if line.last() != Some(&b'\n') {
                return Ok(start);
            }
            number += 1;
            let text = std::str::from_utf8(&line).map_err(|e| e.to_string().into());
            text.and_then(|text| read(text.trim_end(), number, start))
                .map_err(|problem| problem.at(&self.path, number))?;
            start += bytes as u64;
        }
    }

    /// The variants that are done.
    pub fn done(&self) -> &Done {
        &self.done
    }

    /// How many of them failed.
    pub fn failed(&self) -> u64 {
        self.failed
    }

    /// Adds what came of a variant.
    ///
    /// # Errors
    /// [`SweepError::Io`] where there is no room; the journal is then as it was.
    pub fn add(&mut self, record: &Record) -> Result<(), SweepError> {
        self.append_line(record)?;
        self.done.insert(record.variant);
        self.failed += u64::from(record.error.is_some());
        Ok(())
    }

    fn append_line(&mut self, content: &impl Serialize) -> Result<(), SweepError> {
        let io = SweepError::io(&self.path);
        let mut line = serde_json::to_vec(content).map_err(|e| io(io::Error::other(e)))?;
        line.push(b'\n');
        if let Err(error) = self.file.write_all(&line) {
            // Half a line at the end would be taken away at the next start, too.
            let _ = self.file.set_len(self.length);
            let _ = self.file.seek(SeekFrom::Start(self.length));
            return Err(io(error));
        }
        self.length += line.len() as u64;
        Ok(())
    }

    /// Returns where the line of every variant begins; `None` for those that are not done.
    ///
    /// # Errors
    /// As [`Journal::open`].
    pub(crate) fn places(&self) -> Result<Vec<Option<u64>>, SweepError> {
        let mut places = vec![None; self.variants as usize];
        self.each_line(|line, number, start| {
            if number > 1 {
                let record: Record = serde_json::from_str(line).map_err(|e| e.to_string())?;
                places[record.variant as usize] = Some(start);
            }
            Ok(())
        })?;
        Ok(places)
    }

    /// Reads the record that begins at a place.
    ///
    /// # Errors
    /// As [`Journal::open`].
    pub(crate) fn at(&self, place: u64) -> Result<Record, SweepError> {
        let io = SweepError::io(&self.path);
        let mut file = &self.file;
        file.seek(SeekFrom::Start(place)).map_err(&io)?;
        let mut line = String::new();
        BufReader::with_capacity(1 << 10, file.take(self.length - place))
            .read_line(&mut line)
            .map_err(&io)?;
        serde_json::from_str(&line).map_err(|e| io(io::Error::other(e)))
    }
}

/// What is wrong with a line.
enum LineError {
    Text(String),
    Whole(SweepError),
}

impl From<String> for LineError {
    fn from(text: String) -> Self {
        LineError::Text(text)
    }
}

impl LineError {
    fn at(self, path: &Path, line: u64) -> SweepError {
        match self {
            LineError::Whole(error) => error,
            LineError::Text(problem) => SweepError::Journal {
                path: path.to_owned(),
                line,
                problem,
            },
        }
    }
}

/// Checks that a journal is that of this sweep.
fn check_heading(folder: &Path, line: &str, expected: &Heading) -> Result<(), LineError> {
    let found: Heading = serde_json::from_str(line).map_err(|e| e.to_string())?;
    let other = if found.version != expected.version {
        format!(
            "made by version {}, not {}",
            found.version, expected.version
        )
    } else if found.variants != expected.variants {
        format!("of {} variants, not {}", found.variants, expected.variants)
    } else if found.sweep != expected.sweep {
        "of as many variants, with other parameters".to_owned()
    } else {
        return Ok(());
    };
    Err(LineError::Whole(SweepError::Another {
        path: folder.to_owned(),
        found: other,
    }))
}
