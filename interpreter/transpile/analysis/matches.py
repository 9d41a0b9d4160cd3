"""``match`` as ``if`` and ``elif``: a pattern is a test of its subject, and variables that are parts of it."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterable
from typing import Any

from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.rewriting import Substitution, placed

_PLAIN = ("int", "float", "str", "bool")  # classes whose only pattern is the value itself


class _Unsupported(Exception):
    """A pattern has no test that the translation knows."""


class Matches(ast.NodeTransformer):
    """Converts ``match`` statements; those with other patterns stay as they are.

    ``fields`` are the names of the fields of the program's data classes and named tuples by class, in their order.
    """

    def __init__(self, tree: ast.Module) -> None:
        self._fields = {
            cls.name: [s.target.id for s in cls.body if isinstance(s, ast.AnnAssign) and isinstance(s.target, ast.Name)]
            for cls in tree.body if isinstance(cls, ast.ClassDef)
        }  # fmt: skip
        self._taken = {n.id for n in walk_tree(tree) if isinstance(n, ast.Name)}

    def visit_Match(self, node: ast.Match) -> ast.stmt | list[ast.stmt]:
        """Return the ``if`` statement, after an assignment of the subject where it is no variable."""
        self.generic_visit(node)
        before: list[ast.stmt] = []
        subject = node.subject
        if _is_display(subject, node.cases):
            subject, before = self._named_parts(subject, _captured(node.cases))
        elif not isinstance(subject, ast.Name):
            name = "subject"
            while name in self._taken:
                name += "_"
            target = ast.copy_location(ast.Name(name, ast.Store()), subject)
            before = [ast.copy_location(ast.Assign([target], subject), node)]
            subject = ast.copy_location(ast.Name(name, ast.Load()), subject)
        branches: list[ast.stmt] = []
        try:
            for case in reversed(node.cases):
                branches = self._branch(subject, case, branches)
        except _Unsupported:
            return node
        for each in branches:
            placed(each, node)
        return [*before, *branches]

    def _named_parts(self, subject: Any, captured: set[str]) -> tuple[ast.Tuple, list[ast.stmt]]:
        """Return a tuple of variables that no pattern assigns, and the statements that assign the items to them."""
        before: list[ast.stmt] = []
        names: list[ast.expr] = []
        for n, each in enumerate(subject.elts):
            if not isinstance(each, (ast.Name, ast.Constant)) or getattr(each, "id", None) in captured:
                name = f"subject_{n}"
                while name in self._taken:
                    name += "_"
                self._taken.add(name)
                before.append(placed(ast.Assign([ast.Name(name, ast.Store())], each), each))
                each = ast.copy_location(ast.Name(name, ast.Load()), each)
            names.append(each)
        return ast.copy_location(ast.Tuple(names, ast.Load()), subject), before

    def _branch(self, subject: ast.expr, case: ast.match_case, other: list[ast.stmt]) -> list[ast.stmt]:
        tests, bound = self._pattern(subject, case.pattern)
        if case.guard is not None:
            tests.append(Substitution(bound).visit(copy.deepcopy(case.guard)))
        stores = [
            ast.Assign([ast.Name(name, ast.Store())], value)
            for name, value in bound.items()
            if not (isinstance(value, ast.Name) and value.id == name)
        ]
        for each in walk_tree(*stores, *tests):
            if "lineno" in each._attributes and not hasattr(each, "lineno"):
                ast.copy_location(each, case.pattern)
        body = [*map(_fresh, stores), *case.body]
        return [ast.copy_location(ast.If(_fresh(_all(tests)), body, other), case.pattern)] if tests else body

    def _pattern(self, subject: ast.expr, pattern: ast.pattern) -> tuple[list[ast.expr], dict[str, ast.expr]]:
        """Return the tests of a pattern, and the variables that it binds."""
        if isinstance(pattern, ast.MatchValue):
            return [ast.Compare(subject, [ast.Eq()], [pattern.value])], {}
        if isinstance(pattern, ast.MatchSingleton):
            same = ast.Eq() if isinstance(pattern.value, bool) else ast.Is()
            return [ast.Compare(subject, [same], [ast.Constant(pattern.value)])], {}
        if isinstance(pattern, ast.MatchAs):
            tests, bound = self._pattern(subject, pattern.pattern) if pattern.pattern is not None else ([], {})
            return tests, bound | ({pattern.name: subject} if pattern.name else {})
        if isinstance(pattern, ast.MatchOr):
            return self._alternatives(subject, pattern)
        if isinstance(pattern, ast.MatchSequence):
            return self._sequence(subject, pattern.patterns)
        if isinstance(pattern, ast.MatchMapping):
            return self._mapping(subject, pattern)
        if isinstance(pattern, ast.MatchClass):
            return self._class(subject, pattern)
        raise _Unsupported

    def _alternatives(self, subject: ast.expr, pattern: ast.MatchOr) -> tuple[list[ast.expr], dict[str, ast.expr]]:
        alternatives = [self._pattern(subject, each) for each in pattern.patterns]
        if any(bound for _, bound in alternatives):
            raise _Unsupported
        if not all(tests for tests, _ in alternatives):
            return [], {}  # one of them always matches
        return [ast.BoolOp(ast.Or(), [_all(tests) for tests, _ in alternatives])], {}

    def _sequence(self, subject: ast.expr, patterns: list[ast.pattern]) -> tuple[list[ast.expr], dict[str, ast.expr]]:
        """Return the tests of a sequence pattern, and the variables that it binds."""
        if isinstance(subject, ast.Tuple):
            # `_is_display` has compared the lengths
            return self._parts([], zip(patterns, subject.elts))
        stars = [n for n, each in enumerate(patterns) if isinstance(each, ast.MatchStar)]
        count = len(patterns) - len(stars)
        size = ast.Call(ast.Name("len", ast.Load()), [subject], [])
        kinds = ast.Tuple([ast.Name("list", ast.Load()), ast.Name("tuple", ast.Load())], ast.Load())
        tests: list[ast.expr] = [
            ast.Call(ast.Name("isinstance", ast.Load()), [subject, kinds], []),
            ast.Compare(size, [ast.GtE() if stars else ast.Eq()], [ast.Constant(count)]),
        ]
        parts: list[tuple[ast.pattern, ast.expr]] = []
        for n, each in enumerate(patterns):
            after = len(patterns) - 1 - n
            if isinstance(each, ast.MatchStar):
                end = ast.UnaryOp(ast.USub(), ast.Constant(after)) if after else None
                rest = ast.Subscript(subject, ast.Slice(ast.Constant(n), end, None), ast.Load())
                name = ast.MatchAs(None, each.name)
                # a starred name is bound to a list, even if the subject is a tuple
                parts.append((name, ast.Call(ast.Name("list", ast.Load()), [rest], [])))
            else:
                is_last = bool(stars) and n > stars[0]
                index = ast.UnaryOp(ast.USub(), ast.Constant(after + 1)) if is_last else ast.Constant(n)
                parts.append((each, ast.Subscript(subject, index, ast.Load())))
        return self._parts(tests, parts)

    def _mapping(self, subject: ast.expr, pattern: ast.MatchMapping) -> tuple[list[ast.expr], dict[str, ast.expr]]:
        kind = ast.Call(ast.Name("isinstance", ast.Load()), [subject, ast.Name("dict", ast.Load())], [])
        tests: list[ast.expr] = [kind, *(ast.Compare(key, [ast.In()], [subject]) for key in pattern.keys)]
        parts: list[tuple[ast.pattern, ast.expr]] = [
            (p, ast.Subscript(subject, key, ast.Load())) for key, p in zip(pattern.keys, pattern.patterns)
        ]
        if pattern.rest is not None:
            keys = ", ".join(map(ast.unparse, pattern.keys))
            key, value = f"{pattern.rest}_key", f"{pattern.rest}_value"  # no names of the subject or the patterns
            items = f"{ast.unparse(subject)}.items()"
            text = f"{{{key}: {value} for {key}, {value} in {items} if {key} not in ({keys},)}}"
            parts.append((ast.MatchAs(None, pattern.rest), ast.parse(text, mode="eval").body))
        return self._parts(tests, parts)

    def _class(self, subject: ast.expr, pattern: ast.MatchClass) -> tuple[list[ast.expr], dict[str, ast.expr]]:
        name = ast.unparse(pattern.cls)
        tests: list[ast.expr] = [ast.Call(ast.Name("isinstance", ast.Load()), [subject, pattern.cls], [])]
        if name in _PLAIN and len(pattern.patterns) == 1 and not pattern.kwd_attrs:
            return self._parts(tests, [(pattern.patterns[0], subject)])
        if name in _PLAIN and not pattern.patterns and not pattern.kwd_attrs:
            return tests, {}
        fields = self._fields.get(name)
        if fields is None or len(fields) < len(pattern.patterns):
            if pattern.patterns or fields is None:
                raise _Unsupported
        given = [*zip(fields or (), pattern.patterns), *zip(pattern.kwd_attrs, pattern.kwd_patterns)]
        return self._parts(tests, [(each, ast.Attribute(subject, attr, ast.Load())) for attr, each in given])

    def _parts(
        self, tests: list[ast.expr], parts: Iterable[tuple[ast.pattern, ast.expr]]
    ) -> tuple[list[ast.expr], dict[str, ast.expr]]:
        bound: dict[str, ast.expr] = {}
        for pattern, subject in parts:
            more, names = self._pattern(subject, pattern)
            tests += more
            bound |= names
        return tests, bound


def _is_display(subject: ast.expr, cases: list[ast.match_case]) -> bool:
    """Return whether a subject is a tuple of items, and each pattern has one part for each of them."""
    if not isinstance(subject, ast.Tuple) or any(isinstance(each, ast.Starred) for each in subject.elts):
        return False
    return all(_fits(each.pattern, len(subject.elts)) for each in cases)


def _captured(cases: list[ast.match_case]) -> set[str]:
    """Return the variables that patterns assign."""
    nodes = walk_tree(*(each.pattern for each in cases))
    names = {n.name for n in nodes if isinstance(n, (ast.MatchAs, ast.MatchStar)) and n.name}
    return names | {n.rest for n in nodes if isinstance(n, ast.MatchMapping) and n.rest}


def _fits(pattern: ast.pattern | None, count: int) -> bool:
    if isinstance(pattern, ast.MatchOr):
        return all(_fits(each, count) for each in pattern.patterns)
    if isinstance(pattern, ast.MatchAs):
        return pattern.pattern is None or _fits(pattern.pattern, count)
    is_row = isinstance(pattern, ast.MatchSequence) and len(pattern.patterns) == count
    return is_row and not any(isinstance(each, ast.MatchStar) for each in pattern.patterns)  # type: ignore[union-attr]


def _all(tests: list[ast.expr]) -> ast.expr:
    return ast.BoolOp(ast.And(), tests) if len(tests) > 1 else tests[0]


def _fresh(node: Any) -> Any:
    """Return a copy in which no node occurs twice: the types of a subject depend on where it is."""
    if isinstance(node, list):
        return [_fresh(each) for each in node]
    if not isinstance(node, ast.AST):
        return node
    made = type(node)(**{name: _fresh(value) for name, value in ast.iter_fields(node)})
    return ast.copy_location(made, node)
