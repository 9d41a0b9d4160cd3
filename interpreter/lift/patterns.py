"""Rules of lifting that find structure: rings, grids, nested loops, tables of similar parts, and aligned parts.

The rules read a program's loops as Szalinski (Nandi et al., "Synthesizing structured CAD models with equality
saturation and inverse transformations", PLDI 2020) reads flat lists of solids: a pose that is affine in a loop's index
is a repetition with a name. A rewriting is kept only if it needs fewer nodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from scenelang.interpreter.lift.simplify import factors, is_pose, is_zero, product, vector_of
from scenelang.interpreter.lift.tree import (
    ANY,
    CodeTree,
    OpenProgram,
    Poly,
    array,
    atom,
    bodies,
    code,
    comments_of,
    copied,
    defined_names,
    expression,
    form,
    keyword,
    listed,
    names,
    poly,
    same,
    size,
    symbol,
)


@dataclass(frozen=True, slots=True)
class _Loop:
    """Loop that gives parts: ``variable`` counts from 0 to ``count`` - 1."""

    count: CodeTree
    variable: str
    body: list[CodeTree]
    node: CodeTree


def _loop_of(node: CodeTree) -> _Loop | None:
    operands = node.operands
    if node.head == "union-loop" and len(operands) == 2 and operands[1].head == "lambda":
        parameters = operands[1].operands[0].items
        if parameters is None or len(parameters) != 1 or parameters[0].name is None:
            return None
        return _Loop(operands[0], parameters[0].name, operands[1].operands[1:], node)
    if node.head != "for/union" or len(operands) < 2 or operands[0].items is None or len(operands[0].items) != 1:
        return None
    clause = operands[0].items[0].items
    if clause is None or len(clause) != 2 or clause[0].name is None:
        return None
    count = _count(clause[1])
    return _Loop(count, clause[0].name, operands[1:], node) if count is not None else None


def _count(sequence: CodeTree) -> CodeTree | None:
    """Return the length of a sequence of the integers from 0."""
    if sequence.head in ("range", "iota") and len(sequence.operands) == 1:
        return sequence.operands[0]
    if sequence.items is None:
        return sequence if type(sequence.value) is int else None
    if sequence.head == "quote" and sequence.operands:
        values = [item.value if type(item.value) is int else None for item in sequence.operands[0].items or ()]
        if len(values) > 1 and values == list(range(len(values))):
            return atom(len(values), sequence.span)
    return None


class _Body:
    """Body of a loop: local values, the part, and the factors of its pose."""

    def __init__(self, program: OpenProgram, loop: _Loop) -> None:
        self.program, self.loop = program, loop
        self.rebound = frozenset(("+", "-", "*", "/", "pi", "tau", "sin", "cos")) - program.known
        self.values: dict[str, CodeTree] = {}
        for statement in loop.body[:-1]:
            if statement.head == "define" and len(statement.operands) == 2 and statement.operands[0].name is not None:
                self.values[statement.operands[0].name] = statement.operands[1]
        last = loop.body[-1]
        self.part, self.matrices = last, list[CodeTree]()
        if last.head == "transform" and len(last.operands) == 2 and is_pose(last.operands[1]):
            self.part, self.matrices = last.operands[0], factors(last.operands[1])

    def is_placed_freely(self) -> bool:
        """Return whether the poses may be computed before the parts, and once for all of them."""
        poses = self.program.effects(*self.matrices, *self.values.values())
        parts = self.program.effects(*self.loop.body[:-1], self.part)
        return self.program.effects(*self.matrices).is_pure and not parts.changes & (poses.reads | {ANY})

    def depends(self, node: CodeTree) -> bool:
        """Return whether an expression depends on the variable of the loop."""
        seen, waiting = set[str](), [node]
        while waiting:
            for name in names(waiting.pop()):
                if name == self.loop.variable:
                    return True
                if name not in seen:
                    seen.add(name)
                    waiting += [self.values[name]] if name in self.values else []
                    if name not in self.values and name in self._others():
                        return True
        return False

    def _others(self) -> set[str]:
        """Names that other statements of the body define."""
        return {
            name for statement in self.loop.body[:-1] for name in defined_names(statement) if name not in self.values
        }

    def poly(self, node: CodeTree) -> Poly:
        return poly(node, self.values, self.rebound)

    def linear(self, node: CodeTree) -> tuple[Poly, Poly] | None:
        """Return slope and offset of an expression in the variable, or None if it is not linear."""
        split = self.poly(node).split(self.loop.variable, self.depends)
        if split is None or any(self.depends(split[1].atoms[text]) for key in split[1].terms for text, _ in key):
            return None
        return split

    def copies(self, part: CodeTree) -> CodeTree:
        """Return the object that a combinator copies: the part, or a function of the index."""
        statements = self._needed(part)
        plain = not statements and not self.depends(part)
        if plain and self.program.effects(part).is_pure:
            return part
        variable = self.loop.variable if self.depends(part) or statements else "_"
        span = part.span
        return form("lambda", listed([symbol(variable, span)], span), *statements, part, span=span)

    def _needed(self, part: CodeTree) -> list[CodeTree]:
        """Return the statements of the body that a part needs."""
        used = set(names(part))
        kept: list[CodeTree] = []
        for statement in reversed(self.loop.body[:-1]):
            own = set(defined_names(statement))
            if own & used or not self.program.effects(statement).is_pure or not own:
                kept.insert(0, statement)
                used |= set(names(statement))
        return kept


def find(program: OpenProgram, top: CodeTree) -> bool:
    """Apply the rules of this file to a top-level form."""
    changed = False
    for node in reversed(list(code(top))):
        if node.head in ("union-loop", "for/union"):
            rules = (_index_loops, _over_items, find_ring, _line, _filtered)
            changed |= any(rule(program, node) for rule in rules)
        elif node.head == "for*/union":
            changed |= _grid(program, node) or _filtered(program, node)
    return changed


def accept(node: CodeTree, new: CodeTree) -> bool:
    """Replace a node if that makes the program shorter; comments that the new one lacks are put above it."""
    if size(new) >= size(node):
        return False
    kept = set(comments_of(new))
    lost = tuple(row for row in comments_of(node) if row not in kept and row not in node.trivia.before)
    if node.trivia.after in lost:
        lost = tuple(row for row in lost if row != node.trivia.after)
    if lost:
        new.trivia = replace(new.trivia, before=(*lost, *new.trivia.before))
    node.become(new)
    return True


def _over_items(program: OpenProgram, node: CodeTree) -> bool:
    """Write a loop over the indices of a sequence as a loop over its items."""
    loop = _loop_of(node)
    first = loop.body[0] if loop is not None and len(loop.body) > 1 else None
    if loop is None or first is None or not {"ref", "length", "enumerate"} <= program.known:
        return False
    if first.head not in ("define", "define-values") or len(first.operands) != 2 or first.operands[1].head != "ref":
        return False
    target, item = first.operands
    if target.items is not None and first.head == "define":
        return False
    reference = item.operands
    if len(reference) != 2 or reference[1].name != loop.variable or not _has_length(reference[0], loop.count):
        return False
    used = set(names(reference[0]))
    effects = program.effects(*loop.body)
    if used & {loop.variable} or effects.changes & (used | {ANY}):
        return False
    rest, span = loop.body[1:], node.span
    sequence, pattern = reference[0], target
    if any(loop.variable in names(statement) for statement in rest):
        pattern = listed([symbol(loop.variable, span), target], span)
        sequence = form("enumerate", sequence, span=span)
    return accept(node, form("for/union", listed([listed([pattern, sequence], span)], span), *rest, span=span))


def _has_length(sequence: CodeTree, count: CodeTree) -> bool:
    """Return whether a sequence surely has as many items."""
    if sequence.name is not None:
        return count.head == "length" and len(count.operands) == 1 and count.operands[0].name == sequence.name
    if sequence.head == "quote":
        return len(sequence.operands[0].items or ()) == count.value and type(count.value) is int
    return sequence.is_array and len(sequence.items or ()) == count.value and type(count.value) is int


def _filtered(program: OpenProgram, node: CodeTree) -> bool:
    """Write a loop whose body gives nothing in some cases with ``:unless`` or ``:when``."""
    loop = _loop_of(node)
    is_for = node.head != "union-loop" and len(node.operands) == 2 and node.operands[0].items is not None
    if not is_for and (loop is None or len(loop.body) != 1):
        return False
    condition = _test_for_nothing(node.operands[1] if is_for or loop is None else loop.body[0])
    if condition is None:
        return False
    test, key, rest = condition
    span = node.span
    if is_for or loop is None:
        clauses = listed([*(node.operands[0].items or []), keyword(key, span), test], span)
    else:
        clause = listed([symbol(loop.variable, span), _counted(loop.count)], span)
        clauses = listed([clause, keyword(key, span), test], span)
    return accept(node, form(node.head if is_for and node.head else "for/union", clauses, *rest, span=span))


def _test_for_nothing(body: CodeTree) -> tuple[CodeTree, str, list[CodeTree]] | None:
    """Return the test, whether it must hold, and what is done then, of ``(if test (union) part)``."""
    if body.head == "if" and len(body.operands) == 3:
        test, then, other = body.operands
        if _is_nothing(then):
            return *_positive(test, "unless"), [other]
        return (*_positive(test, "when"), [then]) if _is_nothing(other) else None
    clauses = body.operands if body.head == "cond" else []
    if len(clauses) < 2 or any(not clause.items or len(clause.items) < 2 for clause in clauses):
        return None
    first, *others = (clause.items or [] for clause in clauses)
    if len(first) != 2 or not _is_nothing(first[1]) or clauses[0].trivia.before or first[1].trivia.before:
        return None
    if others[0][0].name == "else":
        return None if clauses[1].trivia.before else (*_positive(first[0], "unless"), others[0][1:])
    return *_positive(first[0], "unless"), [form("cond", *clauses[1:], span=body.span)]


def _is_nothing(node: CodeTree) -> bool:
    return node.head == "union" and not node.operands


def _positive(test: CodeTree, key: str) -> tuple[CodeTree, str]:
    """Return a test without ``not``, and the keyword that fits it."""
    if test.head == "not" and len(test.operands) == 1:
        return test.operands[0], "when" if key == "unless" else "unless"
    return test, key


# --- rings ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Circle:
    """Where a ring's copies are: the angles, from +z towards +x, and the pose of the part at the angle 0."""

    radius: CodeTree
    start: Poly
    slope: Poly
    turns: bool
    inner: list[CodeTree]


