"""Forms that define names in a body or at top level: how each is found before anything is expanded."""

from __future__ import annotations

from collections.abc import Callable

from scenelang.grammar.datum import Atom, Datum, ListDatum, Symbol
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter import macros
from scenelang.interpreter.expand import (
    Expander,
    Pending,
    core,
    is_identifier,
    opaque,
    syntax_error,
)
from scenelang.interpreter.records import MAKE_RECORD, record_procedure_names
from scenelang.interpreter.scope import Scope, base_name

Scanner = Callable[[Expander, ListDatum, Scope, list[Pending]], None]
SCANNERS: dict[str, Scanner] = {}


def scans(name: str) -> Callable[[Scanner], Scanner]:
    def register(scanner: Scanner) -> Scanner:
        SCANNERS[name] = scanner
        return scanner

    return register


def _definition(target: Datum, value: Callable[[], Datum], datum: Datum) -> Pending:
    return Pending(lambda: core("DEFINE", [target, value()], datum.span), True, datum)


def _is_global(scope: Scope) -> bool:
    """True for the scope of a file's top level: its parent is the one that knows the builtins."""
    return scope.parent is not None and scope.parent.fallback is not None


@scans("define")
def scan_define(expander: Expander, datum: ListDatum, scope: Scope, pending: list[Pending]) -> None:
    items = datum.items
    if len(items) < 2:
        raise syntax_error("define", "`define` needs a name and a value", datum.span)
    head = items[1]
    if isinstance(head, ListDatum) and head.items:
        if len(items) < 3:
            raise syntax_error("define", "the function has no body", datum.span)
        name = head.items[0]
        if not is_identifier(name):
            raise expander.not_a_name(name)
        target = _target(expander, name, scope)
        rest = head.items[1:]
        if rest or head.tail is None:
            parameters: Datum = ListDatum(rest, head.tail, head.span)
        else:
            parameters = head.tail
        spelled = base_name(name.value)
        value = lambda: expander.expand_lambda(parameters, items[2:], scope, datum.span, spelled)
    else:
        if len(items) != 3:
            what = "has no value" if len(items) == 2 else "has more than one value"
            raise syntax_error("define", f"this `define` {what}", datum.span)
        if not is_identifier(head):
            raise syntax_error("define", "`define` needs a name", head.span)
        target = _target(expander, head, scope)
        spelled = base_name(head.value)
        value = lambda: expand_named(expander, items[2], scope, spelled)
    pending.append(_definition(target, value, datum))


def expand_named(expander: Expander, datum: Datum, scope: Scope, name: str) -> Datum:
    """A value; a function written here gets ``name``."""
    if isinstance(datum, ListDatum) and len(datum.items) > 2 and datum.tail is None:
        binding = expander.binding_of(datum.items[0], scope)
        if getattr(binding, "name", None) == "lambda":
            return expander.expand_lambda(datum.items[1], datum.items[2:], scope, datum.span, name)
    return expander.expand(datum, scope)


def _target(expander: Expander, name: Datum, scope: Scope) -> Datum:
    return expander.declare_target(name, scope, recursive=True, is_global=_is_global(scope))


@scans("define-values")
def scan_define_values(expander: Expander, datum: ListDatum, scope: Scope, pending: list[Pending]) -> None:
    if len(datum.items) != 3:
        raise syntax_error("define-values", "`define-values` needs names and one value", datum.span)
    target = _target(expander, datum.items[1], scope)
    pending.append(_definition(target, lambda: expander.expand(datum.items[2], scope), datum))


@scans("define-syntax")
def scan_define_syntax(expander: Expander, datum: ListDatum, scope: Scope, pending: list[Pending]) -> None:
    if len(datum.items) != 3 or not is_identifier(datum.items[1]):
        raise syntax_error("define-syntax", "`define-syntax` needs a name and `syntax-rules`", datum.span)
    name = datum.items[1]
    _refuse_reserved(expander, name, scope)
    try:
        macro = macros.syntax_rules(expander, datum.items[2], scope, base_name(name.value), datum.span)
    except SceneError:
        scope.bind(name.value, macros.broken(base_name(name.value), datum.span))
        raise
    scope.bind(name.value, macro)
    expander.note_use(name, macro, defines=True)


