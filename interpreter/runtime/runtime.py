"""State of a single run: words, memoized calls, random streams, meter and log.

Memoization of calls (docs/language.md, "Evaluation and sharing"). The result of a call is stored unless the call drew
random numbers, modified something older than itself, or made a mutable object reachable. Mutable objects older than the
call that it reads are marked ``observed``; its result is then valid only in the current epoch, and modifying an
observed object starts a new epoch. Bindings of words have epochs of their own. Age is determined by birth stamps:
``clock`` numbers the calls, and a mutable object stores the clock at its creation. When a call ends, normally or not,
its reads and writes are merged into those of its caller; a cache hit merges those of the stored call.

Across versions of a program that is edited, a memoized call stays valid while the function of its word is the same
object, since an edit creates every function again that mentions a changed definition. Recording the version of each
definition that a call reads would be finer, but would cost time at every read.
"""

from __future__ import annotations

import copy
import random
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, LimitError, SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.runtime import parts, procedures
from scenelang.interpreter.runtime.procedures import (
    TAIL,
    Closure,
    Condition,
    Escape,
    EscapeSignal,
    RecordProcedure,
    bind_arguments,
    bind_entity,
    check_keywords,
)
from scenelang.interpreter.runtime.show import MAX_LENGTH, described, show
from scenelang.interpreter.runtime.types import Builtin, Library, type_name
from scenelang.interpreter.scene.declarations import Declaration
from scenelang.interpreter.scene.entity import Entity, Frames
from scenelang.interpreter.scene.modelling.operations import Expression
from scenelang.interpreter.scene.modelling.solid import SolidShape
from scenelang.interpreter.scene.part_columns import distinct_entities
from scenelang.interpreter.scene.primitives import class_of, former_word, word_of_today
from scenelang.interpreter.scene.primitives.mesh_file import Asset
from scenelang.interpreter.scene.setup import CAMERA, LIGHT, Declared, Setup, misplaced_setup, with_declared
from scenelang.interpreter.values.limits import Limits, Meter
from scenelang.interpreter.values.values import (
    NIL,
    Embedding,
    HandleList,
    Mutable,
    MutableList,
    Procedure,
    Set,
    Stream,
    Table,
    embedding_key,
    memo_key,
)

if TYPE_CHECKING:
    from scenelang.interpreter.scene.modelling.outlines import Typeface

# The two random streams of a run are numpy's legacy generator and Python's, so that transpiled programs draw the same
# numbers.


class Streams:
    """The two global random streams, created when first used; ``was_used`` is whether either ever was."""

    def __init__(self, seed: int) -> None:
        self.was_used = False
        self._seeds: list[Any] = [seed, seed]  # a number for numpy; for Python a text too
        self._numpy: Any = None
        self._python: random.Random | None = None

    @property
    def numpy(self) -> Any:
        """Stream of type ``numpy.random.RandomState`` (MT19937)."""
        self.was_used = True
        if self._numpy is None:
            from numpy.random import RandomState

            self._numpy = RandomState(self._seeds[0])
        return self._numpy

    @property
    def python(self) -> random.Random:
        """Stream of Python's module ``random`` (MT19937)."""
        self.was_used = True
        if self._python is None:
            self._python = random.Random(self._seeds[1])
        return self._python

    def seed_numpy(self, seed: int) -> None:
        """Seed numpy's stream, at its next use."""
        self._seeds[0], self._numpy = seed, None

    def seed_python(self, seed: float | str) -> None:
        """Seed Python's stream, at its next use."""
        self._seeds[1], self._python = seed, None

    def seed(self, seed: int) -> None:
        """Seed both streams, as is done just before the root is evaluated.

        Draws at top level use the streams as seeded at the start of the run.
        """
        self.seed_numpy(seed)
        self.seed_python(seed)

    def snapshot(self) -> Any:
        """Return the state of both streams, for ``restore``."""
        numpy_state = self._numpy.get_state() if self._numpy is not None else None
        python_state = self._python.getstate() if self._python is not None else None
        return tuple(self._seeds), numpy_state, python_state

    def restore(self, snapshot: Any) -> None:
        """Restore the state of both streams from a ``snapshot``."""
        seeds, numpy_state, python_state = snapshot
        self._seeds, self._numpy, self._python = list(seeds), None, None
        if numpy_state is not None:
            self.numpy.set_state(numpy_state)
        if python_state is not None:
            self.python.setstate(python_state)


# Calls of a function, or turns of a loop, after which it is compiled to Python: that costs about 20 microseconds for
# each line, as much as a hundred or more calls as closures.
HOT = 150
NEVER = 1 << 62  # later than every call
_MAX_CALL_SITES = 16  # locations of a shared primitive that are recorded
_MAX_AGE = 20  # versions of the program after which an unused call is forgotten
_MIN_CHARGED_ITEMS = 32  # the call itself pays for shorter keys and texts
_MAX_WARNINGS = 1000  # of a run


