"""One animated file of a run: every frame is in it, names follow pieces through hand-off, nothing pops."""
from __future__ import annotations

import json
import unittest
from dataclasses import replace

import numpy as np
from PIL import Image

from sunder_tools.errors import CommandError
from sunder_tools.pictures.animated import animated_glb
from sunder_tools.pictures.between import Between, ends, film_frames, key_frames
from sunder_tools.pictures.frames import BODIES, SHELL, SOFT, Frame, list_frames
from sunder_tools.pictures.look import Look
from sunder_tools.pictures.mesh import mesh_of
from sunder_tools.pictures.meshes import Scene, load_scene
from sunder_tools.pictures.raster import perspective_camera
from sunder_tools.pictures.rigid import centre_of, fit, quaternion, share_of_turn, turn_of
from sunder_tools.pictures.story import story_of
from sunder_tools.pictures.usda import identifier, usda_text
from sunder_tools.pictures.views import draw_scene
from sunder_tools.report.scene_text import Words, parse_text, words_of

from .mesh_files import Animated
from .synthetic import BALL_RADIUS_M, HEIGHT_M, ball, write_vtp
from .test_render import OfARun
from .test_view import InAFolder
from .usda_file import Usda

SINGLE = 1e-6  # [m] of scenes of a metre: single precision, a few times over
SCENE = """materials { name: "glass" density: 2500 strength: 1 }
shells { name: "pane" material: "glass" thickness_m: 0.01 }"""


def sorted_triangles(corners: np.ndarray) -> np.ndarray:
    """Triangles (m, 3, 3) in an order that does not depend on how they are listed."""
    flat = corners.reshape(len(corners), 9).round(4)
    return corners[np.lexsort(flat.T)]


