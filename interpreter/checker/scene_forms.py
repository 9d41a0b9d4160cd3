"""Checks of the scene forms: ``bind``, ``call``, ``transform``, ``union`` and ``union-loop``.

The functions report mistakes to ``inference``. ``node`` is an expression and ``kind`` the kind of its value.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix, SceneError
from scenelang.interpreter.checker.calls import check_keywords, split, takes
from scenelang.interpreter.checker.common import (
    A_PART,
    MAX_SHOWN,
    accepts,
    advice_on_value,
    arity_of,
    brief,
    is_keyword,
    is_profile,
    may_be_parts,
    profile_hint,
    shown,
    swap_fix,
    triple_fix,
    wrap_fix,
)
from scenelang.interpreter.checker.other_tools import hint_for_primitive
from scenelang.interpreter.compile.analyze import called_builtin
from scenelang.interpreter.compile.kinds import (
    ANY,
    ARRAYS,
    ENTITY,
    LIST,
    MATRIX,
    NEVER,
    PART,
    PARTS,
    Kind,
    describe,
    item_of,
    join,
    length_of,
)
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.parts import OF_ENTITIES
from scenelang.interpreter.scene.primitives import (
    COLOR,
    MATERIALS,
    PHYSICS,
    Attribute,
    find,
    former_word,
    word_of_today,
)

if TYPE_CHECKING:
    from scenelang.interpreter.checker.infer import KindInference

_PHYSICS_NAMES = frozenset(attribute.name for attribute in PHYSICS)
_ENTITY_ARGUMENTS = 2  # positional arguments that ``call`` passes to the function of a word: embedding and handles


# --- words -----------------------------------------------------------------------------------------------------------


def call_word(inference: KindInference, node: ast.Call, word: Kind, arguments: Sequence[Kind]) -> Kind:
    """Check ``(call word argument ...)``."""
    if not accepts("Word", word):
        report_word(inference, node.word, word, "call")
        return ENTITY
    name = node.word.value if type(node.word) is ast.Constant else None
    owner = f'"{name}"' if name is not None else "the word"
    if not _check_embeddings(inference, node, owner):
        return ENTITY
    parts = split(inference, node, node.arguments, owner, "")
    if parts is None or name is None:
        return ENTITY
    positional, keywords = parts
    function = inference.world.word_function(name)
    if function is not None:
        _call_bound(inference, node, name, function, positional, keywords)
    elif not inference.world.may_be_bound(name):
        check_primitive(inference, node, name, positional, keywords)
    return ENTITY


def call_primitive(inference: KindInference, node: ast.Application) -> None:
    """Check ``(primitive word argument ...)``."""
    word = node.arguments[0] if node.arguments else None
    if type(word) is not ast.Constant or type(word.value) is not str:
        return
    call = ast.Call(word, node.arguments[1:], node.span)
    if _check_embeddings(inference, call, f'"{word.value}"'):
        parts = split(inference, node, node.arguments[1:], f'"{word.value}"', "")
        if parts is not None:
            check_primitive(inference, node, word.value, *parts)


def report_word(inference: KindInference, node: Any, kind: Kind, form: str) -> None:
    """Report a word of ``call`` or ``bind`` that is not a string."""
    text = node.span.text
    is_name = type(node) is ast.Reference and node.span.expansion is None
    hint = f'write the word in quotes: `"{text}"`' if is_name else None
    inference.report(
        "word", f"`{form}` expects a string for the word, got {shown(node, kind)}", node.span, hint,
        expected="a String", found=describe(kind),
    )  # fmt: skip


def _check_embeddings(inference: KindInference, node: ast.Call, owner: str) -> bool:
    """Check that the positional arguments of a call may be embeddings.

    Returns False after a report, and True for a computed argument, which may be a keyword.
    """
    pending = iter(node.arguments)
    written: list[tuple[Any, Any]] = []
    for argument in pending:
        if is_keyword(argument):
            value = next(pending, None)
            if value is None:
                break
            written.append((argument, value))
            continue
        kind = inference.result.kinds[argument]
        if kind is ANY or kind is NEVER:
            return True  # it may be a keyword, and the next argument its value
        tags = {option.tag for option in kind.options}
        if "Keyword" in tags:
            return True
        if tags & {"Embedding", "String"}:
            continue
        text = argument.span.text
        empty = next((key for key, value in written if is_keyword(value)), None)
        if empty is not None:
            message = f"missing value after `{empty.span.text}` in a call of {owner}"
            following = next(value.span.text for key, value in written if key is empty)
            sample = _sample(inference, node, str(empty.value))
            example = f"{empty.span.text} {sample}"
            hint = f"the next item is the keyword `{following}`: write a value between them, such as `{example}`"
            inference.report("embedding", message, empty.span, hint, expected="a value", found="a keyword")
            return False
        spelled = _spelled_attribute(inference, node, argument)
        if spelled is not None:
            return spelled
        hint = _named_values(inference, node, argument) or "a word is called with names: `(call word :name value)`"
        fixes: tuple[Fix, ...] = ()
        if len(node.arguments) == 1 and type(node.word) is ast.Constant and argument.span.expansion is None:
            only = _only_attribute(inference, node.word.value, kind)
            if kind is MATRIX:
                hint = "a part is placed by `transform`: `(transform (call ...) pose)`"
            elif kind is ENTITY:
                hint = "entities are put together by `union`"
            if only is not None:
                is_short = len(text) <= MAX_SHOWN
                hint = f"name the attribute: `:{only} {text}`" if is_short else f"write `:{only}` before it"
                fixes = (Fix(f"Name it `:{only}`", (Edit(argument.span, f":{only} {text}"),), safe=True),)
        if kind is ENTITY and type(node.word) is ast.Constant and node.word.value in OF_ENTITIES:
            name = str(node.word.value)
            hint, fixes = f"`{name}` is a function: write `({name} ...)`", _called_fix(node, name)
        inference.report(
            "embedding",
            f"{owner} takes values by name, as `:name value`, but got {shown(argument, kind)}",
            argument.span, hint, fixes=fixes, expected="an Embedding", found=describe(kind),
        )  # fmt: skip
        return False
    return True


def _sample(inference: KindInference, node: ast.Call, name: str) -> str:
    """Return a value that an attribute may have."""
    word = node.word.value if type(node.word) is ast.Constant else None
    cls = _primitive(word) if type(word) is str and inference.world.word_function(word) is None else None
    known = (COLOR, *MATERIALS, *(cls.attributes if cls is not None else ()))
    accepted = next((attribute.accepts for attribute in known if attribute.name == name), ())
    if "Color" in accepted:
        return '(color "red")'
    return "1" if "Number" in accepted or not accepted else "[0 1 0]" if "Triple" in accepted else '"name"'


def _named_values(inference: KindInference, node: ast.Call, argument: Any) -> str | None:
    """Return the hint for values without names: the call with the names that they may have, or these names."""
    if type(node.word) is not ast.Constant:
        return None
    arguments: Sequence[Any] = node.arguments
    given = {str(key.value) for key in arguments if is_keyword(key)}
    names = [name for name in _attribute_names(inference, node.word.value) if name not in given]
    function = inference.world.word_function(node.word.value)
    if function is not None and not any(p.kind in ("keyword", "keys") for p in function.parameters):
        name = next((p.name for p in function.parameters if p.kind == "required"), "size")
        call = f"(call {node.word.span.text} :{name} {argument.span.text[:MAX_SHOWN]})"
        return f"give it a keyword parameter, `(lambda (:{name}) ...)`, and write `{call}`"
    plain = arguments if not given else (argument,)
    is_written = all(value.span.expansion is None for value in (node, *plain))
    if function is not None and is_written and len(plain) <= len(names):
        pairs = " ".join(f":{name} {value.span.text}" for name, value in zip(names, plain))
        written = f"(call {node.word.span.text} {pairs})" if not given else pairs
        if len(written) <= _MAX_CALL:
            return f"write `{written}`"
    if function is None and names:
        kind = inference.result.kinds[argument]
        fitting = [name for name in names if _takes_kind(node.word.value, name, kind)] or names
        return f"name the value: {' or '.join(f'`:{name} {argument.span.text[:MAX_SHOWN]}`' for name in fitting[:3])}"
    if not names:
        return f"name the value, such as `:scale {argument.span.text[:MAX_SHOWN]}`" if function is None else None
    return f"name the value: {', '.join(f'`:{name}`' for name in names[:6])}"


_MAX_CALL = 80  # characters of a call in a hint


def _takes_kind(word: str, name: str, kind: Kind) -> bool:
    """Return whether an attribute of a primitive accepts a value."""
    attribute = next((each for each in _primitive(word).attributes if each.name == name), None)
    return attribute is not None and any(accepts(type_, kind) for type_ in attribute.accepts)


def _called_fix(node: ast.Call, name: str) -> tuple[Fix, ...]:
    """Return the edit of ``(call "difference" ...)`` to ``(difference ...)``."""
    word = node.word.span
    if word.expansion is not None or not node.span.text.startswith("("):
        return ()
    return (Fix(f"Call `{name}`", (Edit(Span(word.source, node.span.start + 1, word.end), name),), safe=True),)


def _spelled_attribute(inference: KindInference, node: ast.Call, argument: Any) -> bool | None:
    """Report ``(call "cube" scale 2)``, where the name of an attribute lacks its colon.

    Returns None if this is not the case.
    """
    if type(argument) is not ast.Reference or type(node.word) is not ast.Constant:
        return None
    if argument.span.expansion is not None:
        return None
    text = argument.span.text
    if text not in (
        *_attribute_names(inference, node.word.value),
        COLOR.name,
        *(attribute.name for attribute in (*MATERIALS, *PHYSICS)),
    ):
        return None
    at = Span(argument.span.source, argument.span.start, argument.span.start)
    inference.report(
        "embedding", f"the attribute `{text}` lacks its colon", argument.span, f"write `:{text}`",
        fixes=(Fix(f"Write `:{text}`", (Edit(at, ":"),), safe=True),), expected=f":{text}", found=text,
    )  # fmt: skip
    return False


def _attribute_names(inference: KindInference, word: str) -> list[str]:
    """Return the known attributes of a word."""
    function = inference.world.word_function(word)
    if function is not None:
        return [p.name for p in function.parameters if p.kind == "keyword"]
    cls = None if inference.world.may_be_bound(word) else _primitive(word)
    return [attribute.name for attribute in cls.attributes] if cls is not None else []


def _only_attribute(inference: KindInference, word: str, kind: Kind) -> str | None:
    """Return the only attribute of a word that accepts a value of this kind, or None."""
    function = inference.world.word_function(word)
    if function is not None:
        names = [p.name for p in function.parameters if p.kind == "keyword" and takes(p, kind)]
        return names[0] if len(names) == 1 else None
    if inference.world.may_be_bound(word) or (cls := _primitive(word)) is None:
        return None
    names = [attribute.name for attribute in cls.attributes if any(accepts(name, kind) for name in attribute.accepts)]
    return names[0] if len(names) == 1 else None


def _primitive(word: str) -> Any:
    """Return the class of a primitive, or None."""
    try:
        return find(word)
    except SceneError:
        return None


def _call_bound(
    inference: KindInference,
    node: ast.Call,
    word: str,
    function: ast.Lambda,
    positional: Sequence[Any],
    keywords: Sequence[tuple[str, Any, Any]],
) -> None:
    """Check a call of a word of the program against the function that it is bound to."""
    owner = f'"{word}"'
    named = {p.name: p for p in function.parameters if p.kind == "keyword"}
    takes_any = any(p.kind == "keys" for p in function.parameters)
    required = sum(p.kind == "required" for p in function.parameters)
    if required > _ENTITY_ARGUMENTS:
        _report_too_many_required(inference, node, word, function, required)
        return
    if not named and not takes_any:
        _warn_plain_parameters(inference, node, word, function, keywords)
        return
    embeddings = () if any(map(_may_carry_attributes, positional)) else None
    checked = [keyword for keyword in keywords if keyword[0] in named or keyword[0] not in _PHYSICS_NAMES]
    check_keywords(inference, node, owner, "attribute", function, checked, embeddings)


def _may_carry_attributes(node: Any) -> bool:
    """Return whether an embedding may have attributes: a text has none, a handle may have some in Z."""
    return not (type(node) is ast.Constant and type(node.value) is str)


def _report_too_many_required(
    inference: KindInference, node: ast.Call, word: str, function: ast.Lambda, required: int
) -> None:
    """Report a word's function with more required parameters than ``call`` passes."""
    hint = f"make them keyword parameters, such as `:{function.parameters[0].name}`; parameters: {function.usage}"
    inference.report(
        "arity", f'the function of "{word}" has {required} required parameters, but `call` passes at most two',
        node.span,
        hint, expected="at most 2 required parameters", found=str(required), signature=function.usage,
    )  # fmt: skip


