"""Generators and context managers of the program in the place where they are used.

A generator is a list to the translation. Where that makes a difference (the generator is endless, or the loop over it
changes what it looks at), its statements take the place of the loop, whose body takes the place of ``yield``; one that
calls itself gets the body as a function. ``with`` becomes the statements of the manager around those of its body.
"""

from __future__ import annotations

import ast
import copy
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from scenelang.interpreter.transpile.analysis.python_text import child_nodes, scope_of, walk_tree
from scenelang.interpreter.transpile.analysis.rewriting import (
    Substitution,
    free_name,
    is_sized,
    name_of,
    names_in,
    placed,
)

_MANAGERS = ("contextmanager", "contextlib.contextmanager")
_HARMLESS = ("errstate", "printoptions", "nullcontext")  # managers of the library that change no result


class _Impossible(Exception):
    """A use cannot be written in place."""


def with_generators_in_place(tree: ast.Module, is_meant: Callable[[ast.expr], bool]) -> ast.Module | None:
    """Return a module in which loops over its own generators are written in place; None if there are none.

    ``is_meant`` says which loops, by what they iterate over; loops over endless generators always are.
    """
    inliner = _Generators(_Delegations().visit(copy.deepcopy(tree)), is_meant)
    tree = inliner.visit(inliner.tree)
    return inliner.finished(tree) if inliner.count else None


def without_managers(tree: ast.Module) -> ast.Module:
    """Write the ``with`` statements of a module, in place, as what they do."""
    managers = _Managers(tree)
    tree = managers.visit(tree)
    return managers.finished(tree)


# --- functions ------------------------------------------------------------------------------------------------------


def _functions_of(tree: ast.Module) -> dict[str, ast.FunctionDef | None]:
    """Return the functions and methods of a module by name; None for names that several have."""
    functions: dict[str, ast.FunctionDef | None] = {}
    for node in walk_tree(tree):
        if isinstance(node, ast.FunctionDef):
            functions[node.name] = None if node.name in functions else node
    return functions


class _Inlining(ast.NodeTransformer):
    """What both have in common: the function that a call means, and its body for the arguments."""

    def __init__(self, tree: ast.Module) -> None:
        self.tree = tree
        self.functions = _functions_of(tree)
        self.methods = {
            m.name
            for cls in walk_tree(tree)
            if isinstance(cls, ast.ClassDef)
            for m in cls.body
            if isinstance(m, ast.FunctionDef)
        }
        self.taken = names_in(tree)
        self.count = 0

    def called(self, node: ast.expr) -> ast.FunctionDef | None:
        """Return the function of the program that a call calls, if there is no doubt about it."""
        if not isinstance(node, ast.Call):
            return None
        if isinstance(node.func, ast.Name):
            function = self.functions.get(node.func.id)
            return function if node.func.id not in self.methods else None
        if isinstance(node.func, ast.Attribute) and node.func.attr in self.methods:
            return self.functions.get(node.func.attr)
        return None

    def fresh(self, name: str) -> str:
        """Return a name that nothing has, and take it."""
        return free_name(name, self.taken)

    def body_for(self, function: ast.FunctionDef, call: ast.Call, stored: set[str]) -> list[ast.stmt]:
        """Return the body of a function for the arguments of a call: assignments of these come first.

        ``stored`` are the variables that what takes the place of ``yield`` assigns.
        """
        given = function.args
        if given.kwarg or given.posonlyargs or any(isinstance(a, ast.Starred) for a in call.args):
            raise _Impossible
        names = [each.arg for each in given.args]
        values: dict[str, ast.expr] = {}
        arguments = list(call.args)
        if isinstance(call.func, ast.Attribute):
            arguments.insert(0, call.func.value)
        if (len(arguments) > len(names) and not given.vararg) or any(k.arg is None for k in call.keywords):
            raise _Impossible
        values |= dict(zip(names, arguments))
        if given.vararg:
            values[given.vararg.arg] = ast.Tuple(arguments[len(names) :], ast.Load())
        values |= {str(k.arg): k.value for k in call.keywords}
        defaults = dict(zip(names[len(names) - len(given.defaults) :], given.defaults))
        defaults |= {a.arg: d for a, d in zip(given.kwonlyargs, given.kw_defaults) if d is not None}
        everything = [*names, *(a.arg for a in given.kwonlyargs), *([given.vararg.arg] if given.vararg else [])]
        if set(values) - set(everything) or any(name not in values | defaults for name in everything):
            raise _Impossible
        local = scope_of(function)[0]
        assigned = {
            n.id for n in walk_tree(*function.body) if isinstance(n, ast.Name) and not isinstance(n.ctx, ast.Load)
        }
        known: dict[str, ast.expr] = {}
        before: list[ast.stmt] = []
        for name in everything:
            value = values.get(name, defaults.get(name))
            assert value is not None
            is_stable = isinstance(value, ast.Constant) or (isinstance(value, ast.Name) and value.id not in stored)
            if is_stable and name not in assigned:
                known[name] = value
                continue
            made = self.fresh(name)
            known[name] = ast.Name(made, ast.Load())
            before.append(ast.copy_location(ast.Assign([ast.Name(made, ast.Store())], copy.deepcopy(value)), call))
        known |= {name: ast.Name(self.fresh(name), ast.Load()) for name in sorted(local - set(everything))}
        body = [Substitution(known).visit(each) for each in copy.deepcopy(function.body)]
        if body and isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant):
            body = body[1:]
        return [*before, *body]


