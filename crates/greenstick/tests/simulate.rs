//! A simulation that is stopped, or killed, and resumed ends in the same bytes; and what is refused.

use greenstick::fibre::scene::Scene;
use greenstick::geometry::{CancelToken, Context};
use greenstick::simulate::{Origin, SimulateError, SimulateRequest, frames, simulate};
use std::fs;
use std::path::{Path, PathBuf};

const SCENE: &str = "duration = 0.012\nframes_per_second = 250.0\nrows_per_second = 1000.0\n\
[stem]\nkind = \"cylinder\"\nlength = \"6 cm\"\ndiameter = \"6 mm\"\n\
[wood]\nstiffness = 0.002\n[rods]\nnumber = 12\nedge = [\"4 mm\", \"5 mm\"]\ntwist = \"off\"\nweibull = 5.0\n\
[[clamp]]\nto = 0.2\n\
[[body]]\nat = 0.9\ntouch = [0, 0, 1]\nvelocity = [0, 0, -1.5]\n\
[[body]]\nshape = \"sphere\"\ndiameter = \"1 cm\"\nat = 0.5\ntouch = [0, 0, -1]\ngap = \"1 mm\"\nmotion = \"free\"\nvelocity = [0, 0, 1]\n";

fn request(folder: &Path, resume: bool) -> SimulateRequest {
    SimulateRequest {
        scene: Scene::read(SCENE).unwrap(),
        origin: Origin::default(),
        folder: folder.to_owned(),
        resume,
    }
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("greenstick-{}-{name}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    folder
}

const FILES: [&str; 5] = [
    "energy.csv",
    "events.csv",
    "frames.gsf",
    "forces.csv",
    "checkpoint.bin",
];

fn bytes(folder: &Path) -> Vec<Vec<u8>> {
    FILES.map(|f| fs::read(folder.join(f)).unwrap()).to_vec()
}

#[test]
fn a_run_that_was_stopped_or_killed_ends_in_the_same_bytes() {
    let whole = folder("whole");
    let report = simulate(None, &request(&whole, false), &Context::quiet()).unwrap();
    assert!(
        report.broke[0] > 0,
        "the scene must break something: {report}"
    );
    assert_eq!((report.frames, frames(&whole).unwrap().len()), (4, 4));
    let parts = folder("parts");
    for stop in [2, 7, 10] {
        let token = CancelToken::default();
        let asking = token.clone();
        let context = Context::new(token, move |progress| {
            if progress.stage.name() == "simulate"
                && progress.of_stage * 12.0 > f64::from(stop) - 0.5
            {
                asking.cancel();
            }
        });
        let stopped = simulate(None, &request(&parts, stop > 2), &context);
        assert!(
            matches!(stopped, Err(SimulateError::Cancelled(_))),
            "{stopped:?}"
        );
        // A kill leaves rows and half a frame behind the checkpoint.
        for name in &FILES[..4] {
            let mut all = fs::read(parts.join(name)).unwrap();
            let torn = match name {
                &"frames.gsf" => all[16..46].to_vec(),
                _ => b"0.5,1,2,3".to_vec(),
            };
            all.extend(torn);
            fs::write(parts.join(name), all).unwrap();
        }
        frames(&parts).unwrap();
    }
    simulate(None, &request(&parts, true), &Context::quiet()).unwrap();
    assert!(bytes(&parts) == bytes(&whole));
    // Resuming what is done changes nothing.
    simulate(None, &request(&parts, true), &Context::quiet()).unwrap();
    assert!(bytes(&parts) == bytes(&whole));

    let taken = simulate(None, &request(&parts, false), &Context::quiet());
    assert!(
        matches!(taken, Err(SimulateError::Taken { .. })),
        "{taken:?}"
    );
    let mut other = request(&parts, true);
    other.scene.seed = 2;
    let foreign = simulate(None, &other, &Context::quiet());
    assert!(
        matches!(foreign, Err(SimulateError::OtherRun { .. })),
        "{foreign:?}"
    );
    let point = parts.join("checkpoint.bin");
    let good = fs::read(&point).unwrap();
    for (at, words) in [
        (8, "of version 255"),
        (200, "checksum is wrong"),
        (0, "no checkpoint"),
    ] {
        let mut bad = good.clone();
        bad[at] = 255;
        fs::write(&point, bad).unwrap();
        let told = simulate(None, &request(&parts, true), &Context::quiet())
            .unwrap_err()
            .to_string();
        assert!(told.contains(words), "{told}");
    }
    fs::write(&point, &good).unwrap();
    assert!(
        bytes(&parts) == bytes(&whole),
        "a refused checkpoint must cost nothing"
    );
    fs::write(parts.join("energy.csv"), "short").unwrap();
    let told = simulate(None, &request(&parts, true), &Context::quiet())
        .unwrap_err()
        .to_string();
    assert!(
        told.contains("has 5 bytes, but the checkpoint was written when it had"),
        "{told}"
    );
    let _ = fs::remove_dir_all(&whole);
    let _ = fs::remove_dir_all(&parts);
}

#[test]
fn a_step_that_is_not_stable_is_refused_with_the_limit() {
    let place = folder("unstable");
    let mut wrong = request(&place, false);
    wrong.scene.step = Some(0.01);
    let told = simulate(None, &wrong, &Context::quiet())
        .unwrap_err()
        .to_string();
    assert!(told.contains("is not stable: the limit is"), "{told}");
    let _ = fs::remove_dir_all(&place);
}

/// The column of a table, by name.
fn column(folder: &Path, table: &str, name: &str) -> Vec<f64> {
    let text = fs::read_to_string(folder.join(table)).unwrap();
    let mut lines = text.lines();
    let at = lines.next().unwrap().split(',').position(|n| n == name);
    let at = at.unwrap_or_else(|| panic!("no column {name}"));
    lines
        .map(|l| l.split(',').nth(at).unwrap().parse().unwrap())
        .collect()
}

#[test]
fn one_thread_and_two_write_the_same_bytes() {
    let [one, two] = [1, 2].map(|threads| {
        let place = folder(&format!("threads-{threads}"));
        let mut asked = request(&place, false);
        // Enough that the work is shared.
        asked.scene.rods.number = 120;
        asked.scene.duration = 0.004;
        asked.scene.wood.stiffness = 0.0005;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| simulate(None, &asked, &Context::quiet()))
            .unwrap();
        let all = bytes(&place);
        let _ = fs::remove_dir_all(&place);
        all
    });
    assert!(one == two);
}

