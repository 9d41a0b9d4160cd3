"""From the block that a program asks for to a state that the game has (the paper, appendix "Minecraft Renderer")."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from scenelang.backends.minecraft.asked import NAMESPACE, namespaced
from scenelang.backends.minecraft.block_names import alias, nearest, renamed
from scenelang.backends.minecraft.blocks import BlockState
from scenelang.backends.minecraft.old_properties import modern
from scenelang.backends.minecraft.table import BlockKind, Table, load_table
from scenelang.grammar.diagnostics import Diagnostic, suggest
from scenelang.grammar.source import Span

Similar = Callable[[str, Sequence[str]], str | None]  # of the names, that which means most nearly the first text
_MISSPELT = 0.95  # so alike are a name and its misspelling
_LONGEST = 100  # letters of a name that are compared


@dataclass(frozen=True, slots=True)
class Resolved:
    """A state with all of its block's properties. ``given``: those that the program set; the others are defaults."""

    state: BlockState
    given: frozenset[str] = frozenset()
    warnings: tuple[Diagnostic, ...] = ()


def resolve(
    block_type: str,
    properties: Mapping[str, str] | None = None,
    table: Table | None = None,
    similar: Similar | None = None,
    span: Span | None = None,
) -> Resolved:
    """The state of the block ``block_type``, with or without namespace, whose ``properties`` are as given.

    A block that the version does not have becomes, without a word, what the game calls it there; else the nearest one,
    with a warning that names both: an alias, a misspelling, what ``similar`` finds, or the most alike name.
    Properties of earlier versions become what they are today, without a word; what means nothing to the block is left
    out, with a warning. Warnings carry ``span``.
    """
    table = table or load_table()
    name = namespaced(block_type)
    given = dict(properties or {})
    kind = table.blocks.get(name) or _renamed(name, table)
    if kind is not None:
        found = modern(name, kind, given, table)
        return _filled(found.kind, found.given, *(_left_out(found.kind, *pair, span) for pair in found.dropped.items()))
    kind = _nearest(name.partition(":")[2][:_LONGEST], table, similar)
    found = modern(name, kind, given, table)
    dropped = ", ".join(f"{key}={value}" for key, value in given.items() if key in found.dropped)
    without = f", without {dropped}" if dropped else ""
    message = (
        f"Minecraft {table.version} has no block `{name[:_LONGEST]}`; `{found.kind.name}` is laid instead{without}"
    )
    return _filled(found.kind, found.given, Diagnostic("unknown-block", message, span))


def _filled(kind: BlockKind, given: Mapping[str, str], *warnings: Diagnostic) -> Resolved:
    state = BlockState(kind.name, tuple(sorted({**kind.defaults, **given}.items())))
    return Resolved(state, frozenset(given), warnings)


def _renamed(name: str, table: Table) -> BlockKind | None:
    other = renamed(name.removeprefix(NAMESPACE), {known.removeprefix(NAMESPACE) for known in table.blocks})
    return None if other is None else table.blocks[NAMESPACE + other]


def _nearest(name: str, table: Table, similar: Similar | None) -> BlockKind:
    """The block to lay in place of one that there is not: never one for operators."""
    names = [kind.name.removeprefix(NAMESPACE) for kind in table.blocks.values() if not kind.is_for_operators]
    found = alias(name, names)
    if found is None:
        found, likeness = nearest(name, names)
        if similar is not None and likeness < _MISSPELT:
            meant = similar(name.replace("_", " "), names)
            found = meant if meant in names else found
    return table.blocks[NAMESPACE + found]


def _left_out(kind: BlockKind, name: str, value: str, span: Span | None) -> Diagnostic:
    """The warning for a property that the block does not take."""
    if name not in kind.values:
        have = f"it has {_listed(kind.values)}" if kind.values else "it has none"
        message = f"the block `{kind.name}` has no property `{name[:_LONGEST]}`, which is left out; {have}"
        return Diagnostic("block-property", message, span, hint=suggest(name, kind.values))
    values = _listed(kind.values[name], "or")
    message = f"`{name}` of `{kind.name}` is {values}, not `{value[:_LONGEST]}`, which is left out"
    return Diagnostic("block-property", message, span, hint=suggest(value, kind.values[name]))


def _listed(names: Sequence[str] | Mapping[str, object], last: str = "and") -> str:
    shown = [f"`{name}`" for name in names]
    return f" {last} ".join(part for part in (", ".join(shown[:-1]), shown[-1]) if part)
