"""`sunder engine new`: a rigid-body engine to start from."""
from __future__ import annotations

import argparse
import re
from pathlib import Path

from ..errors import BAD_INPUT, DONE, CommandError
from ..places import REPOSITORY
from ..words import command_line
from .parser import Subparsers, add_choice, add_command, one_of

NAME = "engine"
PYTHON = '''\
#!/usr/bin/python3
"""{name}: a rigid-body engine for Sunder. It has no contacts yet: each body goes on as the shell process predicts."""
import sys

sys.path.append({modules!r})  # where sunder_engine is
from sunder_engine import BAD_INPUT, Engine, Refused, main  # noqa: E402


class {type}(Engine):
    name, version = "{name}", "0.1"
    # Words of rigid/README.md. Declare one once its cases of the suite pass: "contact", "friction", ...
    capabilities = ["spheres", "boxes", "half_spaces", "convex_hulls", "compound", "deterministic", "double_precision"]

    def __init__(self):
        self.bodies = {{}}  # RigidBody by id: shape, mass, principal_inertia, is_static, contact_group
        self.moving = {{}}  # BodyState by id, of each body that is not static: position, orientation w x y z, velocity,
        #                     angular_momentum (world axes, about the centre of mass)

    def add(self, body):
        if body.mass > 1e9:  # refuse what your engine cannot hold
            raise Refused("bad_body", f"body {{body.id}}: {{body.mass}} kg is too heavy", BAD_INPUT)
        self.bodies[body.id] = body
        if not body.is_static:
            self.moving[body.id] = self.state_of(body)

    def advance(self, window_s, predicted, solved):
        for motion in predicted:
            # An engine with contacts solves them here. Start each body with the average velocity that leads from
            # self.moving[motion.id] to motion in window_s. Then add the change of velocity that the contacts made to
            # motion.velocity, and window_s times that change to motion.position (rigid/README.md, "A window").
            self.move(self.moving[motion.id], motion)

    def states(self):
        return [self.moving[number] for number in sorted(self.moving)]


if __name__ == "__main__":
    sys.exit(main({type}))
'''
TEMPLATES = {"python": PYTHON}


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder engine`."""
    parser = add_command(subparsers, NAME, "write a rigid-body engine to start from",
                         "'engine new' writes NAME, a program: a whole engine without contacts, on a base class that has\n"
                         "the session, its checks and the connection. Refuses to replace a file.",
                         "sunder engine new my_engine && sunder run SCENE --rigid ./my_engine")
    parser.add_argument("action", metavar="new", type=one_of("new"), help="what to do: new")
    parser.add_argument("name", metavar="NAME", type=Path, help="name of the engine, with a folder before it if you like")
    add_choice(parser, "--language", tuple(TEMPLATES), "language of the engine (default: python)", "python")


def run(arguments: argparse.Namespace) -> int:
    """Writes the engine and says how to try it; returns the exit status. Raises CommandError."""
    target, name = arguments.name, arguments.name.name
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise CommandError(f"engine new: '{name}' is no name of an engine: it has small letters, digits and '_' and starts "
                           "with a letter", BAD_INPUT)
    text = TEMPLATES[arguments.language].format(name=name, modules=str(REPOSITORY / "coupler"),
                                                type="".join(part.capitalize() for part in name.split("_")))
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with target.open("x", encoding="utf-8") as sink:
            sink.write(text)
        target.chmod(0o755)
    except FileExistsError:
        raise CommandError(f"{target}: is there already, and is not replaced; choose another name or folder",
                           BAD_INPUT) from None
    except OSError as error:
        raise CommandError(f"cannot write {target}: {error.strerror}", BAD_INPUT) from None
    path = target if target.is_absolute() else Path(".") / target
    called = command_line([f"./{path}" if not path.is_absolute() else path])
    print(f"{target} is written; try it with: sunder validate engines --rigid {called}\n"
          f"and run a scene with:    sunder run SCENE --rigid {called}")
    return DONE
