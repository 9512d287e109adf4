"""Crack paths, branching and cost: whole runs against published results."""
from __future__ import annotations

import math

import numpy as np

from sunder_tools.launch.build import Executables
from sunder_tools.pictures.crack_lines import Graph, grown, last_graph
from sunder_tools.report.run_json import read_run

from .crack_pictures import draw_cracks
from .trials import Table, add_books, kept_run

ARM = 4e-3  # [m]: length of two parallel cracks that counts as a branch
RUN = 25e-3  # [m]: length over which a crack's direction is measured
APART = 1e-3  # [m] between two cracks


def leaving(graph: Graph, place: np.ndarray) -> np.ndarray:
    """Returns points (k, 2) [m] of the edges that are connected to the vertex nearest to `place`."""
    vertex = graph.vertices()
    nearest = int(np.argmin(np.linalg.norm(graph.ends.reshape(-1, 2) - place, axis=1)))
    reached = {int(vertex.reshape(-1)[nearest])}
    inside = np.zeros(len(graph), bool)
    while True:
        more = np.isin(vertex, list(reached)).any(axis=1) & ~inside
        if not more.any():
            return graph.ends[inside].reshape(-1, 2)
        inside |= more
        reached.update(int(v) for v in vertex[more].reshape(-1))


def first_division(graph: Graph) -> tuple[float, float]:
    """Returns place along u [m] and time [s] of the first vertex from which a crack runs on in two directions; NaN:
    none."""
    vertex = graph.vertices()
    times: dict[int, list[tuple[float, float]]] = {}
    for (a, b), ends, born in zip(vertex, graph.ends, graph.born):
        times.setdefault(int(a), []).append((float(born), float(ends[0, 0])))
        times.setdefault(int(b), []).append((float(born), float(ends[1, 0])))
    found = [(sorted(t)[-1][0], t[0][1]) for t in times.values() if len(t) >= 3]
    when, place = min(found, default=(math.nan, math.nan))
    return place, when


def lasting_division(graph: Graph, start: float, end: float) -> tuple[float, float]:
    """Returns the place along u [m] from which cracks cross planes of constant u in two places, `APART` from each
    other, over the length `ARM`. Also returns the time of the second crack there [s]. NaN where there is no such
    place."""
    planes = np.arange(start, end, 0.25e-3)
    u = graph.ends[:, :, 0]
    apart, second = np.zeros(len(planes), bool), np.full(len(planes), math.nan)
    for k, plane in enumerate(planes):
        hit = np.nonzero((u.min(axis=1) <= plane) & (u.max(axis=1) > plane))[0]
        if len(hit) < 2:
            continue
        ends = graph.ends[hit]
        share = (plane - ends[:, 0, 0]) / (ends[:, 1, 0] - ends[:, 0, 0])
        v = ends[:, 0, 1] + share * (ends[:, 1, 1] - ends[:, 0, 1])
        first = int(np.argmin(graph.born[hit]))
        other = np.abs(v - v[first]) > APART
        if other.any():
            apart[k], second[k] = True, graph.born[hit][other].min()
    needed = int(round(ARM / 0.25e-3))
    for k in range(len(planes) - needed):
        if apart[k:k + needed].all():
            return float(planes[k]), float(second[k])
    return math.nan, math.nan


def front_speed(graph: Graph, until: float) -> tuple[float, float]:
    """Returns the mean speed of the foremost tip along u until a time, and the largest speed over 5 mm [m/s]."""
    order = np.argsort(graph.born, kind="stable")
    when = graph.born[order]
    front = np.maximum.accumulate(graph.ends[order][:, :, 0].max(axis=1))
    chosen = when <= until
    when, front = when[chosen], front[chosen]
    if len(when) < 3 or when[-1] == when[0]:
        return math.nan, math.nan
    fastest = 0.0
    for i, at in enumerate(front):
        j = int(np.searchsorted(front, at + 5e-3))
        if j < len(front) and when[j] > when[i]:
            fastest = max(fastest, float((front[j] - at) / (when[j] - when[i])))
    return float((front[-1] - front[0]) / (when[-1] - when[0])), fastest


def _draw(table: Table, name: str, graphs: list[Graph], extent: tuple[float, float], size: int = 400) -> None:
    if table.pictures is not None:
        draw_cracks(table.pictures / f"{name}.png", [graphs], extent, size)


