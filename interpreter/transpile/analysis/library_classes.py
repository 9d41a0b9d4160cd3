"""Values of libraries as objects of classes of the program: complex numbers, frozen sets, iterators, and rotations.

A frozen set is one where a program has it as an item or a key, an iterator one from which the program takes items by
`next`. What else a program does with them is then an error of the translation.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable

from scenelang.interpreter.transpile.analysis.inlining import is_endless, is_generator
from scenelang.interpreter.transpile.analysis.library import COMPLEX, FROZEN_SET, ITERATORS
from scenelang.interpreter.transpile.analysis.library_rotations import with_rotations
from scenelang.interpreter.transpile.analysis.python_text import variable_of, walk_tree
from scenelang.interpreter.transpile.analysis.rewriting import is_annotation, parents_of, placed

PathOf = Callable[[ast.AST], "str | None"]
_COMPLEX_CALLS = {
    "cmath.rect": "complex_rect", "cmath.phase": "complex_phase", "cmath.polar": "complex_polar",
    "cmath.exp": "complex_exp", "cmath.sqrt": "complex_sqrt",
}  # fmt: skip
_COMPLEX_NUMBERS = ("cmath.pi", "cmath.tau", "cmath.e")
_CLASSES = {"iter": "ListIterator", "itertools.count": "CountIterator", "itertools.cycle": "CycleIterator"}
_EATERS = ("list", "tuple", "set", "sum", "sorted", "min", "max", "any", "all")
_CHANGING = (
    "append",
    "extend",
    "insert",
    "pop",
    "remove",
    "clear",
    "add",
    "update",
    "appendleft",
    "popleft",
    "discard",
)


def with_library_classes(tree: ast.Module, path_of: PathOf) -> list[ast.stmt]:
    """Write such values, in place, as objects; return the classes of these."""
    sources = [
        *_frozen_sets(tree), *_complex_numbers(tree, path_of), *_iterators(tree, path_of),
        *with_rotations(tree, path_of),
    ]  # fmt: skip
    return [each for source in sources for each in ast.parse(source).body]


def _names(tree: ast.Module, name: str) -> list[ast.Name]:
    return [n for n in walk_tree(tree) if isinstance(n, ast.Name) and n.id == name]


# --- frozen sets ----------------------------------------------------------------------------------------------------


def _frozen_sets(tree: ast.Module) -> list[str]:
    parents = parents_of(tree)
    uses = [n for n in _names(tree, "frozenset") if not is_annotation(n, parents)]
    calls = [parents[n] for n in uses]
    is_called = all(
        isinstance(c, ast.Call) and c.func is n and len(c.args) < 2 and not c.keywords for n, c in zip(uses, calls)
    )
    if not is_called or all(_is_collection(c, parents) for c in calls):
        return []
    for use in uses:
        use.id = "frozen_set"
    for node in walk_tree(tree):
        if isinstance(node, ast.Compare) and isinstance(node.left, ast.Set):
            if len(node.ops) == 1 and isinstance(node.ops[0], (ast.In, ast.NotIn)):  # which a frozen set may equal
                items = ast.List(node.left.elts, ast.Load())
                node.left = placed(ast.Call(ast.Name("frozen_set", ast.Load()), [items], []), node.left)
    return [FROZEN_SET]


def _is_collection(call: ast.AST, parents: dict[ast.AST, ast.AST]) -> bool:
    """Return whether a frozen set is only asked for its members: it is a constant, or on the right of ``in``."""
    parent = parents[call]
    if isinstance(parent, ast.Compare):
        return parent.left is not call
    return isinstance(parent, (ast.Assign, ast.AnnAssign)) and isinstance(parents[parent], ast.Module)


# --- complex numbers ------------------------------------------------------------------------------------------------


def _complex_numbers(tree: ast.Module, path_of: PathOf) -> list[str]:
    nodes = walk_tree(tree)
    paths = [path for n in nodes if (path := path_of(n) or "").startswith("cmath.")]
    literals = [n for n in nodes if isinstance(n, ast.Constant) and type(n.value) is complex]
    parents = parents_of(tree)
    names = [n for n in _names(tree, "complex") if not is_annotation(n, parents)]
    is_number = all(_makes_complex(parents[n], n) for n in names)
    if not (paths or literals or names) or not is_number or {*paths} - {*_COMPLEX_CALLS, *_COMPLEX_NUMBERS}:
        return []
    _Complex(path_of).visit(tree)
    return [COMPLEX]


def _makes_complex(parent: ast.AST, name: ast.Name) -> bool:
    """Return whether ``complex`` is the class in a test, or is called for its parts."""
    if not isinstance(parent, ast.Call) or parent.keywords:
        return False
    if parent.func is not name:
        return isinstance(parent.func, ast.Name) and parent.func.id == "isinstance"
    return len(parent.args) == 2 or (len(parent.args) == 1 and isinstance(parent.args[0], ast.Constant))


class _Complex(ast.NodeTransformer):
    """Writes complex numbers and the functions of ``cmath`` by the class of such numbers."""

    def __init__(self, path_of: PathOf) -> None:
        self._path_of = path_of

    def visit_arg(self, node: ast.arg) -> ast.arg:
        return node  # annotations stay

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AnnAssign:
        node.value = self.visit(node.value) if node.value is not None else None
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        returns, node.returns = node.returns, None
        self.generic_visit(node)
        node.returns = returns
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        if type(node.value) is not complex:
            return node
        parts: list[ast.expr] = [ast.Constant(node.value.real), ast.Constant(node.value.imag)]
        return placed(ast.Call(ast.Name("complex_number", ast.Load()), parts, []), node)

    def visit_Name(self, node: ast.Name) -> ast.expr:
        complex_call = _COMPLEX_CALLS.get(self._path_of(node) or "")
        name = "complex_number" if node.id == "complex" else complex_call or node.id
        return ast.copy_location(ast.Name(name, node.ctx), node)

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        path = self._path_of(node) or ""
        if path in _COMPLEX_CALLS:
            return ast.copy_location(ast.Name(_COMPLEX_CALLS[path], ast.Load()), node)
        if path in _COMPLEX_NUMBERS:
            return placed(ast.Attribute(ast.Name("math", ast.Load()), node.attr, ast.Load()), node)
        self.generic_visit(node)
        return node


# --- iterators ------------------------------------------------------------------------------------------------------


def _iterators(tree: ast.Module, path_of: PathOf) -> list[str]:
    nodes = walk_tree(tree)
    if any(isinstance(n, ast.Name) and n.id == "StopIteration" for n in nodes):
        return []  # which the program expects
    generators = {
        n.name for n in tree.body
        if isinstance(n, ast.FunctionDef) and is_generator(n) and not is_endless(n) and is_pure(n)
    }  # fmt: skip
    changed = {*_changed(nodes)}
    parents = parents_of(tree)
    sources: list[str] = []
    for node in nodes:
        target = node.targets[0] if isinstance(node, ast.Assign) and len(node.targets) == 1 else None
        if not isinstance(node, ast.Assign) or not isinstance(target, ast.Name) or not isinstance(node.value, ast.Call):
            continue
        kind = _kind(node.value, path_of, generators)
        given = {n.id for each in node.value.args for n in walk_tree(each) if isinstance(n, ast.Name)}
        if kind is None or (kind != "itertools.count" and given & changed) or not _is_own(target.id, nodes):
            continue
        uses = [n for n in _names(tree, target.id) if n is not target]
        if _is_asked(uses, parents, kind):
            name = f"{_CLASSES[kind]}{len(sources) + 1 if sources else ''}"  # one for each, since its items have a type
            sources.append(ITERATORS[kind].replace(_CLASSES[kind], name))
            _write(node, kind, name, path_of)
            for use in uses:
                _write_use(use, parents)
    return sources


def _changed(nodes: Iterable[ast.AST]) -> Iterable[str]:
    """Iterate over the variables whose lists may change."""
    for node in nodes:
        is_method = isinstance(node, ast.Attribute) and node.attr in _CHANGING
        is_item = isinstance(node, ast.Subscript) and not isinstance(node.ctx, ast.Load)
        variable = variable_of(node) if is_method or is_item else None
        if variable is not None:
            yield variable.id


_PURE = (
    "abs", "all", "any", "divmod", "enumerate", "float", "int", "isinstance", "iter", "len", "list", "max", "min",
    "range", "reversed", "round", "set", "sorted", "str", "sum", "tuple", "zip",
)  # fmt: skip
_READING = (
    "endswith", "isalpha", "isdigit", "islower", "isspace", "isupper", "items", "keys", "lower", "split", "splitlines",
    "startswith", "strip", "upper", "values",
)  # fmt: skip


def is_pure(node: ast.AST, *own: str) -> bool:
    """Return whether it does not matter when the items of an iterator are computed: all that it calls is pure."""
    if isinstance(node, ast.FunctionDef):
        own = (node.name,)
    if any(isinstance(n, (ast.Global, ast.Nonlocal, ast.NamedExpr)) for n in walk_tree(node)):
        return False
    for call in (n.func for n in walk_tree(node) if isinstance(n, ast.Call)):
        if isinstance(call, ast.Name) and call.id in (*_PURE, *own):
            continue
        is_reading = isinstance(call, ast.Attribute) and call.attr in _READING
        if not is_reading and not (isinstance(call, ast.Attribute) and ast.unparse(call.value) == "math"):
            return False
    return True


def _kind(call: ast.Call, path_of: PathOf, generators: set[str]) -> str | None:
    """Return the kind of the iterator that a call makes; a generator of the program is a list to the translation."""
    if isinstance(call.func, ast.Name) and call.func.id in generators:
        return "iter"
    is_iter = isinstance(call.func, ast.Name) and call.func.id == "iter" and len(call.args) == 1
    path = "iter" if is_iter else path_of(call.func)
    return path if path in _CLASSES and all(map(is_pure, call.args)) else None


def _is_own(name: str, nodes: Iterable[ast.AST]) -> bool:
    """Return whether a variable is assigned at one place only."""
    stores = [n for n in nodes if isinstance(n, ast.Name) and n.id == name and not isinstance(n.ctx, ast.Load)]
    return len(stores) == 1 and not any(isinstance(n, ast.arg) and n.arg == name for n in nodes)


def _is_asked(uses: list[ast.Name], parents: dict[ast.AST, ast.AST], kind: str) -> bool:
    """Return whether a program takes items of an iterator by ``next``, and does nothing else that matters."""
    ways = [_use(each, parents) for each in uses]
    return "next" in ways and all(each == "next" or (each and kind == "iter") for each in ways)


def _use(name: ast.Name, parents: dict[ast.AST, ast.AST]) -> str:
    parent = parents[name]
    if isinstance(parent, ast.Call) and isinstance(parent.func, ast.Name) and parent.args and parent.args[0] is name:
        if parent.func.id == "next" and not parent.keywords:
            return "next"
        return "rest" if parent.func.id in _EATERS and len(parent.args) == 1 else ""
    if isinstance(parent, ast.For) and parent.iter is name and not parent.orelse:
        return "loop"
    return "rest" if isinstance(parent, (ast.comprehension, ast.Starred)) else ""


def _write(node: ast.Assign, kind: str, name: str, path_of: PathOf) -> None:
    """Write the call that makes an iterator, in place."""
    call = node.value
    assert isinstance(call, ast.Call)
    if kind != "itertools.count":
        is_made = path_of(call.func) == kind or (isinstance(call.func, ast.Name) and call.func.id == "iter")
        items = call.args[0] if is_made else call
        call = ast.Call(call.func, [ast.Call(ast.Name("list", ast.Load()), [items], [])], [])
    call.func = ast.Name(name, ast.Load())
    node.value = placed(call, node)


def _write_use(name: ast.Name, parents: dict[ast.AST, ast.AST]) -> None:
    """Write a use of an iterator as a method call, in place: ``next``, a loop, or all remaining items."""
    use, parent = _use(name, parents), parents[name]
    if use == "next" and isinstance(parent, ast.Call):
        method = "following" if len(parent.args) == 1 else "following_or"
        parent.func = placed(ast.Attribute(name, method, ast.Load()), parent)
        parent.args = parent.args[1:]
        return
    if use == "loop" and isinstance(parent, ast.For):
        owner = parents[parent]
        test = ast.Call(ast.Attribute(ast.Name(name.id, ast.Load()), "has_next", ast.Load()), [], [])
        first = ast.Assign([parent.target], _method(name, "following"))
        loop = placed(ast.While(test, [first, *parent.body], []), parent)
        for _, block in ast.iter_fields(owner):
            if isinstance(block, list):
                block[:] = [loop if each is parent else each for each in block]
        # later uses in the loop look up their parents
        for child in parent.body:
            parents[child] = loop
        return
    rest = placed(_method(name, "rest"), name)
    for field, value in ast.iter_fields(parent):
        if value is name:
            setattr(parent, field, rest)
        elif isinstance(value, list):
            value[:] = [rest if each is name else each for each in value]


def _method(name: ast.Name, method: str) -> ast.Call:
    return ast.Call(ast.Attribute(ast.Name(name.id, ast.Load()), method, ast.Load()), [], [])
