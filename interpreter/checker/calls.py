"""Checks of calls: arguments against the signatures of builtins, of the program's functions and of its words."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.datum import ListDatum, Source, Span, dataclass
from scenelang.grammar.diagnostics import Edit, Fix, near_names
from scenelang.grammar.reader import read
from scenelang.interpreter.checker.builtins import check_angle, check_values, need_of_argument, result_of
from scenelang.interpreter.checker.common import (
    A_PART,
    AXES,
    MAX_SHOWN,
    accepts,
    advice_on_value,
    arity_of,
    is_keyword,
    is_profile,
    literal_fits,
    may_be_parts,
    meant_keyword,
    missing_branch,
    name_of,
    number_of,
    plural,
    profile_hint,
    shown,
    swap_fix,
    turned,
    unquoted_number,
    wrap_fix,
)
from scenelang.interpreter.compile.kinds import ANY, ENTITY, INTEGER, NEVER, NONE, PART, Kind, describe, item_of
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.types import (
    STD,
    Builtin,
    BuiltinParameter,
    Type,
    call_hint,
    default_hint,
    expected_name,
)

if TYPE_CHECKING:
    from scenelang.interpreter.checker.infer import KindInference, RecordCode

_MAX_WRITTEN = 80  # characters of a call that a hint shows in full


def function_of(builtin: Builtin) -> Kind:
    """Return the kind of a builtin as a value."""
    return Kind("Function", None, None, builtin)


# --- calls -----------------------------------------------------------------------------------------------------------


def call(inference: KindInference, node: ast.Application, function: Kind, arguments: Sequence[Kind]) -> Kind:
    """Check a call, and return the kind of its result.

    Parameters
    ----------
    node
        The call.
    function
        Kind of its head.
    arguments
        Kinds of its arguments.
    """
    if function is ANY or function is NEVER:
        return ANY
    if not accepts("Function", function):
        return report_not_a_function(inference, node, function, arguments)
    if function.tag != "Function":
        return ANY
    code = function.code
    if isinstance(code, Builtin):
        return call_builtin(inference, node, code, arguments)
    if isinstance(code, ast.Lambda):
        return _call_lambda(inference, node, code, arguments, function)
    if code is not None and not isinstance(code, str):
        return _call_record(inference, node, code, arguments, function)
    return function.item if function.item is not None else ANY


def report_not_a_function(
    inference: KindInference, node: ast.Application, function: Kind, arguments: Sequence[Kind]
) -> Kind:
    """Report a call whose head is not a function.

    The hint is the form that is probably meant: an array, ``ref``, ``call``, ``union``, or no call.

    Parameters
    ----------
    node
        The call.
    function
        Kind of its head.
    arguments
        Kinds of its arguments.

    Returns
    -------
    Kind
        ANY, as the kind of the call.
    """
    head = node.function
    described = describe(function)
    text = head.span.text
    hint = 'write a list of values as `(list ...)`, a call of a word as `(call "word" ...)`'
    fixes: tuple[Fix, ...] = ()
    is_written = head.span.expansion is None and node.span.expansion is None
    if is_written and node.arguments and _are_numbers(node):
        array = "[" + node.span.text[1:-1].strip() + "]"
        hint = f"an array is written in square brackets: `{array}`"
        fixes = (Fix("Write an array", (Edit(node.span, array),), safe=True),)
    elif is_written and _may_be_numbers(node, (function, *arguments)):
        array = "[" + node.span.text[1:-1].strip() + "]"
        hint = "an array is written in square brackets" + (f": `{array}`" if len(array) <= MAX_SHOWN else "")
        fixes = (Fix("Write an array", (Edit(node.span, array),)),)
    elif function.tag in ("Vector", "List", "Array", "Matrix", "MutableList", "Table") and len(arguments) == 1:
        if is_written and type(head) is ast.Reference:
            written = f"(ref {text} {node.arguments[0].span.text})"
            hint = f"write `{written}`" if len(written) <= MAX_SHOWN else "use `ref` to read an item"
            fixes = (Fix(f"Write `{written[:MAX_SHOWN]}`", (Edit(node.span, written),), safe=True),)
        else:
            hint = "use `ref` to read an item: `(ref sequence index)`"
    elif function.tag == "Keyword" and len(arguments) == 1:
        name, owner = text.removeprefix(":"), node.arguments[0].span.text
        kind = arguments[0]
        if kind.tag == "Record" and kind.code and is_written:
            hint = f"a field is read by its function: `({kind.code}-{name} {owner})`"
            edit = Edit(node.span, f"({kind.code}-{name} {owner})")
            fixes = (Fix("Call its function", (edit,), safe=True),)
        else:
            hint = f"a field is read by its function, such as `(leg-{name} x)`, an item of a table by `(ref x key)`"
    elif type(head) is ast.Constant and function.tag == "String" and is_written:
        hint = f"call a word with `call`: `(call {text} ...)`"
        fixes = (
            Fix("Call the word", (Edit(Span(head.span.source, head.span.start, head.span.start), "call "),), safe=True),
        )
    elif type(head) is ast.Reference and isinstance(head.target, Variable) and head.target.shadows:
        name, place = head.target.name, head.target.span
        line = f" in line {place.source.position(place.start)[0]}" if place is not None else ""
        hint = f"`{name}` is defined{line} and hides the function: write `std/{name}`, or give yours another name"
    elif function is ENTITY and is_written and type(head) is ast.Call:
        at = Span(head.span.source, head.span.start, head.span.start)
        hint = "several parts are put together by `union`"
        fixes = (Fix("Write `union`", (Edit(at, "union "),), safe=True),)
    elif (
        not node.arguments
        and is_written
        and type(head)
        in (
            ast.Constant,
            ast.Reference,
            ast.Application,
            ast.Call,
        )
    ):
        hint = f"remove the parentheses: `{text}`" if len(text) <= MAX_SHOWN else "remove the parentheses"
        fixes = (Fix("Remove the parentheses", (Edit(node.span, text),), safe=True),)
    return inference.report(
        "not-a-procedure", f"expected a function to call, got {shown(head, function)}", node.span, hint, fixes=fixes,
        expected="a Function", found=described,
    )  # fmt: skip


def _are_numbers(node: ast.Application) -> bool:
    """Return whether parentheses hold numbers only; ``#(1 2)`` has its own explanation."""
    before = node.span.source.text[node.span.start - 1 : node.span.start]
    return before != "#" and all(number_of(part) is not None for part in (node.function, *node.arguments))


def _may_be_numbers(node: ast.Application, kinds: Sequence[Kind]) -> bool:
    """Return whether parentheses contain three values that may all be numbers, as a point has."""
    return len(kinds) == len(AXES) and all(
        kind is ANY or any(option.tag in ("Integer", "Float") for option in kind.options) for kind in kinds
    )


