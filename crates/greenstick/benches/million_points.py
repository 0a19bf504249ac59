"""A cloud of a million points, read, cleaned, surfaced and broken, with the time of each stage.

pip install numpy; cargo build --release; python3 crates/greenstick/benches/million_points.py, in the repository's root.
The points lie on a bent, tapering stem of 10 m with bark furrows, 1 mm of noise; one in 200 is strewn about it.
"""

import json
import os
import resource
import subprocess
import tempfile

import numpy

COUNT = 1_000_000


def cloud():
    chance = numpy.random.default_rng(1)
    along = chance.uniform(0, 10, COUNT)
    angle = chance.uniform(0, 2 * numpy.pi, COUNT)
    bark = 0.006 * numpy.cos(14 * angle + numpy.sin(3 * along)) + 0.004 * numpy.cos(31 * angle)
    radius = 0.2 - 0.008 * along + bark + chance.normal(0, 0.001, COUNT)
    x = radius * numpy.cos(angle) + 0.1 * numpy.sin(along / 4)
    points = numpy.stack([x, radius * numpy.sin(angle), along], 1)
    points[:: 200] = chance.uniform([-1, -1, 0], [1, 1, 10], (COUNT // 200, 3))
    return points.astype("<f4")


def main():
    header = "ply\nformat binary_little_endian 1.0\n" f"element vertex {COUNT}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "cloud.ply")
        with open(path, "wb") as file:
            file.write(header.encode() + cloud().tobytes())
        command = ["target/release/greenstick", "break", path, "--unit", "m", "--json"]
        out = subprocess.run(command + ["-o", os.path.join(folder, "broken.glb")], check=True, stdout=subprocess.PIPE).stdout
    report = json.loads(out)
    for stage in report["stages"]:
        print(f"{stage['name']:>10} {stage['seconds']:8.2f} s")
    surfaced = [s["seconds"] for s in report["stages"] if s["name"] in ("read", "clean", "find stem", "bark")]
    bark = report["scan"]["bark"]
    print(f"surfaced in {sum(surfaced):.2f} s: {bark['points']} points, {bark['cells'][0]} x {bark['cells'][1]} cells,")
    print(f"{1e3 * bark['noise_m']:.2f} mm off the surface; ", end="")
    print(f"{resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024:.0f} MiB in all")


if __name__ == "__main__":
    main()