class WordCell(Mutable):
    """Binding of a word, which is older than every call."""

    __slots__ = ("function", "span")

    def __init__(self) -> None:
        self.birth = 0
        self.observed = False
        self.function: Any = None
        self.span: Span | None = None


@dataclass(frozen=True, slots=True)
class Validity:
    """Condition under which memoized calls are valid; equal ones are shared.

    Attributes
    ----------
    epoch
        Epoch of mutable state in which they are valid; None if they read none.
    oldest_read
        Birth stamp of the oldest object that they read, merged on a cache hit.
    bindings
        Epoch of the bindings of words.
    has_output
        Whether the calls printed or warned.
    """

    epoch: int | None
    oldest_read: int
    bindings: int
    has_output: bool


@dataclass(slots=True, eq=False)
class MemoEntry:
    """Memoized call. ``trace`` are the primitives that it called, with their locations, and the memoized calls."""

    value: Any
    validity: Validity
    version: int  # version of the program in which it was used last
    trace: tuple[Any, ...] = ()


@dataclass(frozen=True, slots=True)
class ZEntry:
    """Entry of the embeddings file Z: text and attributes of an embedding (its vectors are used by backends)."""

    text: str | None = None
    attributes: Mapping[str, Any] = field(default_factory=dict)


def _record_call_site(entity: Entity, span: Span) -> None:
    """Record the location of another call that created a shared primitive."""
    if len(entity.call_sites) < _MAX_CALL_SITES and all(site is not span for site in entity.call_sites):
        entity.call_sites = (*entity.call_sites, span)


def _distinct(trace: Sequence[Any]) -> Iterator[Any]:
    """Iterate over the items of a trace, each once."""
    keys = set()
    for item in trace:
        key = id(item) if type(item) is MemoEntry else (id(item[0]), id(item[1]))
        if key not in keys:
            keys.add(key)
            yield item