def branching(table: Table, executables: Executables) -> None:
    """Runs scenes/branching.textproto at 2, 1 and 0.5 mm, and at 1 mm with a branch ratio a tenth lower and higher."""
    rayleigh = 2112.0  # [m/s]
    x, y, graphs = [], [], []
    for elements, ratio in ((50, None), (100, None), (200, None), (100, 0.9), (100, 1.1)):
        settings = [f"shells[strip].plate.elements_x={elements}", f"shells[strip].plate.elements_y={elements * 2 // 5}"]
        if ratio is not None:
            settings.append(f"fracture.branch_ratio={ratio * math.sqrt(2.0):.6f}")
        with kept_run(executables, "branching.textproto", settings) as (folder, seconds):
            graphs.append(last_graph(folder))
            graph, run = grown(graphs[-1]), read_run(folder)
        start = float(graph.born.min())
        place, when = first_division(graph)
        stays, later = lasting_division(graph, 0.051, 0.095)
        mean, fastest = front_speed(graph, when if math.isfinite(when) else 80e-6)
        energy = run["energy"]
        length = float(np.linalg.norm(graph.ends[:, 1] - graph.ends[:, 0], axis=1).sum())
        spent = energy["dissipated_fracture"] / (3.0 * 2e-4 * length)
        what = f"{100.0 / elements:.1f} mm" + ("" if ratio is None else f", branch ratio {ratio} of sqrt(2)")
        table.lines.append(
            f"branching {what}: starts at {start * 1e6:.1f} us, divides at {when * 1e6:.1f} us "
            f"{place * 1e3 - 50.0:.1f} mm from the notch, for good at {later * 1e6:.1f} us and {stays * 1e3 - 50.0:.1f} mm; mean speed until then "
            f"{mean / rayleigh:.2f} and fastest {fastest / rayleigh:.2f} of the "
            f"Rayleigh speed (not capped below it); energy released {spent:.2f} of G_f times the length")
        if ratio is None:
            table.add(f"branching_{elements}_us", later * 1e6, 35.0, 0.2858, seconds)  # 25 to 45
            add_books(table, f"branching_{elements}", run)
            x.append(100.0 / elements)
            y.append(later * 1e6)
    table.add("branching_over_grids", float(np.max(y) / np.min(y)), 1.0, 0.15, 0.0)
    _draw(table, "branching", graphs, (0.1, 0.04))
    table.curves.append({"name": "crack divides", "x_label": "spacing [mm]", "y_label": "time [us]", "x": x, "y": y,
                         "logarithmic": False})


def kalthoff(table: Table, executables: Executables) -> None:
    """Runs scenes/kalthoff.textproto on three grids: the direction from the notch's end to the far end of its crack."""
    graphs = []
    for elements in (75, 100, 150):
        with kept_run(executables, "kalthoff.textproto", [
                f"shells[plate].plate.elements_{axis}={elements}" for axis in "xy"]) as (folder, seconds):
            graphs.append(last_graph(folder))
            graph, run = grown(graphs[-1]), read_run(folder)
        notch = np.array([0.05, 0.025])
        points = leaving(graph, notch)
        away = np.linalg.norm(points - notch, axis=1)
        far, end = points[np.argmin(np.abs(away - RUN))] - notch, points[np.argmax(away)] - notch
        table.add(f"kalthoff_{elements}_degrees", math.degrees(math.atan2(end[1], end[0])), 70.0, 5.0 / 70.0, seconds)
        first = math.degrees(math.atan2(far[1], far[0]))
        table.add(f"kalthoff_{elements}_first_degrees", first, 70.0, 5.0 / 70.0, 0.0)
        add_books(table, f"kalthoff_{elements}", run)
        table.lines.append(f"kalthoff, {100.0 / elements:.2g} mm: starts at {graph.born.min() * 1e6:.1f} us, "
                           f"{away.max() * 1e3:.0f} mm away at the end; the first {RUN * 1e3:.0f} mm run at "
                           f"{math.degrees(math.atan2(far[1], far[0])):.1f} degrees")
    _draw(table, "kalthoff", graphs, (0.1, 0.1))


