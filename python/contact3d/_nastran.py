"""Bulk data of Nastran: free, small and large fields, included files, points in cylindrical and other coordinate systems.

meshlane and meshio take r, θ, z for x, y, z, and leave out cards in large fields or in lower case.
"""

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

#: Cells by the number of their nodes. Corners and middles stand in the order of VTK up to the middles of tetrahedra and shells.
CELLS = {
    "CTETRA": {4: "tetra", 10: "tetra10"},
    "CHEXA": {8: "hexahedron", 20: "hexahedron20"},
    "CPENTA": {6: "wedge", 15: "wedge15"},
    "CPYRAM": {5: "pyramid", 13: "pyramid13"},
    "CPYRA": {5: "pyramid", 13: "pyramid13"},
}
SHELLS = {"CTRIA3": 3, "CTRIAR": 3, "CTRIA6": 3, "CQUAD4": 4, "CQUADR": 4, "CQUAD8": 4}


class BulkError(ValueError):
    """A card that cannot be read rightly, and what to do about it."""


class Systems:
    """Coordinate systems, by their numbers."""

    def __init__(self, cards: list[list[str]], points: dict[int, tuple[int, list[float]]]) -> None:
        self._points = points
        self._cards: dict[int, tuple[str, int, list[Any]]] = {}
        for name, *fields in cards:
            if name.startswith("CORD2"):
                numbers = [_real(f) for f in _padded(fields, 11)[2:11]]
                self._cards[int(fields[0])] = (name[5], int(fields[1] or 0), [numbers[i : i + 3] for i in (0, 3, 6)])
            elif name.startswith("CORD1"):
                for start in (0, 4):
                    if any(of := fields[start : start + 4]):
                        self._cards[int(of[0])] = (name[5], 0, [int(f) for f in of[1:]])
            elif name.startswith("CORD"):
                raise BulkError(f"{name} is not read; write the points in the basic system, or with CORD2R, CORD2C or CORD2S")
        self._axes: dict[int, tuple[np.ndarray, np.ndarray]] = {}

    def grid(self, number: int) -> np.ndarray:
        """The place of a grid point in the basic system."""
        if number not in self._points:
            raise BulkError(f"the grid point {number} is used and not defined")
        return self.place(*self._points[number])

    def place(self, system: int, at: list[float]) -> np.ndarray:
        """A place in the basic system, from its coordinates in a system."""
        if system == 0:
            return np.array(at)
        if system not in self._cards:
            raise BulkError(f"points are in the coordinate system {system}, which the file does not define; add its CORD2 card")
        kind = self._cards[system][0]
        a, b, c = at
        if kind == "C":
            a, b = a * math.cos(math.radians(b)), a * math.sin(math.radians(b))
        elif kind == "S":
            theta, phi = math.radians(b), math.radians(c)
            a, b, c = a * math.sin(theta) * math.cos(phi), a * math.sin(theta) * math.sin(phi), a * math.cos(theta)
        if system not in self._axes:
            self._axes[system] = self._frame(system)
        origin, axes = self._axes[system]
        return origin + axes @ [a, b, c]

    def _frame(self, system: int) -> tuple[np.ndarray, np.ndarray]:
        _, parent, given = self._cards[system]
        try:
            origin, on_z, in_xz = [self.grid(p) if isinstance(p, int) else self.place(parent, p) for p in given]
        except RecursionError:
            raise BulkError(f"the coordinate system {system} is defined by itself") from None
        z = on_z - origin
        y = np.cross(z, in_xz - origin)
        if not np.linalg.norm(y) > 0.0:
            raise BulkError(f"the three points of the coordinate system {system} lie on a line")
        z, y = z / np.linalg.norm(z), y / np.linalg.norm(y)
        return origin, np.column_stack([np.cross(y, z), y, z])