class WholeRuns(OfARun):
    def whole(self, *arguments: str) -> Animated:
        target = self.folder / "run.glb"
        status, said = self.sunder("export", "--gltf", str(target), *arguments)
        self.assertEqual(status, 0, said)
        return Animated(target.read_bytes())

    def test_every_frame_is_in_it(self) -> None:
        film, frames = self.whole(), list_frames(self.folder)
        tops = [name for name in film.names if "_shape_" not in name]
        extras = film.json["extras"]
        self.assertEqual(extras, {"fps": 24.0, "speed": None, "times_s": [frame.time_s for frame in frames]})
        for k in range(len(frames)):
            time = float(film.times[k])
            self.assertAlmostEqual(time, k / 24.0, places=6)
            shown = np.concatenate([c for name in tops for c in film.seen(name, time).values()])
            mesh = mesh_of(frames, k)
            wanted = mesh.points[mesh.triangles]
            self.assertEqual(shown.shape, wanted.shape, f"frame {k}")
            np.testing.assert_allclose(np.sort(shown.mean(axis=1), axis=0), np.sort(wanted.mean(axis=1), axis=0), atol=4 * SINGLE)
            np.testing.assert_allclose(sorted_triangles(shown).mean(axis=1), sorted_triangles(wanted).mean(axis=1), atol=0.05)

    def test_usd_has_every_frame_too(self) -> None:
        status, said = self.sunder("export", "--usd", str(self.folder / "run.usda"), "--speed", "1", "--fps", "4")
        self.assertEqual(status, 0, said)
        stage, frames = Usda((self.folder / "run.usda").read_text()), list_frames(self.folder)
        tops = [path for path, prim in stage.prims.items() if prim.kind == "Xform" and "xformOp:translate" in prim.types]
        film, times = film_frames(frames, 4.0, 1.0)
        self.assertAlmostEqual(stage.meta["endTimeCode"], frames[-1].time_s * 4.0, places=6)
        for k in range(len(film)):
            shown = np.concatenate([c for path in tops for c in stage.seen(path, float(f"{4 * times[k]:.9g}")).values()])
            mesh = mesh_of(film, k)
            np.testing.assert_allclose(np.sort(shown.mean(axis=1), axis=0), np.sort(mesh.points[mesh.triangles].mean(axis=1), axis=0),
                                       atol=4 * SINGLE)

    def test_names_that_usd_does_not_allow(self) -> None:
        taken: set[str] = set()
        self.assertEqual([identifier(n, taken) for n in ("pane", "2nd pane", "Glas\u00e4", "pane", "")],
                         ["pane", "_2nd_pane", "Glas_", "pane_2", "_"])

    def test_resampled_times_are_those_of_a_film(self) -> None:
        frames = list_frames(self.folder)
        film = self.whole("--fps", "30", "--speed", "0.5")
        runs = np.array([frame.time_s for frame in frames])
        for time in film.times:  # of a frame of the run, or of a picture
            self.assertLess(min(np.abs(runs / 0.5 - time).min(), abs(30 * time - round(30 * time)) / 30), 1e-6)
        self.assertAlmostEqual(float(film.times[-1]), 2.0 * frames[-1].time_s, places=5)  # the end is there too
        fall = frames[3].time_s, frames[4].time_s
        middle = 0.5 * (fall[0] + fall[1])
        between, _ = film_frames(frames[3:5], 1.0, middle - fall[0])
        bodies = between[1].read(BODIES)
        assert bodies is not None
        of_all = [f.read(BODIES) for f in (frames[3], between[1], frames[4])]
        here = [centre_of(f.points[:len(ball(1.0)[0])], ball(1.0)[1]) for f in of_all if f is not None]
        self.assertEqual(len(here), 3)
        np.testing.assert_allclose(here[1], 0.5 * (here[0] + here[2]), atol=1e-9)
        self.assertAlmostEqual(here[0][2], HEIGHT_M + BALL_RADIUS_M + 0.003 - 20 * fall[0], places=9)

    def test_pictures_between_frames_cost_nothing_and_are_where_they_were(self) -> None:
        """The slower the film, the more pictures; targets and meshes are those of the run, places those of the pictures."""
        frames = list_frames(self.folder)
        for end, speed, fps in ((5, 1e-4, 24.0), (9, 0.05, 24.0)):
            chosen = ("--frames", f"0-{end - 1}")
            plain, film = self.whole(*chosen), self.whole(*chosen, "--speed", str(speed), "--fps", str(fps))
            pictures, times = film_frames(frames[:end], fps, speed)
            self.assertGreater(len(pictures), 200)
            targets, before = ([len(mesh["primitives"][0].get("targets", ())) for mesh in one.json["meshes"]] for one in (film, plain))
            if end == 5:
                self.assertEqual(targets, before)
            else:  # many frames lie before the second picture
                self.assertLess((len(targets), sum(targets)), (len(before), sum(before)))
            status, said = self.sunder("export", "--usd", str(self.folder / "run.usda"), *chosen, "--speed", str(speed), "--fps", str(fps))
            self.assertEqual(status, 0, said)
            stage = Usda((self.folder / "run.usda").read_text())
            self.assertEqual(sum(prim.kind == "Mesh" for prim in stage.prims.values()), len(targets))
            tops = [name for name in film.names if "_shape_" not in name]
            xforms = [path for path, prim in stage.prims.items() if prim.kind == "Xform" and "xformOp:translate" in prim.types]
            for k in [*range(0, len(pictures), 97), len(pictures) - 1]:
                mesh, time = mesh_of(pictures, k), float(times[k])
                wanted = np.sort(mesh.points[mesh.triangles].reshape(-1, 3), axis=0)
                for shown in (np.concatenate([c for name in tops for c in film.seen(name, time).values()]),
                              np.concatenate([c for path in xforms for c in stage.seen(path, fps * time).values()])):
                    np.testing.assert_allclose(np.sort(shown.reshape(-1, 3), axis=0), wanted, atol=SINGLE)

    def test_frames_between_two_pictures_are_left_out(self) -> None:
        frames = list_frames(self.folder)
        found, times = key_frames(frames, 4.0, 1.0)  # the first four lie before the second picture
        self.assertEqual([frame.time_s for frame in found][0], 0.0)
        self.assertEqual(found[-1], frames[-1])
        self.assertLess(len(found), len(frames))
        self.assertTrue(any(isinstance(frame, Between) for frame in found))
        self.assertTrue((np.diff(times.astype("f4")) > 0.0).all())
        near = [Frame(time, {}) for time in (0.0, 1.0, 1.0 + 1e-9, 2.0, 2.0 + 1e-9)]  # files have single precision
        self.assertEqual([frame.time_s for frame in key_frames(near, 24.0, 0.1)[0]], [0.0, 1.0 + 1e-9, 2.0 + 1e-9])

    def test_bodies_turn_about_their_centre_of_mass(self) -> None:
        """A bar with most of its points at one end: that end does not swing about the middle of the points."""
        corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1.0]]) * [4, 1, 1]
        sides = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
        triangles = np.array([[q[0], q[k], q[k + 1]] for q in sides for k in (1, 2)])
        points = np.concatenate([corners, np.tile([[0.0, 0.5, 0.5]], (9, 1))])  # the last ones are of no triangle but one
        triangles = np.concatenate([triangles, [[8 + k, 8 + k, 8 + k] for k in range(9)]])
        turn = turn_of(np.array([0, 0, np.sin(0.5), np.cos(0.5)]))
        (self.folder / "bar").mkdir()
        frames = []
        for k, (here, time) in enumerate(((points, 0.0), ((points - [2, 0.5, 0.5]) @ turn.T + [5, 0.5, 2.5], 1.0))):
            write_vtp(self.folder / f"bar/{k}.vtp", here, triangles, floats="f8",
                      cell_data={"body": np.ones(len(triangles)), "kind": np.zeros(len(triangles))})
            frames.append(Frame(time, {BODIES: self.folder / f"bar/{k}.vtp"}))
        bodies = film_frames(frames, 4.0, 1.0)[0][1].read(BODIES)
        assert bodies is not None
        quarter = turn_of(np.array([0, 0, np.sin(0.125), np.cos(0.125)]))
        np.testing.assert_allclose(bodies.points, (points - [2, 0.5, 0.5]) @ quarter.T + [2.75, 0.5, 1.0], atol=1e-12)

    def test_a_film_has_a_picture_a_step(self) -> None:
        status, said = self.sunder("render", "--film", "--speed", "2", "--fps", "8", "--size", "64x48", "--jobs", "1", "--out",
                                   str(self.folder / "film.gif"))
        self.assertEqual(status, 0, said)
        frames = list_frames(self.folder)
        with Image.open(self.folder / "film.gif") as film:
            self.assertEqual(film.n_frames, int((frames[-1].time_s - frames[0].time_s) / 2 * 8 + 1e-9) + 1)

    def test_a_sequence_can_be_resampled(self) -> None:
        status, said = self.sunder("export", "--speed", "1", "--fps", "10", "--frames", "5-last")
        self.assertEqual(status, 0, said)
        times = [float(row.split(",")[1]) for row in (self.folder / "export" / "frame_times.csv").read_text().splitlines()[1:]]
        np.testing.assert_allclose(np.diff(times), 0.1, atol=1e-12)
        self.assertEqual(len(list((self.folder / "export").glob("*.ply"))), len(times))

    def test_what_is_refused(self) -> None:
        for arguments, words in ((("--gltf", "run.gltf"), "end it in .glb"), (("--usd", "run.usd"), "end it in .usda"), (("--fps", "24"), "give --speed too"),
                                 (("--speed", "0"), "not a number above 0"), (("--speed", "1e-12"), "take a higher --speed"),
                                 (("--gltf", "a.glb", "--out", "x"), "leave --out out")):
            status, said = self.sunder("export", *arguments)
            self.assertEqual(status, 2)
            self.assertRegex(said, words)
        status, said = self.sunder("render", "--speed", "0.1")
        self.assertEqual(status, 2)
        self.assertRegex(said, "--film only")


