"""What can be told of a program's words before it runs: which one is the root, which look like mistakes."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.source import Span
from scenelang.interpreter.analyse import children, walk
from scenelang.interpreter.program import Program
from scenelang.interpreter.shapes import GEOMETRY, WORDS
from scenelang.interpreter.values import Keyword, Pair

_NEAR = 0.84
_ALL_GEOMETRY = frozenset(name for names in GEOMETRY.values() for name in names)


def _strings(value: Any) -> Iterator[str]:
    """Every string in a constant, quoted lists included."""
    stack = [value]
    while stack:
        item = stack.pop()
        if type(item) is str:
            yield item
        elif type(item) is Pair:
            stack += (item.car, item.cdr)


def _own_word(form: Any) -> str | None:
    if type(form) is ast.Bind and type(form.word) is ast.Constant and type(form.word.value) is str:
        return form.word.value
    return None


def find_root(program: Program) -> tuple[str, list[Diagnostic]]:
    """The root word (language.md, section 5, "Root") and warnings; raises SceneError when there is none."""
    if program.scene is not None and type(program.scene.word) is ast.Constant:
        if type(program.scene.word.value) is str:
            return program.scene.word.value, []
        raise SceneError("word", "`scene` wants a string for the root's word", None, program.scene.span)
    words = program.words or program.all_words
    if not words:
        hint = 'bind one: `(bind "word" (lambda () (call "cube")))`'
        raise SceneError("no-root", "the program binds no word, so there is no scene", hint)
    used = _words_used(program)
    candidates = [word for word in words if word not in used]
    if not candidates:
        candidates = [word for word in program.all_words if word not in used]
    if not candidates:
        return list(words)[-1], []
    root = candidates[-1]
    if len(candidates) == 1:
        return root, []
    listed = ", ".join(f'"{word}"' for word in candidates)
    message = f'several words could be the root: {listed}; taking the last, "{root}"'
    hint = f'say which: `(scene "{root}")` or --root'
    return root, [Diagnostic("ambiguous-root", message, program.all_words.get(root), hint)]


def _words_used(program: Program) -> set[str]:
    """Words whose string occurs outside their own function."""
    used: set[str] = set()
    for form in program.forms:
        own = _own_word(form)
        start = form.function if own is not None else form
        for node in walk(start):
            if type(node) is ast.Constant:
                used.update(text for text in _strings(node.value) if text != own)
    return used


def word_warnings(program: Program) -> list[Diagnostic]:
    """Calls of words that look misspelled or come too early, and parameters that a ``call`` never fills."""
    found: list[Diagnostic] = []
    bound: set[str] = set()
    for form in program.forms:
        if type(form) is not ast.Bind:
            found += _early_calls(program, form, bound)
        own = _own_word(form)
        if own is not None:
            bound.add(own)
            found += _optional_parameters(own, form)
        for node in walk(form):
            if type(node) is ast.Call:
                found += _near_word(program, node)
                found += _idle_attributes(program, node)
    return found


def _early_calls(program: Program, form: Any, bound: set[str]) -> Iterator[Diagnostic]:
    """Words called by a top-level expression before their ``bind``; bodies of functions run later."""
    stack = [form]
    while stack:
        node = stack.pop()
        if type(node) is ast.Lambda:
            continue
        if type(node) is ast.Call and type(node.word) is ast.Constant:
            word = node.word.value
            if word in program.all_words and word not in bound:
                yield Diagnostic("undefined-word", f'"{word}" is called here before it is bound', node.span)
        stack.extend(children(node))


def _optional_parameters(word: str, form: ast.Bind) -> Iterator[Diagnostic]:
    function = form.function
    if type(function) is ast.Lambda:
        for parameter in function.parameters:
            if parameter.kind == "optional":
                hint = f"make it a keyword parameter: `(:{parameter.name} default)`"
                message = f'a `call` of "{word}" never fills `{parameter.name}`; it keeps its default'
                yield Diagnostic("optional-embedding", message, function.span, hint)


def _idle_attributes(program: Program, node: ast.Call) -> Iterator[Diagnostic]:
    """Attributes of a geometric primitive that its geometry does not read, though another's does, or nearly so."""
    word = node.word.value if type(node.word) is ast.Constant else None
    if word in program.all_words or word not in GEOMETRY:
        return
    for argument in node.arguments:
        if type(argument) is not ast.Constant or type(argument.value) is not Keyword:
            continue
        name = str(argument.value)
        hint = idle_hint(word, name)
        if hint is not None:
            yield Diagnostic("idle-attribute", f'a "{word}" does not read the attribute `:{name}`', argument.span, hint)


def idle_hint(word: str, name: str) -> str | None:
    """A hint for an attribute that a geometric primitive does not read, though another's geometry does, or nearly so;
    None where it is read, or may be the program's own."""
    read = GEOMETRY[word]
    if name in read:
        return None
    near = get_close_matches(name.lower(), read, n=1, cutoff=0.75)
    if near:
        return f"did you mean `:{near[0]}`?"
    return "it reads " + ", ".join(f"`:{n}`" for n in read) if name in _ALL_GEOMETRY else None


def _near_word(program: Program, node: ast.Call) -> Iterator[Diagnostic]:
    word = node.word.value if type(node.word) is ast.Constant else None
    if type(word) is not str or word in program.all_words or word in WORDS:
        return
    known = [*program.all_words, *WORDS]
    near = [other for other in known if sorted(other) == sorted(word)] or get_close_matches(word, known, 1, _NEAR)
    if near:
        message = f'"{word}" is never bound, so it is a primitive of its own'
        place: Span = node.word.span
        yield Diagnostic("near-word", message, place, f'did you mean "{near[0]}"?')
