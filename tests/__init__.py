"""Tests, validation, benchmarks, and the subcommands of `sunder` that run them. Puts coupler/ on the path of Python."""
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[1]
if str(REPOSITORY / "coupler") not in sys.path:
    sys.path.insert(0, str(REPOSITORY / "coupler"))
