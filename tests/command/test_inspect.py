"""`sunder inspect`: its table, the scene that it writes, and what it refuses."""
from __future__ import annotations

import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path
from typing import Any

from sunder_tools.command.inspect import checked, report, write_scene
from sunder_tools.errors import BAD_INPUT, DONE, CommandError
from sunder_tools.words import own_command

from . import REPOSITORY

BUILD = Path(os.environ.get("SUNDER_BUILD_DIR") or REPOSITORY / "build" / "release").absolute()
SHELL = BUILD / "shell" / "sunder-shell"
CACHE = BUILD / "CMakeCache.txt"
HAS_CAD = CACHE.is_file() and re.search(r"^SUNDER_CAD:BOOL=ON$", CACHE.read_text(), re.M) is not None
# A sphere of 25 mm: one face, divided into six shells with a pole each.
SPHERE = """ISO-10303-21;
HEADER;
FILE_DESCRIPTION(('sphere'),'2;1');
FILE_NAME('sphere','2026-01-01T00:00:00',(''),(''),'','','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));
ENDSEC;
DATA;
#1 = APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#2);
#2 = APPLICATION_CONTEXT('core data for automotive mechanical design processes');
#3 = SHAPE_DEFINITION_REPRESENTATION(#4,#10);
#4 = PRODUCT_DEFINITION_SHAPE('','',#5);
#5 = PRODUCT_DEFINITION('design','',#6,#9);
#6 = PRODUCT_DEFINITION_FORMATION('','',#7);
#7 = PRODUCT('sphere','sphere','',(#8));
#8 = PRODUCT_CONTEXT('',#2,'mechanical');
#9 = PRODUCT_DEFINITION_CONTEXT('part definition',#2,'design');
#10 = ADVANCED_BREP_SHAPE_REPRESENTATION('',(#11,#15),#27);
#11 = AXIS2_PLACEMENT_3D('',#12,#13,#14);
#12 = CARTESIAN_POINT('',(0.,0.,0.));
#13 = DIRECTION('',(0.,0.,1.));
#14 = DIRECTION('',(1.,0.,0.));
#15 = MANIFOLD_SOLID_BREP('',#16);
#16 = CLOSED_SHELL('',(#17));
#17 = ADVANCED_FACE('',(#18),#22,.T.);
#18 = FACE_BOUND('',#19,.T.);
#19 = VERTEX_LOOP('',#20);
#20 = VERTEX_POINT('',#21);
#21 = CARTESIAN_POINT('',(0.,0.,-25.));
#22 = SPHERICAL_SURFACE('',#11,25.);
#27 = ( GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#31))
GLOBAL_UNIT_ASSIGNED_CONTEXT((#28,#29,#30)) REPRESENTATION_CONTEXT('','3D') );
#28 = ( LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.) );
#29 = ( NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.) );
#30 = ( NAMED_UNIT(*) SI_UNIT($,.STERADIAN.) SOLID_ANGLE_UNIT() );
#31 = UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.E-07),#28,'distance_accuracy_value','');
ENDSEC;
END-ISO-10303-21;
"""

