"""What the tests have in common."""

from __future__ import annotations

import importlib
import os
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
SNAP = ROOT / ".ci/snap.toml"
# The program, built before the tests run.
PROGRAM = Path(os.environ.get("GREENSTICK_PROGRAM", ROOT / "target/release/greenstick"))


def needs(package: str, variable: str) -> Any:
    """A package that not everybody has. Without it the test is skipped, or fails where the environment variable is set."""
    return importlib.import_module(package) if os.environ.get(variable) else pytest.importorskip(package)
