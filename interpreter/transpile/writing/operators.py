"""Operators and subscripts, and conversions of expressions to the type that their context requires."""

from __future__ import annotations

import ast
import re
import string
from collections.abc import Sequence

from scenelang.interpreter.transpile.analysis.inference import (
    ARRAY,
    BOOL,
    CONTAINERS,
    DICT,
    FLOAT,
    FUNCTION,
    INT,
    LIST,
    NONE,
    NUMBERS,
    POSE,
    RECORD,
    SEQUENCES,
    SET,
    SHAPE,
    STR,
    STREAM,
    TUPLE,
    UNKNOWN,
    AbstractType,
    never_equal,
)
from scenelang.interpreter.transpile.analysis.python_text import child_nodes, walk_tree
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
    none,
    number,
    quote,
)
from scenelang.interpreter.transpile.writing.writer import WriteExpression, Writer

# f-strings, ``%`` and ``format``, which become ``(format "..." ...)``.


_PERCENT = re.compile(r"%(?:\((\w+)\))?([-+ #0]*)(\d+)?(?:\.(\d+))?([a-zA-Z%])")


def interpolated(w: Writer, node: ast.JoinedStr) -> Code:
    """Return the code of an f-string."""
    template = ""
    values: list[Code] = []
    widths: list[Code] = []  # computed parts of specifications, at the places of _COMPUTED
    for part in node.values:
        if isinstance(part, ast.Constant):
            template += _escaped(str(part.value))
        elif isinstance(part, ast.FormattedValue):
            spec = ""
            for p in part.format_spec.values if isinstance(part.format_spec, ast.JoinedStr) else ():
                spec += str(p.value) if isinstance(p, ast.Constant) else _COMPUTED
                if isinstance(p, ast.FormattedValue):
                    if p.format_spec is not None or p.conversion != -1 or not w.type(p.value).only(INT | STR):
                        raise w.unsupported("a computed format specification", part)
                    widths.append(w.expr(p.value))
            is_quoted = part.conversion == ord("r") and w.type(part.value).only(STR)
            field = "{" + (f":{spec}" if spec else "") + "}"
            template += f"'{field}'" if is_quoted else field
            values.append(as_text(w, part.value) if not spec else w.expr(part.value))
    if widths:
        inner = LiteralCode(_escaped(template).replace(_COMPUTED, "{}"))
        return form("format", form("format", inner, *widths), *values)
    return _format(template, values)


_COMPUTED = "\0"


def _format(template: str, values: list[Code]) -> Code:
    if not values:
        return LiteralCode(template.replace("{{", "{").replace("}}", "}"))
    return form("format", LiteralCode(template), *values)


def _escaped(text: str) -> str:
    return text.replace("{", "{{").replace("}", "}}")


def percent(w: Writer, node: ast.BinOp) -> Code:
    """Return the code of ``"..." % values``."""
    if not isinstance(node.left, ast.Constant):
        return dynamic(w, "py-%", w.expr(node.left), w.expr(node.right))
    values = list(node.right.elts) if isinstance(node.right, ast.Tuple) else [node.right]
    template, position = "", 0
    codes: list[Code] = []
    text = str(node.left.value)
    for match in _PERCENT.finditer(text):
        template += _escaped(text[position : match.start()])
        position = match.end()
        name, flags, width, precision, kind = match.groups()
        if kind == "%":
            template += "%"
            continue
        if name or kind not in "sdifgeExX" or len(codes) >= len(values):
            raise w.error("python-call", f"the format `{match.group()}` does not match the values", node.left)
        value = values[len(codes)]
        template += "{" + _spec(flags, width, precision, kind) + "}"
        if kind in "di" and not w.type(value).only(INT):
            codes.append(form("truncate", w.expr(value)))
        else:
            codes.append(as_text(w, value) if kind == "s" else w.expr(value))
    if len(codes) != len(values):
        raise w.error("python-call", f"the format expects {len(codes)} values, got {len(values)}", node)
    return _format(template + _escaped(text[position:]), codes)


def _spec(flags: str, width: str | None, precision: str | None, kind: str) -> str:
    if kind == "s" and not width and not precision:
        return ""
    align = "<" if "-" in flags else ">" if kind == "s" and width else ""
    sign = "+" if "+" in flags else ""
    zero = "0" if "0" in flags and not align else ""
    kind = {"i": "d", "s": ""}.get(kind, kind)
    return f":{align}{sign}{zero}{width or ''}{'.' + precision if precision else ''}{kind}"


def format_method(w: Writer, node: ast.Call, func: ast.Attribute) -> Code:
    """Return the code of ``"...".format(...)``.

    Named fields become positions; fields cannot access attributes or items.
    """
    named = {k.arg: position for position, k in enumerate(node.keywords, len(node.args)) if k.arg is not None}
    values = [*node.args, *(k.value for k in node.keywords)]
    if not isinstance(func.value, ast.Constant):
        return form("format", w.expr(func.value), *(w.expr(value) for value in values))
    template = ""
    try:
        fields = list(string.Formatter().parse(str(func.value.value)))
    except ValueError as problem:
        raise w.error("python-call", f"malformed format string: {problem}", func.value) from None
    for literal, name, spec, conversion in fields:
        template += _escaped(literal)
        if name is None:
            continue
        if "." in name or "[" in name:
            raise w.error("python-forbidden", f"the field `{{{name}}}` accesses the contents of its value", func.value)
        if conversion not in (None, "s"):
            raise w.unsupported(f"`!{conversion}` in a format", func.value)
        if name and not name.isdigit():
            if name not in named:
                raise w.error("python-call", f"missing value for the field `{name}` of the format string", func.value)
            name = str(named[name])
        template += "{" + name + (f":{spec}" if spec else "") + "}"
    return _format(template, [as_text(w, value) for value in values])


