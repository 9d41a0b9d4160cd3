"""Data that Python computes by means which the translation does not know: parsed texts, mazes, solvers, noise.

An expression, or a run of statements, that makes no shapes is evaluated wherever the program gets to it, and its value
written down: as a constant, or as a table by the variables on which it depends. The functions that make shapes are
translated as they are, with their loops and parameters; a value of a parameter that is not in a table is an error.

A *site* is the smallest such part around what does not translate whose value is data, that changes nothing and that
depends on data alone. If it is not, the part around it is tried: the expression it is in, its statement, the
statements before. A variable that holds no data (an iterator, an object of a class that does not translate) exists
only while the program is translated; what uses it is a site of its own, by what the variable depends on.
"""

from __future__ import annotations

import ast
import copy
import itertools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np

from scenelang.grammar.diagnostics import Diagnostic
from scenelang.interpreter.runtime.modelling_helpers import ASSERT_THAT, relation_helpers, scene_helpers
from scenelang.interpreter.transpile.analysis.python_text import (
    PythonText,
    child_nodes,
    scope_of,
    variable_of,
    walk_tree,
)
from scenelang.interpreter.transpile.analysis.rewriting import is_annotation, is_registered, parents_of, placed
from scenelang.interpreter.transpile.evaluation import NeedsPrimitives, UnsupportedPython
from scenelang.interpreter.transpile.evaluation.evaluator import StepBudget
from scenelang.interpreter.transpile.evaluation.folding import Folding, defaults_of, fixed_parameter, items_of
from scenelang.interpreter.transpile.evaluation.loops import Heap, UnrollPlan
from scenelang.interpreter.transpile.evaluation.objects import (
    MISSING,
    Frame,
    IntMember,
    NamedTuple,
    Native,
    PythonGenerator,
    PythonObject,
    TextMember,
    Unroll,
    ValueObject,
)
from scenelang.interpreter.transpile.evaluation.residue import Residual, call_node, has_residual, node_of

_MOST_ROUNDS = 30  # evaluations with other sites
_MOST_ROWS = 400  # of a table
_MOST_ITEMS = 1_000  # of an iterator
_MOST_NODES = 20_000  # of the data of a program
_MOST_COMPARED = 40  # evaluations of a site after which nothing may have changed
_MOST_COORDINATES = 4  # of an array on which a site depends
_POINT = "coordinates"
_MOST_FIELDS = 8  # of an object on which a site depends
_SHAPE_MAKERS = frozenset(
    [
        "primitive_call",
        "library_call",
        "concat_shapes",
        "loop",
        "transform_shape",
        "compute_shape_center",
        "compute_shape_min",
        "compute_shape_max",
        "compute_shape_sizes",
    ]
)
_TAKERS = ("list", "tuple", "set", "sum", "sorted", "min", "max", "any", "all", "dict", "enumerate", "zip", "len")
_SCOPES = (ast.FunctionDef, ast.Lambda)
_COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
_VIEWS: tuple[type, ...] = (type({}.keys()), type({}.values()), type({}.items()), range)
_ENTER, _LEAVE, _VALUE = "site of statements", "end of statements", "site"  # no names of Python


class _Failure(Exception):
    """The data of a program cannot be written down."""


@dataclass(eq=False)
class _Site:
    """Part of a program whose value is written down.

    Attributes
    ----------
    nodes
        One expression, or statements in a row.
    keys
        Names of the variables on which the value depends.
    outputs
        Variables that statements assign for others.
    hidden
        Those of them that are no data.
    rows
        Values by keys, as texts of their expressions: the keys and the values themselves.
    """

    nodes: list[Any]
    keys: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    hidden: set[str] = field(default_factory=set)
    rows: dict[str, tuple[list[ast.expr], list[ast.expr]]] = field(default_factory=dict)
    made: list[tuple[Any, str]] = field(default_factory=list)
    parts: list[list[str]] | None = None  # of the keys: the attributes of objects
    failure: str = ""
    count: int = 0
    is_taken: bool = False  # whether its items are all that is used of it
    stored: frozenset[str] = frozenset()
    used: frozenset[str] = frozenset()  # all variables that it reads
    index: str = ""  # variable that counts the items of a loop, which are no data

    @property
    def is_expression(self) -> bool:
        return isinstance(self.nodes[0], ast.expr)


def tabulated(text: PythonText, root: str, errors: Sequence[Diagnostic], budget: StepBudget) -> PythonText | None:
    """Return a program with data in place of what has errors and computes it; None if that is impossible."""
    try:
        return _Tabulation(text, root, errors, budget).result()
    except _Failure:
        return None


