"""Unparser: convert the core AST back to a program in the language, for ``expand``.

The result shows a program without macros and derived forms.
"""

from __future__ import annotations

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
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.grammar.reader import read
from scenelang.interpreter.compile.analyze import children, pattern_variables, walk
from scenelang.interpreter.expand.forms import FORMS, PAPER_FORMS
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.procedures import MAKE_RECORD
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.scene.pose import to_array
from scenelang.interpreter.values.values import NIL, Array, Embedding, Matrix, Pair, Procedure, Vector

_NOWHERE = Span(Source("<expansion>", ""), 0, 0)
# Characters that are replaced in the name of a renamed variable.
_UNREADABLE = lazy_pattern(r"[^A-Za-z0-9!?*<>=/_-]+")
_PLAIN = (int, float, bool, str, type(None))  # types of atoms whose printed text always reads as an equal atom


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
    """Return the error for a value that no text reads as."""
    kind = "symbol" if type(value) is Symbol else "value"
    message = f"the expansion has the {kind} `{show(value, 60)}`, and no text reads as that {kind}"
    return SceneError("unsupported", message, "let the macro insert a string, or code that makes the value", span)


def _keywords(node: Any) -> list[ast.Parameter]:
    """Return the keyword parameters of a function."""
    return [p for p in node.parameters if p.kind == "keyword"] if type(node) is ast.Lambda else []


def _defined(forms: Iterable[Any]) -> Iterator[Variable]:
    """Iterate over the variables that top-level forms define."""
    return (v for form in forms if type(form) is ast.Define for v in pattern_variables(form.target))


def _record_of(node: Any) -> ast.Application | None:
    """Return the call that creates a record type, if the node defines its procedures, else None."""
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
        """Name all variables of a program; those in ``fixed`` keep their names."""
        self.names: dict[Variable, str] = {}
        self._free: dict[int, set[Variable]] = {}  # free variables of each binding node, by id
        self._fixed = set(fixed)
        self._renamed: set[Variable] = set()  # variables that a fixed name would capture
        self._spelled: set[str] = set()  # names in the program, which new names avoid
        # First, find the free variables of all nodes, on which it depends which names would capture a reference.
        globals_ = list(_defined(forms))
        mentioned: set[Variable] = set()
        for form in forms:
            mentioned |= self._visit(form)
        # Variables of other files keep their names, so these are assigned before all others.
        outside = mentioned - set(globals_)
        self.names.update((variable, variable.name) for variable in outside)
        self._fixed |= outside
        self._spelled.update(self.names.values())
        # Then name from the outside in: an inner variable must avoid the names of outer ones that its scope refers to.
        self._assign(globals_, outside)
        for form in forms:
            self._descend(form)

    def _visit(self, node: Any) -> set[Variable]:
        """Return the free variables of ``node``."""
        free: set[Variable] = set()
        target = getattr(node, "target", None)
        if type(node) in (ast.Reference, ast.Assignment) and isinstance(target, Variable):
            free.add(target)
        for child in children(node):
            free |= self._visit(child)
        bound = _bound(node)
        self._spelled.update(variable.name for variable in bound)
        if bound:
            free.difference_update(bound)
            self._free[id(node)] = free
        self._fix({p.name: p.target for p in _keywords(node) if p.target is not None}, free)
        record = _record_of(node)
        if record is not None:  # the names of a record's procedures stem from its name and fields
            self._fix({v.name: v for v in pattern_variables(node.target)}, free)
            for default in record.arguments[1:]:
                if type(default) is ast.Lambda:
                    earlier = {p.name: p.target for p in default.parameters if p.target is not None}
                    self._fix(earlier, self._free.get(id(default), set()))
        return set(free)

    def _fix(self, fixed: dict[str, Variable], visible: set[Variable]) -> None:
        """Keep the names of some variables, and rename outer variables that they would capture."""
        self._fixed.update(fixed.values())
        self._renamed.update(v for v in visible if v.name in fixed and v not in fixed.values())

    def _descend(self, node: Any) -> None:
        """Name the variables that a node and its descendants bind, outermost first."""
        bound = _bound(node)
        if bound:
            self._assign([v for v in bound if v not in self.names], self._free[id(node)])
        for child in children(node):
            self._descend(child)

    def _assign(self, variables: list[Variable], visible: set[Variable]) -> None:
        """Name variables that one node binds; ``visible`` are the outer variables that its subexpressions use.

        Variables whose names are fixed come first. Raises ``SceneError`` if two of them collide.
        """
        taken = {self.names[variable] for variable in visible if variable in self.names}
        for variable in sorted(variables, key=lambda v: v not in self._fixed):
            is_readable = _reads_back(Symbol(variable.name))
            stem = variable.name if is_readable else _UNREADABLE.sub("-", variable.name).strip("-")
            stem = stem if is_readable or _reads_back(Symbol(stem)) else "v"
            name, count = stem, 0
            is_unfit = variable in self._renamed or (name in FORMS and name not in PAPER_FORMS) or name == "else"
            if variable in self._fixed and not is_readable:
                raise _unreadable(Symbol(name), variable.span)
            if variable in self._fixed and (is_unfit or name in taken):
                message = f"`{name}` shadows another `{name}` used by a macro, and neither can be renamed"
                raise SceneError("unsupported", message, "rename one of them", variable.span)
            while is_unfit or name in taken:
                count += 1
                name = f"{stem}.{count}"
                is_unfit = name in self._spelled
            self.names[variable] = name
            self._spelled.add(name)
            taken.add(name)


