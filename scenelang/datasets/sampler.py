"""Drawing of samples: a spec and a number decide everything about a sample.

Every quantity of every sample has its own random stream, keyed by the spec's seed, the sample's number, the attempt and
the quantity's name. A sample is therefore the same for any number of workers, in any order, after any
interruption, and alone; and adding a quantity changes no other.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np

from scenelang.backends.pictures.camera import Viewpoint, read_camera
from scenelang.backends.pictures.declared import View
from scenelang.backends.pictures.viewpoints import hemisphere_views, orbit_views, trajectory_views
from scenelang.datasets.spec import CameraPlan, Distribution, Spec
from scenelang.grammar.diagnostics import SceneError

KEY_DIGITS = 9  # of a sample's key, so that keys sort as numbers


def stream(seed: int, *names: object) -> np.random.Generator:
    """Return the random stream of one quantity: Philox, keyed by the digest of the names.

    Examples
    --------
    >>> stream(7, 0, "size").random() == stream(7, 0, "size").random() != stream(7, 1, "size").random()
    True
    """
    text = json.dumps([seed, *map(str, names)])
    digest = hashlib.blake2b(text.encode("utf-8", "surrogatepass"), digest_size=16).digest()
    return np.random.Generator(np.random.Philox(key=int.from_bytes(digest, "little")))


@dataclass(frozen=True, slots=True)
class Draw:
    """Drawn quantities of one sample.

    Attributes
    ----------
    values
        Drawn quantities by name, for the sample's record and statistics.
    looks, binds
        Attributes and expressions by word.
    seed
        Seed of the program.
    """

    index: int
    attempt: int
    program: str
    seed: int
    params: Mapping[str, Any]
    looks: Mapping[str, Mapping[str, Any]]
    binds: Mapping[str, str]
    environment: str
    ground: str | None
    quality: str
    split: str
    values: Mapping[str, Any]

    @property
    def scene_key(self) -> str:
        """Key of the quantities that decide the evaluated scene."""
        return json.dumps([self.program, self.seed, self.params, self.looks, self.binds], sort_keys=True)


def key_of(index: int) -> str:
    """Return the key of a sample; keys sort as their numbers do.

    Examples
    --------
    >>> key_of(42)
    '000000042'
    """
    return f"{index:0{KEY_DIGITS}d}"


def index_of(key: str) -> int:
    """Return the number of a sample's key, or of the key of one of its images; raises SceneError("value")."""
    number = key.partition("-")[0]
    if not (number.isascii() and number.isdecimal() and len(number) <= 18):
        raise SceneError("value", f"`{key[:60]}` is not the key of a sample", f"such as {key_of(42)}")
    return int(number)


def draw_sample(spec: Spec, index: int, attempt: int = 0) -> Draw | None:
    """Return the sample of a number, None if it is not assigned to a split.

    A split by scene is decided by the draw here, and again by the evaluated scene when the sample is made.
    """

    def random(*names: object) -> np.random.Generator:
        """Return the stream of a quantity of this sample."""
        return stream(spec.seed, index, attempt, *names)

    program = spec.programs[int(random("program").integers(len(spec.programs)))]
    seed = int(random("seed").integers(1 << 32)) if spec.seeds is None else int(spec.seeds.draw(random("seed")))
    params = {name: param.draw(random("param", name)) for name, param in spec.params.items()}
    looks = {
        word: {name: look.draw(random("word", word, name)) for name, look in change.looks.items()}
        for word, change in spec.words.items()
        if change.looks
    }
    binds = {
        word: str(change.bind.draw(random("bind", word)))
        for word, change in spec.words.items()
        if change.bind is not None
    }
    environment = str(spec.pictures.environment.draw(random("environment")))
    ground = spec.pictures.ground.draw(random("ground"))
    quality = str(spec.pictures.quality.draw(random("quality")))
    values: dict[str, Any] = {"program": spec.program_name(program), "seed": seed}
    values |= {f"param.{name}": value for name, value in params.items()}
    values |= {f"{word}.{name}": value for word, look in looks.items() for name, value in look.items()}
    values |= {f"{word}.bind": text for word, text in binds.items()}
    values |= {"environment": environment, "ground": ground, "quality": quality}
    split = _split(spec, program, params, values)
    if split is None:
        return None
    return Draw(index, attempt, program, seed, params, looks, binds, environment, ground, quality, split, values)


_OUTSIDE_SCENE = ("environment", "ground", "quality", "program")  # quantities that do not change the evaluated scene


# --- splits ----------------------------------------------------------------------------------------------------------


