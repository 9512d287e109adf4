"""Measures of an impact: force, impulse and velocity of the striking body, and the energy that it lost, by cause."""
from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real
from typing import Any

import numpy as np

from sunder_tools.errors import CommandError
from sunder_tools.words import did_you_mean

from .measures import Stated
from .scene import Results, Scene
from .schema import with_preset

STANDARD_GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2], for a scene without gravity field
UNTOUCHED = 1e-7  # share of the body's momentum that is round-off of the nine digits in probes.csv, over all rows
NO_PUSH = 1e-3  # share of the largest impulse: contact has ended where less is to come
SETTLED = 0.02  # last share of the record in which nothing pushes a body whose values are final
FORCE, INTERVAL = "mean_force_N", "mean_force_interval_s"  # columns of `impact` with an interval
FEWEST_ROWS = 4  # of the probe, in an interval over which a force is taken
AT_REST = 1e-9  # share of the first speed: round-off of the nine digits in probes.csv
LAST_SHARE = 0.1  # last share of the record, in which a body that went through
STILL_SLOWED = 0.02  # loses less than this share of its speed, although splinters may still touch it
ENERGIES = ("lost", "motion", "elastic", "fracture", "plastic", "faces", "contact", "damping", "frozen", "handoff", "engine", "other",
            "missing")  # of energy_taken


