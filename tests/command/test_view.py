"""What `sunder view` serves, without a browser: tests/viewer has the page itself."""
from __future__ import annotations

import contextlib
import http.client
import io
import json
import os
import struct
import tempfile
import threading
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from sunder_tools.command.main import main
from sunder_tools import places
from sunder_tools.errors import CommandError
from sunder_tools.launch import node
from sunder_tools.pictures import view
from sunder_tools.pictures.frames import BODIES, SHELL, list_frames
from sunder_tools.pictures.motion import body_velocity
from sunder_tools.pictures.playback import Playback, impulses
from sunder_tools.places import BUILD_DIR_VARIABLE
from sunder_tools.report.columns import read_columns, thin
from sunder_tools.report.scene_text import SCENE_COPY, SceneTextError, Words, parse_text, scene_words, words_of

from . import REPOSITORY
from .synthetic import SyntheticRun


class InAFolder(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def synthetic(self, count: int = 9) -> SyntheticRun:
        run = SyntheticRun(self.folder, elements=8, fragments=8, count=count)
        for k in range(count):
            run.write(k)
        run.write_run_json("done", count - 1)
        return run


class Served(InAFolder):
    def setUp(self) -> None:
        super().setUp()
        self.synthetic()
        self.server = view.Server(self.folder)
        thread = threading.Thread(target=self.server.serve_forever, args=(0.02,))
        thread.start()
        self.addCleanup(self.server.server_close)
        self.addCleanup(thread.join)
        self.addCleanup(self.server.shutdown)

    def get(self, path: str, host: str | None = None) -> tuple[int, bytes, dict[str, str]]:
        connection = http.client.HTTPConnection("127.0.0.1", self.server.server_port, timeout=1800)
        try:
            connection.request("GET", path, headers={"Host": host} if host else {})
            answer = connection.getresponse()
            return answer.status, answer.read(), dict(answer.getheaders())
        finally:
            connection.close()

    def test_only_this_machine_and_only_what_is_listed(self) -> None:
        self.assertEqual(self.server.server_address[0], "127.0.0.1")
        self.assertEqual(self.get("/state", "evil.example:80")[0], 403)
        self.assertEqual(self.get("/state", f"localhost:{self.server.server_port}")[0], 200)
        for path in ("/../../etc/passwd", "/frames/shell_000000.vtp", "/run.json", "/frame/99", "/frame/-1", "/frame/1e9", "/x"):
            self.assertEqual(self.get(path)[0], 404, path)

    def test_the_browser_is_told_to_stay_here(self) -> None:
        status, page, headers = self.get("/")
        self.assertEqual(status, 200)
        policy = headers["Content-Security-Policy"]
        self.assertIn("default-src 'none'", policy)
        self.assertNotIn("unsafe", policy)
        self.assertNotRegex(page.decode(), r"https?://")
        for name in ("view", "frame", "scene", "colours", "plots"):
            status, script, headers = self.get(f"/{name}.js")
            self.assertEqual((status, headers["Content-Type"]), (200, "text/javascript; charset=utf-8"))
            self.assertNotRegex(script.decode(), r"https?://")

    def test_a_frame_is_what_the_files_say(self) -> None:
        frames = list_frames(self.folder)
        for k in (0, 5, len(frames) - 1):
            _, packed, _ = self.get(f"/frame/{k}")
            length, = struct.unpack_from("<I", packed)
            header = json.loads(packed[4:4 + length])
            self.assertEqual(header["time_s"], frames[k].time_s)

            def array(name: str) -> np.ndarray:
                kind, offset, count = header["arrays"][name]
                self.assertEqual((4 + length + offset) % 4, 0)
                return np.frombuffer(packed, "<" + kind, count, 4 + length + offset)

            for part, name in ((SHELL, "shell"), (BODIES, "bodies")):
                mesh = frames[k].read(part)
                if mesh is None:
                    self.assertNotIn(f"{name}.index", header["arrays"])
                    continue
                np.testing.assert_array_equal(array(f"{name}.index").reshape(-1, 3), mesh.triangles)
                places = array(f"{name}.position").reshape(-1, 3) + np.array(header["origin"])
                np.testing.assert_allclose(places, mesh.points, atol=1e-7)  # single precision of half a metre

    def test_a_shell_has_its_thickness(self) -> None:
        """The page gets a closed surface with the volume of the sheet; where it is flat it has no normals."""
        thickness = 0.004
        (self.folder / SCENE_COPY).write_text(
            f'materials {{ name: "glass" density: 2500 }} shells {{ name: "pane" material: "glass" thickness_m: {thickness} }}')
        frames = list_frames(self.folder)
        for k in (0, 4):
            _, packed, _ = self.get(f"/frame/{k}")
            length, = struct.unpack_from("<I", packed)
            header = json.loads(packed[4:4 + length])
            arrays = {name: np.frombuffer(packed, "<" + kind, count, 4 + length + offset)
                      for name, (kind, offset, count) in header["arrays"].items()}
            self.assertEqual(header["thickness_m"], thickness)
            corner = arrays["shell.position"].reshape(-1, 3)[arrays["shell.index"].reshape(-1, 3)].astype(float)
            shell = frames[k].read(SHELL)
            assert shell is not None
            a, b, c = shell.points[shell.triangles].transpose(1, 0, 2)
            area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
            a, b, c = corner.transpose(1, 0, 2)
            volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
            self.assertAlmostEqual(volume / (area * thickness), 1.0, delta=1e-3)  # it sags by less than a hundredth
            normal = np.linalg.norm(arrays["shell.normal"].reshape(-1, 3), axis=1)[arrays["shell.index"].reshape(-1, 3)]
            own = np.cross(b - a, c - a)
            self.assertTrue((np.abs(own[:, 2]) < 0.5 * np.linalg.norm(own, axis=1))[(normal == 0.0).all(axis=1)].all(), "edges")
            self.assertGreater(int((normal == 0.0).all(axis=1).sum()), 32)
            for name in ("damage", "fragment", "part"):
                self.assertEqual(len(arrays[f"shell.{name}"]), len(corner))
            self.assertEqual(3 * len(arrays["shell.speed"]), len(arrays["shell.position"]))

    def test_broken_files_are_told(self) -> None:
        path = self.folder / "frames" / "bodies_000002.vtp"
        path.write_bytes(path.read_bytes()[:500])
        status, text, _ = self.get("/frame/2")
        self.assertEqual(status, 500)
        self.assertIn("bodies_000002.vtp", text.decode())
        (self.folder / "frames.pvd").write_text("<VTKFile><Coll")
        status, text, _ = self.get("/state")
        self.assertEqual(status, 500)
        self.assertIn("frames.pvd", text.decode())

    def test_a_port_in_use_is_told(self) -> None:
        with self.assertRaisesRegex(CommandError, f"--port {self.server.server_port}: port is in use; give another"):
            view.Server(self.folder, self.server.server_port)

    def test_another_run_in_the_folder_has_other_versions(self) -> None:
        before = [f["version"] for f in self.server.playback.state()["frames"]]
        self.synthetic()
        after = [f["version"] for f in self.server.playback.state()["frames"]]
        self.assertFalse(set(before) & set(after))


class Refused(InAFolder):
    def refused(self, *arguments: str) -> str:
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            self.assertEqual(main(["view", *arguments]), 2)
        return said.getvalue()

    def test_what_is_no_run(self) -> None:
        self.assertIn("holds neither run.json nor frames.pvd", self.refused(str(self.folder)))
        self.assertIn("no such folder", self.refused(str(self.folder / "nowhere")))
        for port in ("-1", "65536", "http"):
            self.assertIn("is not a port", self.refused(str(self.folder), f"--port={port}"))

    def test_three_js_goes_into_the_named_build_and_nowhere_else(self) -> None:
        self.synthetic(3)
        with mock.patch.dict(os.environ, {BUILD_DIR_VARIABLE: str(self.folder / "build"), node.REGISTRY_VARIABLE: "http://127.0.0.1:1"}), \
                mock.patch.object(places, "work_folder", lambda: self.folder / "none"), \
                mock.patch.object(node.shutil, "which", lambda _: None), mock.patch.object(node.time, "sleep", lambda _: None):
            self.assertIn("cannot download http://127.0.0.1:1/three/", self.refused(str(self.folder), "--no-browser"))
            self.assertFalse((self.folder / "none").exists())
            self.assertEqual(view.packages(), self.folder / "build" / "viewer" / "node_modules")

    def test_a_run_without_frames_can_be_watched(self) -> None:
        (self.folder / "run.json").write_text('{"schema": 1, "status": "running"}')
        state = Playback(self.folder).state()
        self.assertEqual((state["frames"], state["status"]), ([], "running"))
        self.assertEqual(Playback(self.folder).curves(), {"plots": []})


class Curves(InAFolder):
    def test_a_row_that_is_being_written_is_left_out(self) -> None:
        path = self.folder / "series.csv"
        path.write_text("time [s],kinetic [J]\n0,1\n1,nan\nbad,2\n3,4,5\n2,3.")
        columns = read_columns(path)
        np.testing.assert_array_equal(columns["time [s]"], [0, 1])
        self.assertEqual(read_columns(self.folder / "none.csv"), {})

    def test_peaks_survive_thinning(self) -> None:
        time = np.arange(100_000.0)
        values = np.sin(time / 3e4)
        values[77_777], values[12_345], values[5] = 9.0, -9.0, np.nan
        t, y = thin(time, values)
        self.assertLess(len(t), 2100)
        self.assertEqual((y[t == 77_777], y[t == 12_345]), (9.0, -9.0))
        self.assertEqual((t[0], t[-1]), (0.0, 99_999.0))
        self.assertTrue((np.diff(t) > 0).all())

    def test_impulse_is_momentum_less_weight(self) -> None:
        time = np.linspace(0.0, 1.0, 101)
        got = np.where(time > 0.5, 3.0, 0.0)  # [m/s] at half time, from whatever it touched
        probes = {"time [s]": time, "p_vx [m/s]": 2.0 + got, "p_vy [m/s]": 0.0 * time, "p_vz [m/s]": -9.81 * time,
                  "reaction_x [N]": 0.0 * time + 4.0}
        words = Words(probes=(("p", "ball"),), masses=(("ball", 2.0),))
        plot, = impulses(probes, words)[:1]
        self.assertEqual([(plot["unit"], c["name"]) for c in plot["curves"]][:1], [("N s", "p x")])
        curves = {c["name"]: c["y"][-1] for c in plot["curves"]}
        self.assertAlmostEqual(curves["p x"], 6.0)
        self.assertAlmostEqual(curves.get("p z", 0.0), 0.0)
        self.assertAlmostEqual(curves["supports x"], 4.0)
        plots = impulses(probes, Words())  # mass not known
        self.assertEqual([(p["unit"], p["curves"][0]["name"]) for p in plots], [("N s", "supports x"), ("m/s", "p x")])
        self.assertAlmostEqual(plots[1]["curves"][0]["y"][-1], 3.0)

    def test_impulse_of_supports_is_what_the_solver_has_summed(self) -> None:
        time = np.linspace(0.0, 1.0, 5)
        probes = {"time [s]": time, "reaction_x [N]": 0.0 * time + 4.0,
                  "p_support_0_u_min_x [N]": 0.0 * time + 3.0, "p_support_0_u_max_x [N]": 0.0 * time + 1.0,
                  "p_support_0_u_min_impulse_x [N s]": np.array([0.0, 1.0, 2.0, 0.0, 0.5]),
                  "p_support_0_u_max_impulse_x [N s]": np.array([0.0, 0.0, 0.0, 0.0, -1.5])}
        plot = impulses(probes, Words())[0]
        curves = {c["name"]: c["y"] for c in plot["curves"]}
        self.assertEqual(curves["p_support_0_u_min x"], [0.0, 1.0, 3.0, 3.0, 3.5])
        self.assertEqual(curves["supports x"], [0.0, 1.0, 3.0, 3.0, 2.0])

    def test_bodies_move_as_they_do_between_frames(self) -> None:
        run = self.synthetic(9)
        frames = list_frames(self.folder)
        here = frames[2].read(BODIES)
        assert here is not None
        body = here.of_triangles("body", 0)
        velocity = body_velocity(frames, 2)
        ball = velocity[np.unique(here.triangles[body == 0])]
        np.testing.assert_allclose(ball, np.broadcast_to([0, 0, -20.0], ball.shape), atol=1e-6)
        np.testing.assert_array_equal(velocity[np.unique(here.triangles[body == 1])], 0.0)
        born = frames[run.count // 3 + 1]
        shard = born.read(BODIES)
        assert shard is not None
        mine = np.unique(shard.triangles[shard.of_triangles("kind", 0) == 1])
        speed = np.linalg.norm(body_velocity(frames, run.count // 3 + 1)[mine], axis=1)
        self.assertGreater(speed.min(), 0.1, "one that is new has the speed of its first interval")


class SceneText(InAFolder):
    def test_reads_what_the_format_allows(self) -> None:
        message = parse_text('a: 1 # one\nb { c: "x # y" d: [1, 2.5] } b < c: \'z\' >; e: WORD, f: -1e-3')
        self.assertEqual(message, {"a": [1.0], "b": [{"c": ["x # y"], "d": [1.0, 2.5]}, {"c": ["z"]}], "e": ["WORD"],
                                   "f": [-1e-3]})

    def test_rejects_what_is_none(self) -> None:
        for text in ("a {", "a:", "{ }", 'a: "x', "a: [1", "1: 2"):
            with self.assertRaises(SceneTextError, msg=text):
                parse_text(text)

    def test_every_scene_of_the_project_can_be_read(self) -> None:
        for path in sorted((REPOSITORY / "scenes").glob("*.textproto")):
            words = words_of(parse_text(path.read_text()), [])
            self.assertTrue(all(words.shells), path.name)
        car = words_of(parse_text((REPOSITORY / "scenes" / "impactor.textproto").read_text()), [])
        self.assertEqual([n for n, g in zip(car.shells, car.glass) if g], ["windscreen", "rear_window"])
        mass = car.mass_under("impactor")
        assert mass is not None
        self.assertAlmostEqual(mass, 0.5 * 0.7 * 0.5 * 2300)

    def test_a_mass_that_was_set_is_not_guessed(self) -> None:
        scene = parse_text((REPOSITORY / "scenes" / "impactor.textproto").read_text())
        self.assertIsNone(words_of(scene, ["materials[concrete].density=1"]).mass_under("impactor"))
        self.assertIsNotNone(words_of(scene, ["end_time_s=1"]).mass_under("impactor"))

    def test_a_mesh_that_became_several_shells_has_their_names(self) -> None:
        (self.folder / SCENE_COPY).write_text("""materials { name: "clay" density: 2000 strength: 1 } materials { name: "glass" }
            shells { name: "vase" material: "clay" thickness_m: 0.01 } shells { name: "lid" material: "glass" thickness_m: 0.02 }""")
        told: dict[str, Any] = {"schema": 1, "counts": {"patches": 4}, "shells": ["vase.1", "vase.2.1", "vase.2.2", "lid"]}
        (self.folder / "run.json").write_text(json.dumps(told))
        words = scene_words(self.folder)
        self.assertEqual((words.shells, words.materials), (tuple(told["shells"]), ("clay", "clay", "clay", "glass")))
        self.assertEqual((words.glass, words.thickness), ((False, False, False, True), (0.01, 0.01, 0.01, 0.02)))
        self.assertEqual(words.surface_density[:3], (20.0,) * 3)
        own = {**told, "shell_materials": ["clay", "glass", "clay", "glass"], "shell_thickness_m": [0.01, 0.03, 0.01, 0.02]}
        (self.folder / "run.json").write_text(json.dumps(own))  # a part of the mesh has its own
        words = scene_words(self.folder)
        self.assertEqual((words.materials, words.glass), (("clay", "glass", "clay", "glass"), (False, True, False, True)))
        self.assertEqual((words.thickness[1], words.breaks), (0.03, (True, False, True, False)))
        (self.folder / "run.json").write_text(json.dumps({**own, "shell_materials": ["clay", "jade", "clay", "glass"]}))
        self.assertEqual(scene_words(self.folder).materials, ("clay", "clay", "clay", "glass"))
        for shells in (["vase.1", "vase.2", "jug.1", "lid"], ["vase.1", "lid"], "lid", None):  # of no shell, too few, no list
            (self.folder / "run.json").write_text(json.dumps({**told, "shells": shells}))
            self.assertEqual(scene_words(self.folder), Words())

    def test_names_of_another_scene_are_not_taken(self) -> None:
        (self.folder / "run.json").write_text('{"schema": 1, "scene": "impactor", "counts": {"patches": 3}}')
        self.assertEqual(scene_words(self.folder), Words())
        (self.folder / "run.json").write_text('{"schema": 1, "scene": "../../etc/passwd"}')
        self.assertEqual(scene_words(self.folder), Words())


if __name__ == "__main__":
    unittest.main()
