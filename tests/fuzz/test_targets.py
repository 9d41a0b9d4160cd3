"""Every target of the fuzzer: a few new inputs each, and the inputs that were once too much for it.

`make fuzz TARGET=reader N=20000` runs one for long; what it finds belongs in the folder ``corpus``."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from searching import many

from fuzz.running import examine, examples
from fuzz.targets import ALL, Target

CORPUS = Path(__file__).with_name("corpus")
BY_NAME = {target.name: target for target in ALL}
KEPT = sorted(path for path in CORPUS.glob("*/*") if path.is_file())
FEW = {"options": 6, "programs": 6, "repl": 4, "runs": 8}


@pytest.mark.search
@pytest.mark.parametrize("target", ALL, ids=lambda target: target.name)
@pytest.mark.sampled(2)
def test_a_few_inputs(target: Target) -> None:
    target.check(target.make(random.Random(0)))  # loads modules
    found = examples(target, many(FEW.get(target.name, 12)))
    assert found is None, found


@pytest.mark.parametrize("path", KEPT, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_what_was_found_once(path: Path) -> None:
    examine(BY_NAME[path.parent.name], path.read_bytes())


def test_a_finding_is_told_with_its_input() -> None:
    def fail(data: bytes) -> None:
        raise KeyError(len(data))

    found = examples(Target("failing", lambda rng: rng.randbytes(3), fail), 5)
    assert found is not None
    assert (found.kind.split(" ")[0], len(found.data)) == ("KeyError", 3)