def read(source: Path, library: Any) -> Any:
    """The mesh of a file; the properties of its cells are the array ``property``."""
    points: dict[int, tuple[int, list[float]]] = {}
    blocks: dict[str, tuple[list[list[int]], list[int]]] = {}
    cards = list(_cards(source))
    default = next((int(fields[1]) for name, *fields in cards if name == "GRDSET" and len(fields) > 1 and fields[1]), 0)
    for name, *fields in cards:
        if name == "GRID":
            _, system, *place = _padded(fields, 5)
            points[int(fields[0])] = (int(system or default), [_real(value) for value in place[:3]])
        elif name in CELLS:
            nodes = [int(value) for value in fields[2:] if value]
            if len(nodes) not in CELLS[name]:
                expected = " or ".join(map(str, CELLS[name]))
                raise BulkError(f"{name} {fields[0]} has {len(nodes)} nodes, expected {expected}; mesh all in one order")
            _append(blocks, CELLS[name][len(nodes)], fields, nodes)
        elif name in SHELLS:
            kind = {3: "triangle", 4: "quad"}[SHELLS[name]]
            _append(blocks, kind, fields, [int(value) for value in fields[2 : 2 + SHELLS[name]]])
        elif name.startswith(("CTET", "CHEX", "CPEN", "CPYR")) or name.startswith("=") or name == "*":
            raise BulkError(f"the card {name} is not read; write the mesh with CTETRA, one card for each")
    systems = Systems([card for card in cards if card[0].startswith("CORD")], points)
    number = {grid: n for n, grid in enumerate(points)}
    try:
        cells = [(kind, np.array([[number[node] for node in cell] for cell in own])) for kind, (own, _) in blocks.items()]
    except KeyError as error:
        raise BulkError(f"a cell uses the grid point {error.args[0]}, which is not defined") from error
    places = np.array([systems.grid(grid) for grid in points]).reshape(-1, 3)
    properties = [np.array(tags) for _, tags in blocks.values()]
    return library.Mesh(places, cells, cell_data={"property": properties} if cells else {})


def _append(blocks: dict[str, tuple[list[list[int]], list[int]]], kind: str, fields: list[str], nodes: list[int]) -> None:
    own, tags = blocks.setdefault(kind, ([], []))
    own.append(nodes)
    # A cell without a property has that of its own number.
    tags.append(int(fields[1] or fields[0]))


def _padded(fields: list[str], size: int) -> list[str]:
    return fields + [""] * (size - len(fields))


def _real(text: str) -> float:
    """A number such as 1.5, 1.5-3 or 1.5D-3."""
    text = re.sub(r"(?<=[0-9.])[DEde]?(?=[+-]\d+$)|(?<=[0-9.])[Dd](?=\d+$)", "e", text)
    return float(text) if text else 0.0


def _cards(source: Path, depth: int = 0) -> Iterator[list[str]]:
    """Each card: its name in capitals without a star, then its fields."""
    card: list[str] = []
    lines = source.read_text(encoding="utf-8", errors="replace").splitlines()
    begin = [n for n, line in enumerate(lines) if re.match(r"\s*BEGIN\s+(BULK|SUPER)", line, re.IGNORECASE)]
    if len(begin) > 1:
        raise BulkError(f"{source.name} has several bulk sections; write the mesh of one")
    for line in lines[begin[0] + 1 if begin else 0 :]:
        line = line.partition("$")[0].expandtabs(8).rstrip()
        if re.match(r"\s*ENDDATA", line, re.IGNORECASE):
            break
        if include := re.match(r"\s*INCLUDE\s*['\"]?([^'\"]+)", line, re.IGNORECASE):
            if depth > 9 or not (source.parent / include[1].strip()).is_file():
                raise BulkError(f"cannot read the included file {include[1].strip()}; put it beside {source.name}")
            yield from [card] if card else []
            card = []
            yield from _cards(source.parent / include[1].strip(), depth + 1)
        elif line:
            name, fields = _fields(line)
            if name == "" or name[0] in "+*":
                card += fields
            else:
                yield from [card] if card else []
                card = [name.rstrip("*").upper(), *fields]
    yield from [card] if card else []


def _fields(line: str) -> tuple[str, list[str]]:
    """The name and the fields of a line: eight, or four that are wide."""
    if "," in line:
        name, *fields = [part.strip() for part in line.split(",")]
        count = 4 if "*" in name else 8
        if len(fields) > count + 1:
            raise BulkError(f"a line of free fields has {len(fields)} fields, and {count} are read: {line[:60]!r}")
        return name, _padded(fields[:count], count)
    name, wide = line[:8].strip(), "*" in line[:8]
    width, count = (16, 4) if wide else (8, 8)
    line = line.ljust(8 + width * count)
    return name, [line[8 + width * n : 8 + width * (n + 1)].strip() for n in range(count)]
