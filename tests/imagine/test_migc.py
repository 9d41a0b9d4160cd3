"""MIGC: its layer equals modules written after the paper's figure, and its checkpoint's key names go both ways."""

from __future__ import annotations

import re
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_diffusion import WIDTH, small_diffusion
from small_models import seeded

from scenelang.backends.neural.imagine.layout import AttentionRegion
from scenelang.backends.neural.imagine.migc import (
    FILE,
    Migc,
    MigcAttention,
    MigcConditioning,
    box_masks,
    expected_shapes,
    from_checkpoint,
    load_migc,
    processor_of,
    shared_box_mask,
    to_checkpoint,
)
from scenelang.backends.neural.imagine.sampling import Checkpoint, Sampling, generate_image, load_checkpoint
from scenelang.backends.neural.weights import ModelHub
from scenelang.grammar.diagnostics import SceneError

BOXES = [(0.0, 0.0, 0.5, 0.75), (0.25, 0.25, 1.0, 1.0), (0.625, 0.0, 0.875, 0.25)]  # of whole cells
MIDDLE = "mid_block.attentions.0.transformer_blocks.0.attn2.processor"
UP = "up_blocks.1.attentions.0.transformer_blocks.0.attn2.processor"


def weights(width: int = WIDTH, text: int = WIDTH, seed: int = 3) -> dict[str, Any]:
    torch = seeded(seed)
    return {name: torch.randn(shape) * 0.3 for name, shape in expected_shapes(width, text).items()}


@pytest.fixture(scope="module")
def checkpoint(tmp_path_factory: pytest.TempPathFactory) -> Checkpoint:
    return load_checkpoint(str(small_diffusion(tmp_path_factory.mktemp("models") / "sd")))


def regions(checkpoint: Checkpoint, texts: list[str]) -> list[AttentionRegion]:
    if not texts:
        return []
    encoded = checkpoint.text_encoder.encode_with_pooled([(text,) for text in texts])
    return [AttentionRegion(BOXES[i], encoded.hidden_states[[i]], encoded.pooled[[i]]) for i in range(len(texts))]


# --- the layer -------------------------------------------------------------------------------------------------------


