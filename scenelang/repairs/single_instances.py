"""Exceptions for chosen instances: edits of a program that change one object of a loop, or of a function that is called
several times.

A form that makes the instances is wrapped in an entity whose word has the values of the variables in scope, and the
program is evaluated. In the tree of that scene, the words around the chosen instances say which values single them out,
for a condition such as ``(= i 3)``. Where no variable does, the value of a form further outside is made again with the
chosen part changed. As everywhere in ``instance_edits``, evaluation proves each candidate.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

from scenelang.backends.surfaces.solids import FloatArray
from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Source, Span, Symbol, walk
from scenelang.grammar.diagnostics import Edit
from scenelang.grammar.reader import read
from scenelang.interpreter.inspection.instance_paths import Located, primitive_ranges
from scenelang.interpreter.scene.entity import Entity, Scene
from scenelang.interpreter.scene.flatten import FlatFrame, flatten
from scenelang.interpreter.values.values import IDENTITY
from scenelang.repairs.form_candidates import FormCandidate, vector_text
from scenelang.repairs.program_forms import enclosing_forms, forms_of, head_of, names_in_scope, uses_around
from scenelang.repairs.whole_objects import helper_function

_MARK = "variables of a form\n"  # begins the word of the entity around the value of a form
_MAX_VALUE = 120  # characters of a value in a condition
_MAX_NAMES = 8  # variables in scope, the innermost first
_MAX_CONDITIONS = 3  # that are tried at a form
_MAX_FORMS = 6  # that are tried on each level
_MAX_MATCHED_PRIMITIVES = 200_000  # of a scene, as in ``instance_edits``
# Combinators that copy an object or call a function of the indices of the copy, with the argument that is the object
# and the number of indices (``Template`` in `stdlib/combinators.scene`).
_TEMPLATES = {"ring": (2, 1), "along": (1, 1), "scatter": (2, 1), "scatter-on": (1, 1), "grid": (1, 3)}
_INDEX_NAMES = ("i", "j", "k", "m", "n", "index", "row", "column", "layer", "copy")
_HELPER = """(define ({name} object path change)
  (if (entity? object)
    (make-entity (entity-word object) (entity-embedding object)
      ({name} (entity-children object) path change))
    (for/list ((part (parts object)) (k (iota (length (parts object)))))
      (cond
        ((not (= k (first path))) part)
        ((= (length path) 1) (change part))
        (else (cons ({name} (car part) (rest path) change) (cdr part)))))))
