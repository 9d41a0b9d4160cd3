"""Which library function or module a Python name means, also where its import is missing."""

from __future__ import annotations

import ast
import builtins

from scenelang.interpreter.transpile.analysis.scopes import Names

MODULES = {
    "np": "numpy", "numpy": "numpy", "math": "math", "random": "random", "helper": "helper", "itertools": "itertools",
    "functools": "functools", "collections": "collections", "colorsys": "colorsys", "operator": "operator",
    "copy": "copy",
    "numpy.random": "numpy.random", "numpy.linalg": "numpy.linalg", "dataclasses": "dataclasses", "typing": "typing",
}  # fmt: skip

# Names that only annotations use.
ANNOTATIONS = frozenset({
    "P", "T", "Shape", "Generator", "Iterator", "Iterable", "Callable", "List", "Tuple", "Dict", "Set", "Optional",
    "Any",
    "Union", "Sequence", "Literal", "NamedTuple", "TypeVar", "Point", "Color", "ndarray",
})  # fmt: skip

FORBIDDEN = {
    "os": "the operating system", "sys": "the interpreter", "subprocess": "other programs", "shutil": "files",
    "pathlib": "files", "socket": "the network", "requests": "the network", "urllib": "the network",
    "http": "the network",
    "pickle": "files", "importlib": "Python modules", "builtins": "the interpreter", "ctypes": "the interpreter",
    "threading": "threads", "multiprocessing": "other programs", "asyncio": "the network", "inspect": "the interpreter",
    "io": "files", "tempfile": "files", "glob": "files", "signal": "the operating system", "gc": "the interpreter",
    "open": "files", "eval": "Python code", "exec": "Python code", "compile": "Python code",
    "__import__": "Python modules",
    "globals": "the interpreter", "locals": "the interpreter", "vars": "the interpreter", "input": "the keyboard",
    "getattr": "attributes by name", "setattr": "attributes by name", "delattr": "attributes by name",
    "breakpoint": "the debugger", "memoryview": "memory", "exit": "the interpreter", "quit": "the interpreter",
    "dir": "the interpreter", "help": "the interpreter", "id": "the interpreter", "super": "inheritance",
    "classmethod": "class methods", "object": "classes", "type": "classes", "hash": "the interpreter",
}  # fmt: skip

BUILTINS = frozenset(name for name in dir(builtins) if not name.startswith("_"))


class Paths:
    """Dotted paths of the names in one program."""

    def __init__(self, names: Names) -> None:
        self._names = names

    def of(self, node: ast.expr) -> str | None:
        """``numpy.sin``, ``len``, ``library_call``: what ``node`` means, None for values of the program."""
        if isinstance(node, ast.Name):
            variable = self._names.variables.get(node)
            if variable is None:
                return MODULES.get(node.id, node.id)
            path = self._names.imports.get(variable)
            if path is None or len(variable.stores) > 1:
                return None
            return MODULES.get(path, path.removeprefix("helper."))
        if isinstance(node, ast.Attribute):
            base = self.of(node.value)
            if base is None or not is_module(base):
                return None
            return f"{base}.{node.attr}".removeprefix("helper.")
        return None


def is_module(path: str) -> bool:
    return path in _MODULE_PATHS or (path in FORBIDDEN and path.islower())


_MODULE_PATHS = frozenset(MODULES.values()) | {"typing", "collections.abc", "itertools.chain"}


def is_annotation(paths: Paths, node: ast.expr) -> bool:
    """Whether a value is only a type, as in ``Color = Tuple[float, float, float]``."""
    if isinstance(node, ast.Subscript):
        return is_annotation(paths, node.value) and not isinstance(node.value, ast.Subscript)
    if isinstance(node, ast.Call):
        return (paths.of(node.func) or "").removeprefix("typing.") in ("TypeVar", "NewType")
    path = (paths.of(node) or "").removeprefix("typing.")
    return path in ANNOTATIONS or path == "numpy.ndarray"