class Parting(InAFolder):
    """A plate of two squares turns and flies; the right one parts from it at frame 2 and is a body from frame 3 on. The left
    one is a frozen body from frame FREEZES on."""
    SPIN, SPEED, STEP, THICK, FREEZES = 30.0, np.array([1.0, 0.5, -2.0]), 1e-3, 0.01, 6
    SIDES = np.array([2.0, 1.0])  # of the plate [m]

    def setUp(self) -> None:
        super().setUp()
        (self.folder / "frames").mkdir()
        self.words = words_of(parse_text(SCENE), [])
        entries = []
        for k in range(6):
            self.write(k)
            entries += [f'<DataSet timestep="{k * self.STEP!r}" part="{p}" file="frames/{n}_{k}.vtp"/>'
                        for p, n in ((0, "shell"), (2, "bodies")) if p or k < self.FREEZES]
        (self.folder / "frames.pvd").write_text(f"<VTKFile><Collection>{''.join(entries)}</Collection></VTKFile>")
        self.frames = list_frames(self.folder)
        self.film = Animated(animated_glb(story_of(self.frames, self.words, {}), np.arange(6.0), {}))

    def write_scene(self) -> None:
        """Writes SCENE as the scene of the run."""
        (self.folder / "scene.textproto").write_text(SCENE)
        (self.folder / "command.json").write_text(json.dumps({"scene": str(self.folder / "scene.textproto"), "settings": []}))

    def placed(self, points: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Points of the rest shape, and their velocities: about the right square's centre, which flies straight on."""
        angle = self.SPIN * time
        turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
        middle = np.array([1.5, 0.5, 0.0])
        arm = (points - middle) @ turn.T
        return arm + middle + self.SPEED * time, self.SPEED + self.SPIN * np.stack([-arm[:, 1], arm[:, 0], 0 * arm[:, 0]], 1)

    def write(self, k: int) -> None:
        time, gap = k * self.STEP, 0.002 if k >= 2 else 0.0
        left = np.array([[0, 0, 0], [1 - gap, 0, 0], [1 - gap, 1, 0], [0, 1, 0.0]])
        right = np.array([[1 + gap, 0, 0], [2, 0, 0], [2, 1, 0], [1 + gap, 1, 0.0]])
        square = np.array([[0, 1, 2], [0, 2, 3]])
        rest, triangles, piece = left, square, [1, 1]
        if k < 2:
            rest, triangles, piece = np.concatenate([left, right[[1, 2]]]), np.concatenate([square, [[1, 4, 5], [1, 5, 2]]]), [1] * 4
        elif k == 2:
            rest, triangles, piece = np.concatenate([left, right]), np.concatenate([square, square + 4]), [1, 1, 2, 2]
        now, velocity = self.placed(rest, time)
        write_vtp(self.folder / f"frames/shell_{k}.vtp", now, triangles, floats="f8",
                  point_data={"velocity": velocity, "displacement": now - rest, "uv": rest[:, :2] / self.SIDES}
                  | self.more_of(rest),
                  cell_data={"fragment": np.array(piece, float), "damage": np.zeros(len(piece)), "shell": np.zeros(len(piece))})
        leaving = [(2.0, 1.0, right)] if k >= 3 else []
        leaving += [(1.0, 3.0, left)] if k >= self.FREEZES else []
        points, faces, body, kind = [np.zeros((0, 3))], [np.zeros((0, 3), int)], [np.zeros(0)], [np.zeros(0)]
        at_rest = [np.zeros((0, 3))]
        for number, sort, corners in leaving:
            faces.append(thick_square() + sum(map(len, points)))
            points.append(self.thick(corners, time))
            at_rest.append(self.faces(corners))
            body.append(np.full(len(faces[-1]), number))
            kind.append(np.full(len(faces[-1]), sort))
        rest = np.concatenate(at_rest)
        write_vtp(self.folder / f"frames/bodies_{k}.vtp", np.concatenate(points), np.concatenate(faces), floats="f8",
                  point_data={"displacement": np.concatenate(points) - rest, "uv": rest[:, :2] / self.SIDES}
                  | self.more_of(rest),
                  cell_data={"body": np.concatenate(body), "kind": np.concatenate(kind)})

    def more_of(self, rest: np.ndarray) -> dict[str, np.ndarray]:
        """Further arrays of points that rest there."""
        return {}

    def thick(self, corners: np.ndarray, time: float) -> np.ndarray:
        """Points of both faces (2n, 3) [m] of a square, inside before outside."""
        return self.placed(self.faces(corners), time)[0]

    def faces(self, corners: np.ndarray) -> np.ndarray:
        """The same at rest."""
        up = np.array([0, 0, 0.5 * self.THICK])
        return np.stack([corners - up, corners + up], axis=1).reshape(-1, 3)


def thick_square() -> np.ndarray:
    """Triangles of both faces and the edge of a square."""
    square = np.array([[0, 1, 2], [0, 2, 3]])
    return np.concatenate([2 * square + 1, 2 * square[:, ::-1], *(
        [[2 * a, 2 * b, 2 * b + 1], [2 * a, 2 * b + 1, 2 * a + 1]] for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)))])


