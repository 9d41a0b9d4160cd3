"""`embed --model`: how things look, in a model's words."""

from __future__ import annotations

import json

from models.conftest import Place, system, texts
from models.server import Said

SCENE = """(bind "row" (lambda () (union
  (call "vase" :color [.9 .9 .9])
  (transform (call "vase" :color [.7 .05 .05]) (translate [2 0 0]))
  (transform (call "vase" :color [.9 .9 .9]) (translate [4 0 0])))))
"""


def words(place: Place) -> list[str]:
    (place.work / "row.scene").write_text(SCENE)
    done = place.run("embed", "row.scene", "--model", "claude-haiku-5-5", "--print", "--json")
    assert done.code == 0, done.err
    return [row["text"] for row in json.loads(done.out)["rows"]]


def test_each_look_is_asked_for_once(place: Place) -> None:
    server = place.serve([Said("1. glazed ivory\n2) ox-blood glaze\n3. nothing")])
    assert words(place) == ["glazed ivory", "ox-blood glaze"]
    (request,) = server.requests
    assert request["model"] == "claude-haiku-5-5"
    asked = texts(request["messages"][0]).splitlines()
    assert asked[-2].startswith('1. "vase", about ivory: {"color": [0.9, 0.9, 0.9]')
    assert asked[-1].startswith('2. "vase", about ')
    assert "catalogue" in system(request)


def test_what_is_not_answered_keeps_the_table_s_word(place: Place) -> None:
    place.serve([Said("I would say:\n2. ox-blood glaze")])
    assert words(place) == ["ivory", "ox-blood glaze"]


def test_it_is_not_asked_twice(place: Place) -> None:
    server = place.serve([Said("1. glazed ivory\n2. ox-blood glaze")])
    assert words(place) == words(place)
    assert len(server.requests) == 1


def test_the_limit_on_cost_holds(place: Place) -> None:
    server = place.serve([])
    (place.work / "row.scene").write_text(SCENE)
    done = place.run("embed", "row.scene", "--model", "--max-cost", "0.0001", "--print")
    assert (done.code, "of --max-cost remains" in done.err) == (1, True)
    assert server.requests == []
