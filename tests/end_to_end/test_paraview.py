"""What ParaView reads in frames, by its own `pvpython`: skipped, with the reason, where that is not installed."""
from __future__ import annotations

import json
import re
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

from .test_fields import BUILD, CRACKED, TOP, run, told_areas

PVPYTHON = shutil.which("pvpython")
WHY = "pvpython is not installed (Debian's paraview, python3-paraview)"
# Prints the area of the blocks called `shell` at each time.
AREAS = """
import json, sys
from paraview import servermanager, simple
reader = simple.PVDReader(FileName=sys.argv[1])
shells = simple.ExtractBlock(Input=reader, Selectors=["//shell"])
integrated = simple.IntegrateVariables(Input=shells)
found = []
for time in reader.TimestepValues:
    integrated.UpdatePipeline(time)
    area = servermanager.Fetch(integrated).GetCellData().GetArray("Area")
    found.append([time, area.GetValue(0)])
print("FOUND", json.dumps(found))
"""
# Prints the moment of the cell that is nearest to a place, and the stress across at both faces, at the first time.
MOMENT = """
import json, sys
from paraview import servermanager, simple
reader = simple.PVDReader(FileName=sys.argv[1])
shells = simple.ExtractBlock(Input=reader, Selectors=["//shell"])
shells.UpdatePipeline(reader.TimestepValues[0])
block = servermanager.Fetch(shells)
while block.IsA("vtkMultiBlockDataSet"):
    block = block.GetBlock(0)
place = [float(word) for word in sys.argv[2:5]]
cell = min(range(block.GetNumberOfCells()), key=lambda k: sum(
    (0.5 * (block.GetCell(k).GetBounds()[2 * d] + block.GetCell(k).GetBounds()[2 * d + 1]) - place[d]) ** 2 for d in range(3)))
of = block.GetCellData()
moment = of.GetArray("bending_moment_N")
print("FOUND", json.dumps([moment.GetComponentName(k) for k in range(6)] + list(moment.GetTuple(cell))
                          + [of.GetArray(f"stress_{face}_Pa").GetTuple(cell)[0] for face in ("outside", "inside")]))
"""
SHARE = 1e-3  # of the weight, for linear theory
THICKNESS = 0.25  # [m], of the roof


@unittest.skipUnless(PVPYTHON, WHY)
class ParaView(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)

    def ask(self, program: str, *arguments: str) -> list:
        script = self.folder / "ask.py"
        script.write_text(program)
        done = subprocess.run([str(PVPYTHON), "--force-offscreen-rendering", str(script), str(self.folder / "out" / "frames.pvd"),
                               *arguments], text=True, check=False, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE)
        found = re.search(r"(?m)^FOUND (.*)$", done.stdout)
        assert found is not None, done.stdout + done.stderr
        answer = json.loads(found[1])
        assert isinstance(answer, list)
        return answer

    def test_the_area_at_each_time_is_that_of_the_run(self) -> None:
        run(self.folder, (TOP / "scenes" / "glass.textproto").read_text(), *CRACKED["glass"])
        found = self.ask(AREAS)
        frames = sorted((self.folder / "out" / "frames").glob("shell_*.vtp"))
        self.assertEqual(len(found), len(frames))
        self.assertGreater(len(found), 5)
        for (time, area), frame in zip(found, frames):
            told = sum(told_areas(frame))
            self.assertLess(abs(area / told - 1.0), 2e-3, time)  # as in test_fields
        surface = json.loads((self.folder / "out" / "run.json").read_text())["surface"]
        self.assertGreater(surface["torn_m2"], 5e-3 * area, "nothing is torn")
        self.assertLess(abs(found[-1][1] / (surface["now_m2"] + surface["torn_m2"]) - 1.0), 2e-3)

    def test_the_moment_at_the_crown_is_that_of_sanders_theory(self) -> None:
        """The theory is solved, and printed, by the case scordelis_lo_moment of `validate shells`."""
        told = subprocess.run([f"{BUILD}/tests/sunder-validate", "shells", "--case", "scordelis_lo_moment"], text=True,
                              check=True, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE).stdout
        crown = re.search(r"roof at  0 degrees: moment +(\S+) and +(\S+) N m/m", told)
        assert crown is not None, told
        scene = (TOP / "scenes" / "roof.textproto").read_text().replace("output {", "output {\n  fields: [BENDING_MOMENT, STRESS]")
        # its weight there is a tenth of the roof's 90 N/m^2, of 9 m/s^2
        run(self.folder, scene, f"gravity.z={-90.0 * SHARE}", "end_time_s=5e-3", *(
            f"shells[roof].cylinder.{key}" for key in ("elements_u=24", "elements_v=24", "degree=3")))
        answer = self.ask(MOMENT, "0", "0", "25")
        self.assertEqual(answer[:6], ["xx", "yy", "zz", "xy", "yz", "xz"])
        # 0.5 % between the theories, as in tests/validation; a cell's centre is a third of an element from the crown, where
        # the moment is flat
        self.assertLess(abs(answer[6] / SHARE / float(crown[2]) - 1.0), 0.01)
        # that moment bends a section of this thickness; stress is linear over it
        outside, inside = answer[12:]
        self.assertLess(abs((outside - inside) * THICKNESS ** 2 / 12.0 / SHARE / float(crown[2]) - 1.0), 0.01)


if __name__ == "__main__":
    unittest.main()
