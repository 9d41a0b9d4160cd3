"""What lints want to know of one top-level form, gathered once and kept as long as the form stays the same."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Datum, ListDatum, Source, Span, subdatums
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix, SceneError
from scenelang.grammar.reader import read
from scenelang.interpreter.compile.analyse import children, pattern_variables, walk
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.runtime.values import Keyword, Pair
from scenelang.interpreter.scene.primitives import geometry_attributes, solid_words

if TYPE_CHECKING:
    from scenelang.interpreter.program.program import Program


# Attributes and parameters that never meet.


def _all_geometry() -> frozenset[str]:
    """The attributes that the geometry of some primitive reads."""
    return frozenset(name for word in solid_words() for name in geometry_attributes(word) or ())


def optional_parameters(form: Any, word: str | None) -> Iterator[Diagnostic]:
    """Parameters of a word's function that a ``call`` never fills."""
    function = form.function if word is not None else None
    if type(function) is ast.Lambda:
        for parameter in function.parameters:
            if parameter.kind == "optional":
                hint = f"make it a keyword parameter: `(:{parameter.name} default)`"
                message = f'a `call` of "{word}" never fills `{parameter.name}`; it keeps its default'
                yield Diagnostic("optional-embedding", message, function.span, hint)


def idle_attributes(nodes: Iterable[Any]) -> Iterator[tuple[str, Diagnostic]]:
    """Attributes of a geometric primitive that its geometry does not read, though another's does, or nearly so."""
    for node in nodes:
        word = node.word.value if type(node) is ast.Call and type(node.word) is ast.Constant else None
        if word is None or geometry_attributes(word) is None:
            continue
        for argument in node.arguments:
            if type(argument) is ast.Constant and type(argument.value) is Keyword:
                name, span = str(argument.value), argument.span
                hint = idle_hint(word, name)
                if hint is not None:
                    near = near_attribute(word, name)
                    fixes = (Fix(f"Change to `:{near}`", (Edit(span, f":{near}"),)),) if near else ()
                    message = f'a "{word}" does not read the attribute `:{name}`'
                    yield word, Diagnostic("idle-attribute", message, span, hint, fixes=fixes)


def near_attribute(word: str, name: str) -> str | None:
    """An attribute that the primitive reads and ``name`` may be a misspelling of."""
    near = get_close_matches(name.lower(), geometry_attributes(word) or (), n=1, cutoff=0.75)
    return near[0] if near else None


def idle_hint(word: str, name: str) -> str | None:
    """A hint for an attribute that a geometric primitive does not read, though another's geometry does, or nearly so;
    None where it is read, or may be the program's own."""
    read = geometry_attributes(word) or ()
    if name in read:
        return None
    near = near_attribute(word, name)
    if near:
        return f"did you mean `:{near}`?"
    return "it reads " + ", ".join(f"`:{n}`" for n in read) if name in _all_geometry() else None


# Poses that are probably composed in the wrong order.


def turned_after_moved(nodes: Iterable[Any]) -> Iterator[Diagnostic]:
    """A thing that is moved and then turned by a fixed angle about the origin, so that it swings away from its place.

    An angle that varies places things round a circle, and a move along the axis commutes with the turn: both are fine.
    """
    for node in nodes:
        if type(node) is ast.Transform:
            factors = _factors(node)
            for turn, move in pairwise(factors):
                if turn.span.expansion is None and _is_fixed_turn(turn) and _leaves_axis(turn, move):
                    yield _pose_warning(turn)


def _factors(node: ast.Transform) -> list[Any]:
    """The matrices on the way to the part, the last applied first."""
    found: list[Any] = []
    part: Any = node
    if type(node.part) is ast.Transform:
        part = node
        while type(part) is ast.Transform:
            found += _product(part.matrix)
            part = part.part
            if len(found) > 1:
                break
        return found[: len(_product(node.matrix)) + 1]
    return _product(node.matrix)


def _product(matrix: Any) -> list[Any]:
    if _head(matrix) == "@":
        return [factor for argument in matrix.arguments for factor in _product(argument)]
    return [matrix]


def _head(node: Any) -> str | None:
    if type(node) is ast.Application and type(node.function) is ast.Reference:
        target = node.function.target
        return target.name if isinstance(target, Builtin) else None
    return None


def _is_fixed_turn(node: Any) -> bool:
    if _head(node) != "rotate" or len(node.arguments) != 2:
        return False
    return not any(
        type(part) is ast.Reference and isinstance(part.target, Variable) and not part.target.is_global
        for part in walk(node.arguments[0])
    )


