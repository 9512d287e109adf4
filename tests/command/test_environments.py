"""Real runs in unusual environments: other users, paths and languages, and read-only folders.

A test that needs root, or a right that a container lacks, is skipped with the reason.
"""
from __future__ import annotations

import errno
import json
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

from sunder_tools import places
from sunder_tools.errors import CommandError
from sunder_tools.launch.socket_dir import SocketDir

from . import REPOSITORY

BUILD = Path(os.environ.get("SUNDER_BUILD_DIR") or REPOSITORY / "build" / "release").absolute()
SCENE = REPOSITORY / "scenes" / "cut_pane.textproto"
UNTIL_S = "0.0005"
STUCK_S = 1800.0  # after which a process hangs, whatever else the machine does
NOBODY = 65534
LANGUAGE = "de_DE.UTF-8"


class Environments(unittest.TestCase):
    def setUp(self) -> None:
        # not below TMPDIR or /tmp, which the tests change
        self.here = Path(tempfile.mkdtemp(prefix="sunder-environments-", dir="/var/tmp"))
        self.addCleanup(shutil.rmtree, self.here, ignore_errors=True)
        self.here.chmod(0o755)
        self.environment = {**os.environ, "SUNDER_BUILD_DIR": str(BUILD)}

    def run_scene(self, checkout: Path = REPOSITORY, before: tuple[str, ...] = (), user: int | None = None,
                  out: str = "out") -> None:
        """Runs a scene in this environment. It has to end well and leave run.json and the contact sheet."""
        work = self.here / "work"
        work.mkdir(exist_ok=True)
        if user is not None:
            os.chown(work, user, user)
        ids: dict[str, Any] = {} if user is None else {"user": user, "group": user, "extra_groups": []}
        done = subprocess.run([*before, str(checkout / "coupler" / "sunder"), "run",
                               str(checkout / "scenes" / SCENE.name), "--until", UNTIL_S, "--out", out], cwd=work,
                              env=self.environment, capture_output=True, timeout=STUCK_S, check=False, **ids)
        said = done.stderr.decode(errors="replace")
        self.assertEqual(done.returncode, 0, said)
        self.assertEqual(json.loads((work / out / "run.json").read_text(encoding="utf-8"))["status"], "done")
        self.assertTrue((work / out / "contact_sheet.png").is_file(), said)

    def mounted(self, script: str) -> tuple[str, ...]:
        """Prefix of a command that gives it mounts of its own, made by a line of shell. Skips where that is not allowed."""
        prefix = ("unshare", "--mount", "sh", "-c", f'{script} && exec "$@"', "sh")
        tried = subprocess.run([*prefix, "true"], capture_output=True, text=True, check=False) \
            if os.geteuid() == 0 and shutil.which("unshare") else None
        if tried is None or tried.returncode != 0:
            self.skipTest(f"mounts of one's own: {tried.stderr.strip() if tried else 'need root and unshare'}")
        return prefix

    def test_a_path_with_a_space_and_an_umlaut(self) -> None:
        checkout = self.here / "Prüfstand zwei" / "sunder"
        checkout.mkdir(parents=True)
        for room in ("coupler", "scenes", "proto"):
            shutil.copytree(REPOSITORY / room, checkout / room)
        shutil.copy(REPOSITORY / "CMakeLists.txt", checkout)
        temporary = self.here / "Ablage für alles"
        temporary.mkdir()
        self.environment["TMPDIR"] = str(temporary)
        self.run_scene(checkout, out="Läufe/der erste")

    def speak_german(self) -> None:
        """Makes a language with a decimal comma, and gives it to the runs. Skips where its sources are missing."""
        if shutil.which("localedef") is None:
            self.skipTest("a decimal comma: localedef is not installed")
        made = subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", str(self.here / "languages" / LANGUAGE)],
                              capture_output=True, text=True, check=False)
        self.environment["LOCPATH"] = str(self.here / "languages")
        for name in ("LC_ALL", "LC_NUMERIC", "LANG"):
            self.environment[name] = LANGUAGE
        point = subprocess.run(["locale", "decimal_point"], env=self.environment, capture_output=True, text=True, check=False)
        if point.stdout.strip() != ",":
            self.skipTest(f"a decimal comma: localedef made no {LANGUAGE}: {made.stderr.strip()} (Debian: locales)")

    def test_another_language(self) -> None:
        (self.here / "languages").mkdir()
        self.speak_german()
        self.run_scene()

    def test_no_language_and_no_home(self) -> None:
        self.environment.pop("HOME", None)
        self.environment["LC_ALL"] = "C"
        self.run_scene(out="C")

    def test_a_temporary_folder_with_a_long_path(self) -> None:
        long = self.here / "t"
        while len(str(long)) < 200:
            long = long / "a_long_name_of_a_folder"
        long.mkdir(parents=True)
        self.environment["TMPDIR"] = str(long)
        self.run_scene()

    def test_tmp_is_read_only(self) -> None:
        self.environment["TMPDIR"] = str(self.here)
        self.run_scene(before=self.mounted("mount --bind /tmp /tmp && mount -o remount,bind,ro /tmp && ! touch /tmp/x 2>&-"))

    def test_a_long_temporary_folder_and_nothing_else(self) -> None:
        """What is left is the folder where the command is run, whose own path may be long, too."""
        long = self.here
        while len(str(long)) < 200:
            long = long / "a_long_name_of_a_folder"
        long.mkdir(parents=True)
        self.environment["TMPDIR"] = str(long)
        self.environment.pop("XDG_RUNTIME_DIR", None)
        bound = self.mounted("".join(f"mount --bind {place} {place} && mount -o remount,bind,ro {place} && "
                                     for place in ("/tmp", "/dev/shm")) + "! touch /tmp/x 2>&- && ! touch /dev/shm/x 2>&-")
        self.run_scene(before=bound)  # in /var/tmp
        work = self.here
        self.here = long
        self.run_scene(before=(*bound, "sh", "-c", f"mount --bind {work} /mnt && mount --bind /var/tmp /var/tmp && "
                               f"mount -o remount,bind,ro /var/tmp && cd /mnt{str(long)[len(str(work)):]}/work && exec \"$@\"", "sh"))

    def test_the_checkout_is_read_only(self) -> None:
        here = str(REPOSITORY)
        self.run_scene(before=self.mounted(f"mount --bind '{here}' '{here}' && mount -o remount,bind,ro '{here}'"))

    def test_another_user_than_root(self) -> None:
        if os.geteuid() != 0:
            self.skipTest("the tests do not run as root: every other test here covers this case")
        seen = subprocess.run(["test", "-x", str(BUILD / "shell" / "sunder-shell")], user=NOBODY, group=NOBODY,
                              extra_groups=[], check=False)
        if seen.returncode != 0:
            self.skipTest(f"{BUILD} is in a folder that only root may enter")
        self.environment.pop("HOME", None)
        self.run_scene(user=NOBODY)


    def test_another_user_of_a_finished_checkout(self) -> None:
        """The checkout is built, belongs to root and is not named by SUNDER_BUILD_DIR."""
        if os.geteuid() != 0:
            self.skipTest("needs root, who may make files of root's")
        checkout = self.here / "checkout"
        for room in ("coupler", "scenes", "proto"):
            shutil.copytree(REPOSITORY / room, checkout / room)
        for program in ("shell/sunder-shell", "rigid/sunder-rigid"):
            target = checkout / "build" / "release" / program
            target.parent.mkdir(parents=True)
            shutil.copy(BUILD / program, target)
        (checkout / "build" / "lock").touch()
        del self.environment["SUNDER_BUILD_DIR"]
        self.environment.pop("HOME", None)
        self.run_scene(checkout, user=NOBODY)