#[test]
fn energy_is_kept_from_the_first_row_of_a_bent_start_to_the_last() {
    let place = folder("energy");
    let mut asked = request(&place, false);
    let text = "duration = 0.1\nstep = 3e-6\n[stem]\nkind = \"cylinder\"\nlength = \"6 cm\"\ndiameter = \"6 mm\"\n\
        [wood]\nstiffness = 0.002\n[rods]\nnumber = 12\nedge = [\"5 mm\", \"5 mm\"]\ntwist = \"off\"\n\
        [start]\nbend = 20.0\n[failure]\nrods = false\nyielding = false\nbonds = \"never\"\n\
        [contact]\nrods = false\n[loads]\ngravity = [0, 0, -9.81]\n";
    asked.scene = Scene::read(text).unwrap();
    let report = simulate(None, &asked, &Context::quiet()).unwrap();
    // It starts at rest, so its energy at the start is that of bending, and swings into motion and back.
    let kinetic = column(&place, "energy.csv", "kinetic_J");
    assert_eq!(kinetic[0], 0.0);
    assert!(
        report.energy.largest_j < 1e-3 * report.energy.most_j,
        "{report}"
    );
    // Falling freely, the work of the weight is what its energy loses.
    let (weight, work) = (
        column(&place, "energy.csv", "gravity_J"),
        column(&place, "energy.csv", "work_J"),
    );
    let fallen = weight[0] - weight.last().unwrap();
    assert!(fallen > 1e-4 && (work.last().unwrap() / fallen - 1.0).abs() < 1e-6);
    let _ = fs::remove_dir_all(&place);
}