# Arithmetic.


_ARITHMETIC: dict[type[ast.operator], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%", ast.Pow: "expt",
}  # fmt: skip


_JOINING = (ast.Add, ast.Sub, ast.Mult, ast.Div)


_ORDER: dict[type[ast.cmpop], str] = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">="}


_ON_SETS: dict[type[ast.operator], str] = {
    ast.BitAnd: "set-intersection", ast.BitOr: "set-union", ast.Sub: "set-difference",
}  # fmt: skip


_ON_BITS: dict[type[ast.operator], str] = {
    ast.BitAnd: "bitwise-and", ast.BitOr: "bitwise-or", ast.BitXor: "bitwise-xor",
}  # fmt: skip


def binary(w: Writer, node: ast.BinOp) -> Code:
    """Return the code of a binary operation, chosen by the types of its operands."""
    left, right = w.type(node.left), w.type(node.right)
    kinds = left.kinds | right.kinds
    op = type(node.op)
    if op is ast.MatMult:
        return _chain(w, node, "@", ast.MatMult, write_array)
    # `&` and `|` of arrays combine masks, which `_bits` writes
    if kinds & (ARRAY | POSE) and op not in (ast.BitAnd, ast.BitOr):
        return _array_arithmetic(w, node, op)
    if op is ast.Mod and left.only(STR):
        return percent(w, node)
    if op is ast.Add and kinds & (STR | SEQUENCES | SHAPE):
        return _concatenation(w, node, left, right)
    if op is ast.Mult and kinds & (STR | SEQUENCES | SHAPE):
        return _repetition(w, node, left, right)
    if op in (ast.BitAnd, ast.BitOr, ast.BitXor, ast.LShift, ast.RShift) or (op is ast.Sub and kinds & SET):
        return _bits(w, node, op, left, right)
    if kinds & UNKNOWN and not _is_certain(left, right) and op in (ast.Add, ast.Mult, ast.Mod):
        return dynamic(w, f"py-{_ARITHMETIC[op]}", w.expr(node.left), w.expr(node.right))
    if op not in _ARITHMETIC:
        raise w.unsupported("this operator", node)
    return _arithmetic(w, node, op)


def _is_certain(left: AbstractType, right: AbstractType) -> bool:
    """Return whether one operand determines the type of the other: a Float cannot be a repetition count."""
    return left.only(FLOAT) or right.only(FLOAT)


def _arithmetic(w: Writer, node: ast.BinOp, op: type[ast.operator]) -> Code:
    if op in _JOINING:
        return _chain(w, node, _ARITHMETIC[op], op, numeric)
    return form(_ARITHMETIC[op], numeric(w, node.left), numeric(w, node.right))


def _chain(w: Writer, node: ast.BinOp, head: str, op: type[ast.operator], write: WriteExpression) -> Code:
    """Return ``(+ a b c)`` for ``a + b + c``, with the same operations in the same order."""
    operands: list[ast.expr] = []
    inner: ast.expr = node
    while isinstance(inner, ast.BinOp) and type(inner.op) is op and (inner is node or _same_kind(w, inner, node)):
        operands.append(inner.right)
        inner = inner.left
    operands.append(inner)
    return form(head, *(write(w, operand) for operand in reversed(operands)))


def _same_kind(w: Writer, inner: ast.BinOp, outer: ast.BinOp) -> bool:
    """Return whether two operations are the same kind of arithmetic, so that one form can express both."""
    kinds = w.type(inner).kinds
    if isinstance(outer.op, ast.MatMult):
        return bool(kinds & (POSE | ARRAY))
    return not kinds & (STR | SEQUENCES | SHAPE | SET | UNKNOWN)


def _array_arithmetic(w: Writer, node: ast.BinOp, op: type[ast.operator]) -> Code:
    if op not in _ARITHMETIC:
        raise w.unsupported("this array operator", node)
    if op in _JOINING:
        return _chain(w, node, _ARITHMETIC[op], op, _array_operand)
    return form(_ARITHMETIC[op], _array_operand(w, node.left), _array_operand(w, node.right))


def _array_operand(w: Writer, node: ast.expr) -> Code:
    return numeric(w, node) if w.type(node).only(BOOL) else write_array(w, node)


def _concatenation(w: Writer, node: ast.BinOp, left: AbstractType, right: AbstractType) -> Code:
    kinds = left.kinds | right.kinds
    if left.only(NUMBERS) or right.only(NUMBERS):
        return _arithmetic(w, node, ast.Add)
    if kinds & (UNKNOWN | NUMBERS) and not kinds & SHAPE:
        return dynamic(w, "py-+", w.expr(node.left), w.expr(node.right))
    if kinds & SHAPE:
        return _flat(w, node, "union", SHAPE | LIST)
    if kinds & STR:
        return _flat(w, node, "string-append", STR)
    code = _flat(w, node, "append", SEQUENCES)
    return form("mutable", code) if w.is_mutated(node) else code