class _Tabulation:
    """Finds sites, and writes down what they give."""

    def __init__(self, text: PythonText, root: str, errors: Sequence[Diagnostic], budget: StepBudget) -> None:
        self._text, self._root, self._budget = text, root, budget
        self._errors = errors
        self._tree = text.tree
        self._parents = parents_of(self._tree)
        self._shaped = self._shape_makers()
        self._variables: dict[ast.AST, set[str]] = {}  # that hold shapes, by scope
        self._opaque: set[str] = set()  # functions and classes that exist only while the program is translated
        self._methods: set[str] = set()  # such methods
        self._sites: list[_Site] = []
        self._hidden: dict[tuple[ast.AST, str], _Site] = {}  # by scope and name
        self._names = {n.id for n in walk_tree(self._tree) if isinstance(n, ast.Name)}
        self._names |= {n.name for n in walk_tree(self._tree) if isinstance(n, (ast.FunctionDef, ast.ClassDef))}

    def result(self) -> PythonText:
        """Return the program with the data."""
        self._find_opaque()
        for node in walk_tree(self._tree):
            if self._is_touching(node):
                self._add(node)
        if not self._sites:
            raise _Failure
        for _ in range(_MOST_ROUNDS):
            for site in self._sites:
                self._describe(site)
            self._evaluate()
            failed = [site for site in self._sites if site.failure]
            if not failed:
                return self._rewritten()
            causes = [site for site in failed if site.failure != "key"]  # a variable that is no data may vanish
            for site in causes or failed:
                if site in self._sites:
                    self._widen(site)
        raise _Failure

    # --- what makes shapes, and what does not translate --------------------------------------------------------

    def _shape_makers(self) -> set[str]:
        """Return the names of functions and classes that make shapes, directly or through others."""
        makers = {*_SHAPE_MAKERS, *_modelling_called(self._tree)}
        tops = [each for each in self._tree.body if isinstance(each, (ast.FunctionDef, ast.ClassDef))]
        uses = {each.name: _names_in(each) for each in tops}
        changed = True
        while changed:
            more = {name for name, used in uses.items() if used & makers} - makers
            methods = {
                each.name
                for cls in tops if isinstance(cls, ast.ClassDef)
                for each in _methods_of(cls) if not each.name.startswith("__") and _names_in(each) & makers
            }  # fmt: skip
            changed = bool((more | methods) - makers)
            makers |= more | methods
        return makers

    def _is_shapeless(self, *nodes: ast.AST) -> bool:
        """Return whether a part neither makes shapes nor uses variables that hold some."""
        used = {name for node in nodes for name in _names_in(node)}
        if used & self._shaped:
            return False
        scope = self._scope(nodes[0])
        while not isinstance(scope, ast.Module):
            if used & self._shape_variables(scope):
                return False
            scope = self._scope(self._parents[scope])
        return not any(isinstance(n, (ast.Yield, ast.YieldFrom)) for node in nodes for n in walk_tree(node))

    def _shape_variables(self, scope: ast.AST) -> set[str]:
        """Return the variables of a function that hold shapes: those assigned from what makes some."""
        if scope in self._variables:
            return self._variables[scope]
        variables: set[str] = set()
        assigned = [(_targets(node), _names_in(_value_in(node))) for node in walk_tree(scope)]
        changed = True
        while changed:
            changed = False
            for targets, used in assigned:
                if targets - variables and used & (self._shaped | variables):
                    variables |= targets
                    changed = True
        self._variables[scope] = variables
        return variables

    def _find_opaque(self) -> None:
        """Find the functions, classes and methods without shapes in which errors are, and those that use them."""
        tops = [each for each in self._tree.body if isinstance(each, (ast.FunctionDef, ast.ClassDef))]
        wrong = [each for each in tops if self._has_error(each)]
        for each in wrong:
            if each.name not in self._shaped and not is_registered(each):
                if isinstance(each, ast.FunctionDef) or self._has_error_of_class(each):
                    self._opaque.add(each.name)
                else:
                    self._methods |= {m.name for m in _methods_of(each) if self._has_error(m)}
            elif isinstance(each, ast.ClassDef):
                if self._has_error_of_class(each):
                    raise _Failure  # a class that makes shapes
                self._methods |= {
                    m.name for m in _methods_of(each) if self._has_error(m) and m.name not in self._shaped
                }
        self._spread_opaque(frozenset())

    def _spread_opaque(self, names: frozenset[str]) -> None:
        """Mark functions, classes and methods without shapes that use opaque ones, or variables that are not data."""
        tops = [each for each in self._tree.body if isinstance(each, (ast.FunctionDef, ast.ClassDef))]
        changed = True
        while changed:
            before = len(self._opaque) + len(self._methods)
            for each in tops:
                if each.name in self._shaped or is_registered(each):
                    continue
                if isinstance(each, ast.FunctionDef):
                    self._opaque |= {each.name} if self._uses_opaque(names, each) else set()
                else:
                    wrong_methods = {m.name for m in _methods_of(each) if self._uses_opaque(names, m)}
                    is_whole = any(name.startswith("__") for name in wrong_methods) or self._uses_opaque(
                        names,
                        *each.bases,
                        *each.decorator_list,
                        *(s for s in each.body if not isinstance(s, ast.FunctionDef)),
                    )
                    self._opaque |= {each.name} if is_whole else set()
                    self._methods |= wrong_methods
            changed = before != len(self._opaque) + len(self._methods)

    def _has_error(self, node: ast.AST) -> bool:
        first = min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", ()))])  # type: ignore[attr-defined]
        start, end = self._text.offset(first, 0), self._text.span(node).end
        return any(d.span is not None and start <= d.span.start <= end for d in self._errors)

    def _has_error_of_class(self, node: ast.ClassDef) -> bool:
        """Return whether a class does not translate as a whole, or its instances cannot be made."""
        inside = [m for m in _methods_of(node) if not m.name.startswith("__")]
        spans = [self._text.span(m) for m in inside]
        start, end = self._text.span(node).start, self._text.span(node).end
        return any(
            d.span is not None and start <= d.span.start <= end
            and not any(span.start < d.span.start <= span.end for span in spans)
            for d in self._errors
        )  # fmt: skip

    def _uses_opaque(self, names: frozenset[str], *nodes: ast.AST) -> bool:
        return any(
            (isinstance(n, ast.Name) and n.id in self._opaque | names)
            or (isinstance(n, ast.Attribute) and n.attr in self._methods)
            for node in nodes for n in _with_meaning(node)
        )  # fmt: skip

    def _is_kept(self, node: ast.AST) -> bool:
        """Return whether a part remains in the program: it is not in an opaque function or class, or a decorator."""
        while node in self._parents:
            parent = self._parents[node]
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
                is_top = isinstance(parent, ast.Module)
                if (is_top and node.name in self._opaque) or (
                    isinstance(parent, ast.ClassDef) and node.name in self._methods
                ):
                    return False
            node = parent
        return True

    def _is_touching(self, node: ast.AST) -> bool:
        """Return whether a node that remains has an error, or is the name of something opaque."""
        if isinstance(node, ast.Name):
            is_local = self._binding(node) is not self._tree
            is_opaque = node.id in self._opaque and not is_local
            is_hidden = isinstance(node.ctx, ast.Load) and (self._binding(node), node.id) in self._hidden
            if (is_opaque or is_hidden) and self._is_kept(node):
                return not is_annotation(node, self._parents)
        if isinstance(node, ast.Attribute) and node.attr in self._methods:
            return self._is_kept(node)
        if not isinstance(node, (ast.expr, ast.stmt)) or isinstance(node, (ast.ClassDef, ast.Import, ast.ImportFrom)):
            return False
        span = self._text.span(node)
        if not any(d.span is not None and d.span.start == span.start and d.span.end == span.end for d in self._errors):
            return False
        return self._is_kept(node) and not is_annotation(node, self._parents)

    # --- sites -------------------------------------------------------------------------------------------------

    def _site_around(self, node: ast.AST) -> _Site | None:
        while True:
            for site in self._sites:
                if any(node is each for each in site.nodes):
                    return site
            if node not in self._parents:
                return None
            node = self._parents[node]

    def _add(self, node: ast.AST) -> None:
        """Add the site of a node that does not translate."""
        if self._site_around(node) is not None:
            return
        if isinstance(node, ast.expr):
            parent = self._parents[node]
            while isinstance(parent, (ast.Attribute, ast.Call, ast.Subscript)) and (
                node is getattr(parent, "func", None) or node is getattr(parent, "value", None)
            ):
                node, parent = parent, self._parents[parent]  # a call of a method, not the method
                if isinstance(node, ast.Call):
                    break
        self._grow(node)

    def _grow(self, node: ast.AST) -> None:
        """Make a site of a part without shapes, or of the part around it that can be one."""
        while isinstance(node, ast.expr) or not isinstance(node, ast.stmt):
            if isinstance(node, ast.expr) and self._is_value(node):
                if not self._is_shapeless(node):
                    raise _Failure(ast.unparse(node))
                return self._put(_Site([node]))
            if node not in self._parents:
                raise _Failure  # all statements of the module
            node = self._parents[node]
        if isinstance(node, ast.FunctionDef) and isinstance(self._parents[node], (ast.Module, ast.ClassDef)):
            raise _Failure
        self._grow_statements([node])

    def _is_value(self, node: ast.expr) -> bool:
        """Return whether an expression can be written down: it is no target, part of a text or an argument's name."""
        parent = self._parents[node]
        if isinstance(getattr(node, "ctx", None), (ast.Store, ast.Del)) or isinstance(node, (ast.Slice, ast.Starred)):
            return False
        if isinstance(parent, (ast.JoinedStr, ast.FormattedValue, ast.Expr)) or isinstance(node, ast.FormattedValue):
            return False
        if isinstance(parent, ast.Call) and node is parent.func:
            return False
        if isinstance(parent, ast.Attribute) and isinstance(self._parents.get(parent), ast.Call):
            return self._parents[parent].func is not parent  # type: ignore[attr-defined]
        return not any(isinstance(each, ast.NamedExpr) for each in walk_tree(node))

    def _grow_statements(self, nodes: list[Any]) -> None:
        for node in nodes:
            if isinstance(node, (ast.Return, ast.Import, ast.ImportFrom, ast.Global, ast.Nonlocal)):
                raise _Failure
            if not self._is_shapeless(node) or _leaves(node):
                raise _Failure
        self._put(_Site(nodes))

    def _put(self, site: _Site) -> None:
        inside = {each for node in site.nodes for each in walk_tree(node)}
        self._sites = [each for each in self._sites if each.nodes[0] not in inside]
        self._hidden = {key: each for key, each in self._hidden.items() if each in self._sites}
        self._sites.append(site)

    def _widen(self, site: _Site) -> None:
        """Try what is around a site that cannot be written down."""
        if site.is_expression:
            node = site.nodes[0]
            if site.failure == "value" and not site.index and self._is_iterated(node):
                self._count(site)
                return
            self._sites.remove(site)
            self._grow(self._parents[node])
            return
        new = [name for name in site.outputs if name in site.failure.split() and name not in site.hidden]
        if new:
            self._hide(site, new)
            return
        block = _block_of(self._parents[site.nodes[0]], site.nodes[0])
        place = next(n for n, each in enumerate(block) if each is site.nodes[0])
        self._sites.remove(site)
        if place == 0 or not self._is_shapeless(block[place - 1]):
            self._grow(self._parents[site.nodes[0]])
        else:
            self._grow_statements([block[place - 1], *site.nodes])

    def _is_iterated(self, node: ast.expr) -> bool:
        """Return whether an expression gives the items of a loop whose variables nothing else assigns."""
        loop = self._parents[node]
        if not isinstance(loop, (ast.For, ast.comprehension)) or node is not loop.iter:
            return False
        scope = self._scope(node) if isinstance(loop, ast.For) else self._parents[loop]
        names = {n.id for n in walk_tree(loop.target) if isinstance(n, ast.Name)}
        uses = [n for n in walk_tree(scope) if isinstance(n, ast.Name) and n.id in names and self._binding(n) is scope]
        stores = [n for n in uses if not isinstance(n.ctx, ast.Load)]
        return len(stores) == len(names) and all(
            isinstance(n, (ast.Name, ast.Tuple, ast.Store)) for n in walk_tree(loop.target)
        )

    def _count(self, site: _Site) -> None:
        """Count the items of a loop instead; what uses them is a site by their numbers."""
        loop: Any = self._parents[site.nodes[0]]
        scope = self._scope(loop) if isinstance(loop, ast.For) else self._parents[loop]
        number = itertools.count(2)
        site.index = "index"
        while site.index in self._names:
            site.index = f"index_{next(number)}"
        self._names.add(site.index)
        names = {n.id for n in walk_tree(loop.target) if isinstance(n, ast.Name)}
        for name in names:
            self._hidden[scope, name] = site
        for node in walk_tree(scope):
            if isinstance(node, ast.Name) and node.id in names and isinstance(node.ctx, ast.Load):
                if self._binding(node) is scope and self._is_kept(node):
                    self._add(node)

    def _hide(self, site: _Site, names: Sequence[str]) -> None:
        """Keep variables that hold no data out of the program: whatever uses them is a site."""
        scope = self._scope(site.nodes[0])
        inside = {each for node in site.nodes for each in walk_tree(node)}
        if isinstance(scope, ast.Module):
            self._spread_opaque(frozenset(names))
            self._sites = [each for each in self._sites if self._is_kept(each.nodes[0])]
        for name in names:
            site.hidden.add(name)
            self._hidden[scope, name] = site
            for node in walk_tree(scope):
                if not isinstance(node, ast.Name) or node.id != name or self._binding(node) is not scope:
                    continue
                if isinstance(node.ctx, ast.Load) and node not in inside and self._is_kept(node):
                    self._add(node)
                elif not isinstance(node.ctx, ast.Load) and self._site_around(node) is None:
                    raise _Failure  # assigned elsewhere, too
        if isinstance(scope, ast.Module):
            for node in walk_tree(self._tree):
                if self._is_touching(node):
                    self._add(node)

    # --- variables ---------------------------------------------------------------------------------------------

    def _scope(self, node: ast.AST) -> ast.AST:
        """Return the function around a node, or the module."""
        while node in self._parents:
            parent = self._parents[node]
            if isinstance(parent, _SCOPES) and (isinstance(parent, ast.Lambda) or node in parent.body):
                return parent
            node = parent
        return node

    def _binding(self, name: ast.Name) -> ast.AST:
        """Return the function or comprehension that has a variable, or the module."""
        node: ast.AST = name
        while node in self._parents:
            node = self._parents[node]
            if isinstance(node, _COMPREHENSIONS) and name.id in _comprehended(node):
                return node
            if isinstance(node, _SCOPES) and name.id in scope_of(node)[0]:
                return node
        return node

    def _describe(self, site: _Site) -> None:
        """Find on which variables a site depends, and what it gives."""
        site.rows, site.failure, site.count, site.made, site.parts = {}, "", 0, [], None
        inside = {each for node in site.nodes for each in walk_tree(node)}
        used: dict[str, ast.AST] = {}
        stored: set[str] = set()
        for node in inside:
            if isinstance(node, ast.Name):
                binding = self._binding(node)
                if isinstance(node.ctx, ast.Store) and binding not in inside:
                    stored.add(node.id)
                if isinstance(node.ctx, ast.Load) and binding not in inside:
                    used[node.id] = binding
            elif isinstance(node, ast.FunctionDef):
                stored.add(node.name)
        site.used = frozenset(used)
        keys: list[str] = []
        pending = sorted(used)
        while pending:
            name = pending.pop(0)
            home = self._hidden.get((used[name], name))
            if home is not None and home is not site:
                self._check_single(home.keys, used[name])
                needed = [*home.keys, *([home.index] if home.index else [])]
                pending += [each for each in needed if each not in used]
                used |= {each: used[name] for each in needed if each not in used}
            elif not isinstance(used[name], ast.Module) and not (
                name in stored and not self._is_stored_outside(name, used[name], inside)
            ):
                keys.append(name)
        site.keys, site.stored = tuple(dict.fromkeys(keys)), frozenset(stored)
        site.is_taken = site.is_expression and _is_taken(site.nodes[0], self._parents[site.nodes[0]])
        if not site.is_expression:
            scope = self._scope(site.nodes[0])
            loads = {
                node.id
                for node in walk_tree(scope)
                if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node not in inside
            }
            site.outputs = tuple(sorted(name for name in stored if name in loads))

    def _is_stored_outside(self, name: str, scope: ast.AST, inside: set[ast.AST]) -> bool:
        given = scope.args if isinstance(scope, _SCOPES) else None
        if given is not None and any(each.arg == name for each in walk_tree(given) if isinstance(each, ast.arg)):
            return True
        return any(
            isinstance(n, ast.Name) and n.id == name and not isinstance(n.ctx, ast.Load) and n not in inside
            for n in walk_tree(scope)
        )

    def _check_single(self, names: Iterable[str], scope: ast.AST) -> None:
        """Raise an exception if a variable, on which another depends that exists no longer, is assigned twice."""
        for name in names:
            stores = sum(
                isinstance(n, ast.Name) and n.id == name and not isinstance(n.ctx, ast.Load) for n in walk_tree(scope)
            )
            given = scope.args if isinstance(scope, _SCOPES) else None
            is_parameter = given is not None and any(
                isinstance(each, ast.arg) and each.arg == name for each in walk_tree(given)
            )
            if stores + is_parameter > 1:
                raise _Failure

    # --- evaluation --------------------------------------------------------------------------------------------

    def _evaluate(self) -> None:
        instrumented = _Instrumented(self._sites).result(self._tree)
        run = _Run(replace(self._text, tree=instrumented), self._sites, self._budget, self._kept_classes())
        try:
            run.evaluate(self._root)
        finally:
            self._budget.left -= run.evaluator.steps
        if run.error is not None or any(site.failure for site in self._sites):
            if not any(site.failure for site in self._sites):
                raise _Failure(run.error)
            return
        for site in self._sites:
            if any(_text_of(run.data(value)) != text for value, text in site.made):
                site.failure = "value"  # which the program changes later

    def _kept_classes(self) -> frozenset[str]:
        tops = (each for each in self._tree.body if isinstance(each, ast.ClassDef))
        return frozenset(each.name for each in tops if each.name not in self._opaque)

    # --- the program with the data -----------------------------------------------------------------------------

    def _rewritten(self) -> PythonText:
        size = sum(sum(1 for row in site.rows.values() for n in row[1] for _ in ast.walk(n)) for site in self._sites)
        if size > _MOST_NODES:
            raise _Failure
        memo: dict[int, Any] = {}
        tree = copy.deepcopy(self._tree, memo)
        made: list[tuple[ast.AST, list[ast.stmt]]] = []  # by the statements at the top level that need them
        for site in self._sites:
            made.append((memo[id(self._top_level(site.nodes[0]))], []))
            self._replace(site, memo, made[-1][1])
        body = [
            each
            for each in tree.body
            if not (isinstance(each, (ast.FunctionDef, ast.ClassDef)) and each.name in self._opaque)
        ]
        for cls in body:
            if isinstance(cls, ast.ClassDef) and self._methods:
                kept = [m for m in cls.body if not (isinstance(m, ast.FunctionDef) and m.name in self._methods)]
                cls.body = kept or [ast.copy_location(ast.Pass(), cls)]
        for top, statements in made:
            place = next((n for n, each in enumerate(body) if each is top), 0)
            used = {n.id for n in walk_tree(*statements) if isinstance(n, ast.Name)}
            if isinstance(top, (ast.FunctionDef, ast.ClassDef)):  # which looks when it is called
                classes = [n for n, each in enumerate(body) if isinstance(each, ast.ClassDef) and each.name in used]
                place = max([place, *(n + 1 for n in classes)])
            body[place:place] = statements
        tree.body = body
        lines = {n.lineno for n in walk_tree(tree) if hasattr(n, "lineno")}
        comments = [c for c in self._text.comments if c.line in lines or c.line + 1 in lines]
        diagnostics = [*self._text.diagnostics, *self._warnings()]
        tree = _without_unused(tree, self._root)
        return replace(self._text, tree=tree, comments=comments, diagnostics=diagnostics)

    def _top_level(self, node: ast.AST) -> ast.AST:
        while not isinstance(self._parents[node], ast.Module):
            node = self._parents[node]
        return node

    def _warnings(self) -> Iterator[Diagnostic]:
        """Tell which parameters of words have no other values than those for which the data has been computed."""
        told: set[tuple[str, str]] = set()
        for site in self._sites:
            function = next((n for n in self._around(site.nodes[0]) if isinstance(n, ast.FunctionDef)), None)
            if function is None or not is_registered(function) or not site.rows:
                continue
            parameters = {each.arg for each in walk_tree(function.args) if isinstance(each, ast.arg)}
            for key in site.keys:
                if key in parameters and (function.name, key) not in told:
                    told.add((function.name, key))
                    yield fixed_parameter(function.name, key, self._text.span(site.nodes[0]))

    def _replace(self, site: _Site, memo: dict[int, Any], made: list[ast.stmt]) -> None:
        """Replace a site of the copied tree by its data; definitions that the data needs are added to ``made``."""
        first = site.nodes[0]
        shown = (
            [name for name in site.outputs if name not in site.hidden] or [] if not site.is_expression else ["value"]
        )
        is_top = isinstance(self._scope(first), ast.Module) and not any(
            isinstance(each, _COMPREHENSIONS) for each in self._around(first)
        )
        value: ast.expr | None = None
        if shown and site.rows:
            value = self._value(site, made, is_top=is_top)
        if site.is_expression:
            copied = memo[id(first)]
            new = value if value is not None else ast.Constant(0 if site.index else None)
            parent: Any = memo[id(self._parents[first])]
            if site.index:
                new = call_node("range", [new])
                parent.target = ast.Name(site.index, ast.Store())
                placed(parent.target, first)
            placed(new, first)
            _substitute(parent, copied, new)
            return
        block = _block_of(memo[id(self._parents[first])], memo[id(first)])
        place = next(n for n, each in enumerate(block) if each is memo[id(first)])
        new_statements: list[ast.stmt] = []
        if value is not None:
            targets = [ast.Name(name, ast.Store()) for name in shown]
            if is_top and isinstance(value, ast.Tuple) and len(shown) > 1:
                new_statements = [ast.Assign([t], v) for t, v in zip(targets, value.elts)]
            else:
                target: ast.expr = ast.Tuple(list(targets), ast.Store()) if len(targets) > 1 else targets[0]
                new_statements = [ast.Assign([target], value)]
        elif shown:
            # the site was never evaluated, but other statements may still read the variables
            new_statements = [ast.Assign([ast.Name(name, ast.Store())], ast.Constant(None)) for name in shown]
        if not new_statements and len(block) == len(site.nodes):
            new_statements = [ast.Pass()]
        for each in new_statements:
            placed(each, first)
        block[place : place + len(site.nodes)] = new_statements

    def _around(self, node: ast.AST) -> Iterator[ast.AST]:
        while node in self._parents:
            node = self._parents[node]
            yield node

    def _value(self, site: _Site, made: list[ast.stmt], *, is_top: bool) -> ast.expr:
        """Return the expression of what a site gives: data, a constant, or a look-up in a table."""
        rows = list(site.rows.values())
        values = [row[1][0] if len(row[1]) == 1 else ast.Tuple(row[1], ast.Load()) for row in rows]
        parts = [part for name, parts in zip(site.keys, site.parts or []) for part in _key_parts(name, parts)]
        columns = [[row[0][n] for row in rows] for n in range(len(parts))]
        indices = {each.index for each in self._sites if each.index}
        place = next((n for n, part in enumerate(parts) if isinstance(part, ast.Name) and part.id in indices), None)
        table = _Keys(parts, columns)
        if not parts and (is_top or _is_small(values[0])):
            return copy.deepcopy(values[0])
        lists = _by_index(columns, values, place) if place is not None else None
        if lists is not None and place is not None:
            table = _Keys([*parts[:place], *parts[place + 1 :]], lists[0])
            values = lists[1]
        if not table.nodes:
            name = self._new_name(site, is_constant=True)
            made.append(placed(ast.Assign([ast.Name(name, ast.Store())], values[0]), site.nodes[0], is_new=True))
            expression: ast.expr = ast.Name(name, ast.Load())
        else:
            expression = self._look_up(site, table, values, made)
        is_item = lists is not None and place is not None
        return ast.Subscript(expression, parts[place], ast.Load()) if is_item and place is not None else expression

    def _look_up(self, site: _Site, keys: _Keys, values: list[ast.expr], made: list[ast.stmt]) -> ast.expr:
        """Return the call of a function that finds data by its keys in a table."""
        name = self._new_name(site, is_constant=False)
        table = f"{name}_data".upper()
        loaded = [ast.Name(each, ast.Load()) for each in keys.names]
        key: ast.expr = loaded[0] if len(loaded) == 1 else ast.Tuple(list(loaded), ast.Load())
        line = self._text.source.text.count("\n", 0, self._text.span(site.nodes[0]).start) + 1
        varied = ", ".join(f"`{each}`" for each in keys.names)
        where = f"line {line} of the Python was evaluated for other values of {varied} only"
        message = f"{where}: change the value there, and translate that"
        error = ast.Raise(call_node("ValueError", [ast.Constant(message)]), None)
        test = ast.Compare(copy.deepcopy(key), [ast.In()], [ast.Name(table, ast.Load())])
        row = ast.Return(ast.Subscript(ast.Name(table, ast.Load()), copy.deepcopy(key), ast.Load()))
        arguments = ast.arguments([], [ast.arg(each) for each in keys.names], None, [], [], None, [])
        function = ast.FunctionDef(name, arguments, [ast.If(test, [row], []), error], [], None)
        data = ast.Dict(list(keys.rows), values)
        made.append(placed(ast.Assign([ast.Name(table, ast.Store())], data), site.nodes[0], is_new=True))
        made.append(placed(function, site.nodes[0], is_new=True))
        return ast.Call(ast.Name(name, ast.Load()), keys.nodes, [])

    def _new_name(self, site: _Site, *, is_constant: bool) -> str:
        """Return an unused name for a constant or look-up function, derived from the place of its value."""
        stem = ""
        shown = [each for each in site.outputs if each not in site.hidden]
        node = site.nodes[0]
        parent = self._parents[node]
        if shown:
            stem = "_and_".join(shown[:2])
        elif isinstance(parent, ast.Assign) and isinstance(parent.targets[0], ast.Name):
            stem = parent.targets[0].id
        elif isinstance(parent, ast.keyword) and parent.arg:
            stem = parent.arg
        else:
            calls = [n for n in walk_tree(node) if isinstance(n, ast.Call)]
            function = calls[0].func if calls else node
            stem = getattr(function, "attr", getattr(function, "id", "")) or "data"
        stem = stem.strip("_").lower() or "data"
        for number in itertools.count(1):
            name = (
                f"{stem}_data" if number == 1 and is_constant else f"{stem}_for" if number == 1 else f"{stem}_{number}"
            )
            name = name.upper() if is_constant else name
            if name not in self._names:
                self._names |= {name, f"{name}_DATA"}
                return name
        raise AssertionError


