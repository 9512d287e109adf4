"""Memory that pictures take again and again stays with the process."""
from __future__ import annotations

import ctypes

TRIM_THRESHOLD, MMAP_THRESHOLD = -1, -3  # of mallopt, malloc.h
MOST = 1 << 30                           # [bytes] that are kept, and the largest block of them


def keep_memory() -> None:
    """Has the C library keep freed memory for the next array. The system hands out pages that are new and zero, which took a
    quarter of the time of a picture. Does nothing where the library has no mallopt."""
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (OSError, AttributeError):
        return
    for option in (TRIM_THRESHOLD, MMAP_THRESHOLD):
        mallopt(option, MOST)
