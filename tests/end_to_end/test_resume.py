"""Runs that resume from a checkpoint, and replays of recorded runs, with the real programs."""
from __future__ import annotations

import csv
import json
import math
import os
import signal
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any

TOP = Path(__file__).resolve().parents[2]
BUILD = Path(os.environ["SUNDER_BUILD_DIR"])
SUNDER = [str(TOP / "coupler" / "sunder")]
SCENE = str(TOP / "scenes" / "cut_pane.textproto")
SOFT = str(TOP / "scenes" / "soft_ball.textproto")
GLASS = str(TOP / "scenes" / "glass.textproto")
SHATTERING = [part for setting in ("shells[pane].plate.elements_x=40", "shells[pane].plate.elements_y=40", "end_time_s=2.2e-3",
                                   "fracture.latest_freeze_s=2e-3", "output.checkpoint_interval_s=1e-4",
                                   "output.shell_frame_interval_s=1e-4") for part in ("--set", setting)]
TRIES = 3
OFTEN = [part for setting in ("output.checkpoint_interval_s=3e-4", "output.frame_interval_s=1",
                              "output.shell_frame_interval_s=1") for part in ("--set", setting)]
# A growing pressure presses a mat onto another one, which is drawn along at an edge: it slips there and sticks
# elsewhere.
MATS = """name: "mats"
end_time_s: 0.012
window_s: 5e-4
materials { name: "rubber" density: 1000 youngs_modulus: 1e7 poisson_ratio: 0.4 mass_damping_per_s: 200 }
shells {
  name: "low"
  material: "rubber"
  thickness_m: 0.004
  fibres { compression_modulus: 1e5 shear_modulus: 1e5 friction: 0.3 }
  plate { size_x_m: 0.24 size_y_m: 0.24 elements_x: 12 elements_y: 12 }
  supports { edges: ALL kind: CLAMPED }
}
shells {
  name: "high"
  material: "rubber"
  thickness_m: 0.004
  fibres { compression_modulus: 1e5 shear_modulus: 1e5 friction: 0.3 }
  plate { size_x_m: 0.16 size_y_m: 0.16 elements_x: 8 elements_y: 8 pose { position { x: 0.003 z: 0.00401 } } }
  loads { pressure: -1000 factor { time_s: 0 value: 0 } factor { time_s: 0.004 value: 1 } }
  loads { edge_force { edge: U_MAX force_per_length { x: 40 } } }
}
"""
# A strip that is pulled at 1 m/s: it flows from a strain of 0.01 on.
STRIP = """name: "strip"
end_time_s: 0.002
window_s: 2e-5
gravity {}
materials { name: "metal" density: 1000 youngs_modulus: 2e9 poisson_ratio: 0.3 yield_stress: 2e7 hardening_modulus: 2e8 }
shells {
  name: "strip"
  material: "metal"
  thickness_m: 0.002
  plate { size_x_m: 0.1 size_y_m: 0.04 elements_x: 10 elements_y: 4 }
  supports { edges: U_MIN kind: CLAMPED }
  supports {
    edges: U_MAX kind: SIMPLY_SUPPORTED axes: X axes: Z
    motion { time_s: 0 } motion { time_s: 0.002 displacement { x: 0.002 } }
  }
}
"""
# Two sheets on a seam that opens at a force. One of their supports is released first, and a ball is between both events.
SEAMS = """name: "seams"
end_time_s: 2e-3
window_s: 1e-5
gravity {}
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 }
materials { name: "steel" density: 7800 }
shells {
  name: "pane"
  material: "glass"
  thickness_m: 0.003
  plate { size_x_m: 0.3 size_y_m: 0.3 elements_x: 12 elements_y: 12 }
  supports { edges: U_MIN kind: CLAMPED }
  supports { regions { low { u: 0.1 v: 0.1 } high { u: 0.15 v: 0.15 } } kind: CLAMPED until_s: 4e-4 }
}
shells {
  name: "flap"
  material: "glass"
  thickness_m: 0.003
  plate { size_x_m: 0.2 size_y_m: 0.3 elements_x: 8 elements_y: 12 pose { position { x: 0.25 } } }
  loads { edge_force { edge: U_MAX force_per_length { x: 3e4 } } factor {} factor { time_s: 1.5e-3 value: 1 } }
}
seams { rules { first: "pane" second: "flap" strength: 2e4 } }
bodies { name: "ball" material: "steel" sphere { radius_m: 0.02 } pose { position { z: 0.0225 } } twist { linear { z: -2 } } }
output {
  fields: CONTACT_PRESSURE
  probes { name: "hit" shell: "pane" body: "ball" }
  probes { name: "under" shell: "pane" at { u: 0.15 v: 0.15 } fields: [CONTACT_PRESSURE, STRESS] }
  probe_interval_s: 3e-5
}
"""
# A cut that grows while a punch with a prescribed motion presses; both end before the sheet freezes. Another such body is
# beside a free one, so the windows of flight depend on whether it has arrived.
DRIVEN = """name: "driven"
end_time_s: 0.5
window_s: 1e-4
settle_window_s: 2e-3
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 strength: 180e6 fracture_energy: 8 }
materials { name: "steel" density: 7800 }
shells {
  name: "pane"
  material: "glass"
  thickness_m: 0.004
  plate { size_x_m: 0.3 size_y_m: 0.3 elements_x: 16 elements_y: 16 }
  supports { edges: U_MIN kind: CLAMPED }
  cuts { points { u: 0.1 v: 0 } points { u: 0.12 v: 0.3 } time_s: 1e-4 until_s: 1e-3 }
}
fracture { mode: CUTS latest_freeze_s: 2e-3 }
bodies { name: "ball" material: "steel" sphere { radius_m: 0.01 } pose { position { x: 0.5 z: 0.06 } } }
bodies {
  name: "near"
  sphere { radius_m: 0.03 }
  motion { position { x: 0.5 } }
  motion { time_s: 4e-3 position { x: 0.5 z: 0.01 } rotation { axis { y: 1 } angle_deg: 500 } }
}
"""
# Two linked rods hang from the world. The lower one is released first. Linked bodies overlap, and still do after that.
JOINTS = """name: "joints"
end_time_s: 0.1
window_s: 1e-3
materials { name: "jelly" density: 2500 youngs_modulus: 1e6 poisson_ratio: 0.2 }
shells {
  name: "sheet"
  material: "jelly"
  thickness_m: 0.002
  plate { size_x_m: 0.04 size_y_m: 0.04 elements_x: 4 elements_y: 4 pose { position { z: 9 } } }
  supports { edges: ALL kind: CLAMPED }
}
bodies { name: "upper" material: "jelly" box { size_m { x: 0.3 y: 0.02 z: 0.02 } } pose { position { x: 0.15 } } }
bodies { name: "lower" material: "jelly" box { size_m { x: 0.3 y: 0.02 z: 0.02 } } pose { position { x: 0.44 } } }
joints { name: "early" kind: BALL first: "lower" second: "upper" position { x: 0.295 } breaks { time_s: 0.02 } }
joints { name: "late" kind: HINGE first: "upper" position {} axis { y: 1 } breaks { time_s: 0.07 } }
"""
# A fine sheet on a seam with a coarse one that a ball cracks, above a free one that is coarser still.
LOCAL = """name: "local"
end_time_s: 1e-3
window_s: 2e-5
time_step_safety: 0.6
local_time_steps: true
materials { name: "steel" density: 7800 youngs_modulus: 2.1e11 poisson_ratio: 0.3 }
materials { name: "glass" density: 2500 youngs_modulus: 70e9 poisson_ratio: 0.22 strength: 6e7 fracture_energy: 8 }
shells { name: "fine" material: "steel" thickness_m: 0.002
  plate { size_x_m: 0.12 size_y_m: 0.24 elements_x: 12 elements_y: 24 } supports { edges: U_MIN kind: CLAMPED } }
shells { name: "coarse" material: "glass" thickness_m: 0.003
  plate { size_x_m: 0.24 size_y_m: 0.24 elements_x: 8 elements_y: 8 pose { position { x: 0.18 } } } }
shells { name: "free" material: "steel" thickness_m: 0.002
  plate { size_x_m: 0.8 size_y_m: 0.8 elements_x: 8 elements_y: 8 pose { position { z: -0.0026 } } } }
seams {}
bodies { name: "ball" material: "steel" sphere { radius_m: 0.06 } pose { position { x: 0.18 z: 0.062 } } twist { linear { z: -6 } } }
"""
# A ball shatters a free plate. Its pieces touch one another, so the engine has contact impulses to forget.
PLATE = """name: "plate"
end_time_s: 8e-4
window_s: 2e-6
gravity {}
materials {
  name: "disc"
  density: 2200
  youngs_modulus: 22.35e9
  poisson_ratio: 0.25
  strength: 11.2e6
  fracture_energy: 20.8
}
materials { name: "ball" density: 7700 }
shells {
  name: "disc"
  material: "disc"
  thickness_m: 0.0025
  plate { size_x_m: 0.08 size_y_m: 0.08 elements_x: 26 elements_y: 26 }
}
bodies {
  name: "ball"
  material: "ball"
  sphere { radius_m: 0.005 }
  pose { position { z: 0.01225 } }
  twist { linear { z: -100 } }
}
fracture { mode: TIPS seed: 1 }
"""