def _flat(w: Writer, node: ast.BinOp, head: str, kinds: int) -> Code:
    operands: list[ast.expr] = []
    inner: ast.expr = node
    while (
        isinstance(inner, ast.BinOp) and isinstance(inner.op, ast.Add) and (inner is node or w.type(inner).only(kinds))
    ):
        operands.append(inner.right)
        inner = inner.left
    operands.append(inner)
    return form(head, *(w.expr(operand) for operand in reversed(operands)))


def _repetition(w: Writer, node: ast.BinOp, left: AbstractType, right: AbstractType) -> Code:
    items, count = (node.left, node.right) if left.kinds & (STR | SEQUENCES | SHAPE) else (node.right, node.left)
    if left.only(FLOAT) or right.only(FLOAT):
        return _arithmetic(w, node, ast.Mult)  # only a number can be multiplied by a Float
    if (left.kinds | right.kinds) & UNKNOWN or w.type(items).kinds & NUMBERS:
        return dynamic(w, "py-*", w.expr(node.left), w.expr(node.right))
    if isinstance(items, (ast.List, ast.Tuple)) and len(items.elts) == 1 and not isinstance(items.elts[0], ast.Starred):
        code: Code = form("make-list", w.expr(count), w.expr(items.elts[0]))
    elif w.type(items).kinds & SHAPE:
        code = form("repeat", form("primitives", w.expr(items)), w.expr(count))
    else:
        code = form("repeat", w.expr(items), w.expr(count))
    return form("mutable", code) if w.is_mutated(node) else code


def _bits(w: Writer, node: ast.BinOp, op: type[ast.operator], left: AbstractType, right: AbstractType) -> Code:
    kinds = left.kinds | right.kinds
    if kinds & SET and (op is ast.BitXor or op in _ON_SETS):
        if op is ast.BitXor:
            a, b = w.expr(node.left), w.expr(node.right)
            return form(
                "set-union", form("set-difference", a, b), form("set-difference", w.expr(node.right), w.expr(node.left))
            )
        return form(_ON_SETS[op], w.expr(node.left), w.expr(node.right))
    if kinds & DICT and op is ast.BitOr:
        return form("table-merge", w.expr(node.left), w.expr(node.right))
    if is_mask(left) and is_mask(right) and op in (ast.BitAnd, ast.BitOr):
        return form("min" if op is ast.BitAnd else "max", w.expr(node.left), w.expr(node.right))
    if left.only(BOOL) and right.only(BOOL) and op in (ast.BitAnd, ast.BitOr):
        return form("and" if op is ast.BitAnd else "or", w.expr(node.left), w.expr(node.right))
    if op in (ast.LShift, ast.RShift):
        shift = w.expr(node.right) if op is ast.LShift else form("-", w.expr(node.right))
        return form("arithmetic-shift", numeric(w, node.left), shift)
    return form(_ON_BITS[op], numeric(w, node.left), numeric(w, node.right))


def unary(w: Writer, node: ast.UnaryOp) -> Code:
    operand = node.operand
    if isinstance(node.op, ast.Not):
        return form("not", write_test(w, operand))
    if isinstance(node.op, ast.USub):
        value = operand.value if isinstance(operand, ast.Constant) else None
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            inner = w.expr(operand)
            assert isinstance(inner, LiteralCode)
            return LiteralCode(-value, w.span(node), f"-{inner.text}" if inner.text else None)
        return form("-", write_array(w, operand) if w.type(operand).only(ARRAY) else numeric(w, operand))
    if isinstance(node.op, ast.UAdd):
        return numeric(w, operand)
    if is_mask(w.type(operand)):
        return form("-", number(1), w.expr(operand))
    if w.type(operand).only(BOOL):
        raise w.unsupported("`~` of a Boolean", node)
    return form("-", form("-", numeric(w, operand)), number(1))


# Comparisons, `and` and `or`.


def comparison(w: Writer, node: ast.Compare) -> Code:
    """Return the code of ``a < b`` or a chained comparison."""
    operands = [node.left, *node.comparators]
    if len(node.ops) == 1:
        return _compare(w, node, node.ops[0], operands[0], operands[1])
    heads = {_ORDER.get(type(op), "=" if isinstance(op, ast.Eq) else "") for op in node.ops}
    if len(heads) == 1 and "" not in heads and all(w.is_numeric(o) for o in operands):
        return form(heads.pop(), *(numeric(w, o) for o in operands))
    if any(not w.is_simple(o) and w.effect(o).has_effect for o in operands[1:-1]):
        raise w.unsupported("a chained comparison whose middle operand has side effects", node)
    return form("and", *(_compare(w, node, op, a, b) for op, a, b in zip(node.ops, operands, operands[1:])))


