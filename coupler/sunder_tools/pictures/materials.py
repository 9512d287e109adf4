"""Names and looks of materials in pictures and exports. Nothing here or below needs PIL: Blender's own Python has numpy alone."""
from __future__ import annotations

from ..report.appearance import FLOOR, GLASS, STEEL, Appearance, unknown
from ..report.scene_text import Words
from .thick import OTHER, SIDE_NAMES

Named = tuple[str, Appearance]  # a material and its look
OPACITY = 0.5                   # of glass, in formats that have no transmission


def slot_name(material: str, side: int) -> str:
    """The name of a material's slot: of the sides of a sheet each has its own."""
    return material if side == OTHER else f"{material}_{SIDE_NAMES[side]}"


def colour_of(look: Appearance) -> tuple[float, ...]:
    """The colour of a material with this look, and its opacity where it is glass."""
    return (*look.colour, OPACITY) if look.clear else look.colour


def material_of_shell(part: int, words: Words) -> Named:
    """Name and look of a shell's material; of a shell that the scene does not tell about, a material of its own."""
    if part >= len(words.materials):
        return f"shell_{part}", unknown(part)
    name = words.materials[part]
    known = dict(words.appearances).get(name)
    return name, known if known is not None else GLASS if words.glass[part] else unknown(words.materials.index(name))


def material_of_shards(part: int, words: Words) -> Named:
    """The same for shards of a shell; -1 where that is not known: it may be the only material that breaks."""
    if part >= 0:
        return material_of_shell(part, words)
    if len({m for m, breaks in zip(words.materials, words.breaks) if breaks}) == 1:
        return material_of_shell(words.breaks.index(True), words)
    return "shards", unknown(0)


def material_of_body(number: int, words: Words) -> Named:
    """The same for a body of the scene, by its number. Where the scene names no material it is steel, a half space a matt floor,
    with the name of the body; `_body` is added to one that a material has."""
    name = words.body_materials[number - 1] if 0 < number <= len(words.bodies) else ""
    if name:
        return name, dict(words.appearances).get(name, STEEL)
    name = name_of_body(number, words)
    look = FLOOR if name in words.half_spaces else STEEL
    taken = {slot_name(material, side) for material in (*words.materials, *words.body_materials, *dict(words.appearances))
             for side in (*SIDE_NAMES, OTHER)}
    while name in taken:
        name += "_body"
    return name, look


def name_of_body(number: int, words: Words) -> str:
    """The name of a body of the scene, by its number."""
    return words.bodies[number - 1] if 0 < number <= len(words.bodies) else f"body_{number}"
