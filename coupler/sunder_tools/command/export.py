"""`sunder export`: a run as a sequence of meshes, as one animated file, or as point caches."""
from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import BAD_INPUT, DONE, CommandError
from .parser import Subparsers, add_choice, add_command, add_run_folder, number_above_zero, positive

NAME = "export"


def add_parser(subparsers: Subparsers) -> None:
    """Arguments of `sunder export`."""
    parser = add_command(
        subparsers, NAME, "meshes for Blender and Houdini, one a frame or one animated file",
        "Writes one file per frame to DIR/export, and frame_times.csv. PLY has velocity per vertex, and fragment, damage,\n"
        "part, body, kind and side per face; the other format is binary glTF. Shells have their thickness: faces outside,\n"
        "inside and at the edge, also along cracks. With --gltf or --usd it writes one animated file instead: a node with\n"
        "keyframes for each piece (pane_piece_17) and body, from first frame to last. With --pc2 it writes a point cache\n"
        "and a mesh file (OBJ) for each of them, and a table, objects.csv.", "sunder export runs/glass --gltf glass.glb")
    add_run_folder(parser)
    add_choice(parser, "--format", ("ply", "gltf"), "default: ply", "ply")
    parser.add_argument("--frames", metavar="LIST", help="numbers such as 0,5,10-20,last, or times\nsuch as 7.5ms or 10ms-20ms (default: all)")
    parser.add_argument("--gltf", metavar="FILE", type=Path, help="one animated file, .glb")
    parser.add_argument("--usd", metavar="FILE", type=Path, help="the same as USD, .usda")
    parser.add_argument("--pc2", metavar="DIR", type=Path, help="the same as point caches and OBJ, in a folder")
    parser.add_argument("--fps", metavar="N", type=positive, help="pictures a second of the film (default: 24)")
    parser.add_argument("--speed", metavar="F", type=number_above_zero,
                        help="how fast time runs in the film, e.g. 0.1 (default: the\nrun's frames, one a picture)")
    parser.add_argument("--middle", action="store_true", help="middle surfaces of shells, without thickness; shards stay solid")
    parser.add_argument("--out", metavar="DIR", type=Path, help="another folder")


def run(arguments: argparse.Namespace) -> int:
    """Writes the files; returns the exit status. Raises CommandError."""
    whole = [(kind, target) for kind, target in (("gltf", arguments.gltf), ("usd", arguments.usd), ("pc2", arguments.pc2))
             if target is not None]
    if arguments.fps is not None and arguments.speed is None and not whole:
        raise CommandError("--fps: a file a frame has no rate; give --speed too, or --gltf FILE", BAD_INPUT)
    if whole and arguments.out is not None:
        raise CommandError(f"--{whole[0][0]}: says itself where to write; leave --out out", BAD_INPUT)
    for kind, target in whole:
        from ..pictures.one_file import export_one
        export_one(arguments.folder, kind, target, arguments.frames, arguments.fps, arguments.speed, arguments.middle)
    if whole:
        return DONE
    from ..pictures.export import export
    return export(arguments.folder, arguments.format, arguments.out, arguments.frames, arguments.fps, arguments.speed,
                  arguments.middle)
