"""`validate extremes`: scenes far from any use, each with what is expected of it, run by the real programs."""