def split(inference: KindInference, node: Any, arguments: Sequence[Any], name: str, usage: str) -> Any:
    """Split the argument nodes of a call into positional and keyword arguments.

    Parameters
    ----------
    node
        The call.
    arguments
        Its arguments, whose kinds are known.
    name
        Name of the called function in messages.
    usage
        Parameter list for the hint, "" if it is not known.

    Returns
    -------
    tuple of (list, list), or None
        Nodes of positional arguments, and rows ``(name, keyword node, value node)``. None after a report, or if a
        computed argument may be a keyword.
    """
    positional: list[Any] = []
    keywords: list[tuple[str, Any, Any]] = []
    pending = iter(arguments)
    for argument in pending:
        kind = inference.result.kinds[argument]
        if is_keyword(argument):
            key = str(argument.value)
            value = next(pending, None)
            if value is None:
                hint = f"write a value behind it: `:{key} value`"
                inference.report("keyword", f"missing value after `:{key}` in a call of {name}", argument.span, hint)
                return None
            if any(key == known for known, _, _ in keywords):
                hint = "leave out one of them"
                inference.report("keyword", f"duplicate argument `:{key}` of {name}", argument.span, hint)
                return None
            keywords.append((key, argument, value))
        elif kind is ANY or any(option.tag == "Keyword" for option in kind.options):
            if kind is not ANY:
                return None
            positional.append(argument)
        else:
            positional.append(argument)
    return positional, keywords


def _may_hide_keywords(inference: KindInference, positional: Sequence[Any]) -> bool:
    """Return whether a positional argument of unknown kind may be a keyword, whose value would be the next argument."""
    return any(inference.result.kinds[node] is ANY and _may_be_keyword(node) for node in positional)


def _may_be_keyword(node: Any) -> bool:
    """Return whether an expression of unknown kind may be a keyword: only a variable may."""
    return type(node) is ast.Reference and isinstance(node.target, Variable)


def item_given(kind: Kind) -> Kind:
    """Return the kind of the items of a sequence that a library function passes to a callback; ANY if unknown."""
    item = item_of(kind) if kind.tag in ("List", "Vector", "String") else ANY
    return ANY if item is NEVER else item


# --- builtins --------------------------------------------------------------------------------------------------------


def call_builtin(inference: KindInference, node: ast.Application, builtin: Builtin, arguments: Sequence[Kind]) -> Kind:
    """Check a call of a builtin, and return the kind of its result.

    ``arguments`` are the kinds of the arguments of the call ``node``.
    """
    signature = builtin.signature
    nodes: Sequence[Any] = node.arguments
    keywords: Sequence[tuple[str, Any, Any]] = ()
    if signature.keywords:
        parts = split(inference, node, nodes, f"`{builtin.name}`", builtin.usage)
        if parts is None:
            return ANY
        nodes, keywords = parts
        if not _check_builtin_keywords(inference, builtin, keywords):
            return ANY
    parameters = signature.positional
    count = len(nodes)
    if not signature.takes(count):
        written = written_keyword(nodes)
        if written is not None and not signature.keywords:
            return inference.report(
                "arity", f"`{builtin.name}` takes its arguments by position, not as `{written.span.text}`",
                written.span, builtin.call_hint, fixes=_by_position(node, parameters),
                expected="positional arguments", found=written.span.text, signature=builtin.usage,
            )  # fmt: skip
        if signature.keywords and _may_hide_keywords(inference, nodes):
            return ANY
        return _report_arity(inference, node, builtin, nodes)
    kinds = [inference.result.kinds[argument] for argument in nodes]
    for index, (argument, kind) in enumerate(zip(nodes, kinds)):
        parameter = parameters[index] if index < len(parameters) else signature.rest
        assert parameter is not None
        if kind is ANY:
            need_of_argument(inference, builtin, index, parameter, argument)
        elif not _fits(parameter, argument, kind):
            return _report_type(inference, node, builtin, parameter, index, nodes)
        else:
            report_half(inference, argument, kind, parameter.type.name)
    if not check_values(inference, node, builtin, nodes, kinds, keywords):
        return ANY
    callback = _CALLBACKS.get(builtin.name)
    if callback is not None:
        callback(inference, node, builtin, nodes, kinds)
    return result_of(builtin, kinds, bool(signature.keywords and len(nodes) < len(node.arguments)))


def report_half(inference: KindInference, node: Any, kind: Kind, wants: str) -> None:
    """Report an ``if`` without a second branch where a value of the type ``wants`` is needed."""
    if kind is ANY or accepts(wants, NONE) or not any(option.tag == "None" for option in kind.options):
        return
    branch = missing_branch(node, wants)
    if branch is not None:
        half, message, hint, fixes = branch
        inference.report("conditional-failure", message, half.span, hint, fixes=fixes, always=False,
                         expected=expected_name(wants), found="`none`")  # fmt: skip


def _by_position(node: ast.Application, parameters: Sequence[BuiltinParameter]) -> tuple[Fix, ...]:
    """Return the fix for a call that names all arguments of a builtin, in the order of its parameters."""
    keys, values = node.arguments[::2], node.arguments[1::2]
    names = [str(key.value) if type(key) is ast.Constant else "" for key in keys]
    if node.span.expansion is not None or names != [p.name for p in parameters[: len(values)]]:
        return ()
    edits = tuple(Edit(Span(key.span.source, key.span.start, v.span.start), "") for key, v in zip(keys, values))
    return (Fix("Pass them by position", edits, safe=True),)


def _fits(parameter: BuiltinParameter, argument: Any, kind: Kind) -> bool:
    """Return whether an argument may have the type of a parameter.

    A literal Float may be an Integer only if it is whole.
    """
    name = parameter.type.name
    if name == "Integer" and type(argument) is ast.Constant and type(argument.value) is float:
        return argument.value.is_integer()
    return accepts(parameter.type, kind)


def _report_arity(inference: KindInference, node: ast.Application, builtin: Builtin, nodes: Sequence[Any]) -> Kind:
    """Report a wrong number of arguments of a builtin."""
    signature = builtin.signature
    required, most = len(signature.required), len(signature.required) + len(signature.optional)
    if signature.rest is not None:
        expected = f"at least {required}"
    else:
        expected = str(required) if required == most else f"{required} to {most}"
    count = len(nodes)
    noun = "argument" if expected.split()[-1] == "1" else "arguments"
    hint, fixes = _grouped(inference, node, builtin, nodes)
    if signature.rest is None and not fixes:
        fixes = _without_surplus(node, nodes, most)
    return inference.report(
        "arity", f"`{builtin.name}` expects {expected} {noun}, got {count}", node.span,
        hint or builtin.call_hint, fixes=fixes, expected=f"{expected} {noun}",
        found=plural(count, "argument"), signature=builtin.usage,
    )  # fmt: skip


def _without_surplus(node: ast.Application, nodes: Sequence[Any], most: int) -> tuple[Fix, ...]:
    """Return the fix that leaves out the arguments beyond the last one that a function takes."""
    if len(nodes) <= most or any(part.span.expansion is not None for part in (node, *nodes)):
        return ()
    start = nodes[most - 1].span.end if most else nodes[0].span.start
    surplus = Span(node.span.source, start, nodes[-1].span.end)
    return (Fix(f"Leave out `{surplus.text.strip()[:MAX_SHOWN]}`", (Edit(surplus, ""),)),)