def find_ring(program: OpenProgram, node: CodeTree) -> bool:
    """Write a loop whose parts are spaced evenly on a circle around the y axis as a ``ring``."""
    loop = _loop_of(node)
    # a ring may repeat the count in its sweep, where it would draw a second random number
    if loop is None or "ring" not in program.known or program.is_blocks or program.effects(loop.count).draws:
        return False
    body = _Body(program, loop)
    if not body.matrices or not body.is_placed_freely():
        return False
    circle = _turned(body) or _placed(body)
    if circle is None:
        return False
    count = poly(loop.count, {}, body.rebound)
    sweep = circle.slope * count
    part = body.part
    if circle.inner:
        part = form("transform", part, product(circle.inner), span=part.span)
    copies = body.copies(part)
    new = _ring_form(loop, copies, circle, sweep)
    if new is None or (copies.head == "lambda" and _is_forced(circle, new)):
        return False
    new.trivia = loop.body[-1].trivia if node.head == "for/union" else new.trivia
    return accept(node, new)


def _is_forced(circle: _Circle, ring: CodeTree) -> bool:
    """Return whether a ring says less than the loop: without a radius, or in the other direction."""
    return is_zero(circle.radius) or len(ring.operands) > 6


def _ring_form(loop: _Loop, copies: CodeTree, circle: _Circle, sweep: Poly) -> CodeTree | None:
    span = loop.node.span
    items = [loop.count, copies]
    if not (circle.radius.is_number and circle.radius.value == 1):
        items += [keyword("radius", span), circle.radius]
    start = expression(circle.start, loop.node)
    turn = Poly({(("pi", 1),): 2}, {"pi": symbol("pi", span)})
    swept = symbol("tau", span) if sweep.equals(turn) else expression(sweep, loop.node)
    if start is None or swept is None:
        return None
    if sweep.equals(-turn):
        swept = form("-", symbol("tau", span), span=span)
    if not is_zero(start):
        items += [keyword("start", span), start]
    if swept.name != "tau":
        items += [keyword("sweep", span), swept]
    if not circle.turns:
        items += [keyword("turn", span), atom(False, span)]
    return form("ring", *items, span=span)


