"""Lists of shapes in functions of a program, and what their loops do with them."""

from __future__ import annotations

import ast

from scenelang.interpreter.transpile.analysis.rewriting import is_registering

_GROWN = ("append", "extend")

# What a loop does with the lists of a function is decided by the text of the function: a list that is only added to,
# and whose items only become shapes, may contain all turns of a loop as one shape.


class ListUsage:
    """Lists of shapes in a function.

    Attributes
    ----------
    lists
        Names of lists that are only added to, and whose items only become a shape.
    frames
        Those of the lists whose items become the frames of an animation.
    grown
        For each loop that only adds shapes to lists: the names of the lists.
    stored
        For each such loop: the names that it assigns.
    bodies
        For each such loop: its body, with conditions in place of ``continue``.
    yielding
        Loops of a registered function that yield its frames.
    spread
        Comprehensions whose items only become a shape.
    """

    def __init__(self, function: ast.FunctionDef, is_called: bool) -> None:
        self.grown: dict[ast.For, set[str]] = {}
        self.stored: dict[ast.For, set[str]] = {}
        self._function = function
        self._is_animation = any(is_registering(each, "register_animation") for each in function.decorator_list)
        self.spread: set[ast.AST] = set()
        self.yielding: set[ast.For] = set()
        self.bodies: dict[ast.For, list[ast.stmt]] = {}
        self._is_registered = not is_called and any(is_registering(each) for each in function.decorator_list)
        self._parents: dict[ast.AST, ast.AST] = {
            child: node for node in ast.walk(function) for child in ast.iter_child_nodes(node)
        }
        # with nested functions: a list that one of them uses is not only added to
        names: dict[str, list[ast.Name]] = {}
        for node in ast.walk(function):
            if isinstance(node, ast.Name):
                names.setdefault(node.id, []).append(node)
        self.lists = {
            name
            for name, nodes in names.items()
            if any(isinstance(node.ctx, ast.Store) for node in nodes) and all(map(self._is_list, nodes))
        }
        returned = [each for each in ast.walk(function) if isinstance(each, ast.Return) and self._is_animation]
        self.frames = {each.value.id for each in returned if isinstance(each.value, ast.Name)} & self.lists
        for node in ast.walk(function):
            if isinstance(node, ast.For):
                self._add(node)
            elif isinstance(node, (ast.ListComp, ast.GeneratorExp)) and self._is_spread(node):
                self.spread.add(node)

    def may_keep(self, node: ast.For) -> bool:
        """Return whether a loop may remain."""
        return bool(self.grown.get(node)) or node in self.yielding

    def _add(self, node: ast.For) -> None:
        inner = [each for statement in node.body for each in ast.walk(statement)]
        yields = {each.value for each in inner if isinstance(each, ast.Expr) and isinstance(each.value, ast.Yield)}
        if node.orelse or any(isinstance(each, _LEAVING) and each not in yields for each in inner):
            return
        if yields and not self._is_registered:
            return
        self.bodies[node] = _nested(node.body)
        stores = [each for each in [*inner, *ast.walk(node.target)] if _is_stored(each)]
        names = {each: str(getattr(each, "id", "")) for each in stores}
        added = {_grown_name(each) for each in inner if _is_growth(each)}
        added |= {name for each, name in names.items() if isinstance(self._parents[each], ast.AugAssign)}
        assigned = {name for each, name in names.items() if not isinstance(self._parents[each], ast.AugAssign)}
        stored = {*names.values()}
        read = {each.id for each in inner if isinstance(each, ast.Name) and self._is_read(each)}
        lists = (added & self.lists) - assigned
        if lists & read:
            return  # a turn looks at what the turns before have added
        self.grown[node], self.stored[node] = lists, stored
        if yields:
            self.yielding.add(node)

    def _is_read(self, node: ast.Name) -> bool:
        return isinstance(node.ctx, ast.Load) and not _is_growth(self._parents.get(node))

    def _is_own(self, node: ast.AST) -> bool:
        """Return whether a node is in the function itself, not in one inside of it."""
        parent = self._parents.get(node)
        while parent is not None and not isinstance(parent, (ast.FunctionDef, ast.Lambda)):
            parent = self._parents.get(parent)
        return parent is self._function

    def _is_list(self, node: ast.Name) -> bool:
        parent = self._parents.get(node)
        if not self._is_own(node):
            return False
        if isinstance(node.ctx, ast.Store):
            if isinstance(parent, ast.AugAssign):
                return isinstance(parent.op, ast.Add)
            value = self._assigned(node)
            return isinstance(value, (ast.List, ast.ListComp))
        if _is_growth(parent):
            call = self._parents.get(parent) if parent is not None else None
            return isinstance(call, ast.Call) and isinstance(self._parents.get(call), ast.Expr)
        return self._is_whole(node)

    def _assigned(self, node: ast.Name) -> ast.expr | None:
        """Return the expression whose value a name becomes, None if that is not plain."""
        parent = self._parents.get(node)
        if isinstance(parent, (ast.Assign, ast.AnnAssign)):
            return parent.value
        assignment = self._parents.get(parent) if isinstance(parent, ast.Tuple) else None
        if isinstance(assignment, ast.Assign) and isinstance(assignment.value, ast.Tuple):
            assert isinstance(parent, ast.Tuple)
            place = parent.elts.index(node)
            return assignment.value.elts[place] if len(assignment.value.elts) == len(parent.elts) else None
        return None

    def _is_whole(self, node: ast.AST) -> bool:
        """Return whether all items of a list become one shape, or the frames of an animation."""
        parent = self._parents.get(node)
        if isinstance(parent, ast.Return):
            return self._is_registered
        call = self._parents.get(parent) if isinstance(parent, ast.Starred) else None
        return isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "concat_shapes"

    def _is_spread(self, node: ast.ListComp | ast.GeneratorExp) -> bool:
        if self._is_animation and len(node.generators) > 1:
            return False  # each item may be a frame
        if self._is_whole(node):
            return not isinstance(node, ast.GeneratorExp) or not isinstance(self._parents.get(node), ast.Return)
        parent = self._parents.get(node)
        if isinstance(node, ast.GeneratorExp):
            return False
        if isinstance(parent, ast.AugAssign):
            return isinstance(parent.target, ast.Name) and parent.target.id in self.lists
        if isinstance(parent, ast.Assign):
            return all(isinstance(each, ast.Name) and each.id in self.lists for each in parent.targets)
        method = parent.func if isinstance(parent, ast.Call) else None
        is_extended = isinstance(method, ast.Attribute) and method.attr == "extend"
        return is_extended and method is not None and _grown_name(method) in self.lists


def _nested(body: list[ast.stmt]) -> list[ast.stmt]:
    """Return the body of a loop with the rest under a condition in place of ``if ...: continue``."""
    for place, statement in enumerate(body):
        if isinstance(statement, ast.If) and not statement.orelse and isinstance(statement.body[-1], ast.Continue):
            rest = _nested(body[place + 1 :])
            if len(statement.body) > 1 or not rest:
                return body
            test = ast.copy_location(ast.UnaryOp(ast.Not(), statement.test), statement.test)
            return [*body[:place], ast.copy_location(ast.If(test, rest, []), statement)]
    return body


_LEAVING = (ast.Return, ast.Break, ast.Yield, ast.YieldFrom, ast.Try, ast.With, ast.Global, ast.Nonlocal, ast.While)


def leaves(statement: ast.stmt) -> bool:
    return any(isinstance(each, (*_LEAVING, ast.Continue)) for each in ast.walk(statement))


def _is_stored(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)


def _is_growth(node: ast.AST | None) -> bool:
    return isinstance(node, ast.Attribute) and node.attr in _GROWN and isinstance(node.value, ast.Name)


def _grown_name(node: ast.AST) -> str:
    return node.value.id if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) else ""
