"""Unparser: convert the core AST back to a program in the language, for ``expand``.

The result shows a program without macros and derived forms.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.datum import (
    ArrayDatum,
    Atom,
    Datum,
    Handle,
    Keyword,
    ListDatum,
    Source,
    Span,
    Symbol,
    atom_text,
)
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.reader import read
from scenelang.interpreter.compile.analyse import children, pattern_variables, walk
from scenelang.interpreter.expand.forms import FORMS, PAPER_FORMS
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.procedures import MAKE_RECORD
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.scene.pose import to_array
from scenelang.interpreter.values.values import NIL, Array, Embedding, Matrix, Pair, Procedure, Vector

_NOWHERE = Span(Source("<expansion>", ""), 0, 0)
_UNREADABLE = re.compile(r"[^A-Za-z0-9!?*<>=/_-]+")
_PLAIN = (int, float, bool, str, type(None))  # types of atoms that always read as what they print


def _list(*items: Datum) -> ListDatum:
    return ListDatum(items, None, _NOWHERE)


def _symbol(name: str) -> Atom:
    return Atom(Symbol(name), _NOWHERE)


def unparse(forms: Iterable[Any], fixed: frozenset[Variable] = frozenset()) -> list[Datum]:
    """Convert top-level core forms to datums.

    A variable that would capture references to another one is renamed with a number, except for the variables in
    ``fixed``. Raises ``SceneError`` if two variables that cannot be renamed collide, and for a value that no text
    reads as, such as a symbol with a space that a macro made.
    """
    forms = list(forms)
    unparser = _Unparser(forms, fixed)
    return [unparser.form(form) for form in forms]


@cache
def _reads_back(value: Any) -> bool:
    """Return whether the reader returns an equal atom for the text of ``value``."""
    try:
        forms = read(Source("<expansion>", atom_text(value))).forms
    except SceneError:
        return False
    atom = forms[0] if len(forms) == 1 else None
    return isinstance(atom, Atom) and type(atom.value) is type(value) and bool(atom.value == value)


def _atom(value: Any, span: Span) -> Atom:
    """Return ``value`` as an atom; raises ``SceneError`` at ``span`` if its text is not read as it."""
    if type(value) not in _PLAIN and not (type(value) in (Symbol, Keyword, Handle) and _reads_back(value)):
        raise _unreadable(value, span)
    return Atom(value, _NOWHERE)


def _unreadable(value: Any, span: Span | None) -> SceneError:
    kind = "symbol" if type(value) is Symbol else "value"
    message = f"the expansion has the {kind} `{show(value, 60)}`, and no text reads as that {kind}"
    return SceneError("unsupported", message, "let the macro insert a string, or code that makes the value", span)


def _keywords(node: Any) -> list[ast.Parameter]:
    return [p for p in node.parameters if p.kind == "keyword"] if type(node) is ast.Lambda else []


def _defined(forms: Iterable[Any]) -> Iterator[Variable]:
    """Iterate over the variables that top-level forms define."""
    return (v for form in forms if type(form) is ast.Define for v in pattern_variables(form.target))


def _record_of(node: Any) -> ast.Application | None:
    """Return the making of a record type whose procedures a definition names, or None."""
    if type(node) is not ast.Define or type(node.value) is not ast.Application:
        return None
    function = node.value.function
    return node.value if type(function) is ast.Reference and function.target is MAKE_RECORD else None


def _bound(node: Any) -> list[Variable]:
    """Return the variables that a node binds in its subexpressions."""
    kind = type(node)
    if kind is ast.Lambda:
        targets = [parameter.target for parameter in node.parameters]
    elif kind is ast.Body:
        targets = [item.target for item in node.items if type(item) is ast.Define]
    elif kind is ast.For:
        targets = [item.target for item in node.accumulators]
        targets += [target for clause in node.clauses for target in clause.targets]
    elif kind is ast.LetEscape or kind is ast.Guard:
        targets = [node.target]
    else:
        return []
    return [variable for target in targets for variable in pattern_variables(target)]


class _Names:
    """Assignment of a name to every variable such that all references resolve correctly without hygiene.

    A variable is renamed if its name would capture a reference to an outer variable or shadow a special form. The names
    of keyword parameters, params and variables of other files cannot change; if one of them would capture a reference,
    the outer variable is renamed instead.
    """

    def __init__(self, forms: list[Any], fixed: frozenset[Variable]) -> None:
        self.names: dict[Variable, str] = {}
        self._free: dict[int, set[Variable]] = {}  # free variables of each binding node, by id
        self._fixed = set(fixed)
        self._renamed: set[Variable] = set()
        self._spelled: set[str] = set()
        globals_ = list(_defined(forms))
        mentioned: set[Variable] = set()
        for form in forms:
            mentioned |= self._visit(form)
        outside = mentioned - set(globals_)
        self.names.update((variable, variable.name) for variable in outside)
        self._fixed |= outside
        self._spelled.update(self.names.values())
        self._assign(globals_, outside)
        for form in forms:
            self._descend(form)

    def _visit(self, node: Any) -> set[Variable]:
        """Return the free variables of ``node``."""
        found: set[Variable] = set()
        target = getattr(node, "target", None)
        if type(node) in (ast.Reference, ast.Assignment) and isinstance(target, Variable):
            found.add(target)
        for child in children(node):
            found |= self._visit(child)
        bound = _bound(node)
        self._spelled.update(variable.name for variable in bound)
        if bound:
            found.difference_update(bound)
            self._free[id(node)] = found
        self._fix({p.name: p.target for p in _keywords(node) if p.target is not None}, found)
        record = _record_of(node)
        if record is not None:  # the names of a record's procedures stem from its name and fields
            self._fix({v.name: v for v in pattern_variables(node.target)}, found)
            for default in record.arguments[1:]:
                if type(default) is ast.Lambda:
                    earlier = {p.name: p.target for p in default.parameters if p.target is not None}
                    self._fix(earlier, self._free.get(id(default), set()))
        return set(found)

    def _fix(self, fixed: dict[str, Variable], visible: set[Variable]) -> None:
        """Keep the names of some variables; those of outer variables that they would capture change."""
        self._fixed.update(fixed.values())
        self._renamed.update(v for v in visible if v.name in fixed and v not in fixed.values())

    def _descend(self, node: Any) -> None:
        bound = _bound(node)
        if bound:
            self._assign([v for v in bound if v not in self.names], self._free[id(node)])
        for child in children(node):
            self._descend(child)

    def _assign(self, variables: list[Variable], visible: set[Variable]) -> None:
        taken = {self.names[variable] for variable in visible if variable in self.names}
        for variable in sorted(variables, key=lambda v: v not in self._fixed):
            is_readable = _reads_back(Symbol(variable.name))
            stem = variable.name if is_readable else _UNREADABLE.sub("-", variable.name).strip("-")
            stem = stem if is_readable or _reads_back(Symbol(stem)) else "v"
            name, count = stem, 0
            unfit = variable in self._renamed or (name in FORMS and name not in PAPER_FORMS) or name == "else"
            if variable in self._fixed and not is_readable:
                raise _unreadable(Symbol(name), variable.span)
            if variable in self._fixed and (unfit or name in taken):
                message = f"`{name}` shadows another `{name}` used by a macro, and neither can be renamed"
                raise SceneError("unsupported", message, "rename one of them", variable.span)
            while unfit or name in taken:
                count += 1
                name = f"{stem}.{count}"
                unfit = name in self._spelled
            self.names[variable] = name
            self._spelled.add(name)
            taken.add(name)


class _Unparser:
    def __init__(self, forms: list[Any], fixed: frozenset[Variable]) -> None:
        self.names = _Names(forms, fixed).names
        # the names of variables that hide the paper's forms; outside a program such a name is the form as a function
        defined = {variable for form in walk(*forms) for variable in _bound(form)} | set(_defined(forms))
        self.defined = defined
        self.taken = {self.names[variable] for variable in defined}

    def name(self, variable: Variable) -> str:
        return self.names[variable]

    def form(self, node: Any) -> Datum:
        return _UNPARSERS[type(node)](self, node)

    def forms(self, nodes: Iterable[Any]) -> list[Datum]:
        return [self.form(node) for node in nodes]

    def target(self, target: Any) -> Datum:
        if target is None:
            return _symbol("_")
        if isinstance(target, Variable):
            return _symbol(self.name(target))
        if isinstance(target, tuple):
            items, rest = target
            tail = None if rest is False else self.target(rest)
            return ListDatum(tuple(self.target(item) for item in items), tail, _NOWHERE)
        return _symbol(self._procedure_name(target))

    def _procedure_name(self, target: Any) -> str:
        name = target.name if isinstance(target, (Builtin, Procedure)) else str(target)
        return f"std/{name}" if name in self.taken else name

    def body(self, node: Any) -> list[Datum]:
        """Return the forms of a function's body."""
        return self.sequence(node.items if type(node) is ast.Body and not self._leading_locals(node) else (node,))

    def sequence(self, nodes: Iterable[Any]) -> list[Datum]:
        """Return forms in which none is a sequence of forms."""
        return [self.form(item) for node in nodes for item in self._sequence(node)]

    def _sequence(self, node: Any) -> Iterator[Any]:
        is_block = type(node) is ast.Body and bool(node.items) and not any(type(i) is ast.Define for i in node.items)
        for item in node.items if is_block else ():
            yield from self._sequence(item)
        if not is_block:
            yield node

    # --- one method per node -----------------------------------------------------------------------------------

    def constant(self, node: ast.Constant) -> Datum:
        datum = _constant_datum(node.value, node.span)
        plain = isinstance(datum, ArrayDatum) or (isinstance(datum, Atom) and not isinstance(datum.value, Symbol))
        return datum if plain else _list(_symbol("quote"), datum)

    def handle(self, node: ast.HandleLiteral) -> Datum:
        return _atom(Handle(node.name), node.span)

    def reference(self, node: ast.Reference) -> Datum:
        return self.target(node.target)

    def define(self, node: ast.Define) -> Datum:
        value = node.value
        record = _record_of(node)
        if record is not None:
            return self._record(record)
        if type(value) is ast.Lambda and isinstance(node.target, Variable):
            items, tail = self._parameter_list(value)
            head = ListDatum((self.target(node.target), *items), tail, _NOWHERE)
            return _list(_symbol("define"), head, *self.body(value.body))
        name = "define" if isinstance(node.target, Variable) else "define-values"
        return _list(_symbol(name), self.target(node.target), self.form(value))

    def function(self, node: ast.Lambda) -> Datum:
        items, tail = self._parameter_list(node)
        parameters = ListDatum(tuple(items), tail, _NOWHERE) if items or tail is None else tail
        return _list(_symbol("lambda"), parameters, *self.body(node.body))

    def _parameter_list(self, node: ast.Lambda) -> tuple[list[Datum], Datum | None]:
        """Return a function's parameters, and the parameter for the rest of the arguments."""
        items: list[Datum] = []
        tail: Datum | None = None
        for parameter in node.parameters:
            annotation = f"::{parameter.type.name}" if parameter.type is not None else ""
            name = self.name(parameter.target) if parameter.target is not None else "_"
            atom: Datum = _symbol(name + annotation)
            if parameter.kind == "keyword":
                atom = _atom(Keyword(parameter.name + annotation), node.span)
            if parameter.default is not None:
                atom = _list(atom, self.form(parameter.default))
            if parameter.kind == "rest":
                tail = atom
            elif parameter.kind == "keys":
                items += (_symbol("&keys"), atom)
            else:
                items.append(atom)
        return items, tail

    def block(self, node: ast.Body) -> Datum:
        locals_ = self._leading_locals(node)
        if locals_:
            bindings = [_list(self.target(item.target), self.form(item.value)) for item in locals_]
            return _list(_symbol("let*"), _list(*bindings), *self.sequence(node.items[len(locals_) :]))
        if any(type(item) is ast.Define for item in node.items):
            return _list(_symbol("let"), _list(), *self.sequence(node.items))
        return _list(_symbol("begin"), *self.sequence(node.items))

    @staticmethod
    def _leading_locals(node: ast.Body) -> list[ast.Define]:
        """Return the leading definitions that stem from a ``let``: their variables are not visible before them."""
        leading = []
        for item in node.items:
            if type(item) is not ast.Define or any(v.recursive for v in pattern_variables(item.target)):
                break
            leading.append(item)
        return leading

    def application(self, node: ast.Application) -> Datum:
        head = self.form(node.function)
        is_own = type(node.function) is ast.Reference and node.function.target in self.defined
        if isinstance(head, Atom) and head.value in PAPER_FORMS and not is_own:
            head = _list(_symbol("begin"), head)  # the form as a function, which checks its arguments when it is called
        return _list(head, *self.forms(node.arguments))

    def _record(self, node: ast.Application) -> Datum:
        facts = node.arguments[0]
        assert type(facts) is ast.Constant
        name, names, types = facts.value
        fields: list[Datum] = []
        for field, expected, default in zip(names, types, node.arguments[1:], strict=True):
            atom = _symbol(field if expected is None else f"{field}::{expected.name}")
            fields.append(_list(atom, self.form(default.body)) if type(default) is ast.Lambda else atom)
        return _list(_symbol("define-record"), _symbol(name), *fields)

    def loop(self, node: ast.For) -> Datum:
        name = "for*" if node.kind == "each" else f"for*/{node.kind}"
        parts: list[Datum] = [_symbol(name)]
        if node.accumulators:
            parts.append(_list(*(_list(self.target(a.target), self.form(a.value)) for a in node.accumulators)))
        parallel = any(len(clause.targets) > 1 for clause in node.clauses)
        is_nested = sum(clause.kind == "each" for clause in node.clauses) > 1 and not parallel
        if node.accumulators:
            parts[0] = _symbol("for*/fold" if is_nested else "for/fold")
        if parallel and not node.accumulators:
            parts[0] = _symbol(name.replace("for*", "for"))
        clauses: list[Datum] = []
        for clause in node.clauses:
            if clause.kind == "each":
                clauses += [_list(self.target(t), self.form(v)) for t, v in zip(clause.targets, clause.values)]
            else:
                clauses += (Atom(Keyword(clause.kind), _NOWHERE), self.form(clause.values[0]))
        return _list(*parts, _list(*clauses), *self.body(node.body))

    def guard(self, node: ast.Guard) -> Datum:
        clause = _list(_symbol("else"), *self.body(node.handler))
        return _list(_symbol("guard"), _list(self.target(node.target), clause), *self.body(node.body))


