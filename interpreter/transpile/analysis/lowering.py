"""Rewriting of Python constructs that the translation does not support as simpler ones with the same meaning.

Functions of Python's library become functions of the program (``LIBRARY``), operator methods become methods that
operators call, alternative constructors static methods, fixed arguments (``partial``) arguments of the calls. What
evaluates Python sees the program as it was written.
"""

from __future__ import annotations

import ast
import copy
import json
import re
import string
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from functools import partial, reduce
from operator import or_
from typing import Any

from scenelang.interpreter.transpile.analysis.decorators import without_decorators
from scenelang.interpreter.transpile.analysis.enumerations import is_its_value, without_enumerations
from scenelang.interpreter.transpile.analysis.grids import PATHS as GRID_PATHS
from scenelang.interpreter.transpile.analysis.grids import Grids
from scenelang.interpreter.transpile.analysis.inference import ARRAY, DICT, INT, LIST, NUMBERS, STR, TUPLE
from scenelang.interpreter.transpile.analysis.inheritance import Dispatch, without_bases, without_hooks
from scenelang.interpreter.transpile.analysis.inlining import without_managers
from scenelang.interpreter.transpile.analysis.library import COUNTER_METHODS, EAGER, GETTERS, LIBRARY, OWN_METHODS
from scenelang.interpreter.transpile.analysis.library_classes import is_pure, with_library_classes
from scenelang.interpreter.transpile.analysis.library_rotations import ROTATIONS
from scenelang.interpreter.transpile.analysis.matches import Matches
from scenelang.interpreter.transpile.analysis.operator_cases import method_for, split_operators
from scenelang.interpreter.transpile.analysis.plain_classes import name_rest, with_plain_classes
from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.rewriting import (
    OPERATOR_METHODS,
    Substitution,
    free_name,
    is_registered,
    is_registering,
    is_repeatable,
    is_sized,
    is_test_of_class,
    name_of,
    names_in,
    placed,
)

_SILENT = ("logging", "warnings")  # modules whose functions only tell people something
_MODULES = ("random", "numpy.random", "math")  # which a program passes on as a parameter
_PROGRESS = ("tqdm.tqdm", "tqdm.auto.tqdm", "tqdm.std.tqdm", "rich.progress.track")  # which show how far a loop is
_SILENT_CALLS = ("sys.setrecursionlimit", "sys.stdout.flush", "sys.stderr.flush", "sys.stderr.write")

_TEXTS = ("__repr__", "__str__")  # texts of objects, which the translation does not write
_ORDER = {"lt": ast.Lt, "le": ast.LtE, "gt": ast.Gt, "ge": ast.GtE}
_METHODS = (
    *OPERATOR_METHODS.values(), *(f"i{name}" for name in OPERATOR_METHODS.values()),
    "radd", "rsub", "rmul", "neg", "abs", "getitem", "setitem", "len", "contains", "iter",
    "call", "bool", *_ORDER,
)  # fmt: skip
# Methods that other code asks for without a name: a loop, ``zip`` and ``len`` of an object, ``in``, ``bool``.
_IMPLICIT = ("len", "contains", "iter", "getitem", "bool", "call")
_CONSTANTS = {f"string.{name}": getattr(string, name) for name in ("ascii_uppercase", "ascii_lowercase", "digits")}
_MARKERS = ("ABC", "abc.ABC", "Generic", "typing.Generic", "Protocol", "typing.Protocol")  # bases without methods
_COUNT = "itertools.count"
_MOST_JSON = 20_000  # characters of a text that becomes literals
_WRITTEN = (
    _COUNT,
    "json.loads",
    *GETTERS,
    "itertools.islice",
    "numpy.ndindex",
    "numpy.c_",
    "numpy.ptp",
    "numpy.newaxis",
    "numpy.ndenumerate",
    "numpy.argwhere",
    "numpy.nonzero",
    "itertools.repeat",
)  # by `_Library` itself
_REWRITTEN = frozenset([*LIBRARY, *_CONSTANTS, *_WRITTEN, *GRID_PATHS])
_FIRST = ast.Pass(lineno=1, col_offset=0, end_lineno=1, end_col_offset=0)  # a place for what has none
_PURE = ("iter", "range", "len", "reversed", "abs", "round", "int", "float")
_CONSUMERS = ("list", "tuple", "set", "sum", "sorted", "min", "max", "any", "all", "enumerate", "zip")
_OF_VALUES = ("abs", "float", "int", "len", "range", "round", "str")  # functions of numbers and texts
_UNORDERED = ("set", "sum", "sorted", "min", "max", "any", "all")  # to which the order of a set does not matter
MOST_PASSES = 6  # each finds the types of what the one before has made


def lowered(tree: ast.Module) -> ast.Module:
    """Return a module without constructs that the translation does not know; the same one if it has none."""
    paths = _imported(tree)
    if _is_plain(tree, paths):
        return tree
    whole, tree = tree, copy.deepcopy(tree)
    before = ast.dump(tree)
    path_of = lambda node: _path(node, paths)
    tree.body = [each for each in tree.body if not _is_unused(each, tree)]
    _without_names_of_types(tree)
    tree = Grids(path_of).visit(tree)
    classes_of_library = with_library_classes(tree, path_of)
    tree.body[_first_statement(tree) : 0] = [placed(each, _FIRST, is_new=True) for each in classes_of_library]
    tree = _Targets().visit(with_plain_classes(without_decorators(tree)))
    tree = without_managers(Matches(tree).visit(tree))
    tree = without_enumerations(tree)
    tree = _Silent(paths).visit(tree)
    _with_fixed_arguments(tree, paths)
    _with_fixed_modules(tree, paths)
    tested = {ast.unparse(each.args[1]) for each in walk_tree(tree) if is_test_of_class(each)}
    classes = [each for each in tree.body if isinstance(each, ast.ClassDef)]
    for cls in classes:
        is_tested = cls.name in tested and any("Protocol" in ast.unparse(base) for base in cls.bases)
        cls.bases = [base for base in cls.bases if is_tested or not _is_marker(base)]
    bases = {ast.unparse(base) for cls in classes for base in cls.bases}
    without_hooks(tree)
    without_bases(tree)
    name_rest(tree)
    is_sorted = any(map(_orders, walk_tree(tree)))
    for cls in classes:
        if cls.name not in bases:
            _name_own_class(cls)
        _Assigned().visit(cls)
        _lower_class(cls, is_sorted=is_sorted)
        split_operators(cls, {each.name for each in classes} - bases)
    names = _Library(paths, tree)
    tree = names.visit(tree)
    made = [each for text in names.made.values() for each in ast.parse(text).body]
    for node in walk_tree(*made):
        _at(node, 1)
    tree.body[_first_statement(tree) : 0] = made
    has_order = any(_ordered_fields(cls) for cls in classes)  # which `OperatorMethods` writes as keys
    return tree if made or has_order or ast.dump(tree) != before else whole


def _without_names_of_types(tree: ast.Module) -> None:
    """Leave the name of a type out of the messages of exceptions, in place, if no handler reads them.

    Where such an exception ends the program, its message comes from the evaluator, which knows the name.
    """
    nodes = walk_tree(tree)
    if any(isinstance(each, ast.ExceptHandler) and each.name for each in nodes):
        return
    for node in walk_tree(*(each.exc for each in nodes if isinstance(each, ast.Raise) and each.exc is not None)):
        if isinstance(node, ast.FormattedValue) and _is_name_of_type(node.value):
            node.value = placed(ast.Constant("object"), node.value)
        elif isinstance(node, ast.Call):
            node.args = [placed(ast.Constant("object"), e) if _is_name_of_type(e) else e for e in node.args]


def _is_name_of_type(node: ast.expr) -> bool:
    if not isinstance(node, ast.Attribute) or node.attr != "__name__":
        return False
    kind = node.value
    return (isinstance(kind, ast.Attribute) and kind.attr == "__class__") or (
        isinstance(kind, ast.Call) and isinstance(kind.func, ast.Name) and kind.func.id == "type"
    )


def _is_unused(node: ast.stmt, tree: ast.Module) -> bool:
    """Return whether a statement defines a class that nothing names, and that does nothing else."""
    if not isinstance(node, ast.ClassDef) or node.decorator_list or node.keywords or _is_derived(node, tree):
        return False
    if not all(isinstance(each, (ast.Pass, ast.FunctionDef, ast.Expr)) for each in node.body):
        return False
    named = [n for n in walk_tree(tree) if isinstance(n, ast.Name) and n.id == node.name]
    inside = [n for n in walk_tree(node) if isinstance(n, ast.Name) and n.id == node.name]
    texts = (n.value for n in walk_tree(tree) if isinstance(n, ast.Constant) and isinstance(n.value, str))
    return len(named) == len(inside) and not any(node.name in each for each in texts)


