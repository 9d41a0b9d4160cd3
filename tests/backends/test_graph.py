"""The computation graph as a drawing: nodes, counts, places, and text that cannot leave its element."""

from __future__ import annotations

import xml.etree.ElementTree as xml
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from support import evaluate

from scenelang.backends.pictures.call_graph import call_graph, laid_out
from scenelang.cli.main import main

FIGURE = Path(__file__).parent.parent.parent / "examples" / "paper" / "chessboard.scene"
SPONGE = FIGURE.parent.parent / "menger-sponge.scene"
SVG = "{http://www.w3.org/2000/svg}"


def texts(path: Path) -> list[str]:
    return [element.text or "" for element in xml.parse(path).iter(f"{SVG}text")]


def test_figure_2_is_drawn(tmp_path: Path) -> None:
    assert main(["graph", str(FIGURE), "-o", str(tmp_path / "a.svg")]) == 0
    found = texts(tmp_path / "a.svg")
    assert {"chessboard", "board", "square"} <= set(found)
    assert "×64" in found
    assert "<z1>" in found


def test_levels_of_a_recursion_are_nodes_and_counts_are_exact(tmp_path: Path) -> None:
    assert main(["graph", str(SPONGE), "-o", str(tmp_path / "a.svg"), "--define", "level=8"]) == 0
    found = texts(tmp_path / "a.svg")
    assert found.count("×20") == 8
    scene = evaluate(
        '(bind "a" (lambda () (union-loop 3 (lambda (i) (call "b" :n i)))))'
        '(bind "b" (lambda (:n) (union-loop (+ n 1) (lambda (i) (call "cube")))))'
    )
    graph = call_graph(scene)
    assert [node.word for node in graph.nodes] == ["a", "b", "cube"]
    assert [node.instances for node in graph.nodes] == [1, 3, 6]
    assert [edge.label for edge in graph.edges] == ["×3", "×1–3"]
    assert graph.nodes[1].handles == ("z2", "z4", "…")


def test_depth_hides_what_is_below(tmp_path: Path) -> None:
    assert main(["graph", str(SPONGE), "-o", str(tmp_path / "a.svg"), "--depth", "1"]) == 0
    assert any("more" in text for text in texts(tmp_path / "a.svg"))


def test_thumbnails_are_pictures(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(
        '(bind "pair" (lambda () (union (call "sphere") (call "nothing"))))(bind "nothing" (lambda () (union)))'
    )
    assert main(["graph", str(tmp_path / "a.scene"), "-o", str(tmp_path / "a.svg"), "--thumbnails"]) == 0
    images = [element.get("href") or "" for element in xml.parse(tmp_path / "a.svg").iter(f"{SVG}image")]
    assert len(images) == 2
    assert all(image.startswith("data:image/png;base64,") for image in images)


def test_words_cannot_leave_their_elements(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(
        '(bind "<script>alert(1)</script>" (lambda () (call "</text><a href=\\"x\\">&")))'
    )
    assert main(["graph", str(tmp_path / "a.scene"), "-o", str(tmp_path / "a.svg")]) == 0
    kinds = {element.tag.removeprefix(SVG) for element in xml.parse(tmp_path / "a.svg").iter()}
    assert kinds <= {"svg", "title", "defs", "marker", "path", "rect", "g", "text"}
    assert "<script>alert(1)</script>" in texts(tmp_path / "a.svg")


def test_wrong_uses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["graph", str(SPONGE), "-o", str(tmp_path / "a.png")]) == 2
    assert main(["graph", str(SPONGE), "-o", str(tmp_path / "no" / "a.svg")]) == 1
    assert main(["graph", str(SPONGE), "-o", str(tmp_path / "a.svg"), "--frame", "2"]) == 1
    assert "frame 2 does not exist" in capsys.readouterr().err


@given(
    st.lists(st.tuples(st.integers(0, 14), st.integers(1, 15)).filter(lambda e: e[0] < e[1]), max_size=40, unique=True)
)
def test_no_nodes_overlap_and_edges_point_down(edges: list[tuple[int, int]]) -> None:
    sizes = [(40.0 + 7 * i % 50, 30.0 + i) for i in range(16)]
    layout = laid_out(sizes, edges)
    for i, a in enumerate(layout.places):
        for b in layout.places[i + 1 :]:
            apart_x = abs(a.x - b.x) >= (a.width + b.width) / 2.0 - 1e-6
            assert apart_x or abs(a.y - b.y) >= (a.height + b.height) / 2.0
    for (start, end), way in zip(edges, layout.ways):
        heights = [layout.places[start].y, *(place.y for place in way), layout.places[end].y]
        assert heights == sorted(set(heights))
