"""Tests of the package that users import as `sunder`. Those of whole series run real programs, of SUNDER_BUILD_DIR."""
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "coupler"))
