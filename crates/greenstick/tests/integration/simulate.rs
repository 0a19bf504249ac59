//! Simulations in folders and in memory: what is stopped, or killed, and resumed ends in the same bytes; what is refused;
//! and what the tables say.

use greenstick::fibre::EventKind;
use greenstick::fibre::scene::{Scene, SolverChoice};
use greenstick::files::run::{Origin, RunFolder};
use greenstick::geometry::{CancelToken, Context};
use greenstick::simulate::{
    MemoryRun, RunSource, SimulateError, SimulateReport, SimulateRequest, simulate,
};
use std::fs;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

const SCENE: &str = "duration = 0.012\nframes_per_second = 250.0\nrows_per_second = 1000.0\n\
[stem]\nkind = \"cylinder\"\nlength = \"6 cm\"\ndiameter = \"6 mm\"\n\
[wood]\nstiffness = 0.002\n[rods]\nnumber = 12\nedge = [\"4 mm\", \"5 mm\"]\ntwist = \"off\"\nweibull = 5.0\n\
[[clamp]]\nto = 0.2\n\
[[body]]\nat = 0.9\ntouch = [0, 0, 1]\nvelocity = [0, 0, -1.5]\n\
[[body]]\nshape = \"sphere\"\ndiameter = \"1 cm\"\nat = 0.5\ntouch = [0, 0, -1]\ngap = \"1 mm\"\nmotion = \"free\"\nvelocity = [0, 0, 1]\n";

fn request(scene: &str, resume: bool) -> SimulateRequest {
    SimulateRequest {
        scene: Scene::read(scene).unwrap(),
        resume,
        ..SimulateRequest::default()
    }
}

/// A folder that is removed with its content when it is dropped.
struct TemporaryFolder(PathBuf);

