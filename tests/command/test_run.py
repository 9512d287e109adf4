"""`sunder run` with fake executables: outcomes, exit statuses, and what is left behind."""
from __future__ import annotations

import contextlib
import fcntl
import io
import json
import os
import signal
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path
from unittest import mock

from sunder_tools import errors
from sunder_tools.launch import folder
from sunder_tools.launch.own_time import OwnTime
from sunder_tools.launch.run import _verdict
from sunder_tools.launch.watch import Ending, watch

from . import REPOSITORY
from .fakes import write_executables

# The main thread has ended, another one lives on: as a killed process is while a thread of it waits for a processor.
DIES_SLOWLY = """
import ctypes, os, signal, threading, time
def last():
    time.sleep(4.0)
    os.kill(os.getpid(), signal.SIGKILL)
threading.Thread(target=last).start()
ctypes.CDLL(None).pthread_exit(None)  # the lock of the interpreter is released around it
"""
STUCK_S = 1800.0  # after which a process hangs, whatever else the machine does


class RunCommand(unittest.TestCase):
    pictures = False  # whether runs draw them: only where a test is about them, for they take longest

    def setUp(self) -> None:
        self._temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self._temporary.cleanup)
        self.here = Path(self._temporary.name)
        for name in ("tmp", "pids", "work"):
            (self.here / name).mkdir()
        write_executables(self.here / "build")
        self.folder = self.here / "work"  # in which the command is given
        self.scene = self.folder / "pane.textproto"
        self.scene.write_text("name: 'pane'\n")

    def start(self, *arguments: str, **environment: str) -> subprocess.Popen[str]:
        if arguments[0] == "run" and not self.pictures:
            arguments = (*arguments, "--no-pictures")
        process = subprocess.Popen(
            [REPOSITORY / "coupler" / "sunder", *arguments], cwd=self.folder, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
            env={**os.environ, "SUNDER_BUILD_DIR": str(self.here / "build"), "TMPDIR": str(self.here / "tmp"),
                 "FAKE_PIDS": str(self.here / "pids"), **environment})
        self.addCleanup(self._end, process)
        return process

    @staticmethod
    def _end(process: subprocess.Popen[str]) -> None:
        if process.poll() is None:
            process.kill()
        process.communicate()

    def run_to_end(self, *arguments: str, **environment: str) -> tuple[int, str, str]:
        process = self.start(*arguments, **environment)
        out, err = process.communicate(timeout=STUCK_S)
        return process.returncode, out, err

    def wait_for_frames(self, folder: Path, count: int = 3) -> None:
        end = time.monotonic() + STUCK_S
        while len(list(folder.glob("frames/bodies_*.vtp"))) < count:
            self.assertLess(time.monotonic(), end, "no frames came")
            time.sleep(0.01)

    def wait_for_end(self, pid: int, limit_s: float, launcher: subprocess.Popen[str]) -> None:
        """Fails where a process takes longer than `limit_s` to end, in its own time and the launcher's together."""
        had = OwnTime(pid, launcher.pid)
        while Path(f"/proc/{pid}").exists():
            self.assertLess(had.look(), limit_s, f"process {pid} still runs")
            time.sleep(0.01)

    def pid(self, name: str) -> int:
        return int((self.here / "pids" / f"{name}.pid").read_text())

    def assert_nothing_left(self) -> None:
        self.assertEqual(list((self.here / "tmp").iterdir()), [], "socket folder is still there")
        for name in ("shell", "rigid"):
            with self.assertRaises(ProcessLookupError):
                os.kill(self.pid(name), 0)

    def test_done(self) -> None:
        self.pictures = True
        status, out, err = self.run_to_end("run", str(self.scene))
        self.assertEqual(status, 0, err)
        folder, = (self.here / "work" / "runs").iterdir()
        self.assertRegex(folder.name, r"^pane-\d{8}-\d{6}$")
        self.assertIn("contact_sheet.png", out)
        self.assertIn("handed to the engine 31", out)
        self.assertIn("frame 2", err)
        self.assertIn("frame 2\n", (folder / "shell.log").read_text())
        self.assertIn("peer is here", (folder / "rigid.log").read_text())
        self.assertTrue((folder / "contact_sheet.png").is_file())
        self.assert_nothing_left()

    def test_pictures_are_left_out_when_asked(self) -> None:
        status, out, err = self.run_to_end("run", str(self.scene), "--out", str(self.here / "out"))
        self.assertEqual(status, 0, err)
        self.assertNotIn("contact_sheet.png", out)
        self.assertFalse((self.here / "out" / "contact_sheet.png").exists())
        self.assertEqual(self.run_to_end("render", str(self.here / "out"), "--sheet")[0], 0)
        self.assertTrue((self.here / "out" / "contact_sheet.png").is_file())

    def test_refused_scene_leaves_nothing(self) -> None:
        self.scene.write_text("wrong: 1\n")
        status, _, err = self.run_to_end("run", str(self.scene))
        self.assertEqual(status, 2)
        self.assertIn("pane.textproto:1:1: wrong: unknown field; remove it", err)
        self.assertEqual([p.name for p in (self.here / "work").iterdir()], ["pane.textproto"])
        self.assertEqual(list((self.here / "pids").iterdir()), [], "something was launched")

    def test_killed_peer_ends_the_other(self) -> None:
        self.pictures = True
        for victim, other in (("rigid", "shell"), ("shell", "rigid")):
            with self.subTest(victim=victim):
                out = self.here / victim
                process = self.start("run", str(self.scene), "--out", str(out), "--quiet", FAKE_FRAMES="400")
                self.wait_for_frames(out)
                (out / "checkpoint").mkdir()
                (out / "checkpoint" / "state").touch()
                os.kill(self.pid(victim), signal.SIGKILL)
                self.wait_for_end(self.pid(other), 2.0, process)
                _, err = process.communicate(timeout=STUCK_S)
                self.assertEqual(process.returncode, 3)
                self.assertIn(f"(sunder-{victim}) was killed by SIGKILL", err)
                self.assertIn(f"{victim}.log", err)
                run = json.loads((out / "run.json").read_text())
                self.assertEqual(run["status"], "failed")
                self.assertIn(f"sunder run --resume {out}", err)
                if victim == "shell":
                    self.assertIn(f"sunder run --resume {out}", run["error"]["message"])
                    self.assertEqual(run["error"]["kind"], "peer_lost")
                    self.assertEqual(run["engine"]["name"], "fake", "what was there is kept")
                self.assertTrue((out / "contact_sheet.png").exists())
                self.assert_nothing_left()
                self.assertEqual(self.run_to_end("run", str(self.scene), "--out", str(out))[0], 0)

    def test_deaf_peer_is_stopped(self) -> None:
        for victim, deaf in (("rigid", "SHELL"), ("shell", "RIGID")):
            with self.subTest(victim=victim):
                out = self.here / victim
                process = self.start("run", str(self.scene), "--out", str(out), FAKE_FRAMES="400",
                                     **{"FAKE_" + deaf: "deaf"})
                self.wait_for_frames(out)
                os.kill(self.pid(victim), signal.SIGKILL)
                self.wait_for_end(self.pid(deaf.lower()), 3.5, process)  # 2 s grace, 0.5 s after SIGTERM, slack
                _, err = process.communicate(timeout=STUCK_S)
                self.assertEqual(process.returncode, 3)
                self.assertIn(f"(sunder-{victim}) was killed by SIGKILL", err)
                self.assertEqual(json.loads((out / "run.json").read_text())["error"]["kind"], "peer_lost")
                self.assert_nothing_left()

    def test_interrupt_writes_pictures(self) -> None:
        self.pictures = True
        for number in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(number=number):
                out = self.here / number.name
                process = self.start("run", str(self.scene), "--out", str(out), FAKE_FRAMES="400")
                self.wait_for_frames(out)
                os.kill(process.pid, number)
                text, err = process.communicate(timeout=STUCK_S)
                self.assertEqual(process.returncode, 130, err)
                self.assertIn("interrupted", text)
                self.assertTrue((out / "contact_sheet.png").exists())
                self.assertEqual(json.loads((out / "run.json").read_text())["status"], "interrupted")
                self.assert_nothing_left()

    def test_second_interrupt_kills(self) -> None:
        out = self.here / "out"
        process = self.start("run", str(self.scene), "--out", str(out), FAKE_FRAMES="400", FAKE_SHELL="deaf")
        self.wait_for_frames(out)
        os.kill(process.pid, signal.SIGINT)
        time.sleep(0.3)
        self.assertIsNone(process.poll())
        os.kill(process.pid, signal.SIGINT)
        process.communicate(timeout=STUCK_S)
        self.assertEqual(process.returncode, 130)
        self.assertEqual(json.loads((out / "run.json").read_text())["status"], "interrupted")
        self.assert_nothing_left()

    def test_two_at_once_get_their_own_folders(self) -> None:
        processes = [self.start("run", str(self.scene), "--quiet") for _ in range(2)]
        for process in processes:
            process.communicate(timeout=STUCK_S)
            self.assertEqual(process.returncode, 0)
        self.assertEqual(len(list((self.here / "work" / "runs").glob("pane-*/run.json"))), 2)

    def test_out_is_not_shared_while_in_use(self) -> None:
        out = self.here / "out"
        first = self.start("run", str(self.scene), "--out", str(out), FAKE_FRAMES="400")
        self.wait_for_frames(out)
        status, _, err = self.run_to_end("run", str(self.scene), "--out", str(out))
        self.assertEqual(status, 2)
        self.assertIn("another run is writing there", err)
        self.assertIsNone(first.poll())
        first.send_signal(signal.SIGINT)  # and waited for, or it writes into a folder that is being removed
        first.communicate(timeout=STUCK_S)

    def test_foreign_folder_is_refused_and_own_is_replaced(self) -> None:
        out = self.here / "out"
        out.mkdir()
        (out / "thesis.tex").write_text("years of work")
        status, _, err = self.run_to_end("run", str(self.scene), "--out", str(out))
        self.assertEqual(status, 2)
        self.assertIn("holds other files", err)
        (out / "run.json").write_text('{"my": "other project"}')
        self.assertEqual(self.run_to_end("run", str(self.scene), "--out", str(out))[0], 2)
        (out / "run.json").write_text('{"schema": 1}')
        (out / "frames").mkdir()
        (out / "frames" / "holiday.jpg").write_text("sun")
        (out / "frames" / "old.vtp").write_text("old")
        self.scene.write_text("wrong: 1\n")
        self.assertEqual(self.run_to_end("run", str(self.scene), "--out", str(out))[0], 2)
        self.assertTrue((out / "frames" / "old.vtp").exists(), "a refused scene must not cost the old run")
        self.scene.write_text("")
        self.assertEqual(self.run_to_end("run", str(self.scene), "--out", str(out), "--rigid", "bulet")[0], 2)
        self.assertTrue((out / "frames" / "old.vtp").exists(), "nor must an unknown engine")
        self.assertEqual(self.run_to_end("run", str(self.scene), "--out", str(out))[0], 0)
        self.assertFalse((out / "frames" / "old.vtp").exists())
        self.assertTrue((out / "thesis.tex").exists())
        self.assertTrue((out / "frames" / "holiday.jpg").exists())

    def test_engine_that_refuses(self) -> None:
        status, _, err = self.run_to_end("run", str(self.scene), "--rigid", "nonesuch", FAKE_RIGID="refuse")
        self.assertEqual(status, 2)
        self.assertIn("--engine nonesuch: no such engine", err)
        self.assertFalse((self.here / "work" / "runs").exists())

    def test_engine_as_a_path(self) -> None:
        engine = self.here / "mine"
        engine.write_text((self.here / "build" / "rigid" / "sunder-rigid").read_text())
        engine.chmod(0o755)
        (self.here / "build" / "rigid" / "sunder-rigid").write_text("#!/bin/sh\nexit 9\n")
        self.assertEqual(self.run_to_end("run", str(self.scene), "--rigid", str(engine))[0], 0)
        status, _, err = self.run_to_end("run", str(self.scene), "--rigid", str(self.scene))
        self.assertEqual(status, 2)
        self.assertIn(f"--rigid {self.scene}: is not an executable file; to make it one: chmod +x {self.scene}", err)
        self.scene.chmod(0o755)  # the remedy: it is launched then
        self.assertNotIn("not an executable", self.run_to_end("run", str(self.scene), "--rigid", str(self.scene))[2])
        status, _, err = self.run_to_end("run", str(self.scene), "--rigid", "./nothing")
        self.assertEqual(status, 2)
        self.assertIn("--rigid ./nothing: there is no such file; give the path of a program", err)
        self.assertIn("--rigid .//: is a folder; give", self.run_to_end("run", str(self.scene), "--rigid", ".//")[2])

    def test_a_name_that_is_a_file_here_is_meant_as_a_path(self) -> None:
        for name, words in (("bulet", "did you mean 'bullet'?"), ("bulet", "did you mean ./bulet, the file here?")):
            status, _, err = self.run_to_end("run", str(self.scene), "--rigid", name)
            self.assertEqual(status, 2)
            self.assertIn(f"--rigid bulet: {words}", err)
            (self.here / "work" / "bulet").write_text((self.here / "build" / "rigid" / "sunder-rigid").read_text())
            (self.here / "work" / "bulet").chmod(0o755)
        self.assertEqual(self.run_to_end("run", str(self.scene), "--rigid", "./bulet")[0], 0)  # the remedy

    def test_no_engine_is_listed_twice(self) -> None:
        dart = self.here / "build" / "rigid" / "sunder-rigid-dart"
        dart.write_text("#!/bin/sh\n")
        dart.chmod(0o755)
        (self.here / "build" / "rigid" / "sunder-rigid").write_text(
            "#!/bin/sh\n[ $1 = --list ] && echo bullet ode && exit 0\nexit 2\n")
        err = self.run_to_end("run", str(self.scene), "--rigid", "qqqqq")[2]
        self.assertIn("there are bullet, ode, ", err)
        self.assertEqual(err.count("dart"), 1, err)

    def test_the_last_words_of_an_engine_that_cannot_start_are_shown(self) -> None:
        engine = self.here / "mine"
        engine.write_text("#!/usr/bin/python3\nimport no_such_module\n")
        engine.chmod(0o755)
        status, _, err = self.run_to_end("run", str(self.scene), "--rigid", str(engine), FAKE_SHELL="deaf")
        self.assertEqual(status, 3)
        self.assertIn("(mine) ended with status 1 and said last: ModuleNotFoundError: No module named 'no_such_module'", err)

    def checkpointed(self, *arguments: str) -> Path:
        """The folder of a run that can go on; its engine is ./mine beside the scene."""
        engine = self.here / "work" / "mine"
        engine.write_text((self.here / "build" / "rigid" / "sunder-rigid").read_text())
        engine.chmod(0o755)
        out = self.here / "out"
        status, _, err = self.run_to_end("run", str(self.scene), "--out", str(out), "--rigid", "./mine", *arguments)
        self.assertEqual(status, 0, err)
        (out / "checkpoint").mkdir()
        (out / "checkpoint" / "state").touch()
        return out

    def test_a_run_goes_on_with_its_own_engine(self) -> None:
        out = self.checkpointed()
        status, _, err = self.run_to_end("run", "--resume", str(out), "--rigid", "nosuchengine")
        self.assertEqual(status, 2)
        self.assertIn("continues with the scene, settings and engine of that run; leave --rigid out", err)
        self.assertEqual(self.run_to_end("run", "--resume", str(out))[0], 0)  # the remedy

    def test_a_run_goes_on_from_another_folder(self) -> None:
        out = self.checkpointed()
        engine = self.here / "work" / "mine"
        self.assertEqual(json.loads((out / "command.json").read_text())["engine"], str(engine))
        self.folder = self.here
        self.assertEqual(self.run_to_end("run", "--resume", str(out))[0], 0)
        moved = self.here / "mine"
        engine.rename(moved)
        status, _, err = self.run_to_end("run", "--resume", str(out))
        self.assertEqual(status, 2)
        self.assertIn(f"--resume {out}: {engine}: there is no such file. That run was made with it; put it back there, or write "
                      f'its new path as "engine" into {out / "command.json"}', err)
        kept = json.loads((out / "command.json").read_text())
        (out / "command.json").write_text(json.dumps({**kept, "engine": str(moved)}))  # a remedy
        self.assertEqual(self.run_to_end("run", "--resume", str(out))[0], 0)
        (out / "command.json").write_text(json.dumps(kept))
        moved.rename(engine)  # the other
        self.assertEqual(self.run_to_end("run", "--resume", str(out))[0], 0)

    def test_a_run_without_pictures_goes_on_without_them(self) -> None:
        self.pictures = True  # not asked for again
        out = self.checkpointed("--no-pictures")
        self.assertEqual(self.run_to_end("run", "--resume", str(out))[0], 0)
        self.assertFalse((out / "contact_sheet.png").exists())

    def test_a_program_of_the_user_has_its_own_name(self) -> None:
        """However it ends: no message calls it by the name of the program that comes with the project."""
        engine = self.here / "my-engine"
        engine.write_text((self.here / "build" / "rigid" / "sunder-rigid").read_text())
        engine.chmod(0o755)
        for told, words in (("refuse", "(my-engine) refused to start"), ("deaf", "(my-engine) did not end after goodbye")):
            _, _, err = self.run_to_end("run", str(self.scene), "--rigid", str(engine), FAKE_RIGID=told)
            self.assertIn(words, err)
            self.assertNotIn("sunder-rigid", err)
        for ending in (Ending(shell=3, rigid=5), Ending(shell=3), Ending(rigid=5), Ending(rigid_was_signalled=True),
                       Ending(shell=3, rigid=2), Ending(shell_was_signalled=True)):
            message = _verdict(ending, Path("run"), "my-engine")[1]
            self.assertIn("(my-engine)", message)
            self.assertNotIn("sunder-rigid", message)
        going = self.here / "going"
        going.mkdir()
        (going / "run.json").write_text('{"time": {"windows": 3}}')
        self.assertIn("(my-engine) refused to go on after 3 windows", _verdict(Ending(shell=3, rigid=2), going, "my-engine")[1])

    def test_the_last_words_of_an_engine_are_left_out_where_the_shell_has_told_them(self) -> None:
        out = self.here / "out"
        out.mkdir()
        (out / "rigid.log").write_text("starting\nmine: engine_failed: a number is not finite\n")
        for error, said in (('{"kind": "engine_failed"}', False), ('{"kind": "peer_lost"}', True), ("null", True)):
            (out / "run.json").write_text('{"schema": 1, "error": ' + error + "}")
            message = _verdict(Ending(shell=3, rigid=4), out, "mine")[1]
            self.assertEqual("and said last: mine: engine_failed: a number is not finite" in message, said, message)

    def test_a_folder_in_which_a_run_has_just_begun(self) -> None:
        out = self.here / "work" / "out"
        out.mkdir()
        (out / "command.json").write_text("{}")  # there is no run.json yet
        held = os.open(out, os.O_RDONLY)
        self.addCleanup(os.close, held)
        fcntl.flock(held, fcntl.LOCK_EX)
        status, _, err = self.run_to_end("run", str(self.scene), "--out", str(out))
        self.assertEqual((status, err), (2, f"sunder: {out}: another run is writing there; choose another --out\n"))
        fcntl.flock(held, fcntl.LOCK_UN)
        self.assertIn("holds other files and no run.json", self.run_to_end("run", str(self.scene), "--out", str(out))[2])

    def test_a_folder_that_another_run_removes_meanwhile(self) -> None:
        out = self.here / "out"
        real = os.open
        removed: list[Path] = []

        def vanishing(path: Path, flags: int) -> int:
            handle = real(path, flags)
            if not removed:
                removed.append(path)
                out.rmdir()
            return handle

        with mock.patch.object(folder.os, "open", vanishing):
            taken = folder.open_folder(out, self.scene)
        self.addCleanup(taken.close)
        self.assertEqual(removed, [out])
        self.assertTrue(out.is_dir())
        with self.assertRaisesRegex(errors.CommandError, "another run is writing there"):
            folder.open_folder(out, self.scene)

    @unittest.skipUnless(Path("/proc/sys").is_dir(), "needs a folder that even root cannot write to")
    def test_unwritable_out(self) -> None:
        status, _, err = self.run_to_end("run", str(self.scene), "--out", "/proc/sys/run")
        self.assertEqual(status, 2)
        self.assertIn("cannot write the run folder", err)

    def test_command_line_errors(self) -> None:
        for arguments, words in ((["rnu"], "did you mean 'run'"), (["run"], "SCENE"),
                                 (["run", "no.textproto"], "no such scene"),
                                 (["run", str(self.scene), "--set", "x"], "PATH=VALUE"),
                                 (["run", str(self.scene), "--until", "nan"], "positive"),
                                 (["run", str(self.scene), "--threads", "0"], "at least 1")):
            with self.subTest(arguments=arguments):
                status, _, err = self.run_to_end(*arguments)
                self.assertEqual(status, 2)
                self.assertIn(words, err)
        for arguments in (["--help"], ["run", "--help"], ["check", "--help"], ["test", "--help"]):
            self.assertEqual(self.run_to_end(*arguments)[0], 0)

    def test_check(self) -> None:
        status, out, _ = self.run_to_end("check", str(self.scene))
        self.assertEqual((status, out), (0, "report\n"))
        self.scene.write_text("wrong: 1\n")
        self.assertEqual(self.run_to_end("check", str(self.scene))[0], 2)


