"""Method calls on lists, dicts, sets, strings, arrays, random streams and the program's own classes."""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import TypeAlias

from scenelang.grammar.diagnostics import suggest
from scenelang.interpreter.transpile.analysis.inference import (
    ARRAY,
    DICT,
    LIST,
    POSE,
    RECORD,
    SET,
    SHAPE,
    STR,
    STREAM,
    TUPLE,
)
from scenelang.interpreter.transpile.analysis.scopes import PythonVariable
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
from scenelang.interpreter.transpile.writing.numpy_calls import DRAWS, draw, sort_options
from scenelang.interpreter.transpile.writing.operators import (
    after_effects,
    format_method,
    never_contains,
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
    found = w.type(func.value)
    if w.is_mutated(node) or any(site.is_mutated for site in found.sites) or found.kinds & (DICT | SET):
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
        found = w.type(node.args[0])
        other = w.expr(node.args[0]) if found.may(DICT) else form("list->table", w.expr(node.args[0]))
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
    found = form("string-index", w.expr(func.value), w.expr(given["sub"]))
    return form("or", found, LiteralCode(-1)) if func.attr == "find" else found


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
        found = form("string-index", w.expr(func.value), w.expr(given["x"]))
        return form("or", found, form("error", LiteralCode("substring not found")))
    if never_contains(w, func.value, given["x"]):
        return after_effects(w, (func.value, given["x"]), form("error", LiteralCode("the item is not in the list")))
    found = form("index-of", w.expr(func.value), w.expr(given["x"]))
    return form("or", found, form("error", LiteralCode("the item is not in the list")))


def _remove(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "x", "remove")
    if never_contains(w, func.value, given["x"]):
        return after_effects(w, (func.value, given["x"]), form("error", LiteralCode("the item is not in the list")))
    return form("remove!", w.expr(func.value), w.expr(given["x"]))


# --- arrays ----------------------------------------------------------------------------------------------------


def _array_reduction(head: str) -> MethodWriter:
    def write(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
        given = arguments_of(w, node, "axis?", func.attr)
        options = [Key("axis"), w.expr(given["axis"])] if "axis" in given else []
        return form(head, w.expr(func.value), *options)

    return write


def _astype(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    given = arguments_of(w, node, "dtype", "astype")
    to = w.paths.of(given["dtype"]) or ""
    return form("truncate" if "int" in to else "inexact", w.expr(func.value))


def _same(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    return w.expr(func.value)


def _dot(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    found = w.type(func.value)
    return form("@" if found.kinds & POSE else "dot", write_array(w, func.value), write_array(w, node.args[0]))


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
    "clip": _array_clip,
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
