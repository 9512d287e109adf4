"""Reader for the frames that the shell process writes: VTK XML PolyData, raw appended data.

Strict on purpose: what is not exactly as shell/io writes it is an error, never a guess.
"""
from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

TYPES: dict[str, np.dtype] = {"Float64": np.dtype("<f8"), "Float32": np.dtype("<f4"),
         "Int64": np.dtype("<i8"), "Int32": np.dtype("<i4")}


class VtpError(ValueError):
    """The file is not a frame; the message names the file and what is wrong."""


@dataclass
class PolyData:
    """One .vtp file. Cells are in the file's order: vertices, then lines, then polygons."""
    points: np.ndarray  # (n, 3) float64 [m]
    verts: np.ndarray = field(default_factory=lambda: np.zeros((0,), int))          # point per cell
    line_points: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))  # of all polylines, one after another
    line_bounds: np.ndarray = field(default_factory=lambda: np.zeros(1, np.int64))  # where each begins, and the end
    triangles: np.ndarray = field(default_factory=lambda: np.zeros((0, 3), int))    # (m, 3) points
    point_data: dict[str, np.ndarray] = field(default_factory=dict)
    cell_data: dict[str, np.ndarray] = field(default_factory=dict)
    # (k,) each: TimeValue [s]; where there are shells, shell_name (texts) and shell_area_m2
    field_data: dict[str, np.ndarray] = field(default_factory=dict)

    def of_triangles(self, name: str, default: float) -> np.ndarray:
        """Cell data of the triangles only; `default` everywhere where the array is absent."""
        values = self.cell_data.get(name)
        if values is None:
            return np.full(len(self.triangles), default)
        return values[len(values) - len(self.triangles):]

    def segments(self) -> np.ndarray:
        """All polylines as (k, 2) pairs of points."""
        goes_on = np.ones(len(self.line_points), bool)
        goes_on[self.line_bounds[1:] - 1] = False  # the last point of each
        first = np.flatnonzero(goes_on)
        return np.stack([self.line_points[first], self.line_points[first + 1]], axis=1)


def read_vtp(path: Path) -> PolyData:
    """Reads one file. Raises VtpError if it is truncated or otherwise not a frame, OSError if absent."""
    return _Reader(path).read()


