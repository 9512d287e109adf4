"""The Python side of the command `sunder`, by product: `command` over `pictures`, `launch` and `report`.

Only the standard library is needed up to the first picture; numpy and PIL are imported then.
"""
