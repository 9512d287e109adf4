"""`sunder export`: a run as a sequence of meshes."""
from __future__ import annotations

import argparse
from pathlib import Path

from .parser import Subparsers, add_choice, add_command, add_run_folder

NAME = "export"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder export`."""
    parser = add_command(
        subparsers, NAME, "a sequence of meshes for Blender and Houdini",
        "Writes one file per frame to DIR/export, and frame_times.csv. PLY has velocity per vertex, and fragment, damage,\n"
        "part, body, kind and side per face; the other format is binary glTF. Shells have their thickness: faces outside,\n"
        "inside and at the edge, also along cracks.")
    add_run_folder(parser)
    add_choice(parser, "--format", ("ply", "gltf"), "default: ply", "ply")
    parser.add_argument("--frames", metavar="LIST", help="numbers such as 0,5,10-20,last (default: all)")
    parser.add_argument("--middle", action="store_true", help="middle surfaces of shells, without thickness")
    parser.add_argument("--out", metavar="DIR", type=Path, help="another folder")


def run(arguments: argparse.Namespace) -> int:
    """Writes the files; returns the exit status. Raises CommandError."""
    from ..pictures.export import export
    return export(arguments.folder, arguments.format, arguments.out, arguments.frames, arguments.middle)
