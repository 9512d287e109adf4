"""Encrypted runs by the command: over a relay that records all data, and between two hosts in network namespaces."""
from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
SUNDER = REPOSITORY / "coupler" / "sunder"
BUILD = Path(os.environ.get("SUNDER_BUILD_DIR") or REPOSITORY / "build" / "release")
SCENE = REPOSITORY / "scenes" / "cut_pane.textproto"
LONGEST_S = 1800.0  # after which a process hangs, whatever else the machine does
UNTIL_S = "0.002"
STOPPED_S = 4.0  # of a process: longer than a busy machine delays anything


class Relay:
    """Relays one connection between two ports of this machine and records the data of both directions."""

    def __init__(self, to_port: int) -> None:
        self.heard = bytearray()
        self._to = to_port
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._listening.getsockname()[1])
        self._sockets = [self._listening]
        self._threads = [threading.Thread(target=self._accept, daemon=True)]
        self._threads[0].start()

    def _accept(self) -> None:
        near, _ = self._listening.accept()
        end = time.monotonic() + LONGEST_S
        while True:
            try:
                far = socket.create_connection(("127.0.0.1", self._to))
                break
            except ConnectionRefusedError:
                if time.monotonic() > end:
                    raise
                time.sleep(0.02)
        self._sockets += [near, far]
        for source, sink in ((near, far), (far, near)):
            self._threads.append(threading.Thread(target=self._pump, args=(source, sink), daemon=True))
            self._threads[-1].start()

    def _pump(self, source: socket.socket, sink: socket.socket) -> None:
        try:
            while words := source.recv(65536):
                self.heard += words
                sink.sendall(words)
            sink.shutdown(socket.SHUT_WR)
        except OSError:  # one side has closed: the other is closed too
            for end in (source, sink):
                with contextlib.suppress(OSError):
                    end.shutdown(socket.SHUT_RDWR)

    def end(self) -> bytes:
        for thread in self._threads:
            thread.join(LONGEST_S)
        for each in self._sockets:
            each.close()
        return bytes(self.heard)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        return int(listening.getsockname()[1])


