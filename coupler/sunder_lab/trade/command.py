"""`sunder trade SCENE`: from the command line to table and files."""
from __future__ import annotations

import argparse

from sunder_tools.errors import DONE, CommandError

from ..campaign import Settings
from ..scene import Scene
from . import report
from .trade import Trade, folder_of


def trade(options: argparse.Namespace) -> int:
    """Runs what `options` ask for (see `sunder trade --help`); exit status 0, also where single settings were refused.

    Raises CommandError where the scene itself cannot be traded.
    """
    if not options.scene.is_file():
        raise CommandError(f"{options.scene}: no such scene file")
    if options.report and not options.report.absolute().parent.is_dir():
        raise CommandError(f"--json {options.report}: there is no folder {options.report.absolute().parent}")
    scene = Scene.load(options.scene).set(dict(setting.split("=", 1) for setting in options.settings))
    if options.until:
        scene.message.end_time_s = float(options.until)
    out = folder_of(options.scene, options.out)
    one = Trade(scene, options.budget, options.seeds, [n for n in options.vary.split(",") if n], options.rigid,
                options.scene.stem)
    found = one.run(Settings(out, options.jobs, threads=options.threads, quiet=options.quiet))
    report.write(found, out, options.report, options.plots)
    print(report.tell(found))
    for what, name in dict.fromkeys((("table", "trade.csv"), ("plot", "trade.png"), ("plot", f"trade.{options.plots}"), ("all of it", "trade.json"), ("runs", "results.csv"))):
        if (out / name).is_file():
            print(f"{what:<16} {out / name}")
    return DONE
