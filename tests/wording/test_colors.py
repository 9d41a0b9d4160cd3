"""Colors and the words for them."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenelang.backends.neural.descriptions import color_names, color_words, mentions_color, named_points, oklab
from scenelang.backends.surfaces.image_files import from_srgb
from scenelang.stdlib.colors import named_colors

ROWS = color_names()
NOISE = 1e-3  # of linear light: less than one step of 8 bits except near black


def linear(digits: str) -> list[float]:
    return [float(from_srgb(np.array(int(digits[at : at + 2], 16) / 255))) for at in (0, 2, 4)]


def test_every_color_of_the_table_names_itself() -> None:
    assert color_words([linear(digits) for _, digits in ROWS]) == [name for name, _ in ROWS]


def test_names_are_everyday_words_in_sensible_number() -> None:
    names = {name for name, _ in ROWS}
    assert 150 <= len(names) <= 300
    assert all(name == name.lower() and name.replace(" ", "").isalpha() for name in names)
    assert not {name for name in names if len(name) > 13 and " " not in name}  # no lightgoldenrodyellow
    assert len({digits for _, digits in ROWS}) == len(ROWS)


def test_different_names_are_apart() -> None:
    names, points = named_points()
    apart = np.linalg.norm(points[:, None] - points, axis=2)
    other = np.array([[a != b for a in names] for b in names])
    assert apart[other].min() > 0.01


@pytest.mark.parametrize(
    ("color", "word"),
    [
        ((0.9, 0.9, 0.9), "ivory"), ((1, 1, 1), "white"), ((0, 0, 0), "black"), ((0.2, 0.2, 0.2), "grey"),
        ((0.05, 0.05, 0.05), "charcoal"), ((0.5, 0.5, 0.5), "light grey"), ((0.1, 0.1, 0.1), "dark grey"),
        ((1, 0, 0), "red"), ((0, 1, 0), "green"), ((0, 0, 1), "blue"), ((1, 1, 0), "yellow"), ((0, 1, 1), "cyan"),
        ((1, 0, 1), "magenta"), ((-1, 0, 0), "black"), ((7, 7, 7), "white"),
    ],
)  # fmt: skip
def test_well_known_colors(color: tuple[float, ...], word: str) -> None:
    assert color_words([color]) == [word]


@pytest.mark.parametrize(
    "name",
    ["ivory", "gold", "navy", "crimson", "teal", "salmon", "orchid", "turquoise", "tan", "indigo", "black", "silver"],
)
def test_the_names_of_the_language_come_back(name: str) -> None:
    assert color_words([linear(named_colors()[name])]) == [name]


@given(st.sampled_from(range(len(ROWS))), st.tuples(*[st.floats(-NOISE, NOISE)] * 3))
def test_noise_goes_back_to_the_name(row: int, noise: tuple[float, ...]) -> None:
    name, digits = ROWS[row]
    color = np.array(linear(digits))
    if color.min() > 0.02:  # near black a step of light is a large step to the eye
        there = color + noise
        assert color_words([there, 2 * color - there]) == [name, name]  # as far on one side as on the other


def test_greys_are_neutral_from_black_to_white() -> None:
    words = color_words([[g, g, g] for g in np.linspace(0, 1, 101)])
    neutral = ("grey", "black", "white", "ivory", "silver", "charcoal", "graphite", "soot", "gunmetal", "pewter")
    assert [word for word in words if not word.endswith(neutral)] == []
    assert (words[0], words[-1]) == ("black", "white")


def test_the_nearest_of_many_is_the_nearest_of_each() -> None:
    names, points = named_points()
    colors = np.array(list(product(np.linspace(0, 1, 17), repeat=3)))  # more than one chunk
    expected = [names[int(np.linalg.norm(points - oklab(color), axis=1).argmin())] for color in colors]
    assert color_words(colors) == expected
    assert color_words([]) == []


@pytest.mark.parametrize("text", ["a red one", "Ivory, polished", "reddish", "dark green glass", "papayawhip"])
def test_texts_that_name_a_color(text: str) -> None:
    assert mentions_color(text)


@pytest.mark.parametrize("text", ["tall", "weathered", "hundred", "goldsmith", "oaken", ""])
def test_texts_that_name_none(text: str) -> None:
    assert not mentions_color(text)
