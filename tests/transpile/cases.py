"""The programs that the tests of the translation share, and how their outcome is looked at."""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from corpus.compare import feature

from scenelang.grammar.datum import Source, print_datum
from scenelang.grammar.diagnostics import Diagnostic, render_text
from scenelang.grammar.reader import read
from scenelang.interpreter.runtime.show import primitive_attributes
from scenelang.interpreter.scene.entity import Scene
from scenelang.interpreter.scene.flatten import flatten
from scenelang.interpreter.transpile.analysis.python_text import find_code
from scenelang.interpreter.transpile.translate import Translation, translate
from scenelang.session.session import Evaluated, Session

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Case:
    """A response and its golden geometry."""

    path: Path
    golden: Path

    @property
    def name(self) -> str:
        return self.path.stem

    @cached_property
    def text(self) -> str:
        return self.path.read_text("utf-8")

    @cached_property
    def code(self) -> str:
        """The Python between the fences."""
        found = find_code(self.text)
        return found.code(self.text)

    def golden_scene(self) -> Any:
        """It as read, not to be changed; the tests of one case come one after the other."""
        return _golden(self.golden)


@lru_cache(maxsize=2)
def _golden(path: Path) -> Any:
    data = path.read_bytes()
    return json.loads(gzip.decompress(data) if path.suffix == ".gz" else data)


def _cases(texts: Path, goldens: Path) -> list[Case]:
    found = []
    for path in sorted(texts.glob("*.txt")):
        plain, packed = goldens / f"{path.stem}.json", goldens / f"{path.stem}.json.gz"
        if plain.exists() or packed.exists():
            found.append(Case(path, packed if packed.exists() else plain))
    return found


CORPUS = _cases(HERE / "responses", HERE / "golden")
IMITATIONS = [
    case
    for folder in sorted(HERE.glob("programs*"))
    for case in _cases(folder, folder.with_name(f"golden_{folder.name}"))
]

_translations: dict[Path, Translation] = {}


def translated(case: Case) -> Translation:
    """The translation of a case, worked out once."""
    if case.path not in _translations:
        _translations[case.path] = translate(Source(str(case.path), case.text))
    return _translations[case.path]


@lru_cache(maxsize=2)
def scene_of_case(case: Case) -> Scene:
    """The scene of a case's translation; the tests of one case come one after the other."""
    return scene_of(f"{case.name}.scene", translated(case).text)


@lru_cache(maxsize=2)
def flattened_case(case: Case) -> Any:
    """It as `scenelang flatten --json` gives it, not to be changed."""
    return flattened(scene_of_case(case))


def told(diagnostics: Iterable[Diagnostic]) -> str:
    return "\n".join(render_text(d) for d in diagnostics)


def evaluated(name: str, text: str) -> Evaluated:
    return Session().evaluate(Source(name, text))


def scene_of(name: str, text: str) -> Scene:
    """The scene of a program that must be right."""
    result = evaluated(name, text)
    assert result.scene is not None, f"{told(result.diagnostics)}\n{text}"
    return result.scene


def flattened(scene: Scene) -> Any:
    """The scene as `scenelang flatten --json` gives it."""
    frames = []
    for frame in flatten(scene).frames:
        rows = []
        for i in range(len(frame)):
            entity = frame.primitives[frame.index[i]]
            matrix = [*frame.matrices[i].tolist(), [0.0, 0.0, 0.0, 1.0]]
            rows.append({"word": entity.word, "attributes": primitive_attributes(entity), "matrix": matrix})
        frames.append({"primitives": rows})
    return json.loads(json.dumps({"frames": frames}))


def printed(text: str) -> list[str]:
    """Each form of a program on one line; the program must read without complaint."""
    result = read(Source("<translation>", text))
    assert not result.diagnostics, told(result.diagnostics)
    return [print_datum(form) for form in result.forms]


def first_difference(ours: Any, golden: Any) -> str | None:
    """What differs between two flattened scenes whose primitives come in the same order; lengths to 1e-4."""
    if len(ours["frames"]) != len(golden["frames"]):
        return f"{len(ours['frames'])} frames instead of {len(golden['frames'])}"
    for number, (a, b) in enumerate(zip(ours["frames"], golden["frames"])):
        left, right = ([feature(p) for p in frame["primitives"]] for frame in (a, b))
        if len(left) != len(right):
            return f"frame {number}: {len(left)} primitives instead of {len(right)}"
        for i, (p, q) in enumerate(zip(left, right)):
            if not _same_primitive(p, q):
                return f"frame {number}, primitive {i}: {p} instead of {q}"
    return None


def _same_primitive(a: Any, b: Any) -> bool:
    if a[0] != b[0]:
        return False
    lengths = np.allclose(a[1], b[1], atol=1e-4, rtol=1e-4)
    moments = np.allclose(a[2], b[2], atol=1e-4, rtol=1e-3)
    look = a[3] == b[3] if a[0] == "block" else np.allclose(a[3], b[3], atol=2e-3)
    return bool(lengths and moments and look)
