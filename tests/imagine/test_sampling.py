"""Pictures: equal to those of diffusers' own pipelines, with words, depth and GLIGEN; learned vectors among words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_diffusion import WIDTH, small_control, small_diffusion
from small_models import seeded

from scenelang.backends.neural.clip import parse_prompt
from scenelang.backends.neural.imagine.layout import AttentionRegion, Gligen, Regional, grounding_tokens
from scenelang.backends.neural.imagine.sampling import (
    Checkpoint,
    Control,
    Sampling,
    check_control,
    generate_image,
    load_checkpoint,
    load_control,
)
from scenelang.backends.neural.weights import ModelHub
from scenelang.grammar.diagnostics import SceneError

SAMPLING = Sampling(64, 64, 4, 5.0, 3)
PROMPT, NEGATIVE = "a mossy moai, on a Beach", "blurry"
BOXES = [(0.0, 0.1, 0.5, 0.9), (0.4, 0.0, 1.0, 1.0)]


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("models")
    small_diffusion(folder / "sd")
    small_control(folder / "control", folder / "sd")
    return folder


@pytest.fixture(scope="module")
def checkpoint(models: Path) -> Checkpoint:
    return load_checkpoint(str(models / "sd"))


@pytest.fixture(scope="module")
def gated(tmp_path_factory: pytest.TempPathFactory) -> Checkpoint:
    return load_checkpoint(str(small_diffusion(tmp_path_factory.mktemp("models") / "gligen", gated=True)))


def words(checkpoint: Checkpoint) -> Any:
    return checkpoint.text_encoder.encode([(NEGATIVE,), (PROMPT,)])


def parts(checkpoint: Checkpoint) -> dict[str, Any]:
    """What diffusers' pipelines are made of."""
    return {
        "vae": checkpoint.vae,
        "unet": checkpoint.unet,
        "text_encoder": checkpoint.text_encoder.network,
        "tokenizer": checkpoint.text_encoder.tokenizer,
        "scheduler": checkpoint.scheduler,
        "safety_checker": None,
        "feature_extractor": None,
        "requires_safety_checker": False,
    }


def theirs(pipeline: Any, **options: Any) -> Any:
    torch = seeded()
    pipeline.set_progress_bar_config(disable=True)
    source = torch.Generator().manual_seed(SAMPLING.seed)
    made = pipeline(
        PROMPT,
        negative_prompt=NEGATIVE,
        num_inference_steps=4,
        guidance_scale=5.0,
        generator=source,
        output_type="np",
        **options,
    )
    return made.images[0] * 255.0


# --- diffusers -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scheduler", ["own", "euler", "ancestral", "pndm"])
@pytest.mark.sampled(2)
def test_pictures_are_those_of_diffusers(scheduler: str, models: Path) -> None:
    import diffusers

    names = {"euler": "EulerDiscreteScheduler", "ancestral": "EulerAncestralDiscreteScheduler", "pndm": "PNDMScheduler"}
    made = load_checkpoint(str(models / "sd"))
    chosen = made.scheduler if scheduler == "own" else getattr(diffusers, names[scheduler])(steps_offset=1)
    made = Checkpoint(made.name, made.unet, made.vae, made.text_encoder, chosen)
    wanted = theirs(diffusers.StableDiffusionPipeline(**parts(made)))
    assert np.abs(generate_image(made, words(made), SAMPLING) - wanted).max() <= 1.0
    assert wanted.std() > 10.0


def test_the_checkpoints_own_scheduler_or_ddim(models: Path) -> None:
    assert type(load_checkpoint(str(models / "sd"), scheduler="ddim").scheduler).__name__ == "DDIMScheduler"


def test_depth_is_that_of_diffusers(checkpoint: Checkpoint, models: Path) -> None:
    import diffusers

    torch = seeded(5)
    network = load_control(str(models / "control"))
    depth = np.tile(np.linspace(1.0, 8.0, 64, dtype=np.float32)[:, None], (1, 64))
    plain = generate_image(checkpoint, words(checkpoint), SAMPLING)
    assert np.array_equal(generate_image(checkpoint, words(checkpoint), SAMPLING, None, Control(network, depth)), plain)
    for parameter in network.parameters():
        torch.nn.init.normal_(parameter, std=0.1)
    pipeline = diffusers.StableDiffusionControlNetPipeline(**parts(checkpoint), controlnet=network)
    inverse = (1.0 / depth - 1.0 / 8.0) / (1.0 - 1.0 / 8.0)
    shown = torch.from_numpy(0.1 + 0.9 * inverse).expand(1, 3, -1, -1)
    found = generate_image(checkpoint, words(checkpoint), SAMPLING, None, Control(network, depth))
    assert np.abs(found - theirs(pipeline, image=shown)).max() <= 1.0
    assert np.abs(found.astype(int) - plain).max() > 3
    half = Sampling(64, 64, 4, 5.0, 3, control=0.5)
    wanted = theirs(pipeline, image=shown, controlnet_conditioning_scale=0.5)
    assert (
        np.abs(generate_image(checkpoint, words(checkpoint), half, None, Control(network, depth)) - wanted).max() <= 1.0
    )


