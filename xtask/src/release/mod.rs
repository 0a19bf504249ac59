//! Everything that a version is published as, built into one folder: packages for crates.io, the program with its manual
//! and completions, the wheel for Python, the extension for Blender, the licences and the bill of materials of what they
//! were built from, and checksums of it all.

mod bill;
mod dependencies;
mod licences;

use crate::workspace;
use dependencies::Dependencies;
use sha2::{Digest, Sha256};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folder of the outcome, below the root.
const FOLDER: &str = "target/release-files";
/// Shells that completions are made for, and the names of the files that they look for.
const SHELLS: [(&str, &str); 4] = [
    ("bash", "greenstick.bash"),
    ("zsh", "_greenstick"),
    ("fish", "greenstick.fish"),
    ("powershell", "_greenstick.ps1"),
];
/// How what was built is published, once it has been looked at.
const PUBLISHING: &str =
    "to publish: cargo publish --workspace; python3 -m twine upload target/release-files/*.whl";

/// Builds everything. Returns what must be mended before it can be published.
pub fn build(root: &Path) -> Result<Vec<String>, String> {
    let folder = root.join(FOLDER);
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    make_folder(&folder)?;
    let found = Dependencies::of(root)?;
    let faults = licences::faults(&found);
    write(
        &folder.join("THIRD-PARTY-LICENCES.txt"),
        licences::texts(&found)?,
    )?;
    let bill = bill::cyclone_dx(&found, &version(root)?);
    let bill = serde_json::to_vec_pretty(&bill).map_err(|e| e.to_string())?;
    write(&folder.join("greenstick.cdx.json"), bill)?;
    packages(root, &folder)?;
    program(root, &folder)?;
    wheel(root, &folder)?;
    extension(root, &folder)?;
    let files = workspace::files_below(&folder, &|_| true)?;
    let mut sums = String::new();
    for file in &files {
        let bytes = fs::read(file).map_err(|e| format!("{}: {e}", file.display()))?;
        let sum: String = Sha256::digest(&bytes)
            .iter()
            .map(|b| format!("{b:02x}"))
            .collect();
        let name = workspace::relative(file, &folder);
        println!("{:>12} bytes  {name}", bytes.len());
        sums += &format!("{sum}  {name}\n");
    }
    write(&folder.join("SHA256SUMS"), sums)?;
    println!("{PUBLISHING}");
    Ok(faults)
}

/// The packages of crates.io, each of which has to compile from nothing but its own files and what it says that it needs.
fn packages(root: &Path, folder: &Path) -> Result<(), String> {
    let target = root.join("target/packages");
    if target.exists() {
        fs::remove_dir_all(&target).map_err(|e| format!("{}: {e}", target.display()))?;
    }
    let mut package = cargo(root);
    // Cargo's own test of a package builds it. Nothing that is missing takes code to be made of it to be found out.
    package
        .args(["package", "--workspace", "--locked"])
        .args(["--exclude", "xtask", "--exclude", "greenstick-python"])
        .args(["--allow-dirty", "--no-verify", "--quiet", "--target-dir"])
        .arg(&target);
    run(package)?;
    let into = folder.join("crates");
    make_folder(&into)?;
    let built = target.join("package");
    let sources = target.join("sources");
    make_folder(&sources)?;
    let is_package = |path: &Path| path.extension().is_some_and(|e| e == "crate");
    let at_top = |path: &Path| path.parent() == Some(&*built);
    let mut unpacked = Vec::new();
    for package in workspace::files_below(&built, &|p| is_package(p) && at_top(p))? {
        copy(&package, &into)?;
        let mut tar = Command::new("tar");
        // Cargo judges by their times whether files have changed, and those in packages are of one time.
        tar.arg("-xmzf").arg(&package).arg("-C").arg(&sources);
        run(tar)?;
        let folder = package.file_stem().unwrap_or_default();
        unpacked.push(folder.to_string_lossy().into_owned());
    }
    check_unpacked(root, &sources, &unpacked)
}

