"""The settings that trade speed for accuracy: which of them a scene has, to what each may be turned, what that may cost.

A change is what one knob does to a scene. Whether a scene bears it is judged by the solver's own check when it is run; what
is left out here is what cannot mean anything for the scene.
"""
from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Callable

from sunder_tools.launch.fidelity import PRESETS, Preset

from ..scene import Scene

ROOT_2 = math.sqrt(2.0)
ELEMENTS = (0.5, 1.0 / ROOT_2, ROOT_2, 2.0)  # times the scene's own, in either direction
LAYERS = (2, 3, 5, 7, 9, 11)
SAFETIES = (0.4, 0.6, 0.8, 0.95)
WINDOWS = (0.25, 0.5, 2.0, 4.0)              # times the scene's own
DEFAULT_SAFETY, DEFAULT_LAYERS = 0.8, 2      # proto/scene.proto
SCHEMES = ("PROXY", "EXPORTED", "ITERATED", "STAGGERED", "LAGGED")
MODELS = ("PLANE_STRESS", "PAPER_PROJECTION", "JGT17", "GHF18")
TRANSFERS = ("DIRECT", "FLIP", "APIC")
ENGINES = ("bullet", "ode", "freeflight", "inprocess")
KNOBS = ("elements", "layers", "gauss_points", "bending", "stress_model", "transfer", "time_step_safety", "window",
         "scheme", "degree", "engine", "fidelity")
LENGTH = "element_m"  # of patches that are divided by the length of an element
# These come nearer to the exact answer of the scene's own model. The others replace a law or a scheme: where one of them is
# nearer to the reference than what it replaces, two errors happen to cancel.
CONVERGING = ("elements", "layers", "gauss_points", "time_step_safety", "window", "degree", "fidelity")
# What a user may look for and not find.
NO_SUCH = {
    "extraction interval": "there is no such setting: cracks are looked at so often that an edge's travel at the Rayleigh speed "
                           "takes two looks",
    "precision of tables": "there is no such setting: tables of shape functions are in double precision",
}


@dataclass(frozen=True)
class Change:
    """One knob turned: `apply` changes a scene, `cost` is a guess of the factor in run time, `engine` replaces the run's."""
    knob: str
    value: str
    cost: float
    apply: Callable[[Scene], None]
    engine: str | None = None

    @property
    def label(self) -> str:
        """As it stands in tables: 'elements x0.5'."""
        return f"{self.knob} {self.value}"


@dataclass(frozen=True)
class Setting:
    """Changes made together, none of the same knob; none at all is the scene's own."""
    changes: tuple[Change, ...] = ()

    @property
    def label(self) -> str:
        """'own', or the labels of the changes."""
        return ", ".join(c.label for c in self.changes) or "own"

    @property
    def converging(self) -> "Setting":
        """Without the changes that replace a law or a scheme."""
        return Setting(tuple(c for c in self.changes if c.knob in CONVERGING))

    @property
    def guess(self) -> float:
        """Factor in run time, of the scene's own."""
        return math.prod(c.cost for c in self.changes)

    def scene(self, scene: Scene) -> Scene:
        """A changed copy."""
        out = scene.copy()
        for change in self.changes:
            change.apply(out)
        return out

    def engine(self, own: str) -> str:
        """The engine that it asks for, else the run's."""
        return next((c.engine for c in self.changes if c.engine), own)


def breaks(scene: Scene) -> bool:
    """Whether cracks may come by themselves."""
    message = scene.message
    strong = {m.name for m in message.materials if m.HasField("strength")}
    cuts_only = message.fracture.DESCRIPTOR.enum_types_by_name["Mode"].values_by_name["CUTS"].number
    return message.fracture.mode != cuts_only and any(s.material in strong for s in message.shells)


def moves(scene: Scene) -> bool:
    """Whether bodies are there that the shell can push."""
    return any(not b.is_static and b.WhichOneof("shape") != "half_space" for b in scene.message.bodies)


def weakens(scene: Scene) -> bool:
    """Whether layers have a state of their own: they yield, take damage, or are tempered."""
    message = scene.message
    yielding = {m.name for m in message.materials if m.HasField("yield_stress")}
    damage = message.fracture.DESCRIPTOR.enum_types_by_name["Mode"].values_by_name["DAMAGE"].number
    return ((message.fracture.mode == damage and breaks(scene)) or any(
        s.material in yielding or s.HasField("surface_compression") for s in message.shells))