def reference(
    state: dict[str, Any], attn: Any, own: Any, everywhere: Any, given: list[AttentionRegion], shape: Any
) -> Any:
    """The layer by torch's own modules, for one picture whose places are as many as the masks' cells: (HW, C)."""
    torch = seeded()
    nn, width = torch.nn, own.shape[-1]
    height, breadth = shape

    def module(made: Any, prefix: str) -> Any:
        held = {key[len(prefix) + 1 :]: value for key, value in state.items() if key.startswith(prefix + ".")}
        made.double().load_state_dict(held)
        return made

    def multi(prefix: str, queries: Any, read: Any, hidden: Any = None) -> Any:
        made = nn.MultiheadAttention(
            width, 8, kdim=read.shape[-1], vdim=read.shape[-1], batch_first=True, dtype=torch.double
        )
        with torch.no_grad():
            for name in "qkv":
                weight = state[f"{prefix}.to_{name}.weight"]
                if made.in_proj_weight is None:
                    getattr(made, f"{name}_proj_weight").copy_(weight)
                else:
                    made.in_proj_weight["qkv".index(name) * width :][:width].copy_(weight)
            made.in_proj_bias.zero_()
            made.out_proj.weight.copy_(state[f"{prefix}.to_out.0.weight"])
            made.out_proj.bias.copy_(state[f"{prefix}.to_out.0.bias"])
        return made(queries, read, read, attn_mask=hidden, need_weights=False)[0]

    masks = torch.zeros(len(given), height, breadth, dtype=torch.double)
    for mask, each in zip(masks, given):
        x0, y0, x1, y1 = each.box
        mask[int(y0 * height) : int(y1 * height), int(x0 * breadth) : int(x1 * breadth)] = 1.0
    background = (masks.sum(dim=0) == 0).double()
    embed = module(nn.Sequential(nn.Linear(64, 512), nn.SiLU(), nn.Linear(512, 512), nn.SiLU(), nn.Linear(512, WIDTH)),
                   "pos_net.linears_position")  # fmt: skip
    rows = [everywhere * background.reshape(-1, 1)]
    normal = nn.functional.layer_norm(own, (width,), state["norm.weight"], state["norm.bias"])
    for mask, each in zip(masks, given):
        x0, y0, x1, y1 = each.box
        box = torch.tensor([x0, x1, y0, y1], dtype=torch.double)
        waves = [f(100 ** (i / 8) * box) for i in range(8) for f in (torch.sin, torch.cos)]
        tokens = torch.stack([each.pooled[0], embed(torch.cat(waves))])
        apart = attn.processor(attn, own[None], each.hidden_states)[0] + multi("ea", normal[None], tokens[None])[0]
        rows.append(apart * mask.reshape(-1, 1))
    groups = torch.stack([*masks, background]).reshape(len(given) + 1, -1)
    hidden = torch.einsum("gp,gq->pq", groups, groups) == 0
    blind = hidden.all(dim=1)
    shown = multi("la", own[None], own[None], hidden & ~blind[:, None])[0]
    mean = (own @ state["la.to_v.weight"].T).mean(dim=0) @ state["la.to_out.0.weight"].T + state["la.to_out.0.bias"]
    rows.append(torch.where(blind[:, None], mean, shown))

    about = torch.stack([background, *masks, torch.ones_like(background), torch.zeros_like(background)])
    read = torch.stack([*rows, torch.zeros_like(own)]).reshape(-1, height, breadth, width).permute(0, 3, 1, 2)
    rated = module(nn.Conv2d(width + 1, width, 1), "sac.conv1")(torch.cat([read, about[:, None]], dim=1))
    rated = module(nn.Conv2d(width, 1, 1), "sac.conv2")(cbam(module, "sac.cbam1", rated))[:, 0]
    order = torch.randperm(28, generator=torch.Generator().manual_seed(7))
    slots = [*rated[1:-2], *[rated[-1]] * (28 - len(given))]
    weighed = cbam(module, "sac.cbam2", torch.stack([rated[0], *[slots[i] for i in order], rated[-2]])[None])[0]
    places = order.tolist()
    chosen = torch.stack([weighed[0], *[weighed[1 + places.index(i)] for i in range(len(given))], weighed[-1]])
    share = chosen.reshape(len(rows), -1, 1).softmax(dim=0)
    return sum(row * part for row, part in zip(rows, share))


def cbam(module: Any, prefix: str, state: Any) -> Any:
    """Woo et al. 2018: what matters among channels, then where."""
    torch = seeded()
    nn, channels = torch.nn, state.shape[1]
    hidden = channels // 16 if channels != 30 else 30
    mlp = module(nn.Sequential(nn.Flatten(), nn.Linear(channels, hidden), nn.ReLU(), nn.Linear(hidden, channels)),
                 f"{prefix}.ChannelGate.mlp")  # fmt: skip
    pooled = mlp(nn.AdaptiveAvgPool2d(1)(state)) + mlp(nn.AdaptiveMaxPool2d(1)(state))
    state = state * pooled.sigmoid()[..., None, None]
    spread = module(nn.Conv2d(2, 1, 7, padding=3, bias=False), f"{prefix}.SpatialGate.spatial.conv")
    return state * spread(torch.stack([state.max(dim=1)[0], state.mean(dim=1)], dim=1)).sigmoid()