def _warn_plain_parameters(
    inference: KindInference, node: ast.Call, word: str, function: ast.Lambda, keywords: Sequence[tuple[str, Any, Any]]
) -> None:
    """Warn about ``(call "leg" :height 2)`` where the function has ``height`` as a positional parameter."""
    names = {p.name: p for p in function.parameters if p.kind in ("required", "optional")}
    for key, key_node, _ in keywords:
        if key in names:
            embedding = "the embedding" if names[key] is function.parameters[0] else "an embedding"
            message = f'"{word}" takes `{key}` by position, so that it is {embedding}, not the value of `:{key}`'
            hint = f"make it a keyword parameter: `(lambda (:{key}) ...)`"
            fixes = keyword_fixes(names[key], function)
            inference.warn("plain-parameter", message, key_node.span, hint, fixes)
            return


def keyword_fixes(parameter: ast.Parameter, function: ast.Lambda) -> tuple[Fix, ...]:
    """Return the fix that makes a positional parameter a keyword parameter."""
    span = parameter.target.span if isinstance(parameter.target, Variable) else None
    if span is None or span.expansion is not None or function.span.expansion is not None:
        return ()
    edit = Edit(Span(span.source, span.start, span.start), ":")
    return (Fix("Make it a keyword parameter", (edit,), safe=True),)


