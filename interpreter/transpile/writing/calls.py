"""Calls of library functions: the table from dotted paths to the functions that generate the calls."""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import TypeAlias

from scenelang.grammar.diagnostics import suggest
from scenelang.interpreter.runtime.modelling_helpers import (
    ASSERT_THAT,
    modelling_helpers,
    relation_helpers,
    scene_helpers,
)
from scenelang.interpreter.transpile.analysis.inference import (
    ARRAY,
    DICT,
    INT,
    LIST,
    POSE,
    RECORD,
    SET,
    SHAPE,
    STR,
    STREAM,
    TUPLE,
    AbstractType,
)
from scenelang.interpreter.transpile.analysis.rewriting import name_of
from scenelang.interpreter.transpile.analysis.scopes import PythonVariable
from scenelang.interpreter.transpile.writing import helpers, modelling
from scenelang.interpreter.transpile.writing.code import (
    Code,
    FormCode,
    Key,
    LiteralCode,
    Name,
    VariableRef,
    form,
    none,
    number,
)
from scenelang.interpreter.transpile.writing.numpy_calls import (
    DRAWS,
    CallWriter,
    draw,
    elementwise_call,
    is_vector,
    keyword_of,
    numeric_call,
    only_positional,
    plain_arguments,
    sort_options,
    with_kept_axis,
    write_arange,
    write_argsort,
    write_bool,
    write_callable,
    write_defaultdict,
    write_dict,
    write_dimensions,
    write_divmod,
    write_draw,
    write_enumerate,
    write_extreme,
    write_field,
    write_filter,
    write_float,
    write_int,
    write_isinstance,
    write_len,
    write_linspace,
    write_map,
    write_math_pow,
    write_meshgrid,
    write_next,
    write_np_append,
    write_np_array,
    write_np_bool,
    write_np_clip,
    write_np_columns,
    write_np_copy,
    write_np_diag,
    write_np_diff,
    write_np_eye,
    write_np_flip,
    write_np_float,
    write_np_isclose,
    write_np_like,
    write_np_median,
    write_np_norm,
    write_np_outer,
    write_np_repeat,
    write_np_reshape,
    write_np_roll,
    write_np_round,
    write_np_rows,
    write_np_shape,
    write_np_sort,
    write_np_stack,
    write_np_std,
    write_np_tile,
    write_np_where,
    write_pow,
    write_print,
    write_quantifier,
    write_range,
    write_reduction,
    write_reversed,
    write_round,
    write_seed,
    write_sequence,
    write_set,
    write_shuffle,
    write_sorted,
    write_str,
    write_stream,
    write_sum,
    write_zip,
)
from scenelang.interpreter.transpile.writing.operators import (
    after_effects,
    format_method,
    is_mask,
    never_contains,
    numeric,
    write_array,
    write_iterable,
)
from scenelang.interpreter.transpile.writing.user_calls import arguments_of, call_record_method
from scenelang.interpreter.transpile.writing.writer import Writer

MethodWriter: TypeAlias = "Callable[[Writer, ast.Call, ast.Attribute], Code]"


