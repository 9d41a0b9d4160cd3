"""Registered functions by all the texts that call them, and which of them is the root of the scene."""

from __future__ import annotations

import ast

from scenelang.interpreter.transpile.analysis.paths import Paths
from scenelang.interpreter.transpile.analysis.scopes import Function, Names


def registered_words(names: Names) -> dict[str, Function]:
    """What ``library_call`` may say -> the function: by name first (the last definition wins), then by the text it was
    registered with, then by that text up to its first ``;``."""
    registered = [f for f in names.ordered if f.is_registered and f.word is not None]
    words: dict[str, Function] = {}
    for function in registered:
        words[str(function.word)] = function
    current = [f for f in registered if words[str(f.word)] is f]
    for function in current:
        words.setdefault(function.text, function) if function.text else None
    for function in current:
        start = function.text.partition(";")[0].strip()
        words.setdefault(start, function) if start else None
    return words


def find_root(names: Names, paths: Paths, words: dict[str, Function]) -> Function | None:
    """The paper's own tool takes the common ancestor of the call graph; if there is none, the last function with no
    callers and at least one callee; else the last registered. An animation comes before all."""
    firsts: dict[str, Function] = {}
    for function in names.ordered:
        if function.is_registered and function.word is not None:
            firsts.setdefault(function.word, words[function.word])
    functions = list(firsts.values())
    animations = [f for f in functions if f.is_animation]
    if animations:
        return animations[-1]
    if not functions:
        return None
    callees = {function: _callees(function, names, paths, words) - {function} for function in functions}
    for function in functions:
        if len(functions) > 1 and _reachable(function, callees) >= set(functions) - {function}:
            return function
    called = {callee for found in callees.values() for callee in found}
    tops = [f for f in functions if f not in called and callees[f]]
    return tops[-1] if tops else functions[-1]


def _callees(function: Function, names: Names, paths: Paths, words: dict[str, Function]) -> set[Function]:
    """The registered functions that ``function`` calls, itself or through plain functions of the program."""
    found: set[Function] = set()
    seen: set[Function] = set()
    stack = [function]
    while stack:
        current = stack.pop()
        if current in seen:
            continue
        seen.add(current)
        for node in ast.walk(current.node):
            if isinstance(node, ast.Call) and paths.of(node.func) == "library_call":
                word = node.args[0] if node.args else None
                if isinstance(word, ast.Constant) and str(word.value) in words:
                    found.add(words[str(word.value)])
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                variable = names.variables.get(node)
                for used in variable.functions if variable is not None else ():
                    if used.is_registered:
                        found.add(words[str(used.word)])
                    else:
                        stack.append(used)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in words:
                if words[node.value].word == node.value:
                    found.add(words[node.value])
    return found


def _reachable(function: Function, callees: dict[Function, set[Function]]) -> set[Function]:
    found: set[Function] = set()
    stack = [function]
    while stack:
        for callee in callees[stack.pop()]:
            if callee not in found:
                found.add(callee)
                stack.append(callee)
    return found