class Runtime:
    """State of a single run of a program.

    Parameters
    ----------
    library
        Standard library.
    limits
        Resource limits.
    seed
        Seed of the random streams.
    handles
        Entries of the embeddings file Z, by handle.
    memoize
        Whether calls are memoized; disabled only in tests of memoization itself.
    snapshots
        Serial numbers of calls at whose start the state of the random streams is saved; None for all calls.
    asset
        Function ``asset(file, charge)`` that measures a mesh file.
    font
        Function ``font(file, charge)`` that loads a font file.
    image
        Function ``image(file, charge)`` that returns the path of an image of a texture.
    hot
        Number of calls of a procedure, or of turns of a loop, after which it is compiled to a Python function; None to
        run all code as closures.
    """

    def __init__(
        self,
        library: Library,
        limits: Limits | None = None,
        seed: int = 0,
        handles: Mapping[str, ZEntry] | None = None,
        memoize: bool = True,
        snapshots: frozenset[int] | None = frozenset(),
        asset: Callable[[str, Callable[[int], None]], Asset] | None = None,
        hot: int | None = HOT,
        font: Callable[[str, Callable[[int], None]], Typeface] | None = None,
        image: Callable[[str, Callable[[int], None]], str] | None = None,
    ) -> None:
        """Start a run in which nothing is bound or memoized; see the class for the arguments."""
        self.hot = hot
        self.units: list[dict[str, Any]] = []  # namespaces of generated functions
        # Embeddings of calls whose attributes are literals, by the identity of the node, which is kept alive. Closures
        # and generated code of one node share it: two with a list in them are not equal, and the call was made again.
        self.literal_embeddings: dict[int, tuple[Any, Embedding]] = {}
        self.library = library
        self.asset = asset
        self.font = font
        self.image = image
        self.limits = limits or Limits()
        self.meter = Meter(self.limits)
        self.tick = self.meter.tick
        self.charge = self.meter.charge
        self.streams = Streams(seed)
        self.words: dict[str, WordCell] = {}
        self.handles = handles or {}
        self.entities = 0
        # Reads and writes of the innermost call; see the docstring of the module.
        self.clock = 1
        self.serial = 0
        self.oldest_write = NEVER
        self.oldest_read = NEVER
        self.drew_random = False
        self.epoch = 0
        self.bindings = 0  # epoch of the bindings of words
        self.binds = 0  # number of times that a word was bound
        self.place: Callable[[Span], Span] = lambda span: span  # converts spans to the text that the user sees
        self.site: Span | None = None  # location of the last call of a builtin with keywords
        self.version = 0  # version of the program, counted by ``restart``
        self.output = 0  # printed lines, warnings, and primitives that cannot outlive a version
        self.live_primitives: list[Entity] = []  # of this version and those kept from earlier ones
        self.trace: list[Any] | None = None  # see ``MemoEntry``; None in a run of a single version
        self._unkept: dict[int, Any] = {}  # keys of those primitives, by the identity of the entity
        self._memoize = memoize
        self._memo: dict[Any, MemoEntry] = {}
        self._validity = Validity(None, NEVER, 0, False)
        self._primitives: dict[Any, Entity] = {}
        # pending tail call, for the trampoline
        self.next_body: Any = None
        self.next_frame: Any = None
        self.log: list[str] = []
        self._log_size = 0
        self.generated_symbols = 0
        self.warnings: dict[tuple[str, str, Span | None], Diagnostic] = {}
        self.declarations: list[Declaration] = []  # not yet assigned to an entity
        self.form: Any = None  # top-level form that runs; None while the root is evaluated
        self.setups: dict[int, tuple[Any, Setup]] = {}  # cameras, lights, ... that a form declares, by its id
        self._set_up = 0  # number of these declarations
        self._snapshot_at = snapshots
        self.snapshots: dict[int, Any] = {}

    def reset(self, spent: float = 0.0) -> None:
        """Prepare another evaluation in the same run: reset limits, log and warnings.

        ``spent`` is the CPU time in seconds that is used up already (see ``Meter.reset``).
        """
        self.meter.reset(spent)
        self.entities = 0
        self.log.clear()
        self._log_size = 0
        self.warnings.clear()

    def invalidate_calls(self) -> None:
        """Invalidate all memoized calls, after a change of their dependencies that was not tracked."""
        self.epoch += 1
        self._memo.clear()

    def restart(self, seed: int, spent: float = 0.0) -> None:
        """Prepare a run of the next version of the program, which may use memoized calls of earlier versions."""
        self.reset(spent)
        self.declarations.clear()
        self.setups.clear()
        self.version += 1
        self.streams.seed(seed)
        self.generated_symbols = 0
        self.serial, self.drew_random, self.oldest_read, self.oldest_write = 0, False, NEVER, NEVER
        for key in self._unkept.values():
            del self._primitives[key]
        self._unkept.clear()
        self.live_primitives, self.trace = list(self._primitives.values()), []
        for entity in self.live_primitives:
            entity.call_sites = ()

    def forget_output(self) -> None:
        """Forget the memoized calls that printed or warned, so that they do so again."""
        self._memo = {key: entry for key, entry in self._memo.items() if not entry.validity.has_output}

    def keep_calls(self, functions: Mapping[str, Any], bindings: int, epoch: int | None = None) -> None:
        """Forget all memoized calls except current ones of given functions.

        Parameters
        ----------
        functions
            Entity functions that have not changed, by word.
        bindings, epoch
            Epochs in which the calls must be valid: those before the definitions that the functions do not depend on.
            Without ``epoch``, calls that read mutable state are forgotten.
        """
        current = {}
        for key, entry in self._memo.items():
            old = entry.validity
            is_call = len(key) == 4  # function, word, z and gamma; other keys have no word
            is_current = is_call and functions.get(key[1]) is key[0] and old.bindings == bindings
            is_current = is_current and (old.epoch is None or old.epoch == epoch)
            if is_current and not old.has_output and self.version - entry.version <= _MAX_AGE:
                epoch_now = None if old.epoch is None else self.epoch
                entry.validity = self._validity_of(epoch_now, old.oldest_read, self.bindings, has_output=False)
                current[key] = entry
        self._memo = current

    def _validity_of(self, epoch: int | None, oldest_read: int, bindings: int, *, has_output: bool) -> Validity:
        """Return a validity; the last one is reused if it is equal, as it usually is."""
        last = self._validity
        is_same = last.epoch == epoch and last.oldest_read == oldest_read
        if not (is_same and last.bindings == bindings and last.has_output == has_output):
            last = self._validity = Validity(epoch, oldest_read, bindings, has_output)
        return last

    @property
    def kept(self) -> int:
        """Number of objects that are cached for later calls."""
        return len(self._memo) + len(self._primitives) + len(self.units)

    # --- procedures --------------------------------------------------------------------------------------------

    def apply(self, function: Any, args: Sequence[Any]) -> Any:
        """Call a procedure; raise ``SceneError`` if ``function`` is not one."""
        if type(function) is Closure:
            if function.arity == len(args):
                self.tick()
                result = function.code.body([function.env, *args])
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
        """Call a procedure with one argument; a fast path for loops of builtins."""
        if type(function) is Closure and function.arity == 1:
            self.tick()
            result = function.code.entry(function.env, a)
            while result is TAIL:
                self.tick()
                result = self.next_body(self.next_frame)
            return result
        return self.apply(function, (a,))

    def call2(self, function: Any, a: Any, b: Any) -> Any:
        """Call a procedure with two arguments; a fast path for loops of builtins."""
        if type(function) is Closure and function.arity == 2:
            self.tick()
            result = function.code.entry(function.env, a, b)
            while result is TAIL:
                self.tick()
                result = self.next_body(self.next_frame)
            return result
        return self.apply(function, (a, b))

    def apply_other(self, function: Any, args: Sequence[Any]) -> Any:
        """Call a procedure other than a closure."""
        if type(function) is RecordProcedure:
            return function.call(self, args)
        if type(function) is Builtin:
            self.tick()
            return procedures.call_builtin(self, function, args)
        if type(function) is Escape:
            if len(args) > 1:
                raise SceneError(
                    "arity", f"the escape procedure `{function.name}` expects at most 1 argument, got {len(args)}"
                )
            if not function.active:
                raise SceneError("escape", f"`{function.name}` was called after its `let/ec` returned")
            raise EscapeSignal(function, args[0] if args else None)
        raise self.not_a_procedure(function)

    def not_a_procedure(self, value: Any, span: Span | None = None) -> SceneError:
        """Return the error for calling ``value``; ``span`` is the location of the call."""
        message = f"expected a function to call, got {described(value, 60)}"
        hint = 'write a list of values as `(list ...)`, a call of a word as `(call "word" ...)`'
        head = re.match(r"\(([^\s()]+)", span.text) if span is not None and span.expansion is None else None
        if head is not None and head[1] in _known_names(self.library):
            hint = f"the program defines `{head[1]}`, which hides the function: write `std/{head[1]}`, or rename yours"
        return SceneError("not-a-procedure", message, hint=hint)

    # --- tracking of reads and writes ------------------------------------------------------------------------------

    def read(self, value: Mutable) -> None:
        """Record that a mutable object is read."""
        birth = value.birth
        if birth < self.serial:
            value.observed = True
            if birth < self.oldest_read:
                self.oldest_read = birth

    def write(self, value: Mutable) -> None:
        """Record that a mutable object is about to be modified; raise ``SceneError`` for a copy inside an embedding."""
        if value.birth < 0:
            raise SceneError("immutable", "a table that belongs to an embedding cannot be modified")
        if value.observed:
            if type(value) is WordCell:
                self.bindings += 1
            else:
                self.epoch += 1
            value.observed = False
        if value.birth < self.oldest_write:
            self.oldest_write = value.birth

    def show(self, value: Any, limit: int = MAX_LENGTH) -> str:
        """Return ``value`` as text for the program, recording reads of its mutable parts."""
        text = show(value, limit, self.read)
        if len(text) > _MIN_CHARGED_ITEMS:
            self.charge(len(text) >> 3)
        return text

    def display(self, value: Any) -> str:
        """Return ``value`` as text like ``show``, but strings without quotes."""
        return value if type(value) is str else self.show(value)

    def read_error(self) -> None:
        """Record that a program reads the text of an error, which may depend on any mutable state.

        The calls being evaluated are therefore not memoized: the text can show mutable values, whose reads are not
        recorded. ``error-code`` and ``error-is?`` do not count as reading the text.
        """
        self.drew_random = True

    def draw(self, stream: Any = None) -> None:
        """Record that a random number is drawn from ``stream``, or from a global stream if None."""
        if stream is None:
            self.drew_random = True
        else:
            self.write(stream)

    # --- construction of values -----------------------------------------------------------------------------------

    def mutable_list(self, items: list[Any]) -> MutableList:
        """Return a mutable list, born in the current call."""
        self.meter.check_size(len(items), "a list")
        return MutableList(items, self.clock)

    def table_of(self, entries: dict[Any, tuple[Any, Any]]) -> Table:
        """Return a table; ``entries`` maps canonical keys (see ``values.table_key``) to ``(key, value)``."""
        return Table(entries, self.clock)

    def set_of(self, entries: dict[Any, Any]) -> Set:
        """Return a set; ``entries`` maps canonical keys (see ``values.table_key``) to members."""
        return Set(entries, self.clock)

    def handle(self, name: str) -> Embedding:
        """Return the embedding of a handle, with its text and attributes in the embeddings file Z."""
        entry = self.handles.get(name)
        if entry is None:
            return Embedding(name)
        return Embedding(name, entry.text, dict(entry.attributes))

    # --- words and calls ------------------------------------------------------------------------------------------

    def word_cell(self, word: str) -> WordCell:
        """Return the binding of a word, which the calls being evaluated then depend on."""
        cell = self.words.get(word)
        if cell is None:
            cell = self.words[word] = WordCell()
        cell.observed = True
        return cell

    def bind_word(self, word: Any, function: Any, span: Span | None = None) -> None:
        """Bind a word to an entity function, as ``(bind word function)`` at ``span`` does."""
        if type(word) is not str:
            raise SceneError("word", f"`bind` expects a string for the word, got {type_name(word)}")
        if not isinstance(function, Procedure):
            hint = "write an entity function as `(lambda (z gamma) ...)` or `(lambda () ...)`"
            raise SceneError("type", f'`bind` expects a function for "{word}", got {type_name(function)}', hint=hint)
        cell = self.words.get(word)
        if cell is None:
            cell = self.words[word] = WordCell()
        self.write(cell)
        self.binds += 1
        cell.function = function
        cell.span = span

    def call_word(self, word: str, z: Embedding, rest: Any, written: frozenset[str], span: Span | None) -> Entity:
        """Evaluate ``(call word z . rest)``, reusing the result of an equal earlier call if possible.

        ``written`` are the names of the attributes in this call, which the entity function must accept.
        """
        function = self.word_cell(word).function
        if function is None:
            return self.primitive(word, z, span)
        if written and type(function) is Closure:
            check_keywords(function.code, written, word)
        key: Any = z.key if z.key is not None else embedding_key(z, self.charge)
        rest_key = () if rest is NIL else memo_key(rest, self.charge)
        if key is False or rest_key is None or not self._memoize:
            key = False
        else:
            if len(key) + len(rest_key) > _MIN_CHARGED_ITEMS:
                self.charge((len(key) + len(rest_key)) >> 6)  # cost of hashing and comparing the key
            key = (function, word, key, rest_key)
            entry = self._recall(key)
            if entry is not None:
                shared: Entity = entry.value
                return shared
        return self._run_call(word, function, z, rest, key, span)

    def literal_call(self, word: str, z: Embedding, written: frozenset[str], span: Span) -> Callable[[], Entity]:
        """Return a function that evaluates ``(call word ...)`` with literal attributes, as ``call_word`` does.

        It returns the primitive of its last evaluation again as long as that is shared and the word is unbound.
        """
        words, primitives = self.words, self._primitives
        key: Any = None
        last: Entity | None = None

        def call() -> Entity:
            nonlocal key, last
            if last is not None and self.trace is None and words[word].function is None:
                if primitives.get(key) is last and not self._unkept:
                    return last  # the cell stays observed until the word is bound
            entity = self.call_word(word, z, NIL, written, span)
            if entity.shape is not None and type(z.key) is tuple and len(z.key) <= _MIN_CHARGED_ITEMS:
                key, last = (word, z.key), entity
            return entity

        return call

    def save_streams(self, serial: int) -> None:
        """Save the state of the random streams if it was requested for this call."""
        if self._snapshot_at is None or serial in self._snapshot_at:
            self.snapshots[serial] = self.streams.snapshot()

    def _run_call(self, word: str, function: Any, z: Embedding, rest: Any, key: Any, span: Span | None) -> Entity:
        """Evaluate a call that is not memoized, and memoize it under ``key`` unless that is False."""

        def compute(serial: int) -> Entity:
            """Create the entity, with the declarations that its function states."""
            before, set_up = len(self.declarations), self._set_up
            try:
                entity = self.make_entity(word, z, self._entity_parts(word, function, z, rest))
            except SceneError as error:
                del self.declarations[before:]
                error.called(f'"{word}"', span)
                raise
            if len(self.declarations) > before:
                entity.declarations = self.declared_since(before)
            entity.tainted |= self._set_up > set_up
            entity.function, entity.rest, entity.serial = function, rest, serial
            entity.effects = self.oldest_write < serial
            return entity

        result: Entity = self._account(key, compute, lambda entity: entity.tainted)
        return result

    def apply_memoized(self, function: Procedure, z: Embedding, rest: Any) -> Any:
        """Apply an entity function, reusing the result of an equal earlier application as ``call_word`` does.

        Parameters
        ----------
        function
            Entity function.
        z
            Embedding of the entity.
        rest
            List of the embeddings of its descendants (gamma in the paper).

        Returns
        -------
        Any
            Whatever the function returns; unlike ``call_word``, no entity is created from it.
        """
        key: Any = z.key if z.key is not None else embedding_key(z, self.charge)
        rest_key = memo_key(rest, self.charge)
        if key is False or rest_key is None or not self._memoize:
            key = False
        else:
            self.charge((len(key) + len(rest_key)) >> 6)
            key = (function, key, rest_key)
            entry = self._recall(key)
            if entry is not None:
                return entry.value
        before, set_up = len(self.declarations), self._set_up

        def is_tainted(value: Any) -> bool:
            """Declarations belong to the entity around this call, so each such call must state them again."""
            is_stating = len(self.declarations) > before or self._set_up > set_up
            return is_stating or memo_key(value, self.charge) is None

        return self._account(
            key, lambda _serial: self.apply_entity_function(function, function.name, z, rest), is_tainted
        )

    def _recall(self, key: Any) -> MemoEntry | None:
        """Return the memoized call of a key if it is still valid, merging its reads into the current call."""
        entry = self._memo.get(key)
        if entry is None:
            return None
        valid = entry.validity
        if valid.bindings != self.bindings or (valid.epoch is not None and valid.epoch != self.epoch):
            return None
        if valid.oldest_read < self.oldest_read:
            self.oldest_read = valid.oldest_read
        if valid.has_output:
            self.output += 1  # so that the calls around it are forgotten as well and it prints again
        if self.trace is not None:
            if entry.version != self.version:
                self.replay((entry,))
            self.trace.append(entry)
        return entry

    def replay(self, trace: Sequence[Any]) -> None:
        """Record the call sites of primitives as the memoized calls did in an earlier version."""
        stack = list(reversed(trace))
        while stack:
            item = stack.pop()
            if type(item) is MemoEntry:
                if item.version != self.version:
                    item.version = self.version
                    stack.extend(reversed(item.trace))
            elif item[1] is not None:
                _record_call_site(*item)

    def _account(self, key: Any, compute: Callable[[int], Any], is_tainted: Callable[[Any], bool]) -> Any:
        """Run a call while tracking its reads and writes, and memoize its value under ``key`` if that is sound."""
        self.tick()
        serial = self.clock = self.clock + 1
        self.save_streams(serial)
        outer_serial, outer_write, outer_read = self.serial, self.oldest_write, self.oldest_read
        outer_drew, output, bindings = self.drew_random, self.output, self.bindings
        self.serial, self.oldest_write, self.oldest_read, self.drew_random = serial, NEVER, NEVER, False
        traced = len(self.trace) if self.trace is not None else 0
        try:
            value = compute(serial)
            if key is not False and not (self.drew_random or self.oldest_write < serial or is_tainted(value)):
                epoch = None if self.oldest_read >= serial else self.epoch
                valid = self._validity_of(epoch, self.oldest_read, bindings, has_output=self.output != output)
                entry = MemoEntry(value, valid, self.version)
                self._memo[key] = entry
                if self.trace is not None:
                    entry.trace = tuple(_distinct(self.trace[traced:]))
                    self.trace[traced:] = [entry]
            return value
        finally:
            self.serial = outer_serial
            self.drew_random = self.drew_random or outer_drew
            if outer_write < self.oldest_write:
                self.oldest_write = outer_write
            if outer_read < self.oldest_read:
                self.oldest_read = outer_read

    def check_written(self, word: str, written: frozenset[str]) -> None:
        """Raise an error for attributes of a call that the entity function does not accept."""
        function = self.word_cell(word).function
        if written and type(function) is Closure:
            check_keywords(function.code, tuple(written), word)

    def reevaluate(self, entity: Entity, z: Embedding) -> Entity:
        """Create ``entity`` again with another embedding, by calling its entity function."""
        if entity.is_primitive:
            return self.primitive(entity.word, z)
        if entity.function is None:
            return self.make_entity(entity.word, z, entity.children)
        self._snapshot_at = None
        self.entities = 0
        return self._run_call(entity.word, entity.function, z, entity.rest, False, None)

    def _entity_parts(self, word: str, function: Any, z: Embedding, rest: Any) -> Sequence[Any]:
        """Return the parts that an entity function returns."""
        value = self.apply_entity_function(function, word, z, rest)
        if type(value) is Frames:
            raise SceneError("frames", f'the value of "{word}" cannot be frames, because it is not the root')
        return parts.parts_of(self, value, word)

    def apply_entity_function(self, function: Any, word: str, z: Embedding, rest: Any) -> Any:
        """Call an entity function, and return what it returns: an entity or parts, if it is correct.

        Parameters
        ----------
        function
            Closure or builtin. It gets as many of the arguments z and gamma as it has required parameters.
        word
            Word that it is bound to, for error messages.
        z
            Embedding of the entity.
        rest
            List of the embeddings of its descendants (gamma).
        """
        if type(function) is Closure:
            if function.arity == 0:
                result = function.code.entry(function.env)
            elif function.arity == 1:
                result = function.code.entry(function.env, z)
            elif function.arity == 2:
                result = function.code.entry(function.env, z, rest)
            else:
                result = function.body(bind_entity(self, function, word, z, rest))
            while result is TAIL:
                self.tick()
                result = self.next_body(self.next_frame)
            return result
        if type(function) is Builtin:
            return self.apply(function, [z, rest][: len(function.signature.required)])
        return self.apply(function, [z])

    def make_entity(self, word: str, z: Embedding, children: Sequence[Any]) -> Entity:
        """Create an entity with ``children``, pairs ``(Entity . Matrix)``."""
        self._count_entity()
        tainted = (z.key if z.key is not None else embedding_key(z, self.charge)) is False
        if not tainted:
            for entity in distinct_entities(children):
                if entity.tainted:
                    tainted = True
                    break
        return Entity(word, z, children, None, tainted)

    def primitive(self, word: str, z: Embedding, span: Span | None = None) -> Entity:
        """Return the primitive ``word`` with the embedding ``z``, called at ``span``; it is shared with all equal ones.

        Raises SceneError if an attribute is invalid.
        """
        key: Any = z.key if z.key is not None else embedding_key(z, self.charge)
        if key is False:
            return self._new_primitive(word, z, span, tainted=True)
        if len(key) > _MIN_CHARGED_ITEMS:
            self.charge(len(key) >> 6)
        entity = self._primitives.get((word, key))
        if entity is None:
            output = self.output
            entity = self._primitives[word, key] = self._new_primitive(word, z, span, tainted=False)
            if self.output != output:
                self._unkept[id(entity)] = (word, key)
        elif span is not None and (not entity.call_sites or span is not entity.call_sites[-1]):
            _record_call_site(entity, span)
        if self.trace is not None:
            self.trace.append((entity, span))
        if self._unkept and id(entity) in self._unkept:
            self.output += 1
        return entity

    def _new_primitive(self, word: str, z: Embedding, span: Span | None, *, tainted: bool) -> Entity:
        """Create a primitive; one whose file may change, or that warns, is not shared with the next version."""
        self._count_entity()
        attributes = parts.geometric_attributes(self, z)
        asset = None
        cls = class_of(word)
        today = word_of_today(word, attributes) if cls.is_semantic else None
        if today is not None:
            raise SceneError("attribute", former_word(word, today), f'write `(call "{today}" ...)`', span)
        if cls.is_file:
            self.output += 1  # the file may change
            asset, attributes = parts.load_asset(self, attributes)
        shape = cls.from_attributes(word, attributes, asset)
        bytes_ = parts.color_of_bytes(z)
        if bytes_ is not None:
            hint = f"components from 0 to 255 are converted by `rgb`: `(rgb {bytes_[1:-1]})`"
            self.warn("out-of-range", f'`:color` of "{word}" should be 0 to 1, got {bytes_}', span, hint)
        if shape.is_flat:
            self.warn("no-extent", f'the primitive "{word}" has zero extent along some axis', span)
        entity = Entity(word, z, (), shape, tainted, () if span is None else (span,))
        if self.trace is not None:
            self.live_primitives.append(entity)
        return entity

    def solid(self, word: str, z: Embedding, expression: Expression) -> Entity:
        """Return the entity of a computed solid; equal ones, of equal expressions and embeddings, are shared.

        Parameters
        ----------
        word
            Word of the entity: the operation.
        z
            Embedding, with the attributes.
        expression
            Operation with its operands; its ``site`` is where the program creates the entity.
        """
        key: Any = embedding_key(z, self.charge)
        entity = None if key is False else self._primitives.get((expression, key))
        if entity is None:
            self._count_entity()
            shape = SolidShape.of(expression, parts.geometric_attributes(self, z))
            sites = () if expression.site is None else (expression.site,)
            entity = Entity(word, z, (), shape, key is False, sites)
            if key is not False:
                self._primitives[expression, key] = entity
            if self.trace is not None:
                self.live_primitives.append(entity)
        elif expression.site is not None:
            _record_call_site(entity, expression.site)
        if self.trace is not None:
            self.trace.append((entity, expression.site))
        return entity

    def _count_entity(self) -> None:
        """Count a distinct entity; raise ``LimitError`` if there are too many."""
        self.entities += 1
        if self.entities > self.limits.entities:
            raise LimitError(
                "entities",
                f"limit of {self.limits.entities:,} distinct entities exceeded",
                hint="raise the limit with --max-entities",
            )

    # --- output ----------------------------------------------------------------------------------------------------

    def declare(self, declaration: Declaration) -> None:
        """Record a declaration about the entity whose call is being evaluated, or about the scene outside of calls."""
        self.output += 1  # its location changes if the text above it is edited
        self.meter.check_size(len(self.declarations) + 1, "the list of declarations")
        self.declarations.append(declaration)

    def declared_since(self, before: int) -> tuple[Declaration, ...]:
        """Remove the declarations after the first ``before`` and return them."""
        declared = tuple(self.declarations[before:])
        del self.declarations[before:]
        return declared

    def declare_setup(self, item: Declared) -> None:
        """Record a camera, light, ... of the scene, which code at top level states; raises SceneError."""
        if self.form is None:
            raise SceneError("misplaced", *misplaced_setup(item.form))
        self._set_up += 1
        _, setup = self.setups.get(id(self.form), (None, ()))
        self.setups[id(self.form)] = self.form, with_declared(setup, item)

    def begin_form(self, form: Any) -> None:
        """Begin to run a top-level form, which states its declarations anew."""
        self.form = form
        self.setups.pop(id(form), None)

    def setup_of(self, forms: Iterable[Any]) -> Setup:
        """Return what the top-level forms declare, in their order; raises SceneError for duplicates."""
        setup: Setup = ()
        for form in forms if self.setups else ():
            for item in self.setups.get(id(form), (None, ()))[1]:
                setup = with_declared(setup, item)
        return setup

    def print(self, text: str) -> None:
        """Append a line to the log, up to the limit of its size."""
        self.output += 1
        self._log_size += len(text) + 1
        if self._log_size > self.limits.log:
            self.warn("print-limit", "the log is full; further output of the program is discarded")
        else:
            self.log.append(text)

    def warn(self, name: str, message: str, span: Span | None = None, hint: str | None = None) -> None:
        """Add the warning ``name`` with a message and a hint; the same one at the same ``span`` is added once.

        Warnings beyond a maximum number are dropped.
        """
        self.output += 1
        key = (name, message, span)
        if key not in self.warnings and len(self.warnings) < _MAX_WARNINGS:
            self.warnings[key] = Diagnostic(name, message, span, hint)


