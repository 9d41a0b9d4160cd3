"""Running a target by Hypothesis, in batches that go on where the last ones ended. A finding is kept as a file and does
not stop the run: another of its kind is passed over."""

from __future__ import annotations

import contextlib
import faulthandler
import json
import random
import time
import traceback
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st
from hypothesis.database import DirectoryBasedExampleDatabase

from fuzz.targets import Target
from scenelang.interpreter.values.limits import resident_bytes

_MOST_GROWTH = 900_000_000
_STUCK = 120.0


class TooSlow(Exception):
    """An input that took longer than its target allows."""


class TooLarge(Exception):
    """An input after which the process held far more memory."""


def examine(target: Target, data: bytes) -> None:
    """Check one input, its time and its memory."""
    before, start = resident_bytes(), time.monotonic()
    target.check(data)
    took = time.monotonic() - start
    if took > target.seconds:
        raise TooSlow(f"{took:.1f} s")
    if resident_bytes() - before > _MOST_GROWTH:
        raise TooLarge(f"{(resident_bytes() - before) / 1e6:.0f} MB")


def signature(error: BaseException) -> str:
    """What findings of one kind have in common: the error and the place in the package that it came from."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if "/tests/" not in f.filename]
    place = f"{Path(frames[-1].filename).name}:{frames[-1].name}" if frames else str(error)[:60]
    return f"{type(error).__name__} in {place}"


def examples(
    target: Target, count: int, batch: int = 0, database: Path | None = None, known: set[str] | None = None
) -> Finding | None:
    """Try ``count`` inputs; the first finding of a kind that is not known."""
    passed_over = known if known is not None else set()
    found: list[Finding] = []

    @seed(batch)
    @settings(
        max_examples=count, deadline=None, derandomize=False, phases=[Phase.reuse, Phase.generate], suppress_health_check=list(HealthCheck),
        database=DirectoryBasedExampleDatabase(database) if database is not None else None,
    )  # fmt: skip
    @given(st.integers(0, 2**64))
    def trial(number: int) -> None:
        data = target.make(random.Random(f"{batch} {number}"))
        try:
            examine(target, data)
        except Exception as error:
            kind = signature(error)
            if kind not in passed_over:
                passed_over.add(kind)
                found.append(Finding(kind, str(error)[:300], data))
        tried[0] += 1

    tried = [0]
    trial()
    return Finding.of(found, tried[0])


@dataclass(frozen=True)
class Finding:
    """An input that a target does not bear, with those found after it and how many inputs were tried."""

    kind: str
    message: str
    data: bytes
    more: tuple[Finding, ...] = ()
    tried: int = field(default=0, compare=False)

    @staticmethod
    def of(found: list[Finding], tried: int) -> Finding | None:
        if not found:
            return None
        first = found[0]
        return Finding(first.kind, first.message, first.data, tuple(found[1:]), tried)


def run(target: Target, wanted: int, folder: Path, batch: int = 500) -> dict[str, Any]:
    """Try inputs until there were ``wanted`` in all, also over several runs; what ``folder`` says afterwards."""
    folder.mkdir(parents=True, exist_ok=True)
    account = folder / f"{target.name}.json"
    told = (
        json.loads(account.read_text())
        if account.exists()
        else {"tried": 0, "batches": 0, "seconds": 0.0, "findings": []}
    )
    known = {kind for kind, _, _ in told["findings"]}
    with contextlib.suppress(Exception):
        target.check(target.make(random.Random(0)))  # loads modules
    while told["tried"] < wanted:
        start = time.monotonic()
        faulthandler.dump_traceback_later(max(_STUCK, batch * target.seconds), exit=True)
        count = min(batch, wanted - told["tried"])
        first = examples(target, count, told["batches"] + 1, folder / "examples" / target.name, known)
        faulthandler.cancel_dump_traceback_later()
        for finding in (first, *first.more) if first is not None else ():
            path = folder / "found" / target.name / f"{len(told['findings'])}"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(finding.data)
            told["findings"].append([finding.kind, finding.message, str(path)])
            print(f"{target.name}: {finding.kind}: {finding.message[:200]}", flush=True)
        told["tried"] += count
        told["batches"] += 1
        told["seconds"] = round(told["seconds"] + time.monotonic() - start, 1)
        account.write_text(json.dumps(told, indent=1))
    return told
