"""Name resolution of the Python program: its variables, functions and classes."""

from __future__ import annotations

import ast
import builtins
from dataclasses import dataclass, field
from typing import TypeAlias

from scenelang.interpreter.transpile.analysis.python_text import child_nodes, walk_tree

FunctionNode: TypeAlias = ast.FunctionDef | ast.Lambda | ast.Module
Comprehension: TypeAlias = ast.ListComp | ast.SetComp | ast.GeneratorExp | ast.DictComp
COMPREHENSIONS = (ast.ListComp, ast.SetComp, ast.GeneratorExp, ast.DictComp)


@dataclass(eq=False, slots=True)
class PythonVariable:
    """Variable of a function or the module.

    Attributes
    ----------
    stores
        Nodes that assign it.
    reads, readers
        Number of reads, and the functions that read it.
    is_keyword
        Whether it is a parameter that is passed by keyword.
    is_cell
        Whether it must be assigned in place, because a closure or a later iteration of a loop observes the assignment.
    is_assigned_elsewhere
        Whether another function assigns it.
    functions
        Functions that a ``def`` binds to it.
    record
        Class variable, record variable and field, if it names a field of a record.
    text
        Name or comment for the output.
    """

    name: str
    function: Function | None
    stores: list[ast.AST] = field(default_factory=list)
    reads: int = 0
    readers: set[Function] = field(default_factory=set)
    is_parameter: bool = False
    is_keyword: bool = False
    is_cell: bool = False
    is_assigned_elsewhere: bool = False
    is_temporary: bool = False
    is_comprehension: bool = False
    functions: list[Function] = field(default_factory=list)
    record: tuple[PythonVariable, str, str] | None = None
    text: str = ""

    @property
    def is_captured(self) -> bool:
        """Whether a nested function reads the variable."""
        return any(reader is not self.function for reader in self.readers)


@dataclass(eq=False, slots=True)
class PythonParameter:
    """Parameter of a function.

    ``kind`` is ``plain``, ``rest`` (``*args``), ``keys`` (``**kw``) or ``keyword`` (after ``*``).
    """

    variable: PythonVariable
    default: ast.expr | None
    kind: str
    annotation: ast.expr | None


@dataclass(eq=False, slots=True)
class Function:
    """Function, lambda, method or the module.

    Attributes
    ----------
    word
        Word that a registered function is bound to.
    text
        Text with which it was registered.
    is_called_directly
        Whether it is called as a Python function, not only with ``library_call``.
    is_used_as_value
        Whether it is used other than as a callee.
    """

    node: FunctionNode
    name: str
    parent: Function | None
    variable: PythonVariable | None = None
    parameters: list[PythonParameter] = field(default_factory=list)
    locals: dict[str, PythonVariable] = field(default_factory=dict)
    word: str | None = None
    text: str = ""
    is_animation: bool = False
    is_generator: bool = False
    owner: Class | None = None
    is_static: bool = False
    is_called_directly: bool = False
    is_used_as_value: bool = False
    named_arguments: set[str] = field(default_factory=set)

    @property
    def body(self) -> list[ast.stmt]:
        return [] if isinstance(self.node, ast.Lambda) else self.node.body

    @property
    def is_registered(self) -> bool:
        return self.word is not None or self.is_animation

    def parameter(self, name: str) -> PythonParameter | None:
        return next((p for p in self.parameters if p.variable.name == name), None)


@dataclass(eq=False, slots=True)
class Class:
    """Class that is translated to a record."""

    node: ast.ClassDef
    name: str
    variable: PythonVariable
    fields: list[tuple[str, ast.expr | None]] = field(default_factory=list)
    methods: dict[str, Function] = field(default_factory=dict)
    properties: set[str] = field(default_factory=set)
    constants: dict[str, ast.expr] = field(default_factory=dict)
    is_dataclass: bool = False