def changes_of(scene: Scene, engine: str) -> tuple[list[Change], dict[str, str]]:
    """Every single change that means something for the scene, and why knobs were left out."""
    out: list[Change] = []
    left: dict[str, str] = {}
    for name, make in (("elements", _elements), ("layers", _layers), ("gauss_points", _gauss_points), ("bending", _bending),
                       ("stress_model", _stress_model), ("transfer", _transfer), ("time_step_safety", _safety),
                       ("window", _window), ("scheme", _scheme), ("degree", _degree)):
        made = make(scene)
        if isinstance(made, str):
            left[name] = made
        out += made if isinstance(made, list) else []
    if moves(scene) or breaks(scene):
        out += [Change("engine", e, 1.0, lambda scene: None, e) for e in ENGINES if e != engine]
    else:
        left["engine"] = "the scene has no body for an engine to move, and nothing comes off"
    out += [_preset(name) for name, preset in PRESETS.items() if preset != Preset()]
    return out, {**left, **NO_SUCH}


def elements(factor: float) -> Change:
    """Of every shell that says how many or how long; a substep lasts as long as a wave takes through one, hence the third
    power."""
    def apply(scene: Scene) -> None:
        for patch, names in _counted(scene):
            for name in names:
                if name == LENGTH:
                    setattr(patch, name, float(f"{getattr(patch, name) / factor:.6g}"))
                else:
                    setattr(patch, name, max(1, round(getattr(patch, name) * factor)))
    return Change("elements", f"x{factor:.3g}", factor ** 3, apply)


def window(factor: float) -> Change:
    """window_s times `factor`; settle_window_s stays a whole multiple of it."""
    def apply(scene: Scene) -> None:
        message = scene.message
        message.window_s = float(f"{message.window_s * factor:.12g}")
        if message.HasField("settle_window_s"):
            times = max(1, round(message.settle_window_s / message.window_s))
            message.settle_window_s = times * message.window_s
    return Change("window", f"x{factor:.3g}", 1.0, apply)


def layers(count: Callable[[int], int], name: str, cost: float) -> Change:
    """`count` makes the number of layers from a shell's own."""
    def apply(scene: Scene) -> None:
        for shell in _layered(scene):
            shell.layers = min(16, max(2, count(_layers_of(shell))))
    return Change("layers", name, cost, apply)


def _preset(name: str) -> Change:
    """What `sunder run --fidelity` would take."""
    def apply(scene: Scene) -> None:
        scene.fidelity(name)
    return Change("fidelity", name, PRESETS[name].elements ** 3, apply)


def finer(scene: Scene, level: int) -> Setting:
    """All that converges, `level` times finer by the root of two in space (coarser where negative), and the window by two;
    layers two more a level, where they have a state of their own. Level 0 is the scene's own."""
    if level == 0:
        return Setting()
    factor = ROOT_2 ** level
    changes = [elements(factor)]
    if moves(scene) or breaks(scene):
        changes.append(window(0.5 ** level))
    if weakens(scene) and _layered(scene):
        own = max(_layers_of(s) for s in _layered(scene))
        most = min(16, max(2, own + 2 * level))
        changes.append(layers(lambda n: n + most - own, f"{most}", (most / own) ** 0.9))
    return Setting(tuple(changes))


def _counted(scene: Scene) -> list[tuple[Any, list[str]]]:
    """Patches and the names of those of their fields that count elements, or give their length."""
    out = []
    for shell in scene.message.shells:
        patch = getattr(shell, shell.WhichOneof("patch") or "plate")
        names = [n for n in ("elements_x", "elements_y", "elements_u", "elements_v", LENGTH)
                 if n in patch.DESCRIPTOR.fields_by_name and patch.HasField(n)]
        if names:
            out.append((patch, names))
    return out


def _elements(scene: Scene) -> list[Change] | str:
    if not _counted(scene):
        return "no shell says how many elements it has, or how long they are: they are those of the knots"
    return [elements(factor) for factor in ELEMENTS]


def _layered(scene: Scene) -> list[Any]:
    return [s for s in scene.message.shells if s.bending == s.DESCRIPTOR.fields_by_name["bending"].enum_type.values_by_name[
        "LAYERED"].number]


def _layers_of(shell: Any) -> int:
    return int(shell.layers) if shell.HasField("layers") else DEFAULT_LAYERS


def _layers(scene: Scene) -> list[Change] | str:
    shells = _layered(scene)
    if not shells:
        return "bending is LINEAR, which has none"
    own = max(_layers_of(s) for s in shells)
    around = [n for n in LAYERS if n < own][-2:] + [n for n in LAYERS if n > own][:2]

    def to(n: int) -> Callable[[int], int]:
        return lambda _: n

    return [layers(to(n), str(n), (n / own) ** 0.9) for n in around]


