"""Python values as TOML: scenes and settings for the command line."""

import json
import math
import os
from collections.abc import Mapping, Sequence
from typing import Any


def document(scene: Mapping[str, Any]) -> str:
    """A scene as a TOML document, one line for each key of the root."""
    return "".join(f"{key(name)} = {value(item)}\n" for name, item in scene.items())


def key(name: str) -> str:
    """A key of a table, quoted where it has to be."""
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
