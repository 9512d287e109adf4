"""Parts of scene files that a script makes: the lines between `# begin NAME` and `# end NAME`."""
from __future__ import annotations

from pathlib import Path


def number(value: float) -> str:
    """Returns the shortest text of a number, to a nanometre."""
    text = f"{value:.9f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def replace_part(scene: Path, name: str, note: str, lines: list[str]) -> None:
    """Replaces a part of a scene; `note` says how it was made. Raises ValueError where the scene has no such part."""
    old = scene.read_text().splitlines()
    begins = [k for k, line in enumerate(old) if line.split(":")[0].strip() == f"# begin {name}"]
    ends = [k for k, line in enumerate(old) if line.strip() == f"# end {name}"]
    if len(begins) != 1 or len(ends) != 1 or ends[0] < begins[0]:
        raise ValueError(f"{scene}: needs a line '# begin {name}' and, below it, a line '# end {name}'")
    new = [*old[:begins[0]], f"# begin {name}: {note}", *lines, *old[ends[0]:]]
    scene.write_text("\n".join(new) + "\n")
