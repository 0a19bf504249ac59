"""The erosion beside a loop of OpenCV's `erode` on the same sections, and beside Table 1 of Forests 2023.

pip install opencv-python-headless numpy; python3 crates/wood/benches/erosion_opencv.py, in the repository's root.
Both give every pixel the number of the pass that took it off. One thread each; least times of the runs, for OpenCV of the processor rather than the clock.
"""

import os
import subprocess
import tempfile
import time

import cv2
import numpy

PAPER = {32: (11, 0.1628), 64: (21, 0.5469), 128: (41, 3.9118), 256: (80, 29.1836), 512: (159, 240.4738)}


def opencv(section):
    """Number of the pass that took each pixel off."""
    kernel = numpy.ones((3, 3), numpy.uint8)
    now = section.copy()
    numbers = now.astype(numpy.uint16)
    while True:
        cv2.erode(now, kernel, dst=now, borderType=cv2.BORDER_CONSTANT, borderValue=0)
        if not cv2.countNonZero(now):
            return numbers
        cv2.add(numbers, now, dst=numbers, dtype=cv2.CV_16U)


def read(path):
    lines = open(path).read().split("\n")
    return numpy.array([[int(c) for c in line] for line in lines[2:] if line], numpy.uint8)


def main():
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory() as folder:
        ours = {}
        command = ["cargo", "bench", "-q", "-p", "greenstick-wood", "--bench", "erosion", "--"]
        out = subprocess.run(
            command + ["--pictures", folder], check=True, text=True, stdout=subprocess.PIPE
        ).stdout
        for line in out.splitlines()[1:]:
            size, contours, median, least = line.split()
            ours[size] = (contours, median, least)
        print(f"{'size':>5} {'paper':>11} {'':>9} {'greenstick':>11} {'':>9} {'OpenCV':>9} {'':>9}")
        print(
            f"{'':>5} {'contours':>11} {'s':>9} {'contours':>11} {'ms':>9} {'contours':>9} {'ms':>9} {'faster':>7}"
        )
        for size, (contours, seconds) in PAPER.items():
            section = read(os.path.join(folder, f"{size}.pbm"))
            best = float("inf")
            for _ in range(41):
                start = time.process_time()
                numbers = opencv(section)
                best = min(best, (time.process_time() - start) * 1e3)
            count, _, least = ours[str(size)]
            print(
                f"{size:>5} {contours:>11} {seconds:>9} {count:>11} {float(least):>9.3f} {numbers.max():>9} "
                f"{best:>9.3f} {best / float(least):>7.1f}"
            )
        print(f"512 sections of 512 x 512, all threads: {ours['512x512'][1]} ms")


if __name__ == "__main__":
    main()