def _looped(node: ast.Application, builtin: Builtin, nodes: Sequence[Any]) -> tuple[str, tuple[Fix, ...]]:
    """Return a hint and a fix for a count and a function in place of a list: ``(frames 24 (lambda (i) ...))``."""
    forms = read(Source("<function>", nodes[1].span.text)).forms
    items = forms[0].items if len(forms) == 1 and isinstance(forms[0], ListDatum) else ()
    if len(items) < 3 or not isinstance(items[1], ListDatum) or len(items[1].items) != 1 or node.span.expansion:
        return f"it takes one list, which a loop makes: `({builtin.name} (for/list ((i (range 24))) ...))`", ()
    body = nodes[1].span.text[items[2].span.start : items[-1].span.end]
    written = f"({builtin.name} (for/list (({items[1].items[0].span.text} {nodes[0].span.text})) {body}))"
    name, count = items[1].items[0].span.text, nodes[0].span.text
    shown_ = f"`{written}`" if len(written) <= MAX_SHOWN else f"`({builtin.name} (for/list (({name} {count})) ...))`"
    return f"it takes one list, which a loop makes: {shown_}", (Fix("Write a loop", (Edit(node.span, written),)),)


def _grouped(
    inference: KindInference, node: ast.Application, builtin: Builtin, nodes: Sequence[Any]
) -> tuple[str | None, tuple[Fix, ...]]:
    """Return a hint and a fix for numbers that belong into an array: ``(translate 1 2 3)``."""
    if builtin.name == "rotate" and len(nodes) == 1 and inference.result.kinds[nodes[0]].tag == "Vector":
        return turned(node, nodes[0])
    if builtin.name == "array" and len(nodes) > 1:
        return _listed(inference, node, nodes)
    tags = [inference.result.kinds[item].tag for item in nodes]
    if tags == ["Integer", "Function"] and [p.type.name for p in builtin.signature.required] == ["Sequence"]:
        return _looped(node, builtin, nodes)
    parameters = (*builtin.signature.required, *builtin.signature.optional)
    vectors = [i for i, parameter in enumerate(parameters) if parameter.type.name in ("Vector", "Point")]
    if builtin.name == "scale":
        vectors = [0]
    numeric = {"Integer", "Float"}
    for index in vectors:
        group = nodes[index : index + 3]
        rest = nodes[index + 3 :]
        if len(group) < 3 or index + 1 + len(rest) > len(parameters):
            continue
        kinds = [inference.result.kinds[item] for item in group]
        if any(kind is not ANY and numeric.isdisjoint(option.tag for option in kind.options) for kind in kinds):
            continue
        if any(item.span.expansion is not None for item in group):
            continue
        written = "[" + " ".join(item.span.text for item in group) + "]"
        span = Span(node.span.source, group[0].span.start, group[-1].span.end)
        before = " ".join(item.span.text for item in nodes[:index])
        text = f"({builtin.name} {before + ' ' if before else ''}{written}{' ...' if rest else ''})"
        return f"write `{text}`", (Fix("Write an array", (Edit(span, written),), safe=True),)
    return None, ()


def _listed(
    inference: KindInference, node: ast.Application, nodes: Sequence[Any]
) -> tuple[str | None, tuple[Fix, ...]]:
    """Return a hint and a fix for ``(array a b c)``: a vector of numbers, a list of anything else."""
    if node.span.expansion is not None:
        return None, ()
    kinds = [inference.result.kinds[item] for item in nodes]
    if all(kind.tag in ("Integer", "Float") for kind in kinds):
        written = "[" + " ".join(item.span.text for item in nodes) + "]"
        hint = f"write `{written}`" if len(written) <= MAX_SHOWN else "write an array in square brackets"
        return hint, (Fix("Write an array", (Edit(node.span, written),), safe=True),)
    head = node.function.span
    return "a list of values is `(list ...)`", (Fix("Write a list", (Edit(head, "list"),)),)


def _report_type(
    inference: KindInference,
    node: ast.Application,
    builtin: Builtin,
    parameter: BuiltinParameter,
    index: int,
    nodes: Sequence[Any],
) -> Kind:
    """Report the argument ``nodes[index]`` of a builtin, which has the wrong type."""
    expected = expected_name(parameter.type.name)
    kinds = [inference.result.kinds[argument] for argument in nodes]
    argument, kind = nodes[index], kinds[index]
    hint, fixes = _swapped(builtin, node, nodes, kinds)
    if hint is None:
        hint, fixes = _advice(inference, builtin, parameter, argument, kind, node)
    return inference.report(
        "type", f"`{builtin.name}` expects {expected} for `{parameter.name}`, got {shown(argument, kind)}", node.span,
        hint or builtin.call_hint, fixes=fixes, expected=expected, found=describe(kind),
        signature=builtin.usage,
    )  # fmt: skip


def _swapped(
    builtin: Builtin, node: Any, nodes: Sequence[Any], kinds: Sequence[Kind]
) -> tuple[str | None, tuple[Fix, ...]]:
    """Return a hint and a fix for two arguments in the wrong order."""
    parameters = (*builtin.signature.required, *builtin.signature.optional)
    for i in range(len(nodes)):
        for j in range(i + 1, min(len(nodes), len(parameters))):
            a, b = parameters[i], parameters[j]
            if a.type.name == b.type.name == "Any" or kinds[i] is ANY is kinds[j]:
                continue
            if ANY in (kinds[i], kinds[j]) and (kinds[i] is ANY or accepts(a.type, kinds[i])):
                continue  # an unknown argument is swapped only if the known one is wrong
            rest = all(
                accepts(parameters[k].type, kinds[k])
                for k in range(min(len(nodes), len(parameters)))
                if k not in (i, j)
            )
            is_wrong = not (accepts(a.type, kinds[i]) and accepts(b.type, kinds[j]))
            if rest and is_wrong and accepts(a.type, kinds[j]) and accepts(b.type, kinds[i]):
                return swap_fix(node, nodes[i], nodes[j])
    return None, ()


def _is_fraction(node: Any) -> bool:
    """Return whether an expression is a number that is not whole."""
    value = number_of(node)
    return value is not None and not float(value).is_integer()


def _as_iota(inference: KindInference, node: ast.Application) -> str:
    """Return the call of ``iota`` with the numbers of a call of ``range``, as far as they are known."""
    values = [inference.number_of(argument) for argument in node.arguments]
    if len(values) == 1 or None in values or values[-1] == 0:
        return "(iota count start step)"
    start, end, step = [*values, 1][:3]
    texts = [argument.span.text for argument in node.arguments]
    count = math.ceil(round((end - start) / step, 9))  # type: ignore[operator]
    return f"(iota {max(count, 0)} {texts[0]} {texts[2] if len(texts) > 2 else 1})"


