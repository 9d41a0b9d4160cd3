"""Functions of Python mode that stand for builtins of solids, profiles and paths, for parts, and for relations.

Names and parameters are those of the registries, written as Python writes them: ``offset-profile`` is
``offset_profile``, ``:join`` is ``join=``. The transpiler translates the calls, the prompts list them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from types import MappingProxyType

from scenelang.grammar.datum import dataclass
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.runtime.modelling_signatures import PARTS, SIGNATURES
from scenelang.interpreter.runtime.types import BuiltinParameter, Signature, parse_signature
from scenelang.interpreter.scene.declarations import RELATIONS, Relation

ASSERT_THAT = "assert_that"
VALUE = "value"  # another name of the operand of a relation that is no object
_OPERAND = lazy_pattern(r"\[?([A-Za-z][\w-]*)\]?")


@dataclass(frozen=True, slots=True)
class ModellingHelper:
    """Function of Python mode that stands for a builtin, or for a part of the library.

    Attributes
    ----------
    name, counterpart
        Name in Python and name of the builtin, or the word of the part.
    signature, result
        Parameters and type of the result of the builtin.
    module
        File that the program imports for it; empty for a builtin.
    """

    name: str
    counterpart: str
    signature: Signature
    result: str
    module: str = ""

    @property
    def is_word(self) -> bool:
        """Whether it is a word of the library of parts, which is called."""
        return bool(self.module) and self.is_shape

    @property
    def is_shape(self) -> bool:
        """Whether it makes a shape."""
        return self.result == "Entity"

    @property
    def draws(self) -> bool:
        """Whether it draws random numbers."""
        return any(parameter.name == "stream" for parameter in self.signature.keywords)

    @property
    def keywords(self) -> Mapping[str, BuiltinParameter]:
        """Keyword parameters by their names in Python."""
        return {python_name(parameter.name): parameter for parameter in self.signature.keywords}

    @property
    def positional(self) -> tuple[str, ...]:
        """Names of the positional parameters in Python, without that of the rest."""
        return tuple(python_name(parameter.name) for parameter in self.signature.positional)

    @property
    def usage(self) -> str:
        """Call with all parameters, such as ``point_at(path, t)``."""
        return f"{self.name}({', '.join(self._parameters())})"

    def _parameters(self) -> Iterator[str]:
        """Yield the parameters as a Python signature has them."""
        yield from (python_name(parameter.name) for parameter in self.signature.required)
        yield from (f"{python_name(parameter.name)}=None" for parameter in self.signature.optional)
        if self.signature.rest is not None:
            yield f"*{python_name(self.signature.rest.name)}"
        elif self.keywords:
            yield "*"
        yield from (f"{name}=None" for name in self.keywords)


@dataclass(frozen=True, slots=True)
class RelationHelper:
    """Relation as Python mode writes it within ``assert_that``: ``size("table", .75, axis="y")``.

    Attributes
    ----------
    name, relation
        Name in Python, and the relation.
    operands
        Names of the operands in Python; a call may pass them by name.
    """

    name: str
    relation: Relation
    operands: tuple[str, ...]

    @property
    def keywords(self) -> Mapping[str, str]:
        """Names of the options by their names in Python."""
        return {python_name(option): option for option in self.relation.keywords}

    @property
    def usage(self) -> str:
        """Call with all parameters, such as ``size(a, length=None, *, axis=None, within=None)``."""
        return f"{self.name}({', '.join(self._parameters())})"

    def _parameters(self) -> Iterator[str]:
        """Yield the parameters as a Python signature has them."""
        least, _ = self.relation.operand_counts
        yield from self.operands[:least]
        yield from (f"{name}=None" for name in self.operands[least:])
        yield "*more" if self.relation.is_open else "*"
        yield from (f"{name}=None" for name in self.keywords)


def is_vector(parameter: BuiltinParameter | None) -> bool:
    """Return whether a parameter takes a vector or a color, which Python writes as a tuple."""
    return parameter is not None and (parameter.name == "color" or parameter.type.name in ("Vector", "Point"))


def python_name(name: str) -> str:
    """Return a name of the language as Python writes it.

    >>> python_name("left-of")
    'left_of'
    """
    return name.replace("-", "_").replace(" ", "_").lower()


@cache
def modelling_helpers() -> Mapping[str, ModellingHelper]:
    """Return the functions for solids, profiles and paths by their names in Python."""
    helpers = (
        ModellingHelper(python_name(name), name, parse_signature(parameters), result)
        for name, (parameters, result) in SIGNATURES.items()
    )
    return MappingProxyType({helper.name: helper for helper in helpers})


@cache
def part_helpers() -> Mapping[str, ModellingHelper]:
    """Return the parts of the library and their sockets by their names in Python: ``chair``, ``table_top``."""
    helpers = (
        ModellingHelper(python_name(name), name, parse_signature(parameters), result, module)
        for name, (parameters, result, module) in PARTS.items()
    )
    return MappingProxyType({helper.name: helper for helper in helpers})


@cache
def scene_helpers() -> Mapping[str, ModellingHelper]:
    """Return the functions for solids, profiles, paths and parts by their names in Python."""
    return MappingProxyType({**part_helpers(), **modelling_helpers()})


@cache
def relation_helpers() -> Mapping[str, RelationHelper]:
    """Return the relations by their names in Python."""
    helpers = (RelationHelper(python_name(name), each, _operands(each)) for name, each in RELATIONS.items())
    return MappingProxyType({helper.name: helper for helper in helpers})


def _operands(relation: Relation) -> tuple[str, ...]:
    """Return the names of the operands in the usage of a relation: its words before the first option."""
    words = re.split(r"\s+\[?:", relation.usage.removeprefix(f"({relation.name} "))[0]
    return tuple(python_name(match) for match in _OPERAND.findall(words.replace("...", "")))