# --- primitives ------------------------------------------------------------------------------------------------------


def check_primitive(
    inference: KindInference,
    node: Any,
    word: str,
    positional: Sequence[Any],
    keywords: Sequence[tuple[str, Any, Any]],
) -> None:
    """Check the attributes of a primitive: their kinds, and the values of literals.

    Parameters
    ----------
    node
        The call.
    word
        Word of the primitive; any word that is not bound is a semantic primitive.
    positional, keywords
        Arguments of the call, as ``calls.split`` returns them.
    """
    cls = _primitive(word)
    today = word_of_today(word, [key for key, _, _ in keywords]) if cls is None else None
    if today is not None:
        fix = Fix(f'Change to "{today}"', (Edit(node.word.span, f'"{today}"'),), safe=True)
        inference.report("attribute", former_word(word, today), node.word.span, f'write `(call "{today}" ...)`',
                         fixes=(fix,))  # fmt: skip
        return
    attributes = cls.attributes if cls is not None else ()
    known = {attribute.name: attribute for attribute in (COLOR, *MATERIALS, *_physics_of(cls), *attributes)}
    for key, _, value in keywords:
        attribute = known.get(key)
        if attribute is not None and attribute.accepts:
            _check_attribute(inference, word, attribute, value)
    given = {key.partition("=")[0] for key, _, _ in keywords}  # `:file="a.glb"` has an error of its own
    needed = [each for each in attributes if each.needed and each.name not in given]
    if needed and not any(map(_may_carry_attributes, positional)):
        name, value = needed[0].name, needed[0].needed
        meant = [said[0] for key in given if (said := hint_for_primitive(key)) is not None]  # as `:vertices` of a mesh
        hint = meant[0] if meant else f'write `(call "{word}" :{name} {value})`'
        inference.report("attribute", f'the primitive "{word}" requires the attribute `:{name}`, a string', node.span,
                         hint, expected=f":{name}", found="nothing", signature=_usage_of(word))  # fmt: skip
    _warn_of_further_embeddings(inference, word, positional)
    ends = [value for key, _, value in keywords if key in ("p0", "p1")]
    points = [[inference.number_of(item) for item in end.items] for end in ends if type(end) is ast.ArrayLiteral]
    if "p0" in known and len(points) == 2 and points[0] == points[1] and None not in points[0]:
        message = f'the ends `:p0` and `:p1` of "{word}" are the same point, so that it has no length'
        inference.warn("no-extent", message, ends[1].span, expected="two points", found=ends[1].span.text)


def _physics_of(cls: Any) -> tuple[Attribute, ...]:
    """Return the physics attributes of a primitive; a semantic primitive passes all attributes on to a model."""
    return PHYSICS if cls is not None and not cls.is_semantic else ()