class HandOff(Parting):
    def test_a_piece_has_one_node_from_crack_to_flight(self) -> None:
        self.assertEqual(sorted(n for n in self.film.names if "_shape_" not in n), ["pane", "pane_piece_1", "pane_piece_2"])
        self.assertEqual(self.film.seen("pane_piece_2", 1.99), {})
        for k in range(2, 6):
            seen = self.film.seen("pane_piece_2", float(k))
            self.assertEqual(set(seen), {"glass_outside", "glass_inside", "glass_edge"})
            area = 0.5 * np.linalg.norm(np.cross(*(seen["glass_outside"][:, j] - seen["glass_outside"][:, 0] for j in (1, 2))), axis=1)
            self.assertAlmostEqual(float(area.sum()), 0.998, places=5)
            wanted, _ = self.placed(np.array([[1.501, 0.5, 0.0]]), k * self.STEP)
            np.testing.assert_allclose(self.film.centre("pane_piece_2", float(k)), wanted[0], atol=SINGLE)

    def test_nothing_pops(self) -> None:
        """Just before each frame the surface is where it is in the frame, but for what turning bends in a step."""
        bent = 0.5 * (self.SPIN * self.STEP) ** 2  # of a square's half diagonal, below 1 m
        for k in range(1, 6):
            before, after = (np.concatenate([c.reshape(-1, 3) for name in ("pane_piece_1", "pane_piece_2")
                                             for c in self.film.seen(name, time).values()]) for time in (k - 1e-5, float(k)))
            apart = np.linalg.norm(before[:, None] - after[None], axis=2)
            self.assertLess(float(max(apart.min(axis=0).max(), apart.min(axis=1).max())), 2.0 * bent + 2 * 0.002 + 1e-4, f"frame {k}")
            if k == 3:  # the piece leaves: its centre goes on without a step
                np.testing.assert_allclose(self.film.centre("pane_piece_2", 3 - 1e-5), self.film.centre("pane_piece_2", 3.0),
                                           atol=1e-4 * self.STEP * 10 + SINGLE)

    def test_pictures_draw_the_same_faces_of_the_shell_and_of_the_shard(self) -> None:
        for k in range(2, 6):
            drawn = corners_drawn(load_scene(self.frames[k], Look(glass=(True,), thickness=(self.THICK,))))
            gap = np.array([[0, 0, 0], [0.998, 0, 0], [0.998, 1, 0], [0, 1, 0], [1.002, 0, 0], [2, 0, 0], [2, 1, 0], [1.002, 1, 0]])
            wanted = np.concatenate([self.thick(part, k * self.STEP)[thick_square()] for part in (gap[:4], gap[4:])])
            np.testing.assert_allclose(in_order(drawn), in_order(wanted), atol=1e-9)

    def test_what_bends_has_morph_targets(self) -> None:
        """Frames 0 and 1 have the same triangles: half way the points are half way."""
        shape = self.film.json["meshes"][self.film.json["nodes"][self.film.names.index("pane_piece_1_shape_0")]["mesh"]]
        self.assertEqual(len(shape["primitives"][0]["targets"]), 2)  # frame 1, and where frame 2 finds it
        one, two, half = (self.film.seen("pane_piece_1", t)["glass_outside"] for t in (0.0, 1.0, 0.5))
        np.testing.assert_allclose(half, 0.5 * (one + two), atol=SINGLE)
        wanted, _ = self.placed(np.array([[0, 0, 0.005], [1, 0, 0.005], [1, 1, 0.005]]), self.STEP)
        np.testing.assert_allclose(two[0], wanted, atol=SINGLE)

    def test_points_of_a_shell_go_to_where_the_next_frame_has_them(self) -> None:
        for k in range(5):
            shell, after = self.frames[k].read(SHELL), self.frames[k + 1].read(SHELL)
            assert shell is not None
            found = ends(shell, after, self.frames[k + 1].read(BODIES), self.STEP)
            rest = shell.points - shell.point_data["displacement"]
            wanted, _ = self.placed(rest, (k + 1) * self.STEP)
            exact = np.ones(len(rest), bool) if k in (0, 3, 4) else np.abs(rest[:, 0]) < 1e-9  # others are on the crack, or leave
            np.testing.assert_allclose(found[exact], wanted[exact], atol=1e-12)
            np.testing.assert_allclose(found, wanted, atol=(self.SPIN * self.STEP) ** 2 + 0.001)

    def test_a_slow_film_shows_pieces_where_pictures_have_them(self) -> None:
        """Through a crack and a hand-off. Middle surfaces go straight; their faces too, and so lose up to thickness times
        turn² / 16 half way."""
        speed, fps = 1e-4, 24.0
        pictures, times = film_frames(self.frames, fps, speed)
        for middle, lost in ((True, 0.0), (False, self.THICK * (self.SPIN * self.STEP) ** 2 / 16.0)):
            found, at = key_frames(self.frames, fps, speed)
            things = story_of(found, self.words, {}, middle)
            self.assertEqual([len(s.points) for t in things for s in t.shapes],
                             [len(s.points) for t in story_of(self.frames, self.words, {}, middle) for s in t.shapes])
            film = Animated(animated_glb(things, at, {}))
            for k in [*range(0, len(pictures), 41), len(pictures) - 1]:
                mesh = mesh_of(pictures, k, () if middle else self.words.thickness)
                shown = np.concatenate([c for name in ("pane_piece_1", "pane_piece_2") for c in film.seen(name, float(times[k])).values()])
                np.testing.assert_allclose(np.sort(shown.reshape(-1, 3), axis=0), np.sort(mesh.points[mesh.triangles].reshape(-1, 3), axis=0),
                                           atol=SINGLE + lost)

    def test_frames_of_one_time_leave_no_infinite_velocity(self) -> None:
        frames, none = [replace(frame, time_s=0.0) for frame in self.frames], np.zeros(6)
        for times in (none, np.arange(6.0) / 24.0):
            text = usda_text(story_of(frames, self.words, {}), times, 24.0, None, none)
            self.assertNotRegex(text, r"\b(inf|nan)\b")
            self.assertIn("velocities", text)

    def test_usd_tells_the_same(self) -> None:
        stage = Usda(usda_text(story_of(self.frames, self.words, {}), np.arange(6.0) / 24.0, 24.0, 0.5))
        self.assertEqual({k: stage.meta[k] for k in ("upAxis", "metersPerUnit", "endTimeCode", "timeCodesPerSecond", "defaultPrim")},
                         {"upAxis": "Z", "metersPerUnit": 1, "endTimeCode": 5, "timeCodesPerSecond": 24, "defaultPrim": "run"})
        for name in ("pane_piece_1", "pane_piece_2"):
            self.assertEqual(stage.prims[f"/run/pane/{name}"].kind, "Xform")
            for time in (0.0, 0.5, 1.0, 1.5, 1.99, 2.0, 2.5, 3.0, 3.5, 5.0):
                usd, gltf = stage.seen(f"/run/pane/{name}", time), self.film.seen(name, time)
                self.assertEqual(set(usd), set(gltf), f"{name} at {time}")
                for material, corners in usd.items():
                    np.testing.assert_allclose(corners, gltf[material], atol=SINGLE)
                if usd:
                    np.testing.assert_allclose(stage.at(f"/run/pane/{name}", "xformOp:translate", time),
                                               self.film.centre(name, time), atol=SINGLE)
        mesh = stage.prims["/run/pane/pane_piece_1/shape_0"]
        self.assertEqual((mesh.types["points"], mesh.meta["normals.interpolation"]), ("point3f[]", "vertex"))
        self.assertEqual({float(t) for t in mesh.values["points"]}, {0, 1, 2})
        np.testing.assert_allclose(np.array(mesh.values["primvars:rest"])[:, 2].max(), 0.5 * self.THICK, atol=1e-9)


