"""Gaussians in the page, in place of solids."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from later import later
from support import evaluate

from scenelang.backends.neural.painting.shown import surface_splats
from scenelang.backends.neural.splats.gaussians import Splats
from scenelang.backends.viewer.packet import packet_of, splat_columns
from scenelang.cli.main import main
from scenelang.grammar.diagnostics import LimitError

torch = later("torch")


@pytest.fixture(autouse=True)
def has_torch() -> None:
    pytest.importorskip("torch")


PAIR = """(bind "pair" (lambda () (union
  (call "sphere" :radius 1 :color [.8 .05 .05]) (transform (call "cube" :color [.05 .1 .8]) (translate [3 0 0])))))
"""
FILM = """(bind "mover" (lambda () (frames (for/list ((i 2))
  (transform (call "sphere" :color [.8 .05 .05]) (translate (list (* 5 i) 0 0)))))))
"""


def some(count: int) -> Splats:
    generator = torch.Generator().manual_seed(0)
    axes = torch.randn(count, 3, 3, generator=generator, dtype=torch.float64)
    return Splats(
        torch.randn(count, 3, generator=generator, dtype=torch.float64),
        axes @ axes.mT,
        torch.rand(count, generator=generator, dtype=torch.float64),
        torch.rand(count, 3, generator=generator, dtype=torch.float64),
    )


def test_columns_are_the_gaussians_in_the_frame_of_the_stage() -> None:
    frames = [some(5), some(3)]
    found = splat_columns(frames, 3, np.array([1.0, 2.0, 3.0]), 0.5)
    assert found["splatStart"].tolist() == [0, 5, 8, 8]
    places = found["splatPlace"].reshape(-1, 3)
    assert np.allclose(places[5:], 0.5 * (frames[1].means.numpy() - [1, 2, 3]), atol=1e-6)
    spread = found["splatSpread"].reshape(-1, 6)[2]
    whole = spread[[[0, 1, 2], [1, 3, 4], [2, 4, 5]]]
    assert np.allclose(whole, 0.25 * frames[0].covariances[2].numpy(), atol=1e-6)
    paint = found["splatColor"].reshape(-1, 4)
    assert np.abs(paint[:5, :3] / 255 - frames[0].colors.numpy()).max() < 0.5 / 255 + 1e-9
    assert np.abs(paint[:5, 3] / 255 - frames[0].opacities.numpy()).max() < 0.5 / 255 + 1e-9


def test_too_many_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenelang.backends.viewer.packet.MAX_SPLATS", 7)
    with pytest.raises(LimitError, match="8 Gaussians"):
        splat_columns([some(8)], 1, np.zeros(3), 1.0)


def test_a_packet_without_splats_has_none() -> None:
    scene = evaluate(PAIR)
    assert b"splatStart" not in packet_of(scene)
    assert b"splatStart" in packet_of(scene, splats=surface_splats)


def show_page(browser: Any, path: Path) -> Any:
    from viewer.conftest import Shown

    return Shown(browser, path.as_uri(), (640, 480)).ready()


@pytest.fixture
def shown(browser: Any, tmp_path: Path) -> Callable[..., Any]:
    def open_page(text: str, *more: str) -> Any:
        (tmp_path / "a.scene").write_text(text)
        assert main(["view", str(tmp_path / "a.scene"), *more, "--html", str(tmp_path / "a.html"), "-q"]) == 0
        return show_page(browser, tmp_path / "a.html")

    return open_page


def red(picture: Any) -> Any:
    return (picture[:, :, 0].astype(int) - picture[:, :, 2]) > 60


def blue(picture: Any) -> Any:
    return (picture[:, :, 2].astype(int) - picture[:, :, 0]) > 60


@pytest.mark.browser
def test_gaussians_cover_what_solids_cover(shown: Callable[..., Any]) -> None:
    solids, splats = shown(PAIR).picture(), shown(PAIR, "--splats").picture()
    for of in (red, blue):
        both, either = (of(solids) & of(splats)).sum(), (of(solids) | of(splats)).sum()
        assert both > 0.9 * either > 900
    assert not np.array_equal(solids, splats)


@pytest.mark.browser
def test_frames_and_clicks_work(shown: Callable[..., Any]) -> None:
    page = shown(FILM, "--splats")
    first = red(page.picture()).nonzero()[1].mean()
    page.page.locator("#frame").fill("1")
    page.settled()
    assert red(page.picture()).nonzero()[1].mean() > first + 50


def test_mistakes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.scene").write_text(PAIR)
    page = ["--html", str(tmp_path / "a.html")]
    for more, code, said in (
        (["--distilled", str(tmp_path)], 1, "no distillation in"),
        ([str(tmp_path / "b.scene"), "--distilled", str(tmp_path)], 2, "one program"),
        (["--minecraft", "--splats"], 2, "`--minecraft` cannot be combined with `--splats` or `--distilled`"),
    ):
        assert main(["view", str(tmp_path / "a.scene"), *more, *page]) == code
        assert said in capsys.readouterr().err