def _is_derived(node: ast.ClassDef, tree: ast.Module) -> bool:
    """Return whether a class is derived from another of the program, which may do something about it."""
    names = {each.name for each in tree.body if isinstance(each, ast.ClassDef)}
    return any(isinstance(n, ast.Name) and n.id in names for base in node.bases for n in walk_tree(base))


def _is_plain(tree: ast.Module, paths: Mapping[str, str]) -> bool:
    """Return whether a module has nothing that is written otherwise, as most answers."""
    for node in walk_tree(tree):
        if isinstance(node, (ast.ClassDef, ast.Match, ast.With)):
            return False
        if isinstance(node, ast.FunctionDef) and (node.args.kwarg or not all(map(is_registering, node.decorator_list))):
            return False
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "str":
            return False
        if isinstance(node, ast.Attribute) and node.attr == "__getitem__":
            return False
        if isinstance(node, ast.Name) and node.id in ("frozenset", "iter", "next", "complex", "SimpleNamespace"):
            return False
        if isinstance(node, ast.Constant) and type(node.value) is complex:
            return False
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant) and node.slice.value is None:
            return False
        if isinstance(node, (ast.For, ast.comprehension)) and _Targets.is_meant(node.target):
            return False
        if (_path(node, paths) or "") in _REWRITTEN or _method(node) in OWN_METHODS:
            return False
    is_meant = any(path in ("functools.partial", ROTATIONS, "sys", *_SILENT) for path in paths.values())
    defaults = [each for n in walk_tree(tree) if isinstance(n, ast.arguments) for each in n.defaults]
    return not is_meant and not any(paths.get(name_of(each)) in _MODULES for each in defaults)


def _at(node: ast.AST, line: int) -> None:
    for name in node._attributes:
        setattr(node, name, line if "lineno" in name else 0)


def _first_statement(tree: ast.Module) -> int:
    """Return the place behind the docstring and the imports."""
    last = [n for n, each in enumerate(tree.body) if isinstance(each, (ast.Import, ast.ImportFrom))]
    return last[-1] + 1 if last else 0


def _imported(tree: ast.Module) -> dict[str, str]:
    """Return the dotted paths of the names that a module imports, and assigns nowhere."""
    paths: dict[str, str] = {}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            paths |= {each.asname or each.name: f"{node.module}.{each.name}" for each in node.names}
        elif isinstance(node, ast.Import):
            paths |= {each.asname or each.name: each.name for each in node.names}
    stored = {n.id for n in walk_tree(tree) if isinstance(n, ast.Name) and not isinstance(n.ctx, ast.Load)}
    stored |= {n.arg for n in walk_tree(tree) if isinstance(n, ast.arg)}
    stored |= {n.name for n in walk_tree(tree) if isinstance(n, (ast.FunctionDef, ast.ClassDef))}
    return {name: path for name, path in paths.items() if name not in stored}


def _path(node: ast.AST, paths: Mapping[str, str]) -> str | None:
    if isinstance(node, ast.Name):
        return paths.get(node.id)
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in paths:
        return f"{paths[node.value.id]}.{node.attr}"
    return None


def _method(node: ast.AST) -> tuple[str, int] | None:
    """Return the name of the method that a call calls, and the number of its arguments."""
    is_call = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and not node.keywords
    return (node.func.attr, len(node.args)) if is_call else None  # type: ignore[attr-defined]


