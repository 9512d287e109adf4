"""The Python side of the command `sunder`: install, build, launch, watch, draw.

Only the standard library is needed up to the first picture; numpy and PIL are imported then.
"""