def _advice(
    inference: KindInference, builtin: Builtin, parameter: BuiltinParameter, argument: Any, kind: Kind, node: Any
) -> tuple[str | None, tuple[Fix, ...]]:
    """Return a hint and a fix for one argument of the wrong kind."""
    name = parameter.type.name
    hint, fixes = advice_on_value(argument, name)
    if hint is not None:
        return hint, fixes
    if name in ("Parts", "Entity") and is_profile(argument):
        is_alone = not all(map(is_profile, node.arguments))
        return profile_hint("" if is_alone else builtin.name, argument), ()
    text = argument.span.text if argument.span.expansion is None else ""
    is_short = bool(text) and len(text) <= MAX_SHOWN and "\n" not in text
    if name == "Numeric" and kind.tag == "List":
        if builtin.name == "+" and all(inference.result.kinds[operand].tag == "List" for operand in node.arguments):
            return "lists are joined by `append`; `(array list)` makes an array, which is added item by item", ()
        if is_short:
            return f"arithmetic needs an array: `(array {text})`", (wrap_fix(argument, "array"),)
        return "arithmetic needs an array: `(vector a b)`, `(array list)`", ()
    if builtin.name == "vector-ref" and kind.tag == "List" and node.function.span.expansion is None:
        return "items of any sequence are read by `ref`", (Fix("Write `ref`", (Edit(node.function.span, "ref"),)),)
    if builtin.name == "repeat" and kind.tag == "Integer" and node.function.span.text == "repeat":
        if any(inference.result.kinds[operand].tag == "Function" for operand in node.arguments[1:]):
            fix = Fix("Write `union-loop`", (Edit(node.function.span, "union-loop"),))
            return "copies by the index of a loop are made by `(union-loop count function)`", (fix,)
    if builtin.name == "vector" and kind.tag not in ("Integer", "Float", "Vector", "Array", "List"):
        if node.function.span.expansion is None and node.function.span.text == "vector":
            fix = Fix("Write a list", (Edit(node.function.span, "list"),))
            return "a vector has numbers; a list of any values is `(list ...)`", (fix,)
    if name in ("Numeric", "Number", "Float", "Integer") and kind.tag == "String":
        hint, fixes = unquoted_number(argument)
        if hint is None and builtin.name == "+" and node.function.span.expansion is None:
            are_texts = all(inference.result.kinds[operand].tag == "String" for operand in node.arguments)
            join_ = "string-append" if are_texts else "string"
            head = Edit(node.function.span, join_)
            written = f"({join_} {' '.join(operand.span.text for operand in node.arguments)})"
            shown_ = f"`{written}`" if len(written) <= MAX_SHOWN else f"`{join_}`"
            return f"texts are joined by {shown_}", (Fix(f"Write `{join_}`", (head,), safe=True),)
        return hint, fixes
    if name == "String" and kind.tag in ("Integer", "Float"):
        fixes = (wrap_fix(argument, "string"),) if is_short else ()
        return "convert the number: `(string x)`", fixes
    if name in ("Vector", "Point") and kind.tag in ("Integer", "Float"):
        return "write a point as `[x y z]`", ()
    if builtin.name == "range" and kind.tag == "Float" and (parameter.name == "step" or _is_fraction(argument)):
        return f"`range` counts in whole numbers; others are `{_as_iota(inference, node)}`: count, start, step", ()
    if name == "Integer" and kind.tag == "Float":
        return "round it: `(round n)`, `(floor n)`", ()
    if name == "Function":
        fixes = ()
        if kind is ENTITY and is_short:
            fixes = (Fix("Write a function", (Edit(argument.span, f"(lambda (_) {text})"),), safe=True),)
        return "pass a function: `(lambda (x) ...)`", fixes
    if name == "Entity" and kind.tag == "String" and is_short:
        return f"call the word: `(call {text})`", (wrap_fix(argument, "call"),)
    takes_function = any(p.type.name == "Function" for p in builtin.signature.positional)
    if name == "Sequence" and kind is INTEGER and is_short and takes_function:
        return f"the numbers from 0 are `(iota {text})`", (wrap_fix(argument, "iota"),)
    if name == "Sequence" and kind is ENTITY:
        return _parts_hint(builtin.name, text if is_short else "entity"), ()
    if name == "Parts" and kind.tag == "String" and is_short:
        return f"call the word: `(call {text})`", (wrap_fix(argument, "call"),)
    return None, ()


def _parts_hint(function: str, text: str) -> str:
    """Return the hint for an entity in place of a sequence."""
    if function in ("x-of", "y-of", "z-of"):
        return f"its position is `({function} (compute-shape-center {text}))`"
    if function == "frames":
        return "one item for each frame: `(frames (for/list ((t 10)) ...))`"
    return f"the list of its parts is `(cdr {text})`"


def _check_builtin_keywords(
    inference: KindInference, builtin: Builtin, keywords: Sequence[tuple[str, Any, Any]]
) -> bool:
    """Check the names and types of keyword arguments of a builtin."""
    known = {parameter.name: parameter for parameter in builtin.signature.keywords}
    positional = [parameter.name for parameter in builtin.signature.positional]
    callee = Callee(f"`{builtin.name}`", known, builtin.usage, positional)
    is_valid = True
    for key, key_node, value in keywords:
        parameter = known.get(key)
        kind = inference.result.kinds[value]
        if parameter is not None and kind is ANY:
            place = f"passed to `{builtin.name}` as `:{key}`"
            inference.need(value, place, (parameter.type,), expected_name(parameter.type.name))
        elif parameter is None:
            report_unknown_keyword(inference, callee, key, key_node.span)
            is_valid = False
        elif not accepts(parameter.type, kind):
            expected = expected_name(parameter.type.name)
            inference.report(
                "type", f"`{builtin.name}` expects {expected} for `:{key}`, got {shown(value, kind)}", value.span,
                builtin.call_hint, expected=expected, found=describe(kind), signature=builtin.usage,
            )  # fmt: skip
            is_valid = False
    return is_valid


@dataclass(frozen=True, slots=True)
class Callee:
    """Function of a call whose keyword arguments are checked.

    Attributes
    ----------
    owner
        The function, for error messages.
    keywords
        Names of the keyword parameters.
    usage
        Its parameter list, or a call of it.
    positional
        Names of the parameters that are given by their places.
    what
        The word for a keyword argument in messages.
    """

    owner: str
    keywords: Collection[str]
    usage: str
    positional: Sequence[str] = ()
    what: str = "parameter"


def report_unknown_keyword(inference: KindInference, callee: Callee, key: str, span: Span) -> None:
    """Report a keyword argument ``key`` at ``span`` that a function does not have, with the name that is meant."""
    known = callee.keywords
    message = f"{callee.owner} has no {callee.what} `:{key}`"
    name, sign, value = key.partition("=")
    if sign and name in known:
        hint = f"write `:{name} {value or '...'}`: a value follows its keyword"
        fix = Fix("Leave out the `=`", (Edit(span, f":{name} {value}"),), safe=True)
        inference.report("keyword", message, span, hint, fixes=(fix,), found=f":{key}", signature=callee.usage)
        return
    near = near_names(key, known) or _abbreviated(key, known) or _meant_by_other_tools(key, known)
    if not near and key in callee.positional:
        call = " ".join([callee.owner.strip("`"), *callee.positional])
        hint = f"`{key}` is given by its place, without a name: `({call})`"
        inference.report("keyword", message, span, hint, found=f":{key}", signature=callee.usage)
        return
    fixes = tuple(Fix(f"Change to `:{other}`", (Edit(span, f":{other}"),), safe=len(near) == 1) for other in near)
    hint = f"did you mean {' or '.join(f'`:{other}`' for other in near)}?" if near else _known_keywords(known)
    inference.report(
        "keyword", message, span, hint, fixes=fixes, expected=", ".join(f":{name}" for name in known) or "no keyword",
        found=f":{key}", signature=callee.usage, near=[f":{other}" for other in near],
    )  # fmt: skip