class _Reader:
    def __init__(self, path: Path) -> None:
        self._path = path
        self._data = path.read_bytes()
        self._begin = 0  # of the appended data, after the '_'
        self._end = 0  # first byte after the last array read, from the start of the appended data

    def _fail(self, what: str) -> VtpError:
        return VtpError(f"{self._path}: {what}")

    def _require(self, condition: bool, what: str) -> None:
        if not condition:
            raise self._fail(what)

    def read(self) -> PolyData:
        opening = re.search(rb'<AppendedData\s+encoding="raw"\s*>\s*_', self._data)
        if opening is None:
            raise self._fail("no <AppendedData encoding=\"raw\"> section")
        self._begin = opening.end()
        try:
            root = ElementTree.fromstring(self._data[:opening.start()] + b"</VTKFile>")
        except ElementTree.ParseError as error:
            raise self._fail(f"header: {error}") from None
        for key, wanted in (("type", "PolyData"), ("byte_order", "LittleEndian"), ("header_type", "UInt64")):
            self._require(root.get(key) == wanted, f"{key} is {root.get(key)!r}, must be {wanted!r}")
        self._require(root.get("compressor") is None, "compressed; must be plain")
        pieces = root.findall("PolyData/Piece")
        self._require(len(pieces) == 1, f"{len(pieces)} pieces, must be 1")
        piece = pieces[0]
        count = {key: self._integer(piece, "NumberOf" + key) for key in ("Points", "Verts", "Lines", "Strips", "Polys")}
        self._require(count["Strips"] == 0, "strips are not supported")

        arrays = piece.findall("Points/DataArray")
        self._require(len(arrays) == 1, f"{len(arrays)} arrays of points, must be 1")
        points = self._array(arrays[0], count["Points"]).astype(float)
        self._require(points.shape[1:] == (3,) and bool(np.isfinite(points).all()),
                      "points must be three finite numbers each")
        verts, vert_bounds = self._cells(piece, "Verts", count)
        self._require(bool((np.diff(vert_bounds) == 1).all()), "a vertex cell that is not one point")
        lines, line_bounds = self._cells(piece, "Lines", count)
        polys, poly_bounds = self._cells(piece, "Polys", count)
        self._require(bool((np.diff(line_bounds) > 0).all()), "a line without points")
        self._require(bool((np.diff(poly_bounds) == 3).all()), "a polygon that is not a triangle")
        data = PolyData(
            points, verts, lines, line_bounds, polys.reshape(-1, 3),
            self._named(piece, "PointData", count["Points"]),
            self._named(piece, "CellData", count["Verts"] + count["Lines"] + count["Polys"]), self._fields(root))
        closing = self._data[self._begin + self._end:]
        self._require(re.fullmatch(rb"\s*</AppendedData>\s*</VTKFile>\s*", closing) is not None,
                      "does not end after its last array; truncated or overwritten")
        return data

    def _integer(self, element: ElementTree.Element, key: str) -> int:
        text = element.get(key, "0")
        self._require(text.isascii() and text.isdigit(), f"{key} is {text!r}, must be a count")
        return int(text)

    def _array(self, element: ElementTree.Element, tuples: int | None) -> np.ndarray:
        """The values of a DataArray; (tuples,) or (tuples, components). None: as many as there are."""
        name = element.get("Name", "?")
        kind = TYPES.get(element.get("type", ""))
        if kind is None:
            raise self._fail(f"array {name!r}: type {element.get('type')!r}, must be one of {', '.join(TYPES)}")
        self._require(element.get("format") == "appended", f"array {name!r}: format must be 'appended'")
        self._require("offset" in element.keys(), f"array {name!r}: has no offset")
        start = self._begin + self._integer(element, "offset")
        self._require(start + 8 <= len(self._data), f"array {name!r}: starts beyond the end; truncated")
        size = int(np.frombuffer(self._data, "<u8", 1, start)[0])
        self._require(size <= len(self._data) - start - 8,
                      f"array {name!r}: {size} bytes announced, {len(self._data) - start - 8} left; truncated")
        components = self._integer(element, "NumberOfComponents") if "NumberOfComponents" in element.keys() else 1
        self._require(components >= 1, f"array {name!r}: no components")
        if tuples is None:
            tuples = size // (kind.itemsize * components)
        self._require(size == tuples * components * kind.itemsize,
                      f"array {name!r}: {size} bytes, must be {tuples} x {components} x {kind.itemsize}")
        self._end = max(self._end, start + 8 + size - self._begin)
        values = np.frombuffer(self._data, kind, tuples * components, start + 8)
        return values if components == 1 else values.reshape(tuples, components)

    def _cells(self, piece: ElementTree.Element, section: str,
               count: dict[str, int]) -> tuple[np.ndarray, np.ndarray]:
        """Point indices of a section's cells one after the other, and where each begins (cells + 1)."""
        arrays = {a.get("Name"): a for a in piece.findall(f"{section}/DataArray")}
        if count[section] == 0 and not arrays:
            return np.zeros(0, np.int64), np.zeros(1, np.int64)
        self._require({"connectivity", "offsets"} <= set(arrays), f"{section}: needs connectivity and offsets")
        offsets = self._array(arrays["offsets"], count[section])
        connectivity = self._array(arrays["connectivity"], None)
        self._require(offsets.dtype.kind == "i" and connectivity.dtype.kind == "i" and connectivity.ndim == 1,
                      f"{section}: connectivity and offsets must be integers")
        bounds = np.concatenate([[0], offsets]).astype(np.int64)
        self._require(bool((np.diff(bounds) >= 0).all()) and int(bounds[-1]) == len(connectivity),
                      f"{section}: offsets do not match the connectivity")
        self._require(len(connectivity) == 0 or (connectivity.min() >= 0 and connectivity.max() < count["Points"]),
                      f"{section}: index of a point that does not exist")
        return connectivity.astype(np.int64), bounds

    def _fields(self, root: ElementTree.Element) -> dict[str, np.ndarray]:
        """Numbers and texts that belong to no point or cell. They are in the header; texts are bytes with a zero after each."""
        found = {}
        for element in root.findall("PolyData/FieldData/*"):
            name, kind = element.get("Name", "?"), element.get("type", "")
            self._require(element.get("format") == "ascii", f"field {name!r}: format must be 'ascii'")
            self._require(kind == "String" or kind in TYPES,
                          f"field {name!r}: type {kind!r}, must be String or one of {', '.join(TYPES)}")
            words = (element.text or "").split()
            try:
                if kind == "String":
                    texts = bytes(map(int, words)).decode().split("\0")
                    values = np.array(texts[:-1], str)
                    if texts[-1]:
                        raise ValueError(f"the text {texts[-1]!r} has no zero after it")
                else:
                    values = np.array([float(word) if TYPES[kind].kind == "f" else int(word) for word in words], TYPES[kind])
            except (ValueError, OverflowError) as error:
                raise self._fail(f"field {name!r}: {error}") from None
            self._require(len(values) == self._integer(element, "NumberOfTuples"),
                          f"field {name!r}: {len(values)} values, must be {element.get('NumberOfTuples')}")
            found[name] = values
        return found

    def _named(self, piece: ElementTree.Element, section: str, tuples: int) -> dict[str, np.ndarray]:
        return {a.get("Name", "?"): self._array(a, tuples) for a in piece.findall(f"{section}/DataArray")}
