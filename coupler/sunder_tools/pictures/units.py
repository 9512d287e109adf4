"""Names of quantities as labels, with units that suit their sizes: 'crack_length_m' of 0.6 is 'crack length [mm]' of 600."""
from __future__ import annotations

import math
import re
from typing import Iterable

# endings of columns, the longest first where one ends another
ENDINGS = {"m_per_s2": "m/s²", "m_per_s": "m/s", "rad_per_s": "rad/s", "kg_m2": "kg m²", "J_per_m2": "J/m²", "N_per_m": "N/m",
           "N_m": "N m", "N_s": "N s", "m2": "m²", "m3": "m³", "Pa": "Pa", "Hz": "Hz", "kg": "kg", "rad": "rad", "deg": "°", "m": "m",
           "s": "s", "N": "N", "J": "J", "W": "W"}
PREFIXED = ("m", "s", "N", "J", "Pa", "Hz", "W", "N s", "N m", "J/m²", "N/m")  # take a prefix of the first unit
PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}
LONGEST = 0  # [exponent] seconds take none above
AREAS = (("mm²", 1e6, 1e-3), ("cm²", 1e4, 1e-1))  # up to which area [m²]
WRITTEN = {"um": "µm", "us": "µs", "m^2": "m²", "m2": "m²"}
# columns of the project's own measures whose names alone do not say what they are
WORDS = {
    "energy_lost_J": "energy lost", "energy_motion_J": "energy to motion", "energy_elastic_J": "energy stored",
    "energy_fracture_J": "energy to fracture", "energy_plastic_J": "energy to yielding", "energy_faces_J": "energy to crack faces",
    "energy_contact_J": "energy to contact", "energy_damping_J": "energy to damping", "energy_frozen_J": "energy of frozen panes",
    "energy_handoff_J": "energy that rigid shards cannot carry", "energy_engine_J": "energy to the engine",
    "energy_other_J": "energy to healing and transfer", "energy_missing_J": "energy missing in the books",
    "contact_until_s": "end of contact", "pieces": "number of pieces", "pieces_off": "number of pieces that came off",
    "largest_piece_m2": "area of the largest piece", "median_piece_m2": "median area of pieces", "mean_piece_m2": "mean area of pieces",
    "radial_cracks": "number of radial cracks", "dent_in_m3": "volume dented in", "dent_out_m3": "volume dented out",
    "deepest_m": "depth of the dent", "mean_force_N": "largest mean force", "weibull_modulus": "Weibull modulus"}


def words_and_unit(name: str) -> tuple[str, str]:
    """Splits a label such as 'time [s]', or the name of a column such as 'impulse_N_s'; '' where it has no unit."""
    words, unit = _split(name)
    return WORDS.get(name, words), unit


def _split(name: str) -> tuple[str, str]:
    told = re.fullmatch(r"(.*\S)\s*\[([^\]]*)\]", name.strip())
    if told:
        return _plain(told[1]), "" if told[2] == "-" else WRITTEN.get(told[2], told[2])
    for ending, unit in ENDINGS.items():
        if name.endswith("_" + ending):
            return name[:-len(ending) - 1].replace("_", " "), unit
    return _plain(name) if " " in name else name.replace("_", " "), ""


def _plain(words: str) -> str:
    return words.replace("^2", "²").replace("^3", "³")


def scale(unit: str, values: Iterable[float]) -> tuple[float, str]:
    """Returns a factor for values of this unit, and the unit that they have then, so that the largest is 1 to 1000."""
    largest = max((abs(v) for v in values if math.isfinite(v)), default=0.0)
    if largest == 0.0:
        return 1.0, unit
    if unit == "m²":
        for small, factor, limit in AREAS:
            if largest < limit:
                return factor, small
        return 1.0, unit
    if unit == "kg":
        return (1e6, "mg") if largest < 1e-3 else (1e3, "g") if largest < 1.0 else (1.0, unit)
    if unit == "m/s":
        return (1e3, "mm/s") if largest < 0.1 else (1.0, unit)
    if unit not in PREFIXED:
        return 1.0, unit
    exponent = 3 * math.floor(math.log10(largest * (1 + 1e-12)) / 3)
    if unit == "s":
        exponent = min(exponent, LONGEST)
    exponent = min(max(exponent, min(PREFIXES)), max(PREFIXES))
    return 10.0 ** -exponent, PREFIXES[exponent] + unit


def label(words: str, unit: str) -> str:
    """Joins both."""
    return f"{words} [{unit}]" if unit else words


def valued(name: str, value: object) -> str:
    """Writes a value of a quantity: 'thickness 4 mm'."""
    words, unit = words_and_unit(name)
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        return f"{words} {value}"
    factor, unit = scale(unit, [float(value)])
    return f"{words} {value * factor:g}{' ' + unit if unit else ''}"
