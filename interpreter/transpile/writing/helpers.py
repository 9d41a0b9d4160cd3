"""Calls of the helper API: ``library_call``, ``primitive_call``, ``loop``, matrices, boxes."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence

from scenelang.grammar.diagnostics import suggest
from scenelang.grammar.python_helpers import HELPERS
from scenelang.grammar.reader import is_keyword_name
from scenelang.interpreter.checker.other_tools import hint_for_primitive
from scenelang.interpreter.checker.rules import unread_hint
from scenelang.interpreter.scene.primitives import block_words, geometry_attributes, solid_words
from scenelang.interpreter.transpile.analysis.inference import POSE, SEQUENCES, SHAPE
from scenelang.interpreter.transpile.analysis.python_text import walk_tree
from scenelang.interpreter.transpile.analysis.scopes import Function, PythonVariable, is_none
from scenelang.interpreter.transpile.writing.code import (
    ArgumentName,
    Code,
    FormCode,
    Key,
    LiteralCode,
    Name,
    VariableRef,
    form,
    is_form,
    none,
    number,
    returns_parts,
)
from scenelang.interpreter.transpile.writing.operators import write_test, write_vector
from scenelang.interpreter.transpile.writing.user_calls import (
    arguments_of,
    expand_starred,
    is_ones,
    is_zero_vector,
    write_argument,
)
from scenelang.interpreter.transpile.writing.writer import WriteExpression, Writer

_BLOCKS = {word.replace("-", "_"): word for word in block_words()}
_SHAPES = {word.replace("-", "_"): word for word in solid_words()}
_ATTRIBUTES = {"block_type": "block-type", "block_kwargs": "block-kwargs"}
_MAX_SHOWN_NAME = 60  # characters of a wrong name in a message
_VECTORS = ("color", "scale", "p0", "p1")


# --- library_call ----------------------------------------------------------------------------------------------


def library_call(w: Writer, node: ast.Call) -> Code:
    keywords = list(node.keywords)
    word = node.args[0] if node.args else None
    if word is None:
        argument = next((k for k in keywords if k.arg == "func_name"), None)
        if argument is None:
            raise w.error("python-call", "missing function name in a call of `library_call`", node)
        keywords.remove(argument)
        word = argument.value
    if len(node.args) > 1:
        raise w.error(
            "python-call", "`library_call` expects one name followed by keyword arguments", node.args[1],
            "pass each argument as `name=value`",
        )  # fmt: skip
    if isinstance(word, ast.Constant) and isinstance(word.value, str):
        target = w.analysed.words.get(word.value)
        if target is None:
            return _unknown_call(w, node, word.value)
        assert target.word is not None
        check_keywords(w, node, target, keywords)
        return _call(w, LiteralCode(target.word, w.span(word)), keywords, target)
    return _computed_call(w, word, keywords)


def _computed_call(w: Writer, word: ast.expr, keywords: list[ast.keyword]) -> Code:
    """Return a call of a computed word; an unknown word evaluates to an empty union, as in the paper's tool."""
    known = possible_words(w, word)
    if known and all(name in w.analysed.words for name in known):
        return _call(w, w.expr(word), keywords)
    if w.is_simple(word):
        return form("if", form("bound?", w.expr(word)), _call(w, w.expr(word), keywords), form("union"))
    variable = PythonVariable("word", None, is_temporary=True)
    body = form("if", form("bound?", VariableRef(variable)), _call(w, VariableRef(variable), keywords), form("union"))
    return form("let", FormCode([FormCode([VariableRef(variable), w.expr(word)])]), body)


def possible_words(w: Writer, word: ast.expr) -> list[str]:
    """Return the words that a variable may hold if they all come from constant displays; empty if unknown."""
    variable = w.variable(word)
    if variable is None or variable.function is None:
        return []
    possible: list[str] = []
    for store in variable.stores:
        source = _source_of(w, store)
        if source is None:
            return []
        strings = [n.value for n in walk_tree(source) if isinstance(n, ast.Constant) and isinstance(n.value, str)]
        if not strings or any(isinstance(n, (ast.Call, ast.BinOp, ast.JoinedStr)) for n in walk_tree(source)):
            return []
        words = [s for s in strings if s in w.analysed.words]
        others = [s for s in strings if s not in w.analysed.words]
        if others and not isinstance(source, ast.Dict):
            return []
        possible += words
    return possible


