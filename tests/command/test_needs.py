"""What a scene needs of the build: OpenCASCADE where it reads a CAD file."""
from __future__ import annotations

import tempfile
import unittest
from pathlib import Path
from unittest import mock

from sunder_tools.launch import needs

from . import REPOSITORY


class OfAScene(unittest.TestCase):
    def test_a_cad_message_is_found_however_it_is_written(self) -> None:
        for text in ('shells { cad { path: "a.step" } }', "shells{cad{path:'a.igs'}}", "shells { cad: < path: 'a' > }",
                     "shells { cad # the panel\n { path: 'a' } }", "# cad\nshells {\n  cad\n  {\n", 'name: "a # b" shells { cad { } }', "name: 'it\\'s' cad {"):
            self.assertTrue(needs.reads_cad(text), text)

    def test_what_only_speaks_of_it_is_none(self) -> None:
        for text in ("", "# cad { path: 'a.step' }", 'name: "cad { }"', "name: 'a \\' cad { }'", "shells { arcad { } }",
                     "shells { plate { } name: 'cad' }", "shells { nurbs { } } # then cad {"):
            self.assertFalse(needs.reads_cad(text), text)
        self.assertEqual([p.name for p in (REPOSITORY / "scenes").rglob("*.textproto") if p.parent.name != "cad" and needs.reads_cad(p.read_text())], [])

    def test_its_build_is_asked_for(self) -> None:
        with tempfile.TemporaryDirectory() as folder, mock.patch.object(needs, "ensure_built") as ensure:
            scene = Path(folder) / "scene.textproto"
            for text, cad in ((b"shells { cad { } }", True), (b"shells { plate { } }", False), (b"\xff cad {", False)):
                scene.write_bytes(text)
                needs.built_for(scene)
                ensure.assert_called_with(cad=cad)
            needs.built_for(Path(folder) / "none.textproto")
            ensure.assert_called_with(cad=False)


if __name__ == "__main__":
    unittest.main()
