"""The examples: each is free of warnings, makes the scene that it announces, and has its picture in the gallery."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from scenelang import Entity, Options, Session
from scenelang.grammar.diagnostics import render_text
from scenelang.interpreter.inspection.outline import outline
from scenelang.interpreter.scene.bounds import parts_box, word_box
from scenelang.interpreter.scene.entity import Scene, count_words, descendants
from scenelang.interpreter.scene.flatten import flatten
from scenelang.interpreter.scene.modelling.solid import SolidShape
from scenelang.stdlib.reference import combinators

ROOT = Path(__file__).parents[1]
EXAMPLES = ROOT / "examples"
NAMES = sorted(str(path.relative_to(EXAMPLES).with_suffix("")) for path in EXAMPLES.rglob("*.scene"))
GEOMETRIC = {"cube", "sphere", "cylinder", "cone"}
README = (ROOT / "README.md").read_text("utf-8")

# Figure 2 of the paper; "..." stands for what the figure leaves out.
FIGURE_2 = """
(bind "chessboard"
  (lambda (embedding ...)
    (union
      (call "board" ...)
      (call "chess pieces" ...))))
(bind "board"
  (lambda (embedding ...)
    (define (create-squares i) ...)
    (union-loop 64 create-squares)))
(bind "chess pieces"
  (lambda (embedding ...)
    (define (create-pawns i)
      (let* ((white-pawn (call "pawn" ...))
             (black-pawn (call "pawn" ...))
             (white-pose (translate (list (* i 0.125) 0.02 0.125)))
             (black-pose (translate (list (* i 0.125) 0.02 0.75)))
             (white-pawn-t (transform white-pawn white-pose))
             (black-pawn-t (transform black-pawn black-pose)))
        (union white-pawn-t black-pawn-t)))
    (define pieces-order
      '("rook" "knight" "bishop" "queen" "king"
        "bishop" "knight" "rook"))
    (define (create-other-pieces i)
      (let* ((piece-order (list-ref pieces-order i))
             (white-piece (call piece-order ...))
             (black-piece (call piece-order ...))
             (white-pose (translate (list (* i 0.125) 0.02 0)))
             (black-pose (translate (list (* i 0.125) 0.02 0.875)))
             (white-piece-t (transform white-piece white-pose))
             (black-piece-t (transform black-piece black-pose)))
        (union white-piece-t black-piece-t)))
    (union (union-loop 8 create-pawns)
           (union-loop 8 create-other-pieces))))
