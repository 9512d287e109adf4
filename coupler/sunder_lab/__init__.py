"""Experiments with Sunder: scenes as messages, runs as arrays, series of runs. Users write `import sunder`."""
