"""Prompts as the states that a diffusion model listens to, with learned vectors in place of handles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from scenelang.backends.base import need
from scenelang.backends.clip.prompts import Prompt
from scenelang.backends.clip.splicing import Vectors, Vocabulary, tokens_of
from scenelang.backends.clip.text import TextEncoder
from scenelang.backends.weights import INSTALL

if TYPE_CHECKING:
    from torch import Tensor


class Words(Protocol):
    """Gradients flow into the vectors and nowhere else."""

    @property
    def width(self) -> int:
        """Numbers of a token's vector, and of a state."""

    @property
    def context(self) -> int:
        """Tokens of a prompt, the two at its ends included."""

    def vectors_of(self, text: str) -> Tensor:
        """The vectors (K, width) of a text's own tokens: what a pseudo-word may start from."""

    def encode(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> Tensor:
        """The states (B, context, width) of prompts with the vectors of their handles; raises SceneError("value") for
        a handle without any, or of vectors of another width."""


class ClipWords:
    """States of the layer before the last of an OpenCLIP text encoder, what MVDream and Stable Diffusion 2 hear."""

    def __init__(self, encoder: TextEncoder) -> None:
        self._encoder = encoder

    @property
    def width(self) -> int:
        return self._encoder.width

    @property
    def context(self) -> int:
        return self._encoder.context

    def vectors_of(self, text: str) -> Tensor:
        return self._encoder.vectors_of(text)  # type: ignore[no-any-return]

    def encode(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> Tensor:
        return self._encoder.encode(prompts, vectors).earlier  # type: ignore[no-any-return]


@dataclass(frozen=True, slots=True, eq=False)
class Encoded:
    """B prompts encoded: ``words`` (B, T, D) are what attention reads, ``pooled`` (B, D) the states at their ends."""

    words: Tensor
    pooled: Tensor


class TransformerWords:
    """States of the last layer of ``network``, a CLIPTextModel of transformers; ``tokenizer`` is its CLIPTokenizer."""

    def __init__(self, network: Any, tokenizer: Any) -> None:
        self._torch = need("torch", INSTALL)
        self.network = network
        self.tokenizer = tokenizer

    @property
    def width(self) -> int:
        return int(self.network.config.hidden_size)

    @property
    def context(self) -> int:
        return int(self.network.config.max_position_embeddings)

    def vectors_of(self, text: str) -> Tensor:
        table = self.network.get_input_embeddings()
        return table(self._torch.tensor(self._numbers(text), device=table.weight.device))  # type: ignore[no-any-return]

    def encode(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> Tensor:
        return self.encoded(prompts, vectors).words

    def encoded(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> Encoded:
        """As ``encode``, with the states at the ends of the prompts."""
        tokenizer = self.tokenizer
        vocabulary = Vocabulary(
            self._numbers,
            tokenizer.bos_token_id,
            tokenizer.eos_token_id,
            tokenizer.pad_token_id,
            self.context,
            self.width,
        )
        table = self.network.get_input_embeddings()
        tokens = tokens_of(prompts, vectors or {}, vocabulary, table.weight.device)

        def spliced(module: Any, given: Any, own: Tensor) -> Any:
            return self._torch.where(tokens.mask[..., None], tokens.vectors.to(own.dtype), own)

        options = {}
        if getattr(self.network.config, "use_attention_mask", False):  # of some checkpoints of Stable Diffusion 2
            places = self._torch.arange(self.context, device=tokens.ids.device)
            options["attention_mask"] = (places <= tokens.ends[:, None]).long()
        hook = table.register_forward_hook(spliced)  # the network itself takes nothing but token numbers
        try:
            states = self.network(input_ids=tokens.ids, **options).last_hidden_state
        finally:
            hook.remove()
        return Encoded(states, states[self._torch.arange(len(states), device=states.device), tokens.ends])

    def _numbers(self, text: str) -> list[int]:
        """No part of a text is a special token: Stable Diffusion 2 calls its padding "!"."""
        return list(self.tokenizer(text, add_special_tokens=False, split_special_tokens=True).input_ids)
