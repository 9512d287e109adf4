"""Fenced blocks of the READMEs, and what their info strings ask for.

    ```sh                       the block is run by bash, in a folder that has the checkout's files
    ```sh check: REASON         its commands are parsed and the files that they name must exist
    ```sh norun: REASON         it is left alone
    ```textproto                a whole scene: it must pass `sunder check` and, with until=SECONDS, is run for that long;
                                with `run` to its end
    ```textproto into=SCENE     a part of a scene: merged into SCENE, the same
    ```python run               it is run with the project's modules on the path
    ```python check: REASON     it must compile
    ```cpp check: REASON        a test of the place that REASON names compiles the same lines
    ```text                     output: left alone

Blocks of one README share a folder, in their order. `file=NAME` saves a block there. `drop=PATH,...` empties fields of the
base scene first, e.g. drop=bodies,shells[pane].supports.
"""
from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

TOP = Path(__file__).resolve().parents[2]
LANGUAGES = ("sh", "textproto", "python", "text", "cpp")


@dataclass(frozen=True)
class Snippet:
    """One fenced block."""
    readme: Path
    line: int  # of its opening fence, from 1
    language: str
    info: str  # what follows the language
    text: str

    @property
    def place(self) -> str:
        return f"{self.readme.relative_to(TOP)}:{self.line}"

    @property
    def mode(self) -> str:
        """run, check or norun."""
        word = re.match(r"(check|norun):", self.info)
        return word[1] if word else "run"

    @property
    def is_run(self) -> bool:
        """Whether a scene or a program is run, and not only checked."""
        return "run" in self.info.split() or self.option("until") is not None

    @property
    def reason(self) -> str:
        """Why it is not run."""
        return self.info.partition(":")[2].strip() if self.mode != "run" else ""

    def option(self, name: str) -> str | None:
        """The value of NAME=VALUE in the info string."""
        found = re.search(rf"(?:^|\s){name}=(\S+)", self.info)
        return found[1] if found else None


def readmes() -> list[Path]:
    """Every README.md of the checkout, those of builds and of installed packages left out."""
    return sorted(p for p in TOP.rglob("README.md")
                  if not {"build", "node_modules", "runs"} & set(p.relative_to(TOP).parts))


def snippets(readme: Path) -> list[Snippet]:
    """The blocks of a README, in order. Raises ValueError where one is not closed."""
    out: list[Snippet] = []
    begin, info = 0, ""
    held: list[str] = []
    for number, line in enumerate(readme.read_text().splitlines(), 1):
        fence = re.match(r"\s*```(.*)$", line)
        if not begin and fence:
            begin, info, held = number, fence[1].strip(), []
        elif begin and fence:
            language, _, rest = info.partition(" ")
            out.append(Snippet(readme, begin, language, rest.strip(), "\n".join(held) + "\n"))
            begin = 0
        elif begin:
            held.append(line)
    if begin:
        raise ValueError(f"{readme}:{begin}: the block is not closed")
    return out


def merged(base: Any, part: Any) -> None:
    """Puts `part` into `base`: an element of a list that has the name of one in `base` goes into that one."""
    for field, value in part.ListFields():
        if field.type != field.TYPE_MESSAGE:
            if field.label == field.LABEL_REPEATED:
                getattr(base, field.name).extend(value)
            else:
                setattr(base, field.name, value)
        elif field.label != field.LABEL_REPEATED:
            getattr(base, field.name).SetInParent()
            merged(getattr(base, field.name), value)
        else:
            for element in value:
                name = getattr(element, "name", "")
                same = [other for other in getattr(base, field.name) if name and getattr(other, "name", "") == name]
                merged(same[0] if same else getattr(base, field.name).add(), element)


def dropped(message: Any, path: str) -> None:
    """Empties a field, e.g. shells[pane].supports. Raises KeyError where it is not there."""
    for step in re.findall(r"[^.\[\]]+(?:\[[^\]]+\])?", path):
        name, _, element = step.partition("[")
        if not element:
            if step == path.rsplit(".", 1)[-1]:
                message.ClearField(name)
                return
            message = getattr(message, name)
            continue
        found = [m for m in getattr(message, name) if m.name == element.rstrip("]")]
        if not found:
            raise KeyError(path)
        message = found[0]