class Verdict(unittest.TestCase):
    """Which process is named where both have ended before the launcher looked."""

    def test_a_killed_shell_is_the_shells_failure(self) -> None:
        for first in (False, True):  # the rigid process, which noticed, ended before the launcher saw either
            ending = Ending(shell=-signal.SIGKILL, rigid=3, rigid_first=first)
            status, message = _verdict(ending, Path("run"), "sunder-rigid")
            self.assertEqual(status, 3)
            self.assertIn("(sunder-shell) was killed by SIGKILL", message)

    def test_a_killed_rigid_process_is_its_own_failure(self) -> None:
        for shell in (3, -signal.SIGTERM):
            status, message = _verdict(Ending(shell=shell, rigid=-signal.SIGKILL, rigid_first=True), Path("run"), "my-engine")
            self.assertEqual(status, 3)
            self.assertIn("(my-engine) was killed by SIGKILL", message)


    def test_a_shell_that_dies_slowly_is_the_first_to_die(self) -> None:
        """Its connections are closed and the rigid process has ended, but other threads keep it from being reaped."""
        dying = subprocess.Popen(["/usr/bin/python3", "-c", DIES_SLOWLY])
        self.addCleanup(dying.kill)
        while Path(f"/proc/{dying.pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z":
            time.sleep(0.01)
        rigid = subprocess.Popen(["/bin/sh", "-c", "exit 1"])  # an engine of one's own, with a status of its own
        ending = watch(dying, rigid, [])
        self.assertEqual((ending.shell, ending.rigid), (-signal.SIGKILL, 1))
        status, message = _verdict(ending, Path("run"), "my-engine")
        self.assertEqual(status, 3)
        self.assertIn("(sunder-shell) was killed by SIGKILL", message)
        self.assertNotIn("my-engine", message)


    def test_a_process_that_is_stopped_is_not_ended(self) -> None:
        shell = subprocess.Popen(["/bin/sh", "-c", "kill -STOP $$; exit 3"])
        self.addCleanup(shell.kill)
        while not Path(f"/proc/{shell.pid}/stat").read_text().rpartition(")")[2].split()[0] in "Tt":
            time.sleep(0.01)
        rigid = subprocess.Popen(["/bin/sh", "-c", "kill -KILL $$"])
        threading.Timer(3.5, shell.send_signal, [signal.SIGCONT]).start()  # it would have been ended after 2.5 s
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            ending = watch(shell, rigid, [])
        self.assertEqual((ending.shell, ending.rigid, ending.shell_was_signalled), (3, -signal.SIGKILL, False))
        self.assertIn(f"kill -CONT {shell.pid}", said.getvalue())


class Own(unittest.TestCase):
    """Time of a process's own."""

    def test_sleep_and_work_count_and_waiting_for_a_processor_does_not(self) -> None:
        cpu = min(os.sched_getaffinity(0))
        sleeper = subprocess.Popen(["sleep", "60"])
        workers = [subprocess.Popen(["/usr/bin/python3", "-c", f"import os\nos.sched_setaffinity(0, {{{cpu}}})\nwhile 1: pass"])
                   for _ in range(4)]
        try:
            time.sleep(0.5)
            asleep, busy = OwnTime(sleeper.pid), OwnTime(workers[0].pid)
            start = time.monotonic()
            while time.monotonic() - start < 2.0:
                asleep.look(), busy.look()
                time.sleep(0.02)
            self.assertGreater(asleep.look(), 0.3)
            self.assertLess(busy.look(), 1.2, "four share a processor: each has half a second of two")
        finally:
            for process in (sleeper, *workers):
                process.kill()
                process.wait()


if __name__ == "__main__":
    unittest.main()