class _Unparser:
    """Converter of core forms to datums, with one method per node, once all variables have names."""

    def __init__(self, forms: list[Any], fixed: frozenset[Variable]) -> None:
        self.names = _Names(forms, fixed).names
        # A variable can hide one of the paper's forms; in a program without such a variable, the name is the form as a
        # function.
        defined = {variable for form in walk(*forms) for variable in _bound(form)} | set(_defined(forms))
        self.defined = defined
        self.taken = {self.names[variable] for variable in defined}

    def name(self, variable: Variable) -> str:
        """Return the name of a variable in the text."""
        return self.names[variable]

    def form(self, node: Any) -> Datum:
        """Return an expression or definition as a datum."""
        return _UNPARSERS[type(node)](self, node)

    def forms(self, nodes: Iterable[Any]) -> list[Datum]:
        """Return several expressions as datums."""
        return [self.form(node) for node in nodes]

    def target(self, target: Any) -> Datum:
        """Return a variable, a pattern, ``_``, or the name of a builtin."""
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
        """Return the name of a builtin, with ``std/`` if a variable of the program hides it."""
        name = target.name if isinstance(target, (Builtin, Procedure)) else str(target)
        return f"std/{name}" if name in self.taken else name

    def body(self, node: Any) -> list[Datum]:
        """Return the forms of a function's body."""
        return self.sequence(node.items if type(node) is ast.Body and not self._leading_locals(node) else (node,))

    def sequence(self, nodes: Iterable[Any]) -> list[Datum]:
        """Return forms with nested sequences spliced in."""
        return [self.form(item) for node in nodes for item in self._sequence(node)]

    def _sequence(self, node: Any) -> Iterator[Any]:
        """Iterate over the expressions of a body without definitions; any other node is one expression."""
        is_sequence = type(node) is ast.Body and bool(node.items) and not any(type(i) is ast.Define for i in node.items)
        if not is_sequence:
            yield node
            return
        for item in node.items:
            yield from self._sequence(item)

    # --- one method per node -----------------------------------------------------------------------------------

    def constant(self, node: ast.Constant) -> Datum:
        """Return a literal; lists and symbols are quoted."""
        datum = _constant_datum(node.value, node.span)
        is_literal = isinstance(datum, ArrayDatum) or (isinstance(datum, Atom) and not isinstance(datum.value, Symbol))
        return datum if is_literal else _list(_symbol("quote"), datum)

    def handle(self, node: ast.HandleLiteral) -> Datum:
        """Return a handle."""
        return _atom(Handle(node.name), node.span)

    def reference(self, node: ast.Reference) -> Datum:
        """Return the name of a variable or builtin."""
        return self.target(node.target)

    def define(self, node: ast.Define) -> Datum:
        """Return ``define``, ``define-values`` or ``define-record``."""
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
        """Return a ``lambda``."""
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
        """Return a body as an expression: ``let*``, ``let`` or ``begin``."""
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
        """Return a call."""
        head = self.form(node.function)
        is_defined = type(node.function) is ast.Reference and node.function.target in self.defined
        if isinstance(head, Atom) and head.value in PAPER_FORMS and not is_defined:
            head = _list(_symbol("begin"), head)  # the form as a function, which checks its arguments when it is called
        return _list(head, *self.forms(node.arguments))

    def _record(self, node: ast.Application) -> Datum:
        """Return ``define-record`` for the call that creates a record type."""
        facts = node.arguments[0]
        assert type(facts) is ast.Constant
        name, names, types = facts.value
        fields: list[Datum] = []
        for field, expected, default in zip(names, types, node.arguments[1:], strict=True):
            atom = _symbol(field if expected is None else f"{field}::{expected.name}")
            fields.append(_list(atom, self.form(default.body)) if type(default) is ast.Lambda else atom)
        return _list(_symbol("define-record"), _symbol(name), *fields)

    def loop(self, node: ast.For) -> Datum:
        """Return a ``for`` form; clauses with several targets are parallel and need ``for`` rather than ``for*``."""
        name = "for*" if node.kind == "each" else f"for*/{node.kind}"
        parts: list[Datum] = [_symbol(name)]
        if node.accumulators:
            parts.append(_list(*(_list(self.target(a.target), self.form(a.value)) for a in node.accumulators)))
        is_parallel = any(len(clause.targets) > 1 for clause in node.clauses)
        is_nested = sum(clause.kind == "each" for clause in node.clauses) > 1 and not is_parallel
        if node.accumulators:
            parts[0] = _symbol("for*/fold" if is_nested else "for/fold")
        if is_parallel and not node.accumulators:
            parts[0] = _symbol(name.replace("for*", "for"))
        clauses: list[Datum] = []
        for clause in node.clauses:
            if clause.kind == "each":
                clauses += [_list(self.target(t), self.form(v)) for t, v in zip(clause.targets, clause.values)]
            else:
                clauses += (Atom(Keyword(clause.kind), _NOWHERE), self.form(clause.values[0]))
        return _list(*parts, _list(*clauses), *self.body(node.body))

    def guard(self, node: ast.Guard) -> Datum:
        """Return ``guard`` with a single ``else`` clause; the expander made others tests in the handler."""
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
    """Return nested lists of numbers as array literals."""
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
