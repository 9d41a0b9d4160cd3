"""Evaluation of programs while every value is compared with the kind that was inferred for its expression."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from scenelang import Session, Source
from scenelang.grammar import ast
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.checker.book import findings, misuses, needs_of
from scenelang.interpreter.checker.program import Program
from scenelang.interpreter.compile.compile import Compiler
from scenelang.interpreter.compile.kinds import Kind, describe
from scenelang.interpreter.runtime.procedures import TAIL, UNDEFINED
from scenelang.interpreter.scene.entity import Entity, Frames
from scenelang.interpreter.values.values import (
    NIL,
    Array,
    Condition,
    Embedding,
    HandleList,
    Keyword,
    Matrix,
    MutableArray,
    MutableList,
    Pair,
    Procedure,
    Record,
    Set,
    Stream,
    Symbol,
    Table,
    Vector,
)
from scenelang.session.session import run_with_room

_TAGS: dict[type, str] = {
    bool: "Boolean", int: "Integer", float: "Float", str: "String", type(None): "None", Symbol: "Symbol",
    Keyword: "Keyword", type(NIL): "List", Vector: "Vector", Matrix: "Matrix", Array: "Array",
    MutableArray: "MutableArray", MutableList: "MutableList", Table: "Table", Set: "Set", Stream: "Stream",
    Embedding: "Embedding", Entity: "Entity", Frames: "Frames", Condition: "Error", HandleList: "Handles",
    Record: "Record",
}  # fmt: skip
_FEW = 20  # items that are looked at


def tag_of(value: Any) -> str:
    if isinstance(value, Procedure):
        return "Function"
    if type(value) is not Pair:
        return _TAGS.get(type(value), type(value).__name__)
    if type(value.car) is Entity and type(value.cdr) is Matrix:
        return "Part"
    for _ in range(1000):
        value = value.cdr
        if type(value) is not Pair:
            break
    return "List" if value is NIL or type(value) is Pair else "Pair"


def contains(kind: Kind, value: Any, depth: int = 0) -> bool:
    """Whether a kind contains a value."""
    if kind.tag == "Any" or value is UNDEFINED:
        return True
    tag = tag_of(value)
    option = next((option for option in kind.options if option.tag == tag), None)
    if option is None or depth > 4:
        return option is not None
    if tag in ("List", "Vector"):
        items, rest = [], value
        if tag == "Vector":
            items = list(value)
        while type(rest) is Pair and len(items) < 200:
            items.append(rest.car)
            rest = rest.cdr
        if option.items is not None:
            return len(option.items) == len(items) and all(
                contains(each, item, depth + 1) for each, item in list(zip(option.items, items))[:_FEW]
            )
        return option.item is None or all(contains(option.item, item, depth + 1) for item in items[:_FEW])
    if tag == "Record":
        return option.code is None or option.code == value.type.name
    return True


@dataclass
class Traced:
    """What was found in one run: findings of the check, values outside their kinds, expressions that had a value."""

    program: Program | None
    findings: list[Diagnostic] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)
    evaluated: set[Any] = field(default_factory=set)  # expressions that had a value
    failing: list[tuple[Any, str]] = field(default_factory=list)
    error: Diagnostic | None = None
    errors: tuple[Diagnostic, ...] = ()

    @property
    def false_alarms(self) -> list[str]:
        """Errors about expressions that had a value."""
        return [
            f"{name}: {node.span.text[:80]}"
            for node, name in self.failing
            if name != "conditional-failure"
            and node in self.evaluated
            # The binding of a word has a value; its calls fail, if its function cannot return parts.
            and not (type(node) is ast.Bind and name == "parts")
        ]


def trace(source: Source, session: Session | None = None) -> Traced:
    """Check and run a program."""
    session = session or Session()
    checked = session.check(source)
    if checked.program is None:
        return Traced(None, errors=checked.diagnostics)
    program = checked.program
    errors = tuple(d for d in checked.diagnostics if d.is_error)
    results = program.kinds.of(program)
    traced = Traced(program, findings(program, None), errors=errors)
    traced.failing = [each for result in results for each in result.failing]
    needs = needs_of(results)
    traced.failing += [(passed.call, d.name) for result in results for passed, d in misuses(result, needs)]
    kinds = {node: kind for result in results for node, kind in result.kinds.items()}
    compile_ = Compiler.compile

    def compiled(self: Compiler, node: Any, context: Any) -> Any:
        run = compile_(self, node, context)
        kind = kinds.get(node)
        if kind is None:
            return run

        def look(frame: Any) -> Any:
            value = run(frame)
            if value is not TAIL and type(value).__name__ != "Mark":
                traced.evaluated.add(node)
                if kind.tag != "Any" and not contains(kind, value) and len(traced.wrong) < 20:
                    traced.wrong.append(f"{node.span.text[:80]!r}: {describe(kind)}, got {tag_of(value)}")
            return value

        return look

    Compiler.compile = compiled  # type: ignore[method-assign]
    try:
        if any(d.is_error for d in program.diagnostics):
            return traced
        runtime = session.runtime_of(source)
        runtime.hot = None  # only closures are compiled node by node
        run_with_room(lambda: session._run(program, runtime), session.options.limits.depth)
    except SceneError as error:
        traced.error = error.diagnostic
    finally:
        Compiler.compile = compile_  # type: ignore[method-assign]
    return traced
