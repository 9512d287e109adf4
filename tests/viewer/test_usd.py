"""A USD file of a run as another program opens it: three.js under Node.js, which shares no code with the writer."""
from __future__ import annotations

import json
import shutil
import subprocess
import unittest
from pathlib import Path
from typing import Any

import numpy as np

from sunder_tools.pictures.view import packages
from tests.command.test_render import OfARun
from tests.command.usda_file import Usda

LOADER = Path("three") / "examples" / "jsm" / "loaders" / "USDLoader.js"
SCRIPT = Path(__file__).parent / "usd_by_three.mjs"
SINGLE = 2e-6  # [m], of scenes of a metre
PATIENCE_S = 1800.0


def by_three(node: str, file: Path, codes: list[float]) -> list[dict[str, Any]]:
    """Meshes of the file: what they hang under, triangles a material, corners in the world at each time code."""
    done = subprocess.run([node, str(SCRIPT), str(packages() / LOADER), str(file), *map(str, codes)], capture_output=True, text=True,
                          timeout=PATIENCE_S)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    found: list[dict[str, Any]] = json.loads(done.stdout)
    return found


class InThree(OfARun):
    def setUp(self) -> None:
        super().setUp()
        node = shutil.which("node")
        if node is None:
            raise unittest.SkipTest("no Node.js; as root: apt-get install nodejs")
        if not (packages() / LOADER).is_file():
            raise unittest.SkipTest("no three.js; 'sunder view' or 'sunder test' installs it")
        self.node, self.file = node, self.folder / "run.usda"

    def test_it_has_the_shapes_their_places_and_their_materials(self) -> None:
        status, said = self.sunder("export", "--usd", str(self.file), "--speed", "1", "--fps", "24")
        self.assertEqual(status, 0, said)
        stage = Usda(self.file.read_text())
        codes = [float(code) for code in np.linspace(0.0, stage.meta["endTimeCode"], 7)]
        meshes = by_three(self.node, self.file, codes)
        paths = {(p.split("/")[-2], p.split("/")[-1]): p for p, prim in stage.prims.items() if prim.kind == "Mesh"}
        self.assertEqual({(m["thing"], m["name"]) for m in meshes}, set(paths))
        moved = 0
        for mesh in meshes:
            path = paths[mesh["thing"], mesh["name"]]
            subsets = [p for q, p in stage.prims.items() if p.kind == "GeomSubset" and q.startswith(path + "/")]
            self.assertEqual(sorted(mesh["counts"]), sorted(len(p.values["indices"]) for p in subsets), path)
            self.assertEqual(mesh["uv"], "primvars:st" in stage.prims[path].values, path)
            for subset in subsets:
                shader = stage.prims[subset.values["material:binding"] + "/preview"].values
                near = [np.abs(np.subtract(colour, shader["inputs:diffuseColor"])).max() for colour in mesh["colours"]]
                self.assertLess(min(near), 1e-3, path)
                self.assertIn(shader["inputs:opacity"], mesh["opacities"], path)
            if isinstance(stage.prims[path].values["points"], dict):
                continue  # three.js takes the first sample of points
            thing = path.rsplit("/", 1)[0]
            for code in codes:
                if stage.at(path, "visibility", code) == "invisible" or any(
                        stage.at(p, "visibility", code) != "invisible" for p in paths.values() if p != path and p.startswith(thing + "/")):
                    continue
                here = np.array(mesh["at"][str(code)]).reshape(-1, 3, 3).mean(axis=1)
                wanted = np.concatenate(list(stage.seen(thing, code).values())).mean(axis=1)
                np.testing.assert_allclose(np.sort(here, axis=0), np.sort(wanted, axis=0), atol=SINGLE, err_msg=f"{path} at {code}")
                moved += 1
        self.assertGreater(moved, 6)


if __name__ == "__main__":
    unittest.main()