# --- evaluation ----------------------------------------------------------------------------------------------------


class _Run(Folding):
    """Evaluates a program for the values of its sites; shapes are all the same to it."""

    def __init__(self, text: PythonText, sites: list[_Site], budget: StepBudget, classes: frozenset[str]) -> None:
        super().__init__(text, items_of(text.tree), set(), UnrollPlan(is_off=True), budget)
        self._sites, self._classes = sites, classes
        self._called: dict[str, dict[str, Any]] = {}  # arguments of the first call of each word
        self._has_texts = any(
            isinstance(n, ast.JoinedStr) or (isinstance(n, ast.Name) and n.id in ("str", "repr", "format"))
            for n in walk_tree(text.tree)
        )  # in which a fraction is no number
        self._open: list[tuple[_Site, Heap | None, list[Any]]] = []
        self._shape = Residual(ast.Constant(None), "shape", self, primitives=lambda: [self._shape])
        self.evaluator.builtins |= self._stand_ins()

    def _stand_ins(self) -> dict[str, Native]:
        functions: dict[str, Callable[..., Any]] = {
            _ENTER: self._enter, _LEAVE: self._leave, _VALUE: self._measure, "print": lambda *_, **__: None,
            "concat_shapes": lambda *_: self._shape, "transform_shape": lambda *_: self._shape,
            "primitive_call": lambda *_, **__: self._shape, "library_call": self._call_word, "loop": self._repeat,
            **{name: self._pose_by(function) for name, function in _MATRICES.items()},
            **{name: lambda *_, **__: self._shape for name, each in scene_helpers().items() if each.is_shape},
            ASSERT_THAT: lambda *_, **__: None,
        }  # fmt: skip
        return {name: Native(name, function) for name, function in functions.items()}

    def evaluate(self, root: str) -> None:
        """Evaluate the module and its root function."""
        try:
            for item in self._items:
                self.evaluator.run(item.node)
            if root not in self._functions:
                raise UnsupportedPython(f"`{root}` is not registered")
            for stream in self.streams:
                stream.seed(0)
            self._is_started = True
            heap = Heap.of((self.evaluator.module, *self.streams))
            result = self.evaluator.call(self._functions[root][0], (), {})
            for _ in self.evaluator.iterate(result) if type(result) is PythonGenerator else ():
                pass
            if heap is None or not heap.is_unchanged():
                raise UnsupportedPython("the program changes its data")
            if not any(site.failure for site in self._sites):
                self._add_defaults(heap)
        except (Exception, NeedsPrimitives) as error:
            self.error = error

    def _add_defaults(self, heap: Heap) -> None:
        """Evaluate the words of the program for their defaults, too, which the scene may never use."""
        for name, named in list(self._called.items()):
            function = self._functions[name][0]
            defaults = defaults_of(function)
            before = [(site, dict(site.rows), list(site.made), site.parts) for site in self._sites]
            try:
                if defaults and name not in self._animations:
                    self.evaluator.call(function, (), {k: v for k, v in named.items() if k not in defaults})
                is_right = heap.is_unchanged() and not any(site.failure for site in self._sites)
            except (Exception, NeedsPrimitives):
                is_right = False
            if not is_right:  # then a call with these is an error
                self._open.clear()
                for site, rows, made, parts in before:
                    site.rows, site.made, site.parts, site.failure = rows, made, parts, ""
            if not heap.is_unchanged():
                return

    def _call_word(self, func_name: str, /, **named: Any) -> Any:
        name = self._find(func_name)
        if name is not None:
            self._called.setdefault(name, named)
        result = self._shape if name is None else self.evaluator.call(self._functions[name][0], (), named)
        return list(result) if type(result) is PythonGenerator else self._shape

    def _pose_by(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that gives a pose, one that is not known for numbers that are not."""

        def make(*arguments: Any, **named: Any) -> Any:
            is_known = not has_residual([*arguments, *named.values()])
            return function(*arguments, **named) if is_known else Residual(ast.Constant(None), "pose", self)

        return make

    def _repeat(self, n: int, fn: Any) -> Residual:
        for i in self.evaluator.iterate(range(n)):
            self.evaluator.call(fn, (i,), {})
        return self._shape

    def extended(self, value: Residual, other: Any) -> Any:
        """Return ``value += other``."""
        return value if value is self._shape else value + other

    def hold(self, value: Residual) -> Residual:
        """Return a residual value, which nobody writes."""
        return value

    def _seed(self, *rest: Any) -> None:
        """Do nothing: no data depends on what is drawn."""

    def _stated(self, node: ast.expr, kind: str, prefix: str) -> Residual:
        return Residual(ast.Name(prefix, ast.Load()), kind, self)

    # --- sites -------------------------------------------------------------------------------------------------

    def _measure(self, number: int, value: Any, *keys: Any) -> Any:
        self._enter(number, value, *keys)
        result = self.evaluator.call(value, (), {})
        site = self._sites[number]
        if site.index or ((_is_iterator(result) or isinstance(result, _VIEWS)) and site.is_taken):
            result = list(itertools.islice(self.evaluator.iterate(result), _MOST_ITEMS))
            if len(result) == _MOST_ITEMS:
                raise UnsupportedPython("an endless iterator is no data")
        self._leave(number, lambda: result)
        return result

    def _enter(self, number: int, *keys: Any) -> None:
        site = self._sites[number]
        site.count += 1
        first, *rest = keys
        frame = first.outer
        given: list[Any] = []
        for key in rest if site.is_expression else keys[1:]:
            try:
                given.append(self.evaluator.call(key, (), {}))
            except NameError:
                given.append(None)  # assigned by nobody yet
        if any(_is_iterator(_variable(frame, name)) for name in site.used):
            site.failure = "state"  # whose items it may take
        heap = Heap.of((frame,)) if site.count < _MOST_COMPARED else None
        if heap is None and site.count < _MOST_COMPARED:
            site.failure = "state"
        self._open.append((site, heap, self._written(site, given)))

    def _written(self, site: _Site, given: list[Any]) -> list[ast.expr]:
        """Return the expressions of the values on which a site depends; objects are their fields."""
        nodes: list[ast.expr] = []
        parts: list[list[str]] = []
        for value in given:
            is_record = type(value) is PythonObject and value.cls.name in self._classes
            fields = value.own_fields() if is_record else None
            is_point = isinstance(value, np.ndarray) and value.ndim == 1 and value.size <= _MOST_COORDINATES
            parts.append([_POINT] if is_point else [] if fields is None else list(fields))
            value = tuple(value.tolist()) if is_point else value
            try:
                if isinstance(value, (np.ndarray, dict, set)) or (fields is not None and len(fields) > _MOST_FIELDS):
                    raise UnsupportedPython("no key of a table")
                nodes += map(self.data, [value] if fields is None else fields.values())
            except UnsupportedPython:
                site.failure = "key"
                return []
        if site.parts not in (None, parts):
            site.failure = "key"
        site.parts = parts
        return nodes

    def _leave(self, number: int, *outputs: Any) -> None:
        """Record the outputs of a site for its keys, or the reason why they are not data."""
        site, heap, keys = self._open.pop()
        if site is not self._sites[number]:
            raise UnsupportedPython("an exception ends a part that is data")
        if site.failure:
            return
        shown = [name for name in site.outputs if name not in site.hidden]
        values: list[ast.expr] = []
        wrong: list[str] = []
        for name, output in zip(["value"] if site.is_expression else shown, outputs):
            try:
                value = output() if site.is_expression else self.evaluator.call(output, (), {})
                value = len(value) if site.index else value
                values.append(self.data(value))
                if not isinstance(value, (int, float, str, tuple, type(None))):
                    site.made.append((value, _text_of(values[-1])))
            except (UnsupportedPython, NameError):
                wrong.append(name)
        if wrong:
            site.failure = " ".join(wrong)
            return
        if heap is not None and not self._is_local(site, heap):
            site.failure = "state"
            return
        key = _text_of(*keys)
        before = site.rows.setdefault(key, (keys, values))
        if _text_of(*before[1]) != _text_of(*values):
            # equal keys with different outputs: the site depends on something else as well
            site.failure = "function"
        elif len(site.rows) > _MOST_ROWS:
            site.failure = "rows"

    @staticmethod
    def _is_local(site: _Site, heap: Heap) -> bool:
        """Return whether a site has changed nothing but its own variables."""
        frame = heap.held[0]
        try:
            heap.check(frame, set(site.outputs) | site.stored, [], lambda: Unroll(ast.Pass()))
        except Unroll:
            return False
        return True

    def data(self, value: Any) -> ast.expr:
        """Return the expression of data. Raises UnsupportedPython for a value that is none."""
        if isinstance(value, NamedTuple) and value.cls.name in self._classes:
            return ast.Call(ast.Name(value.cls.name, ast.Load()), [self.data(each) for each in value], [])
        if type(value) is PythonObject:
            return self._object(value)
        if isinstance(value, (IntMember, TextMember)):
            return self._member(value.cls, value.name)
        if isinstance(value, (ValueObject, Residual, Native)) and not isinstance(value, NamedTuple):
            raise UnsupportedPython("no data")
        if type(value) in (list, tuple, set, frozenset):
            items = [self.data(each) for each in value]
            if type(value) in (set, frozenset):
                return ast.Set(items) if items else call_node("set", [])
            return ast.List(items, ast.Load()) if type(value) is list else ast.Tuple(items, ast.Load())
        if isinstance(value, dict):
            return ast.Dict([self.data(each) for each in value], [self.data(each) for each in value.values()])
        if isinstance(value, np.ndarray) and value.dtype.kind not in "iufb":
            raise UnsupportedPython("no data")
        if isinstance(value, (int, float, str, np.ndarray, np.generic, type(None))):
            return node_of(value)
        if isinstance(value, (Fraction, Decimal)) and not self._has_texts:
            return node_of(float(value))
        raise UnsupportedPython("no data")

    def _member(self, cls: Any, name: Any) -> ast.expr:
        if cls.name not in self._classes or not name:
            raise UnsupportedPython("no data")
        return ast.Attribute(ast.Name(cls.name, ast.Load()), name, ast.Load())

    def _object(self, value: PythonObject) -> ast.expr:
        """Return the call that makes an object of a data class."""
        cls = value.cls
        if cls.members is not None:
            return self._member(cls, value.fields.get("name"))
        names = [each.name for each in cls.data or () if each.in_init]
        has_own = any(cls.find(name) is not MISSING for name in ("__post_init__", "__setattr__"))
        if cls.name not in self._classes or cls.data is None or has_own or names != list(value.own_fields()):
            raise UnsupportedPython("no data")
        given = {each.name: self.data(value.fields[each.name]) for each in cls.data}
        named = [ast.keyword(each.name, given.pop(each.name)) for each in cls.data if each.is_keyword]
        return ast.Call(ast.Name(cls.name, ast.Load()), list(given.values()), named)


def _variable(frame: Frame | None, name: str) -> Any:
    while frame is not None:
        if name in frame.names:
            return frame.names[name]
        frame = frame.outer
    return None


def _is_iterator(value: Any) -> bool:
    return type(value) is PythonGenerator or (isinstance(value, Iterator) and type(value) is not PythonObject)


def _about(linear: np.ndarray[Any, Any], point: Any) -> np.ndarray[Any, Any]:
    """Return the pose of a linear map about a point."""
    pose = np.eye(4)
    pose[:3, :3] = linear
    if point is not None:
        origin = np.asarray(point, float)[:3]
        pose[:3, 3] = origin - linear @ origin
    return pose


def _unit(direction: Any) -> np.ndarray[Any, Any]:
    axis = np.asarray(direction, float)[:3]
    unit: np.ndarray[Any, Any] = axis / np.linalg.norm(axis)
    return unit


def _translation(offset: Any) -> np.ndarray[Any, Any]:
    pose = np.eye(4)
    pose[:3, 3] = np.asarray(offset, float)[:3]
    return pose


def _rotation(angle: float, direction: Any, point: Any = None) -> np.ndarray[Any, Any]:
    axis = _unit(direction)
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    turned = np.cos(angle) * np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * np.outer(axis, axis)
    return _about(turned, point)


def _scaling(scale: Any, origin: Any = None) -> np.ndarray[Any, Any]:
    return _about(np.diag(np.broadcast_to(np.asarray(scale, float), 3)), origin)


def _reflection(point: Any, normal: Any) -> np.ndarray[Any, Any]:
    axis = _unit(normal)
    return _about(np.eye(3) - 2 * np.outer(axis, axis), point)


_MATRICES: dict[str, Callable[..., Any]] = {
    "translation_matrix": _translation, "rotation_matrix": _rotation, "scale_matrix": _scaling,
    "reflection_matrix": _reflection, "identity_matrix": lambda: np.eye(4),
}  # fmt: skip


class _Instrumented:
    """Writes calls around the sites of a program, which tell what they depend on and what they give."""

    def __init__(self, sites: list[_Site]) -> None:
        self._sites = sites

    def result(self, tree: ast.Module) -> ast.Module:
        """Return the program with the calls."""
        memo: dict[int, Any] = {}
        copied = copy.deepcopy(tree, memo)
        parents = parents_of(copied)
        for number, site in enumerate(self._sites):
            first = memo[id(site.nodes[0])]
            keys = [_thunk(ast.Name(name, ast.Load())) for name in site.keys]
            if site.is_expression:
                call = _call(_VALUE, number, [_thunk(copy.copy(first)), *keys])
                parent: Any = parents[first]
                if site.index:
                    call = ast.Call(ast.Name("enumerate", ast.Load()), [call], [])
                    parent.target = ast.Tuple([ast.Name(site.index, ast.Store()), parent.target], ast.Store())
                    placed(parent.target, first)
                placed(call, first)
                _substitute(parent, first, call)
                continue
            block = _block_of(parents[first], first)
            place = next(n for n, each in enumerate(block) if each is first)
            shown = [name for name in site.outputs if name not in site.hidden]
            outputs = [_thunk(ast.Name(name, ast.Load())) for name in shown]
            before = ast.Expr(_call(_ENTER, number, [_thunk(ast.Constant(None)), *keys]))
            after = ast.Expr(_call(_LEAVE, number, outputs))
            placed(before, first)
            placed(after, first)
            block[place : place + len(site.nodes)] = [before, *block[place : place + len(site.nodes)], after]
        return copied


def _thunk(node: ast.expr) -> ast.Lambda:
    return ast.Lambda(ast.arguments([], [], None, [], [], None, []), node)


def _call(name: str, number: int, arguments: Sequence[ast.expr]) -> ast.Call:
    return ast.Call(ast.Name(name, ast.Load()), [ast.Constant(number), *arguments], [])


# --- syntax --------------------------------------------------------------------------------------------------------


def _substitute(parent: ast.AST, old: ast.AST, new: ast.AST) -> None:
    for name, value in ast.iter_fields(parent):
        if value is old:
            setattr(parent, name, new)
        elif isinstance(value, list):
            value[:] = [new if each is old else each for each in value]


def _block_of(parent: ast.AST, statement: ast.AST) -> list[Any]:
    """Return the list of statements in which one is."""
    for _, value in ast.iter_fields(parent):
        if isinstance(value, list) and any(each is statement for each in value):
            return value
    raise _Failure


def _text_of(*nodes: ast.expr) -> str:
    return ", ".join(map(ast.dump, nodes))


def _with_meaning(node: ast.AST) -> Iterator[ast.AST]:
    """Iterate over the nodes that are no annotations."""
    yield node
    for name, value in ast.iter_fields(node):
        if name not in ("annotation", "returns"):
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from _with_meaning(child)


def _modelling_called(tree: ast.Module) -> set[str]:
    """Return the functions for solids and declarations that a program calls and does not define itself."""
    nodes = list(walk_tree(tree))
    called = {each.func.id for each in nodes if isinstance(each, ast.Call) and isinstance(each.func, ast.Name)}
    own = {each.name for each in nodes if isinstance(each, (ast.FunctionDef, ast.ClassDef))}
    own |= {each.id for each in nodes if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)}
    return called & {*scene_helpers(), *relation_helpers(), ASSERT_THAT} - own


def _names_in(node: ast.AST | None) -> set[str]:
    """Return the names and attributes in a part, without annotations."""
    nodes = list(_with_meaning(node)) if node is not None else []
    return {n.id for n in nodes if isinstance(n, ast.Name)} | {n.attr for n in nodes if isinstance(n, ast.Attribute)}


def _targets(node: ast.AST) -> set[str]:
    """Return the variables that a node assigns, or whose values it may change."""
    nodes: list[ast.AST] = []
    if isinstance(node, ast.Assign):
        nodes = [each for target in node.targets for each in walk_tree(target)]
    elif isinstance(node, (ast.AugAssign, ast.AnnAssign, ast.For, ast.comprehension, ast.NamedExpr)):
        nodes = walk_tree(node.target)
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
        variable = variable_of(node.func)
        nodes = [variable] if variable is not None else []
    elif isinstance(node, ast.FunctionDef):
        return {node.name}
    return {each.id for each in nodes if isinstance(each, ast.Name)}


def _value_in(node: ast.AST) -> ast.AST | None:
    if isinstance(node, (ast.For, ast.comprehension)):
        return node.iter
    if isinstance(node, ast.Call):
        return ast.Tuple([*node.args, *(k.value for k in node.keywords)], ast.Load())
    if isinstance(node, (ast.Assign, ast.AugAssign, ast.AnnAssign, ast.NamedExpr)):
        return node.value
    return node if isinstance(node, ast.FunctionDef) else None


def _is_taken(node: ast.expr, parent: ast.AST) -> bool:
    """Return whether only the items of an expression are used, all of them in a row."""
    if isinstance(parent, (ast.For, ast.comprehension)):
        return node is parent.iter
    is_call = isinstance(parent, ast.Call) and isinstance(parent.func, ast.Name) and parent.func.id in _TAKERS
    return isinstance(parent, ast.Starred) or is_call


def _comprehended(node: Any) -> set[str]:
    return {n.id for each in node.generators for n in walk_tree(each.target) if isinstance(n, ast.Name)}


def _methods_of(node: ast.ClassDef) -> list[ast.FunctionDef]:
    return [each for each in node.body if isinstance(each, ast.FunctionDef)]


def _leaves(node: ast.stmt) -> bool:
    """Return whether a statement may leave what is around it."""
    pending: list[tuple[ast.AST, bool]] = [(node, False)]
    while pending:
        each, is_in_loop = pending.pop()
        if isinstance(each, ast.Return) or (isinstance(each, (ast.Break, ast.Continue)) and not is_in_loop):
            return True
        if not isinstance(each, _SCOPES):
            inner = is_in_loop or isinstance(each, (ast.For, ast.While))
            pending += [(child, inner) for child in child_nodes(each)]
    return False


def _is_small(node: ast.expr) -> bool:
    return sum(1 for _ in itertools.islice(ast.walk(node), 12)) < 12


class _Keys:
    """Keys of a table: the expressions of the arguments, their names, and the keys of the rows."""

    def __init__(self, parts: list[ast.expr], columns: list[list[ast.expr]]) -> None:
        self.nodes = [_rounded_key(part, column) for part, column in zip(parts, columns)]
        self.names = [_name_of_key(part) for part in parts]
        if len(set(self.names)) < len(self.names):
            self.names = [f"argument_{n}" for n in range(len(parts))]
        rounded = [_rounded(column) if any(map(_is_computed, column)) else column for column in columns]
        self.rows = [row[0] if len(row) == 1 else ast.Tuple(list(row), ast.Load()) for row in zip(*rounded)]


def _by_index(
    columns: list[list[ast.expr]], values: list[ast.expr], place: int
) -> tuple[list[list[ast.expr]], list[ast.expr]] | None:
    """Return rows whose values are lists by an index, the column at a place, if it counts from 0 in each of them."""
    others = [*columns[:place], *columns[place + 1 :]]
    items_by_key: dict[str, tuple[list[ast.expr], list[ast.expr]]] = {}
    for n, value in enumerate(values):
        key = [column[n] for column in others]
        _, items = items_by_key.setdefault(_text_of(*key), (key, []))
        index = columns[place][n]
        if not isinstance(index, ast.Constant) or index.value != len(items):
            return None
        items.append(value)
    keys = [key for key, _ in items_by_key.values()]
    rows: list[ast.expr] = [ast.List(items, ast.Load()) for _, items in items_by_key.values()]
    return [[key[n] for key in keys] for n in range(len(others))], rows


def _name_of_key(part: Any) -> str:
    named: Any = part.args[0] if isinstance(part, ast.Call) else part
    return str(named.attr if isinstance(named, ast.Attribute) else named.id)


def _key_parts(name: str, attributes: list[str]) -> list[ast.expr]:
    loaded = ast.Name(name, ast.Load())
    if attributes == [_POINT]:
        return [call_node("tuple", [loaded])]
    return [ast.Attribute(copy.copy(loaded), each, ast.Load()) for each in attributes] or [loaded]


_DIGITS = 9  # of computed numbers in keys, whose last digits depend on who computes them


def _is_computed(node: ast.expr) -> bool:
    return any(
        isinstance(n, ast.Constant) and type(n.value) is float and len(repr(n.value)) > _DIGITS for n in ast.walk(node)
    )


def _rounded_key(part: ast.expr, column: list[ast.expr]) -> ast.expr:
    """Return the expression of a key, with its numbers rounded if some of its column are computed."""
    if not any(map(_is_computed, column)):
        return part
    kinds = {len(each.elts) if isinstance(each, ast.Tuple) else 0 for each in column}
    if len(kinds) > 1 or any(isinstance(n, (ast.List, ast.Dict)) for each in column for n in ast.walk(each)):
        return part
    count = kinds.pop()
    if not count:
        return call_node("round", [part, ast.Constant(_DIGITS)])
    numbers = all(isinstance(n, (ast.Constant, ast.UnaryOp)) for each in column for n in each.elts)  # type: ignore[attr-defined]
    source = part.args[0] if isinstance(part, ast.Call) else part
    items = [ast.Subscript(copy.deepcopy(source), ast.Constant(n), ast.Load()) for n in range(count)]
    return (
        ast.Tuple([call_node("round", [each, ast.Constant(_DIGITS)]) for each in items], ast.Load())
        if numbers
        else part
    )


def _rounded(column: list[ast.expr]) -> list[ast.expr]:
    return [_Rounded().visit(copy.deepcopy(each)) for each in column]


class _Rounded(ast.NodeTransformer):
    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        return ast.Constant(round(node.value, _DIGITS)) if type(node.value) is float else node


def _without_unused(tree: ast.Module, root: str) -> ast.Module:
    """Leave out functions, classes and constants that nothing reaches any longer."""
    while True:
        used = {
            n.id
            for each in tree.body
            for n in walk_tree(each)
            if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)
        }
        texts = {
            n.value
            for each in tree.body
            for n in walk_tree(each)
            if isinstance(n, ast.Constant) and type(n.value) is str
        }
        kept = [each for each in tree.body if not _is_unused(each, used | texts | {root})]
        if len(kept) == len(tree.body):
            return tree
        tree.body = kept


def _is_unused(node: ast.stmt, used: set[str]) -> bool:
    if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.decorator_list:
        return node.name not in used
    if isinstance(node, ast.Assign) and len(node.targets) == 1 and isinstance(node.targets[0], ast.Name):
        calls = [n for n in walk_tree(node.value) if isinstance(n, ast.Call)]
        return node.targets[0].id not in used and not calls
    return False
