"""All warnings about a program, less those that its comments allow."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.library import STD
from scenelang.interpreter.lint.facts import Facts
from scenelang.interpreter.lint.names import can_go, is_written, remove
from scenelang.interpreter.lint.removal import keeps_root
from scenelang.interpreter.lint.words import unreachable_words, word_warnings
from scenelang.interpreter.program import Program


def lint(program: Program, is_scene: Callable[[], bool]) -> list[Diagnostic]:
    """Warnings about a program without errors. ``is_scene()``: it is surely a scene, not a file of definitions for
    others to import; asked only where it matters."""
    own = [each for each in program.facts if not _is_library(each.form)]
    found = word_warnings(program)
    for each in own:
        found += [_with_safe_fixes(diagnostic, program) for diagnostic in each.local]
    found += unreachable_words(program)
    unused = list(_unused_globals(program, own))
    return [*found, *unused] if unused and is_scene() else found


def lint_of_forms(program: Program) -> list[Diagnostic]:
    """Warnings about single forms, for a program that has errors elsewhere."""
    local = (warning for each in program.facts if not _is_library(each.form) for warning in each.local)
    return [_with_safe_fixes(warning, program) for warning in local]


def _with_safe_fixes(diagnostic: Diagnostic, program: Program) -> Diagnostic:
    """Fixes that could make another word the root are not safe."""
    if all(not fix.safe or keeps_root(fix, program) for fix in diagnostic.fixes):
        return diagnostic
    fixes = (replace(fix, safe=fix.safe and keeps_root(fix, program)) for fix in diagnostic.fixes)
    return replace(diagnostic, fixes=tuple(fixes))


def _is_library(form: Any) -> bool:
    return str(form.span.source.name).startswith(STD)


def _unused_globals(program: Program, own: Sequence[Facts]) -> Iterator[Diagnostic]:
    """Top-level definitions of the main file that no other form reads, nor mentions in a macro."""
    params = {param.span for param in program.params}
    users: dict[Any, set[int]] = {}
    for each in program.facts:
        for variable in each.used:
            users.setdefault(variable, set()).add(id(each))
    for each in own:
        if each.form.span.source.name != program.main.name or each.form.span in params:
            continue
        for variable in each.defined:
            used = bool(users.get(variable, set()) - {id(each)})
            if used or len(each.defined) > 1 or not is_written(variable) or variable.name.startswith("_"):
                continue
            if not _is_mentioned(program, variable.name):
                fixes = (remove(each.form, safe=False),) if can_go(each.form) else ()  # who may import it?
                yield Diagnostic("unused", f"`{variable.name}` is never used", variable.span, fixes=fixes)


def _is_mentioned(program: Program, name: str) -> bool:
    """Whether the name stands in the main file more often than where it is defined: a macro may mean it."""
    alone = rf"(?<![^\s()\[\]'`,@]){re.escape(name)}(?![^\s()\[\]])"
    return len(re.findall(alone, program.main.text)) > 1
