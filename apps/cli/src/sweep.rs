//! `greenstick sweep`: how many threads make a sweep, and what is said of it.

use crate::arguments::SweepOptions;
use crate::failure::{Failure, print};
use crate::outcome::spent;
use crate::progress::{Progress, StageTime};
use greenstick::files;
use greenstick::formats::Encoded;
use greenstick::schema::{Parameters, markdown_tables};
use greenstick_sweep::job::{SWEEP_FILE, TEMPLATE_FILE, template};
use greenstick_sweep::variant::BendFile;
use greenstick_sweep::{Run, Sweep, SweepError, SweepSettings, Variant};
use serde::Serialize;
use std::io::{BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;

/// Variants above which the user is asked first: about an hour of work, or a folder that is a nuisance to delete.
const MANY: u64 = 10_000;

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
    /// Of a forest.
    #[serde(skip_serializing_if = "Option::is_none")]
    scene: Option<String>,
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
    let run = Run {
        sweep: &sweep,
        folder,
        part: options.part,
        threads: threads(options),
        alone: &in_one_thread,
    };
    let wanted = run.wanted();
    if wanted > MANY && !options.yes {
        confirm(wanted, folder)?;
    }
    let mut journal = run.journal()?;
    let found = journal.done().count();
    let progress = Progress::start(options.reporting.quiet);
    let [work, write] = progress.split([("variants", 100.0), ("table", 1.0)]);
    let stopped = run.make(&mut journal, &work).err();
    let stop = |error: SweepError| {
        let left = wanted - journal.done().count();
        Failure::from(error).or_cancelled(format!(
            "stopped; {left} of {wanted} variants are missing, and the same command goes on with them"
        ))
    };
    if let Some(error) = stopped {
        return Err(stop(error));
    }
    let overview = match options.part {
        None => Some(run.overview(&journal, &write).map_err(stop)?),
        Some(_) => None,
    };
    let (table, sheet, scene) =
        overview.map_or((None, None, None), |o| (Some(o.table), o.sheet, o.scene));
    let name = |path: Option<PathBuf>| path.map(|path| path.display().to_string());
    let report = Report {
        variants: wanted,
        found,
        made: journal.done().count() - found,
        failed: journal.failed(),
        table: name(table),
        sheet: name(sheet),
        scene: name(scene),
        stages: progress.finish(),
    };
    if options.reporting.prints_report() {
        print(&format_report(&report, options.reporting.json)?)?;
    }
    Ok(ExitCode::SUCCESS)
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
    if let Some(forest) = sweep.forest() {
        // A recipe breaks whole files; this one says which tree it is of.
        print(&format!("# {}\n", forest.trees()[number as usize].name))?;
    } else if let (Variant::Break(file), Some(path)) = (&mut variant, input) {
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

/// Calls something in a pool of one thread, in which the loops inside a break do not compete with those of other variants.
fn in_one_thread(call: &mut (dyn FnMut() + Send)) {
    match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(call),
        Err(_) => call(),
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
    for file in [&report.table, &report.sheet, &report.scene]
        .into_iter()
        .flatten()
    {
        text += &format!("wrote    {file}\n");
    }
    let total: f64 = report.stages.iter().map(|s| s.seconds).sum();
    Ok(text + &format!("time     {total:.2} s: {}\n", spent(&report.stages)))
}
