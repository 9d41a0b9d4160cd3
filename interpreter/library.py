"""The interface through which the interpreter is given builtins: it never imports ``stdlib``.

A builtin's signature, types, doc and example are written once, in its entry; help, reference documentation,
completion and prompts come from there. Signatures are written as people read them::

    angle::Float axis::Vector [point::Vector]      two required parameters and an optional one
    count::Integer items::Any ...                  a rest parameter
    xs::Sequence [:key::Function] [:reverse::Boolean]   keyword parameters, each optional
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from scenelang.interpreter.types import Type, parse_type
from scenelang.interpreter.values import Procedure

STD = "std/"  # before a name: the library's own, never shadowed; before a file: a module of the library


@dataclass(frozen=True, slots=True)
class Parameter:
    name: str
    type: Type
    optional: bool = False
    keyword: bool = False
    rest: bool = False


@dataclass(frozen=True, slots=True)
class Signature:
    """The parameters of a builtin by kind; ``text`` is the signature as written."""

    text: str
    required: tuple[Parameter, ...]
    optional: tuple[Parameter, ...]
    rest: Parameter | None
    keywords: tuple[Parameter, ...]


_PARAMETER = re.compile(r"\[(?P<inner>[^\s\[\]]+(?:\[.*?\])?)\]|(?P<plain>\.\.\.|[^\s\[\]]+(?:\[[^\s]*\])?)")


def parse_signature(text: str) -> Signature:
    """Parse the notation above. Raises ValueError for a parameter out of order."""
    parameters: list[Parameter] = []
    for match in _PARAMETER.finditer(text):
        word = match["inner"] or match["plain"]
        if word == "...":
            last = parameters.pop()
            parameters.append(Parameter(last.name, last.type, rest=True))
            continue
        keyword = word.startswith(":")
        name, _, annotation = word.lstrip(":").partition("::")
        optional = match["inner"] is not None or keyword
        parameters.append(Parameter(name, parse_type(annotation or "Any"), optional, keyword))
    required = tuple(p for p in parameters if not (p.optional or p.rest))
    optional = tuple(p for p in parameters if p.optional and not p.keyword)
    rest = next((p for p in parameters if p.rest), None)
    keywords = tuple(p for p in parameters if p.keyword)
    if parameters != [*required, *optional, *([rest] if rest else []), *keywords]:
        raise ValueError(f"parameters out of order in {text!r}")
    return Signature(text, required, optional, rest, keywords)


@dataclass(frozen=True, eq=False)
class Builtin(Procedure):
    """One registry entry.

    ``function(runtime, *positionals, **keywords)``: optional parameters that are not given are left out, a rest
    parameter becomes Python's ``*args``; names with dashes arrive with underscores. ``intrinsic`` names the operation
    that the compiler has a fast path for. ``example`` is a pair of an expression and its printed value.
    """

    name: str
    parameters: str
    result: str
    function: Callable[..., Any]
    doc: str
    example: tuple[str, str] | None
    topic: str
    since: str = "0.1"
    intrinsic: str | None = None

    @cached_property
    def signature(self) -> Signature:
        return parse_signature(self.parameters)

    @property
    def usage(self) -> str:
        """The signature as diagnostics and help show it: ``(rotate angle::Float axis::Vector) -> Matrix``."""
        return f"({self.name}{' ' if self.parameters else ''}{self.parameters}) -> {self.result}"


@dataclass(frozen=True, eq=False)
class Library:
    """What a program can use: builtins and constants by name, and modules of source in the language by file name.

    ``prelude`` names the modules whose definitions every program sees; ``imported`` holds, by module, the builtins that
    a program has only when it imports that module.
    """

    builtins: Mapping[str, Builtin]
    constants: Mapping[str, Any]
    modules: Mapping[str, str]
    prelude: tuple[str, ...]
    constant_docs: Mapping[str, str]
    imported: Mapping[str, Mapping[str, Builtin]] = field(default_factory=dict)

    def module_of(self, name: str) -> str | None:
        """The module that brings the builtin ``name``, None for any other name."""
        return next((module for module, builtins in self.imported.items() if name in builtins), None)


class Registry:
    """Collects the entries of one topic; ``@registry.define(...)`` stands beside each function."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.entries: dict[str, Builtin] = {}

    def define(
        self,
        name: str,
        parameters: str,
        result: str,
        doc: str,
        example: tuple[str, str] | None = None,
        intrinsic: str | None = None,
    ) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
        """Register the decorated function under ``name``."""

        def register(function: Callable[..., Any]) -> Callable[..., Any]:
            if name in self.entries:
                raise ValueError(f"{name} is registered twice")
            entry = Builtin(name, parameters, result, function, doc, example, self.topic, intrinsic=intrinsic)
            self.entries[name] = entry
            return function

        return register
