"""`run --profile` and `bench --profile`: what is read, told, drawn and refused."""
from __future__ import annotations

import contextlib
import io
import json
import os
import tempfile
import unittest
from pathlib import Path
from typing import Any
from unittest import mock

from sunder_tools.errors import CommandError
from sunder_tools.pictures import plots, roofline
from sunder_tools.places import BUILD_DIR_VARIABLE
from sunder_tools.report.profile import read_profile, table

from . import sunder
from .fakes import write_executables

FORCE = {"stage": "internal_force", "seconds": 3.0, "passes": 1000.0, "bytes": 2e6, "operations": 6e6, "memory_gb_per_s": 20.0,
         "memory_s": 0.1, "operations_s": 0.15, "limit": "operations", "times_limit": 20.0}
PROFILE: dict[str, Any] = {"schema": 1, "threads": 2, "substeps": 990.0, "fma_peak_gflops": 40.0,
                           "stages": [{"stage": "coupling", "seconds": 1.0}, FORCE]}
NUMBERS = {"operations_per_layer_point": 160.0, "bytes_per_layer_point": 20.0, "fma_peak_gflops": 58.0, "memory_gb_per_s": 20.0,
           "force_ns_per_layer_point": 8.0, "force_ns_per_layer_point_10k": 7.5, "force_ns_per_layer_point_160k": 8.0}


class Profiles(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.said = io.StringIO()
        write_executables(self.folder / "build")
        for context in (contextlib.redirect_stderr(self.said), contextlib.redirect_stdout(io.StringIO())):
            context.__enter__()
            self.addCleanup(context.__exit__, None, None, None)

    def write(self, profile: dict[str, Any]) -> None:
        (self.folder / "profile.json").write_text(json.dumps(profile))

    def program(self, name: str, body: str) -> None:
        path = self.folder / "build" / "tests" / name
        path.parent.mkdir(exist_ok=True, parents=True)
        path.write_text(f"#!/usr/bin/python3\nimport sys\n{body}\n")
        path.chmod(0o755)

    def test_the_table_has_the_longest_stage_first_and_what_a_pass_does(self) -> None:
        self.write(PROFILE)
        profile = read_profile(self.folder)
        assert profile is not None
        lines = table(profile).splitlines()
        self.assertEqual([line.split()[0] for line in lines[1:3]], ["internal_force", "coupling"])
        self.assertEqual(lines[1].split(), ["internal_force", "3.000", "75%", "3000.0", "2000.0", "6000.0", "20.0", "times", "that",
                                            "of", "operations"])
        self.assertEqual(lines[2].split(), ["coupling", "1.000", "25%"])
        self.assertIn("40.0 GFLOP/s, memory 20.0 GB/s (internal_force); 2 threads, 990 substeps", lines[3])

    def test_a_missing_or_damaged_profile_is_none(self) -> None:
        self.assertIsNone(read_profile(self.folder))
        for text in ("{", "[]", '{"threads": 1}', json.dumps({**PROFILE, "stages": [{"seconds": 1.0}]})):
            (self.folder / "profile.json").write_text(text)
            self.assertIsNone(read_profile(self.folder), text)
        with self.assertRaisesRegex(CommandError, "run the scene with --profile"):
            roofline.write_profile(self.folder)

    def test_rates_stand_under_the_roof_of_their_memory(self) -> None:
        with mock.patch.object(roofline, "write_panels") as drawn:
            self.write(PROFILE)
            self.assertEqual(roofline.write_profile(self.folder), self.folder / "profile.png")
        roofs, times = drawn.call_args.args[0]
        roof, rate = roofs.lines
        self.assertEqual((rate.name, rate.x, rate.y), ("internal_force", [3.0], [2.0]))
        self.assertEqual(roof.x[1:2] + roof.y[1:], [2.0, 40.0, 40.0])  # the bend: 40 GFLOP/s over 20 GB/s
        self.assertEqual(roof.y[0], 20.0 * roof.x[0])
        self.assertEqual([line.name for line in times.lines], ["internal_force", "coupling"])
        self.write({**PROFILE, "stages": PROFILE["stages"][:1]})
        with self.assertRaisesRegex(CommandError, "no stage has a model"):
            roofline.write_profile(self.folder)

    def test_it_is_drawn(self) -> None:
        if not plots.there():
            self.skipTest("there is no matplotlib")
        self.write(PROFILE)
        self.assertTrue(roofline.write_profile(self.folder).read_bytes().startswith(b"\x89PNG"))

    def test_a_picture_that_cannot_be_drawn_is_refused_before_the_run(self) -> None:
        scene = self.folder / "scene.textproto"
        scene.write_text("end_time_s: 1\n")
        with mock.patch.dict(os.environ, {BUILD_DIR_VARIABLE: str(self.folder / "build")}), \
                mock.patch.object(plots, "there", return_value=False):
            self.assertEqual(sunder(["run", str(scene), "--profile", "--out", str(self.folder / "run")]), 2)
        self.assertIn("--profile: there is no matplotlib", self.said.getvalue())
        self.assertIn("or leave the picture out with --no-pictures", self.said.getvalue())
        self.assertFalse((self.folder / "run").exists())

    def test_benchmarks_are_drawn_and_refused(self) -> None:
        with mock.patch.dict(os.environ, {BUILD_DIR_VARIABLE: str(self.folder / "build")}):
            self.program("sunder-bench", "out = sys.argv[sys.argv.index('--json') + 1]\n"
                         f"open(out, 'w').write({json.dumps(json.dumps(NUMBERS))})")
            if plots.there():
                self.assertEqual(sunder(["bench", "--profile", str(self.folder / "kernels.svg")]), 0)
                self.assertIn("force, 160k", (self.folder / "kernels.svg").read_text())
            for arguments, words in ((["--profile", "x.cheese"], "'.cheese' is none of .png, .svg, .pdf"),
                                     (["--profile", "x.png", "--filter", "fma"], "leave --filter out")):
                self.assertEqual(sunder(["bench", *arguments]), 2)
                self.assertIn(words, self.said.getvalue())


if __name__ == "__main__":
    unittest.main()