def _turned(body: _Body) -> _Circle | None:
    """Recognise parts that are rotated about the y axis."""
    turn, *rest = body.matrices
    if turn.head != "rotate" or len(turn.operands) not in (2, 3) or not _is_axis(turn.operands[1], 1):
        return None
    if len(turn.operands) == 3 and not _is_origin(turn.operands[2]):
        return None
    angle = body.linear(turn.operands[0])
    if angle is None or not angle[0].terms:
        return None
    radius = atom(0, turn.span)
    vector = vector_of(rest[0]) if rest else None
    if vector is not None and not is_zero(vector[0]):
        return None  # the radius would be hidden in the part
    if vector is not None and is_zero(vector[0]) and not is_zero(vector[2]) and not body.depends(vector[2]):
        if not (set(names(vector[2])) & set(body.values)):
            radius = vector[2]
            lifted = array([atom(0, turn.span), vector[1], atom(0, turn.span)], turn.span)
            rest = [form("translate", lifted, span=turn.span), *rest[1:]] if not is_zero(vector[1]) else rest[1:]
    return _Circle(radius, angle[1], angle[0], True, rest)


def _placed(body: _Body) -> _Circle | None:
    """Recognise parts whose x and z are the cosine and sine of an angle."""
    vector = vector_of(body.matrices[0])
    if vector is None:
        return None
    first, second = _polar(body, vector[0]), _polar(body, vector[2])
    if first is None or second is None or {first[0], second[0]} != {"sin", "cos"}:
        return None
    if not first[1].equals(second[1]) or not first[2].equals(second[2]):
        return None
    angle = body.linear(first[3])
    radius = _radius(vector[0], body, first[1]) or expression(first[1], vector[0])
    if angle is None or not angle[0].terms or radius is None:
        return None
    slope, offset = angle
    turns, inner = False, body.matrices[1:]
    if first[0] == "cos":
        quarter = Poly({(("pi", 1),): 0.5}, {"pi": symbol("pi", vector[0].span)})
        slope, offset = -slope, quarter - offset
    turned = body.linear(inner[0].operands[0]) if inner and _is_turn(inner[0]) else None
    if turned is not None and turned[0].equals(slope):
        turns = True
        more = expression(turned[1] - offset, vector[0])
        if more is None:
            return None
        about = form("rotate", more, copied(inner[0].operands[1]), span=more.span)
        inner = inner[1:] if is_zero(more) else [about, *inner[1:]]
    if not is_zero(vector[1]):
        span = vector[1].span
        inner = [form("translate", array([atom(0, span), vector[1], atom(0, span)], span), span=span), *inner]
    return _Circle(radius, offset, slope, turns, inner)