@dataclass(eq=False)
class PythonNames:
    """Result of name resolution.

    Attributes
    ----------
    variables
        Variable of each name node.
    functions, classes
        Function or class of each definition.
    ordered
        All functions in source order.
    imports
        Dotted path of each imported name.
    walrus
        Targets of assignment expressions.
    """

    module: Function
    variables: dict[ast.AST, PythonVariable] = field(default_factory=dict)
    functions: dict[ast.AST, Function] = field(default_factory=dict)
    classes: dict[ast.AST, Class] = field(default_factory=dict)
    ordered: list[Function] = field(default_factory=list)
    home: dict[ast.AST, Function] = field(default_factory=dict)
    imports: dict[PythonVariable, str] = field(default_factory=dict)
    walrus: list[ast.Name] = field(default_factory=list)


class _Scope:
    """Scope during name resolution; comprehensions and classes have their own scopes inside a function's."""

    __slots__ = ("function", "is_class", "names", "parent")

    def __init__(
        self, function: Function, parent: _Scope | None, names: dict[str, PythonVariable], is_class: bool = False
    ):
        self.function = function
        self.parent = parent
        self.names = names
        self.is_class = is_class

    def find(self, name: str) -> PythonVariable | None:
        scope: _Scope | None = self
        while scope is not None:
            if name in scope.names and (not scope.is_class or scope is self):
                return scope.names[name]
            scope = scope.parent
        return None


def resolve(tree: ast.Module) -> PythonNames:
    """Resolve all names of a program."""
    return _Resolver(tree).names


