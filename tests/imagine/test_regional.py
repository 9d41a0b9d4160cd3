"""Regional attention: what a sentence says of an instance stays in its box."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_diffusion import WIDTH, small_diffusion
from small_models import seeded

from scenelang.backends.neural.imagine.layout import (
    AttentionRegion,
    Regional,
    RegionalAttention,
    cells_in,
    feature_shape,
)
from scenelang.backends.neural.imagine.sampling import Checkpoint, Sampling, generate_image, load_checkpoint

TEXTS = ("a red cube", "mossy stone")
LEFT, RIGHT = (0.0, 0.0, 0.5, 1.0), (0.5, 0.25, 1.0, 0.75)


@pytest.fixture(scope="module")
def checkpoint(tmp_path_factory: pytest.TempPathFactory) -> Checkpoint:
    folder: Path = small_diffusion(tmp_path_factory.mktemp("models") / "sd")
    return load_checkpoint(str(folder))


def region(checkpoint: Checkpoint, text: str, box: tuple[float, float, float, float]) -> AttentionRegion:
    encoded = checkpoint.text_encoder.encode_with_pooled([(text,)])
    return AttentionRegion(box, encoded.hidden_states, encoded.pooled)


def layer(torch: Any) -> Any:
    from diffusers.models.attention_processor import Attention

    made = Attention(query_dim=WIDTH, cross_attention_dim=WIDTH, heads=4, dim_head=8)
    return made.requires_grad_(False)


def test_one_layer_is_exactly_local(checkpoint: Checkpoint) -> None:
    torch = seeded()
    attn = layer(torch)
    states, words = torch.randn(2, 64, WIDTH), torch.randn(2, 77, WIDTH)

    def run(text: str) -> Any:
        regions = [region(checkpoint, text, LEFT), region(checkpoint, "a fixed palm", RIGHT)]
        return RegionalAttention(attn.processor, regions, (8, 8), True, 10.0)(attn, states, words)

    one, other = run("a red cube"), run("a mossy statue of stone")
    changed = (one != other).any(dim=2)
    assert not changed[0].any()
    assert changed[1].nonzero()[:, 0].tolist() == sorted(cells_in(LEFT, (8, 8)))


def test_a_layer_is_the_formula(checkpoint: Checkpoint) -> None:
    """Attention written out by matrices, blended place by place."""
    torch = seeded(1)
    attn = layer(torch)
    states, words = torch.randn(2, 24, WIDTH), torch.randn(2, 77, WIDTH)
    regions = [region(checkpoint, "a cube", (0.1, 0.0, 0.7, 1.0)), region(checkpoint, "a palm", (0.4, 0.3, 1.0, 1.0))]
    out = RegionalAttention(attn.processor, regions, (4, 6), True, 10.0)(attn, states, words)

    def attended(query: Any, read: Any) -> Any:
        q, k, v = (m.weight @ x.T for m, x in ((attn.to_q, query), (attn.to_k, read), (attn.to_v, read)))
        rows = [
            torch.softmax(q[h : h + 8].T @ k[h : h + 8] / 8**0.5, dim=1) @ v[h : h + 8].T for h in range(0, WIDTH, 8)
        ]
        return torch.cat(rows, dim=1) @ attn.to_out[0].weight.T + attn.to_out[0].bias

    assert torch.allclose(out[0], attended(states[0], words[0]), atol=1e-5)
    for place in range(24):
        row, column = divmod(place, 6)
        x, y = (column + 0.5) / 6, (row + 0.5) / 4
        total, weight = attended(states[1], words[1])[place], 1.0
        for each in regions:
            x0, y0, x1, y1 = each.box
            if x0 <= x <= x1 and y0 <= y <= y1:
                total, weight = total + 10.0 * attended(states[1], each.hidden_states[0])[place], weight + 10.0
        assert torch.allclose(out[1, place], total / weight, atol=1e-5), place


def test_self_attention_and_the_model_itself_stay(checkpoint: Checkpoint) -> None:
    before = dict(checkpoint.unet.attn_processors)
    with Regional(checkpoint.unet, [region(checkpoint, "a cube", LEFT)], (8, 8), True):
        during = dict(checkpoint.unet.attn_processors)
    assert checkpoint.unet.attn_processors == before
    assert {name for name in before if during[name] is not before[name]} == {n for n in before if ".attn2." in n}


def test_no_regions_change_nothing(checkpoint: Checkpoint) -> None:
    words = checkpoint.text_encoder.encode([("",), ("a beach",)])
    sampling = Sampling(64, 64, 2, 5.0, 1)
    plain = generate_image(checkpoint, words, sampling)
    assert np.array_equal(
        generate_image(checkpoint, words, sampling, Regional(checkpoint.unet, [], (8, 8), True)), plain
    )
    same = [AttentionRegion(LEFT, words[1:], None)]  # told in its box what it is told everywhere
    blended = generate_image(checkpoint, words, sampling, Regional(checkpoint.unet, same, (8, 8), True))
    assert np.abs(blended.astype(int) - plain).max() <= 1


def test_over_a_whole_run_influence_stays_near_the_box(checkpoint: Checkpoint) -> None:
    """Convolutions and self-attention carry a little of it on; what differs, differs mostly in the box."""
    words = checkpoint.text_encoder.encode([("",), ("a beach",)])
    ratios = []
    for box in (LEFT, (0.5, 0.0, 1.0, 1.0), (0.0, 0.5, 1.0, 1.0)):
        latents = [final(checkpoint, words, region(checkpoint, text, box)) for text in TEXTS]
        ratios.append(inner_share(latents[0] - latents[1], box))
    assert min(ratios) > 2.0, ratios
    everywhere = [final(checkpoint, checkpoint.text_encoder.encode([("",), (text,)])) for text in TEXTS]
    assert inner_share(everywhere[0] - everywhere[1], LEFT) < 1.3


def inner_share(difference: Any, box: tuple[float, float, float, float]) -> float:
    """How many times as large latents' difference (1, C, 16, 16) is in a box as outside."""
    torch = seeded()
    flat = difference.abs().mean(dim=(0, 1)).reshape(-1)
    mine = torch.zeros(256, dtype=torch.bool)
    mine[cells_in(box, (16, 16))] = True
    return float(flat[mine].mean() / flat[~mine].mean())


def final(checkpoint: Checkpoint, words: Any, steered: AttentionRegion | None = None) -> Any:
    """The latent after a run, taken where the picture is decoded."""
    kept: list[Any] = []
    steering = Regional(checkpoint.unet, [steered] if steered else [], (16, 16), True)
    hook = checkpoint.vae.decoder.register_forward_pre_hook(lambda _module, given: kept.append(given[0]))
    try:
        generate_image(checkpoint, words, Sampling(128, 128, 6, 3.0, 4), steering)
    finally:
        hook.remove()
    return kept[0]


def test_cells_and_levels() -> None:
    assert cells_in((0.0, 0.0, 0.5, 0.5), (4, 4)) == [0, 1, 4, 5]
    assert cells_in((0.3, 0.3, 0.31, 0.31), (4, 4)) == [5]
    assert cells_in((0.99, 0.99, 1.0, 1.0), (4, 4)) == [15]
    assert [feature_shape(n, (9, 12)) for n in (108, 30, 9, 4, 1)] == [(9, 12), (5, 6), (3, 3), (2, 2), (1, 1)]
    with pytest.raises(ValueError, match="no level"):
        feature_shape(50, (9, 12))