# Keywords of three.js, Blender, Unity and others; those of a row mean the same.
_SAME_KEYWORDS = (
    ("position", "location", "pos", "from", "origin", "eye", "at"),
    ("target", "look-at", "lookat", "to", "center", "aim"),
    ("intensity", "energy", "brightness", "watts", "power"),
    ("size", "scale", "dimensions", "dims"),
    ("metalness", "metallic"), ("transparency", "alpha", "opacity"), ("emissive", "emission", "glow"),
    ("rotation", "turn"), ("sides", "segments", "resolution", "fn"),
)  # fmt: skip


def _meant_by_other_tools(key: str, known: Any) -> list[str]:
    """Return the keyword that means what ``key`` does in other tools, if a function has just one."""
    same = [name for row in _SAME_KEYWORDS if key.lower() in row for name in row if name in known]
    return same if len(same) == 1 else []


_MAX_LISTED = 8  # names in a hint


def _known_keywords(known: Any) -> str:
    """Return the hint that lists the keyword arguments that a function has."""
    names = [f"`:{name}`" for name in known]
    if not names:
        return "it has no keyword arguments: values are passed by position"
    return f"it has {', '.join(names[:_MAX_LISTED])}{' and others' if len(names) > _MAX_LISTED else ''}"


def _abbreviated(key: str, known: Any) -> list[str]:
    """Return the names that ``key`` abbreviates, or that abbreviate it: ``:h`` for ``:height``."""
    return [name for name in known if name.startswith(key) or (len(name) > 1 and key.startswith(name))][:2]


# --- functions that are passed to builtins ---------------------------------------------------------------------------


def check_callback(
    inference: KindInference, node: Any, function: Kind, arguments: Sequence[Kind], caller: str, runs: bool
) -> None:
    """Check that a function accepts the arguments of a callback.

    Parameters
    ----------
    node, function
        Expression that is passed as the callback, and its kind.
    arguments
        Kinds of the arguments with which it is called.
    caller
        Name of the calling function in messages.
    runs
        Whether the callback is certainly called; otherwise, a mistake is reported as a conditional failure.
    """
    if function.tag != "Function":
        return
    code, count = function.code, len(arguments)
    low, high, name, usage = arity_of(code)
    if low is None:
        return
    if low <= count <= high:
        if isinstance(code, Builtin):
            _check_callback_types(inference, node, code, arguments, caller, runs=runs)
        return
    expected = (
        f"{'at least ' if high == math.inf else ''}{low if low == high or high == math.inf else f'{low} to {high}'}"
    )
    fixes: tuple[Fix, ...] = ()
    hint = call_hint(name, usage)
    head = re.match(r"\(lambda\s+\(\)", node.span.text) if node.span.expansion is None else None
    if head is not None and count == 1:
        at = Span(node.span.source, node.span.start + head.end() - 1, node.span.start + head.end() - 1)
        fixes = (Fix("Add a parameter", (Edit(at, "_"),), safe=True),)
        hint = "add a parameter: `(lambda (i) ...)`"
    inference.report(
        "arity", f"{caller} calls {name} with {plural(count, 'argument')}, but it expects {expected}", node.span,
        hint, fixes=fixes, always=runs, expected=f"a Function of {plural(count, 'argument')}",
        found=f"a Function of {expected}", signature=usage,
    )  # fmt: skip


def takes(parameter: ast.Parameter, kind: Kind) -> bool:
    """Return whether a parameter may accept a value."""
    return parameter.type is None or accepts(parameter.type, kind)


def _check_callback_types(
    inference: KindInference, node: Any, code: Builtin, arguments: Sequence[Kind], caller: str, *, runs: bool
) -> None:
    """Check the types of the arguments with which a function calls a builtin that is passed to it.

    Parameters
    ----------
    node
        Expression that is passed, for the location.
    code
        The builtin.
    arguments
        Kinds of the arguments.
    caller
        Name of the calling function in messages.
    runs
        Whether the builtin is certainly called; otherwise, a mistake is reported as a conditional failure.
    """
    signature = code.signature
    parameters = signature.positional
    for index, kind in enumerate(arguments):
        parameter = parameters[index] if index < len(parameters) else signature.rest
        if parameter is None or accepts(parameter.type, kind):
            continue
        expected = expected_name(parameter.type.name)
        described = describe(kind)
        inference.report(
            "type",
            f"{caller} calls `{code.name}`, which expects {expected} for `{parameter.name}`, got {described}",
            node.span,
            code.call_hint,
            always=runs,
            expected=expected,
            found=described,
            signature=code.usage,
        )
        return


def _mapped(inference: KindInference, node: Any, builtin: Builtin, nodes: Sequence[Any], kinds: Sequence[Kind]) -> None:
    """Check the function of ``map`` and similar functions against the number of sequences."""
    sequences = kinds[1:]
    runs = bool(sequences) and all(kind.items for kind in sequences)
    check_callback(inference, nodes[0], kinds[0], [*map(item_given, sequences)], f"`{builtin.name}`", runs)


def _applied(
    inference: KindInference, node: Any, builtin: Builtin, nodes: Sequence[Any], kinds: Sequence[Kind]
) -> None:
    """Check the function of ``apply`` against the arguments and the items of the list, if its length is known."""
    items = kinds[-1].items if kinds[-1].tag == "List" else None
    if items is None or len(nodes) == 1:
        return
    arguments = [*kinds[1:-1], *items]
    if not any(kind is ANY or kind.tag == "Keyword" for kind in arguments):
        check_callback(inference, nodes[0], kinds[0], arguments, "`apply`", True)


def _tested(inference: KindInference, node: Any, builtin: Builtin, nodes: Sequence[Any], kinds: Sequence[Kind]) -> None:
    """Check the predicate of ``filter`` and similar functions."""
    check_callback(inference, nodes[0], kinds[0], [ANY], f"`{builtin.name}`", bool(kinds[1].items))


def _folded(inference: KindInference, node: Any, builtin: Builtin, nodes: Sequence[Any], kinds: Sequence[Kind]) -> None:
    """Check the function of a fold against the items and the accumulator."""
    sequences = kinds[2:]
    runs = bool(sequences) and all(kind.items for kind in sequences)
    items = [*map(item_given, sequences)]
    passed = [ANY, *items] if builtin.name == "fold-left" else [*items, ANY]
    check_callback(inference, nodes[0], kinds[0], passed, f"`{builtin.name}`", runs)


_CALLBACKS: dict[str, Callable[..., None]] = {
    "map": _mapped, "for-each": _mapped, "append-map": _mapped, "filter-map": _mapped, "any": _mapped,
    "every": _mapped, "filter": _tested, "remove": _tested, "partition": _tested, "find": _tested,
    "list-index": _tested, "apply": _applied, "fold": _folded, "fold-left": _folded, "fold-right": _folded,
}  # fmt: skip


