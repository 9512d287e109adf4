"""Validation by whole runs, beside the C++ cases of this folder: each case against an exact or a published answer."""
