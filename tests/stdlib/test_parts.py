"""Parts: everyday objects that stand, have their size, face +z, and carry what their sockets place."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest

import scenelang as sl
from scenelang.backends.geometry.lint import check_geometry
from scenelang.bench.sizes import everyday_sizes
from scenelang.grammar.datum import ListDatum, Source, print_datum
from scenelang.grammar.diagnostics import CODES
from scenelang.grammar.reader import read
from scenelang.reference.searching import fitting_parts, search
from scenelang.session.session import Session
from scenelang.stdlib.library import build_library, part_modules
from scenelang.stdlib.reference import LibraryPart, ReferenceRecord, parts

PARTS = {part.word: part for part in parts()}
SOCKETS = {socket.name: (part, socket) for part in parts() for socket in part.sockets}
MOST_PRIMITIVES = 200
NEAR = 0.02  # metres, from the origin to the middle of the box
OTHER = {"Number": (0.8, 1.25), "Integer": (-1, 2)}  # factors of lengths, steps of counts
TINTS = ("[.1 .2 .6]", "[.9 .9 .9]")


def program(part: LibraryPart, body: str) -> str:
    return f'(import "{part.record.module}")\n(bind "all" (lambda () (union {body})))\n(scene "all")'


def called(part: LibraryPart, arguments: str = "") -> str:
    return f'(call "{part.word}" {arguments})'


def warnings(scene: sl.Scene) -> list[str]:
    """Return the warnings of a scene's program and of its geometry; notes are what may be meant."""
    found = [*scene.warnings, *check_geometry(scene.graph)]
    return [d.message for d in found if not CODES[d.name].code.startswith("N")]


def bounds(scene: sl.Scene) -> np.ndarray:
    box = scene.bounds
    assert box is not None
    return box


@cache
def default_values(word: str) -> dict[str, str]:
    """Return the default of each parameter of a part, evaluated, by its name with the type."""
    part = PARTS[word]
    listed = re.sub(r"\[(:[^\[\]]*)\]", r"(\1)", part.record.signature.removesuffix(" -> Entity"))
    (form,) = read(Source("a.scene", listed)).forms
    assert isinstance(form, ListDatum)
    heads = [each for each in form.items[2:] if isinstance(each, ListDatum)]
    names = [print_datum(head.items[0]) for head in heads]
    plain = [name.removeprefix(":").partition("::")[0] for name in names]
    given = " ".join(f"({print_datum(head)[1:-1]})" for head in heads)
    prints = " ".join(f"(print {name})" for name in plain)
    text = f'(define (show {given}) {prints})(bind "a" (lambda () (show) (call "cube")))'
    log = Session().evaluate(Source("a.scene", text)).log
    return dict(zip(names, log, strict=True))


def other_values(part: LibraryPart, name: str, value: str) -> list[str]:
    """Return two values of a parameter that are not its default."""
    kind = name.rpartition("::")[2]
    if kind == "Vector":
        return list(TINTS)
    if kind == "String":
        return [f'"{each}"' for each in re.findall(r'"(\w+)"', part.parameters) if each != value][:2]
    if kind == "Integer":
        return [str(max(1, int(value) + step)) for step in OTHER[kind]] if value != "1" else ["2", "3"]
    return [repr(float(value) * factor) for factor in OTHER[kind]]


VARIANTS = [
    pytest.param(word, f":{name[1:].partition('::')[0]} {value}", id=f"{word} {name[1:].partition('::')[0]} {value}")
    for word in PARTS
    for name, default in default_values(word).items()
    for value in other_values(PARTS[word], name, default)
]


def test_there_are_thirty_parts() -> None:
    assert len(PARTS) == len(parts()) == 30
    assert len(SOCKETS) >= 20
    for module in part_modules():
        text = build_library().modules[module]
        words = re.findall(r'^\(bind "([^"]+)"', text, re.M)
        assert {part.word for part in parts() if part.record.module == f"std/{module}"} == set(words)
        functions = re.findall(r"^\(define \(([^\s%()]+)", text, re.M)
        assert set(functions) <= set(SOCKETS), module


@pytest.mark.parametrize("word", PARTS)
def test_a_part_is_sound(word: str) -> None:
    part = PARTS[word]
    scene = sl.evaluate(program(part, called(part)))
    assert warnings(scene) == []
    assert scene.violations(f'(supported "{word}")') == []
    assert len(scene.flatten()) <= MOST_PRIMITIVES
    assert scene.warnings == ()


@pytest.mark.parametrize("word", PARTS)
def test_a_part_has_its_size_and_stands_at_the_origin(word: str) -> None:
    part, usual = PARTS[word], everyday_sizes()[word]
    low, high = bounds(sl.evaluate(program(part, called(part))))
    assert high - low == pytest.approx(part.size, abs=0.01)
    assert low[1] == pytest.approx(0.0, abs=1e-6)
    assert np.abs(low + high)[[0, 2]].max() / 2 <= NEAR
    width, height, depth = high - low
    assert usual.height[0] <= height <= usual.height[1]
    assert usual.length[0] <= max(width, depth) <= usual.length[1]


@pytest.mark.sampled(6)
@pytest.mark.parametrize(("word", "argument"), VARIANTS)
def test_a_part_with_another_value(word: str, argument: str) -> None:
    part = PARTS[word]
    scene = sl.evaluate(program(part, called(part, argument)))
    assert warnings(scene) == []
    assert scene.violations(f'(supported "{word}")') == []
    low, high = bounds(scene)
    assert low[1] == pytest.approx(0.0, abs=1e-6)
    assert np.abs(low + high)[[0, 2]].max() / 2 <= max(NEAR, 0.03 * float((high - low).max()))


