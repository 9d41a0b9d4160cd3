"""Functions and classes of the program: parameters, calls, and records."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence

from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import SceneError, did_you_mean, near_names, suggest
from scenelang.grammar.python_helpers import HELPERS
from scenelang.interpreter.transpile.analysis.inference import BOOL, FLOAT, INT, NOTHING, T_INT
from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.scopes import Class, Function, PythonParameter, PythonVariable
from scenelang.interpreter.transpile.writing.code import (
    ArgumentName,
    Code,
    FormCode,
    Key,
    LiteralCode,
    Name,
    VariableRef,
    form,
    kebab,
)
from scenelang.interpreter.transpile.writing.operators import numeric, write_iterable, write_vector
from scenelang.interpreter.transpile.writing.writer import Writer, is_used_as_vector

# Parameters.


def write_parameters(w: Writer, function: Function) -> FormCode:
    """Return the parameter list; defaults that are not constant have been hoisted."""
    items: list[Code] = []
    rest: Code | None = None
    for parameter in function.parameters:
        variable = parameter.variable
        name = VariableRef(variable, w.span(variable.stores[0]), is_keyword=variable.is_keyword)
        if parameter.kind == "rest":
            rest = name
        elif parameter.kind == "keys":
            items += [Name("&keys"), name]
        elif parameter.default is not None:
            items.append(FormCode([name, _write_default(w, function, variable, parameter.default)]))
        else:
            items.append(name)
    return FormCode(items, _signature_span(w, function), rest)


def _signature_span(w: Writer, function: Function) -> Span | None:
    """Return the span of the parameters in the Python code."""
    if not function.parameters:
        return None
    first = w.span(function.parameters[0].variable.stores[0])
    last_parameter = function.parameters[-1]
    last = w.span(last_parameter.default or last_parameter.annotation or last_parameter.variable.stores[0])
    return Span(first.source, first.start, max(first.end, last.end))


def _write_default(w: Writer, function: Function, variable: PythonVariable, node: ast.expr) -> Code:
    """Return the default of a parameter, or the variable that it was hoisted to."""
    hoisted = w.defaults.get(node)  # hoisted, because it must be evaluated at the definition
    if hoisted is not None:
        return VariableRef(hoisted, w.span(node))
    return write_vector(w, node) if w.is_vector_literal(node) and is_used_as_vector(w, node) else w.expr(node)


def is_constant_default(w: Writer, node: ast.expr) -> bool:
    """Return whether a default has the same value whenever it is evaluated."""
    effect = w.effect(node)
    if effect.has_effect or effect.inspects or effect.reads:
        return False
    if any(w.is_mutated(n) for n in walk_tree(node)):
        return False
    for name in walk_tree(node):
        if isinstance(name, ast.Name):
            variable = w.names.variables.get(name)
            if variable is not None and (len(variable.stores) > 1 or variable.is_cell):
                return False
        elif isinstance(name, ast.Call) and w.paths.of(name.func) is None:
            return False
    return True


def lambda_locals(w: Writer, function: Function) -> list[Code]:
    """Return definitions of the variables that ``:=`` assigns inside a lambda."""
    parameters = {parameter.variable for parameter in function.parameters}
    own = [variable for variable in function.locals.values() if variable not in parameters]
    return [form("define", VariableRef(variable), LiteralCode(None)) for variable in own]


# Calls.


def call_function(w: Writer, node: ast.Call) -> Code:
    """Return a call of a variable, a lambda or the result of another call."""

    record = _record_of(w, node.func)
    if record is not None:
        return construct(w, node, record)
    target = w.single_function(node.func)
    if target is None and isinstance(node.func, ast.Name):
        targets = w.facts.targets.get(node, [])
        target = targets[0] if len(targets) == 1 and isinstance(targets[0].node, ast.Lambda) else None
        variable = w.variable(node.func)
        if target is not None and (variable is None or len(variable.stores) != 1 or not _is_named(w, variable, target)):
            target = None
    if target is None:
        return _call_value(w, node)
    assert isinstance(node.func, ast.Name)
    function = VariableRef(w.names.variables[node.func], w.span(node.func))
    return call_known(w, node, function, target, [])


def _is_named(w: Writer, variable: PythonVariable, function: Function) -> bool:
    """Return whether a variable is only the name of a lambda."""
    outer = w.parent(variable.stores[0])
    return isinstance(outer, ast.Assign) and outer.value is function.node


def _record_of(w: Writer, func: ast.expr) -> Class | None:
    variable = w.variable(func)
    return next((c for c in w.names.classes.values() if c.variable is variable), None) if variable is not None else None


def call_known(w: Writer, node: ast.Call, function: Code, target: Function, first: list[Code]) -> Code:
    """Return a call of ``target``, whose parameters are known; ``first`` are arguments before those of ``node``."""
    parameters = target.parameters[len(first) :]
    stars = [a for a in node.args if isinstance(a, ast.Starred)]
    _check(w, node, target, parameters, has_star=bool(stars))
    if stars:
        return _spread(w, node, function, parameters, first)
    items = list(first)
    rest = next((p for p in parameters if p.kind == "rest"), None)
    plain = [p for p in parameters if p.kind == "plain"]
    for position, argument in enumerate(node.args):
        if position < len(plain):
            if plain[position].variable.is_keyword:
                items.append(ArgumentName(plain[position].variable.name, w.span(argument)))
        elif rest is None:
            break
        items.append(w.comment_item(write_argument(w, argument, plain[position : position + 1]), argument))
    tables: list[Code] = []
    for keyword in node.keywords:
        if keyword.arg is None:
            tables.append(form("keywords", w.expr(keyword.value)))
            continue
        named = [p for p in parameters if p.variable.name == keyword.arg]
        value = write_argument(w, keyword.value, named)
        items += w.comment_pair(ArgumentName(keyword.arg, w.span(keyword)), value, keyword)
    if tables:
        return form("apply", function, *items, *([form("append", *tables)] if len(tables) > 1 else tables))
    return FormCode([function, *items])


def write_argument(w: Writer, node: ast.expr, parameters: Sequence[PythonParameter] = ()) -> Code:
    """Return an argument of a function of the program.

    A display that is only used as a vector becomes an array, a Boolean for a numeric parameter becomes a number.
    """
    if w.type(node).only(BOOL) and any(
        w.facts.variables.get(p.variable, NOTHING).kinds & (INT | FLOAT) for p in parameters
    ):
        return numeric(w, node)
    return write_vector(w, node) if w.is_vector_literal(node) and is_used_as_vector(w, node) else w.expr(node)


def _check(w: Writer, node: ast.Call, target: Function, parameters: list[PythonParameter], *, has_star: bool) -> None:
    """Raise an error if the arguments of a call do not match the parameters."""
    plain = [p for p in parameters if p.kind == "plain"]
    names = [p.variable.name for p in parameters if p.kind in ("plain", "keyword")]
    kinds = {p.kind for p in parameters}
    if not has_star and len(node.args) > len(plain) and "rest" not in kinds:
        expected = f"{len(plain)} argument{'s' if len(plain) != 1 else ''}"
        raise _misfit(
            w, node, target, parameters, f"`{target.name}` expects {expected}, got {len(node.args)}", expected
        )
    given = {p.variable.name for p, _ in zip(plain, node.args)} if not has_star else set()
    for keyword in node.keywords:
        if keyword.arg is None:
            return
        if keyword.arg not in names and "keys" not in kinds:
            message = f"`{target.name}` has no parameter `{keyword.arg}`"
            near = near_names(keyword.arg, names)
            error = _misfit(w, keyword, target, parameters, message, ", ".join(names) or "no keyword")
            error.hint, error.near, error.found = did_you_mean(near), tuple(near), keyword.arg
            raise error
        if keyword.arg in given:
            raise w.error(
                "python-call", f"multiple values for the argument `{keyword.arg}` of `{target.name}`", keyword
            )
        given.add(keyword.arg)
    missing = [
        p.variable.name for p in parameters
        if p.kind in ("plain", "keyword") and p.default is None and p.variable.name not in given
    ]  # fmt: skip
    if missing and not has_star:
        names_text = ", ".join(f"`{m}`" for m in missing)
        message = f"missing arguments in a call of `{target.name}`: {names_text}"
        raise _misfit(w, node, target, parameters, message, ", ".join(missing))


def _misfit(
    w: Writer, node: ast.AST, target: Function, parameters: Sequence[PythonParameter], message: str, expected: str
) -> SceneError:
    """Return the error for a call that does not match its function, with the signature."""
    marks = {"rest": "*", "keys": "**"}
    names = [f"{marks.get(p.kind, '')}{p.variable.name}{'=...' if p.default is not None else ''}" for p in parameters]
    error = w.error("python-call", message, node)
    error.expected, error.found = expected, w.text.text(node)[:80]
    error.signature = f"{target.name}({', '.join(names)})"
    return error


def _spread(w: Writer, node: ast.Call, function: Code, parameters: list[PythonParameter], first: list[Code]) -> Code:
    """Return the call of ``f(*xs)``. Keyword parameters are passed by position through a wrapper."""
    before: list[Code] = list(first)
    lists: list[Code] = []
    named = [k for k in node.keywords if k.arg is not None]
    plain = [p for p in parameters if p.kind == "plain" and p.variable.name not in {k.arg for k in named}]
    given: list[Code] = []
    tables: list[Code] = []
    for keyword in node.keywords:
        if keyword.arg is None:
            tables.append(form("keywords", w.expr(keyword.value)))
            continue
        given += [ArgumentName(keyword.arg, w.span(keyword)), w.expr(keyword.value)]
    if any(p.variable.is_keyword for p in plain):
        count = _positional_count(w, node)
        plain = plain if count is None else plain[:count]
        rest = next((p for p in parameters if p.kind == "rest"), None)
        optional = [p for p in plain if count is None and p.default is not None and isinstance(p.default, ast.Constant)]
        defaults = {p: w.expr(p.default) for p in optional if p.default is not None}
        function, given, tables = by_position(function, plain, given, tables, rest, defaults), [], []
    for argument in node.args:
        if isinstance(argument, ast.Starred):
            lists.append(write_iterable(w, argument.value))
        elif lists:
            lists.append(form("list", w.expr(argument)))
        else:
            before.append(w.expr(argument))
    before += given
    lists += tables
    tail = lists[0] if len(lists) == 1 else form("append", *lists)
    return form("apply", function, *before, tail)


def _positional_count(w: Writer, node: ast.Call) -> int | None:
    """Return the number of positional arguments of a call with starred arguments, or None if it is unknown."""
    total = 0
    for argument in node.args:
        length = w.known_length(argument.value) if isinstance(argument, ast.Starred) else 1
        if length is None:
            return None
        total += length
    return total


def by_position(
    function: Code, parameters: list[PythonParameter], given: Sequence[Code] = (), tables: Sequence[Code] = (),
    rest: PythonParameter | None = None, defaults: Mapping[PythonParameter, Code] | None = None,
) -> Code:  # fmt: skip
    """Return ``(lambda (a b) (f :a a :b b))``, which takes keyword parameters of ``function`` by position.

    ``given`` and ``tables`` are further keyword arguments, ``rest`` takes the remaining positional ones; those with
    ``defaults`` may be missing.
    """
    variables = [PythonVariable(p.variable.name, None, is_temporary=True) for p in parameters]
    items: list[Code] = []
    for parameter, variable in zip(parameters, variables):
        if parameter.variable.is_keyword:
            items.append(ArgumentName(parameter.variable.name))
        items.append(VariableRef(variable))
    remaining = PythonVariable(rest.variable.name, None, is_temporary=True) if rest is not None else None
    lists: list[Code] = [*([VariableRef(remaining)] if remaining is not None else []), *tables]
    call: Code = FormCode([function, *items, *given])
    if lists:
        tail = lists[0] if len(lists) == 1 else form("append", *lists)
        call = form("apply", function, *items, *given, tail)
    optional = defaults or {}
    names: list[Code] = [
        FormCode([VariableRef(v), optional[p]]) if p in optional else VariableRef(v)
        for p, v in zip(parameters, variables)
    ]
    signature = FormCode(names, None, VariableRef(remaining) if remaining is not None else None)
    return FormCode([Name("lambda"), signature, call])


def as_positional(w: Writer, function: Function, node: ast.Name) -> Code:
    """Return a function with keyword parameters as a value that is called by position, for its required parameters."""
    plain = [p for p in function.parameters if p.kind == "plain"]
    required = sum(1 for p in plain if p.default is None)
    given = (
        1 if isinstance(w.parent(node), (ast.Call, ast.keyword)) else 0
    )  # the argument that `loop`, `map` or a key function passes
    return by_position(VariableRef(w.names.variables[node], w.span(node)), plain[: max(required, given)])


def _call_value(w: Writer, node: ast.Call) -> Code:
    """Return a call of a function that is unknown; keywords are used if all possible functions agree."""
    targets = w.facts.targets.get(node, [])
    names = {tuple(p.variable.name for p in t.parameters) for t in targets}
    is_named = any(p.variable.is_keyword for t in targets for p in t.parameters)
    if is_named and len(names) == 1 and not isinstance(node.func, ast.Lambda):
        return call_known(w, node, w.expr(node.func), targets[0], [])
    function = w.expr(node.func)
    if any(isinstance(a, ast.Starred) for a in node.args):
        return _spread(w, node, function, [], [])
    items = [w.comment_item(write_argument(w, a), a) for a in node.args]
    for keyword in node.keywords:
        if keyword.arg is None:
            items_list = form("keywords", w.expr(keyword.value))
            return form("apply", function, *items, items_list)
        items += [ArgumentName(keyword.arg, w.span(keyword)), w.expr(keyword.value)]
    return FormCode([function, *items])


# Binding of arguments to the parameters of a library function.


def arguments_of(w: Writer, node: ast.Call, signature: str, name: str) -> dict[str, ast.expr]:
    """Return the arguments by parameter; raise an error if they do not match.

    ``signature`` names the parameters in order; ``?`` marks an optional one.
    """
    parameters = signature.split()
    names = [p.rstrip("?") for p in parameters]
    by_parameter: dict[str, ast.expr] = {}
    for position, argument in enumerate(expand_starred(w, node.args)):
        if isinstance(argument, ast.Starred):
            raise w.unsupported(f"a `*` argument in a call of `{name}`", argument)
        if position >= len(names):
            message = (
                f"`{name}` expects at most {len(names)} argument{'s' if len(names) != 1 else ''}, got {len(node.args)}"
            )
            as_one = (
                f"write `{name}(({', '.join(map(ast.unparse, node.args))}))`: one tuple" if len(names) == 1 else None
            )
            raise _library_misfit(w, name, message, f"a call of `{name}` with {len(node.args)} arguments", node, as_one)
        by_parameter[names[position]] = argument
    for keyword in node.keywords:
        if keyword.arg is None:
            raise w.unsupported(f"`**` in a call of `{name}`", keyword)
        if keyword.arg not in names:
            message, what = f"`{name}` has no parameter `{keyword.arg}`", f"the argument `{keyword.arg}` of `{name}`"
            raise _library_misfit(w, name, message, what, keyword, suggest(keyword.arg, names))
        if keyword.arg in by_parameter:
            raise w.error("python-call", f"multiple values for the argument `{keyword.arg}` of `{name}`", keyword)
        by_parameter[keyword.arg] = keyword.value
    for parameter in parameters:
        if not parameter.endswith("?") and parameter not in by_parameter:
            message, what = (
                f"missing argument `{parameter}` in a call of `{name}`",
                f"a call of `{name}` without `{parameter}`",
            )
            raise _library_misfit(w, name, message, what, node)
    return by_parameter


def _library_misfit(
    w: Writer, name: str, message: str, what: str, node: ast.AST, hint: str | None = None
) -> SceneError:
    """Return the error of an argument that does not fit: a mistake for the helper API.

    Of Python's libraries the translation knows only a part; the evaluator, which calls them, finds the mistakes.
    """
    return w.error("python-call", message, node, hint) if name in HELPERS else w.unsupported(what, node)


def expand_starred(w: Writer, arguments: list[ast.expr]) -> list[ast.expr]:
    """Return the arguments with ``*xs`` expanded where ``xs`` is a variable of known length."""
    expanded: list[ast.expr] = []
    for argument in arguments:
        length = w.known_length(argument.value) if isinstance(argument, ast.Starred) else None
        if length is None or not isinstance(argument, ast.Starred) or not w.is_simple(argument.value):
            expanded.append(argument)
            continue
        items = [site.items for site in w.type(argument.value).sites if site.items is not None]
        for position in range(length):
            item = ast.copy_location(ast.Subscript(argument.value, ast.Constant(position), ast.Load()), argument)
            ast.copy_location(item.slice, argument)
            for types in items:
                w.facts.types[item] = w.type(item) | types[position]
            w.facts.types[item.slice] = T_INT
            expanded.append(item)
    return expanded


def is_zero_vector(node: ast.expr | None) -> bool:
    """Return whether ``node`` is ``(0, 0, 0)``, ``np.zeros(3)``, or None."""
    if node is None:
        return True
    if isinstance(node, (ast.Tuple, ast.List)):
        return len(node.elts) == 3 and all(_is_zero(e) for e in node.elts)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and len(node.args) == 1:
        if node.func.attr == "zeros":
            return isinstance(node.args[0], ast.Constant) and node.args[0].value == 3
        if node.func.attr == "array":
            return is_zero_vector(node.args[0])
    return False


def _is_zero(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) in (int, float) and node.value == 0


def is_ones(node: ast.expr) -> bool:
    """Return whether ``node`` is ``(1, 1, 1)``."""
    return (
        isinstance(node, (ast.Tuple, ast.List))
        and len(node.elts) == 3
        and all(isinstance(e, ast.Constant) and type(e.value) in (int, float) and e.value == 1 for e in node.elts)
    )


# Records: classes and dataclasses, their constructors, fields and methods.


def _record(w: Writer, node: ast.expr) -> Class:
    classes = w.type(node).classes
    if len(classes) != 1:
        names = ", ".join(sorted(c.name for c in classes)) or "several classes"
        hint = f"possible classes: {names}" if classes else None
        raise w.unsupported("a value that may be of several classes", node, hint)
    return classes[0]


def read_field(w: Writer, node: ast.Attribute) -> Code:
    record = _record(w, node.value)
    if node.attr in record.properties:
        return FormCode([VariableRef(w.records.part(record, "method", node.attr)), w.expr(node.value)])
    if node.attr in record.constants:
        return VariableRef(w.records.part(record, "constant", node.attr))
    fields = [name for name, _ in record.fields]
    if node.attr not in fields:
        hint = suggest(node.attr, [*fields, *record.methods])
        raise w.error("python-name", f"`{record.name}` has no attribute `{node.attr}`", node, hint)
    return FormCode([VariableRef(w.records.part(record, "get", node.attr), w.span(node)), w.expr(node.value)])


def set_field(w: Writer, target: ast.Attribute, value: Code) -> Code:
    record = _record(w, target.value)
    if target.attr in record.constants:
        raise w.unsupported("an attribute of a class that changes", target)
    if target.attr in record.properties:
        hint = f"write a method with `@{target.attr}.setter`"
        raise w.error("python-call", f"property `{target.attr}` of `{record.name}` has no setter", target, hint)
    return FormCode(
        [VariableRef(w.records.part(record, "set", target.attr), w.span(target)), w.expr(target.value), value]
    )


def predicate(w: Writer, name: ast.expr, value: ast.expr) -> Code:
    variable = w.variable(name)
    record = next(c for c in w.names.classes.values() if c.variable is variable)
    return FormCode([VariableRef(w.records.part(record, "is")), w.expr(value)])


def call_record_method(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    record = _record(w, func.value)
    method = record.methods.get(func.attr)
    if method is None:
        if func.attr in [name for name, _ in record.fields]:
            return FormCode([w.expr(func), *(w.expr(a) for a in node.args)])
        raise w.error(
            "python-name", f"`{record.name}` has no method `{func.attr}`", func, suggest(func.attr, record.methods)
        )
    function = VariableRef(w.records.part(record, "method", func.attr), w.span(func))
    is_class = (
        any(c.variable is w.variable(func.value) for c in w.names.classes.values()) if w.variable(func.value) else False
    )
    first = [] if method.is_static or is_class else [w.expr(func.value)]
    return call_known(w, node, function, method, first)


def construct(w: Writer, node: ast.Call, record: Class) -> Code:
    """Return the call of a constructor, ``Point(1, y=2)``."""
    constructor = record.methods.get("__init__")
    if constructor is not None:
        function: Code = VariableRef(w.records.part(record, "make"), w.span(node.func))
        self_less = _without_self(constructor)
        return call_known(w, node, function, self_less, [])
    fields = [name for name, _ in record.fields]
    if len(node.args) > len(fields):
        raise w.error("python-call", f"`{record.name}` has {len(fields)} fields, got {len(node.args)} values", node)
    items: list[Code] = [w.expr(a) for a in node.args]
    given = set(fields[: len(node.args)])
    for keyword in node.keywords:
        if keyword.arg is None or keyword.arg not in fields:
            raise w.error(
                "python-call",
                f"`{record.name}` has no field `{keyword.arg}`",
                keyword,
                suggest(str(keyword.arg), fields),
            )
        given.add(keyword.arg)
        items += [Key(kebab(keyword.arg)), w.expr(keyword.value)]
    missing = [name for name, default in record.fields if default is None and name not in given]
    if missing:
        names = ", ".join(f"`{m}`" for m in missing)
        raise w.error("python-call", f"missing fields in a call of `{record.name}`: {names}", node)
    return FormCode([VariableRef(record.variable, w.span(node.func)), *items])


def _without_self(constructor: Function) -> Function:
    copy = Function(constructor.node, constructor.name, constructor.parent, parameters=constructor.parameters[1:])
    return copy
