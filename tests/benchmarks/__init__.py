"""Benchmarks: programs that measure, goals of their numbers, and whole runs that are measured."""
