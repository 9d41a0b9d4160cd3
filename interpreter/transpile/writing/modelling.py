"""Calls of Python mode for solids, profiles and paths, and ``assert_that`` with its relations.

They become the forms of the language as they are written; nothing is evaluated. Arguments are bound here, so that one
that does not fit is an error at its place in the Python; their types are those that the checker knows of the builtins.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence

from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.runtime.modelling_helpers import (
    VALUE,
    ModellingHelper,
    RelationHelper,
    is_vector,
    relation_helpers,
    scene_helpers,
)
from scenelang.interpreter.runtime.types import BuiltinParameter
from scenelang.interpreter.scene.declarations import COLOR, FLAGS
from scenelang.interpreter.transpile.analysis.scopes import is_none
from scenelang.interpreter.transpile.writing.code import Code, FormCode, Key, LiteralCode, Name, form
from scenelang.interpreter.transpile.writing.helpers import in_order, write_color
from scenelang.interpreter.transpile.writing.operators import write_iterable, write_vector
from scenelang.interpreter.transpile.writing.user_calls import expand_starred
from scenelang.interpreter.transpile.writing.writer import WriteExpression, Writer

# --- solids, profiles and paths ----------------------------------------------------------------------------------


def modelling_call(w: Writer, node: ast.Call) -> Code:
    """Return the call of the builtin, or of the part, that a function of Python mode stands for."""
    helper = scene_helpers()[w.paths.of(node.func) or ""]
    positional, keywords = _bound(w, node, helper)
    if any(isinstance(value, ast.Starred) for value in positional):
        return _spread(w, helper, positional, keywords)
    values = [*positional, *(keyword.value for keyword in keywords)]
    writers = [*_writers(helper, len(positional)), *(_keyword_writer(helper, keyword) for keyword in keywords)]
    count = len(positional)
    if helper.module:
        w.imports.add(helper.module)
    head = [Name("call"), LiteralCode(helper.counterpart)] if helper.is_word else [Name(helper.counterpart)]
    return in_order(
        w, values, writers, lambda *codes: FormCode([*head, *codes[:count], *_pairs(w, keywords, codes[count:])])
    )


def _bound(w: Writer, node: ast.Call, helper: ModellingHelper) -> tuple[list[ast.expr], list[ast.keyword]]:
    """Return the positional arguments of a call in the order of the parameters, and its keyword arguments."""
    values = expand_starred(w, node.args)
    named = _named(w, node, (*helper.positional, *helper.keywords), helper)
    for name in helper.positional[len(values) :]:
        if name in named:
            values.append(named.pop(name).value)
    twice = next((keyword for name, keyword in named.items() if name in helper.positional), None)
    if twice is not None:
        raise _misfit(w, helper, f"wrong or missing arguments before `{twice.arg}` in a call of `{helper.name}`", twice)
    has_star = any(isinstance(value, ast.Starred) for value in values)
    if not has_star and not helper.signature.takes(len(values)):
        raise _misfit(w, helper, f"`{helper.name}` expects other arguments, got {len(values)}", node)
    return values, [keyword for keyword in named.values() if not is_none(keyword.value)]


def _named(
    w: Writer, node: ast.Call, names: Sequence[str], helper: ModellingHelper | RelationHelper
) -> dict[str, ast.keyword]:
    """Return the keyword arguments of a call by name; raise an error for one that the function does not take."""
    named: dict[str, ast.keyword] = {}
    for keyword in node.keywords:
        if keyword.arg is None:
            raise w.unsupported(f"`**` in a call of `{helper.name}`", keyword.value)
        if keyword.arg not in names:
            hint = suggest(keyword.arg, names)
            raise _misfit(w, helper, f"`{helper.name}` has no parameter `{keyword.arg}`", keyword, hint)
        named[keyword.arg] = keyword
    return named


def _misfit(
    w: Writer, helper: ModellingHelper | RelationHelper, message: str, node: ast.AST, hint: str | None = None
) -> SceneError:
    """Return the error of arguments that do not fit, with the signature."""
    error = w.error("python-call", message, node, hint or f"write `{helper.usage}`")
    error.signature = helper.usage
    return error


def _writers(helper: ModellingHelper, count: int) -> list[WriteExpression]:
    """Return how the first positional arguments of a helper are written."""
    parameters = helper.signature.positional[:count]
    rest = [Writer.expr] * (count - len(parameters))
    return [*(write_vector if is_vector(each) else Writer.expr for each in parameters), *rest]


def _keyword_writer(helper: ModellingHelper, keyword: ast.keyword) -> WriteExpression:
    """Return how the value of a keyword argument is written: a color, the name of a choice, or as it is."""
    parameter = helper.keywords[keyword.arg or ""]
    if parameter.name == "color":
        return write_color
    return _write_choice if _is_choice(parameter) else _write_option


def _write_option(w: Writer, value: ast.expr) -> Code:
    """Return a value as it is, several numbers as a vector: such as one factor or two."""
    is_vector_display = isinstance(value, (ast.Tuple, ast.List)) and w.is_vector_literal(value)
    return write_vector(w, value) if is_vector_display else w.expr(value)


def _is_choice(parameter: BuiltinParameter) -> bool:
    """Return whether a parameter takes a keyword of the language, which Python writes as a text."""
    return parameter.type.name == "Keyword"


def _write_choice(w: Writer, value: ast.expr) -> Code:
    """Return the keyword of the language for a text, ``:miter`` for ``"miter"``."""
    if not (isinstance(value, ast.Constant) and isinstance(value.value, str) and value.value.isidentifier()):
        raise w.unsupported("a choice that is no constant text", value, 'write the text itself, such as `"round"`')
    return Key(value.value.replace("_", "-"), w.span(value))


def _pairs(w: Writer, keywords: Sequence[ast.keyword], values: Sequence[Code]) -> Iterator[Code]:
    """Yield keyword arguments with their values."""
    for keyword, value in zip(keywords, values, strict=True):
        yield Key((keyword.arg or "").replace("_", "-"), w.span(keyword))
        yield value


def _spread(
    w: Writer, helper: ModellingHelper, positional: Sequence[ast.expr], keywords: Sequence[ast.keyword]
) -> Code:
    """Return ``(apply f a :key b list)`` for ``f(a, *list, key=b)``."""
    first = next(position for position, value in enumerate(positional) if isinstance(value, ast.Starred))
    if helper.signature.rest is None:
        raise w.unsupported(f"`*` of an unknown number of arguments in a call of `{helper.name}`", positional[first])
    before = [write(w, value) for write, value in zip(_writers(helper, first), positional)]
    lists = [
        write_iterable(w, value.value) if isinstance(value, ast.Starred) else form("list", w.expr(value))
        for value in positional[first:]
    ]
    values = [_keyword_writer(helper, keyword)(w, keyword.value) for keyword in keywords]
    tail = lists[0] if len(lists) == 1 else form("append", *lists)
    return form("apply", Name(helper.counterpart), *before, *_pairs(w, keywords, values), tail)


# --- declarations ------------------------------------------------------------------------------------------------


def assert_that(w: Writer, node: ast.Call) -> Code:
    """Return the declarations of ``assert_that(on("cup", "table"), not near, "message")``."""
    values = list(node.args)
    given = {keyword.arg: keyword for keyword in node.keywords}
    unknown = next((keyword for name, keyword in given.items() if name != "message"), None)
    if unknown is not None:
        hint = 'options belong to a relation: `assert_that(clear_of("chair", "chair", min=.1))`'
        raise w.error("python-call", f"`assert_that` has no parameter `{unknown.arg}`", unknown, hint)
    if len(values) > 1 and isinstance(values[-1], (ast.Constant, ast.JoinedStr)) and "message" not in given:
        messages = [values.pop()]
    else:
        messages = [keyword.value for keyword in given.values()]
    stated = [relation for value in values for relation in _relations(w, value)]
    if not stated:
        raise w.error("python-call", "`assert_that` expects relations", node, 'write `assert_that(on("cup", "table"))`')
    return form("assert-that", *stated, *map(w.expr, messages))


def relation_alone(w: Writer, node: ast.Call) -> Code:
    """Raise the error for a relation that is no argument of ``assert_that``."""
    name = w.text.text(node.func)
    message = f"`{name}` is a relation, which only `assert_that` takes"
    raise w.error("python-call", message, node, f"write `assert_that({name}(...))`")


def _relations(w: Writer, value: ast.expr) -> Iterator[Code]:
    """Yield the relations of an argument of ``assert_that``: one, or several joined by ``and``."""
    if isinstance(value, ast.BoolOp) and isinstance(value.op, ast.And):
        for each in value.values:
            yield from _relations(w, each)
    else:
        yield _relation(w, value)


def _relation(w: Writer, value: ast.expr) -> Code:
    """Return one relation with its operands and options, or one with ``not``."""
    if isinstance(value, ast.UnaryOp) and isinstance(value.op, ast.Not):
        return form("not", _relation(w, value.operand), span=w.span(value))
    path = w.paths.of(value.func) if isinstance(value, ast.Call) else None
    helper = relation_helpers().get(path or "")
    if helper is None or not isinstance(value, ast.Call):
        raise _no_relation(w, value)
    operands, options = _operands(w, value, helper)
    kinds = [helper.relation.kind_of(position) for position in range(len(operands))]
    written = [(write_color if kind == COLOR and not _is_text(each) else Writer.expr)(w, each)
               for kind, each in zip(kinds, operands)]  # fmt: skip
    return FormCode([Name(helper.relation.name), *written, *_options(w, helper, options)], w.span(value))


def _is_text(value: ast.expr) -> bool:
    """Return whether an expression is a constant text."""
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


def _no_relation(w: Writer, value: ast.expr) -> SceneError:
    """Return the error of an argument of ``assert_that`` that is no relation."""
    name = value.func.id if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) else None
    if name in relation_helpers():
        message = f"`{name}` is a name of the program here, and no relation"
        return w.error("python-call", message, value, f"give what the program calls `{name}` another name")
    if name is not None:
        known = relation_helpers()
        hint = suggest(name, known) or f"the relations are {', '.join(known)}"
        return w.error("python-call", f"unknown relation `{name}`", value, hint)
    hint = 'write `on("cup", "table")`; for several words, call `assert_that` in a loop'
    return w.error("python-call", "`assert_that` expects relations", value, hint)


def _operands(w: Writer, node: ast.Call, helper: RelationHelper) -> tuple[list[ast.expr], dict[str, ast.expr]]:
    """Return the operands of a relation in order, and its options by their names in Python."""
    values = expand_starred(w, node.args)
    starred = next((value for value in values if isinstance(value, ast.Starred)), None)
    if starred is not None:
        raise w.unsupported(f"`*` of an unknown number of operands in `{helper.name}`", starred)
    named = _named(w, node, (*helper.operands, VALUE, *helper.keywords), helper)
    for position, name in enumerate(helper.operands):
        takes_value = position == len(helper.operands) - 1 and helper.relation.kind_of(position) != "object"
        keyword = named.get(name) or (named.get(VALUE) if takes_value else None)
        if keyword is not None and position == len(values):
            values.append(named.pop(keyword.arg or "").value)
    wrong = next((each for name, each in named.items() if name in (*helper.operands, VALUE)), None)
    problem = helper.relation.wrong_count(len(values))
    if wrong is not None or problem is not None:
        message = problem or f"`{helper.name}` has no operand left for `{wrong.arg if wrong else VALUE}`"
        raise _misfit(w, helper, message.replace(f"`{helper.relation.name}`", f"`{helper.name}`"), wrong or node)
    return values, {name: keyword.value for name, keyword in named.items() if not is_none(keyword.value)}


def _options(w: Writer, helper: RelationHelper, options: Mapping[str, ast.expr]) -> Iterator[Code]:
    """Yield the options of a relation: a flag that is true alone, any other with its value."""
    for name, value in options.items():
        option = helper.keywords[name]
        if option not in FLAGS:
            yield Key(option, w.span(value))
            yield w.expr(value)
        elif not (isinstance(value, ast.Constant) and isinstance(value.value, bool)):
            raise w.unsupported(f"a value other than `True` and `False` for `{name}`", value)
        elif value.value:
            yield Key(option, w.span(value))
