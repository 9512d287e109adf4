"""Subcommands of `sunder` that need tests/: they are there in a checkout only. Same shape as coupler/sunder_tools/command."""