@pytest.mark.parametrize("count", [1, 3])
def test_a_layer_is_the_papers(count: int, checkpoint: Checkpoint) -> None:
    torch = seeded(2)
    attn = deepcopy(dict(checkpoint.unet.named_modules())[MIDDLE.removesuffix(".processor")]).double()
    told = regions(checkpoint, ["a moai", "a tall palm", "a red cube"][:count])
    given = [AttentionRegion(each.box, each.hidden_states.double(), each.pooled.double()) for each in told]
    own, words = torch.randn(2, 64, WIDTH).double(), torch.randn(2, 77, WIDTH).double()
    state = {name: tensor.double() for name, tensor in weights().items()}
    with torch.no_grad():
        everywhere = attn.processor(attn, own, words)
        wanted = reference(state, attn, own[1], everywhere[1], given, (8, 8))
        made = MigcAttention(attn.processor, state, given, (8, 8), True, torch.Generator().manual_seed(7))
        found = made(attn, own, words)
    assert torch.equal(found[0], everywhere[0])
    assert torch.allclose(found[1], wanted, atol=1e-9)
    assert not torch.allclose(found[1], everywhere[1], atol=1e-2)


def test_layout_attention_reads_every_box() -> None:
    """Two places of the first box see each other, whichever box it is."""
    torch = seeded()
    for boxes in (BOXES, BOXES[::-1]):
        guides = box_masks(boxes, (8, 8), torch.zeros(1, 64, WIDTH))
        x0, y0, x1, y1 = boxes[0]
        within = torch.zeros(8, 8, dtype=torch.bool)
        within[int(8 * y0) : int(8 * y1), int(8 * x0) : int(8 * x1)] = True
        inside = within.reshape(-1).nonzero()[:, 0]
        assert shared_box_mask(guides)[inside][:, inside].all()


def test_it_acts_in_the_first_half_of_the_steps(checkpoint: Checkpoint) -> None:
    seeded()
    given = regions(checkpoint, ["a moai", "a tall palm"])
    steering = MigcConditioning(checkpoint.unet, Migc({UP: weights()}), given, (8, 8), True, 0)
    before = dict(checkpoint.unet.attn_processors)
    with steering:
        layer = checkpoint.unet.attn_processors[UP]
        assert isinstance(layer, MigcAttention)
        active = []
        for number in range(10):
            steering.step(number, 10)
            active.append(layer.active)
    assert active == [True] * 5 + [False] * 5
    assert checkpoint.unet.attn_processors == before


def test_pictures_heed_it_and_repeat(checkpoint: Checkpoint) -> None:
    words = checkpoint.text_encoder.encode([(), ("a beach",)])
    sampling = Sampling(64, 64, 4, 5.0, 3)
    held = Migc({MIDDLE: weights(), UP: weights(seed=4)})

    def picture(texts: list[str]) -> Any:
        steering = MigcConditioning(checkpoint.unet, held, regions(checkpoint, texts), (8, 8), True, 9)
        return generate_image(checkpoint, words, sampling, steering)

    one = picture(["a moai", "a palm"])
    assert np.array_equal(one, picture(["a moai", "a palm"]))
    assert not np.array_equal(one, picture(["a moai", "a red cube"]))
    assert not np.array_equal(one, generate_image(checkpoint, words, sampling))
    plain = generate_image(checkpoint, words, sampling)
    assert np.array_equal(picture([]), plain)


# --- the checkpoint --------------------------------------------------------------------------------------------------


def test_key_names_go_both_ways() -> None:
    names = [MIDDLE, UP, UP.replace("0.transformer", "2.transformer"), UP.replace("blocks.1", "blocks.3")]
    names += [
        f"down_blocks.{i}.attentions.{j}.transformer_blocks.0.attn2.processor" for i in range(3) for j in range(2)
    ]
    held = Migc({name: weights(seed=i) for i, name in enumerate(names)})
    keys = to_checkpoint(held)
    back = from_checkpoint(keys)
    assert list(back.layers) == names
    for name in names:
        assert all(back.layers[name][key] is tensor for key, tensor in held.layers[name].items())
    assert len(keys) == len(names) * len(expected_shapes(WIDTH, WIDTH))
    assert all(re.match(r"model\.diffusion_model\.(input|middle|output)_block", key) for key in keys)


