"""What a trade tells: the table, trade.csv, trade.json, and the plot of error over cost."""
from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

from sunder_tools.errors import CommandError
from sunder_tools.pictures.plots import ENDINGS, INK, Line, Panel, write_panels

from ..member import write_atomically
from ..table import Table
from .judge import Gap
from .knobs import Setting
from .quantities import UNITS
from .trade import Outcome, Row, as_json


OWN = Setting().label


def write(found: Outcome, folder: Path, json_file: Path | None, plots: str = "png") -> None:
    """trade.csv, trade.json and, where matplotlib is there, trade.png into the folder of the trade, and the plot with another
    ending too; the JSON also where the user wants it.

    Raises CommandError where that cannot be written.
    """
    table(found).write_csv(folder / "trade.csv")
    write_atomically(folder / "trade.json", as_json(found))
    for ending in ENDINGS:
        (folder / f"trade{ending}").unlink(missing_ok=True)
    for ending in dict.fromkeys(("png", plots)):
        try:
            write_panels([panel(found)], folder / f"trade.{ending}")
        except (CommandError, OSError) as error:
            print(f"sunder: trade.{ending} is not drawn: {error}", file=sys.stderr, flush=True)
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
            "error": r.judged.error, "noise": r.judged.noise, "resolved": r.judged.resolved, "on_front": r.on_front,
            "on_bounds": r.on_bounds, "like_own": r.like_own}
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
        start = f"{'* ' if r.on_front else '< ' if r.on_bounds else '  '}{_title(r):<{width}} {r.judged.processor_s:>8.3g} {ratio} "
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
    lines.append(f"front (*)        {'; '.join(r.judged.label for r in found.on_front()) or 'no error is told from none'}")
    if found.on_bounds():
        lines.append(f"bounds (<)       {'; '.join(r.judged.label for r in found.on_bounds())}: their errors are below what is written, "
                     "and no cheaper setting has a smaller bound" + ("; they may be better than the front" if found.on_front() else ""))
    if like := [r.judged.label for r in found.rows if r.like_own]:
        why = f"of each quantity their difference is within its 95 % interval over {found.seeds} runs" if found.chance else "their results are equal"
        lines.append(f"like own         {'; '.join(like)}: {why}, so do not prefer one for its error")
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
    """Error over cost, both logarithmic. The front is a line with its settings written beside it. Bars are the noise; an
    arrow is a bound, below which the error is not known."""
    def points(name: str, kinds: tuple[str, ...], size: float = 5.0, colour: str = "") -> Line:
        some = [r for r in found.rows if r.kind in kinds and r.judged.gaps and math.isfinite(r.judged.height)]
        return Line(name, [r.judged.processor_s for r in some], [r.judged.height for r in some], [r.judged.noise for r in some],
                    labels=[_title(r) if (r.kind == "own" or r.on_bounds) and not r.on_front else "" for r in some],
                    bound=[not r.judged.resolved for r in some], joined=False, size=size, colour=colour)

    best = [r for r in found.on_front() if math.isfinite(r.judged.height)]
    lines = [Line("front", [r.judged.processor_s for r in best], [r.judged.height for r in best],
                  labels=[_title(r) for r in best]),
             points("one change", ("one", "next finest")), points("together", ("together",)),
             points("the scene's own", ("own",), size=10.0, colour=INK)]
    return Panel(f"{found.scene}: error over cost", "processor time of a run [s]", "error against the reference", lines, True,
                 bars="± noise; arrows down from upper bounds")
