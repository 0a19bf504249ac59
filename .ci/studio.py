#!/usr/bin/env python3
"""Drives the studio's real window under Xvfb as a person would: starts it on a file, drags a slider, saves the project and
exports the pieces by keys, and compares what it wrote with what the command line makes of the same project, byte for byte. Then
takes the graphics device from a window, which has to begin again by itself.

Usage: studio.py STUDIO GREENSTICK MESH FOLDER. Needs Xvfb, xdotool and a Vulkan driver (mesa-vulkan-drivers)."""

import os
import pathlib
import shutil
import subprocess
import sys
import time

DISPLAY = ":93"
WIDTH, HEIGHT = 1360, 860
PATIENCE = 240  # seconds, on a busy machine


def wait_for(what, condition):
    start = time.monotonic()
    while time.monotonic() - start < PATIENCE:
        found = condition()
        if found:
            return found
        time.sleep(0.2)
    sys.exit(f"{what} did not happen within {PATIENCE} s")


def xdotool(*words):
    done = subprocess.run(["xdotool", *map(str, words)], capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else ""


def press(key):
    xdotool("key", key)
    time.sleep(2)


def enter_until(what, key, path):
    """Opens a dialog by a key and presses Return until a file is there: the dialog may take its time to appear. Keys that come while
    the window is busy may be lost: after half a minute without a file the key is pressed again."""
    tries = 0

    def is_there():
        nonlocal tries
        if tries % 10 == 0:
            press(key)
        tries += 1
        press("Return")
        return is_complete(path)

    wait_for(what, is_there)


def drag_a_slider():
    """The first sliders of the panel on the right: at one of these heights lies that of a number."""
    x = WIDTH - 150
    for y in (211, 280, 303):
        xdotool("mousemove", x - 12, y)
        time.sleep(0.3)
        xdotool("mousedown", 1)
        for _ in range(5):
            xdotool("mousemove_relative", "--", 7, 0)
            time.sleep(0.15)
        xdotool("mouseup", 1)
        time.sleep(0.5)


def is_complete(path):
    if not path.is_file():
        return False
    size = path.stat().st_size
    time.sleep(1)
    return size > 0 and path.stat().st_size == size


def drive(studio, mesh, folder):
    """Runs the window; returns the project and the pieces that it wrote."""
    environment = dict(os.environ, DISPLAY=DISPLAY, XDG_CONFIG_HOME=str(folder / "config"))
    environment.setdefault("XDG_RUNTIME_DIR", str(folder))
    environment.pop("WAYLAND_DISPLAY", None)
    window = subprocess.Popen([studio, mesh.name], cwd=folder, env=environment)
    try:
        number = wait_for("a window", lambda: xdotool("search", "--name", mesh.name))
        xdotool("windowfocus", number.splitlines()[0])
        time.sleep(8)
        project = folder / f"{mesh.stem}.greenstick.toml"
        enter_until("a saved project", "ctrl+s", project)
        before = project.read_bytes()

        # A busy machine may not have drawn the panel yet.
        def is_changed():
            drag_a_slider()
            press("ctrl+s")
            return is_complete(project) and project.read_bytes() != before

        wait_for("a change of the project by a slider", is_changed)

        # Nor may it have followed the mouse to the end.
        def is_settled():
            saved = project.read_bytes()
            press("ctrl+s")
            return is_complete(project) and project.read_bytes() == saved

        wait_for("the end of the change", is_settled)
        pieces = folder / "broken.glb"
        enter_until("an export", "ctrl+e", pieces)
        press("ctrl+q")
        code = window.wait(PATIENCE)
        if code != 0:
            sys.exit(f"the studio ended with code {code}")
    finally:
        if window.poll() is None:
            window.kill()
    return project, pieces


def lose_the_card(studio, folder):
    """Runs the example whose graphics device is lost after some seconds: another window of the same program follows."""
    environment = dict(os.environ, DISPLAY=DISPLAY, XDG_CONFIG_HOME=str(folder / "lost"))
    environment.setdefault("XDG_RUNTIME_DIR", str(folder))
    environment.pop("WAYLAND_DISPLAY", None)
    program = pathlib.Path(studio).parent / "examples" / "lost_card"
    window = subprocess.Popen([program, "10"], cwd=folder, env=environment)
    try:
        first = wait_for("a window", lambda: xdotool("search", "--name", "Greenstick"))

        def is_another():
            if window.poll() is not None:
                sys.exit(f"the studio ended with code {window.returncode} when its graphics device was lost")
            found = xdotool("search", "--name", "Greenstick")
            return found if found and found != first else None

        wait_for("another window", is_another)

        def is_ended():
            # The window of before may still be listed.
            for number in xdotool("search", "--name", "Greenstick").splitlines():
                xdotool("windowfocus", number)
                press("ctrl+q")
            return window.poll() is not None

        time.sleep(8)
        if window.poll() is not None:
            sys.exit(f"the studio ended with code {window.returncode} when its graphics device was lost")
        wait_for("the end of the program", is_ended)
        code = window.wait(PATIENCE)
        if code != 0:
            sys.exit(f"the studio ended with code {code} after its graphics device was lost")
    finally:
        if window.poll() is None:
            window.kill()


def main():
    studio, greenstick, mesh, folder = sys.argv[1:]
    folder = pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for file in pathlib.Path(mesh).parent.glob(pathlib.Path(mesh).stem + ".*"):
        shutil.copy(file, folder)
    copy = folder / pathlib.Path(mesh).name
    # Reset where its last client leaves, it would refuse the studio just after it answered what asked for it.
    screen = ["-screen", "0", f"{WIDTH}x{HEIGHT}x24", "-noreset"]
    server = subprocess.Popen(["Xvfb", DISPLAY, *screen], stderr=subprocess.DEVNULL)
    os.environ["DISPLAY"] = DISPLAY
    try:
        wait_for("a display", lambda: xdotool("getdisplaygeometry"))
        project, pieces = drive(studio, copy, folder)
        lose_the_card(studio, folder)
    finally:
        server.terminate()
    expected = folder / "expected.glb"
    subprocess.run(
        [greenstick, "break", "--recipe", project.name, "-o", expected.name, "--quiet"], cwd=folder, check=True
    )
    subprocess.run([greenstick, "break", copy.name, "-o", "unchanged.glb", "--quiet"], cwd=folder, check=True)
    if pieces.read_bytes() == (folder / "unchanged.glb").read_bytes():
        sys.exit("no slider was dragged: the pieces are those of a request without changes")
    if pieces.read_bytes() != expected.read_bytes():
        sys.exit(f"{pieces} differs from what the command line makes of {project}")
    print(f"the window's pieces are those of the command line: {pieces.stat().st_size} bytes")


if __name__ == "__main__":
    main()