def _warn_of_further_embeddings(inference: KindInference, word: str, positional: Sequence[Any]) -> None:
    """Warn of embeddings after the first one, which are those of parts: a primitive has none."""
    for further in positional[1:]:
        if inference.result.kinds[further].tag in ("String", "Embedding"):
            kinds = [inference.result.kinds[each].tag for each in positional[:2]]
            texts = " ".join(each.span.text for each in positional[:2])
            hint = "write one text" if kinds[0] == kinds[1] else f"join them: `(embedding {texts})`"
            message = f'"{word}" has no parts, so that only its first embedding counts'
            inference.warn("idle-attribute", message, further.span, hint)
            return


def _usage_of(word: str) -> str:
    """Return the attributes of a primitive as a call."""
    cls = _primitive(word)
    names = [COLOR.name, *(attribute.name for attribute in cls.attributes)] if cls is not None else [COLOR.name]
    return f'(call "{word}" {" ".join(f"[:{name}]" for name in dict.fromkeys(names))})'


def _check_attribute(inference: KindInference, word: str, attribute: Attribute, value: Any) -> None:
    """Check the kind and the range of an attribute's value."""
    kind = inference.result.kinds[value]
    if kind is ANY:
        types = (*attribute.accepts, "None")
        place = f'used as `:{attribute.name}` of "{word}"'
        inference.need(value, place, types, str(attribute.type), "attribute")
        if attribute.low is not None:
            low, high = attribute.low, attribute.high
            limits = "not negative" if high == math.inf else f"{low:g} to {high:g}"
            inference.need(value, place, (), limits, "out-of-range", fails=lambda number: not low <= number <= high)
    if type(value) is ast.ArrayLiteral and {"Triple", "Color"} & set(attribute.accepts):
        inference.need_numbers(value, f'a component of `:{attribute.name}` of "{word}"')
    if kind is ANY or kind is NEVER or any(option.tag == "None" for option in kind.options):
        return
    if not any(accepts(name, kind) for name in attribute.accepts):
        hint, fixes = _attribute_advice(attribute, value, kind)
        inference.report(
            "attribute",
            f'the attribute `:{attribute.name}` of "{word}" must be {attribute.type}, got {shown(value, kind)}',
            value.span, hint or attribute.doc, fixes=fixes, expected=attribute.type, found=describe(kind),
            signature=_usage_of(word),
        )  # fmt: skip
        return
    if type(value) is ast.Constant and type(value.value) is str and attribute.read is not None:
        try:
            attribute.read(word, attribute.name, value.value)
        except SceneError as error:
            inference.report(error.name, error.message, value.span, error.hint or attribute.doc,
                             expected=attribute.type, found=value.span.text, near=error.near)  # fmt: skip
            return
    _check_range(inference, word, attribute, value)


def _attribute_advice(attribute: Attribute, value: Any, kind: Kind) -> tuple[str | None, tuple[Fix, ...]]:
    """Return the hint and fix for an attribute of the wrong type."""
    for wants in attribute.accepts:
        hint, fixes = advice_on_value(value, wants)
        if hint is not None:
            return hint, fixes
    text = value.span.text
    is_literal = type(value) is ast.Constant and type(value.value) is str and value.span.expansion is None
    if attribute.name == "color" and is_literal:
        written = re.fullmatch(r'"rgba?\(\s*(\d+)\s*,\s*(\d+)\s*,\s*(\d+)[^)]*\)"', text)
        if written is not None:
            color = f"(rgb {' '.join(written.groups())})"
            return f"write `{color}`", (Fix(f"Write `{color}`", (Edit(value.span, color),), safe=True),)
        return f"convert the name: `(color {text})`", (wrap_fix(value, "color"),)
    if "Triple" in attribute.accepts and "Number" not in attribute.accepts and kind.tag in ("Integer", "Float"):
        return "write a point as `[x y z]`", ()
    if attribute.accepts == ("Number",) and kind.tag in ("Vector", "List"):
        return "it is one number", ()
    if "Triple" in attribute.accepts and kind.tag == "Vector":
        role = "place" if attribute.name in ("p0", "p1") else "color" if "Color" in attribute.accepts else "size"
        return triple_fix(value, role)
    return None, ()


def _check_range(inference: KindInference, word: str, attribute: Attribute, value: Any) -> None:
    """Warn about literal values that are outside the range of an attribute."""
    if attribute.low is None or value.span.expansion is not None:
        return
    if attribute.name == "color" and type(value) is not ast.ArrayLiteral:
        _check_named_color(inference, attribute, value)
    items = value.items if type(value) is ast.ArrayLiteral else (value,)
    numbers = [inference.number_of(item) for item in items]
    outside = [n for n in numbers if n is not None and (n < attribute.low or n > attribute.high)]
    if attribute.name == "color" and len(numbers) == 4 and not outside:
        message = f'the attribute `:color` of "{word}" has three components; the fourth is ignored'
        _, fixes = triple_fix(value)
        inference.warn("out-of-range", message, value.span, "transparency is the attribute `:opacity`", fixes,
                       expected="three numbers", found=value.span.text)  # fmt: skip
    if not outside:
        return
    hint = _range_hint(attribute, value, numbers)
    code = re.search(r"`(\(rgb [^`]*\)|[\d.]+)`\Z", hint or "")
    fixes = (Fix(f"Change to `{code[1]}`", (Edit(value.span, code[1]),)),) if code else ()
    text = value.span.text if type(value) is not ast.Reference else f"{value.span.text}, which is {outside[0]:g}"
    limits = "not be negative" if attribute.high == math.inf else f"be {attribute.low:g} to {attribute.high:g}"
    inference.warn(
        "out-of-range", f'the attribute `:{attribute.name}` of "{word}" should {limits}, got {text}',
        value.span, hint, fixes, expected=limits.removeprefix("not be ").removeprefix("be "), found=value.span.text,
    )  # fmt: skip


