"""The page: a figure after the other with its picture, and Table 2 beside ours. It needs no network."""
from __future__ import annotations

import html
import json
from pathlib import Path
from typing import Any, Iterable

from sunder_tools.errors import CommandError
from sunder_tools.launch.run import COMMAND_FILE, read_usage
from sunder_tools.pictures.vtp import VtpError
from sunder_tools.replacing import replacing
from sunder_tools.report.machine import commit, cores, processor
from sunder_tools.report.run_json import read_run
from sunder_tools.words import command_line

from .catalogue import CASES, CORES, TABLE_2, THREADS, Row
from .checks import checks_of, said, verdict
from .figures import FIGURES, Figure
from .runs import Runs

STYLE = """body { font: 16px/1.5 sans-serif; color: #262e36; background: #fafaf9; max-width: 1240px; margin: 2em auto; padding: 0 1em }
img { max-width: 100%; border: 1px solid #dee0e2 } figure { margin: 1em 0 } figcaption { color: #5a646e }
table { border-collapse: collapse } td, th { padding: .2em .7em; text-align: right; border-bottom: 1px solid #dee0e2 }
td:first-child, th:first-child { text-align: left } pre { background: #f0f1f1; padding: .6em; overflow-x: auto; font-size: 13px }
h2 { border-top: 2px solid #dee0e2; padding-top: .8em } .lack { color: #a03020 }"""


def write_page(runs: Runs) -> Path:
    """Writes index.html from the record of what was drawn; returns its path. Raises CommandError."""
    path = runs.folder / "index.html"
    body = [f"<h1>The paper's figures, {runs.size} size</h1>",
            f"<p>A Hybrid Lagrangian–Eulerian Formulation of Thin-Shell Fracture (Fan, Chitalu, Komura). Made by <code>coupler/sunder "
            f"paper --size {runs.size}</code>, commit {_text(commit())}, {_text(processor())}, {cores()} cores.</p>", _contents(runs)]
    body += [part for figure in FIGURES.values() for part in _figure(runs, figure)]
    body += ["<h2 id='table2'>Table 2</h2>", *table(runs)]
    page = (f"<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'><title>The paper, {runs.size}</title><style>{STYLE}</style>"
            "</head><body>\n" + "\n".join(body) + "\n</body></html>\n")
    try:
        with replacing(path) as part:
            part.write_text(page, encoding="utf-8")
    except OSError as error:
        raise CommandError(f"cannot write {path}: {error.strerror}; free some space there, or name another --out") from None
    return path


def _text(words: object) -> str:
    return html.escape(str(words), quote=True)


def _list(items: Iterable[str]) -> str:
    return "<ul>" + "".join(f"<li>{_text(item)}</li>" for item in items) + "</ul>"


def state(runs: Runs, figure: Figure) -> str:
    """One of 'drawn', 'failed', 'a drawing' and 'not run'."""
    if figure.draw is None:
        return "a drawing"
    if runs.record.figures.get(str(figure.number), {}).get("pictures"):
        return "drawn"
    return "failed" if any(runs.failure(case) for case in figure.cases) else "not run"


def _contents(runs: Runs) -> str:
    return "<p>" + " · ".join(f"<a href='#fig{n}'>{n}</a>{'' if state(runs, f) == 'drawn' else f' ({state(runs, f)})'}"
                              for n, f in FIGURES.items()) + " · <a href='#table2'>Table 2</a></p>"


def _figure(runs: Runs, figure: Figure) -> list[str]:
    out = [f"<h2 id='fig{figure.number}'>Figure {figure.number}. {_text(figure.title)}</h2>"]
    drawn: dict[str, Any] = runs.record.figures.get(str(figure.number), {})
    for name, words in drawn.get("pictures", []):
        out.append(f"<figure><img src='{_text(name)}' alt='{_text(words)}'><figcaption>{_text(words)}</figcaption></figure>")
    out.append(f"<p><b>The paper.</b> {_text(figure.says)}</p>")
    if figure.draw is None:
        return out
    told = [f"{case} failed: {runs.failure(case)}" for case in figure.cases if runs.failure(case)]
    told += [f"Not drawn: {drawn['failed']}"] if drawn.get("failed") else []
    if told:
        out.append(f"<div class='lack'>{_list(told)}</div>")
    if drawn.get("found"):
        out.append(f"<p><b>What came out.</b></p>{_list(drawn['found'])}")
    elif not told:
        out.append("<p><b>Here.</b> Not run yet.</p>")
    out += _checks(runs, figure)
    warnings = [f"{case}: {w}" for case in figure.cases for w in read_run(runs.place(case)).get("warnings") or []]
    if warnings:
        out.append(f"<p><b>Warnings of the runs.</b></p>{_list(warnings)}")
    out.append(f"<p><b>What differs, and why.</b></p>{_list(figure.differs)}")
    out.append("<details><summary>Commands</summary><pre>" + "\n".join(_text(command(case, runs.size)) for case in figure.cases)
               + "</pre></details>")
    return out


