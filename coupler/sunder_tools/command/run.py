"""`sunder run`: a scene in two processes, and its contact sheet."""
from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import BAD_INPUT, CommandError
from ..launch import engines
from ..launch.fidelity import PRESETS, with_fidelity
from ..launch.run import COMMAND_FILE, DEFAULT_ENGINE, Draw, Job, run_scene
from .parser import Subparsers, add_choice, add_command, add_scene, add_settings, need_scene, positive_seconds, threads

NAME = "run"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder run`."""
    parser = add_command(
        subparsers, NAME, "run a scene and draw its pictures",
        "Checks the scene, runs it in two processes, draws contact_sheet.png.\n"
        "Ctrl-C ends the run after the current window, with the pictures so far.",
        "sunder run scenes/glass.textproto --set 'bodies[ball].twist.linear.z=-10'")
    add_scene(parser, nargs="?")
    add_settings(parser, "change a field, e.g. shells[pane].thickness_m=0.003; repeatable")
    add_fidelity(parser)
    parser.add_argument("--out", metavar="DIR", type=Path,
                        help="run folder; an earlier run there is replaced (default: runs/<scene>-<date>-<time>)")
    parser.add_argument("--rigid", metavar="ENGINE",
                        help="a name that 'sunder engines' lists, inprocess[:NAME], the path of a program that serves\n"
                             f"one, or the address at which one waits (ipc://..., tcp://...); default: {DEFAULT_ENGINE}")
    parser.add_argument("--resume", metavar="DIR", type=Path,
                        help="continue the run in this folder from its last checkpoint; the result is the same to the bit,\n"
                             "but after Ctrl-C")
    parser.add_argument("--record", action="store_true", help="keep all messages in session.rec, for 'sunder replay'")
    parser.add_argument("--trace", action="store_true",
                        help="trace.json: both processes on one clock, for Perfetto or chrome://tracing")
    parser.add_argument("--profile", action="store_true",
                        help="profile.json and profile.png: the stages of a substep beside the limits of this machine,\n"
                             "which are measured at the end of the run")
    parser.add_argument("--keys", metavar="DIR", type=Path,
                        help="folder made by 'sunder keys'; encrypts the messages, which tcp:// to another machine requires")
    parser.add_argument("--until", metavar="SECONDS", type=positive_seconds,
                        help="end at this simulated time instead of the scene's end_time_s")
    parser.add_argument("--threads", metavar="N", type=threads, help="threads of the shell solver (default: all)")
    parser.add_argument("--quiet", action="store_true", help="no progress and no summary, errors only")
    parser.add_argument("--no-pictures", dest="pictures", action="store_false",
                        help="leave contact_sheet.png to 'sunder render DIR --sheet', also where the run is resumed")


def add_fidelity(parser: argparse.ArgumentParser) -> None:
    """Adds the option --fidelity, which `run` and `check` share."""
    add_choice(parser, "--fidelity", tuple(PRESETS),
               "replace the scene's elements and window by those of a preset; --set has the last word")


def run(arguments: argparse.Namespace) -> int:
    """Runs or resumes; returns the exit status. Raises CommandError."""
    if arguments.resume:
        return _resume(arguments)
    if arguments.scene is None:
        raise CommandError("run: SCENE is missing; see 'sunder run --help'", BAD_INPUT)
    need_scene(arguments.scene)
    settings = with_fidelity(arguments.scene, arguments.settings, arguments.fidelity, arguments.quiet, arguments.until)
    job = Job(arguments.scene, arguments.rigid or DEFAULT_ENGINE, tuple(settings), arguments.until, arguments.threads,
              arguments.keys, arguments.record, arguments.trace, arguments.fidelity, arguments.profile, arguments.pictures)
    return run_scene(job, arguments.out, arguments.quiet, draw=_draw if arguments.pictures else None,
                     draw_profile=_profile_picture(arguments))


def _resume(arguments: argparse.Namespace) -> int:
    for given, name in ((arguments.scene, "SCENE"), (arguments.settings, "--set"), (arguments.out, "--out"),
                        (arguments.record, "--record"), (arguments.fidelity, "--fidelity"), (arguments.rigid, "--rigid")):
        if given:
            raise CommandError(f"--resume {arguments.resume}: continues with the scene, settings and engine of that run; leave "
                               f"{name} out")
    kept = Job.read(arguments.resume)
    if not kept.scene.is_file():
        raise CommandError(f"{kept.scene}: no such scene file; the run in {arguments.resume} was of it")
    if engines.is_path(kept.engine) and engines.no_program(kept.engine):
        raise CommandError(f"--resume {arguments.resume}: {kept.engine}: {engines.no_program(kept.engine)}. That run was made "
                           f"with it; put it back there, or write its new path as \"engine\" into {arguments.resume / COMMAND_FILE}")
    arguments.pictures &= kept.pictures
    job = Job(kept.scene, kept.engine, kept.settings, arguments.until or kept.until, arguments.threads or kept.threads,
              arguments.keys, trace=arguments.trace, fidelity=kept.fidelity, profile=arguments.profile,
              pictures=arguments.pictures)
    return run_scene(job, None, arguments.quiet, arguments.resume, _draw if arguments.pictures else None,
                     _profile_picture(arguments))


def _profile_picture(arguments: argparse.Namespace) -> Draw | None:
    """What draws the profile. Raises CommandError where it is asked for and cannot be drawn, before anything is run."""
    if not arguments.profile or not arguments.pictures:
        return None
    from ..pictures.plots import need_matplotlib
    from ..pictures.roofline import write_profile
    try:
        need_matplotlib()
    except CommandError as error:
        raise CommandError(f"--profile: {error}; or leave the picture out with --no-pictures", BAD_INPUT) from None
    return write_profile


def _draw(folder: Path) -> Path:
    from ..pictures.contact_sheet import write_contact_sheet  # numpy and PIL only now
    return write_contact_sheet(folder)