def _leaves_axis(turn: Any, move: Any) -> bool:
    """Whether ``move`` is a translation that surely does not go along the axis of ``turn``."""
    if _head(move) != "translate" or len(move.arguments) != 1:
        return False
    axis, offset = _numbers(turn.arguments[1]), _numbers(move.arguments[0])
    if axis is None or offset is None:
        return False
    return any(shift not in (0, None) and along == 0 for along, shift in zip(axis, offset))


def _numbers(node: Any) -> list[float | None] | None:
    """The items of an array literal, None for those that are worked out."""
    if type(node) is not ast.ArrayLiteral:
        return None
    return [item.value if type(item) is ast.Constant else None for item in node.items]


def _pose_warning(turn: Any) -> Diagnostic:
    span: Span = turn.span
    message = "this turns what was moved before, about the origin: it swings away from its place"
    hint = "turn first, then move, or give `rotate` a point to turn about"
    return Diagnostic("turned-after-moved", message, span, hint)


# When a piece of program may be taken out without a change of what the program does.


def written_nodes(form: Any) -> Iterator[Any]:
    """The nodes of a form that stand in the text for themselves: what a macro was given may be used for anything."""
    stack = [form]
    while stack:
        node = stack.pop()
        if node.span.expansion is None:
            yield node
            stack.extend(children(node))


def is_inert(node: Any, ready: Collection[Any] = ()) -> bool:
    """Whether evaluating an expression does nothing, cannot fail, and draws nothing. ``ready``: variables of bodies
    that have their values by then."""
    kind = type(node)
    if kind is ast.Constant or kind is ast.Lambda:
        return True
    if kind is ast.Reference:
        target = node.target
        return isinstance(target, Builtin) or target in ready or (isinstance(target, Variable) and not target.recursive)
    return kind is ast.ArrayLiteral and all(
        type(item) is ast.Constant and type(item.value) in (int, float) for item in node.items
    )


def keeps_root(fix: Fix, program: Program) -> bool:
    """Whether a fix leaves alone which word is the root: where no form says so, the one that nothing mentions."""
    if program.scene is not None:
        return True
    for edit in fix.edits:
        before = edit.span.text
        if "\\" in before or any(before.count(f'"{w}"') > edit.text.count(f'"{w}"') for w in program.all_words):
            return False
    return True


def is_followed(form: Any, span: Span) -> bool:
    """Whether another form, which is no string, follows the one at ``span`` in the same parentheses."""
    found = _list_around(form.span, span)
    if found is None:
        return False
    items = found.items
    position = next(i for i, item in enumerate(items) if item.span.start == span.start - form.span.start)
    if position + 1 >= len(items) or found.tail is not None:
        return False
    following = items[position + 1]
    return isinstance(following, ListDatum) or type(getattr(following, "value", "")) is not str


def _list_around(outer: Span, inner: Span) -> ListDatum | None:
    """The list whose direct item stands at ``inner``."""
    try:
        forms = read(Source("<form>", outer.text)).forms
    except SceneError:
        return None
    wanted = inner.start - outer.start
    stack: list[Datum] = list(forms)
    while stack:
        datum = stack.pop()
        if isinstance(datum, ListDatum) and any(item.span.start == wanted for item in datum.items[1:]):
            return datum
        stack.extend(part for part in subdatums(datum) if part.span.start <= wanted < part.span.end)
    return None


def spaced(span: Span, text: str) -> str | None:
    """``text`` to stand at ``span``, apart from its neighbours; None where it would join a prefix before it."""
    around = span.source.text
    before, after = around[: span.start][-1:], around[span.end : span.end + 1]
    if before == "," and text.startswith("@"):
        return None
    lead = " " if before and before not in " \t\r\n([{'`,@" else ""
    trail = " " if after and after not in " \t\r\n)]};" else ""
    return f"{lead}{text}{trail}" if text else " " if lead and trail else ""


# Conditions that are always true or always false.


_BY_TYPE = frozenset(("eq?", "eqv?", "equal?"))
_COMPARISONS = frozenset(("=", "<", ">", "<=", ">=", "eq?", "eqv?", "equal?"))

_MOST_READ = 200_000  # letters of conditions of one form that are read again for a fix: they may be nested deeply


