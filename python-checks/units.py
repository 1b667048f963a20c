"""Words for units, from the dimension of a quantity and the units of length and force.

Written from docs/reference/scene.md, not from the program: a stress or an energy has a name where it is a
power of ten of Pa or J, and so do the quantities that a stress is part of.
"""

import re

METRES = {"m": 0, "mm": -3, "cm": -2, "um": -6, "nm": -9, "km": 3}
NEWTONS = {"N": 0, "kN": 3, "MN": 6, "mN": -3}
STRESS = {-3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}
ENERGY = {-9: "n", -6: "u", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


def unit_word(row: dict, length: str, force: str) -> str:
    """The unit of a dataset of the schema in a file of these units."""
    if row["unit"] in ("1", "s", "B"):
        return row["unit"]
    if root := re.fullmatch(r"\((.+)\)\^\(1/2\)", row["unit"]):
        return f"({in_units(root[1], length, force)})^(1/2)"
    return in_units(row["unit"], length, force)


def in_units(si: str, length: str, force: str) -> str:
    """An SI word with every unit in it replaced by that of these units."""
    known = length in METRES and force in NEWTONS
    stress, energy = f"{force}/{length}^2", f"{force} {length}"
    if known and (prefix := STRESS.get(NEWTONS[force] - 2 * METRES[length])) is not None:
        stress = f"{prefix}Pa"
    if known and (prefix := ENERGY.get(NEWTONS[force] + METRES[length])) is not None:
        energy = f"{prefix}J"
    if (length, force) == ("in", "lbf"):
        stress = "psi"
    if si == "J":
        return energy
    if si == "Pa" or "/" not in stress:
        words = {"Pa": stress, "m": length, "N": force}
        return re.sub(r"Pa|m|N", lambda word: words[word[0]], si)
    spelled = {"m^3/Pa": "{m}^5/{N}", "m/Pa": "{m}^3/{N}", "Pa/m^3": "{N}/{m}^5"}
    pattern = spelled.get(si) or re.sub(r"m|N", lambda word: f"{{{word[0]}}}", si)
    return pattern.format(m=length, N=force)
