"""Lint rules that inspect a single top-level form. Their results are cached until the form changes."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Datum, ListDatum, Source, Span, dataclass, subdatums
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix, SceneError, close_matches, may_resemble, near_names
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.grammar.reader import read
from scenelang.interpreter.checker.common import MAX_SHOWN
from scenelang.interpreter.checker.other_tools import calls_of_other_tools, hint_for_primitive
from scenelang.interpreter.compile.analyze import called_builtin, children, pattern_variables, strings_in, walk
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.scene.primitives import (
    COLOR,
    MATERIALS,
    PHYSICS,
    SCALE,
    find,
    geometry_attributes,
    is_word,
    solid_words,
)
from scenelang.interpreter.scene.setup import PROPERTIES
from scenelang.interpreter.values.values import Keyword

if TYPE_CHECKING:
    from scenelang.interpreter.checker.program import Program
    from scenelang.interpreter.scene.primitives.base import Attribute


# --- parameters that no call passes, values that no template takes ---------------------------------------------------


def optional_parameters(form: Any, word: str | None) -> Iterator[Diagnostic]:
    """Report optional positional parameters of an entity function, which ``call`` never passes.

    ``form`` is a ``bind`` and ``word`` the word that it binds. Without a word, nothing is reported.
    """
    function = form.function if word is not None else None
    if type(function) is ast.Lambda:
        for parameter in function.parameters:
            if parameter.kind == "optional":
                hint = f"make it a keyword parameter: `(:{parameter.name} default)`"
                message = f'`call` never passes the optional parameter `{parameter.name}` of "{word}"'
                yield Diagnostic("optional-embedding", message, function.span, hint)


# The directives of C, Python, Common Lisp and Scheme, in the order of their values.
_DIRECTIVE = lazy_pattern(r"~[asdfgvwADSFGVW]|%(?:\.\d+)?[sdifgeuxr]")


def unused_values(nodes: Iterable[Any]) -> Iterator[Diagnostic]:
    """Report values of ``format`` that no field of a literal template takes."""
    for node in nodes:
        if called_builtin(node) != "format" or not node.arguments or type(node.arguments[0]) is not ast.Constant:
            continue
        template, values = node.arguments[0], node.arguments[1:]
        taken = _taken_values(template.value) if type(template.value) is str else None
        if taken is None or len(values) <= taken:
            continue
        fields = f"{taken} field{'s' * (taken != 1)}" if taken else "no field"
        message = f"the template of `format` has {fields}, so {values[taken].span.text} is not written"
        written, directives = _DIRECTIVE.subn("{}", template.span.text)
        fixes: tuple[Fix, ...] = ()
        if not taken and directives == len(values):
            fixes = (Fix(f"Change to `{written}`", (Edit(template.span, written),), safe=False),)
        yield Diagnostic("unused-value", message, values[taken].span, "a field is written `{}`", fixes=fixes)


def _taken_values(template: str) -> int | None:
    """Return the number of values that a template of ``format`` takes, or None if it is malformed."""
    count = last = 0
    try:
        from string import Formatter

        for _, name, spec, _ in Formatter().parse(template):
            nested = [inner_name for _, inner_name, _, _ in Formatter().parse(spec or "")]
            for field in (name, *nested):
                count += field == ""
                last = max(last, int(field) + 1 if field is not None and field.isdecimal() else 0)
    except ValueError:
        return None
    return max(count, last)


# --- poses that are probably composed in the wrong order -------------------------------------------------------------


def turned_after_moved(nodes: Iterable[Any]) -> Iterator[Diagnostic]:
    """Report a part that is translated and then rotated by a constant angle about the origin.

    Three cases are excluded: a variable angle arranges parts in a circle, a translation along the axis commutes with
    the rotation, and a rotation between two translations has its pivot written out. Only poses that are written in one
    place are compared.
    """
    for node in nodes:
        if type(node) is ast.Transform:
            factors = _factors(node)
            for before, rotation, translation in zip([None, *factors], factors, factors[1:]):
                if (
                    called_builtin(before) != "translate"
                    and rotation.span.expansion is None
                    and _is_constant_rotation(rotation)
                    and _is_off_axis(rotation, translation)
                ):
                    yield _pose_warning(rotation, translation)


def _factors(node: ast.Transform) -> list[Any]:
    """Return the matrices that are applied to the part, the last applied first."""
    last_factors = _product(node.matrix)
    if type(node.part) is not ast.Transform:
        return last_factors
    factors: list[Any] = []
    part: Any = node
    while type(part) is ast.Transform and len(factors) < 2:
        factors += _product(part.matrix)
        part = part.part
    return factors[: len(last_factors) + 1]


def _product(matrix: Any) -> list[Any]:
    """Return the factors of nested products ``(@ pose ...)``."""
    if called_builtin(matrix) == "@":
        return [factor for argument in matrix.arguments for factor in _product(argument)]
    return [matrix]


def _is_constant_rotation(node: Any) -> bool:
    """Return whether ``node`` is a ``rotate`` about the origin whose angle does not depend on local variables."""
    if called_builtin(node) != "rotate" or len(node.arguments) != 2:
        return False
    return not any(
        type(part) is ast.Reference and isinstance(part.target, Variable) and not part.target.is_global
        for part in walk(node.arguments[0])
    )


def _is_off_axis(rotation: Any, translation: Any) -> bool:
    """Return whether ``translation`` certainly has a component perpendicular to the axis of ``rotation``."""
    if called_builtin(translation) != "translate" or len(translation.arguments) != 1:
        return False
    axis, offset = _numbers(rotation.arguments[1]), _numbers(translation.arguments[0])
    if axis is None or offset is None:
        return False
    return any(shift not in (0, None) and along == 0 for along, shift in zip(axis, offset))


def _numbers(node: Any) -> list[float | None] | None:
    """Return the items of an array literal, with None for items that are not constant, or None for other nodes."""
    if type(node) is not ast.ArrayLiteral:
        return None
    return [item.value if type(item) is ast.Constant else None for item in node.items]


def _pose_warning(rotation: Any, translation: Any) -> Diagnostic:
    """Return the warning about a rotation after a translation, with the fix that exchanges them."""
    turn: Span = rotation.span
    move: Span = translation.span
    message = "the part is rotated about the origin after it was translated, so it swings away from its position"
    hint = "rotate first and then translate, or pass a pivot point to `rotate`"
    fixes: tuple[Fix, ...] = ()
    if move.expansion is None and not move.overlaps(turn):
        fixes = (Fix("Rotate first", (Edit(turn, move.text), Edit(move, turn.text))),)
    return Diagnostic("turned-after-moved", message, turn, hint, fixes=fixes)


# --- expressions that can be removed without changing the behavior of the program -----------------------------------
#
# A safe fix never changes the behavior of a valid program, except for four that correct a value without effect (W402,
# W405, W407, W608). It leaves alone whatever could fail: an array of non-numbers, a name that is read before its
# definition, a comparison of a variable with itself. It also leaves assigned variables, macro arguments, the only form
# of a body, and code that mentions a word on which the root depends. Only editors offer fixes that guess.


def written_nodes(form: Any) -> Iterator[Any]:
    """Iterate over the nodes of a form that are not operands of a macro, which may use them in any way."""
    stack = [form]
    while stack:
        node = stack.pop()
        if node.span.expansion is None:
            yield node
            stack.extend(children(node))


def is_inert(node: Any, ready: Collection[Any] = ()) -> bool:
    """Return whether evaluating an expression has no effects, cannot fail, and draws no random numbers.

    ``ready`` are the local variables that have been defined at this point.
    """
    kind = type(node)
    if kind is ast.Constant or kind is ast.Lambda:
        return True
    if kind is ast.Reference:
        target = node.target
        return isinstance(target, Builtin) or target in ready or (isinstance(target, Variable) and not target.recursive)
    return kind is ast.ArrayLiteral and all(
        type(item) is ast.Constant and type(item.value) in (int, float) for item in node.items
    )


def preserves_root(fix: Fix, program: Program) -> bool:
    """Return whether a fix cannot change the root, which is inferred from the words that a program does not mention."""
    if program.scene is not None:
        return True
    for edit in fix.edits:
        before = edit.span.text
        if "\\" in before or any(before.count(f'"{w}"') > edit.text.count(f'"{w}"') for w in program.all_words):
            return False
    return True


def is_followed(form: Any, span: Span) -> bool:
    """Return whether the form at ``span`` is followed by another form, other than a string, in the same list."""
    enclosing = _enclosing_list(form.span, span)
    if enclosing is None:
        return False
    items = enclosing.items
    position = next(i for i, item in enumerate(items) if item.span.start == span.start - form.span.start)
    if position + 1 >= len(items) or enclosing.tail is not None:
        return False
    following = items[position + 1]
    return isinstance(following, ListDatum) or type(getattr(following, "value", "")) is not str


def _enclosing_list(outer: Span, inner: Span) -> ListDatum | None:
    """Return the list that has a direct item, other than its first, at the start of ``inner``, or None."""
    return _lists_of(outer.text).get(inner.start - outer.start)


@lru_cache(maxsize=1)  # the findings in a form are made one after another
def _lists_of(text: str) -> Mapping[int, ListDatum]:
    """Return the lists in a text by the starts of their items."""
    try:
        pending: list[Datum] = list(read(Source("<form>", text)).forms)
    except SceneError:
        return {}
    lists: dict[int, ListDatum] = {}
    for datum in pending:  # the loop appends to it, so outer lists come first
        if isinstance(datum, ListDatum):
            for item in datum.items[1:]:
                lists.setdefault(item.span.start, datum)
        pending += subdatums(datum)
    return lists


def with_spacing(span: Span, text: str) -> str | None:
    """Pad ``text`` for insertion at ``span`` so that it does not merge with its neighbors.

    Returns None if a prefix forbids it.
    """
    around = span.source.text
    before, after = around[: span.start][-1:], around[span.end : span.end + 1]
    if before == "," and text.startswith("@"):
        return None
    before_text = " " if before and before not in " \t\r\n([{'`,@" else ""
    after_text = " " if after and after not in " \t\r\n)]};" else ""
    return f"{before_text}{text}{after_text}" if text else " " if before_text and after_text else ""


# --- constant conditions ---------------------------------------------------------------------------------------------


_BY_TYPE = frozenset(("eq?", "eqv?", "equal?"))
_COMPARISONS = frozenset(("=", "<", ">", "<=", ">=", "eq?", "eqv?", "equal?"))

# Characters of conditions in a form that are parsed again for fixes: nested conditions would take quadratic time.
_MAX_REPARSED = 200_000


def constant_conditions(nodes: Iterable[Any], form: Any) -> Iterator[Diagnostic]:
    """Report constant tests of ``if`` and derived forms, and constant operands of ``and`` and ``or``."""
    written = {id(node) for node in written_nodes(form)}
    remaining = _MAX_REPARSED
    for node in nodes:
        kind = type(node)
        if kind is ast.If and node.span.expansion is None:
            remaining -= node.span.end - node.span.start
            yield from _constant_test(node, is_direct=id(node) in written, is_read=remaining > 0)
        elif kind is ast.And or kind is ast.Or:
            for item in node.items[:-1]:
                if item.span.expansion is None and _constant_truth(item) is not None:
                    yield _condition_warning(item, ())


def _constant_test(node: ast.If, *, is_direct: bool, is_read: bool) -> Iterator[Diagnostic]:
    """Report an ``if`` with a constant test, with a fix that replaces it by the branch that runs.

    Parameters
    ----------
    is_direct
        Whether the ``if`` is not an operand of a macro, so that the fix may be safe.
    is_read
        Whether its text may be parsed again for the fix.
    """
    truth = _constant_truth(node.test)
    if truth is None or node.test.span.expansion is not None or (truth and _is_default(node)):
        return
    chosen = node.then if truth else node.otherwise
    text = node.span.text if is_read else ""
    fixes: tuple[Fix, ...] = ()
    if (
        text.startswith("(if ")
        and chosen is not None
        and chosen.span.expansion is None
        and _inside(chosen.span, node.span)
    ):
        branch = _branch(text, 2 if truth else 3)
        replacement = with_spacing(node.span, branch) if branch is not None else None
        if replacement is not None:
            is_safe = is_direct and _cannot_fail(node.test)
            fixes = (Fix("Replace with the branch that runs", (Edit(node.span, replacement),), is_safe),)
    yield _condition_warning(node.test, fixes)


def _branch(text: str, position: int) -> str | None:
    """Return the source text of an operand of an ``if``, including prefixes such as a quote."""
    forms = read(Source("<if>", text)).forms
    items = forms[0].items if forms and isinstance(forms[0], ListDatum) else ()
    return items[position].span.text if position < len(items) else None


def _cannot_fail(test: Any) -> bool:
    """Return whether a constant test cannot fail either, unlike a comparison of an undefined variable with itself."""
    if type(test) is ast.Application:
        return all(type(item) is ast.Constant for item in test.arguments)
    return is_inert(test)


def _is_default(node: ast.If) -> bool:
    """Return whether a constant true test is a ``cond`` clause ``(#t ...)``, which is common instead of ``else``."""
    return not node.span.text.startswith(("(if", "(when", "(unless"))


def _inside(inner: Span, outer: Span) -> bool:
    """Return whether a span lies strictly inside another one."""
    return inner.source is outer.source and outer.start < inner.start and inner.end < outer.end


def _constant_truth(test: Any) -> bool | None:
    """Return the truth value of a constant test, or None if it may vary."""
    kind = type(test)
    if kind is ast.Constant:
        return test.value is not False and test.value is not None
    if kind is ast.Lambda or (kind is ast.Reference and isinstance(test.target, Builtin)):
        return True
    if kind is ast.Application and type(test.function) is ast.Reference and isinstance(test.function.target, Builtin):
        if test.function.target.name in _COMPARISONS and len(test.arguments) == 2:
            return _constant_comparison(test.function.target.name, *test.arguments)
    return None


def _constant_comparison(name: str, left: Any, right: Any) -> bool | None:
    """Return the result of a comparison that does not depend on the run, or None."""
    same = type(left) is type(right) is ast.Reference and left.target is right.target
    if same and not isinstance(left.target, Builtin):
        return name not in ("<", ">")
    if name in _BY_TYPE and type(getattr(left, "value", None)) is not type(getattr(right, "value", None)):
        return None  # 1 and 1.0 are equal numbers of different types
    values = [item.value for item in (left, right) if type(item) is ast.Constant]
    if len(values) == 2 and all(type(value) in (int, float) for value in values):
        a, b = values
        return bool({"<": a < b, ">": a > b, "<=": a <= b, ">=": a >= b}.get(name, a == b))
    return None


def _condition_warning(test: Any, fixes: tuple[Fix, ...]) -> Diagnostic:
    """Return the warning about a constant test."""
    always = "true" if _constant_truth(test) else "false"
    message = f"this condition is always {always}"
    hint = None
    if type(test) is ast.Lambda or (type(test) is ast.Reference and isinstance(test.target, Builtin)):
        hint = "a function is always true; to call it, write `(name argument ...)`"
    return Diagnostic("constant-condition", message, test.span, hint, fixes=fixes)


# --- unused variables ------------------------------------------------------------------------------------------------


_MACRO_DEFINITIONS = ("define-syntax", "let-syntax", "letrec-syntax", "define-macro")


def is_user_written(variable: Variable) -> bool:
    """Return whether the user wrote the name of a variable, unlike names introduced by macros and derived forms."""
    span = variable.span
    if span is None or span.expansion is not None or variable.from_macro:
        return False
    return span.text.lstrip(":").partition("::")[0] == variable.name


def unused_locals(nodes: Sequence[Any], form: Any) -> Iterator[Diagnostic]:
    """Report local definitions and parameters that are never used.

    Parameters prescribed by the caller are excluded: the positional parameters of anonymous functions and entity
    functions.
    """
    if any(head in form.span.text for head in _MACRO_DEFINITIONS):
        return  # a macro in the form may refer to them when it is used
    used = {node.target for node in nodes if type(node) is ast.Reference}
    named_functions = _named_functions(nodes, form)
    removable: set[int] | None = None  # computed when needed, because it reads the text again
    for node in nodes:
        if type(node) is ast.Define and node is not form:
            if isinstance(node.target, Variable) and node.target not in used:
                removable = _removable(form) if removable is None else removable
                fixes = (remove(node),) if id(node) in removable else ()
                yield from _unused("", node.target, used, fixes)
        elif type(node) is ast.Lambda:
            removable_kinds = ["keyword", "optional"]
            if id(node) in named_functions:  # no caller outside the form prescribes its positional parameters
                removable_kinds.append("required")
            for parameter in node.parameters:
                if parameter.kind in removable_kinds and isinstance(parameter.target, Variable):
                    yield from _unused("the parameter ", parameter.target, used)


def _named_functions(nodes: Iterable[Any], form: Any) -> set[int]:
    """Return the ids of local functions that are only called by name, as far as static analysis can determine."""
    named = {id(node.value) for node in nodes if type(node) is ast.Define}
    passed = set()
    for node in nodes:
        operands = node.arguments if type(node) in (ast.Application, ast.Call) else ()
        passed |= {item.target for item in operands if type(item) is ast.Reference}
        if type(node) is ast.UnionLoop and type(node.function) is ast.Reference:
            passed.add(node.function.target)
    for node in nodes:
        if type(node) is ast.Define and node.target in passed:
            named.discard(id(node.value))
    if type(form) is ast.Define:
        named.discard(id(form.value))  # other forms may use it as a value
    return named


def _removable(form: Any) -> set[int]:
    """Return the ids of local definitions that can be removed if they are unused.

    Such a definition is inert and never assigned, and an expression follows it, since a body must not be empty.
    """
    removable = set()
    for node in written_nodes(form):
        if type(node) is not ast.Body:
            continue
        ready: set[Any] = set()
        for item in node.items[:-1]:
            if type(item) is not ast.Define or not isinstance(item.target, Variable):
                continue
            if is_removable(item, ready) and not item.target.assigned and is_followed(form, item.span):
                removable.add(id(item))
            ready.add(item.target)
    return removable


def is_removable(form: Any, ready: Collection[Any] = ()) -> bool:
    """Return whether a form is an inert ``define``; ``ready`` are the variables defined before it."""
    if type(form) is not ast.Define or not form.span.text.startswith("(define ") or form.span.expansion is not None:
        return False
    return isinstance(form.target, Variable) and is_inert(form.value, ready)


def remove(form: Any, safe: bool = True) -> Fix:
    """Return the fix that removes a definition."""
    return Fix("Remove it", (Edit(form.span, ""),), safe)


def _unused(kind: str, variable: Variable, used: set[Any], fixes: tuple[Fix, ...] = ()) -> Iterator[Diagnostic]:
    """Report a variable that is never used, unless its name begins with an underscore."""
    if variable not in used and is_user_written(variable) and not variable.name.startswith("_"):
        yield Diagnostic("unused", f"{kind}`{variable.name}` is never used", variable.span, fixes=fixes)


# --- shadowed builtins -----------------------------------------------------------------------------------------------
#
# Shadowing a builtin is not a mistake in itself, because every program has parameters such as `:scale` and `:color`. A
# call of the shadowing variable is one if it cannot be a function: `(lambda (:scale) (scale 2))`.


def shadowed_calls(nodes: Sequence[Any], form: Any) -> Iterator[Diagnostic]:
    """Report calls of a variable that shadows a builtin function but cannot be a function itself."""
    values = _non_functions(nodes)
    for node in nodes:
        if type(node) is not ast.Application or type(node.function) is not ast.Reference:
            continue
        variable = node.function.target
        if isinstance(variable, Variable) and values.get(variable) and variable.shadows:
            name = variable.name
            line = f" of line {variable.span.source.position(variable.span.start)[0]}" if variable.span else ""
            message = f"`{name}` is {values[variable]}{line} here, and no function: it hides the builtin function"
            written = f"(std/{node.span.text[1:]}" if node.span.text.startswith(f"({name}") else f"std/{name}"
            hint = (
                f"write `{written}`, or give yours another name"
                if len(written) <= MAX_SHOWN
                else (f"write `std/{name}` for the function, or give yours another name")
            )
            fixes: tuple[Fix, ...] = ()
            if node.span.expansion is None and _may_be_vector(node):
                array = f"[{node.span.text[1:-1].strip()}]"
                hint = f"an array is written in square brackets, as `{array}`; {hint}"
                fixes = (Fix("Write an array", (Edit(node.span, array),)),)
            yield Diagnostic("shadowed-builtin", message, node.function.span, hint, fixes=fixes)


def _may_be_vector(node: ast.Application) -> bool:
    """Return whether an application has two arguments that are numbers or variables, as a vector in parentheses."""
    return len(node.arguments) == 2 and all(
        (type(argument) is ast.Constant and type(argument.value) in (int, float)) or type(argument) is ast.Reference
        for argument in node.arguments
    )


def _non_functions(nodes: Iterable[Any]) -> dict[Variable, str]:
    """Return the variables that evidently do not hold a function, with a description of each for error messages."""
    descriptions: dict[Variable, str] = {}
    for node in nodes:
        if type(node) is ast.Lambda:
            for parameter in node.parameters:
                if isinstance(parameter.target, Variable) and _is_data(parameter):
                    descriptions[parameter.target] = "a parameter"
        elif type(node) is ast.Define and isinstance(node.target, Variable) and not node.target.assigned:
            if type(node.value) in (ast.Constant, ast.ArrayLiteral, ast.Call, ast.Transform, ast.Union):
                descriptions[node.target] = "a variable"
    return descriptions


def _is_data(parameter: ast.Parameter) -> bool:
    """Return whether the type or default of a parameter shows that it does not hold a function."""
    if parameter.type is not None:
        return parameter.type.name not in ("Function", "Any")
    if parameter.kind != "keyword":
        return False
    default = parameter.default
    if type(default) is ast.Application and type(default.function) is ast.Reference:
        made = default.function.target
        return isinstance(made, Builtin) and made.result not in ("Any", "Function")
    return default is None or type(default) in (ast.Constant, ast.ArrayLiteral)


@dataclass(frozen=True, slots=True, eq=False)
class FormFacts:
    """Facts about a top-level form, from which the lints of a program are computed.

    Attributes
    ----------
    word
        Word that the form binds.
    strings
        Strings in the form; a word's own name in its function is omitted.
    word_calls, early_calls
        Constant words of calls, and of those that run together with the form.
    idle_attributes
        Warnings about attributes, with the word; they apply if the program does not bind the word.
    unpassed
        Warnings about parameters that no call passes.
    warnings
        Warnings that depend on nothing outside the form.
    defined, used, assigned
        Global variables that the form defines, refers to, and changes by ``set!``.
    computes_strings
        Whether the form calls a builtin that returns a string, which may be a word.
    binds
        Words that any ``bind`` in the form binds (None if computed), with their functions.
    builtins
        Names of the builtins that the form refers to.
    """

    form: Any
    word: str | None
    strings: frozenset[str]
    word_calls: tuple[tuple[str, Span], ...]
    early_calls: tuple[tuple[str, Span], ...]
    idle_attributes: tuple[tuple[str, Diagnostic], ...]
    unpassed: tuple[Diagnostic, ...]
    warnings: tuple[Diagnostic, ...]
    defined: tuple[Variable, ...]
    used: frozenset[Variable]
    computes_strings: bool
    binds: tuple[tuple[str | None, Any], ...]
    assigned: frozenset[Variable]
    builtins: frozenset[str]


def facts_of(form: Any) -> FormFacts:
    """Collect the facts about a core form."""
    nodes = list(walk(form))
    word = bound_word(form)
    builtins = frozenset(
        node.target.name for node in nodes if type(node) is ast.Reference and isinstance(node.target, Builtin)
    )
    # Words that a camera looks at are not called by it: they may be the scene's.
    kept = nodes if builtins.isdisjoint(PROPERTIES) else _without_setup(form)
    strings = {text for node in kept if type(node) is ast.Constant for text in strings_in(node.value)}
    targets = [node.target for node in nodes if type(node) is ast.Reference]
    return FormFacts(
        form,
        word,
        frozenset(strings - {word}) if word is not None else frozenset(strings),
        tuple(_calls(nodes)),
        tuple(_calls(_immediate_nodes(form))) if type(form) is not ast.Bind else (),
        tuple(unread_attributes(nodes)),
        tuple(optional_parameters(form, word)),
        (
            *unused_locals(nodes, form),
            *shadowed_calls(nodes, form),
            *constant_conditions(nodes, form),
            *turned_after_moved(nodes),
            *unused_values(nodes),
        ),
        tuple(pattern_variables(form.target)) if type(form) is ast.Define else (),
        frozenset(target for target in targets if isinstance(target, Variable) and target.is_global),
        any(isinstance(target, Builtin) and target.result == "String" for target in targets),
        tuple(_binds(nodes)),
        frozenset(node.target for node in nodes if type(node) is ast.Assignment),
        builtins,
    )


def _without_setup(form: Any) -> Iterator[Any]:
    """Iterate over the nodes of a form that are not inside a call of ``camera``, ``light``, ..."""
    stack = [form]
    while stack:
        node = stack.pop()
        if called_builtin(node) not in PROPERTIES:
            yield node
            stack += children(node)


def _binds(nodes: Iterable[Any]) -> Iterator[tuple[str | None, Any]]:
    """Iterate over the words of all ``bind`` forms, None for a computed one, with their functions."""
    for node in nodes:
        if type(node) is ast.Bind:
            word = node.word.value if type(node.word) is ast.Constant else None
            yield (word if type(word) is str else None), node.function


def bound_word(form: Any) -> str | None:
    """Return the word of a ``(bind "word" ...)`` form; None for other forms and for a computed word."""
    if type(form) is ast.Bind and type(form.word) is ast.Constant and type(form.word.value) is str:
        return form.word.value
    return None


def _calls(nodes: Any) -> Iterator[tuple[str, Span]]:
    """Iterate over the literal words of calls, with their spans."""
    for node in nodes:
        if type(node) is ast.Call and type(node.word) is ast.Constant and type(node.word.value) is str:
            yield node.word.value, node.word.span


def _immediate_nodes(form: Any) -> Iterator[Any]:
    """Iterate over the nodes outside functions."""
    stack = [form]
    while stack:
        node = stack.pop()
        if type(node) is not ast.Lambda:
            yield node
            stack.extend(children(node))


class FactCache:
    """Cache of the facts about forms, so that unchanged forms are not analyzed again."""

    def __init__(self) -> None:
        self._facts: dict[int, FormFacts] = {}

    def of(self, forms: Sequence[Any]) -> list[FormFacts]:
        """Return the facts about the forms of a program; entries of other forms are evicted."""
        known = self._facts
        facts = [known.get(id(form)) or facts_of(form) for form in forms]
        self._facts = {id(entry.form): entry for entry in facts}
        return facts


# --- attributes that no primitive uses -------------------------------------------------------------------------------

# Similarities of names (difflib's ratio, see `lint`). An attribute of a primitive that does not read the written one is
# suggested from a wrong letter in four (0.75), because the written one means nothing there. A word without geometry may
# have any attribute: from a wrong letter in five (0.8), which no two of the 20 attributes of primitives have in common.
_MIN_ATTRIBUTE_RATIO = 0.75
_MIN_WORD_RATIO = 0.8

# Names that people write for attributes, and hints what to write instead. Rows of a word come before those of "*".
_PLACED = 'a part is placed by `transform`: `(transform (call "{word}") (translate [x y z]))`'
_TURNED = 'a part is turned by `transform`: `(transform (call "{word}") (rotate angle [0 1 0]))`'
_ENDS = "the axis goes from `:p0` to `:p1`: `:p1 [0 {value} 0]`"
_SIDES = "the sizes along x, y and z are one attribute: `:scale [x y z]`"
_DIAMETER = "half the diameter is the `:radius`{half}"
_MATERIAL = "a material is made of `:color`, `:roughness`, `:metallic`, `:opacity`, `:emission` and `:ior`"
_SMOOTH = "surfaces are exact; `export --tolerance` says how finely they are divided"
_CONSTANT = 'the radius is constant; that of a "cone" decreases to 0'
_AXIS = {
    "height h length depth": _ENDS,
    "diameter d": _DIAMETER,
    "r2 top-radius radius-top": _CONSTANT,
    "radius1 radius2 radius-1 radius-2": _CONSTANT,
}
_BOX = {
    "width height depth length w h x-size y-size z-size": _SIDES,
    "bevel fillet corner-radius": '"rounded-cube" has rounded edges: `:radius`',
}
_ROUND = {
    "diameter d": _DIAMETER,
    "minor minor-radius tube-radius thickness r2 inner-radius outer-radius": "the radius of the tube is `:tube`",
    "major major-radius ring-radius": "the radius of the ring is `:radius`",
}
_ANY = {
    "position pos location center centre at origin offset translate translation place": _PLACED,
    "rotation rotate angle orientation axis euler yaw pitch": _TURNED,
    "texture material shader image uv texture-map bump": _MATERIAL,
    "segments sides resolution subdivisions facets fn slices stacks $fn $fa $fs": _SMOOTH,
    "paint fill background backgroundColor background-color tint": 'the color is `:color`: `:color (color "red")`',
    "transparency": "`:opacity` is 1 for an opaque surface and 0 for an invisible one",
}


def _by_name(rows: Mapping[str, str]) -> dict[str, str]:
    """Return the hints by single names."""
    return {name: meant for names, meant in rows.items() for name in names.split()}


MEANT: Mapping[str, Mapping[str, str]] = {
    **{word: _by_name(_AXIS) for word in ("cylinder", "cone", "capsule")},
    **{word: _by_name(_BOX) for word in ("cube", "rounded-cube")},
    **{word: _by_name(_ROUND) for word in ("sphere", "torus")},
    "*": _by_name(_ANY),
}


def unread_attributes(nodes: Iterable[Any]) -> Iterator[tuple[str, Diagnostic]]:
    """Iterate over the words of calls, with warnings about attributes that the primitive of the word does not read."""
    for node in nodes:
        word = node.word.value if type(node) is ast.Call and type(node.word) is ast.Constant else None
        if called_builtin(node) == "embedding":
            yield from _misspelled_attributes(node)
            yield from _bytes(node)
        if word is None or type(word) is not str:
            continue
        others = list(calls_of_other_tools(node, word))
        yield from ((word, other) for other in others)
        values = {id(key): value for key, value in pairwise(node.arguments)}
        texts = {id(key) for key, value in pairwise(node.arguments) if type(value) is ast.Constant is type(key)
                 and type(value.value) is str}  # fmt: skip
        for argument in node.arguments if not others else ():
            if type(argument) is ast.Constant and type(argument.value) is Keyword:
                name, span = str(argument.value), argument.span
                if "=" in name:
                    yield "", _with_sign(name, span)  # also if the program binds the word
                    continue
                is_geometric = geometry_attributes(word) is not None
                is_described = not is_geometric and id(argument) in texts  # `:scales "emerald"` of a dragon
                hint = (
                    unread_hint(word, name, _passed(values.get(id(argument))))
                    if is_geometric
                    else None
                    if is_described
                    else _semantic_hint(word, name)
                )
                foreign = hint_for_primitive(name) if is_geometric and hint is None else None
                if foreign is not None and name not in (geometry_attributes(word) or ()):
                    hint = foreign[0]
                if hint is not None:
                    near = near_attribute(word, name) or (foreign[1] if foreign else _named_in(hint))
                    is_former = near is not None and near == _today(word, name)
                    fixes = (Fix(f"Change to `:{near}`", (Edit(span, f":{near}"),), is_former),) if near else ()
                    message = f'the primitive "{word}" does not use the attribute `:{name}`'
                    yield (
                        word,
                        Diagnostic(
                            "idle-attribute", message, span, hint, fixes=fixes, found=f":{name}",
                            expected=" ".join(f":{n}" for n in geometry_attributes(word) or ()),
                            near=(f":{near}",) if near else (),
                        ),
                    )  # fmt: skip


def _passed(value: Any) -> str | None:
    """Return the code of what is passed as an attribute, if it is short."""
    is_written = value is not None and value.span.expansion is None
    return value.span.text if is_written and len(value.span.text) <= _MAX_CODE else None


_MAX_CODE = 20  # characters of code in a hint


def _with_sign(name: str, span: Span) -> Diagnostic:
    """Return the warning about a keyword argument with the equals sign of other languages."""
    keyword, _, value = name.partition("=")
    after = span.source.text[span.end : span.end + 1]
    written = f":{keyword} {value}" if value or not after.isspace() else f":{keyword}"
    fix = Fix(f"Change to `{written.rstrip()}`", (Edit(span, written),), safe=True)
    hint = f"write `:{keyword} value`, without an equals sign"
    message = f"no primitive uses the attribute `:{name}`"
    return Diagnostic("idle-attribute", message, span, hint, fixes=(fix,), found=f":{name}", near=(f":{keyword}",))


def _misspelled_attributes(node: Any) -> Iterator[tuple[str, Diagnostic]]:
    """Iterate over warnings about keywords of an ``embedding`` that are probably misspelled attributes."""
    known = {attribute.name for attribute in (SCALE, COLOR, *MATERIALS, *PHYSICS)} | _all_geometry()
    for argument in node.arguments:
        if type(argument) is ast.Constant and type(argument.value) is Keyword and argument.value not in known:
            written = str(argument.value)
            typos = {name for name in known if _is_typo(written, name)}  # rare, and faster than the names that are near
            near = [name for name in near_names(written, known) if name in typos] if typos else ()
            if near:
                span, meant = argument.span, f":{near[0]}"
                fix = Fix(f"Change to `{meant}`", (Edit(span, meant),))
                message = f"no primitive uses the attribute `{argument.span.text}`"
                yield "", Diagnostic("idle-attribute", message, span, f"did you mean `{meant}`?", fixes=(fix,),
                                     found=f":{argument.value}", near=(meant,))  # fmt: skip


_BYTE = 255  # largest color component in other tools


def _bytes(node: Any) -> Iterator[tuple[str, Diagnostic]]:
    """Iterate over warnings about colors of an ``embedding`` whose components go up to 255 instead of 1."""
    for key, value in pairwise(node.arguments):
        if type(key) is not ast.Constant or key.value != Keyword(COLOR.name) or value.span.expansion is not None:
            continue
        numbers = _numbers(value) or ()
        known = [float(x) for x in numbers if isinstance(x, (int, float))]
        if len(known) == len(numbers) == 3 and 1 < max(known) <= _BYTE and min(known) >= 0:
            written = f"(rgb {' '.join(item.span.text for item in value.items)})"
            fix = Fix(f"Change to `{written}`", (Edit(value.span, written),))
            message = f"the attribute `:color` should be 0 to 1, got {value.span.text}"
            hint = f"components from 0 to 255 are converted by `rgb`: `{written}`"
            yield "", Diagnostic("out-of-range", message, value.span, hint, fixes=(fix,), expected="0 to 1",
                                 found=value.span.text)  # fmt: skip


def _is_typo(name: str, near: str) -> bool:
    """Return whether a name is so similar to another that it is probably a misspelling of it."""
    if not may_resemble(near, name, _MIN_WORD_RATIO):
        return False
    from difflib import SequenceMatcher

    return SequenceMatcher(None, near, name).ratio() >= _MIN_WORD_RATIO


def _named_in(hint: str) -> str | None:
    """Return the attribute that a hint names, if the written value fits it; a diameter is not a radius."""
    match = re.match(r"(?:the colou?r is|the radius of the (?:tube|ring) is) `:([\w-]+)`", hint)
    return match[1] if match is not None else None


def _attributes_of(word: str) -> tuple[Attribute, ...]:
    """Return the attributes that change how a word looks; a word that is no primitive is drawn as a box."""
    try:
        primitive = find(word)
    except SceneError:
        primitive = None
    return (*(primitive.attributes if primitive is not None else (SCALE,)), COLOR, *MATERIALS)


def _today(word: str, name: str) -> str | None:
    """Return the name of an attribute that earlier versions called ``name``, or None."""
    return next((each.name for each in _attributes_of(word) if name and name == each.former), None)


def near_attribute(word: str, name: str) -> str | None:
    """Return the attribute of a primitive that ``name`` is a synonym or a misspelling of."""
    known = _attributes_of(word)
    for attribute in known:
        if name == attribute.former:
            return attribute.name
        if name.lower() in attribute.aliases and name != "transparency":
            return attribute.name
    near = close_matches(name.lower(), [attribute.name for attribute in known], 1, _MIN_ATTRIBUTE_RATIO)
    if near:
        return near[0]
    # `:emission-strength`, `:base-color` and `:metallicFactor` of other tools
    parts = re.findall(r"[a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", "-", name).lower())
    own = [part for part in parts if part not in _QUALIFIERS]
    return own[0] if len(own) == 1 < len(parts) and own[0] in {attribute.name for attribute in known} else None