def _checks(runs: Runs, figure: Figure) -> list[str]:
    """What the runs must hold; what fails is in red."""
    try:
        checks = checks_of(runs, figure.number, figure.cases)
    except (VtpError, OSError) as error:
        return [f"<div class='lack'>{_list([f'The books are not checked: {error}'])}</div>"]
    failed = [said(check, runs.size) for check in checks if verdict(check, runs.size) == "failed"]
    good = [said(check, runs.size) for check in checks if verdict(check, runs.size) != "failed"]
    return ([f"<p><b>Checks.</b></p>{_list(good)}"] if good else []) + (
        [f"<div class='lack'><b>Checks that fail.</b>{_list(failed)}</div>"] if failed else [])


def command(case: str, size: str) -> str:
    """The command line that runs a case alone."""
    words = ["coupler/sunder", "run", CASES[case].file()]
    for setting in CASES[case].all_settings(size):
        words += ["--set", setting]
    return command_line(words)


HEADS = ("figure", "points, paper", "here", "steps, paper", "here", "s a step, paper", "here",
         "core-s in all, paper", "here", "ratio", "threads, paper", "here",
         "core-s a step, paper", "here", "ratio", "core-µs a point and step, paper", "here", "ratio")
FORMS = (",.0f", ",.0f", ".3g", ",.0f", ".0f", ".3g", ".3g")  # of points, steps, ...
COMPARED = (3, 5, 6)  # those that have a ratio


def table(runs: Runs) -> list[str]:
    """Table 2 and ours, row by row."""
    rows = [_row(row, measured(runs, row.case)) for row in TABLE_2]
    cells = ["<tr>" + "".join(f"<td>{_text(c)}</td>" for c in row) + "</tr>" for row in rows]
    return [f"<p>Points are those in layers (type IV). The paper's processor has {CORES} cores, which run {THREADS} threads; its "
            f"core-seconds are {CORES} times the seconds of its clock. Core-seconds here are the processor time of both "
            "processes, with contact, cracks, rigid shards and writing, over the substeps. A ratio is the paper's over ours. "
            "The steps differ in length, and a small size has fewer points: the last ratio is the one that compares. In all counts "
            "the whole run, which for Fig. 1 and Fig. 15 is not as long as the paper's.</p>",
            "<div style='overflow-x:auto'><table><tr>" + "".join(f"<th>{_text(h)}</th>" for h in HEADS) + "</tr>", *cells,
            "</table></div>"]


def measured(runs: Runs, case: str) -> dict[str, float]:
    """Points, steps, seconds and core-seconds a step, and threads of a run; {} where it has not been run to its end."""
    if not case:
        return {}
    folder = runs.place(case)
    run, usage = read_run(folder), read_usage(folder)
    steps = float((run.get("time") or {}).get("substeps") or 0)
    if run.get("status") != "done" or not steps or not usage:
        return {}
    try:
        threads = json.loads((folder / COMMAND_FILE).read_text()).get("threads") or cores()
    except (OSError, ValueError, AttributeError):
        threads = cores()
    return {"points": float(run["counts"]["layer_points"]), "steps": steps, "step_s": float(run["time"]["wall_s"]) / steps,
            "threads": float(threads), "core_s": usage["processor_s"] / steps}


def _row(row: Row, ours: dict[str, float]) -> list[str]:
    core_s = CORES * row.step_s
    theirs = (row.points, row.steps, row.step_s, core_s * row.steps, THREADS, core_s, 1e6 * core_s / row.points)
    mine = (ours["points"], ours["steps"], ours["step_s"], ours["core_s"] * ours["steps"], ours["threads"], ours["core_s"],
            1e6 * ours["core_s"] / ours["points"]) if ours else None
    out = [str(row.figure)]
    for k, (form, paper) in enumerate(zip(FORMS, theirs)):
        out += [format(paper, form), format(mine[k], form) if mine else "–"]
        if k in COMPARED:
            out.append(format(paper / mine[k], ",.0f") if mine else "–")
    return out