def call_method(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    """Return the code of ``owner.name(...)``."""

    owner = w.type(func.value)
    if func.attr.startswith("__"):
        raise w.error("python-forbidden", f"`.{func.attr}` accesses interpreter internals", func)
    if owner.classes or owner.kinds & RECORD:
        return call_record_method(w, node, func)
    if owner.kinds & STREAM:
        return _stream_method(w, node, func)
    if func.attr == "format" and owner.may(STR):
        return format_method(w, node, func)
    for kinds, table in _TABLES:
        if owner.kinds & kinds and func.attr in table:
            return table[func.attr](w, node, func)
    if (
        not owner.kinds or owner.only(SHAPE) or owner.kinds & ~0xFFFF
    ):  # an unknown type is inferred from the name of the method
        for _, table in _TABLES:
            if func.attr in table:
                return table[func.attr](w, node, func)
    reported = len(w.diagnostics)
    for part in (func.value, *node.args):
        w.expr(part)
    if len(w.diagnostics) > reported:
        return form("list")  # the error in an operand is already reported
    known = sorted({name for kinds, table in _TABLES if owner.kinds & kinds for name in table})
    raise w.unsupported(f"the method `.{func.attr}`", node, suggest(func.attr, known))


def _simple(head: str, signature: str = "") -> MethodWriter:
    """Return a writer that translates ``x.name(a)`` to ``(head x a)``."""

    def write(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
        given = arguments_of(w, node, signature, func.attr)
        return form(head, w.expr(func.value), *(w.expr(value) for value in given.values()))

    return write


def _list_method(head: str, signature: str = "") -> MethodWriter:
    """Return a writer like ``_simple`` for a method that returns a new list."""

    def write(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
        code = _simple(head, signature)(w, node, func)
        return form("mutable", code) if w.is_mutated(node) else code

    return write


# --- lists -----------------------------------------------------------------------------------------------------


def _extend(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "iterable", "extend")
    return form("extend!", w.expr(func.value), write_iterable(w, given["iterable"]))


def _pop(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "index? default?", "pop")
    return form("pop!", w.expr(func.value), *(w.expr(v) for v in given.values()))


def _popleft(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    return form("pop!", w.expr(func.value), LiteralCode(0))


def _appendleft(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    return form("insert!", w.expr(func.value), LiteralCode(0), w.expr(node.args[0]))


def _sort(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "key? reverse?", "sort")
    return form("sort!", w.expr(func.value), *sort_options(w, given))


def _copy(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    inferred = w.type(func.value)
    if w.is_mutated(node) or any(site.is_mutated for site in inferred.sites) or inferred.kinds & (DICT | SET):
        return form("mutable", w.expr(func.value))
    return w.expr(func.value)


def _count(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "x", "count")
    if never_contains(w, func.value, given["x"]):
        return after_effects(w, (func.value, given["x"]), number(0))
    return form("count", w.expr(func.value), w.expr(given["x"]))


# --- tables ----------------------------------------------------------------------------------------------------


def _get(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "key default?", "get")
    default = w.expr(given["default"]) if "default" in given else none()
    return form("ref", w.expr(func.value), w.expr(given["key"]), default)


def _setdefault(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "key default?", "setdefault")
    if not w.is_simple(func.value) or not w.is_simple(given["key"]):
        if w.effect(func.value, given["key"]).has_effect:
            raise w.unsupported("`setdefault` on an expression with side effects", node)

    def table() -> Code:
        return w.expr(func.value)

    default = w.expr(given["default"]) if "default" in given else none()
    test = form("has-key?", table(), w.expr(given["key"]))
    store = form("set-ref!", table(), w.expr(given["key"]), default)
    return form("begin", form("unless", test, store), form("ref", table(), w.expr(given["key"])))


def _update(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    pairs: list[Code] = []
    for keyword in node.keywords:
        if keyword.arg is None:
            raise w.unsupported("`**` in `update`", keyword)
        pairs += [LiteralCode(keyword.arg), w.expr(keyword.value)]
    if w.type(func.value).kinds & SET:
        return form("extend!", w.expr(func.value), *(write_iterable(w, a) for a in node.args))
    other: Code | None = form("table", *pairs) if pairs else None
    if node.args:
        inferred = w.type(node.args[0])
        other = w.expr(node.args[0]) if inferred.may(DICT) else form("list->table", w.expr(node.args[0]))
    return form("update!", w.expr(func.value), other or form("table"))


def _list_view(head: str) -> MethodWriter:
    def write(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
        arguments_of(w, node, "", func.attr)
        return form(head, w.expr(func.value))

    return write


# --- sets ------------------------------------------------------------------------------------------------------


def _set_operation(head: str) -> MethodWriter:
    def write(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
        return form(head, w.expr(func.value), *(write_iterable(w, a) for a in node.args))

    return write


def _isdisjoint(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    return form("empty?", form("set-intersection", w.expr(func.value), write_iterable(w, node.args[0])))


def _issuperset(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    return form("subset?", form("list->set", write_iterable(w, node.args[0])), w.expr(func.value))


def _discard(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    item = w.expr(node.args[0])
    return form(
        "when", form("contains?", w.expr(func.value), item), form("remove!", w.expr(func.value), w.expr(node.args[0]))
    )


# --- strings ---------------------------------------------------------------------------------------------------


def _join(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "iterable", "join")
    separator = func.value
    items = write_iterable(w, given["iterable"])
    if isinstance(separator, ast.Constant) and separator.value == "":
        return form("apply", Name("string-append"), items)
    return form("string-join", items, w.expr(separator))


def _string_find(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "sub", func.attr)
    position = form("string-index", w.expr(func.value), w.expr(given["sub"]))
    return form("or", position, LiteralCode(-1)) if func.attr == "find" else position


def _title(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    raise w.unsupported(f"`.{func.attr}()`", node, "write the text in the required case")


def _isdigit(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    return form("exact?", form("string->number", w.expr(func.value)))


def _splitlines(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    code = form("string-split", w.expr(func.value), LiteralCode("\n"))
    return form("mutable", code) if w.is_mutated(node) else code


def _cased(head: str, other: str) -> MethodWriter:
    """Return a writer for ``isupper`` or ``islower``: there are cased letters, all of this case."""

    def write(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
        same = form("equal?", w.expr(func.value), form(head, w.expr(func.value)))
        return form("and", same, form("not", form("equal?", w.expr(func.value), form(other, w.expr(func.value)))))

    return write


def _isalpha(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    letter = PythonVariable("letter", None, is_temporary=True)
    same = form("equal?", form("string-upcase", VariableRef(letter)), form("string-downcase", VariableRef(letter)))
    return FormCode(
        [Name("for/and"), FormCode([FormCode([VariableRef(letter), w.expr(func.value)])]), form("not", same)]
    )


def _isspace(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    return form("empty?", form("string-trim", w.expr(func.value)))


def _index(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "x", "index")
    if w.type(func.value).only(STR):
        position = form("string-index", w.expr(func.value), w.expr(given["x"]))
        return form("or", position, form("error", LiteralCode("substring not found")))
    if never_contains(w, func.value, given["x"]):
        return after_effects(w, (func.value, given["x"]), form("error", LiteralCode("the item is not in the list")))
    position = form("index-of", w.expr(func.value), w.expr(given["x"]))
    return form("or", position, form("error", LiteralCode("the item is not in the list")))


def _remove(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "x", "remove")
    if never_contains(w, func.value, given["x"]):
        return after_effects(w, (func.value, given["x"]), form("error", LiteralCode("the item is not in the list")))
    return form("remove!", w.expr(func.value), w.expr(given["x"]))


# --- arrays ----------------------------------------------------------------------------------------------------


def _array_reduction(head: str) -> MethodWriter:
    def write(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
        given = arguments_of(w, node, "axis? keepdims?", func.attr)
        options = [Key("axis"), w.expr(given["axis"])] if "axis" in given else []
        return with_kept_axis(w, form(head, w.expr(func.value), *options), given)

    return write


def _array_test(head: str) -> MethodWriter:
    def write(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
        only_positional(w, node)
        call = ast.copy_location(ast.Call(node.func, [func.value], []), node)
        if node.args or not (is_mask(w.type(func.value)) or is_vector(w.type(func.value))):
            raise w.unsupported(f"`.{func.attr}` of this array", node)
        return write_np_bool(head)(w, call)

    return write


def _astype(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "dtype", "astype")
    to = w.paths.of(given["dtype"]) or ""
    return form("truncate" if "int" in to else "inexact", w.expr(func.value))


def _same(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    return w.expr(func.value)


def _dot(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    inferred = w.type(func.value)
    return form("@" if inferred.kinds & POSE else "dot", write_array(w, func.value), write_array(w, node.args[0]))


def _array_copy(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    if w.is_mutated(node):
        return form("mutable-array", w.expr(func.value))
    return form("array", w.expr(func.value)) if w.may_change(func.value) else w.expr(func.value)


def _reshape(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    shape = w.expr(node.args[0]) if len(node.args) == 1 else form("list", *(w.expr(a) for a in node.args))
    return form("reshape", w.expr(func.value), shape)


def _array_clip(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "min max", "clip")
    return form("clip", w.expr(func.value), w.expr(given["min"]), w.expr(given["max"]))


# --- streams ---------------------------------------------------------------------------------------------------


def _stream_method(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    """Return a draw from a separate stream, ``rng.uniform(0, 1)``."""

    is_python = w.is_python_stream(func.value)
    name = {"integers": "randint"}.get(func.attr, func.attr)
    path = f"{'random' if is_python else 'numpy.random'}.{name}"
    stream = w.expr(func.value)
    if path in DRAWS:
        return draw(w, node, path, stream)
    if name == "shuffle":
        return form("py-shuffle!" if is_python else "shuffle!", w.expr(node.args[0]), Key("stream"), stream)
    if name in ("rand", "randn"):
        return form(name, *(w.expr(a) for a in node.args), Key("stream"), stream)
    raise w.unsupported(f"`.{func.attr}` of a random stream", node)


_ARRAY_METHODS: dict[str, MethodWriter] = {
    "sum": _array_reduction("sum"), "mean": _array_reduction("mean"), "max": _array_reduction("max"),
    "min": _array_reduction("min"), "prod": _array_reduction("product"), "argmin": _array_reduction("argmin"),
    "argmax": _array_reduction("argmax"), "cumsum": _array_reduction("cumsum"), "tolist": _list_method("->list"),
    "astype": _astype, "item": _same, "copy": _array_copy, "dot": _dot, "reshape": _reshape,
    "flatten": _simple("flatten"),
    "ravel": _simple("flatten"), "transpose": _simple("transpose"), "round": _simple("round", "decimals?"),
    "clip": _array_clip, "any": _array_test("/or"), "all": _array_test("/and"),
}  # fmt: skip
_LIST_METHODS: dict[str, MethodWriter] = {
    "append": _simple("push!", "x"), "extend": _extend, "insert": _simple("insert!", "index x"), "pop": _pop,
    "popleft": _popleft, "appendleft": _appendleft, "remove": _remove, "clear": _simple("clear!"),
    "sort": _sort, "reverse": _simple("reverse!"), "index": _index, "count": _count, "copy": _copy,
}  # fmt: skip
_DICT_METHODS: dict[str, MethodWriter] = {
    "get": _get, "setdefault": _setdefault, "items": _list_view("table-items"), "keys": _list_view("table-keys"),
    "values": _list_view("table-values"), "update": _update, "pop": _pop, "copy": _copy, "clear": _simple("clear!"),
}  # fmt: skip
_SET_METHODS: dict[str, MethodWriter] = {
    "add": _simple("add!", "x"), "remove": _simple("remove!", "x"), "discard": _discard, "update": _update,
    "union": _set_operation("set-union"), "intersection": _set_operation("set-intersection"),
    "difference": _set_operation("set-difference"), "issubset": _set_operation("subset?"), "issuperset": _issuperset,
    "isdisjoint": _isdisjoint, "copy": _copy, "clear": _simple("clear!"),
}  # fmt: skip
_STRING_METHODS: dict[str, MethodWriter] = {
    "upper": _simple("string-upcase"), "lower": _simple("string-downcase"), "strip": _simple("string-trim", "chars?"),
    "lstrip": _simple("string-trim-left", "chars?"), "rstrip": _simple("string-trim-right", "chars?"),
    "split": _list_method("string-split", "sep?"), "join": _join,
    "replace": _simple("string-replace", "old new count?"),
    "startswith": _simple("string-prefix?", "prefix"), "endswith": _simple("string-suffix?", "suffix"),
    "find": _string_find, "index": _index, "count": _count, "zfill": lambda w, node, func: form(
        "string-pad", w.expr(func.value), w.expr(node.args[0]), LiteralCode("0")),
    "splitlines": _splitlines, "isupper": _cased("string-upcase", "string-downcase"),
    "islower": _cased("string-downcase", "string-upcase"), "isalpha": _isalpha, "isspace": _isspace,
    "title": _title, "capitalize": _title, "isdigit": _isdigit, "rjust": _simple("string-pad", "width fill?"),
    "ljust": _simple("string-pad-right", "width fill?"),
}  # fmt: skip
_TABLES: tuple[tuple[int, dict[str, MethodWriter]], ...] = (
    (ARRAY | POSE, _ARRAY_METHODS),
    (DICT, _DICT_METHODS),
    (SET, _SET_METHODS),
    (LIST | TUPLE | SHAPE, _LIST_METHODS),
    (STR, _STRING_METHODS),
)


# --- methods ----------------------------------------------------------------------------------------------------------


# Calls of `math`.


def write_fmod(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x y", "math.fmod")
    return form("inexact", form("remainder", numeric(w, given["x"]), numeric(w, given["y"])))


def write_dist(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "p q", "math.dist")
    return form("distance", write_array(w, given["p"]), write_array(w, given["q"]))


def write_isclose(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a b rel_tol? abs_tol? rtol? atol?", "isclose")
    relative = given.get("rel_tol", given.get("rtol"))
    absolute = given.get("abs_tol", given.get("atol"))
    a, b = numeric(w, given["a"]), numeric(w, given["b"])
    largest = form("max", form("abs", numeric(w, given["a"])), form("abs", numeric(w, given["b"])))
    tolerance: Code = form("*", w.expr(relative) if relative is not None else LiteralCode(1e-9, None, "1e-9"), largest)
    if absolute is not None:
        tolerance = form("max", tolerance, w.expr(absolute))
    return form("<=", form("abs", form("-", a, b)), tolerance)


def write_factorial(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "n", "math.factorial")
    return form("product", form("range", number(1), form("+", w.expr(given["n"]), number(1))))


def write_copysign(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x y", "math.copysign")
    sign = given["y"]
    # the angle tells the zeros apart
    y = numeric(w, sign) if w.type(sign).only(INT) else form("atan", numeric(w, sign), number(-1))
    test = form("<", y, number(0))
    return form(
        "*",
        form("abs", numeric(w, given["x"])),
        form("if", test, LiteralCode(-1.0, None, "-1."), LiteralCode(1.0, None, "1.")),
    )


def write_cbrt(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x", "cbrt")
    return form(
        "*",
        form("sign", w.expr(given["x"])),
        form("expt", form("abs", w.expr(given["x"])), form("/", number(1), number(3))),
    )


def write_isqrt(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "n", "math.isqrt")
    return form("floor", form("sqrt", w.expr(given["n"])))


def write_prod(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable", "prod")
    return form("product", write_iterable(w, given["iterable"]))


# Calls of `itertools`, `functools`, `collections` and other small modules.


def write_reduce(w: Writer, node: ast.Call) -> Code:
    function, source, *start = plain_arguments(w, node)
    if w.paths.of(function) == "operator.add" and w.type(node).kinds & SHAPE:
        return form("union", *([w.expr(start[0])] if start else []), write_iterable(w, source))
    if start:
        return form("fold-left", w.expr(function), w.expr(start[0]), write_iterable(w, source))
    first = write_iterable(w, source)
    return form("fold-left", w.expr(function), form("first", first), form("rest", write_iterable(w, source)))


def write_itertools_product(w: Writer, node: ast.Call) -> Code:
    repeat = keyword_of(node, "repeat")
    sources = list(plain_arguments(w, node))
    if repeat is not None:
        if not isinstance(repeat, ast.Constant) or not isinstance(repeat.value, int) or not 0 < repeat.value < 9:
            raise w.unsupported("a `repeat` other than a constant from 1 to 8", repeat)
        sources = sources * repeat.value
    variables = [PythonVariable("item", None, is_temporary=True) for _ in sources]
    clauses = FormCode([FormCode([VariableRef(v), write_iterable(w, s)]) for v, s in zip(variables, sources)])
    return FormCode([Name("for*/list"), clauses, form("list", *(VariableRef(v) for v in variables))])


def write_combinations(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable r", "combinations")
    if not isinstance(given["r"], ast.Constant) or given["r"].value != 2:
        raise w.unsupported("`combinations` with a length other than 2", node)
    i, j, items = (PythonVariable(name, None, is_temporary=True) for name in ("i", "j", "items"))
    length = form("length", VariableRef(items))
    clauses = FormCode([
        FormCode([VariableRef(i), form("range", length)]),
        FormCode([VariableRef(j), form("range", form("+", VariableRef(i), number(1)), length)]),
    ])  # fmt: skip
    body = form(
        "list", form("ref", VariableRef(items), VariableRef(i)), form("ref", VariableRef(items), VariableRef(j))
    )
    return form(
        "let",
        FormCode([FormCode([VariableRef(items), write_iterable(w, given["iterable"])])]),
        FormCode([Name("for*/list"), clauses, body]),
    )


def write_chain(w: Writer, node: ast.Call) -> Code:
    if len(node.args) == 1 and isinstance(node.args[0], ast.Starred):
        return form("apply", Name("append"), write_iterable(w, node.args[0].value))
    return form("append", *(write_iterable(w, a) for a in plain_arguments(w, node)))


def write_chain_from_iterable(w: Writer, node: ast.Call) -> Code:
    items = arguments_of(w, node, "iterable", "chain.from_iterable")["iterable"]
    if any(site.element.kinds & SHAPE for site in w.type(node).sites):  # whose primitives are not taken out
        return form("union", write_iterable(w, items))
    return form("apply", Name("append"), write_iterable(w, items))


def write_cycle(w: Writer, node: ast.Call) -> Code:
    """Return a cycle as a mutable list that ``next`` rotates; as a list, it would end after one turn."""
    outer = w.parent(node)
    variable = w.variable(outer.targets[0]) if isinstance(outer, ast.Assign) else None
    calls = [w.parent(read) for read in w.reads_of(variable)] if variable is not None else [outer]
    if not all(isinstance(call, ast.Call) and name_of(call) in ("next", "zip") for call in calls):
        raise w.unsupported("`cycle` but in `next`, `zip` and `islice`", node, "use an index modulo the length")
    return form("mutable", write_iterable(w, arguments_of(w, node, "iterable", "itertools.cycle")["iterable"]))


def write_accumulate(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable", "itertools.accumulate")
    return form("->list", form("cumsum", write_iterable(w, given["iterable"])))


def write_itertools_repeat(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "object times", "itertools.repeat")
    return form("make-list", w.expr(given["times"]), w.expr(given["object"]))


def write_hsv(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "h s v", "colorsys.hsv_to_rgb")
    return form("hsv", *(numeric(w, given[name]) for name in "hsv"))


def write_copy(w: Writer, node: ast.Call) -> Code:
    value = arguments_of(w, node, "x", "copy")["x"]
    is_deep = w.paths.of(node.func) == "copy.deepcopy"
    if w.type(value).kinds & RECORD:
        raise w.unsupported("copying a record", node, "create a new record")
    return _copied(w, w.expr(value), w.type(value) | w.type(node), 0, is_deep=is_deep)


def _copied(w: Writer, code: Code, inferred: AbstractType, level: int, *, is_deep: bool) -> Code:
    """Return a copy of mutable containers, recursively for a deep copy; immutable values are not copied."""
    if not _is_mutated(inferred, 0) or level > 3:
        return code
    inner = AbstractType(0)
    for site in inferred.sites:
        inner = inner | site.element
    if not is_deep or not _is_mutated(inner, 0):
        return form("mutable", code)
    item = PythonVariable("item", None, is_temporary=True)
    copied = _copied(w, VariableRef(item), inner, level + 1, is_deep=True)
    if inferred.only(DICT):
        key = PythonVariable("key", None, is_temporary=True)
        clauses = FormCode([FormCode([FormCode([VariableRef(key), VariableRef(item)]), form("table-items", code)])])
        return FormCode([Name("for/table"), clauses, form("list", VariableRef(key), copied)])
    return form("mutable", FormCode([Name("for/list"), FormCode([FormCode([VariableRef(item), code])]), copied]))


def _is_mutated(inferred: AbstractType, level: int) -> bool:
    """Return whether a container, or one inside it, is modified anywhere."""
    return any(site.is_mutated or (level < 4 and _is_mutated(site.element, level + 1)) for site in inferred.sites)


def _not_here(what: str, hint: str) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        raise w.unsupported(what, node, hint)

    return write


CONSTANTS = {
    "math.pi": "pi", "math.tau": "tau", "math.e": "e", "math.inf": "inf", "math.nan": "nan",
    "numpy.pi": "pi", "numpy.e": "e", "numpy.inf": "inf", "numpy.nan": "nan",
}  # fmt: skip

# Functions of one or more numbers, elementwise on arrays.
_NUMERIC = {
    "sin": "sin", "cos": "cos", "tan": "tan", "asin": "asin", "acos": "acos", "atan": "atan", "sinh": "sinh",
    "cosh": "cosh", "tanh": "tanh", "sqrt": "sqrt", "exp": "exp", "log": "log", "log2": "log2", "log10": "log10",
    "radians": "deg", "degrees": "to-degrees", "floor": "floor", "ceil": "ceiling", "trunc": "truncate",
    "atan2": "atan", "hypot": "hypot", "fabs": "abs", "gcd": "gcd", "lcm": "lcm",
}  # fmt: skip
_NUMPY = {
    **_NUMERIC, "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan", "deg2rad": "deg",
    "rad2deg": "to-degrees", "abs": "abs", "absolute": "abs", "sign": "sign", "square": "square", "power": "expt",
    "mod": "%", "remainder": "%", "maximum": "max", "minimum": "min", "add": "+", "subtract": "-", "multiply": "*",
    "divide": "/", "negative": "-", "clip": "clip", "interp": "interp", "dot": "dot", "cross": "cross", "inner": "dot",
    "matmul": "@", "cumsum": "cumsum", "argmin": "argmin", "argmax": "argmax", "transpose": "transpose",
    "linalg.inv": "inverse", "linalg.det": "determinant", "linalg.solve": "solve", "vdot": "dot", "rint": "round",
}  # fmt: skip


CALLS: dict[str, CallWriter] = {
    **dict.fromkeys(scene_helpers(), modelling.modelling_call), ASSERT_THAT: modelling.assert_that,
    **dict.fromkeys(relation_helpers(), modelling.relation_alone),
    "library_call": helpers.library_call, "primitive_call": helpers.primitive_call, "loop": helpers.loop,
    "concat_shapes": helpers.concat_shapes, "transform_shape": helpers.transform_shape,
    "translation_matrix": helpers.translation_matrix, "rotation_matrix": helpers.rotation_matrix,
    "scale_matrix": helpers.scale_matrix, "reflection_matrix": helpers.reflection_matrix,
    "identity_matrix": helpers.identity_matrix, "register": helpers.registration,
    "register_animation": helpers.registration,
    **{f"compute_shape_{name}": helpers.box(name) for name in ("center", "min", "max", "sizes")},
    "len": write_len, "range": write_range, "enumerate": write_enumerate, "zip": write_zip, "map": write_map,
    "filter": write_filter,
    "sorted": write_sorted,
    "reversed": write_reversed, "min": write_extreme("min"), "max": write_extreme("max"), "sum": write_sum,
    "any": write_quantifier("/or"),
    "all": write_quantifier("/and"), "int": write_int, "float": write_float, "str": write_str, "repr": write_str,
    "bool": write_bool, "round": write_round,
    "list": write_sequence, "tuple": write_sequence, "iter": write_sequence, "set": write_set,
    "frozenset": write_set, "dict": write_dict,
    "divmod": write_divmod, "pow": write_pow, "abs": elementwise_call("abs"), "print": write_print,
    "isinstance": write_isinstance,
    "callable": write_callable, "next": write_next, "chr": numeric_call("chr"), "ord": numeric_call("ord"),
    **{f"math.{name}": numeric_call(head) for name, head in _NUMERIC.items()},
    "math.pow": write_math_pow, "math.fmod": write_fmod, "math.dist": write_dist, "math.isclose": write_isclose,
    "math.factorial": write_factorial,
    "math.copysign": write_copysign, "math.cbrt": write_cbrt, "math.isqrt": write_isqrt, "math.prod": write_prod,
    "math.fsum": write_sum,
    "math.isnan": numeric_call("nan?"), "math.isinf": numeric_call("infinite?"),
    "math.isfinite": numeric_call("finite?"),
    **{f"numpy.{name}": elementwise_call(head) for name, head in _NUMPY.items()},
    "numpy.array": write_np_array, "numpy.asarray": write_np_array, "numpy.zeros": write_np_shape("zeros"),
    "numpy.ones": write_np_shape("ones"),
    "numpy.empty": write_np_shape("zeros"), "numpy.full": write_np_shape("full"),
    "numpy.zeros_like": write_np_like("zeros"),
    "numpy.ones_like": write_np_like("ones"), "numpy.full_like": write_np_like("full"),
    "numpy.linspace": write_linspace,
    "numpy.arange": write_arange, "numpy.round": write_np_round, "numpy.around": write_np_round,
    "numpy.linalg.norm": write_np_norm,
    "numpy.stack": write_np_stack("stack-arrays"), "numpy.vstack": write_np_rows,
    "numpy.column_stack": write_np_stack("stack-arrays", 1), "numpy.concatenate": write_np_stack("concatenate"),
    "numpy.hstack": write_np_columns, "numpy.append": write_np_append, "numpy.where": write_np_where,
    "numpy.clip": write_np_clip,
    "numpy.sum": write_reduction("sum"), "numpy.mean": write_reduction("mean"), "numpy.max": write_reduction("max"),
    "numpy.min": write_reduction("min"), "numpy.amax": write_reduction("max"), "numpy.amin": write_reduction("min"),
    "numpy.prod": write_reduction("product"), "numpy.average": write_reduction("mean"), "numpy.float64": write_np_float,
    "numpy.float32": write_np_float, "numpy.int32": write_int, "numpy.int64": write_int, "numpy.eye": write_np_eye,
    "numpy.identity": write_np_eye, "numpy.diag": write_np_diag,
    "numpy.copy": write_np_copy, "numpy.any": write_np_bool("/or"), "numpy.all": write_np_bool("/and"),
    "numpy.sort": write_np_sort,
    "numpy.flip": write_np_flip, "numpy.reshape": write_np_reshape, "numpy.outer": write_np_outer,
    "numpy.allclose": write_np_isclose,
    "numpy.isclose": write_np_isclose, "numpy.repeat": write_np_repeat, "numpy.tile": write_np_tile,
    "numpy.cbrt": write_cbrt,
    "numpy.fmod": write_fmod, "numpy.trunc": elementwise_call("truncate"),
    **{path: write_draw(path) for path in DRAWS},
    "numpy.random.rand": write_dimensions("rand"), "numpy.random.randn": write_dimensions("randn"),
    "numpy.random.seed": write_seed("set-seed!"),
    "random.seed": write_seed("py-set-seed!"), "numpy.random.shuffle": write_shuffle("shuffle!"),
    "random.shuffle": write_shuffle("py-shuffle!"), "numpy.random.RandomState": write_stream("random-stream"),
    "numpy.random.default_rng": write_stream("default-rng"), "random.Random": write_stream("py-random-stream"),
    "functools.reduce": write_reduce, "itertools.product": write_itertools_product,
    "itertools.combinations": write_combinations,
    "itertools.chain": write_chain, "itertools.chain.from_iterable": write_chain_from_iterable,
    "itertools.repeat": write_itertools_repeat,
    "colorsys.hsv_to_rgb": write_hsv, "copy.copy": write_copy, "copy.deepcopy": write_copy,
    "collections.OrderedDict": write_dict,
    "numpy.diff": write_np_diff, "numpy.roll": write_np_roll, "numpy.std": write_np_std,
    "numpy.median": write_np_median, "numpy.random.get_state": numeric_call("random-state"),
    "numpy.random.set_state": numeric_call("set-random-state!"), "itertools.cycle": write_cycle,
    "itertools.accumulate": write_accumulate,
    "collections.deque": write_sequence, "collections.defaultdict": write_defaultdict, "numpy.argsort": write_argsort,
    "numpy.meshgrid": write_meshgrid, "dataclasses.field": write_field,
}  # fmt: skip


# --- functions as values ---


_VALUE_NAMES = {
    **{name: helper.counterpart for name, helper in modelling_helpers().items()},
    "len": "length", "abs": "abs", "min": "min", "max": "max", "sum": "sum", "float": "inexact", "int": "truncate",
    "round": "round", "sorted": "sort", "list": "->list", "tuple": "->list", "set": "list->set", "reversed": "reverse",
    "str.upper": "string-upcase", "concat_shapes": "union", "transform_shape": "transform",
    "translation_matrix": "translate", "compute_shape_center": "compute-shape-center", "operator.add": "+",
    "operator.mul": "*", "numpy.random.default_rng": "default-rng", "operator.sub": "-", "numpy.array": "array",
    "numpy.linalg.norm": "norm", "ord": "ord",
    "chr": "chr",
    **{f"math.{name}": head for name, head in _NUMERIC.items()},
    **{f"numpy.{name}": head for name, head in _NUMPY.items()},
}  # fmt: skip


def _value(name: str) -> Callable[[Writer], Code]:
    return lambda w: Name(name)


def _str_value(w: Writer) -> Code:
    w.imports.add("std/python.scene")
    return Name("py-str")


VALUES: dict[str, Callable[[Writer], Code]] = {
    **{path: _value(name) for path, name in _VALUE_NAMES.items()},
    "str": _str_value,
}
