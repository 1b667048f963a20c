"""Surfaces of element faces in input files of Abaqus and CalculiX, which meshio leaves out."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

#: Corners of the face S1, S2, … of each kind of cell.
FACES = {
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
}
SHELLS = ("triangle", "quad")


def surfaces(source: Path, mesh: Any) -> Iterator[tuple[str, list[np.ndarray]]]:
    """The name of each ``*SURFACE`` and its sides, by their corners."""
    numbers: list[int] = []
    found: dict[str, list[tuple[str, str]]] = {}
    for keyword, options, data in _blocks(source):
        if keyword == "ELEMENT":
            numbers += [int(line.split(",")[0]) for line in _whole(data)]
        elif keyword == "SURFACE" and options.get("TYPE", "ELEMENT").upper() == "ELEMENT" and "NAME" in options:
            pairs = [[part.strip() for part in line.split(",")] for line in data]
            found.setdefault(options["NAME"], []).extend((pair[0], pair[1].upper() if len(pair) > 1 else "") for pair in pairs)
    cells = [(k, n) for k, block in enumerate(mesh.cells) for n in range(len(block.data))]
    by_number = dict(zip(numbers, cells, strict=False))
    sets = {name.upper(): members for name, members in mesh.cell_sets.items()}
    for name, pairs in found.items():
        sides = []
        for of, side in pairs:
            for k, n in [by_number[int(of)]] if of.isdigit() and int(of) in by_number else _members(sets.get(of.upper())):
                corners = _corners(mesh.cells[k].type, side)
                if corners is not None:
                    sides.append(mesh.cells[k].data[n][list(corners)])
        yield name, sides


def _members(blocks: Any) -> list[tuple[int, int]]:
    return [(k, int(n)) for k, block in enumerate(blocks or []) if block is not None for n in block]


def _corners(kind: str, side: str) -> tuple[int, ...] | None:
    base = kind.rstrip("0123456789")
    if base in SHELLS:
        return tuple(range(3 if base == "triangle" else 4))
    faces = FACES.get(base, ())
    number = int(side[1:]) if side.startswith("S") and side[1:].isdigit() else 0
    return faces[number - 1] if 1 <= number <= len(faces) else None


def _blocks(source: Path) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    """Keywords with their options and lines of data."""
    keyword, options, data = "", {}, []
    for raw in source.read_text(encoding="utf-8", errors="replace").splitlines():
        line = raw.strip()
        if line.startswith("**") or not line:
            continue
        if line.startswith("*"):
            yield keyword, options, data
            head, *rest = line[1:].split(",")
            pairs = (part.partition("=") for part in rest)
            keyword, options, data = head.strip().upper(), {key.strip().upper(): value.strip() for key, _, value in pairs}, []
        else:
            data.append(line)
    yield keyword, options, data


def _whole(data: list[str]) -> list[str]:
    """Lines with those that continue them."""
    joined: list[str] = []
    goes_on = False
    for line in data:
        if goes_on:
            joined[-1] += line
        else:
            joined.append(line)
        goes_on = line.endswith(",")
    return joined