def sunder(*arguments: str) -> subprocess.CompletedProcess[str]:
    more = ["--no-pictures"] if arguments[0] == "run" else []
    return subprocess.run([*SUNDER, *arguments, *more], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, timeout=1800, check=False)


def process_names(events: list[dict[str, Any]]) -> list[str]:
    """What a trace calls its processes."""
    return [event["args"]["name"] for event in events if event["name"] == "process_name"]


def state(folder: Path) -> str:
    return str(json.loads((folder / "run.json").read_text())["state_hash"])


def is_cracking(run_json: Path) -> bool:
    """Checks that the run has pieces, that its cracks grow further, and that it has a checkpoint to resume from."""
    try:
        run = json.loads(run_json.read_text())
        return bool(run["counts"]["fragments"] > 1 and run["time"]["frozen_at_s"] is None
                    and run["time"]["simulated_s"] < 1.9e-3 and (run_json.parent / "checkpoint" / "state").is_file())
    except (OSError, ValueError, KeyError):
        return False


def children(parent: int, program: str) -> list[int]:
    """Returns the processes of this name that `parent` has started and that have not ended."""
    try:
        pids = Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
        return [int(pid) for pid in pids if Path(os.readlink(f"/proc/{pid}/exe")).name == program]
    except FileNotFoundError:  # one of them has ended meanwhile
        return []


