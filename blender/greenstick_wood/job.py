"""A break in a thread of its own, so that Blender's window goes on. Nothing here touches Blender's data."""

import threading
from typing import Any

import greenstick


class Stopped(Exception):
    """Raised in the thread of a job that is to stop."""


class Job:
    """Breaks a scene; `state` goes from "idle" to "running", then to "done", "failed" or "cancelled"."""

    def __init__(self, session: greenstick.Session) -> None:
        self.session = session
        self.state = "idle"
        self.fraction = 0.0
        self.stage = ""
        self.result: Any = None
        self.message = ""
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self, request: greenstick.Request) -> None:
        """Starts on a request; what ran before is stopped first."""
        self.cancel()
        self.wait()
        self._stop.clear()
        self.state, self.fraction, self.result, self.message = "running", 0.0, None, ""
        self._thread = threading.Thread(target=self._work, args=(request,), daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """Asks a running job to stop, which it does within a tenth of a second."""
        self._stop.set()

    def wait(self) -> None:
        """Waits until nothing runs."""
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def run(self, request: greenstick.Request) -> None:
        """Does the work here and now."""
        self.start(request)
        self.wait()

    def _progress(self, stage: str, fraction: float) -> None:
        self.stage, self.fraction = stage, fraction
        if self._stop.is_set():
            raise Stopped

    def _work(self, request: greenstick.Request) -> None:
        try:
            self.result = self.session.broken(request, progress=self._progress)
            self.state = "done"
        except (Stopped, greenstick.Cancelled):
            self.state = "cancelled"
        except greenstick.GreenstickError as error:
            self.message, self.state = str(error), "failed"
        except Exception as error:  # A thread must not end without a word.
            self.message, self.state = f"{type(error).__name__}: {error}", "failed"