def test_a_controlnet_for_another_model_is_told(checkpoint: Checkpoint) -> None:
    import diffusers

    other = diffusers.ControlNetModel(
        block_out_channels=(16, 16),
        down_block_types=("CrossAttnDownBlock2D", "DownBlock2D"),
        cross_attention_dim=16,
        norm_num_groups=8,
        layers_per_block=1,
    )
    with pytest.raises(SceneError, match="cross_attention_dim is 16, not 32") as caught:
        check_control(other, checkpoint.unet)
    assert caught.value.name == "weights"


# --- GLIGEN ----------------------------------------------------------------------------------------------------------


def regions(checkpoint: Checkpoint, count: int = 2) -> list[AttentionRegion]:
    encoded = checkpoint.text_encoder.encode_with_pooled([("a moai",), ("a tall palm",)])
    return [
        AttentionRegion(BOXES[i % 2], encoded.hidden_states[[i % 2]], encoded.pooled[[i % 2]]) for i in range(count)
    ]


@pytest.mark.slow
def test_closed_gates_change_nothing(gated: Checkpoint) -> None:
    plain = generate_image(gated, words(gated), SAMPLING)
    assert np.array_equal(
        generate_image(gated, words(gated), SAMPLING, Gligen(gated.unet, regions(gated), True)), plain
    )


def test_open_gates_are_those_of_diffusers(gated: Checkpoint) -> None:
    import diffusers

    torch = seeded()
    plain = generate_image(gated, words(gated), SAMPLING)
    alphas = [p for name, p in gated.unet.named_parameters() if name.endswith(("alpha_attn", "alpha_dense"))]
    for parameter in alphas:
        parameter.fill_(1.5)
    pipeline = diffusers.StableDiffusionGLIGENPipeline(**parts(gated))
    boxes = [list(box) for box in BOXES]
    wanted = theirs(
        pipeline, gligen_phrases=["a moai", "a tall palm"], gligen_boxes=boxes, gligen_scheduled_sampling_beta=0.5
    )
    found = generate_image(gated, words(gated), SAMPLING, Gligen(gated.unet, regions(gated), True, beta=0.5))
    for parameter in alphas:
        parameter.fill_(torch.tensor(0.0))
    assert np.abs(found - wanted).max() <= 1.0
    assert np.abs(found.astype(int) - plain).max() > 3


def test_thirty_slots(gated: Checkpoint) -> None:
    given = grounding_tokens(gated.unet, regions(gated, 40), True)
    assert given["boxes"].shape == (2, 30, 4)
    assert given["positive_embeddings"].shape == (2, 30, WIDTH)
    assert given["masks"].sum(dim=1).tolist() == [0.0, 30.0]


def test_a_model_without_gates_is_told(checkpoint: Checkpoint) -> None:
    with pytest.raises(SceneError, match="no gated attention layers of GLIGEN") as caught:
        Gligen(checkpoint.unet, regions(checkpoint), True)
    assert caught.value.name == "weights"


# --- words -----------------------------------------------------------------------------------------------------------


def test_words_are_those_of_transformers(checkpoint: Checkpoint) -> None:
    torch = seeded()
    texts = ["", "a mossy moai", "a castle, " * 60]
    tokens = checkpoint.text_encoder.tokenizer(
        texts, padding="max_length", truncation=True, max_length=77, return_tensors="pt"
    )
    wanted = checkpoint.text_encoder.network(tokens.input_ids)
    found = checkpoint.text_encoder.encode_with_pooled([(text,) if text else () for text in texts])
    assert torch.allclose(found.hidden_states, wanted.last_hidden_state, atol=1e-5)
    assert torch.allclose(found.pooled, wanted.pooler_output, atol=1e-5)


def test_a_vector_equal_to_a_words_own_gives_the_same_picture(checkpoint: Checkpoint) -> None:
    torch = seeded()
    (number,) = checkpoint.text_encoder.tokenizer("mossy", add_special_tokens=False).input_ids[1:] or [None]
    table = checkpoint.text_encoder.network.get_input_embeddings().weight
    numbers = checkpoint.text_encoder.tokenizer("mossy", add_special_tokens=False).input_ids
    vectors = {"z2": table[numbers].detach().clone()}
    assert number is not None
    prompts = [(), parse_prompt("a <z2> moai")], [(), ("a mossy moai",)]
    spliced, written = (checkpoint.text_encoder.encode_with_pooled(each, vectors) for each in prompts)
    assert torch.equal(spliced.hidden_states, written.hidden_states)
    assert torch.equal(spliced.pooled, written.pooled)
    box = (0.0, 0.0, 0.5, 1.0)
    whole = words(checkpoint)
    pictures = [
        generate_image(
            checkpoint,
            whole,
            SAMPLING,
            Regional(checkpoint.unet, [AttentionRegion(box, each.hidden_states[1:], each.pooled[1:])], (8, 8), True),
        )
        for each in (spliced, written, checkpoint.text_encoder.encode_with_pooled([(), ("a golden moai",)]))
    ]
    assert np.array_equal(pictures[0], pictures[1])
    assert not np.array_equal(pictures[0], pictures[2])