@pytest.mark.parametrize("word", [word for word, part in PARTS.items() if "is at -z" in part.front])
def test_the_back_is_at_the_back(word: str) -> None:
    """What is high up is behind the middle: the back of a seat, the headboard of a bed, the tap of a sink."""
    corners = "(list (compute-shape-min each) (compute-shape-max each))"
    text = f"(for ((each (primitives {called(PARTS[word])}))) (print {corners}))"
    log = sl.evaluate(f'(import "{PARTS[word].record.module}")(bind "a" (lambda () {text} (call "cube")))').log
    boxes = np.array([[float(n) for n in re.findall(r"[-\d.e]+", line)] for line in log]).reshape(-1, 2, 3)
    sizes = boxes[:, 1] - boxes[:, 0]
    high = boxes[:, 1, 1] > 0.9 * boxes[:, 1, 1].max()
    middles, volumes = boxes.mean(axis=1)[high], sizes.prod(axis=1)[high]
    assert np.average(middles[:, 2], weights=volumes) < -0.005


@pytest.mark.parametrize("word", PARTS)
def test_the_example_of_a_part(word: str) -> None:
    picture = PARTS[word].record.picture
    assert picture is not None
    assert f'(call "{word}"' in picture
    assert warnings(sl.evaluate(program(PARTS[word], picture))) == []


PROBE = '(bind "probe" (lambda () (transform (call "cube" :scale .012) (translate [0 .006 0]))))'


def poses_of(socket: ReferenceRecord) -> str:
    call = f"({socket.name})"
    return call if "List[Matrix]" in socket.signature else f"(list {call})"


@pytest.mark.parametrize("name", SOCKETS)
def test_a_socket_is_on_the_surface(name: str) -> None:
    part, socket = SOCKETS[name]
    placed = f"(for/union ((place {poses_of(socket)})) (transform {{}} place))"
    if socket.doc.startswith("Return the pose that"):  # of the part itself
        low, high = bounds(sl.evaluate(program(part, placed.format(called(part)))))
        assert low[1] == pytest.approx(0.0, abs=1e-3)
        assert not np.allclose([low, high], bounds(sl.evaluate(program(part, called(part)))), atol=0.02)
        return
    scene = sl.evaluate(PROBE + program(part, called(part) + placed.format('(call "probe")')))
    if "on the ground" in socket.doc:
        assert scene.violations('(supported "probe")', f'(clear-of "probe" "{part.word}")') == []
    else:
        assert scene.violations(f'(on "probe" "{part.word}")') == []


def test_sockets_follow_the_parameters() -> None:
    part = PARTS["table"]
    probe = '(transform (call "probe") (table-top :height .6))'
    scene = sl.evaluate(PROBE + program(part, f"{called(part, ':height .6')} {probe}"))
    assert scene.violations('(on "probe" "table")') == []


def test_a_chair_faces_the_table_from_every_place() -> None:
    body = '(call "table") (for/union ((place (table-seats :count 5))) (transform (call "chair") place))'
    scene = sl.evaluate(program(PARTS["table"], body))
    assert (
        scene.violations('(facing "chair" "table" :within 60)', '(count "chair" 5)', '(clear-of "chair" "chair")') == []
    )


def test_a_program_may_bind_the_word_of_a_part_itself() -> None:
    text = (
        '(import "std/furniture.scene")(bind "lamp" (lambda () (call "sphere")))(bind "all" (lambda () (call "lamp")))'
    )
    assert [item.shape for item in sl.evaluate(text + '(scene "all")').flatten()] == ["sphere"]


def test_all_modules_together() -> None:
    imports = "".join(f'(import "std/{module}")' for module in part_modules())
    row = " ".join(f'(transform (call "{word}") (translate [{9 * i} 0 0]))' for i, word in enumerate(PARTS))
    scene = sl.evaluate(f'{imports}(bind "all" (lambda () (union {row})))(scene "all")')
    assert set(PARTS) <= set(scene.count())


@pytest.mark.parametrize(
    ("query", "word"),
    [("chair", "chair"), ("couch", "sofa"), ("mug", "cup"), ("stairs", "staircase"), ("washbasin", "sink"),
     ("chest of drawers", "cabinet"), ("parasol", "umbrella")],
)  # fmt: skip
def test_a_part_is_found_by_its_word_and_by_meaning(query: str, word: str) -> None:
    first = search(query, 1)[0]
    assert (first.kind, first.name) == ("part", word)
    assert f'(import "{PARTS[word].record.module}")' in first.doc
    assert first.example == " ".join((PARTS[word].record.picture or "").split())[:200]


@pytest.mark.parametrize(
    ("text", "words"),
    [("A table with four chairs", ["table", "chair"]), ("a living room", ["sofa", "lamp"]),
     ("Street-lamps along a road", ["street lamp", "lamp"]), ("mirrored bowling pins", []), ("a chessboard", [])],
)  # fmt: skip
def test_parts_that_fit_a_text(text: str, words: list[str]) -> None:
    assert [part.word for part in fitting_parts(text)] == words
    assert len(fitting_parts(" ".join(PARTS))) == 8