class _Resolver(ast.NodeVisitor):
    def __init__(self, tree: ast.Module) -> None:
        module = Function(tree, "", None)
        self.names = PythonNames(module)
        self.names.functions[tree] = module
        self.names.ordered.append(module)
        self.scope = _Scope(module, None, module.locals)
        self._declare_locals(module, tree.body, set())
        for statement in tree.body:
            self.visit(statement)

    # --- declarations ------------------------------------------------------------------------------------------

    def _declare_locals(self, function: Function, body: list[ast.stmt], outer: set[str]) -> None:
        for name in _assigned_names(body):
            if name not in outer and name not in function.locals:
                function.locals[name] = PythonVariable(name, function)

    def _store(self, name: str, node: ast.AST) -> PythonVariable | None:
        variable = self.scope.find(name)
        if variable is not None:
            variable.stores.append(node)
            if variable.function is not self.scope.function:
                variable.is_assigned_elsewhere = True
            self.names.variables[node] = variable
        return variable

    # --- names -------------------------------------------------------------------------------------------------

    def visit_Name(self, node: ast.Name) -> None:
        if isinstance(node.ctx, ast.Load):
            variable = self.scope.find(node.id)
            if variable is not None:
                variable.reads += 1
                variable.readers.add(self.scope.function)
                self.names.variables[node] = variable
        else:
            self._store(node.id, node)

    def visit_NamedExpr(self, node: ast.NamedExpr) -> None:
        self.visit(node.value)
        if self._store(node.target.id, node.target) is not None:
            self.names.walrus.append(node.target)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        if isinstance(node.target, ast.Name):
            variable = self._store(node.target.id, node.target)
            if variable is not None:
                variable.reads += 1
                variable.readers.add(self.scope.function)
        else:
            self.visit(node.target)
        self.visit(node.value)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.target)
            self.visit(node.value)

    def visit_Import(self, node: ast.Import) -> None:
        for alias in node.names:
            name = alias.asname or alias.name.partition(".")[0]
            self._import(name, alias.name if alias.asname else name, alias)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        for alias in node.names:
            if alias.name != "*":
                self._import(alias.asname or alias.name, f"{node.module}.{alias.name}", alias)

    def _import(self, name: str, path: str, node: ast.AST) -> None:
        variable = self._store(name, node)
        if variable is not None:
            if self.names.imports.get(variable) == path:
                variable.stores.pop()  # the same import again
            self.names.imports[variable] = path

    def visit_ExceptHandler(self, node: ast.ExceptHandler) -> None:
        if node.name:
            self._store(node.name, node)
        self.generic_visit(node)

    # --- functions ---------------------------------------------------------------------------------------------

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self._function(node, node.name, node.body)

    def visit_Lambda(self, node: ast.Lambda) -> None:
        self._function(node, "lambda", None)

    def _function(
        self, node: ast.FunctionDef | ast.Lambda, name: str, body: list[ast.stmt] | None, owner: Class | None = None
    ) -> Function:
        """Resolve the names of a function or lambda in a scope of its own."""
        function = Function(node, name, self.scope.function, owner=owner)
        if isinstance(node, ast.FunctionDef):
            for decorator in node.decorator_list:
                _read_decorator(function, node, decorator)
                self.visit(decorator)
            # a method is not a variable: it is found through its class
            if owner is None:
                function.variable = self._store(name, node)
                if function.variable is not None:
                    function.variable.functions.append(function)
        self.names.functions[node] = function
        self.names.ordered.append(function)
        self._parameters(function, node.args)
        enclosing = self.scope
        self.scope = _Scope(function, enclosing, function.locals)
        if body is None:
            assert isinstance(node, ast.Lambda)
            self._declare_locals(function, [ast.Expr(node.body)], set())
            self.visit(node.body)
        else:
            outer = _outer_names(body)
            for declared in outer:
                variable = enclosing.find(declared) if declared in _nonlocals(body) else self._module_variable(declared)
                if variable is not None:
                    function.locals.pop(declared, None)
            self._declare_locals(function, body, outer)
            function.is_generator = _has_yield(body)
            for statement in body:
                self.visit(statement)
        self.scope = enclosing
        return function

    def _module_variable(self, name: str) -> PythonVariable:
        names = self.names.module.locals
        if name not in names:
            names[name] = PythonVariable(name, self.names.module)
        return names[name]

    def _parameters(self, function: Function, arguments: ast.arguments) -> None:
        plain = [*arguments.posonlyargs, *arguments.args]
        defaults: list[ast.expr | None] = [None] * (len(plain) - len(arguments.defaults)) + list(arguments.defaults)
        rows = [(a, d, "plain") for a, d in zip(plain, defaults)]
        if arguments.vararg:
            rows.append((arguments.vararg, None, "rest"))
        rows += [(a, d, "keyword") for a, d in zip(arguments.kwonlyargs, arguments.kw_defaults)]
        if arguments.kwarg:
            rows.append((arguments.kwarg, None, "keys"))
        for argument, default, kind in rows:
            if default is not None:
                self.visit(default)
            variable = PythonVariable(argument.arg, function, [argument], is_parameter=True)
            function.locals[argument.arg] = variable
            self.names.variables[argument] = variable
            function.parameters.append(PythonParameter(variable, default, kind, argument.annotation))

    # --- classes -----------------------------------------------------------------------------------------------

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        """Record a class with its methods, properties, fields and constants."""
        variable = self._store(node.name, node)
        if variable is None:
            return
        record = Class(node, node.name, variable)
        record.is_dataclass = any("dataclass" in ast.unparse(d) for d in node.decorator_list)
        record.is_dataclass |= any("NamedTuple" in ast.unparse(b) for b in node.bases)
        self.names.classes[node] = record
        enclosing = self.scope
        # methods do not see the names of the class body
        self.scope = _Scope(enclosing.function, enclosing, {}, is_class=True)
        for statement in node.body:
            if isinstance(statement, ast.FunctionDef):
                method = self._function(statement, statement.name, statement.body, record)
                method.is_static = any(ast.unparse(d) == "staticmethod" for d in statement.decorator_list)
                if any(ast.unparse(d) == "property" for d in statement.decorator_list):
                    record.properties.add(statement.name)
                record.methods[statement.name] = method
            elif isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
                if statement.value is not None:
                    self.visit(statement.value)
                record.fields.append((statement.target.id, statement.value))
            elif isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name):
                self.visit(statement.value)
                record.constants[statement.targets[0].id] = statement.value
        self.scope = enclosing
        _collect_fields(record)

    # --- comprehensions ----------------------------------------------------------------------------------------

    def _comprehension(self, node: Comprehension, *results: ast.expr) -> None:
        enclosing = self.scope
        self.visit(node.generators[0].iter)
        self.scope = _Scope(enclosing.function, enclosing, {})
        for position, generator in enumerate(node.generators):
            if position:
                self.visit(generator.iter)
            for name in _target_names(generator.target):
                self.scope.names[name] = PythonVariable(name, enclosing.function, is_comprehension=True)
            self.visit(generator.target)
            for condition in generator.ifs:
                self.visit(condition)
        for result in results:
            self.visit(result)
        self.scope = enclosing

    def visit_ListComp(self, node: ast.ListComp) -> None:
        self._comprehension(node, node.elt)

    def visit_SetComp(self, node: ast.SetComp) -> None:
        self._comprehension(node, node.elt)

    def visit_GeneratorExp(self, node: ast.GeneratorExp) -> None:
        self._comprehension(node, node.elt)

    def visit_DictComp(self, node: ast.DictComp) -> None:
        self._comprehension(node, node.key, node.value)