class Freezing(Parting):
    """The same, but the left square freezes at frame 4."""
    FREEZES = 4

    def test_a_piece_keeps_its_node_and_nothing_pops(self) -> None:
        self.assertEqual(sorted(n for n in self.film.names if "_shape_" not in n), ["pane", "pane_piece_1", "pane_piece_2"])
        bent = (self.SPIN * self.STEP) ** 2 * 0.5 * 1.6  # of the corner that is farthest from the axis
        before, after = (self.film.seen("pane_piece_1", time) for time in (4 - 1e-5, 4.0))
        self.assertEqual(set(before), set(after))
        for material in before:
            apart = np.linalg.norm(before[material].reshape(-1, 3)[:, None] - after[material].reshape(-1, 3)[None], axis=2)
            self.assertLess(float(max(apart.min(axis=0).max(), apart.min(axis=1).max())), 2.0 * bent + 1e-4, material)


class Standing(Parting):
    """The same, at rest: whatever a picture shows of hand-off and freezing is a fault of the picture."""
    SPIN, SPEED, FREEZES = 0.0, np.zeros(3), 4

    def test_no_picture_shows_hand_off_or_freezing(self) -> None:
        for scene in ('shells { name: "pane" material: "glass" thickness_m: 0.01 }',
                      'shells { name: "pane" material: "clay" thickness_m: 0.01 }'):
            words = words_of(parse_text(scene), [])
            look = Look(glass=words.glass, thickness=words.thickness, part_of={1: 0, 2: 0})
            scenes = [load_scene(self.frames[k], look) for k in (2, 3, 4)]
            camera = perspective_camera(np.array([0.0, 0.0, -0.2]), np.array([2.0, 1.0, 0.2]), np.array([-0.42, 0.8, -0.46]),
                                        400, 300)
            parted, handed, frozen = (draw_scene(one, camera, 400, 300) for one in scenes)
            self.assertGreater(parted.std(), 0.02)
            for other in (handed, frozen):
                changed = np.abs(parted - other).max(axis=2) > 1.0 / 255.0
                self.assertLess(changed.mean(), 1e-3, "but for pixels of lines")
            thin = draw_scene(load_scene(self.frames[2], Look(glass=words.glass)), camera, 400, 300)
            self.assertGreater((np.abs(parted - thin).max(axis=2) > 0.02).mean(), 2e-3, "the thickness is not seen")