def _placed(statements: Sequence[ast.stmt], origin: ast.AST) -> list[ast.stmt]:
    for each in statements:
        placed(each, origin)
    return [*statements]


def _own(body: Iterable[ast.AST], *kinds: type) -> Iterator[ast.AST]:
    """Iterate over the nodes of some kinds that belong to a loop or function itself, not to one inside."""
    pending = list(body)
    while pending:
        node = pending.pop()
        if isinstance(node, kinds):
            yield node
        if isinstance(node, (ast.For, ast.While)) and (ast.Break in kinds or ast.Continue in kinds):
            pending += node.orelse
        elif not isinstance(node, (ast.FunctionDef, ast.Lambda, ast.ClassDef)):
            pending += child_nodes(node)


def _stored_in(statements: Iterable[ast.AST]) -> set[str]:
    return {n.id for n in walk_tree(*statements) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}


# --- generators -----------------------------------------------------------------------------------------------------


def is_endless(function: ast.FunctionDef) -> bool:
    """Return whether a generator has a loop that nothing ends."""
    loops = (each for each in walk_tree(function) if isinstance(each, (ast.While, ast.For)))
    return is_generator(function) and any(
        _goes_on(each) and not [*_own(each.body, ast.Break, ast.Return)] for each in loops
    )  # fmt: skip


def _goes_on(loop: ast.While | ast.For) -> bool:
    """Return whether nothing but its body ends a loop."""
    if isinstance(loop, ast.For):
        return isinstance(loop.iter, ast.Call) and name_of(loop.iter) == "count"
    return isinstance(loop.test, ast.Constant) and bool(loop.test.value)


def is_generator(function: ast.FunctionDef) -> bool:
    return any(True for _ in _own(function.body, ast.Yield, ast.YieldFrom))


class _Delegations(ast.NodeTransformer):
    """Writes ``yield from (x for y in z)`` as the loop that it is."""

    def visit_Expr(self, node: ast.Expr) -> ast.stmt:
        inner = node.value.value if isinstance(node.value, ast.YieldFrom) else None
        if not isinstance(inner, ast.GeneratorExp):
            return node
        body: ast.stmt = ast.Expr(ast.Yield(inner.elt))
        for clause in reversed(inner.generators):
            for test in reversed(clause.ifs):
                body = ast.If(test, [body], [])
            body = ast.For(clause.target, clause.iter, [body], [])
        return placed(body, node)


