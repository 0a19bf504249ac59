//! Making what is missing of a sweep by several threads, which share the number of the next variant and a channel to the journal,
//! nothing else.

use crate::error::SweepError;
use crate::forest_scene::write_scene;
use crate::journal::{Done, Journal, Record};
use crate::part::Part;
use crate::plan::Sweep;
use crate::sheet::write_sheet;
use crate::table::{TABLE_FILE, write_table};
use crate::worker::{Worker, remove_leftovers};
use greenstick::geometry::Context;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// How often cancelling is looked for while variants are made.
const INTERVAL: Duration = Duration::from_millis(100);
/// Records that wait for the journal, at most.
const WAITING: usize = 256;

/// Calls what it is given so that the loops inside of a variant run on the calling thread alone, such as in a pool of one thread.
pub type Alone<'a> = dyn Fn(&mut (dyn FnMut() + Send)) + Sync + 'a;

/// A sweep, or a part of it, that is made in a folder.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// The sweep.
    pub sweep: &'a Sweep,
    /// The folder of all that is written.
    pub folder: &'a Path,
    /// The part that is made; `None` for all.
    pub part: Option<Part>,
    /// Threads that make variants, at least 1.
    pub threads: usize,
    /// What keeps the loops inside of a variant from competing with those of other variants.
    pub alone: &'a Alone<'a>,
}

/// The files that tell of a whole sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Overview {
    /// The table of all variants.
    pub table: PathBuf,
    /// The contact sheet, if there is one.
    pub sheet: Option<PathBuf>,
    /// The scene of a forest, if there is one.
    pub scene: Option<PathBuf>,
}

impl Run<'_> {
    /// How many variants are asked for.
    pub fn wanted(&self) -> u64 {
        let all = self.sweep.count();
        self.part.map_or(all, |part| part.count(all))
    }

    /// Opens the journal: of a sweep, which takes over what parts have made, or of a part.
    ///
    /// # Errors
    /// As [`Journal::open`].
    pub fn journal(&self) -> Result<Journal, SweepError> {
        if let Some(part) = self.part {
            // Files that are not renamed yet may be those of other parts.
            return Journal::open_part(self.folder, self.sweep, part);
        }
        let mut journal = Journal::open(self.folder, self.sweep)?;
        journal.take_parts(self.folder, self.sweep)?;
        remove_leftovers(self.folder);
        Ok(journal)
    }

    /// Makes all variants that are missing in the journal. A variant that cannot be made has a record that says why.
    ///
    /// # Errors
    /// [`SweepError`] where the sweep cannot go on: a file cannot be written, or the caller cancelled. What was made is in the
    /// journal.
    pub fn make(&self, journal: &mut Journal, context: &Context) -> Result<(), SweepError> {
        let done = journal.done().clone();
        let next = AtomicU64::new(0);
        let (sender, receiver) = sync_channel(WAITING);
        thread::scope(|scope| {
            for _ in 0..self.threads.max(1) {
                let (sender, context, done, next) =
                    (sender.clone(), context.silenced(), &done, &next);
                scope.spawn(move || {
                    (self.alone)(&mut || self.work(next, done, &sender, &context));
                });
            }
            // The channel ends with the last thread.
            drop(sender);
            let kept = self.keep(&receiver, journal, context);
            if kept.is_err() {
                context.cancel_token().cancel();
                // Threads that wait to send must not wait for ever; what they have made is kept where that is possible.
                for record in receiver.into_iter().flatten() {
                    let _ = journal.add(&record);
                }
            }
            kept
        })
    }

    /// Writes the table and the contact sheet of a whole sweep, and the scene of a forest.
    ///
    /// # Errors
    /// [`SweepError`] where a file cannot be written, or the caller cancelled.
    pub fn overview(&self, journal: &Journal, context: &Context) -> Result<Overview, SweepError> {
        write_table(self.sweep, journal, self.folder, context)?;
        Ok(Overview {
            table: self.folder.join(TABLE_FILE),
            sheet: write_sheet(self.sweep, self.folder)?,
            scene: write_scene(self.sweep, journal, self.folder, context)?,
        })
    }

    /// Makes variants until there are none left.
    fn work(
        &self,
        next: &AtomicU64,
        done: &Done,
        sender: &SyncSender<Result<Record, SweepError>>,
        context: &Context,
    ) {
        let mut worker = Worker::new(self.sweep, self.folder);
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= self.sweep.count() {
                return;
            }
            if done.contains(number) || self.part.is_some_and(|part| !part.contains(number)) {
                continue;
            }
            let start = Instant::now();
            let made = worker.make(number, context).map(|record| Record {
                seconds: start.elapsed().as_secs_f64(),
                ..record
            });
            let goes_on = made.is_ok();
            if sender.send(made).is_err() || !goes_on {
                return;
            }
        }
    }

    /// Puts what comes into the journal.
    fn keep(
        &self,
        receiver: &Receiver<Result<Record, SweepError>>,
        journal: &mut Journal,
        context: &Context,
    ) -> Result<(), SweepError> {
        let wanted = self.wanted().max(1) as f64;
        loop {
            match receiver.recv_timeout(INTERVAL) {
                Ok(record) => journal.add(&record?)?,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            context.report(journal.done().count() as f64 / wanted)?;
        }
    }
}
