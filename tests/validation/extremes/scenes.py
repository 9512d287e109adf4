"""Text of the scenes that `validate extremes` runs: a field a line, so that a refusal can be held to its line."""
from __future__ import annotations

from typing import Any, Sequence

GLASS: dict[str, Any] = {"density": 2500.0, "youngs_modulus": 70e9, "poisson_ratio": 0.22}
TOUGH = {"strength": 1e15, "fracture_energy": 8.0}  # never reached


def message(name: str, fields: dict[str, object]) -> str:
    """`name { field: value ... }`, a field a line; what is None is left out, what is a tuple is x, y, z."""
    lines = [f"{name} {{"]
    for key, value in fields.items():
        if isinstance(value, tuple):
            lines.append(f"{key} {{ " + " ".join(f"{axis}: {v!r}" for axis, v in zip("xyz", value)) + " }")
        elif isinstance(value, str) and value.startswith("{"):
            lines.append(f"{key} {value}")
        elif value is not None:
            lines.append(f"{key}: {str(value).lower() if isinstance(value, bool) else value}")
    return "\n".join(lines) + "\n}"


def quoted(text: str) -> str:
    return f'"{text}"'


def material(name: str = "glass", **fields: object) -> str:
    return message("materials", {"name": quoted(name), **fields})


def sheet(size: float | tuple[float, float] = 1.0, thickness: float = 0.01, elements: int = 8, *parts: str,
          **fields: object) -> str:
    """A square or rectangular plate in the plane z = 0 about the origin; `parts` are supports, loads and cuts."""
    size_x, size_y = size if isinstance(size, tuple) else (size, size)
    plate = message("plate", {"size_x_m": size_x, "size_y_m": size_y, "elements_x": elements, "elements_y": elements})
    return shell(plate, thickness, *parts, **fields)


def shell(patch: str, thickness: float, *parts: str, **fields: object) -> str:
    head = message("shells", {"name": quoted("sheet"), "material": quoted("glass"), "thickness_m": thickness, **fields})
    return "\n".join([head[:-2], patch, *parts, "}"])


def ball(radius: float, position: tuple[float, float, float], velocity: tuple[float, float, float],
         name: str = "ball", made_of: str = "steel") -> str:
    return "\n".join([message("bodies", {"name": quoted(name), "material": quoted(made_of),
                                         "sphere": f"{{ radius_m: {radius!r} }}"})[:-2],
                      "pose {", message("position", dict(zip("xyz", position))), "}",
                      "twist {", message("linear", dict(zip("xyz", velocity))), "}", "}"])


def scene(end: float, window: float, *parts: str, gravity: float = 0.0, probes: Sequence[str] = (),
          **fields: Any) -> str:
    """`probes`: 'ball' a body of that name, 'u v' a point of the sheet, whose columns are then p0, p1..."""
    asked = []
    for k, probe in enumerate(probes):
        u, _, v = probe.partition(" ")
        asked.append(message("probes", {"name": quoted(probe), "body": quoted(probe)} if not v else {
            "name": quoted(f"p{k}"), "shell": quoted("sheet"), "at": f"{{ u: {u} v: {v} }}"}))
    head = {"name": quoted("extreme"), "end_time_s": end, "window_s": window, **fields}
    return "\n".join([*(f"{key}: {value}" for key, value in head.items() if value is not None),
                      message("gravity", {"z": gravity}), *parts,
                      "\n".join([f"output {{\nframe_interval_s: {end}", *asked, "}"])]) + "\n"


CLAMPED = "supports { edges: ALL kind: CLAMPED }"
# edges held across the sheet, free to slide in it: Navier's plate
SIMPLE = "\n".join(["supports { edges: ALL kind: SIMPLY_SUPPORTED axes: Z }",
                    "supports { corners: U_MIN_V_MIN kind: SIMPLY_SUPPORTED }",
                    "supports { corners: U_MAX_V_MIN kind: SIMPLY_SUPPORTED axes: Y }"])