class Encrypted(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.root = Path(temporary.name)
        self.environment = {**os.environ, "SUNDER_BUILD_DIR": str(BUILD)}

    def sunder(self, *arguments: object) -> subprocess.CompletedProcess[str]:
        return subprocess.run([str(SUNDER), *map(str, arguments)], capture_output=True, text=True, check=False,
                              timeout=LONGEST_S, env=self.environment)

    def start(self, *command: object) -> subprocess.Popen[str]:
        process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   env=self.environment)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def make_keys(self) -> Path:
        keys = self.root / "keys"
        made = self.sunder("keys", keys)
        self.assertEqual(made.returncode, 0, made.stderr)
        return keys

    def ended(self, process: subprocess.Popen[str]) -> None:
        said, _ = process.communicate(timeout=LONGEST_S)
        self.assertEqual(process.returncode, 0, said)

    def run_json(self, out: Path) -> dict[str, object]:
        run: dict[str, object] = json.loads((out / "run.json").read_text())
        self.assertEqual(run["status"], "done")
        return run

    def test_the_command_makes_keys_serves_and_runs_and_nobody_reads_along(self) -> None:
        keys = self.make_keys()
        again = self.sunder("keys", keys)
        self.assertEqual(again.returncode, 2, again.stderr)
        self.assertIn("no key is ever written over", again.stderr)
        hashes = set()
        ways: list[list[str | Path]] = [[], ["--keys", keys]]
        for number, options in enumerate(ways):
            port = free_port()
            served = self.start(SUNDER, "serve", "--endpoint", f"tcp://127.0.0.1:{port}", *options)
            relay, out = Relay(port), self.root / f"out{number}"
            ran = self.sunder("run", SCENE, "--rigid", f"tcp://127.0.0.1:{relay.port}", *options, "--until", UNTIL_S,
                              "--out", out, "--quiet")
            self.assertEqual(ran.returncode, 0, ran.stderr)
            self.ended(served)
            run = self.run_json(out)
            hashes.add(run["state_hash"])
            heard = relay.end()
            self.assertGreater(len(heard), 1000)
            # This text is in Hello's reply; without keys anybody can read it.
            self.assertEqual(b"double_precision" in heard, not options)
        self.assertEqual(len(hashes), 1, "encryption changed the run")

    def test_a_stopped_process_is_waited_for_over_a_network(self) -> None:
        keys, out = self.make_keys(), self.root / "out"
        out.mkdir()
        both = ["--endpoint", f"tcp://127.0.0.1:{free_port()}", "--keys", keys]
        rigid = self.start(BUILD / "rigid" / "sunder-rigid", *both)
        shell = self.start(BUILD / "shell" / "sunder-shell", "--scene", SCENE, "--out", out, "--quiet", *both)
        end = time.monotonic() + LONGEST_S
        while len(list(out.glob("frames/bodies_*.vtp"))) < 2:
            self.assertIsNone(shell.poll())
            self.assertLess(time.monotonic(), end, "no frames came")
            time.sleep(0.01)
        rigid.send_signal(signal.SIGSTOP)
        with self.assertRaises(subprocess.TimeoutExpired):
            shell.wait(STOPPED_S)
        rigid.send_signal(signal.SIGCONT)
        said, _ = shell.communicate(timeout=LONGEST_S)
        self.assertEqual(shell.returncode, 0, said)
        self.ended(rigid)

    def test_keys_are_for_an_engine_at_an_address(self) -> None:
        keys = self.make_keys()
        ran = self.sunder("run", SCENE, "--keys", keys, "--out", self.root / "out")
        self.assertEqual(ran.returncode, 2, ran.stderr)
        self.assertIn("leave it out", ran.stderr)
        self.assertFalse((self.root / "out").exists())
        far = self.sunder("serve", "--endpoint", "tcp://0.0.0.0:5555")
        self.assertEqual(far.returncode, 2)
        self.assertIn("give --keys DIR, made by 'sunder keys DIR'", far.stderr)

    def namespaces(self) -> tuple[list[str], list[str]]:
        """Returns command prefixes for two hosts with a cable between them; both vanish with the processes that hold
        them."""
        if os.geteuid() != 0:
            self.skipTest("two hosts need network namespaces, and those root")
        for tool in ("ip", "unshare", "nsenter"):
            if shutil.which(tool) is None:
                self.skipTest(f"two hosts need '{tool}': apt-get install iproute2 util-linux")
        hosts: list[list[str]] = []
        holders = [self.start("unshare", "--net", "sleep", 10 * LONGEST_S) for _ in range(2)]
        own = os.readlink("/proc/self/ns/net")
        for holder in holders:
            end = time.monotonic() + LONGEST_S
            while holder.poll() is None and os.readlink(f"/proc/{holder.pid}/ns/net") == own:
                self.assertLess(time.monotonic(), end, "unshare made no network namespace")
                time.sleep(0.01)
            if holder.poll() is not None:
                self.skipTest(f"two hosts: no network namespace here: {holder.communicate()[0].strip()}")
            hosts.append(["nsenter", f"--net=/proc/{holder.pid}/ns/net"])
        cable = ["ip", "link", "add", "cable", "type", "veth", "peer", "name", "cable", "netns", str(holders[1].pid)]
        laid = subprocess.run([*hosts[0], *cable], capture_output=True, text=True, check=False)
        if laid.returncode != 0:
            self.skipTest(f"two hosts: no veth here: {laid.stderr.strip()}")
        for number, host in enumerate(hosts, 1):
            for what in (["addr", "add", f"192.0.2.{number}/24", "dev", "cable"],
                         ["addr", "add", f"2001:db8::{number}/64", "dev", "cable", "nodad"],
                         ["link", "set", "cable", "up"], ["link", "set", "lo", "up"]):
                set_up = subprocess.run([*host, "ip", *what], capture_output=True, text=True, check=False)
                if set_up.returncode != 0 and "2001:" not in what[2]:
                    self.fail(f"ip {' '.join(what)}: {set_up.stderr}")
        return hosts[0], hosts[1]

    def across(self, hosts: tuple[list[str], list[str]], bind: str, connect: str, rigid_keys: list[object],
               shell_keys: list[object], out: Path) -> tuple[subprocess.Popen[str], subprocess.CompletedProcess[str]]:
        served = self.start(*hosts[0], BUILD / "rigid" / "sunder-rigid", "--endpoint", bind, *rigid_keys)
        out.mkdir()
        ran = subprocess.run([*hosts[1], str(BUILD / "shell" / "sunder-shell"), "--scene", str(SCENE), "--out", str(out),
                              "--until", UNTIL_S, "--quiet", "--endpoint", connect, *map(str, shell_keys)],
                             capture_output=True, text=True, check=False, timeout=LONGEST_S)
        return served, ran

    def test_two_hosts(self) -> None:
        hosts = self.namespaces()
        keys = self.make_keys()
        theirs, ours = self.root / "rigid_host", self.root / "shell_host"  # each host lacks the other's secret key
        for folder, other in ((theirs, "shell.key"), (ours, "rigid.key")):
            shutil.copytree(keys, folder)
            (folder / other).unlink()
        hashes = set()
        for number, (bind, connect) in enumerate((("tcp://0.0.0.0:5555", "tcp://192.0.2.1:5555"),
                                                  ("tcp://[::]:5555", "tcp://[2001:db8::1]:5555"))):
            with self.subTest(bind=bind):
                if number == 1 and "2001:db8::2" not in subprocess.run(
                        [*hosts[1], "ip", "-6", "address"], capture_output=True, text=True, check=False).stdout:
                    self.skipTest("two hosts: no IPv6 here")
                out = self.root / f"out{number}"
                served, ran = self.across(hosts, bind, connect, ["--keys", theirs], ["--keys", ours], out)
                self.assertEqual(ran.returncode, 0, ran.stderr)
                self.ended(served)
                hashes.add(self.run_json(out)["state_hash"])
        self.assertEqual(len(hashes), 1, "one scene ended in two states")

    def test_a_cable_that_is_out_for_some_seconds_ends_nothing(self) -> None:
        hosts = self.namespaces()
        shell, rigid = self.run_until_frames(hosts, UNTIL_S)
        subprocess.run([*hosts[0], "ip", "link", "set", "cable", "down"], check=True)
        time.sleep(STOPPED_S)
        self.assertEqual((shell.poll(), rigid.poll()), (None, None), "both wait")
        subprocess.run([*hosts[0], "ip", "link", "set", "cable", "up"], check=True)
        for process in (shell, rigid):
            said, _ = process.communicate(timeout=LONGEST_S)
            self.assertEqual(process.returncode, 0, said)

    def test_a_cable_that_is_cut_is_noticed_on_both_hosts(self) -> None:
        hosts = self.namespaces()
        shell, rigid = self.run_until_frames(hosts)
        subprocess.run([*hosts[0], "ip", "link", "set", "cable", "down"], check=True)
        for process in (shell, rigid):  # no connection closes: only what is not acknowledged can tell
            said, _ = process.communicate(timeout=LONGEST_S)
            self.assertEqual(process.returncode, 3, said)
            self.assertIn("peer_lost", said)
            self.assertIn("has acknowledged nothing for", said)

    def run_until_frames(self, hosts: tuple[list[str], list[str]], until: str = "",
                         ) -> tuple[subprocess.Popen[str], subprocess.Popen[str]]:
        """Starts a run over two hosts; returns the shell process and the rigid process once there are frames."""
        keys, out = self.make_keys(), self.root / "out"
        out.mkdir()
        rigid = self.start(*hosts[0], BUILD / "rigid" / "sunder-rigid", "--endpoint", "tcp://0.0.0.0:5555", "--keys", keys)
        shell = self.start(*hosts[1], BUILD / "shell" / "sunder-shell", "--scene", SCENE, "--out", out, "--quiet",
                           "--endpoint", "tcp://192.0.2.1:5555", "--keys", keys, *(["--until", until] if until else []))
        end = time.monotonic() + LONGEST_S
        while len(list(out.glob("frames/bodies_*.vtp"))) < 2:
            self.assertIsNone(shell.poll())
            self.assertLess(time.monotonic(), end, "no frames came")
            time.sleep(0.01)
        return shell, rigid

    def test_a_host_with_other_keys_is_turned_away(self) -> None:
        hosts = self.namespaces()
        keys, others = self.make_keys(), self.root / "others"
        self.assertEqual(self.sunder("keys", others).returncode, 0)
        shutil.copy(keys / "rigid.pub", others / "rigid.pub")
        served, ran = self.across(hosts, "tcp://0.0.0.0:5555", "tcp://192.0.2.1:5555", ["--keys", keys],
                                  ["--keys", others], self.root / "out")
        self.assertEqual(ran.returncode, 3, ran.stderr)
        self.assertIn("not_admitted", ran.stderr + (self.root / "out" / "run.json").read_text())
        self.assertIsNone(served.poll(), "a stranger ended the rigid process")


if __name__ == "__main__":
    unittest.main()