# What other tools add to the name of a property.
_QUALIFIERS = frozenset(("strength", "factor", "intensity", "amount", "value", "level", "base", "diffuse", "map"))


def unread_hint(word: str, name: str, value: str | None = None) -> str | None:
    """Return a hint for an attribute that a geometric primitive does not use, but that was probably meant to change it.

    None for an attribute that is read, and for one that may have a meaning in the program. ``value`` is the code of
    what is passed.
    """
    read = geometry_attributes(word) or ()
    if name in read or any(name == attribute.name for attribute in (*MATERIALS, *PHYSICS)):
        return None
    for table in (MEANT.get(word, {}), MEANT["*"]):
        if name in table:
            is_number = value is not None and re.fullmatch(r"\d*\.?\d+", value) is not None
            half = f": `:radius {float(value or 0) / 2:g}`" if is_number else ""
            return table[name].format(word=word, value=name if value is None else value, half=half)
    near = near_attribute(word, name)
    if near:
        return f"did you mean `:{near}`?"
    return "it uses " + ", ".join(f"`:{n}`" for n in read) if name in _all_geometry() else None


def _semantic_hint(word: str, name: str) -> str | None:
    """Return a hint for an attribute of a word without geometry that is probably misspelled."""
    if is_word(word):
        return None  # blocks and mesh files check their attributes themselves
    near = near_attribute(word, name)
    is_typo = near is not None and near != name and _is_typo(name, near)
    return f"did you mean `:{near}`?" if is_typo else None


def _all_geometry() -> frozenset[str]:
    """Return the attributes that the geometry of some primitive reads."""
    return frozenset(name for word in solid_words() for name in geometry_attributes(word) or ())
