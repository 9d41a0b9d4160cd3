"""Builtins that modify mutable lists, arrays, tables and sets in place, and builtins for tables and sets."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import Registry, type_name
from scenelang.interpreter.values.values import (
    NIL,
    Embedding,
    Keyword,
    Mutable,
    MutableArray,
    MutableList,
    Pair,
    Set,
    Symbol,
    Table,
    make_list,
    table_key,
)
from scenelang.stdlib.operands import (
    INT64,
    bad_index,
    blocks,
    cannot_change,
    empty_sequence,
    items,
    length,
    reorder,
    to_numpy,
    wrong_type,
)
from scenelang.stdlib.sequences import (
    axis_selection,
    check_index,
    missing_key,
    position_of,
    ref,
    sorted_items,
    to_index,
)

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

registry = Registry("mutation")

_MIN_CHARGED_ITEMS = 1 << 16  # the reallocation of longer lists is charged


def _writable_list(rt: Runtime, name: str, value: Any) -> list[Any]:
    """Return the items of a mutable list, and record that it is modified."""
    if type(value) is not MutableList:
        raise cannot_change(name, value, "a mutable list")
    rt.write(value)
    members: list[Any] = value.items
    return members


def _writable_table(rt: Runtime, name: str, value: Any) -> dict[Any, tuple[Any, Any]]:
    """Return the entries of a table, and record that it is modified."""
    if type(value) is not Table:
        raise cannot_change(name, value, "a table")
    rt.write(value)
    entries: dict[Any, tuple[Any, Any]] = value.entries
    return entries


def _check_growth(rt: Runtime, count: int) -> None:
    """Check that a collection of ``count`` items may get one more."""
    if count > _MIN_CHARGED_ITEMS:
        rt.charge(count >> 16)  # the amortized cost of reallocation
    if count >= rt.limits.size:
        rt.meter.check_size(count + 1, "a list")


# --- assignment ------------------------------------------------------------------------------------------------


def set_entry(rt: Runtime, entries: dict[Any, tuple[Any, Any]], key: Any, value: Any) -> None:
    """Set the value of ``key``; the spelling of an existing key is preserved."""
    canonical = table_key(key, rt.charge)
    old = entries.get(canonical)
    entries[canonical] = (key if old is None else old[0], value)


def set_array(rt: Runtime, array: MutableArray, keys: tuple[Any, ...], value: Any) -> None:
    """Assign a number or an array to the selection of ``keys``."""
    data = array.data
    selection = axis_selection(data.shape, keys, "set-ref!")
    new = to_numpy(rt, value, "set-ref!")
    if data.dtype.kind == "i" and new.dtype.kind == "f":
        rt.charge(new.size >> 4)
        if not all(number.is_integer() and abs(number) < INT64 for number in new.ravel().tolist()):
            hint = "to store Floats, create the array with `(mutable (* 1. array))`"
            raise SceneError("type", f"`set-ref!` expects Integers for this array, got {show(value, 60)}", hint=hint)
    rt.write(array)
    rt.charge(new.size >> 2)
    try:
        data[selection] = new
    except ValueError:
        message = f"the shape of {show(value, 60)} does not match the selection of `set-ref!`"
        raise SceneError("value", message) from None


@registry.define(
    "set-ref!",
    "collection::Any key::Any more::Any ...",
    "Any",
    "`(set-ref! xs i value)`: assign an item of a mutable list, a mutable array or a table. An array takes an index, "
    "`:all` or '(start end) for each axis; further indices of a list select in the item.",
    (
        '(let ((xs (mutable \'(1 2 3))) (t (table))) (set-ref! xs -1 9) (set-ref! t "a" 5) (list xs t))',
        '((mutable-list 1 2 9) (table "a" 5))',
    ),
    intrinsic="set-ref!",
)
def set_ref(rt: Runtime, collection: Any, key: Any, *more: Any) -> None:
    if not more:
        hint = "write `(set-ref! xs index value)`"
        raise SceneError("arity", "`set-ref!` expects a value after the index", hint=hint)
    value = more[-1]
    if type(collection) is MutableArray:  # one index for each axis
        set_array(rt, collection, (key, *more[:-1]), value)
        return
    for next_key in more[:-1]:
        collection, key = ref(rt, collection, key), next_key
        if type(collection) is MutableArray:
            hint = "to assign an item of a mutable array, write `(set-ref! array i j value)`"
            raise SceneError("value", "`set-ref!` follows indices only through lists and tables", hint=hint)
    if type(collection) is Table:
        rt.write(collection)
        set_entry(rt, collection.entries, key, value)
        _check_growth(rt, len(collection.entries))
    else:
        members = _writable_list(rt, "set-ref!", collection)
        members[check_index(to_index(key, "set-ref!"), len(members), collection)] = value


@registry.define(
    "update!",
    "collection::Any key::Any [f::Function] [default::Any]",
    "Any",
    "`(update! xs key f)`: replace the value at an index or key by `(f value)`; for a table, `default` is used for a "
    "missing key. `(update! table other)` adds all entries of another table.",
    (
        '(let ((t (table "a" 1))) (update! t "a" (lambda (n) (+ n 1))) (update! t "b" - 5) t)',
        '(table "a" 2 "b" -5)',
    ),
)
def update(rt: Runtime, collection: Any, key: Any, f: Any = None, *default: Any) -> None:
    if f is None:
        extend(rt, collection, key)
        return
    if type(collection) is MutableList and type(key) is int and -1 < key < len(collection.items) and not default:
        rt.read(collection)
        value = rt.call1(f, collection.items[key])
        if key < len(collection.items):  # which `f` may have shortened
            rt.write(collection)
            collection.items[key] = value
            return
        set_ref(rt, collection, key, value)
        return
    if not isinstance(collection, Mutable):
        raise cannot_change("update!", collection, "a mutable list, a mutable array or a table")
    old = ref(rt, collection, key, *default) if type(collection) is Table else ref(rt, collection, key)
    set_ref(rt, collection, key, rt.call1(f, old))


# --- growing and shrinking -------------------------------------------------------------------------------------


@registry.define(
    "push!",
    "xs::Any value::Any",
    "Any",
    "Append a value to a mutable list.",
    ("(let ((xs (mutable-list 1))) (push! xs 2) xs)", "(mutable-list 1 2)"),
)
def push(rt: Runtime, xs: Any, value: Any) -> None:
    members = _writable_list(rt, "push!", xs)
    _check_growth(rt, len(members))
    members.append(value)


@registry.define(
    "pop!",
    "xs::Any [key::Any] [default::Any]",
    "Any",
    "Remove and return the last item of a mutable list, or the one at an index; of a table, the value of a key, or "
    "the default if the key is missing.",
    ("(let ((xs (mutable-list 1 2 3))) (list (pop! xs) (pop! xs 0) xs))", "(3 1 (mutable-list 2))"),
)
def pop(rt: Runtime, xs: Any, *key_and_default: Any) -> Any:
    if type(xs) is Table:
        return _pop_entry(rt, xs, key_and_default)
    members = _writable_list(rt, "pop!", xs)
    if not members:
        raise empty_sequence("pop!", "mutable list")
    if not key_and_default:
        return members.pop()
    rt.charge(len(members) >> 4)
    return members.pop(check_index(to_index(key_and_default[0], "pop!"), len(members), xs))


def _pop_entry(rt: Runtime, table: Table, key_and_default: tuple[Any, ...]) -> Any:
    """Remove the entry of a key and return its value, or the default."""
    if not key_and_default:
        raise SceneError("arity", "`pop!` of a table expects a key", hint="write `(pop! table key)`")
    entries = _writable_table(rt, "pop!", table)
    key = table_key(key_and_default[0], rt.charge)
    if key in entries:
        return entries.pop(key)[1]
    if len(key_and_default) == 2:
        return key_and_default[1]
    raise missing_key("table", key_and_default[0], (name for name, _ in entries.values()))


@registry.define(
    "insert!",
    "xs::Any index::Integer value::Any",
    "Any",
    "Insert a value into a mutable list before the item at `index`; the length itself is the end.",
    ("(let ((xs (mutable-list 1 3))) (insert! xs 1 2) xs)", "(mutable-list 1 2 3)"),
)
def insert(rt: Runtime, xs: Any, index: int, value: Any) -> None:
    members = _writable_list(rt, "insert!", xs)
    if not -len(members) <= index <= len(members):
        raise bad_index(index, len(members), "list")
    _check_growth(rt, len(members))
    rt.charge(len(members) >> 4)
    members.insert(index, value)


@registry.define(
    "extend!",
    "xs::Any more::Sequence",
    "Any",
    "Append all items to a mutable list, add all entries of a table to a table, or all members to a set.",
    ("(let ((xs (mutable-list 1))) (extend! xs '(2 3)) xs)", "(mutable-list 1 2 3)"),
)
def extend(rt: Runtime, xs: Any, more: Any) -> None:
    if type(xs) is Table:
        if type(more) is not Table:
            raise wrong_type("extend!", "a table to add to a table", more)
        rt.read(more)
        added = list(more.entries.values())  # a copy, because a table may be extended by itself
        entries = _writable_table(rt, "extend!", xs)
        rt.charge(len(added))
        for key, value in added:
            set_entry(rt, entries, key, value)
        _check_growth(rt, len(entries))
        return
    members = items(rt, more, "extend!")
    if type(xs) is Set:
        for member in members:
            add(rt, xs, member)
        return
    target = _writable_list(rt, "extend!", xs)
    rt.meter.check_size(len(target) + len(members), "a list")
    target.extend(members)


@registry.define(
    "add!",
    "set::Any member::Any",
    "Any",
    "Add a member to a set, if it is not yet there.",
    ("(let ((s (set 1))) (add! s 2) (add! s 1.) s)", "(set 1 2)"),
)
def add(rt: Runtime, target: Any, member: Any) -> None:
    if type(target) is not Set:
        hint = "`push!` appends to a mutable list" if type(target) is MutableList else None
        raise wrong_type("add!", "a set", target, hint)
    rt.write(target)
    _check_growth(rt, len(target.entries))
    target.entries.setdefault(table_key(member, rt.charge), member)


@registry.define(
    "remove!",
    "xs::Any value::Any",
    "Any",
    "Remove the first item equal to `value` from a mutable list, or a member from a set; a missing one is an error.",
    ("(let ((xs (mutable-list 1 2 1))) (remove! xs 1) xs)", "(mutable-list 2 1)"),
)
def remove(rt: Runtime, xs: Any, value: Any) -> None:
    if type(xs) is Set:
        rt.write(xs)
        member = table_key(value, rt.charge)
        if member not in xs.entries:
            raise missing_key("set", value, xs.entries.values())
        del xs.entries[member]
        return
    if type(xs) is Table:
        raise wrong_type("remove!", "a mutable list or a set", xs, "`remove-key!` removes an entry of a table")
    members = _writable_list(rt, "remove!", xs)
    index = position_of(rt, xs, value, "remove!")  # equality by value, as in `contains?`
    if index is None:
        raise SceneError("value", f"the list does not contain {show(value, 60)}")
    rt.charge(len(members) >> 4)
    del members[index]


@registry.define(
    "remove-at!",
    "xs::Any index::Integer",
    "Any",
    "Remove the item at an index from a mutable list.",
    ("(let ((xs (mutable-list 1 2 3))) (remove-at! xs 0) xs)", "(mutable-list 2 3)"),
)
def remove_at(rt: Runtime, xs: Any, index: int) -> None:
    members = _writable_list(rt, "remove-at!", xs)
    rt.charge(len(members) >> 4)
    del members[check_index(index, len(members), xs)]


@registry.define(
    "splice!",
    "xs::Any start::Any end::Any new::Sequence",
    "Any",
    "Replace the items from `start` up to but excluding `end` of a mutable list by others; none omits a bound.",
    ("(let ((xs (mutable-list 1 2 3 4))) (splice! xs 1 3 '(a b c)) xs)", "(mutable-list 1 a b c 4)"),
)
def splice(rt: Runtime, xs: Any, start: Any, end: Any, new: Any) -> None:
    members = _writable_list(rt, "splice!", xs)
    bounds = [None if bound is None else to_index(bound, "splice!") for bound in (start, end)]
    rt.charge(len(members) >> 7)
    members[slice(*bounds)] = list(items(rt, new))
    rt.meter.check_size(len(members), "a list")


@registry.define(
    "remove-key!",
    "table::Any key::Any",
    "Any",
    "Remove the entry of a key from a table; a missing key is an error.",
    ('(let ((t (table "a" 1 "b" 2))) (remove-key! t "a") t)', '(table "b" 2)'),
)
def remove_key(rt: Runtime, table: Any, key: Any) -> None:
    entries = _writable_table(rt, "remove-key!", table)
    canonical = table_key(key, rt.charge)
    if canonical not in entries:
        raise missing_key("table", key, (name for name, _ in entries.values()))
    del entries[canonical]


@registry.define(
    "clear!",
    "xs::Any",
    "Any",
    "Remove all items from a mutable list, a table or a set.",
    ("(let ((xs (mutable-list 1 2))) (clear! xs) xs)", "(mutable-list)"),
)
def clear(rt: Runtime, xs: Any) -> None:
    if type(xs) is Table or type(xs) is Set:
        rt.write(xs)
        rt.charge(len(xs.entries) >> 6)
        xs.entries.clear()
    else:
        members = _writable_list(rt, "clear!", xs)
        rt.charge(len(members) >> 6)
        members.clear()


# --- reordering ------------------------------------------------------------------------------------------------


@registry.define(
    "sort!",
    "xs::Any [less::Function] [:key::Function] [:reverse::Boolean]",
    "Any",
    "Sort a mutable list or a mutable array in place; see `sort`.",
    ("(let ((xs (mutable-list 3 1 2))) (sort! xs) xs)", "(mutable-list 1 2 3)"),
)
def sort_in_place(rt: Runtime, xs: Any, less: Any = None, *, key: Any = None, reverse: bool = False) -> None:
    reorder(rt, "sort!", xs, lambda members: sorted_items(rt, members, less, key, reverse))


@registry.define(
    "reverse!",
    "xs::Any",
    "Any",
    "Reverse a mutable list or a mutable array in place.",
    ("(let ((xs (mutable-list 1 2 3))) (reverse! xs) xs)", "(mutable-list 3 2 1)"),
)
def reverse_in_place(rt: Runtime, xs: Any) -> None:
    reorder(rt, "reverse!", xs, lambda members: members[::-1])


tables = Registry("tables")

Entries = dict[Any, tuple[Any, Any]]


# --- tables ----------------------------------------------------------------------------------------------------


@tables.define("table", "keys-and-values::Any ...", "Table",
                 "Return a table from alternating keys and values. Keys compare by value; the insertion order is "
                 "preserved.",
                 ('(ref (table "oak" 3 "ash" 5) "ash")', "5"))  # fmt: skip
def table(rt: Runtime, *keys_and_values: Any) -> Any:
    if len(keys_and_values) % 2:
        count = len(keys_and_values)
        message = f"`table` expects a value after every key, got {count} argument{'s' if count > 1 else ''}"
        raise SceneError("arity", message, hint='write keys and values as in `(table "a" 1 "b" 2)`')
    entries: Entries = {}
    for index in range(0, len(keys_and_values), 2):
        set_entry(rt, entries, keys_and_values[index], keys_and_values[index + 1])
    return rt.table_of(entries)


@tables.define("list->table", "pairs::Sequence", "Table",
                 "Return a table from a list of pairs (key . value) or lists (key value).",
                 ("(list->table '((\"a\" . 1) (\"b\" 2)))", '(table "a" 1 "b" 2)'))  # fmt: skip
def list_to_table(rt: Runtime, pairs: Any) -> Any:
    entries: Entries = {}
    for pair in items(rt, pairs, "list->table"):
        rt.charge(1)
        set_entry(rt, entries, *_key_and_value(rt, pair))
    return rt.table_of(entries)


def _key_and_value(rt: Runtime, pair: Any) -> tuple[Any, Any]:
    """Return the parts of a pair ``(key . value)`` or a list ``(key value)``."""
    if type(pair) is Pair and type(pair.cdr) is not Pair and pair.cdr is not NIL:
        return pair.car, pair.cdr
    members = items(rt, pair, "list->table")
    if len(members) != 2:
        raise wrong_type("list->table", "pairs (key . value) or lists (key value)", pair)
    return members[0], members[1]


@tables.define("table-keys", "table::Table", "List", "Return the keys, in insertion order.",
                 ('(table-keys (table "a" 1 "b" 2))', '("a" "b")'))  # fmt: skip
def table_keys(rt: Runtime, table: Table) -> Any:
    return make_list(items(rt, table))


@tables.define("table-values", "table::Table", "List", "Return the values, in insertion order.",
                 ('(table-values (table "a" 1 "b" 2))', "(1 2)"))  # fmt: skip
def table_values(rt: Runtime, table: Table) -> Any:
    return make_list([value for _, value in _entries(rt, table)])


@tables.define("table-items", "table::Table", "List", "Return the lists (key value), in insertion order.",
                 ('(table-items (table "a" 1 "b" 2))', '(("a" 1) ("b" 2))'))  # fmt: skip
def table_items(rt: Runtime, table: Table) -> Any:
    entries = _entries(rt, table)
    return make_list([make_list(entry) for block in blocks(rt, entries) for entry in block])


def _entries(rt: Runtime, table: Table) -> list[tuple[Any, Any]]:
    """Return the keys and values of a table, and record that it is read."""
    rt.read(table)
    rt.charge(len(table.entries) >> 1)
    return list(table.entries.values())


@tables.define("table-merge", "table::Table more::Table ...", "Table",
                 "Return a new table with the entries of all; the values of later tables take precedence.",
                 ('(table-merge (table "a" 1 "b" 2) (table "b" 3))', '(table "a" 1 "b" 3)'))  # fmt: skip
def table_merge(rt: Runtime, *tables: Table) -> Any:
    entries: Entries = {}
    for table in tables:
        for block in blocks(rt, _entries(rt, table)):
            for key, value in block:
                set_entry(rt, entries, key, value)
    return rt.table_of(entries)


@tables.define("has-key?", "collection::Any key::Any", "Boolean",
                 "Return whether a table has the key, or an embedding the attribute.",
                 ('(has-key? (table "a" none) "a")', "#t"))  # fmt: skip
def has_key(rt: Runtime, collection: Any, key: Any) -> bool:
    if type(collection) is Table:
        rt.read(collection)
        return table_key(key, rt.charge) in collection.entries
    if type(collection) is not Embedding:
        raise wrong_type("has-key?", "a table or an embedding", collection)
    return isinstance(key, str) and str(key) in collection.attributes


@tables.define("keywords", "table::Table", "List",
                 "Return the entries as keyword arguments for `apply`: the list (:key value ...).",
                 ('(keywords (table "width" 2 "depth" 1))', "(:width 2 :depth 1)"))  # fmt: skip
def keywords(rt: Runtime, table: Table) -> Any:
    out: list[Any] = []
    for key, value in _entries(rt, table):
        if type(key) not in (str, Symbol, Keyword):
            raise SceneError("type", f"`keywords` expects names as keys, got {type_name(key)}")
        out += (Keyword(key), value)
    return make_list(out)


# --- sets ------------------------------------------------------------------------------------------------------


def _set_of(rt: Runtime, members: list[Any]) -> Any:
    """Return a set of members, the first of equal ones."""
    return rt.set_of(_by_key(rt, members))


def _by_key(rt: Runtime, members: list[Any]) -> dict[Any, Any]:
    """Return the first of all equal members, by canonical key."""
    entries: dict[Any, Any] = {}
    for block in blocks(rt, members):
        for member in block:
            entries.setdefault(table_key(member, rt.charge), member)
    return entries


@tables.define("set", "members::Any ...", "Set",
                 "Return a set of the arguments; members compare by value, the insertion order is preserved.",
                 ("(set 1 2 1.)", "(set 1 2)"))  # fmt: skip
def set_(rt: Runtime, *members: Any) -> Any:
    return _set_of(rt, list(members))


@tables.define("list->set", "xs::Sequence", "Set", "Return the set of the items of a sequence.",
                 ("(list->set '(3 1 3))", "(set 3 1)"))  # fmt: skip
def list_to_set(rt: Runtime, xs: Any) -> Any:
    return _set_of(rt, items(rt, xs, "list->set", ordered=False))


def _entry_map(rt: Runtime, name: str, value: Any) -> dict[Any, Any]:
    """Return the members of a set, or of any sequence, by canonical key."""
    if type(value) is Set:
        rt.read(value)
        rt.charge(len(value.entries) >> 2)
        return dict(value.entries)
    return _by_key(rt, items(rt, value, name, ordered=False))


@tables.define("set-union", "set::Set more::Sequence ...", "Set", "Return a new set of the members of all.",
                 ("(set-union (set 1 2) (set 2 3))", "(set 1 2 3)"))  # fmt: skip
def set_union(rt: Runtime, first: Any, *more: Any) -> Any:
    entries = _entry_map(rt, "set-union", first)
    for other in more:
        for key, member in _entry_map(rt, "set-union", other).items():
            entries.setdefault(key, member)
        rt.charge(len(entries) >> 4)
    return rt.set_of(entries)


@tables.define("set-intersection", "set::Set more::Sequence ...", "Set",
                 "Return a new set of the members that all have in common.",
                 ("(set-intersection (set 1 2 3) (set 2 3 4))", "(set 2 3)"))  # fmt: skip
def set_intersection(rt: Runtime, first: Any, *more: Any) -> Any:
    entries = _entry_map(rt, "set-intersection", first)
    for other in more:
        common = _entry_map(rt, "set-intersection", other)
        rt.charge(len(entries) >> 4)
        entries = {key: member for key, member in entries.items() if key in common}
    return rt.set_of(entries)


@tables.define("set-difference", "set::Set more::Sequence ...", "Set",
                 "Return a new set of the members of the first that are in no other.",
                 ("(set-difference (set 1 2 3) (set 2))", "(set 1 3)"))  # fmt: skip
def set_difference(rt: Runtime, first: Any, *more: Any) -> Any:
    entries = _entry_map(rt, "set-difference", first)
    for other in more:
        excluded = _entry_map(rt, "set-difference", other)
        rt.charge(len(entries) >> 4)
        entries = {key: member for key, member in entries.items() if key not in excluded}
    return rt.set_of(entries)


@tables.define("subset?", "a::Set b::Sequence", "Boolean", "Return whether all members of `a` are in `b`.",
                 ("(subset? (set 1) (set 1 2))", "#t"))  # fmt: skip
def is_subset(rt: Runtime, a: Any, b: Any) -> bool:
    return length(rt, a) == 0 or _entry_map(rt, "subset?", a).keys() <= _entry_map(rt, "subset?", b).keys()
