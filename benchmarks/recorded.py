"""Numbers that tasks state, counted in the recorded responses: `make eval-recorded`. Exits with 1 where any differs."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from scenelang.backends.neural.descriptions import color_words
from scenelang.console.reports import table
from scenelang.grammar.diagnostics import render_text
from scenelang.interpreter.scene.entity import Entity, count_words, descendants, instance_counts
from scenelang.interpreter.scene.primitives import items_of
from scenelang.session.session import Session

RESPONSES = Path(__file__).parent.parent / "tests" / "transpile" / "responses"


@dataclass(frozen=True, slots=True)
class Counted:
    """``times`` the instances of ``word``: those inside entities of the word ``inside``, those whose ``:color`` the
    table of colours calls by a word that ends in ``color``."""

    word: str
    times: int = 1
    inside: str | None = None
    color: str | None = None


@dataclass(frozen=True, slots=True)
class Stated:
    """The response in file ``task`` (without ``.txt``) is to have ``number`` of ``what``, which is a sum of counts."""

    task: str
    what: str
    number: int
    sum_of: tuple[Counted, ...]


STATED = (
    Stated("n01-table-apples-bananas", "apples", 5, (Counted("apple"),)),
    Stated("n01-table-apples-bananas", "bananas", 3, (Counted("banana"),)),
    Stated("n02-connect-four", "red discs", 10, (Counted("disc", color="red"),)),
    Stated("n02-connect-four", "yellow discs", 9, (Counted("disc", color="yellow"),)),
    Stated("n04-staircase", "steps", 13, (Counted("step"),)),
    # a row of spots has one dividing line more than spots, and one along the back
    Stated(
        "n06-parking-lot",
        "spots",
        24,
        (Counted("cube", inside="parking_row_lines"), Counted("parking_row_lines", times=-2)),
    ),
    Stated("n06-parking-lot", "cars", 19, (Counted("car"),)),
    Stated("n08-domino-spiral", "dominoes", 28, (Counted("domino"),)),
    Stated("n10-rubiks-cube", "cubies", 27, (Counted("cubie"),)),
    Stated("n10-rubiks-cube", "stickers", 54, (Counted("sticker"),)),
    Stated("t01-chessboard", "squares", 64, (Counted("board_square"),)),
    Stated("t01-chessboard", "pawns", 16, (Counted("pawn"),)),
    Stated("t02-moai", "moai", 7, (Counted("moai"),)),
    Stated("t04-jenga", "blocks", 24, (Counted("jenga_block"),)),
    Stated("t04-jenga.edit", "blocks left", 22, (Counted("jenga_block"),)),
    Stated("t09-coke-cans", "cans", 15, (Counted("coke_can"),)),
    Stated("t11-bookshelf", "books", 36, (Counted("book"),)),
)


def main() -> int:
    """Print one table of everything that is stated, and say by the exit code whether all of it is so."""
    roots = {task: scene_of(task) for task in dict.fromkeys(stated.task for stated in STATED)}
    rows = [("response", "task", "what", "stated", "counted", "ok")]
    wrong = 0
    for stated in STATED:
        number = sum(counted.times * count(roots[stated.task], counted) for counted in stated.sum_of)
        ok = number == stated.number
        wrong += not ok
        response = stated.task.partition("-")[0] + ("" if "." not in stated.task else " edited")
        rows.append(
            (response, sentence(stated.task), stated.what, str(stated.number), str(number), "ok" if ok else "NO")
        )
    print(table(rows, (False, False, False, True, True, False)))
    print(f"\n{len(STATED) - wrong} of {len(STATED)} as stated")
    return 1 if wrong else 0


def scene_of(task: str) -> Entity:
    """The root of a response's scene, first frame."""
    session = Session()
    result = session.evaluate(session.source(str(RESPONSES / f"{task}.txt")))
    if result.scene is None:
        sys.exit("\n".join(render_text(diagnostic) for diagnostic in result.diagnostics))
    return result.scene.root


def sentence(task: str) -> str:
    """What the response was asked for, from its program's docstring."""
    found = re.search(r'^"""\s*(.+?)\s*"""', (RESPONSES / f"{task}.txt").read_text("utf-8"), re.M | re.S)
    return " ".join(found[1].split()) if found else ""


def count(root: Entity, counted: Counted) -> int:
    """Instances in the expanded scene, of the word that ``counted`` names."""
    if counted.inside is not None:
        return sum(many * count_words(entity).get(counted.word, 0) for entity, many in _called(root, counted.inside))
    if counted.color is None:
        return count_words(root).get(counted.word, 0)
    return sum(many for entity, many in _called(root, counted.word) if _is_colored(entity, counted.color))


def _called(root: Entity, word: str) -> Iterator[tuple[Entity, int]]:
    """The distinct entities of a word, each with the number of its instances."""
    order = list(descendants(root))
    instances = instance_counts(order)
    return ((entity, instances[id(entity)]) for entity in order if entity.word == word)


def _is_colored(entity: Entity, color: str) -> bool:
    channels = items_of(entity.embedding.attributes.get("color"))
    return channels is not None and color_words([channels])[0].split()[-1] == color


if __name__ == "__main__":
    sys.exit(main())
