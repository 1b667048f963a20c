"""Input files of Abaqus and CalculiX in the form that meshlane reads rightly.

Included files are joined, sets are written by numbers, and the sides of each ``*SURFACE`` become sets of their own. meshlane
numbers the nodes and cells, and places the instances.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

#: Corners of the face S1, S2, … of each kind of cell.
FACES = {
    "tetra": ((0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)),
    "hexahedron": ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)),
    "wedge": ((0, 1, 2), (3, 5, 4), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)),
}
SHELLS = {"triangle": 3, "quad": 4}
#: Shells that meshlane knows, by the number of their nodes.
SHELL_TYPES = {3: "S3", 4: "S4", 6: "STRI65", 8: "S8R", 9: "S9R5"}
#: Keywords that make or move nodes and elements which the file does not list.
GENERATED = ("NGEN", "NFILL", "NMAP", "NCOPY", "ELGEN", "ELCOPY", "SYSTEM")
SIDE = "contact3d side "
INSTANCE = "contact3d instance "
#: Numbers of a generated set; more do not fit into the memory.
MOST_GENERATED = 10**8

#: Numbers by instance; outside an assembly the instance is empty.
Members = dict[str, list[int]]


class DeckError(ValueError):
    """A keyword that cannot be read rightly, and what to do about it."""


@dataclass
class _Scope:
    """A part, an instance, the assembly or the file: its nodes, its cells by their nodes, and its sets."""

    nodes: set[int] = field(default_factory=set)
    cells: dict[int, list[int]] = field(default_factory=dict)
    sets: dict[tuple[str, str], tuple[str, Members]] = field(default_factory=dict)
    hidden: set[tuple[str, str]] = field(default_factory=set)
    is_assembly: bool = False

    def add(self, kind: str, name: str, members: Members, *, hidden: bool = False) -> None:
        key = (kind, name.upper())
        _, held = self.sets.setdefault(key, (name, {}))
        for instance, numbers in members.items():
            held.setdefault(instance, []).extend(numbers)
        if hidden:
            self.hidden.add(key)

    def text(self) -> Iterator[str]:
        for (kind, key), (name, members) in self.sets.items():
            for instance, numbers in members.items():
                if numbers and (kind, key) not in self.hidden:
                    yield f"*{kind}, {kind}={name}" + (f", INSTANCE={instance}" if instance else "")
                    yield from map(str, dict.fromkeys(numbers))


class Deck:
    """The text for meshlane, and what was left out."""

    def __init__(self, source: Path) -> None:
        self.lines: list[str] = []
        self.ignored: list[str] = []
        self._parts: dict[str, _Scope] = {}
        self._instances: dict[str, tuple[str, _Scope]] = {}
        self._scopes = [_Scope()]
        blocks = list(_blocks(source))
        placed = {_option(options, "PART").upper() for keyword, options, _ in blocks if keyword == "INSTANCE"}
        is_left_out = False
        for keyword, options, data in blocks:
            if keyword == "PART":
                is_left_out = bool(placed) and _option(options, "NAME").upper() not in placed
            if not is_left_out:
                self._add(keyword, options, data)
            is_left_out &= keyword != "END PART"
        self.lines += self._scopes[0].text()

    def _add(self, keyword: str, options: dict[str, str], data: list[str]) -> None:
        scope = self._scopes[-1]
        if keyword in GENERATED:
            raise DeckError(f"*{keyword} makes nodes or elements that the file does not list; write the mesh out in full")
        if keyword in ("PART", "ASSEMBLY", "INSTANCE"):
            self._begin(keyword, options, data)
        elif keyword in ("END PART", "END ASSEMBLY", "END INSTANCE"):
            if scope.is_assembly and len(self._instances) > 1:
                for name in self._instances:
                    cells = [number for of in self._of_instance(name) for number in of.cells]
                    scope.add("ELSET", INSTANCE + name, {name: cells})
            self.lines += [*scope.text(), f"*{keyword}"]
            self._scopes.pop()
        elif keyword == "NODE":
            self._nodes(options, data)
        elif keyword == "ELEMENT":
            self._elements(options, data)
        elif keyword in ("NSET", "ELSET"):
            if "ELSET" in options and keyword == "NSET":
                cells = self._lookup("ELSET", options["ELSET"])
                members = {instance: self._nodes_of(instance, numbers) for instance, numbers in cells.items()}
            else:
                members = self._members(keyword, options, data)
            scope.add(keyword, _option(options, keyword), members, hidden="INTERNAL" in options)
        elif keyword == "SURFACE":
            self._surface(options, data)

    def _begin(self, keyword: str, options: dict[str, str], data: list[str]) -> None:
        scope = _Scope(is_assembly=keyword == "ASSEMBLY")
        name = options.get("NAME", "")
        if keyword == "PART":
            self._parts[name.upper()] = scope
        elif keyword == "INSTANCE":
            part = _option(options, "PART")
            if part.upper() not in self._parts:
                raise DeckError(f"*INSTANCE {name!r} takes the part {part!r}, which the file does not have; add its *PART")
            self._instances[name.upper()] = (part.upper(), scope)
        self._scopes.append(scope)
        part = f", PART={options['PART'].upper()}" if keyword == "INSTANCE" else ""
        self.lines += [f"*{keyword}, NAME={name.upper()}{part}", *data]

    def _nodes(self, options: dict[str, str], data: list[str]) -> None:
        if options.get("SYSTEM", "R").upper() != "R":
            raise DeckError("*NODE, SYSTEM= has cylindrical or spherical coordinates; write the nodes in Cartesian coordinates")
        scope, numbers = self._scopes[-1], []
        self.lines.append("*NODE")
        for line in data:
            number, *place = [part.strip() for part in line.split(",")]
            values = [(value or "0").upper().replace("D", "E") for value in (*place, "", "", "")[:3]]
            numbers.append(int(number))
            self.lines.append(", ".join([number, *values]))
        _require_new(scope.nodes, numbers, "node")
        scope.nodes.update(numbers)
        if "NSET" in options:
            scope.add("NSET", options["NSET"], {"": numbers})

    def _elements(self, options: dict[str, str], data: list[str]) -> None:
        scope, kind = self._scopes[-1], _option(options, "TYPE").upper()
        solid = re.fullmatch(r"(?:C|DC|AC)3D(4|6|8|10|15|20)(?![0-9])[A-Z]*", kind)
        if not solid and re.match(r"(C|DC|AC|COH|F|Q|GK|SC|CSS|CIN|U)[0-9]*3D|U\d|VU\d|SC[68]", kind):
            raise DeckError(f"elements of type {kind} cannot be read; mesh the part with C3D4 or C3D10, or take them out")
        if solid and scope.is_assembly:
            raise DeckError(f"elements of type {kind} stand in the assembly; write them into a *PART")
        is_shell = re.match(r"(S|R3D|STRI|M3D|SFM3D|DS)[34689]", kind)
        if not solid and not is_shell:
            # Springs, masses and the like; their sets hold no cells.
            scope.add("ELSET", options.get("ELSET", ""), {})
            return
        rows = [[int(part) for part in line.split(",") if part.strip()] for line in _whole(data)]
        if not rows:
            return
        _require_new(scope.cells.keys(), [row[0] for row in rows], "element")
        self.lines.append(f"*ELEMENT, TYPE={f'C3D{solid[1]}' if solid else SHELL_TYPES.get(len(rows[0]) - 1, kind)}")
        for number, *nodes in rows:
            scope.cells[number] = nodes
            if solid and len(nodes) != int(solid[1]):
                raise DeckError(f"element {number} of type {kind} has {len(nodes)} nodes; expected {solid[1]}")
            self.lines.append(", ".join(map(str, [number, *nodes])))
        if solid and (unknown := {node for _, *nodes in rows for node in nodes} - self._known_nodes()):
            raise DeckError(f"elements of type {kind} use node {min(unknown)}, which no *NODE before them defines")
        if "ELSET" in options:
            scope.add("ELSET", options["ELSET"], {"": [row[0] for row in rows]})

    def _known_nodes(self) -> set[int]:
        """Nodes of the scope; of the part as well inside an instance."""
        scope = self._scopes[-1]
        own = [self._parts[part].nodes for part, of in self._instances.values() if of is scope]
        return scope.nodes.union(*own)

    def _surface(self, options: dict[str, str], data: list[str]) -> None:
        scope, name = self._scopes[-1], _option(options, "NAME")
        kind = options.get("TYPE", "ELEMENT").upper()
        if kind == "NODE":
            scope.add("NSET", name, self._members("NSET", {}, [line.split(",")[0] for line in data]))
        elif kind != "ELEMENT" or "COMBINE" in options:
            self.ignored.append(f"ignored *SURFACE {name!r}: only surfaces of elements and of nodes are read")
        else:
            for line in data:
                of, side = (*(part.strip() for part in line.split(",")), "")[:2]
                members = self._members("ELSET", {}, [of])
                scope.add("ELSET", f"{SIDE}{name} {side.upper() or 'ALL'}", members)
                if side and not of.isdigit():
                    scope.hidden.add(("ELSET", of.strip('"').upper()))

    def _members(self, kind: str, options: dict[str, str], data: list[str]) -> Members:
        instance, members = options.get("INSTANCE", "").upper(), Members()
        for line in data:
            parts = [part.strip().strip('"') for part in line.split(",") if part.strip()]
            if "GENERATE" in options:
                if not 2 <= len(parts) <= 3 or not all(part.isdigit() for part in parts):
                    raise DeckError(f"GENERATE wants lines of first, last, step, found {line.strip()!r}")
                first, last, step = (*map(int, parts), 1)[:3]
                if last - first > step * MOST_GENERATED:
                    raise DeckError(f"a set is generated from {first} to {last}; expected at most {MOST_GENERATED} numbers")
                members.setdefault(instance, []).extend(range(first, last + 1, step))
                continue
            for part in parts:
                found = {instance: [int(part)]} if part.isdigit() else self._lookup(kind, part)
                for of, numbers in found.items():
                    members.setdefault(of or instance, []).extend(numbers)
        return members

    def _lookup(self, kind: str, name: str) -> Members:
        name = name.strip('"').upper()
        for scope in reversed(self._scopes):
            if (kind, name) in scope.sets:
                return scope.sets[kind, name][1]
        instance, _, own = name.rpartition(".")
        for scope in self._of_instance(instance):
            if (kind, own) in scope.sets:
                return {instance: scope.sets[kind, own][1].get("", [])}
        if kind == "NSET" and "." in name and own.isdigit():
            return {instance: [int(own)]}
        raise DeckError(f"the set {name!r} is used and not defined before; write its *{kind} before its use")

    def _of_instance(self, instance: str) -> list[_Scope]:
        if instance not in self._instances:
            return []
        part, scope = self._instances[instance]
        return [scope, self._parts[part]]

    def _nodes_of(self, instance: str, numbers: list[int]) -> list[int]:
        scopes = [*self._of_instance(instance), *self._scopes]
        cells = [scope.cells[number] for number in numbers for scope in scopes if number in scope.cells]
        return [node for nodes in cells for node in nodes]


def surfaces(mesh: Any) -> Iterator[tuple[str, list[np.ndarray]]]:
    """Takes the sets that stand for sides out of a mesh: the name of each ``*SURFACE`` and its sides, by their corners."""
    for key in [key for key in mesh.cell_sets if key.startswith(SIDE)]:
        name, _, side = key.removeprefix(SIDE).rpartition(" ")
        sides = []
        for block, numbers in zip(mesh.cells, mesh.cell_sets.pop(key), strict=True):
            if len(numbers):
                for corners in _corners(block.type.rstrip("0123456789"), name, side):
                    sides += list(block.data[np.asarray(numbers, dtype=int)][:, list(corners)])
        yield name, sides


def _corners(base: str, name: str, side: str) -> list[tuple[int, ...]]:
    if base in SHELLS:
        return [tuple(range(SHELLS[base]))]
    faces = FACES.get(base, ())
    if side == "ALL":
        return list(faces)
    number = int(side[1:]) if re.fullmatch(r"S\d+", side) else 0
    if not 1 <= number <= len(faces):
        raise DeckError(f"*SURFACE {name!r} takes the side {side} of a {base}, which has S1 to S{len(faces)}")
    return [faces[number - 1]]


def _option(options: dict[str, str], key: str) -> str:
    if not options.get(key):
        raise DeckError(f"a keyword lacks {key}=; its options are {', '.join(options) or 'none'}")
    return options[key]


def _require_new(known: Any, numbers: list[int], kind: str) -> None:
    twice = [number for number in numbers if number in known]
    if twice or len(set(numbers)) < len(numbers):
        number = twice[0] if twice else max(numbers, key=numbers.count)
        raise DeckError(f"{kind} {number} is defined twice; number the mesh again")


def _blocks(source: Path, depth: int = 0) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    """Keywords with their options and lines of data, those of included files among them."""
    keyword, options, data, goes_on = "", {}, [], False
    for line in _text(source, depth):
        if line.startswith("*") or goes_on:
            if not goes_on:
                if keyword:
                    yield from _block(source, keyword, options, data, depth)
                keyword, options, data = " ".join(line[1:].split(",")[0].upper().split()), {}, []
                line = line.partition(",")[2]
            for part in line.split(","):
                key, _, value = part.partition("=")
                options[key.strip().upper()] = value.strip().strip('"')
            goes_on = line.endswith(",")
        else:
            data.append(line)
    if keyword:
        yield from _block(source, keyword, options, data, depth)


def _block(source: Path, keyword: str, options: dict[str, str], data: list[str], depth: int
           ) -> Iterator[tuple[str, dict[str, str], list[str]]]:
    if keyword == "INCLUDE":
        yield from _blocks(source.parent / _option(options, "INPUT"), depth + 1)
    elif "INPUT" in options and keyword in ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE"):
        yield keyword, options, [*data, *_text(source.parent / options["INPUT"], depth + 1)]
    else:
        yield keyword, options, data


def _text(source: Path, depth: int) -> list[str]:
    # Abaqus allows five levels.
    if depth > 5:
        raise DeckError(f"*INCLUDE goes deeper than five levels at {source}; does a file include itself?")
    try:
        raw = source.read_bytes()
    except OSError as error:
        raise DeckError(f"cannot read the included file {source}: {error.strerror}") from error
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("cp1252", errors="replace")
    lines = (line.strip() for line in text.splitlines())
    return [line for line in lines if line and not line.startswith("**")]


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