def _check_named_color(inference: KindInference, attribute: Attribute, value: Any) -> None:
    """Warn about a color that another place of the program defines, with components up to 255 instead of 1."""
    array = inference.array_of(value)
    numbers = [inference.number_of(item) for item in array.items] if array is not None else []
    known = [number for number in numbers if number is not None]
    if array is None or len(known) != len(numbers) or max(known, default=0) <= 1 or array.span.expansion is not None:
        return
    hint = _range_hint(attribute, array, numbers)
    code = re.search(r"`(\(rgb [^`]*\))`\Z", hint or "")
    fixes = (Fix(f"Change to `{code[1]}`", (Edit(array.span, code[1]),)),) if code else ()
    message = f"`{value.span.text}` is a color, whose components should be 0 to 1, got {array.span.text}"
    inference.warn("out-of-range", message, array.span, hint, fixes, expected="0 to 1", found=array.span.text)


def _range_hint(attribute: Attribute, value: Any, numbers: Sequence[float | None]) -> str | None:
    """Return the hint for a value out of range: components up to 255, percent, or the attribute's documentation."""
    known = [number for number in numbers if number is not None]
    if attribute.name == "color" and len(known) == len(numbers) == 3 and max(known) <= 255 and min(known) >= 0:
        return f"components from 0 to 255 are converted by `rgb`: `(rgb {' '.join(i.span.text for i in value.items)})`"
    if attribute.high == 1.0 and len(known) == 1 and 1.0 < known[0] <= 100.0:
        return f"a share of 1, not percent: write `{known[0] / 100:g}`"
    return attribute.doc


# --- transform and parts ---------------------------------------------------------------------------------------------


def transform(inference: KindInference, node: ast.Transform, part: Kind, matrix: Kind) -> Kind:
    """Check ``(transform part matrix)``."""
    is_part, is_pose = may_be_parts(part), accepts("Matrix", matrix)
    is_swapped = not is_part and accepts("Matrix", part) and may_be_parts(matrix)
    if part is ANY:
        inference.need(node.part, "placed by `transform`", ("Parts",), "an entity", "parts")
    if matrix is ANY and not is_swapped:
        inference.need(node.matrix, "used as a pose", ("Matrix",), "a pose", "pose")
    if not (is_part and is_pose):
        if is_swapped:
            hint, fixes = swap_fix(node, node.part, node.matrix)
            usage = "(transform part matrix)"
            inference.report(
                "pose", f"`transform` expects the part first and the pose second, got {describe(part)} first",
                node.part.span if fixes else node.span, hint if fixes else f"{hint}: write `{usage}`", fixes=fixes,
                expected="an Entity", found=describe(part), signature=usage,
            )  # fmt: skip
        elif not is_part:
            report_parts(inference, node.part, part, "`transform`")
        else:
            _report_pose(inference, node, matrix)
        return PART
    if type(node.matrix) is ast.ArrayLiteral and not _is_square(node.matrix):
        _report_pose(inference, node, matrix)
    elif _is_other_size(inference, node.matrix) or _is_no_pose(inference, node.matrix):
        _report_pose(inference, node, ARRAYS)
    if part is ENTITY or part is PART:
        return PART
    return PARTS if part.tag == "List" else join(PART, LIST)


def _is_other_size(inference: KindInference, node: Any) -> bool:
    """Return whether an expression is a unit matrix that is not 4x4."""
    if called_builtin(node) not in ("eye", "identity-matrix") or not node.arguments:
        return False
    return inference.number_of(node.arguments[0]) not in (None, 4)


def _is_no_pose(inference: KindInference, node: Any) -> bool:
    """Return whether an expression is a sum or multiple of poses, whose last row is not 0 0 0 1."""
    name = called_builtin(node)
    if name not in ("+", "-", "*", "/"):
        return False
    kinds = [inference.result.kinds[operand] for operand in node.arguments]
    poses = sum(kind is MATRIX for kind in kinds)
    if name in ("+", "-"):
        return poses == len(kinds) > 1
    factors = [
        inference.number_of(operand) for operand in node.arguments if inference.result.kinds[operand] is not MATRIX
    ]
    return poses == 1 and len(factors) == 1 and factors[0] not in (None, 1)


def _is_square(array: ast.ArrayLiteral) -> bool:
    """Return whether an array of arrays may have four rows of four items."""
    lengths = [len(row.items) for row in array.items if type(row) is ast.ArrayLiteral]
    return len(lengths) < len(array.items) or set(lengths) == {4} == {len(array.items)}


def _report_pose(inference: KindInference, node: ast.Transform, kind: Kind) -> None:
    """Report a value that is not a pose."""
    value = node.matrix
    hint, fixes = "a vector becomes a pose with `(translate [x y z])`", ()
    quoted = advice_on_value(value, "Vector")
    if type(value) is ast.ArrayLiteral and any(type(row) is ast.ArrayLiteral for row in value.items):
        hint = "a pose has four rows of four numbers, the last of which is [0 0 0 1]"
    if _is_no_pose(inference, value):
        hint = "poses are composed by `@`: `(@ last first)`, the first applies first; `(scale n)` is a pose"
        head = value.function.span  # type: ignore[union-attr]
        if head.expansion is None and head.text == "+":
            fixes = (Fix("Write `@`", (Edit(head, "@"),), safe=True),)  # type: ignore[assignment]
    elif kind.tag in ("Vector", "List") and value.span.expansion is None and (length_of(kind) in (3, None)):
        fixes = (wrap_fix(value, "translate"),)  # type: ignore[assignment]
    elif kind.tag == "Function":
        hint = "call the function to get its pose"
    if quoted[0] is not None:
        hint, fixes = quoted[0].replace("write `", "write `(translate ").removesuffix("`") + ")`", ()
    inference.report(
        "pose", f"a pose must be a 4x4 matrix whose last row is 0 0 0 1, got {shown(value, kind)}", value.span, hint,
        fixes=fixes, expected="a Matrix", found=describe(kind),
    )  # fmt: skip