"""


def path_of(name: str) -> Path:
    return EXAMPLES / f"{name}.scene"


def scene_of(name: str, seed: int = 0, **defines: Any) -> Scene:
    """The scene of an example; fails on any error or warning."""
    session = Session(Options(seed=seed, defines={key.replace("_", "-"): str(v) for key, v in defines.items()}))
    result = session.evaluate(session.source(str(path_of(name))))
    assert [render_text(d) for d in result.diagnostics] == []
    assert result.scene is not None
    return result.scene


def box(scene: Scene, word: str | None = None) -> tuple[float, ...]:
    found = word_box(scene, word)
    assert found is not None
    return found


def counts(scene: Scene) -> Mapping[str, int]:
    return count_words(scene.root)


def entities(scene: Scene, word: str) -> list[Entity]:
    """The distinct entities of a word, in the order in which a program placed them."""
    return [entity for entity in descendants(*scene.frames) if entity.word == word]


# --- all of them -----------------------------------------------------------------------------------------------------


def test_there_are_enough() -> None:
    assert len(NAMES) >= 13


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.sampled(2)
def test_example_runs_without_a_word(name: str) -> None:
    session = Session()
    checked = session.check(session.source(str(path_of(name))))
    assert [render_text(d) for d in checked.diagnostics] == []
    scene = scene_of(name)
    has_solids = any(isinstance(entity.shape, SolidShape) for entity in descendants(scene.root))
    assert sum(counts(scene).values()) > 10 or has_solids
    low, high = box(scene)[:3], box(scene)[3:]
    assert all(0 < b - a < 1000 for a, b in zip(low, high))


@pytest.mark.parametrize("name", NAMES)
def test_example_is_well_kept(name: str) -> None:
    lines = path_of(name).read_text("utf-8").splitlines()
    assert lines[0].startswith("; ")
    assert max(map(len, lines)) <= 88
    assert not any(line != line.rstrip() or "\t" in line for line in lines)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.sampled(4)
def test_example_has_its_picture_and_a_line_in_the_readme(name: str) -> None:
    picture = ROOT / "docs" / "gallery" / f"{name.replace('/', '-')}.jpg"
    assert picture.stat().st_size < 150_000
    with Image.open(picture) as image:
        assert image.size == (640, 480)
        colors = image.convert("RGB").getcolors(1 << 24)
    assert colors is not None
    assert len(colors) > 50
    assert f"(examples/{name}.scene)" in README
    assert f"(docs/gallery/{picture.name})" in README


# --- chess -----------------------------------------------------------------------------------------------------------


def _without_comments(text: str) -> str:
    return " ".join(re.sub(r";[^\n]*", "", text).split())


def test_figure_2_is_as_printed() -> None:
    pieces = [re.escape(piece.strip()) for piece in _without_comments(FIGURE_2).split("...")]
    pattern = r"\s?.*?\s?".join(pieces)
    assert re.fullmatch(pattern, _without_comments(path_of("paper/chessboard").read_text("utf-8")))


def test_figure_2_counts() -> None:
    found = counts(scene_of("paper/chessboard"))
    assert found == {
        "chessboard": 1, "board": 1, "square": 64, "chess pieces": 1,
        "pawn": 16, "rook": 4, "knight": 4, "bishop": 4, "queen": 2, "king": 2,
    }  # fmt: skip


def test_figure_2_handles() -> None:
    lines = list(outline(scene_of("paper/chessboard"), expand=True))
    words = [re.sub(r"^[│├└─ ]*", "", line) for line in lines]
    numbers = dict(enumerate(words, 1))
    assert len(numbers) == 99
    expected = {1: "chessboard", 2: "board", 3: "square", 66: "square", 67: "chess pieces", 68: "pawn", 69: "pawn",
                83: "pawn", 84: "rook", 86: "knight", 88: "bishop", 90: "queen", 92: "king"}  # fmt: skip
    for number, word in expected.items():
        assert re.match(rf"{word} <z{number}>(\s|$)", numbers[number]), numbers[number]


def test_figure_2_shares_squares_and_pieces() -> None:
    scene = scene_of("paper/chessboard")
    assert len(entities(scene, "square")) == 2
    assert len(entities(scene, "pawn")) == 2
    assert all(entity.is_primitive for entity in entities(scene, "pawn") + entities(scene, "square"))


def test_figure_2_in_the_command_line() -> None:
    command = [sys.executable, "-P", "-m", "scenelang", "tree", str(path_of("paper/chessboard"))]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "64 x square <z3> ... <z66>" in done.stdout
    assert "16 x pawn <z68> ... <z83>" in done.stdout
    assert done.stderr == ""


def test_chess_set() -> None:
    scene = scene_of("chessboard")
    found = counts(scene)
    assert scene.word == "chess set"
    assert (found["square"], found["pawn"], found["king"]) == (64, 16, 2)
    primitives = flatten(scene).frames[0].primitives
    assert {entity.word for entity in primitives} == GEOMETRIC


def test_chess_pieces_stand_on_the_board() -> None:
    scene = scene_of("chessboard")
    top = box(scene, "square")[4]
    heights = []
    for word in ("pawn", "rook", "knight", "bishop", "queen", "king"):
        low, high = box(scene, word)[1], box(scene, word)[4]
        assert low == pytest.approx(top)
        heights.append(high - low)
    assert heights == sorted(heights)
    assert len(set(heights)) == 6


def test_white_is_in_front_and_its_queen_on_a_light_square() -> None:
    scene = scene_of("chessboard")
    chess = next(part for part in scene.root.children if part.car.word == "chessboard")
    board, pieces = (part.car for part in chess.car.children)
    queens = [part for part in pieces.children if part.car.word == "queen"]
    brightness = [sum(queen.car.embedding.attributes["color"]) for queen in queens]
    assert brightness[0] > brightness[1]
    assert queens[0].cdr[11] < queens[1].cdr[11]  # along z, before the mirror image
    assert chess.cdr[10] == -1  # the image has white at +z
    place = (queens[0].cdr[3], queens[0].cdr[11])
    below = next(part for part in board.children if (part.cdr[3], part.cdr[11]) == place)
    assert below.car.embedding.text == "maple"


# --- one by one ------------------------------------------------------------------------------------------------------


def test_moai_vary() -> None:
    scene = scene_of("moai")
    assert counts(scene)["moai"] == 7
    statues = entities(scene, "moai")
    assert len({statue.embedding.attributes["tall"] for statue in statues}) == 7
    again, other = scene_of("moai"), scene_of("moai", seed=1)
    assert box(again) == box(scene)
    assert box(other) != box(scene)
    assert counts(scene_of("moai", statues=3))["moai"] == 3


def test_staircase_climbs() -> None:
    scene = scene_of("spiral-staircase")
    steps = [part for part in scene.root.children if part.car.word == "step"]
    assert len(steps) == 26
    heights = [part.cdr[7] for part in steps]
    assert [b - a for a, b in pairwise(heights)] == pytest.approx([0.18] * 25)
    taller = scene_of("spiral-staircase", steps=30, rise=0.2)
    assert counts(taller)["step"] == 30
    assert box(taller)[4] > box(scene)[4]


def test_jenga_has_eight_layers_of_three() -> None:
    scene = scene_of("jenga")
    assert counts(scene)["block"] == 24
    blocks = [part for part in scene.root.children if part.car.word == "block"]
    layers = [parts_box(blocks[i : i + 3]) for i in range(0, 24, 3)]
    for lower, upper in pairwise(layers):
        assert lower is not None
        assert upper is not None
        assert lower[4] <= upper[1] + 1e-9
    along_x = [abs(block.cdr[2]) for block in blocks]  # how far the block's length points along x
    assert along_x == pytest.approx([i // 3 % 2 for i in range(24)], abs=0.04)
    assert counts(scene_of("jenga", layers=2))["block"] == 6


def test_tree_is_shared() -> None:
    scene = scene_of("fractal-tree")
    found = counts(scene)
    assert found["leaf"] == 3 * 3**7
    assert found["branch"] == sum(3**level for level in range(8))
    assert sum(1 for _ in descendants(scene.root)) < found["leaf"] / 5
    assert counts(scene_of("fractal-tree", levels=3))["leaf"] == 3 * 3**3


@pytest.mark.parametrize("level", [0, 1, 2, 3, 4, 8])
def test_sponge(level: int) -> None:
    scene = scene_of("menger-sponge", level=level)
    assert counts(scene)["cube"] == 20**level
    assert box(scene) == pytest.approx((-0.5, 0, -0.5, 0.5, 1, 0.5))
    assert sum(1 for _ in descendants(scene.root)) == level + 3


def test_sponge_refuses_levels_out_of_range() -> None:
    session = Session(Options(defines={"level": "13"}))
    result = session.evaluate(session.source(str(path_of("menger-sponge"))))
    assert [d.name for d in result.diagnostics] == ["param"]


def test_dolls_shrink_and_stand() -> None:
    scene = scene_of("nesting-dolls")
    boxes = [parts_box([part]) for part in scene.root.children]
    assert len(boxes) == 6
    heights = []
    for found in boxes:
        assert found is not None
        assert found[1] == pytest.approx(0)
        heights.append(found[4])
    assert all(0.7 < b / a < 0.85 for a, b in pairwise(heights))
    assert counts(scene_of("nesting-dolls", dolls=3))["doll"] == 3


def test_orrery_moves() -> None:
    scene = scene_of("orrery")
    assert scene.animated
    assert len(scene.frames) == 48
    assert all(count_words(frame) == counts(scene) for frame in scene.frames)
    arms = [[part.car for part in frame.children if part.car.word == "arm"] for frame in scene.frames]
    turns = [[arm.embedding.attributes["turns"] for arm in frame] for frame in arms]
    for planet in range(6):
        assert all(turns[i][planet] < turns[i + 1][planet] for i in range(47))
    assert turns[24][2] - turns[0][2] == pytest.approx(0.5)  # the earth, after half a year
    suns = {id(part.car) for frame in scene.frames for part in frame.children if part.car.word == "sun"}
    assert len(suns) == 1
    assert len(scene_of("orrery", frame_count=5).frames) == 5


@pytest.mark.parametrize("name", NAMES)
def test_only_the_strict_example_is_strict(name: str) -> None:
    session = Session(Options(strict=True))
    checked = session.check(session.source(str(path_of(name))))
    assert checked.ok == (name == "strict")
    if name != "strict":
        assert {d.name for d in checked.diagnostics} == {"strict"}


def test_strict_example() -> None:
    found = counts(scene_of("strict"))
    assert (found["round temple"], found["shaft"], found["columns"]) == (1, 12, 1)
    command = [sys.executable, "-P", "-m", "scenelang", "check", "--strict", str(path_of("strict"))]
    assert subprocess.run(command, capture_output=True, check=False).returncode == 0


def test_macros_expand() -> None:
    command = [sys.executable, "-P", "-m", "scenelang", "expand", str(path_of("macros"))]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert '(bind "half brick"' in text
    assert "(place " not in text
    assert "define-blocks" not in text
    found = counts(scene_of("macros"))
    assert (found["tower"], found["gate"], found["pillar"]) == (5, 1, 2)


def test_words_have_no_geometry() -> None:
    scene = scene_of("words")
    primitives = flatten(scene).frames[0].primitives
    words = {entity.word for entity in primitives}
    assert {"moai", "tree", "sea", "meadow"} <= words
    assert not words & GEOMETRIC
    assert all(entity.embedding.text for entity in primitives)


def test_combinators_example_uses_all() -> None:
    text = path_of("combinators").read_text("utf-8")
    for record in combinators():
        assert f"({record.name} " in text, record.name
    found = counts(scene_of("combinators"))
    assert found["column"] == 9
    assert found["monument"] == 1