def _read_decorator(function: Function, node: ast.FunctionDef, decorator: ast.expr) -> None:
    """Apply the decorators ``@register()``, ``@register("text")`` and ``@register_animation()`` to the function."""
    called = decorator.func if isinstance(decorator, ast.Call) else decorator
    name = called.id if isinstance(called, ast.Name) else called.attr if isinstance(called, ast.Attribute) else ""
    if name == "register_animation":
        function.is_animation = True
        function.word = node.name
    elif name == "register":
        function.word = node.name
        arguments = [*decorator.args, *(k.value for k in decorator.keywords)] if isinstance(decorator, ast.Call) else []
        if arguments and isinstance(arguments[0], ast.Constant) and isinstance(arguments[0].value, str):
            function.text = arguments[0].value


def _collect_fields(record: Class) -> None:
    """Add the fields that ``__init__`` and other methods assign on ``self``."""
    known = {name for name, _ in record.fields}
    for method in record.methods.values():
        if method.is_static or not method.parameters:
            continue
        own = method.parameters[0].variable.name
        for node in walk_tree(method.node):
            if (
                isinstance(node, ast.Attribute)
                and isinstance(node.ctx, ast.Store)
                and isinstance(node.value, ast.Name)
                and node.value.id == own
                and node.attr not in known
            ):
                known.add(node.attr)
                record.fields.append((node.attr, None))


def _own_nodes(body: list[ast.stmt]) -> list[ast.AST]:
    """Return all nodes of a body except the contents of nested functions and classes.

    The nested definitions themselves, and defaults and decorators of nested functions, are included.
    """
    nodes: list[ast.AST] = []
    stack: list[ast.AST] = list(reversed(body))
    while stack:
        node = stack.pop()
        nodes.append(node)
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
            decorators = [] if isinstance(node, ast.Lambda) else node.decorator_list
            defaults = [*node.args.defaults, *(default for default in node.args.kw_defaults if default is not None)]
            stack.extend(reversed([*decorators, *defaults]))
            continue
        if isinstance(node, ast.ClassDef):
            continue
        stack.extend(reversed(list(child_nodes(node))))
    return nodes


def _assigned_names(body: list[ast.stmt]) -> list[str]:
    names: dict[str, None] = {}
    inner = _comprehension_targets(body)
    for node in _own_nodes(body):
        if isinstance(node, ast.Name) and not isinstance(node.ctx, ast.Load) and node not in inner:
            names[node.id] = None
        elif isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.AsyncFunctionDef)):
            names[node.name] = None
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            for alias in node.names:
                names[alias.asname or alias.name.partition(".")[0]] = None
        elif isinstance(node, ast.ExceptHandler) and node.name:
            names[node.name] = None
    return list(names)