def _split(spec: Spec, program: str, params: Mapping[str, Any], values: Mapping[str, Any]) -> str | None:
    """Return the split of a draw, None if no rule matches."""
    plan = spec.splits
    if plan is None:
        return "train"
    if plan.by == "program":
        return split_of_program(spec, program)
    if plan.by == "scene":
        scene = {name: value for name, value in values.items() if name not in _OUTSIDE_SCENE}
        return split_of_scene(spec, json.dumps([spec.texts[program], scene], sort_keys=True, default=list))
    return _by_value(plan.rules, params[plan.by])


def split_of_scene(spec: Spec, scene: str) -> str:
    """Return the split of all samples of one scene; ``scene`` is a text that equal scenes share."""
    assert spec.splits is not None
    return _by_share(spec.splits.rules, float(stream(spec.seed, "split", scene).random()))


def _by_share(rules: Mapping[str, float], place: float) -> str:
    """Return the split at the position ``place`` from 0 to 1 of the concatenated shares."""
    end = 0.0
    for name, share in rules.items():
        end += share
        if place < end:
            return name
    return list(rules)[-1]


def _by_value(rules: Mapping[str, Any], value: Any) -> str | None:
    """Return the split of a param's value, None if no rule matches."""
    rest = None
    for name, rule in rules.items():
        if rule == "rest":
            rest = name
        elif isinstance(rule, dict):
            low, high = rule["range"]
            if isinstance(value, int | float) and low <= value < high:
                return name
        elif value in rule:
            return name
    return rest


def split_of_program(spec: Spec, path: str) -> str | None:
    """Return the split of a program: by the first pattern that matches it, or dealt by shares.

    Programs of equal text are in one split, whatever their names.
    """
    assert spec.splits is not None
    rules = spec.splits.rules
    if all(isinstance(rule, float) for rule in rules.values()):
        return _dealt(spec)[spec.texts[path]]
    rest = next((name for name, rule in rules.items() if rule == "rest"), None)
    return spec.matched_splits.get(spec.texts[path], rest)


def _dealt(spec: Spec) -> dict[str, str]:
    """Return the split of each text: shuffled by the seed, then cut by the shares, at least one text in each."""
    assert spec.splits is not None
    return _deal(spec.seed, tuple(sorted(set(spec.texts.values()))), tuple(spec.splits.rules.items()))


@lru_cache(maxsize=8)
def _deal(seed: int, texts: tuple[str, ...], shares: tuple[tuple[str, float], ...]) -> dict[str, str]:
    """Return the split of each text: shuffled by the seed, then cut by the shares."""
    order = sorted(texts, key=lambda text: stream(seed, "deal", text).random())
    ends = np.cumsum([share for _, share in shares]) * len(order)
    cuts = [round(float(end)) for end in ends]
    for i in range(len(cuts)):  # no split is empty if there are enough programs
        cuts[i] = min(max(cuts[i], (cuts[i - 1] if i else 0) + 1), len(order))
    cuts[-1] = len(order)
    names = [name for name, _ in shares]
    return {text: names[next(i for i, cut in enumerate(cuts) if place < cut)] for place, text in enumerate(order)}


# --- cameras ---------------------------------------------------------------------------------------------------------


def views_of(spec: Spec, draw: Draw) -> tuple[View, ...]:
    """Return the cameras of a sample; raises SceneError for a camera file that cannot be read."""
    plan = spec.cameras

    def random(*names: object) -> np.random.Generator:
        """Return the stream of a quantity of this sample."""
        return stream(spec.seed, draw.index, draw.attempt, "camera", *names)

    if plan.kind == "file":
        return tuple(
            read_camera(plan.files[(draw.index * plan.views + i) % len(plan.files)]) for i in range(plan.views)
        )
    if plan.kind == "trajectory":
        assert plan.target is not None
        size = (spec.pictures.width, spec.pictures.height)
        return trajectory_views(plan.eyes, plan.target, plan.views, float(plan.fov.draw(random("fov"))), size)
    if plan.kind == "orbit":
        return orbit_views(_viewpoint(plan, random), plan.views, plan.sweep)
    if _is_default(plan.azimuth, "azimuth") and _is_default(plan.elevation, "elevation"):
        like = _viewpoint(plan, random)
        return hemisphere_views(plan.views, random("hemisphere"), like)
    return tuple(_viewpoint(plan, partial(random, i)) for i in range(plan.views))


def _is_default(quantity: Distribution, name: str) -> bool:
    """Return whether a quantity of the cameras is as by default."""
    return bool(quantity == getattr(CameraPlan(), name))


def _viewpoint(plan: CameraPlan, random: Any) -> Viewpoint:
    """Draw a camera on the hemisphere."""
    distance = plan.distance.draw(random("distance"))
    return Viewpoint(
        azimuth=float(plan.azimuth.draw(random("azimuth"))),
        elevation=float(plan.elevation.draw(random("elevation"))),
        distance=None if distance is None else float(distance),
        fov=float(plan.fov.draw(random("fov"))),
        target=plan.target,
        orthographic=plan.orthographic,
    )
