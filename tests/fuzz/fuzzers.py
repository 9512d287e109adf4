"""`sunder fuzz`: clang's libFuzzer on everything that reads what others wrote; see tests/fuzz/README.md."""
from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from sunder_tools.errors import BAD_INPUT, CHECK_FAILED, DONE, CommandError
from sunder_tools.launch.build import only_builder
from sunder_tools.launch.install import PACKAGES, ensure_installed
from sunder_tools.launch.logged import run_logged, tail
from sunder_tools.places import REPOSITORY
from sunder_tools.words import did_you_mean

# Messages get most: they come from another process. Seconds a target that ends by itself would take are not known.
TARGETS = ("session", "replies", "bullet", "ode", "scene", "pgm", "mesh", "surface", "pc2")
DEFAULT_RUNS = 100_000
FUZZ_PACKAGES = ("clang", "libclang-rt-dev")  # compiler; sanitizers and libFuzzer
MOST_BYTES = 4096
SLOWEST_S = 20  # for one input
# Leaks of exceptions on their way are none; a short quarantine is twice as fast.
SANITIZERS = {"ASAN_OPTIONS": "detect_leaks=0:quarantine_size_mb=16:malloc_context_size=8",
              "UBSAN_OPTIONS": "print_stacktrace=1"}


def fuzz(target: str | None, runs: int) -> int:
    """Installs clang, builds the fuzzers into build/fuzz, gives each `runs` inputs; exit status 1 for a finding."""
    if target is not None and target not in TARGETS:
        raise CommandError(f"no target '{target}'; {did_you_mean(target, TARGETS)}", BAD_INPUT)
    folder = REPOSITORY / "build" / "fuzz"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with only_builder(folder.parent / "lock"):
            ensure_installed(folder.parent / "install.log", PACKAGES + FUZZ_PACKAGES)
            _build(folder)
        (folder / "findings").mkdir(exist_ok=True)
        found = [name for name in ((target,) if target else TARGETS) if not _run(folder, name, runs)]
    except OSError as error:
        raise CommandError(f"cannot fuzz in {folder}: {error.strerror or error}: {error.filename}") from None
    return CHECK_FAILED if found else DONE


def _build(folder: Path) -> None:
    log = folder / "build.log"
    log.unlink(missing_ok=True)
    print("sunder: building the fuzzers, with sanitizers", file=sys.stderr, flush=True)
    for command in (["cmake", "-S", str(REPOSITORY / "tests" / "fuzz"), "-B", str(folder), "-G", "Ninja",
                     "-DCMAKE_CXX_COMPILER=clang++"], ["cmake", "--build", str(folder)]):
        if run_logged(command, log) != 0:
            raise CommandError(f"{tail(log, 40)}\nbuilding the fuzzers failed; the whole log is {log}")


def _run(folder: Path, name: str, runs: int) -> bool:
    """True where nothing was found. New inputs that reach new code stay in build/fuzz/corpus for the next time."""
    subprocess.run([str(folder / "fuzz_seeds"), str(folder / "corpus")], check=True)
    own = folder / "corpus" / name
    own.mkdir(parents=True, exist_ok=True)
    given = [path for path in (REPOSITORY / "tests" / "fuzz" / "corpus" / name,) if path.is_dir()]
    log = folder / f"{name}.log"
    options = [f"-runs={runs}", f"-max_len={MOST_BYTES}", f"-timeout={SLOWEST_S}", "-entropic=0",
               "-print_final_stats=1", f"-artifact_prefix={folder}/findings/{name}-"]
    if name == "scene":
        given.append(REPOSITORY / "scenes")
        options.append(f"-dict={_dictionary(folder / 'scene.dict')}")
    memory = Path("/dev/shm")
    # what a fuzzer writes for itself to read must not wear out a disk, nor stay where one is killed
    with tempfile.TemporaryDirectory(dir=memory if os.access(memory, os.W_OK) else None) as temporary:
        with log.open("wb") as sink:
            status = subprocess.run([str(folder / f"fuzz_{name}"), *options, str(own), *map(str, given)], check=False,
                                    stdout=sink, stderr=sink, stdin=subprocess.DEVNULL,
                                    env={**os.environ, **SANITIZERS, "TMPDIR": temporary}).returncode
    text = log.read_text(errors="replace")
    if status == 0:
        count = re.search(r"number_of_executed_units: *(\d+)", text)
        print(f"{name:8s} {count[1] if count else '?':>10s} inputs, nothing found", flush=True)
        return True
    why = re.search(r"^(finding: .*|.*runtime error: .*|==\d+== ?ERROR: .*)$", text, re.M)
    kept = re.search(r"Test unit written to (\S+)", text)
    print(f"{name:8s} {why[1] if why else f'ended with status {status}'}\n"
          f"         input {kept[1] if kept else 'not kept'}, whole log {log}", flush=True)
    return False


def _dictionary(path: Path) -> Path:
    """The words of scenes: names of fields and of enumerations."""
    files = (REPOSITORY / "proto" / f"{name}.proto" for name in ("scene", "shell", "patch", "bodies", "geometry"))
    text = "".join(file.read_text() for file in files)
    words = sorted(set(re.findall(r"\b(\w+) = \d+;", text)))
    path.write_text("".join(f'"{word}"\n' for word in words))
    return path
