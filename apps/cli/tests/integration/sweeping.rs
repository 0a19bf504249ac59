//! `greenstick sweep`: the same as by hand, resumed wherever it was killed, one failure no end.

use crate::support::Folder;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A sweep of small breaks without textures.
const SMALL: &str = "
species = 'white oak'
[sweep]
textures = false
sheet = 0
[break]
rings = 6
sectors = 12
[vary]
seed = { from = 1, to = 40 }
";

/// What varies in it.
const SEEDS: &str = "seed = { from = 1, to = 40 }";

/// The lines of a journal after the first, by variant.
fn records(folder: &Folder, name: &str) -> BTreeMap<u64, Vec<Value>> {
    let text = fs::read_to_string(folder.0.join(name).join("journal.jsonl")).unwrap();
    let mut records: BTreeMap<u64, Vec<Value>> = BTreeMap::new();
    for line in text.lines().skip(1) {
        let record: Value = serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"));
        let number = record["variant"].as_u64().unwrap();
        records.entry(number).or_default().push(record);
    }
    records
}

/// The bytes of all pieces.
fn pieces(folder: &Folder, name: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let variants = folder.0.join(name).join("variants");
    let mut found = BTreeMap::new();
    for part in fs::read_dir(variants).unwrap() {
        for file in fs::read_dir(part.unwrap().path()).unwrap() {
            let path = file.unwrap().path();
            let inside = path.strip_prefix(folder.0.join(name)).unwrap().to_owned();
            found.insert(inside, fs::read(&path).unwrap());
        }
    }
    found
}

#[test]
fn a_killed_sweep_goes_on_with_what_is_missing_and_nothing_twice() {
    let folder = Folder::new();
    fs::write(folder.0.join("s.toml"), SMALL).unwrap();
    let whole = folder.run(&["sweep", "s.toml", "-o", "whole", "--quiet"]);
    assert_eq!((whole.code, whole.err.as_str()), (0, ""));
    let mut before = 0;
    for wanted in [3, 11, 20] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_greenstick"))
            .args([
                "sweep",
                "s.toml",
                "-o",
                "killed",
                "--quiet",
                "--threads",
                "2",
            ])
            .current_dir(&folder.0)
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let start = Instant::now();
        let journal = folder.0.join("killed/journal.jsonl");
        let lines = || fs::read_to_string(&journal).map_or(0, |text| text.lines().count());
        while lines() < wanted && start.elapsed() < Duration::from_secs(120) {
            sleep(Duration::from_millis(2));
        }
        // SIGKILL: the program can do nothing about it.
        child.kill().unwrap();
        child.wait().unwrap();
        // What a machine that lost power may leave: half a line.
        let mut text = fs::read(&journal).unwrap();
        text.extend(b"{\"variant\":39,\"seco");
        fs::write(&journal, text).unwrap();
        assert!(lines() > before, "{before} lines, then {}", lines());
        before = lines() - 1;
    }
    let rest = folder.run(&["sweep", "s.toml", "-o", "killed", "--json"]);
    assert_eq!(rest.code, 0, "{}", rest.err);
    let report: Value = serde_json::from_str(&rest.out).unwrap();
    assert_eq!(report["variants"], 40);
    let (found, made) = (report["found"].as_u64(), report["made"].as_u64());
    assert!(
        found.unwrap() >= 19 && found.unwrap() + made.unwrap() == 40,
        "{report}"
    );
    let records = records(&folder, "killed");
    assert_eq!(records.len(), 40);
    assert!(records.values().all(|lines| lines.len() == 1));
    let (killed, whole) = (pieces(&folder, "killed"), pieces(&folder, "whole"));
    assert!(killed.keys().eq(whole.keys()), "{:?}", killed.keys());
    assert!(killed == whole, "pieces differ");
    let again = folder.run(&["sweep", "s.toml", "-o", "killed"]);
    assert!(
        again
            .out
            .starts_with("variants 40, 0 made, 40 were there\n"),
        "{}",
        again.out
    );
}

