"""What the tests have in common."""

from __future__ import annotations

import os
from pathlib import Path

ROOT = Path(__file__).parents[2]
SNAP = ROOT / ".ci/snap.toml"
# The program, built before the tests run.
PROGRAM = Path(os.environ.get("GREENSTICK_PROGRAM", ROOT / "target/release/greenstick"))
