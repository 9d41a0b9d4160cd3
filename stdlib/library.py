"""The standard library as the interpreter takes it: all builtins, the constants, and modules in the language."""

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
    predicates,
    python,
    random,
    sequences,
    strings,
)
from scenelang.stdlib.numbers import CONSTANTS

TOPICS: tuple[Registry, ...] = (
    entities.registry,
    entities.poses,
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

# What comes with an import only: `(import "std/python.scene")` brings the names of that registry.
IMPORTED: dict[str, Registry] = {"python.scene": python.registry}

PRELUDE = ("prelude.scene", "combinators.scene")


def _collect(topics: tuple[Registry, ...]) -> dict[str, Builtin]:
    """The entries of all topics by name; no two topics, nor a topic and what is imported, share one."""
    builtins: dict[str, Builtin] = {}
    for registry in topics:
        for name, entry in registry.entries.items():
            if name in builtins:
                raise ValueError(f"{name} is registered by two topics, {builtins[name].topic} and {entry.topic}")
            builtins[name] = entry
    return builtins


def _modules() -> dict[str, str]:
    """The source of every module in the language that comes with the package, by file name."""
    found = sorted(Path(__file__).parent.glob("*.scene"))
    return {path.name: path.read_text("utf-8") for path in found}


@cache
def build_library() -> Library:
    """The standard library; made once, as nothing changes it."""
    _collect((*TOPICS, *IMPORTED.values()))  # refuses a name that stands twice
    return Library(
        builtins=_collect(TOPICS),
        constants={name: value for name, (value, _) in CONSTANTS.items()},
        modules={**dict.fromkeys(IMPORTED, ""), **_modules()},
        prelude=PRELUDE,
        constant_docs={name: doc for name, (_, doc) in CONSTANTS.items()},
        imported={module: registry.entries for module, registry in IMPORTED.items()},
    )
