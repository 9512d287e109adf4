"""Where the project is, and the variable that names another build of it."""
from __future__ import annotations

from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
BUILD_DIR_VARIABLE = "SUNDER_BUILD_DIR"