# --- functions of the program ----------------------------------------------------------------------------------------


def _call_lambda(
    inference: KindInference, node: ast.Application, code: ast.Lambda, arguments: Sequence[Kind], function: Kind
) -> Kind:
    """Check a call of a function of the program or of a combinator, and return the kind of its result."""
    owner = name_of(code)
    result = function.item if function.item is not None else ANY
    named = {p.name: p for p in code.parameters if p.kind == "keyword"}
    takes_any = any(p.kind == "keys" for p in code.parameters)
    nodes: Sequence[Any] = node.arguments
    keywords: Sequence[tuple[str, Any, Any]] = ()
    if named or takes_any:
        parts = split(inference, node, nodes, owner, code.usage)
        if parts is None:
            return ANY
        nodes, keywords = parts
        if not takes_any and _report_positional_keyword(inference, code, owner, nodes, keywords):
            return ANY
    elif written_keyword(nodes) is not None and _report_plain_keyword(inference, node, code, owner):
        return ANY
    positional = [p for p in code.parameters if p.kind in ("required", "optional")]
    required = sum(p.kind == "required" for p in positional)
    has_rest = any(p.kind == "rest" for p in code.parameters)
    is_unsure = bool(named or takes_any) and _may_hide_keywords(inference, nodes)
    if (len(nodes) < required or (len(nodes) > len(positional) and not has_rest)) and not is_unsure:
        return _report_lambda_arity(inference, node, code, nodes, {key for key, _, _ in keywords})
    swap = _swapped_parameters(inference, node, positional, nodes)
    if swap is not None:
        hint, fixes = swap
        return inference.report(
            "type", f"two arguments of {owner} are swapped", node.span, _swapped_hint(node, hint, fixes), fixes=fixes,
            expected=code.usage, found=" ".join(describe(inference.result.kinds[n]) for n in nodes),
            signature=code.usage,
        )  # fmt: skip
    are_valid = [
        _check_parameter(inference, owner, parameter, argument, code.usage)
        for parameter, argument in zip(positional, nodes)
    ]
    are_valid.append(check_keywords(inference, node, owner, "argument", code, keywords, () if is_unsure else None))
    if code.name in INDICES and all(map(is_library_parameter, positional)):
        _check_copies(inference, code, nodes, keywords)
    return result if all(are_valid) else ANY


def _swapped_hint(node: Any, hint: str, fixes: tuple[Fix, ...]) -> str:
    """Return the hint with the call in which two arguments are exchanged, if that is short."""
    if not fixes:
        return hint
    start, written = node.span.start, node.span.text
    for edit in reversed(fixes[0].edits):
        written = written[: edit.span.start - start] + edit.text + written[edit.span.end - start :]
    return f"write `{written}`" if len(written) <= _MAX_WRITTEN else hint


def _swapped_parameters(
    inference: KindInference, node: Any, parameters: Sequence[ast.Parameter], nodes: Sequence[Any]
) -> tuple[str, tuple[Fix, ...]] | None:
    """Return the hint and fix for two adjacent arguments whose types show that they are swapped."""
    for i in range(min(len(parameters), len(nodes)) - 1):
        first, second = parameters[i], parameters[i + 1]
        a, b = inference.result.kinds[nodes[i]], inference.result.kinds[nodes[i + 1]]
        if first.type is None or accepts(first.type, a) or b is ANY or not accepts(first.type, b):
            continue
        if second.type is None or accepts(second.type, a):
            return swap_fix(node, nodes[i], nodes[i + 1])
    return None


def check_keywords(
    inference: KindInference,
    node: Any,
    owner: str,
    what: str,
    code: ast.Lambda,
    keywords: Sequence[tuple[str, Any, Any]],
    positional: Sequence[Any] | None,
) -> bool:
    """Check the keyword arguments of a function: their names and types, and that none is missing.

    Parameters
    ----------
    what
        The word for a keyword argument in messages: "argument" or "attribute".
    positional
        None if the arguments passed by position cannot supply keyword arguments; missing ones are reported only then.
    """
    named = {p.name: p for p in code.parameters if p.kind == "keyword"}
    takes_any = any(p.kind == "keys" for p in code.parameters)
    signature = f"(call {owner} {code.usage[1:-1]})" if what == "attribute" and code.usage.startswith("(") else None
    unknown = [key for key in keywords if key[0] not in named and not takes_any]
    is_named = owner.startswith("`")  # not a word, which is called with keywords alone
    places = [p.name for p in code.parameters if p.kind in ("required", "optional") and is_named]
    callee = Callee(owner, named, signature or code.usage, places)
    for key, key_node, _ in unknown:
        report_unknown_keyword(inference, callee, key, key_node.span)
    are_valid = [
        _check_parameter(inference, owner, named[key], value, code.usage, signature)
        for key, _, value in keywords
        if key in named
    ]
    passed = {key for key, _, _ in keywords}
    missing = [name for name, p in named.items() if p.default is None and name not in passed]
    if missing and not unknown and positional is None:  # an unknown name is probably the missing one, misspelled
        _report_missing(inference, node, owner, missing, code.usage, what, signature)
        return False
    return all(are_valid) and not unknown


def _check_parameter(
    inference: KindInference,
    owner: str,
    parameter: ast.Parameter,
    value: Any,
    usage: str,
    signature: str | None = None,
) -> bool:
    """Check an argument against the type of a parameter; without a type, against the uses in the function's body."""
    kind = inference.result.kinds[value]
    if parameter.type is None:
        inference.pass_argument(parameter, owner, value, usage)
        return (
            parameter.name != "objects"
            or not is_library_parameter(parameter)
            or _check_stacked(inference, owner, parameter, value, kind, usage)
        )
    if kind is ANY:
        inference.need(value, f"passed to {owner}", (parameter.type,), expected_name(parameter.type.name))
    report_half(inference, value, kind, parameter.type.name)
    if accepts(parameter.type, kind) and literal_fits(parameter.type, value):
        return not is_library_parameter(parameter) or _check_combined(inference, owner, parameter, value, kind, usage)
    sign = ":" if parameter.kind == "keyword" else ""
    expected = expected_name(parameter.type.name)
    hint, fixes = _advice_of_type(parameter.type, value, kind)
    inference.report(
        "type", f"the parameter `{sign}{parameter.name}` of {owner} expects {expected}, got {shown(value, kind)}",
        value.span, hint or default_hint(owner, usage), fixes=fixes, expected=expected, found=describe(kind),
        signature=signature or usage,
    )  # fmt: skip
    return False


def _advice_of_type(type_: Type, value: Any, kind: Kind) -> tuple[str | None, tuple[Fix, ...]]:
    """Return the hint and fix for an argument that does not have the type of a parameter."""
    hint, fixes = advice_on_value(value, type_.name)
    if hint is not None:
        return hint, fixes
    if type_.name in _OBJECTS and is_profile(value):
        return profile_hint("", value), ()
    if type_.name in _OBJECTS:
        return _called_word(value, kind)
    return meant_keyword(type_, value)


