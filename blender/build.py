"""Makes the archive of the Blender extension: `python3 blender/build.py WHEEL -o DIR`.

One archive for each platform, as the wheel holds the library for one. Blender 4.5 and newer installs it by drag and drop."""

import argparse
import re
import sys
import tomllib
import zipfile
from pathlib import Path

HERE = Path(__file__).parent
SOURCE = HERE / "greenstick_wood"
# Platforms of wheels, and what Blender calls them.
PLATFORMS = {
    r"manylinux.*_x86_64|linux_x86_64": "linux-x64",
    r"manylinux.*_aarch64|linux_aarch64": "linux-arm64",
    r"win_amd64": "windows-x64",
    r"win_arm64": "windows-arm64",
    r"macosx.*_arm64": "macos-arm64",
    r"macosx.*_x86_64": "macos-x64",
}


def platform_of(wheel: Path) -> str:
    """The platform of a wheel, by its name."""
    parts = wheel.stem.split("-")
    if wheel.suffix != ".whl" or len(parts) != 5 or parts[0] != "greenstick":
        sys.exit(f"{wheel} is not a wheel of greenstick; `maturin build --release` in python/ makes one")
    for pattern, name in PLATFORMS.items():
        if re.fullmatch(pattern, parts[4].split(".")[0]):
            return name
    sys.exit(f"{wheel} is for {parts[4]}, which Blender does not run on")


def build(wheel: Path, folder: Path) -> Path:
    """Writes the archive for the platform of a wheel into a folder."""
    if not wheel.is_file():
        sys.exit(f"{wheel} is not there; `maturin build --release` in python/ makes a wheel")
    platform = platform_of(wheel)
    manifest = (SOURCE / "blender_manifest.toml").read_text()
    version = wheel.stem.split("-")[1]
    manifest = re.sub(r'(?m)^version = ".*"$', f'version = "{version}"', manifest)
    manifest = manifest.replace("platforms = []", f'platforms = ["{platform}"]')
    manifest = manifest.replace("wheels = []", f'wheels = ["./wheels/{wheel.name}"]')
    assert tomllib.loads(manifest)["wheels"], "the manifest has no place for the wheel"
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / f"greenstick_wood-{version}-{platform.replace('-', '_')}.zip"
    part = target.with_suffix(".part")
    with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(SOURCE.glob("*.py")):
            archive.write(file, file.name)
        archive.writestr("blender_manifest.toml", manifest)
        for name in ("LICENSE-MIT", "LICENSE-APACHE"):
            archive.write(HERE.parent / name, name)
        archive.write(wheel, f"wheels/{wheel.name}")
    part.replace(target)
    return target


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("wheel", type=Path, help="wheel of greenstick for one platform")
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder for the archive")
    options = parser.parse_args()
    print(build(options.wheel, options.output))