def _source_of(w: Writer, store: ast.AST) -> ast.expr | None:
    """Return the display that a variable takes its values from, directly or through a loop over it."""
    outer = w.parent(store)
    while isinstance(outer, (ast.Tuple, ast.List)):
        outer = w.parent(outer)
    value: ast.expr | None = None
    if isinstance(outer, (ast.For, ast.comprehension)):
        value = outer.iter
    elif isinstance(outer, ast.Assign):
        value = outer.value
    if isinstance(value, ast.Call) and w.paths.of(value.func) in ("enumerate", "zip") and value.args:
        values = [a for a in value.args if not isinstance(a, ast.Starred)]
        resolved = [_display(w, a) for a in values]
        strings = [r for r in resolved if r is not None and any(_is_string(n) for n in walk_tree(r))]
        return strings[0] if len(strings) == 1 else None
    return _display(w, value) if value is not None else None


def _is_string(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _display(w: Writer, node: ast.expr) -> ast.expr | None:
    if isinstance(node, (ast.List, ast.Tuple, ast.Set, ast.Constant)):
        return node
    variable = w.variable(node)
    if variable is not None and len(variable.stores) == 1 and variable.stores[0] is not node:
        outer = w.parent(variable.stores[0])
        if isinstance(outer, ast.Assign) and outer.targets[0] is variable.stores[0]:
            return _display(w, outer.value)
    return None


def _unknown_call(w: Writer, node: ast.Call, word: str) -> Code:
    known = [f.word for f in w.analysed.words.values() if f.word]
    own = next((f for f in w.names.ordered if f.name == word and not f.is_registered), None)
    line = getattr(own.node, "lineno", 0) if own is not None else 0
    hint = f"`{word}` in line {line} lacks `@register()`" if line else suggest(word, known)
    w.warn("unknown-function", f"no function is registered as `{word}`; the call returns an empty shape", node, hint)
    code = form("union")
    code.after = f'no function is registered as "{word}"'
    return code


def _call(w: Writer, word: Code, keywords: list[ast.keyword], target: Function | None = None) -> Code:
    items: list[Code] = []
    tables: list[Code] = []
    for keyword in keywords:
        if keyword.arg is None:
            tables.append(form("keywords", w.expr(keyword.value)))
            continue
        parameter = target.parameter(keyword.arg) if target is not None else None
        value = write_argument(w, keyword.value, [parameter] if parameter is not None else [])
        items += w.comment_pair(ArgumentName(keyword.arg, w.span(keyword)), value, keyword)
    if tables:
        return form("apply", Name("call"), word, *items, *([form("append", *tables)] if len(tables) > 1 else tables))
    return form("call", word, *items)


def check_keywords(w: Writer, node: ast.Call, target: Function, keywords: list[ast.keyword]) -> None:
    """Raise an error if the keyword arguments of a call do not match the parameters."""
    named = [k.arg for k in keywords if k.arg is not None]
    takes_all = any(p.kind == "keys" for p in target.parameters)
    names = [p.variable.name for p in target.parameters if p.kind in ("plain", "keyword")]
    for keyword in keywords:
        if keyword.arg is not None and keyword.arg not in names and not takes_all:
            raise w.error(
                "python-call", f"`{target.name}` has no parameter `{keyword.arg}`", keyword, suggest(keyword.arg, names)
            )
    if any(k.arg is None for k in keywords):
        return
    missing = [
        p.variable.name for p in target.parameters
        if p.default is None and p.kind in ("plain", "keyword") and p.variable.name not in named
    ]  # fmt: skip
    if missing:
        names_text = ", ".join(f"`{m}`" for m in missing)
        raise w.error("python-call", f"missing arguments in a call of `{target.name}`: {names_text}", node)


# --- primitive_call --------------------------------------------------------------------------------------------


def primitive_call(w: Writer, node: ast.Call) -> Code:
    """Return a primitive; its attributes are those of ``shape_kwargs`` and the keyword arguments, in source order."""
    positional = [name.rstrip("?") for name in HELPERS["primitive_call"].parameters.split()]
    given: list[tuple[str, ast.expr]] = []
    for position, argument in enumerate(expand_starred(w, node.args)):
        if isinstance(argument, ast.Starred) or position >= len(positional):
            raise w.error("python-call", "`primitive_call` expects a name, `shape_kwargs` and `color`", argument)
        given.append((positional[position], argument))
    spread = [keyword.value for keyword in node.keywords if keyword.arg is None]
    given += [(keyword.arg, keyword.value) for keyword in node.keywords if keyword.arg is not None]
    word = next((value for name, value in given if name == "name"), None)
    if word is None:
        raise w.error("python-call", "missing primitive name in a call of `primitive_call`", node)
    items: list[Code] = []
    tables: list[Code] = []
    is_block = bool(spread) and _is_block(w, word)
    for value in spread:
        if is_block:
            tables.append(form("keywords", w.expr(value)))
        else:
            _arguments_in(w, value, {name for name, _ in given}, items, tables)
    for name, value in given:
        if name == "shape_kwargs":
            _shape_kwargs(w, value, items, tables)
            _warn_unused(w, word, value)
        elif name != "name":
            _attribute(w, name, value, items)
    head, word_code = _primitive_word(w, word)
    if tables:
        return form("apply", Name(head), word_code, *items, *([form("append", *tables)] if len(tables) > 1 else tables))
    return form(head, word_code, *items)


def _is_block(w: Writer, word: ast.expr) -> bool:
    """Return whether the primitive is made of Minecraft blocks, whose attributes may be passed as keyword arguments.

    A computed word is assumed to be if the program names such a primitive.
    """
    if isinstance(word, ast.Constant):
        return word.value in _BLOCKS
    nodes = walk_tree(w.analysed.text.tree)
    return any(isinstance(node, ast.Constant) and str(node.value) in _BLOCKS for node in nodes)


def _arguments_in(w: Writer, value: ast.expr, given: set[str], items: list[Code], tables: list[Code]) -> None:
    """Add the attributes of ``**value``, a dictionary that may contain ``shape_kwargs`` and ``color``."""
    if not isinstance(value, ast.Name):
        raise w.unsupported("`**` with an expression other than a variable in a call of `primitive_call`", value)
    if "shape_kwargs" not in given:
        tables.append(form("keywords", form("ref", w.expr(value), LiteralCode("shape_kwargs"), form("table"))))
    if "color" not in given:
        items += [Key("color"), form("ref", w.expr(value), LiteralCode("color"), none())]


def _primitive_word(w: Writer, word: ast.expr) -> tuple[str, Code]:
    """Return ``call`` and the word, or ``primitive`` if the program binds the word itself."""
    bound = {f.word for f in w.names.ordered if f.word}
    if not isinstance(word, ast.Constant):
        return ("primitive" if bound & {*_SHAPES.values(), *_BLOCKS.values()} else "call"), w.expr(word)
    name = str(word.value)
    if name not in _SHAPES and name not in _BLOCKS:
        hint = suggest(name, [*_SHAPES, *_BLOCKS]) or f"available primitives: {', '.join([*_SHAPES, *_BLOCKS])}"
        raise w.error("python-call", f"unknown primitive `{name}`", word, hint)
    name = {**_SHAPES, **_BLOCKS}.get(name, name)
    return ("primitive" if name in bound else "call"), LiteralCode(name, w.span(word))


def _shape_kwargs(w: Writer, value: ast.expr, items: list[Code], tables: list[Code]) -> None:
    pairs: list[tuple[str, ast.expr]] | None = None
    if isinstance(value, ast.Dict) and all(_is_text(key) for key in value.keys):
        pairs = []
        for key, attribute in zip(value.keys, value.values):
            assert isinstance(key, ast.Constant)
            _check_attribute_name(w, str(key.value), key)
            pairs.append((str(key.value), attribute))
    elif isinstance(value, ast.Call) and w.paths.of(value.func) == "dict" and not value.args:
        if all(k.arg is not None for k in value.keywords):
            pairs = [(str(k.arg), k.value) for k in value.keywords]
    elif is_none(value):
        pairs = []
    if pairs is None:
        tables.append(form("keywords", w.expr(value)))
        return
    for name, attribute in pairs:
        _attribute(w, name, attribute, items)


def _warn_unused(w: Writer, word: ast.expr, value: ast.expr) -> None:
    """Warn about attributes that no primitive has; attributes of other primitives are reported by the checker."""
    name_given = word.value if isinstance(word, ast.Constant) else None
    primitive = _SHAPES.get(name_given) if isinstance(name_given, str) else None
    used = None if primitive is None else geometry_attributes(primitive)
    if not isinstance(name_given, str) or primitive is None or used is None or not isinstance(value, ast.Dict):
        return
    for key in value.keys:
        name = key.value if isinstance(key, ast.Constant) else None
        if not isinstance(name, str) or key is None or name in used or hint_for_primitive(name) is not None:
            continue
        if unread_hint(primitive, name) is None:
            hint = "it uses " + ", ".join(f"`{n}`" for n in used)
            w.warn("idle-attribute", f"the primitive `{name_given}` does not use `{name}`", key, hint)


def _is_text(key: ast.expr | None) -> bool:
    return isinstance(key, ast.Constant) and isinstance(key.value, str)


def _attribute(w: Writer, name: str, value: ast.expr, items: list[Code]) -> None:
    """Append ``:name value`` unless it is the default."""
    is_default = (
        (name == "color" and is_ones(value))
        or (name == "fill" and isinstance(value, ast.Constant) and value.value is True)
        or (name == "block_kwargs" and _is_nothing(value))
    )
    if is_default:
        return
    key = Key(_keyword_of(name), w.span(value))
    if name == "color":
        code = write_color(w, value)
    elif name == "block_kwargs":
        code = _block_kwargs(w, value)
    elif name == "fill":
        code = write_test(w, value)
    else:
        code = write_vector(w, value) if name in _VECTORS else w.expr(value)
    items += w.comment_pair(key, code, value)


def _keyword_of(name: str) -> str:
    return _ATTRIBUTES.get(name, name).replace("_", "-")


def _check_attribute_name(w: Writer, name: str, key: ast.expr) -> None:
    """Raise an error if the key of a table cannot be a keyword."""
    if not is_keyword_name(_keyword_of(name)):
        shown = repr(name) if len(name) <= _MAX_SHOWN_NAME else repr(name[:_MAX_SHOWN_NAME]) + "..."
        hint = "an attribute name is a single word such as `radius`"
        raise w.error("python-call", f"invalid attribute name {shown}", key, hint)


def _is_nothing(value: ast.expr) -> bool:
    return (isinstance(value, ast.Dict) and not value.keys) or is_none(value)


def write_color(w: Writer, value: ast.expr) -> Code:
    """Return a color of three components; a fourth, alpha, is dropped."""
    if isinstance(value, (ast.Tuple, ast.List)) and len(value.elts) == 4:
        if not any(isinstance(e, ast.Starred) for e in value.elts) and not w.effect(value.elts[3]).has_effect:
            return write_vector(w, ast.copy_location(ast.Tuple(value.elts[:3], ast.Load()), value))
    code = write_vector(w, value)
    length = w.known_length(value)
    if length is not None and length > 3:
        return form("slice", code, LiteralCode(0), LiteralCode(3))
    return code


def _block_kwargs(w: Writer, value: ast.expr) -> Code:
    """Return the states of a block as an association list; other expressions may be tables."""
    if not isinstance(value, ast.Dict) or not all(isinstance(key, ast.Constant) for key in value.keys):
        return w.expr(value)
    is_constant = all(isinstance(v, ast.Constant) for v in value.values)
    rows: list[Code] = []
    for key, item in zip(value.keys, value.values):
        assert key is not None
        code = w.expr(item)
        if not isinstance(item, ast.Constant):
            code = form("unquote", code)
        rows.append(w.comment_item(FormCode([w.expr(key), code]), key))
    return form("quote" if is_constant else "quasiquote", FormCode(rows))


# --- shapes ----------------------------------------------------------------------------------------------------


def concat_shapes(w: Writer, node: ast.Call) -> Code:
    if node.keywords:
        raise w.error("python-call", f"`concat_shapes` has no parameter `{node.keywords[0].arg}`", node.keywords[0])
    if node.args and w.type(node).only(POSE):
        return _first_matrix(w, node, node.args)
    items: list[Code] = []
    for argument in node.args:
        value = argument.value if isinstance(argument, ast.Starred) else argument
        code = w.expr(value)
        if is_form(code, "union") and isinstance(code, FormCode) and len(node.args) > 1 and not code.after:
            items += code.items[1:] if isinstance(argument, ast.Starred) else [code]
        elif isinstance(argument, ast.Starred) and isinstance(value, (ast.List, ast.Tuple)) and is_form(code, "list"):
            assert isinstance(code, FormCode)
            items += code.items[1:]
        else:
            items.append(w.comment_item(code, argument))
    if len(items) == 1 and (returns_parts(items[0]) or _is_union_list(w, node.args[0])):
        return items[0]
    return form("union", *items)


def _first_matrix(w: Writer, node: ast.Call, matrices: Sequence[ast.expr]) -> Code:
    """Return the first of several matrices concatenated into a pose, of which the paper's tool only reads four rows."""
    hint = "to apply both, `b` first, write `a @ b`"
    w.warn("python-ignored", "only the first of several matrices concatenated into a pose has an effect", node, hint)
    first = matrices[0]
    code = form("ref", w.expr(first.value), number(0)) if isinstance(first, ast.Starred) else w.expr(first)
    return form("begin", *(w.expr(m) for m in matrices[1:]), code) if w.effect(*matrices[1:]).has_effect else code


def _joined_matrices(w: Writer, node: ast.expr) -> Sequence[ast.expr]:
    """Return the 4x4 matrices that ``np.concatenate`` or ``np.vstack`` joins along the first axis, or none."""
    if not isinstance(node, ast.Call) or len(node.args) != 1 or node.keywords:
        return ()
    parts = node.args[0]
    if w.paths.of(node.func) not in ("numpy.concatenate", "numpy.vstack") or not isinstance(
        parts, (ast.List, ast.Tuple)
    ):
        return ()
    return parts.elts if parts.elts and all(w.type(part).only(POSE) for part in parts.elts) else ()


def _pose(w: Writer, node: ast.expr) -> Code:
    joined = _joined_matrices(w, node)
    if joined and isinstance(node, ast.Call):
        return _first_matrix(w, node, joined)
    return w.expr(node)


def _is_union_list(w: Writer, argument: ast.expr) -> bool:
    """Return whether an argument is a variable whose list was collected as parts."""
    if not isinstance(argument, ast.Starred):
        return False
    variable = w.variable(argument.value)
    return variable is not None and variable in w.unions


def _given(w: Writer, node: ast.Call, name: str) -> dict[str, ast.expr]:
    """Return the arguments of a call of a helper, by parameter."""
    return arguments_of(w, node, HELPERS[name].parameters, name)


def transform_shape(w: Writer, node: ast.Call) -> Code:
    given = _given(w, node, "transform_shape")
    values = [given["shape"], given["pose"]]
    return in_order(w, values, [Writer.expr, _pose], lambda shape, pose: form("transform", shape, pose))


def loop(w: Writer, node: ast.Call) -> Code:
    given = _given(w, node, "loop")
    function = w.type(given["fn"])
    if any(_never_returns_shape(w, f) for f in function.functions):
        raise w.error("python-call", "the function passed to `loop` does not return a shape", given["fn"])
    return form("union-loop", w.expr(given["n"]), w.expr(given["fn"]))


def _never_returns_shape(w: Writer, function: Function) -> bool:
    returned = w.facts.returns.get(function)
    return returned is not None and returned.kinds != 0 and not returned.may(SHAPE | SEQUENCES)


def in_order(w: Writer, values: list[ast.expr], writers: Sequence[WriteExpression], build: Callable[..., Code]) -> Code:
    """Return a call whose arguments are evaluated in Python's order, through a ``let*`` if the order matters."""
    positions = [(v.lineno, v.col_offset) for v in values]
    codes = [write(w, value) for write, value in zip(writers, values)]
    if positions == sorted(positions) or all(
        w.effect(a).commutes(w.effect(b)) for i, a in enumerate(values) for b in values[i + 1 :]
    ):
        return build(*codes)
    order = sorted(range(len(values)), key=lambda i: positions[i])
    variables = [PythonVariable("value", None, is_temporary=True) for _ in values]
    bindings = FormCode([FormCode([VariableRef(variables[i]), codes[i]]) for i in order])
    return form("let*", bindings, build(*(VariableRef(v) for v in variables)))


# --- poses and boxes -------------------------------------------------------------------------------------------


def translation_matrix(w: Writer, node: ast.Call) -> Code:
    given = _given(w, node, "translation_matrix")
    return form("translate", write_vector(w, given["offset"]))


def rotation_matrix(w: Writer, node: ast.Call) -> Code:
    given = _given(w, node, "rotation_matrix")
    values = [given["angle"], given["direction"]]
    if not is_zero_vector(given.get("point")):
        values.append(given["point"])
    writers = [Writer.expr, write_vector, write_vector]
    return in_order(w, values, writers, lambda *codes: form("rotate", *codes))


def scale_matrix(w: Writer, node: ast.Call) -> Code:
    given = _given(w, node, "scale_matrix")
    values = [given["scale"]]
    if not is_zero_vector(given.get("origin")):
        values.append(given["origin"])
    return in_order(w, values, [write_vector, write_vector], lambda *codes: form("scale", *codes))


def reflection_matrix(w: Writer, node: ast.Call) -> Code:
    given = _given(w, node, "reflection_matrix")
    if is_zero_vector(given["point"]):
        return form("reflect", write_vector(w, given["normal"]))
    values = [given["point"], given["normal"]]
    return in_order(w, values, [write_vector, write_vector], lambda *codes: form("reflect", *codes))


def identity_matrix(w: Writer, node: ast.Call) -> Code:
    _given(w, node, "identity_matrix")
    return form("identity-pose")


def box(name: str) -> Callable[[Writer, ast.Call], Code]:
    def write(w: Writer, node: ast.Call) -> Code:
        given = _given(w, node, f"compute_shape_{name}")
        return form(f"compute-shape-{name}", w.expr(given["shape"]))

    return write


def registration(w: Writer, node: ast.Call) -> Code:
    raise w.unsupported("`register` as a call", node, "use it as a decorator: `@register()`")
