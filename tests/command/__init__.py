"""Tests of the command `sunder`, with fake executables; see fakes.py."""
import sys
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "coupler"))
