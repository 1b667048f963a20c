"""Scenes as users have them, as the program takes them."""

import os
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from . import _toml
from ._keys import plain
from .scene import Scene

#: The path of a scene, its text (of more than one line), a dict as ``tomllib`` makes it, or typed classes.
SceneLike = str | os.PathLike[str] | Mapping[str, Any] | Scene


def files(content: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """The tables of bodies and obstacles that name a file, with their keys."""
    for first, *below in (("body", "gmsh"), ("contact", "obstacle", "surface")):
        entries = content.get(first)
        entries = entries if isinstance(entries, list) else [entries]
        for number, table in enumerate(entries):
            for name in below:
                table = table.get(name) if isinstance(table, Mapping) else None
            if isinstance(table, Mapping) and isinstance(table.get("file"), (str, os.PathLike)):
                yield ".".join([first, *([str(number)] if len(entries) > 1 else []), *below]), table


def given(scene: SceneLike) -> tuple[str | None, str | None, dict[str, Any]]:
    """The path of a scene or its text, and the keys that differ: mesh files count from the working directory there."""
    if isinstance(scene, (Scene, Mapping)):
        content = plain(scene)
        text = _toml.document(content)
    elif isinstance(scene, str) and "\n" in scene:
        text = scene
        try:
            content = tomllib.loads(scene)
        except tomllib.TOMLDecodeError:
            content = {}
    elif isinstance(scene, (str, os.PathLike)):
        return os.fspath(scene), None, {}
    else:
        kinds = "a path, a text, a dict or a contact3d.scene.Scene"
        raise TypeError(f"a scene is {kinds}, not {type(scene).__name__}")
    changes = {f"{key}.file": str(Path(table["file"]).absolute()) for key, table in files(content)}
    return None, text, changes
