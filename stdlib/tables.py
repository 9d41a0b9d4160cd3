"""Tables and sets: making them, and asking them."""

from __future__ import annotations

from typing import Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.runtime import Runtime
from scenelang.interpreter.runtime.types import Registry, type_name
from scenelang.interpreter.runtime.values import NIL, Embedding, Keyword, Pair, Set, Symbol, Table, make_list, table_key
from scenelang.stdlib.lists import blocks, items, length, wrong_type
from scenelang.stdlib.mutation import set_entry

registry = Registry("tables")

Entries = dict[Any, tuple[Any, Any]]


# --- tables ----------------------------------------------------------------------------------------------------


@registry.define("table", "keys-and-values::Any ...", "Table",
                 "A table from keys to values, written one after the other. Keys compare by value; the order of "
                 "insertion is kept.",
                 ('(ref (table "oak" 3 "ash" 5) "ash")', "5"))  # fmt: skip
def table(rt: Runtime, *keys_and_values: Any) -> Any:
    if len(keys_and_values) % 2:
        count = len(keys_and_values)
        message = f"`table` wants a value after every key, got {count} argument{'s' if count > 1 else ''}"
        raise SceneError("arity", message, hint='`(table "a" 1 "b" 2)`')
    entries: Entries = {}
    for index in range(0, len(keys_and_values), 2):
        set_entry(rt, entries, keys_and_values[index], keys_and_values[index + 1])
    return rt.table_of(entries)


@registry.define("list->table", "pairs::Sequence", "Table",
                 "A table from a list of pairs (key . value) or of lists (key value).",
                 ("(list->table '((\"a\" . 1) (\"b\" 2)))", '(table "a" 1 "b" 2)'))  # fmt: skip
def list_to_table(rt: Runtime, pairs: Any) -> Any:
    entries: Entries = {}
    for pair in items(rt, pairs, "list->table"):
        rt.charge(1)
        set_entry(rt, entries, *_key_and_value(rt, pair))
    return rt.table_of(entries)


def _key_and_value(rt: Runtime, pair: Any) -> tuple[Any, Any]:
    if type(pair) is Pair and type(pair.cdr) is not Pair and pair.cdr is not NIL:
        return pair.car, pair.cdr
    members = items(rt, pair, "list->table")
    if len(members) != 2:
        raise wrong_type("list->table", "pairs (key . value) or lists (key value)", pair)
    return members[0], members[1]


@registry.define("table-keys", "table::Table", "List", "The keys, in order of insertion.",
                 ('(table-keys (table "a" 1 "b" 2))', '("a" "b")'))  # fmt: skip
def table_keys(rt: Runtime, table: Table) -> Any:
    return make_list(items(rt, table))


@registry.define("table-values", "table::Table", "List", "The values, in order of insertion.",
                 ('(table-values (table "a" 1 "b" 2))', "(1 2)"))  # fmt: skip
def table_values(rt: Runtime, table: Table) -> Any:
    return make_list([value for _, value in _entries(rt, table)])


@registry.define("table-items", "table::Table", "List", "The lists (key value), in order of insertion.",
                 ('(table-items (table "a" 1 "b" 2))', '(("a" 1) ("b" 2))'))  # fmt: skip
def table_items(rt: Runtime, table: Table) -> Any:
    entries = _entries(rt, table)
    return make_list([make_list(entry) for block in blocks(rt, entries) for entry in block])


def _entries(rt: Runtime, table: Table) -> list[tuple[Any, Any]]:
    rt.read(table)
    rt.charge(len(table.entries) >> 1)
    return list(table.entries.values())


@registry.define("table-merge", "table::Table more::Table ...", "Table",
                 "A new table with the entries of all; later tables win.",
                 ('(table-merge (table "a" 1 "b" 2) (table "b" 3))', '(table "a" 1 "b" 3)'))  # fmt: skip
def table_merge(rt: Runtime, *tables: Table) -> Any:
    entries: Entries = {}
    for one in tables:
        for block in blocks(rt, _entries(rt, one)):
            for key, value in block:
                set_entry(rt, entries, key, value)
    return rt.table_of(entries)


@registry.define("has-key?", "thing::Any key::Any", "Boolean",
                 "True when a table holds the key, or an embedding the attribute.",
                 ('(has-key? (table "a" none) "a")', "#t"))  # fmt: skip
