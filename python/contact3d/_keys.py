"""What the classes of a scene have in common."""

import os
import tomllib
import types
import typing
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, Self

from . import _toml


class Keys:
    """A table of a scene: what its keys are is the matter of its class."""

    def __repr__(self) -> str:
        given = ", ".join(f"{name}={value!r}" for name, value in vars(self).items() if value is not None)
        return f"{type(self).__name__}({given})"

    def to_dict(self) -> dict[str, Any]:
        """The keys that are given, as ``tomllib`` would read them."""
        return {name: plain(value) for name, value in vars(self).items() if value is not None}

    def to_toml(self) -> str:
        """The same as a TOML document, which :meth:`from_toml` and the program read."""
        return _toml.document(self.to_dict())

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Self:
        """The classes for a dict as ``tomllib`` makes it; an unknown key is a TypeError."""
        hints = typing.get_type_hints(cls)
        known = [entry.name for entry in fields(cls)]  # type: ignore[arg-type]
        for key in content:
            if key not in known:
                raise TypeError(f"{cls.__name__} has no key {key!r}; it has {', '.join(known)}")
        return cls(**{key: _typed(hints[key], value) for key, value in content.items()})

    @classmethod
    def from_toml(cls, source: str | os.PathLike[str]) -> Self:
        """The classes for a TOML file, or for its text if that has more than one line."""
        is_text = isinstance(source, str) and "\n" in source
        text = str(source) if is_text else Path(source).read_text(encoding="utf-8")
        return cls.from_dict(tomllib.loads(text))


def plain(value: Any) -> Any:
    """A value of a scene without classes."""
    if isinstance(value, Keys):
        return value.to_dict()
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [plain(item) for item in value]
    return value


def _typed(hint: Any, value: Any) -> Any:
    """A value with classes where the hint has them and the value the form of one."""
    if isinstance(value, Mapping):
        classes = [kind for kind in _members(hint) if is_dataclass(kind)]
        if classes:
            return classes[0].from_dict(value)  # type: ignore[union-attr]
    if isinstance(value, list):
        for kind in _members(hint):
            if typing.get_origin(kind) is Sequence:
                return [_typed(typing.get_args(kind)[0], item) for item in value]
    return value


def _members(hint: Any) -> tuple[Any, ...]:
    is_union = isinstance(hint, types.UnionType) or typing.get_origin(hint) is typing.Union
    return typing.get_args(hint) if is_union else (hint,)
