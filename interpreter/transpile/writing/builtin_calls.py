"""Calls of Python's builtins."""

from __future__ import annotations

import ast
from collections.abc import Callable
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
    SEQUENCES,
    SET,
    SHAPE,
    STR,
    TUPLE,
)
from scenelang.interpreter.transpile.analysis.scopes import PythonVariable, is_none
from scenelang.interpreter.transpile.writing.code import (
    Code,
    FormCode,
    Key,
    LiteralCode,
    Name,
    VariableRef,
    form,
    is_form,
    lambda_list,
    number,
    quote,
)
from scenelang.interpreter.transpile.writing.conversions import (
    dynamic,
    loop_head,
    numeric,
    parallel_sources,
    printable,
    truth,
    write_array,
    write_iterable,
    write_test,
)
from scenelang.interpreter.transpile.writing.operators import container
from scenelang.interpreter.transpile.writing.user_calls import arguments_of, lambda_locals, predicate, write_parameters
from scenelang.interpreter.transpile.writing.writer import Writer

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
        raise w.error(
            "python-call", f"`{w.text.text(node.func)}` has no parameter `{node.keywords[0].arg}`", node.keywords[0]
        )


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
    found = w.type(given["iterable"])
    if not found.only(LIST | TUPLE):
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
    def write(w: Writer, node: ast.Call) -> Code:
        key, default = keyword_of(node, "key"), keyword_of(node, "default")
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
            source, element = write_iterable(w, inner), w.type(node)
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


def write_sum(w: Writer, node: ast.Call) -> Code:
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
    found = w.type(given["x"])
    if found.only(STR):
        base = [w.expr(given["base"])] if "base" in given else []
        return form("truncate", form("string->number", form("string-trim", w.expr(given["x"])), *base))
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


def write_float(w: Writer, node: ast.Call) -> Code:
    if not node.args:
        return LiteralCode(0.0, None, "0.")
    given = arguments_of(w, node, "x", "float")
    found = w.type(given["x"])
    if found.only(STR):
        if isinstance(given["x"], ast.Constant) and str(given["x"].value).strip("+ ").lower() in ("inf", "infinity"):
            return Name("inf")
        return form("inexact", form("string->number", w.expr(given["x"])))
    return w.expr(given["x"]) if found.only(FLOAT) else form("inexact", numeric(w, given["x"]))


def write_str(w: Writer, node: ast.Call) -> Code:
    given = arguments_of(w, node, "x", "str")
    found = w.type(given["x"])
    if found.only(STR):
        return w.expr(given["x"])
    if found.only(INT | FLOAT):
        return form("number->string", w.expr(given["x"]))
    return dynamic(w, "py-str", w.expr(given["x"]))


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
    if not node.args:
        return form("mutable-list") if w.is_mutated(node) else quote(FormCode([]))
    source = arguments_of(w, node, "iterable", "list")["iterable"]
    is_mutable = w.is_mutated(node)
    if isinstance(source, ast.GeneratorExp):
        head = loop_head(w, "/list", source.generators)
        code: Code = FormCode([*head, w.expr(source.elt)])
        return form("mutable", code) if is_mutable else code
    found = w.type(source)
    if is_mutable:
        inner = write_iterable(w, source)
        return form("mutable", form("->list", inner) if found.kinds & (ARRAY | STR | SET | DICT) else inner)
    if found.only(LIST | TUPLE) and not any(site.is_mutated for site in found.sites):
        return w.expr(source)
    if found.kinds & SHAPE:
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
    pairs: list[Code] = []
    tables: list[Code] = []
    for keyword in node.keywords:
        if keyword.arg is None:
            tables.append(w.expr(keyword.value))
        else:
            pairs += w.comment_pair(LiteralCode(keyword.arg, w.span(keyword)), w.expr(keyword.value), keyword)
    for argument in node.args:
        tables.insert(
            0, w.expr(argument) if w.type(argument).only(DICT) else form("list->table", write_iterable(w, argument))
        )
    if not tables:
        return form("table", *pairs)
    if pairs:
        tables.append(form("table", *pairs))
    if len(tables) == 1:
        return (
            tables[0]
            if isinstance(tables[0], FormCode) and w.type(node.args[0]).kinds & ~DICT
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
    return form("print", *(printable(w, a) for a in node.args if not isinstance(a, ast.Starred)))


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
    found = FormCode([*loop_head(w, "/list", source.generators), w.expr(source.elt)])
    if default is None:
        return form("first", found)
    items = PythonVariable("found", None, is_temporary=True)
    body = form("if", form("empty?", VariableRef(items)), w.expr(default), form("first", VariableRef(items)))
    return form("let", FormCode([FormCode([VariableRef(items), found])]), body)
