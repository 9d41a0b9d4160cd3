"""Blocks: the statements of a body as definitions, effects, and the pieces of collected lists."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from scenelang.interpreter.transpile.analysis.collect import PURE, Collection, Effect
from scenelang.interpreter.transpile.analysis.scopes import PythonVariable
from scenelang.interpreter.transpile.writing.code import (
    Brackets,
    Code,
    FormCode,
    Name,
    VariableRef,
    count_refs,
    form,
    is_form,
    move_comments,
    none,
    quote,
    replace,
    returns_parts,
    walk,
)


@dataclass(eq=False, slots=True)
class BlockItem:
    """Item of a block.

    Attributes
    ----------
    kind
        ``define`` (``target`` is a variable or a pattern), ``function`` (``value`` is the whole definition) or
        ``effect``.
    value, effect
        Code and its side effects.
    variables, target
        Variables that it defines, and their pattern.
    note
        Carrier of its comments.
    nested
        Number of definitions inlined into it.
    exits
        Whether the code after it is unreachable.
    """

    kind: str
    value: Code
    effect: Effect
    variables: tuple[PythonVariable, ...] = ()
    target: Code | None = None
    note: Code = field(default_factory=lambda: Code(None))
    nested: int = 0
    exits: bool = False

    def mentions(self, variable: PythonVariable) -> bool:
        return any(type(node) is VariableRef and node.variable is variable for node in walk(self.value))


@dataclass(eq=False, slots=True)
class CollectedPiece:
    """Addition of one statement to a list: one item, or (``is_many``) a list of items."""

    code: Code
    is_many: bool
    effect: Effect
    mentions: set[PythonVariable] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.update_mentions()

    def update_mentions(self) -> None:
        self.mentions = {node.variable for node in walk(self.code) if type(node) is VariableRef}


@dataclass(eq=False, slots=True)
class Collecting:
    """List that is being collected.

    ``as_union`` is set if its shapes are only combined, so that its value may be parts.
    """

    collection: Collection
    as_union: bool
    is_mutated: bool
    pieces: list[CollectedPiece] = field(default_factory=list)
    note: Code = field(default_factory=lambda: Code(None))

    def combined(self) -> Code:
        """Return the whole list, or parts."""
        return combine_union(self.pieces) if self.as_union else combine_list(self.pieces)


def combine_union(pieces: Sequence[CollectedPiece]) -> Code:
    """Combine pieces into one ``union``; a single shape needs none."""
    if len(pieces) == 1 and _is_one(pieces[0]):
        return pieces[0].code
    items: list[Code] = []
    for piece in pieces:
        if is_form(piece.code, "union") and isinstance(piece.code, FormCode) and not piece.code.after:
            inner = piece.code.items[1:]
            if inner:
                move_comments(piece.code, inner[0])
                items += inner
                continue
        items.append(piece.code)
    return form("union", *items)


def _is_one(piece: CollectedPiece) -> bool:
    """Return whether a piece can be used without a ``union``; branches of an ``if`` are unions already."""
    return not piece.is_many or returns_parts(piece.code) or is_form(piece.code, "if") or is_form(piece.code, "cond")


def combine_list(pieces: Sequence[CollectedPiece]) -> Code:
    """Combine pieces into one list."""
    if not pieces:
        return quote(FormCode([]))
    if all(not piece.is_many for piece in pieces):
        return form("list", *(piece.code for piece in pieces))
    lists: list[Code] = []
    for piece in pieces:
        if piece.is_many:
            lists.append(piece.code)
        elif lists and is_form(lists[-1], "list") and isinstance(lists[-1], FormCode):
            lists[-1].items.append(piece.code)
        else:
            lists.append(form("list", piece.code))
    return lists[0] if len(lists) == 1 else form("append", *lists)


class Block:
    """Items of a block in order, and the lists that are being collected in it."""

    def __init__(self) -> None:
        self.items: list[BlockItem] = []
        self.collecting: list[Collecting] = []
        self._nested = 0

    # --- additions ---------------------------------------------------------------------------------------------

    def add(self, item: BlockItem) -> None:
        """Append an item; pieces that cannot be reordered with it are named first."""
        for collecting in self.collecting:
            self._preserve_order(collecting, item)
        self.items.append(item)

    def add_effect(self, value: Code, effect: Effect, note: Code | None = None, exits: bool = False) -> None:
        self.add(BlockItem("effect", value, effect, note=note or Code(None), exits=exits))

    @property
    def has_exited(self) -> bool:
        """Whether the end of the block is unreachable."""
        return bool(self.items) and self.items[-1].exits

    def add_piece(self, collecting: Collecting, piece: CollectedPiece) -> None:
        """Add a piece of a list, whose evaluation is deferred unless its effects do not commute with those of other
        lists."""
        for other in self.collecting:
            if other is not collecting and any(not piece.effect.commutes(p.effect) for p in other.pieces):
                self.name_pieces(other)
        collecting.pieces.append(piece)

    def _preserve_order(self, collecting: Collecting, item: BlockItem) -> None:
        """Preserve the order of the pieces so far and of an item that follows them."""
        pieces = collecting.pieces
        for variable in item.variables:
            if not any(variable in piece.mentions for piece in pieces):
                continue
            if not item.mentions(variable) and self._inline_into(pieces, variable, item):
                continue
            if not self._rename_last(variable, item):
                self.name_pieces(collecting)
                return
        if item.effect != PURE and any(not piece.effect.commutes(item.effect) for piece in pieces):
            self.name_pieces(collecting)

    def _inline_into(self, pieces: list[CollectedPiece], variable: PythonVariable, new: BlockItem) -> bool:
        """Inline a redefined variable: ``x = a; xs.append(x); x = b`` appends ``a``.

        ``new`` is the item that follows the pieces. Returns whether inlining was possible.
        """
        users = [piece for piece in pieces if variable in piece.mentions]
        position = self._last_definition(variable)
        if position is None or len(users) != 1 or count_refs(users[0].code, variable) != 1:
            return False
        item = self.items[position]
        if any(variable in piece.mentions for piece in self._pieces() if piece is not users[0]):
            return False
        if _changes_meaning([new], item.value):
            return False
        if not self._may_move(position, users[0].code, users[0].effect, pieces[: pieces.index(users[0])]):
            return False
        move_comments(item.note, item.value)
        if type(users[0].code) is VariableRef:
            move_comments(users[0].code, item.value)
            users[0].code = item.value
        else:
            replace(users[0].code, lambda node: type(node) is VariableRef and node.variable is variable, item.value)
        users[0].effect = users[0].effect | item.effect
        users[0].update_mentions()
        del self.items[position]
        return True

    def _rename_last(self, variable: PythonVariable, item: BlockItem) -> bool:
        """Give the value that ``item`` replaces its own variable, as for ``xs.append(x); x = x + 1; xs.append(x)``."""
        position = self._last_definition(variable)
        if position is None or variable.is_cell or item.kind != "define":
            return False
        earlier = PythonVariable(variable.name, variable.function)
        defining = self.items[position]
        defining.target, defining.variables = VariableRef(earlier), (earlier,)
        pieces = self._pieces()
        readers = [item.value, *(i.value for i in self.items[position + 1 :]), *(piece.code for piece in pieces)]
        for node in walk(*readers):
            if type(node) is VariableRef and node.variable is variable:
                node.variable = earlier
        for piece in pieces:
            piece.update_mentions()
        return True

    def name_pieces(self, collecting: Collecting) -> None:
        """Evaluate the pieces so far at this point, bound to a temporary variable."""
        if not collecting.pieces or (len(collecting.pieces) == 1 and type(collecting.pieces[0].code) is VariableRef
                                     and collecting.pieces[0].code.variable.is_temporary):  # fmt: skip
            return
        original = collecting.collection.variable
        variable = PythonVariable(original.name, None, is_temporary=True)
        effect = total(piece.effect for piece in collecting.pieces)
        single = len(collecting.pieces) == 1 and not collecting.pieces[0].is_many
        value = collecting.pieces[0].code if single else collecting.combined()
        self.items.append(BlockItem("define", value, effect, (variable,), VariableRef(variable)))
        collecting.pieces = [CollectedPiece(VariableRef(variable), not single, PURE)]

    # --- definitions -------------------------------------------------------------------------------------------

    def _last_definition(self, variable: PythonVariable) -> int | None:
        for position in range(len(self.items) - 1, -1, -1):
            item = self.items[position]
            if variable in item.variables:
                return (
                    position
                    if item.kind == "define" and item.variables == (variable,) and type(item.target) is VariableRef
                    else None
                )
        return None

    def _pieces(self) -> list[CollectedPiece]:
        return [piece for collecting in self.collecting for piece in collecting.pieces]

    def _may_move(self, position: int, code: Code, own: Effect, pieces: Sequence[CollectedPiece]) -> bool:
        """Return whether the definition at ``position`` can be inlined into ``code``.

        ``code`` follows all items and ``pieces``, has the effect ``own`` and mentions the variable once.
        """
        item = self.items[position]
        (variable,) = item.variables
        later = self.items[position + 1 :]
        if any(i.mentions(variable) for i in later) or _changes_meaning(later, item.value):
            return False
        if not may_replace(code, variable, item.effect, own):
            return False
        effects = [*(i.effect for i in later), *(piece.effect for piece in pieces)]
        return all(item.effect.commutes(effect) for effect in effects)

    def define(self, variable: PythonVariable, value: Code, effect: Effect, note: Code, nests: bool = True) -> None:
        """Add ``x = value``; the previous value of ``x`` is inlined if ``value`` uses it once."""
        if nests:
            effect, note = self._inline_previous(variable, value, effect, note)
        self.add(BlockItem("define", value, effect, (variable,), VariableRef(variable), note, self._nested))
        self._nested = 0

    def _inline_previous(
        self, variable: PythonVariable, value: Code, effect: Effect, note: Code
    ) -> tuple[Effect, Code]:
        position = self._last_definition(variable)
        if position is None or type(value) is VariableRef or count_refs(value, variable) != 1:
            return effect, note
        item = self.items[position]
        if item.nested >= _MAX_NESTING:
            return effect, note
        pieces = self._pieces()
        if any(variable in piece.mentions for piece in pieces) or not self._may_move(position, value, effect, pieces):
            return effect, note
        move_comments(item.note, note)
        if position + 1 < len(self.items):  # the name of its first definition keeps its place among the others
            note.blank = note.blank and item.note.blank
        replace(value, lambda node: type(node) is VariableRef and node.variable is variable, item.value)
        del self.items[position]
        self._nested = item.nested + 1
        return item.effect | effect, note


def _changes_meaning(items: Sequence[BlockItem], value: Code) -> bool:
    """Return whether ``value`` would refer to variables that ``items`` define."""
    new = {variable for item in items for variable in item.variables}
    return any(type(node) is VariableRef and node.variable in new for node in walk(value))


def total(effects: Iterable[Effect]) -> Effect:
    result = PURE
    for effect in effects:
        result = result | effect
    return result


_MAX_NESTING = 8  # longer chains of x = f(x) are more readable as let*
# Heads of forms that may evaluate their operands more than once or not at all.
_REPEATED = ("lambda", "define", "while", "let/ec", "guard", "union-loop")
_CONDITIONAL = ("if", "and", "or", "when", "unless", "cond")


def may_replace(code: Code, variable: PythonVariable, effect: Effect, own: Effect) -> bool:
    """Return whether a value with ``effect`` can replace the only mention of ``variable`` in ``code``.

    It must be evaluated exactly once; if it has effects or reads mutable state, it must always be evaluated and in the
    same order. ``own`` is the effect of ``code``.
    """
    if type(code) is VariableRef:
        return True
    is_ordered = effect.has_effect or effect.inspects or bool(effect.reads)
    if is_ordered and not effect.commutes(own) and not _comes_first(code, variable):
        return False
    stack = [code]
    while stack:
        node = stack.pop()
        if type(node) is VariableRef and node.variable is variable:
            return True
        if type(node) is Brackets:
            stack += node.items
        elif type(node) is FormCode:
            head = node.items[0].text if node.items and type(node.items[0]) is Name else ""
            if head in _REPEATED or head.startswith("for"):
                if head.startswith("for") and len(node.items) > 1 and _in_first_clause(node.items[1], variable):
                    return True
            elif head in _CONDITIONAL and is_ordered:
                stack += node.items[1:2] if head != "cond" else []
            else:
                stack += node.items
    return False


def _comes_first(code: Code, variable: PythonVariable) -> bool:
    """Return whether ``code`` reads ``variable`` before any other effect or read of mutable state."""
    node: Code | None = code
    while node is not None and type(node) is not VariableRef:
        if type(node) is Brackets:
            operands = node.items
        elif type(node) is FormCode and node.items and type(node.items[0]) is Name:
            if node.items[0].text in (*_REPEATED, "cond", "let", "let*") or node.items[0].text.startswith("for"):
                return False
            operands = node.items[1:]
        else:
            return False
        node = next((item for item in operands if type(item) in (VariableRef, FormCode, Brackets)), None)
    return type(node) is VariableRef and node.variable is variable


def _in_first_clause(clauses: Code, variable: PythonVariable) -> bool:
    """Return whether ``variable`` is in the sequence of a loop's first clause, which is evaluated once."""
    first = clauses.items[0] if isinstance(clauses, FormCode) and clauses.items else None
    if not isinstance(first, FormCode) or len(first.items) != 2:
        return False
    return may_replace(first.items[1], variable, PURE, PURE) if count_refs(first.items[1], variable) else False