def is_library_parameter(parameter: ast.Parameter) -> bool:
    """Return whether a parameter is declared in a source file of the standard library, not in the program."""
    span = parameter.target.span if isinstance(parameter.target, Variable) else None
    return span is not None and span.source.name.startswith(STD)


def _check_combined(
    inference: KindInference, owner: str, parameter: ast.Parameter, value: Any, kind: Kind, usage: str
) -> bool:
    """Check an argument of a combinator beyond its type: parts, a count, an angle."""
    assert parameter.type is not None
    name = parameter.type.name
    if name in _OBJECTS and all(option.tag != "Function" for option in kind.options):
        inner = item_of(kind) if name == "List[Parts]" and kind.items is None else kind
        if not may_be_parts(inner):
            _report_object(inference, owner, parameter, value, kind, usage)
            return False
    number = inference.number_of(value)
    if name == "Integer" and number is not None and number < 0:
        inference.report("value", f"{owner} expects a count that is not negative for `{parameter.name}`, got "
                         f"{number:g}", value.span, expected="a count that is not negative",
                         found=f"{number:g}")  # fmt: skip
        return False
    if name == "Number" and parameter.name in _ANGLES:
        check_angle(inference, value)
    return True


_OBJECTS = ("Parts", "Template", "List[Parts]")
_ANGLES = ("turn", "sweep", "start")


def _report_object(
    inference: KindInference, owner: str, parameter: ast.Parameter, value: Any, kind: Kind, usage: str
) -> None:
    """Report an argument of a combinator that is not parts."""
    hint, fixes = _called_word(value, kind)
    message = f"the parameter `{parameter.name}` of {owner} expects entities, got {shown(value, kind)}"
    inference.report(
        "parts" if kind.tag == "List" else "type", message, value.span, hint or default_hint(owner, usage),
        fixes=fixes, expected=A_PART, found=describe(kind), signature=usage,
    )  # fmt: skip


def _called_word(value: Any, kind: Kind) -> tuple[str | None, tuple[Fix, ...]]:
    """Return the hint and fix for a word in place of an entity."""
    if kind.tag == "String" and type(value) is ast.Constant and value.span.expansion is None:
        return f"a word is called: `(call {value.span.text})`", (wrap_fix(value, "call"),)
    if kind.tag == "List" and any(item.tag == "String" for item in kind.items or (item_of(kind),)):
        return 'a word is called: `(list (call "word") ...)`', ()
    return None, ()


def _check_stacked(
    inference: KindInference, owner: str, parameter: ast.Parameter, value: Any, kind: Kind, usage: str
) -> bool:
    """Check the list of ``stack``, whose items are parts, or arrays as in numpy."""
    items = kind.items if kind.items is not None else (item_of(kind),)
    are_arrays = bool(items) and items[0] is not ANY and not may_be_parts(items[0])
    fit = all(accepts("Array", item) if are_arrays else may_be_parts(item) for item in items)
    if kind is ANY or (kind.tag == "List" and fit):
        return True
    if kind.tag != "List" and kind is not ENTITY and kind is not PART and kind.tag != "String":
        return True
    _report_object(inference, owner, parameter, value, kind, usage)
    return False


# Number of indices that a combinator passes to the function of its copies.
INDICES = {"grid": 3, "ring": 1, "scatter": 1}


def _check_copies(
    inference: KindInference, code: ast.Lambda, nodes: Sequence[Any], keywords: Sequence[tuple[str, Any, Any]]
) -> None:
    """Check the function of a combinator's copies: its arity, and that it returns parts."""
    for parameter, node in zip(code.parameters, nodes):
        kind = inference.result.kinds[node]
        if parameter.type is None or parameter.type.name != "Template" or kind.tag != "Function":
            continue
        counts = [n for p, n in zip(code.parameters, nodes) if p.type is not None and p.type.name == "Integer"]
        counts += [value for key, _, value in keywords if key in ("nx", "ny", "nz")]
        runs = all((inference.number_of(count) or 0) > 0 for count in counts)
        check_callback(inference, node, kind, [INTEGER] * INDICES[code.name], f"`{code.name}`", runs)
        result = kind.item
        if result is not None and not may_be_parts(result):
            inference.report(
                "parts", f"the function of `{code.name}` must return entities, got {describe(result)}", node.span,
                always=runs, expected=A_PART, found=describe(result),
            )  # fmt: skip


def written_keyword(nodes: Sequence[Any]) -> Any:
    """Return the first literal keyword among arguments, or None."""
    return next(filter(is_keyword, nodes), None)


def _report_plain_keyword(inference: KindInference, node: Any, code: ast.Lambda, owner: str) -> bool:
    """Report ``(f :height 2)`` where ``height`` is a positional parameter.

    The function takes the keyword as a value, so the number of its arguments is wrong.
    """
    key = written_keyword(node.arguments)
    names = [p.name for p in code.parameters if p.kind in ("required", "optional")]
    required = sum(p.kind == "required" for p in code.parameters)
    has_rest = any(p.kind == "rest" for p in code.parameters)
    if str(key.value) not in names or has_rest or required <= len(node.arguments) <= len(names):
        return False
    hint = f"pass `{key.value}` by position, or make it a keyword parameter: `(:{key.value} default)`"
    inference.report(
        "arity", f"{owner} takes `{key.value}` by position, not as the keyword `:{key.value}`", key.span, hint,
        expected=f"{plural(len(names), 'positional argument')}", found=f":{key.value}", signature=code.usage,
    )  # fmt: skip
    return True


def _report_positional_keyword(
    inference: KindInference,
    code: ast.Lambda,
    owner: str,
    nodes: Sequence[Any],
    keywords: Sequence[tuple[str, Any, Any]],
) -> bool:
    """Report ``(f :h 1)`` where the function has keyword parameters, but takes ``h`` by position."""
    positional = [p.name for p in code.parameters if p.kind in ("required", "optional")]
    for key, key_node, value in keywords:
        if key in positional:
            span = key_node.span
            fixes: tuple[Fix, ...] = ()
            if span.expansion is None and positional.index(key) == len(nodes) and key_node is keywords[0][1]:
                fixes = (Fix("Pass it by position", (Edit(Span(span.source, span.start, value.span.start), ""),)),)
            inference.report(
                "keyword", f"{owner} takes `{key}` by position, not as the keyword `:{key}`", span,
                call_hint(owner, code.usage), fixes=fixes, expected=f"`{key}` by position", found=f":{key}",
                signature=code.usage,
            )  # fmt: skip
            return True
    return False


def _is_parts(kind: Kind) -> bool:
    """Return whether a value is known, and may be parts."""
    return kind is not ANY and may_be_parts(kind)