def corners_drawn(scene: Scene) -> np.ndarray:
    """Corners (m, 3, 3) [m] of all triangles."""
    return np.concatenate([surface.points[surface.triangles] for surface in (scene.glass, scene.solid)])


def in_order(corners: np.ndarray) -> np.ndarray:
    """Triangles (m, 9) in the order of their places; each begins with its first corner in that order."""
    turned = []
    for triangle in corners.round(7):
        first = min(range(3), key=lambda k: tuple(triangle[k]))
        turned.append(np.roll(triangle, -first, axis=0).ravel())
    return np.array(sorted(map(tuple, turned)))


class SoftBodies(InAFolder):
    def test_balls_go_on_to_where_the_next_frame_has_their_particles(self) -> None:
        """Other particles come to the surface in the last frame: up to then the old ones move."""
        frames = []
        for k, surface in enumerate(((1, 1, 0), (1, 1, 0), (0, 1, 1))):
            points = np.array([[0.0, 0, 0], [0, 0, 0.1], [0.1, 0, 0.1]]) + [0.2 * k, 0, 0.1 * k * k]
            write_vtp(self.folder / f"soft_{k}.vtp", points, floats="f8", point_data={
                "velocity": np.tile([2.0, 0, 0], (3, 1)), "radius": np.full(3, 0.05), "surface": np.array(surface, float),
                "normal": np.tile([0.0, 0, 1], (3, 1)), "soft_body": np.zeros(3)})
            frames.append(Frame(0.1 * k, {SOFT: self.folder / f"soft_{k}.vtp"}))
        pictures, times = film_frames(frames, 10.0, 0.05)
        found, at = key_frames(frames, 10.0, 0.05)
        self.assertEqual((len(pictures), len(found)), (41, 3))
        things = story_of(found, Words(), {})
        self.assertEqual([len(shape.points) for shape in things[0].shapes], [3, 1])
        film = Animated(animated_glb(things, at, {}))
        for k in range(41):
            mesh = mesh_of(pictures, k)
            np.testing.assert_allclose(film.seen("soft_0", float(times[k]))["soft_0"], mesh.points[mesh.triangles], atol=SINGLE)