def has_key(rt: Runtime, thing: Any, key: Any) -> bool:
    if type(thing) is Table:
        rt.read(thing)
        return table_key(key, rt.charge) in thing.entries
    if type(thing) is not Embedding:
        raise wrong_type("has-key?", "a table or an embedding", thing)
    return isinstance(key, str) and str(key) in thing.attributes


@registry.define("keywords", "table::Table", "List",
                 "The entries as keyword arguments, for `apply`: the list (:key value ...).",
                 ('(keywords (table "width" 2 "depth" 1))', "(:width 2 :depth 1)"))  # fmt: skip
def keywords(rt: Runtime, table: Table) -> Any:
    out: list[Any] = []
    for key, value in _entries(rt, table):
        if type(key) not in (str, Symbol, Keyword):
            raise SceneError("type", f"`keywords` wants names for keys, got {type_name(key)}")
        out += (Keyword(key), value)
    return make_list(out)


# --- sets ------------------------------------------------------------------------------------------------------


def _set_of(rt: Runtime, members: list[Any]) -> Any:
    return rt.set_of(_by_key(rt, members))


def _by_key(rt: Runtime, members: list[Any]) -> dict[Any, Any]:
    """The first of all equal members, by canonical key."""
    entries: dict[Any, Any] = {}
    for block in blocks(rt, members):
        for member in block:
            entries.setdefault(table_key(member, rt.charge), member)
    return entries


@registry.define("set", "members::Any ...", "Set",
                 "A set of the arguments; members compare by value, the order of insertion is kept.",
                 ("(set 1 2 1.)", "(set 1 2)"))  # fmt: skip
def set_(rt: Runtime, *members: Any) -> Any:
    return _set_of(rt, list(members))


@registry.define("list->set", "xs::Sequence", "Set", "The set of the items of a sequence.",
                 ("(list->set '(3 1 3))", "(set 3 1)"))  # fmt: skip
def list_to_set(rt: Runtime, xs: Any) -> Any:
    return _set_of(rt, items(rt, xs, "list->set", ordered=False))


def _entry_map(rt: Runtime, name: str, value: Any) -> dict[Any, Any]:
    """Members of a set, or of any sequence, by canonical key."""
    if type(value) is Set:
        rt.read(value)
        rt.charge(len(value.entries) >> 2)
        return dict(value.entries)
    return _by_key(rt, items(rt, value, name, ordered=False))


@registry.define("set-union", "set::Set more::Sequence ...", "Set", "A new set of the members of all.",
                 ("(set-union (set 1 2) (set 2 3))", "(set 1 2 3)"))  # fmt: skip
def set_union(rt: Runtime, first: Any, *more: Any) -> Any:
    entries = _entry_map(rt, "set-union", first)
    for other in more:
        for key, member in _entry_map(rt, "set-union", other).items():
            entries.setdefault(key, member)
        rt.charge(len(entries) >> 4)
    return rt.set_of(entries)


@registry.define("set-intersection", "set::Set more::Sequence ...", "Set", "A new set of the members that all have.",
                 ("(set-intersection (set 1 2 3) (set 2 3 4))", "(set 2 3)"))  # fmt: skip
def set_intersection(rt: Runtime, first: Any, *more: Any) -> Any:
    entries = _entry_map(rt, "set-intersection", first)
    for other in more:
        kept = _entry_map(rt, "set-intersection", other)
        rt.charge(len(entries) >> 4)
        entries = {key: member for key, member in entries.items() if key in kept}
    return rt.set_of(entries)


@registry.define("set-difference", "set::Set more::Sequence ...", "Set",
                 "A new set of the members of the first that no other has.",
                 ("(set-difference (set 1 2 3) (set 2))", "(set 1 3)"))  # fmt: skip
def set_difference(rt: Runtime, first: Any, *more: Any) -> Any:
    entries = _entry_map(rt, "set-difference", first)
    for other in more:
        dropped = _entry_map(rt, "set-difference", other)
        rt.charge(len(entries) >> 4)
        entries = {key: member for key, member in entries.items() if key not in dropped}
    return rt.set_of(entries)


@registry.define("subset?", "a::Set b::Sequence", "Boolean", "True when `b` has all members of `a`.",
                 ("(subset? (set 1) (set 1 2))", "#t"))  # fmt: skip
def is_subset(rt: Runtime, a: Any, b: Any) -> bool:
    return length(rt, a) == 0 or _entry_map(rt, "subset?", a).keys() <= _entry_map(rt, "subset?", b).keys()
