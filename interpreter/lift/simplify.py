"""Rules of lifting that shorten: inline what is used once, compose poses, remove what nothing uses, declare params."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from scenelang.grammar.datum import Keyword, Symbol
from scenelang.grammar.layout import line_comment
from scenelang.interpreter.lift.tree import (
    CodeTree,
    OpenProgram,
    SideEffects,
    array,
    atom,
    bodies,
    bound_names,
    code,
    defined_names,
    form,
    is_constant,
    joined,
    listed,
    names,
    size,
    symbol,
    walk,
)

_POSES = ("translate", "rotate", "scale", "reflect", "@")
_BOXES = ("compute-shape-min", "compute-shape-max", "compute-shape-center", "compute-shape-sizes")
_AXES = ("x-of", "y-of", "z-of")
_MAX_SCALAR = 9  # nodes of a number's expression that is inlined
_MAX_TOLD = 24  # nodes of an expression whose place says what its name says
_MAX_LITERAL = 12  # nodes of a literal that is inlined


# --- poses and unions ----------------------------------------------------------------------------------------------


def is_pose(node: CodeTree) -> bool:
    """Return whether an expression surely gives a matrix."""
    return node.head in _POSES


def factors(matrix: CodeTree) -> list[CodeTree]:
    """Return the factors of a product of matrices."""
    if matrix.head != "@":
        return [matrix]
    return [factor for operand in matrix.operands for factor in factors(operand)]


def product(matrices: Sequence[CodeTree]) -> CodeTree:
    """Return the product of matrices; neighboring translations are added."""
    kept: list[CodeTree] = []
    for matrix in matrices:
        total = _added(kept[-1], matrix) if kept else None
        if total is not None:
            kept[-1] = total
        else:
            kept.append(matrix)
    return kept[0] if len(kept) == 1 else form("@", *kept, span=kept[0].span)


def vector_of(translation: CodeTree) -> list[CodeTree] | None:
    """Return the three coordinates of ``(translate [x y z])``."""
    if translation.head != "translate" or len(translation.operands) != 1:
        return None
    vector = translation.operands[0]
    return vector.items if vector.is_array and vector.items is not None and len(vector.items) == 3 else None


def is_zero(node: CodeTree) -> bool:
    return node.is_number and node.value == 0


def _added(first: CodeTree, second: CodeTree) -> CodeTree | None:
    a, b = vector_of(first), vector_of(second)
    if a is None or b is None:
        return None
    total = [_sum(x, y) for x, y in zip(a, b)]
    if any(one is None for one in total):
        return None
    return form("translate", array([one for one in total if one is not None], first.span), span=first.span)


def _sum(x: CodeTree, y: CodeTree) -> CodeTree | None:
    if is_zero(y):
        return x
    if is_zero(x):
        return y
    if not x.is_number or not y.is_number:
        if y.head == "-" and len(y.operands) == 1:
            return form("-", x, y.operands[0], span=x.span)
        if x.head == "-" and len(x.operands) == 1:
            return form("-", y, x.operands[0], span=x.span)
        return form("+", x, y, span=x.span)
    return atom(x.value + y.value, x.span)


def shorten(program: OpenProgram, top: CodeTree) -> bool:
    """Write poses of poses as products, unions of unions as one, and shorter conditions and arithmetic."""
    changed = False
    for node in reversed(list(code(top))):
        head = node.head
        if head is None:
            continue
        if head == "transform" and len(node.operands) == 2:
            changed |= _compose_transform(program, node)
            if is_pose(node.operands[1]):
                _shorten_numbers(node.operands[1])
        elif head == "union":
            changed |= _flatten_union(node)
        elif head == "ref" and len(node.operands) == 2:
            changed |= _name_axis(node)
        elif head == "cond":
            changed |= _to_if(node)
        elif head in ("*", "/", "+") and head in program.known:
            changed |= _arithmetic(program, node)
    return changed


def _compose_transform(program: OpenProgram, node: CodeTree) -> bool:
    inner, outer = node.operands
    if inner.head != "transform" or len(inner.operands) != 2 or not is_pose(outer) or not is_pose(inner.operands[1]):
        return False
    if not program.effects(inner.operands[1]).commutes(program.effects(outer)):
        return False
    matrices = [*factors(outer), *factors(inner.operands[1])]
    assert node.items is not None
    body = inner.operands[0]
    body.trivia = joined(inner.trivia, body.trivia)
    node.items[1:] = [body, product(matrices)]
    return True


def _flatten_union(node: CodeTree) -> bool:
    changed = False
    kept: list[CodeTree] = []
    for member in node.operands:
        if member.head == "union" and member.items is not None and len(member.items) > 1:
            first, last = member.items[1], member.items[-1]
            first.trivia = joined(replace(member.trivia, after=None), first.trivia)
            if member.trivia.after and not last.trivia.after:
                last.trivia = replace(last.trivia, after=member.trivia.after)
            kept += member.items[1:]
            changed = True
        else:
            kept.append(member)
    assert node.items is not None
    node.items[1:] = kept
    if len(kept) == 1 and gives_parts(kept[0]):
        node.become(kept[0])
        return True
    return changed


def gives_parts(node: CodeTree) -> bool:
    """Return whether the value is a list of parts already, so that a ``union`` around it says nothing."""
    head = node.head or ""
    return head in ("union", "union-loop", "primitives", "ring", "grid", "align") or head.endswith("/union")


def _name_axis(node: CodeTree) -> bool:
    """Write ``(ref box 1)`` as ``(y-of box)``."""
    box, index = node.operands
    if box.head not in _BOXES or type(index.value) is not int or index.value not in (0, 1, 2):
        return False
    node.become(form(_AXES[index.value], box, span=node.span))
    return True


# --- inlining ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Use:
    """The only use of a variable: the nodes around it, each with the position of the next, and the conditions."""

    path: tuple[tuple[CodeTree, int], ...]
    is_repeated: bool
    is_conditional: bool

    @property
    def parent(self) -> CodeTree:
        return self.path[-1][0]

    @property
    def position(self) -> int:
        return self.path[-1][1]


def inline(program: OpenProgram, top: CodeTree) -> bool:
    """Put the expressions of variables that are used once in the places where they are used."""
    changed = False
    for node, start in bodies(top):
        changed |= _unfold_let(node, start)
        changed |= _inline_body(program, node, start)
    return changed


def _unfold_let(node: CodeTree, start: int) -> bool:
    """Turn a ``let*`` that is all of a body into definitions, if no name is bound twice."""
    assert node.items is not None
    last = node.items[-1]
    if node.head not in ("lambda", "define") or len(node.items) != start + 1 or last.head not in ("let", "let*"):
        return False
    items = last.items or []
    if len(items) < 3 or items[1].items is None or items[1].name is not None:
        return False
    bindings = items[1].items
    targets = [binding.items[0] for binding in bindings if binding.items is not None and len(binding.items) == 2]
    bound = [name for target in targets for name in names(target) if name != "_"]
    if len(targets) != len(bindings) or len(set(bound)) != len(bound) or set(bound) & set(bound_names(node)):
        return False
    inner = {name for statement in items[2:] for name in defined_names(statement)}
    if inner & set(bound):
        return False
    if last.head == "let" and any(
        names(binding.items[1])[name] for binding in bindings if binding.items for name in bound
    ):
        return False
    # a name that is read before it is bound means an outer variable
    for position, binding in enumerate(bindings):
        assert binding.items is not None
        later = [name for target in targets[position:] for name in names(target)]
        if any(name in names(binding.items[1]) for name in later):
            return False
    statements = []
    for binding, target in zip(bindings, targets):
        assert binding.items is not None
        head = "define-values" if target.items is not None else "define"
        definition = form(head, target, binding.items[1], span=binding.span)
        definition.trivia = binding.trivia
        statements.append(definition)
    new = [*statements, *items[2:]]
    new[0].trivia = joined(last.trivia, new[0].trivia)
    node.items[start:] = new
    return True


def _inline_body(program: OpenProgram, node: CodeTree, start: int) -> bool:
    """Inline the definitions of a body that are used once; return whether the body changed."""
    assert node.items is not None
    statements = node.items[start:]
    if len(statements) < 2:
        return False
    total = Counter[str]()
    for statement in statements:
        total.update(names(statement))
    changed = False
    # from the end, since an inlined value takes its own uses of earlier definitions along
    position = len(statements) - 2
    while position >= 0:
        definition = statements[position]
        _select_axis(definition, total)
        if definition.head == "define" and len(definition.items or ()) >= 3:
            done = _inline_definition(program, node, statements, position, total)
            if done:
                changed = True
                del statements[position]
        position -= 1
    if changed:
        node.items[start:] = statements
        statements[0].trivia = replace(statements[0].trivia, blank=False)
    return changed


def _select_axis(definition: CodeTree, total: Counter[str]) -> None:
    """Write ``(define-values (_ y _) box)`` as ``(define y (y-of box))``."""
    items = definition.items or []
    if definition.head != "define-values" or len(items) != 3 or items[2].head not in _BOXES:
        return
    targets = items[1].items or []
    if len(targets) != 3 or items[1].tail is not None or any(target.name is None for target in targets):
        return
    used = [index for index, target in enumerate(targets) if target.name != "_" and total[target.name or ""] > 1]
    if len(used) == 1:
        span = definition.span
        items[0] = symbol("define", span)
        items[1] = targets[used[0]]
        items[2] = form(_AXES[used[0]], items[2], span=items[2].span)


def _inline_definition(
    program: OpenProgram, body: CodeTree, statements: list[CodeTree], position: int, total: Counter[str]
) -> bool:
    """Move a value to the only use of its name, if any; return whether the definition can be deleted."""
    definition = statements[position]
    assert definition.items is not None
    value = _value(definition)
    name = next(defined_names(definition), None)
    # a total of 2 is the definition and one use
    if value is None or name is None or total[name] > 2 or names(value)[name]:
        return False
    effects = program.effects(value)
    if total[name] == 1:
        if not effects.is_pure and value.head != "lambda":
            return False
        total.subtract(names(definition))
        _keep_comments(definition, statements[position + 1], only_section=True)
        return True
    if statements[-1].name == name and position == len(statements) - 2:
        value.trivia = joined(joined(statements[-1].trivia, definition.trivia), value.trivia)
        statements[-1] = value
        total.subtract({name: 2})
        return True
    place = None
    for index in range(position + 1, len(statements)):
        if names(statements[index])[name]:
            place = index, _use_of(statements[index], name)
            break
    if place is None or place[1] is None:
        return False
    index, use = place
    if use is None or not _is_better(program, definition, value, use):
        return False
    if _may_move(program, value, effects, statements[position + 1 : index], use):
        _put(definition, value, use, name)
        total.subtract({name: 2})
        return True
    return False


def _value(definition: CodeTree) -> CodeTree | None:
    """Return the expression of a definition; that of a function is a ``lambda``."""
    items = definition.items or []
    target = items[1]
    if target.items is None:
        return items[2] if len(items) == 3 else None
    if not target.items or target.items[0].name is None:
        return None
    parameters = listed(target.items[1:], target.span)
    if target.tail is not None:
        if not parameters.items:
            parameters = target.tail
        else:
            parameters.tail = target.tail
    return form("lambda", parameters, *items[2:], span=definition.span)


def _use_of(statement: CodeTree, name: str) -> _Use | None:
    """Return where a name that occurs once is used, or None if the place is not an operand."""
    path: list[tuple[CodeTree, int]] = []
    node, is_repeated, is_conditional = statement, False, False
    while node.name != name:
        if node.items is None or node.tail is not None or node.head in ("quote", "quasiquote", "set!", "guard"):
            return None
        position = next((i for i, item in enumerate(node.items) if _contains(item, name)), None)
        if position is None:
            return None
        head = node.head or ""
        if (
            head == "define-record"
            or name in bound_names(node)
            or (path and path[-1][0].head == "case" and not position)
        ):
            return None
        is_repeated = is_repeated or _repeats(node, position, path)
        is_conditional = is_conditional or _is_choice(head, position)
        path.append((node, position))
        node = node.items[position]
    if not path or (path[-1][1] == 0 and not path[-1][0].is_array):
        return None  # the head of an application
    return _Use(tuple(path), is_repeated, is_conditional)


def _contains(node: CodeTree, name: str) -> bool:
    return any(one.name == name for one in walk(node))


def _is_choice(head: str, position: int) -> bool:
    return head in ("cond", "case") or (position > 1 and head in ("if", "when", "unless", "and", "or"))


def _repeats(node: CodeTree, position: int, path: Sequence[tuple[CodeTree, int]]) -> bool:
    """Return whether an item of a node is evaluated another number of times than the node."""
    head, items = node.head or "", node.items or []
    if head in ("lambda", "while", "do", "let/ec", "union-loop") or head.startswith("define-"):
        return head not in ("define-values", "union-loop")
    if head == "define":
        return items[1].items is not None
    if head.startswith("for") and head != "for-each":
        return position > 1
    if head.startswith("let") and items[1].name is not None:
        return True
    outer = path[-1][0].head or "" if path else ""
    if outer.startswith("for") and outer != "for-each" and path[-1][1] == 1:
        return position > 0  # only the first clause is evaluated once
    return False


def _may_move(
    program: OpenProgram, value: CodeTree, effects: SideEffects, between: Sequence[CodeTree], use: _Use
) -> bool:
    if use.is_repeated and (not is_constant(value) or size(value) > _MAX_LITERAL):
        return False
    if use.is_conditional and not effects.is_pure and value.head != "lambda":
        return False
    used = set(names(value))
    for node, _ in use.path:
        if used and used & set(bound_names(node)):
            return False
    before = [*between, *(item for node, position in use.path for item in (node.items or [])[1:position])]
    if value.head == "lambda":
        return not _is_assigned(before, used)
    return all(effects.commutes(program.effects(node)) for node in before)


def _is_assigned(nodes: Iterable[CodeTree], used: set[str]) -> bool:
    return any(
        one.head == "set!" and one.operands[0].name in used for node in nodes for one in code(node) if one.operands
    )


# Which definitions are better inlined.

_PARTS = frozenset(["call", "primitive", "transform", "union", "union-loop", "ring", "grid", "mirror", "align"])
_VAGUE = frozenset((
    *("shape", "shapes", "result", "results", "part", "parts", "object", "objects", "obj", "item", "items", "model"),
    *("entity", "group", "all", "step", "unit", "base", "out", "res", "tmp", "temp", "copy", "fn", "final"),
    *("transformed", "moved", "rotated", "placed", "positioned", "s", "x", "y", "z", "t", "p", "m", "r"),
))  # fmt: skip


def is_part(node: CodeTree) -> bool:
    """Return whether an expression gives an entity or parts."""
    head = node.head or ""
    return head in _PARTS or head.endswith("/union")


def _is_better(program: OpenProgram, definition: CodeTree, value: CodeTree, use: _Use) -> bool:
    parent, position = use.parent, use.position
    commented = bool(definition.trivia.before or definition.trivia.after or definition.trivia.end)
    if value.head == "lambda":
        return parent.head in ("union-loop", "map", "ring", "grid", "for-each") and not use.is_conditional
    is_call = value.head is not None and value.head not in program.known
    if is_part(value) or is_call:
        if parent.head in ("union", "frames") or _is_result(use):
            return True
        if parent.head == "transform" and position == 1:
            return True
    if commented:
        return False
    name = next(defined_names(definition), None)
    before = parent.items[position - 1].value if parent.items and position > 1 else None
    is_told = type(before) is Keyword and before == name  # the place says what the name does
    if value.is_number:
        return name in _VAGUE or is_told
    if is_told or (parent.head == "transform" and is_pose(value)):
        return size(value) <= _MAX_TOLD
    if is_constant(value):
        return size(value) <= _MAX_LITERAL and not _is_table(value)
    return size(value) <= _MAX_SCALAR and not (parent.head == "define" and position == 2)


def _is_table(value: CodeTree) -> bool:
    return value.head == "quote" and size(value) > 6


def _is_result(use: _Use) -> bool:
    """Return whether the use is the whole last statement of a body."""
    parent, position = use.parent, use.position
    return parent.head in ("let", "let*", "lambda", "when") and position == len(parent.items or ()) - 1


def _put(definition: CodeTree, value: CodeTree, use: _Use, name: str) -> None:
    parent, position = use.parent, use.position
    assert parent.items is not None
    old = parent.items[position]
    trivia = joined(old.trivia, replace(definition.trivia, blank=False))
    value.trivia = joined(trivia, value.trivia)
    note = _note(name, value)
    target = parent if parent.head == "transform" and position == 1 else value
    if note and parent.head in ("union", "transform") and not (target.trivia.before or target.trivia.after):
        if not (value.trivia.before or value.trivia.after):
            target.trivia = replace(target.trivia, after=line_comment(note))
    parent.items[position] = value


def _note(name: str, value: CodeTree) -> str | None:
    """Return a comment that preserves a name that says more than the expression."""
    words = [word for word in name.strip("%").split("-") if not word.isdigit()]
    told = " ".join(_texts(value)).lower()
    if not words or len(name) < 3 or all(word in _VAGUE or word in told for word in words):
        return None
    return " ".join(words)


def _texts(node: CodeTree) -> Iterator[str]:
    for one in walk(node):
        if type(one.value) in (str, Symbol, Keyword):
            yield str(one.value)


def _keep_comments(definition: CodeTree, following: CodeTree, *, only_section: bool = False) -> None:
    """Keep the comments above an empty line, which are about more than the definition that goes."""
    before = definition.trivia.before
    cut = max((i for i, row in enumerate(before) if row is None), default=-1)
    if cut >= 0:
        following.trivia = replace(following.trivia, before=(*before[: cut + 1], *following.trivia.before))
    if definition.trivia.blank and not following.trivia.blank:
        following.trivia = replace(following.trivia, blank=True)


# --- shorter forms of the same value -------------------------------------------------------------------------------


def _to_if(node: CodeTree) -> bool:
    """Write a ``cond`` of one test and an ``else`` as ``if``."""
    clauses = node.operands
    if len(clauses) != 2 or any(not clause.items or len(clause.items) != 2 for clause in clauses):
        return False
    (test, then), (word, other) = (clause.items or [] for clause in clauses)
    if word.name != "else" or then.name == "=>" or next(defined_names(then), None) or next(defined_names(other), None):
        return False
    then.trivia = joined(clauses[0].trivia, then.trivia)
    other.trivia = joined(clauses[1].trivia, other.trivia)
    node.become(form("if", test, then, other, span=node.span))
    return True


def _arithmetic(program: OpenProgram, node: CodeTree) -> bool:
    """Write ``(* 2 pi x)`` as ``(* tau x)``, ``(/ (- x) 2)`` as ``(/ x -2)`` and ``(+ a (- b))`` as ``(- a b)``.

    These give the same floating-point numbers.
    """
    operands, span = node.operands, node.span
    if node.head == "*" and len(operands) > 1 and _is_number(operands[0], 2) and operands[1].name == "pi":
        if not {"pi", "tau"} <= program.known:
            return False
        rest = operands[2:]
        tau = symbol("tau", span)
        node.become(form("*", tau, *rest, span=span) if rest else tau)
        return True
    if "-" not in program.known or len(operands) != 2:
        return False
    first, second = operands
    if (
        node.head in ("*", "/")
        and first.head == "-"
        and len(first.operands) == 1
        and second.is_number
        and second.value > 0
    ):
        negative = atom(-second.value, second.span)
        negative.spelling = f"-{second.spelling}" if second.spelling and second.spelling[0] in ".0123456789" else None
        node.become(form(node.head, first.operands[0], negative, span=span))
        return True
    if node.head == "+" and second.head == "-" and len(second.operands) == 1:
        node.become(form("-", first, second.operands[0], span=span))
        return True
    return False


def _shorten_numbers(matrix: CodeTree) -> None:
    """Drop the error in the last digits of numbers in a pose: 2.5999999999999996 is 2.6."""
    for one in code(matrix):
        shorten_number(one)


def shorten_number(node: CodeTree) -> None:
    if node.items is None and type(node.value) is float and len(repr(node.value)) > 15:
        short = float(f"{node.value:.13g}")
        if len(repr(short)) < 12 and abs(short - node.value) <= 1e-14 * abs(node.value):
            node.value, node.spelling = short, None


def _is_number(node: CodeTree, value: float) -> bool:
    return node.is_number and node.value == value


# --- what nothing uses ---------------------------------------------------------------------------------------------


def remove_unused(program: OpenProgram) -> bool:
    """Remove definitions and words that nothing reaches from the scene. Programs without a scene are libraries."""
    root = next((form.operands[0].value for form in program.forms if form.head == "scene" and form.operands), None)
    if type(root) is not str or any(form.head == "import" for form in program.forms):
        return False
    owners: dict[str, list[CodeTree]] = {}
    for top in program.forms:
        for name in _provided(top):
            owners.setdefault(name, []).append(top)
    used: set[int] = set()
    waiting = [top for top in program.forms if not list(_provided(top)) or not program.effects(*_run(top)).is_pure]
    while waiting:
        top = waiting.pop()
        if id(top) in used:
            continue
        used.add(id(top))
        for name in _needed(top):
            waiting += owners.get(name, ())
        if any(_is_computed(one) for one in walk(top)):
            waiting += (owner for name, tops in owners.items() if name.startswith('"') for owner in tops)
    kept = [top for top in program.forms if id(top) in used]
    if len(kept) == len(program.forms):
        return False
    for position, top in enumerate(program.forms):
        if not any(top is one for one in kept):
            following = next((one for one in program.forms[position + 1 :] if any(one is k for k in kept)), None)
            if following is not None:
                _keep_comments(top, following)
    program.forms[:] = kept
    return True


def _run(top: CodeTree) -> list[CodeTree]:
    """Return what evaluating a definition evaluates: nothing of a function."""
    items = top.items or []
    if top.head == "define" and len(items) > 2 and (items[1].items is not None or items[2].head == "lambda"):
        return []
    return [one for one in items[2:] if one.head != "lambda"]


def _provided(top: CodeTree) -> Iterator[str]:
    if top.head == "bind" and len(top.items or ()) > 2 and type(top.operands[0].value) is str:
        yield f'"{top.operands[0].value}'
    elif top.head in ("define", "define-values"):
        yield from defined_names(top)


def _needed(top: CodeTree) -> Iterator[str]:
    for one in walk(top):
        if type(one.value) is Symbol:
            yield str(one.value)
        elif type(one.value) is str:  # a word may be computed, or come from a table
            yield f'"{one.value}'


def _is_computed(node: CodeTree) -> bool:
    """Return whether a call computes the word that it calls, which may be any."""
    return node.head == "call" and bool(node.operands) and type(node.operands[0].value) is not str


# --- params --------------------------------------------------------------------------------------------------------


def declare_params(program: OpenProgram, room: int = 0) -> bool:
    """Declare numbers that shape the scene as params: those at top level, and those at the top of the scene's root.

    A default of the root that becomes a param adds a node; ``room`` is how many may be added.
    """
    changed = False
    assigned = {
        str(one.operands[0].value) for top in program.forms for one in code(top) if one.head == "set!" and one.operands
    }
    defined = Counter(name for top in program.forms for name in defined_names(top))
    for top in program.forms:
        operands = top.operands
        name = operands[0].name if top.head == "define" and len(operands) == 2 else None
        if name is None or name in program.language:
            continue
        if _is_size(operands[1]) and name not in assigned and defined[name] == 1:
            assert top.items is not None
            top.items[0] = symbol("param", top.span)
            changed = True
    return _hoist(program, assigned, room) or changed


def _is_size(node: CodeTree) -> bool:
    return node.is_number


def _hoist(program: OpenProgram, assigned: set[str], room: int) -> bool:
    """Declare the numbers among the defaults and first definitions of the root as params."""
    scene = next((top for top in program.forms if top.head == "scene"), None)
    if scene is None or len(scene.operands) != 1 or type(scene.operands[0].value) is not str:
        return False
    word = scene.operands[0].value
    roots = [top for top in program.forms if top.head == "bind" and top.operands[0].value == word]
    if len(roots) != 1 or len(roots[0].operands) != 2 or roots[0].operands[1].head != "lambda":
        return False
    function = roots[0].operands[1]
    if _is_called(program, word):
        return False
    taken = {name for top in program.forms for name in defined_names(top)} | program.language
    params: list[CodeTree] = []
    _take_defaults(function, taken | assigned, params, room)
    bound = Counter(name for one in code(function) for name in bound_names(one))
    taken |= assigned | {name for name, times in bound.items() if times != 1}
    _take_definitions(function, taken, params)
    _take_values(function, taken, params, room - len(params))
    if not params:
        return False
    assert function.items is not None
    function.items[2].trivia = replace(function.items[2].trivia, blank=False)
    params[0].trivia = replace(params[0].trivia, blank=True)
    position = next((k for k, top in enumerate(program.forms) if top.head not in ("import", "param", None)), 0)
    first = program.forms[position]
    header = first.trivia.before
    cut = max((k for k, row in enumerate(header) if row is None), default=-1)
    if position == 0 and header and cut >= 0:  # the program's own comment stays at the top
        params[0].trivia = replace(params[0].trivia, before=(*header[: cut + 1], *params[0].trivia.before), blank=False)
        first.trivia = replace(first.trivia, before=header[cut + 1 :], blank=True)
    else:
        first.trivia = replace(first.trivia, blank=True)
    program.forms[position:position] = params
    return True


def _is_called(program: OpenProgram, word: str) -> bool:
    for top in program.forms:
        if top.head == "scene":
            continue
        texts = [one for one in walk(top) if type(one.value) is str and one.value == word]
        if len(texts) > (top.head == "bind" and top.operands[0].value == word):
            return True
    return False


def _take_defaults(function: CodeTree, taken: set[str], params: list[CodeTree], room: int) -> None:
    parameters = function.operands[0]
    used = {name for statement in function.operands[1:] for name in names(statement)}
    kept: list[CodeTree] = []
    for parameter in parameters.items or ():
        pair = parameter.items or []
        name = str(pair[0].value) if len(pair) == 2 and type(pair[0].value) is Keyword else None
        if name is None or "::" in name or name in taken or not _is_size(pair[1]) or len(params) >= room:
            kept.append(parameter)
            continue
        if name not in used and not any(name in names(other) for other in parameters.items or ()):
            continue
        params.append(form("param", symbol(name, parameter.span), pair[1], span=parameter.span))
        params[-1].trivia = parameter.trivia
    if parameters.items is not None:
        parameters.items[:] = kept


def _take_definitions(function: CodeTree, taken: set[str], params: list[CodeTree]) -> None:
    assert function.items is not None
    uses = names(function)
    kept: list[CodeTree] = []
    for statement in function.items[2:]:
        operands = statement.operands
        name = operands[0].name if statement.head == "define" and len(operands) == 2 else None
        if name is None or not _is_size(operands[1]) or name in taken or uses[name] < 2:
            kept.append(statement)
            continue
        assert statement.items is not None
        statement.items[0] = symbol("param", statement.span)
        statement.trivia = replace(statement.trivia, blank=False)
        params.append(statement)
    function.items[2:] = kept


def _take_values(function: CodeTree, taken: set[str], declared: list[CodeTree], room: int) -> None:
    """Take definitions of several numbers at once, ``(define-values (a b) '(1 2))``."""
    assert function.items is not None
    kept: list[CodeTree] = []
    for statement in function.items[2:]:
        operands = statement.operands
        targets = operands[0].items if statement.head == "define-values" and len(operands) == 2 else None
        values = operands[1].operands[0].items if targets and operands[1].head == "quote" else None
        if not targets or not values or len(values) != len(targets) or not all(map(_is_size, values)):
            kept.append(statement)
            continue
        spelled = [target.name or "_" for target in targets]
        is_free = not any(name in taken or name == "_" for name in spelled)
        growth = 4 * len(spelled) - size(statement)
        if not is_free or growth > room:
            kept.append(statement)
            continue
        room -= growth
        params = [form("param", target, value, span=statement.span) for target, value in zip(targets, values)]
        params[0].trivia = replace(statement.trivia, blank=False)
        declared += params
    function.items[2:] = kept