def _constant_datum(value: Any, span: Span) -> Datum:
    """Return a constant as a datum, without the quote that a list or symbol requires."""
    if type(value) is Pair:
        items = []
        while type(value) is Pair:
            items.append(_constant_datum(value.car, span))
            value = value.cdr
        return ListDatum(tuple(items), None if value is NIL else _constant_datum(value, span), _NOWHERE)
    if value is NIL:
        return _list()
    if type(value) is Vector:
        return ArrayDatum(tuple(_atom(item, span) for item in value), _NOWHERE)
    if type(value) in (Matrix, Array):
        data = to_array(value) if type(value) is Matrix else value.data
        return _nested(data.tolist())
    if type(value) is Embedding and value.handle is not None:
        return _atom(Handle(value.handle), span)
    return _atom(value, span)


def _nested(rows: Any) -> Datum:
    if isinstance(rows, list):
        return ArrayDatum(tuple(_nested(row) for row in rows), _NOWHERE)
    return Atom(rows, _NOWHERE)


def _headed(name: str, *fields: str) -> Callable[[_Unparser, Any], Datum]:
    """Return an unparser of a form whose operands are ``fields`` of the node; tuples are spliced, None is omitted."""

    def build(unparser: _Unparser, node: Any) -> Datum:
        operands: list[Datum] = []
        for field in fields:
            value = getattr(node, field)
            if isinstance(value, tuple):
                operands += unparser.forms(value)
            elif value is not None:
                operands.append(unparser.target(value) if field == "target" else unparser.form(value))
        hidden = name in unparser.taken and name in PAPER_FORMS
        return _list(_symbol(f"std/{name}" if hidden else name), *operands)

    return build