def constant_conditions(nodes: Iterable[Any], form: Any) -> Iterator[Diagnostic]:
    """Tests of ``if`` and its kin, and operands of ``and`` and ``or``, that the text alone decides."""
    written = {id(node) for node in written_nodes(form)}
    letters = _MOST_READ
    for node in nodes:
        kind = type(node)
        if kind is ast.If and node.span.expansion is None:
            letters -= node.span.end - node.span.start
            yield from _of_choice(node, id(node) in written, letters > 0)
        elif kind is ast.And or kind is ast.Or:
            for item in node.items[:-1]:
                if item.span.expansion is None and _decided(item) is not None:
                    yield _condition_warning(item, ())


def _of_choice(node: ast.If, is_written: bool, is_read: bool) -> Iterator[Diagnostic]:
    always = _decided(node.test)
    if always is None or node.test.span.expansion is not None or _is_default(node, always):
        return
    kept = node.then if always else node.otherwise
    text = node.span.text if is_read else ""
    fixes: tuple[Fix, ...] = ()
    if text.startswith("(if ") and kept is not None and kept.span.expansion is None and _inside(kept.span, node.span):
        branch = _branch(text, 2 if always else 3)
        replacement = spaced(node.span, branch) if branch is not None else None
        if replacement is not None:
            safe = is_written and _cannot_fail(node.test)
            fixes = (Fix("Keep only the branch that runs", (Edit(node.span, replacement),), safe),)
    yield _condition_warning(node.test, fixes)


def _branch(text: str, position: int) -> str | None:
    """The text of a branch of an ``if`` as it is written, with a prefix such as a quote."""
    forms = read(Source("<if>", text)).forms
    items = forms[0].items if forms and isinstance(forms[0], ListDatum) else ()
    return items[position].span.text if position < len(items) else None


def _cannot_fail(test: Any) -> bool:
    """Whether a test that is always the same cannot fail either, as a comparison of a variable with itself can."""
    if type(test) is ast.Application:
        return all(type(item) is ast.Constant for item in test.arguments)
    return is_inert(test)


def _is_default(node: ast.If, always: bool) -> bool:
    """``(#t ...)`` as the last clause of ``cond``, which many write for ``else``."""
    return always and not node.span.text.startswith(("(if", "(when", "(unless"))


def _inside(inner: Span, outer: Span) -> bool:
    return inner.source is outer.source and outer.start < inner.start and inner.end < outer.end


def _decided(test: Any) -> bool | None:
    """The truth of a test that is always the same; None where it may vary."""
    kind = type(test)
    if kind is ast.Constant:
        return test.value is not False and test.value is not None
    if kind is ast.Lambda or (kind is ast.Reference and isinstance(test.target, Builtin)):
        return True
    if kind is ast.Application and type(test.function) is ast.Reference and isinstance(test.function.target, Builtin):
        if test.function.target.name in _COMPARISONS and len(test.arguments) == 2:
            return _compared(test.function.target.name, *test.arguments)
    return None


def _compared(name: str, left: Any, right: Any) -> bool | None:
    same = type(left) is type(right) is ast.Reference and left.target is right.target
    if same and not isinstance(left.target, Builtin):
        return name not in ("<", ">")
    if name in _BY_TYPE and type(getattr(left, "value", None)) is not type(getattr(right, "value", None)):
        return None  # 1 and 1. are equal numbers of two types
    values = [item.value for item in (left, right) if type(item) is ast.Constant]
    if len(values) == 2 and all(type(value) in (int, float) for value in values):
        a, b = values
        return bool({"<": a < b, ">": a > b, "<=": a <= b, ">=": a >= b}.get(name, a == b))
    return None


def _condition_warning(test: Any, fixes: tuple[Fix, ...]) -> Diagnostic:
    always = "true" if _decided(test) else "false"
    message = f"this condition is always {always}"
    hint = None
    if type(test) is ast.Lambda or (type(test) is ast.Reference and isinstance(test.target, Builtin)):
        hint = "a function is true; call it: `(name argument ...)`"
    return Diagnostic("constant-condition", message, test.span, hint, fixes=fixes)


# Names that nothing uses, and names of the library that are called where something else is meant by them.


_MACROS = ("define-syntax", "let-syntax", "letrec-syntax", "define-macro")


def is_written(variable: Variable) -> bool:
    """Whether the name stands in the program as a name that somebody gave: no macro's, no form's own."""
    span = variable.span
    if span is None or span.expansion is not None or variable.from_macro:
        return False
    return span.text.lstrip(":").partition("::")[0] == variable.name


