"""Drives samples: sends what they ask, side by side or as batches, records everything, and answers from the records."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from threading import Event, Thread

from scenelang.backends.language_models.client import Answer, Client
from scenelang.backends.language_models.conversation import Reply
from scenelang.grammar.diagnostics import SceneError
from scenelang.inference.live_count import LiveCount
from scenelang.inference.records import Run
from scenelang.inference.steps import Ask, Outcome, Steps, Told

_GLANCE = 0.1  # seconds between looks at Ctrl-C
_FIRST_WAIT, _LONGEST_WAIT, _LONGER = 0.5, 30.0, 1.5  # seconds between looks at a batch
_LONGEST_BATCH = 25 * 3600.0  # a day, after which batches expire, and an hour
Ended = Outcome | SceneError


class Cancelled(BaseException):
    """Ctrl-C reached a sample's thread."""


class _Progress:
    """One sample under way: its generator and what it waits for."""

    def __init__(self, sample: int, steps: Steps) -> None:
        self.sample = sample
        self.number = 0
        self.ask: Ask | None = None
        self.ended: Ended | None = None
        self._steps = steps

    def begin(self, run: Run) -> None:
        self._go(run, lambda: next(self._steps))

    def answer(self, run: Run, reply: Reply) -> None:
        self._go(run, lambda: self._steps.send(reply))

    def fail(self, run: Run, error: SceneError) -> None:
        self._go(run, lambda: self._steps.throw(error))

    def _go(self, run: Run, first: Callable[[], Ask | Told]) -> None:
        """Go on to the next question, or to the end."""
        try:
            step = first()
            while isinstance(step, Told):
                assert self.ask is not None
                run.judged(self.sample, self.number, self.ask.purpose.value, step.verdict)
                step = self._steps.send(None)
        except StopIteration as end:
            self.ask, self.ended = None, end.value
        except SceneError as error:
            self.ask, self.ended = None, error
        else:
            self.ask, self.number = step, self.number + 1


