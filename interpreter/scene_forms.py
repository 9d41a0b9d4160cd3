"""Compiled call sites of ``bind``, ``call``, ``union``, ``union-loop`` and ``transform``.

They do what the prelude's definitions do (``stdlib/prelude.scene``), tested equal to them, without the detour.
"""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.source import Span
from scenelang.interpreter.entity import Entity
from scenelang.interpreter.parts import call_embeddings, copy_table, parts_of, transformed
from scenelang.interpreter.procedures import TAIL, Closure, Frame, Node
from scenelang.interpreter.show import show
from scenelang.interpreter.types import type_name
from scenelang.interpreter.values import (
    ANONYMOUS,
    IDENTITY,
    NIL,
    Embedding,
    Keyword,
    Matrix,
    Pair,
    Procedure,
    Table,
    make_list,
)

if TYPE_CHECKING:
    from scenelang.interpreter.compile import Compiler, Context
    from scenelang.interpreter.runtime import Runtime


def _placed(error: SceneError, span: Span) -> SceneError:
    if error.span is None:
        error.span = span
    return error


def compile_bind(compiler: Compiler, node: ast.Bind, context: Context) -> Node:
    word = compiler.compile(node.word, context.inner)
    function = compiler.compile(node.function, context.inner)
    rt, span = compiler.rt, node.span

    def bind(f: Frame) -> None:
        name = word(f)
        value = function(f)
        try:
            rt.bind_word(name, value, span)
        except SceneError as error:
            raise _placed(error, span) from None

    return bind


# --- call ------------------------------------------------------------------------------------------------------


def compile_call(compiler: Compiler, node: ast.Call, context: Context) -> Node:
    rt, span = compiler.rt, node.span
    word = compiler.compile(node.word, context.inner)
    plan = _attributes_only(node.arguments)
    if plan is None:
        return _general_call(rt, word, compiler.compile_all(node.arguments, context.inner), span)
    names, values = plan
    if all(_is_constant(value) for value in values):
        nodes = compiler.compile_all(values, context.inner)
        z = Embedding(None, None, {name: value([]) for name, value in zip(names, nodes)}) if names else ANONYMOUS
        return _constant_call(rt, word, z, frozenset(names), span)
    nodes = compiler.compile_all(values, context.inner)
    return _attribute_call(rt, word, tuple(zip(names, nodes)), span)


def _is_constant(node: ast.Expr) -> bool:
    """True for literals: numbers, strings, arrays of numbers."""
    if type(node) is ast.ArrayLiteral:
        return bool(node.items) and all(type(i) is ast.Constant and type(i.value) in (int, float) for i in node.items)
    return type(node) is ast.Constant


def _attributes_only(arguments: tuple[ast.Expr, ...]) -> tuple[list[str], list[ast.Expr]] | None:
    """Names and values when all arguments are literal ``:name value`` pairs, no name twice; else None."""
    names: list[str] = []
    values: list[ast.Expr] = []
    if len(arguments) % 2:
        return None
    for index in range(0, len(arguments), 2):
        name = arguments[index]
        if type(name) is not ast.Constant or type(name.value) is not Keyword or str(name.value) in names:
            return None
        names.append(str(name.value))
        values.append(arguments[index + 1])
    return names, values


def _constant_call(rt: Runtime, word: Node, z: Embedding, written: frozenset[str], span: Span) -> Node:
    def call(f: Frame) -> Any:
        name = word(f)
        try:
            if type(name) is not str:
                call_embeddings(rt, name, [])
            return rt.call_word(name, z, NIL, written, span)
        except SceneError as error:
            raise _placed(error, span)

    return call


def _attribute_call(rt: Runtime, word: Node, attributes: tuple[tuple[str, Node], ...], span: Span) -> Node:
    written = frozenset(name for name, _ in attributes)

    def call(f: Frame) -> Any:
        name = word(f)
        given = {}
        for key, node in attributes:
            value = node(f)
            given[key] = copy_table(rt, value) if type(value) is Table else value
        try:
            if type(name) is not str:
                call_embeddings(rt, name, [])
            return rt.call_word(name, Embedding(None, None, given), NIL, written, span)
        except SceneError as error:
            raise _placed(error, span)

    return call


def _general_call(rt: Runtime, word: Node, arguments: tuple[Node, ...], span: Span) -> Node:
    def call(f: Frame) -> Any:
        name = word(f)
        values = [argument(f) for argument in arguments]
        try:
            z, rest, written = call_embeddings(rt, name, values)
            return rt.call_word(name, z, make_list(rest), written, span)
        except SceneError as error:
            raise _placed(error, span)

    return call


# --- union -----------------------------------------------------------------------------------------------------


def add_parts(rt: Runtime, out: list[Any], value: Any, span: Span) -> None:
    """Append the parts that ``value`` is."""
    if type(value) is Pair and type(value.cdr) is Matrix and type(value.car) is Entity:
        out.append(value)
    elif type(value) is Entity:
        out.append(Pair(value, IDENTITY))
    else:
        try:
            out.extend(parts_of(rt, value))
        except SceneError as error:
            raise _placed(error, span) from None


def compile_union(compiler: Compiler, node: ast.Union, context: Context) -> Node:
    rt = compiler.rt
    members = tuple(zip(compiler.compile_all(node.members, context.inner), [m.span for m in node.members]))

    def union(f: Frame) -> Any:
        values = [(member(f), span) for member, span in members]
        out: list[Any] = []
        for value, span in values:
            add_parts(rt, out, value, span)
        return make_list(out)

    return union


def compile_union_loop(compiler: Compiler, node: ast.UnionLoop, context: Context) -> Node:
    rt, span = compiler.rt, node.span
    count = compiler.compile(node.count, context.inner)
    function = compiler.compile(node.function, context.inner)
    tick = rt.tick

    def loop(f: Frame) -> Any:
        turns = count(f)
        body = function(f)
        values: list[Any] = []
        add = values.append
        try:
            turns = _turns(turns)
            if not isinstance(body, Procedure):
                raise rt.not_a_procedure(body)
            if type(body) is Closure and body.arity == 1:
                run, env = body.body, body.env
                for i in range(turns):
                    tick()
                    value = run([env, i])
                    while value is TAIL:
                        tick()
                        value = rt.next_body(rt.next_frame)
                    add(value)
            else:
                for i in range(turns):
                    add(rt.apply(body, (i,)))
        except SceneError as error:
            if type(body) is Closure and error.span is not None and body.code.name != "lambda":
                error.called(f"`{body.code.name}`", span)
            raise _placed(error, span)
        out: list[Any] = []
        for value in values:
            add_parts(rt, out, value, span)
        return make_list(out)

    return loop


def _turns(count: Any) -> int:
    if type(count) is int:
        return count
    if type(count) is float and count.is_integer():
        return int(count)
    message = f"`union-loop` wants an Integer for the number of turns, got {type_name(count)}: {show(count, 60)}"
    raise SceneError("type", message, hint="round it: `(round n)`, `(floor n)`")


# --- transform -------------------------------------------------------------------------------------------------


def compile_transform(compiler: Compiler, node: ast.Transform, context: Context) -> Node:
    rt, span = compiler.rt, node.span
    part = compiler.compile(node.part, context.inner)
    matrix = compiler.compile(node.matrix, context.inner)

    def transform(f: Frame) -> Any:
        p = part(f)
        m = matrix(f)
        if type(p) is Entity and type(m) is Matrix and isfinite(sum(m)):
            return Pair(p, m)
        try:
            return transformed(rt, p, m)
        except SceneError as error:
            raise _placed(error, span) from None

    return transform
