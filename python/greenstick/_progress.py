"""What ``progress=True`` shows."""

from __future__ import annotations

from typing import Any

_STEPS = 1000


class Bar:
    """A bar of tqdm, from 0 to 1."""

    def __init__(self, tqdm: Any) -> None:
        self._bar = tqdm(total=_STEPS, bar_format="{desc} {bar} {percentage:3.0f} % [{elapsed}<{remaining}]")

    def show(self, stage: str, fraction: float) -> None:
        """Shows how much of the whole is done, 0 to 1."""
        self._bar.set_description_str(stage, refresh=False)
        self._bar.update(int(fraction * _STEPS) - self._bar.n)

    def close(self) -> None:
        """Leaves the bar as it is."""
        self._bar.close()


def bar() -> Bar | None:
    """A bar where tqdm is installed."""
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return Bar(tqdm)