def are_no_parts(kind: Kind) -> bool:
    """Return whether a value is a list of unknown length whose items, if it has any, cannot be parts."""
    item = item_of(kind) if kind.tag == "List" and kind.items is None else ANY
    return item is not ANY and item is not NEVER and not may_be_parts(item)


def report_missing_branch(inference: KindInference, node: Any, kind: Kind, place: str) -> None:
    """Warn about an ``if`` without a second branch whose value is used as a part.

    Parameters
    ----------
    node, kind
        Expression, and its kind.
    place
        Form that expects parts, for the message.
    """
    missing = _if_without_branch(node)
    if missing is None or kind is ANY or not any(option.tag == "None" for option in kind.options):
        return
    text = missing.span.text
    head = re.match(r"\((if|when|unless)\b", text)
    if head is None or missing.span.expansion is not None:
        return  # the clauses of `cond` and `case` may cover all values
    name = head[1]
    message = f"{place} gets `none` where this `{name}` has no branch, which is neither an entity nor parts"
    hint = "nothing at all is `(union)`: `(if test entity (union))`"
    fixes: tuple[Fix, ...] = ()
    if name == "if" and missing.otherwise is None:
        end = missing.span.end - 1
        edit = Edit(Span(missing.span.source, end, end), " (union)")
        fixes = (Fix("Add a branch", (edit,), safe=True),)
    inference.report(
        "parts", message, missing.span, hint, fixes=fixes, always=False,
        expected=A_PART, found="`none`",
    )  # fmt: skip


def _if_without_branch(node: Any) -> Any:
    """Return the conditional without a branch that determines the value of an expression, or None."""
    pending = [node]
    while pending:
        node = pending.pop()
        if type(node) is ast.Body and node.items:
            pending.append(node.items[-1])
        elif type(node) is ast.If:
            ends = (node.then, node.otherwise)
            if any(end is None or (type(end) is ast.Constant and end.value is None) for end in ends):
                return node
            pending += ends
    return None


def report_parts(inference: KindInference, node: Any, kind: Kind, place: str, always: bool = True) -> None:
    """Report a value that is neither an entity nor a list of parts.

    Parameters
    ----------
    node, kind
        Expression, and its kind.
    place
        Form that expects parts, at the start of the message.
    always
        Whether every value of the kind is wrong; otherwise only the items of some lists are, and the report is a
        conditional failure.
    """
    hint = None
    fixes: tuple[Fix, ...] = ()
    culprit = _not_a_part(kind) if always else item_of(kind)
    text = node.span.text
    is_written = node.span.expansion is None and len(text) <= MAX_SHOWN
    if culprit.tag == "None":
        hint = (
            "`for` only runs its body and has no value: use `for/union`"
            if type(node) is ast.For
            else "nothing at all is `(union)`"
        )
        last = node.items[-1] if type(node) is ast.Body and node.items else node
        if type(last) is ast.Define:
            hint = "the last form of a body is its value, and this one ends with a definition"
        if type(node) is ast.For and node.span.expansion is None and text.startswith("(for "):
            start = node.span.start + 1
            fixes = (Fix("Use `for/union`", (Edit(Span(node.span.source, start, start + 3), "for/union"),), safe=True),)
    elif culprit.tag == "Boolean":
        hint = "nothing at all is `(union)`"
    elif culprit.tag == "Matrix":
        hint = "a pose belongs to an entity: `(transform entity matrix)`"
    elif culprit.tag == "String" and is_written:
        hint = f"a word is called: `(call {text})`"
        fixes = (wrap_fix(node, "call"),) if type(node) is ast.Constant else ()
    elif culprit.tag == "Function":
        hint = f"call the function: `({text})`" if is_written else "call the function"
        if is_written and type(node) is ast.Reference and isinstance(kind.code, ast.Lambda):
            fixes = (Fix("Call the function", (Edit(node.span, f"({text})"),), safe=_takes_nothing(kind)),)
    elif is_profile(node):
        hint = profile_hint(place.strip("`"), node)
    elif culprit.tag == "Embedding":
        hint = 'an embedding belongs to a call: `(call "word" embedding)`'
    elif culprit.tag == "Pair" and culprit.items is not None and may_be_parts(culprit.items[1]):
        hint = "the entity comes first: `(cons entity matrix)`"
        if type(node) is ast.Application and len(node.arguments) == 2:
            fixes = swap_fix(node, *node.arguments)[1]
    elif culprit.tag == "Frames":
        hint = "a video is `frames` around the whole: `(frames (for/list (...) (union still moving)))`"
    message = f"{place} expects entities or (entity . matrix) pairs, got {shown(node, culprit)}"
    dropped = _dropped_before(inference, node) if place.startswith('"') and always else None
    if place.startswith('"'):
        message = f"{place} must return an entity or several, got {shown(node, culprit)}"
    if dropped is not None:
        inference.result.findings.remove(dropped)
        assert dropped.span is not None
        entity = dropped.span.text
        hint = (
            f"the last value of a body counts: put {f'`{entity}`' if len(entity) <= MAX_SHOWN else 'the entity'} last"
        )
        fixes = ()
    inference.report(
        "parts", message, node.span, hint,
        fixes=fixes, always=always, expected=A_PART, found=describe(culprit),
    )  # fmt: skip