def _is_turn(matrix: CodeTree) -> bool:
    return matrix.head == "rotate" and len(matrix.operands) == 2 and _is_axis(matrix.operands[1], 1)


def _polar(body: _Body, node: CodeTree) -> tuple[str, Poly, Poly, CodeTree] | None:
    """Read ``radius * cos(angle)``: the function, the radius, the angle as polynomial and as expression."""
    value = body.poly(node)
    if len(value.terms) != 1:
        return None
    ((key, number),) = value.terms.items()
    waves = [(text, power) for text, power in key if value.atoms[text].head in ("sin", "cos")]
    if len(waves) != 1 or waves[0][1] != 1:
        return None
    wave = value.atoms[waves[0][0]]
    if len(wave.operands) != 1 or wave.head is None:
        return None
    rest = Poly({tuple(pair for pair in key if pair != waves[0]): number}, value.atoms)
    if any(body.depends(rest.atoms[text]) for text, _ in next(iter(rest.terms))):
        return None
    return wave.head, rest, body.poly(wave.operands[0]), wave.operands[0]


def _radius(coordinate: CodeTree, body: _Body, value: Poly) -> CodeTree | None:
    """Return the radius as it is written in ``(* radius (cos angle))``."""
    operands = coordinate.operands if coordinate.head == "*" and len(coordinate.operands) == 2 else []
    radius = next((one for one in operands if body.poly(one).equals(value)), None)
    return radius if radius is not None and not set(names(radius)) & set(body.values) else None


