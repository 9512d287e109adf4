"""Products fused with sums stay where they belong: of what both kernels and others make, the linker keeps one copy, and which
one would hang on what the compiler puts inline."""
from __future__ import annotations

import os
import re
import subprocess
import unittest
from pathlib import Path

PARTS = Path(os.environ.get("SUNDER_BUILD_DIR", "build/release")) / "shell"
FUSED = re.compile(r"\tvfn?m(?:add|sub)")  # instructions of x86-64 that fuse
OTHERS = ("sunder_shell", "sunder_shell_cold", "sunder-shell", "sunder_scene", "sunder_link")
HEAD = re.compile(r"^[0-9a-f]+ <(.*)>:$")


def lines(*command: str | Path) -> list[str]:
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, check=True).stdout.splitlines()


def objects(target: str) -> list[Path]:
    """The objects that the build knows of the target, not what earlier ones have left."""
    known = lines("ninja", "-C", PARTS.parent, "-t", "inputs", "shell/sunder-shell")
    return [PARTS.parent / name for name in known if f"/{target}.dir/" in name and name.endswith(".o")]


def shared(path: Path) -> set[str]:
    """Names of what may be in several objects."""
    return {parts[2] for line in lines("nm", path) if len(parts := line.split()) == 3 and parts[1] in "WV"}


def fused(path: Path) -> set[str]:
    """Names of the functions that fuse."""
    found, name = set(), ""
    for line in lines("objdump", "-d", "--no-show-raw-insn", path):
        if head := HEAD.match(line):
            name = head[1]
        elif FUSED.search(line):
            found.add(name)
    return found


class Fused(unittest.TestCase):
    def test_no_other_file_makes_what_a_kernel_fuses(self) -> None:
        kernels = objects("sunder_kernels")
        others = [path for target in OTHERS for path in objects(target)]
        self.assertGreater(min(len(kernels), len(others)), 10)
        elsewhere = set[str]().union(*map(shared, others))
        both = {name: path.name for path in kernels for name in fused(path) & elsewhere}
        self.assertEqual(both, {}, "make the file a kernel too (shell/CMakeLists.txt)")


if __name__ == "__main__":
    unittest.main()
