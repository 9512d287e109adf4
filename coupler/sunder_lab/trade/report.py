"""What a trade tells: the table, trade.csv, trade.json, and the plot of error over cost."""
from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

from sunder_tools.errors import CommandError
from sunder_tools.pictures.plots import Line, Panel, write_panels

from ..member import write_atomically
from ..table import Table
from .judge import Gap
from .knobs import Setting
from .quantities import UNITS
from .trade import Outcome, Row, as_json


OWN = Setting().label


def write(found: Outcome, folder: Path, json_file: Path | None) -> None:
    """trade.csv, trade.json and, where matplotlib is there, trade.png into the folder of the trade; the JSON also where the
    user wants it.

    Raises CommandError where that cannot be written.
    """
    table(found).write_csv(folder / "trade.csv")
    write_atomically(folder / "trade.json", as_json(found))
    (folder / "trade.png").unlink(missing_ok=True)
    try:
        write_panels([panel(found)], folder / "trade.png")
    except (CommandError, OSError) as error:
        print(f"sunder: trade.png is not drawn: {error}", file=sys.stderr, flush=True)
    if json_file is not None:
        try:
            write_atomically(json_file, as_json(found))
        except OSError as error:
            raise CommandError(f"--json {json_file}: {error.strerror}") from None


def table(found: Outcome) -> Table:
    """A row a setting, cheapest first."""
    own = _own_cost(found)
    rows: list[dict[str, Any]] = []
    for r in found.rows:
        row: dict[str, Any] = {
            "setting": r.judged.label, "kind": r.kind, "runs": r.runs, "processor_s": r.judged.processor_s,
            "wall_s": r.judged.wall_s, "cost_ratio": r.judged.processor_s / own if own else math.nan,
            "error": r.judged.error, "noise": r.judged.noise, "resolved": r.judged.resolved, "on_front": r.on_front}
        for name in found.own_errors:
            gap = r.judged.gaps.get(name)
            row.update({f"{name} [{UNITS[name]}]": r.values.get(name), f"{name} error": gap and gap.error,
                        f"{name} noise": gap and gap.noise})
        rows.append({**row, "why_not": r.error})
    return Table(rows)


def _own_cost(found: Outcome) -> float:
    return next((r.judged.processor_s for r in found.rows if r.judged.label == OWN), 0.0)


def share(value: float) -> str:
    """A relative error as text."""
    return f"{100.0 * value:.2g}%" if value < 0.995 else f"{100.0 * value:.0f}%"


def in_words(gap: Gap) -> str:
    """'3.1%', or '<4%' where that is all that can be told."""
    return share(gap.error) if gap.resolved else f"<{share(gap.noise)}" if math.isfinite(gap.noise) else "?"


def tell(found: Outcome) -> str:
    """The table for people."""
    names = list(found.own_errors)
    width = max([len(_title(r)) for r in found.rows] + [7])
    own = _own_cost(found)
    lines = [f"{'':2}{'setting':<{width}} {'cpu s':>8} {'x own':>7} {'error':>7}  " + " ".join(f"{n:>13}" for n in names)]
    for r in found.rows:
        ratio = f"{r.judged.processor_s / own:>7.2f}" if own else f"{'-':>7}"
        start = f"{'* ' if r.on_front else '  '}{_title(r):<{width}} {r.judged.processor_s:>8.3g} {ratio} "
        if r.error:
            lines.append(f"{start}  {r.error.splitlines()[-1]}")
        elif r.kind == "reference":
            lines.append(f"{start}{'0':>7}  " + " ".join(f"{'+-' + share(found.own_errors[n]):>13}" for n in names))
        else:
            total = Gap(r.judged.error, r.judged.noise)
            lines.append(f"{start}{in_words(total):>7}  " + " ".join(f"{in_words(r.judged.gaps[n]):>13}" for n in names))
    lines += ["", f"error            root mean square of {', '.join(names)}, against the reference: {found.reference}",
              f"                 its own errors (+-) are its differences to: {found.next_finest}"]
    lines.append(f"                 {found.seeds} runs of each; '<': within the 95 % interval of their difference, or below the "
                 "reference's own error" if found.chance else "                 '<': below the reference's own error")
    lines.append(f"front (*)        {'; '.join(r.judged.label for r in found.on_front())}")
    lines.append(f"processor time   {found.spent_s / 60:.2g} of {found.budget_s / 60:.2g} min")
    for label, cost in found.over_budget.items():
        lines.append(f"over budget      {label}: about {cost:.3g} s more")
    for name, why in found.not_compared.items():
        lines.append(f"not compared     {name}: {why}")
    for name, why in found.not_applicable.items():
        lines.append(f"not varied       {name}: {why}")
    return "\n".join(lines)


def _title(row: Row) -> str:
    words = {"reference": " (reference)", "next finest": " (next finest)", "own": " (the scene's)"}.get(row.kind, "")
    return row.judged.label + words


def panel(found: Outcome) -> Panel:
    """Error over cost, both logarithmic; the front is a line with its settings written beside it, the dashes of the bars
    are what cannot be told from no error."""
    def places(kinds: tuple[str, ...]) -> list[tuple[float, float]]:
        return [(r.judged.processor_s, r.judged.height) for r in found.rows
                if r.kind in kinds and r.judged.gaps and math.isfinite(r.judged.height)]

    best = [r for r in found.on_front() if math.isfinite(r.judged.height)]
    lines = [Line("front", [r.judged.processor_s for r in best], [r.judged.height for r in best],
                  labels=[_title(r) for r in best]),
             Line("one change", [], [], dots=places(("one", "next finest"))),
             Line("together", [], [], dots=places(("together",))),
             Line("the scene's own", [], [], dots=places(("own",)))]
    return Panel(f"{found.scene}: error over cost", "processor time of a run [s]", "error against the reference", lines, True)
