"""Packages for Node.js, from a registry on this machine: what is checked, and what is left behind when it fails."""
from __future__ import annotations

import base64
import contextlib
import hashlib
import http.server
import io
import json
import os
import shutil
import subprocess
import tarfile
import tempfile
import threading
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

from sunder_tools.errors import CommandError
from sunder_tools import places
from sunder_tools.launch import engines, node
from sunder_tools.launch.build import Executables

from . import REPOSITORY


def archive(files: dict[str, bytes], link: str = "") -> bytes:
    out = io.BytesIO()
    with tarfile.open(fileobj=out, mode="w:gz") as tar:
        for name, content in files.items():
            member = tarfile.TarInfo(name)
            member.size = len(content)
            tar.addfile(member, io.BytesIO(content))
        if link:
            member = tarfile.TarInfo("package/link")
            member.type, member.linkname = tarfile.SYMTYPE, link
            tar.addfile(member)
    return out.getvalue()


class Packages(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.root = Path(temporary.name)
        self.sources, self.folder = self.root / "jolt", self.root / "build" / "node"
        self.sources.mkdir()
        self.served: dict[str, bytes] = {}
        self.asked: list[str] = []
        outer = self

        class Registry(http.server.BaseHTTPRequestHandler):
            def do_GET(self) -> None:  # noqa: N802: the base class's name
                outer.asked.append(self.path)
                content = outer.served.get(self.path)
                self.send_response(404 if content is None else 200)
                self.end_headers()
                self.wfile.write(content or b"")

            def log_message(self, *_: object) -> None:
                pass

        server = http.server.HTTPServer(("127.0.0.1", 0), Registry)
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        self.addCleanup(server.server_close)
        self.addCleanup(thread.join)
        self.addCleanup(server.shutdown)
        self.said = io.StringIO()
        contexts: tuple[contextlib.AbstractContextManager[Any], ...] = (
            mock.patch.dict(os.environ, {node.REGISTRY_VARIABLE: f"http://127.0.0.1:{server.server_port}/"}),
            mock.patch.object(node.shutil, "which", lambda _: None),
            mock.patch.object(node.time, "sleep", lambda _: None), contextlib.redirect_stderr(self.said))
        for context in contexts:
            context.__enter__()
            self.addCleanup(context.__exit__, None, None, None)
        self.serve("ball", "1.2.3", archive({"package/index.js": b"ball", "package/lib/deep.js": b"deep"}))
        self.serve("@round/ball", "4.5.6", archive({"other/index.js": b"round"}))
        self.lock("ball", "@round/ball")

    def serve(self, name: str, version: str, content: bytes) -> None:
        self.served[f"/{name}/-/{name.split('/')[-1]}-{version}.tgz"] = content

    def lock(self, *names: str, **integrities: str) -> None:
        versions = {path.split("/-/")[0][1:]: (path.rpartition("-")[2].removesuffix(".tgz"), content)
                    for path, content in self.served.items()}
        packages: dict[str, object] = {"": {"name": "engine"}}
        for name in names:
            version, content = versions[name]
            sha = "sha512-" + base64.b64encode(hashlib.sha512(content).digest()).decode()
            packages[f"node_modules/{name}"] = {"version": version, "integrity": integrities.get(name, sha)}
        (self.sources / node.LOCK_FILE).write_text(json.dumps({"packages": packages}))

    def get(self) -> None:
        node.ensure_packages(self.root / "node.log", self.sources, self.folder)

    def refused(self, *words: str) -> None:
        with self.assertRaises(CommandError) as caught:
            self.get()
        for word in words:
            self.assertIn(word, str(caught.exception))

    def read(self, name: str) -> str:
        return (self.folder / "node_modules" / name).read_text()

    def test_are_unpacked_once(self) -> None:
        self.get()
        self.assertEqual((self.read("ball/index.js"), self.read("ball/lib/deep.js"), self.read("@round/ball/index.js")),
                         ("ball", "deep", "round"))
        self.assertEqual(sorted(self.asked), ["/@round/ball/-/ball-4.5.6.tgz", "/ball/-/ball-1.2.3.tgz"])
        self.asked.clear()
        self.get()
        self.assertEqual(self.asked, [])
        self.assertEqual(os.listdir(self.folder.parent), ["node"])

    def test_are_renewed_when_the_lock_file_changes(self) -> None:
        self.get()
        self.served.clear()
        self.serve("ball", "2.0.0", archive({"package/index.js": b"newer"}))
        self.lock("ball")
        self.get()
        self.assertEqual(self.read("ball/index.js"), "newer")
        self.assertEqual(os.listdir(self.folder / "node_modules"), ["ball"])
        self.assertEqual(os.listdir(self.folder.parent), ["node"])

    def test_a_failure_leaves_the_old_ones(self) -> None:
        self.get()
        old = self.read("ball/index.js")
        self.serve("ball", "1.2.3", archive({"package/index.js": b"forged"}))
        (self.sources / node.LOCK_FILE).write_text((self.sources / node.LOCK_FILE).read_text() + "\n")
        self.refused("ball 1.2.3: the archive that came has sha512", node.LOCK_FILE)
        self.assertEqual(self.read("ball/index.js"), old)
        self.assertEqual(os.listdir(self.folder.parent), ["node"])

    def test_what_is_not_there_is_said_with_the_remedy(self) -> None:
        self.served.pop("/ball/-/ball-1.2.3.tgz")
        self.refused("ball-1.2.3.tgz: HTTP Error 404", "check the network", node.REGISTRY_VARIABLE)
        self.assertFalse(self.folder.exists())
        with mock.patch.dict(os.environ, {node.REGISTRY_VARIABLE: "http://127.0.0.1:9"}):  # nobody listens there
            self.refused("cannot download http://127.0.0.1:9/", "check the network")
        with mock.patch.dict(os.environ, {node.REGISTRY_VARIABLE: "nowhere"}):
            self.refused("cannot download nowhere/", node.REGISTRY_VARIABLE)

    def test_only_sha512_is_taken(self) -> None:
        self.lock("ball", ball="sha1-abc")
        self.refused("'sha1-abc', must be sha512")

    def test_archives_stay_below_their_folder(self) -> None:
        for content in (archive({"package/../../out.js": b"x"}), archive({"/package/out.js": b"x"}), archive({"out.js": b"x"}),
                        archive({}, link="/etc/passwd"), b"no archive"):
            self.serve("ball", "1.2.3", content)
            self.lock("ball")
            self.refused("ball: its archive")
            self.assertEqual(os.listdir(self.root / "build"), [])

    def test_the_real_lock_file_can_be_read(self) -> None:
        lock = json.loads((REPOSITORY / "rigid" / "jolt" / node.LOCK_FILE).read_text())["packages"]
        wanted = json.loads((REPOSITORY / "rigid" / "jolt" / "package.json").read_text())["dependencies"]
        self.assertEqual(lock[""]["dependencies"], wanted)
        for place, entry in lock.items():
            if place:
                self.assertRegex(entry["integrity"], "^sha512-")
                self.assertRegex(entry["version"], r"^\d+\.\d+\.\d+$")
        for name, version in wanted.items():
            self.assertEqual(lock[f"node_modules/{name}"]["version"], version)


class Npm(unittest.TestCase):
    def test_its_failure_is_told(self) -> None:
        with tempfile.TemporaryDirectory() as temporary:
            root = Path(temporary)
            (root / "package.json").write_text("{}")
            (root / node.LOCK_FILE).write_text("{}")

            def run(command: list[str], log: Path, cwd: Path) -> int:
                log.write_text("npm is ill\n")
                self.assertIn("--ignore-scripts", command)
                self.assertTrue((cwd / node.LOCK_FILE).is_file())
                return 1

            with mock.patch.object(node, "run_logged", run), mock.patch.object(node.shutil, "which", lambda _: "/bin/npm"), \
                    contextlib.redirect_stderr(io.StringIO()), self.assertRaises(CommandError) as caught:
                node.ensure_packages(root / "log", root, root / "build" / "node")
            self.assertIn("npm is ill", str(caught.exception))
            self.assertIn("failed with status 1", str(caught.exception))
            self.assertEqual(os.listdir(root / "build"), [])


class Places(unittest.TestCase):
    """Packages are found in the named build, beside it or in the work folder, and go into the named build."""

    def test_where_packages_are_and_go(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            root = Path(name)
            sources, work, build = root / "sources", root / "work", root / "build" / "release"
            sources.mkdir()
            (sources / places.LOCK_FILE).write_text("{}")
            with mock.patch.object(places, "work_folder", lambda: work), mock.patch.dict(os.environ):
                os.environ.pop(places.BUILD_DIR_VARIABLE, None)
                self.assertEqual(places.npm_folder("node", sources), work / "node")
                os.environ[places.BUILD_DIR_VARIABLE] = str(build)
                self.assertEqual(places.npm_folder("node", sources), build / "node")
                for place in (work, build.parent, build):  # the later is preferred
                    (place / "node").mkdir(parents=True)
                    (place / "node" / places.LOCK_FILE).write_text("of another version")
                    self.assertNotEqual(places.npm_folder("node", sources), root / "nowhere")
                    (place / "node" / places.LOCK_FILE).write_text("{}")
                    self.assertEqual(places.npm_folder("node", sources), place / "node")

    def test_a_list_of_engines_downloads_nothing_into_a_named_build(self) -> None:
        with tempfile.TemporaryDirectory() as name, mock.patch.dict(os.environ, {places.BUILD_DIR_VARIABLE: name}), \
                mock.patch.object(places, "work_folder", lambda: Path(name) / "work"), \
                mock.patch.object(engines, "names", lambda _: list(engines.NODE_PROGRAMS)), \
                mock.patch.object(node, "ensure_packages") as packages, mock.patch.object(node, "ensure_installed") as install:
            listed = engines.table(Executables(*[Path(name) / "none"] * 3))
            for engine in ("jolt", "mujoco"):
                self.assertRegex(listed, f"(?m)^{engine} +- +not here: --rigid {engine} downloads it to {name}/node$")
            packages.assert_not_called()
            install.assert_not_called()

    def test_a_named_build_installs_no_node_js(self) -> None:
        with mock.patch.dict(os.environ, {places.BUILD_DIR_VARIABLE: "/nowhere"}), \
                mock.patch.object(node, "ensure_installed") as install, mock.patch.object(node, "ensure_packages") as packages:
            with mock.patch.object(node.shutil, "which", lambda _: None), \
                    self.assertRaisesRegex(CommandError, "no Node.js, and SUNDER_BUILD_DIR is set.*apt-get install .* nodejs"):
                node.ensure_node()
            packages.assert_not_called()
            with mock.patch.object(node.shutil, "which", lambda _: "/usr/bin/node"):
                node.ensure_node(folder=Path("/nowhere/node"))
            install.assert_not_called()
            self.assertEqual(packages.call_args.args[0], Path("/nowhere/node.log"))

    def test_the_engine_looks_in_the_same_places(self) -> None:
        program = shutil.which("node")
        if program is None:
            self.skipTest("there is no Node.js")
        with tempfile.TemporaryDirectory() as name:
            for place in ("build", "build/release"):
                folder = Path(name) / place / "node"
                folder.mkdir(parents=True)
                shutil.copy(REPOSITORY / "rigid" / "jolt" / places.LOCK_FILE, folder)
                done = subprocess.run([REPOSITORY / "rigid" / "jolt" / "sunder-rigid-jolt", "--check"], capture_output=True, text=True,
                                      env={**os.environ, places.BUILD_DIR_VARIABLE: f"{name}/build/release"}, check=False)
                self.assertEqual(done.returncode, 2)
                self.assertIn(f"node package {folder}/node_modules/", done.stderr)
                self.assertIn("-m sunder_tools.launch.node", done.stderr)


class Islands(unittest.TestCase):
    def told(self, expression: str) -> object:
        """What an expression gives; bodies a to d move, f does not, and w is the world."""
        program = shutil.which("node")
        if program is None:
            self.skipTest("there is no Node.js")
        text = f"""import {{ islands }} from './rigid/jolt/islands.mjs';
            import {{ freeIslands }} from './rigid/jolt/jolt_islands.mjs';
            const [a, b, c, d, f] = [...'abcdf'].map((name) => ({{ name, body: {{ is_static: name === 'f' }} }}));
            const w = undefined, moves = (held) => held !== undefined && !held.body.is_static;
            process.stdout.write(JSON.stringify({expression}.map((group) => group.map((held) => held.name))));"""
        done = subprocess.run([program, "--input-type=module", "-e", text], cwd=REPOSITORY, capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def test_a_chain_of_pairs_is_one_group(self) -> None:
        self.assertEqual(self.told("islands([[c, d], [a, b], [b, d]], moves)"), [["c", "d", "a", "b"]])
        self.assertEqual(self.told("islands([[a, b], [c, w], [w, d]], moves)"), [["a", "b"], ["c"], ["d"]])
        self.assertEqual(self.told("islands([], moves)"), [])

    def test_what_does_not_move_connects_nothing(self) -> None:
        self.assertEqual(self.told("islands([[a, f], [f, b]], moves)"), [["a"], ["b"]])

    def test_groups_that_hang_on_something_are_not_free(self) -> None:
        self.assertEqual(self.told("freeIslands([[a, b], [b, f], [c, d]])"), [["c", "d"]])
        self.assertEqual(self.told("freeIslands([[a, b], [w, a], [c, d]])"), [["c", "d"]])


if __name__ == "__main__":
    unittest.main()
