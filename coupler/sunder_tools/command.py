"""Arguments of `sunder`, and what each command does."""
from __future__ import annotations

import argparse
import difflib
import os
import signal
import subprocess
import sys
from pathlib import Path
from types import FrameType
from typing import NoReturn, Sequence

from .build import BUILD_DIR_VARIABLE, REPOSITORY, build_dir, ensure_built
from .errors import BAD_INPUT, CHECK_FAILED, DONE, INTERRUPTED, PEER_LOST, CommandError, Interrupted, how_it_ended
from .install import BROWSER_PACKAGES, SLURM_PACKAGES, ensure_installed

COMMANDS = ("run", "check", "build", "test", "validate", "bench", "engines", "serve", "keys", "replay", "fuzz",
            "sweep", "trade", "models", "view", "render", "export")
EPILOG = f"""\
exit status:
  0 done, 1 a check failed, 2 bad input (also: cannot install, build or write),
  3 one of the two processes was lost, 4 physics or ledger, 130 interrupted

environment:
  {BUILD_DIR_VARIABLE}  use the executables of this build folder (shell/sunder-shell,
                    rigid/sunder-rigid); nothing is installed or built then
"""


def _setting(text: str) -> str:
    path, equals, _ = text.partition("=")
    if not equals or not path:
        raise argparse.ArgumentTypeError(f"'{text}' is not PATH=VALUE, e.g. bodies[ball].twist.linear.z=-20")
    return text


def _positive_seconds(text: str) -> str:
    try:
        good = 0.0 < float(text) < float("inf")
    except ValueError:
        good = False
    if not good:
        raise argparse.ArgumentTypeError(f"'{text}' is not a positive number of seconds")
    return text


def _threads(text: str) -> str:
    if not text.isascii() or not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a whole number of at least 1")
    return text


def _count(text: str) -> int:
    return int(_threads(text))


def _port(text: str) -> int:
    if not text.isascii() or not text.isdigit() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"'{text}' is not a port, 0 to 65535")
    return int(text)


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    numbers = [int(n) if n.isascii() and n.isdigit() and len(n) < 6 else 0 for n in (width, height)]
    if not all(32 <= n <= 7680 for n in numbers):
        raise argparse.ArgumentTypeError(f"'{text}' is no size, e.g. 1280x720; each of 32 to 7680 pixels")
    return numbers[0], numbers[1]


def _view(text: str) -> tuple[float, float]:
    from .render import VIEWS, parse_view
    try:
        return parse_view(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is no view: {', '.join(VIEWS)}, or AZIMUTH,ELEVATION in degrees "
                                         "(elevation of -89 to 89)") from None


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 1e-3 <= value <= 1e3:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of 0.001 to 1000")
    return value


class _Parser(argparse.ArgumentParser):
    """Like argparse, but an unknown command gets a suggestion."""

    def error(self, message: str) -> NoReturn:
        raise CommandError(f"{message}; see '{self.prog} --help'", BAD_INPUT)


