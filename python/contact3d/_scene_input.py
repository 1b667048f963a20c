"""Scenes as users have them, as the program takes them."""

import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from . import _toml
from ._keys import plain
from .scene import Scene

#: The path of a scene, its text (of more than one line), a dict as ``tomllib`` makes it, or typed classes.
SceneLike = str | os.PathLike[str] | Mapping[str, Any] | Scene


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
    body = content.get("body")
    mesh = body.get("gmsh") if isinstance(body, Mapping) else None
    changes = {}
    if isinstance(mesh, Mapping) and isinstance(mesh.get("file"), (str, os.PathLike)):
        changes["body.gmsh.file"] = str(Path(mesh["file"]).absolute())
    contact = content.get("contact")
    obstacle = contact.get("obstacle") if isinstance(contact, Mapping) else None
    surface = obstacle.get("surface") if isinstance(obstacle, Mapping) else None
    if isinstance(surface, Mapping) and isinstance(surface.get("file"), (str, os.PathLike)):
        changes["contact.obstacle.surface.file"] = str(Path(surface["file"]).absolute())
    return None, text, changes