def _compare(w: Writer, node: ast.Compare, op: ast.cmpop, a: ast.expr, b: ast.expr) -> Code:
    """Return the code of a single comparison, chosen by the types of its operands."""
    span = w.span(node)
    if isinstance(op, ast.NotEq) and is_mask(w.type(node)):
        return form("-", number(1), form("array-map", Name("="), write_array(w, a), write_array(w, b)), span=span)
    if isinstance(op, (ast.NotEq, ast.IsNot, ast.NotIn)):
        positive: ast.cmpop = {ast.NotEq: ast.Eq, ast.IsNot: ast.Is, ast.NotIn: ast.In}[type(op)]()
        return form("not", _compare(w, node, positive, a, b), span=span)
    if isinstance(op, ast.In):
        return _contains(w, a, b)
    if isinstance(op, ast.Eq) and is_mask(w.type(node)):
        return form("array-map", Name("="), write_array(w, a), write_array(w, b), span=span)
    if isinstance(op, (ast.Is, ast.Eq)):
        return _equal(w, a, b)
    left, right = w.type(a), w.type(b)
    head = _ORDER[type(op)]
    if (left.kinds | right.kinds) & ARRAY:
        return form("array-map", Name(head), write_array(w, a), write_array(w, b), span=span)
    if left.only(SET) and right.only(SET):
        small, large = (a, b) if head in ("<", "<=") else (b, a)
        subset = form("subset?", w.expr(small), w.expr(large), span=span)
        return (
            subset if "=" in head else form("and", subset, form("not", form("equal?", w.expr(a), w.expr(b))), span=span)
        )
    if left.only(STR) and right.only(STR):
        return form(f"string{head}?", w.expr(a), w.expr(b), span=span)
    if (
        (left | right).only(NUMBERS | NONE)
        or not left.kinds
        or not right.kinds
        or left.only(FLOAT)
        or right.only(FLOAT)
    ):
        return form(head, numeric(w, a), numeric(w, b), span=span)
    if (left | right).only(NUMBERS | NONE | UNKNOWN):
        return form(head, numeric(w, a), numeric(w, b), span=span)
    # of unknown values only `<` exists: `a <= b` is written as `not (b < a)`
    first, second = (a, b) if head in ("<", ">=") else (b, a)
    less = dynamic(w, "py-<", w.expr(first), w.expr(second))
    return less if head in ("<", ">") else form("not", less, span=span)


def _contains(w: Writer, item: ast.expr, container: ast.expr) -> Code:
    inferred = w.type(container)
    if inferred.kinds & UNKNOWN:
        return dynamic(w, "py-in", w.expr(item), w.expr(container))
    if never_contains(w, container, item):
        return after_effects(w, (item, container), LiteralCode(False))
    code = form("primitives", w.expr(container)) if inferred.kinds & SHAPE else w.expr(container)
    return form("contains?", code, w.expr(item))


def never_contains(w: Writer, container: ast.expr, item: ast.expr) -> bool:
    """Return whether a sequence contains only tuples and the item is a list, or vice versa."""
    inferred = w.type(container)
    if not inferred.only(SEQUENCES) or not inferred.sites:
        return False
    return all(site.element.kinds and never_equal(site.element, w.type(item)) for site in inferred.sites)


def after_effects(w: Writer, operands: Sequence[ast.expr], result: Code) -> Code:
    """Return ``result``, evaluated after the operands that have effects."""
    acting = [operand for operand in operands if w.effect(operand).has_effect]
    return form("begin", *(w.expr(operand) for operand in acting), result) if acting else result


def _equal(w: Writer, a: ast.expr, b: ast.expr) -> Code:
    for first, second in ((a, b), (b, a)):
        if is_none(second):
            return form("none?", w.expr(first))
        if isinstance(second, ast.Constant) and isinstance(second.value, bool) and w.type(first).only(BOOL):
            return w.expr(first) if second.value else form("not", w.expr(first))
    left, right = w.type(a), w.type(b)
    if never_equal(left, right):  # a tuple and a list, which are equal in the language
        return after_effects(w, (a, b), LiteralCode(False))
    if left.only(BOOL) and right.only(BOOL):
        return form("equal?", w.expr(a), w.expr(b))
    if _is_number(left) and _is_number(right):
        return form("=", numeric(w, a), numeric(w, b))
    if left.only(STR) or right.only(STR) or (left | right).only(STR | NONE):
        return form("equal?", w.expr(a), w.expr(b))
    if _is_exact(w, left) and _is_exact(w, right):
        return form("equal?", w.expr(a), w.expr(b))
    if left.only(BOOL) or right.only(BOOL) or (left.kinds & (ARRAY | RECORD | FUNCTION)):
        return form("equal?", w.expr(a), w.expr(b))
    if (isinstance(b, (ast.List, ast.Tuple)) and not b.elts) or (isinstance(a, (ast.List, ast.Tuple)) and not a.elts):
        return form("equal?", w.expr(a), w.expr(b))
    return dynamic(w, "py-==", w.expr(a), w.expr(b))


def _is_number(inferred: AbstractType) -> bool:
    return not inferred.kinds or inferred.only(NUMBERS)


def _is_exact(w: Writer, inferred: AbstractType) -> bool:
    """Return whether ``equal?`` agrees with Python's equality: for strings and Integers, and sequences of these."""
    if not inferred.kinds or not inferred.only(INT | STR | NONE | SEQUENCES):
        return False
    return all(site.element.only(INT | STR | NONE) for site in inferred.sites)


def boolean(w: Writer, node: ast.BoolOp) -> Code:
    """Return the value of ``a and b`` or ``a or b``."""
    head = "and" if isinstance(node.op, ast.And) else "or"
    *first, last = node.values
    if all(w.type(v).only(BOOL | NONE | ALWAYS_TRUE) or not w.type(v).kinds for v in first):
        return form(head, *(write_test(w, v) if w.type(v).only(BOOL) else w.expr(v) for v in first), w.expr(last))
    result = w.expr(last)
    for value in reversed(first):
        if head == "or" and _is_empty_display(last) and w.type(value).only(CONTAINERS | NONE) and value is first[-1]:
            result = form("or", w.expr(value), result)
        elif w.is_simple(value):
            test, code = write_test(w, value), w.expr(value)
            result = form("if", test, code, result) if head == "or" else form("if", test, result, code)
        else:
            thunk = FormCode([Name("lambda"), FormCode([]), result])
            result = dynamic(w, f"py-bool-{head}", w.expr(value), thunk)
    return result


