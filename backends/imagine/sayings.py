"""What the model is told of each place of a layout."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from scenelang.backends.clip.conditions import Condition
from scenelang.backends.clip.granularity import IntArray
from scenelang.backends.clip.sentences import Sentences
from scenelang.backends.imagine.layout import Layout
from scenelang.backends.maps.truth import Truth


def conditions_in(layout: Layout, truth: Truth, units: IntArray, sentences: Sentences) -> list[Condition]:
    """The condition of every place; ``units`` (M,) are what each instance counts as. Raises SceneError("value")."""
    primitives = truth.ancestry.primitives
    of = units[primitives]
    return [
        sentences.condition(place.instance, primitives[np.flatnonzero(of == place.instance)].tolist())
        for place in layout.places
    ]


def handles_in(conditions: Sequence[Condition]) -> set[str]:
    """The handles of what the conditions are said of."""
    return {handle for condition in conditions for handle in condition.handles}