@dataclass(frozen=True)
class Motion:
    """Motion of a body from its probe. `time` (n,) [s]; `position`, `velocity`, `impulse` (n, 3) [m], [m/s], [N s]."""
    name: str
    mass: float            # [kg]
    gravity: np.ndarray    # (3,) [m/s^2]
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray

    @property
    def impulse(self) -> np.ndarray:
        """Returns the impulse (n, 3) [N s] on the body since the start, without gravity."""
        fallen = self.gravity * (self.time - self.time[0])[:, None]
        return self.mass * (self.velocity - self.velocity[0] - fallen)

    def force(self, over_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Returns middles of intervals (k,) [s] that follow one another, and the mean force in each (k, 3) [N], without
        gravity.

        An interval has at least `over_s` [s]. Its mean is exact: the impulse in it over its length. The default contact
        acts by impulses, so a force over ever shorter intervals has no limit. Keep `over_s` where windows change.
        """
        keep = [0]
        for k in range(1, len(self.time)):
            if self.time[k] - self.time[keep[-1]] >= over_s * (1.0 - 1e-9):
                keep.append(k)
        time, impulse = self.time[keep], self.impulse[keep]
        if len(time) < 2:
            raise CommandError(f"probe of '{self.name}': no two rows {over_s} s apart")
        return 0.5 * (time[1:] + time[:-1]), np.diff(impulse, axis=0) / np.diff(time)[:, None]

    @property
    def contact_until(self) -> float:
        """Returns the time [s] after which less than a thousandth of the largest impulse is to come; 0 without an
        impulse. At the end of the run, final values are not final yet (`settled`)."""
        most = np.linalg.norm(self.impulse, axis=1).max()
        if most <= UNTOUCHED * self.mass * float(np.linalg.norm(self.velocity, axis=1).max()):
            return 0.0
        left = np.linalg.norm(self.impulse - self.impulse[-1], axis=1)
        return float(self.time[1 + int(np.flatnonzero(left > NO_PUSH * most)[-1])]) if most > 0.0 else 0.0

    @property
    def settled(self) -> bool:
        """Returns whether the body was touched, and its last contact ended before the last two hundredths of the record.
        Otherwise it has not arrived, or may still be pushed, and what is final of it is that of the moment."""
        return 0.0 < self.contact_until <= self.time[-1] - SETTLED * (self.time[-1] - self.time[0])

    def largest_mean_force(self, interval_s: float) -> float:
        """Returns the largest mean force over any interval of this length [N], without gravity.

        It is the largest impulse in such an interval over its length. It converges as windows get shorter, since the
        interval stays; within it, the force may have been larger. The impulse of a window is spread over it: where a
        first touch is late in its window, the mean is too small by up to the force after it times window over interval.
        Raises CommandError where rows of the probe are too far apart to tell.
        """
        check_interval(interval_s)
        if interval_s > self.time[-1] - self.time[0]:
            raise CommandError(f"probe of '{self.name}': interval_s is {interval_s:g}, but its rows cover "
                               f"{self.time[-1] - self.time[0]:g} s only")
        # Between rows the impulse is linear, so the largest one in an interval is in one that begins or ends at a row.
        first = np.unique(np.concatenate([self.time, self.time - interval_s]))
        first = first[(first >= self.time[0]) & (first <= self.time[-1] - interval_s)]
        impulse = [np.interp(first + interval_s, self.time, way) - np.interp(first, self.time, way) for way in self.impulse.T]
        size = np.linalg.norm(impulse, axis=0)
        at, most = first[size.argmax()], float(size.max())
        apart, inside = np.diff(self.time), np.linalg.norm(np.diff(self.impulse, axis=0), axis=1)
        matters = (self.time[:-1] < at + interval_s) & (self.time[1:] > at) & (inside > 0.0) | (inside > most * (1.0 + 1e-9))
        coarse = apart[matters & (FEWEST_ROWS * apart > interval_s * (1.0 + 1e-9))]
        if len(coarse):
            raise CommandError(f"probe of '{self.name}': interval_s is {interval_s:g}, but rows are {coarse.max():g} s apart; "
                               f"give at least {FEWEST_ROWS * coarse.max():g}, or lower window_s, settle_window_s (which "
                               "counts once the shell is frozen) and output.probe_interval_s")
        return most / interval_s

    @property
    def direction(self) -> np.ndarray:
        """Returns the unit vector (3,) of the body's initial direction; zero where it was at rest."""
        speed = float(np.linalg.norm(self.velocity[0]))
        return self.velocity[0] / speed if speed > 0.0 else np.zeros(3)

    @property
    def residual_velocity(self) -> float:
        """Returns the final speed along the initial direction [m/s]; negative after a bounce."""
        return float(self.velocity[-1] @ self.direction)

    @property
    def energy_lost(self) -> float:
        """Returns the kinetic energy of translation, without the work of gravity and without that of spin [J]."""
        fallen = float(self.gravity @ (self.position[-1] - self.position[0]))
        return self.mass * (0.5 * float((self.velocity[0] ** 2).sum() - (self.velocity[-1] ** 2).sum()) + fallen)


def check_interval(interval_s: float) -> None:
    """Raises CommandError where it is no time above zero."""
    if isinstance(interval_s, bool) or not isinstance(interval_s, Real):
        raise CommandError(f"interval_s is {interval_s!r}, which is no number; give a time above 0 [s] over which the force is taken")
    if not interval_s > 0.0 or not math.isfinite(interval_s):
        raise CommandError(f"interval_s is {interval_s}; give a time above 0 [s] over which the force is taken")


def motion(results: Results, body: str | None = None, mass: float | None = None) -> Motion:
    """Reads the body's motion. `body` may be omitted where only one body has a probe. `mass` [kg] is needed for
    meshes only.

    Raises CommandError where the scene has no such body, no probe of it, or does not say its mass.
    """
    scene, columns = results.scene.message, results.probes
    name, probe, own_mass = struck(scene, body, mass)
    gravity = scene.gravity if scene.HasField("gravity") else None
    return Motion(name, own_mass, np.array([gravity.x, gravity.y, gravity.z] if gravity is not None else STANDARD_GRAVITY),
                  columns["time"], columns.vector(probe), columns.vector(probe, "_vx _vy _vz"))


def struck(scene: Any, body: str | None, mass: float | None) -> tuple[str, str, float]:
    """Returns the names of the body and its probe in the message of a scene, and the body's mass [kg]. Raises
    CommandError as `motion` does."""
    probed = {probe.body: probe.name for probe in scene.output.probes if probe.body and not probe.shell}  # else of contact
    if body is None:
        if len(probed) != 1:
            raise CommandError(f"name the body; there are probes of: {', '.join(probed) or 'none'}")
        body, = probed
    found = [b for b in scene.bodies if b.name == body]
    if not found:
        raise CommandError(f"no body '{body}'; {did_you_mean(body, (b.name for b in scene.bodies))}")
    if body not in probed:
        raise CommandError(f"the scene has no probe of '{body}'; add output {{ probes {{ name: \"{body}\" body: "
                           f"\"{body}\" }} }}")
    return body, probed[body], mass if mass is not None else mass_of(scene, found[0])


def mass_of(scene: Any, body: Any) -> float:
    """Returns the mass [kg] of a sphere or a box. Raises CommandError for other shapes."""
    density = next((with_preset(m).density for m in scene.materials if m.name == body.material), 0.0)
    shape = body.WhichOneof("shape")
    if density > 0.0 and shape == "sphere":
        return float(density * 4.0 / 3.0 * math.pi * body.sphere.radius_m ** 3)
    if density > 0.0 and shape == "box":
        size = body.box.size_m
        return float(density * size.x * size.y * size.z)
    raise CommandError(f"body '{body.name}': its mass is not known from shape '{shape}' and material "
                       f"'{body.material}'; give mass=")


def energy_taken(results: Results, body: str | None = None, mass: float | None = None) -> dict[str, float]:
    """Returns the energy that the body lost, and its distribution at the end [J].

    `lost`: by the body. `motion`: of all else, which is shell, shards, other bodies, and the body's own spin.
    `elastic`: stored. `fracture`, `plastic` and `damping`: taken by these.
    `faces`: crack faces that slide on each other and crush. `contact`: inelastic impacts and friction.
    `frozen` and `handoff`: vibration that frozen panes and rigid shards do not have.
    `engine`: contacts of the engine. `other`: healing and transfer.
    `missing`: the rest. It is the residual of the books, and the work of gravity on shell and others.
    """
    one, energy = motion(results, body, mass), results.energy
    out = {"lost": one.energy_lost,
           "motion": energy["kinetic"] - 0.5 * one.mass * float((one.velocity[-1] ** 2).sum()),
           "elastic": energy["elastic"], "fracture": energy["dissipated_fracture"],
           "plastic": energy["dissipated_plastic"], "faces": energy["face_friction"] + energy["face_crushing"],
           "contact": energy["contact"], "damping": energy["damping"],
           "frozen": energy["frozen"], "handoff": energy["handoff_lost"], "engine": energy["engine"],
           "other": energy["healing"] + energy["transfer"] - energy["crack_injected"]}
    out["missing"] = out["lost"] + energy["external_work"] - sum(v for k, v in out.items() if k != "lost")
    return out


def perforated(results: Results, body: str | None = None) -> bool | None:
    """Returns whether the body went through the shell; None: not decided at the end of the run.

    Through is: its centre beyond the plane of the shell by its radius and half the thickness, along the direction in
    which it came, still moving on, and hardly slowed any more. Held up is: stopped or on its way back. Meant for
    a plate that is held at its border; raises CommandError for another shell.
    """
    plate, sphere = perforable(results.scene.message, body)
    one = motion(results, body)
    centre = plate.plate.pose.position
    beyond = float((one.position[-1] - [centre.x, centre.y, centre.z]) @ one.direction)
    speed = float(np.linalg.norm(one.velocity[0]))
    if speed == 0.0:
        raise CommandError(f"body '{one.name}' stands still at the start")
    if one.residual_velocity <= AT_REST * speed:
        return False
    reach = sphere.radius_m + 0.5 * plate.thickness_m
    before = int(np.searchsorted(one.time, one.time[-1] - LAST_SHARE * (one.time[-1] - one.time[0])))
    lost = float(one.velocity[min(before, len(one.time) - 2)] @ one.direction) - one.residual_velocity
    return True if beyond > reach and lost < STILL_SLOWED * one.residual_velocity else None


def perforable(scene: Any, body: str | None) -> tuple[Any, Any]:
    """Returns the plate and the sphere in the message of a scene. Raises CommandError as `perforated` does."""
    if len(scene.shells) != 1 or scene.shells[0].WhichOneof("patch") != "plate" or not scene.shells[0].supports:
        raise CommandError("perforation is defined for one plate with supports: a free one flies off with what struck it")
    name, _, _ = struck(scene, body, 1.0)
    found = next(b for b in scene.bodies if b.name == name)
    if found.WhichOneof("shape") != "sphere":
        raise CommandError(f"perforation is defined for spheres; '{name}' is none")
    return scene.shells[0], found.sphere


def impact(body: str | None = None, mass: float | None = None, interval_s: float | None = None) -> Any:
    """Measures, for experiments, the usual quantities of an impact by `body`, as columns.

    `residual_velocity_m_per_s` along the way in which it came, `impulse_N_s`, `contact_until_s`, `energy_..._J` as by
    `energy_taken`, and `crack_length_m`. `settled` is 1 where it was touched and the last contact ended before the last
    two hundredths of the record. Where it is 0 it has not arrived or may still be pushed. Then `end_time_s` is too short
    for final values.

    With `interval_s` also `mean_force_N`, the largest mean force over an interval of this length, and
    `mean_force_interval_s`, the length. It is at least four rows of the probe, better ten. A row is a window, if
    `output.probe_interval_s` is no longer. Keep the interval where windows change. There is no peak of the force without
    one: the default contact acts by impulses. So the force over a window grows without limit as windows get shorter.
    """
    forces = () if interval_s is None else (FORCE, INTERVAL)

    def refuse(scene: Scene) -> None:
        struck(scene.message, body, mass)
        if interval_s is not None:
            check_interval(interval_s)
            rows = max(scene.message.window_s, scene.message.output.probe_interval_s)
            if FEWEST_ROWS * rows > interval_s * (1.0 + 1e-9):
                raise CommandError(f"interval_s is {interval_s:g}, but rows of the probe are {rows:g} s apart; give at least "
                                   f"{FEWEST_ROWS * rows:g}, or lower window_s and output.probe_interval_s")

    def measure(results: Results) -> dict[str, float]:
        one = motion(results, body, mass)
        energy = energy_taken(results, body, mass)
        told = () if interval_s is None else (one.largest_mean_force(interval_s), interval_s)
        return {"residual_velocity_m_per_s": one.residual_velocity,
                "impulse_N_s": float(np.linalg.norm(one.impulse[-1])),
                **dict(zip(forces, told)), "contact_until_s": one.contact_until, "settled": float(one.settled),
                **{f"energy_{name}_J": value for name, value in energy.items()},
                "crack_length_m": float(results.series["cracks"][-1])}
    gone = {"peak_force_N": "it grew without limit as windows got shorter; take interval_s in sunder.impact, which gives "
                            "mean_force_N"}
    if not forces:
        gone["mean_force_N"] = gone["mean_force_interval_s"] = "sunder.impact gives it with interval_s"
    return Stated(("residual_velocity_m_per_s", "impulse_N_s", *forces, "contact_until_s", "settled",
                   *(f"energy_{name}_J" for name in ENERGIES), "crack_length_m"), measure, refuse, gone)