#[test]
fn what_holds_the_wood_bears_its_weight_and_what_presses_it_is_borne() {
    // Held at both ends, let sink in strong damping: the clamps bear the weight, and the body on top pushes as much as
    // they bear more.
    let place = folder("forces");
    let mut asked = request(&place, false);
    let text = "duration = 0.3\nrows_per_second = 100.0\n[stem]\nkind = \"cylinder\"\nlength = \"6 cm\"\ndiameter = \"6 mm\"\n\
        [wood]\nstiffness = 0.002\n[rods]\nnumber = 12\nedge = [\"2.5 mm\", \"2.5 mm\"]\ntwist = \"off\"\n\
        [failure]\nrods = false\nyielding = false\nbonds = \"never\"\n[contact]\nrods = false\n\
        [loads]\ngravity = [0, 0, -9.81]\ndamping = 400.0\n[[clamp]]\nto = 0.1\n[[clamp]]\nfrom = 0.9\nto = 1.0\n\
        [[body]]\nname = \"press\"\nat = 0.5\ntouch = [0, 0, 1]\ngap = \"0.5 mm\"\n\
        [[body.key]]\ntime = 0.0\n[[body.key]]\ntime = 0.1\nmove_by = \"0, 0, -1.5 mm\"\n";
    asked.scene = Scene::read(text).unwrap();
    simulate(None, &asked, &Context::quiet()).unwrap();
    let force = column(&place, "forces.csv", "force_z_N");
    let rows: Vec<&[f64]> = force.chunks(3).collect();
    let weight = 9.81 * mass(&place);
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
    let book = |name| *column(&place, "energy.csv", name).last().unwrap();
    let start = column(&place, "energy.csv", "balance_J")[0];
    let (off, work) = (book("balance_J") - start, book("contact_work_J"));
    assert!(off.abs() < 0.02 * work, "{off} of {work}");
    let _ = fs::remove_dir_all(&place);
}

/// Mass of a run's rods, kg.
fn mass(folder: &Path) -> f64 {
    let point = fs::read(folder.join("checkpoint.bin")).unwrap();
    let (point, _) = greenstick::fibre::store::Checkpoint::from_bytes(&point).unwrap();
    point.world.bundle.mass.iter().sum()
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
    let torn = folder("torn");
    let of = |folder: &Path, duration: f64, resume: bool| {
        let mut request = request(folder, resume);
        request.scene = Scene::read(TORN).unwrap();
        request.scene.duration = duration;
        request
    };
    let failed = |resume: bool| {
        let failed = simulate(None, &of(&torn, 0.2, resume), &Context::quiet());
        let Err(SimulateError::Solver { checkpoint, .. }) = failed else {
            panic!("{failed:?}")
        };
        checkpoint
    };
    let checkpoint = failed(false);
    assert!((0.08..0.2).contains(&checkpoint), "{checkpoint}");
    let kept = fs::read(torn.join("checkpoint.bin")).unwrap();
    // It fails in the same way again, and costs nothing.
    assert_eq!(failed(true), checkpoint);
    assert!(fs::read(torn.join("checkpoint.bin")).unwrap() == kept);
    // As far as it went it is what a run is that ends there.
    simulate(None, &of(&torn, checkpoint, true), &Context::quiet()).unwrap();
    let short = folder("short");
    simulate(None, &of(&short, checkpoint, false), &Context::quiet()).unwrap();
    assert!(bytes(&torn) == bytes(&short));
    let _ = fs::remove_dir_all(&torn);
    let _ = fs::remove_dir_all(&short);
}