def _comprehension_targets(body: list[ast.stmt]) -> set[ast.AST]:
    return {
        name
        for node in _own_nodes(body)
        if isinstance(node, COMPREHENSIONS)
        for generator in node.generators
        for name in walk_tree(generator.target)
        if isinstance(name, ast.Name)
    }


def _target_names(target: ast.expr) -> list[str]:
    return [node.id for node in walk_tree(target) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)]


def _nonlocals(body: list[ast.stmt]) -> set[str]:
    return {name for node in _own_nodes(body) if isinstance(node, ast.Nonlocal) for name in node.names}


def _outer_names(body: list[ast.stmt]) -> set[str]:
    return {name for node in _own_nodes(body) if isinstance(node, (ast.Nonlocal, ast.Global)) for name in node.names}


def _has_yield(body: list[ast.stmt]) -> bool:
    return any(isinstance(node, (ast.Yield, ast.YieldFrom)) for node in _own_nodes(body))


# Modules and library functions that names refer to; imports that models commonly omit are assumed.


MODULES = {
    "np": "numpy", "numpy": "numpy", "math": "math", "random": "random", "helper": "helper", "itertools": "itertools",
    "functools": "functools", "collections": "collections", "colorsys": "colorsys", "operator": "operator",
    "copy": "copy",
    "numpy.random": "numpy.random", "numpy.linalg": "numpy.linalg", "dataclasses": "dataclasses", "typing": "typing",
}  # fmt: skip

# Names that are only used in annotations.
ANNOTATIONS = frozenset({
    "P", "T", "Shape", "Generator", "Iterator", "Iterable", "Callable", "List", "Tuple", "Dict", "Set", "Optional",
    "Any",
    "Union", "Sequence", "Literal", "NamedTuple", "ParamSpec", "TypeVar", "Point", "Color", "ndarray",
})  # fmt: skip

# What each forbidden module or builtin uses, for messages.
FORBIDDEN = {
    "os": "the operating system", "sys": "interpreter internals", "subprocess": "other programs", "shutil": "files",
    "pathlib": "files", "socket": "the network", "requests": "the network", "urllib": "the network",
    "http": "the network",
    "pickle": "files", "importlib": "dynamic imports", "builtins": "interpreter internals",
    "ctypes": "interpreter internals", "threading": "threads", "multiprocessing": "other programs",
    "asyncio": "the network", "inspect": "interpreter internals",
    "io": "files", "tempfile": "files", "glob": "files", "signal": "the operating system",
    "gc": "interpreter internals",
    "open": "files", "eval": "dynamic code evaluation", "exec": "dynamic code evaluation",
    "compile": "dynamic code evaluation",
    "__import__": "dynamic imports",
    "globals": "interpreter internals", "locals": "interpreter internals", "vars": "interpreter internals",
    "input": "user input",
    "getattr": "attribute access by name", "setattr": "attribute access by name",
    "delattr": "attribute access by name",
    "breakpoint": "the debugger", "memoryview": "raw memory", "exit": "interpreter internals",
    "quit": "interpreter internals",
    "dir": "interpreter internals", "help": "interpreter internals", "id": "interpreter internals",
    "super": "inheritance",
    "classmethod": "class methods", "object": "class objects", "type": "class objects",
    "hash": "interpreter internals",
}  # fmt: skip

BUILTINS = frozenset(name for name in dir(builtins) if not name.startswith("_"))


class LibraryPaths:
    """Dotted paths of library names in a program."""

    def __init__(self, names: PythonNames) -> None:
        self._names = names

    def of(self, node: ast.expr) -> str | None:
        """Return the dotted path of ``node``, such as ``numpy.sin``, ``len`` or ``library_call``.

        Returns None for the program's values.
        """
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