class Conductor:
    """Runs samples of one run with one client."""

    def __init__(self, client: Client, run: Run, live: LiveCount, side_by_side: int = 4) -> None:
        self._client = client
        self._run = run
        self._live = live
        self._side_by_side = side_by_side
        self._cancelled = Event()

    # --- single requests -------------------------------------------------------------------------------------------

    def singly(self, samples: Mapping[int, Steps]) -> dict[int, Ended]:
        """Run samples side by side, each with its own requests. Ctrl-C ends them and leaves the records."""
        waiting = [_Progress(sample, steps) for sample, steps in samples.items()]
        done: dict[int, Ended] = {}
        faults: list[BaseException] = []

        def work() -> None:
            while waiting and not self._cancelled.is_set():
                try:
                    progress = waiting.pop(0)
                except IndexError:
                    return
                try:
                    done[progress.sample] = self._played(progress)
                except BaseException as fault:
                    faults.append(fault)
                    return

        threads = [Thread(target=work, daemon=True) for _ in range(min(self._side_by_side, len(waiting)))]
        for thread in threads:
            thread.start()
        try:
            while any(thread.is_alive() for thread in threads):
                threads[0].join(_GLANCE) if threads[0].is_alive() else time.sleep(_GLANCE)
        except KeyboardInterrupt:
            self._cancelled.set()
            raise
        finally:
            self._live.end()
        if faults:
            raise faults[0]
        return {sample: done[sample] for sample in samples}

    def _played(self, progress: _Progress) -> Ended:
        progress.begin(self._run)
        while progress.ask is not None:
            try:
                answer = self._answer(progress, progress.ask)
            except SceneError as error:
                progress.fail(self._run, error)
            else:
                progress.answer(self._run, answer.reply)
        assert progress.ended is not None
        return progress.ended

    def _answer(self, progress: _Progress, ask: Ask) -> Answer:
        """From the records, else from the service."""
        sample, number, purpose = progress.sample, progress.number, ask.purpose.value
        key = self._client.key(ask.request, sample, number)
        answer = self._run.recorded(sample, number, key)
        if answer is not None:
            return answer
        self._run.asked(sample, number, purpose, self._client.payload(ask.request))
        count = self._live.counting(sample, number, purpose)

        def watch(text: str) -> None:
            if self._cancelled.is_set():
                raise Cancelled
            count(text)

        with self._run.sending(sample, number, purpose) as note:
            answer = self._client.ask(ask.request, sample, number, watch, note)
        self._run.answered(sample, number, purpose, key, answer)
        return answer

    # --- batches ---------------------------------------------------------------------------------------------------

    def in_batches(self, samples: Mapping[int, Steps]) -> dict[int, Ended]:
        """Run samples in rounds: what all of them ask goes out as one batch."""
        going = [_Progress(sample, steps) for sample, steps in samples.items()]
        for progress in going:
            progress.begin(self._run)
        while any(progress.ask is not None for progress in going):
            self._round([progress for progress in going if progress.ask is not None])
        return {progress.sample: progress.ended for progress in going if progress.ended is not None}

    def _round(self, going: Sequence[_Progress]) -> None:
        """Answer every question of a round: from the records, from earlier runs, and the rest by one batch."""
        left: dict[str, tuple[_Progress, Ask, str]] = {}
        for progress in going:
            ask = progress.ask
            assert ask is not None
            key = self._client.key(ask.request, progress.sample, progress.number)
            answer = self._run.recorded(progress.sample, progress.number, key)
            if answer is None and (answer := self._client.kept(key)) is not None:
                self._take(progress, ask, key, answer)
            elif answer is not None:
                progress.answer(self._run, answer.reply)
            else:
                left[f"sample-{progress.sample}-{progress.number}"] = (progress, ask, key)
        if left:
            self._batch(left)

    def _batch(self, left: Mapping[str, tuple[_Progress, Ask, str]]) -> None:
        keys = {name: key for name, (_, _, key) in left.items()}
        try:
            batch, reserved = self._submitted(keys, {name: ask for name, (_, ask, _) in left.items()})
            self._wait(batch)
            answers = self._client.collect(batch, reserved)
        except SceneError as error:
            for progress, _, _ in left.values():
                progress.fail(self._run, error)
            return
        for name, (progress, ask, key) in left.items():
            answer = answers.get(name, SceneError("model-request", "the batch has no answer to this question"))
            if isinstance(answer, SceneError):
                progress.fail(self._run, answer)
            else:
                self._client.keep(key, answer.reply)
                self._take(progress, ask, key, answer)
        self._run.note(batch=None)

    def _submitted(self, keys: Mapping[str, str], asks: Mapping[str, Ask]) -> tuple[str, dict[str, float]]:
        """A batch under way: the one that was sent before the run was interrupted, maybe amid its answers, else a new
        one; and the dollars that are set aside for each question."""
        sent = self._sent(keys)
        if sent is not None:
            self._client.spending.reserve(sum(sent[1].values()))
            return sent
        for name, ask in asks.items():
            sample, number = (int(piece) for piece in name.split("-")[1:])
            self._run.asked(sample, number, ask.purpose.value, self._client.payload(ask.request))
        batch, reserved = self._client.submit({name: ask.request for name, ask in asks.items()})
        self._run.note(batch={"id": batch, "reserved": reserved, "keys": dict(keys)})
        return batch, reserved

    def _sent(self, keys: Mapping[str, str]) -> tuple[str, dict[str, float]] | None:
        """The batch that the run's records say is under way, where it holds all these questions."""
        sent = self._run.facts.get("batch")
        if sent is None:
            return None
        try:
            if not keys.items() <= sent["keys"].items():
                return None
            return str(sent["id"]), {name: float(sent["reserved"][name]) for name in keys}
        except (KeyError, TypeError, ValueError, AttributeError):
            raise SceneError("run", f"the run {self._run.name} is damaged: its batch cannot be read") from None

    def _wait(self, batch: str) -> None:
        """Wait until a batch is done. Raises SceneError for one that never is."""
        provider, wait, started = self._client.batches(), _FIRST_WAIT, time.monotonic()
        try:
            while count := provider.pending(batch):
                if time.monotonic() - started > _LONGEST_BATCH:
                    raise SceneError("model-request", "the batch is not done after a day", "look again with --resume")
                self._live.waiting(count)
                time.sleep(wait)
                wait = min(_LONGEST_WAIT, wait * _LONGER)
        finally:
            self._live.end()

    def _take(self, progress: _Progress, ask: Ask, key: str, answer: Answer) -> None:
        """Record an answer that came otherwise than by a single request, and go on with it."""
        self._run.answered(progress.sample, progress.number, ask.purpose.value, key, answer)
        progress.answer(self._run, answer.reply)