def _known_names(library: Library) -> set[str]:
    """Return the predefined names; names of the prelude that start with `%` are private to it."""
    return {*library.builtins, *library.constants, *(name for name in library.prelude_names if name[0] != "%")}


def raised_value(error: SceneError) -> Any:
    """Return the value that ``guard`` binds: the operand of ``raise``, or the error as a Condition."""
    return error.value if error.value is not None else Condition(error)


def root_arguments(runtime: Runtime) -> tuple[Embedding, HandleList]:
    """Return the root's embedding ``<z1>`` and its infinite list gamma, ``<z2> <z3> ...``."""
    return runtime.handle("z1"), HandleList(2)


# Undo log: a runtime whose changes can be rolled back if an evaluation fails.


_EXCLUDED = ("birth", "observed")  # slots that a rollback does not restore


class JournaledRuntime(Runtime):
    """Runtime with an undo log: from ``begin`` on, the state of every older object is saved before it changes."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._journal: dict[int, tuple[Mutable, dict[str, Any]]] = {}
        self._start = 0
        self._streams = self.streams.snapshot()
        self._declared = 0
        self._setups = self.setups

    def begin(self) -> None:
        """Start a transaction, whose changes can be rolled back."""
        self._journal = {}
        self.clock += 1
        self._start = self.clock
        self._streams = self.streams.snapshot()
        self._declared = len(self.declarations)
        self._setups = dict(self.setups)
        self.drew_random = False

    @property
    def has_changed(self) -> bool:
        """Whether an object older than the transaction was modified, a random number drawn, or a camera declared."""
        return bool(self._journal) or self.drew_random or self.setups != self._setups

    @property
    def has_written(self) -> bool:
        """Whether an object older than the transaction was modified."""
        return bool(self._journal)

    def has_written_other(self, cells: Sequence[Mutable]) -> bool:
        """Return whether an object older than the transaction was modified that is not one of ``cells``."""
        return not self._journal.keys() <= set(map(id, cells))

    def roll_back(self) -> None:
        """Roll back all changes since the start of the transaction."""
        for target, state in self._journal.values():
            for name, value in state.items():
                setattr(target, name, value)
        self.streams.restore(self._streams)
        del self.declarations[self._declared :]
        self.setups = dict(self._setups)
        if self._journal:
            self.invalidate_calls()
        self._journal = {}

    def setup_of(self, forms: Iterable[Any]) -> Setup:
        """Return what the top-level forms declare; later ones replace those of their name, as definitions do."""
        latest: dict[Any, Declared] = {}
        for form in forms:
            for item in self.setups.get(id(form), (None, ()))[1]:
                is_single = item.name or item.form != LIGHT
                key = (item.form, item.name if item.form in (CAMERA, LIGHT) else "") if is_single else len(latest)
                latest.pop(key, None)
                latest[key] = item
        return tuple(latest.values())

    def write(self, value: Mutable) -> None:
        """Save the state of an older object before its first change."""
        if 0 <= value.birth < self._start and id(value) not in self._journal:
            self._journal[id(value)] = value, _state(value)
        super().write(value)


def _state(target: Mutable) -> dict[str, Any]:
    """Return the state of a mutable object: containers and generators are copied, values keep their identity."""
    state = {name: getattr(target, name) for name in type(target).__slots__ if name not in _EXCLUDED}
    if isinstance(target, Stream):
        return {name: copy.deepcopy(value) for name, value in state.items()}
    return {
        name: copy.copy(value) if isinstance(value, (list, dict, np.ndarray)) else value
        for name, value in state.items()
    }