impl TemporaryFolder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("greenstick-{}-{name}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        TemporaryFolder(path)
    }

    fn run(&self) -> RunFolder {
        RunFolder::new(&self.0, Origin::default())
    }

    fn simulate(&self, request: &SimulateRequest) -> Result<SimulateReport, SimulateError> {
        simulate(request, &mut self.run(), &Context::quiet())
    }

    /// Returns the bytes of all files that a resumed run must end in again.
    fn bytes(&self) -> Vec<Vec<u8>> {
        FILES
            .map(|name| fs::read(self.0.join(name)).unwrap())
            .to_vec()
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

const FILES: [&str; 5] = [
    "energy.csv",
    "events.csv",
    "frames.gsf",
    "forces.csv",
    "checkpoint.bin",
];

/// Returns a context that cancels itself in the tick before `tick`, of 12.
fn cancelled_at_tick(tick: u32) -> Context {
    let token = CancelToken::default();
    let cancelling = token.clone();
    Context::new(token, move |progress| {
        if progress.stage.name() == "simulate" && progress.of_stage * 12.0 > f64::from(tick) - 0.5 {
            cancelling.cancel();
        }
    })
}

/// Adds what a killed run leaves behind its checkpoint: incomplete rows and half a frame.
fn append_incomplete_records(folder: &Path) {
    for name in &FILES[..4] {
        let mut all = fs::read(folder.join(name)).unwrap();
        let incomplete = match name {
            &"frames.gsf" => all[16..46].to_vec(),
            _ => b"0.5,1,2,3".to_vec(),
        };
        all.extend(incomplete);
        fs::write(folder.join(name), all).unwrap();
    }
}

#[test]
fn a_run_that_was_stopped_or_killed_ends_in_the_same_bytes() {
    let whole = TemporaryFolder::new("whole");
    let report = whole.simulate(&request(SCENE, false)).unwrap();
    assert!(
        report.broke[0] > 0,
        "the scene must break something: {report}"
    );
    let frames = whole.run().frames().unwrap();
    assert_eq!((report.frames, frames.count()), (4, 4));
    let parts = TemporaryFolder::new("parts");
    for tick in [2, 7, 10] {
        let request = request(SCENE, tick > 2);
        let stopped = simulate(&request, &mut parts.run(), &cancelled_at_tick(tick));
        assert!(
            matches!(stopped, Err(SimulateError::Cancelled(_))),
            "{stopped:?}"
        );
        append_incomplete_records(&parts.0);
        parts.run().frames().unwrap();
    }
    parts.simulate(&request(SCENE, true)).unwrap();
    assert!(parts.bytes() == whole.bytes());
    // Resuming what is done changes nothing.
    parts.simulate(&request(SCENE, true)).unwrap();
    assert!(parts.bytes() == whole.bytes());
}

#[test]
fn slow_motion_has_more_frames_while_rods_break_and_can_be_resumed() {
    const SLOW: f64 = 20.0;
    let mut asked = request(SCENE, false);
    asked.scene.slow = SLOW;
    let mut whole = MemoryRun::new();
    simulate(&asked, &mut whole, &Context::quiet()).unwrap();
    let times = whole.frames().unwrap().times;
    let broke: Vec<f64> = (whole.events().unwrap().iter())
        .filter(|e| e.kind == EventKind::RodBroke)
        .map(|e| e.time)
        .collect();
    assert!(!broke.is_empty());
    // At its own pace where nothing breaks, and slowly wherever a rod does.
    let longest = times.windows(2).map(|t| t[1] - t[0]).fold(0.0, f64::max);
    assert!((longest - 0.004).abs() < 1e-9, "{times:?}");
    for time in broke {
        let after = times.partition_point(|&t| t < time);
        let interval = times[after] - times[after - 1];
        assert!((interval * 250.0 * SLOW - 1.0).abs() < 0.05, "{interval}");
    }
    let mut parts = MemoryRun::new();
    for tick in [2, 7, 10] {
        asked.resume = tick > 2;
        let stopped = simulate(&asked, &mut parts, &cancelled_at_tick(tick));
        assert!(matches!(stopped, Err(SimulateError::Cancelled(_))));
    }
    asked.resume = true;
    simulate(&asked, &mut parts, &Context::quiet()).unwrap();
    assert_eq!(whole.frames().unwrap(), parts.frames().unwrap());
    assert_eq!(whole.energies().unwrap(), parts.energies().unwrap());
    for number in 0..whole.frames().unwrap().count() {
        assert_eq!(whole.frame(number).unwrap(), parts.frame(number).unwrap());
    }
}

#[test]
fn what_is_no_run_of_this_scene_is_refused_and_stays_as_it_is() {
    let place = TemporaryFolder::new("refused");
    let mut asked = request(SCENE, false);
    asked.scene.duration = 0.001;
    let nothing = place.simulate(&SimulateRequest {
        resume: true,
        ..asked.clone()
    });
    assert!(
        matches!(nothing, Err(SimulateError::NothingToResume { .. })),
        "{nothing:?}"
    );
    place.simulate(&asked).unwrap();
    let before = place.bytes();
    let taken = place.simulate(&asked);
    assert!(
        matches!(taken, Err(SimulateError::Taken { .. })),
        "{taken:?}"
    );
    asked.resume = true;
    let mut other = asked.clone();
    other.scene.seed = 2;
    let foreign = place.simulate(&other);
    assert!(
        matches!(foreign, Err(SimulateError::OtherRun { .. })),
        "{foreign:?}"
    );
    let message = || place.simulate(&asked).unwrap_err().to_string();
    let checkpoint = place.0.join("checkpoint.bin");
    let good = fs::read(&checkpoint).unwrap();
    for (at, words) in [
        (8, "of version 255"),
        (200, "checksum is wrong"),
        (0, "no checkpoint"),
    ] {
        let mut bad = good.clone();
        bad[at] = 255;
        fs::write(&checkpoint, bad).unwrap();
        assert!(message().contains(words), "{}", message());
    }
    fs::write(&checkpoint, &good).unwrap();
    assert!(place.bytes() == before);
    fs::write(place.0.join("energy.csv"), "short").unwrap();
    let words = "has 5 bytes, but the checkpoint was written when it had";
    assert!(message().contains(words), "{}", message());
}

#[test]
fn a_run_in_memory_records_what_a_folder_holds() {
    let place = TemporaryFolder::new("beside-memory");
    let in_folder = place.simulate(&request(SCENE, false)).unwrap();
    let folder = place.run();
    let mut memory = MemoryRun::new();
    let stopped = simulate(&request(SCENE, false), &mut memory, &cancelled_at_tick(7));
    assert!(
        matches!(stopped, Err(SimulateError::Cancelled(_))),
        "{stopped:?}"
    );
    let resumed = request(SCENE, true);
    let in_memory = simulate(&resumed, &mut memory, &Context::quiet()).unwrap();
    assert_eq!(
        SimulateReport {
            files: Vec::new(),
            ..in_folder
        },
        in_memory
    );
    assert_eq!(folder.scene().unwrap(), memory.scene().unwrap());
    assert_eq!(folder.energies().unwrap(), memory.energies().unwrap());
    assert_eq!(folder.events().unwrap(), memory.events().unwrap());
    assert_eq!(folder.forces().unwrap(), memory.forces().unwrap());
    assert_eq!(folder.frames().unwrap(), memory.frames().unwrap());
    for number in 0..memory.frames().unwrap().count() {
        assert_eq!(folder.frame(number).unwrap(), memory.frame(number).unwrap());
    }
    let beyond = folder.frame(4).unwrap_err().to_string();
    assert_eq!(beyond, memory.frame(4).unwrap_err().to_string());
    let taken = simulate(&request(SCENE, false), &mut memory, &Context::quiet());
    assert!(
        matches!(taken, Err(SimulateError::Taken { .. })),
        "{taken:?}"
    );
}

#[test]
fn a_step_that_is_not_stable_is_refused_with_the_limit() {
    let mut wrong = request(SCENE, false);
    wrong.scene.step = Some(0.01);
    let message = simulate(&wrong, &mut MemoryRun::new(), &Context::quiet())
        .unwrap_err()
        .to_string();
    assert!(message.contains("is not stable: the limit is"), "{message}");
}

#[test]
fn one_thread_and_two_write_the_same_bytes() {
    let [one, two] = [1, 2].map(|threads| {
        let place = TemporaryFolder::new(&format!("threads-{threads}"));
        let mut asked = request(SCENE, false);
        // Enough that the work is shared.
        asked.scene.rods.number = 120;
        asked.scene.duration = 0.004;
        asked.scene.wood.stiffness = 0.0005;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| place.simulate(&asked)).unwrap();
        place.bytes()
    });
    assert!(one == two);
}

