"""Calls of Python's builtins, and of numpy: arrays, reductions and random draws."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Callable
from contextlib import suppress
from typing import TypeAlias

from scenelang.interpreter.transpile.analysis.inference import (
    ARRAY,
    BOOL,
    DICT,
    FLOAT,
    INT,
    LIST,
    NONE,
    NUMBERS,
    POSE,
    SEQUENCES,
    SET,
    SHAPE,
    STR,
    TUPLE,
    AbstractType,
)
from scenelang.interpreter.transpile.analysis.scopes import PythonVariable, is_none
from scenelang.interpreter.transpile.writing.code import (
    Brackets,
    Code,
    FormCode,
    Key,
    LiteralCode,
    Name,
    VariableRef,
    form,
    is_form,
    lambda_list,
    none,
    number,
    quote,
)
from scenelang.interpreter.transpile.writing.operators import (
    as_text,
    container,
    dynamic,
    is_mask,
    loop_head,
    numeric,
    parallel_sources,
    printable,
    truth,
    write_array,
    write_iterable,
    write_test,
)
from scenelang.interpreter.transpile.writing.user_calls import arguments_of, lambda_locals, predicate, write_parameters
from scenelang.interpreter.transpile.writing.writer import Writer


def write_np_array(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "object dtype? copy?", "np.array")
    source = given["object"]
    if w.type(source).only(NUMBERS):
        return numeric(w, source)
    if isinstance(source, (ast.List, ast.Tuple)) and not source.elts:
        code: Code = form("zeros", number(0))
    else:
        code = write_array(w, source)
    if not isinstance(code, Brackets) and not is_form(code, "array") and not w.type(source).only(ARRAY | POSE):
        code = form("array", code)
    elif not isinstance(code, Brackets) and w.may_change(source) and not w.is_mutated(node):
        code = form("array", code)  # a copy, because the source may be modified later
    if _is_float(w, given.get("dtype")):
        code = form("inexact", code)
    if w.is_mutated(node):
        return form("mutable-array", code)
    return code


def _is_float(w: Writer, dtype: ast.expr | None) -> bool:
    if dtype is None:
        return False
    if isinstance(dtype, ast.Constant):
        return str(dtype.value).startswith("float")
    return w.paths.of(dtype) in ("float", "numpy.float64", "numpy.float32", "numpy.float_")


def write_np_shape(head: str) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        given = arguments_of(w, node, "shape fill_value? dtype?" if head == "full" else "shape dtype?", f"np.{head}")
        items = [w.expr(given["shape"])]
        if head == "full":
            items.append(numeric(w, given["fill_value"]))
        code = form(head, *items)
        if w.paths.of(given["dtype"]) == "int" if "dtype" in given else False:
            code = form("exact", code)
        return form("mutable-array", code) if w.is_mutated(node) else code

    return write


def write_np_like(head: str) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        given = arguments_of(w, node, "a fill_value? dtype?", f"np.{head}_like")
        items: list[Code] = [form("array-shape", write_array(w, given["a"]))]
        if head == "full":
            items.append(numeric(w, given["fill_value"]))
        code = form(head, *items)
        return form("mutable-array", code) if w.is_mutated(node) else code

    return write


def write_linspace(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "start stop num? endpoint?", "np.linspace")
    items = [numeric(w, given["start"]), numeric(w, given["stop"])]
    if "num" in given:
        items.append(w.expr(given["num"]))
    endpoint = given.get("endpoint")
    if endpoint is not None and not (isinstance(endpoint, ast.Constant) and endpoint.value is True):
        items += [Key("endpoint"), write_test(w, endpoint)]
    code = form("linspace", *items)
    return form("mutable-array", code) if w.is_mutated(node) else code


def write_arange(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "start stop? step?", "np.arange")
    return form("arange", *(numeric(w, value) for value in given.values()))


def write_reduction(head: str) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        given = arguments_of(w, node, "a axis? keepdims?", f"np.{head}")
        source = given["a"]
        code = write_array(w, source) if w.type(source).kinds & ARRAY else write_iterable(w, source)
        options = [Key("axis"), w.expr(given["axis"])] if "axis" in given else []
        return with_kept_axis(w, form(head, code, *options), given)

    return write


def with_kept_axis(w: Writer, code: Code, given: dict[str, ast.expr]) -> Code:
    """Return a reduction along an axis that stays, with one item, where ``keepdims`` says so."""
    kept, axis = given.get("keepdims"), given.get("axis")
    if kept is None or (isinstance(kept, ast.Constant) and kept.value is False):
        return code
    if axis is None or not isinstance(kept, ast.Constant):
        raise w.unsupported("`keepdims` without an axis", kept)
    return form("expand-dims", code, w.expr(axis))


def write_np_norm(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x axis? keepdims?", "np.linalg.norm")
    if "axis" in given:
        square = form("square", write_array(w, given["x"]))
        return with_kept_axis(w, form("sqrt", form("sum", square, Key("axis"), w.expr(given["axis"]))), given)
    inner = given["x"]
    if isinstance(inner, ast.BinOp) and isinstance(inner.op, ast.Sub) and w.type(inner).only(ARRAY):
        if not isinstance(inner.left, ast.BinOp):
            return form("distance", write_array(w, inner.left), write_array(w, inner.right))
    return form("norm", write_array(w, inner))


def write_np_stack(head: str, axis: int | None = None) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        given = arguments_of(w, node, "arrays axis?", f"np.{head}")
        source = given["arrays"]
        if isinstance(source, (ast.List, ast.Tuple)) and not any(isinstance(e, ast.Starred) for e in source.elts):
            items = [write_array(w, e) for e in source.elts]
        else:
            items = [write_iterable(w, source)]
        if "axis" in given:
            items += [Key("axis"), w.expr(given["axis"])]
        elif axis is not None:
            items += [Key("axis"), number(axis)]
        return form(head, *items)

    return write


def is_matrix(inferred: AbstractType) -> bool:
    """Return whether a value is known to be two-dimensional."""
    if inferred.only(POSE):
        return True
    return inferred.only(ARRAY | SEQUENCES) and bool(inferred.sites) and all(
        site.element.only(ARRAY | SEQUENCES) for site in inferred.sites
    )  # fmt: skip


def is_vector(inferred: AbstractType) -> bool:
    """Return whether a value is known to be one-dimensional."""
    return (
        inferred.only(ARRAY | SEQUENCES)
        and bool(inferred.sites)
        and all(site.element.only(NUMBERS) for site in inferred.sites)
    )


def write_np_rows(w: Writer, node: ast.Call) -> Code:
    """Return the code of ``np.vstack``, which stacks vectors as rows and concatenates matrices."""
    source = arguments_of(w, node, "tup", "np.vstack")["tup"]
    if not isinstance(source, (ast.List, ast.Tuple)) or any(isinstance(e, ast.Starred) for e in source.elts):
        items = w.type(source).sites
        head = "concatenate" if items and all(is_matrix(site.element) for site in items) else "stack-arrays"
        return form(head, write_iterable(w, source))
    if not any(is_matrix(w.type(e)) for e in source.elts):
        return form("stack-arrays", *(write_array(w, e) for e in source.elts))
    row = quote(FormCode([number(1), number(-1)]))
    codes = [
        write_array(w, e) if is_matrix(w.type(e)) else form("reshape", write_array(w, e), row) for e in source.elts
    ]
    return form("concatenate", *codes)


def write_np_columns(w: Writer, node: ast.Call) -> Code:
    """Return the code of ``np.hstack``, which concatenates vectors, and matrices along their columns."""
    source = arguments_of(w, node, "tup", "np.hstack")["tup"]
    if isinstance(source, (ast.List, ast.Tuple)) and not any(isinstance(e, ast.Starred) for e in source.elts):
        types = [w.type(e) for e in source.elts]
        codes = [
            form("vector", w.expr(e)) if t.only(NUMBERS) else write_array(w, e) for e, t in zip(source.elts, types)
        ]
    else:
        codes, types = [write_iterable(w, source)], [site.element for site in w.type(source).sites]
    options = [Key("axis"), number(1)] if types and all(is_matrix(inferred) for inferred in types) else []
    return form("concatenate", *codes, *options)


def write_np_append(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "arr values", "np.append")
    values = given["values"]
    second = write_array(w, values) if not w.type(values).only(NUMBERS) else form("vector", w.expr(values))
    return form("concatenate", write_array(w, given["arr"]), second)


def write_np_where(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "condition a b", "np.where")
    if w.type(given["condition"]).only(BOOL):
        return form("if", write_test(w, given["condition"]), w.expr(given["a"]), w.expr(given["b"]))
    return form("where", *(write_array(w, given[name]) for name in ("condition", "a", "b")))


def write_np_clip(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a a_min? a_max? min? max?", "np.clip")
    low, high = given.get("a_min", given.get("min")), given.get("a_max", given.get("max"))
    low, high = (None if b is None or is_none(b) else b for b in (low, high))
    if low is None or high is None:
        bound, head = (low, "max") if low is not None else (high, "min")
        if bound is None:
            return w.expr(given["a"])
        return form(head, write_array(w, given["a"]), write_array(w, bound))
    if w.type(given["a"]).only(NUMBERS):
        return form("clamp", *(numeric(w, x) for x in (given["a"], low, high)))
    return form("clip", write_array(w, given["a"]), write_array(w, low), write_array(w, high))


def write_np_float(w: Writer, node: ast.Call) -> Code:
    return form("inexact", numeric(w, node.args[0]))


def write_np_eye(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "n", "np.eye")
    code = form("eye", w.expr(given["n"]))
    return form("mutable-array", code) if w.is_mutated(node) else code


def write_np_diag(w: Writer, node: ast.Call) -> Code:
    """Return the code of ``np.diag`` of a vector, whose items are those of a diagonal."""
    source = arguments_of(w, node, "v", "np.diag")["v"]
    if not is_vector(w.type(source)):
        raise w.unsupported("`np.diag` of what may be a matrix", node)
    items = PythonVariable("items", None, is_temporary=True)
    bindings = FormCode([FormCode([VariableRef(items), write_array(w, source)])])
    return form("let", bindings, form("*", form("eye", form("length", VariableRef(items))), VariableRef(items)))


def write_np_isclose(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a b rtol? atol?", "np.isclose")
    difference = form("abs", form("-", write_array(w, given["a"]), write_array(w, given["b"])))
    relative = w.expr(given["rtol"]) if "rtol" in given else LiteralCode(1e-5, None, "1e-5")
    absolute = w.expr(given["atol"]) if "atol" in given else LiteralCode(1e-8, None, "1e-8")
    rest = form("-", difference, form("*", relative, form("abs", write_array(w, given["b"]))))
    largest = rest if w.is_numeric(given["a"]) and w.is_numeric(given["b"]) else form("max", rest)
    return form("<=", largest, absolute)


def write_np_diff(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a axis?", "np.diff")
    axis = given.get("axis")
    is_first = axis is not None and isinstance(axis, ast.Constant) and axis.value == 0
    if not is_first and (axis is not None or is_matrix(w.type(given["a"]))):
        raise w.unsupported("`np.diff` of what may be a matrix", node, "name the axis 0")
    array = PythonVariable("array", None, is_temporary=True)
    bounds = [number(1), none()], [number(0), number(-1)]
    following, before = (form("slice", VariableRef(array), quote(FormCode([*each]))) for each in bounds)
    return form(
        "let", FormCode([FormCode([VariableRef(array), write_array(w, given["a"])])]), form("-", following, before)
    )


def write_np_roll(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a shift axis?", "np.roll")
    axis = given.get("axis")
    is_first = axis is not None and isinstance(axis, ast.Constant) and axis.value == 0
    if (
        not is_first
        and not w.type(given["a"]).only(SEQUENCES)
        and (axis is not None or not is_vector(w.type(given["a"])))
    ):
        raise w.unsupported("`np.roll` of what may be a matrix", node, "name the axis 0")
    array, shift = PythonVariable("array", None, is_temporary=True), PythonVariable("shift", None, is_temporary=True)
    length = form("length", VariableRef(array))
    bindings = FormCode([
        FormCode([VariableRef(array), write_array(w, given["a"])]),
        FormCode([VariableRef(shift), form("-", length, form("%", w.expr(given["shift"]), length))]),
    ])  # fmt: skip
    bounds = [VariableRef(shift), none()], [number(0), VariableRef(shift)]
    parts = [form("slice", VariableRef(array), form("list", *each)) for each in bounds]  # rows, or items
    return form("let*", bindings, form("concatenate", *parts))


def write_np_std(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a", "np.std")
    array = PythonVariable("array", None, is_temporary=True)
    spread = form("mean", form("square", form("-", VariableRef(array), form("mean", VariableRef(array)))))
    return form("let", FormCode([FormCode([VariableRef(array), write_array(w, given["a"])])]), form("sqrt", spread))


def write_np_median(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a", "np.median")
    array, count = PythonVariable("array", None, is_temporary=True), PythonVariable("count", None, is_temporary=True)
    low = form("ref", VariableRef(array), form("//", form("-", VariableRef(count), number(1)), number(2)))
    high = form("ref", VariableRef(array), form("//", VariableRef(count), number(2)))
    bindings = FormCode([
        FormCode([VariableRef(array), form("sort", form("flatten", write_array(w, given["a"])))]),
        FormCode([VariableRef(count), form("length", VariableRef(array))]),
    ])  # fmt: skip
    return form("let*", bindings, form("/", form("+", low, high), number(2)))


def write_np_copy(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a", "np.copy")
    code = write_array(w, given["a"])
    if w.is_mutated(node):
        return form("mutable-array", code)
    return form("array", code) if w.may_change(given["a"]) else code


def write_np_bool(head: str) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        if len(node.args) == 1 and is_mask(w.type(node.args[0])):
            return form("=", form("max" if head == "/or" else "min", w.expr(node.args[0])), number(1))
        return write_quantifier(head)(w, node)

    return write


def write_np_sort(w: Writer, node: ast.Call) -> Code:
    return form("sort", write_array(w, arguments_of(w, node, "a", "np.sort")["a"]))


def write_np_flip(w: Writer, node: ast.Call) -> Code:
    return form("reverse", write_array(w, arguments_of(w, node, "a", "np.flip")["a"]))


def write_np_reshape(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a shape", "np.reshape")
    return form("reshape", write_array(w, given["a"]), w.expr(given["shape"]))


def write_np_outer(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a b", "np.outer")
    column = form("reshape", write_array(w, given["a"]), quote(FormCode([number(-1), number(1)])))
    return form("*", column, write_array(w, given["b"]))


def write_np_repeat(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a repeats", "np.repeat")
    item = PythonVariable("item", None, is_temporary=True)
    body = form("make-list", w.expr(given["repeats"]), VariableRef(item))
    return form(
        "array",
        FormCode([Name("for/append"), FormCode([FormCode([VariableRef(item), write_array(w, given["a"])])]), body]),
    )


def write_np_tile(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a reps", "np.tile")
    return form("array", form("repeat", form("->list", write_array(w, given["a"])), w.expr(given["reps"])))


def write_argsort(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a", "np.argsort")
    keys, item = PythonVariable("keys", None, is_temporary=True), PythonVariable("i", None, is_temporary=True)
    key = FormCode([Name("lambda"), FormCode([VariableRef(item)]), form("ref", VariableRef(keys), VariableRef(item))])
    order = form("array", form("sort", form("range", form("length", VariableRef(keys))), Key("key"), key))
    return form("let", FormCode([FormCode([VariableRef(keys), write_array(w, given["a"])])]), order)


def write_meshgrid(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x y indexing?", "np.meshgrid")
    x, y = PythonVariable("x", None, is_temporary=True), PythonVariable("y", None, is_temporary=True)
    rows = form("stack-arrays", form("make-list", form("length", VariableRef(y)), VariableRef(x)))
    columns = form("transpose", form("stack-arrays", form("make-list", form("length", VariableRef(x)), VariableRef(y))))
    order = given.get("indexing")
    if order is not None and not (isinstance(order, ast.Constant) and order.value in ("ij", "xy")):
        raise w.unsupported("a computed argument `indexing`", order)
    is_matrix = order is not None and isinstance(order, ast.Constant) and order.value == "ij"
    names = ("y", "x") if is_matrix else ("x", "y")  # with "ij" the first array changes along the first axis
    bindings = FormCode(
        [
            FormCode([VariableRef(x), write_array(w, given[names[0]])]),
            FormCode([VariableRef(y), write_array(w, given[names[1]])]),
        ]
    )
    return form("let*", bindings, form("list", *((columns, rows) if is_matrix else (rows, columns))))


def write_defaultdict(w: Writer, node: ast.Call) -> Code:
    arguments_of(w, node, "factory?", "defaultdict")
    return form("table")


def write_field(w: Writer, node: ast.Call) -> Code:
    raise w.unsupported("`field` outside a dataclass", node)


# Draws from `random` and `numpy.random`.


DRAWS: dict[str, tuple[str, str]] = {
    # path: (builtin, parameters in order; after ":" the keyword of the builtin)
    "numpy.random.uniform": ("uniform", "low? high? size?:size"),
    "numpy.random.normal": ("normal", "loc? scale? size?:size"),
    "numpy.random.standard_normal": ("normal", "size?:size"),
    "numpy.random.randint": ("randint", "low high? size?:size dtype?"),
    "numpy.random.random": ("random", "size?:size"),
    "numpy.random.random_sample": ("random", "size?:size"),
    "numpy.random.choice": ("choice", "a size?:size replace?:replace p?:p"),
    "numpy.random.permutation": ("permutation", "x"),
    "random.random": ("py-random", ""),
    "random.uniform": ("py-uniform", "a b"),
    "random.gauss": ("py-gauss", "mu? sigma?"),
    "random.randint": ("py-randint", "a b"),
    "random.randrange": ("py-randrange", "start stop? step?"),
    "random.choice": ("py-choice", "seq"),
    "random.choices": ("py-choices", "population weights?:weights k?:k"),
    "random.sample": ("py-sample", "population k"),
}
_SEQUENCE_PARAMETERS = ("a", "seq", "population", "x")
_NO_KEYWORD_VALUES = ("dtype",)


def draw(w: Writer, node: ast.Call, path: str, stream: Code | None = None) -> Code:
    """Return a draw from the global stream or ``stream``."""
    head, signature = DRAWS[path]
    parameters = [p.partition(":") for p in signature.split()]
    given = arguments_of(w, node, " ".join(p[0] for p in parameters), path)
    items: list[Code] = []
    options: list[Code] = []
    pending: list[ast.expr] = []
    for name, _, keyword in parameters:
        name = name.rstrip("?")
        value = given.get(name)
        if value is None or name in _NO_KEYWORD_VALUES or (keyword and is_none(value)):
            continue
        if keyword:
            options += [Key(keyword), write_test(w, value) if keyword == "replace" else w.expr(value)]
            continue
        items += [_draw_argument(w, v, name) for v in (*pending, value)]
        pending = []
    items = _fill_gaps(path, given, items)
    if stream is not None:
        options += [Key("stream"), stream]
    code = form(head, *items, *options)
    if path == "numpy.random.permutation" and not w.type(node.args[0]).only(INT) and w.type(node).kinds & ARRAY:
        code = form("permutation", write_array(w, node.args[0]), *options)
    return form("mutable", code) if w.is_mutated(node) else code


def _draw_argument(w: Writer, value: ast.expr, name: str) -> Code:
    if name in _SEQUENCE_PARAMETERS and not w.type(value).only(NUMBERS):
        return write_iterable(w, value)
    return numeric(w, value)


def _fill_gaps(path: str, given: dict[str, ast.expr], items: list[Code]) -> list[Code]:
    """Insert defaults for optional arguments before a given one, as in ``np.random.normal(scale=.1)``."""
    first = {
        "numpy.random.normal": ("loc", "scale", 0),
        "numpy.random.uniform": ("low", "high", 0),
        "random.gauss": ("mu", "sigma", 0),
    }
    rule = first.get(path)
    if rule is not None and rule[1] in given and rule[0] not in given:
        return [number(rule[2]), *items]
    if path == "numpy.random.uniform" and "low" in given and "high" not in given:
        return [*items, number(1)]
    return items


def write_draw(path: str) -> CallWriter:
    return lambda w, node: draw(w, node, path)


def write_dimensions(head: str) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        only_positional(w, node)
        return form(head if node.args else ("random" if head == "rand" else "normal"), *(w.expr(a) for a in node.args))

    return write


def write_shuffle(head: str) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        return form(head, w.expr(arguments_of(w, node, "x", "shuffle")["x"]))

    return write


def _seed_number(seed: bytes | bool) -> int:
    """Return the number by which ``random.seed`` starts its stream for another value, as CPython does (version 2)."""
    return int(seed) if isinstance(seed, bool) else int.from_bytes(seed + hashlib.sha512(seed).digest(), "big")


def write_seed(head: str) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        given = [*node.args, *(keyword.value for keyword in node.keywords if keyword.arg in ("a", "seed"))]
        if not given or is_none(given[0]):
            raise w.unsupported("seeding from the clock", node, "pass a number as the seed")
        seed = None
        with suppress(ValueError, TypeError):
            seed = ast.literal_eval(given[0])
        if head == "py-set-seed!" and isinstance(seed, (bytes, bool)):  # kinds of values that the language lacks
            return form(head, LiteralCode(_seed_number(seed)))
        return form(head, w.expr(given[0]))

    return write


def write_stream(head: str) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        return form(head, *(w.expr(a) for a in (*node.args, *(k.value for k in node.keywords)) if not is_none(a)))

    return write


# Builtins.


# Helpers for the writers of library calls.


CallWriter: TypeAlias = "Callable[[Writer, ast.Call], Code]"


def numeric_call(head: str) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        only_positional(w, node)
        return form(head, *(numeric(w, argument) for argument in node.args))

    return write


def elementwise_call(head: str) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        items = [write_array(w, a) if not w.type(a).only(NUMBERS) else numeric(w, a) for a in plain_arguments(w, node)]
        for keyword in node.keywords:
            if keyword.arg != "axis":
                raise w.unsupported(f"`{keyword.arg}` here", keyword)
            items += [Key("axis"), w.expr(keyword.value)]
        return form(head, *items)

    return write


def plain_arguments(w: Writer, node: ast.Call) -> list[ast.expr]:
    for argument in node.args:
        if isinstance(argument, ast.Starred):
            raise w.unsupported("a `*` argument in this call", argument)
    return node.args


def only_positional(w: Writer, node: ast.Call) -> None:
    plain_arguments(w, node)
    if node.keywords:
        raise w.unsupported(f"the argument `{node.keywords[0].arg}` of `{w.text.text(node.func)}`", node.keywords[0])


def keyword_of(node: ast.Call, name: str) -> ast.expr | None:
    return next((k.value for k in node.keywords if k.arg == name), None)


def is_comprehension(node: ast.expr) -> bool:
    return isinstance(node, (ast.GeneratorExp, ast.ListComp))


def write_len(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x", "len")
    return form("length", container(w, given["x"]))


def write_range(w: Writer, node: ast.Call) -> Code:
    only_positional(w, node)
    code = form("range", *(numeric(w, a) for a in node.args))
    return form("mutable", code) if w.is_mutated(node) else code


def write_enumerate(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable start?", "enumerate")
    start = given.get("start")
    return form("enumerate", write_iterable(w, given["iterable"]), *([w.expr(start)] if start is not None else []))


def write_zip(w: Writer, node: ast.Call) -> Code:
    if len(node.args) == 1 and isinstance(node.args[0], ast.Starred):
        return form("apply", Name("zip"), write_iterable(w, node.args[0].value))
    return form("zip", *parallel_sources(w, plain_arguments(w, node)))


def write_map(w: Writer, node: ast.Call) -> Code:
    if len(node.args) < 2:
        raise w.error("python-call", "`map` expects a function and a sequence", node)
    function, *sources = plain_arguments(w, node)
    is_text = all(site.element.only(STR) for site in w.type(sources[0]).sites) and w.type(sources[0]).kinds != 0
    if w.paths.of(function) in ("int", "float") and is_text:
        return form("map", Name("string->number"), write_iterable(w, sources[0]))
    return form("map", w.expr(function), *(write_iterable(w, source) for source in sources))


def write_filter(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "function iterable", "filter")
    function = given["function"]
    if is_none(function):
        item = PythonVariable("item", None, is_temporary=True)
        element = w.facts.type(node)
        test = VariableRef(item) if element.only(BOOL) else dynamic(w, "py-truthy?", VariableRef(item))
        code: Code = FormCode([Name("lambda"), FormCode([VariableRef(item)]), test])
    elif isinstance(function, ast.Lambda):
        inner = w.names.functions[function]
        code = form(
            "lambda", lambda_list(write_parameters(w, inner)), *lambda_locals(w, inner), write_test(w, function.body)
        )
    else:
        code = w.expr(function)
    return form("filter", code, write_iterable(w, given["iterable"]))


def write_sorted(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable key? reverse?", "sorted")
    code = form("sort", write_iterable(w, given["iterable"]), *sort_options(w, given))
    inferred = w.type(given["iterable"])
    if not inferred.only(LIST | TUPLE):
        code = form("sort", form("->list", code.items[1]), *code.items[2:])
    return form("mutable", code) if w.is_mutated(node) else code


def sort_options(w: Writer, given: dict[str, ast.expr]) -> list[Code]:
    """Return the options ``:key`` and ``:reverse`` of a sort."""
    options: list[Code] = []
    key, reverse = given.get("key"), given.get("reverse")
    if key is not None and not is_none(key):
        options += [Key("key"), w.expr(key)]
    if reverse is not None and not (isinstance(reverse, ast.Constant) and reverse.value is False):
        options += [Key("reverse"), write_test(w, reverse)]
    return options


def write_reversed(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "sequence", "reversed")
    source = write_iterable(w, given["sequence"])
    if w.type(given["sequence"]).kinds & (STR | ARRAY):
        source = form("->list", source)
    code = form("reverse", source)
    return form("mutable", code) if w.is_mutated(node) else code


def write_extreme(which: str) -> CallWriter:
    """Return the writer of calls of ``min`` or ``max``."""

    def write(w: Writer, node: ast.Call) -> Code:
        """Return the code of a call of ``min`` or ``max``."""
        key, default = keyword_of(node, "key"), keyword_of(node, "default")
        for keyword in node.keywords:
            if keyword.arg not in ("key", "default"):
                raise w.unsupported(f"the argument `{keyword.arg}` of `{which}`", keyword)
        args = node.args
        starred = any(isinstance(a, ast.Starred) for a in args)
        if starred and len(args) > 1:
            joined = ast.copy_location(ast.List(list(args), ast.Load()), node)
            source, element = w.expr(joined), w.type(node)
        elif len(args) == 1:
            inner = args[0].value if isinstance(args[0], ast.Starred) else args[0]
            source, element = write_iterable(w, inner), w.type(node)
        else:
            inferred = w.type(node)
            is_numeric = inferred.only(NUMBERS | ARRAY) or not inferred.kinds or inferred.only(INT | FLOAT | NONE)
            if key is None and is_numeric:
                return form(which, *(numeric(w, a) for a in args))
            source, element = form("list", *(w.expr(a) for a in args)), inferred
        options = [Key("key"), w.expr(key)] if key is not None else []
        # `min` and `max` take numbers only, `min-of` and `max-of` any ordered values
        plain = key is None and (element.only(INT | FLOAT) or not element.kinds)
        code = form(which, source) if plain else form(f"{which}-of", source, *options)
        if default is not None:
            test = form("empty?", source)
            return form("if", test, w.expr(default), code)
        return code

    return write


def write_sum(w: Writer, node: ast.Call) -> Code:
    """Return the code of ``sum``: a union of shapes, a list of the items of lists, or a sum of numbers."""
    given = arguments_of(w, node, "iterable start?", "sum")
    source, start = given["iterable"], given.get("start")
    element = w.facts.type(source)
    if any(site.element.kinds & SHAPE for site in element.sites):
        return form("union", write_iterable(w, source))
    if start is not None and w.type(start).kinds & SEQUENCES:
        code = form("apply", Name("append"), w.expr(start), write_iterable(w, source))
        return form("mutable", code) if w.is_mutated(node) else code
    if isinstance(source, (ast.GeneratorExp, ast.ListComp)):
        head = loop_head(w, "/sum", source.generators)
        total: Code = FormCode([*head, numeric(w, source.elt)])
    elif _sums_booleans(w, source):
        # Booleans are not numbers in the language
        item = PythonVariable("item", None, is_temporary=True)
        clauses = FormCode([FormCode([VariableRef(item), write_iterable(w, source)])])
        total = FormCode([Name("for/sum"), clauses, form("if", VariableRef(item), number(1), number(0))])
    else:
        total = form("sum", write_iterable(w, source) if not element.kinds & ARRAY else w.expr(source))
    if start is None or (isinstance(start, ast.Constant) and start.value == 0):
        return total
    return form("+", numeric(w, start), total)


def _sums_booleans(w: Writer, source: ast.expr) -> bool:
    sites = w.type(source).sites
    return bool(sites) and all(site.element.only(BOOL) for site in sites)


def write_quantifier(kind: str) -> CallWriter:
    def write(w: Writer, node: ast.Call) -> Code:
        source = arguments_of(w, node, "iterable", "any" if kind == "/or" else "all")["iterable"]
        if isinstance(source, (ast.GeneratorExp, ast.ListComp)):
            return FormCode([*loop_head(w, kind, source.generators), write_test(w, source.elt)])
        item = PythonVariable("item", None, is_temporary=True)
        sites = w.type(source).sites
        is_plain = bool(sites) and all(site.element.only(BOOL) for site in sites)
        test = VariableRef(item) if is_plain else dynamic(w, "py-truthy?", VariableRef(item))
        return FormCode(
            [Name(f"for{kind}"), FormCode([FormCode([VariableRef(item), write_iterable(w, source)])]), test]
        )

    return write


def write_int(w: Writer, node: ast.Call) -> Code:
    if not node.args:
        return number(0)
    given = arguments_of(w, node, "x base?", "int")
    inferred = w.type(given["x"])
    if inferred.only(STR):
        base = [w.expr(given["base"])] if "base" in given else []
        return form("truncate", form("string->number", form("string-trim", w.expr(given["x"])), *base))
    if inferred.only(INT):
        return w.expr(given["x"])
    inner = given["x"]
    if isinstance(inner, ast.Call) and w.paths.of(inner.func) in (
        "numpy.floor",
        "numpy.ceil",
        "numpy.round",
        "math.floor",
    ):
        return w.expr(inner)
    return form("truncate", numeric(w, inner))


def write_float(w: Writer, node: ast.Call) -> Code:
    if not node.args:
        return LiteralCode(0.0, None, "0.")
    given = arguments_of(w, node, "x", "float")
    inferred = w.type(given["x"])
    if inferred.only(STR):
        if isinstance(given["x"], ast.Constant) and str(given["x"].value).strip("+ ").lower() in ("inf", "infinity"):
            return Name("inf")
        return form("inexact", form("string->number", w.expr(given["x"])))
    return w.expr(given["x"]) if inferred.only(FLOAT) else form("inexact", numeric(w, given["x"]))


def write_str(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x", "str")
    inferred = w.type(given["x"])
    if inferred.only(STR):
        return w.expr(given["x"])
    if inferred.only(INT | FLOAT):
        return form("number->string", w.expr(given["x"]))
    return as_text(w, given["x"])


def write_bool(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x", "bool")
    return (
        form("not", form("not", truth(w, given["x"], w.type(given["x"]))))
        if not w.type(given["x"]).only(BOOL)
        else w.expr(given["x"])
    )


def write_round(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "number ndigits?", "round")
    digits = given.get("ndigits")
    if digits is None or is_none(digits):
        return form("round", numeric(w, given["number"]))
    return form("round", numeric(w, given["number"]), w.expr(digits))


def write_np_round(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a decimals?", "np.round")
    decimals = given.get("decimals")
    return form("round", write_array(w, given["a"]), *([w.expr(decimals)] if decimals is not None else []))


def write_sequence(w: Writer, node: ast.Call) -> Code:
    """Return the code of ``list(x)`` or ``tuple(x)``."""
    if not node.args and not node.keywords:
        return form("mutable-list") if w.is_mutated(node) else quote(FormCode([]))
    source = arguments_of(w, node, "iterable", "list")["iterable"]
    is_mutable = w.is_mutated(node)
    if isinstance(source, ast.GeneratorExp):
        head = loop_head(w, "/list", source.generators)
        code: Code = FormCode([*head, w.expr(source.elt)])
        return form("mutable", code) if is_mutable else code
    inferred = w.type(source)
    if is_mutable:
        inner = write_iterable(w, source)
        return form("mutable", form("->list", inner) if inferred.kinds & (ARRAY | STR | SET | DICT) else inner)
    if inferred.only(LIST | TUPLE) and not any(site.is_mutated for site in inferred.sites):
        return w.expr(source)
    if inferred.kinds & SHAPE:
        return form("primitives", w.expr(source))
    return form("->list", write_iterable(w, source))


def write_set(w: Writer, node: ast.Call) -> Code:
    if not node.args:
        return form("set")
    source = arguments_of(w, node, "iterable", "set")["iterable"]
    if isinstance(source, (ast.GeneratorExp, ast.ListComp)):
        return FormCode([*loop_head(w, "/set", source.generators), w.expr(source.elt)])
    return form("list->set", write_iterable(w, source))


def write_dict(w: Writer, node: ast.Call) -> Code:
    """Return the code of ``dict`` for a mapping or a sequence of pairs, and keyword arguments."""
    pairs: list[Code] = []
    tables: list[Code] = []
    for keyword in node.keywords:
        if keyword.arg is None:
            tables.append(w.expr(keyword.value))
        else:
            pairs += w.comment_pair(LiteralCode(keyword.arg, w.span(keyword)), w.expr(keyword.value), keyword)
    for argument in node.args:
        # first, since keyword arguments override its items
        tables.insert(
            0, w.expr(argument) if w.type(argument).only(DICT) else form("list->table", write_iterable(w, argument))
        )
    if not tables:
        return form("table", *pairs)
    if pairs:
        tables.append(form("table", *pairs))
    if len(tables) == 1:
        # `list->table` has made a new table, any other one must be copied
        return (
            tables[0]
            if node.args and isinstance(tables[0], FormCode) and w.type(node.args[0]).kinds & ~DICT
            else form("mutable", tables[0])
        )
    return form("table-merge", *tables)


def write_divmod(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a b", "divmod")
    return form("floor/", numeric(w, given["a"]), numeric(w, given["b"]))


def write_pow(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "base exponent", "pow")
    return form("expt", numeric(w, given["base"]), numeric(w, given["exponent"]))


def write_math_pow(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x y", "math.pow")
    return form("inexact", form("expt", numeric(w, given["x"]), numeric(w, given["y"])))


def write_print(w: Writer, node: ast.Call) -> Code:
    given = [a for a in node.args if not isinstance(a, ast.Starred)]
    return form("print", *(w.message(a) if isinstance(a, ast.JoinedStr) else printable(w, a) for a in given))


def write_isinstance(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x types", "isinstance")
    names = given["types"].elts if isinstance(given["types"], ast.Tuple) else [given["types"]]
    tests: list[Code] = []
    for name in names:
        head = _INSTANCE_TESTS.get(w.paths.of(name) or "")
        if head is not None:
            if not any(is_form(test, head) for test in tests):  # lists and tuples are the same type in the language
                tests.append(form(head, w.expr(given["x"])))
            continue
        variable = w.variable(name)
        if variable is not None and any(c.variable is variable for c in w.names.classes.values()):
            tests.append(predicate(w, name, given["x"]))
            continue
        raise w.unsupported(f"`isinstance` of `{w.text.text(name)}`", name)
    return tests[0] if len(tests) == 1 else form("or", *tests)


_INSTANCE_TESTS = {
    "int": "exact?", "float": "inexact?", "str": "string?", "bool": "boolean?", "list": "list?", "tuple": "list?",
    "dict": "table?", "set": "set?", "numpy.ndarray": "array?", "numpy.floating": "inexact?",
}  # fmt: skip


def write_callable(w: Writer, node: ast.Call) -> Code:
    return form("procedure?", w.expr(arguments_of(w, node, "x", "callable")["x"]))


def write_next(w: Writer, node: ast.Call) -> Code:
    """Return the code of ``next(x for x in xs if c)``, the first item; other iterators are not supported."""
    given = arguments_of(w, node, "iterator default?", "next")
    source, default = given["iterator"], given.get("default")
    if isinstance(source, ast.Call) and w.paths.of(source.func) == "iter" and source.args:
        return form("first", write_iterable(w, source.args[0]))
    makers = {w.paths.of(s.node.func) for s in w.type(source).sites if isinstance(s.node, ast.Call)}
    if makers == {"itertools.cycle"} and isinstance(source, ast.Name):
        item = PythonVariable("item", None, is_temporary=True)
        taken = FormCode([FormCode([VariableRef(item), form("pop!", w.expr(source), number(0))])])
        return form("let", taken, form("push!", w.expr(source), VariableRef(item)), VariableRef(item))
    if not isinstance(source, ast.GeneratorExp):
        raise w.unsupported("`next` of an iterator", node, "use a `for` loop or an index")
    first = FormCode([*loop_head(w, "/list", source.generators), w.expr(source.elt)])
    if default is None:
        return form("first", first)
    items = PythonVariable("found", None, is_temporary=True)
    body = form("if", form("empty?", VariableRef(items)), w.expr(default), form("first", VariableRef(items)))
    return form("let", FormCode([FormCode([VariableRef(items), first])]), body)