def modes(table: Table, executables: Executables) -> None:
    """Checks that the crack of a stretched sheet stays in line with the notch, and that of a sheared sheet turns by
    70.5 degrees."""
    graphs = []
    for scene in ("mode_one", "mode_two"):
        with kept_run(executables, f"{scene}.textproto", []) as (folder, seconds):
            graphs.append(last_graph(folder))
            graph, run = grown(graphs[-1]), read_run(folder)
        add_books(table, scene, run)
        notch, spacing = np.array([0.1, 0.1013]), 0.004
        middle = graph.ends.mean(axis=1)
        length = np.linalg.norm(graph.ends[:, 1] - graph.ends[:, 0], axis=1)
        if scene == "mode_one":
            ahead = (middle[:, 0] > notch[0]) & (np.abs(middle[:, 1] - notch[1]) < 0.05)
            off = float((np.abs(middle[:, 1] - notch[1]) * length)[ahead].sum() / length[ahead].sum())
            table.add("mode_one_off_line_spacings", off / spacing, 0.0, 3.0, seconds)
            reached = float(leaving(graph, notch)[:, 0].max())
            table.add("mode_one_crossed", min((reached - notch[0]) / (0.2 - notch[0]), 1.0), 1.0, 0.02, 0.0)
        else:
            near = (np.linalg.norm(middle - notch, axis=1) < 5.0 * spacing) & (middle[:, 1] < notch[1])
            points = graph.ends[near].reshape(-1, 2)
            far = points[np.argmax(np.linalg.norm(points - notch, axis=1))] - notch
            table.add("mode_two_turn_degrees", math.degrees(math.atan2(-far[1], far[0])), 70.5, 0.15, seconds)
            table.lines.append("mode_two: largest hoop stress of pure shear is at 70.5 degrees (Erdogan and Sih 1963)")
    _draw(table, "modes", graphs, (0.2, 0.2))


def pressed_plate(table: Table, executables: Executables) -> None:
    """Runs scenes/pressed_plate.textproto: between middle and corners cracks run along the diagonals."""
    with kept_run(executables, "pressed_plate.textproto", []) as (folder, seconds):
        graph, run = grown(last_graph(folder)), read_run(folder)
    way = graph.ends[:, 1] - graph.ends[:, 0]
    length = np.linalg.norm(way, axis=1)
    place = graph.ends.mean(axis=1) - 0.25
    corner = np.abs(place).min(axis=1) > 0.12  # more than half way to a corner
    diagonal = np.arctan2(place[:, 1], place[:, 0])
    wanted = np.sign(np.sin(2.0 * diagonal)) * math.pi / 4.0
    turn = np.angle(np.exp(2j * (np.arctan2(way[:, 1], way[:, 0]) - wanted))) / 2.0
    off = float((np.abs(turn) * length)[corner].sum() / length[corner].sum())
    # 45 is the value without any order
    table.add("pressed_off_diagonal_degrees", math.degrees(off), 0.0, 22.5, seconds)
    table.add("pressed_corners", len({(x > 0, y > 0) for x, y in place[corner]}), 4.0, 0.0, 0.0)
    add_books(table, "pressed", run)
    _draw(table, "pressed_plate", [graph], (0.5, 0.5), 800)
    table.lines.append(f"pressed_plate: {len(length)} edges, {run['counts']['fragments']} fragments, "
                       f"{length[corner].sum() / length.sum():.2f} of the length near the corners")


FINE_GLASS = 245  # elements along the pane: the 60,000 points of the paper's table 2


def share(table: Table, executables: Executables) -> None:
    """Measures the share of fracture in the time of windows with growing cracks, with few cracks and with many."""
    each = []
    fine = [f"shells[pane].plate.elements_{axis}={FINE_GLASS}" for axis in "xy"]
    ways: tuple[tuple[str, str, list[str]], ...] = (
        ("glass", "glass.textproto", ["end_time_s=2e-3"]),
        ("pressed_plate", "pressed_plate.textproto", []),
        ("fine_glass", "glass.textproto", ["end_time_s=1e-3", *fine]))
    for name, scene, settings in ways:
        with kept_run(executables, scene, settings) as (folder, seconds):
            run, edges = read_run(folder), len(last_graph(folder))
        grew = run["time"]["cracks_grew"]
        table.add(f"{name}_fracture_share", grew["crack_update_s"] / grew["wall_s"], 0.0, 0.15, seconds)
        each.append(grew["crack_update_s"] / edges)
        table.lines.append(f"share {name}: {edges} edges, {run['counts']['fragments']} fragments, crack update "
                           f"{grew['crack_update_s']:.2f} of {grew['wall_s']:.2f} s, {1e3 * each[-1]:.2f} ms an edge")
    table.add("cost_of_an_edge_many_to_few", max(each[1] / each[0], 1.0), 1.0, 0.5, 0.0)  # a lower cost is no fault
