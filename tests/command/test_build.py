"""Installing and building, without apt and cmake: what is asked of them, and what is said when they fail."""
from __future__ import annotations

import contextlib
import errno
import fcntl
import io
import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

from sunder_tools.command import build as command
from sunder_tools.command.main import main
from sunder_tools.errors import CommandError
from sunder_tools.launch import build, engines, first_use, install, level, logged
from sunder_tools.places import BUILD_DIR_VARIABLE

from ..validation import programs
from . import REPOSITORY


class Fresh(unittest.TestCase):
    """The real build files, asked what they would build: nothing is compiled."""

    def test_the_suite_of_engines_is_built_where_no_test_was(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            root = Path(os.path.realpath(name))
            for path in REPOSITORY.iterdir():
                if path.name not in ("build", "runs", ".git"):
                    (root / path.name).symlink_to(path)
            log = root / "build" / build.LOG

            def ask(command: list[str], to: Path, cwd: Path | None = None, on_line: Any = None) -> int:
                if command[1] == "--build":  # ninja lists what these targets need; it knows no target that is not configured
                    command = ["ninja", "-C", command[2], "-t", "commands", *command[4:-2]]
                return logged.run_logged(command, to, cwd, on_line)

            with mock.patch.object(build, "REPOSITORY", root), mock.patch.object(build, "run_logged", ask), \
                    mock.patch.object(build, "ensure_installed"), mock.patch.dict(os.environ), \
                    mock.patch.object(first_use, "_built_in", None), contextlib.redirect_stderr(io.StringIO()) as said:
                os.environ.pop(BUILD_DIR_VARIABLE, None)
                build.ensure_built()
                of_a_run = log.read_text()
                build.ensure_built(targets=("sunder-conformance",))  # as `validate engines` asks for it
                of_the_suite = log.read_text()
        self.assertIn("-o rigid/sunder-rigid", of_a_run)
        self.assertNotIn("-o tests/sunder-conformance", of_a_run)
        self.assertIn("-o tests/sunder-conformance", of_the_suite)
        self.assertEqual(said.getvalue().count("sunder: configuring"), 2, "the tests' build files were not there before")


class Building(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.root = Path(os.path.realpath(temporary.name))
        self.folder = self.root / "build" / "release"
        self.said = io.StringIO()
        self.commands: list[list[str]] = []
        self.status = 0
        self.cad = self.dart = False
        self.ensure_installed = mock.MagicMock()
        contexts: tuple[contextlib.AbstractContextManager[Any], ...] = (
            mock.patch.object(build, "REPOSITORY", self.root), contextlib.redirect_stderr(self.said),
            mock.patch.object(build, "ensure_installed", self.ensure_installed), mock.patch.object(build, "run_logged", self.run_fake),
            mock.patch.dict(os.environ), mock.patch.object(first_use, "_built_in", None))
        for context in contexts:
            context.__enter__()
            self.addCleanup(context.__exit__, None, None, None)
        os.environ.pop(BUILD_DIR_VARIABLE, None)

    def run_fake(self, command: list[str], log: Path, cwd: Path | None = None, on_line=None) -> int:
        self.commands.append(command)
        self.assertEqual(cwd, self.root)
        if command[1] == "--preset":
            self.folder.mkdir(parents=True, exist_ok=True)
            (self.folder / "build.ninja").write_text("")
            self.cad = self.cad or "-DSUNDER_CAD=ON" in command  # cmake's cache keeps it
            self.dart = self.dart or "-DSUNDER_DART=ON" in command
            tests = "ON" if "-DBUILD_TESTING=ON" in command else "OFF"
            (self.folder / "CMakeCache.txt").write_text(f"CMAKE_HOME_DIRECTORY:INTERNAL={self.root}\n"
                                                        f"SUNDER_CAD:BOOL={'ON' if self.cad else 'OFF'}\n"
                                                        f"SUNDER_DART:BOOL={'ON' if self.dart else 'OFF'}\nBUILD_TESTING:BOOL={tests}\n")
        with log.open("a") as sink:
            sink.write("".join(f"line {k}\n" for k in range(100)))
        for line in ("[0/1] Re-checking globbed directories...", "[1/2] one", "[2/2] two") if on_line and len(self.commands) < 3 else ():
            on_line(line)
        return self.status

    def test_configures_once(self) -> None:
        found = build.ensure_built()
        self.assertEqual(found.shell, self.folder / "shell" / "sunder-shell")
        self.assertEqual([c[:3] for c in self.commands],
                         [["cmake", "--preset", "release"], ["cmake", "--build", str(self.folder)]])
        self.assertIn("sunder-rigid", self.commands[1])
        self.assertIn("building 2 steps", self.said.getvalue())
        said = self.said.getvalue()
        build.ensure_built()
        self.assertEqual(len(self.commands), 3)
        self.assertEqual(self.said.getvalue(), said, "nothing to do, nothing to say")

    def test_what_a_run_needs_comes_first_and_tests_when_they_are_wanted(self) -> None:
        build.ensure_built()
        self.assertEqual(self.ensure_installed.call_args.args[1], install.PACKAGES)
        self.assertEqual(self.commands[0], ["cmake", "--preset", "release", "-DBUILD_TESTING=OFF"])
        build.ensure_built(targets=("sunder-single",))
        self.assertEqual([c[1] for c in self.commands[2:]], ["--build"], "it needs no package of tests")
        build.ensure_built(targets=("sunder-bench",))
        self.assertEqual(self.ensure_installed.call_args.args[1], install.PACKAGES + install.TEST_PACKAGES)
        self.assertEqual(self.commands[3], ["cmake", "--preset", "release", "-DBUILD_TESTING=ON"])
        self.assertEqual(self.commands[4][3:-2], ["--target", "sunder-shell", "sunder-rigid", "sunder-bench"])
        build.ensure_built(all_targets=True)
        self.assertNotIn("--target", self.commands[5])
        build.ensure_built(cad=True)
        self.assertEqual(self.commands[6], ["cmake", "--preset", "release", "-DBUILD_TESTING=ON", "-DSUNDER_CAD=ON"])

    def test_the_times_of_the_first_use_are_kept_and_no_later_ones(self) -> None:
        kept = self.root / "build" / first_use.FILE
        first_use.drawn()
        self.assertFalse(kept.exists(), "no program has been built")
        build.ensure_built()
        first_use.tested(kept.parent)  # without a first picture: not of a first use
        self.assertEqual(list(first_use.read(kept.parent)), ["first_build_s", "first_build_steps"])
        self.assertEqual(first_use.read(kept.parent)["first_build_steps"], 2.0)
        first_use.installed(kept.parent, 24.04)
        first_use.drawn()
        before = first_use.read(kept.parent)
        self.assertEqual((list(before), before["first_install_s"]), (list(first_use.KEYS), 24.0))
        made_with = first_use.made_with(kept.parent)
        self.assertEqual({"commit", "date", "system", "processor", "cores", "load", "compiler"}, set(made_with))
        (self.folder / "CMakeCache.txt").unlink()
        self.commands.clear()
        build.ensure_built()
        first_use.installed(kept.parent, 1.0)
        first_use.drawn()
        self.assertEqual((first_use.read(kept.parent), first_use.made_with(kept.parent)), (before, made_with))
        first_use.failed(kept.parent)
        first_use.tested(kept.parent)
        self.assertEqual(first_use.read(kept.parent), before, "what is built by then is not in it")
        kept.write_text(kept.read_text().replace(first_use.FAILED, "nothing"))
        first_use.tested(kept.parent)
        after = first_use.read(kept.parent)
        self.assertEqual((list(after), first_use.made_with(kept.parent)), ([*first_use.KEYS, first_use.TEST_KEY], made_with))
        first_use.tested(kept.parent)
        self.assertEqual(first_use.read(kept.parent), after)
        kept.write_text("[")
        self.assertEqual((first_use.read(kept.parent), first_use.made_with(kept.parent)), ({}, {}))

    def test_an_installation_uses_its_own_programs(self) -> None:
        programs = self.root / "libexec"
        here = programs / "x86-64-v2"
        here.mkdir(parents=True)
        (here / "sunder-shell").write_text("")
        (self.root / "VERSION").write_text("1.2.3\n")
        with mock.patch.object(build, "INSTALLED", self.root / "VERSION"), mock.patch.object(build, "PROGRAMS", programs):
            self.assertEqual(build.ensure_built().rigid, here / "sunder-rigid")
            self.assertEqual(build.ensure_built(cad=True).rigid, here / "sunder-rigid", "the solver says whether it has it")
            with self.assertRaisesRegex(CommandError, "which an installation does not have"):
                build.ensure_built(targets=("sunder-bench",))
        self.assertEqual(self.commands, [], "nothing is built")

    def test_cad_installs_and_configures_once_more_and_stays(self) -> None:
        build.ensure_built()
        self.assertEqual(self.ensure_installed.call_args.args[1], install.PACKAGES)
        build.ensure_built(cad=True)
        self.assertEqual(self.ensure_installed.call_args.args[1], install.PACKAGES + install.CAD_PACKAGES)
        self.assertEqual(self.commands[2], ["cmake", "--preset", "release", "-DBUILD_TESTING=OFF", "-DSUNDER_CAD=ON"])
        before = len(self.commands)
        build.ensure_built(cad=True)
        build.ensure_built()
        self.assertTrue(all(c[:2] == ["cmake", "--build"] for c in self.commands[before:]), "nothing to configure")
        self.assertTrue(self.cad)

    def test_dart_is_a_program_of_its_own_that_few_ask_for(self) -> None:
        build.ensure_built(cad=True)
        self.assertNotIn("-DSUNDER_DART=ON", self.commands[0])
        found = engines.resolve("dart", build.ensure_built())
        self.assertEqual(found.command, (str(self.folder / "rigid" / "sunder-rigid-dart"), "--engine", "dart"))
        self.assertEqual(self.ensure_installed.call_args.args[1], install.PACKAGES + install.DART_PACKAGES)
        self.assertEqual(self.commands[-2], ["cmake", "--preset", "release", "-DBUILD_TESTING=OFF", "-DSUNDER_DART=ON"])
        self.assertEqual(self.commands[-1][3:-2], ["--target", "sunder-shell", "sunder-rigid", "sunder-rigid-dart"])
        build.ensure_built()
        self.assertNotIn("sunder-rigid-dart", self.commands[-1])
        (self.root / "VERSION").write_text("1.2.3\n")
        with mock.patch.object(build, "INSTALLED", self.root / "VERSION"), self.assertRaisesRegex(CommandError, "an installation does not have"):
            build.ensure_built(dart=True)
        os.environ[BUILD_DIR_VARIABLE] = str(self.folder)
        self.finished("shell/sunder-shell", "rigid/sunder-rigid")
        asked = f"lacks sunder-rigid-dart.*run: cmake -S {self.root} -B {self.folder} -DSUNDER_DART=ON && cmake --build .*libdart-dev"
        with self.assertRaisesRegex(CommandError, asked):
            engines.resolve("dart", build.ensure_built())
        self.finished("rigid/sunder-rigid-dart")
        self.assertEqual(engines.resolve("dart", build.ensure_built()), found)

    def test_the_table_of_engines_says_what_brings_dart_here(self) -> None:
        def said() -> str:
            with mock.patch.object(engines, "names", return_value=[]):
                return next(line for line in engines.table(build.Executables(*[self.folder / "none"] * 3)).splitlines() if "dart" in line)

        self.assertRegex(said(), r"^dart +- +not built: --rigid dart installs and builds it$")
        os.environ[BUILD_DIR_VARIABLE] = str(self.folder)
        self.assertRegex(said(), f"not built, and {BUILD_DIR_VARIABLE} is set; run: cmake -S {self.root} -B {self.folder} "
                                 f"-DSUNDER_DART=ON && cmake --build {self.folder} --target sunder-rigid-dart .*libdart-dev")
        del os.environ[BUILD_DIR_VARIABLE]
        (self.root / "VERSION").write_text("1.2.3\n")
        with mock.patch.object(build, "INSTALLED", self.root / "VERSION"):
            self.assertRegex(said(), "only from a checkout: 'coupler/sunder run SCENE --rigid dart' there installs and builds it$")

    def test_the_command_builds_here_or_says_why_not(self) -> None:
        with mock.patch.object(command, "ensure_built") as ensure:
            self.assertEqual(main(["build", "--cad"]), 0)
            ensure.assert_called_once_with(cad=True)
            os.environ[BUILD_DIR_VARIABLE] = str(self.root)
            self.assertEqual(main(["build"]), 2)
        self.assertIn("nothing is built then; unset it", self.said.getvalue())

    def test_a_moved_checkout_is_configured_again(self) -> None:
        self.folder.mkdir(parents=True)
        (self.folder / "CMakeCache.txt").write_text("CMAKE_HOME_DIRECTORY:INTERNAL=/elsewhere\n")
        (self.folder / "stale").write_text("")
        build.ensure_built()
        self.assertEqual(self.commands[0][:2], ["cmake", "--preset"])
        self.assertFalse((self.folder / "stale").exists())

    def test_failure_shows_the_end_of_the_log(self) -> None:
        self.status = 1
        with self.assertRaises(CommandError) as raised:
            build.ensure_built()
        self.assertEqual(raised.exception.status, 2)
        self.assertIn("line 99\nconfiguring failed with status 1", str(raised.exception))
        self.assertNotIn("line 59\n", str(raised.exception))

    def test_the_second_builder_waits_and_says_so(self) -> None:
        (self.root / "build").mkdir()
        with (self.root / "build" / "lock").open("a") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            second = threading.Thread(target=build.ensure_built)
            second.start()
            end = time.monotonic() + 1800.0
            while "another sunder is building" not in self.said.getvalue():
                self.assertLess(time.monotonic(), end)
                time.sleep(0.01)
            self.assertEqual(self.commands, [])
        second.join(1800.0)
        self.assertEqual(len(self.commands), 2)

    def test_who_waits_is_told_how_far_the_other_is(self) -> None:
        (self.root / "build").mkdir()
        log = self.root / "build" / "build.log"
        log.write_text("[99/99] of an earlier build\n")
        os.utime(log, (1.0, 1.0))
        with mock.patch.object(build, "TELL_S", 0.05), mock.patch.object(build, "POLL_S", 0.01), \
                (self.root / "build" / "lock").open("a") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            second = threading.Thread(target=build.ensure_built)
            second.start()
            for step in ("", "[3/64]", "[4/64]"):
                if step:
                    log.write_text(f"[0/2] Re-checking globbed directories...\n[2/64] a\n{step} b\na warning\n")
                end = time.monotonic() + 1800.0
                while f"the other one builds {step}\n" not in self.said.getvalue() if step else "waiting" not in self.said.getvalue():
                    self.assertLess(time.monotonic(), end)
                    time.sleep(0.01)
        second.join(1800.0)
        self.assertRegex(self.said.getvalue(), r"(?s)^sunder: another .*\nsunder: waiting; the other one builds \[3/64\]\nsunder: "
                         r"waiting; the other one builds \[4/64\]\nsunder: configuring\n")
        self.assertNotIn("99", self.said.getvalue())

    def test_a_build_that_was_interrupted_is_to_be_run_again(self) -> None:
        for self.status, how in ((-15, r" \(cmake was killed by SIGTERM\)"), (137, r" \(cmake was killed by SIGKILL\)")):
            with self.assertRaisesRegex(CommandError, f"was interrupted{how}; run this again, and it goes on from there; the "
                                                      "whole log is .*build.log$"):
                build.ensure_built()
        self.status = 1
        with mock.patch.object(build, "tail", lambda log, lines: "ninja: build stopped: interrupted by user."), \
                self.assertRaisesRegex(CommandError, "was interrupted; run this again"):
            build.ensure_built()

    def finished(self, *programs: str) -> None:
        for name in programs:
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (self.folder / name).write_text("")
            (self.folder / name).chmod(0o755)

    def test_a_finished_build_serves_those_who_may_not_write_to_it(self) -> None:
        (self.root / "shell").mkdir()
        (self.root / "shell" / "old.cpp").write_text("")
        self.finished("shell/sunder-shell", "rigid/sunder-rigid")
        more: list[dict[str, Any]] = [{"targets": ("sunder-single",)}, {"cad": True}, {"all_targets": True}]
        for number in (errno.EACCES, errno.EROFS):
            with mock.patch.object(build, "only_builder", side_effect=OSError(number, "no", "lock")):
                self.assertEqual(build.ensure_built().shell, self.folder / "shell" / "sunder-shell")
                self.assertEqual(self.said.getvalue(), "")
                for asked in more:
                    with self.assertRaisesRegex(CommandError, f"cannot build .* set {BUILD_DIR_VARIABLE} to a build folder"):
                        build.ensure_built(**asked)
        with mock.patch.object(build, "only_builder", side_effect=OSError(errno.EROFS, "no", "lock")):
            (self.root / "shell" / "new.cpp").write_text("")
            os.utime(self.root / "shell" / "new.cpp", (time.time() + 60, time.time() + 60))
            build.ensure_built()
            self.assertIn("note: ", self.said.getvalue())
            self.assertIn("shell/new.cpp is newer than its programs", self.said.getvalue())
            (self.folder / "shell" / "sunder-shell").unlink()
            with self.assertRaisesRegex(CommandError, BUILD_DIR_VARIABLE):
                build.ensure_built()
        with mock.patch.object(build, "only_builder", side_effect=OSError(errno.ENOSPC, "full", "lock")), \
                self.assertRaisesRegex(CommandError, "cannot build"):
            build.ensure_built()
        self.assertEqual(self.commands, [])

    def test_a_named_build_says_how_what_it_lacks_is_built(self) -> None:
        os.environ[BUILD_DIR_VARIABLE] = str(self.folder)
        self.finished("shell/sunder-shell", "rigid/sunder-rigid")
        executables = build.ensure_built()
        with self.assertRaisesRegex(CommandError, f"lacks sunder-single.*cmake --build {self.folder} --target sunder-single"):
            build.ensure_built(targets=("sunder-single",))
        with mock.patch.object(engines, "check") as check, self.assertRaisesRegex(CommandError, "--target sunder-single"):
            engines.resolve("inprocess:bullet", executables)
        check.assert_called_once()  # of a wrong name the user hears first
        with self.assertRaisesRegex(CommandError, f"cmake --build {self.folder} --target sunder-bench"):
            programs.program("sunder-bench")
        self.finished("coupler/single/sunder-single")
        build.ensure_built(targets=("sunder-single", "sunder-conformance"))
        self.assertEqual(engines.resolve("inprocess:ode", executables).in_process, "ode")

    def test_a_build_folder_without_executables_is_refused(self) -> None:
        os.environ[BUILD_DIR_VARIABLE] = str(self.root)
        with self.assertRaisesRegex(CommandError, "not an executable"):
            build.ensure_built()


class Levels(unittest.TestCase):
    """The programs of an installation: the highest level that the processor has, of those that are there."""

    def chosen(self, flags: set[str], there: tuple[str, ...]) -> str:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "cpuinfo").write_text(f"processor : 0\nflags : {' '.join(sorted(flags))}\n")
            for entry in there:
                (folder / "levels" / entry).mkdir(parents=True)
                (folder / "levels" / entry / "sunder-shell").write_text("")
            return level.level(folder / "levels", folder / "cpuinfo").name

    def test_the_highest_that_the_processor_has(self) -> None:
        second, third, fourth = level.NEEDS.values()
        everything = tuple(level.NEEDS)
        self.assertEqual(self.chosen(second, everything), "x86-64-v2")
        self.assertEqual(self.chosen(second | third, everything), "x86-64-v3")
        self.assertEqual(self.chosen(second | third | fourth, everything), "x86-64-v4")
        self.assertEqual(self.chosen(second | third | fourth, everything[:2]), "x86-64-v3")
        self.assertEqual(self.chosen(second | fourth, everything), "x86-64-v2", "a level needs those below it")

    def test_a_processor_that_is_too_old_is_refused_by_what_it_lacks(self) -> None:
        second, *_ = level.NEEDS.values()
        with self.assertRaisesRegex(CommandError, "this processor lacks popcnt"):
            self.chosen(second - {"popcnt"}, tuple(level.NEEDS))


class Installing(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.log = Path(temporary.name) / "install.log"

    def test_nothing_missing_runs_nothing(self) -> None:
        with mock.patch.object(install, "missing_packages", return_value=[]), \
                mock.patch.object(install, "run_logged") as run:
            install.ensure_installed(self.log)
        run.assert_not_called()

    def test_only_what_is_missing_is_installed(self) -> None:
        with mock.patch.object(install, "missing_packages", side_effect=[["cmake", "g++"], []]), \
                mock.patch.object(install, "_as_root", return_value=["sudo", "-n"]), \
                mock.patch.object(install, "run_logged", return_value=0) as run, \
                contextlib.redirect_stderr(io.StringIO()):
            install.ensure_installed(self.log)
        update, get = (call.args[0] for call in run.call_args_list)
        self.assertEqual(update[-1], "update")
        self.assertEqual(get[-4:], ["-y", "--no-install-recommends", "cmake", "g++"])
        self.assertEqual(get[:4], ["sudo", "-n", "env", "DEBIAN_FRONTEND=noninteractive"])

    def test_without_the_right_to_install_the_command_is_said(self) -> None:
        with mock.patch.object(install, "missing_packages", return_value=["cmake"]), \
                mock.patch.object(install, "_as_root", return_value=None), \
                self.assertRaisesRegex(CommandError, "sudo sh -c 'apt-get update && apt-get install .* cmake'"):
            install.ensure_installed(self.log)

    def test_apt_failure_shows_log_and_remedy(self) -> None:
        def fail(command: list[str], log: Path) -> int:
            log.write_text("E: Could not resolve 'deb.debian.org'\n")
            return 100
        with mock.patch.object(install, "missing_packages", return_value=["cmake"]), \
                mock.patch.object(install, "_as_root", return_value=[]), \
                mock.patch.object(install, "run_logged", fail), contextlib.redirect_stderr(io.StringIO()), \
                self.assertRaisesRegex(CommandError, "(?s)Could not resolve.*update failed with status 100.*check network"):
            install.ensure_installed(self.log)

    def test_another_distribution_is_told_what_to_install(self) -> None:
        elsewhere = {"ID": "fedora", "VERSION_ID": "41", "PRETTY_NAME": "Fedora Linux 41"}
        with mock.patch.object(install.platform, "freedesktop_os_release", return_value=elsewhere), \
                mock.patch.object(install.subprocess, "run", side_effect=FileNotFoundError), \
                self.assertRaisesRegex(CommandError, "Fedora Linux 41 has no dpkg.*Debian 13, Ubuntu 24.04 .names only, not "
                                                     "tried.*Eigen.*protoc.*SUNDER_BUILD_DIR"):
            install.missing_packages()

    def test_an_untried_distribution_is_named_before_it_is_installed_on(self) -> None:
        ubuntu = {"ID": "ubuntu", "VERSION_ID": "24.04", "PRETTY_NAME": "Ubuntu 24.04.1 LTS"}
        debian = {"ID": "debian", "VERSION_ID": "13", "PRETTY_NAME": "Debian GNU/Linux 13"}
        for told, expected in ((ubuntu, "Ubuntu 24.04.1 LTS was not tried"), (debian, "")):
            said = io.StringIO()
            with mock.patch.object(install.platform, "freedesktop_os_release", return_value=told), \
                    mock.patch.object(install, "missing_packages", side_effect=[["cmake"], []]), \
                    mock.patch.object(install, "_as_root", return_value=[]), \
                    mock.patch.object(install, "run_logged", return_value=0), contextlib.redirect_stderr(said):
                install.ensure_installed(self.log)
            self.assertEqual("was not tried" in said.getvalue(), bool(expected), said.getvalue())
            self.assertIn(expected, said.getvalue())

    def test_unknown_package_is_missing(self) -> None:
        self.assertEqual(install.missing_packages(("python3", "no-such-package-here")), ["no-such-package-here"])


class Logged(unittest.TestCase):
    def test_output_status_and_lines(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "log"
            lines: list[str] = []
            self.assertEqual(logged.run_logged(["sh", "-c", "echo one; echo two >&2; exit 7"], log, None, lines.append), 7)
            self.assertEqual(lines, ["one", "two"])
            self.assertEqual(logged.tail(log, 1), "two")

    def test_a_script_that_is_ended_takes_the_program_along(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            script = ("from pathlib import Path; from sunder_tools.launch.logged import run_logged; "
                      f"run_logged(['sh', '-c', 'echo $$; exec sleep 600'], Path('{folder}/log'), None, "
                      "lambda line: print(line, flush=True))")
            with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                                  env={**os.environ, "PYTHONPATH": str(REPOSITORY / "coupler")}) as process:
                assert process.stdout is not None
                child = int(process.stdout.readline())
                process.terminate()
                self.assertEqual(process.stdout.read(), "")  # its end: nobody holds the pipe
                process.wait()
            for _ in range(600):  # the kernel may not have put it away yet
                if not Path(f"/proc/{child}").exists() or "State:\tZ" in Path(f"/proc/{child}/status").read_text():
                    break
                time.sleep(0.1)
            else:
                self.fail(f"process {child} goes on")


if __name__ == "__main__":
    unittest.main()
