"""The standard library for the interpreter: all builtins, the constants, and modules written in the language."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from scenelang.interpreter.runtime.types import Builtin, Library, Registry
from scenelang.stdlib import (
    arrays,
    colors,
    control,
    entities,
    lists,
    mutation,
    numbers,
    paths,
    predicates,
    profiles,
    python,
    random,
    sequences,
    solids,
    strings,
)
from scenelang.stdlib.numbers import CONSTANTS

TOPICS: tuple[Registry, ...] = (
    entities.registry,
    entities.poses,
    solids.registry,
    profiles.registry,
    paths.registry,
    numbers.registry,
    predicates.registry,
    lists.registry,
    sequences.registry,
    control.calling,
    mutation.registry,
    mutation.tables,
    strings.registry,
    arrays.registry,
    random.registry,
    control.registry,
    colors.registry,
)

# Registries whose names must be imported: `(import "std/python.scene")`.
IMPORTED: dict[str, Registry] = {"python.scene": python.registry}

PRELUDE = ("prelude.scene", "combinators.scene")


def _collect(topics: tuple[Registry, ...]) -> dict[str, Builtin]:
    """Return the entries of all topics by name; a name in two topics is an error."""
    builtins: dict[str, Builtin] = {}
    for registry in topics:
        for name, entry in registry.entries.items():
            if name in builtins:
                raise ValueError(f"{name} is registered by two topics, {builtins[name].topic} and {entry.topic}")
            builtins[name] = entry
    return builtins


def _modules() -> dict[str, str]:
    """Return the source of every module of the package that is written in the language, by file name."""
    paths = sorted(Path(__file__).parent.glob("*.scene"))
    return {path.name: path.read_text("utf-8") for path in paths}


@cache
def build_library() -> Library:
    """Return the standard library; cached, since it is immutable."""
    _collect((*TOPICS, *IMPORTED.values()))  # check that no topic shares a name with an imported module
    return Library(
        builtins=_collect(TOPICS),
        constants={name: value for name, (value, _) in CONSTANTS.items()},
        modules={**dict.fromkeys(IMPORTED, ""), **_modules()},
        prelude=PRELUDE,
        constant_docs={name: doc for name, (_, doc) in CONSTANTS.items()},
        imported={module: registry.entries for module, registry in IMPORTED.items()},
    )
