"""Which engine has which capability: each is launched and asked, and the table of rigid/README.md is what they say.

    /usr/bin/python3 -B -m tests.docs.engines      # writes the table into rigid/README.md

The table stands between the lines BEGIN and END. Its test makes it anew and compares. An engine that this machine does not have,
such as one under Node.js without its packages, keeps its column.
"""
from __future__ import annotations

import re
import sys

from tests.docs.snippets import TOP

sys.path.insert(0, str(TOP / "coupler"))
sys.pycache_prefix = str(TOP / "build" / "pycache")
from sunder_tools.errors import CommandError  # noqa: E402
from sunder_tools.launch import engines  # noqa: E402
from sunder_tools.launch.build import Executables, ensure_built  # noqa: E402

PAGE = TOP / "rigid" / "README.md"
KNOWN = TOP / "tests" / "conformance" / "known"
CAPABILITIES = "Capabilities"  # the heading on the page whose table has the words in order
BEGIN, END = "<!-- engines: made by tests/docs/engines.py -->", "<!-- end of engines -->"
HAS, LACKS = "yes", ""
FAILS = "rows of the suite that are known to fail"


def words_of(page: str) -> list[str]:
    """The capabilities that the page explains, in its order."""
    part = page.partition(BEGIN)[0].partition(f"\n## {CAPABILITIES}\n")[2]
    cells = [line.split("|")[1] for line in part.splitlines() if line.startswith("| `")]
    return [word for cell in cells for word in re.findall(r"`([^`]+)`", cell)]


def declared(executables: Executables) -> dict[str, list[str] | None]:
    """What each engine of the project declares; None of one that this machine does not have."""
    found: dict[str, list[str] | None] = {}
    for name in engines.names(executables):
        try:
            said = engines.hello(engines.resolve(name, executables), executables)["capabilities"]
            assert isinstance(said, list)
            found[name] = [str(word) for word in said]
        except CommandError as error:
            print(f"{name} keeps its column: {error}", file=sys.stderr)
            found[name] = None
    found.setdefault(engines.DART, None)  # where it is not built
    return found


def known_failures(name: str) -> list[str]:
    """Rows of the suite that an engine is known to fail, without the reasons."""
    path = KNOWN / f"{name}.txt"
    lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() else []
    return [line.split()[0] for line in lines if line.strip() and not line.startswith("#")]


def columns_of(made: str) -> dict[str, list[str]]:
    """The columns of a table, by their heads, without these."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in made.splitlines() if line.startswith("|")]
    return {column[0].strip("`"): list(column[2:]) for column in zip(*rows)} if rows else {}


def table(words: list[str], found: dict[str, list[str] | None], written: str) -> str:
    """The table; a column that is not known is that of the table as `written`. Raises ValueError where an engine declares what
    the page does not explain."""
    kept = columns_of(written)
    columns = []
    for name, said in found.items():
        unknown = [word for word in said or [] if word not in words]
        if unknown:
            raise ValueError(f"{name} declares {', '.join(unknown)}, which {PAGE.name} does not explain under '{CAPABILITIES}'")
        cells = [HAS if word in said else LACKS for word in words] if said is not None else kept.get(name, [])[:len(words)]
        cells += [""] * (len(words) - len(cells))
        columns.append([f"`{name}`", "---", *cells, ", ".join(f"`{row}`" for row in known_failures(name))])
    head = ["capability", "---", *(f"`{word}`" for word in words), FAILS]
    return "\n".join(f"| {' | '.join(row)} |" for row in zip(head, *columns))


def parts_of(text: str) -> tuple[str, str, str]:
    """The page before the table, the table, and the page after it. Raises ValueError where the marks are not there."""
    before, begin, rest = text.partition(BEGIN + "\n")
    made, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"{PAGE}: needs the lines {BEGIN} and {END}")
    return before + begin, made.rstrip("\n"), END + after


def main() -> int:
    """Writes the table."""
    text = PAGE.read_text(encoding="utf-8")
    before, made, after = parts_of(text)
    PAGE.write_text(before + table(words_of(text), declared(ensure_built()), made) + "\n" + after, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