def unused_locals(nodes: Sequence[Any], form: Any) -> Iterator[Diagnostic]:
    """Local definitions and parameters that nothing reads. What a caller prescribes is left alone: the positional
    parameters of functions without a name of their own, and of entity functions."""
    if any(head in form.span.text for head in _MACROS):
        return  # a macro that nobody has used yet may read them
    used = {node.target for node in nodes if type(node) is ast.Reference}
    named = _named_functions(nodes, form)
    removable = _removable(form)
    for node in nodes:
        if type(node) is ast.Define and node is not form:
            if isinstance(node.target, Variable):
                fixes = (remove(node),) if id(node) in removable else ()
                yield from _unused(node.target, used, "is never used", fixes)
        elif type(node) is ast.Lambda:
            for parameter in node.parameters:
                free = parameter.kind in ("keyword", "optional") or (parameter.kind == "required" and id(node) in named)
                if free and isinstance(parameter.target, Variable):
                    yield from _unused(parameter.target, used, "is a parameter that is never used")


def _named_functions(nodes: Iterable[Any], form: Any) -> set[int]:
    """Functions that only their name calls, as far as can be seen."""
    found = {id(node.value) for node in nodes if type(node) is ast.Define}
    passed = set()
    for node in nodes:
        operands = node.arguments if type(node) in (ast.Application, ast.Call) else ()
        passed |= {item.target for item in operands if type(item) is ast.Reference}
        if type(node) is ast.UnionLoop and type(node.function) is ast.Reference:
            passed.add(node.function.target)
    for node in nodes:
        if type(node) is ast.Define and node.target in passed:
            found.discard(id(node.value))
    if type(form) is ast.Define:
        found.discard(id(form.value))  # other forms may pass it on
    return found


def _removable(form: Any) -> set[int]:
    """Definitions of bodies that may go if nothing reads them: they do nothing else, nothing assigns them, and a value
    comes after them."""
    found = set()
    for node in written_nodes(form):
        if type(node) is not ast.Body:
            continue
        ready: set[Any] = set()
        for item in node.items[:-1]:
            if type(item) is not ast.Define or not isinstance(item.target, Variable):
                continue
            if can_go(item, ready) and not item.target.assigned and is_followed(form, item.span):
                found.add(id(item))
            ready.add(item.target)
    return found


def can_go(form: Any, ready: Collection[Any] = ()) -> bool:
    """Whether a form is a ``define`` that does nothing but define; ``ready``: the variables defined before it."""
    if type(form) is not ast.Define or not form.span.text.startswith("(define ") or form.span.expansion is not None:
        return False
    return isinstance(form.target, Variable) and is_inert(form.value, ready)


def remove(form: Any, safe: bool = True) -> Fix:
    """The fix that takes out a definition."""
    return Fix("Remove it", (Edit(form.span, ""),), safe)


def _unused(variable: Variable, used: set[Any], what: str, fixes: tuple[Fix, ...] = ()) -> Iterator[Diagnostic]:
    if variable not in used and is_written(variable) and not variable.name.startswith("_"):
        yield Diagnostic("unused", f"`{variable.name}` {what}", variable.span, fixes=fixes)


# --- names of the library -------------------------------------------------------------------------------------------


def shadowed_calls(nodes: Sequence[Any], form: Any) -> Iterator[Diagnostic]:
    """Calls of a parameter or local that cannot be a function, though the library has a function of that name."""
    values = _values(nodes)
    for node in nodes:
        if type(node) is not ast.Application or type(node.function) is not ast.Reference:
            continue
        variable = node.function.target
        if isinstance(variable, Variable) and values.get(variable) and variable.shadows:
            name = variable.name
            message = f"`{name}` is {values[variable]} here, not the function of the library"
            hint = f"the library's function is always `std/{name}`"
            yield Diagnostic("shadowed-builtin", message, node.function.span, hint)


def _values(nodes: Iterable[Any]) -> dict[Variable, str]:
    """What the variables are that hold no function, as far as the text tells."""
    found: dict[Variable, str] = {}
    for node in nodes:
        if type(node) is ast.Lambda:
            for parameter in node.parameters:
                if isinstance(parameter.target, Variable) and _is_data(parameter):
                    found[parameter.target] = "a parameter"
        elif type(node) is ast.Define and isinstance(node.target, Variable) and not node.target.assigned:
            if type(node.value) in (ast.Constant, ast.ArrayLiteral, ast.Call, ast.Transform, ast.Union):
                found[node.target] = "a variable"
    return found


def _is_data(parameter: ast.Parameter) -> bool:
    if parameter.type is not None:
        return parameter.type.name not in ("Function", "Any")
    return parameter.kind == "keyword" and (
        parameter.default is None or type(parameter.default) in (ast.Constant, ast.ArrayLiteral)
    )


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
