"""Validation by whole runs, beside the C++ cases of this folder. Each case is compared with an exact or published
result."""