class _Library(ast.NodeTransformer):
    """Replaces functions of the library by those of the program; ``made`` are the texts of these by name."""

    def __init__(self, paths: Mapping[str, str], tree: ast.Module) -> None:
        nodes = walk_tree(tree)
        self._paths = paths
        self._names = {each.id for each in nodes if isinstance(each, ast.Name)}
        self._functions = {each.name for each in nodes if isinstance(each, ast.FunctionDef)}
        self._counters = self._counting(tree)
        self._other = {"collections.Counter"} if self._counters is None else set()
        methods = {
            m.name for n in nodes if isinstance(n, ast.ClassDef) for m in n.body if isinstance(m, ast.FunctionDef)
        }
        self._other |= {f"operator.{name}" for name in ("add", "mul") if name not in methods}  # which numbers have
        self.made: dict[str, str] = {}

    def _counting(self, tree: ast.Module) -> set[str] | None:
        """Return the names of what holds counters; None if a method may be one of a counter, or of something else."""
        counters: set[str] = set()
        others: set[str] = set()
        for node in walk_tree(tree):
            targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
            value = getattr(node, "value", None)
            if isinstance(node, (ast.Assign, ast.AnnAssign)) and value is not None:
                calls = [n for n in walk_tree(value) if _path(n, self._paths) == "collections.Counter"]
                made = isinstance(value, ast.Call) and any(value.func is n for n in calls)
                is_counter = made or (isinstance(node, ast.AnnAssign) and bool(calls))
                (counters if is_counter else others).update(filter(None, map(name_of, targets)))
            elif isinstance(node, ast.arg):
                kinds = [n for n in walk_tree(node) if _path(n, self._paths) == "collections.Counter"]
                (counters if kinds else others).add(node.arg)
        owners = {
            name_of(n.value) for n in walk_tree(tree) if isinstance(n, ast.Attribute) and n.attr in COUNTER_METHODS
        }  # fmt: skip
        return None if owners - others - counters or owners & counters & others else counters

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return self._replaced(node)

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        if _path(node, self._paths) == "numpy.newaxis":
            return ast.copy_location(ast.Constant(None), node)
        if node.attr == "__getitem__" and is_repeatable(node.value):  # `max(..., key=table.__getitem__)`
            function = ast.parse(f"lambda key: {ast.unparse(node.value)}[key]", mode="eval").body
            return placed(function, node, is_new=True)
        return self._replaced(node) if _path(node, self._paths) in (*LIBRARY, *_CONSTANTS) else self._inner(node)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Write calls whose arguments decide what they are: the beginning of a fresh iterator, indices of an array."""
        path = _path(node.func, self._paths)
        self.generic_visit(node)
        if path in _PROGRESS and node.args:
            return node.args[0]
        if isinstance(node.func, ast.Attribute) and node.func.attr in COUNTER_METHODS and not node.keywords:
            if name_of(node.func.value) in (self._counters or ()):
                name = f"counter_{node.func.attr}"
                self.made[name] = COUNTER_METHODS[node.func.attr]
                return placed(ast.Call(ast.Name(name, ast.Load()), [node.func.value, *node.args], []), node)
        node.args = [_method_of_text(each) for each in node.args]
        if path in GETTERS:
            return _getter(path, node) or node
        if path is not None and path.rpartition(".")[2] in EAGER:
            node.args = [_listed(each) for each in node.args]
        source = OWN_METHODS.get(_method(node) or ("", 0))
        if source is not None and path is None and isinstance(node.func, ast.Attribute):
            if node.func.attr not in self._functions:
                name = ast.parse(source).body[0].name  # type: ignore[attr-defined]
                self.made[name] = source
                return placed(ast.Call(ast.Name(name, ast.Load()), [node.func.value, *node.args], []), node)
        if path == "numpy.ptp" and node.args:
            ends = [copy.deepcopy(node) for _ in range(2)]
            for end, name in zip(ends, ("max", "min")):
                assert isinstance(end.func, ast.Attribute)
                end.func.attr = name
            return placed(ast.BinOp(ends[0], ast.Sub(), ends[1]), node) if is_repeatable(node.args[0]) else node
        if path == "json.loads" and len(node.args) == 1 and not node.keywords:
            return _parsed(node.args[0]) or node
        last = node.args[-1] if node.args else None
        if path == "itertools.takewhile" and isinstance(last, ast.Call) and _path(last.func, self._paths) == _COUNT:
            node.func, node.args = self._function("itertools.counted_while", node), [node.args[0], *last.args]
            node.keywords = last.keywords
            return node
        if path == "itertools.takewhile" and isinstance(last, ast.GeneratorExp) and self._is_mapped_count(last):
            clause = last.generators[0]
            assert isinstance(clause.iter, ast.Call)
            assert isinstance(clause.target, ast.Name)
            given = ast.arguments([], [ast.arg(clause.target.id)], None, [], [], None, [])
            value = placed(ast.Lambda(given, last.elt), last)
            node.func, node.keywords = self._function("itertools.mapped_while", node), clause.iter.keywords
            node.args = [node.args[0], value, *clause.iter.args]
            return node
        if isinstance(node.func, ast.Name) and node.func.id == "zip":
            return self._counted(node)
        if path == "itertools.islice" and len(node.args) in (2, 3) and isinstance(node.args[0], ast.Call):
            endless = node.args[0]
            if _path(endless.func, self._paths) == "itertools.cycle" and len(endless.args) == 1:
                node.func = self._function("itertools.first_of_cycle", node)
                node.args = [endless.args[0], *node.args[1:]]
                return node
            listed = ast.Call(ast.Name("list", ast.Load()), [node.args[0]], [])
            first, last = [None, *node.args[1:]][-2:]
            return placed(ast.Subscript(listed, ast.Slice(first, last, None), ast.Load()), node)
        if path == "numpy.ndindex" and not any(isinstance(each, (ast.Starred, ast.Attribute)) for each in node.args):
            sizes: list[ast.expr] = [ast.Call(ast.Name("range", ast.Load()), [each], []) for each in node.args]
            product = ast.Attribute(ast.Name("itertools", ast.Load()), "product", ast.Load())
            return placed(ast.Call(product, sizes, []), node)
        return node

    def visit_For(self, node: ast.For) -> Any:
        """Write a loop over all numbers as one that counts, and one over the indices of an array as nested ones."""
        written = self._named_index(node.target, node.iter, node.body)
        if written is not None:
            node.target, node.body = written
        self.generic_visit(node)
        clauses = self._indices(node.target, node.iter)
        if clauses is not None and not node.orelse and not any(isinstance(n, ast.Break) for n in walk_tree(*node.body)):
            body, before = node.body, self._held(node.iter, clauses, node)
            for each in clauses[2][::-1]:
                body = [ast.If(each.ifs[0], body, [])] if each.ifs else body
                body = [ast.For(each.target, each.iter, body, [])]
            for each in body:
                placed(each, node)
            return [*before, *body]
        call = node.iter
        if not isinstance(call, ast.Call) or _path(call.func, self._paths) != _COUNT or call.keywords or node.orelse:
            return node
        if not isinstance(node.target, ast.Name) or not all(isinstance(each, ast.Constant) for each in call.args):
            return node
        start, step = [*call.args, *([ast.Constant(0)] if not call.args else []), ast.Constant(1)][:2]
        first = ast.BinOp(start, ast.Sub(), step)
        target = node.target
        following = ast.BinOp(ast.Name(target.id, ast.Load()), ast.Add(), copy.deepcopy(step))
        advance = ast.Assign([ast.Name(target.id, ast.Store())], following)
        loop = ast.While(ast.Constant(True), [advance, *node.body], [])
        made = [ast.Assign([target], first), loop]
        for each in made:
            placed(each, node)
        return made

    def _named_index(self, target: ast.expr, items: ast.expr, body: list[Any]) -> tuple[ast.expr, list[Any]] | None:
        """Return a target with a name for each number of an index of ``np.ndindex``, and the body with those names."""
        is_index = isinstance(items, ast.Call) and _path(items.func, self._paths) == "numpy.ndindex"
        if not is_index or not isinstance(items, ast.Call) or not isinstance(target, ast.Name):
            return None
        uses = [n for n in walk_tree(*body) if isinstance(n, ast.Name) and n.id == target.id]
        sizes = (ast.Starred, ast.Attribute, ast.Tuple)
        if any(isinstance(each, sizes) for each in items.args) or not all(isinstance(n.ctx, ast.Load) for n in uses):
            return None
        names = [self._new(f"{target.id}_{n}") for n in range(len(items.args))]
        index = ast.Tuple([ast.Name(name, ast.Load()) for name in names], ast.Load())
        written = [placed(Substitution({target.id: index}).visit(each), items) for each in body]
        return ast.Tuple([ast.Name(name, ast.Store()) for name in names], ast.Store()), written

    def _indices(self, target: ast.expr, items: ast.expr) -> tuple[Any, ...] | None:
        """Return the array over whose indices a loop goes, its name, and the nested clauses of that loop."""
        if not isinstance(items, ast.Call) or not items.args or items.keywords:
            return None
        path, array = _path(items.func, self._paths), items.args[0]
        elements = target.elts if isinstance(target, ast.Tuple) else []
        names, value = elements, None
        if path == "numpy.ndenumerate" and len(elements) == 2 and isinstance(elements[0], ast.Tuple):
            names, value = elements[0].elts, elements[1]
        elif isinstance(items.func, ast.Name) and items.func.id == "zip" and isinstance(array, ast.Starred):
            inner = array.value
            if not isinstance(inner, ast.Call) or _path(inner.func, self._paths) != "numpy.nonzero":
                return None
            array = inner.args[0]
        elif path != "numpy.argwhere":
            return None
        if not names or not all(isinstance(each, ast.Name) for each in names):
            return None
        name = array.id if isinstance(array, ast.Name) else self._new("cells")
        shape = ast.Attribute(ast.Name(name, ast.Load()), "shape", ast.Load())
        clauses = []
        for n, each in enumerate(names):
            side = ast.Subscript(copy.deepcopy(shape), ast.Constant(n), ast.Load())
            clauses.append(ast.comprehension(each, ast.Call(ast.Name("range", ast.Load()), [side], []), [], 0))
        index = ast.Tuple([ast.Name(each.id, ast.Load()) for each in names if isinstance(each, ast.Name)], ast.Load())
        item = ast.Subscript(ast.Name(name, ast.Load()), index, ast.Load())
        if value is None:
            clauses[-1].ifs.append(item)
        else:
            clauses.append(ast.comprehension(value, ast.List([item], ast.Load()), [], 0))
        return array, name, clauses

    def _new(self, name: str) -> str:
        return free_name(name, self._names)

    @staticmethod
    def _held(items: ast.expr, indexed: tuple[Any, ...], origin: ast.AST) -> list[ast.stmt]:
        array, name, _ = indexed
        if isinstance(array, ast.Name):
            return []
        made = ast.Assign([ast.Name(name, ast.Store())], array)
        placed(made, origin)
        return [made]

    def _in_comprehension(self, node: Any) -> Any:
        self.generic_visit(node)
        clauses: list[ast.comprehension] = []
        for each in node.generators:
            indexed = self._indices(each.target, each.iter)
            if indexed is None or not isinstance(indexed[0], ast.Name):
                clauses.append(each)
                continue
            indexed[2][-1].ifs += each.ifs
            clauses += indexed[2]
        node.generators = clauses
        for clause in clauses:
            placed(clause, node)
        return node

    visit_ListComp = visit_SetComp = visit_DictComp = visit_GeneratorExp = _in_comprehension

    def _counted(self, node: ast.Call) -> ast.expr:
        """Write ``zip(xs, count())`` with as many numbers as there are items."""
        paths = [_path(each.func, self._paths) if isinstance(each, ast.Call) else None for each in node.args]
        repeats = [p == "itertools.repeat" and len(e.args) == 1 for p, e in zip(paths, node.args)]  # type: ignore[attr-defined]
        counts = [p == _COUNT or repeat for p, repeat in zip(paths, repeats)]
        others = [each for each, is_count in zip(node.args, counts) if not is_count and is_sized(each)]
        if not any(counts) or not others:
            return node
        other = others[0]
        for n, each in enumerate(node.args):
            if counts[n] and isinstance(each, ast.Call) and not each.keywords:
                if repeats[n]:
                    size = ast.Call(ast.Name("len", ast.Load()), [copy.deepcopy(other)], [])
                    items = ast.List([each.args[0]], ast.Load())
                    node.args[n] = placed(ast.BinOp(items, ast.Mult(), size), node)
                    continue
                start, step = [*each.args, *([ast.Constant(0)] if not each.args else []), ast.Constant(1)][:2]
                size = ast.Call(ast.Name("len", ast.Load()), [copy.deepcopy(other)], [])
                index = ast.Name("index", ast.Load())
                number = ast.BinOp(start, ast.Add(), ast.BinOp(index, ast.Mult(), step))
                indices = ast.Call(ast.Name("range", ast.Load()), [size], [])
                clause = ast.comprehension(ast.Name("index", ast.Store()), indices, [], 0)
                node.args[n] = placed(ast.ListComp(number, [clause]), node)
        return node

    def _is_mapped_count(self, node: ast.GeneratorExp) -> bool:
        """Return whether a generator gives something for each number, which nothing but the number decides."""
        clause = node.generators[0]
        is_count = isinstance(clause.iter, ast.Call) and _path(clause.iter.func, self._paths) == _COUNT
        is_plain = len(node.generators) == 1 and not clause.ifs and isinstance(clause.target, ast.Name)
        return is_count and is_plain and is_pure(node.elt)

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        """Write ``np.c_[a, b]`` as the call that it is."""
        is_call = _path(node.value, self._paths) == "numpy.c_" and isinstance(node.slice, ast.Tuple)
        self.generic_visit(node)
        if is_call and isinstance(node.value, ast.Attribute):
            function = ast.Attribute(node.value.value, "column_stack", ast.Load())
            return placed(ast.Call(function, [node.slice], []), node)
        return node

    def _inner(self, node: ast.Attribute) -> ast.expr:
        self.generic_visit(node)
        return node

    def visit_ImportFrom(self, node: ast.ImportFrom) -> ast.ImportFrom | None:
        given = {each.name: f"{node.module}.{each.name}" for each in node.names}
        node.names = [n for n in node.names if given[n.name] not in LIBRARY or given[n.name] in self._other]
        return node if node.names else None

    def _replaced(self, node: ast.Name | ast.Attribute) -> ast.expr:
        path = _path(node, self._paths)
        if path in _CONSTANTS:
            return ast.copy_location(ast.Constant(_CONSTANTS[path]), node)
        if path not in LIBRARY or path in self._other:
            return node
        return self._function(path, node)

    def _function(self, path: str, node: ast.expr) -> ast.expr:
        """Return the name of a function in Python of the library."""
        own = path.rpartition(".")[2]
        is_taken = own in self._names and self._paths.get(own) != path
        name = f"{own}_of_library" if is_taken else own
        self.made[name] = LIBRARY[path].replace(f"def {own}(", f"def {name}(", 1)
        return ast.copy_location(ast.Name(name, ast.Load()), node)


def _method_of_text(node: ast.expr) -> ast.expr:
    """Return ``str.strip`` as a function that calls the method."""
    is_method = isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "str"
    if not is_method or not isinstance(node, ast.Attribute):
        return node
    return placed(ast.parse(f"lambda text: text.{node.attr}()", mode="eval").body, node, is_new=True)


def _parsed(text: ast.expr) -> ast.expr | None:
    """Return the values that a constant text of JSON means, None if they are no plain ones, or too many."""
    if not isinstance(text, ast.Constant) or not isinstance(text.value, str) or len(text.value) > _MOST_JSON:
        return None
    try:
        values = repr(json.loads(text.value))
        ast.literal_eval(values)
    except (ValueError, RecursionError):  # no text of JSON, or infinite numbers
        return None
    return placed(ast.parse(values, mode="eval").body, text, is_new=True)


def _listed(node: ast.expr) -> ast.expr:
    """Return a list in place of an iterator, or of a view of a table, that is used up at once."""
    if _method(node) in (("keys", 0), ("values", 0), ("items", 0)):
        return placed(ast.Call(ast.Name("list", ast.Load()), [node], []), node)
    return ast.copy_location(ast.ListComp(node.elt, node.generators), node) if type(node) is ast.GeneratorExp else node


def _getter(path: str, node: ast.Call) -> ast.expr | None:
    """Return the function that `attrgetter`, `itemgetter` or `methodcaller` makes; None for computed names."""
    given = [each.value for each in node.args if isinstance(each, ast.Constant)]
    if path == "operator.methodcaller":
        if not given or not all(map(is_repeatable, node.args)) or not str(given[0]).isidentifier():
            return None
        function = ast.Attribute(ast.Name("each", ast.Load()), str(given[0]), ast.Load())
        parts: list[ast.expr] = [ast.Call(function, node.args[1:], node.keywords)]
    elif node.keywords or len(given) != len(node.args) or not given:
        return None
    elif path == "operator.attrgetter":
        names = [name for name in given if type(name) is str]
        if len(names) < len(given) or not all(part.isidentifier() for name in names for part in name.split(".")):
            return None
        body = ast.parse(", ".join(f"each.{name}" for name in names), mode="eval").body
        parts = body.elts if isinstance(body, ast.Tuple) else [body]
    else:
        parts = [ast.Subscript(ast.Name("each", ast.Load()), each, ast.Load()) for each in node.args]
    body = parts[0] if len(parts) == 1 else ast.Tuple(parts, ast.Load())
    made = ast.Lambda(ast.arguments([], [ast.arg("each")], None, [], [], None, []), body)
    return placed(made, node, is_new=True)


class _Targets(ast.NodeTransformer):
    """Writes targets of loops with a starred name before the last one by indices; ``count`` says how many."""

    def __init__(self) -> None:
        self.count = 0

    @staticmethod
    def is_meant(target: ast.expr) -> bool:
        """Return whether a target is one of these."""
        return isinstance(target, ast.Tuple) and any(isinstance(each, ast.Starred) for each in target.elts[:-1])

    def visit_For(self, node: ast.For) -> ast.stmt:
        self.generic_visit(node)
        if self.is_meant(node.target):
            self.count += 1
            name = f"items_{self.count}"
            unpack = ast.Assign([node.target], ast.Name(name, ast.Load()))
            node.target = ast.copy_location(ast.Name(name, ast.Store()), node.target)
            node.body.insert(0, ast.copy_location(unpack, node.target))
            placed(unpack, node)
        return node

    def _in_comprehension(self, node: Any) -> Any:
        """Write starred targets of a comprehension as indices, since an expression cannot contain an assignment."""
        self.generic_visit(node)
        for clause in node.generators:
            if not self.is_meant(clause.target):
                continue
            self.count += 1
            name, elements = f"items_{self.count}", clause.target.elts
            star = next(n for n, each in enumerate(elements) if isinstance(each, ast.Starred))
            known: dict[str, ast.expr] = {}
            for n, each in enumerate(elements):
                end = n - len(elements) + 1
                index: ast.expr | ast.Slice = (
                    ast.Constant(n) if n < star else ast.UnaryOp(ast.USub(), ast.Constant(1 - end))
                )
                if n == star:
                    each = each.value
                    index = ast.Slice(ast.Constant(n), ast.UnaryOp(ast.USub(), ast.Constant(-end)), None)
                if isinstance(each, ast.Name):
                    known[each.id] = ast.Subscript(ast.Name(name, ast.Load()), index, ast.Load())
            clause.target = ast.copy_location(ast.Name(name, ast.Store()), clause.target)
            renamed = Substitution(known)
            clause.ifs = [renamed.visit(each) for each in clause.ifs]
            for field in ("elt", "key", "value"):
                if hasattr(node, field):
                    setattr(node, field, placed(renamed.visit(getattr(node, field)), node))
        return node

    visit_ListComp = visit_SetComp = visit_DictComp = visit_GeneratorExp = _in_comprehension


class _Silent(ast.NodeTransformer):
    """Leaves out logs and warnings, and the names of loggers."""

    def __init__(self, paths: Mapping[str, str]) -> None:
        self._names = {name for name, path in paths.items() if path.partition(".")[0] in _SILENT}
        self._has_streams = paths.get("sys") == "sys"

    def visit_Module(self, node: ast.Module) -> ast.Module:
        for each in node.body:
            if isinstance(each, ast.Assign) and isinstance(each.targets[0], ast.Name) and self._is_silent(each.value):
                self._names.add(each.targets[0].id)
        self.generic_visit(node)
        if self._has_streams and not any(isinstance(n, ast.Name) and n.id == "sys" for n in walk_tree(node)):
            self._names.add("sys")
        node.body = [each for each in node.body if not self._is_left_out(each)]
        return node

    def _is_left_out(self, node: ast.stmt) -> bool:
        if isinstance(node, ast.Import):
            return all((each.asname or each.name) in self._names for each in node.names)
        if isinstance(node, ast.ImportFrom):
            return (node.module or "").partition(".")[0] in _SILENT
        return isinstance(node, ast.Assign) and self._is_silent(node.value)

    def _is_silent(self, node: ast.expr) -> bool:
        while isinstance(node, (ast.Call, ast.Attribute)):
            node = node.func if isinstance(node, ast.Call) else node.value
        return isinstance(node, ast.Name) and node.id in self._names

    def visit_Expr(self, node: ast.Expr) -> ast.stmt:
        is_plain = isinstance(node.value, ast.Call) and not any(
            isinstance(each, (ast.Call, ast.NamedExpr)) and each is not node.value and not self._is_pure(each)
            for each in walk_tree(node.value)
        )
        is_silent = self._is_silent(node.value) or self._is_aside(node.value)
        return ast.copy_location(ast.Pass(), node) if is_plain and is_silent else node

    def _is_aside(self, node: ast.expr) -> bool:
        """Return whether a call sets up Python itself, or writes to people beside what the program prints."""
        if not self._has_streams or not isinstance(node, ast.Call):
            return False
        is_error = any(each.arg == "file" and ast.unparse(each.value) == "sys.stderr" for each in node.keywords)
        return ast.unparse(node.func) in _SILENT_CALLS or (is_error and ast.unparse(node.func) == "print")

    @staticmethod
    def _is_pure(node: ast.AST) -> bool:
        return (
            isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("len", "round", "str")
        )


def _with_fixed_arguments(tree: ast.Module, paths: Mapping[str, str]) -> None:
    """Write the arguments that ``name = partial(function, ...)`` fixes into the calls of the name, if all are calls."""
    fixed = [
        each for each in walk_tree(tree)
        if isinstance(each, ast.Assign) and isinstance(each.value, ast.Call) and isinstance(each.targets[0], ast.Name)
        and _path(each.value.func, paths) == "functools.partial" and each.value.args
    ]  # fmt: skip
    for statement in fixed:
        target, call = statement.targets[0], statement.value
        assert isinstance(target, ast.Name)
        assert isinstance(call, ast.Call)
        uses = [n for n in walk_tree(tree) if isinstance(n, ast.Name) and n.id == target.id and n is not target]
        calls = [n for n in walk_tree(tree) if isinstance(n, ast.Call) and any(n.func is use for use in uses)]
        first = call.args[0]
        is_method = isinstance(first, ast.Attribute) and not is_repeatable(first)
        given_here = [*(call.args[1:] if is_method else call.args), *(k.value for k in call.keywords)]
        is_simple = all(is_repeatable(each) and _are_constant(each, tree) for each in given_here)
        if len(calls) < len(uses) or not calls or not is_simple:
            continue
        if is_method and isinstance(first, ast.Attribute):  # of an object that is made once
            owner = free_name(f"{target.id}_owner", names_in(tree))
            made = ast.copy_location(ast.Assign([ast.Name(owner, ast.Store())], first.value), statement)
            _replace(tree, statement, placed(made, statement))
            call.args[0] = placed(ast.Attribute(ast.Name(owner, ast.Load()), first.attr, ast.Load()), first)
        for each in calls:
            each.func = copy.deepcopy(call.args[0])
            each.args = [*copy.deepcopy(call.args[1:]), *each.args]
            given = {k.arg for k in each.keywords}
            each.keywords += [copy.deepcopy(k) for k in call.keywords if k.arg not in given]
        _replace(tree, statement)


def _with_fixed_modules(tree: ast.Module, paths: Mapping[str, str]) -> None:
    """Write a module for the parameter of which it is the default, in place, if no call passes another."""
    for function in [each for each in tree.body if isinstance(each, ast.FunctionDef)]:
        given = function.args
        if not given.args or not given.defaults or given.posonlyargs or given.vararg or is_registered(function):
            continue
        last, default = given.args[-1].arg, given.defaults[-1]
        if not isinstance(default, ast.Name) or paths.get(default.id) not in _MODULES or last == default.id:
            continue
        uses = [n for n in walk_tree(tree) if isinstance(n, ast.Name) and n.id == function.name]
        calls = [n for n in walk_tree(tree) if isinstance(n, ast.Call) and any(n.func is use for use in uses)]
        passed = any(
            len(call.args) >= len(given.args) or any(isinstance(each, ast.Starred) for each in call.args)
            or any(k.arg in (last, None) for k in call.keywords)
            for call in calls
        )  # fmt: skip
        if len(calls) == len(uses) and not passed:
            given.args.pop()
            given.defaults.pop()
            function.body = [Substitution({last: default}).visit(each) for each in function.body]


def _are_constant(node: ast.expr, tree: ast.Module) -> bool:
    """Return whether each variable of an expression is assigned at one place only."""
    names = {each.id for each in walk_tree(node) if isinstance(each, ast.Name)}
    stores = [n.id for n in walk_tree(tree) if isinstance(n, ast.Name) and not isinstance(n.ctx, ast.Load)]
    return all(stores.count(name) <= 1 for name in names)


def _replace(tree: ast.Module, statement: ast.stmt, other: ast.stmt | None = None) -> None:
    for node in walk_tree(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and statement in body:
            body[body.index(statement)] = other or ast.copy_location(ast.Pass(), statement)


# --- classes -------------------------------------------------------------------------------------------------------


def _is_marker(base: ast.expr) -> bool:
    return ast.unparse(base.value if isinstance(base, ast.Subscript) else base) in _MARKERS


_PLAIN_FIELD = re.compile(r"['\"]?((int|float|str|bool|None|tuple|Tuple|Color|\.\.\.|[\[\], |])+)['\"]?")
_UNSET = re.compile(r"(dataclasses\.)?field\(init=False(, repr=False)?\)")  # which the class assigns itself
_CACHED = ("cached_property", "functools.cached_property")


def _decorators(node: ast.FunctionDef) -> set[str]:
    return {ast.unparse(each) for each in node.decorator_list}


def _dunder(name: str) -> str | None:
    inner = name.removeprefix("__").removesuffix("__")
    is_special = name == f"__{inner}__"
    plain = f"{inner}_" if inner in ("or", "and") else inner
    return plain if is_special and plain in _METHODS else None


def _orders(node: ast.AST) -> bool:
    """Return whether a call compares items of which it is not known what they are."""
    name = ast.unparse(node.func).rpartition(".")[2] if isinstance(node, ast.Call) else ""
    return name in ("sorted", "sort", "min", "max") and not any(k.arg == "key" for k in node.keywords)  # type: ignore[attr-defined]


def _compared_fields(node: ast.ClassDef) -> list[str]:
    """Return the fields by which a data class compares."""
    return [
        each.target.id for each in node.body if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name)
        and "compare=False" not in ast.unparse(each.value or ast.Constant(None))
    ]  # fmt: skip


def _ordered_fields(node: ast.ClassDef) -> list[str]:
    """Return the fields of a data class that has an order; none for any other class."""
    return _compared_fields(node) if any("order=True" in ast.unparse(each) for each in node.decorator_list) else []


def _write_order(node: ast.ClassDef) -> None:
    """Write the comparison of a data class that has an order: that of its fields."""
    fields = _compared_fields(node)
    sides = [", ".join(f"{owner}.{name}" for name in fields) for owner in ("self", "other")]
    one, other = sides if len(fields) == 1 else (f"({each})" for each in sides)
    made = ast.parse(f"def lt(self, other):\n    return {one} < {other}").body[0]
    placed(made, node, is_new=True)
    node.body.append(made)


def _lower_class(node: ast.ClassDef, *, is_sorted: bool) -> None:
    """Make the operator methods of a class plain ones, its class methods static, and write its constructor."""
    if not is_sorted and any("order=True" in ast.unparse(each) for each in node.decorator_list):
        _write_order(node)
    node.body = [each for each in node.body if getattr(each, "name", "") not in _TEXTS] or [
        ast.copy_location(ast.Pass(), node)
    ]
    own = {each.name for each in node.body if isinstance(each, ast.FunctionDef)}
    if "__getitem__" in own and not own & {"__iter__", "__len__"}:
        node.body += _iteration_by_index(node)
    for each in node.body:
        setter = each.decorator_list[0] if isinstance(each, ast.FunctionDef) and each.decorator_list else None
        if isinstance(each, ast.FunctionDef) and setter is not None and ast.unparse(setter) == f"{each.name}.setter":
            each.name, each.decorator_list = f"set_{each.name}", []
        if isinstance(each, ast.AnnAssign) and (default := _plain_default(each.value)) is not None:
            each.value = default
        if isinstance(each, ast.AnnAssign) and each.value is not None and _UNSET.fullmatch(ast.unparse(each.value)):
            each.value = ast.copy_location(ast.Constant(None), each.value)
            each.__dict__["is_unset"] = True
        if not isinstance(each, ast.FunctionDef):
            continue
        plain = _dunder(each.name)
        if plain in _ORDER and is_sorted:
            continue  # which they decide, too
        if plain is not None and plain not in own and (plain != "iter" or is_pure(each)):
            each.name = plain
            if plain == "iter":
                _without_iterator(each)
        for decorator in each.decorator_list:
            if ast.unparse(decorator) in _CACHED and _is_steady(each):
                each.decorator_list = [ast.copy_location(ast.Name("property", ast.Load()), decorator)]
            elif ast.unparse(decorator) == "classmethod" and each.args.args and not node.bases:
                each.decorator_list = [ast.copy_location(ast.Name("staticmethod", ast.Load()), decorator)]
                cls = each.args.args.pop(0).arg
                for name in walk_tree(each):
                    if isinstance(name, ast.Name) and name.id == cls:
                        name.id = node.name
    finish = next((e for e in node.body if isinstance(e, ast.FunctionDef) and e.name == "__post_init__"), None)
    if finish is not None and "__init__" not in own and any("dataclass" in ast.unparse(d) for d in node.decorator_list):
        _write_constructor(node, finish)


class _Assigned(ast.NodeTransformer):
    """Writes ``object.__setattr__(self, "x", value)``, as a frozen data class sets its fields, as an assignment."""

    def visit_Expr(self, node: ast.Expr) -> ast.stmt:
        call = node.value
        if not isinstance(call, ast.Call) or ast.unparse(call.func) != "object.__setattr__" or len(call.args) != 3:
            return node
        owner, name, value = call.args
        if not isinstance(name, ast.Constant) or not isinstance(name.value, str) or not name.value.isidentifier():
            return node
        target = ast.copy_location(ast.Attribute(owner, name.value, ast.Store()), name)
        return ast.copy_location(ast.Assign([target], value), node)


def _name_own_class(node: ast.ClassDef) -> None:
    """Write ``type(self)`` and ``self.__class__`` in the methods of a class without derived ones as its name."""
    for method in node.body:
        if not isinstance(method, ast.FunctionDef) or not method.args.args or method.decorator_list:
            continue
        own = method.args.args[0].arg
        _OwnClass({f"type({own})", f"{own}.__class__"}, node.name).visit(method)


class _OwnClass(ast.NodeTransformer):
    def __init__(self, texts: set[str], name: str) -> None:
        self._texts, self._name = texts, name

    def visit_Call(self, node: ast.Call) -> ast.expr:
        return self._named(node)

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        return self._named(node)

    def _named(self, node: ast.Call | ast.Attribute) -> ast.expr:
        if ast.unparse(node) in self._texts:
            return ast.copy_location(ast.Name(self._name, ast.Load()), node)
        self.generic_visit(node)
        return node


def _plain_default(value: ast.expr | None) -> ast.expr | None:
    """Return the default of ``field(default=3, repr=False)``, which a constructor takes as ``= 3``; else None."""
    if not isinstance(value, ast.Call) or name_of(value) != "field" or value.args:
        return None
    given = {each.arg: each.value for each in value.keywords}
    return given.get("default") if {*given} <= {"default", "repr", "hash"} else None


def _iteration_by_index(node: ast.ClassDef) -> list[ast.stmt]:
    """Return the ``__iter__`` that a class has by a ``__getitem__`` which says where its items end."""
    method = next(each for each in node.body if isinstance(each, ast.FunctionDef) and each.name == "__getitem__")
    names = [each.arg for each in method.args.args]
    first = method.body[0]
    if len(names) != 2 or not isinstance(first, ast.If) or "raise IndexError" not in ast.unparse(first.body[0]):
        return []
    owner, index = names
    end = re.fullmatch(rf"not 0 <= {index} < (.+)|(?:{index} < 0 or )?{index} >= (.+)", ast.unparse(first.test))
    if end is None or first.orelse or not is_pure(ast.Module([*method.body[1:]], [])):
        return []
    text = f"def __iter__({owner}):\n    return [{owner}[{index}] for {index} in range({end[1] or end[2]})]"
    return [placed(each, method, is_new=True) for each in ast.parse(text).body]


def _is_steady(method: ast.FunctionDef) -> bool:
    """Return whether a property gives the same whenever it is asked, as far as its text shows: it draws nothing."""
    if len(method.body) == 1 and isinstance(method.body[0], ast.Return):
        return True
    nodes = walk_tree(*method.body)
    own = {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    for node in nodes:
        if isinstance(node, (ast.Attribute, ast.Subscript)) and not isinstance(node.ctx, ast.Load):
            return False
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            owner = node.func.value
            if not (isinstance(owner, ast.Name) and (owner.id in own or owner.id in ("math", "np", "numpy"))):
                return False
    return True


def _write_constructor(node: ast.ClassDef, finish: ast.FunctionDef) -> None:
    """Write the ``__init__`` of a data class that ends with ``__post_init__``, unless a field has a factory."""
    fields = [each for each in node.body if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name)]
    texts = [ast.unparse(each.annotation) + ast.unparse(each.value or ast.Constant(0)) for each in fields]
    if any("field(" in each or "InitVar" in each for each in texts) or len(finish.args.args) != 1:
        return
    own = finish.args.args[0].arg
    unset = {each.target.id for each in fields if getattr(each, "is_unset", False)}  # type: ignore[union-attr]
    lines = [f"        {own}.{each.target.id} = {each.target.id}" for each in fields if each.target.id not in unset]  # type: ignore[union-attr]
    is_keyword = any("kw_only=True" in ast.unparse(each) for each in node.decorator_list)
    given = [
        f"{each.target.id}={ast.unparse(each.value)}" if each.value is not None else each.target.id  # type: ignore[union-attr]
        for each in fields
        if each.target.id not in unset  # type: ignore[union-attr]
    ]
    parameters = ", ".join([own, *(["*"] if is_keyword and given else []), *given])
    text = "\n".join([f"class C:\n    def __init__({parameters}):", *lines, f"        {own}.post_init()"])
    made = ast.parse(text).body[0]
    assert isinstance(made, ast.ClassDef)
    for each in walk_tree(made.body[0]):
        if "lineno" in each._attributes:
            ast.copy_location(each, finish)
    finish.name = "post_init"
    node.body.insert(node.body.index(finish), made.body[0])


def _without_iterator(method: ast.FunctionDef) -> None:
    """Return the items themselves from ``__iter__``: a loop takes them in the same order."""
    for node in walk_tree(method):
        if isinstance(node, ast.Return) and isinstance(node.value, ast.Call) and len(node.value.args) == 1:
            if isinstance(node.value.func, ast.Name) and node.value.func.id == "iter":
                node.value = node.value.args[0]


def _returns_itself(method: str, cls: Any) -> bool:
    """Return whether a method changes its owner and returns it, as ``__iadd__`` does."""
    node = cls.methods[method].node
    ends = [each for each in walk_tree(node) if isinstance(each, ast.Return)]
    own = node.args.args[0].arg if node.args.args else ""
    return bool(ends) and all(isinstance(end.value, ast.Name) and end.value.id == own for end in ends)


class OperatorMethods(ast.NodeTransformer):
    """Replaces operators on instances of the program's classes by calls of their methods; ``count`` says how many."""

    def __init__(
        self,
        classes_of: Callable[[ast.expr], list[Any]],
        kinds_of: Callable[[ast.expr], int],
        keys_of: Callable[[ast.expr], int],
        items_of: Callable[[ast.expr], list[Any]],
        dispatch: Dispatch,
    ) -> None:
        self._classes_of, self._kinds_of, self._keys_of, self._dispatch = classes_of, kinds_of, keys_of, dispatch
        self._items_of = items_of
        self.count = 0

    def visit_Module(self, node: ast.Module) -> ast.Module:
        known = len(self._dispatch.made)
        self.generic_visit(node)
        place = max((n for n, each in enumerate(node.body) if isinstance(each, ast.ClassDef)), default=-1) + 1
        for each in self._dispatch.made[known:]:
            for inner in walk_tree(each):
                _at(inner, 1)
            node.body.insert(place, each)
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        """Add the classes to a function that chooses by them which have become known since it was made."""
        first = node.body[0].test if isinstance(node.body[0], ast.If) else None
        if isinstance(first, ast.Call) and first.args:
            classes = sorted(each.name for each in self._classes_of(first.args[0]))
            if self._dispatch.extend(node, classes):
                self.count += 1
                for each in walk_tree(node):
                    _at(each, 1)
        self.generic_visit(node)
        return node

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        self.generic_visit(node)
        kinds = self._kinds_of(node.value)
        if (
            node.attr == "value" and kinds and not kinds & ~(NUMBERS | STR)
        ):  # a member of an enumeration that is its value
            self.count += 1
            return node.value
        classes = self._classes_of(node.value)
        has_all = len(classes) > 1 and all(node.attr in (*dict(c.fields), *c.constants, *c.properties) for c in classes)
        if not has_all or not isinstance(node.ctx, ast.Load):
            return node
        self.count += 1
        return self._dispatch.field(node, sorted(each.name for each in classes))

    def _has(self, node: ast.expr, method: str) -> bool:
        classes = self._classes_of(node)
        return bool(classes) and all(method in each.methods for each in classes)

    def _call(self, node: ast.expr, owner: ast.expr, method: str, arguments: list[ast.expr]) -> ast.expr:
        self.count += 1
        function = ast.copy_location(ast.Attribute(owner, method, ast.Load()), node)
        made = ast.copy_location(ast.Call(function, arguments, []), node)
        names = sorted(each.name for each in self._classes_of(owner))
        chosen = self._dispatch.call(made, owner, method, names) if len(names) > 1 else None
        return chosen or made

    def _value(self, node: ast.expr, kinds: int) -> ast.expr:
        """Return the value of a member that is a number or a text, where it meets what has ``kinds``."""
        classes = self._classes_of(node)
        if not kinds or kinds & ~(NUMBERS | STR) or len(classes) != 1 or not is_its_value(classes[0].node):
            return node
        self.count += 1
        return ast.copy_location(ast.Attribute(node, "value", ast.Load()), node)

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        self.generic_visit(node)
        kinds = [self._kinds_of(node.right), self._kinds_of(node.left)]
        node.left, node.right = self._value(node.left, kinds[0]), self._value(node.right, kinds[1])
        method = OPERATOR_METHODS.get(type(node.op), "")
        if self._has(node.left, method):
            right = node.right
            method = self._case(node.left, method, right)
            if self._has(right, "in_any_order"):
                right = self._call(right, right, "in_any_order", [])
            return self._call(node, node.left, method, [right])
        if not self._classes_of(node.left) and is_repeatable(node.left) and self._has(node.right, f"r{method}"):
            return self._call(node, node.right, self._case(node.right, f"r{method}", node.left), [node.left])
        return node

    def _case(self, owner: ast.expr, method: str, operand: ast.expr) -> str:
        """Return the method that an operator calls: one for operands of its type, if that is known."""
        classes = self._classes_of(owner)
        if len(classes) != 1:
            return method
        names = {each.name for each in self._classes_of(operand)}
        return method_for(classes[0], method, self._kinds_of(operand), names)

    def visit_Assign(self, node: ast.Assign) -> ast.stmt:
        """Write ``grid[key] = value``, and the assignment of a property, as the call of a method."""
        target = node.targets[0]
        setter = f"set_{target.attr}" if isinstance(target, ast.Attribute) else ""
        if len(node.targets) == 1 and isinstance(target, ast.Attribute) and self._has(target.value, setter):
            value, owner = self.visit(node.value), self.visit(target.value)
            return ast.copy_location(ast.Expr(self._call(node.value, owner, setter, [value])), node)
        if len(node.targets) == 1 and isinstance(target, ast.Subscript) and self._has(target.value, "setitem"):
            node.value = self.visit(node.value)
            owner, key = self.visit(target.value), self.visit(target.slice)
            return ast.copy_location(ast.Expr(self._call(node.value, owner, "setitem", [key, node.value])), node)
        self.generic_visit(node)
        return node

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.stmt:
        """Write ``x += y`` as a call of an operator method, or of the setter of a property or item."""
        self.generic_visit(node)
        method = OPERATOR_METHODS.get(type(node.op), "")
        target = node.target
        is_property = isinstance(target, ast.Attribute) and self._has(target.value, f"set_{target.attr}")
        if isinstance(target, ast.Attribute) and is_property and is_repeatable(target.value):
            asked = ast.copy_location(ast.Attribute(copy.deepcopy(target.value), target.attr, ast.Load()), target)
            new = ast.copy_location(ast.BinOp(asked, node.op, node.value), node.value)
            return ast.copy_location(ast.Expr(self._call(node.value, target.value, f"set_{target.attr}", [new])), node)
        if isinstance(target, ast.Subscript) and self._has(target.value, "setitem") and is_repeatable(target.value):
            # owner and key are written twice
            if is_repeatable(target.slice) and self._has(target.value, "getitem"):
                item = self._call(node.value, target.value, "getitem", [copy.deepcopy(target.slice)])
                new = ast.copy_location(ast.BinOp(item, node.op, node.value), node.value)
                call = self._call(node.value, copy.deepcopy(target.value), "setitem", [target.slice, new])
                return ast.copy_location(ast.Expr(call), node)
        if isinstance(node.target, ast.Name):
            old = ast.copy_location(ast.Name(node.target.id, ast.Load()), node.target)
            for name in (f"i{method}", method):
                if self._has(node.target, name):
                    gives_itself = all(map(partial(_returns_itself, name), self._classes_of(node.target)))
                    value = self._call(node.value, old, name, [node.value])
                    made = ast.Expr(value) if gives_itself else ast.Assign([node.target], value)
                    return ast.copy_location(made, node)
        return node

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        self.generic_visit(node)
        if isinstance(node.op, ast.USub) and self._has(node.operand, "neg"):
            return self._call(node, node.operand, "neg", [])
        if isinstance(node.op, ast.Not):
            node.operand = self._truth(node.operand)
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        self.generic_visit(node)
        node.slice = self._value(node.slice, self._kinds_of_keys(node.value))
        if (
            isinstance(node.ctx, ast.Load)
            and not isinstance(node.slice, ast.Slice)
            and self._has(node.value, "getitem")
        ):
            return self._call(node, node.value, "getitem", [node.slice])
        return node

    def _kinds_of_keys(self, node: ast.expr) -> int:
        """Return the kinds of the keys of a table, or of the indices of a sequence."""
        kinds = self._kinds_of(node)
        if kinds == DICT:
            return self._keys_of(node)
        return INT if kinds and not kinds & ~(LIST | TUPLE | ARRAY | STR) else 0

    def _ordered(self, node: ast.Compare) -> ast.expr | None:
        """Return a comparison of objects by a method of theirs."""
        right = node.comparators[0]
        for name, kind in _ORDER.items():
            if type(node.ops[0]) is kind and self._has(node.left, name):
                return self._call(node, node.left, name, [right])
            mirrored = {"lt": ast.Gt, "gt": ast.Lt, "le": ast.GtE, "ge": ast.LtE}[name]
            if type(node.ops[0]) is mirrored and self._has(node.left, name) and is_repeatable(node.left):
                return self._call(node, right, name, [node.left])
        return None

    def _truth(self, node: ast.expr) -> ast.expr:
        """Return a test of an object by its ``__bool__``, or else by its length."""
        if self._has(node, "bool"):
            return self._call(node, node, "bool", [])
        if self._has(node, "len"):
            size = self._call(node, node, "len", [])
            zero = ast.copy_location(ast.Constant(0), node)
            return ast.copy_location(ast.Compare(size, [ast.Gt()], [zero]), node)
        return node

    def visit_If(self, node: ast.If) -> ast.stmt:
        self.generic_visit(node)
        node.test = self._truth(node.test)
        return node

    def visit_While(self, node: ast.While) -> ast.stmt:
        self.generic_visit(node)
        node.test = self._truth(node.test)
        return node

    def visit_IfExp(self, node: ast.IfExp) -> ast.expr:
        self.generic_visit(node)
        node.test = self._truth(node.test)
        return node

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        self.generic_visit(node)
        if len(node.ops) == 1:
            right = node.comparators[0]
            is_in = isinstance(node.ops[0], (ast.In, ast.NotIn))
            items = right.elts if is_in and isinstance(right, (ast.Tuple, ast.List, ast.Set)) else [right]
            kinds = [self._kinds_of_keys(right) if is_in and items == [right] else self._kinds_of(x) for x in items]
            known = reduce(or_, kinds, 0) if all(kinds) else 0
            left = self._kinds_of(node.left)
            node.left = self._value(node.left, known)
            node.comparators = [right if is_in else self._value(right, left)]
        if len(node.ops) == 1 and type(node.ops[0]) in _ORDER.values():
            return self._ordered(node) or node
        if len(node.ops) == 1 and isinstance(node.ops[0], (ast.In, ast.NotIn)):
            if self._has(node.comparators[0], "contains"):
                made = self._call(node, node.comparators[0], "contains", [node.left])
                is_in = isinstance(node.ops[0], ast.In)
                return made if is_in else ast.copy_location(ast.UnaryOp(ast.Not(), made), node)
            if self._kinds_of(node.comparators[0]) == INT and is_repeatable(node.left):  # flags, which are numbers
                self.count += 1
                both = ast.copy_location(ast.BinOp(node.comparators[0], ast.BitAnd(), copy.deepcopy(node.left)), node)
                same = ast.Eq() if isinstance(node.ops[0], ast.In) else ast.NotEq()
                return ast.copy_location(ast.Compare(both, [same], [node.left]), node)
        return node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Write calls that depend on the classes of their operands as calls of methods or of plain functions."""
        self.generic_visit(node)
        function = node.func
        if isinstance(function, ast.Attribute):
            classes = self._classes_of(function.value)
            if len(classes) > 1 and all(function.attr in each.methods for each in classes):
                names = sorted(each.name for each in classes)
                # the class is known only when the program runs: a function tests for each
                made = self._dispatch.call(node, function.value, function.attr, names)
                self.count += made is not None
                return made or node
            if len(classes) == 1 and function.attr in classes[0].methods and len(node.args) == 1:
                name = self._case(function.value, function.attr, node.args[0])
                self.count += name != function.attr
                function.attr = name
        if ast.unparse(function) in _OF_VALUES or (
            name_of(getattr(function, "value", None)) in ("math", "np", "numpy")
        ):
            node.args = [self._value(each, NUMBERS | STR) for each in node.args]
        if isinstance(function, ast.Attribute) and function.attr in ("get", "pop", "setdefault") and node.args:
            node.args = [self._value(node.args[0], self._kinds_of_keys(function.value)), *node.args[1:]]
        name = ast.unparse(function).removeprefix("dataclasses.")
        if name == "replace" and len(node.args) == 1:
            return self._replaced(node) or node
        if name in ("asdict", "astuple") and len(node.args) == 1 and not node.keywords:
            return self._fields(node, is_table=name == "asdict") or node
        if isinstance(function, ast.Name) and function.id == "sum" and len(node.args) == 2 and not node.keywords:
            if self._has(node.args[1], "add"):
                self.count += 1
                # `sum` of the language does not call operator methods
                made = ast.parse("functools.reduce(lambda total, item: total + item, 0, 0)", mode="eval").body
                assert isinstance(made, ast.Call)
                made.args[1:] = node.args
                for each in walk_tree(made.args[0], made.func):
                    if "lineno" in each._attributes:
                        ast.copy_location(each, node)
                return ast.copy_location(made, node)
        self._sort_by_fields(node)
        if isinstance(function, ast.Name) and function.id in ("len", "abs") and len(node.args) == 1:
            if self._has(node.args[0], function.id):
                return self._call(node, node.args[0], function.id, [])
        if isinstance(function, ast.Name) and function.id in _UNORDERED and len(node.args) == 1:
            if self._has(node.args[0], "in_any_order"):
                node.args = [self._call(node.args[0], node.args[0], "in_any_order", [])]
        if isinstance(function, ast.Name) and function.id in _CONSUMERS and node.args:
            node.args = [self._items(node.args[0]), *node.args[1:]]
        if isinstance(function, (ast.Name, ast.Attribute, ast.Subscript)) and self._is_instance(function):
            self.count += 1
            node.func = ast.copy_location(ast.Attribute(function, "call", ast.Load()), function)
        return node

    def _sort_by_fields(self, node: ast.Call) -> None:
        """Give ``sorted`` and the like a key where items are of a data class whose order is that of its fields."""
        is_method = isinstance(node.func, ast.Attribute) and node.func.attr == "sort"
        is_function = isinstance(node.func, ast.Name) and node.func.id in ("sorted", "min", "max")
        if any(k.arg == "key" for k in node.keywords) or len(node.args) != (0 if is_method else 1):
            return
        if not (is_method or is_function):
            return
        items = self._items_of(node.func.value if isinstance(node.func, ast.Attribute) else node.args[0])
        names = _ordered_fields(items[0].node) if len(items) == 1 else []
        if not names:
            return
        self.count += 1
        parts = ", ".join(f"item.{name}" for name in names)
        key = ast.parse(f"lambda item: {f'({parts})' if len(names) > 1 else parts}", mode="eval").body
        node.keywords.append(ast.keyword("key", placed(key, node, is_new=True)))

    def _replaced(self, node: ast.Call) -> ast.expr | None:
        """Return the call of a data class with the fields of an object, some of them changed."""
        given, classes = node.args[0], self._classes_of(node.args[0])
        changed = {str(k.arg): k.value for k in node.keywords}
        if len(classes) != 1 or not classes[0].is_dataclass or not is_repeatable(given):
            return None
        if "__init__" in classes[0].methods:
            return None
        names = [name for name, _ in classes[0].fields]
        if not {*changed} <= {*names}:
            return None
        self.count += 1
        values = [changed.get(n) or ast.Attribute(copy.deepcopy(given), n, ast.Load()) for n in names]
        made = ast.Call(ast.Name(classes[0].name, ast.Load()), [], [ast.keyword(n, v) for n, v in zip(names, values)])
        placed(made, node)
        return made

    def _fields(self, node: ast.Call, *, is_table: bool) -> ast.expr | None:
        """Return a table, or tuple, of the fields of a data class, if none of them is one with fields or items."""
        given, classes = node.args[0], self._classes_of(node.args[0])
        if len(classes) != 1 or not classes[0].is_dataclass or not is_repeatable(given):
            return None
        annotated = {
            each.target.id: ast.unparse(each.annotation) for each in classes[0].node.body
            if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Name)
        }  # fmt: skip
        names = [name for name, _ in classes[0].fields]
        if not all(_PLAIN_FIELD.fullmatch(annotated.get(name, "")) for name in names):
            return None  # which are copied, too
        self.count += 1
        values: list[ast.expr] = [ast.Attribute(copy.deepcopy(given), name, ast.Load()) for name in names]
        keys: list[ast.expr | None] = [ast.Constant(name) for name in names]
        return placed(ast.Dict(keys, values) if is_table else ast.Tuple(values, ast.Load()), node)

    def _items(self, node: ast.expr) -> ast.expr:
        return self._call(node, node, "iter", []) if self._has(node, "iter") else node

    def visit_For(self, node: ast.For) -> ast.stmt:
        self.generic_visit(node)
        node.iter = self._items(node.iter)
        return node

    def visit_comprehension(self, node: ast.comprehension) -> ast.comprehension:
        self.generic_visit(node)
        node.iter = self._items(node.iter)
        return node

    def visit_YieldFrom(self, node: ast.YieldFrom) -> ast.expr:
        self.generic_visit(node)
        node.value = self._items(node.value)
        return node

    def visit_Starred(self, node: ast.Starred) -> ast.expr:
        self.generic_visit(node)
        node.value = self._items(node.value)
        return node

    def _is_instance(self, node: ast.expr) -> bool:
        return self._has(node, "call")


def without_unused_methods(tree: ast.Module) -> ast.Module:
    """Return a module without the methods that nothing else of it asks for; the same one if all are used.

    Nothing is known of their operands, so that they could not be translated.
    """
    uses = Counter(node.attr for node in walk_tree(tree) if isinstance(node, ast.Attribute))
    unused: set[ast.AST] = set()
    while True:
        further = [each for each in _methods(tree) if each not in unused and not uses[each.name] - _own_uses(each)]
        if not further:
            break
        for method in further:
            unused.add(method)
            uses.subtract(node.attr for node in walk_tree(method) if isinstance(node, ast.Attribute))
            uses[method.name] = max(uses[method.name], 0)
    if not unused:
        return tree
    body = list(tree.body)
    for n, each in enumerate(body):
        if isinstance(each, ast.ClassDef):
            kept = [part for part in each.body if part not in unused] or [ast.copy_location(ast.Pass(), each)]
            cls = copy.copy(each)
            cls.body = kept
            body[n] = cls
    return ast.Module(body, tree.type_ignores)


def _methods(tree: ast.Module) -> Iterator[ast.FunctionDef]:
    """Yield the methods of classes whose calls name them."""
    for cls in tree.body:
        for each in cls.body if isinstance(cls, ast.ClassDef) else ():
            if isinstance(each, ast.FunctionDef) and not each.name.startswith("__") and each.name not in _IMPLICIT:
                yield each


def _own_uses(method: ast.FunctionDef) -> int:
    return sum(isinstance(node, ast.Attribute) and node.attr == method.name for node in walk_tree(method))


def has_classes(tree: ast.Module) -> bool:
    """Return whether a module has classes, whose instances may be operands, or asks members for their values."""
    return any(isinstance(node, ast.ClassDef) for node in tree.body) or any(
        (isinstance(node, ast.Attribute) and node.attr == "value") or isinstance(node, ast.In)
        for node in walk_tree(tree)
    )