#[test]
fn energy_is_conserved_from_the_first_row_of_a_bent_start_to_the_last() {
    let scene = "duration = 0.1\nstep = 3e-6\n[stem]\nkind = \"cylinder\"\nlength = \"6 cm\"\ndiameter = \"6 mm\"\n\
        [wood]\nstiffness = 0.002\n[rods]\nnumber = 12\nedge = [\"5 mm\", \"5 mm\"]\ntwist = \"off\"\n\
        [start]\nbend = 20.0\n[failure]\nrods = false\nyielding = false\nbonds = \"never\"\n\
        [contact]\nrods = false\n[loads]\ngravity = [0, 0, -9.81]\n";
    let mut run = MemoryRun::new();
    let report = simulate(&request(scene, false), &mut run, &Context::quiet()).unwrap();
    let rows = run.energies().unwrap();
    // It starts at rest, so its energy at the start is that of bending, and swings into motion and back.
    assert_eq!(rows[0].rods.kinetic, 0.0);
    assert!(
        report.energy.largest_j < 1e-3 * report.energy.most_j,
        "{report}"
    );
    // Falling freely, the work of the weight is what its energy loses.
    let last = rows.last().unwrap();
    let fallen = rows[0].gravity - last.gravity;
    assert!(fallen > 1e-4 && (last.ledger.work / fallen - 1.0).abs() < 1e-6);
}

#[test]
fn what_holds_the_wood_bears_its_weight_and_what_presses_it_is_borne() {
    // Held at both ends, let sink in strong damping: the clamps bear the weight, and the body on top pushes as much as
    // they bear more.
    let scene = "duration = 0.3\nrows_per_second = 100.0\n[stem]\nkind = \"cylinder\"\nlength = \"6 cm\"\ndiameter = \"6 mm\"\n\
        [wood]\nstiffness = 0.002\n[rods]\nnumber = 12\nedge = [\"2.5 mm\", \"2.5 mm\"]\ntwist = \"off\"\n\
        [failure]\nrods = false\nyielding = false\nbonds = \"never\"\n[contact]\nrods = false\n\
        [loads]\ngravity = [0, 0, -9.81]\ndamping = 400.0\n[[clamp]]\nto = 0.1\n[[clamp]]\nfrom = 0.9\nto = 1.0\n\
        [[body]]\nname = \"press\"\nat = 0.5\ntouch = [0, 0, 1]\ngap = \"0.5 mm\"\n\
        [[body.key]]\ntime = 0.0\n[[body.key]]\ntime = 0.1\nmove_by = \"0, 0, -1.5 mm\"\n";
    let mut run = MemoryRun::new();
    simulate(&request(scene, false), &mut run, &Context::quiet()).unwrap();
    let force: Vec<f64> = run.forces().unwrap().iter().map(|r| r.force.z).collect();
    let rows: Vec<&[f64]> = force.chunks(3).collect();
    let world = run.checkpoint().unwrap().unwrap().world;
    let weight = 9.81 * world.bundle.mass.iter().sum::<f64>();
    // Before it is pressed, and at rest under the press.
    let free = rows[1];
    assert!(
        (free[0] + free[1]).abs() < 2.0 * weight && free[2] == 0.0,
        "{free:?} {weight}"
    );
    let last = rows[rows.len() - 1];
    let sum: f64 = last.iter().sum();
    assert!(last[2] < -10.0 * weight, "{last:?} {weight}");
    assert!(
        (sum - weight).abs() < 0.02 * last[2].abs(),
        "{last:?} {weight}"
    );
    assert!((last[0] / last[1] - 1.0).abs() < 0.2, "{last:?}");
    // The press's work is stored, damped or rubbed off, and nothing else.
    let energies = run.energies().unwrap();
    let end = energies.last().unwrap();
    let (off, work) = (end.balance() - energies[0].balance(), end.contact_work);
    assert!(off.abs() < 0.02 * work, "{off} of {work}");
}