def _dropped_before(inference: KindInference, node: Any) -> Diagnostic | None:
    """Return the warning about the entity right before an expression in its body, if it is the only one."""
    around = inference.nodes[-1].span
    dropped = [
        d
        for d in inference.result.findings
        if d.name == "dropped-value" and d.span is not None and d.span.source is around.source
        and around.start <= d.span.start and d.span.end <= node.span.start
    ]  # fmt: skip
    if len(dropped) != 1 or dropped[0].span is None:
        return None
    between = around.source.text[dropped[0].span.end : node.span.start]
    return dropped[0] if not between.strip() else None


def _takes_nothing(kind: Kind) -> bool:
    """Return whether a function can be called without arguments."""
    low, _, _, _ = arity_of(kind.code)
    return low == 0


def _not_a_part(kind: Kind) -> Kind:
    """Return the kind of the first item of a list that cannot be a part; otherwise the kind itself."""
    while kind.tag == "List":
        items = kind.items if kind.items is not None else (item_of(kind),)
        inner = next((item for item in items if not may_be_parts(item)), None)
        if inner is None:
            return kind
        kind = inner
    return kind


def report_dropped(inference: KindInference, node: Any, kind: Kind) -> None:
    """Warn about an entity that is created in a body and not used."""
    if type(node) is ast.For and node.kind == "each" and node.span.expansion is None:
        value = inference.result.kinds.get(node.body, ANY)
        if value is ENTITY or value is PART or _is_parts(value):
            inference.warn(
                "dropped-value", "the entities that this loop creates are not used", node.span,
                "collect them with `for/union`",
            )  # fmt: skip
        return
    if kind is not ENTITY and kind is not PART and not _is_parts(kind):
        report_unused_result(inference, node)
        return
    if node.span.expansion is None:
        inference.warn(
            "dropped-value", "this entity is not used: only the last value of a body counts", node.span,
            "put all parts into one `(union ...)`",
        )  # fmt: skip


# Pure functions, whose call has no effect if its value is not used, with the mutating function that is probably meant.
_PURE = {
    "append": "extend!", "cons": "push!", "reverse": "reverse!", "sort": "sort!", "shuffle": "shuffle!",
    "delete": "remove!", "string-append": "", "list": "", "vector": "", "translate": "", "rotate": "", "scale": "",
    "reflect": "", "+": "", "-": "", "*": "", "/": "", "@": "", "color": "", "rgb": "", "hsv": "", "set": "add!",
}  # fmt: skip


def report_unused_result(inference: KindInference, node: Any) -> None:
    """Warn about a call in the middle of a body that has no effect."""
    name = called_builtin(node)
    if name not in _PURE or node.span.expansion is not None:
        return
    changing = _PURE[name]
    hint = f"`{name}` returns a new value and changes nothing"
    if name == "set" and len(node.arguments) == 2 and type(node.arguments[0]) is ast.Reference:
        changing, hint = "", f"a variable is changed by `(set! {node.arguments[0].span.text} ...)`"
    if changing:
        hint += f"; a mutable list is changed by `{changing}`, a variable by `set!`"
        if name in ("append", "cons", "list"):
            hint += ", and a loop collects by `for/union` or `for/list`"
    elif name in ("translate", "rotate", "scale", "reflect"):
        hint = "a pose is applied by `transform`: `(transform part pose)`"
    inference.warn("dropped-value", f"the value of `{name}` is not used", node.span, hint)


def _is_parts(kind: Kind) -> bool:
    """Return whether a value is certainly a list of parts."""
    return kind.tag == "List" and kind.item is PART


def _is_no_number(inference: KindInference, node: Any) -> bool:
    """Return whether an expression is certainly not a number."""
    kind = inference.result.kinds[node]
    return kind is not ANY and not any(option.tag in ("Integer", "Float") for option in kind.options)


def report_array_item(inference: KindInference, around: ast.ArrayLiteral, node: Any, kind: Kind) -> None:
    """Report an item of an array literal that is not a number.

    Parameters
    ----------
    around
        Array literal.
    node
        The item.
    kind
        Kind of the item.
    """
    hint = "all items of an array are numbers"
    fixes: tuple[Fix, ...] = ()
    text = node.span.text
    number, number_fixes = advice_on_value(node, "Number")
    if number is not None:
        hint, fixes = number, number_fixes
    elif is_keyword(node) and node.span.expansion is None:
        hint = f"write the variable without a colon: `{node.value}`"
        fixes = (Fix("Remove the colon", (Edit(node.span, str(node.value)),), safe=True),)
    elif around.span.expansion is None and around.span.text.startswith("["):
        written = f"(list {around.span.text[1:-1]})"
        if all(_is_no_number(inference, item) for item in around.items):
            hint = f"write `{written}`, a list of other values" if len(written) <= _MAX_CALL else "use `(list ...)`"
            fixes = (Fix("Write a list", (Edit(around.span, written),), safe=True),)
        elif kind.tag == "String" and type(node) is ast.Reference:
            hint = f"all items of an array are numbers, and the value of `{text}` is in quotes"
    inference.report(
        "type", f"expected a number in an array, got {shown(node, kind)}", node.span, hint, fixes=fixes,
        expected="a number", found=describe(kind),
    )  # fmt: skip


def check_rows(inference: KindInference, node: ast.ArrayLiteral, kinds: Sequence[Kind]) -> bool:
    """Report an array whose items certainly have different shapes: a vector among numbers, or rows of two lengths."""
    lengths = [_row_length(kind) for kind in kinds]
    numbers = [kind.tag in ("Integer", "Float") for kind in kinds]
    known = {length for length in lengths if length is not None}
    is_mixed = bool(known) and any(numbers)
    if not is_mixed and len(known) < 2:
        return True
    culprit = next(i for i, length in enumerate(lengths) if length is not None and (is_mixed or length != lengths[0]))
    item, kind = node.items[culprit], kinds[culprit]
    value = shown(item, kind)
    if not is_mixed:
        message, hint = f"the rows of an array must have the same length, got {value}", None
    else:
        message, hint = f"expected a number in an array of numbers, got {value}", None
        if known == {3}:
            text = item.span.text if item.span.expansion is None and len(item.span.text) <= MAX_SHOWN else "v"
            hint = f"one of its components is `({'xyz'[culprit] if culprit < len('xyz') else 'y'}-of {text})`"
    inference.report("value", message, item.span, hint, expected="a number" if is_mixed else "rows of one length",
                     found=describe(kind))  # fmt: skip
    return False