def make_parser() -> argparse.ArgumentParser:
    """The parser of the whole command line."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = _Parser(prog="sunder", formatter_class=raw, epilog=EPILOG, allow_abbrev=False,
                     description="Tears and shatters thin shells; the pieces fall in a rigid-body engine.\n"
                                 "Installs and builds what is missing by itself.")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", parser_class=_Parser)

    run = commands.add_parser(
        "run", formatter_class=raw, allow_abbrev=False, help="run a scene and draw its pictures",
        description="Checks the scene, runs it in two processes, draws contact_sheet.png.\n"
                    "Ctrl-C ends the run after the current window, with the pictures so far.",
        epilog="example:\n  sunder run scenes/glass.textproto --set 'bodies[ball].twist.linear.z=-10'\n\n" + EPILOG)
    check = commands.add_parser(
        "check", formatter_class=raw, allow_abbrev=False, help="check a scene and say what it will cost",
        description="Reports errors with line, field and remedy; else sizes, stable step, minutes, memory.",
        epilog=EPILOG)
    run.add_argument("scene", metavar="SCENE", type=Path, nargs="?", help="scene file (.textproto)")
    check.add_argument("scene", metavar="SCENE", type=Path, help="scene file (.textproto)")
    for command in (run, check):
        command.add_argument("--set", metavar="PATH=VALUE", dest="settings", action="append", default=[],
                             type=_setting, help="change a field, e.g. shells[pane].thickness_m=0.003; repeatable")
        command.add_argument("--fidelity", choices=("draft", "standard", "reference"),
                             help="elements and window for the scene's own, chosen from 'sunder trade'; --set goes before it")
    run.add_argument("--out", metavar="DIR", type=Path,
                     help="run folder; an earlier run there is replaced (default: runs/<scene>-<date>-<time>)")
    run.add_argument("--rigid", metavar="ENGINE", default="bullet",
                     help="a name that 'sunder engines' lists, inprocess[:NAME], the path of a program that serves\n"
                          "one, or the address at which one waits (ipc://..., tcp://...); default: bullet")
    run.add_argument("--resume", metavar="DIR", type=Path,
                     help="go on with the run in this folder from its last checkpoint, to the bit")
    run.add_argument("--record", action="store_true", help="keep all messages in session.rec, for 'sunder replay'")
    run.add_argument("--trace", action="store_true",
                     help="trace.json: both processes on one clock, for Perfetto or chrome://tracing")
    run.add_argument("--keys", metavar="DIR", type=Path,
                     help="folder made by 'sunder keys': encrypts, as tcp:// beyond this machine must be")
    run.add_argument("--until", metavar="SECONDS", type=_positive_seconds,
                     help="end at this simulated time instead of the scene's end_time_s")
    run.add_argument("--threads", metavar="N", type=_threads, help="threads of the shell solver (default: all)")
    run.add_argument("--quiet", action="store_true", help="no progress and no summary, errors only")
    run.add_argument("--no-pictures", dest="pictures", action="store_false",
                     help="leave contact_sheet.png to 'sunder render DIR --sheet'")

    build = commands.add_parser(
        "build", formatter_class=raw, allow_abbrev=False, help="install and build, which run does by itself",
        description="Installs the packages and builds both programs. Needed for --cad only.", epilog=EPILOG)
    build.add_argument("--cad", action="store_true",
                       help="with OpenCASCADE, which reads STEP and IGES (40 MB more to install); run and test keep it")

    validate = commands.add_parser(
        "validate", formatter_class=raw, allow_abbrev=False, help="compare with exact and published answers",
        description="A table of case, computed, reference, error, tolerance, seconds; exit status 1 where a case fails.",
        epilog=EPILOG)
    validate.add_argument("what", metavar="WHAT", help="shells, seams, cracks, contact, soft, coupling, engines or extremes")
    validate.add_argument("--case", metavar="NAME", help="this case only")
    validate.add_argument("--full", action="store_true", help="with extremes: the long rows as well")
    validate.add_argument("--known", action="store_true",
                          help="exit status 0 where nothing fails but what is known to, as far as tests/validation/known allows")
    validate.add_argument("--rigid", metavar="ENGINE", help="with engines: this one only, as 'run' takes it")
    validate.add_argument("--json", metavar="FILE", type=Path, dest="report", help="the table as JSON")
    validate.add_argument("--plots", metavar="FILE.png", type=Path, help="plots of convergence")
    validate.add_argument("--pictures", metavar="DIR", type=Path, help="pictures of the runs, into this folder")
    bench = commands.add_parser(
        "bench", formatter_class=raw, allow_abbrev=False, help="measure speed beside the machine's limits",
        description="Minima over interleaved repetitions, and the machine's multiply-add peak and bandwidth in the\n"
                    "same run; what a window's exchange with an engine in another process costs, and a whole run.",
        epilog=EPILOG)
    bench.add_argument("--filter", metavar="NAME", dest="pattern", help="benchmarks whose name holds NAME")
    bench.add_argument("--json", metavar="FILE", type=Path, dest="report", help="the numbers as JSON")

    commands.add_parser("engines", formatter_class=raw, allow_abbrev=False, epilog=EPILOG,
                        help="list the rigid-body engines and what they can do",
                        description="Launches each engine and asks it; rigid/README.md says what the words promise.")
    serve = commands.add_parser(
        "serve", formatter_class=raw, allow_abbrev=False, help="wait with an engine for a run on another machine",
        description="Serves one session and ends with it. On the other machine:\n"
                    "  sunder run SCENE --rigid tcp://THIS_MACHINE:PORT --keys DIR", epilog=EPILOG)
    serve.add_argument("--endpoint", metavar="ADDRESS", required=True, help="tcp://0.0.0.0:PORT, or ipc://PATH")
    serve.add_argument("--rigid", metavar="ENGINE", default="bullet", help="its name or program (default: bullet)")
    serve.add_argument("--keys", metavar="DIR", type=Path, help="folder made by 'sunder keys', the same on both machines")
    keys = commands.add_parser(
        "keys", formatter_class=raw, allow_abbrev=False, help="make keys for a run across machines",
        description="Writes rigid.key and shell.key (secret, mode 0600) and both public keys into a new folder.\n"
                    "Each machine needs its own secret key and both public ones.", epilog=EPILOG)
    keys.add_argument("folder", metavar="DIR", type=Path)
    replay = commands.add_parser(
        "replay", formatter_class=raw, allow_abbrev=False, help="play a recorded run to one of its two sides alone",
        description="Exit status 0 where that side says what was recorded, to the bit; else 1 and the first difference.",
        epilog=EPILOG)
    replay.add_argument("folder", metavar="DIR", type=Path, help="folder of a run that was made with --record")
    replay.add_argument("--side", choices=("shell", "rigid"), default="shell", help="who is played to (default: shell)")
    replay.add_argument("--rigid", metavar="ENGINE", help="with --side rigid: another engine than the recorded one")
    replay.add_argument("--keys", metavar="DIR", type=Path, help="with --rigid tcp://HOST:PORT: as for 'sunder run'")
    fuzz = commands.add_parser(
        "fuzz", formatter_class=raw, allow_abbrev=False, help="feed garbage to everything that reads",
        description="Installs clang, builds fuzzers with sanitizers, and looks for input that does harm: messages of\n"
                    "both sides, scenes, images, meshes. Exit status 1 where something is found.", epilog=EPILOG)
    fuzz.add_argument("--target", metavar="NAME", help="session, replies, bullet, scene, pgm or mesh only")
    fuzz.add_argument("--runs", metavar="N", type=_count, default=None, help="inputs for each (default: 100000)")

    sweep = commands.add_parser(
        "sweep", formatter_class=raw, allow_abbrev=False, help="run the experiments that a Python file defines",
        description="Runs every combination of parameters and seeds that is not done yet, and writes results.csv,\n"
                    "results.sqlite, times.csv and plots.png. Stopped or killed, it goes on with the same command.\n"
                    "A run that fails is a row with its error, and exit status 1; the others are run.",
        epilog="example:\n  sunder sweep coupler/experiments/radial_cracks.py\n\n" + EPILOG)
    sweep.add_argument("file", metavar="FILE", type=Path, help="Python file with a sunder.Experiment or sunder.V50")
    sweep.add_argument("--out", metavar="DIR", type=Path, help="folder of the series (default: sweeps/<name of FILE>)")
    sweep.add_argument("--jobs", metavar="N", type=_count, help="runs at a time (default: processors / threads; of an\n"
                                                                "array: as many as Slurm has room for)")
    sweep.add_argument("--executor", choices=("local", "slurm"), default="local",
                       help="processes of this machine, or a Slurm job array; DIR is then on a disk that all nodes share")
    sweep.add_argument("--sbatch", metavar="OPTION", action="append", default=[],
                       help="for sbatch, e.g. --sbatch=--partition=long; repeatable")
    sweep.add_argument("--threads", metavar="N", type=_count, default=1, help="of each run (default: 1)")
    sweep.add_argument("--keep", choices=("last", "all", "none"), default="last",
                       help="frames that stay: first and last with crack lines of all times (default), all, or none")
    sweep.add_argument("--quiet", action="store_true", help="no progress, only the outcome")

    _add_trade(commands)

    models = commands.add_parser(
        "models", formatter_class=raw, allow_abbrev=False, help="list the active models of runs and their share of the time",
        description="A line a run, from its run.json, and why each model was active. Models of one stage share its time.",
        epilog=EPILOG)
    models.add_argument("folders", metavar="DIR", type=Path, nargs="+", help="folders of runs")

    view = commands.add_parser(
        "view", formatter_class=raw, allow_abbrev=False, help="play a run in the browser",
        description="Serves a page to this machine only, until Ctrl-C; a run that is still under way grows on it.",
        epilog=EPILOG)
    view.add_argument("folder", metavar="DIR", type=Path, help="folder of a run")
    view.add_argument("--port", metavar="PORT", type=_port, default=0, help="of 127.0.0.1 (default: a free one)")
    view.add_argument("--no-browser", action="store_true", help="say the address and open nothing")

    _add_pictures(commands)

    test = commands.add_parser(
        "test", formatter_class=raw, help="build everything and run the tests", usage="sunder test [CTEST_ARGUMENT ...]",
        description="What follows goes to ctest, e.g. sunder test -R vtp", epilog=EPILOG, add_help=False)
    test.add_argument("ctest", nargs=argparse.REMAINDER)
    return parser


def _add_trade(commands: argparse._SubParsersAction) -> None:
    trade = commands.add_parser(
        "trade", formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False,
        help="measure what each setting of a scene costs and what error it leaves",
        description="Runs the scene as it is, a reference as fine as the budget allows, then one setting changed at a time,\n"
                    "cheapest first, then several together. Writes trade.csv, trade.json, trade.png and results.csv (a row a\n"
                    "run). Stopped or killed, it goes on with the same command; a larger budget adds to what is there.",
        epilog="example:\n  sunder trade scenes/intact_pane.textproto --budget 5\n\n" + EPILOG)
    trade.add_argument("scene", metavar="SCENE", type=Path, help="scene file (.textproto)")
    trade.add_argument("--budget", metavar="MINUTES", type=float, default=10.0,
                       help="of processor time, all runs of both processes together (default: 10)")
    trade.add_argument("--out", metavar="DIR", type=Path, help="folder of the trade (default: trades/<name of SCENE>)")
    trade.add_argument("--json", metavar="FILE", type=Path, dest="report", help="trade.json here as well")
    trade.add_argument("--vary", metavar="NAMES", default="", help="these settings only, e.g. elements,window")
    trade.add_argument("--seeds", metavar="N", type=_count, help="runs of each setting (default: 4 where it cracks, else 1)")
    trade.add_argument("--set", metavar="PATH=VALUE", dest="settings", action="append", default=[], type=_setting,
                       help="change a field of the scene first; repeatable")
    trade.add_argument("--until", metavar="SECONDS", type=_positive_seconds, help="end each run at this simulated time")
    trade.add_argument("--rigid", metavar="ENGINE", default="bullet", help="as 'run' takes it (default: bullet)")
    trade.add_argument("--threads", metavar="N", type=_count, default=1, help="of each run (default: 1)")
    trade.add_argument("--jobs", metavar="N", type=_count, default=1, help="runs at a time (default: 1, least noise)")
    trade.add_argument("--quiet", action="store_true", help="no progress, only the outcome")


def _add_pictures(commands: argparse._SubParsersAction) -> None:
    raw = argparse.RawDescriptionHelpFormatter
    render = commands.add_parser(
        "render", formatter_class=raw, allow_abbrev=False, help="stills or a film of a run",
        description="Six stills, or those of --frames, into DIR/stills; with --film DIR/film.mp4, where ffmpeg cannot be\n"
                    "installed an animated GIF.",
        epilog="example:\n  sunder render runs/car --film --view 200,15 --colour speed\n\n" + EPILOG)
    render.add_argument("folder", metavar="DIR", type=Path, help="folder of a run")
    render.add_argument("--film", action="store_true", help="a film of all frames, or of those of --frames")
    render.add_argument("--sheet", action="store_true", help="contact_sheet.png again, and nothing else")
    render.add_argument("--frames", metavar="LIST", help="all, or numbers such as 0,5,10-20,last")
    render.add_argument("--out", metavar="PATH", type=Path, help="folder of the stills; file of the film, .mp4, .webm, .gif or\n"
                                                                 ".png (animated)")
    render.add_argument("--size", metavar="WxH", type=_size, default=(1280, 720), help="pixels (default: 1280x720)")
    render.add_argument("--view", metavar="VIEW", type=_view, help="where the eye is: front, back, left, right, top, or\n"
                        "AZIMUTH,ELEVATION in degrees, from +x (default: oblique, on the side that is hit)")
    render.add_argument("--zoom", metavar="F", type=_positive, default=1.0, help="times as near (default: 1)")
    render.add_argument("--close", action="store_true", help="the shell fills the picture, not all that happens")
    render.add_argument("--colour", choices=("part", "damage", "fragment", "speed"), default="part",
                        help="what the shell is coloured by (default: part)")
    render.add_argument("--no-caption", action="store_true", help="no time in the corner")
    render.add_argument("--rate", metavar="FPS", type=_positive, help="frames a second of the film (default: it lasts six\n"
                                                                      "seconds, within 4 to 30)")
    render.add_argument("--jobs", metavar="N", type=_count, default=os.cpu_count() or 1,
                        help="processes (default: as many as processors)")
    export = commands.add_parser(
        "export", formatter_class=raw, allow_abbrev=False, help="a sequence of meshes for Blender and Houdini",
        description="A file a frame into DIR/export: PLY with velocity per vertex and fragment, damage, part, body and\n"
                    "kind per face, or binary glTF; and frame_times.csv.", epilog=EPILOG)
    export.add_argument("folder", metavar="DIR", type=Path, help="folder of a run")
    export.add_argument("--format", choices=("ply", "gltf"), default="ply", help="default: ply")
    export.add_argument("--frames", metavar="LIST", help="numbers such as 0,5,10-20,last (default: all)")
    export.add_argument("--out", metavar="DIR", type=Path, help="another folder")


def _suggestion(command: str) -> str:
    near = difflib.get_close_matches(command, COMMANDS, n=1, cutoff=0.5)
    hint = f"did you mean '{near[0]}'?" if near else f"the commands are {', '.join(COMMANDS)}"
    return f"unknown command '{command}'; {hint} See 'sunder --help'"


def _build(cad: bool) -> int:
    if os.environ.get(BUILD_DIR_VARIABLE):
        raise CommandError(f"{BUILD_DIR_VARIABLE} is set: nothing is built then; unset it to build this checkout", BAD_INPUT)
    ensure_built(cad=cad)
    return DONE


def _with_fidelity(scene: Path, settings: list[str], name: str | None, quiet: bool, until: str | None = None) -> list[str]:
    """`settings`, and before them those of a preset; says which. `until` [s] is what the run will be given."""
    if name is None:
        return settings
    from . import fidelity
    from .scene_text import SceneTextError, parse_text
    shell = str(ensure_built().shell)

    def accepted(tried: Sequence[str]) -> bool:
        command = [shell, "--scene", str(scene), "--check", *(part for s in tried for part in ("--set", s)),
                   *(("--until", until) if until else ())]
        return subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              check=False).returncode == DONE
    try:
        found = fidelity.taken(name, parse_text(scene.read_text()), settings, accepted)
    except (OSError, UnicodeDecodeError, SceneTextError):
        return settings  # no scene: the solver says where
    if not quiet:
        print(f"sunder: {found.words()}", file=sys.stderr, flush=True)
    return [*found.settings, *settings]


def _check(scene: Path, settings: list[str]) -> int:
    executables = ensure_built()
    command = [str(executables.shell), "--scene", str(scene), "--check"]
    status = subprocess.run(command + [part for s in settings for part in ("--set", s)], check=False).returncode
    if status < 0:
        raise CommandError(f"sunder-shell {how_it_ended(status)} while checking {scene}", PEER_LOST)
    return status


def _get_packages() -> None:
    """Of the Jolt engine, Slurm and a browser, which only tests need: where they cannot be had those are skipped, no more."""
    from .node import ensure_node
    from .view import ensure_page

    def ensure_viewer(log: Path) -> None:
        ensure_installed(log, BROWSER_PACKAGES)
        ensure_page()

    log = REPOSITORY / "build" / "install.log"
    for what, install in (("the Jolt engine", ensure_node), ("Slurm", lambda log: ensure_installed(log, SLURM_PACKAGES)),
                          ("the viewer", ensure_viewer)):
        try:
            install(log)
        except (CommandError, OSError) as error:
            print(f"sunder: {error}\nsunder: so the tests of {what} are skipped", file=sys.stderr, flush=True)


def _test(arguments: list[str]) -> int:
    ensure_built(all_targets=True)
    if not os.environ.get(BUILD_DIR_VARIABLE):  # nothing is installed then
        _get_packages()
    at_once = len(os.sched_getaffinity(0)) + 1  # some wait: for a process to start, for its peer, for a browser
    command = ["ctest", "--test-dir", str(build_dir()), "--output-on-failure", f"-j{at_once}", *arguments]
    environment = {key: value for key, value in os.environ.items() if key != BUILD_DIR_VARIABLE}
    environment["PATH"] = "/usr/bin:/bin:" + environment.get("PATH", "")
    environment["OMP_WAIT_POLICY"] = "passive"  # tests run at once: threads that wait must leave the cores to the other
    status = subprocess.run(command, check=False, env=environment).returncode
    return DONE if status == 0 else CHECK_FAILED


def _render(options: argparse.Namespace) -> int:
    from .look import Look
    from .render import Shot, render
    if options.sheet and (options.film or options.frames or options.out):
        raise CommandError("--sheet goes with none of --film, --frames and --out", BAD_INPUT)
    shot = Shot(options.size, options.view, options.zoom, options.close, not options.no_caption, Look(options.colour))
    return render(options.folder, options.out, options.film, options.sheet, options.frames, shot, options.rate, options.jobs)


def _dispatch(arguments: list[str]) -> int:
    parser = make_parser()
    if not arguments:
        parser.print_help(sys.stderr)
        return BAD_INPUT
    if not arguments[0].startswith("-") and arguments[0] not in COMMANDS:
        raise CommandError(_suggestion(arguments[0]), BAD_INPUT)
    if arguments[0] == "test":  # by hand: argparse would take ctest's options for its own
        if arguments[1:2] in (["--help"], ["-h"]):
            parser._subparsers._group_actions[0].choices["test"].print_help()  # type: ignore[union-attr]
            return DONE
        return _test(arguments[1:])
    options = parser.parse_args(arguments)
    if options.command == "build":
        return _build(options.cad)
    if options.command in ("validate", "bench"):
        from . import measure
        if options.command == "bench":
            return measure.bench(options.pattern, options.report)
        return measure.validate(options.what, options.case, options.report, options.plots,
                                options.pictures, options.rigid, options.full, options.known)
    if options.command == "sweep":
        ensure_built()  # and installed: what follows needs protobuf and numpy
        from sunder_lab import sweep
        return sweep.sweep(options.file, sweep.settings_of(options.file, options.out, options.jobs, options.executor,
                                                           options.threads, options.keep, options.sbatch, options.quiet))
    if options.command == "trade":
        ensure_built()
        from sunder_lab.trade import command as trade
        return trade.trade(options)
    if options.command == "models":
        from . import models
        print(models.table(options.folders))
        return DONE
    if options.command == "view":
        from .view import view
        return view(options.folder, options.port, not options.no_browser)
    if options.command == "render":
        return _render(options)
    if options.command == "export":
        from .export import export
        return export(options.folder, options.format, options.out, options.frames)
    if options.command == "fuzz":
        from . import fuzz
        return fuzz.fuzz(options.target, options.runs or fuzz.DEFAULT_RUNS)
    if options.command in ("engines", "serve", "keys", "replay"):
        from . import peers
        return peers.dispatch(options)
    if options.command == "run" and options.resume:
        return _resume(options)
    if options.scene is None:
        raise CommandError("run: SCENE is missing; see 'sunder run --help'", BAD_INPUT)
    if not options.scene.is_file():
        raise CommandError(f"{options.scene}: no such scene file", BAD_INPUT)
    if options.command == "check":
        return _check(options.scene, _with_fidelity(options.scene, options.settings, options.fidelity, False))
    from .run import Job, run_scene  # here: `--help` and `check` do without it
    settings = _with_fidelity(options.scene, options.settings, options.fidelity, options.quiet, options.until)
    job = Job(options.scene, options.rigid, tuple(settings), options.until, options.threads, options.keys,
              options.record, options.trace, options.fidelity)
    return run_scene(job, options.out, options.quiet, pictures=options.pictures)


def _resume(options: argparse.Namespace) -> int:
    from .run import Job, run_scene
    for given, name in ((options.scene, "SCENE"), (options.settings, "--set"), (options.out, "--out"),
                        (options.record, "--record"), (options.fidelity, "--fidelity")):
        if given:
            raise CommandError(f"--resume {options.resume}: goes on with what is there; leave {name} out")
    kept = Job.read(options.resume)
    if not kept.scene.is_file():
        raise CommandError(f"{kept.scene}: no such scene file; the run in {options.resume} was of it")
    job = Job(kept.scene, kept.engine, kept.settings, options.until or kept.until, options.threads or kept.threads,
              options.keys, trace=options.trace, fidelity=kept.fidelity)
    return run_scene(job, None, options.quiet, options.resume, options.pictures)


def _interrupt(number: int, frame: FrameType | None) -> None:
    del number, frame
    raise Interrupted


def main(arguments: list[str]) -> int:
    """Runs the command line `arguments` (without the program's name); returns the exit status."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:  # nohup stays nohup
            signal.signal(number, _interrupt)
    try:
        return _dispatch(arguments)
    except CommandError as error:
        print(f"sunder: {error}", file=sys.stderr)
        return error.status
    except (Interrupted, KeyboardInterrupt):
        print("sunder: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # e.g. `sunder --help | head -1`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
