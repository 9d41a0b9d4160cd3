"""Trains the small diffusion model that the tests distil from: `make train-toy`, about ten minutes on one core.

Run by hand it writes `tests/toy/weights.safetensors` anew; the tests make a few of its steps.

Four views of one colored solid are denoised together under MVDream's conditions (cameras, sentences) with
v-prediction; the text encoder is a small CLIP in OpenCLIP's form that learns along. What is saved is the average of the
weights over the last steps, as the folder layout of docs/distillation.md has it, packed into one file.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from later import later

from scenelang.backends.neural.clip import ClipModel, ClipName, TextEncoder, load_clip
from scenelang.backends.neural.diffusion import DiffusionModel
from scenelang.backends.neural.diffusion_loading import load_diffusion
from toy.model import WEIGHTS, build, pack, save_clip
from toy.pictures import BACKGROUND, COLORS, SENTENCES, SHAPES, STYLES, VIEWS, batch

torch = later("torch")

SEED, STEPS, BATCH = 0, 1500, 6
RATE, DROPPED = 2e-3, 0.15


def train(
    model: DiffusionModel,
    clip: ClipModel,
    steps: int,
    seed: int = SEED,
    report: Callable[[int, float], None] = lambda *_: None,
    grey: float | None = None,
) -> list[float]:
    """Train the networks of ``model`` and ``clip`` in place, all ``steps``; returns the loss of each step."""
    generator = torch.Generator().manual_seed(seed)
    parameters = [*model.network.parameters(), *text_parameters(clip)]
    for parameter in parameters:
        parameter.requires_grad_(True)
    optimiser = torch.optim.AdamW(parameters, lr=RATE, weight_decay=1e-4)
    pace = torch.optim.lr_scheduler.LambdaLR(optimiser, lambda k: min(1, k / 40) * (0.02 + 0.98 * _cosine(k / STEPS)))
    average = [parameter.detach().clone() for parameter in parameters]
    words = TextEncoder(clip)
    losses = []
    for step in range(steps):
        loss = loss_of(model, words, generator, grey)
        optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(parameters, 1.0)
        optimiser.step()
        pace.step()
        keep = min(0.98, (step + 1) / (step + 10))
        torch._foreach_lerp_(average, [parameter.detach() for parameter in parameters], 1.0 - keep)
        losses.append(float(loss.detach()))
        report(step, losses[-1])
    for parameter, mean in zip(parameters, average):
        parameter.data.copy_(mean)
        parameter.requires_grad_(False)
    return losses


def text_parameters(clip: Any) -> list[Any]:
    """The weights of the text tower that its states come from."""
    network = clip.network
    return [
        network.token_embedding.weight,
        network.positional_embedding,
        *network.ln_final.parameters(),
        *network.transformer.parameters(),
    ]


def loss_of(model: DiffusionModel, words: TextEncoder, generator: torch.Generator, grey: float | None = None) -> Any:
    """The mean squared error of v on a batch."""
    texts, pictures, cameras = batch(BATCH, generator, grey)
    heard = ["" if torch.rand((), generator=generator) < DROPPED else text for text in texts]
    states = words.encode([(text,) for text in heard]).penultimate.repeat_interleave(VIEWS, 0)
    clean = model.codec.encode(pictures)
    steps = torch.randint(0, len(model.schedule.alphas_cumprod), (BATCH,), generator=generator).repeat_interleave(VIEWS)
    noise = torch.randn(clean.shape, generator=generator)
    alpha = model.schedule.alphas_cumprod[steps][:, None, None, None]
    wanted = alpha.sqrt() * noise - (1.0 - alpha).sqrt() * clean
    told = model.predict(model.schedule.add_noise(clean, noise, steps), steps, states, cameras)
    return torch.nn.functional.mse_loss(told, wanted)


def _cosine(share: float) -> float:
    return 0.5 + 0.5 * math.cos(math.pi * min(share, 1.0))


def learned_tokens(clip: ClipModel) -> list[int]:
    """The tokens of all sentences, the marks at their ends and the filler."""
    found = {0, clip.tokenizer.sot_token_id, clip.tokenizer.eot_token_id}
    for sentence in SENTENCES:
        for color in COLORS:
            for shape in SHAPES:
                for style in STYLES:
                    found.update(clip.tokenizer.encode(sentence.format(color, shape, style=style)))
    return sorted(found)


def main() -> None:
    import tempfile

    parser = argparse.ArgumentParser(description="train the toy diffusion model anew")
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--one-grey", action="store_true", help="one background, as weights_grey.safetensors has")
    parser.add_argument("-o", "--output", type=Path, default=WEIGHTS)
    given = parser.parse_args()
    torch.set_num_threads(1)
    begun = time.monotonic()

    def report(step: int, loss: float) -> None:
        if step % 50 == 0:
            print(f"step {step}  loss {loss:.4f}  {time.monotonic() - begun:.0f} s", flush=True)

    with tempfile.TemporaryDirectory() as name:
        folder = build(Path(name), given.seed)
        model, clip = load_diffusion(folder), load_clip(ClipName(str(folder / "text")))
        losses = train(model, clip, given.steps, given.seed, report, BACKGROUND if given.one_grey else None)
        model.network.save_pretrained(folder / "unet")
        save_clip(folder / "text", clip.network)
        told = {"seed": str(given.seed), "steps": str(given.steps), "script": "tests/toy/train.py"}
        pack(folder, given.output, learned_tokens(clip), told)
    print(f"wrote {given.output}: loss {sum(losses[-50:]) / len(losses[-50:]):.4f}")


if __name__ == "__main__":
    main()