def is_annotation(paths: LibraryPaths, node: ast.expr) -> bool:
    """Return whether a value is only a type, as in ``Color = Tuple[float, float, float]``."""
    if isinstance(node, ast.Subscript):
        return is_annotation(paths, node.value) and not isinstance(node.value, ast.Subscript)
    if isinstance(node, ast.Call):
        return (paths.of(node.func) or "").removeprefix("typing.") in ("TypeVar", "NewType", "ParamSpec")
    path = (paths.of(node) or "").removeprefix("typing.")
    return path in ANNOTATIONS or path == "numpy.ndarray"


# Registered functions by the texts that may call them, and the root of the scene.


def registered_words(names: PythonNames) -> dict[str, Function]:
    """Map the arguments of ``library_call`` to functions.

    Names have precedence (the last definition wins), then the texts of ``register``, then these texts up to the first
    ``;``.
    """
    registered = [f for f in names.ordered if f.is_registered and f.word is not None]
    words: dict[str, Function] = {}
    for function in registered:
        words[str(function.word)] = function
    current = [f for f in registered if words[str(f.word)] is f]
    for function in current:
        words.setdefault(function.text, function) if function.text else None
    for function in current:
        start = function.text.partition(";")[0].strip()
        words.setdefault(start, function) if start else None
    return words


def find_root(names: PythonNames, paths: LibraryPaths, words: dict[str, Function]) -> Function | None:
    """Return the root function as the paper's tool does.

    That is the common ancestor of the call graph; otherwise the last function that is not called but calls others;
    otherwise the last registered function. An animation takes precedence.
    """
    first_definitions: dict[str, Function] = {}
    for function in names.ordered:
        if function.is_registered and function.word is not None:
            first_definitions.setdefault(function.word, words[function.word])
    functions = list(first_definitions.values())
    animations = [f for f in functions if f.is_animation]
    if animations:
        return animations[-1]
    if not functions:
        return None
    callees = {function: _callees(function, names, paths, words) - {function} for function in functions}
    for function in functions:
        if len(functions) > 1 and _reachable(function, callees) >= set(functions) - {function}:
            return function
    called = {callee for called_by_one in callees.values() for callee in called_by_one}
    uncalled = [f for f in functions if f not in called and callees[f]]
    return uncalled[-1] if uncalled else functions[-1]


def _callees(function: Function, names: PythonNames, paths: LibraryPaths, words: dict[str, Function]) -> set[Function]:
    """Return the registered functions that ``function`` calls, directly or through other functions of the program."""
    called: set[Function] = set()
    seen: set[Function] = set()
    stack = [function]
    while stack:
        current = stack.pop()
        if current in seen:
            continue
        seen.add(current)
        for node in walk_tree(current.node):
            if isinstance(node, ast.Call) and paths.of(node.func) == "library_call":
                word = node.args[0] if node.args else None
                if isinstance(word, ast.Constant) and str(word.value) in words:
                    called.add(words[str(word.value)])
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                variable = names.variables.get(node)
                for used in variable.functions if variable is not None else ():
                    if used.is_registered:
                        called.add(words[str(used.word)])
                    else:
                        stack.append(used)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in words:
                if words[node.value].word == node.value:
                    called.add(words[node.value])
    return called


def _reachable(function: Function, callees: dict[Function, set[Function]]) -> set[Function]:
    reached: set[Function] = set()
    stack = [function]
    while stack:
        for callee in callees[stack.pop()]:
            if callee not in reached:
                reached.add(callee)
                stack.append(callee)
    return reached


# Predicates on Python syntax that several modules of the transpiler use.


def is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def inner_blocks(statement: ast.stmt) -> list[list[ast.stmt]]:
    """Return the blocks of a compound statement that belong to the same function."""
    if isinstance(statement, (ast.FunctionDef, ast.ClassDef)):
        return []
    blocks = [getattr(statement, name, None) for name in ("body", "orelse", "finalbody")]
    inner = [block for block in blocks if block]
    for handler in getattr(statement, "handlers", ()):
        inner.append(handler.body)
    return inner
