"""Calls of library functions: the table from dotted paths to the functions that generate the calls."""

from __future__ import annotations

import ast
from collections.abc import Callable

from scenelang.interpreter.transpile.analysis.inference import DICT, RECORD, AbstractType
from scenelang.interpreter.transpile.analysis.scopes import PythonVariable
from scenelang.interpreter.transpile.writing import helpers
from scenelang.interpreter.transpile.writing.code import Code, FormCode, LiteralCode, Name, VariableRef, form, number
from scenelang.interpreter.transpile.writing.numpy_calls import (
    DRAWS,
    CallWriter,
    elementwise_call,
    keyword_of,
    numeric_call,
    plain_arguments,
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
from scenelang.interpreter.transpile.writing.operators import numeric, write_array, write_iterable
from scenelang.interpreter.transpile.writing.user_calls import arguments_of
from scenelang.interpreter.transpile.writing.writer import Writer

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
    test = form("<", numeric(w, given["y"]), number(0))
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
    return form(
        "apply", Name("append"), write_iterable(w, arguments_of(w, node, "iterable", "chain.from_iterable")["iterable"])
    )


def write_cycle(w: Writer, node: ast.Call) -> Code:
    """Return a cycle as a mutable list that ``next`` rotates."""
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
    return _copied(w, w.expr(value), w.type(value) | w.type(node), is_deep, 0)


def _copied(w: Writer, code: Code, found: AbstractType, is_deep: bool, level: int) -> Code:
    """Return a copy of mutable containers, recursively for a deep copy; immutable values are not copied."""
    if not _is_mutated(found, 0) or level > 3:
        return code
    inner = AbstractType(0)
    for site in found.sites:
        inner = inner | site.element
    if not is_deep or not _is_mutated(inner, 0):
        return form("mutable", code)
    item = PythonVariable("item", None, is_temporary=True)
    copied = _copied(w, VariableRef(item), inner, True, level + 1)
    if found.only(DICT):
        key = PythonVariable("key", None, is_temporary=True)
        clauses = FormCode([FormCode([FormCode([VariableRef(key), VariableRef(item)]), form("table-items", code)])])
        return FormCode([Name("for/table"), clauses, form("list", VariableRef(key), copied)])
    return form("mutable", FormCode([Name("for/list"), FormCode([FormCode([VariableRef(item), code])]), copied]))


def _is_mutated(found: AbstractType, level: int) -> bool:
    """Return whether a container, or one inside it, is modified anywhere."""
    return any(site.is_mutated or (level < 4 and _is_mutated(site.element, level + 1)) for site in found.sites)


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
    "radians": "radians", "degrees": "degrees", "floor": "floor", "ceil": "ceiling", "trunc": "truncate",
    "atan2": "atan", "hypot": "hypot", "fabs": "abs", "gcd": "gcd", "lcm": "lcm",
}  # fmt: skip
_NUMPY = {
    **_NUMERIC, "arcsin": "asin", "arccos": "acos", "arctan": "atan", "arctan2": "atan", "deg2rad": "radians",
    "rad2deg": "degrees", "abs": "abs", "absolute": "abs", "sign": "sign", "square": "square", "power": "expt",
    "mod": "%", "remainder": "%", "maximum": "max", "minimum": "min", "add": "+", "subtract": "-", "multiply": "*",
    "divide": "/", "negative": "-", "clip": "clip", "interp": "interp", "dot": "dot", "cross": "cross", "inner": "dot",
    "matmul": "@", "cumsum": "cumsum", "argmin": "argmin", "argmax": "argmax", "transpose": "transpose",
    "linalg.inv": "inverse", "linalg.det": "determinant", "linalg.solve": "solve", "vdot": "dot", "rint": "round",
}  # fmt: skip


CALLS: dict[str, CallWriter] = {
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
    "numpy.identity": write_np_eye,
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