def _is_empty_display(node: ast.expr) -> bool:
    return (isinstance(node, (ast.List, ast.Tuple)) and not node.elts) or (isinstance(node, ast.Dict) and not node.keys)


# Subscripts.


def subscript(w: Writer, node: ast.Subscript) -> Code:
    """Return the code of ``value[index]``: an item, a slice, or the items at several indices."""
    inferred = w.type(node.value)
    index = node.slice
    if isinstance(index, ast.Slice):
        return _slice(w, node, index, inferred)
    if isinstance(index, ast.Tuple) and inferred.kinds & (ARRAY | POSE):
        return _many(w, node, index)
    if w.type(index).only(BOOL) and isinstance(node.value, (ast.Tuple, ast.List)) and len(node.value.elts) == 2:
        # the idiom `(no, yes)[test]`; a Boolean is not an index in the language
        no, yes = node.value.elts
        if not w.effect(no, yes).has_effect:
            return form("if", write_test(w, index), w.expr(yes), w.expr(no))
    if w.type(index).kinds & (ARRAY | LIST) and inferred.kinds & ARRAY and not inferred.kinds & DICT:
        return _indexed(w, node, index)
    factory = _factory(w, inferred)
    if factory is not None:
        return _item_with_default(w, node, index, factory)
    if inferred.kinds & UNKNOWN and inferred.kinds & SHAPE:
        return dynamic(w, "py-ref", w.expr(node.value), w.expr(index))
    is_key = bool(inferred.kinds & DICT) and any(site.key.kinds & BOOL for site in inferred.sites)
    return form("ref", container(w, node.value), w.expr(index) if is_key else numeric(w, index))


def _indexed(w: Writer, node: ast.Subscript, index: ast.expr) -> Code:
    """Return the code of ``array[indices]``."""
    if is_mask(w.type(index)):
        selected, mark = (
            PythonVariable("item", None, is_temporary=True),
            PythonVariable("mark", None, is_temporary=True),
        )
        sources = [FormCode([VariableRef(selected), w.expr(node.value)]), FormCode([VariableRef(mark), w.expr(index)])]
        clauses = FormCode([*sources, Key("when"), form("=", VariableRef(mark), number(1))])
        return form("array", FormCode([Name("for/list"), clauses, VariableRef(selected)]))
    source, item = PythonVariable("source", None, is_temporary=True), PythonVariable("i", None, is_temporary=True)
    picked = FormCode(
        [
            Name("for/list"),
            FormCode([FormCode([VariableRef(item), write_iterable(w, index)])]),
            form("ref", VariableRef(source), VariableRef(item)),
        ]
    )
    return form("let", FormCode([FormCode([VariableRef(source), w.expr(node.value)])]), form("array", picked))


def is_mask(inferred: AbstractType) -> bool:
    """Return whether a value is the result of an array comparison, which contains 1 and 0."""
    return inferred.only(ARRAY) and any(site.key.kinds & BOOL for site in inferred.sites)


def _factory(w: Writer, inferred: AbstractType) -> ast.expr | None:
    """Return the default factory of a ``defaultdict``, or None."""
    for site in inferred.sites:
        if (
            isinstance(site.node, ast.Call)
            and w.paths.of(site.node.func) == "collections.defaultdict"
            and site.node.args
        ):
            return site.node.args[0]
    return None


def _item_with_default(w: Writer, node: ast.Subscript, index: ast.expr, factory: ast.expr) -> Code:
    """Return an item of a ``defaultdict``: a constant default is not stored, any other is inserted first."""
    simple = {
        "int": number(0),
        "float": LiteralCode(0.0, None, "0."),
        "str": LiteralCode(""),
        "bool": LiteralCode(False),
    }
    default: Code | None = simple.get(w.paths.of(factory) or "")
    if default is None and isinstance(factory, ast.Lambda) and isinstance(factory.body, ast.Constant):
        default = w.expr(factory.body)
    if default is not None:
        return form("ref", w.expr(node.value), w.expr(index), default)
    empty = {"list": "mutable-list", "dict": "table", "set": "set"}.get(w.paths.of(factory) or "")
    new_value = form(empty) if empty else FormCode([w.expr(factory)])
    test = form("has-key?", w.expr(node.value), w.expr(index))
    store = form("set-ref!", w.expr(node.value), w.expr(index), new_value)
    return form("begin", form("unless", test, store), form("ref", w.expr(node.value), w.expr(index)))


def container(w: Writer, node: ast.expr) -> Code:
    """Return a sequence that is indexed or measured; a shape becomes its primitives."""
    inferred = w.type(node)
    return form("primitives", w.expr(node)) if inferred.kinds & SHAPE else w.expr(node)