class _Generators(_Inlining):
    """Writes loops over generators of the program in place."""

    def __init__(self, tree: ast.Module, is_meant: Callable[[ast.expr], bool]) -> None:
        super().__init__(tree)
        self._is_meant = is_meant
        self._made: list[tuple[ast.FunctionDef, ast.FunctionDef]] = []
        self._scopes: list[ast.AST] = [tree]

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        self._scopes.append(node)
        self.generic_visit(node)
        self._scopes.pop()
        return node

    def visit_For(self, node: ast.For) -> Any:
        """Write a loop over a generator of the program without the generator, if possible."""
        if node.orelse or self._generator(node.iter) is None:
            self.generic_visit(node)
            return node
        counted = self._counted(node)
        if counted is not None:
            return [part for each in _placed(counted, node) for part in _listed(self.visit(each))]
        self.generic_visit(node)
        function = self.called(node.iter)
        if function is None:
            return node
        assert isinstance(node.iter, ast.Call)
        # in place gives shorter code; a function also allows several `yield` statements and recursion
        for way in (self._in_place, self._by_function):
            try:
                made = way(node, node.iter, function)
            except _Impossible:
                continue
            self.count += 1
            return _placed(made, node)
        return node

    def _generator(self, node: ast.expr) -> ast.FunctionDef | None:
        """Return the generator whose items an expression gives, if loops over it are to be written in place."""
        function = self.called(node)
        if function is not None and is_generator(function):
            return function if is_endless(function) or self._is_meant(node) else None
        is_wrapped = isinstance(node, ast.Call) and name_of(node) in ("enumerate", "islice") and node.args
        return self._generator(node.args[0]) if is_wrapped and isinstance(node, ast.Call) else None

    def _counted(self, node: ast.For) -> list[ast.stmt] | None:
        """Return a loop over the first items of a generator, or over its items by number, as one over the generator."""
        call = node.iter
        if not isinstance(call, ast.Call) or name_of(call) not in ("enumerate", "islice"):
            return None
        name = self.fresh("number" if name_of(call) == "enumerate" else "left")
        stored, loaded = ast.Name(name, ast.Store()), ast.Name(name, ast.Load())
        if name_of(call) == "enumerate" and isinstance(node.target, ast.Tuple) and len(node.target.elts) == 2:
            start = call.args[1] if len(call.args) > 1 else ast.Constant(0)
            count = ast.Assign([node.target.elts[0]], loaded)
            step: ast.stmt = ast.Assign([copy.copy(stored)], ast.BinOp(copy.copy(loaded), ast.Add(), ast.Constant(1)))
            loop = ast.For(node.target.elts[1], call.args[0], [count, step, *node.body], [])
            return [ast.Assign([stored], start), loop]
        if name_of(call) != "islice" or len(call.args) != 2 or any(True for _ in _own(node.body, ast.Continue)):
            return None
        step = ast.Assign([copy.copy(stored)], ast.BinOp(copy.copy(loaded), ast.Sub(), ast.Constant(1)))
        end = ast.If(ast.Compare(copy.copy(loaded), [ast.LtE()], [ast.Constant(0)]), [ast.Break()], [])
        loop = ast.For(node.target, call.args[0], [*node.body, step, end], [])
        some = ast.Compare(loaded, [ast.Gt()], [ast.Constant(0)])
        return [ast.Assign([stored], call.args[1]), ast.If(some, [loop], [])]

    def visit_Assign(self, node: ast.Assign) -> Any:
        """Write a list of the items of a generator as a loop that appends them."""
        target, value = node.targets[0], node.value
        if len(node.targets) > 1 or not isinstance(target, ast.Name):
            return node
        if isinstance(value, ast.Call) and name_of(value) == "list" and len(value.args) == 1:
            item = self.fresh("item")
            clause = ast.comprehension(ast.Name(item, ast.Store()), value.args[0], [], 0)
            value = ast.ListComp(ast.Name(item, ast.Load()), [clause])
        if not isinstance(value, ast.ListComp) or len(value.generators) > 1:
            return node
        clause = value.generators[0]
        if self._generator(clause.iter) is None:
            return node
        append = ast.Attribute(ast.Name(target.id, ast.Load()), "append", ast.Load())
        body: list[ast.stmt] = [ast.Expr(ast.Call(append, [value.elt], []))]
        for test in clause.ifs:
            body = [ast.If(test, body, [])]
        loop = ast.For(clause.target, clause.iter, body, [])
        made = _placed([ast.Assign([target], ast.List([], ast.Load())), loop], node)
        return [made[0], *_listed(self.visit(made[1]))]

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Write the first items of an endless generator as the call of a function that makes a list of them."""
        self.generic_visit(node)
        name, given = name_of(node), node.args
        if name == "islice" and len(given) == 2:
            return self._taken(given[0], given[1]) or node
        if name == "takewhile" and len(given) == 2:
            return self._taken(given[1], given[0], is_test=True) or node
        if name == "zip":
            sized = [each for each in given if self._generator(each) is None and is_sized(each)]
            for n, each in enumerate(given):
                if sized and self._generator(each) is not None:
                    size = ast.Call(ast.Name("len", ast.Load()), [copy.deepcopy(sized[0])], [])
                    given[n] = self._taken(each, ast.copy_location(size, each)) or each
        return node

    def _taken(self, call: ast.expr, limit: ast.expr, *, is_test: bool = False) -> ast.expr | None:
        """Return a call that lists the items of an endless generator up to a count or test; None if impossible."""
        function = self.called(call)
        if function is None or function not in self.tree.body or not is_endless(function) or not _is_quiet(function):
            return None
        assert isinstance(call, ast.Call)
        stem = f"{function.name}_{'while' if is_test else 'first'}"
        made = next((each for _, each in self._made if each.name == stem), None)
        if made is None:
            parameters = [each.arg for each in (*function.args.args, *function.args.kwonlyargs)]
            inner = f"{function.name}({', '.join(f'{each}={each}' for each in parameters)})"
            taken = names_in(function)
            most, item, taken_items = (free_name(name, taken) for name in ("limit", "item", "items"))
            test = f"if not {most}({item}):\n            break\n        " if is_test else ""
            source = inner if is_test else f"islice({inner}, {most})"
            loop = f"    for {item} in {source}:\n        {test}{taken_items}.append({item})\n"
            text = f"def {stem}({most}):\n    {taken_items} = []\n{loop}    return {taken_items}"
            definition = ast.parse(text).body[0]
            assert isinstance(definition, ast.FunctionDef)
            definition.args.args += copy.deepcopy(function.args.args)
            definition.args.defaults = copy.deepcopy(function.args.defaults)
            definition.args.kwonlyargs = copy.deepcopy(function.args.kwonlyargs)
            definition.args.kw_defaults = copy.deepcopy(function.args.kw_defaults)
            placed(definition, function, is_new=True)
            made = self.visit_FunctionDef(definition)
            # a remaining call is a loop over the generator that could not be written in place
            if any(self.called(n) is function for n in walk_tree(made) if isinstance(n, ast.expr)):
                return None
            self._made.append((function, made))
        new = ast.Call(ast.Name(stem, ast.Load()), [limit, *call.args], call.keywords)
        for each in (new, new.func):
            ast.copy_location(each, call)
        return new

    def _in_place(self, node: ast.For, call: ast.Call, function: ast.FunctionDef) -> list[ast.stmt]:
        """Return the statements of a generator with the body of the loop in place of its ``yield``."""
        yields = [*_own(function.body, ast.Yield, ast.YieldFrom)]
        leaves = [*_own(function.body, ast.Return)]
        calls_itself = any(self.called(n) is function for n in walk_tree(function) if isinstance(n, ast.expr))
        if len(yields) != 1 or isinstance(yields[0], ast.YieldFrom) or leaves or calls_itself:
            raise _Impossible
        body = self.body_for(function, call, _stored_in([node]))
        block, place, path = _place_of_yield(body)
        value = block[place].value.value  # type: ignore[attr-defined]
        breaks = any(True for _ in _own(node.body, ast.Break))
        continues = any(True for _ in _own(node.body, ast.Continue))
        is_last = place == len(block) - 1
        if breaks and not _ends_all(path, body):
            raise _Impossible
        if continues and not (is_last and path and path[-1][1] is block):
            raise _Impossible
        first = ast.Assign([node.target], value if value is not None else ast.Constant(None))
        block[place : place + 1] = [first, *node.body]
        return body

    def _by_function(self, node: ast.For, call: ast.Call, function: ast.FunctionDef) -> list[ast.stmt]:
        """Return the call of a generator that gets the body of the loop as a function."""
        if any(True for _ in _own(node.body, ast.Break)) or any(
            True for _ in _own(node.body, ast.Return, ast.Yield, ast.YieldFrom)
        ):
            raise _Impossible
        scope = self._scopes[-1]
        if not isinstance(scope, ast.FunctionDef) or self._owner(function) is None:
            raise _Impossible
        visit = self.fresh("visit")
        copied = self._with_visitor(function)
        inside = set(walk_tree(node))
        outside = {n.id for n in walk_tree(scope) if isinstance(n, ast.Name) and n not in inside}
        shared = sorted((_stored_in(node.body) | _stored_in([node.target])) & outside)
        body: list[ast.stmt] = [ast.Nonlocal(shared)] if shared else []
        if isinstance(node.target, ast.Name) and node.target.id not in shared:
            parameter = node.target.id
        else:
            parameter = self.fresh("item")
            body.append(ast.Assign([node.target], ast.Name(parameter, ast.Load())))
        body += [_Continues().visit(each) for each in node.body]
        arguments = ast.arguments([], [ast.arg(parameter)], None, [], [], None, [])
        definition = ast.FunctionDef(visit, arguments, body, [], None)
        made = ast.Call(_renamed(call.func, copied.name), [ast.Name(visit, ast.Load()), *call.args], call.keywords)
        return [definition, ast.Expr(made)]

    def _owner(self, function: ast.FunctionDef) -> ast.Module | ast.ClassDef | None:
        """Return the module or class that has a function, None for an inner one, or a method that is decorated."""
        owners: list[ast.Module | ast.ClassDef] = [self.tree]
        owners += [each for each in self.tree.body if isinstance(each, ast.ClassDef)]
        owner = next((each for each in owners if any(part is function for part in each.body)), None)
        return None if isinstance(owner, ast.ClassDef) and function.decorator_list else owner

    def _with_visitor(self, function: ast.FunctionDef) -> ast.FunctionDef:
        """Return a function that passes to its first argument what the generator yields."""
        for known, made in self._made:
            if known is function:
                return made
        copied = copy.deepcopy(function)
        copied.name = self.fresh(f"{function.name}_each")
        copied.args.args.insert(0 if self._owner(function) is self.tree else 1, ast.arg("visit"))
        _Visits(self, function, copied.name).visit(copied)
        _placed([copied], function)
        self._made.append((function, copied))
        return copied

    def finished(self, tree: ast.Module) -> ast.Module:
        """Return the module with the functions that have been made, without generators that nothing uses."""
        for function, made in self._made:
            owner = self._owner(function)
            assert owner is not None
            owner.body.insert(owner.body.index(function) + 1, made)
        owners: list[Any] = [tree, *(each for each in tree.body if isinstance(each, ast.ClassDef))]
        for owner in owners:
            kept = [each for each in owner.body if not (_is_own_generator(each) and not self._is_used(tree, each))]
            owner.body = kept or [ast.copy_location(ast.Pass(), owner)]
        return tree

    @staticmethod
    def _is_used(tree: ast.Module, function: ast.stmt) -> bool:
        inside = set(walk_tree(function))
        return any(
            getattr(n, "id", getattr(n, "attr", None)) == function.name  # type: ignore[attr-defined]
            for n in walk_tree(tree)
            if isinstance(n, (ast.Name, ast.Attribute)) and n not in inside
        )


def _is_own_generator(node: ast.stmt) -> bool:
    is_plain = isinstance(node, ast.FunctionDef) and not node.decorator_list and not node.name.startswith("__")
    return is_plain and isinstance(node, ast.FunctionDef) and is_generator(node)


def _is_quiet(function: ast.FunctionDef) -> bool:
    """Return whether it does not matter when a generator takes its items: it calls no method of what it is given."""
    calls = [n for n in walk_tree(function) if isinstance(n, ast.Call) and isinstance(n.func, ast.Attribute)]
    own = {n.id for n in walk_tree(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    return all(ast.unparse(n.func).partition(".")[0] in {"math", *own} for n in calls)


def _listed(nodes: Any) -> list[Any]:
    return nodes if isinstance(nodes, list) else [nodes]


class _Visits(ast.NodeTransformer):
    """Replaces ``yield`` by calls of the visitor."""

    def __init__(self, inlining: _Generators, function: ast.FunctionDef, name: str) -> None:
        self._inlining, self._function, self._name = inlining, function, name

    def visit_Expr(self, node: ast.Expr) -> ast.stmt:
        visit = ast.Name("visit", ast.Load())
        if isinstance(node.value, ast.Yield):
            value = node.value.value or ast.Constant(None)
            return ast.copy_location(ast.Expr(ast.Call(visit, [value], [])), node)
        if not isinstance(node.value, ast.YieldFrom):
            return node
        inner = node.value.value
        if isinstance(inner, ast.Call) and self._inlining.called(inner) is self._function:
            call = ast.Call(_renamed(inner.func, self._name), [visit, *inner.args], inner.keywords)
            return ast.copy_location(ast.Expr(call), node)
        target = ast.Name(self._inlining.fresh("item"), ast.Store())
        call = ast.Call(visit, [ast.Name(target.id, ast.Load())], [])
        return ast.copy_location(ast.For(target, inner, [ast.Expr(call)], []), node)

    def visit_Yield(self, node: ast.Yield) -> ast.expr:
        raise _Impossible

    def visit_Call(self, node: ast.Call) -> ast.expr:
        self.generic_visit(node)
        if self._inlining.called(node) is self._function:
            raise _Impossible
        return node


def _renamed(function: ast.expr, name: str) -> ast.expr:
    """Return a function, or a method of a value, of another name."""
    if isinstance(function, ast.Attribute):
        return ast.copy_location(ast.Attribute(function.value, name, ast.Load()), function)
    return ast.copy_location(ast.Name(name, ast.Load()), function)


class _Continues(ast.NodeTransformer):
    """Replaces ``continue`` of the body of a loop that becomes a function."""

    def visit_Continue(self, node: ast.Continue) -> ast.stmt:
        return ast.copy_location(ast.Return(None), node)

    def visit_For(self, node: ast.For) -> ast.stmt:
        return node

    def visit_While(self, node: ast.While) -> ast.stmt:
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.stmt:
        return node


_Path = list[tuple[ast.stmt, list[ast.stmt]]]


def _place_of_yield(body: list[ast.stmt]) -> tuple[list[ast.stmt], int, _Path]:
    """Return the block and the place of the only ``yield``, and the loops around it with their blocks."""
    path: _Path = []
    block = body
    blocks: list[tuple[ast.stmt, list[ast.stmt]]] = []
    while True:
        for place, statement in enumerate(block):
            if not any(isinstance(n, ast.Yield) for n in walk_tree(statement)):
                continue
            if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Yield):
                return block, place, path
            blocks = [
                (statement, getattr(statement, name))
                for name in ("body", "orelse")
                if isinstance(getattr(statement, name, None), list)
                and any(isinstance(n, ast.Yield) for n in walk_tree(*getattr(statement, name)))
            ]
            break
        if len(blocks) != 1 or isinstance(blocks[0][0], ast.FunctionDef):
            raise _Impossible
        if isinstance(blocks[0][0], (ast.For, ast.While)):
            path.append(blocks[0])
        block, blocks = blocks[0][1], []


def _ends_all(path: _Path, body: list[ast.stmt]) -> bool:
    """Return whether a ``break`` of the innermost loop ends the whole generator."""
    return len(path) == 1 and body[-1] is path[0][0]


# --- context managers -----------------------------------------------------------------------------------------------


class _Managers(_Inlining):
    """Writes ``with`` statements over managers of the program in place."""

    def __init__(self, tree: ast.Module) -> None:
        super().__init__(tree)
        self._classes = {
            cls.name: cls for cls in tree.body if isinstance(cls, ast.ClassDef)
            and {"__enter__", "__exit__"} <= {getattr(m, "name", "") for m in cls.body}
        }  # fmt: skip
        self._used: set[str] = set()

    def visit_With(self, node: ast.With) -> Any:
        first, *rest = node.items
        if rest:
            node.body = [ast.copy_location(ast.With(rest, node.body), node)]
            node.items = [first]
        self.generic_visit(node)
        try:
            return _placed(self._written(node, first.context_expr, first.optional_vars), node)
        except _Impossible:
            return node

    def _written(self, node: ast.With, manager: ast.expr, target: ast.expr | None) -> list[ast.stmt]:
        if (
            isinstance(manager, ast.Call)
            and ast.unparse(manager.func).rpartition(".")[2] in _HARMLESS
            and target is None
        ):
            return node.body
        function = self.called(manager)
        if function is not None and any(ast.unparse(each) in _MANAGERS for each in function.decorator_list):
            assert isinstance(manager, ast.Call)
            before, value, after = self._parts(self.body_for(function, manager, _stored_in(node.body)))
            body = self._left_by(node.body, after)
            self.count += 1
            stores: list[ast.stmt] = [ast.Assign([target], value or ast.Constant(None))] if target is not None else []
            return [*before, *stores, *body]
        return self._by_methods(node, manager, target)

    def _left_by(self, body: list[ast.stmt], after: list[ast.stmt]) -> list[ast.stmt]:
        """Return the body of a ``with`` statement with what comes after it, wherever it is left."""
        if not after:
            return body
        if any(True for _ in _own(body, ast.Yield, ast.YieldFrom)):
            raise _Impossible
        leaving = _Leaving(after, self.fresh)
        written = [part for each in body for part in _listed(leaving.visit(each))]
        is_left = bool(body) and isinstance(body[-1], (ast.Return, ast.Break, ast.Continue))
        return written if is_left else [*written, *after]

    @staticmethod
    def _parts(body: list[ast.stmt]) -> tuple[list[ast.stmt], ast.expr | None, list[ast.stmt]]:
        """Return what comes before the ``yield`` of a manager, its value, and what comes after."""
        for place, statement in enumerate(body):
            if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Yield):
                return body[:place], statement.value.value, body[place + 1 :]
            if isinstance(statement, ast.Try) and not statement.handlers and not statement.orelse:
                before, value, after = _Managers._parts(statement.body)
                return [*body[:place], *before], value, [*after, *statement.finalbody, *body[place + 1 :]]
            if any(isinstance(n, (ast.Yield, ast.Return)) for n in walk_tree(statement)):
                break
        raise _Impossible

    def _by_methods(self, node: ast.With, manager: ast.expr, target: ast.expr | None) -> list[ast.stmt]:
        """Return the calls of the methods of a manager around the body."""
        name = manager.func.id if isinstance(manager, ast.Call) and isinstance(manager.func, ast.Name) else ""
        is_variable = isinstance(manager, ast.Name) and len(self._classes) == 1
        if name not in self._classes and not is_variable:
            raise _Impossible
        cls = self._classes[name] if name else next(iter(self._classes.values()))
        leave = next(m for m in cls.body if isinstance(m, ast.FunctionDef) and m.name in ("__exit__", "exit"))
        given = [each.arg for each in leave.args.args[1:]]
        given += [leave.args.vararg.arg] if leave.args.vararg else []
        if any(isinstance(n, ast.Name) and n.id in given for n in walk_tree(*leave.body)):
            raise _Impossible  # it looks at the exception
        self._used.add(cls.name)
        before: list[ast.stmt] = []
        held = manager
        if not is_variable:
            held = ast.Name(self.fresh("manager"), ast.Load())
            before.append(ast.Assign([ast.Name(held.id, ast.Store())], manager))
        enter = ast.Call(ast.Attribute(held, "__enter__", ast.Load()), [], [])
        leaving = ast.Call(ast.Attribute(copy.deepcopy(held), "__exit__", ast.Load()), [], [])
        store: ast.stmt = ast.Assign([target], enter) if target is not None else ast.Expr(enter)
        body = self._left_by(node.body, [ast.Expr(leaving)])
        self.count += 1
        return [*before, store, *body]

    def finished(self, tree: ast.Module) -> ast.Module:
        """Return the module without managers that nothing uses any longer; their methods get plain names."""
        used = {n.id for n in walk_tree(tree) if isinstance(n, ast.Name)} | {
            n.attr for n in walk_tree(tree) if isinstance(n, ast.Attribute)
        }
        for node in walk_tree(tree):
            body = getattr(node, "body", None)
            if isinstance(body, list):
                kept = [
                    each for each in body
                    if not (isinstance(each, ast.FunctionDef) and each.name not in used
                            and any(ast.unparse(d) in _MANAGERS for d in each.decorator_list))
                ]  # fmt: skip
                body[:] = kept or ([ast.copy_location(ast.Pass(), body[0])] if body else [])
        for name in self._used:
            for method in self._classes[name].body:
                if isinstance(method, ast.FunctionDef) and method.name == "__exit__":
                    method.args.args, method.args.vararg = method.args.args[:1], None
        for node in walk_tree(tree):
            if isinstance(node, ast.Attribute) and node.attr in ("__enter__", "__exit__"):
                node.attr = node.attr.strip("_")
            if isinstance(node, ast.FunctionDef) and node.name in ("__enter__", "__exit__") and self._used:
                node.name = node.name.strip("_")
        return tree


class _Leaving(ast.NodeTransformer):
    """Writes what a manager does at its end before each statement that leaves its body."""

    def __init__(self, after: list[ast.stmt], fresh: Callable[[str], str]) -> None:
        self._after, self._fresh = after, fresh
        self._loops = 0

    def visit_Return(self, node: ast.Return) -> list[ast.stmt]:
        after = copy.deepcopy(self._after)
        if node.value is None or isinstance(node.value, ast.Constant):
            return [*after, node]
        name = self._fresh("result")
        kept = ast.copy_location(ast.Assign([ast.Name(name, ast.Store())], node.value), node)
        return [kept, *after, ast.copy_location(ast.Return(ast.Name(name, ast.Load())), node)]

    def _left(self, node: Any) -> list[ast.stmt]:
        return [node] if self._loops else [*copy.deepcopy(self._after), node]

    visit_Break = visit_Continue = _left

    def _loop(self, node: Any) -> ast.AST:
        self._loops += 1
        self.generic_visit(node)
        self._loops -= 1
        return node  # type: ignore[no-any-return]

    visit_For = visit_While = _loop

    def _inner(self, node: Any) -> ast.AST:
        return node  # type: ignore[no-any-return]

    visit_FunctionDef = visit_Lambda = visit_ClassDef = _inner
