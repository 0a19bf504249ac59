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

/// The packages of crates.io, each of which has to build from nothing but its own files.
fn packages(root: &Path, folder: &Path) -> Result<(), String> {
    let target = root.join("target/packages");
    let built = target.join("package");
    // Cargo knows packages by name and version alone, and would take what it compiled and unpacked of them before.
    if target.exists() {
        fs::remove_dir_all(&target).map_err(|e| format!("{}: {e}", target.display()))?;
    }
    forget_unpacked()?;
    let mut cargo = cargo(root);
    // Packages are built to see that nothing is missing: optimising them would only take time.
    cargo
        .args([
            "package",
            "--workspace",
            "--exclude",
            "xtask",
            "--locked",
            "--allow-dirty",
            "--quiet",
            "--target-dir",
        ])
        .arg(&target)
        .env("CARGO_PROFILE_DEV_OPT_LEVEL", "0")
        .env("CARGO_PROFILE_DEV_DEBUG", "0");
    run(cargo)?;
    let into = folder.join("crates");
    make_folder(&into)?;
    let is_package = |path: &Path| path.extension().is_some_and(|e| e == "crate");
    let at_top = |path: &Path| path.parent() == Some(&*built);
    for package in workspace::files_below(&built, &|p| is_package(p) && at_top(p))? {
        copy(&package, &into)?;
    }
    Ok(())
}

/// Removes what cargo unpacked of our packages before.
fn forget_unpacked() -> Result<(), String> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| std::env::home_dir().map(|home| home.join(".cargo")));
    let Some(sources) = home.map(|home| home.join("registry/src")) else {
        return Ok(());
    };
    let Ok(registries) = fs::read_dir(&sources) else {
        return Ok(());
    };
    for registry in registries.flatten() {
        // A registry that is a folder has no host, after which the others are named.
        if registry.file_name().to_string_lossy().starts_with('-') {
            let path = registry.path();
            fs::remove_dir_all(&path).map_err(|e| format!("{}: {e}", path.display()))?;
        }
    }
    Ok(())
}

/// The program for this machine, with what its own arguments give: manual pages and completions.
fn program(root: &Path, folder: &Path) -> Result<(), String> {
    let mut build = cargo(root);
    build.args([
        "build",
        "--release",
        "--locked",
        "--quiet",
        "-p",
        "greenstick-cli",
    ]);
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
