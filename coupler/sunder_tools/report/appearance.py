"""What materials look like in pictures, exports and on the page: one table, by words in their names.

A scene gives mechanical properties only. So a word in a material's name decides, then its preset, then its numbers; a material
that none of them tells about gets one of a few colours, by its place in the scene.
"""
from __future__ import annotations

import re
from dataclasses import dataclass

Colour = tuple[float, float, float]  # sRGB, 0..1

GLASS_IOR = 1.52       # [-] refractive index of what light goes through
LEAST_METAL = 6500.0  # [kg/m^3], above stone and ceramics
MOST_CLOTH = 1e6      # [Pa], below rubber


@dataclass(frozen=True)
class Appearance:
    """The look of a material. Light goes through glass; a metal mirrors; cloth has fluff; paint has a coat; the rest is plain."""
    kind: str               # glass, metal, cloth, paint or plain
    colour: Colour          # of glass: what is left of white light behind a sheet
    roughness: float = 0.5  # of reflections: 0 as in a mirror, 1 matt

    @property
    def clear(self) -> bool:
        """Tells whether light goes through."""
        return self.kind == "glass"

    @property
    def metallic(self) -> float:
        """1 of a metal, whose reflections have its colour, else 0."""
        return 1.0 if self.kind == "metal" else 0.0

    @property
    def linear(self) -> Colour:
        """The colour as light."""
        return as_linear(self.colour)


GLASS = Appearance("glass", (0.56, 0.80, 0.75), 0.0)
ACRYLIC = Appearance("glass", (0.73, 0.84, 0.91), 0.05)
PAINT = Appearance("paint", (0.70, 0.20, 0.16), 0.35)
PORCELAIN = Appearance("plain", (0.94, 0.93, 0.90), 0.12)
PLASTER = Appearance("plain", (0.90, 0.87, 0.81), 0.90)
CONCRETE = Appearance("plain", (0.66, 0.65, 0.62), 0.85)
STONE = Appearance("plain", (0.74, 0.71, 0.66), 0.60)
MARBLE = Appearance("plain", (0.91, 0.90, 0.88), 0.20)
CLAY = Appearance("plain", (0.75, 0.46, 0.33), 0.80)
WOOD = Appearance("plain", (0.66, 0.48, 0.31), 0.65)
PAPER = Appearance("plain", (0.95, 0.94, 0.90), 0.90)
RUBBER = Appearance("plain", (0.36, 0.36, 0.38), 0.60)
FOAM = Appearance("plain", (0.87, 0.80, 0.58), 0.95)
PLASTIC = Appearance("plain", (0.46, 0.49, 0.53), 0.40)
FILM = Appearance("plain", (0.70, 0.78, 0.86), 0.30)
ICE = Appearance("glass", (0.82, 0.91, 0.95), 0.15)
SNOW = Appearance("plain", (0.96, 0.97, 0.98), 0.95)
LEATHER = Appearance("plain", (0.45, 0.29, 0.20), 0.55)
FLESH = Appearance("plain", (0.87, 0.68, 0.58), 0.60)
CLOTH = Appearance("cloth", (0.79, 0.44, 0.38), 0.90)
FLOOR = Appearance("plain", (0.62, 0.62, 0.61), 0.85)  # of a half space that the scene gives no material
STEEL = Appearance("metal", (0.58, 0.60, 0.63), 0.28)
IRON = Appearance("metal", (0.46, 0.46, 0.47), 0.45)
ALUMINIUM = Appearance("metal", (0.78, 0.79, 0.81), 0.25)
COPPER = Appearance("metal", (0.83, 0.52, 0.38), 0.25)
BRASS = Appearance("metal", (0.81, 0.67, 0.36), 0.22)
BRONZE = Appearance("metal", (0.66, 0.48, 0.28), 0.30)
GOLD = Appearance("metal", (0.90, 0.73, 0.33), 0.18)
LEAD = Appearance("metal", (0.40, 0.41, 0.45), 0.50)
TITANIUM = Appearance("metal", (0.60, 0.57, 0.54), 0.35)

