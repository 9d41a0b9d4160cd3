"""What is to be said of a name, a word, an attribute: signatures and documentation as Markdown."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from scenelang.attributes import attribute_doc, attributes_of
from scenelang.grammar import ast
from scenelang.grammar.source import Span, comment_above
from scenelang.interpreter.library import STD, Builtin
from scenelang.interpreter.params import Param
from scenelang.interpreter.scope import ConstantBinding, Macro, PaperForm, Special, Variable
from scenelang.interpreter.shapes import PRIMITIVES
from scenelang.lsp.names import Names
from scenelang.stdlib.reference import Record, lookup


def code(text: str) -> str:
    return f"```scene\n{text}\n```"


def of_record(record: Record) -> str:
    """The documentation of a name of the library."""
    parts = [code(record.signature), record.doc]
    parts += [f"`{example.expression}` gives `{example.value}`" for example in record.examples[:2]]
    if record.module is not None:
        parts.append(f'comes with `(import "{record.module}")`')
    return "\n\n".join(parts)


def of_library(binding: Any, name: str) -> Record | None:
    """What the library says of a binding that comes from it."""
    if isinstance(binding, Builtin):
        return lookup(binding.name)
    if isinstance(binding, Special):
        return lookup(binding.name)
    if isinstance(binding, (PaperForm, ConstantBinding)):
        return lookup(name.removeprefix(STD))
    if isinstance(binding, Variable) and binding.span is not None and binding.span.source.name.startswith(STD):
        return lookup(binding.name)
    return None


def of_binding(names: Names, binding: Any, name: str) -> str:
    """The Markdown of a name where it stands."""
    record = of_library(binding, name)
    if record is not None:
        return of_record(record)
    if isinstance(binding, Macro):
        return "\n\n".join([code(f"({binding.name} ...)"), "a macro of this program", *_comment(names, binding.span)])
    if not isinstance(binding, Variable):
        return code(name)
    param = _param(names, binding)
    if param is not None:
        return "\n\n".join(part for part in (code(_param_text(param)), param.doc, "a param") if part)
    form = names.definitions.get(binding)
    if form is None:
        return f"{code(binding.name)}\n\na local name" if not binding.is_global else code(binding.name)
    return "\n\n".join([code(signature(binding.name, form.value)), *_comment(names, form.span)])


def of_word(names: Names, word: str) -> str:
    """The Markdown of a word: how it is called, what the program says above its function, where it is used."""
    form = names.definitions.get(word)
    if form is None:
        if word in PRIMITIVES:
            shape = f"(call {quoted(word)} {' '.join(f':{name}' for name in attributes_of(word))})"
            rows = [f"- `:{name}`: {attribute_doc(word, name)}" for name in attributes_of(word)]
            return "\n\n".join([code(shape), PRIMITIVES[word], "\n".join(rows)])
        return f"{code(f'(call {quoted(word)} ...)')}\n\na word that nothing binds: a primitive of its own"
    uses = sum(1 for use in names.uses_of_word(word) if not use.defines)
    times = "once" if uses == 1 else f"{uses} times"
    return "\n\n".join([code(call_shape(word, form.function)), *_comment(names, form.span), f"used {times} here"])


def of_attribute(names: Names, word: str, name: str) -> str | None:
    """The Markdown of an attribute in a call of a word."""
    form = names.definitions.get(word)
    if form is None:
        doc = attribute_doc(word, name)
        return f"{code(f':{name}')}\n\n{doc}" if doc is not None else None
    function = form.function
    for parameter in function.parameters if type(function) is ast.Lambda else ():
        if parameter.kind == "keyword" and parameter.name == name:
            return f"{code(_parameter_text(parameter))}\n\na parameter of {quoted(word)}"
    return None


def quoted(word: str) -> str:
    return '"' + word.replace("\\", "\\\\").replace('"', '\\"') + '"'


def call_shape(word: str, function: Any) -> str:
    """How a word is called: ``(call "chair" :seat :color ...)``."""
    parameters = function.parameters if type(function) is ast.Lambda else ()
    keywords = [_parameter_text(p) for p in parameters if p.kind == "keyword"]
    return f"(call {' '.join([quoted(word), *keywords])})"


def signature(name: str, value: Any) -> str:
    """How a definition is used."""
    if type(value) is not ast.Lambda:
        text = " ".join(value.span.text.split()) if value.span.expansion is None else "..."
        return f"(define {name} {text if len(text) <= 60 else text[:57] + '...'})"
    return f"({' '.join([name, *(_parameter_text(p) for p in value.parameters)])})"


def _parameter_text(parameter: ast.Parameter) -> str:
    typed = f"{parameter.name}::{parameter.type.name}" if parameter.type is not None else parameter.name
    name = f":{typed}" if parameter.kind == "keyword" else typed
    if parameter.kind in ("rest", "keys"):
        return f". {name}" if parameter.kind == "rest" else f"&keys {name}"
    if parameter.default is None:
        return name
    text = parameter.default.span.text
    return f"[{name} {text}]" if len(text) <= 24 and "\n" not in text else f"[{name}]"


def _param(names: Names, variable: Variable) -> Param | None:
    params = names.version.program.params
    return next((param for param in params if param.name == variable.name), None) if variable.is_global else None


def _param_text(param: Param) -> str:
    ends = "".join(
        f" :{name} {value:g}" for name, value in (("min", param.minimum), ("max", param.maximum)) if value is not None
    )
    return f"(param {param.name} {param.default}{ends})"


def _comment(names: Names, span: Span | None) -> list[str]:
    """The comment directly above a definition."""
    if span is None:
        return []
    place = names.version.place(span)
    comment = _comment_text(comment_above(place.source, place.start))
    return [comment] if comment else []


def _comment_text(lines: Iterable[str]) -> str:
    """The text of comment lines below the last rule that divides the file."""
    found: list[str] = []
    for line in lines:
        found = [] if set(line) <= {";", "-", " ", "="} else [*found, line.lstrip("; ")]
    return "\n".join(found)
