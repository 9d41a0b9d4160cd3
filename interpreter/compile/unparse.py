"""Unparser: convert the core AST back to a program in the language, for ``expand``.

The result shows a program without macros and derived forms.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Handle, Keyword, ListDatum, Source, Span, Symbol
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.compile.analyse import children, pattern_variables
from scenelang.interpreter.expand.forms import FORMS
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.program.program import PAPER_FORMS
from scenelang.interpreter.runtime.procedures import MAKE_RECORD
from scenelang.interpreter.runtime.types import Builtin
from scenelang.interpreter.runtime.values import NIL, Array, Embedding, Matrix, Pair, Procedure, Vector
from scenelang.interpreter.scene.pose import to_array

_NOWHERE = Span(Source("<expansion>", ""), 0, 0)


def _list(*items: Datum) -> ListDatum:
    return ListDatum(items, None, _NOWHERE)


def _symbol(name: str) -> Atom:
    return Atom(Symbol(name), _NOWHERE)


def unparse(forms: Iterable[Any], fixed: frozenset[Variable] = frozenset()) -> list[Datum]:
    """Convert top-level core forms to datums.

    A variable that would capture references to another one is renamed with a number, except for the variables in
    ``fixed``. Raises ``SceneError`` if two variables that cannot be renamed collide.
    """
    forms = list(forms)
    unparser = _Unparser(forms, fixed)
    return [unparser.form(form) for form in forms]


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
        globals_: list[Variable] = []
        mentioned: set[Variable] = set()
        for form in forms:
            mentioned |= self._visit(form)
            if type(form) is ast.Define:
                globals_ += pattern_variables(form.target)
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
        if type(node) is ast.Lambda:
            fixed = {p.name: p.target for p in node.parameters if p.kind == "keyword"}
            self._fixed.update(fixed.values())
            self._renamed.update(v for v in found if v.name in fixed)
        return set(found)

    def _descend(self, node: Any) -> None:
        bound = _bound(node)
        if bound:
            self._assign([v for v in bound if v not in self.names], self._free[id(node)])
        for child in children(node):
            self._descend(child)

    def _assign(self, variables: list[Variable], visible: set[Variable]) -> None:
        taken = {self.names[variable] for variable in visible if variable in self.names}
        for variable in sorted(variables, key=lambda v: v not in self._fixed):
            name, count = variable.name, 0
            unfit = variable in self._renamed or (name in FORMS and name not in PAPER_FORMS) or name == "else"
            if variable in self._fixed and (unfit or name in taken):
                message = f"`{name}` shadows another `{name}` used by a macro, and neither can be renamed"
                raise SceneError("unsupported", message, "rename one of them", variable.span)
            while unfit or name in taken:
                count += 1
                name = f"{variable.name}.{count}"
                unfit = name in self._spelled
            self.names[variable] = name
            self._spelled.add(name)
            taken.add(name)


class _Unparser:
    def __init__(self, forms: list[Any], fixed: frozenset[Variable]) -> None:
        self.names = _Names(forms, fixed).names
        self.taken = set(self.names.values())

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
        if type(node) is ast.Body and not self._leading_locals(node):
            return self.forms(node.items)
        return [self.form(node)]

    # --- one method per node -----------------------------------------------------------------------------------

    def constant(self, node: ast.Constant) -> Datum:
        datum = constant_datum(node.value)
        plain = isinstance(datum, ArrayDatum) or (isinstance(datum, Atom) and not isinstance(datum.value, Symbol))
        return datum if plain else _list(_symbol("quote"), datum)

    def handle(self, node: ast.HandleLiteral) -> Datum:
        return Atom(Handle(node.name), _NOWHERE)

    def reference(self, node: ast.Reference) -> Datum:
        return self.target(node.target)

    def define(self, node: ast.Define) -> Datum:
        value = node.value
        if type(value) is ast.Lambda and isinstance(node.target, Variable):
            parameters = self.parameters(value)
            head = ListDatum((self.target(node.target), *parameters.items), parameters.tail, _NOWHERE)
            return _list(_symbol("define"), head, *self.body(value.body))
        name = "define" if isinstance(node.target, Variable) else "define-values"
        return _list(_symbol(name), self.target(node.target), self.form(value))

    def function(self, node: ast.Lambda) -> Datum:
        return _list(_symbol("lambda"), self.parameters(node), *self.body(node.body))

    def parameters(self, node: ast.Lambda) -> ListDatum:
        items: list[Datum] = []
        tail: Datum | None = None
        for parameter in node.parameters:
            annotation = f"::{parameter.type.name}" if parameter.type is not None else ""
            name = self.name(parameter.target) if parameter.target is not None else "_"
            atom: Datum = _symbol(name + annotation)
            if parameter.kind == "keyword":
                atom = Atom(Keyword(parameter.name + annotation), _NOWHERE)
            if parameter.default is not None:
                atom = _list(atom, self.form(parameter.default))
            if parameter.kind == "rest":
                tail = atom
            elif parameter.kind == "keys":
                items += (_symbol("&keys"), atom)
            else:
                items.append(atom)
        return ListDatum(tuple(items), tail, _NOWHERE)

    def block(self, node: ast.Body) -> Datum:
        locals_ = self._leading_locals(node)
        if locals_:
            bindings = [_list(self.target(item.target), self.form(item.value)) for item in locals_]
            return _list(_symbol("let*"), _list(*bindings), *self.forms(node.items[len(locals_) :]))
        if any(type(item) is ast.Define for item in node.items):
            return _list(_symbol("let"), _list(), *self.forms(node.items))
        return _list(_symbol("begin"), *self.forms(node.items))

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
        head = node.function
        if type(head) is ast.Reference and head.target is MAKE_RECORD:
            return self._record(node)
        return _list(self.form(head), *self.forms(node.arguments))

    def _record(self, node: ast.Application) -> Datum:
        facts = node.arguments[0]
        assert type(facts) is ast.Constant
        return _list(_symbol("record-type"), _symbol(facts.value[0]), *(_symbol(f) for f in facts.value[1]))

    def loop(self, node: ast.For) -> Datum:
        name = "for*" if node.kind == "each" else f"for*/{node.kind}"
        parts: list[Datum] = [_symbol(name)]
        if node.accumulators:
            parts.append(_list(*(_list(self.target(a.target), self.form(a.value)) for a in node.accumulators)))
            parts[0] = _symbol("for/fold")
        parallel = any(len(clause.targets) > 1 for clause in node.clauses)
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


def constant_datum(value: Any) -> Datum:
    """Return a constant as a datum, without the quote that a list or symbol requires."""
    if type(value) is Pair:
        items = []
        while type(value) is Pair:
            items.append(constant_datum(value.car))
            value = value.cdr
        return ListDatum(tuple(items), None if value is NIL else constant_datum(value), _NOWHERE)
    if value is NIL:
        return _list()
    if type(value) is Vector:
        return ArrayDatum(tuple(Atom(item, _NOWHERE) for item in value), _NOWHERE)
    if type(value) in (Matrix, Array):
        data = to_array(value) if type(value) is Matrix else value.data
        return _nested(data.tolist())
    if type(value) is Embedding and value.handle is not None:
        return Atom(Handle(value.handle), _NOWHERE)
    return Atom(value, _NOWHERE)


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