/// Compiles each of the unpacked packages by itself, with the others in place of those of crates.io.
fn check_unpacked(root: &Path, sources: &Path, unpacked: &[String]) -> Result<(), String> {
    let name = |folder: &str| folder.rsplit_once('-').map(|(name, _)| name.to_owned());
    let names: Vec<String> = unpacked.iter().filter_map(|f| name(f)).collect();
    let mut manifest = format!("[workspace]\nresolver = \"3\"\nmembers = {unpacked:?}\n");
    manifest += "[patch.crates-io]\n";
    for (name, folder) in names.iter().zip(unpacked) {
        manifest += &format!("{name} = {{ path = {folder:?} }}\n");
    }
    // By the same profiles, crates of others are compiled for these as they were for the workspace.
    let own = workspace::read(&root.join("Cargo.toml"))?;
    let profiles = own.find("[profile.").unwrap_or(own.len());
    write(&sources.join("Cargo.toml"), manifest + &own[profiles..])?;
    copy(&root.join("Cargo.lock"), sources)?;
    for name in &names {
        let mut check = cargo(sources);
        check
            .args(["check", "--quiet", "--package", name, "--target-dir"])
            .arg(root.join("target"));
        run(check)?;
    }
    Ok(())
}

/// The program for this machine, with what its own arguments give: manual pages and completions.
fn program(root: &Path, folder: &Path) -> Result<(), String> {
    let mut build = cargo(root);
    // With the wheel's crate, so that what both need is compiled once.
    build.args(["build", "--release", "--locked", "--quiet"]);
    build.args(["-p", "greenstick-cli", "-p", "greenstick-python"]);
    run(build)?;
    let program = root.join(format!(
        "target/release/greenstick{}",
        std::env::consts::EXE_SUFFIX
    ));
    copy(&program, folder)?;
    let mut manual = Command::new(&program);
    manual.arg("manual").arg("-o").arg(folder.join("man"));
    run(manual)?;
    let completions = folder.join("completions");
    make_folder(&completions)?;
    for (shell, name) in SHELLS {
        let mut command = Command::new(&program);
        command.args(["completions", shell]);
        write(&completions.join(name), output(command)?)?;
    }
    Ok(())
}

/// The wheel of the Python package for this machine.
fn wheel(root: &Path, folder: &Path) -> Result<(), String> {
    let own = root.join("target/python-build/bin/python");
    let mut python = Command::new(if own.exists() {
        own
    } else {
        PathBuf::from("python3")
    });
    python
        .args([
            "-m",
            "maturin",
            "build",
            "--release",
            "--locked",
            "--quiet",
            "--out",
        ])
        .arg(folder)
        .current_dir(root.join("python"))
        .env("CARGO_TARGET_DIR", root.join("target"));
    run(python).map_err(|e| {
        format!("{e}; `python3 -m pip install maturin` installs what builds the wheel")
    })
}

/// The extension for Blender, around that wheel.
fn extension(root: &Path, folder: &Path) -> Result<(), String> {
    let is_wheel = |path: &Path| path.extension().is_some_and(|e| e == "whl");
    for wheel in workspace::files_below(folder, &is_wheel)? {
        let mut python = Command::new("python3");
        python
            .arg(root.join("blender/build.py"))
            .arg(wheel)
            .arg("-o")
            .arg(folder);
        run(python)?;
    }
    Ok(())
}

/// The version of the workspace.
fn version(root: &Path) -> Result<String, String> {
    let metadata = workspace::metadata(root)?;
    let program = metadata["packages"].as_array().into_iter().flatten();
    let version = program
        .filter(|p| p["name"] == "greenstick")
        .find_map(|p| p["version"].as_str());
    version
        .map(str::to_owned)
        .ok_or_else(|| "the workspace has no package `greenstick`".to_owned())
}

fn cargo(root: &Path) -> Command {
    let mut command = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned()));
    command.current_dir(root);
    command
}

fn run(command: Command) -> Result<(), String> {
    output(command).map(|_| ())
}

/// Runs a command and returns what it printed.
fn output(mut command: Command) -> Result<Vec<u8>, String> {
    let name = format!("{command:?}");
    let output = command
        .output()
        .map_err(|e| format!("{name} did not start: {e}"))?;
    if !output.status.success() {
        return Err(format!(
            "{name} failed: {}",
            String::from_utf8_lossy(&output.stderr)
        ));
    }
    Ok(output.stdout)
}

fn make_folder(folder: &Path) -> Result<(), String> {
    fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))
}

fn copy(file: &Path, folder: &Path) -> Result<(), String> {
    let name = file.file_name().unwrap_or_default();
    fs::copy(file, folder.join(name)).map_err(|e| format!("{}: {e}", file.display()))?;
    Ok(())
}

fn write(file: &Path, content: impl AsRef<[u8]>) -> Result<(), String> {
    fs::write(file, content).map_err(|e| format!("{}: {e}", file.display()))
}
