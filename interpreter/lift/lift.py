"""Lifting of a program: applies the rules until nothing changes, and keeps what would become longer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import dataclass

from scenelang.grammar.concrete import concrete
from scenelang.grammar.datum import Datum, Source, atom_text, walk
from scenelang.grammar.formatter import settled
from scenelang.grammar.layout import Trivia, layout_lines
from scenelang.interpreter.expand.forms import FORMS, INDENTS
from scenelang.interpreter.lift import patterns, simplify, tables
from scenelang.interpreter.lift.tree import (
    NO_COMMENTS,
    CodeTree,
    OpenProgram,
    code,
    copied,
    datum_of,
    defined_names,
    depth_exceeds,
    node_of,
    same,
    size,
)
from scenelang.interpreter.lift.tree import walk as walk_tree
from scenelang.interpreter.scene.primitives import block_words

_MAX_PASSES = 4  # what one pass removes may leave something unused; none of 10,000 programs needed a fourth
_MAX_REWRITES = 8  # of one form in a pass: what a rule changes, another one may change again
_MAX_SURVEYED_REWRITES = 1  # with a survey after each; later, what the first ones know still holds
_MAX_NODES = 60_000  # nodes of a program
_MACROS = ("define-syntax", "define-macro", "let-syntax", "letrec-syntax")
_LIBRARY = ("std/python.scene",)


@dataclass(frozen=True, slots=True)
class Lifted:
    """Program after lifting: its forms, their comments and spellings by ``id``. Unchanged forms are the same."""

    forms: tuple[Datum, ...]
    trivia: Mapping[int, Trivia]
    spelling: Mapping[int, str]


def lift(
    forms: Sequence[Datum],
    trivia: Mapping[int, Trivia],
    spelling: Mapping[int, str],
    library: Set[str],
    fixed: Set[int] = frozenset(),
) -> Lifted:
    """Return an equal program that is easier to read, and not longer.

    Primitives, words, hierarchy, attributes, handles, draws of random numbers and frames stay the same; poses differ by
    rounding.

    Parameters
    ----------
    forms, trivia, spelling
        The program, with its comments and the spelling of atoms by ``id(datum)``.
    library
        Names that the standard library defines.
    fixed
        Ids of datums that must stay as they are, with the forms that contain them.
    """
    same = Lifted(tuple(forms), trivia, spelling)
    if any(depth_exceeds(form) for form in forms):
        return same
    nodes = [node_of(form, trivia, spelling) for form in forms]
    if sum(map(size, nodes)) > _MAX_NODES:
        return same
    originals = {id(node): form for node, form in zip(nodes, forms)}
    program = _program(nodes, library)
    kept = [id(node) for node, form in zip(nodes, forms) if fixed and any(id(datum) in fixed for datum in walk(form))]
    _lift_forms(program, kept)
    if _omits_zeros(spelling):
        _omit_zeros(program)
    notes, texts = dict(trivia), dict(spelling)
    result = [
        _same_form(node, originals.get(id(node)), trivia, spelling) or datum_of(node, notes, texts)
        for node in program.forms
    ]
    return Lifted(tuple(result), notes, texts)


def _omits_zeros(spelling: Mapping[int, str]) -> bool:
    """Return whether a program writes ``.5`` rather than ``0.5``."""
    short = sum(text.lstrip("-").startswith(".") for text in spelling.values())
    return short > sum(text.lstrip("-").startswith("0.") for text in spelling.values())


def _omit_zeros(program: OpenProgram) -> None:
    """Write new numbers as the program writes its own."""
    for top in program.forms:
        for node in walk_tree(top):
            if type(node.value) is float and node.spelling is None and 0 < abs(node.value) < 1:
                text = atom_text(node.value)
                node.spelling = text.replace("0.", ".", 1) if text.lstrip("-").startswith("0.") else None


def lift_text(source: Source, library: Set[str]) -> str:
    """Return the formatted text of a lifted program, which must be valid."""
    tree = concrete(source)
    lifted = lift(tree.forms, tree.trivia, tree.spelling, library, tree.written.raw.keys())
    if all(new is old for new, old in zip(lifted.forms, tree.forms)) and len(lifted.forms) == len(tree.forms):
        return source.text
    lines = layout_lines(
        lifted.forms,
        indents=INDENTS,
        trivia=lifted.trivia,
        spelling=lifted.spelling,
        end=tree.end,
        written=tree.written,
    )
    return settled("\n".join([*lines, ""]), INDENTS)


def _same_form(
    node: CodeTree, original: Datum | None, trivia: Mapping[int, Trivia], spelling: Mapping[int, str]
) -> Datum | None:
    """Return the original of a form that did not change."""
    if original is None or node.trivia is not trivia.get(id(original), NO_COMMENTS):
        return None
    return original if same(node, node_of(original, trivia, spelling)) else None


def _program(nodes: list[CodeTree], library: Set[str]) -> OpenProgram:
    called = {one.operands[0].value for node in nodes for one in code(node) if one.head == "call" and one.operands}
    macros = {name for node in nodes for one in code(node) if one.head in _MACROS for name in _macro_names(one)}
    imports = [node.operands[0].value for node in nodes if node.head == "import" and node.operands]
    program = OpenProgram(
        nodes,
        frozenset(FORMS.keys() | library),
        any(word in called for word in block_words()),
        any(name not in _LIBRARY for name in imports),
        frozenset(macros),
    )
    program.survey()
    return program


def _macro_names(node: CodeTree) -> Sequence[str]:
    if node.head in ("define-syntax", "define-macro"):
        return list(defined_names(node))
    bindings = node.operands[0].items if node.operands else None
    return [str(binding.items[0].value) for binding in bindings or () if binding.items]


_RULES: Sequence[Callable[[OpenProgram, CodeTree], bool]] = (
    simplify.shorten,
    patterns.find,
    tables.find,
    simplify.inline,
    patterns.align,
)


def _lift_forms(program: OpenProgram, fixed: Sequence[int]) -> None:
    """Apply all rules to a program in place until nothing changes; a form that would become longer stays as it is."""
    if FORMS.keys() - program.known:  # the program gives a form another meaning
        return
    before = sum(map(size, program.forms))
    is_whole = not fixed and not program.macros and not program.has_imports
    for _ in range(_MAX_PASSES):
        has_changed = is_whole and any([simplify.remove_unused(program), simplify.declare_params(program)])
        if has_changed:
            program.survey()
        has_changed |= _rewrite_forms(program, fixed)
        if is_whole:
            has_changed |= simplify.declare_params(program, before - sum(map(size, program.forms)))
        if not has_changed:
            return
        program.survey()


def _rewrite_forms(program: OpenProgram, fixed: Sequence[int]) -> bool:
    """Apply the rules for single forms; return whether that changes any."""
    waiting = [
        position for position, top in enumerate(program.forms) if id(top) not in fixed and program.is_understood(top)
    ]
    everything, has_changed = list(waiting), False
    for number in range(_MAX_REWRITES):
        waiting = [position for position in waiting if _rewrite(program, position)]
        if not waiting:
            break
        has_changed = True
        if number < _MAX_SURVEYED_REWRITES:
            known = program.known
            program.survey()
            waiting = waiting if program.known == known else list(everything)  # a name of the library is free again
    return has_changed


def _rewrite(program: OpenProgram, position: int) -> bool:
    """Apply all rules to a form once; return whether that changes it, which must not make it longer."""
    top = program.forms[position]
    new = copied(top, comments=True)
    changed = [rule(program, new) for rule in _RULES]
    if not any(changed) or size(new) > size(top):
        return False
    program.forms[position] = new
    return True
