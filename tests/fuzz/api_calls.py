"""Calls of the Python API with texts that are almost programs, and odd arguments: nothing but SceneError and UsageError may
leave it.

The texts are mutations of real programs, and special forms whose parts are other forms, patterns, arrays and dotted pairs.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from random import Random
from typing import Any

import scenelang as sl
from fuzz.mutations import Mutations
from scenelang.grammar.diagnostics import SceneError, UsageError
from scenelang.interpreter.expand.forms import FORMS
from scenelang.interpreter.values.limits import Limits

LIMITS = Limits(
    steps=100_000, depth=2_000, entities=10_000, primitives=10_000, size=200_000, memory=300_000_000, log=500
)
OPTIONS = sl.Options(limits=LIMITS)

ATOMS = (
    "x", "y", "loop", "_", "...", "=>", "else", "&keys", "&rest", ":x", ":scale", "x::Number", ":x::Shape", "::", "#t", "none", "0", "1", "-2.5",
    "1e400", "nan", '""', '"a"', '"cube"', "<h>", "std/call", "call", "bind", "define", "unquote", "syntax-rules", "quote", "λ", "|", "x.1", "inf",
)  # fmt: skip
SHAPES = (
    "({})", "({} {})", "({} {} {})", "(({}) {})", "(({} {}) ({} {}))", "[{} {}]", "[[{}] [{}]]", "({} . {})", "({} {} . {})", "'{}", "`(1 ,{} ,@{})", ",{}",
    ",@{}", "()", "[]", "(lambda ({}) {})", "(call {} {} {})", "(list {} {})", "(+ {} {})", "(translate [{} 0 0])", "(transform {} {})", "#;{} {}", "(begin {})",
    "(union {} {})", "(({} {} {}))", "((({} {}) {}) {})", "(let (({} {})) {})", "(if {} {} {})", "(define {} {})", "(define ({} {}) {})", "((unquote {}) {})",
)  # fmt: skip
ODD = (
    None,
    True,
    0,
    -1,
    3,
    1e400,
    float("nan"),
    "",
    "a",
    "cube",
    "\ud800",
    "\0",
    [],
    [1, 2, 3],
    [[0, 0, 0], [1, 1, 1]],
    {"a": 1},
    "x" * 5000,
    10**30,
)


def odd_form(random: Random, depth: int = 3) -> str:
    if depth <= 0 or random.random() < 0.35:
        return random.choice(ATOMS)
    if random.random() < 0.4:
        return special_form(random, depth - 1)
    return re.sub(r"\{\}", lambda _: odd_form(random, depth - 1), random.choice(SHAPES))


def special_form(random: Random, depth: int = 2) -> str:
    """A usage of a special form, of whose words some are other forms."""
    usage = random.choice(random.choice(tuple(FORMS.values())).usage.split(" or "))

    def other(match: re.Match[str]) -> str:
        choice = random.random()
        if choice < 0.35:
            return odd_form(random, depth - 1)
        return (
            ""
            if choice < 0.42
            else f"{match[0]} {odd_form(random, depth - 2)}"
            if choice < 0.5
            else random.choice(("x", "1", "(list 1 2)"))
        )

    head, parts = re.match(r"(\(\S*\s?)(.*)", usage, re.S).groups() if usage.startswith("(") else ("", usage)
    return head + re.sub(r"[^\s()\[\]]+", other, parts)


def text(random: Random) -> str:
    if random.random() < 0.25:
        return Mutations(random.randrange(1 << 30)).program()
    forms = [special_form(random, 3) for _ in range(random.choice((1, 1, 1, 2, 3)))]
    if random.random() < 0.6:
        forms = (
            [f'(bind "a" (lambda (x) {forms[0]}))', *forms[1:]]
            if random.random() < 0.5
            else [*forms, '(bind "a" (lambda () (call "cube")))']
        )
    return "\n".join(forms)


def make(random: Random) -> bytes:
    name = random.choice(tuple(CALLS))
    arguments = [random.choice(ODD) for _ in range(3)]
    return json.dumps([name, text(random), text(random) if random.random() < 0.1 else "", arguments]).encode()


# --- the calls -------------------------------------------------------------------------------------------------------


def _scene(text: str) -> sl.Scene:
    return sl.evaluate(text, options=OPTIONS)


def _read_scene(text: str, other: str, odd: list[Any]) -> None:
    scene = _scene(text)
    for value in (
        scene.words,
        scene.params,
        scene.animated,
        scene.bounds,
        scene.extents,
        scene.count(),
        scene.to_json(),
    ):
        str(value)
    scene.tree(), scene.tree_data(), scene.flatten(limit=1_000), repr(scene), scene.html()


def _ask_scene(text: str, other: str, odd: list[Any]) -> None:
    scene = _scene(text)
    for call in (
        lambda: scene.bounds_of(odd[0]), lambda: scene.measure(odd[0]), lambda: scene.instances(odd[1]), lambda: scene.frame(odd[2]),
        lambda: scene.tree(odd[0]), lambda: scene.flatten(odd[1], 1_000), lambda: scene.with_params({"x": odd[2]}),
        lambda: scene.restyled(odd[0], odd[1]), lambda: scene.diff(scene, odd[0]), lambda: scene.count(odd[1]),
    ):  # fmt: skip
        refused(call)


def refused(call: Callable[[], object]) -> None:
    try:
        call()
    except (SceneError, UsageError) as error:
        shown = str(error)
        assert "internal error" not in shown, shown[:300]
        assert len(shown) < 100_000


CALLS: dict[str, Callable[[str, str, list[Any]], object]] = {
    "parse": lambda text, other, odd: repr(sl.parse(text))[:10],
    "check": lambda text, other, odd: [str(d) for d in sl.check(text, options=OPTIONS).diagnostics],
    "evaluate": lambda text, other, odd: _scene(text),
    "expand": lambda text, other, odd: sl.expand(text, options=OPTIONS),
    "format": lambda text, other, odd: sl.format(text),
    "simplify": lambda text, other, odd: sl.simplify(text),
    "transpile": lambda text, other, odd: str(sl.transpile(text)),
    "repair": lambda text, other, odd: sl.repair(text, effort=1.0),
    "edit": lambda text, other, odd: sl.edit_instance(text, "a/cube", move=(1, 0, 0)),
    "edit form": lambda text, other, odd: sl.edit_instance(text, str(odd[0]), form=other),
    "edit attribute": lambda text, other, odd: sl.edit_instance(text, "a", attribute=("color", other)),
    "read": _read_scene,
    "ask": _ask_scene,
    "search": lambda text, other, odd: sl.search(text[:200]),
    "explain": lambda text, other, odd: sl.explain(text[:20]),
    "odd": lambda text, other, odd: [
        refused(lambda call=call: call(odd[0]))  # type: ignore[misc]
        for call in (sl.parse, sl.check, sl.evaluate, sl.expand, sl.format, sl.simplify, sl.transpile, sl.repair, sl.search, sl.explain, sl.load, sl.import_build)
    ],
}  # fmt: skip


def check(data: bytes) -> None:
    try:
        name, text, other, odd = json.loads(data)
        call = CALLS[name]
    except (ValueError, KeyError, TypeError):  # bytes that a search made of others
        return
    refused(lambda: call(text, other, odd))