def _row_length(kind: Kind) -> int | None:
    """Return the length of a row of an array, or None for a number or an unknown length."""
    return length_of(kind) if kind.tag in ("Vector", "List") else None


def check_collected(inference: KindInference, loop: str, node: Any, kind: Kind) -> bool:
    """Return whether a ``for`` loop can collect the value of its body; report it otherwise.

    Parameters
    ----------
    loop
        What the loop does: "append", "sum" or "table"; others can collect any value.
    node, kind
        Body, and the kind of its value.
    """
    name, value = f"`for/{loop}`", shown(node, kind)
    if loop == "append" and not accepts("List", kind):
        error, expected, hint = "type", "a List", "use `for/list` to collect single values"
    elif loop == "sum" and not accepts("Numeric", kind):
        error, expected, hint = "type", "a number or an array", ""
        if may_be_parts(kind):
            hint = "use `for/union` to collect entities"
    elif loop == "table" and not _may_be_row(kind):
        error, expected, hint = "value", "`(list key value)`", ""
    else:
        return True
    message = f"{name} expects {expected} from its body, got {value}"
    inference.report(error, message, node.span, hint or None, expected=expected, found=describe(kind))
    return False


def _may_be_row(kind: Kind) -> bool:
    """Return whether a value may be a list of a key and its value."""
    if kind is ANY or kind is NEVER:
        return True
    return any(option.tag in ("List", "Pair", "Part") and length_of(option) in (None, 2) for option in kind.options)


def report_bound_value(inference: KindInference, node: ast.Bind, kind: Kind) -> None:
    """Report ``bind`` of something other than a function."""
    word = f'"{node.word.value}"' if type(node.word) is ast.Constant else "the word"
    value = node.function
    fixes: tuple[Fix, ...] = ()
    hint = "write an entity function as `(lambda (z gamma) ...)` or `(lambda () ...)`"
    if may_be_parts(kind) and value.span.expansion is None:
        hint = "wrap it in a function: `(lambda () ...)`"
        fixes = (Fix("Wrap it in a function", (Edit(value.span, f"(lambda () {value.span.text})"),), safe=True),)
    inference.report(
        "type", f"`bind` expects a function for {word}, got {describe(kind)}", value.span, hint, fixes=fixes,
        expected="a Function", found=describe(kind),
    )  # fmt: skip


def report_swapped_loop(inference: KindInference, node: ast.UnionLoop) -> None:
    """Report a ``union-loop`` whose count and function are swapped, or whose body comes first."""
    hint, fixes = swap_fix(node, node.count, node.function)
    usage = "(union-loop count function)"
    if inference.result.kinds[node.count].tag != "Function" and fixes:
        body = node.count.span.text
        edits = (Edit(node.count.span, node.function.span.text), Edit(node.function.span, f"(lambda (i) {body})"))
        fixes = (Fix("Write the count and a function", edits, safe=True),)
        written = f"(union-loop {brief(node.function.span.text)} (lambda (i) {brief(body)}))"
        hint = f"the arguments are in the wrong order: write `{written}`"
    inference.report(
        "type", "`union-loop` expects the count first and the function second", node.span,
        hint if "`" in hint else f"{hint}: `{usage}`", fixes=fixes, expected="an Integer", found="a Function",
        signature=usage,
    )  # fmt: skip


def report_loop_body(inference: KindInference, node: ast.UnionLoop, kind: Kind) -> None:
    """Report a body of ``union-loop`` that is not a function."""
    body, described = node.function, describe(kind)
    fixes: tuple[Fix, ...] = ()
    if body.span.expansion is None:
        edit = Edit(body.span, f"(lambda (i) {body.span.text})")
        fixes = (Fix("Write a function", (edit,), safe=may_be_parts(kind)),)
    inference.report(
        "not-a-procedure", f"`union-loop` expects a function of the index, got {described}", body.span,
        "write `(lambda (i) ...)` around the body", fixes=fixes, expected="a Function", found=described,
    )  # fmt: skip


def _hint_of_count(kind: Kind) -> str:
    """Return the hint for a count of ``union-loop`` that is not an Integer."""
    if kind.tag == "String":
        return "write the number without quotes"
    if kind.tag in ("List", "Vector", "MutableList"):
        return "`for/union` goes through a list: `(for/union ((x list)) ...)`"
    return "round it: `(round n)`, `(floor n)`"


def _fix_of_count(node: Any) -> tuple[Fix, ...]:
    """Return the fix for ``(iota n)`` or ``(range n)`` in place of the count."""
    if called_builtin(node) not in ("iota", "range") or len(node.arguments) != 1 or node.span.expansion is not None:
        return ()
    text = node.arguments[0].span.text
    return (Fix(f"Change to `{text}`", (Edit(node.span, text),), safe=True),)


def report_count(inference: KindInference, node: Any, kind: Kind) -> None:
    """Report a count of ``union-loop`` that is not an Integer."""
    fixes = _fix_of_count(node)
    hint = f"write the number itself: `{fixes[0].edits[0].text}`" if fixes else _hint_of_count(kind)
    inference.report(
        "type", f"`union-loop` expects an Integer count, got {shown(node, kind)}", node.span, hint, fixes=fixes,
        expected="an Integer", found=describe(kind),
    )  # fmt: skip