def _slice(w: Writer, node: ast.Subscript, index: ast.Slice, inferred: AbstractType) -> Code:
    if inferred.kinds & ARRAY and w.is_mutated(node):
        raise w.unsupported("modifying an array through a slice", node, "copy the slice with `.copy()`")
    value = container(w, node.value)
    lower, upper, step = (w.expr(part) if part is not None else None for part in (index.lower, index.upper, index.step))
    if lower is None and upper is None and isinstance(index.step, ast.UnaryOp) and _is_minus_one(index.step):
        return form("mutable", form("reverse", value)) if w.is_mutated(node) else form("reverse", value)
    if lower is None and upper is None and step is None:
        return form("mutable" if w.is_mutated(node) else "->list", value) if inferred.kinds & LIST else value
    if lower is None and step is None:
        lower = number(0)
    is_matrix = inferred.only(POSE) or any(site.kind == ARRAY and site.element.kinds & ARRAY for site in inferred.sites)
    if step is not None and is_matrix:
        return form("array", form("slice", form("->list", value), lower or none(), upper or none(), step))
    if step is None and is_matrix:
        return form("slice", value, *axes(w, [index]))  # rows of a matrix
    bounds = [lower or none(), *([upper or none()] if upper or step else []), *([step] if step else [])]
    code = form("slice", value, *bounds)
    return form("mutable", code) if w.is_mutated(node) else code


def _is_minus_one(node: ast.UnaryOp) -> bool:
    return isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant) and node.operand.value == 1


def _many(w: Writer, node: ast.Subscript, index: ast.Tuple) -> Code:
    """Return the code of ``array[i, j]`` or ``array[:, 0]``."""
    if any(isinstance(e, ast.Constant) and e.value is None for e in index.elts):
        return _with_new_axes(w, node, index)
    head = "slice" if any(isinstance(e, ast.Slice) for e in index.elts) else "ref"
    return form(head, w.expr(node.value), *axes(w, index.elts))


def _with_new_axes(w: Writer, node: ast.Subscript, index: ast.Tuple) -> Code:
    """Return the code of ``array[:, None]``: all items, with sides of length 1 between the others."""
    places = [n for n, e in enumerate(index.elts) if isinstance(e, ast.Constant) and e.value is None]
    rest = [n for n, e in enumerate(index.elts) if isinstance(e, ast.Constant) and e.value is ...]
    is_whole = all(
        not isinstance(e, ast.Slice) or (e.lower is None and e.upper is None and e.step is None) for e in index.elts
    )
    is_plain = all(isinstance(e, (ast.Slice, ast.Constant)) for e in index.elts)
    if not is_whole or not is_plain or len(places) + len(rest) + _count(index, ast.Slice) < len(index.elts):
        raise w.unsupported("a new axis of a part of an array", node, "take the part first")
    if len(rest) > 1:
        raise w.error("python-call", "an index contains `...` only once", node)
    numbers = [n - len(index.elts) if rest and n > rest[0] else n for n in places]
    return form("expand-dims", w.expr(node.value), *map(number, numbers))


def _count(index: ast.Tuple, kind: type) -> int:
    return sum(isinstance(each, kind) for each in index.elts)


def axes(w: Writer, elements: Sequence[ast.expr]) -> list[Code]:
    """Return for each axis an index, ``:all`` or (start end)."""
    codes: list[Code] = []
    for element in elements:
        if isinstance(element, ast.Constant) and element.value is ...:
            raise w.unsupported("`...` in an index", element, "write a `:` for each axis")
        if not isinstance(element, ast.Slice):
            codes.append(numeric(w, element))
        elif element.lower is None and element.upper is None and element.step is None:
            codes.append(Key("all"))
        else:
            if element.step is not None:
                raise w.unsupported("a slice step in an index of several axes", element)
            lower = w.expr(element.lower) if element.lower is not None else number(0)
            upper = w.expr(element.upper) if element.upper is not None else none()
            is_constant = type(lower) is LiteralCode and type(upper) is LiteralCode
            codes.append(quote(FormCode([lower, upper])) if is_constant else form("list", lower, upper))
    return codes


# Conversions, patterns, and clauses of loops.


ALWAYS_TRUE = FUNCTION | RECORD | POSE | STREAM


# Tests and numbers.


