"""The standard library for the interpreter: all builtins, the constants, and modules written in the language."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from scenelang.interpreter.runtime.types import Builtin, Library, Registry
from scenelang.stdlib import builtin_names
from scenelang.stdlib.numbers import CONSTANTS

# Registries as ``module.attribute``, in the order of the reference.
TOPICS = (
    "entities.registry",
    "entities.poses",
    "solids.registry",
    "profiles.registry",
    "paths.registry",
    "numbers.registry",
    "predicates.registry",
    "lists.registry",
    "sequences.registry",
    "control.calling",
    "mutation.registry",
    "mutation.tables",
    "strings.registry",
    "arrays.registry",
    "random.registry",
    "control.registry",
    "colors.registry",
    "cameras.registry",
)

# Registries whose names must be imported: `(import "std/python.scene")`.
IMPORTED = {"python.scene": "python.registry"}

PRELUDE = ("prelude.scene", "combinators.scene")


def registry_of(topic: str) -> Registry:
    """Return the registry of a topic of ``TOPICS`` or ``IMPORTED``; its module is imported."""
    module, _, attribute = topic.partition(".")
    registry: Registry = getattr(_module(module), attribute)
    return registry


def _module(name: str) -> Any:
    """Import the module of a topic. The imports are written out, so that a reader and the tests of layers see them."""
    match name:
        case "arrays":
            from scenelang.stdlib import arrays

            return arrays
        case "cameras":
            from scenelang.stdlib import cameras

            return cameras
        case "colors":
            from scenelang.stdlib import colors

            return colors
        case "control":
            from scenelang.stdlib import control

            return control
        case "entities":
            from scenelang.stdlib import entities

            return entities
        case "lists":
            from scenelang.stdlib import lists

            return lists
        case "mutation":
            from scenelang.stdlib import mutation

            return mutation
        case "numbers":
            from scenelang.stdlib import numbers

            return numbers
        case "paths":
            from scenelang.stdlib import paths

            return paths
        case "predicates":
            from scenelang.stdlib import predicates

            return predicates
        case "profiles":
            from scenelang.stdlib import profiles

            return profiles
        case "python":
            from scenelang.stdlib import python

            return python
        case "random":
            from scenelang.stdlib import random

            return random
        case "sequences":
            from scenelang.stdlib import sequences

            return sequences
        case "solids":
            from scenelang.stdlib import solids

            return solids
        case "strings":
            from scenelang.stdlib import strings

            return strings
        case _:
            raise ValueError(f"no module {name}")


class _Builtins(Mapping[str, Builtin]):
    """Builtins by name; the module of one is imported when it is looked up.

    Most programs use a few modules, and importing all of them takes a sixth of ``check``.
    """

    def __init__(self, topics: tuple[str, ...]) -> None:
        """Create the mapping of some topics, whose names are known from ``builtin_names``."""
        self._topics = {name: topic for topic in topics for name in builtin_names.NAMES[topic]}

    def __getitem__(self, name: str) -> Builtin:
        return registry_of(self._topics[name]).entries[name]

    def __contains__(self, name: object) -> bool:
        return name in self._topics

    def __iter__(self) -> Iterator[str]:
        return iter(self._topics)

    def __len__(self) -> int:
        return len(self._topics)


def index_text() -> str:
    """Return the text of ``builtin_names``: the names of the builtins of each topic.

    Raises
    ------
    ValueError
        If two topics define the same name.
    """
    homes: dict[str, str] = {}
    for topic in (*TOPICS, *IMPORTED.values()):
        for name in registry_of(topic).entries:
            if name in homes:
                raise ValueError(f"{name} is registered by two topics, {homes[name]} and {topic}")
            homes[name] = topic
    rows = []
    for topic in (*TOPICS, *IMPORTED.values()):
        names = " ".join(name for name in homes if homes[name] == topic)
        rows.append(f'    "{topic}": {names!r}.split(),\n')
    title = '"""Names of the builtins by topic, written by ``make tables``."""'
    return f"{title}\n\nNAMES: dict[str, list[str]] = {{\n{''.join(rows)}}}\n"


_FOLDER = os.path.dirname(__file__)
_PARTS = os.path.join(_FOLDER, "parts")


def part_modules() -> tuple[str, ...]:
    """Return the file names of the modules of ``parts``, sorted."""
    return tuple(sorted(name for name in os.listdir(_PARTS) if name.endswith(".scene")))


class _Modules(Mapping[str, str]):
    """Sources of the modules that are written in the language, by file name; each is read when it is looked up.

    Those of ``parts`` are some 100 KB, which most programs do not import.
    """

    def __init__(self) -> None:
        self._paths = {
            name: os.path.join(folder, name)
            for folder in (_FOLDER, _PARTS)
            for name in sorted(os.listdir(folder))
            if name.endswith(".scene")
        }
        self._texts = dict.fromkeys(IMPORTED, "")

    def __getitem__(self, name: str) -> str:
        if name not in self._texts:
            with open(self._paths[name], encoding="utf-8") as file:
                self._texts[name] = file.read()
        return self._texts[name]

    def __iter__(self) -> Iterator[str]:
        return iter({**self._texts, **self._paths})

    def __len__(self) -> int:
        return len({**self._texts, **self._paths})


@cache
def build_library() -> Library:
    """Return the standard library; cached, since it is immutable."""
    return Library(
        builtins=_Builtins(TOPICS),
        constants={name: value for name, (value, _) in CONSTANTS.items()},
        modules=_Modules(),
        prelude=PRELUDE,
        constant_docs={name: doc for name, (_, doc) in CONSTANTS.items()},
        imported={module: _Builtins((topic,)) for module, topic in IMPORTED.items()},
    )


if __name__ == "__main__":
    with open(sys.argv[1], "w", encoding="utf-8") as output:
        output.write(index_text())
