"""Work in a thread of its own, so that Blender's window goes on. Nothing here touches Blender's data."""

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import greenstick

# Share of the time that a simulation takes; the rest goes into its film.
_SIMULATING = 0.8


class Stopped(Exception):
    """Raised in the thread of work that is to stop."""


class Task:
    """Work; `state` goes from "idle" to "running", then to "done", "failed" or "cancelled"."""

    def __init__(self) -> None:
        self.state = "idle"
        self.fraction = 0.0
        self.stage = ""
        self.result: Any = None
        self.message = ""
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def begin(self, make: Callable[[], Any]) -> None:
        """Starts to make something; what ran before is stopped first."""
        self.cancel()
        self.wait()
        self._stop.clear()
        self.state, self.fraction, self.result, self.message = "running", 0.0, None, ""
        self._thread = threading.Thread(target=self._work, args=(make,), daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """Asks running work to stop, which it does within a tenth of a second."""
        self._stop.set()

    def wait(self) -> None:
        """Waits until nothing runs."""
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def progress(self, low: float = 0.0, high: float = 1.0) -> Callable[[str, float], None]:
        """What the library calls with its stage and the fraction of a call that is the part from `low` to `high` of all."""

        def progress(stage: str, fraction: float) -> None:
            self.stage, self.fraction = stage, low + (high - low) * fraction
            if self._stop.is_set():
                raise Stopped

        return progress

    def _work(self, make: Callable[[], Any]) -> None:
        try:
            self.result = make()
            self.state = "done"
        except (Stopped, greenstick.Cancelled):
            self.state = "cancelled"
        except greenstick.GreenstickError as error:
            self.message, self.state = str(error), "failed"
        except Exception as error:  # A thread must not end without a word.
            self.message, self.state = f"{type(error).__name__}: {error}", "failed"


class Job(Task):
    """Breaks a scene again and again."""

    def __init__(self, session: greenstick.Session) -> None:
        super().__init__()
        self.session = session

    def start(self, request: greenstick.Request) -> None:
        """Starts on a request; what ran before is stopped first."""
        self.begin(lambda: self.session.broken(request, progress=self.progress()))

    def run(self, request: greenstick.Request) -> None:
        """Does the work here and now."""
        self.start(request)
        self.wait()


class Simulation(Task):
    """Simulates a scene of the library on a mesh, and writes its film into a file. The result is the map from the world of the mesh
    to that of the film (4 × 4), and the notes of the run."""

    def __init__(self, scene: str, mesh: greenstick.Scene, keys: dict[str, Any], texture_size: int) -> None:
        super().__init__()
        self.scene, self.mesh, self.keys, self.texture_size = scene, mesh, keys, texture_size

    def start(self, file: Path) -> None:
        """Starts; the film goes into `file` (.usdc), its textures beside it."""
        self.begin(lambda: self._film(file))

    def _film(self, file: Path) -> tuple[Any, list[str]]:
        run = greenstick.simulate(self.scene, self.mesh, self.keys, progress=self.progress(0.0, _SIMULATING))
        shown = self.progress(_SIMULATING, 1.0)
        film = run.film(texture_size=self.texture_size, progress=lambda stage, fraction: shown(stage, 0.5 * fraction))
        film.write(file, progress=lambda stage, fraction: shown(stage, 0.5 + 0.5 * fraction))
        return film.transform, (run.report or {}).get("notes", [])
