"""What lints want to know of one top-level form, gathered once and kept as long as the form stays the same."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.source import Span
from scenelang.interpreter.analyse import children, pattern_variables, walk
from scenelang.interpreter.library import Builtin
from scenelang.interpreter.lint.attributes import idle_attributes, optional_parameters
from scenelang.interpreter.lint.conditions import constant_conditions
from scenelang.interpreter.lint.names import shadowed_calls, unused_locals
from scenelang.interpreter.lint.poses import turned_after_moved
from scenelang.interpreter.scope import Variable
from scenelang.interpreter.values import Pair


@dataclass(frozen=True, slots=True, eq=False)
class Facts:
    """``word``: the one that the form binds. ``strings``: those outside the function of that very word. ``calls``: the
    constant words of calls; ``early`` those that run as soon as the form does. ``idle``: warnings by the primitive's
    word, should that be no word of the program. ``unfilled``: parameters that no call fills. ``local``: warnings that
    depend on nothing else."""

    form: Any
    word: str | None
    strings: frozenset[str]
    calls: tuple[tuple[str, Span], ...]
    early: tuple[tuple[str, Span], ...]
    idle: tuple[tuple[str, Diagnostic], ...]
    unfilled: tuple[Diagnostic, ...]
    local: tuple[Diagnostic, ...]
    defined: tuple[Variable, ...]
    used: frozenset[Variable]
    makes_strings: bool


def facts_of(form: Any) -> Facts:
    """The facts of a core form at top level."""
    nodes = list(walk(form))
    word = own_word(form)
    strings = {text for node in nodes if type(node) is ast.Constant for text in _strings(node.value)}
    targets = [node.target for node in nodes if type(node) is ast.Reference]
    return Facts(
        form,
        word,
        frozenset(strings - {word}) if word is not None else frozenset(strings),
        tuple(_calls(nodes)),
        tuple(_calls(_running_at_once(form))) if type(form) is not ast.Bind else (),
        tuple(idle_attributes(nodes)),
        tuple(optional_parameters(form, word)),
        (
            *unused_locals(nodes, form),
            *shadowed_calls(nodes, form),
            *constant_conditions(nodes, form),
            *turned_after_moved(nodes),
        ),
        tuple(pattern_variables(form.target)) if type(form) is ast.Define else (),
        frozenset(target for target in targets if isinstance(target, Variable) and target.is_global),
        any(isinstance(target, Builtin) and target.result == "String" for target in targets),
    )


def own_word(form: Any) -> str | None:
    """The word that a form binds, when it is written there."""
    if type(form) is ast.Bind and type(form.word) is ast.Constant and type(form.word.value) is str:
        return form.word.value
    return None


def _strings(value: Any) -> Iterator[str]:
    """Every string in a constant, quoted lists included."""
    stack = [value]
    while stack:
        item = stack.pop()
        if type(item) is str:
            yield item
        elif type(item) is Pair:
            stack += (item.car, item.cdr)


def _calls(nodes: Any) -> Iterator[tuple[str, Span]]:
    for node in nodes:
        if type(node) is ast.Call and type(node.word) is ast.Constant and type(node.word.value) is str:
            yield node.word.value, node.word.span


def _running_at_once(form: Any) -> Iterator[Any]:
    """The nodes outside functions."""
    stack = [form]
    while stack:
        node = stack.pop()
        if type(node) is not ast.Lambda:
            yield node
            stack.extend(children(node))


class FactBook:
    """The facts of forms that were met before, so that those of an unchanged form are not gathered again."""

    def __init__(self) -> None:
        self._facts: dict[int, Facts] = {}

    def of(self, forms: Sequence[Any]) -> list[Facts]:
        """The facts of every form of a program; those of other forms are forgotten."""
        known = self._facts
        facts = [known.get(id(form)) or facts_of(form) for form in forms]
        self._facts = {id(each.form): each for each in facts}
        return facts
