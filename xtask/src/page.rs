//! The web page of the studio: a folder of files that any server can hand out.

use crate::workspace::read;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const TARGET: &str = "wasm32-unknown-unknown";
const PACKAGE: &str = "greenstick-studio";
const LINKER: &str = "CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER";
/// What the page consists of besides the program.
const FILES: [&str; 2] = ["index.html", "worker.js"];
/// Most bytes of the program by gzip.
const MOST: u64 = 8 << 20;

/// Builds the page into `folder`; returns what to say.
pub fn build(root: &Path, folder: &Path) -> Result<String, String> {
    let target = root.join("target/wasm");
    run(cargo(root)
        .args(["build", "--locked", "--profile", "page", "--bin", PACKAGE])
        .args(["-p", PACKAGE, "--target", TARGET, "--target-dir"])
        .arg(&target))?;
    fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let program = target.join(TARGET).join("page").join(PACKAGE);
    run(Command::new(bindgen(root)?)
        .args(["--target", "web", "--no-typescript"])
        .args(["--remove-name-section", "--remove-producers-section"])
        .arg("--out-dir")
        .arg(folder)
        .arg(program.with_extension("wasm")))?;
    for name in FILES {
        let from = root.join("apps/studio/page").join(name);
        fs::copy(&from, folder.join(name)).map_err(|e| format!("{}: {e}", from.display()))?;
    }
    let program = folder.join(format!("{PACKAGE}_bg.wasm"));
    let whole = fs::metadata(&program).map_err(|e| format!("{}: {e}", program.display()))?;
    let zipped = zipped_size(&program)?;
    let said = format!(
        "{} holds the page: its program has {:.1} MB, {:.1} MB by gzip",
        folder.display(),
        whole.len() as f64 / 1e6,
        zipped as f64 / 1e6
    );
    if zipped > MOST {
        return Err(format!("{said}, which is more than {MOST} bytes"));
    }
    Ok(said)
}

/// The cargo that builds for browsers: the machine's own where `rustup target add` has been run, else that of Debian's packages, which bring
/// the source of the standard library, from which it is built.
fn cargo(root: &Path) -> Command {
    let sysroot = Command::new("rustc").args(["--print", "sysroot"]).output();
    let own = sysroot.is_ok_and(|out| {
        let path = String::from_utf8_lossy(&out.stdout).trim().to_owned();
        Path::new(&path).join("lib/rustlib").join(TARGET).is_dir()
    });
    let mut command;
    if own {
        command = Command::new("cargo");
    } else {
        command = Command::new("/usr/bin/cargo");
        command
            .env("PATH", "/usr/bin:/bin")
            .env("RUSTC", "/usr/bin/rustc")
            .env("RUSTC_BOOTSTRAP", "1")
            .arg("-Zbuild-std=std,panic_abort");
        if let Some(major) = debian_llvm() {
            // Debian's compiler comes without a linker for browsers; the one of its own LLVM knows all it writes.
            command.env(LINKER, format!("wasm-ld-{major}"));
        }
    }
    for name in ["CARGO", "RUSTUP_TOOLCHAIN", "RUSTFLAGS"] {
        command.env_remove(name);
    }
    command.current_dir(root);
    command
}

/// The version of LLVM in Debian's compiler.
fn debian_llvm() -> Option<String> {
    let said = Command::new("/usr/bin/rustc").arg("-vV").output().ok()?;
    let said = String::from_utf8(said.stdout).ok()?;
    let version = said
        .lines()
        .find_map(|l| l.strip_prefix("LLVM version: "))?;
    version.split('.').next().map(str::to_owned)
}

/// The program wasm-bindgen of the version that the workspace is locked to; built below target/ where it is not there.
fn bindgen(root: &Path) -> Result<PathBuf, String> {
    let version = locked_version(&read(&root.join("Cargo.lock"))?, "wasm-bindgen")
        .ok_or("Cargo.lock lists no wasm-bindgen")?;
    let folder = root.join("target/wasm-tools").join(&version);
    let program = folder.join("bin/wasm-bindgen");
    if !program.is_file() {
        let mut command = Command::new("cargo");
        command.args([
            "install",
            "--quiet",
            "wasm-bindgen-cli",
            "--bin",
            "wasm-bindgen",
        ]);
        command.args(["--version", &format!("={version}"), "--root"]);
        // It runs for seconds: optimising it well would take minutes.
        command
            .arg(&folder)
            .env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1");
        run(&mut command)?;
    }
    Ok(program)
}

/// The version of a package in a lock file.
fn locked_version(lock: &str, name: &str) -> Option<String> {
    let mut lines = lock.lines();
    lines.find(|l| *l == format!("name = \"{name}\""))?;
    let version = lines.next()?.strip_prefix("version = \"")?;
    Some(version.trim_end_matches('"').to_owned())
}

fn zipped_size(file: &Path) -> Result<u64, String> {
    let zipped = Command::new("gzip").args(["-9", "-c"]).arg(file).output();
    let zipped = zipped.map_err(|e| format!("gzip: {e}"))?;
    if !zipped.status.success() {
        return Err(format!("gzip of {} failed", file.display()));
    }
    Ok(zipped.stdout.len() as u64)
}

fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status();
    let status = status.map_err(|e| format!("{}: {e}", command.get_program().display()))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!(
            "{} failed ({status})",
            command.get_program().display()
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::locked_version;

    #[test]
    fn the_version_of_a_package_is_its_own() {
        let lock = "[[package]]\nname = \"a-b\"\nversion = \"1.0.0\"\n\n[[package]]\nname = \"a\"\nversion = \"2.3.4\"\n";
        assert_eq!(locked_version(lock, "a").as_deref(), Some("2.3.4"));
        assert_eq!(locked_version(lock, "b"), None);
    }
}
