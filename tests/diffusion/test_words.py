"""What models hear: the same states by OpenCLIP and by transformers, and learned vectors in both."""

from __future__ import annotations

from typing import Any

import pytest
from small_models import clip_tokenizer, seeded, small_clip, small_text

from scenelang.backends.neural.clip import ClipName, Prompt, Slot, TextEncoder, load_clip
from scenelang.backends.neural.diffusion import ClipPromptEncoder, TransformersPromptEncoder
from scenelang.grammar.diagnostics import SceneError

PROMPTS: list[Prompt] = [("a moai, in the style of a watercolor",), (), ("castle " * 100,), ("Red <b>blue</b>; 7",)]


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[ClipPromptEncoder, TransformersPromptEncoder]:
    """A text encoder of OpenCLIP, and one of transformers that holds all of its layers but the last."""
    clip = load_clip(ClipName(str(small_clip(tmp_path_factory.mktemp("models") / "clip", layers=3))))
    network = small_text(layers=2)
    network.load_state_dict(as_transformers(clip.network.state_dict(), layers=2), strict=True)
    network.requires_grad_(False)
    return ClipPromptEncoder(TextEncoder(clip)), TransformersPromptEncoder(network, clip_tokenizer())


def as_transformers(tensors: dict[str, Any], layers: int) -> dict[str, Any]:
    found = {
        "embeddings.token_embedding.weight": tensors["token_embedding.weight"],
        "embeddings.position_embedding.weight": tensors["positional_embedding"],
    }
    for end in ("weight", "bias"):
        found[f"final_layer_norm.{end}"] = tensors[f"ln_final.{end}"]
        for number in range(layers):
            ours, theirs = f"encoder.layers.{number}", f"transformer.resblocks.{number}"
            for name, part in zip("qkv", tensors[f"{theirs}.attn.in_proj_{end}"].chunk(3), strict=True):
                found[f"{ours}.self_attn.{name}_proj.{end}"] = part
            found[f"{ours}.self_attn.out_proj.{end}"] = tensors[f"{theirs}.attn.out_proj.{end}"]
            for one, other in (
                ("layer_norm1", "ln_1"),
                ("layer_norm2", "ln_2"),
                ("mlp.fc1", "mlp.c_fc"),
                ("mlp.fc2", "mlp.c_proj"),
            ):
                found[f"{ours}.{one}.{end}"] = tensors[f"{theirs}.{other}.{end}"]
    return found


def test_both_hear_the_same(pair: tuple[ClipPromptEncoder, TransformersPromptEncoder]) -> None:
    torch = seeded()
    one, other = (words.encode(PROMPTS) for words in pair)
    assert one.shape == other.shape == (len(PROMPTS), 77, 32)
    assert torch.allclose(one, other, atol=1e-5)
    assert [(words.width, words.context_length) for words in pair] == [(32, 77)] * 2


def test_both_hear_learned_vectors(pair: tuple[ClipPromptEncoder, TransformersPromptEncoder]) -> None:
    torch = seeded()
    vectors = {"z2": torch.randn(2, 32)}
    one, other = (words.encode([("a ", Slot("z2"), " moai")], vectors) for words in pair)
    assert torch.allclose(one, other, atol=1e-5)
    assert not torch.allclose(one, pair[0].encode([("a big old moai",)]), atol=1e-2)


@pytest.mark.parametrize("which", [0, 1])
def test_a_words_own_vectors_are_the_word(
    pair: tuple[ClipPromptEncoder, TransformersPromptEncoder], which: int
) -> None:
    torch = seeded()
    words = pair[which]
    vectors = {"z2": words.token_embeddings("weathered stone")}
    spliced = words.encode([("a ", Slot("z2"), " moai")], vectors)
    assert torch.equal(spliced, words.encode([("a weathered stone moai",)]))


@pytest.mark.parametrize("which", [0, 1])
def test_gradients_reach_only_the_vectors(
    pair: tuple[ClipPromptEncoder, TransformersPromptEncoder], which: int
) -> None:
    torch = seeded()
    vector = torch.randn(1, 32, requires_grad=True)
    states = pair[which].encode([("a ", Slot("z2"))], {"z2": vector})
    before, after = states[0, 1], states[0, 5]  # words look back only
    assert not torch.autograd.grad(before.square().sum(), vector, retain_graph=True)[0].any()
    (after * torch.randn(32)).sum().backward()
    assert vector.grad is not None
    assert float(vector.grad.abs().max()) > 1e-3


def test_an_exclamation_mark_is_a_word(pair: tuple[ClipPromptEncoder, TransformersPromptEncoder]) -> None:
    """Stable Diffusion 2 pads with "!", which is not what the text encoder learned for one in a prompt."""
    torch = seeded()
    one, other = (words.encode([("a moai! of Dürer",)]) for words in pair)
    assert torch.allclose(one, other, atol=1e-5)


def test_nothing_of_a_prompt_stays(pair: tuple[ClipPromptEncoder, TransformersPromptEncoder]) -> None:
    torch = seeded()
    words = pair[1]
    before = words.encode([("a moai",)])
    with pytest.raises(SceneError, match="have the shape 1 x 8, but this model requires width 32"):
        words.encode([(Slot("z2"),)], {"z2": torch.zeros(1, 8)})
    with pytest.raises(SceneError, match="<z3> has neither learned vectors nor a text"):
        words.encode([(Slot("z3"),)])
    words.encode([(Slot("z2"),)], {"z2": torch.ones(1, 32)})
    assert torch.equal(words.encode([("a moai",)]), before)