"""


@dataclass(frozen=True, slots=True)
class PartChange:
    """Texts of a change of one object.

    Attributes
    ----------
    offset
        Translation (3,) of the object, or of its copy, in the axes of its parent; None for other changes.
    is_copy
        Whether the translation is that of a copy.
    with_pose
        Whether the forms that place the object belong to what is changed.
    of_form
        Text of the changed object for the form that makes it; empty if this is not possible.
    of_part
        Text of the changed part for the variable ``part``, a pair of entity and pose; empty if this is not possible.
    added
        Edits of the program that define the functions used.
    """

    offset: FloatArray | None
    is_copy: bool
    with_pose: bool
    of_form: Callable[[ListDatum], str]
    of_part: str
    added: tuple[Edit, ...] = ()


@dataclass(frozen=True, slots=True)
class _Site:
    """A form to change: the names in scope, and the span that is replaced, with the texts around the form in it.

    ``level`` is the number of entities around the parts that it makes.
    """

    form: ListDatum
    level: int
    names: tuple[str, ...]
    span: Span
    before: str = ""
    after: str = ""


@dataclass(frozen=True, slots=True)
class _Place:
    """The chosen instances at a site: their positions in its value, the only one or not, and conditions for them."""

    site: _Site
    steps: tuple[int, ...]
    is_whole: bool
    conditions: tuple[str, ...]  # an empty one holds always


def exceptions(
    source: Source,
    frames: Sequence[Sequence[Located]],
    change: PartChange,
    evaluate: Callable[[str], Scene | None],
) -> Iterator[FormCandidate]:
    """Yield edits that change only the chosen instances, located in the frames of a scene.

    The forms that make the instances come first, then those that make their parents, and so on. ``evaluate`` returns
    the scene of a text, None if it is wrong.
    """
    chosen = [each for frame in frames for each in frame]
    depths = {len(each.positions) for each in chosen}
    if len(depths) != 1:
        return
    scene = evaluate(source.text)
    if scene is None:
        return
    root = next(root for root, frame in zip(scene.frames, frames) if frame)
    search = _Sites(source, frames, evaluate)
    for depth in range(depths.pop(), -1, -1):
        word = _at(root, chosen[0].positions[:depth]).word
        places = [place for site in search.at(word, depth, change) if (place := search.place(site)) is not None]
        for place in sorted(places, key=_rank):
            yield from _candidates(source, place, change)


def _rank(place: _Place) -> tuple[bool, bool, int]:
    """Return the rank of a place: forms that make the object only, and without conditions, then the shortest form."""
    span = place.site.form.span
    return not place.is_whole, place.is_whole and place.conditions[:1] != ("",), span.end - span.start


def _candidates(source: Source, place: _Place, change: PartChange) -> Iterator[FormCandidate]:
    """Yield the edits of a form that change a part of its value."""
    form, site = place.site.form, place.site
    for condition in place.conditions:
        if place.is_whole:
            before, after, added = *_of_form(form, change, condition), change.added
        else:
            before, after, added = _of_parts(source, form, place.steps, change, condition)
        if not before:
            return
        before, after = f"{site.before}{before}", f"{after}{site.after}"
        vector = "" if change.offset is None else vector_text(change.offset)
        around = None if change.offset is None else (before, after)
        yield FormCandidate(site.span, f"{before}{vector}{after}", False, added, around)


def _of_form(form: ListDatum, change: PartChange, condition: str) -> tuple[str, str]:
    """Return the texts before and after the vector of a change of the value of a form; empty if there are none."""
    text = form.span.text
    if change.offset is None:
        new = change.of_form(form)
        return (f"(if {condition} {new} {text})" if new and condition else new), ""
    if not condition:
        opening = "(union " if change.is_copy else ""
        before = f"{opening}{text} (transform {text}" if change.is_copy else f"(transform {text}"
        return f"{before} (translate ", ")))" if change.is_copy else "))"
    if change.is_copy:
        return f"(if {condition} (union {text} (transform {text} (translate ", f"))) {text})"
    return f"(transform {text} (translate (if {condition} ", " [0 0 0])))"


def _of_parts(
    source: Source, form: ListDatum, steps: tuple[int, ...], change: PartChange, condition: str
) -> tuple[str, str, tuple[Edit, ...]]:
    """Return the texts before and after the vector of a change of a part of the value of a form, and further edits."""
    text = form.span.text
    is_entity = head_of(form) == "call"
    path = steps[1:] if is_entity else steps
    if not path or not (change.of_part or change.offset is not None):
        return "", "", ()
    name, added = helper_function(source, "part-changed", _HELPER)
    before, after = change.of_part, ""
    if change.offset is not None:
        moved = ("(transform part (translate ", "))")
        before, after = (f"(union part {moved[0]}", f"{moved[1]})") if change.is_copy else moved
    if condition:
        before, after = f"(if {condition} {before}", f"{after} part)"
    start = f"({name} {text} '({' '.join(map(str, path))}) (lambda (part) "
    before, after = f"{start}{before}", f"{after}))"
    edits = (*change.added, *added)
    return (f"{before}{after}", "", edits) if change.offset is None else (before, after, edits)


class _Sites:
    """The forms of a program that make the chosen instances, or what contains them."""

    def __init__(
        self,
        source: Source,
        frames: Sequence[Sequence[Located]],
        evaluate: Callable[[str], Scene | None],
    ) -> None:
        self._source, self._frames, self._evaluate = source, frames, evaluate

    def at(self, word: str, depth: int, change: PartChange) -> Iterator[_Site]:
        """Yield the forms that make instances of a word, then those around them, then the bodies of its functions."""
        calls, bodies = forms_of(self._source, word)
        whole: list[ListDatum] = []
        around: list[ListDatum] = []
        for chain in calls if depth else []:
            posed = _with_poses(chain)
            whole.append(chain[posed - 1 if change.with_pose else 0])
            whole += uses_around(self._source, chain[0].span) if change.with_pose else []
            around += chain[posed:]
        seen = set[int]()
        for forms, level in ((whole, depth - 1), (around, depth - 1), (bodies, depth)):
            new = list({form.span.start: form for form in forms if form.span.start not in seen}.values())[:_MAX_FORMS]
            seen.update(form.span.start for form in new)
            yield from (self._site(form, level) for form in new)

    def _site(self, form: ListDatum, level: int) -> _Site:
        """Return a form with the names in scope, as a function of indices where a combinator takes one."""
        outer = enclosing_forms(self._source, form.span)
        names = tuple(dict.fromkeys(names_in_scope(outer, form.span)))[:_MAX_NAMES]
        posed = _with_poses([form, *outer])
        copied, around = [form, *outer][posed - 1], outer[posed - 1 : posed]
        argument, count = _TEMPLATES.get(head_of(around[0]) or "", (0, 0)) if around else (0, 0)
        if not count or len(around[0].items) <= argument or around[0].items[argument].span.start != copied.span.start:
            return _Site(form, level, names, form.span)
        used = {datum.span.text for datum in walk(copied)}
        indices = tuple(name for name in _INDEX_NAMES if name not in used)[:count]
        at = copied.span.start
        before = f"(lambda ({' '.join(indices)}) {copied.span.text[: form.span.start - at]}"
        after = f"{copied.span.text[form.span.end - at :]})"
        return _Site(
            form, level, (*indices, *(name for name in names if name not in indices)), copied.span, before, after
        )

    def place(self, site: _Site) -> _Place | None:
        """Return where the chosen instances are in the value of a site; None if it does not make them."""
        span, text = site.span, self._source.text
        fields = "\\n".join("{!r}" for _ in site.names)
        word = f'(format "{_MARK[:-1]}\\n{fields}"{"".join(f" {name}" for name in site.names)})'
        entity = f"(make-entity {word} (embedding) {site.form.span.text})"
        # A list of entities is a list of frames, one of entities with poses is not: a wrapper is the same of the two.
        value = entity if head_of(site.form) == "call" else f"(transform {entity} (translate [0 0 0]))"
        wrapped = f"{site.before}{value}{site.after}"
        scene = self._evaluate(f"{text[: span.start]}{wrapped}{text[span.end :]}")
        if scene is None or len(scene.frames) != len(self._frames):
            return None
        hits, others = [], set[str]()
        for root, frame, flat in zip(scene.frames, self._frames, flatten(scene, _MAX_MATCHED_PRIMITIVES).frames):
            hits_of_frame = [_hit(root, each.positions, site.level) for each in frame]
            if any(hit is None for hit in hits_of_frame):
                return None
            hits += [hit for hit in hits_of_frame if hit is not None]
            own = {hit.word for hit in hits_of_frame if hit is not None}
            others |= _other_words(root, flat, hits_of_frame, own)
        if not hits or len({hit.steps for hit in hits}) != 1:
            return None
        conditions = tuple(_conditions(site.names, {hit.word for hit in hits}, others))
        return _Place(site, hits[0].steps, all(hit.is_whole for hit in hits), conditions[:_MAX_CONDITIONS])


def _with_poses(chain: Sequence[ListDatum]) -> int:
    """Return the number of forms, from the call on, that only place what the call makes."""
    count = 1
    while count < len(chain) and head_of(chain[count]) == "transform" and len(chain[count].items) == 3:
        if chain[count].items[1].span.start != chain[count - 1].span.start:
            break
        count += 1
    return count


# --- wrapped entities ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Hit:
    """An instance inside a wrapped value: the word and positions of the wrapper, and those from it to the instance."""

    word: str
    wrapper: tuple[int, ...]  # from the root of the scene with wrappers
    steps: tuple[int, ...]
    is_whole: bool  # whether the value of the form is the instance only


def _hit(root: Entity, positions: Sequence[int], level: int) -> _Hit | None:
    """Return the innermost wrapper on a level above an instance; None if there is none."""
    entity, here = root, tuple[int, ...]()
    for depth, position in enumerate(positions[: level + 1]):
        children = _unwrapped(entity)
        if position >= len(children):
            return None
        entity, way, index, siblings = children[position]
        if depth == level:
            wrapper = (*here, *way[:-1])
            steps = (index, *positions[level + 1 :])
            is_whole = siblings == 1 and len(steps) == 1
            return _Hit(_at(root, wrapper).word, wrapper, steps, is_whole) if len(way) > 1 else None
        here = (*here, *way)
    return None


def _at(root: Entity, positions: Sequence[int]) -> Entity:
    """Return the entity at positions below a root."""
    for position in positions:
        root = root.children[position].car
    return root


def _unwrapped(entity: Entity) -> list[tuple[Entity, tuple[int, ...], int, int]]:
    """Return the children of an entity as without wrappers.

    Each has its positions from the entity, its index in the innermost wrapper, and the number of parts in that one.
    """
    children: list[tuple[Entity, tuple[int, ...], int, int]] = []
    for k, part in enumerate(entity.children):
        if part.car.word.startswith(_MARK):
            inside = _unwrapped(part.car)
            for j, (child, way, index, siblings) in enumerate(inside):
                is_nested = len(way) > 1
                children.append((child, (k, *way), index if is_nested else j, siblings if is_nested else len(inside)))
        else:
            children.append((part.car, (k,), k, len(entity.children)))
    return children


def _other_words(root: Entity, flat: FlatFrame, hits: Sequence[_Hit | None], own: set[str]) -> set[str]:
    """Return the words of wrappers that do not contain the chosen instances."""
    located = [Located(hit.wrapper, root, IDENTITY) for hit in hits if hit is not None]
    inside = set[int]()
    for first, last in primitive_ranges(root, located):
        inside.update(range(first, last))
    words = set[str]()
    index = flat.path_index.tolist()
    known = [tuple(word for word in path if word.startswith(_MARK)) for path in flat.paths]
    for row, path in enumerate(index):
        words.update(known[path] if row not in inside else (word for word in known[path] if word not in own))
    return words


def _conditions(names: Sequence[str], own: set[str], others: set[str]) -> Iterator[str]:
    """Yield conditions on variables that hold for the values of the chosen instances and for no others."""
    if not others:
        yield ""
        return
    rows = [word[len(_MARK) :].split("\n") for word in own]
    other_rows = [word[len(_MARK) :].split("\n") for word in others]
    if any(len(row) != len(names) for row in (*rows, *other_rows)):
        return
    usable = [k for k in range(len(names)) if len({row[k] for row in rows}) == 1 and _test(names[k], rows[0][k])]
    for size in (1, 2, 3):
        for columns in combinations(usable, size):
            if not any(all(row[k] == rows[0][k] for k in columns) for row in other_rows):
                tests = [_test(names[k], rows[0][k]) for k in columns]
                yield tests[0] if size == 1 else f"(and {' '.join(tests)})"


def _test(name: str, value: str) -> str:
    """Return the text of a test whether a variable has a value, given as printed; empty if it cannot be written."""
    if len(value) > _MAX_VALUE:
        return ""
    parsed = read(Source("<value>", value))
    if len(parsed.forms) != 1 or any(diagnostic.is_error for diagnostic in parsed.diagnostics):
        return ""
    datum: Datum = parsed.forms[0]
    if isinstance(datum, ArrayDatum):
        is_numeric = all(isinstance(item, Atom) and type(item.value) in (int, float) for item in datum.items)
        return f"(equal? {name} {value})" if is_numeric else ""
    if not isinstance(datum, Atom):
        return ""
    if type(datum.value) is bool:
        return name if datum.value else f"(not {name})"
    if type(datum.value) in (int, float):
        return f"(= {name} {value})"
    if type(datum.value) is str:
        return f"(equal? {name} {value})"
    if isinstance(datum.value, Keyword):
        return f"(equal? {name} {value})"
    return f"(equal? {name} '{value})" if isinstance(datum.value, Symbol) and "<" not in value else ""