def write_test(w: Writer, node: ast.expr) -> Code:
    """Return a test, which is #f or none in the language wherever it is false in Python."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        inner = write_test(w, node.operand)
        if is_form(inner, "not") and isinstance(inner, FormCode):
            return inner.items[1]
        return form("not", inner, span=w.span(node))
    if isinstance(node, ast.BoolOp):
        head = "and" if isinstance(node.op, ast.And) else "or"
        return form(head, *(write_test(w, value) for value in node.values), span=w.span(node))
    if isinstance(node, ast.Constant):
        return LiteralCode(bool(node.value), w.span(node))
    return truth(w, node, w.type(node))


def truth(w: Writer, node: ast.expr, inferred: AbstractType) -> Code:
    """Return the truth value of ``node`` in Python."""
    code = w.expr(node)
    if not inferred.kinds or inferred.only(BOOL | NONE | ALWAYS_TRUE):
        return code
    rest = inferred.without(NONE | BOOL)
    some = _non_empty_test(w, code, node, rest)
    if some is None or (inferred.kinds & BOOL and rest.kinds):
        return dynamic(w, "py-truthy?", code)
    if inferred.kinds & (NONE | BOOL):
        if not w.is_simple(node):
            return dynamic(w, "py-truthy?", code)
        return form("and", w.expr(node), some, span=w.span(node))
    return some


def _non_empty_test(w: Writer, code: Code, node: ast.expr, inferred: AbstractType) -> Code | None:
    """Return the test that a value of a known kind is not zero or empty, or None for other kinds."""
    if inferred.only(INT | FLOAT):
        return form("not", form("zero?", code), span=w.span(node))
    if inferred.only(CONTAINERS | STR):
        if is_form(code, "set-intersection") or not is_form(code, "primitives"):
            return form("not", form("empty?", code), span=w.span(node))
    if inferred.only(SHAPE | LIST):
        return form("not", form("empty?", form("primitives", code)), span=w.span(node))
    return None


def numeric(w: Writer, node: ast.expr) -> Code:
    """Return an operand of arithmetic, with a Boolean as 1 or 0."""
    if isinstance(node, ast.Constant) and isinstance(node.value, bool):
        return number(int(node.value), w.span(node))
    if w.type(node).only(BOOL):
        return form("if", write_test(w, node), number(1), number(0), span=w.span(node))
    return w.expr(node)


def printable(w: Writer, node: ast.expr) -> Code:
    """Return a value that is formatted as in Python."""
    inferred = w.type(node)
    if not inferred.kinds or inferred.only(INT | FLOAT | STR):
        return w.expr(node)
    return dynamic(w, "py-str", w.expr(node))


def as_text(w: Writer, node: ast.expr) -> Code:
    """Return a value that becomes part of a text: a tuple is no list there, and a condition no number."""
    inferred = w.type(node)
    if inferred.only(BOOL):
        return form("if", write_test(w, node), LiteralCode("True"), LiteralCode("False"))
    if inferred.kinds & (BOOL | TUPLE | SET | RECORD) and not w.is_telling:
        raise w.unsupported("a text with a tuple, a set, an object or a condition", node, "write its items")
    return printable(w, node)


def dynamic(w: Writer, operator: str, *arguments: Code) -> Code:
    """Return a call of a dynamic operator, for operands whose types inference does not determine."""
    w.imports.add("std/python.scene")
    return form(operator, *arguments)


def is_constant(node: ast.expr) -> bool:
    """Return whether ``node`` is a literal constant, possibly a number with a sign."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        return isinstance(node.operand, ast.Constant) and isinstance(node.operand.value, (int, float))
    return isinstance(node, ast.Constant)


# Vectors, arrays and sequences.


def write_vector(w: Writer, node: ast.expr) -> Code:
    """Return an expression where a vector or color is expected; displays become arrays."""
    if isinstance(node, (ast.Tuple, ast.List)) and node.elts and not w.is_mutated(node):
        if not any(isinstance(e, ast.Starred) for e in node.elts):
            items = [w.comment_item(numeric(w, element), element) for element in node.elts]
            return Brackets(items, w.span(node))
    if isinstance(node, ast.Call) and len(node.args) == 1 and not isinstance(node.args[0], ast.Starred):
        path = w.paths.of(node.func)
        if path in ("numpy.array", "numpy.asarray") and not w.is_mutated(node):
            return write_vector(w, node.args[0])
        if path in ("tuple", "list") and w.type(node.args[0]).only(ARRAY | SEQUENCES):
            return write_vector(w, node.args[0])
    if isinstance(node, ast.IfExp):
        return form(
            "if", write_test(w, node.test), write_vector(w, node.body), write_vector(w, node.orelse), span=w.span(node)
        )
    return w.expr(node)


def write_array(w: Writer, node: ast.expr) -> Code:
    """Return an operand of array arithmetic; sequences become arrays."""
    if isinstance(node, (ast.Tuple, ast.List)) and node.elts and not w.is_mutated(node):
        if not any(isinstance(e, ast.Starred) for e in node.elts):
            return Brackets([write_array(w, e) for e in node.elts], w.span(node))
    if isinstance(node, ast.Call) and w.paths.of(node.func) in ("tuple", "list") and len(node.args) == 1:
        return write_array(w, node.args[0])
    inferred = w.type(node)
    code = w.expr(node)
    if inferred.only(SEQUENCES) and not isinstance(code, Brackets):
        return form("array", code, span=w.span(node))
    return code


def write_iterable(w: Writer, node: ast.expr) -> Code:
    """Return the iterable of a loop."""
    inferred = w.type(node)
    if inferred.kinds & SHAPE:
        return form("primitives", w.expr(node), span=w.span(node))
    if _is_endless(w, node):
        raise w.unsupported("an endless iterator here", node)
    if inferred.kinds & UNKNOWN and not isinstance(node, ast.Call):
        return dynamic(w, "py-iter", w.expr(node))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "keys":
        if w.type(node.func.value).only(DICT):
            return w.expr(node.func.value)
    if _copies_view(w, node):
        assert isinstance(node, ast.Call)
        return w.expr(node.args[0])  # already a new list, independent of the table
    if isinstance(node, ast.Call) and w.paths.of(node.func) in ("list", "tuple", "iter") and len(node.args) == 1:
        if not isinstance(node.args[0], ast.Starred) and not w.is_mutated(node):
            inner = w.type(node.args[0])
            if inner.kinds & CONTAINERS and not any(s.is_mutated for s in inner.sites):
                return write_iterable(w, node.args[0])
    return w.expr(node)


def _copies_view(w: Writer, node: ast.expr) -> bool:
    """Return whether ``node`` copies a view of a table, as in ``list(table.keys())``."""
    if not isinstance(node, ast.Call) or w.paths.of(node.func) not in ("list", "tuple") or len(node.args) != 1:
        return False
    inner = node.args[0]
    return (
        isinstance(inner, ast.Call)
        and isinstance(inner.func, ast.Attribute)
        and inner.func.attr in ("keys", "values", "items")
    )