def _report_lambda_arity(
    inference: KindInference, node: Any, code: ast.Lambda, nodes: Sequence[Any], passed: Collection[str]
) -> Kind:
    """Report a wrong number of positional arguments, with a fix that makes a list or keyword arguments of the surplus.

    ``nodes`` are the positional arguments, ``passed`` the names of the keyword arguments.
    """
    kinds = [parameter.kind for parameter in code.parameters]
    required, has_rest = kinds.count("required"), "rest" in kinds
    most = required + kinds.count("optional")
    named = {p.name: p for p in code.parameters if p.kind == "keyword"}
    owner, count = name_of(code), len(nodes)
    if has_rest:
        expected = f"at least {required}"
    else:
        expected = str(required) if required == most else f"{required} to {most}"
    noun = "argument" if expected.split()[-1] == "1" else "arguments"
    positional = "positional " if named else ""
    hint = call_hint(owner, code.usage)
    free = [name for name in named if name not in passed]
    fixes: tuple[Fix, ...] = ()
    extra = nodes[most:]
    first = next((p for p in code.parameters if p.kind == "required"), None)
    if (
        extra
        and first is not None
        and first.name == "objects"
        and most == 1
        and all(may_be_parts(inference.result.kinds[argument]) for argument in extra)
    ):
        span = Span(node.span.source, nodes[0].span.start, nodes[-1].span.end)
        listed = f"({node.function.span.text} (list {span.text}))"
        hint = f"the objects are given as one list: `{listed if len(listed) <= _MAX_WRITTEN else '(list ...)'}`"
        if all(_is_parts(inference.result.kinds[argument]) for argument in nodes):
            fixes = (Fix("Write a list", (Edit(span, f"(list {span.text})"),), safe=True),)
        elif inference.result.kinds[nodes[0]].tag == "Integer" and len(nodes) == 2:
            loop = f"(for/list ((i {nodes[0].span.text})) {nodes[1].span.text})"
            hint = (
                f"the objects are given as one list: `{loop if len(loop) <= MAX_SHOWN else '(for/list ((i n)) ...)'}`"
            )
            fixes = (Fix("Write a loop", (Edit(span, loop),)),)
    elif named and extra and len(extra) <= len(free) and all(argument.span.expansion is None for argument in nodes):
        parts = [argument for argument in nodes if _is_parts(inference.result.kinds[argument])]
        if most == 1 and len(parts) == 1 and parts[0] is not nodes[0]:  # the object is not the first
            extra = [argument for argument in nodes if argument is not parts[0]]
            written = " ".join(f":{name} {argument.span.text}" for name, argument in zip(free, extra))
            text = f"{parts[0].span.text} {written}"
            hint = f"the object comes first: `{text}`" if len(text) <= MAX_SHOWN else f"name the arguments: `{written}`"
            span = Span(node.span.source, nodes[0].span.start, nodes[-1].span.end)
            fixes = (Fix("Put the object first", (Edit(span, text),)),)
        else:
            pairs = [f":{name} {argument.span.text}" for name, argument in zip(free, extra)]
            hint = f"name the argument{'s' * (len(pairs) > 1)}: `{' '.join(pairs)}`"
            is_safe = len(extra) == len(free) == 1
            if not all(takes(named[name], inference.result.kinds[argument]) for name, argument in zip(free, extra)):
                pairs, hint = [], call_hint(owner, code.usage)
            fixes = (Fix("Name the arguments", tuple(Edit(e.span, p) for e, p in zip(extra, pairs)), is_safe),) * bool(
                pairs
            )
    if not fixes and not has_rest:
        fixes = _without_surplus(node, nodes, most)
    return inference.report(
        "arity", f"{owner} expects {expected} {positional}{noun}, got {count}", node.span, hint, fixes=fixes,
        expected=f"{expected} {positional}{noun}", found=plural(count, "argument"), signature=code.usage,
    )  # fmt: skip


def _report_missing(
    inference: KindInference,
    node: Any,
    owner: str,
    missing: Sequence[str],
    usage: str,
    what: str,
    signature: str | None = None,
) -> Kind:
    """Report keyword arguments without a default that a call omits."""
    names = " and ".join(f"`:{name}`" for name in missing)
    return inference.report(
        "keyword", f"missing {what}{'s' * (len(missing) > 1)} {names} of {owner}", node.span, call_hint(owner, usage),
        expected=" ".join(f":{name}" for name in missing), found="nothing", signature=signature or usage,
    )  # fmt: skip


def _call_record(
    inference: KindInference, node: ast.Application, code: RecordCode, arguments: Sequence[Kind], function: Kind
) -> Kind:
    """Check a call of a procedure of a record type."""
    result = function.item if function.item is not None else ANY
    if code.role == "new":
        return _call_constructor(inference, node, code, result)
    count = 2 if code.role == "set" else 1
    if len(arguments) != count:
        return inference.report(
            "arity", f"`{code.name}` expects {plural(count, 'argument')}, got {len(arguments)}", node.span,
            expected=plural(count, "argument"), found=plural(len(arguments), "argument"),
        )  # fmt: skip
    if code.role != "test" and not accepts(code.record, arguments[0]):
        expected = expected_name(code.record)
        return inference.report(
            "type", f"`{code.name}` expects {expected}, got {shown(node.arguments[0], arguments[0])}", node.span,
            expected=expected, found=describe(arguments[0]),
        )  # fmt: skip
    return result


def _call_constructor(inference: KindInference, node: ast.Application, code: RecordCode, result: Kind) -> Kind:
    """Check a call of a record's constructor, whose fields are passed by position or by keyword.

    Returns ``result``, the kind of the record, or ANY after a mistake, so that it has no consequential errors.
    """
    owner = f"`{code.record}`"
    usage = "(" + " ".join((code.record, *code.fields)) + ")"
    parts = split(inference, node, node.arguments, owner, usage)
    if parts is None:  # a reported mistake, or a computed argument that may be a keyword
        return ANY
    positional, keywords = parts
    if _may_hide_keywords(inference, positional):  # a variable may have a keyword as its value: no check is possible
        return result
    if len(positional) > len(code.fields):
        argument_count = plural(len(positional), "argument")
        return inference.report(
            "arity",
            f"{owner} has {len(code.fields)} fields, got {argument_count}",
            node.span,
            f"usage: {usage}",
            expected=plural(len(code.fields), "field"),
            found=argument_count,
            signature=usage,
        )
    if not _are_fields(inference, code, positional, keywords, usage):
        return ANY
    passed = {*code.fields[: len(positional)], *(key for key, _, _ in keywords)}
    missing = [field for field in code.fields if field in code.required and field not in passed]
    if missing:
        return inference.report(
            "keyword",
            f"missing field `{missing[0]}` of {owner}",
            node.span,
            f"usage: {usage}",
            expected=" ".join(missing),
            found="nothing",
            signature=usage,
        )
    return result


def _are_fields(
    inference: KindInference,
    code: RecordCode,
    positional: Sequence[Any],
    keywords: Sequence[tuple[str, Any, Any]],
    usage: str,
) -> bool:
    """Return whether all keywords are fields that are not passed before; report the first that is not."""
    passed = set(code.fields[: len(positional)])
    for key, key_node, _ in keywords:
        if key in passed or key not in code.fields:
            remaining = [field for field in code.fields if field not in passed]
            callee = Callee(f"`{code.record}`", remaining, usage, what="field")
            report_unknown_keyword(inference, callee, key, key_node.span)
            return False
        passed.add(key)
    return True