def _degree_of(shell: Any) -> int:
    patch = getattr(shell, shell.WhichOneof("patch") or "plate")
    return int(patch.degree) if "degree" in patch.DESCRIPTOR.fields_by_name and patch.HasField("degree") else 2


def _gauss_points(scene: Scene) -> list[Change] | str:
    shells = list(scene.message.shells)
    more = [s for s in shells if not s.HasField("gauss_points") or s.gauss_points == _degree_of(s)]

    def apply(scene: Scene) -> None:
        for shell in scene.message.shells:
            shell.gauss_points = _degree_of(shell) + (1 if more else 0)

    degree = max((_degree_of(s) for s in shells), default=2)
    if not shells:
        return "the scene has no shell"
    return [Change("gauss_points", str(degree + 1), (1 + 1 / degree) ** 2, apply) if more else
            Change("gauss_points", str(degree), (1 - 1 / (degree + 1)) ** 2, apply)]


def _bending(scene: Scene) -> list[Change] | str:
    if weakens(scene):
        return "layers yield, take damage or are tempered: bending LINEAR has none"
    if any(s.HasField("interlayer") for s in scene.message.shells):
        return "bending LINEAR has no interlayer"
    value = "LINEAR" if _layered(scene) else "LAYERED"

    def apply(scene: Scene) -> None:
        for shell in scene.message.shells:
            shell.ClearField("layers")
            shell.bending = shell.DESCRIPTOR.fields_by_name["bending"].enum_type.values_by_name[value].number
    return [Change("bending", value, 0.6 if value == "LINEAR" else 1.7, apply)]


def _stress_model(scene: Scene) -> list[Change] | str:
    own = {scene[f"shells[{k}].stress_model"] for k in range(len(scene.message.shells))}

    def to(model: str) -> Change:
        def apply(scene: Scene) -> None:
            for k in range(len(scene.message.shells)):
                scene[f"shells[{k}].stress_model"] = model
        return Change("stress_model", model, 1.0, apply)

    return [to(model) for model in MODELS if own != {model}]


def _transfer(scene: Scene) -> list[Change] | str:
    if scene.message.HasField("seams"):
        return "a scene with seams sends no velocities through a grid"

    def to(kind: str) -> Change:
        def apply(scene: Scene) -> None:
            scene["transfer.kind"] = kind
            if kind == "DIRECT":
                scene.message.transfer.ClearField("grid_spacing_m")
        return Change("transfer", kind, 0.25 if kind == "DIRECT" else 4.0, apply)

    return [to(kind) for kind in TRANSFERS if scene["transfer.kind"] != kind]


def _safety(scene: Scene) -> list[Change] | str:
    if scene.message.HasField("time_step_s"):
        return "the scene gives its time_step_s itself"
    own = scene.message.time_step_safety if scene.message.HasField("time_step_safety") else DEFAULT_SAFETY

    def to(value: float) -> Change:
        def apply(scene: Scene) -> None:
            scene["time_step_safety"] = value
        return Change("time_step_safety", f"{value:g}", own / value, apply)

    return [to(value) for value in SAFETIES if abs(value - own) > 1e-3]


def _window(scene: Scene) -> list[Change] | str:
    if not (moves(scene) or breaks(scene)):
        return "the scene has no body that moves, and nothing comes off: a window exchanges nothing"
    return [window(factor) for factor in WINDOWS if scene.message.window_s * factor <= scene.message.end_time_s]


def _scheme(scene: Scene) -> list[Change] | str:
    if not moves(scene):
        return "no body moves"

    def to(scheme: str) -> Change:
        def apply(scene: Scene) -> None:
            scene["coupling.scheme"] = scheme
        return Change("scheme", scheme, 3.0 if scheme == "ITERATED" else 1.0, apply)

    return [to(scheme) for scheme in SCHEMES if scene["coupling.scheme"] != scheme]


def _degree(scene: Scene) -> list[Change] | str:
    made = ("plate", "cylinder", "sphere", "cone", "annulus")
    if not all(s.WhichOneof("patch") in made for s in scene.message.shells):
        return "knots, or a file, give the degree"
    degree = 3 if any(_degree_of(s) == 2 for s in scene.message.shells) else 2

    def apply(scene: Scene) -> None:
        for shell in scene.message.shells:
            shell.ClearField("gauss_points")  # each degree has its own
            getattr(shell, shell.WhichOneof("patch")).degree = degree
    return [Change("degree", str(degree), 3.0 if degree == 3 else 0.33, apply)]
