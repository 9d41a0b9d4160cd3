"""Python expressions, each kind with a handler in a table.

Handlers take the writer first and generate child expressions with ``w.expr``, which uses this table. The recursion goes
through the writer, so that modules for calls do not depend on this one.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from scenelang.grammar.diagnostics import SceneError, did_you_mean, near_names, suggest
from scenelang.grammar.python_helpers import HELPERS
from scenelang.interpreter.runtime.modelling_helpers import ASSERT_THAT, scene_helpers
from scenelang.interpreter.transpile.analysis.inference import ARRAY, POSE, RECORD, SET, SHAPE, STR
from scenelang.interpreter.transpile.analysis.known import RESULTS
from scenelang.interpreter.transpile.analysis.python_text import construct_of, walk_tree
from scenelang.interpreter.transpile.analysis.scopes import (
    ANNOTATIONS,
    BUILTINS,
    FORBIDDEN,
    Comprehension,
    PythonVariable,
    is_module,
)
from scenelang.interpreter.transpile.writing.calls import CALLS, CONSTANTS, VALUES, call_method
from scenelang.interpreter.transpile.writing.code import (
    Brackets,
    Code,
    FormCode,
    LiteralCode,
    Name,
    VariableRef,
    form,
    is_form,
    lambda_list,
    none,
    quote,
)
from scenelang.interpreter.transpile.writing.operators import (
    binary,
    boolean,
    comparison,
    interpolated,
    is_constant,
    loop_head,
    subscript,
    unary,
    write_iterable,
    write_pattern,
    write_test,
)
from scenelang.interpreter.transpile.writing.user_calls import (
    as_positional,
    call_function,
    is_constant_default,
    lambda_locals,
    read_field,
    write_parameters,
)
from scenelang.interpreter.transpile.writing.writer import Writer, is_parts, is_used_as_vector

_UNARY_METHODS = ("get", "append", "add", "index", "count", "remove", "startswith", "endswith", "extend")
_PLAIN_NUMBER = re.compile(r"(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def write_expression(w: Writer, node: ast.expr) -> Code:
    """Return the code of an expression. Errors are recorded as diagnostics."""
    write = _EXPRESSIONS.get(type(node))
    if write is None:
        construct, hint = construct_of(node)
        raise w.unsupported(construct, node, hint)
    try:
        code = write(w, node)
    except SceneError as error:  # recorded, so that the rest is checked as well; the program is discarded
        w.diagnostics.append(error.diagnostic)
        return form("void")
    if code.span is None:
        code.span = w.span(node)
    is_new = isinstance(node, (ast.Call, ast.BinOp, ast.Subscript))
    if is_new and w.type(node).only(ARRAY | POSE) and w.is_mutated(node) and not is_form(code, "mutable-array"):
        return form("mutable-array", code, span=code.span)
    return code


# Constants, names and attributes.


def _constant(w: Writer, node: ast.Constant) -> Code:
    value = node.value
    if isinstance(value, str) and any("\ud800" <= c <= "\udfff" for c in value):
        raise w.unsupported("a string with an unpaired surrogate", node)
    if value is None or isinstance(value, (bool, str)):
        return LiteralCode(value)
    if isinstance(value, (int, float)):
        text = w.text.text(node) if value != math.inf else "1e999"  # `inf` may be a variable of the program
        return LiteralCode(value, None, text if _PLAIN_NUMBER.fullmatch(text) else None)
    raise w.unsupported(f"the constant `{value!r}`", node)


def _name(w: Writer, node: ast.Name) -> Code:
    path = w.paths.of(node)
    if path is not None:
        return _library_value(w, node, path)
    variable = w.names.variables[node]
    record = next((c for c in w.names.classes.values() if c.variable is variable), None)
    if record is not None and "__init__" in record.methods and variable is not None:
        return VariableRef(w.records.part(record, "make"), w.span(node))  # the class as a value makes instances
    function = w.single_function(node)
    is_argument = isinstance(w.parent(node), (ast.Call, ast.keyword, ast.Starred))
    if function is not None and is_argument and any(p.variable.is_keyword for p in function.parameters):
        return as_positional(w, function, node)
    return VariableRef(variable, w.span(node))


def _library_value(w: Writer, node: ast.expr, path: str) -> Code:
    """Return a constant or function of the library as a value."""
    if path in CONSTANTS:
        return Name(CONSTANTS[path])
    if path in VALUES:
        return VALUES[path](w)
    check_path(w, node, path)
    raise w.unsupported(f"`{w.text.text(node)}` as a value", node)


def check_path(w: Writer, node: ast.expr, path: str) -> None:
    """Raise an error if the library name ``path`` is unknown or not allowed."""
    top = path.split(".")[0]
    if top in FORBIDDEN or path in FORBIDDEN:
        from scenelang.interpreter.transpile.evaluation import instead_of  # loads numpy

        raise w.error(
            "python-forbidden",
            f"`{w.text.text(node)}` is not allowed, because it uses {FORBIDDEN[top]}",
            node,
            instead_of(top),
        )
    if path.rpartition(".")[2].startswith("__") or path.startswith("__"):
        raise w.error("python-forbidden", f"`{w.text.text(node)}` accesses interpreter internals", node)
    known = path in RESULTS or path in BUILTINS or path in HELPERS or is_module(path) or path in ANNOTATIONS
    if known:
        return
    if "." in path and is_module(path.rpartition(".")[0]):
        module, _, name = path.rpartition(".")
        near = [p.removeprefix(module + ".") for p in RESULTS if p.startswith(module + ".")]
        raise w.error("python-unsupported", f"`{w.text.text(node)}` is not supported", node, suggest(name, near))
    first = node
    while isinstance(first, ast.Attribute):
        first = first.value
    if w.names.variables.get(first) in w.names.imports:
        raise w.unsupported(f"`{w.text.text(node)}`", node)
    visible = {v.name for v in w.names.variables.values()} | {*HELPERS, *scene_helpers(), ASSERT_THAT} | BUILTINS
    near = near_names(path, sorted(visible))
    error = w.error("python-name", f"`{path}` is not defined", node, did_you_mean(near))
    error.near, error.expected, error.found = tuple(near), "a defined name", path
    raise error


def _attribute(w: Writer, node: ast.Attribute) -> Code:
    path = w.paths.of(node)
    if path is not None:
        return _library_value(w, node, path)
    if node.attr.startswith("__"):
        raise w.error("python-forbidden", f"`.{node.attr}` accesses interpreter internals", node)
    owner = w.type(node.value)
    if owner.kinds & RECORD or owner.classes:
        return read_field(w, node)
    if owner.kinds & (ARRAY | POSE) or not owner.kinds:
        known = {"shape": "array-shape", "T": "transpose", "size": "length"}.get(node.attr)
        if known is not None:
            return form(known, w.expr(node.value))
    if node.attr in _UNARY_METHODS:
        return _bound_method(w, node)
    raise w.unsupported(f"the attribute `.{node.attr}`", node)


def _bound_method(w: Writer, node: ast.Attribute) -> Code:
    """Return a bound method such as ``counts.get`` as a function of one argument."""
    variable = PythonVariable("key", None, is_temporary=True)
    argument = ast.copy_location(ast.Name("key", ast.Load()), node)
    w.names.variables[argument] = variable
    call = ast.copy_location(ast.Call(node, [argument], []), node)
    return form("lambda", FormCode([VariableRef(variable)]), call_method(w, call, node))


# Displays.


def _tuple(w: Writer, node: ast.Tuple) -> Code:
    return _display(w, node, node.elts)


def _list(w: Writer, node: ast.List) -> Code:
    return _display(w, node, node.elts)


def _display(w: Writer, node: ast.Tuple | ast.List, elements: list[ast.expr]) -> Code:
    is_mutable = w.is_mutated(node)
    if any(isinstance(e, ast.Starred) for e in elements):
        joined = _joined(w, elements)
        return form("mutable", joined) if is_mutable else joined
    if is_mutable:
        return form("mutable-list", *_items(w, elements))
    if is_used_as_vector(w, node) and w.is_vector_literal(node):
        return Brackets(_items(w, elements))
    return _immutable_list(w, node, elements)


def _immutable_list(w: Writer, node: ast.expr, elements: list[ast.expr]) -> Code:
    """Return an immutable list: quoted if it is constant, a quasiquoted template if it is mostly constant."""
    if _is_data(w, node):
        return quote(_data(w, node, quasi=False))
    leaves = _leaves(w, node)
    nested = any(isinstance(e, (ast.Tuple, ast.List)) for e in elements)
    constant = sum(1 for leaf in leaves if is_constant(leaf))
    if nested and leaves and 2 * constant >= len(leaves) and _is_template(w, node):
        return form("quasiquote", _data(w, node, quasi=True))
    return form("list", *_items(w, elements))


def _items(w: Writer, elements: Sequence[ast.expr]) -> list[Code]:
    return [w.comment_item(w.expr(element), element) for element in elements]


def _joined(w: Writer, elements: list[ast.expr]) -> Code:
    """Return the code of ``[*a, b, *c]``."""
    pieces: list[Code] = []
    run: list[ast.expr] = []
    is_shape = False

    def close() -> None:
        if run:
            if all(is_constant(e) for e in run):
                pieces.append(quote(FormCode([_data(w, e, quasi=False) for e in run])))
            else:
                pieces.append(form("list", *_items(w, run)))
            run.clear()

    for element in elements:
        if isinstance(element, ast.Starred):
            close()
            is_shape |= bool(w.type(element.value).kinds & SHAPE)
            inferred = w.type(element.value)
            items = write_iterable(w, element.value)
            items = form("->list", items) if inferred.kinds & (STR | SET) else items
            pieces.append(w.comment_item(items, element))
        else:
            run.append(element)
    close()
    if len(pieces) == 1 and not is_shape:
        return form("->list", pieces[0])
    return form("append", *pieces)


def _leaves(w: Writer, node: ast.expr) -> list[ast.expr]:
    if isinstance(node, (ast.Tuple, ast.List)):
        return [leaf for element in node.elts for leaf in _leaves(w, element)]
    return [node]


def _is_data(w: Writer, node: ast.expr) -> bool:
    """Return whether a display is constant, and no part of it is ever modified."""
    if isinstance(node, (ast.Tuple, ast.List)):
        return not w.is_mutated(node) and all(_is_data(w, e) for e in node.elts)
    return is_constant(node)


def _is_template(w: Writer, node: ast.expr) -> bool:
    if isinstance(node, (ast.Tuple, ast.List)):
        return not w.is_mutated(node) and all(not isinstance(e, ast.Starred) and _is_template(w, e) for e in node.elts)
    return True


def _data(w: Writer, node: ast.expr, *, quasi: bool) -> Code:
    if isinstance(node, (ast.Tuple, ast.List)):
        items = [w.comment_item(_data(w, e, quasi=quasi), e) for e in node.elts]
        return FormCode(items, w.span(node))
    if is_constant(node) or not quasi:
        return w.expr(node)
    return form("unquote", w.expr(node), span=w.span(node))


def _set(w: Writer, node: ast.Set) -> Code:
    if any(isinstance(e, ast.Starred) for e in node.elts):
        return form("list->set", _joined(w, node.elts))
    return form("set", *_items(w, node.elts))


def _dict(w: Writer, node: ast.Dict) -> Code:
    pieces: list[Code] = []
    pairs: list[Code] = []
    for key, value in zip(node.keys, node.values):
        if key is None:
            if pairs:
                pieces.append(form("table", *pairs))
                pairs = []
            pieces.append(w.expr(value))
        else:
            pairs += [w.comment_item(w.expr(key), key), w.comment_item(w.expr(value), value)]
    if pairs or not pieces:
        pieces.append(form("table", *pairs))
    is_one = len(pieces) == 1 and (not node.keys or node.keys[0] is not None)
    return pieces[0] if is_one else form("table-merge", *pieces)


# Comprehensions.


def _late_variables(w: Writer, node: Comprehension) -> list[PythonVariable]:
    """Return the variables of a comprehension that its results capture and read later."""
    targets = [n for g in node.generators for n in walk_tree(g.target) if isinstance(n, ast.Name)]
    captured = (w.names.variables.get(n) for n in targets)
    return [variable for variable in dict.fromkeys(captured) if variable is not None and variable.is_cell]


def _late_comprehension(w: Writer, node: Comprehension, late_variables: list[PythonVariable], result: Code) -> Code:
    """Return a comprehension whose variables are shared by all iterations, as captured variables are in Python.

    It is a loop that assigns the variables and concatenates lists.
    """
    temporaries = {variable: PythonVariable(variable.name, None, is_temporary=True) for variable in late_variables}
    w.late_variables.update(temporaries)
    code: Code = form("list", result)
    for generator in reversed(node.generators):
        if generator.ifs:
            tests = [write_test(w, condition) for condition in generator.ifs]
            test = tests[0] if len(tests) == 1 else form("and", *tests)
            code = form("if", test, code, quote(FormCode([])))
        own = {w.names.variables.get(n) for n in walk_tree(generator.target)}
        sets = [form("set!", VariableRef(v), VariableRef(temporaries[v])) for v in late_variables if v in own]
        clause = FormCode([write_pattern(w, generator.target), write_iterable(w, generator.iter)])
        code = FormCode([Name("for/append"), FormCode([clause]), *sets, code])
    for variable in late_variables:
        del w.late_variables[variable]
    return form("let", FormCode([FormCode([VariableRef(variable), none()]) for variable in late_variables]), code)


def _list_comprehension(w: Writer, node: ast.ListComp) -> Code:
    late = _late_variables(w, node)
    if late:
        joined = _late_comprehension(w, node, late, w.expr(node.elt))
        return form("mutable", joined) if w.is_mutated(node) else joined
    kind = "/union" if is_parts(w, node) else "/list"
    head = loop_head(w, kind, node.generators)
    code = FormCode([*head, w.comment_item(w.expr(node.elt), node.elt)])
    return form("mutable", code) if w.is_mutated(node) else code


def _generator(w: Writer, node: ast.GeneratorExp) -> Code:
    late = _late_variables(w, node)
    if late:
        return _late_comprehension(w, node, late, w.expr(node.elt))
    kind = "/union" if is_parts(w, node) else "/list"
    head = loop_head(w, kind, node.generators)
    return FormCode([*head, w.comment_item(w.expr(node.elt), node.elt)])


def _set_comprehension(w: Writer, node: ast.SetComp) -> Code:
    late = _late_variables(w, node)
    if late:
        return form("list->set", _late_comprehension(w, node, late, w.expr(node.elt)))
    return FormCode([*loop_head(w, "/set", node.generators), w.expr(node.elt)])


def _dict_comprehension(w: Writer, node: ast.DictComp) -> Code:
    late = _late_variables(w, node)
    if late:
        pair = form("list", w.expr(node.key), w.expr(node.value))
        return form("list->table", _late_comprehension(w, node, late, pair))
    head = loop_head(w, "/table", node.generators)
    return FormCode([*head, form("list", w.expr(node.key), w.expr(node.value))])


# Calls, functions and the rest.


def _call(w: Writer, node: ast.Call) -> Code:
    path = w.paths.of(node.func)
    if path is not None:
        handler = CALLS.get(path)
        if handler is not None:
            return handler(w, node)
        check_path(w, node.func, path)
        raise w.unsupported(f"`{w.text.text(node.func)}`", node)
    if isinstance(node.func, ast.Attribute):
        return call_method(w, node, node.func)
    return call_function(w, node)


def _lambda(w: Writer, node: ast.Lambda) -> Code:
    function = w.names.functions[node]
    bindings: list[Code] = []
    for parameter in function.parameters:
        if parameter.default is not None and not is_constant_default(w, parameter.default):
            variable = PythonVariable(parameter.variable.name, None, is_temporary=True)
            bindings.append(FormCode([VariableRef(variable), w.expr(parameter.default)]))
            w.defaults[parameter.default] = variable
    code = form("lambda", lambda_list(write_parameters(w, function)), *lambda_locals(w, function), w.expr(node.body))
    return form("let", FormCode(bindings), code) if bindings else code


def _conditional(w: Writer, node: ast.IfExp) -> Code:
    return form("if", write_test(w, node.test), w.expr(node.body), w.expr(node.orelse))


def _named_expression(w: Writer, node: ast.NamedExpr) -> Code:
    variable = w.names.variables.get(node.target)
    if variable is None:  # for example in the body of a class
        raise w.unsupported("`:=` here", node)
    return form("begin", form("set!", VariableRef(variable), w.expr(node.value)), VariableRef(variable))


def _starred(w: Writer, node: ast.Starred) -> Code:
    raise w.unsupported("`*` here", node)


def _yield(w: Writer, node: ast.Yield) -> Code:
    raise w.unsupported("`yield` inside an expression", node)


def _await(w: Writer, node: ast.Await) -> Code:
    raise w.unsupported("`await`", node)


_EXPRESSIONS: Mapping[type[ast.expr], Callable[[Writer, Any], Code]] = MappingProxyType({
    ast.Attribute: _attribute, ast.Await: _await, ast.BinOp: binary, ast.BoolOp: boolean, ast.Call: _call,
    ast.Compare: comparison, ast.Constant: _constant, ast.Dict: _dict, ast.DictComp: _dict_comprehension,
    ast.GeneratorExp: _generator, ast.IfExp: _conditional, ast.JoinedStr: interpolated, ast.Lambda: _lambda,
    ast.List: _list, ast.ListComp: _list_comprehension, ast.Name: _name, ast.NamedExpr: _named_expression,
    ast.Set: _set, ast.SetComp: _set_comprehension, ast.Starred: _starred, ast.Subscript: subscript,
    ast.Tuple: _tuple, ast.UnaryOp: unary, ast.Yield: _yield,
})  # fmt: skip
