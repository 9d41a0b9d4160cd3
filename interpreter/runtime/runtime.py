"""The state of one run: words, memo, random streams, meter, log. Compiled code and builtins work through it.

Sharing of calls (language.md, section 5). A call's result is stored unless the call drew random numbers, changed
something older than itself, or made something mutable reachable. What a call reads that is older and can change is
marked ``observed``; its result then holds for the current epoch only, and a change of an observed thing begins a new
epoch. "Older" is decided by birth stamps: ``clock`` numbers the calls, and a mutable thing carries the clock of its
making. A call merges what it read and wrote into its caller's account however it ends; a hit merges its entry's.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.runtime import procedures
from scenelang.interpreter.runtime.limits import Limits, Meter
from scenelang.interpreter.runtime.procedures import (
    TAIL,
    Closure,
    Condition,
    Escape,
    EscapeSignal,
    Frame,
    bind_arguments,
    bind_entity,
    check_keywords,
)
from scenelang.interpreter.runtime.show import LONGEST, show
from scenelang.interpreter.runtime.types import Builtin, Library, type_name
from scenelang.interpreter.runtime.values import (
    NIL,
    Embedding,
    HandleList,
    Mutable,
    MutableList,
    Procedure,
    Set,
    Table,
    embedding_key,
    memo_key,
)
from scenelang.interpreter.scene import parts
from scenelang.interpreter.scene.entity import Entity, Frames
from scenelang.interpreter.scene.primitives import class_of
from scenelang.interpreter.scene.primitives.asset import Asset

# The two random streams of a run: numpy's legacy generator and Python's, so that transpiled programs draw alike.


class Streams:
    """Made when first drawn from; ``seed`` sets both."""

    def __init__(self, seed: int) -> None:
        self._seeds: list[int] = [seed, seed]
        self._numpy: Any = None
        self._python: random.Random | None = None

    @property
    def numpy(self) -> Any:
        """A ``numpy.random.RandomState`` (MT19937)."""
        if self._numpy is None:
            from numpy.random import RandomState

            self._numpy = RandomState(self._seeds[0])
        return self._numpy

    @property
    def python(self) -> random.Random:
        if self._python is None:
            self._python = random.Random(self._seeds[1])
        return self._python

    def seed_numpy(self, seed: int) -> None:
        self._seeds[0], self._numpy = seed, None

    def seed_python(self, seed: int) -> None:
        self._seeds[1], self._python = seed, None

    def seed(self, seed: int) -> None:
        """Set both streams, as is done just before the root is evaluated."""
        self.seed_numpy(seed)
        self.seed_python(seed)

    def snapshot(self) -> Any:
        """The state of both streams, for ``restore``."""
        numpy_state = self._numpy.get_state() if self._numpy is not None else None
        python_state = self._python.getstate() if self._python is not None else None
        return tuple(self._seeds), numpy_state, python_state

    def restore(self, snapshot: Any) -> None:
        seeds, numpy_state, python_state = snapshot
        self._seeds, self._numpy, self._python = list(seeds), None, None
        if numpy_state is not None:
            self.numpy.set_state(numpy_state)
        if python_state is not None:
            self.python.setstate(python_state)


_NEVER = 1 << 62
_MOST_PLACES = 16
_FEW = 32  # items of a key that are not charged


class WordCell(Mutable):
    """What a word is bound to; older than every call."""

    __slots__ = ("function", "span")

    def __init__(self) -> None:
        self.birth = 0
        self.observed = False
        self.function: Any = None
        self.span: Span | None = None


@dataclass(frozen=True, slots=True)
class MemoEntry:
    """A stored call. ``epoch``: valid only then, or always when None; ``oldest_read`` is merged at a hit."""

    value: Any
    epoch: int | None
    oldest_read: int


@dataclass(frozen=True, slots=True)
class ZEntry:
    """An entry of Z: text and attributes for an embedding (vectors stay with the backends)."""

    text: str | None = None
    attributes: Mapping[str, Any] = field(default_factory=dict)


def _note_place(entity: Entity, span: Span) -> None:
    """One more call that made a shared primitive."""
    if len(entity.places) < _MOST_PLACES and all(place is not span for place in entity.places):
        entity.places = (*entity.places, span)


class Runtime:
    """One run of one program. ``handles`` maps handle names to Z's entries; ``memoise`` is False only in tests of the
    memo itself; ``snapshots`` are the serials of the calls at whose start the streams' state is kept
    (None: all). ``asset(file, charge)`` measures a mesh file."""

    def __init__(
        self,
        library: Library,
        limits: Limits | None = None,
        seed: int = 0,
        handles: Mapping[str, ZEntry] | None = None,
        memoise: bool = True,
        snapshots: frozenset[int] | None = frozenset(),
        asset: Callable[[str, Callable[[int], None]], Asset] | None = None,
    ) -> None:
        self.library = library
        self.asset = asset
        self.limits = limits or Limits()
        self.meter = Meter(self.limits)
        self.tick = self.meter.tick
        self.charge = self.meter.charge
        self.streams = Streams(seed)
        self.words: dict[str, WordCell] = {}
        self.handles = handles or {}
        self.entities = 0
        # what the innermost running call has read and written; see the module's docstring
        self.clock = 1
        self.serial = 0
        self.oldest_write = _NEVER
        self.oldest_read = _NEVER
        self.drew = False
        self.epoch = 0
        self._memoise = memoise
        self._memo: dict[Any, MemoEntry] = {}
        self._primitives: dict[Any, Entity] = {}
        # a tail call on its way to the loop that makes it
        self.next_body: Any = None
        self.next_frame: Any = None
        self.log: list[str] = []
        self._log_size = 0
        self.symbols_made = 0
        self.warnings: dict[tuple[str, str, Span | None], Diagnostic] = {}
        self._snapshot_at = snapshots
        self.snapshots: dict[int, Any] = {}

    def renew(self, started: float | None = None) -> None:
        """Begin another evaluation in the same run: limits, log and warnings begin anew. ``started``: see ``Meter``."""
        self.meter.renew(started)
        self.entities = 0
        self.log.clear()
        self._log_size = 0
        self.warnings.clear()

    def forget_calls(self) -> None:
        """Share no call that was made so far: what calls depend on has changed behind the account's back."""
        self.epoch += 1
        self._memo.clear()

    # --- procedures --------------------------------------------------------------------------------------------

    def apply(self, function: Any, args: Sequence[Any]) -> Any:
        """Call any procedure; raises SceneError when ``function`` is none."""
        if type(function) is Closure:
            if function.arity == len(args):
                frame = [function.env, *args]
            else:
                frame = bind_arguments(self, function, args)
            self.tick()
            result = function.body(frame)
            while result is TAIL:
                self.tick()
                result = self.next_body(self.next_frame)
            return result
        return self.apply_other(function, args)

    def call1(self, function: Any, a: Any) -> Any:
        """``apply`` to one argument, for builtins' loops."""
        if type(function) is Closure and function.arity == 1:
            self.tick()
            result = function.body([function.env, a])
            while result is TAIL:
                self.tick()
                result = self.next_body(self.next_frame)
            return result
        return self.apply(function, (a,))

    def call2(self, function: Any, a: Any, b: Any) -> Any:
        """``apply`` to two arguments, for builtins' loops."""
        if type(function) is Closure and function.arity == 2:
            self.tick()
            result = function.body([function.env, a, b])
            while result is TAIL:
                self.tick()
                result = self.next_body(self.next_frame)
            return result
        return self.apply(function, (a, b))

    def apply_other(self, function: Any, args: Sequence[Any]) -> Any:
        """Call a procedure that is no closure."""
        if type(function) is Builtin:
            self.tick()
            return procedures.call_builtin(self, function, args)
        if type(function) is Escape:
            if len(args) > 1:
                raise SceneError("arity", f"the escape `{function.name}` wants at most 1 argument, got {len(args)}")
            if not function.active:
                raise SceneError("escape", f"`{function.name}` was called after its `let/ec` had ended")
            raise EscapeSignal(function, args[0] if args else None)
        if isinstance(function, Procedure):
            return procedures.call_record_procedure(self, function, args)
        raise self.not_a_procedure(function)

    def not_a_procedure(self, value: Any, span: Span | None = None) -> SceneError:
        """The error for a call of ``value``, which stands at ``span``."""
        message = f"{show(value, 60)} is {type_name(value)}, not a function, so it cannot be called"
        hint = 'a list of values is `(list ...)`; a word is called with `(call "word" ...)`'
        head = re.match(r"\(([^\s()]+)", span.text) if span is not None and span.expansion is None else None
        if head is not None and head[1] in _known_names(self.library):
            hint = f"here `{head[1]}` is a name of the program; the function of that name is always `std/{head[1]}`"
        return SceneError("not-a-procedure", message, hint=hint)

    # --- what calls read and write ---------------------------------------------------------------------------------

    def read(self, thing: Mutable) -> None:
        """Note that a mutable thing is read."""
        birth = thing.birth
        if birth < self.serial:
            thing.observed = True
            if birth < self.oldest_read:
                self.oldest_read = birth

    def write(self, thing: Mutable) -> None:
        """Note that a mutable thing is about to change; raises SceneError for a copy inside an embedding."""
        if thing.birth < 0:
            raise SceneError("immutable", "this table belongs to an embedding and cannot be changed")
        if thing.observed:
            self.epoch += 1
            thing.observed = False
        if thing.birth < self.oldest_write:
            self.oldest_write = thing.birth

    def show(self, value: Any, limit: int = LONGEST) -> str:
        """``value`` as text that the program gets: what can change in it is read."""
        text = show(value, limit, self.read)
        if len(text) > _FEW:
            self.charge(len(text) >> 3)
        return text

    def display(self, value: Any) -> str:
        """As ``show``, but a string is its own text."""
        return value if type(value) is str else self.show(value)

    def look_at_error(self) -> None:
        """Note that a program looks at the text of an error, which may show anything that can change: the running calls
        are not shared."""
        self.drew = True

    def draw(self, stream: Any = None) -> None:
        """Note that a random number is drawn: from ``stream``, or from a global stream."""
        if stream is None:
            self.drew = True
        else:
            self.write(stream)

    # --- making values --------------------------------------------------------------------------------------------

    def mutable_list(self, items: list[Any]) -> MutableList:
        self.meter.check_size(len(items), "a list")
        return MutableList(items, self.clock)

    def table_of(self, entries: dict[Any, tuple[Any, Any]]) -> Table:
        """A table from canonical keys to ``(key, value)`` (see ``equality.table_key``)."""
        return Table(entries, self.clock)

    def set_of(self, entries: dict[Any, Any]) -> Set:
        return Set(entries, self.clock)

    def handle(self, name: str) -> Embedding:
        """The embedding that a handle in the program stands for, with what Z says of it."""
        entry = self.handles.get(name)
        if entry is None:
            return Embedding(name)
        return Embedding(name, entry.text, dict(entry.attributes))

    # --- words and calls ------------------------------------------------------------------------------------------

    def word_cell(self, word: str) -> WordCell:
        """The cell of a word; reading it counts as reading something that can change."""
        cell = self.words.get(word)
        if cell is None:
            cell = self.words[word] = WordCell()
        cell.observed = True
        self.oldest_read = 0
        return cell

    def bind_word(self, word: Any, function: Any, span: Span | None = None) -> None:
        """``(bind word function)``: from now on, as an effect."""
        if type(word) is not str:
            raise SceneError("word", f"`bind` wants a string for the word, got {type_name(word)}")
        if not isinstance(function, Procedure):
            hint = "an entity function is `(lambda (z gamma) ...)` or `(lambda () ...)`"
            raise SceneError("type", f'`bind` wants a function for "{word}", got {type_name(function)}', hint=hint)
        cell = self.words.get(word)
        if cell is None:
            cell = self.words[word] = WordCell()
        self.write(cell)
        cell.function = function
        cell.span = span

    def call_word(self, word: str, z: Embedding, rest: Any, written: frozenset[str], span: Span | None) -> Entity:
        """``(call word z . rest)``: shared with an equal earlier call where that is sound.

        ``written`` are the attribute names written in this very call: the entity function must know them.
        """
        function = self.word_cell(word).function
        if function is None:
            return self.primitive(word, z, span)
        if written and type(function) is Closure:
            check_keywords(function.code, tuple(written), word)
        key: Any = z.key if z.key is not None else embedding_key(z, self.charge)
        rest_key = () if rest is NIL else memo_key(rest, self.charge)
        if key is False or rest_key is None or not self._memoise:
            key = False
        else:
            if len(key) + len(rest_key) > _FEW:
                self.charge((len(key) + len(rest_key)) >> 6)  # what hashing and comparing the key costs
            key = (function, word, key, rest_key)
            entry = self._recall(key)
            if entry is not None:
                shared: Entity = entry.value
                return shared
        return self._run_call(word, function, z, rest, key, span)

    def note_call(self, serial: int) -> None:
        """Keep the state of the random streams if somebody asked for it at this call."""
        if self._snapshot_at is None or serial in self._snapshot_at:
            self.snapshots[serial] = self.streams.snapshot()

    def _run_call(self, word: str, function: Any, z: Embedding, rest: Any, key: Any, span: Span | None) -> Entity:
        def compute(serial: int) -> Entity:
            try:
                entity = self.make_entity(word, z, self._entity_parts(word, function, z, rest))
            except SceneError as error:
                error.called(f'"{word}"', span)
                raise
            entity.function, entity.rest, entity.serial = function, rest, serial
            entity.effects = self.oldest_write < serial
            return entity

        result: Entity = self._account(key, compute, lambda entity: entity.tainted)
        return result

    def shared_application(self, function: Procedure, z: Embedding, rest: Any) -> Any:
        """``apply-entity-function``: run an entity function on z and gamma, shared like a ``call``."""
        key: Any = z.key if z.key is not None else embedding_key(z, self.charge)
        rest_key = memo_key(rest, self.charge)
        if key is False or rest_key is None or not self._memoise:
            key = False
        else:
            self.charge((len(key) + len(rest_key)) >> 6)
            key = (function, key, rest_key)
            entry = self._recall(key)
            if entry is not None:
                return entry.value
        run = lambda serial: self.apply_entity_function(function, function.name, z, rest)
        return self._account(key, run, lambda value: memo_key(value, self.charge) is None)

    def _recall(self, key: Any) -> MemoEntry | None:
        """A stored call that still holds; what it read is merged into the running call's account."""
        entry = self._memo.get(key)
        if entry is None or (entry.epoch is not None and entry.epoch != self.epoch):
            return None
        if entry.oldest_read < self.oldest_read:
            self.oldest_read = entry.oldest_read
        return entry

    def _account(self, key: Any, compute: Callable[[int], Any], is_tainted: Callable[[Any], bool]) -> Any:
        """Run a call with an account of its own, store its value under ``key`` if that is sound, merge the account."""
        self.tick()
        serial = self.clock = self.clock + 1
        self.note_call(serial)
        outer_serial, outer_write, outer_read, outer_drew = self.serial, self.oldest_write, self.oldest_read, self.drew
        self.serial, self.oldest_write, self.oldest_read, self.drew = serial, _NEVER, _NEVER, False
        try:
            value = compute(serial)
            if key is not False and not (self.drew or self.oldest_write < serial or is_tainted(value)):
                epoch = None if self.oldest_read >= serial else self.epoch
                self._memo[key] = MemoEntry(value, epoch, self.oldest_read)
            return value
        finally:
            self.serial = outer_serial
            self.drew = self.drew or outer_drew
            if outer_write < self.oldest_write:
                self.oldest_write = outer_write
            if outer_read < self.oldest_read:
                self.oldest_read = outer_read

    def check_written(self, word: str, written: frozenset[str]) -> None:
        """Refuse attribute names, written in a call, that the entity function does not know."""
        function = self.word_cell(word).function
        if written and type(function) is Closure:
            check_keywords(function.code, tuple(written), word)

    def remake(self, entity: Entity, z: Embedding) -> Entity:
        """Make ``entity`` again under another embedding, by the function that made it; see ``graft``."""
        if entity.is_primitive:
            return self.primitive(entity.word, z)
        if entity.function is None:
            return self.make_entity(entity.word, z, entity.children)
        self._snapshot_at = None
        self.entities = 0
        return self._run_call(entity.word, entity.function, z, entity.rest, False, None)

    def _entity_parts(self, word: str, function: Any, z: Embedding, rest: Any) -> tuple[Any, ...]:
        value = self.apply_entity_function(function, word, z, rest)
        if type(value) is Frames:
            raise SceneError("frames", f'"{word}" is no root, so its value cannot be frames')
        return parts.parts_of(self, value, word)

    def apply_entity_function(self, function: Any, word: str, z: Embedding, rest: Any) -> Any:
        """Fill the parameters of ``function`` with z and gamma, and run it."""
        if type(function) is Closure:
            if function.arity == 0:
                frame: Frame = [function.env]
            elif function.arity == 1:
                frame = [function.env, z]
            elif function.arity == 2:
                frame = [function.env, z, rest]
            else:
                frame = bind_entity(self, function, word, z, rest)
            result = function.body(frame)
            while result is TAIL:
                self.tick()
                result = self.next_body(self.next_frame)
            return result
        if type(function) is Builtin:
            return self.apply(function, [z, rest][: len(function.signature.required)])
        return self.apply(function, [z])

    def make_entity(self, word: str, z: Embedding, children: tuple[Any, ...]) -> Entity:
        """A new entity with ``children``, pairs ``(Entity . Matrix)``."""
        self._count_entity()
        tainted = (z.key if z.key is not None else embedding_key(z, self.charge)) is False
        if not tainted:
            for part in children:
                if part.car.tainted:
                    tainted = True
                    break
        return Entity(word, z, children, None, tainted)

    def primitive(self, word: str, z: Embedding, span: Span | None = None) -> Entity:
        """The primitive ``word`` under ``z``; shared with every equal one."""
        key: Any = z.key if z.key is not None else embedding_key(z, self.charge)
        if key is False:
            return self._new_primitive(word, z, True, span)
        if len(key) > _FEW:
            self.charge(len(key) >> 6)
        entity = self._primitives.get((word, key))
        if entity is None:
            entity = self._primitives[word, key] = self._new_primitive(word, z, False, span)
        elif span is not None and (not entity.places or span is not entity.places[-1]):
            _note_place(entity, span)
        return entity

    def _new_primitive(self, word: str, z: Embedding, tainted: bool, span: Span | None) -> Entity:
        self._count_entity()
        attributes = parts.geometric_attributes(self, z)
        asset = None
        cls = class_of(word)
        if cls.is_file:
            asset, attributes = parts.load_asset(self, attributes)
        shape = cls.made(word, attributes, asset)
        if shape.is_flat:
            self.warn("no-extent", f'the primitive "{word}" has no extent in some direction', span)
        return Entity(word, z, (), shape, tainted, () if span is None else (span,))

    def _count_entity(self) -> None:
        self.entities += 1
        if self.entities > self.limits.entities:
            raise LimitError(
                "entities",
                f"the scene has more than {self.limits.entities:,} distinct entities",
                hint="raise the limit with --max-entities",
            )

    # --- the outside ----------------------------------------------------------------------------------------------

    def print(self, text: str) -> None:
        """Add a line to the log, which has a limit."""
        self._log_size += len(text) + 1
        if self._log_size > self.limits.log:
            self.warn("print-limit", "the log is full; the rest of what the program prints is dropped")
        else:
            self.log.append(text)

    def warn(self, name: str, message: str, span: Span | None = None, hint: str | None = None) -> None:
        """Add a warning, once per place."""
        key = (name, message, span)
        if key not in self.warnings and len(self.warnings) < 1000:
            self.warnings[key] = Diagnostic(name, message, span, hint)


def _known_names(library: Library) -> set[str]:
    from scenelang.interpreter.program.program import prelude_of

    return set(prelude_of(library).names())


def raised_value(error: SceneError) -> Any:
    """What ``guard`` binds: the value that ``raise`` was given, or the error as a Condition."""
    return error.value if error.value is not None else Condition(error)


def root_arguments(runtime: Runtime) -> tuple[Embedding, HandleList]:
    """The root's embedding ``<z1>`` and its endless gamma ``<z2> <z3> ...``."""
    return runtime.handle("z1"), HandleList(2)