# Patterns, and the clauses of loops and comprehensions.


def write_pattern(w: Writer, target: ast.expr) -> Code:
    """Return the pattern of a loop or assignment target; a starred element must be the last."""
    if isinstance(target, ast.Name):
        variable = w.names.variables[target]
        return _binder(w, variable, target)
    if isinstance(target, (ast.Tuple, ast.List)):
        elements = target.elts
        if any(isinstance(e, ast.Starred) for e in elements[:-1]):
            raise w.unsupported("a starred element before the end of this target", target)
        if elements and isinstance(elements[-1], ast.Starred):
            return FormCode(
                [write_pattern(w, e) for e in elements[:-1]], w.span(target), write_pattern(w, elements[-1].value)
            )
        return FormCode([write_pattern(w, e) for e in elements], w.span(target))
    raise w.unsupported("this assignment target", target)


def _binder(w: Writer, variable: PythonVariable, node: ast.AST) -> Code:
    """Return a variable in a pattern; ``_`` if it has that name and is never read."""
    if variable in w.late_variables:
        return VariableRef(w.late_variables[variable], w.span(node))
    if variable.name == "_" and not variable.reads:
        return Name("_", w.span(node))
    return VariableRef(variable, w.span(node))


def loop_head(w: Writer, kind: str, generators: list[ast.comprehension]) -> list[Code]:
    """Return the head and clauses of a comprehension."""
    nested = len(generators) > 1
    clauses: list[Code] = []
    for generator in generators:
        clauses += loop_clauses(w, generator.target, generator.iter, parallel=not nested)
        for condition in generator.ifs:
            clauses += condition_clause(w, condition)
    return [Name(f"for{'*' if nested else ''}{kind}"), FormCode(clauses)]


def condition_clause(w: Writer, condition: ast.expr, holds: bool = True) -> list[Code]:
    """Return ``:when test``, or ``:unless`` for a negated test."""
    while isinstance(condition, ast.UnaryOp) and isinstance(condition.op, ast.Not):
        condition, holds = condition.operand, not holds
    return [Key("when" if holds else "unless"), write_test(w, condition)]


def loop_clauses(w: Writer, target: ast.expr, iterable: ast.expr, parallel: bool) -> list[Code]:
    """Return the clauses of ``for target in iterable``; ``zip`` becomes parallel clauses where these are allowed."""
    path = w.paths.of(iterable.func) if isinstance(iterable, ast.Call) else None
    if (
        parallel
        and path == "zip"
        and isinstance(iterable, ast.Call)
        and isinstance(target, (ast.Tuple, ast.List))
        and len(target.elts) == len(iterable.args)
        and not any(isinstance(e, ast.Starred) for e in (*target.elts, *iterable.args))
    ):
        sources = parallel_sources(w, iterable.args)
        return [FormCode([write_pattern(w, t), source]) for t, source in zip(target.elts, sources)]
    return [FormCode([write_pattern(w, target), write_iterable(w, iterable)])]


def parallel_sources(w: Writer, sources: Sequence[ast.expr]) -> list[Code]:
    """Return the sequences of a ``zip``; ``cycle(xs)`` is repeated to the length of the first other sequence."""
    is_cycle = [_cycles(w, source) for source in sources]
    other = next((s for s, cycles in zip(sources, is_cycle) if not cycles), None)
    codes: list[Code] = []
    for source, cycles in zip(sources, is_cycle):
        if cycles and other is not None:
            if w.effect(other).has_effect:
                raise w.unsupported("`cycle` zipped with a sequence that has side effects", source)
            items = w.expr(source) if isinstance(source, ast.Name) else write_iterable(w, source.args[0])  # type: ignore[attr-defined]
            codes.append(form("repeat", items, form("length", write_iterable(w, other))))
        else:
            codes.append(write_iterable(w, source))
    return codes


def _cycles(w: Writer, source: ast.expr) -> bool:
    """Return whether an iterator repeats its items without end, from the first one on: one that nothing else uses."""
    if isinstance(source, ast.Call):
        return w.paths.of(source.func) == "itertools.cycle" and len(source.args) == 1
    if not isinstance(source, ast.Name) or not _is_endless(w, source):
        return False
    variable = w.variable(source)
    if variable is None or len(w.reads_of(variable)) != 1:
        return False
    for node in walk_tree(w.text.tree):
        block = getattr(node, "body", None)
        if isinstance(block, list) and any(_assigns(w, each, variable) for each in block):
            return any(_takes_once(each, source) for each in block)
    return False


def _takes_once(statement: ast.AST, node: ast.expr) -> bool:
    """Return whether a statement evaluates an expression in it at most once."""
    if statement is node:
        return True
    if isinstance(statement, (ast.While, ast.FunctionDef, ast.Lambda, ast.ClassDef)):
        return False
    if isinstance(statement, ast.For):
        return _takes_once(statement.iter, node)
    if isinstance(statement, (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)):
        return _takes_once(statement.generators[0].iter, node)
    return any(_takes_once(each, node) for each in child_nodes(statement))


def _assigns(w: Writer, node: ast.stmt, variable: PythonVariable) -> bool:
    return isinstance(node, ast.Assign) and w.variable(node.targets[0]) is variable


def _is_endless(w: Writer, node: ast.expr) -> bool:
    return any(
        isinstance(site.node, ast.Call) and w.paths.of(site.node.func) == "itertools.cycle"
        for site in w.type(node).sites
    )
