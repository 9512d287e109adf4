"""Writes patches as a STEP file (AP214): open shells of faces that share edges and corners."""
from __future__ import annotations

from pathlib import Path
from typing import Protocol

import numpy as np


class Face(Protocol):
    """A quadratic patch: control points `net` (along v, along u, 3) over uniform knots."""
    name: str
    net: np.ndarray

    def edge(self, side: str) -> np.ndarray:
        """Returns the control points of an edge, along u or v."""


class _Entities:
    """Collects the numbered lines of the data section."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def add(self, text: str) -> str:
        self.lines.append(f"#{len(self.lines) + 1}={text};")
        return f"#{len(self.lines)}"

    def point(self, p: np.ndarray) -> str:
        return self.add(f"CARTESIAN_POINT('',({','.join(_real(c) for c in p)}))")


def _real(value: float) -> str:
    text = f"{value:.9f}".rstrip("0")
    return "0." if text == "-0." else text


def _knots(spans: int) -> tuple[str, str]:
    """Returns multiplicities and knots."""
    inner = ["1"] * (spans - 1)
    return f"({','.join(['3', *inner, '3'])})", f"({','.join(f'{k}.' for k in range(spans + 1))})"


class _Topology:
    """Adds each corner and each edge once, for all faces that share it."""

    def __init__(self, entities: _Entities) -> None:
        self._entities = entities
        self._vertices: dict[tuple, str] = {}
        self._edges: dict[tuple, tuple[str, bool]] = {}

    def vertex(self, p: np.ndarray) -> str:
        key = tuple(np.round(p, 9) + 0.0)
        if key not in self._vertices:
            self._vertices[key] = self._entities.add(f"VERTEX_POINT('',{self._entities.point(p)})")
        return self._vertices[key]

    def oriented_edge(self, points: np.ndarray) -> str:
        """Adds the edge along control points (n, 3), from the first to the last."""
        key = tuple(map(tuple, np.round(points, 9) + 0.0))
        if key not in self._edges:
            add = self._entities.add
            count, knots = _knots(len(points) - 2)
            poles = ",".join(self._entities.point(p) for p in points)
            spline = add(f"B_SPLINE_CURVE_WITH_KNOTS('',2,({poles}),.UNSPECIFIED.,.F.,.F.,"
                         f"{count},{knots},.UNSPECIFIED.)")
            edge = add(f"EDGE_CURVE('',{self.vertex(points[0])},{self.vertex(points[-1])},{spline},.T.)")
            self._edges[key] = edge, True
            self._edges[key[::-1]] = edge, False
        edge, forwards = self._edges[key]
        return self._entities.add(f"ORIENTED_EDGE('',*,*,{edge},.{'T' if forwards else 'F'}.)")


def write_step(file: Path, patches: list[Face]) -> None:
    """Writes the patches as faces 0, 1, ... in metres; u cross v is the normal."""
    write_bodies(file, "car", {"car": patches}, "make_car.py")


def write_bodies(file: Path, product: str, bodies: dict[str, list[Face]], script: str) -> None:
    """Writes each body as an open shell of that name; faces are numbered through all of them. `script` is what the file
    says made it."""
    data = _Entities()
    topology = _Topology(data)
    models = [_add_body(data, topology, name, patches) for name, patches in bodies.items()]
    _add_product(data, product, models)
    # The file has no date, so the same shape gives the same file.
    head = ["ISO-10303-21;", "HEADER;", "FILE_DESCRIPTION((''),'2;1');",
            f"FILE_NAME('{file.name}','',(''),(''),'{script}','','');",
            "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));", "ENDSEC;", "DATA;"]
    file.write_text("\n".join([*head, *data.lines, "ENDSEC;", "END-ISO-10303-21;"]) + "\n")


def _add_body(data: _Entities, topology: _Topology, name: str, patches: list[Face]) -> str:
    faces = []
    for patch in patches:
        (nu, ku), (nv, kv) = (_knots(count - 2) for count in patch.net.shape[1::-1])
        columns = [f"({','.join(data.point(p) for p in patch.net[:, i])})" for i in range(patch.net.shape[1])]
        surface = data.add(f"B_SPLINE_SURFACE_WITH_KNOTS('{patch.name}',2,2,({','.join(columns)}),.UNSPECIFIED.,"
                           f".F.,.F.,.F.,{nu},{nv},{ku},{kv},.UNSPECIFIED.)")
        border = [topology.oriented_edge(edge) for edge in
                  (patch.edge("v_min"), patch.edge("u_max"), patch.edge("v_max")[::-1], patch.edge("u_min")[::-1])]
        loop = data.add(f"EDGE_LOOP('',({','.join(border)}))")
        bound = data.add(f"FACE_OUTER_BOUND('',{loop},.T.)")
        faces.append(data.add(f"ADVANCED_FACE('{patch.name}',({bound}),{surface},.T.)"))
    shell = data.add(f"OPEN_SHELL('{name}',({','.join(faces)}))")
    return data.add(f"SHELL_BASED_SURFACE_MODEL('{name}',({shell}))")


def _add_product(data: _Entities, name: str, models: list[str]) -> None:
    application = data.add("APPLICATION_CONTEXT('automotive design')")
    data.add(f"APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,{application})")
    context = data.add(f"PRODUCT_CONTEXT('',{application},'mechanical')")
    product = data.add(f"PRODUCT('{name}','{name}','',({context}))")
    data.add(f"PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,({product}))")
    formation = data.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
    stage = data.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')")
    definition = data.add(f"PRODUCT_DEFINITION('design','',{formation},{stage})")
    shape = data.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")
    metre = data.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT($,.METRE.))")
    radian = data.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    steradian = data.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
    accuracy = data.add(f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-7),{metre},'distance_accuracy_value','')")
    world = data.add(f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({accuracy}))"
                     f"GLOBAL_UNIT_ASSIGNED_CONTEXT(({metre},{radian},{steradian}))REPRESENTATION_CONTEXT('',''))")
    origin = data.point(np.zeros(3))
    axes = [data.add(f"DIRECTION('',({a}))") for a in ("0.,0.,1.", "1.,0.,0.")]
    placement = data.add(f"AXIS2_PLACEMENT_3D('',{origin},{axes[0]},{axes[1]})")
    whole = data.add(f"MANIFOLD_SURFACE_SHAPE_REPRESENTATION('',({placement},{','.join(models)}),{world})")
    data.add(f"SHAPE_DEFINITION_REPRESENTATION({shape},{whole})")