_UNPARSERS: dict[type, Callable[[_Unparser, Any], Datum]] = {
    ast.Constant: _Unparser.constant,
    ast.HandleLiteral: _Unparser.handle,
    ast.Reference: _Unparser.reference,
    ast.Assignment: _headed("set!", "target", "value"),
    ast.If: _headed("if", "test", "then", "otherwise"),
    ast.And: _headed("and", "items"),
    ast.Or: _headed("or", "items"),
    ast.Lambda: _Unparser.function,
    ast.Define: _Unparser.define,
    ast.Body: _Unparser.block,
    ast.First: _headed("begin0", "items"),
    ast.Application: _Unparser.application,
    ast.ArrayLiteral: lambda u, n: ArrayDatum(tuple(u.forms(n.items)), _NOWHERE),
    ast.While: lambda u, n: _list(_symbol("while"), u.form(n.test), *u.body(n.body)),
    ast.For: _Unparser.loop,
    ast.LetEscape: lambda u, n: _list(_symbol("let/ec"), u.target(n.target), *u.body(n.body)),
    ast.Guard: _Unparser.guard,
    ast.Bind: _headed("bind", "word", "function"),
    ast.Call: _headed("call", "word", "arguments"),
    ast.Union: _headed("union", "members"),
    ast.UnionLoop: _headed("union-loop", "count", "function"),
    ast.Transform: _headed("transform", "part", "matrix"),
}