TOLD: dict[str, Any] = {
    "file": "part.step", "unit": "millimetre", "unit_m": None, "low_m": [0.0, 0.0, -0.002], "size_m": [0.03, 0.02, 0.004],
    "element_m": 0.001, "thickness_m": 0.0002, "taken": [0, 1],
    "faces": [
        {"face": 0, "kind": "plane", "degree": 2, "width_m": [0.03, 0.02], "area_m2": 5.2e-4, "approximated_m": 2e-8, "parts": 3, "parts_trimmed": 0,
         "holes": 1, "elements": [30, 20], "area_of_shells_m2": 5.2e-4, "shortest_element_m": 0.001, "refused": None,
         "stable_step_s": 1.9e-7, "unfit": False, "warning": None, "shells": ["part.1", "part.2", "part.3"]},
        {"face": 1, "kind": "plane", "degree": 2, "width_m": [0.02, 0.004], "area_m2": 8e-5, "approximated_m": 0.0, "parts": 1, "parts_trimmed": 1,
         "holes": 0, "elements": [20, 4], "area_of_shells_m2": 8e-5, "shortest_element_m": 2e-5, "refused": None,
         "stable_step_s": 2e-9, "unfit": False, "warning": "an element is 2e-05 m long", "shells": ["part.4"]},
        {"face": 2, "kind": "cylinder", "refused": "face 2 closes on itself along u; split it in the CAD program"}],
    "bodies": [{"name": "lid", "faces": [0, 1]}], "layers": [],
    "edges": {"shared": 5, "free": 1, "of_three_faces_or_more": 0, "widest_tolerance_m": 1e-10, "list": []},
    "seams": {"joined": 1, "smooth": 0, "along_trims": 1}, "seams_refused": None}


def octahedron(parts: int, radius: float) -> tuple[list[tuple[float, ...]], list[tuple[int, int, int]]]:
    """Points on a sphere, and triangles between them."""
    number: dict[tuple[int, ...], int] = {}
    faces = []
    for sign in ((x, y, z) for x in (1, -1) for y in (1, -1) for z in (1, -1)):
        def at(i: int, j: int, sign: tuple[int, ...] = sign) -> int:
            return number.setdefault((sign[0] * i, sign[1] * j, sign[2] * (parts - i - j)), len(number))
        for i in range(parts):
            for j in range(parts - i):
                faces.append((at(i, j), at(i + 1, j), at(i, j + 1)))
                if i + j + 1 < parts:
                    faces.append((at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)))
    points = [tuple(radius * c / sum(d * d for d in key) ** 0.5 for c in key) for key in number]
    return points, faces