class Place(unittest.TestCase):
    def test_a_checkout_may_lie_right_below_the_root(self) -> None:
        self.assertEqual(places._programs(Path("/sunder")), Path("/libexec/sunder"))
        self.assertEqual(places._programs(Path("/usr/share/sunder")), Path("/usr/libexec/sunder"))


class Socket(unittest.TestCase):
    def test_no_place_is_said_with_what_was_tried(self) -> None:
        with mock.patch.dict(os.environ, {"TMPDIR": "/" + 200 * "x", "XDG_RUNTIME_DIR": "/nowhere"}), \
                mock.patch("os.mkdir", side_effect=OSError(errno.EROFS, "Read-only file system")), \
                self.assertRaisesRegex(CommandError, "too long for a socket's name.*/tmp .Read-only file system.*set TMPDIR"):
            SocketDir()

    def test_the_present_folder_is_the_last_place(self) -> None:
        real = os.mkdir

        def elsewhere_not(path: str, mode: int = 0o777) -> None:
            if os.path.isabs(path) and not str(path).startswith(os.getcwd()):
                raise OSError(errno.EACCES, "Permission denied")
            real(path, mode)

        before = os.getcwd()
        self.addCleanup(os.chdir, before)
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            with mock.patch.dict(os.environ, {"TMPDIR": "/" + 200 * "x"}), mock.patch("os.mkdir", elsewhere_not), \
                    SocketDir() as socket:
                self.assertEqual(socket.endpoint, f"ipc://{socket.path.name}/link")
                self.assertTrue((Path(folder) / socket.path.name).is_dir())
            self.assertEqual(os.listdir(folder), [])


if __name__ == "__main__":
    unittest.main()