@scans("define-macro")
def scan_define_macro(expander: Expander, datum: ListDatum, scope: Scope, pending: list[Pending]) -> None:
    head = datum.items[1] if len(datum.items) > 2 else None
    if not isinstance(head, ListDatum) or not head.items or not is_identifier(head.items[0]):
        raise syntax_error("define-macro", "`define-macro` needs (name parameter ...) and a body", datum.span)
    name = head.items[0]
    _refuse_reserved(expander, name, scope)
    parameters: Datum = ListDatum(head.items[1:], head.tail, head.span)
    if len(head.items) == 1 and head.tail is not None:
        parameters = head.tail
    try:
        macro = macros.procedural(expander, base_name(name.value), parameters, datum.items[2:], scope, datum.span)
    except SceneError:
        scope.bind(name.value, macros.broken(base_name(name.value), datum.span))
        raise
    scope.bind(name.value, macro)
    expander.note_use(name, macro, defines=True)


def _refuse_reserved(expander: Expander, name: Datum, scope: Scope) -> None:
    """Declare and forget: the same checks as for a variable."""
    uses, expander.uses = expander.uses, None
    expander.declare(name, Scope(scope))
    expander.uses = uses


@scans("define-record")
def scan_define_record(expander: Expander, datum: ListDatum, scope: Scope, pending: list[Pending]) -> None:
    if len(datum.items) < 2 or not is_identifier(datum.items[1]):
        raise syntax_error("define-record", "`define-record` needs a name and fields", datum.span)
    name = datum.items[1]
    spelled = base_name(name.value)
    expander.declare_record(spelled)
    fields, types, defaults = _fields(datum)
    names = record_procedure_names(spelled, fields)
    targets = [name, *(Atom(Symbol(text), name.span) for text in names[1:])]
    target = expander.declare_target(
        ListDatum(tuple(targets), None, name.span), scope, recursive=True, is_global=_is_global(scope)
    )

    def value() -> Datum:
        def default_function(index: int) -> Datum:
            default = defaults[index]
            if default is None:
                return Atom(False, datum.span)
            earlier = ListDatum(tuple(Atom(Symbol(f), datum.span) for f in fields[:index]), None, datum.span)
            return expander.expand_lambda(earlier, [default], scope, default.span, f"{spelled}-{fields[index]}")

        declared = tuple(expander.annotated_type(t, datum.span) if t else None for t in types)
        facts = core("QUOTE", [opaque("DATUM", (spelled, tuple(fields), declared), datum.span)], datum.span)
        operands = [default_function(index) for index in range(len(fields))]
        return ListDatum((Atom(MAKE_RECORD, datum.span), facts, *operands), None, datum.span)

    pending.append(_definition(target, value, datum))


def _fields(datum: ListDatum) -> tuple[list[str], list[str], list[Datum | None]]:
    fields: list[str] = []
    types: list[str] = []
    defaults: list[Datum | None] = []
    for item in datum.items[2:]:
        default: Datum | None = None
        if isinstance(item, ListDatum) and len(item.items) == 2 and item.tail is None:
            item, default = item.items
        if not is_identifier(item):
            hint = "a field is `name` or `(name default)`"
            raise syntax_error("define-record", "this is no field", item.span, hint)
        name, _, annotation = base_name(item.value).partition("::")
        if name in fields:
            raise SceneError("duplicate", f"the field `{name}` is there twice", None, item.span)
        if default is None and any(defaults):
            raise syntax_error(
                "define-record", f"the field `{name}` needs a default, as one before it has one", item.span
            )
        fields.append(name)
        types.append(annotation)
        defaults.append(default)
    return fields, types, defaults


@scans("let-syntax")
@scans("letrec-syntax")
def scan_let_syntax(expander: Expander, datum: ListDatum, scope: Scope, pending: list[Pending]) -> None:
    if len(datum.items) < 3 or not isinstance(datum.items[1], ListDatum):
        raise syntax_error("let-syntax", "`let-syntax` needs ((name (syntax-rules ...)) ...) and a body", datum.span)
    inner = Scope(scope)
    for binding in datum.items[1].items:
        if not isinstance(binding, ListDatum) or len(binding.items) != 2 or not is_identifier(binding.items[0]):
            raise syntax_error("let-syntax", "this is no macro binding", binding.span)
        name, rules = binding.items
        inner.bind(name.value, macros.syntax_rules(expander, rules, inner, base_name(name.value), binding.span))
    pending.append(Pending(lambda: expander.expand_body(datum.items[2:], inner, datum.span), False, datum))
