"""The text encoder against OpenCLIP's own, and splicing: learned vectors in place of handles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from searching import many
from small_models import seeded, small_clip

from scenelang.backends.neural.clip import (
    ClipModel,
    ClipName,
    Slot,
    TextEncoder,
    load_clip,
    parse_prompt,
    slots,
    substitute_texts,
)
from scenelang.grammar.diagnostics import SceneError

TEXTS = ["a moai", "a weathered stone moai, in the style of a watercolor, 3D model", "", "Größe! 7 <b>"]
WORDS = st.sampled_from(["moai", "red", "wooden", "castle", "zebra", "chess", "ivory"])


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> ClipModel:
    return load_clip(ClipName(str(small_clip(tmp_path_factory.mktemp("models") / "clip"))))


@pytest.fixture(scope="module")
def encoder(model: ClipModel) -> TextEncoder:
    return TextEncoder(model)


@pytest.mark.parametrize("text", TEXTS)
def test_texts_are_encoded_as_openclip_does(text: str, model: ClipModel, encoder: TextEncoder) -> None:
    torch = seeded()
    found = encoder.encode([(text,) if text else ()])
    expected = model.network.encode_text(model.tokenizer([text]))
    assert torch.allclose(found.pooled, expected, atol=1e-6)


def test_layers(model: ClipModel, encoder: TextEncoder) -> None:
    """The states before the last layer are those of a model without it."""
    torch = seeded()
    found = encoder.encode([("a moai",)])
    text = model.network
    state = text.token_embedding(model.tokenizer(["a moai"])) + text.positional_embedding
    for block in list(text.transformer.resblocks)[:-1]:
        state = block(state, attn_mask=text.attn_mask)
    assert torch.allclose(found.penultimate, text.ln_final(state), atol=1e-6)
    assert found.hidden_states.shape == found.penultimate.shape == (1, 77, 32)


@settings(max_examples=many(25), deadline=None)
@given(st.lists(WORDS, min_size=1, max_size=4), st.lists(WORDS, min_size=1, max_size=3), WORDS)
def test_a_words_own_vectors_are_the_word(encoder: TextEncoder, before: Any, hidden: Any, after: str) -> None:
    torch = seeded()
    said = f"a {' '.join(before)} {' '.join(hidden)} {after}"
    spliced = (f"a {' '.join(before)} ", Slot("z2"), f" {after}")
    vectors = {"z2": encoder.token_embeddings(" ".join(hidden))}
    one, other = encoder.encode([(said,)]), encoder.encode([spliced], vectors)
    assert torch.equal(one.pooled, other.pooled)
    assert torch.equal(one.hidden_states, other.hidden_states)
    assert torch.equal(one.penultimate, other.penultimate)


def test_gradients_reach_only_the_vectors(model: ClipModel, encoder: TextEncoder) -> None:
    torch = seeded()
    vector = torch.randn(2, 32, requires_grad=True)
    encoder.encode(
        [parse_prompt("a <z2> moai, in the style of <z1>")], {"z2": vector, "z1": torch.zeros(1, 32)}
    ).pooled.sum().backward()
    assert vector.grad is not None
    assert float(vector.grad.abs().min()) > 0
    assert all(parameter.grad is None for parameter in model.network.parameters())


def test_long_prompts_are_cut_as_openclip_does(model: ClipModel, encoder: TextEncoder) -> None:
    torch = seeded()
    text = "castle " * 200
    assert torch.allclose(
        encoder.encode([(text,)]).pooled, model.network.encode_text(model.tokenizer([text])), atol=1e-6
    )


def test_prompts_of_different_lengths_are_encoded_together(encoder: TextEncoder) -> None:
    torch = seeded()
    together = encoder.encode([("a moai",), ("a very long castle of ivory and stone",)])
    alone = encoder.encode([("a moai",)])
    assert torch.allclose(together.pooled[:1], alone.pooled, atol=1e-6)


def test_mistakes(encoder: TextEncoder) -> None:
    torch = seeded()
    with pytest.raises(SceneError, match="<z9> has neither learned vectors nor a text"):
        encoder.encode([(Slot("z9"),)])
    with pytest.raises(SceneError, match="have the shape 1 x 8, but this model requires width 32") as caught:
        encoder.encode([(Slot("z9"),)], {"z9": torch.zeros(1, 8)})
    assert "another model" in (caught.value.hint or "")


# --- prompts ---------------------------------------------------------------------------------------------------------


def test_prompts_are_parsed() -> None:
    assert parse_prompt("a <z2> moai, in the style of <z1>, 3D model") == (
        "a ", Slot("z2"), " moai, in the style of ", Slot("z1"), ", 3D model",
    )  # fmt: skip
    assert parse_prompt("<style*>") == (Slot("style*"),)
    assert parse_prompt("1 < 2 > 0 <3>") == ("1 < 2 > 0 <3>",)
    assert parse_prompt("") == ()


def test_texts_are_written_out() -> None:
    prompt = parse_prompt("a <z2> moai in <z1>")
    assert substitute_texts(prompt, {"z2": "mossy"}.get) == ("a mossy moai in ", Slot("z1"))
    assert substitute_texts(prompt, {"z2": "", "z1": "oil"}.get) == ("a  moai in oil",)
    assert slots(prompt) == ("z2", "z1")


# --- loading ---------------------------------------------------------------------------------------------------------


def test_a_shelf_finds_models_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.backends.neural.weights import model_hub

    torch = seeded()
    small_clip(tmp_path / "ViT-H-14")
    found = load_clip(hub=model_hub(tmp_path))
    assert isinstance(found.network.positional_embedding, torch.nn.Parameter)
    monkeypatch.setenv("SCENELANG_MODELS", str(tmp_path))
    assert load_clip(hub=model_hub()).name.architecture == "ViT-H-14"


def test_what_is_not_there_is_one_clear_line(tmp_path: Path) -> None:
    from scenelang.backends.neural.weights import ModelHub, model_hub

    with pytest.raises(SceneError) as caught:
        load_clip(hub=ModelHub(None, download=False))
    assert caught.value.name == "weights"
    assert "ViT-H-14" in caught.value.message
    assert "--models-dir" in (caught.value.hint or "")
    with pytest.raises(SceneError, match="unknown OpenCLIP model `ViT-H-14/nothing`"):
        load_clip(ClipName("ViT-H-14", "nothing"))
    with pytest.raises(SceneError, match=r"the model directory .* does not exist"):
        model_hub(tmp_path / "nowhere")
    (tmp_path / "ViT-H-14").mkdir()
    with pytest.raises(SceneError, match="cannot load the model") as broken:
        load_clip(hub=model_hub(tmp_path))
    assert broken.value.name == "weights"