class Inspect(unittest.TestCase):
    """The text and the scene, of what sunder-shell says."""

    def test_the_table_has_each_face_with_its_trims_or_its_refusal(self) -> None:
        text = report(TOLD)
        self.assertIn("bodies: 'lid' (2 faces)", text)
        self.assertIn("part.step: 3 faces, 0.03 x 0.02 x 0.004 m, unit millimetre, elements of 0.001 m", text)
        lines = text.splitlines()
        self.assertRegex(lines[2], r"^ +0  plane .* 30 x 20 +1.9e-07  part.1 to part.3 +1 hole, in 3 parts, approximated to 2e-08 m$")
        self.assertRegex(lines[3], r"^ +1  plane .* 20 x 4 +2e-09  part.4 +border$")
        self.assertRegex(lines[4], r"^ +2  cylinder +refused: face 2 closes on itself")
        self.assertEqual(lines[5], "face 1 is slow: an element is 2e-05 m long")
        self.assertIn("edges: 5 shared, 1 free, 0 of three faces or more; the widest tolerance is 1e-10 m", text)
        self.assertIn("seams: 1 joined, 0 of them smooth, 1 along trims", text)

    def test_seams_that_are_refused_are_told(self) -> None:
        self.assertIn("seams refused: faces 0 and 1 share an edge", report({**TOLD, "seams": None,
                                                                            "seams_refused": "faces 0 and 1 share an edge"}))

    def test_the_scene_has_the_faces_that_can_be_taken(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file, scene = Path(folder) / "cad" / "part.step", Path(folder) / "My part.textproto"
            write_scene(scene, file, TOLD)
            text = scene.read_text()
            self.assertIn('name: "my_part"', text)
            self.assertIn('cad { path: "cad/part.step" faces: 0 faces: 1 element_m: 0.001 }', text)
            self.assertIn("position { z: -0.0022 }", text)
            with self.assertRaisesRegex(CommandError, "exists; give another name") as caught:
                write_scene(scene, file, TOLD)
            self.assertEqual(caught.exception.status, BAD_INPUT)

    def test_a_face_that_is_unfit_is_told_and_left_out(self) -> None:
        unfit = {**TOLD["faces"][1], "unfit": True, "shells": []}
        told = {**TOLD, "faces": [TOLD["faces"][0], unfit], "taken": [0]}
        self.assertIn("face 1 is unfit: an element is 2e-05 m long\n", report(told))
        with tempfile.TemporaryDirectory() as folder:
            write_scene(Path(folder) / "a.textproto", Path(folder) / "part.step", told)
            self.assertIn("faces: 0 element_m", (Path(folder) / "a.textproto").read_text())

    def test_all_faces_need_no_list(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            scene = Path(folder) / "a.textproto"
            write_scene(scene, Path(folder) / "part.step", {**TOLD, "faces": TOLD["faces"][:2], "taken": [0, 1]})
            self.assertNotIn("faces:", scene.read_text())

    def test_the_scene_has_the_unit_that_is_given(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            scene = Path(folder) / "a.textproto"
            write_scene(scene, Path(folder) / "part.step", {**TOLD, "faces": TOLD["faces"][:2], "unit_m": 0.0254})
            self.assertIn("# All faces of part.step", scene.read_text())
            self.assertIn('cad { path: "part.step" unit_m: 0.0254 element_m: 0.001 }', scene.read_text())

    def test_a_scene_that_is_not_beside_the_file_is_refused(self) -> None:
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as other:
            with self.assertRaisesRegex(CommandError, "is not beside"):
                write_scene(Path(other) / "a.textproto", Path(folder) / "part.step", TOLD)
            with self.assertRaisesRegex(CommandError, "no face of .* can be taken"):
                write_scene(Path(folder) / "a.textproto", Path(folder) / "part.step", {**TOLD, "faces": TOLD["faces"][2:], "taken": []})


class Programs(unittest.TestCase):
    """Real runs of `sunder inspect` and of the solver that it asks."""

    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def inspect(self, *words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run([str(REPOSITORY / "coupler" / "sunder"), "inspect", *words], cwd=self.folder, text=True, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, env={**os.environ, "SUNDER_BUILD_DIR": str(BUILD)})

    def test_a_broken_file_is_named_and_no_scene(self) -> None:
        (self.folder / "broken.step").write_text("ISO-10303-21;\n")
        done = self.inspect("broken.step", "--scene", "a.textproto")
        self.assertEqual(done.returncode, BAD_INPUT, done.stderr)
        self.assertRegex(done.stderr, r"bad_input: broken.step: (is no STEP file that can be read|this build has no OpenCASCADE)")
        self.assertNotIn("inspect.textproto", done.stderr)
        self.assertFalse((self.folder / "a.textproto").exists())

    def test_an_element_is_positive_and_finite(self) -> None:
        for element in ("0", "-1", "inf", "nan"):
            done = subprocess.run([str(SHELL), "inspect", "a.step", f"--element={element}"], cwd=self.folder, text=True, check=False,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, BAD_INPUT, done.stderr)
            self.assertIn("must be positive and finite [m]; leave it out", done.stderr)

    def test_a_scene_that_is_written_is_checked(self) -> None:
        scene = self.folder / "a.textproto"
        scene.write_text('name: "a" end_time_s: 0.02 window_s: 1e-4 '
                         'materials { name: "steel" density: 7800 youngs_modulus: 2e11 poisson_ratio: 0.3 } '
                         'shells { name: "part" material: "steel" thickness_m: 4e-4 '
                         'plate { size_x_m: 0.02 size_y_m: 0.02 elements_x: 10 elements_y: 10 } }')
        self.assertRegex(checked(SHELL, scene), r"^  substeps +at most \d+, .*\n  time ")
        scene.write_text(scene.read_text().replace("1e-4", "1e-9"))
        with self.assertRaisesRegex(CommandError, "is written, but 'sunder check' refuses it; .*window_s: is 1e-09 s, shorter"
                                    " than the stable step") as caught:
            checked(SHELL, scene)
        self.assertEqual(caught.exception.status, BAD_INPUT)

    def test_the_scene_of_a_mesh_passes_the_check(self) -> None:
        # an octahedron's faces, half of them mirrored, divided and moved onto a sphere of 5 cm
        corners, faces = octahedron(8, 0.05)
        (self.folder / "ball.obj").write_text("".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in corners) +
                                              "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces))
        done = self.inspect("ball.obj", "--element", "0.008", "--scene", "ball.textproto")
        self.assertEqual(done.returncode, DONE, done.stderr)
        self.assertIn(f"ball.obj: {len(faces)} faces, {len(faces)} triangles, {len(corners)} points, 0.1 x 0.1 x 0.1 m", done.stdout)
        self.assertIn(f"1 component, 0 borders of 0 edges, 0 points merged, {len(faces) // 2} triangles turned over", done.stdout)
        self.assertRegex(done.stdout, r"(?m)^part\.2 .* border$")
        self.assertIn("seams: 1 joined, 1 of them smooth", done.stdout)
        self.assertIn(f"ball.textproto is written, and passes {own_command('check', 'ball.textproto')}\n  substeps ", done.stdout)
        self.assertIn('mesh { path: "ball.obj" element_m: 0.008 }', (self.folder / "ball.textproto").read_text())

    def test_a_mesh_in_millimetres_is_taken_by_its_unit(self) -> None:
        corners, faces = octahedron(8, 50.0)
        (self.folder / "ball.obj").write_text("".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in corners) +
                                              "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in faces))
        done = self.inspect("ball.obj", "--unit", "0.001", "--weld", "1e-6", "--element", "0.008", "--scene", "ball.textproto")
        self.assertEqual(done.returncode, DONE, done.stderr)
        self.assertIn("0.1 x 0.1 x 0.1 m where its unit is 0.001 m", done.stdout)
        self.assertIn(f"ball.textproto is written, and passes {own_command('check')}", done.stdout)
        self.assertIn('mesh { path: "ball.obj" unit_m: 0.001 weld_m: 1e-06 element_m: 0.008 }', (self.folder / "ball.textproto").read_text())
        (self.folder / "part.step").write_text("ISO-10303-21;\n")
        done = self.inspect("part.step", "--weld", "0.001")
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertIn("--weld: is for mesh files", done.stderr)

    def test_a_mesh_that_is_refused_is_told_and_has_no_scene(self) -> None:
        (self.folder / "a.off").write_text("OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")
        done = self.inspect("a.off", "--element", "5", "--scene", "a.textproto")
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertIn("refused: element_m is 5 m, and 1 of 1 parts", done.stdout)
        self.assertIn("so there is no scene to write", done.stderr)
        self.assertFalse((self.folder / "a.textproto").exists())
        (self.folder / "b.off").write_text("OFF\n4 1 0\n0 0 0\n")
        done = self.inspect("b.off")
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertRegex(done.stderr, r"bad_input: b\.off: ")
        self.assertNotIn("inspect.textproto", done.stderr)

    def test_check_tells_of_divisions_by_the_ratio_of_the_scene_and_only_where_tips_run(self) -> None:
        told = {}
        for mode in ("mode: CUTS", "branch_ratio: 3", "branch_ratio: 6"):
            (self.folder / "pane.textproto").write_text(f"""name: "pane" end_time_s: 1e-3 window_s: 2e-5
                materials {{ name: "glass" preset: SODA_LIME_GLASS strength: 120e6 }}
                shells {{ name: "pane" material: "glass" thickness_m: 0.003
                  plate {{ size_x_m: 0.2 size_y_m: 0.2 elements_x: 12 elements_y: 12 }} }}
                fracture {{ seed: 1 {mode} }}""")
            done = subprocess.run([str(SHELL), "--scene", str(self.folder / "pane.textproto"), "--check"], text=True, check=False,
                                  stdin=subprocess.DEVNULL, capture_output=True)
            self.assertEqual(done.returncode, DONE, done.stderr)
            told[mode] = [float(length) for length in re.findall(r"(?m)^division .* once it is (\S+) m long", done.stdout)]
        self.assertEqual(told.pop("mode: CUTS"), [])
        (short,), (long,) = told.values()
        self.assertAlmostEqual(long / short, 4.0, delta=0.02)  # the energy release goes with its square; three digits are told

    @unittest.skipUnless(HAS_CAD, f"{BUILD} is without OpenCASCADE")
    def test_the_first_cad_file_compiles_only_what_reads_it(self) -> None:
        rules = re.split(r"^build ", (BUILD / "build.ninja").read_text(), flags=re.M)
        of_shell = [rule for rule in rules if rule.startswith("shell/CMakeFiles/sunder_shell.dir/")]
        self.assertGreater(len(of_shell), 20)
        concerned = {Path(rule.split(":")[0]).stem for rule in of_shell if "opencascade" in rule}
        self.assertEqual(concerned, {"cad_crossings.cpp", "cad_face.cpp", "cad_file.cpp", "cad_names.cpp"})

    @unittest.skipUnless(HAS_CAD, f"{BUILD} is without OpenCASCADE")
    def test_the_scene_of_a_sphere_passes_the_check(self) -> None:
        (self.folder / "ball.step").write_text(SPHERE)
        done = self.inspect("ball.step", "--element", "0.006", "--scene", "ball.textproto")
        self.assertEqual(done.returncode, DONE, done.stderr)
        self.assertRegex(done.stdout, r"(?m)^ +0  sphere .* part\.1 to part\.6 +in 6 parts$")
        self.assertIn("face 0 is slow: an element is ", done.stdout)
        self.assertIn(f"ball.textproto is written, and passes {own_command('check', 'ball.textproto')}\n  substeps ", done.stdout)
        self.assertIn("probes", self.check_with('output { probes { name: "p" shell: "part" } }'))
        self.assertEqual(self.check_with('output { probes { name: "p" shell: "part.6" } }'), "")

    @unittest.skipUnless(HAS_CAD, f"{BUILD} is without OpenCASCADE")
    def test_a_file_without_a_unit_needs_one(self) -> None:
        (self.folder / "ball.step").write_text(SPHERE.replace("((#28,#29,#30))", "((#29,#30))"))
        done = self.inspect("ball.step", "--element", "0.006")
        self.assertEqual(done.returncode, BAD_INPUT, done.stdout)
        self.assertIn("ball.step: --unit is missing, and 'ball.step' says no unit of length; give 0.001 for millimetres", done.stderr)
        done = self.inspect("ball.step", "--element", "0.06", "--unit", "0.01", "--scene", "ball.textproto")
        self.assertEqual(done.returncode, DONE, done.stderr)
        self.assertIn("1 face, 0.5 x 0.5 x 0.5 m, unit 0.01 m,", done.stdout)
        self.assertIn('cad { path: "ball.step" unit_m: 0.01 element_m: 0.06 }', (self.folder / "ball.textproto").read_text())
        (self.folder / "known.step").write_text(SPHERE)
        done = self.inspect("known.step", "--unit", "0.001")
        self.assertEqual(done.returncode, BAD_INPUT)
        self.assertIn("known.step: --unit is 0.001 m, and 'known.step' says its unit, millimetre; leave it out", done.stderr)

    def check_with(self, more: str) -> str:
        """What is refused of the sphere's scene with more in it."""
        scene = self.folder / "more.textproto"
        scene.write_text((self.folder / "ball.textproto").read_text() + more)
        try:
            checked(SHELL, scene)
        except CommandError as error:
            return str(error)
        return ""


if __name__ == "__main__":
    unittest.main()