# --- bodies ----------------------------------------------------------------------------------------------------


def assemble(items: list[BlockItem], final: Code | None) -> list[Code]:
    """Return the forms of a body. Names that are defined again become ``let*``."""
    items = list(items)
    final = _tail_value(items, final)
    return _frame(items, final)


def _tail_value(items: list[BlockItem], final: Code | None) -> Code | None:
    """Simplify ``(define x v) x`` to ``v``, and ``(define x v) effects x`` to ``(begin0 v effects)``."""
    if type(final) is not VariableRef:
        return final
    variable = final.variable
    position = len(items) - 1
    while position >= 0 and items[position].kind == "effect" and variable.is_temporary:
        position -= 1
    if position < 0 or items[position].variables != (variable,) or items[position].kind != "define":
        return final
    item = items[position]
    if type(item.target) is not VariableRef or variable.is_cell:
        return final
    effects = items[position + 1 :]
    if any(effect.mentions(variable) for effect in effects):
        return final
    move_comments(item.note, item.value)
    move_comments(final, item.value)
    del items[position:]
    if not effects:
        return item.value
    return form("begin0", item.value, *(_with_note(e.value, e.note) for e in effects))


def _with_note(code: Code, note: Code) -> Code:
    move_comments(note, code)
    return code


def _frame(items: list[BlockItem], final: Code | None) -> list[Code]:
    conflict = _first_conflict(items)
    if conflict is None:
        forms = [_body_form(item) for item in items]
        if final is None and (not items or items[-1].kind != "effect"):
            final = none()  # a body must end with an expression
        return [*forms, *([final] if final is not None else [])]
    start, _ = conflict
    end = start
    while end < len(items) and items[end].kind == "define":
        end += 1
    before = [_body_form(item) for item in items[:start]]
    if start == end:  # a function whose name is already defined
        return [*before, form("let", FormCode([]), *_frame(items[start:], final))]
    bindings = FormCode([_with_note(FormCode([_target(item), item.value]), item.note) for item in items[start:end]])
    body = _frame(items[end:], final)
    head = "let*" if len(bindings.items) > 1 else "let"
    result = FormCode([Name(head), bindings, *body])
    first = bindings.items[0]
    result.before, first.before = first.before, ()
    result.blank, first.blank = first.blank, False
    return [*before, result]


def _first_conflict(items: list[BlockItem]) -> tuple[int, int] | None:
    """Return the position where a ``let*`` must start, and that of the item that requires it."""
    defined: dict[PythonVariable, int] = {}
    mentioned: set[PythonVariable] = set()
    for position, item in enumerate(items):
        own = {node.variable for node in walk(item.value) if type(node) is VariableRef}
        for variable in item.variables:
            reads_outer = item.kind == "define" and variable in own
            was_mentioned = variable in mentioned and (variable.is_parameter or len(variable.stores) > 1)
            if variable in defined or reads_outer or was_mentioned:
                start = defined.get(variable, position)
                if any(i.kind != "define" for i in items[start:position]):
                    start = position
                return start, position
        for variable in item.variables:
            defined[variable] = position
        mentioned |= own
    return None


def _target(item: BlockItem) -> Code:
    assert item.target is not None
    return item.target


def _body_form(item: BlockItem) -> Code:
    if item.kind == "define":
        target = _target(item)
        head = "define" if type(target) is VariableRef else "define-values"
        return _with_note(form(head, target, item.value, span=item.value.span), item.note)
    return _with_note(item.value, item.note)
