"""Calls of library functions: builtins, math, numpy, random. One table from the dotted path to what writes the call."""

from __future__ import annotations

import ast
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from scenelang.interpreter.transpile import helpers
from scenelang.interpreter.transpile.arguments import arguments_of
from scenelang.interpreter.transpile.code import (
    Brackets,
    Code,
    Form,
    Key,
    Literal,
    Name,
    Ref,
    form,
    is_form,
    number,
    quote,
)
from scenelang.interpreter.transpile.domain import (
    ARRAY,
    BOOL,
    CONTAINERS,
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
)
from scenelang.interpreter.transpile.operators import container, numeric, truth
from scenelang.interpreter.transpile.scopes import Variable
from scenelang.interpreter.transpile.texts import printable

if TYPE_CHECKING:
    from scenelang.interpreter.transpile.expressions import ExpressionWriter

CallWriter: TypeAlias = "Callable[[ExpressionWriter, ast.Call], Code]"

CONSTANTS = {
    "math.pi": "pi", "math.tau": "tau", "math.e": "e", "math.inf": "inf", "math.nan": "nan",
    "numpy.pi": "pi", "numpy.e": "e", "numpy.inf": "inf", "numpy.nan": "nan",
}  # fmt: skip

# Functions of one or more numbers, element by element on arrays.
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