def _is_axis(node: CodeTree, axis: int) -> bool:
    values = _numbers(node)
    return values is not None and all((value == 1) if k == axis else (value == 0) for k, value in enumerate(values))


def _is_origin(node: CodeTree) -> bool:
    return _numbers(node) in ([0, 0, 0], [0.0, 0.0, 0.0])


def _numbers(node: CodeTree) -> list[float] | None:
    items = node.items if node.is_array else None
    if items is None or len(items) != 3 or not all(item.is_number for item in items):
        return None
    return [item.value for item in items]


# --- loops over an index, and grids ----------------------------------------------------------------------------------


def _index_loops(program: OpenProgram, node: CodeTree) -> bool:
    """Write a loop over an index that is divided into row and column as two loops."""
    loop = _loop_of(node)
    if loop is None or len(loop.body) < 2 or not {"floor/", "//", "%"} <= program.known:
        return False
    first = loop.body[0]
    division = _divided(loop, first) or (_divided_apart(loop, *loop.body[:2]) if len(loop.body) > 2 else None)
    if division is None:
        return False
    row, column, divisor, used = division
    rows = _quotient(loop.count, divisor)
    rest = loop.body[used:]
    if rows is None or any(loop.variable in names(statement) for statement in rest):
        return False
    span = node.span
    clauses = [
        listed([symbol(row, span), _counted(rows)], span),
        listed([symbol(column, span), _counted(divisor)], span),
    ]
    new = form("for*/union", listed(clauses, span), *rest, span=span)
    return accept(node, new)


def _counted(count: CodeTree) -> CodeTree:
    """Return a sequence of as many integers: an integer is one by itself."""
    return copied(count) if type(count.value) is int else form("range", copied(count), span=count.span)


def _divided(loop: _Loop, first: CodeTree) -> tuple[str, str, CodeTree, int] | None:
    operands = first.operands
    if first.head != "define-values" or len(operands) != 2 or operands[1].head != "floor/":
        return None
    targets = operands[0].items or []
    dividend = operands[1].operands
    if len(targets) != 2 or len(dividend) != 2 or dividend[0].name != loop.variable:
        return None
    row, column = (target.name for target in targets)
    return (row, column, dividend[1], 1) if row and column and row != column else None


def _divided_apart(loop: _Loop, first: CodeTree, second: CodeTree) -> tuple[str, str, CodeTree, int] | None:
    parts: dict[str, tuple[str, CodeTree]] = {}
    for statement in (first, second):
        if statement.head != "define" or len(statement.operands) != 2 or statement.operands[0].name is None:
            return None
        value = statement.operands[1]
        if value.head not in ("//", "%", "quotient", "modulo") or len(value.operands) != 2:
            return None
        if value.operands[0].name != loop.variable:
            return None
        parts["row" if value.head in ("//", "quotient") else "column"] = statement.operands[0].name, value.operands[1]
    if len(parts) != 2 or not same(parts["row"][1], parts["column"][1]):
        return None
    return parts["row"][0], parts["column"][0], parts["row"][1], 2


