"""What tests of loading share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from small_models import seeded

from scenelang.backends.neural.diffusion_loading import load_diffusion
from scenelang.backends.neural.mvdream import ORIGINAL, Architecture
from scenelang.grammar.diagnostics import SceneError


def predicted(diffusion: Any, latents: Any, cameras: Any = None, depth: Any = None) -> Any:
    torch = seeded()
    states = diffusion.text_encoder.encode([("a red sphere",)] * len(latents))
    with torch.no_grad():
        return diffusion.predict(latents, torch.full((len(latents),), 300), states, cameras, depth)


class Evil:
    """Pickled and loaded without care, it makes the file ``mark``."""

    def __init__(self, mark: Path) -> None:
        self.mark = mark

    def __reduce__(self) -> Any:
        return (Path.touch, (self.mark,))


def wrong(path: Path, said: str, architecture: Architecture = ORIGINAL) -> None:
    with pytest.raises(SceneError, match=said) as caught:
        load_diffusion(path, architecture=architecture)
    assert caught.value.name == "weights"
    assert "\n" not in caught.value.message
    assert len(caught.value.message) < 500