@pytest.mark.parametrize(
    ("key", "layer"),
    [
        ("middle_block.1", "mid_block.attentions.0"),
        ("output_blocks.3.1", "up_blocks.1.attentions.0"),
        ("output_blocks.5.1", "up_blocks.1.attentions.2"),
        ("output_blocks.11.1", "up_blocks.3.attentions.2"),
        ("input_blocks.1.1", "down_blocks.0.attentions.0"),
        ("input_blocks.8.1", "down_blocks.2.attentions.1"),
    ],
)
def test_layers_are_where_diffusers_has_them(key: str, layer: str) -> None:
    """The places of Stable Diffusion 1's blocks, by hand."""
    found = processor_of(f"model.diffusion_model.{key}.transformer_blocks.0.attn2.migc.sac.conv1.weight")
    assert found == (f"{layer}.transformer_blocks.0.attn2.processor", "sac.conv1.weight")


def test_files_are_read(tmp_path: Path) -> None:
    torch = seeded()
    from safetensors.torch import save_file

    tensors = to_checkpoint(Migc({MIDDLE: weights()}))
    (tmp_path / "MIGC").mkdir()
    torch.save({"state_dict": tensors}, tmp_path / "MIGC" / FILE)
    save_file(tensors, tmp_path / "migc.safetensors")
    for found in (load_migc(hub=ModelHub(tmp_path)), load_migc(str(tmp_path / "migc.safetensors"))):
        assert list(found.layers) == [MIDDLE]
        assert found.text_width == WIDTH
        assert torch.equal(found.layers[MIDDLE]["norm.bias"], tensors[next(k for k in tensors if "norm.bias" in k)])


def test_other_weights_are_told(tmp_path: Path, checkpoint: Checkpoint) -> None:
    torch = seeded()
    with pytest.raises(SceneError, match="are not available") as caught:
        load_migc(hub=ModelHub(None))
    assert FILE in (caught.value.hint or "")
    with pytest.raises(SceneError, match=r"unexpected key `model\.weight` in MIGC's checkpoint"):
        from_checkpoint({"model.weight": torch.zeros(1)})
    with pytest.raises(SceneError, match="contains no weights of MIGC"):
        from_checkpoint({})
    broken = weights()
    broken["sac.conv1.weight"] = torch.zeros(2, 2, 1, 1)
    with pytest.raises(SceneError, match=r"sac\.conv1\.weight"):
        from_checkpoint(to_checkpoint(Migc({MIDDLE: broken})))
    (tmp_path / "broken.ckpt").write_bytes(b"not a file of weights")
    with pytest.raises(SceneError, match="cannot load MIGC's weights from") as caught:
        load_migc(str(tmp_path / "broken.ckpt"))
    assert caught.value.name == "weights"
    far = UP.replace("blocks.1", "blocks.3")
    with pytest.raises(SceneError, match=r"no layer up_blocks\.3"):
        MigcConditioning(checkpoint.unet, Migc({far: weights()}), [], (8, 8), True, 0)
    with pytest.raises(SceneError, match="expect text embeddings of width 16, got"):
        MigcConditioning(
            checkpoint.unet, Migc({MIDDLE: weights(text=16)}), regions(checkpoint, ["a moai"]), (8, 8), True, 0
        )


def test_nothing_in_a_checkpoint_is_executed(tmp_path: Path) -> None:
    import pickle

    class Trap:
        def __reduce__(self) -> Any:
            return (Path.touch, (tmp_path / "sprung",))

    (tmp_path / "trap.ckpt").write_bytes(pickle.dumps({"state_dict": Trap()}))
    with pytest.raises(SceneError):
        load_migc(str(tmp_path / "trap.ckpt"))
    assert not (tmp_path / "sprung").exists()
