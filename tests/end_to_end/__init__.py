"""Whole runs of the real programs."""