def _numeric(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        _only_positional(w, node)
        return form(head, *(numeric(w, argument) for argument in node.args))

    return write


def _elementwise(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        items = [w.array(a) if not w.type(a).only(NUMBERS) else numeric(w, a) for a in _plain(w, node)]
        for keyword in node.keywords:
            if keyword.arg != "axis":
                raise w.unsupported(f"`{keyword.arg}` here", keyword)
            items += [Key("axis"), w.expr(keyword.value)]
        return form(head, *items)

    return write


def _plain(w: ExpressionWriter, node: ast.Call) -> list[ast.expr]:
    for argument in node.args:
        if isinstance(argument, ast.Starred):
            raise w.unsupported("a star in this call", argument)
    return node.args


def _only_positional(w: ExpressionWriter, node: ast.Call) -> None:
    _plain(w, node)
    if node.keywords:
        raise w.error(
            "python-call", f"`{w.text.text(node.func)}` has no parameter `{node.keywords[0].arg}`", node.keywords[0]
        )


def _keyword(node: ast.Call, name: str) -> ast.expr | None:
    return next((k.value for k in node.keywords if k.arg == name), None)


def _is_comprehension(node: ast.expr) -> bool:
    return isinstance(node, (ast.GeneratorExp, ast.ListComp))


# --- builtins --------------------------------------------------------------------------------------------------


def _len(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x", "len")
    return form("length", container(w, given["x"]))


def _range(w: ExpressionWriter, node: ast.Call) -> Code:
    _only_positional(w, node)
    code = form("range", *(numeric(w, a) for a in node.args))
    return form("mutable", code) if w.is_mutated(node) else code


def _enumerate(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable start?", "enumerate")
    start = given.get("start")
    return form("enumerate", w.iterable(given["iterable"]), *([w.expr(start)] if start is not None else []))


def _zip(w: ExpressionWriter, node: ast.Call) -> Code:
    if len(node.args) == 1 and isinstance(node.args[0], ast.Starred):
        return form("apply", Name("zip"), w.iterable(node.args[0].value))
    return form("zip", *(w.iterable(a) for a in _plain(w, node)))


def _map(w: ExpressionWriter, node: ast.Call) -> Code:
    function, *sources = _plain(w, node)
    return form("map", w.expr(function), *(w.iterable(source) for source in sources))


def _filter(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "function iterable", "filter")
    function = given["function"]
    if isinstance(function, ast.Constant) and function.value is None:
        item = Variable("item", None, is_temporary=True)
        element = w.facts.type(node)
        test = Ref(item) if element.only(BOOL) else w.dynamic("py-truthy?", Ref(item))
        code: Code = Form([Name("lambda"), Form([Ref(item)]), test])
    elif isinstance(function, ast.Lambda):
        inner = w.names.functions[function]
        code = form("lambda", w.parameters(inner), w.test(function.body))
    else:
        code = w.expr(function)
    return form("filter", code, w.iterable(given["iterable"]))


def _sorted(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable key? reverse?", "sorted")
    code = form("sort", w.iterable(given["iterable"]), *sort_options(w, given))
    found = w.type(given["iterable"])
    if not found.only(LIST | TUPLE):
        code = form("sort", form("->list", code.items[1]), *code.items[2:])
    return form("mutable", code) if w.is_mutated(node) else code


def sort_options(w: ExpressionWriter, given: dict[str, ast.expr]) -> list[Code]:
    """``:key`` and ``:reverse`` of a sort."""
    options: list[Code] = []
    key, reverse = given.get("key"), given.get("reverse")
    if key is not None and not (isinstance(key, ast.Constant) and key.value is None):
        options += [Key("key"), w.expr(key)]
    if reverse is not None and not (isinstance(reverse, ast.Constant) and reverse.value is False):
        options += [Key("reverse"), w.test(reverse)]
    return options


def _reversed(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "sequence", "reversed")
    source = w.iterable(given["sequence"])
    if w.type(given["sequence"]).kinds & (STR | ARRAY):
        source = form("->list", source)
    code = form("reverse", source)
    return form("mutable", code) if w.is_mutated(node) else code


def _extreme(which: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        key, default = _keyword(node, "key"), _keyword(node, "default")
        for keyword in node.keywords:
            if keyword.arg not in ("key", "default"):
                raise w.error("python-call", f"`{which}` has no parameter `{keyword.arg}`", keyword)
        args = node.args
        starred = any(isinstance(a, ast.Starred) for a in args)
        if starred and len(args) > 1:
            joined = ast.copy_location(ast.List(list(args), ast.Load()), node)
            source, element = w.expr(joined), w.type(node)
        elif len(args) == 1:
            inner = args[0].value if isinstance(args[0], ast.Starred) else args[0]
            source, element = w.iterable(inner), w.type(node)
        else:
            found = w.type(node)
            if key is None and (found.only(NUMBERS | ARRAY) or not found.kinds or found.only(INT | FLOAT | NONE)):
                return form(which, *(numeric(w, a) for a in args))
            source, element = form("list", *(w.expr(a) for a in args)), found
        options = [Key("key"), w.expr(key)] if key is not None else []
        plain = key is None and (element.only(INT | FLOAT) or not element.kinds)
        code = form(which, source) if plain else form(f"{which}-of", source, *options)
        if default is not None:
            test = form("empty?", source)
            return form("if", test, w.expr(default), code)
        return code

    return write


def _sum(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable start?", "sum")
    source, start = given["iterable"], given.get("start")
    element = w.facts.type(source)
    if start is not None and w.type(start).kinds & SEQUENCES:
        code = form("apply", Name("append"), w.expr(start), w.iterable(source))
        return form("mutable", code) if w.is_mutated(node) else code
    if isinstance(source, (ast.GeneratorExp, ast.ListComp)):
        head = w.loop_head("/sum", source.generators)
        total: Code = Form([*head, numeric(w, source.elt)])
    elif _sums_booleans(w, source):
        item = Variable("item", None, is_temporary=True)
        clauses = Form([Form([Ref(item), w.iterable(source)])])
        total = Form([Name("for/sum"), clauses, form("if", Ref(item), number(1), number(0))])
    else:
        total = form("sum", w.iterable(source) if not element.kinds & ARRAY else w.expr(source))
    if start is None or (isinstance(start, ast.Constant) and start.value == 0):
        return total
    return form("+", numeric(w, start), total)


def _sums_booleans(w: ExpressionWriter, source: ast.expr) -> bool:
    sites = w.type(source).sites
    return bool(sites) and all(site.element.only(BOOL) for site in sites)


def _quantifier(kind: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        source = arguments_of(w, node, "iterable", "any" if kind == "/or" else "all")["iterable"]
        if isinstance(source, (ast.GeneratorExp, ast.ListComp)):
            return Form([*w.loop_head(kind, source.generators), w.test(source.elt)])
        item = Variable("item", None, is_temporary=True)
        sites = w.type(source).sites
        is_plain = bool(sites) and all(site.element.only(BOOL) for site in sites)
        test = Ref(item) if is_plain else w.dynamic("py-truthy?", Ref(item))
        return Form([Name(f"for{kind}"), Form([Form([Ref(item), w.iterable(source)])]), test])

    return write


def _int(w: ExpressionWriter, node: ast.Call) -> Code:
    if not node.args:
        return number(0)
    given = arguments_of(w, node, "x base?", "int")
    found = w.type(given["x"])
    if found.only(STR):
        base = [w.expr(given["base"])] if "base" in given else []
        return form("truncate", form("string->number", w.expr(given["x"]), *base))
    if found.only(INT):
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


def _float(w: ExpressionWriter, node: ast.Call) -> Code:
    if not node.args:
        return Literal(0.0, None, "0.")
    given = arguments_of(w, node, "x", "float")
    found = w.type(given["x"])
    if found.only(STR):
        if isinstance(given["x"], ast.Constant) and str(given["x"].value).strip("+ ").lower() in ("inf", "infinity"):
            return Name("inf")
        return form("inexact", form("string->number", w.expr(given["x"])))
    return w.expr(given["x"]) if found.only(FLOAT) else form("inexact", numeric(w, given["x"]))


def _str(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x", "str")
    found = w.type(given["x"])
    if found.only(STR):
        return w.expr(given["x"])
    if found.only(INT | FLOAT):
        return form("number->string", w.expr(given["x"]))
    return w.dynamic("py-str", w.expr(given["x"]))


def _bool(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x", "bool")
    return (
        form("not", form("not", truth(w, given["x"], w.type(given["x"]))))
        if not w.type(given["x"]).only(BOOL)
        else w.expr(given["x"])
    )


def _round(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "number ndigits?", "round")
    digits = given.get("ndigits")
    if digits is None or (isinstance(digits, ast.Constant) and digits.value is None):
        return form("round", numeric(w, given["number"]))
    return form("round", numeric(w, given["number"]), w.expr(digits))


def _np_round(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a decimals?", "np.round")
    decimals = given.get("decimals")
    return form("round", w.array(given["a"]), *([w.expr(decimals)] if decimals is not None else []))


def _sequence(w: ExpressionWriter, node: ast.Call) -> Code:
    """``list(x)`` and ``tuple(x)``."""
    if not node.args:
        return form("mutable-list") if w.is_mutated(node) else quote(Form([]))
    source = arguments_of(w, node, "iterable", "list")["iterable"]
    is_mutable = w.is_mutated(node)
    if isinstance(source, ast.GeneratorExp):
        head = w.loop_head("/list", source.generators)
        code: Code = Form([*head, w.expr(source.elt)])
        return form("mutable", code) if is_mutable else code
    found = w.type(source)
    if is_mutable:
        inner = w.iterable(source)
        return form("mutable", form("->list", inner) if found.kinds & (ARRAY | STR | SET | DICT) else inner)
    if found.only(LIST | TUPLE) and not any(site.is_mutated for site in found.sites):
        return w.expr(source)
    if found.kinds & SHAPE:
        return form("primitives", w.expr(source))
    return form("->list", w.iterable(source))


def _set(w: ExpressionWriter, node: ast.Call) -> Code:
    if not node.args:
        return form("set")
    source = arguments_of(w, node, "iterable", "set")["iterable"]
    if isinstance(source, (ast.GeneratorExp, ast.ListComp)):
        return Form([*w.loop_head("/set", source.generators), w.expr(source.elt)])
    return form("list->set", w.iterable(source))


def _dict(w: ExpressionWriter, node: ast.Call) -> Code:
    pairs: list[Code] = []
    tables: list[Code] = []
    for keyword in node.keywords:
        if keyword.arg is None:
            tables.append(w.expr(keyword.value))
        else:
            pairs += [Literal(keyword.arg, w.span(keyword)), w.comment_item(w.expr(keyword.value), keyword)]
    for argument in node.args:
        tables.insert(0, w.expr(argument) if w.type(argument).only(DICT) else form("list->table", w.iterable(argument)))
    if not tables:
        return form("table", *pairs)
    if pairs:
        tables.append(form("table", *pairs))
    if len(tables) == 1:
        return (
            tables[0]
            if isinstance(tables[0], Form) and w.type(node.args[0]).kinds & ~DICT
            else form("mutable", tables[0])
        )
    return form("table-merge", *tables)


def _divmod(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a b", "divmod")
    return form("floor/", numeric(w, given["a"]), numeric(w, given["b"]))


def _pow(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "base exponent", "pow")
    return form("expt", numeric(w, given["base"]), numeric(w, given["exponent"]))


def _math_pow(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x y", "math.pow")
    return form("inexact", form("expt", numeric(w, given["x"]), numeric(w, given["y"])))


def _print(w: ExpressionWriter, node: ast.Call) -> Code:
    return form("print", *(printable(w, a) for a in node.args if not isinstance(a, ast.Starred)))


def _isinstance(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x types", "isinstance")
    names = given["types"].elts if isinstance(given["types"], ast.Tuple) else [given["types"]]
    tests: list[Code] = []
    for name in names:
        head = _INSTANCE_TESTS.get(w.paths.of(name) or "")
        if head is not None:
            if not any(is_form(test, head) for test in tests):  # lists and tuples are one
                tests.append(form(head, w.expr(given["x"])))
            continue
        variable = w.variable(name)
        if variable is not None and any(c.variable is variable for c in w.names.classes.values()):
            from scenelang.interpreter.transpile.records import predicate

            tests.append(predicate(w, name, given["x"]))
            continue
        raise w.unsupported(f"`isinstance` of `{w.text.text(name)}`", name)
    return tests[0] if len(tests) == 1 else form("or", *tests)


_INSTANCE_TESTS = {
    "int": "exact?", "float": "inexact?", "str": "string?", "bool": "boolean?", "list": "list?", "tuple": "list?",
    "dict": "table?", "set": "set?", "numpy.ndarray": "array?", "numpy.floating": "inexact?",
}  # fmt: skip


def _callable(w: ExpressionWriter, node: ast.Call) -> Code:
    return form("procedure?", w.expr(arguments_of(w, node, "x", "callable")["x"]))


def _next(w: ExpressionWriter, node: ast.Call) -> Code:
    """``next(x for x in xs if c)`` is the first one; anything else would need iterators."""
    given = arguments_of(w, node, "iterator default?", "next")
    source, default = given["iterator"], given.get("default")
    if isinstance(source, ast.Call) and w.paths.of(source.func) == "iter" and source.args:
        return form("first", w.iterable(source.args[0]))
    if not isinstance(source, ast.GeneratorExp):
        raise w.unsupported("`next` of an iterator", node, "use a `for` loop or an index")
    found = Form([*w.loop_head("/list", source.generators), w.expr(source.elt)])
    if default is None:
        return form("first", found)
    items = Variable("found", None, is_temporary=True)
    body = form("if", form("empty?", Ref(items)), w.expr(default), form("first", Ref(items)))
    return form("let", Form([Form([Ref(items), found])]), body)


# --- math ------------------------------------------------------------------------------------------------------


def _fmod(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x y", "math.fmod")
    return form("inexact", form("remainder", numeric(w, given["x"]), numeric(w, given["y"])))


def _dist(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "p q", "math.dist")
    return form("distance", w.array(given["p"]), w.array(given["q"]))


def _isclose(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a b rel_tol? abs_tol? rtol? atol?", "isclose")
    relative = given.get("rel_tol", given.get("rtol"))
    absolute = given.get("abs_tol", given.get("atol"))
    a, b = numeric(w, given["a"]), numeric(w, given["b"])
    largest = form("max", form("abs", numeric(w, given["a"])), form("abs", numeric(w, given["b"])))
    tolerance: Code = form("*", w.expr(relative) if relative is not None else Literal(1e-9, None, "1e-9"), largest)
    if absolute is not None:
        tolerance = form("max", tolerance, w.expr(absolute))
    return form("<=", form("abs", form("-", a, b)), tolerance)


def _factorial(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "n", "math.factorial")
    return form("product", form("range", number(1), form("+", w.expr(given["n"]), number(1))))


def _copysign(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x y", "math.copysign")
    test = form("<", numeric(w, given["y"]), number(0))
    return form(
        "*", form("abs", numeric(w, given["x"])), form("if", test, Literal(-1.0, None, "-1."), Literal(1.0, None, "1."))
    )


def _cbrt(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x", "cbrt")
    return form(
        "*",
        form("sign", w.expr(given["x"])),
        form("expt", form("abs", w.expr(given["x"])), form("/", number(1), number(3))),
    )


def _isqrt(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "n", "math.isqrt")
    return form("floor", form("sqrt", w.expr(given["n"])))


def _prod(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable", "prod")
    return form("product", w.iterable(given["iterable"]))


# --- numpy -----------------------------------------------------------------------------------------------------


def _np_array(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "object dtype? copy?", "np.array")
    source = given["object"]
    if w.type(source).only(NUMBERS):
        return numeric(w, source)
    if isinstance(source, (ast.List, ast.Tuple)) and not source.elts:
        code: Code = form("zeros", number(0))
    else:
        code = w.array(source)
    if not isinstance(code, Brackets) and not is_form(code, "array") and not w.type(source).only(ARRAY | POSE):
        code = form("array", code)
    if _is_float(w, given.get("dtype")):
        code = form("inexact", code)
    if w.is_mutated(node):
        return form("mutable-array", code)
    return code


def _is_float(w: ExpressionWriter, dtype: ast.expr | None) -> bool:
    if dtype is None:
        return False
    if isinstance(dtype, ast.Constant):
        return str(dtype.value).startswith("float")
    return w.paths.of(dtype) in ("float", "numpy.float64", "numpy.float32", "numpy.float_")


def _np_shape(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        given = arguments_of(w, node, "shape fill_value? dtype?" if head == "full" else "shape dtype?", f"np.{head}")
        items = [w.expr(given["shape"])]
        if head == "full":
            items.append(numeric(w, given["fill_value"]))
        code = form(head, *items)
        if w.paths.of(given["dtype"]) == "int" if "dtype" in given else False:
            code = form("exact", code)
        return form("mutable-array", code) if w.is_mutated(node) else code

    return write


def _np_like(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        given = arguments_of(w, node, "a fill_value? dtype?", f"np.{head}_like")
        items: list[Code] = [form("array-shape", w.array(given["a"]))]
        if head == "full":
            items.append(numeric(w, given["fill_value"]))
        code = form(head, *items)
        return form("mutable-array", code) if w.is_mutated(node) else code

    return write


def _linspace(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "start stop num? endpoint?", "np.linspace")
    items = [numeric(w, given["start"]), numeric(w, given["stop"])]
    if "num" in given:
        items.append(w.expr(given["num"]))
    endpoint = given.get("endpoint")
    if endpoint is not None and not (isinstance(endpoint, ast.Constant) and endpoint.value is True):
        items += [Key("endpoint"), w.test(endpoint)]
    code = form("linspace", *items)
    return form("mutable-array", code) if w.is_mutated(node) else code


def _arange(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "start stop? step?", "np.arange")
    return form("arange", *(numeric(w, value) for value in given.values()))


def _reduction(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        given = arguments_of(w, node, "a axis?", f"np.{head}")
        source = given["a"]
        code = w.array(source) if w.type(source).kinds & ARRAY else w.iterable(source)
        options = [Key("axis"), w.expr(given["axis"])] if "axis" in given else []
        return form(head, code, *options)

    return write


def _np_norm(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x axis?", "np.linalg.norm")
    if "axis" in given:
        square = form("square", w.array(given["x"]))
        return form("sqrt", form("sum", square, Key("axis"), w.expr(given["axis"])))
    inner = given["x"]
    if isinstance(inner, ast.BinOp) and isinstance(inner.op, ast.Sub) and w.type(inner).only(ARRAY):
        if not isinstance(inner.left, ast.BinOp):
            return form("distance", w.array(inner.left), w.array(inner.right))
    return form("norm", w.array(inner))


def _np_stack(head: str, axis: int | None = None) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        given = arguments_of(w, node, "arrays axis?", f"np.{head}")
        source = given["arrays"]
        if isinstance(source, (ast.List, ast.Tuple)) and not any(isinstance(e, ast.Starred) for e in source.elts):
            items = [w.array(e) for e in source.elts]
        else:
            items = [w.iterable(source)]
        if "axis" in given:
            items += [Key("axis"), w.expr(given["axis"])]
        elif axis is not None:
            items += [Key("axis"), number(axis)]
        return form(head, *items)

    return write


def _np_append(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "arr values", "np.append")
    values = given["values"]
    second = w.array(values) if not w.type(values).only(NUMBERS) else form("vector", w.expr(values))
    return form("concatenate", w.array(given["arr"]), second)


def _np_where(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "condition a b", "np.where")
    if w.type(given["condition"]).only(BOOL):
        return form("if", w.test(given["condition"]), w.expr(given["a"]), w.expr(given["b"]))
    raise w.unsupported("`np.where` of a comparison of arrays", node, "write a comprehension")


def _np_clip(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a a_min? a_max? min? max?", "np.clip")
    low, high = given.get("a_min", given.get("min")), given.get("a_max", given.get("max"))
    low, high = (None if b is None or _is_none(b) else b for b in (low, high))
    if low is None or high is None:
        bound, head = (low, "max") if low is not None else (high, "min")
        if bound is None:
            return w.expr(given["a"])
        return form(head, w.array(given["a"]), w.array(bound))
    if w.type(given["a"]).only(NUMBERS):
        return form("clamp", *(numeric(w, x) for x in (given["a"], low, high)))
    return form("clip", w.array(given["a"]), w.array(low), w.array(high))


def _np_float(w: ExpressionWriter, node: ast.Call) -> Code:
    return form("inexact", numeric(w, node.args[0]))


def _np_eye(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "n", "np.eye")
    code = form("eye", w.expr(given["n"]))
    return form("mutable-array", code) if w.is_mutated(node) else code


def _np_copy(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a", "np.copy")
    code = w.array(given["a"])
    return form("mutable-array", code) if w.is_mutated(node) else code


def _np_bool(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        return _quantifier(head)(w, node)

    return write


def _np_sort(w: ExpressionWriter, node: ast.Call) -> Code:
    return form("sort", w.array(arguments_of(w, node, "a", "np.sort")["a"]))


def _np_flip(w: ExpressionWriter, node: ast.Call) -> Code:
    return form("reverse", w.array(arguments_of(w, node, "a", "np.flip")["a"]))


def _np_reshape(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a shape", "np.reshape")
    return form("reshape", w.array(given["a"]), w.expr(given["shape"]))


def _np_outer(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a b", "np.outer")
    column = form("reshape", w.array(given["a"]), quote(Form([number(-1), number(1)])))
    return form("*", column, w.array(given["b"]))


def _np_allclose(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a b rtol? atol?", "np.allclose")
    difference = form("max", form("abs", form("-", w.array(given["a"]), w.array(given["b"]))))
    return form("<=", difference, w.expr(given["atol"]) if "atol" in given else Literal(1e-8, None, "1e-8"))


def _np_repeat(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a repeats", "np.repeat")
    item = Variable("item", None, is_temporary=True)
    body = form("make-list", w.expr(given["repeats"]), Ref(item))
    return form("array", Form([Name("for/append"), Form([Form([Ref(item), w.array(given["a"])])]), body]))


def _np_tile(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a reps", "np.tile")
    return form("array", form("repeat", form("->list", w.array(given["a"])), w.expr(given["reps"])))


def _argsort(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "a", "np.argsort")
    keys, item = Variable("keys", None, is_temporary=True), Variable("i", None, is_temporary=True)
    key = Form([Name("lambda"), Form([Ref(item)]), form("ref", Ref(keys), Ref(item))])
    order = form("array", form("sort", form("range", form("length", Ref(keys))), Key("key"), key))
    return form("let", Form([Form([Ref(keys), w.array(given["a"])])]), order)


def _meshgrid(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x y", "np.meshgrid")
    x, y = Variable("x", None, is_temporary=True), Variable("y", None, is_temporary=True)
    rows = form("stack-arrays", form("make-list", form("length", Ref(y)), Ref(x)))
    columns = form("transpose", form("stack-arrays", form("make-list", form("length", Ref(x)), Ref(y))))
    bindings = Form([Form([Ref(x), w.array(given["x"])]), Form([Ref(y), w.array(given["y"])])])
    return form("let*", bindings, form("list", rows, columns))


def _defaultdict(w: ExpressionWriter, node: ast.Call) -> Code:
    arguments_of(w, node, "factory?", "defaultdict")
    return form("table")


def _field(w: ExpressionWriter, node: ast.Call) -> Code:
    raise w.unsupported("`field` outside a dataclass", node)


# --- random ----------------------------------------------------------------------------------------------------

_DRAWS: dict[str, tuple[str, str]] = {
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


def draw(w: ExpressionWriter, node: ast.Call, path: str, stream: Code | None = None) -> Code:
    """A draw from a stream: the common one, or ``stream``."""
    head, signature = _DRAWS[path]
    parameters = [p.partition(":") for p in signature.split()]
    given = arguments_of(w, node, " ".join(p[0] for p in parameters), path)
    items: list[Code] = []
    options: list[Code] = []
    waiting: list[ast.expr] = []
    for name, _, keyword in parameters:
        name = name.rstrip("?")
        value = given.get(name)
        if value is None or name in _NO_KEYWORD_VALUES or (keyword and _is_none(value)):
            continue
        if keyword:
            options += [Key(keyword), w.test(value) if keyword == "replace" else w.expr(value)]
            continue
        items += [_draw_argument(w, v, name) for v in (*waiting, value)]
        waiting = []
    items = _fill_gaps(path, given, items)
    if stream is not None:
        options += [Key("stream"), stream]
    code = form(head, *items, *options)
    if path == "numpy.random.permutation" and not w.type(node.args[0]).only(INT) and w.type(node).kinds & ARRAY:
        code = form("permutation", w.array(node.args[0]), *options)
    return form("mutable", code) if w.is_mutated(node) else code


def _draw_argument(w: ExpressionWriter, value: ast.expr, name: str) -> Code:
    if name in _SEQUENCE_PARAMETERS and not w.type(value).only(NUMBERS):
        return w.iterable(value)
    return numeric(w, value)


def _fill_gaps(path: str, given: dict[str, ast.expr], items: list[Code]) -> list[Code]:
    """Optional arguments before one that is given: ``np.random.normal(scale=.1)``."""
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


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _draw(path: str) -> CallWriter:
    return lambda w, node: draw(w, node, path)


def _sides(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        _only_positional(w, node)
        return form(head if node.args else ("random" if head == "rand" else "normal"), *(w.expr(a) for a in node.args))

    return write


def _shuffle(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        return form(head, w.expr(arguments_of(w, node, "x", "shuffle")["x"]))

    return write


def _seed(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        if not node.args or _is_none(node.args[0]):
            raise w.unsupported("seeding from the clock", node, "give the seed a number")
        return form(head, w.expr(node.args[0]))

    return write


def _stream(head: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        return form(head, *(w.expr(a) for a in (*node.args, *(k.value for k in node.keywords)) if not _is_none(a)))

    return write


# --- other modules ---------------------------------------------------------------------------------------------


def _reduce(w: ExpressionWriter, node: ast.Call) -> Code:
    function, source, *start = _plain(w, node)
    if start:
        return form("fold-left", w.expr(function), w.expr(start[0]), w.iterable(source))
    first = w.iterable(source)
    return form("fold-left", w.expr(function), form("first", first), form("rest", w.iterable(source)))


def _itertools_product(w: ExpressionWriter, node: ast.Call) -> Code:
    repeat = _keyword(node, "repeat")
    sources = list(_plain(w, node))
    if repeat is not None:
        if not isinstance(repeat, ast.Constant) or not isinstance(repeat.value, int) or not 0 < repeat.value < 9:
            raise w.unsupported("a computed `repeat`", repeat)
        sources = sources * repeat.value
    variables = [Variable("item", None, is_temporary=True) for _ in sources]
    clauses = Form([Form([Ref(v), w.iterable(s)]) for v, s in zip(variables, sources)])
    return Form([Name("for*/list"), clauses, form("list", *(Ref(v) for v in variables))])


def _combinations(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "iterable r", "combinations")
    if not isinstance(given["r"], ast.Constant) or given["r"].value != 2:
        raise w.unsupported("combinations of any number but 2", node)
    i, j, items = (Variable(name, None, is_temporary=True) for name in ("i", "j", "items"))
    length = form("length", Ref(items))
    clauses = Form([
        Form([Ref(i), form("range", length)]),
        Form([Ref(j), form("range", form("+", Ref(i), number(1)), form("length", Ref(items)))]),
    ])  # fmt: skip
    body = form("list", form("ref", Ref(items), Ref(i)), form("ref", Ref(items), Ref(j)))
    return form(
        "let", Form([Form([Ref(items), w.iterable(given["iterable"])])]), Form([Name("for*/list"), clauses, body])
    )


def _chain(w: ExpressionWriter, node: ast.Call) -> Code:
    if len(node.args) == 1 and isinstance(node.args[0], ast.Starred):
        return form("apply", Name("append"), w.iterable(node.args[0].value))
    return form("append", *(w.iterable(a) for a in _plain(w, node)))


def _chain_from_iterable(w: ExpressionWriter, node: ast.Call) -> Code:
    return form(
        "apply", Name("append"), w.iterable(arguments_of(w, node, "iterable", "chain.from_iterable")["iterable"])
    )


def _itertools_repeat(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "object times", "itertools.repeat")
    return form("make-list", w.expr(given["times"]), w.expr(given["object"]))


def _hsv(w: ExpressionWriter, node: ast.Call) -> Code:
    given = arguments_of(w, node, "h s v", "colorsys.hsv_to_rgb")
    return form("hsv", *(numeric(w, given[name]) for name in "hsv"))


def _copy(w: ExpressionWriter, node: ast.Call) -> Code:
    value = arguments_of(w, node, "x", "copy")["x"]
    found = w.type(value)
    if found.kinds & (LIST | DICT | SET) and any(site.is_mutated for site in found.sites):
        if any(
            s.element.kinds & CONTAINERS and any(inner.is_mutated for inner in s.element.sites) for s in found.sites
        ):
            raise w.unsupported("a deep copy of nested lists that change", node)
        return form("mutable", w.expr(value))
    return w.expr(value)


def _not_here(what: str, hint: str) -> CallWriter:
    def write(w: ExpressionWriter, node: ast.Call) -> Code:
        raise w.unsupported(what, node, hint)

    return write


CALLS: dict[str, CallWriter] = {
    "library_call": helpers.library_call, "primitive_call": helpers.primitive_call, "loop": helpers.loop,
    "concat_shapes": helpers.concat_shapes, "transform_shape": helpers.transform_shape,
    "translation_matrix": helpers.translation_matrix, "rotation_matrix": helpers.rotation_matrix,
    "scale_matrix": helpers.scale_matrix, "reflection_matrix": helpers.reflection_matrix,
    "identity_matrix": helpers.identity_matrix, "register": helpers.registration,
    "register_animation": helpers.registration,
    **{f"compute_shape_{name}": helpers.box(name) for name in ("center", "min", "max", "sizes")},
    "len": _len, "range": _range, "enumerate": _enumerate, "zip": _zip, "map": _map, "filter": _filter,
    "sorted": _sorted,
    "reversed": _reversed, "min": _extreme("min"), "max": _extreme("max"), "sum": _sum, "any": _quantifier("/or"),
    "all": _quantifier("/and"), "int": _int, "float": _float, "str": _str, "repr": _str, "bool": _bool, "round": _round,
    "list": _sequence, "tuple": _sequence, "iter": _sequence, "set": _set, "frozenset": _set, "dict": _dict,
    "divmod": _divmod, "pow": _pow, "abs": _elementwise("abs"), "print": _print, "isinstance": _isinstance,
    "callable": _callable, "next": _next, "chr": _numeric("chr"), "ord": _numeric("ord"),
    **{f"math.{name}": _numeric(head) for name, head in _NUMERIC.items()},
    "math.pow": _math_pow, "math.fmod": _fmod, "math.dist": _dist, "math.isclose": _isclose,
    "math.factorial": _factorial,
    "math.copysign": _copysign, "math.cbrt": _cbrt, "math.isqrt": _isqrt, "math.prod": _prod, "math.fsum": _sum,
    "math.isnan": _numeric("nan?"), "math.isinf": _numeric("infinite?"), "math.isfinite": _numeric("finite?"),
    **{f"numpy.{name}": _elementwise(head) for name, head in _NUMPY.items()},
    "numpy.array": _np_array, "numpy.asarray": _np_array, "numpy.zeros": _np_shape("zeros"),
    "numpy.ones": _np_shape("ones"),
    "numpy.empty": _np_shape("zeros"), "numpy.full": _np_shape("full"), "numpy.zeros_like": _np_like("zeros"),
    "numpy.ones_like": _np_like("ones"), "numpy.full_like": _np_like("full"), "numpy.linspace": _linspace,
    "numpy.arange": _arange, "numpy.round": _np_round, "numpy.around": _np_round, "numpy.linalg.norm": _np_norm,
    "numpy.stack": _np_stack("stack-arrays"), "numpy.vstack": _np_stack("stack-arrays"),
    "numpy.column_stack": _np_stack("stack-arrays", 1), "numpy.concatenate": _np_stack("concatenate"),
    "numpy.hstack": _np_stack("concatenate"), "numpy.append": _np_append, "numpy.where": _np_where,
    "numpy.clip": _np_clip,
    "numpy.sum": _reduction("sum"), "numpy.mean": _reduction("mean"), "numpy.max": _reduction("max"),
    "numpy.min": _reduction("min"), "numpy.amax": _reduction("max"), "numpy.amin": _reduction("min"),
    "numpy.prod": _reduction("product"), "numpy.average": _reduction("mean"), "numpy.float64": _np_float,
    "numpy.float32": _np_float, "numpy.int32": _int, "numpy.int64": _int, "numpy.eye": _np_eye,
    "numpy.identity": _np_eye,
    "numpy.copy": _np_copy, "numpy.any": _np_bool("/or"), "numpy.all": _np_bool("/and"), "numpy.sort": _np_sort,
    "numpy.flip": _np_flip, "numpy.reshape": _np_reshape, "numpy.outer": _np_outer, "numpy.allclose": _np_allclose,
    "numpy.isclose": _isclose, "numpy.repeat": _np_repeat, "numpy.tile": _np_tile, "numpy.cbrt": _cbrt,
    "numpy.fmod": _fmod, "numpy.trunc": _elementwise("truncate"),
    **{path: _draw(path) for path in _DRAWS},
    "numpy.random.rand": _sides("rand"), "numpy.random.randn": _sides("randn"), "numpy.random.seed": _seed("set-seed!"),
    "random.seed": _seed("py-set-seed!"), "numpy.random.shuffle": _shuffle("shuffle!"),
    "random.shuffle": _shuffle("py-shuffle!"), "numpy.random.RandomState": _stream("random-stream"),
    "numpy.random.default_rng": _stream("default-rng"), "random.Random": _stream("py-random-stream"),
    "functools.reduce": _reduce, "itertools.product": _itertools_product, "itertools.combinations": _combinations,
    "itertools.chain": _chain, "itertools.chain.from_iterable": _chain_from_iterable,
    "itertools.repeat": _itertools_repeat,
    "colorsys.hsv_to_rgb": _hsv, "copy.copy": _copy, "copy.deepcopy": _copy, "collections.OrderedDict": _dict,
    "collections.deque": _sequence, "collections.defaultdict": _defaultdict, "numpy.argsort": _argsort,
    "numpy.meshgrid": _meshgrid, "dataclasses.field": _field,
}  # fmt: skip


# --- functions as values ---------------------------------------------------------------------------------------

_VALUE_NAMES = {
    "len": "length", "abs": "abs", "min": "min", "max": "max", "sum": "sum", "float": "inexact", "int": "truncate",
    "round": "round", "sorted": "sort", "list": "->list", "tuple": "->list", "set": "list->set", "reversed": "reverse",
    "str.upper": "string-upcase", "concat_shapes": "union", "transform_shape": "transform",
    "translation_matrix": "translate", "compute_shape_center": "compute-shape-center", "operator.add": "+",
    "operator.mul": "*", "operator.sub": "-", "numpy.array": "array", "numpy.linalg.norm": "norm", "ord": "ord",
    "chr": "chr",
    **{f"math.{name}": head for name, head in _NUMERIC.items()},
    **{f"numpy.{name}": head for name, head in _NUMPY.items()},
}  # fmt: skip


def _value(name: str) -> Callable[[ExpressionWriter], Code]:
    return lambda w: Name(name)


def _str_value(w: ExpressionWriter) -> Code:
    w.imports.add("std/python.scene")
    return Name("py-str")


VALUES: dict[str, Callable[[ExpressionWriter], Code]] = {
    **{path: _value(name) for path, name in _VALUE_NAMES.items()},
    "str": _str_value,
}
