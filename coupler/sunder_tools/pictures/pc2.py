"""Point caches (PC2, version 2) of a run, each beside a mesh file (OBJ) of the same points and faces; metres, y up.

A cache has one list of triangles, so each shape of a piece or body has a cache of its own, with all points in the world.
PC2 has no visibility: before the first frame of a shape and after its last, all points are at its thing's centre, as the
scale 0 of animated.py makes it. These are one sample each. A reader holds the first and the last sample, and so the cache
begins and ends with them.
"""
from __future__ import annotations

import csv
import io
import re
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

import numpy as np

from .glb import upright
from .materials import colour_of
from .rigid import turn_of
from .story import Shape, Thing
from .usda import identifier

MAGIC, VERSION = b"POINTCACHE2\0", 1
FRAMES_A_SAMPLE = 1.0
LIST, MATERIALS = "objects.csv", "materials.mtl"
COLUMNS = ("object", "name", "shell", "start", "samples", "first_frame", "last_frame", "points", "triangles")


@dataclass(frozen=True)
class Cache:
    """The points of a shape over the film."""
    name: str  # of its files
    thing: Thing
    shape: Shape
    start: int                # frame of the first sample
    samples: list[np.ndarray]  # (n, 3) [m] single precision, y up


def _world(thing: Thing, shape: Shape, k: int) -> np.ndarray:
    """Returns the points (n, 3) of a shape at frame k [m]; all are at the centre where it is not seen."""
    at = max(int(np.searchsorted(thing.keys, k, side="right")) - 1, 0)
    centre = thing.centre[at]
    if not shape.first <= k <= shape.last:
        return np.repeat(centre[None], len(shape.points[0]), axis=0)
    points = shape.points[0 if shape.rigid else k - shape.first]
    return points @ turn_of(thing.turn[at]).T + centre


def _cache(name: str, thing: Thing, shape: Shape, frames: int) -> Cache:
    start, last = max(shape.first - 1, 0), min(shape.last + 1, frames - 1)
    samples = [upright(_world(thing, shape, k)) for k in range(start, last + 1)]
    while len(samples) > 1 and np.array_equal(samples[-1], samples[-2]):
        samples.pop()  # the last one is held
    return Cache(name, thing, shape, start, samples)


def caches_of(things: list[Thing], frames: int) -> list[Cache]:
    """Returns the caches of a film of so many frames. Names are those of animated.py, of letters, digits and _."""
    taken: set[str] = set()
    folded: set[str] = set()
    found = []
    for thing in things:
        for number, shape in enumerate(thing.shapes):
            wanted = thing.name if len(thing.shapes) == 1 else f"{thing.name}_shape_{number}"
            name = identifier(wanted, taken)
            while name.lower() in folded:  # some file systems know no case
                name = identifier(wanted, taken)
            folded.add(name.lower())
            found.append(_cache(name, thing, shape, frames))
    return found


def pc2_bytes(cache: Cache) -> bytes:
    """Writes a point cache."""
    head = struct.pack("<12siiffi", MAGIC, VERSION, len(cache.samples[0]), float(cache.start), FRAMES_A_SAMPLE,
                       len(cache.samples))
    return head + b"".join(sample.astype("<f4").tobytes() for sample in cache.samples)


def obj_text(cache: Cache) -> str:
    """Writes the mesh as it is in the first frame in which it is seen."""
    shape = cache.shape
    points = cache.samples[shape.first - cache.start]
    turn = turn_of(cache.thing.turn[cache.thing.keys.index(shape.first)])
    lines = [f"# sunder export: frame {shape.first}, metres, y up", f"mtllib {MATERIALS}", f"o {cache.name}"]
    lines += ["v {:.9g} {:.9g} {:.9g}".format(*point) for point in points]
    lines += ["vn {:.6g} {:.6g} {:.6g}".format(*normal) for normal in upright(shape.normals[0] @ turn.T)]
    textured = np.isfinite(shape.uv).all()
    if textured:
        lines += ["vt {:.7g} {:.7g}".format(*uv) for uv in shape.uv]
    face = "f {0}/{0}/{0} {1}/{1}/{1} {2}/{2}/{2}" if textured else "f {0}//{0} {1}//{1} {2}//{2}"
    for slot in shape.slots:
        lines.append(f"usemtl {_word(slot.material)}")
        lines += [face.format(*corners) for corners in 1 + slot.first + slot.triangles]
    return "\n".join(lines) + "\n"


def _word(name: str) -> str:
    """A material's name as the format reads it: it ends at a space."""
    return re.sub(r"\s", "_", name)


def mtl_text(things: list[Thing]) -> str:
    """Writes all materials."""
    colours = {_word(slot.material): colour_of(slot.look)
               for thing in reversed(things) for shape in thing.shapes for slot in shape.slots}
    lines = []
    for name in sorted(colours):
        red, green, blue, *opacity = colours[name]
        lines += [f"newmtl {name}", f"Kd {red:.4g} {green:.4g} {blue:.4g}", f"d {opacity[0] if opacity else 1.0:.4g}", ""]
    return "\n".join(lines)


def list_text(caches: list[Cache]) -> str:
    """Writes the table of all objects."""
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow(COLUMNS)
    for cache in caches:
        shape = cache.shape
        table.writerow([cache.name, cache.thing.name, cache.thing.group, cache.start, len(cache.samples), shape.first, shape.last,
                        len(shape.points[0]), sum(len(slot.triangles) for slot in shape.slots)])
    return out.getvalue()


def write_caches(folder: Path, things: list[Thing], frames: int, put: Callable[[Path, bytes], None]) -> None:
    """Writes all files into a folder, by `put(path, content)`. Those of an earlier export are removed first, by its list.
    Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    _forget(folder)
    caches = caches_of(things, frames)
    for cache in caches:
        put(folder / f"{cache.name}.obj", obj_text(cache).encode())
        put(folder / f"{cache.name}.pc2", pc2_bytes(cache))
    put(folder / MATERIALS, mtl_text(things).encode())
    put(folder / LIST, list_text(caches).encode())


def _forget(folder: Path) -> None:
    """Removes the objects of an earlier export: they would be taken for those of this one."""
    try:
        rows = list(csv.reader((folder / LIST).read_text().splitlines()))
    except (FileNotFoundError, UnicodeDecodeError, csv.Error):
        return
    if not rows or rows[0] != list(COLUMNS):
        return
    for row in rows[1:]:
        if row and re.fullmatch(r"\w+", row[0], re.ASCII):
            for ending in (".obj", ".pc2"):
                (folder / f"{row[0]}{ending}").unlink(missing_ok=True)
