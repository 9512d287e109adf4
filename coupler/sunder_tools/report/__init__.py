"""Reads what a run folder says in text: run.json, tables of columns, the scene behind it. Starts nothing."""
