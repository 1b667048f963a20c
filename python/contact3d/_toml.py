"""Python values as TOML: scenes and settings for the command line."""

import json
import math
import os
from collections.abc import Mapping, Sequence
from typing import Any


def document(scene: Mapping[str, Any]) -> str:
    """A scene as a TOML document: the root's tables with headings, the rest of each on one line for each key."""
    root = {name: item for name, item in scene.items() if not _is_table(item) and not _is_list_of_tables(item)}
    text = _lines(root)
    for name, item in scene.items():
        if _is_table(item):
            text += f"\n[{key(name)}]\n{_lines(item)}"
        elif _is_list_of_tables(item):
            text += "".join(f"\n[[{key(name)}]]\n{_lines(entry)}" for entry in item)
    return text


def _is_table(item: Any) -> bool:
    return isinstance(item, Mapping)


def _is_list_of_tables(item: Any) -> bool:
    return isinstance(item, Sequence) and len(item) > 0 and all(_is_table(entry) for entry in item)


def _lines(table: Mapping[str, Any]) -> str:
    return "".join(f"{key(name)} = {value(item)}\n" for name, item in table.items())


def key(name: str) -> str:
    """A key of a table, quoted where it has to be."""
    if not isinstance(name, str):
        raise TypeError(f"keys of a scene are texts, not {name!r}")
    bare = name.replace("_", "").replace("-", "")
    return name if bare.isascii() and bare.isalnum() else json.dumps(name, ensure_ascii=False)


def value(item: Any) -> str:
    """A value on one line; numbers and arrays of NumPy count as Python's."""
    if hasattr(item, "tolist"):
        item = item.tolist()
    if isinstance(item, bool):
        return "true" if item else "false"
    if isinstance(item, int):
        return str(item)
    if isinstance(item, float):
        return repr(item) if math.isfinite(item) else str(item)
    if isinstance(item, (str, os.PathLike)):
        return json.dumps(os.fspath(item), ensure_ascii=False)
    if isinstance(item, Mapping):
        return "{" + ", ".join(f"{key(k)} = {value(v)}" for k, v in item.items()) + "}"
    if isinstance(item, Sequence):
        return "[" + ", ".join(value(entry) for entry in item) + "]"
    raise TypeError(f"a scene holds numbers, texts, lists and tables, not {type(item).__name__}")
