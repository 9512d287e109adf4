"""Names and colours of materials in exports. Nothing here or below needs PIL: Blender's own Python has numpy alone."""
from __future__ import annotations

from ..report.scene_text import Words
from .palette import GLASS, PARTS
from .thick import OTHER, SIDE_NAMES

STEEL = (0.58, 0.60, 0.63)


def slot_name(material: str, side: int) -> str:
    """The name of a material's slot: of the sides of a sheet each has its own."""
    return material if side == OTHER else f"{material}_{SIDE_NAMES[side]}"


def material_of_shell(part: int, words: Words) -> tuple[str, tuple[float, ...]]:
    """Name and colour of a shell's material; of a shell that the scene does not tell about, a material of its own."""
    if part >= len(words.materials):
        return f"shell_{part}", tuple(PARTS[part % len(PARTS)])
    name = words.materials[part]
    return name, (*GLASS, 0.5) if words.glass[part] else tuple(PARTS[words.materials.index(name) % len(PARTS)])


def material_of_shards(part: int, words: Words) -> tuple[str, tuple[float, ...]]:
    """The same for shards of a shell; -1 where that is not known: it may be the only material that breaks."""
    if part >= 0:
        return material_of_shell(part, words)
    if len({m for m, breaks in zip(words.materials, words.breaks) if breaks}) == 1:
        return material_of_shell(words.breaks.index(True), words)
    return "shards", tuple(PARTS[0])


def name_and_material_of_body(number: int, words: Words) -> tuple[str, str]:
    """Names of a body of the scene, by its number."""
    known = 0 < number <= len(words.bodies)
    return (words.bodies[number - 1], words.body_materials[number - 1] or "body") if known else (f"body_{number}", "body")
