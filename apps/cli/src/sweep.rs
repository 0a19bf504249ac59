//! `greenstick sweep`: the threads, the clock, and what is said of a sweep.

use crate::arguments::SweepOptions;
use crate::failure::{Failure, print};
use crate::outcome::spent;
use crate::progress::{Progress, StageTime};
use greenstick::files;
use greenstick::formats::Encoded;
use greenstick::geometry::Context;
use greenstick::schema::{Parameters, markdown_tables};
use greenstick_sweep::job::{SWEEP_FILE, TEMPLATE_FILE, template};
use greenstick_sweep::journal::{Done, Journal, Record};
use greenstick_sweep::sheet::write_sheet;
use greenstick_sweep::table::{TABLE_FILE, write_table};
use greenstick_sweep::variant::BendFile;
use greenstick_sweep::worker::remove_leftovers;
use greenstick_sweep::{Part, Sweep, SweepError, SweepSettings, Variant, Worker};
use serde::Serialize;
use std::io::{BufRead, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

/// Variants above which the user is asked first: about an hour of work, or a folder that is a nuisance to delete.
const MANY: u64 = 10_000;
/// How often Ctrl-C is looked for while variants are made.
const INTERVAL: Duration = Duration::from_millis(100);
/// Records that wait for the journal, at most.
const WAITING: usize = 256;

/// What came of a run.
#[derive(Serialize)]
struct Report {
    variants: u64,
    /// Of them, those that an earlier run made.
    found: u64,
    /// Those that this run made.
    made: u64,
    /// All that failed; their rows say why.
    failed: u64,
    /// None of a part.
    #[serde(skip_serializing_if = "Option::is_none")]
    table: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sheet: Option<String>,
    stages: Vec<StageTime>,
}

pub fn run(options: &SweepOptions) -> Result<ExitCode, Failure> {
    if options.markdown {
        print(&reference())?;
        return Ok(ExitCode::SUCCESS);
    }
    let Some(path) = &options.sweep else {
        return Err(Failure::request("no sweep is named").hint("such as sweep.toml"));
    };
    let sweep = read(path)?;
    if let Some(number) = options.show {
        return show(&sweep, number);
    }
    if let Some(folder) = &options.job {
        return write_job(&sweep, path, (folder, options.parts));
    }
    let Some(folder) = &options.output else {
        return Err(
            Failure::request("no folder is named for the results").hint("such as -o variants")
        );
    };
    let wanted = options
        .part
        .map_or(sweep.count(), |part| part.count(sweep.count()));
    if wanted > MANY && !options.yes {
        confirm(wanted, folder)?;
    }
    let mut journal = open(folder, &sweep, options.part)?;
    let found = journal.done().count();
    let progress = Progress::start(options.reporting.quiet);
    let [work, write] = progress.split([("variants", 100.0), ("table", 1.0)]);
    let threads = threads(options);
    let what = What {
        sweep: &sweep,
        folder,
        part: options.part,
        wanted,
    };
    let made = make(&what, &mut journal, threads, &work);
    let stopped = made.err();
    let stop = |error: SweepError| {
        let left = wanted - journal.done().count();
        Failure::from(error).or_cancelled(format!(
            "stopped; {left} of {wanted} variants are missing, and the same command goes on with them"
        ))
    };
    if let Some(error) = stopped {
        return Err(stop(error));
    }
    let (mut table, mut sheet) = (None, None);
    if options.part.is_none() {
        write_table(&sweep, &journal, folder, &write).map_err(stop)?;
        table = Some(folder.join(TABLE_FILE).display().to_string());
        sheet = write_sheet(&sweep, folder)?.map(|path| path.display().to_string());
    }
    let report = Report {
        variants: wanted,
        found,
        made: journal.done().count() - found,
        failed: journal.failed(),
        table,
        sheet,
        stages: progress.finish(),
    };
    if options.reporting.prints_report() {
        print(&format_report(&report, options.reporting.json)?)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Opens the journal of a sweep, which takes over what parts have made, or of a part.
fn open(folder: &Path, sweep: &Sweep, part: Option<Part>) -> Result<Journal, SweepError> {
    if let Some(part) = part {
        // Files that are not renamed yet may be those of other parts.
        return Journal::open_part(folder, sweep, part);
    }
    let mut journal = Journal::open(folder, sweep)?;
    journal.take_parts(folder, sweep)?;
    remove_leftovers(folder);
    Ok(journal)
}

/// Writes a job into a folder: its template and the sweep.
fn write_job(
    sweep: &Sweep,
    path: &Path,
    (folder, parts): (&Path, u64),
) -> Result<ExitCode, Failure> {
    if let Some(file) = sweep.relative_files().first() {
        return Err(Failure::request(format!(
            "{}: it names {file} beside it, which workers would not find",
            path.display()
        ))
        .hint("name it by the whole path that it has on the workers"));
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let text = files::read_text(path)?;
    let written = files::write_folder(
        folder,
        vec![
            Encoded::new(TEMPLATE_FILE, template(sweep, &name, parts)),
            Encoded::new(SWEEP_FILE, text),
        ],
    )?;
    for file in written {
        print(&format!("wrote    {}\n", file.path.display()))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The reference page of the table `[sweep]`.
fn reference() -> String {
    let tables = markdown_tables(&SweepSettings::table(), "##");
    let bending = markdown_tables(&BendFile::table(), "##");
    format!(
        "# Sweeps\n\nThe table `[sweep]` of a sweep; all else in it, by its kind, is a [recipe](parameters.md), the keys of a \
         [scene](scenes.md), or those of a bending test, below; and `[vary]`.\n{tables}\n{bending}"
    )
}

/// Reads a sweep file.
pub fn read(path: &Path) -> Result<Sweep, Failure> {
    let text = files::read_text(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    Sweep::read(&text, folder).map_err(|error| {
        Failure::from(error)
            .about(path)
            .hint("`greenstick sweep --help` shows a sweep, `greenstick parameters` lists keys, units and ranges")
    })
}

/// Prints what decides a variant: a recipe, a scene, or the keys of a bending test.
fn show(sweep: &Sweep, number: u64) -> Result<ExitCode, Failure> {
    let mut variant = sweep.variant(number)?.map_err(Failure::request)?;
    let input = sweep.input_path(&variant);
    if let (Variant::Break(file), Some(path)) = (&mut variant, input) {
        let path = std::path::absolute(path).map_err(Failure::work)?;
        file.input = Some(path.display().to_string());
    }
    print(&variant.to_toml())?;
    Ok(ExitCode::SUCCESS)
}

/// Asks whether so many variants are meant.
fn confirm(count: u64, folder: &Path) -> Result<(), Failure> {
    let refused = || {
        Failure::request(format!(
            "the sweep has {count} variants, which may be a mistake"
        ))
        .hint("--yes makes them without asking")
    };
    if !std::io::stdin().is_terminal() {
        return Err(refused());
    }
    let mut errors = std::io::stderr();
    let _ = write!(
        errors,
        "Make {count} variants in {}? [y/N] ",
        folder.display()
    );
    let _ = errors.flush();
    let mut answer = String::new();
    let read = std::io::stdin().lock().read_line(&mut answer);
    match read {
        Ok(_) if answer.trim().eq_ignore_ascii_case("y") => Ok(()),
        _ => Err(refused()),
    }
}

/// The threads that make variants.
fn threads(options: &SweepOptions) -> usize {
    let available = || thread::available_parallelism().map_or(1, usize::from);
    options
        .reporting
        .threads
        .map_or_else(available, usize::from)
}

/// What is made, and where.
struct What<'a> {
    sweep: &'a Sweep,
    folder: &'a Path,
    part: Option<Part>,
    /// How many variants that are.
    wanted: u64,
}

/// Makes all variants that are missing. Threads share the number of the next variant and a channel to the journal, nothing
/// else.
fn make(
    what: &What,
    journal: &mut Journal,
    threads: usize,
    context: &Context,
) -> Result<(), SweepError> {
    let done = journal.done().clone();
    let next = AtomicU64::new(0);
    let (sender, receiver) = sync_channel(WAITING);
    thread::scope(|scope| {
        for _ in 0..threads {
            let (sender, context, done, next) = (sender.clone(), context.silenced(), &done, &next);
            scope.spawn(move || {
                let numbers = || next.fetch_add(1, Ordering::Relaxed);
                work(what, numbers, done, &sender, &context);
            });
        }
        // The channel ends with the last thread.
        drop(sender);
        let kept = keep(&receiver, what.wanted, journal, context);
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

/// Makes variants until there are none left. The pool of one thread keeps the loops inside a break from competing with those
/// of other variants.
fn work(
    what: &What,
    mut numbers: impl FnMut() -> u64 + Send,
    done: &Done,
    sender: &SyncSender<Result<Record, SweepError>>,
    context: &Context,
) {
    let mut worker = Worker::new(what.sweep, what.folder);
    let mut all = || {
        loop {
            let number = numbers();
            if number >= what.sweep.count() {
                return;
            }
            if done.contains(number) || what.part.is_some_and(|part| !part.contains(number)) {
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
    };
    match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(all),
        Err(_) => all(),
    }
}

/// Puts what comes into the journal.
fn keep(
    receiver: &Receiver<Result<Record, SweepError>>,
    wanted: u64,
    journal: &mut Journal,
    context: &Context,
) -> Result<(), SweepError> {
    use std::sync::mpsc::RecvTimeoutError;
    loop {
        match receiver.recv_timeout(INTERVAL) {
            Ok(record) => journal.add(&record?)?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        context.report(journal.done().count() as f64 / wanted.max(1) as f64)?;
    }
}

fn format_report(report: &Report, json: bool) -> Result<String, Failure> {
    if json {
        return Ok(serde_json::to_string_pretty(report).map_err(Failure::work)? + "\n");
    }
    let mut text = format!("variants {}, {} made", report.variants, report.made);
    if report.found > 0 {
        text += &format!(", {} were there", report.found);
    }
    if report.failed > 0 {
        text += &format!(", {} failed (column error)", report.failed);
    }
    text += "\n";
    if let Some(table) = &report.table {
        text += &format!("wrote    {table}\n");
    }
    if let Some(sheet) = &report.sheet {
        text += &format!("wrote    {sheet}\n");
    }
    let total: f64 = report.stages.iter().map(|s| s.seconds).sum();
    Ok(text + &format!("time     {total:.2} s: {}\n", spent(&report.stages)))
}