# The first row counts that has a word with which a part of the name begins or ends: 'painted_steel' is paint, 'WindowGlass' glass.
# Words of WHOLE are parts of their own: 'lead_foil' is lead, 'leading_edge' is not. Of words with '_' all parts follow each other.
NAMED: tuple[tuple[Appearance, tuple[str, ...]], ...] = (
    (FOAM, ("glass_wool", "rock_wool", "mineral_wool")),
    (PLASTIC, ("glass_fibre", "glass_fiber")),
    (GLASS, ("painted_glass",)),
    (PAINT, ("paint", "lacquer", "enamel", "bodywork")),
    (PLASTIC, ("fibreglass", "fiberglass", "fibre_glass", "fiber_glass", "carbon_fibre", "carbon_fiber", "epoxy")),
    (ACRYLIC, ("acrylic", "perspex", "plexiglas", "pmma", "polycarbonate")),
    (GLASS, ("glass",)),
    (PORCELAIN, ("porcelain", "china", "ceramic", "stoneware")),
    (PLASTER, ("plaster", "gypsum", "chalk", "stucco")),
    (MARBLE, ("marble", "alabaster")),
    (CONCRETE, ("concrete", "cement", "mortar")),
    (CLAY, ("clay", "terracotta", "brick", "pottery")),
    (WOOD, ("wood", "timber", "bark", "oak", "pine", "spruce", "bamboo", "cork")),
    (PAPER, ("paper", "cardboard")),
    (RUBBER, ("rubber", "latex", "silicone", "neoprene")),
    (FOAM, ("foam", "sponge")),
    (LEATHER, ("leather",)),
    (CLOTH, ("cloth", "fabric", "silk", "cotton", "linen", "wool", "denim", "canvas", "textile")),
    (ALUMINIUM, ("alumin", "tinplate", "chrome", "silver")),
    (COPPER, ("copper",)), (BRASS, ("brass",)), (BRONZE, ("bronze",)), (GOLD, ("gold", "golden")), (LEAD, ("lead",)),
    (TITANIUM, ("titanium",)), (IRON, ("iron",)), (STEEL, ("steel", "metal")),
    (PLASTIC, ("plastic", "polymer", "nylon", "abs", "pvc")),
    (FILM, ("film", "foil", "membrane")),
    (STONE, ("stone", "rock", "granite", "slate", "basalt")),
    (ICE, ("ice",)), (SNOW, ("snow",)), (FLESH, ("skin", "flesh", "tissue")),
)
WHOLE = frozenset(("abs", "bark", "cement", "china", "clay", "cork", "film", "foil", "gold", "ice", "iron", "lead", "oak", "pine",
                   "pmma", "pvc", "rock", "skin", "slate"))
PRESETS = {"SODA_LIME_GLASS": GLASS, "ACRYLIC": ACRYLIC}
# Of what nothing is known about: muted and of similar lightness, so that shading shows the shape.
UNKNOWN: tuple[Colour, ...] = (
    (0.64, 0.70, 0.77), (0.73, 0.57, 0.50), (0.62, 0.68, 0.60), (0.76, 0.70, 0.59), (0.56, 0.62, 0.70), (0.66, 0.57, 0.63),
    (0.70, 0.61, 0.54), (0.71, 0.64, 0.58), (0.58, 0.64, 0.61), (0.61, 0.66, 0.64), (0.65, 0.67, 0.72), (0.68, 0.69, 0.73))


def appearance_of(name: str, preset: str, density: float, youngs_modulus: float, yields: bool, number: int) -> Appearance:
    """Returns the look of a material with this name and preset ('' without), density [kg/m^3], Young's modulus [Pa] (NaN where not
    given), with or without a yield stress, and its number in the scene."""
    parts = re.findall("[a-z]+", re.sub("(?<=[a-z])(?=[A-Z])", "_", name).lower())
    found = next((look for look, words in NAMED if any(_says(parts, word) for word in words)), PRESETS.get(preset))
    if found is not None:
        return found
    if yields or density >= LEAST_METAL:
        return STEEL
    if youngs_modulus <= MOST_CLOTH:
        return CLOTH
    return unknown(number)


def _says(parts: list[str], word: str) -> bool:
    """Tells whether a word of NAMED is in a name with these parts."""
    if word in WHOLE:
        return word in parts
    if "_" in word:
        return f"_{word}_" in f"_{'_'.join(parts)}_"
    return any(part.startswith(word) or part.endswith(word) for part in parts)


def unknown(number: int) -> Appearance:
    """Returns the look of the material with this number about which nothing is known."""
    return Appearance("plain", UNKNOWN[number % len(UNKNOWN)], 0.45)


def as_linear(colour: Colour) -> Colour:
    """Returns the same as light, not as it is stored."""
    red, green, blue = (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour)
    return red, green, blue