class Rotations(unittest.TestCase):
    def test_quaternions_and_shares_of_a_turn(self) -> None:
        random = np.random.default_rng(3)
        points = random.normal(size=(12, 3))
        for _ in range(50):
            axis, angle = random.normal(size=3), random.uniform(0, 3.1)
            axis /= np.linalg.norm(axis)
            turn = turn_of(np.append(np.sin(angle / 2) * axis, np.cos(angle / 2)))
            found, left = fit(points, points @ turn.T + 2.0)
            np.testing.assert_allclose(found, turn, atol=1e-12)
            self.assertLess(left, 1e-12)
            self.assertAlmostEqual(abs(quaternion(turn) @ np.append(np.sin(angle / 2) * axis, np.cos(angle / 2))), 1.0, places=12)
            third = share_of_turn(turn, 1.0 / 3.0)
            np.testing.assert_allclose(third @ third @ third, turn, atol=1e-12)
        self.assertGreater(fit(points, points * [1, 1, -1])[1], 0.1)  # a mirror image is no rotation

    def test_a_time_between_frames_that_would_take_too_many_is_refused(self) -> None:
        frames = [Frame(0.0, {}), Frame(1.0, {})]
        with self.assertRaisesRegex(CommandError, "at most 100000"):
            film_frames(frames, 24.0, 1e-6)
        self.assertEqual(len(film_frames(frames, 24.0, 1.0)[0]), 25)
        self.assertEqual(story_of(frames, Words(), {}), [])


if __name__ == "__main__":
    unittest.main()