class Resume(unittest.TestCase):
    def setUp(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self.addCleanup(self._folder.cleanup)
        self.here = Path(self._folder.name)

    def run_to(self, name: str, until: str, *more: str, scene: str = SCENE) -> Path:
        folder = self.here / name
        done = sunder("run", scene, "--out", str(folder), "--until", until, "--quiet", *OFTEN, *more)
        self.assertEqual(done.returncode, 0, done.stderr)
        return folder

    def test_goes_on_to_the_bit(self) -> None:
        for engine in ("bullet", "inprocess:ode"):
            with self.subTest(engine):
                whole = self.run_to(f"whole_{engine}", "0.004", "--rigid", engine)
                part = self.run_to(f"part_{engine}", "0.0008", "--rigid", engine)  # between the cut and the freezing
                self.assertNotEqual(state(part), state(whole))
                done = sunder("run", "--resume", str(part), "--until", "0.004", "--quiet")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(state(part), state(whole))
                self.assertEqual((part / "series.csv").read_text(), (whole / "series.csv").read_text())

    def test_writing_a_checkpoint_changes_nothing(self) -> None:
        scene = self.here / "plate.textproto"
        scene.write_text(PLATE)
        states = set()
        for interval in ("0", "4e-6", "5e-5"):
            folder = self.run_to(interval, "3e-4", "--set", f"output.checkpoint_interval_s={interval}", scene=str(scene))
            states.add(state(folder))
            self.assertGreater(json.loads((folder / "run.json").read_text())["counts"]["handed_off"], 5)
            self.assertEqual((folder / "checkpoint" / "state").is_file(), interval != "0")
        self.assertEqual(len(states), 1)

    def test_soft_bodies_go_on_to_the_bit(self) -> None:
        whole = self.run_to("whole", "0.012", scene=SOFT)  # the sheet throws the ball back
        part = self.run_to("part", "0.006", scene=SOFT)  # the ball presses into the sheet
        done = sunder("run", "--resume", str(part), "--until", "0.012", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(state(part), state(whole))
        self.assertEqual((part / "series.csv").read_text(), (whole / "series.csv").read_text())

    def test_goes_on_after_either_side_was_killed_while_it_cracked(self) -> None:
        def run(name: str, *more: str) -> list[str]:
            return [*SUNDER, "run", GLASS, "--out", str(self.here / name), "--quiet", "--no-pictures", *SHATTERING, *more]

        done = subprocess.run(run("whole"), capture_output=True, text=True, timeout=1800, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        whole = json.loads((self.here / "whole" / "run.json").read_text())
        for program in ("sunder-shell", "sunder-rigid"):
            for tried in range(TRIES):
                folder = self.here / f"{program}_{tried}"
                run_json = folder / "run.json"
                launcher = subprocess.Popen(run(folder.name), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
                while not is_cracking(run_json) and launcher.poll() is None:
                    time.sleep(0.005)
                for process in children(launcher.pid, program):
                    os.kill(process, signal.SIGKILL)
                said = launcher.communicate(timeout=1800)[1]
                if launcher.returncode != 0:  # else it was done before it could be killed
                    break
            with self.subTest(program):
                self.assertEqual(launcher.returncode, 3, said)
                cut = json.loads(run_json.read_text())
                self.assertEqual((cut["status"], cut["error"]["kind"]), ("failed", "peer_lost"))
                self.assertNotEqual(cut.get("state_hash"), whole["state_hash"])
                done = sunder("run", "--resume", str(folder), "--quiet")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(state(folder), whole["state_hash"])
                self.assertEqual((folder / "series.csv").read_text(), (self.here / "whole" / "series.csv").read_text())

    def test_a_metal_goes_on_to_the_bit_before_and_after_its_first_flow(self) -> None:
        scene = self.here / "strip.textproto"
        scene.write_text(STRIP)
        whole = self.run_to("whole", "0.002", scene=str(scene))
        for name, until, flowed in (("before", "0.0004", False), ("after", "0.0014", True)):
            with self.subTest(name):
                part = self.run_to(name, until, scene=str(scene))
                self.assertEqual(json.loads((part / "run.json").read_text())["energy"]["dissipated_plastic"] > 0.0, flowed)
                done = sunder("run", "--resume", str(part), "--until", "0.002", "--quiet")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(state(part), state(whole))
                self.assertEqual((part / "series.csv").read_text(), (whole / "series.csv").read_text())

    def test_local_time_steps_go_on_to_the_bit(self) -> None:
        scene = self.here / "local.textproto"
        scene.write_text(LOCAL)
        whole = self.run_to("whole", "0.001", scene=str(scene))
        part = self.run_to("part", "0.0004", scene=str(scene))
        done = sunder("run", "--resume", str(part), "--until", "0.001", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(state(part), state(whole))
        self.assertEqual((part / "series.csv").read_text(), (whole / "series.csv").read_text())
        two, one = (json.loads((folder / "run.json").read_text()) for folder in (part, whole))
        self.assertEqual(two["local_time_steps"], one["local_time_steps"])
        self.assertGreaterEqual(one["local_time_steps"]["longest_substeps"], 4)  # of the free sheet
        self.assertGreater(one["local_time_steps"]["force_work_saved"], 0.1)
        self.assertGreater(one["cracks"]["length_m"], 0.05)
        self.assertLess(abs(one["energy"]["residual_relative"]), 0.01)  # of first order in the step
        threads = self.run_to("threads", "0.001", "--threads", "2", scene=str(scene))
        self.assertEqual(state(threads), state(whole))

    def test_fibres_go_on_to_the_bit(self) -> None:
        scene = self.here / "mats.textproto"
        scene.write_text(MATS)
        whole = self.run_to("whole", "0.012", scene=str(scene))
        part = self.run_to("part", "0.006", scene=str(scene))  # the mats are pressed, and slip at the drawn edge
        done = sunder("run", "--resume", str(part), "--until", "0.012", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(state(part), state(whole))
        self.assertEqual((part / "series.csv").read_text(), (whole / "series.csv").read_text())
        run = json.loads((whole / "run.json").read_text())
        self.assertGreater(run["energy"]["contact"], 0.0)  # the mats have slipped
        self.assertLess(abs(run["energy"]["residual_relative"]), 0.01)  # of first order in the step
        self.assertIn("fibres", [m["name"] for m in run["models"]])
        self.assertNotIn("contact_between_shells", [m["name"] for m in run["models"]])

    def test_torn_fibres_go_on_to_the_bit(self) -> None:
        scene = self.here / "torn_between.textproto"  # that of the cookbook: strips tear a cloth between them
        page = (TOP / "scenes" / "README.md").read_text()
        begin = page.index('name: "torn_between"')
        scene.write_text(page[begin:page.index("```", begin)])
        whole = self.run_to("whole", "0.0094", scene=str(scene))
        part = self.run_to("part", "0.006", scene=str(scene))  # fibres are damaged, and nothing is cut
        self.assertEqual(json.loads((part / "run.json").read_text())["cracks"]["length_m"], 0.0)
        self.assertGreater(json.loads((part / "run.json").read_text())["energy"]["healing"], 0.0)
        done = sunder("run", "--resume", str(part), "--until", "0.0094", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(state(part), state(whole))
        self.assertEqual((part / "series.csv").read_text(), (whole / "series.csv").read_text())
        run = json.loads((whole / "run.json").read_text())
        self.assertGreaterEqual(run["cracks"]["length_m"], 0.12)  # from border to border
        self.assertGreaterEqual(run["counts"]["fragments"], 4)  # the cloth in two, and the strips; slivers come later
        self.assertLess(abs(run["energy"]["residual_relative"]), 0.01)  # of first order in the step
        self.assertIn("fibre_damage", [m["name"] for m in run["models"]])
        off = self.run_to("off", "0.0094", "--set", "shells[cloth].fibres.shear_strength=1.2e4",
                          scene=str(scene))  # more than friction holds
        self.assertEqual(json.loads((off / "run.json").read_text())["cracks"]["length_m"], 0.0)

    def test_fibres_on_joined_mats_go_on_to_the_bit(self) -> None:
        scene = self.here / "joined.textproto"
        low = """  plate { size_x_m: 0.24 size_y_m: 0.24 elements_x: 12 elements_y: 12 }
  supports { edges: ALL kind: CLAMPED }
}
"""
        left = """  plate { size_x_m: 0.12 size_y_m: 0.24 elements_x: 6 elements_y: 12 pose { position { x: -0.06 } } }
  supports { edges: U_MIN edges: V_MIN edges: V_MAX kind: CLAMPED }
}
"""
        right = MATS[MATS.index("shells {"):MATS.index(low)].replace('"low"', '"right"') + left.replace("x: -0.06", "x: 0.06").replace("U_MIN", "U_MAX")
        scene.write_text(MATS.replace(low, left + right) + "seams {}\n")
        whole = self.run_to("whole", "0.012", scene=str(scene))
        part = self.run_to("part", "0.006", scene=str(scene))
        done = sunder("run", "--resume", str(part), "--until", "0.012", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(state(part), state(whole))
        run = json.loads((whole / "run.json").read_text())
        self.assertGreater(run["energy"]["contact"], 0.0)
        self.assertLess(abs(run["energy"]["residual_relative"]), 0.01)

    def test_driven_bodies_and_growing_cuts_go_on_to_the_bit(self) -> None:
        scene = self.here / "driven.textproto"
        scene.write_text(DRIVEN)
        whole = self.run_to("whole", "0.5", scene=str(scene))
        with (whole / "series.csv").open() as lines:
            rows = [(float(row["time [s]"]), float(row["cracks [m]"])) for row in csv.DictReader(lines)]
        line = math.hypot(0.3, 0.02)
        beyond = 0.5 * (rows[-1][1] - line)  # both ends of the cut run on beyond the borders
        for when, length in rows:
            if 3e-4 < when < 1e-3:  # within an edge of 0.9 elements, and what grows in a window
                self.assertAlmostEqual(length, beyond + line * (when - 1e-4) / 9e-4, delta=0.9 * 0.3 / 16 + line / 9)
        for until in ("5e-4", "3e-3", "0.2"):  # while the cut grows, before the body arrives, long after that
            with self.subTest(until):
                part = self.run_to(f"part_{until}", until, scene=str(scene))
                done = sunder("run", "--resume", str(part), "--until", "0.5", "--quiet")
                self.assertEqual(done.returncode, 0, done.stderr)
                windows = [json.loads((folder / "run.json").read_text())["time"]["windows"] for folder in (part, whole)]
                self.assertEqual(windows[0], windows[1])
                self.assertEqual(state(part), state(whole))

    def test_released_supports_and_seams_stay_released(self) -> None:
        scene = self.here / "seams.textproto"
        scene.write_text(SEAMS)
        whole = self.run_to("whole", "2e-3", scene=str(scene))
        run = json.loads((whole / "run.json").read_text())
        self.assertEqual(run["counts"]["fragments"], 2)  # the seam has opened
        self.assertLess(abs(run["energy"]["residual_relative"]), 1e-5)
        for until in ("3.6e-4", "7e-4", "1.5e-3"):  # before the release, after it, after the seam has opened
            with self.subTest(until):
                part = self.run_to(f"part_{until}", until, scene=str(scene))
                done = sunder("run", "--resume", str(part), "--until", "2e-3", "--quiet")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(state(part), state(whole))
                for name in ("series.csv", "probes.csv"):
                    self.assertEqual((part / name).read_text(), (whole / name).read_text())

    def test_released_joints_stay_released(self) -> None:
        scene = self.here / "joints.textproto"
        scene.write_text(JOINTS)
        for engine in ("bullet", "inprocess:ode"):
            with self.subTest(engine):
                whole = self.run_to(f"whole_{engine}", "0.1", "--rigid", engine, scene=str(scene))
                part = self.run_to(f"part_{engine}", "0.05", "--rigid", engine, scene=str(scene))
                joints = json.loads((part / "run.json").read_text())["joints"]
                self.assertEqual([(j["name"], j["released_s"] is None) for j in joints], [("early", False), ("late", True)])
                done = sunder("run", "--resume", str(part), "--until", "0.1", "--quiet")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(state(part), state(whole))
                joints = json.loads((part / "run.json").read_text())["joints"]
                self.assertAlmostEqual(joints[0]["released_s"], 0.02, places=12)
                self.assertAlmostEqual(joints[1]["released_s"], 0.07, places=12)

    def test_refuses_what_is_no_checkpoint_of_this_run(self) -> None:
        part = self.run_to("part", "0.0008")
        checkpoint = part / "checkpoint" / "state"
        good = checkpoint.read_bytes()
        for name, bytes_ in (("empty", b""), ("cut", good[:-100]), ("flipped", good[:5000] + bytes([good[5000] ^ 1]) + good[5001:]),
                             ("other", b"something else\n" + good)):
            with self.subTest(name):
                checkpoint.write_bytes(bytes_)
                done = sunder("run", "--resume", str(part), "--quiet")
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn("bad_checkpoint", done.stderr)
        checkpoint.write_bytes(good)
        command = json.loads((part / "command.json").read_text())
        command["settings"].append("shells[pane].thickness_m=0.005")
        (part / "command.json").write_text(json.dumps(command))
        done = sunder("run", "--resume", str(part), "--quiet")
        self.assertEqual(done.returncode, 2)
        self.assertIn("other settings", done.stderr)
        checkpoint.unlink()
        self.assertIn("holds no checkpoint", sunder("run", "--resume", str(part)).stderr)

    def test_a_trace_names_the_programs_that_ran(self) -> None:
        mine = self.here / "my \"engine\".sh"
        mine.write_text(f"#!/bin/sh\nshift 2\nexec {BUILD}/rigid/sunder-rigid --engine freeflight \"$@\"\n")
        mine.chmod(0o755)
        for name, engine, says in (("mine", str(mine), ["sunder-shell", "my \"engine\".sh (freeflight "]),
                                   ("alone", "inprocess:bullet", ["sunder-single"])):
            folder = self.run_to(name, "1e-3", "--trace", "--rigid", engine)
            names = process_names(json.loads((folder / "trace.json").read_text())["traceEvents"])
            self.assertEqual([told[:len(says[k])] for k, told in enumerate(names)], says)

    def test_a_recording_plays_to_either_side(self) -> None:
        folder = self.run_to("recorded", "0.003", "--record", "--trace")
        for side in ("shell", "rigid"):
            done = sunder("replay", str(folder), "--side", side)
            self.assertEqual(done.returncode, 0, done.stderr + done.stdout)
        events = json.loads((folder / "trace.json").read_text())["traceEvents"]
        self.assertEqual({event["pid"] for event in events}, {1, 2})
        self.assertTrue(all(event["dur"] >= 0 for event in events if event["ph"] == "X"))
        bullet = json.loads((folder / "run.json").read_text())["engine"]["version"]
        self.assertEqual(process_names(events), ["sunder-shell", f"sunder-rigid (bullet {bullet})"])
        changed = json.loads((folder / "command.json").read_text())
        changed["settings"].append("gravity.z=-9.8")
        (folder / "command.json").write_text(json.dumps(changed))
        done = sunder("replay", str(folder))
        self.assertEqual(done.returncode, 1)
        self.assertIn("is not as recorded", done.stderr)


if __name__ == "__main__":
    unittest.main()