def _quotient(count: CodeTree, divisor: CodeTree) -> CodeTree | None:
    """Return how often a divisor goes into a count, if it surely does without a rest."""
    if type(count.value) is int and type(divisor.value) is int and divisor.value > 0:
        return atom(count.value // divisor.value, count.span) if count.value % divisor.value == 0 else None
    if count.head == "*" and divisor.name is not None and len(count.operands) == 2:
        others = [operand for operand in count.operands if operand.name != divisor.name]
        if len(others) == 1 and (others[0].name is not None or type(others[0].value) is int):
            return others[0]
    return None


def _line(program: OpenProgram, node: CodeTree) -> bool:
    """Write a loop whose parts are spaced evenly about the origin along one axis as a grid."""
    loop = _loop_of(node)
    return loop is not None and _gridded(program, node, [(loop.variable, loop.count)], loop)


def _grid(program: OpenProgram, node: CodeTree) -> bool:
    """Write nested loops whose parts are spaced evenly about the origin as a grid."""
    clauses = node.operands[0].items if node.operands else None
    if clauses is None or len(clauses) not in (2, 3):
        return False
    counts: list[tuple[str, CodeTree]] = []
    for clause in clauses:
        count = _count(clause.items[1]) if clause.items and len(clause.items) == 2 else None
        name = clause.items[0].name if clause.items else None
        if count is None or name is None:
            return False
        counts.append((name, count))
    if any(name in names(count) for name, _ in counts for _, count in counts):
        return False
    loop = _Loop(counts[-1][1], counts[-1][0], node.operands[1:], node)
    return _gridded(program, node, counts, loop)


def _gridded(program: OpenProgram, node: CodeTree, counts: Sequence[tuple[str, CodeTree]], loop: _Loop) -> bool:
    """Write a loop whose parts are spaced evenly along one to three axes as a ``grid``."""
    if "grid" not in program.known or program.is_blocks:
        return False
    # nested loops evaluate an inner count for each outer index, a grid only once
    if not all(program.effects(count).is_pure for _, count in counts):
        return False
    body = _Body(program, loop)
    vector = vector_of(body.matrices[0]) if body.matrices else None
    if vector is None or not body.is_placed_freely():
        return False
    axes = _axes(body, vector, counts)
    if axes is None:
        return False
    rest = _without_axes(vector, axes)
    inner = [*([rest] if rest is not None else []), *body.matrices[1:]]
    part = form("transform", body.part, product(inner), span=node.span) if inner else body.part
    copies = _grid_copies(program, body, part, axes, counts)
    spacing = _spacing(axes, node)
    if copies is None or spacing is None:
        return False
    span = node.span
    items = [copies]
    for axis, (_, count, _) in sorted(axes.items()):
        items += [keyword(["nx", "ny", "nz"][axis], span), copied(count)]
    if not (spacing.is_number and spacing.value == 1):
        items += [keyword("spacing", span), spacing]
    return accept(node, form("grid", *items, span=span))


_Axes = dict[int, tuple[str, CodeTree, Poly]]
_ORDER = (1, 2, 0)  # a grid's loops from the outermost: y, z, x


def _axes(body: _Body, vector: Sequence[CodeTree], counts: Sequence[tuple[str, CodeTree]]) -> _Axes | None:
    """Return the variable, count and spacing of each axis along which copies are centered."""
    axes: _Axes = {}
    for axis, coordinate in enumerate(vector):
        used = [(name, count) for name, count in counts if _mentions(body, coordinate, name)]
        if not used:
            continue
        if len(used) > 1:
            return None
        name, count = used[0]
        spacing = _centered(body, coordinate, name, count)
        if spacing is None:
            return None
        axes[axis] = name, count, spacing
    order = [axes[axis][0] for axis in _ORDER if axis in axes]
    return axes if order == [name for name, _ in counts] else None


def _mentions(body: _Body, node: CodeTree, name: str) -> bool:
    return name in names(node) or any(
        _mentions(body, body.values[one], name) for one in names(node) if one in body.values
    )


def _centered(body: _Body, coordinate: CodeTree, name: str, count: CodeTree) -> Poly | None:
    """Return the spacing of a coordinate that is ``spacing * (i - (count - 1) / 2)``."""
    value = body.poly(coordinate)
    linear = value.split(name, lambda node: _mentions(body, node, name))
    if linear is None or not linear[0].terms:
        return None
    slope, offset = linear
    half = (poly(count, {}, body.rebound) - Poly.number(1)) * Poly.number(0.5)
    if not (offset + slope * half).equals(Poly({}, {})):
        return None
    return slope


def _without_axes(vector: Sequence[CodeTree], axes: _Axes) -> CodeTree | None:
    """Return the translation that remains beside a grid's."""
    span = vector[0].span
    kept = [atom(0, span) if axis in axes else coordinate for axis, coordinate in enumerate(vector)]
    return None if all(map(is_zero, kept)) else form("translate", array(kept, span), span=span)


def _grid_copies(
    program: OpenProgram, body: _Body, part: CodeTree, axes: _Axes, counts: Sequence[tuple[str, CodeTree]]
) -> CodeTree | None:
    statements = body._needed(part)
    free = not any(_mentions(body, part, name) for name, _ in counts)
    if free and not statements and program.effects(part).is_pure:
        return part
    span = part.span
    used = [axes[axis][0] if axis in axes else "_" for axis in range(3)]
    parameters = listed([symbol(name, span) for name in used], span)
    return form("lambda", parameters, *statements, part, span=span)


def _spacing(axes: _Axes, like: CodeTree) -> CodeTree | None:
    spacings = {axis: expression(spacing, like) for axis, (_, _, spacing) in axes.items()}
    if any(spacing is None for spacing in spacings.values()):
        return None
    known = {axis: spacing for axis, spacing in spacings.items() if spacing is not None}
    first = next(iter(known.values()))
    if all(same(first, spacing) for spacing in known.values()):
        return first
    return array([known.get(axis) or atom(0, like.span) for axis in range(3)], like.span)


# --- parts that are aligned by their boxes -------------------------------------------------------------------------

_SIDES = {"compute-shape-min": "min", "compute-shape-max": "max"}


def align(program: OpenProgram, top: CodeTree) -> bool:
    """Write a translation by the distance between two boxes as ``align``."""
    if "align" not in program.known or program.is_blocks or not any(name in _SIDES for name in names(top)):
        return False
    changed = False
    for node, start in bodies(top):
        boxes = _box_variables(node, start)
        for one in code(node):
            if one.head == "transform" and len(one.operands) == 2:
                changed |= _align(one, boxes)
    return changed


_Box = tuple[str, int, CodeTree]  # side, axis and object


def _box_variables(node: CodeTree, start: int) -> dict[str, _Box]:
    variables: dict[str, _Box] = {}
    for statement in (node.items or [])[start:]:
        operands = statement.operands
        if statement.head == "define" and len(operands) == 2 and operands[0].name is not None:
            box = _box(operands[1], {})
            if box is not None:
                variables[operands[0].name] = box
        elif statement.head == "define-values" and len(operands) == 2 and operands[1].head in _SIDES:
            for axis, target in enumerate(operands[0].items or ()):
                if target.name not in (None, "_"):
                    variables[str(target.name)] = _SIDES[operands[1].head or ""], axis, operands[1].operands[0]
    return variables


def _box(node: CodeTree, boxes: dict[str, _Box]) -> _Box | None:
    if node.name is not None:
        return boxes.get(node.name)
    if node.head not in ("x-of", "y-of", "z-of") or len(node.operands) != 1:
        return None
    inner = node.operands[0]
    if inner.head not in _SIDES or len(inner.operands) != 1:
        return None
    return _SIDES[inner.head or ""], "xyz".index(node.head[0]), inner.operands[0]


_ALIGNMENTS = {("max", "min"): "after", ("min", "max"): "before", ("min", "min"): "min", ("max", "max"): "max"}


def _align(node: CodeTree, boxes: dict[str, _Box]) -> bool:
    """Write a translation as ``align`` if its coordinates are distances between the boxes of the same two parts."""
    part, matrix = node.operands
    vector = vector_of(matrix)
    if vector is None or part.name is None:
        return False
    target: CodeTree | None = None
    aligned: list[tuple[str, str]] = []
    for axis, coordinate in enumerate(vector):
        if is_zero(coordinate):
            continue
        if coordinate.head != "-" or len(coordinate.operands) != 2:
            return False
        to, of = (_box(operand, boxes) for operand in coordinate.operands)
        if to is None or of is None or to[1] != axis or of[1] != axis or not same(of[2], part):
            return False
        if target is not None and not same(target, to[2]):
            return False
        target = to[2]
        aligned.append(("xyz"[axis], _ALIGNMENTS[to[0], of[0]]))
    if target is None or target.name is None or target.name == part.name:
        return False
    span = node.span
    keys = [key for axis, side in aligned for key in (keyword(axis, span), keyword(side, span))]
    return accept(node, form("align", part, copied(target), *keys, span=span))
