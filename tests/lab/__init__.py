"""Tests of the package that users import as `sunder`. Those of whole series run real programs, of SUNDER_BUILD_DIR."""
from tests import REPOSITORY

__all__ = ["REPOSITORY"]