def test_gradients_reach_the_vectors(checkpoint: Checkpoint) -> None:
    torch = seeded()
    vector = torch.randn(2, WIDTH, requires_grad=True)
    checkpoint.text_encoder.encode_with_pooled(
        [parse_prompt("a <z2> moai"), ("a palm",)], {"z2": vector}
    ).pooled.sum().backward()
    assert vector.grad is not None
    assert float(vector.grad.abs().min()) > 0.0


def test_vectors_that_do_not_fit(checkpoint: Checkpoint) -> None:
    torch = seeded()
    with pytest.raises(SceneError, match="have the shape 1 x 8, but this model requires width 32"):
        checkpoint.text_encoder.encode([parse_prompt("<z2>")], {"z2": torch.zeros(1, 8)})
    with pytest.raises(SceneError, match="<z2> has neither learned vectors nor a text"):
        checkpoint.text_encoder.encode([parse_prompt("<z2>")])


# --- seeds and mistakes ----------------------------------------------------------------------------------------------


def test_the_seed_decides(checkpoint: Checkpoint) -> None:
    one, again = (generate_image(checkpoint, words(checkpoint), SAMPLING) for _ in range(2))
    assert np.array_equal(one, again)
    assert not np.array_equal(one, generate_image(checkpoint, words(checkpoint), Sampling(64, 64, 4, 5.0, 4)))


def test_without_guidance(checkpoint: Checkpoint) -> None:
    import diffusers

    torch = seeded()
    alone = generate_image(checkpoint, checkpoint.text_encoder.encode([(PROMPT,)]), Sampling(72, 64, 4, 1.0, 3))
    pipeline = diffusers.StableDiffusionPipeline(**parts(checkpoint))
    pipeline.set_progress_bar_config(disable=True)
    source = torch.Generator().manual_seed(3)
    options = {"width": 72, "height": 64, "num_inference_steps": 4, "guidance_scale": 1.0, "output_type": "np"}
    wanted = pipeline(PROMPT, generator=source, **options).images[0] * 255.0
    assert alone.shape == (64, 72, 3)
    assert np.abs(alone - wanted).max() <= 1.0


@pytest.mark.parametrize(
    ("sampling", "said"),
    [
        (Sampling(60, 64), "must be multiples of 8"),
        (Sampling(64, 64, 0), "--steps"),
        (Sampling(64, 64, 4, 1e9), "--guidance"),
        (Sampling(64, 64, 4, float("nan")), "--guidance"),
        (Sampling(64, 64, 4, 1.0, 0, -1.0), "--control-scale"),
    ],
)
def test_mistakes(sampling: Sampling, said: str, checkpoint: Checkpoint) -> None:
    with pytest.raises(SceneError, match=said):
        generate_image(checkpoint, words(checkpoint), sampling)


def test_memory_and_numbers_that_run_out(checkpoint: Checkpoint, monkeypatch: pytest.MonkeyPatch) -> None:
    torch = seeded()

    def full(*_: object, **__: object) -> None:
        raise torch.OutOfMemoryError("CUDA out of memory")

    with monkeypatch.context() as patch:
        patch.setattr(checkpoint.vae, "decode", full)
        with pytest.raises(SceneError, match="out of memory on") as caught:
            generate_image(checkpoint, words(checkpoint), SAMPLING)
    assert caught.value.hint == "use a smaller --size, or --device cpu"
    with pytest.raises(SceneError, match="numeric overflow in the model"):
        generate_image(checkpoint, words(checkpoint) * float("nan"), SAMPLING)


def test_absent_weights(tmp_path: Path) -> None:
    with pytest.raises(SceneError) as caught:
        load_checkpoint(hub=ModelHub(None, download=False))
    assert caught.value.name == "weights"
    assert "stabilityai/stable-diffusion-2-1" in caught.value.message
    assert "mirror" in (caught.value.hint or "")
    (tmp_path / "sd").mkdir()
    with pytest.raises(SceneError, match="cannot load the model"):
        load_checkpoint("sd", ModelHub(tmp_path, download=False))
    with pytest.raises(SceneError, match="thibaud/controlnet-sd21-depth-diffusers"):
        load_control(hub=ModelHub(None, download=False))