/// A stick that is drawn slowly, and from 0.1 s on by 100 m in a step.
const TORN: &str = "duration = 0.2\nframes_per_second = 50.0\nsolver = \"implicit\"\nstep = 0.02\n\
[stem]\nkind = \"cylinder\"\nlength = \"6 cm\"\ndiameter = \"6 mm\"\n\
[rods]\nnumber = 8\nedge = [\"4 mm\", \"5 mm\"]\ntwist = \"off\"\nweibull = 5.0\n\
[[clamp]]\nto = 0.2\n\
[[clamp]]\nfrom = 0.8\nto = 1.0\n\
[[clamp.key]]\ntime = 0.0\n[[clamp.key]]\ntime = 0.1\nmove_by = \"0.2, 0, 0 mm\"\n\
[[clamp.key]]\ntime = 0.12\nmove_by = \"0, 100, 0 m\"\nturn = [0, 0, 170]\n";

#[test]
fn what_was_before_a_step_that_fails_while_it_breaks_is_kept_and_can_be_resumed() {
    let torn = TemporaryFolder::new("torn");
    let of = |duration: f64, resume: bool| {
        let mut request = request(TORN, resume);
        request.scene.duration = duration;
        request
    };
    let failed = |resume: bool| {
        let failed = torn.simulate(&of(0.2, resume));
        let Err(SimulateError::Solver { checkpoint, .. }) = failed else {
            panic!("{failed:?}")
        };
        checkpoint
    };
    let checkpoint = failed(false);
    assert!((0.08..0.2).contains(&checkpoint), "{checkpoint}");
    let kept = fs::read(torn.0.join("checkpoint.bin")).unwrap();
    // It fails in the same way again, and costs nothing.
    assert_eq!(failed(true), checkpoint);
    assert!(fs::read(torn.0.join("checkpoint.bin")).unwrap() == kept);
    // As far as it went it is what a run is that ends there.
    torn.simulate(&of(checkpoint, true)).unwrap();
    let short = TemporaryFolder::new("short");
    short.simulate(&of(checkpoint, false)).unwrap();
    assert!(torn.bytes() == short.bytes());
}

/// Runs a scene on a thread of its own and cancels it after `wait`. Returns whether that was before its end.
fn cancel_from_outside(request: &SimulateRequest, store: &mut MemoryRun, wait: Duration) -> bool {
    let token = CancelToken::default();
    let context = Context::silent(token.clone());
    let result = thread::scope(|scope| {
        let worker = scope.spawn(|| simulate(request, store, &context));
        thread::sleep(wait);
        token.cancel();
        worker.join().unwrap()
    });
    match result {
        Err(SimulateError::Cancelled(_)) => true,
        other => {
            other.unwrap();
            false
        }
    }
}

#[test]
fn a_run_that_another_thread_cancels_anywhere_is_resumed_to_the_same_records() {
    for solver in [SolverChoice::Explicit, SolverChoice::QuasiStatic] {
        let mut asked = request(TORN, false);
        (asked.scene.solver, asked.scene.step) = (solver, None);
        asked.scene.duration = 0.1;
        if solver == SolverChoice::Explicit {
            asked.scene.duration = 0.02;
        }
        let mut whole = MemoryRun::new();
        simulate(&asked, &mut whole, &Context::quiet()).unwrap();
        let mut parts = MemoryRun::new();
        let mut wait = Duration::from_millis(30);
        let mut cancelled = 0;
        while cancel_from_outside(&asked, &mut parts, wait) {
            cancelled += 1;
            wait *= 2;
            // Cancelled before there was a checkpoint, it begins anew.
            asked.resume = parts.checkpoint().unwrap().is_some();
        }
        assert!(cancelled > 0);
        assert_eq!(whole.energies().unwrap(), parts.energies().unwrap());
        assert_eq!(whole.events().unwrap(), parts.events().unwrap());
        assert_eq!(whole.forces().unwrap(), parts.forces().unwrap());
        let frames = whole.frames().unwrap();
        assert_eq!(frames, parts.frames().unwrap());
        for number in 0..frames.count() {
            assert_eq!(whole.frame(number).unwrap(), parts.frame(number).unwrap());
        }
        assert!(whole.checkpoint().unwrap() == parts.checkpoint().unwrap());
    }
}
