"""The check of cracks over time: a sound history passes, and every planted fault is found."""
from __future__ import annotations

import contextlib
import io
import tempfile
import unittest
from pathlib import Path

import numpy as np

from sunder_tools.pictures.crack_lines import graph_of
from sunder_tools.pictures.vtp import VtpError, read_vtp
from tests.validation import crack_check

from .crack_history import STAGES, Edge, history, write_history
from .synthetic import write_vtp


class CrackCheck(unittest.TestCase):
    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.frames = history()

    def found(self) -> crack_check.Findings:
        write_history(self.folder, self.frames)
        return crack_check.check_folder(self.folder)

    def everywhere(self, old: Edge, new: Edge) -> None:
        """Another edge in its place, in every frame that has it."""
        self.frames = [(t, [new if e == old else e for e in edges]) for t, edges in self.frames]

    def faults(self) -> tuple[int, int, int, int, int]:
        found = self.found()
        return found.lost, found.unconnected, found.gaps, found.apart, found.doubled

    def test_a_sound_history_has_no_fault(self) -> None:
        found = self.found()
        self.assertEqual(found.faults(), 0, found.notes)
        self.assertEqual((found.frames, found.growing, found.edges, found.cracks, found.starts), (5, 4, 8, 3, 2))

    def test_an_edge_that_vanishes_is_lost(self) -> None:
        del self.frames[3][1][1]
        found = self.found()
        self.assertEqual(found.lost, 2)  # gone in one frame, and back in the next long after its birth
        self.assertIn("gone or changed", found.notes[0])

    def test_a_vertex_that_moves_by_a_bit_loses_its_edges(self) -> None:
        old, moved = (3.0, 5.4), (float(np.nextafter(3.0, 4.0)), 5.4)
        time_s, edges = self.frames[4]
        self.frames[4] = (time_s, [(moved if a == old else a, moved if b == old else b, crack, birth) for a, b, crack, birth in edges])
        self.assertEqual(self.found().lost, 6)  # three that were, three that come too late

    def test_an_edge_that_changes_hands_is_lost(self) -> None:
        time_s, edges = self.frames[4]
        self.frames[4] = (time_s, [(*e[:2], 2, e[3]) if e is edges[-2] else e for e in edges])
        self.assertGreater(self.found().lost, 0)

    def test_a_new_edge_that_hangs_on_nothing_is_found(self) -> None:
        self.frames[4][1].append(((8.0, 2.0), (9.0, 2.0), 0, 3.5))
        self.assertEqual(self.faults(), (0, 1, 0, 1, 0))
        self.frames[4][1][-1] = ((8.0, 2.0), (9.0, 2.0), 3, 3.5)  # with a number of its own it is a start
        found = self.found()
        self.assertEqual((found.faults(), found.starts), (0, 3))

    def test_a_crack_in_two_pieces_is_found(self) -> None:
        self.frames[1][1].append(((8.0, 2.0), (9.0, 2.0), 0, 0.5))
        for time_s, edges in self.frames[2:]:
            edges.append(((8.0, 2.0), (9.0, 2.0), 0, 0.5))
        self.assertEqual(self.faults(), (0, 0, 0, 1, 0))

    def test_a_gap_at_a_joint_is_found(self) -> None:
        joint = STAGES[4][1][0]
        for short in (0.04, 0.002, 1e-5):  # of a spacing
            self.setUp()
            self.everywhere(joint, (joint[0], (2.5, 5.3 + short), 1, 3.5))
            self.assertEqual(self.faults(), (0, 0, 1, 0, 0), short)
        self.setUp()
        self.everywhere(joint, (joint[0], (2.5, 5.4), 1, 3.5))  # a tip that has not arrived yet
        self.assertEqual(self.faults(), (0, 0, 0, 0, 0))

    def test_a_gap_between_two_ends_is_found(self) -> None:
        self.frames[4][1].append(((4.02, 6.02), (5.0, 6.5), 3, 3.5))
        self.assertEqual(self.faults(), (0, 0, 2, 0, 0))

    def test_an_edge_on_top_of_another_is_found(self) -> None:
        self.frames[4][1].append(((2.5, 5.298), (3.1, 5.42), 1, 3.6))  # past its joint, along what it met
        self.assertEqual(self.found().doubled, 1)
        self.frames[4][1][-1] = ((3.0, 5.4), (4.0, 5.002), 3, 3.6)  # a branch upon a branch
        self.assertEqual(self.found().doubled, 1)
        self.frames[4][1][-1] = ((3.0, 5.4), (4.0, 5.1), 3, 3.6)  # beside it
        self.assertEqual(self.found().doubled, 0)

    def test_a_short_edge_between_two_that_meet_is_not_on_top_of_them(self) -> None:
        # a crack that crosses both branches of the fork, 0.04 and less off their joint
        crossing = [((3.0, 5.2), (3.03, 5.3905), 3, 3.5), ((3.03, 5.3905), (3.045, 5.4295), 3, 3.6),
                    ((3.045, 5.4295), (3.2, 5.9), 3, 3.7)]
        self.frames[4][1].extend(crossing)
        self.assertEqual(self.faults(), (0, 0, 0, 0, 0))
        self.frames[4][1][-2:] = [((3.03, 5.3905), (3.07, 5.3725), 3, 3.6)]  # as short, along a branch
        self.assertEqual(self.found().doubled, 1)

    def test_ends_beyond_the_border_are_no_gap(self) -> None:
        self.frames[4][1].append(((-0.1, 5.02), (1.0, 5.8), 3, 3.5))
        self.assertEqual(self.faults(), (0, 0, 0, 0, 0))

    def test_cracks_of_two_shells_are_none_of_one_another(self) -> None:
        write_history(self.folder, self.frames, shells=2)
        found = crack_check.check_folder(self.folder)
        self.assertEqual(found.faults(), 0, found.notes)  # on one sheet they would run on top of each other
        self.assertEqual((found.frames, found.growing, found.edges, found.cracks, found.starts), (5, 4, 16, 6, 4))
        del self.frames[3][1][1]
        write_history(self.folder, self.frames, shells=2)
        found = crack_check.check_folder(self.folder)
        self.assertEqual(found.lost, 4)
        self.assertTrue(found.notes[0].startswith("shell 0, at ") and found.notes[-1].startswith("shell 1, at "))

    def test_lines_that_went_with_their_sheet_are_where_they_were_at_rest(self) -> None:
        move = np.array([[0.3, 0.2, 0.1], [0.4, 0.2, 0.1]])
        ends = np.array([[0.0, 0.05, 0.0], [0.01, 0.05, 0.0]])
        write_vtp(self.folder / "lines.vtp", ends + move, segments=np.array([[0, 1]]), floats="f8",
                  point_data={"parameter": ends, "displacement": move},
                  cell_data={"crack": np.zeros(1, int), "time": np.zeros(1)})
        graph = graph_of(read_vtp(self.folder / "lines.vtp"), "lines")
        np.testing.assert_allclose(graph.rest[0], ends, atol=1e-12)

    def test_a_curved_border_is_off_its_sides_by_less_than_is_allowed_for(self) -> None:
        angle = np.linspace(0.0, 1.0, 11)
        points = np.concatenate([r * np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], -1) for r in (1.0, 2.0)])
        a = np.arange(10)
        triangles = np.concatenate([np.stack([a, a + 11, a + 12], -1), np.stack([a, a + 12, a + 1], -1)])
        write_vtp(self.folder / "arc.vtp", points, triangles, floats="f8")
        sheet = read_vtp(self.folder / "arc.vtp")
        every = np.ones(len(triangles), bool)
        border, bulge = crack_check.border_of(sheet, every), crack_check.bulge_of(sheet, every)
        radius = np.linalg.norm(border, axis=2).mean(axis=1)
        straight = np.abs(radius - 1.5) < 0.1  # the two ends
        self.assertEqual(straight.sum(), 2)
        np.testing.assert_allclose(bulge[straight], 0.0, atol=1e-12)  # corners are no bend
        sagitta = radius[~straight] * (1.0 - np.cos(0.05))
        self.assertTrue((bulge[~straight] > sagitta).all() and (bulge[~straight] < 2.1 * sagitta).all())
        uneven = points.copy()
        uneven[:, :2] = np.stack([np.tile(angle ** 2, 2), np.repeat([0.0, 1.0], 11)], -1)
        write_vtp(self.folder / "strip.vtp", uneven, triangles, floats="f8")
        np.testing.assert_allclose(crack_check.bulge_of(read_vtp(self.folder / "strip.vtp"), every), 0.0, atol=1e-12)

    def test_frames_without_parameters_are_refused(self) -> None:
        write_history(self.folder, self.frames)
        write_vtp(self.folder / "frames/cracks_0.vtp", [])
        with self.assertRaisesRegex(VtpError, "no parameter, crack, time; written by"):
            crack_check.check_folder(self.folder)

    def test_as_a_command_it_prints_and_fails(self) -> None:
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            write_history(self.folder, self.frames)
            self.assertEqual(crack_check.main([str(self.folder)]), 0)
            del self.frames[3][1][1]
            write_history(self.folder, self.frames)
            self.assertEqual(crack_check.main([str(self.folder)]), 1)
            self.assertEqual(crack_check.main([str(self.folder / "none")]), 2)
            self.assertEqual(crack_check.main([]), 2)
        self.assertIn("lost 2, unconnected 0", said.getvalue())


if __name__ == "__main__":
    unittest.main()