#[test]
fn a_variant_is_the_break_of_its_recipe() {
    let folder = Folder::new();
    let text = SMALL.replace("textures = false", "samples = 3").replace(
        SEEDS,
        "high.height = { between = [0.5, 2] }\nspecies = ['white oak', 'Norway spruce']",
    );
    fs::write(
        folder.0.join("s.toml"),
        format!("texture_size = 64\n{text}"),
    )
    .unwrap();
    let run = folder.run(&["sweep", "s.toml", "-o", "d", "--threads", "3"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    for number in [0, 4] {
        let shown = folder.run(&["sweep", "s.toml", "--show", &number.to_string()]);
        fs::write(folder.0.join("v.toml"), &shown.out).unwrap();
        let by_hand = folder.run(&["break", "--recipe", "v.toml", "-o", "v.glb", "--quiet"]);
        assert_eq!(by_hand.code, 0, "{}", by_hand.err);
        let name = format!("d/variants/0000/{number:07}.glb");
        assert!(
            folder.read("v.glb") == folder.read(&name),
            "variant {number}"
        );
    }
}

#[test]
fn a_variant_that_fails_is_a_row_and_the_rest_is_made() {
    let folder = Folder::new();
    let text = SMALL.replace(SEEDS, "at = [0.5, '7 m', 0.4]");
    fs::write(
        folder.0.join("s.toml"),
        text.replace("sheet = 0", "sheet = 3"),
    )
    .unwrap();
    let run = folder.run(&["sweep", "s.toml", "-o", "d"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    assert!(
        run.out
            .starts_with("variants 3, 3 made, 1 failed (column error)\n"),
        "{}",
        run.out
    );
    let records = records(&folder, "d");
    let error = records[&1][0]["error"].as_str().unwrap();
    assert!(
        error.starts_with("place 7.0000m is off the stem"),
        "{error}"
    );
    assert!(records[&0][0].get("error").is_none() && records[&2][0]["figures"]["closed"] == true);
    assert!(!folder.0.join("d/variants/0000/0000001.glb").exists());
    assert!(folder.read("d/variants.parquet").starts_with(b"PAR1"));
    assert!(folder.read("d/sheet.png").starts_with(b"\x89PNG"));
}

/// Asserts that a sweep is refused with a message.
fn assert_refused(folder: &Folder, text: &str, arguments: &[&str], message: &str) {
    folder.write("refused.toml", text);
    let run = folder.run(&[&["sweep", "refused.toml"], arguments].concat());
    assert_eq!(run.code, 2, "{}", run.err);
    assert!(run.err.contains(message), "{message}: {}", run.err);
}

#[test]
fn what_is_wrong_is_said_before_anything_is_made() {
    let folder = Folder::new();
    for (line, message) in [
        (
            "sed = [1]",
            "[vary] sed: unknown parameter \"sed\"; did you mean \"seed\"",
        ),
        (
            "moisture = [12, -1]",
            "[vary] moisture: moisture is -1, but it must be",
        ),
        ("moisture = { between = [12] }", "expected from and to"),
        (
            "moisture = { from = 12, to = 3, steps = 4 }",
            "12 is above 3",
        ),
        ("moisture = { from = 12, to = 30 }", "expected steps"),
        ("species = { from = 1, to = 3 }", "it takes no numbers"),
        ("seed = []", "the list is empty"),
        ("seed = [1]\nbreak.seed = [2]", "it varies twice"),
        (
            "seed = { from = 1, to = 1000000 }",
            "the sweep has 1000000 variants, which may be a mistake\n  hint: --yes",
        ),
        (
            "seed = { from = 1, to = 1000000 }\nslab_count = { from = 1, to = 100 }\nrings = { from = 6, to = 60 }",
            "make more than 1073741824 variants",
        ),
    ] {
        assert_refused(&folder, &SMALL.replace(SEEDS, line), &["-o", "d"], message);
    }
    let above = format!("sheet = 3\n{SMALL}");
    let unknown = "line 1, column 1: unknown parameter \"sheet\"";
    assert_refused(&folder, &above, &["-o", "d"], unknown);
    let misspelt = SMALL.replace("sheet", "sheep");
    assert_refused(
        &folder,
        &misspelt,
        &["-o", "d"],
        "unknown parameter \"sheep\"",
    );
    let none = "there is no variant 40; expected 0 to 39";
    assert_refused(&folder, SMALL, &["--show", "40"], none);
    assert!(!folder.0.join("d").exists());
}

#[test]
fn a_folder_with_another_sweep_is_refused_and_kept() {
    let folder = Folder::new();
    folder.write("first.toml", SMALL.replace(SEEDS, "seed = [1]"));
    let first = folder.run(&["sweep", "first.toml", "-o", "d", "--quiet"]);
    assert_eq!(first.code, 0, "{}", first.err);
    let journal = folder.read("d/journal.jsonl");
    let same_size = SMALL.replace(SEEDS, "seed = [2]");
    let other = "d: this folder holds another sweep (of as many variants, with other parameters)";
    assert_refused(&folder, &same_size, &["-o", "d"], other);
    let size = "d: this folder holds another sweep (of 1 variants, not 40)";
    assert_refused(&folder, SMALL, &["-o", "d"], size);
    assert!(folder.read("d/journal.jsonl") == journal);
}

/// A sweep of short simulations.
const RUNS: &str = "
duration = 0.004
[sweep]
kind = 'scene'
scene = 'snap.toml'
sheet = 2
[vary]
seed = [1, 2]
wood.species = ['white oak', 'Norway spruce']
wood.moisture = [12, 400]
";

/// The scene of these.
const SNAP: &str = include_str!("../../../../.ci/snap.toml");

#[test]
fn a_simulation_is_the_run_of_its_scene() {
    let folder = Folder::new();
    folder.write("snap.toml", SNAP);
    folder.write("s.toml", RUNS.replace(", 400", ""));
    let run = folder.run(&["sweep", "s.toml", "-o", "d", "--threads", "2"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    let records = records(&folder, "d");
    assert_eq!(records.len(), 4);
    for number in [0, 3] {
        let shown = folder.run(&["sweep", "s.toml", "--show", &number.to_string()]);
        folder.write("v.toml", &shown.out);
        let by_hand = folder.run(&["simulate", "v.toml", "-o", "run", "--no-pictures", "--json"]);
        assert_eq!(by_hand.code, 0, "{}", by_hand.err);
        fs::remove_dir_all(folder.0.join("run")).unwrap();
        let report: Value = serde_json::from_str(&by_hand.out).unwrap();
        let figures = &records[&number][0]["figures"];
        let same = |figure: &str, reported: &Value| {
            assert_eq!(&figures[figure], reported, "{figure} of {number}");
        };
        same("greatest_load_n", &report["outcome"]["greatest_load_n"]);
        same("mode", &report["outcome"]["mode"]);
        same("fracture_loss_j", &report["fracture_loss_j"]);
        same("most_energy_j", &report["energy"]["most_j"]);
        same("rods_broken", &report["broke"][0]);
    }
    let loads: Vec<f64> = (0..4)
        .map(|n| {
            records[&n][0]["figures"]["greatest_load_n"]
                .as_f64()
                .unwrap()
        })
        .collect();
    assert!(loads.iter().all(|load| *load > 0.0), "{loads:?}");
    assert!(loads[0] != loads[1] && loads[0] != loads[2], "{loads:?}");
    assert!(folder.read("d/variants.parquet").starts_with(b"PAR1"));
    assert!(folder.read("d/sheet.png").starts_with(b"\x89PNG"));
    assert!(!folder.0.join("d/variants").exists());
}

#[test]
fn simulations_resume_and_fail_as_breaks_do_and_leave_files_where_asked() {
    let folder = Folder::new();
    folder.write("snap.toml", SNAP);
    let text = RUNS
        .replace("sheet = 2", "file = 'glb'\ntextures = false\nsheet = 0")
        .replace("seed = [1, 2]\n", "")
        .replace("wood.moisture = [12, 400]", "rods.number = [7, 12]");
    folder.write("s.toml", &text);
    let whole = folder.run(&["sweep", "s.toml", "-o", "whole", "--quiet"]);
    assert_eq!((whole.code, whole.err.as_str()), (0, ""));
    // All but the first two lines of the journal are lost, and half a line is left.
    fs::create_dir(folder.0.join("cut")).unwrap();
    let journal = fs::read_to_string(folder.0.join("whole/journal.jsonl")).unwrap();
    let kept: Vec<&str> = journal.lines().take(2).collect();
    folder.write("cut/journal.jsonl", &(kept.join("\n") + "\n{\"vari"));
    let rest = folder.run(&["sweep", "s.toml", "-o", "cut", "--json"]);
    assert_eq!(rest.code, 0, "{}", rest.err);
    let report: Value = serde_json::from_str(&rest.out).unwrap();
    assert_eq!((&report["found"], &report["made"]), (&1.into(), &3.into()));
    let (cut, whole_pieces) = (pieces(&folder, "cut"), pieces(&folder, "whole"));
    assert_eq!((cut.len(), whole_pieces.len()), (3, 4));
    assert!(cut.iter().all(|(name, bytes)| whole_pieces[name] == *bytes));
    let figures = |name: &str, number| records(&folder, name)[&number][0]["figures"].clone();
    for number in 0..4 {
        assert_eq!(figures("cut", number), figures("whole", number));
    }
    // Rods without twist cannot fill a curved stem: a row with its error.
    let failing = RUNS
        .replace(
            "wood.moisture = [12, 400]",
            "stem.kind = ['cylinder', 'branch']",
        )
        .replace("wood.species = ['white oak', 'Norway spruce']\n", "")
        .replace("seed = [1, 2]\n", "");
    folder.write("f.toml", &failing);
    let run = folder.run(&["sweep", "f.toml", "-o", "f"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let records = records(&folder, "f");
    let error = records[&1][0]["error"].as_str().unwrap();
    assert!(error.contains("twist must be on"), "{error}");
    assert!(records[&0][0].get("error").is_none(), "{records:?}");
}

#[test]
fn a_bending_test_is_that_of_its_keys() {
    let folder = Folder::new();
    folder.write(
        "s.toml",
        "rods = 16\n[sweep]\nkind = 'bend-test'\n[vary]\nspecies = ['white oak', 'Sitka spruce']\nspecimens = ['auto', 3]\n",
    );
    let run = folder.run(&["sweep", "s.toml", "-o", "d"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    let records = records(&folder, "d");
    assert_eq!(records.len(), 4);
    // The order is species, specimens.
    let figures = |number: u64| &records[&number][0]["figures"];
    let options = [
        "bend-test",
        "--species",
        "Sitka spruce",
        "--rods",
        "16",
        "--json",
    ];
    let alone = folder.run(&options);
    let report: Value = serde_json::from_str(&alone.out).unwrap();
    let rupture = &report["modulus_of_rupture_pa"];
    assert_eq!(figures(2)["rupture_pa"]["test"], rupture["test"]);
    assert_eq!(figures(2)["rupture_pa"]["table"], rupture["table"]);
    assert_eq!(figures(2)["maximum_load_n"], report["maximum"]["load_n"]);
    let many = folder.run(&[&options[..], &["--specimens", "3"]].concat());
    let report: Value = serde_json::from_str(&many.out).unwrap();
    let rupture = &report["summary"]["modulus_of_rupture_pa"];
    assert_eq!(figures(3)["rupture_pa"]["test"], rupture["mean"]);
    assert_eq!(
        figures(3)["rupture_pa"]["deviation"],
        rupture["standard_deviation"]
    );
    assert_eq!(
        (&figures(3)["specimens"], &figures(2)["specimens"]),
        (&3.into(), &1.into())
    );
    assert!(folder.read("d/variants.parquet").starts_with(b"PAR1"));
    assert!(!folder.0.join("d/sheet.png").exists());
}

#[test]
fn kinds_refuse_what_they_do_not_have() {
    let folder = Folder::new();
    for (text, message) in [
        (
            "[sweep]\nkind = 'scene'\nscene = 'bent'\n[vary]\nseed = [1]",
            "did you mean \"bend\"",
        ),
        (
            "[sweep]\nkind = 'scene'\nscene = 'bend'\n[vary]\nwood.moistur = [1]",
            "[vary] wood.moistur: unknown parameter \"wood.moistur\"; did you mean \"wood.moisture\"",
        ),
        (
            "slab_height = 2\n[sweep]\nkind = 'bend-test'\n[vary]\nseed = [1]",
            "line 1, column 1: unknown parameter \"slab_height\"",
        ),
        (
            "[sweep]\nscene = 'bend'\n[vary]\nseed = [1]",
            "scene belongs to simulations",
        ),
        (
            "[sweep]\nkind = 'bend-test'\nfile = 'glb'\n[vary]\nseed = [1]",
            "bending tests have no pieces",
        ),
        (
            "[sweep]\nkind = 'bend-test'\n[vary]\nspecies = ['wite oak']",
            "did you mean \"Oak, white\"",
        ),
        (
            "[sweep]\nkind = 'bending'\n[vary]\nseed = [1]",
            "kind is \"bending\", but it must be one of break, scene, bend-test",
        ),
    ] {
        assert_refused(&folder, text, &["-o", "d"], message);
    }
    assert!(!folder.0.join("d").exists());
}

#[test]
fn parts_make_a_whole_that_nothing_is_missing_from_or_twice_in() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL.replace("to = 40", "to = 11"));
    let whole = folder.run(&["sweep", "s.toml", "-o", "whole", "--quiet"]);
    assert_eq!((whole.code, whole.err.as_str()), (0, ""));
    // Both write to one folder at the same time.
    let part = |part: &str| {
        Command::new(env!("CARGO_BIN_EXE_greenstick"))
            .args(["sweep", "s.toml", "-o", "d", "--part", part, "--quiet"])
            .current_dir(&folder.0)
            .spawn()
            .unwrap()
    };
    for mut child in [part("1/3"), part("3/3")] {
        assert!(child.wait().unwrap().success());
    }
    assert!(!folder.0.join("d/variants.parquet").exists());
    // Half of a line is what a part that was killed may leave.
    let journal = folder.0.join("d/journal-000003-of-000003.jsonl");
    let mut text = fs::read_to_string(&journal).unwrap();
    assert_eq!(text.lines().count(), 1 + 3);
    text += "{\"variant\":39,\"seco";
    fs::write(&journal, text).unwrap();
    let again = folder.run(&["sweep", "s.toml", "-o", "d", "--part", "3/3"]);
    assert!(
        again.out.starts_with("variants 3, 0 made, 3 were there\n"),
        "{}",
        again.out
    );
    // The second part was never made; the whole does.
    for (found, made) in [(7, 4), (11, 0)] {
        let rest = folder.run(&["sweep", "s.toml", "-o", "d", "--json"]);
        assert_eq!(rest.code, 0, "{}", rest.err);
        let report: Value = serde_json::from_str(&rest.out).unwrap();
        assert_eq!(
            (&report["found"], &report["made"]),
            (&found.into(), &made.into())
        );
    }
    let records = records(&folder, "d");
    assert_eq!(records.len(), 11);
    assert!(records.values().all(|lines| lines.len() == 1));
    assert!(pieces(&folder, "d") == pieces(&folder, "whole"));
    assert!(folder.read("d/variants.parquet").starts_with(b"PAR1"));
    let other = SMALL.replace("to = 40", "to = 12");
    let message = "d: this folder holds another sweep (of 11 variants, not 12)";
    assert_refused(&folder, &other, &["-o", "d", "--part", "3/3"], message);
    let none = "expected the number of a part and how many there are, such as 1/8";
    assert_refused(&folder, SMALL, &["-o", "d", "--part", "9/8"], none);
}

#[test]
fn a_job_has_a_task_for_each_part() {
    let folder = Folder::new();
    folder.write("s.toml", SMALL);
    let written = folder.run(&["sweep", "s.toml", "--job", "job", "--parts", "64"]);
    assert_eq!(written.code, 0, "{}", written.err);
    let template: Value = serde_json::from_slice(&folder.read("job/template.json")).unwrap();
    let steps = &template["steps"];
    let parts = &steps[0]["parameterSpace"]["taskParameterDefinitions"][0];
    // There are no more than variants.
    assert_eq!(parts["range"], "1-40");
    assert_eq!(steps[1]["dependencies"][0]["dependsOn"], steps[0]["name"]);
    assert!(folder.read("job/sweep.toml") == SMALL.as_bytes());
    let named = format!("input = 'pole.ply'\n{SMALL}");
    let message = "it names pole.ply beside it";
    assert_refused(&folder, &named, &["--job", "other"], message);
    assert!(!folder.0.join("other").exists());
}
