"""The text encoder of a CLIP model, with learned vectors in place of handles (Textual Inversion's pseudo-words)."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.clip.models import ClipModel
from scenelang.backends.clip.prompts import Prompt
from scenelang.backends.clip.splicing import Tokens, Vectors, Vocabulary, tokens_of
from scenelang.backends.weights import INSTALL


@dataclass(frozen=True, slots=True, eq=False)
class Encoded:
    """B prompts encoded: ``words`` (B, T, width) are the states of the last layer after the final norm, ``earlier``
    those of the layer before (what MVDream and Stable Diffusion 2 listen to), ``pooled`` (B, D) the embedding in
    Z_CLIP, not normalised."""

    words: Any
    earlier: Any
    pooled: Any


class TextEncoder:
    """Encodes prompts; gradients flow into the vectors and nowhere else."""

    def __init__(self, model: ClipModel) -> None:
        self._torch = need("torch", INSTALL)
        self._text = getattr(model.network, "text", model.network)  # some models have a tower of its own
        self._tokenizer = model.tokenizer

    @property
    def width(self) -> int:
        """Numbers of a token's vector."""
        return int(self._text.token_embedding.weight.shape[1])

    @property
    def fingerprint(self) -> str:
        """What tells these weights from others of the same architecture."""
        weight = self._text.ln_final.weight.detach().float().cpu().numpy()
        position = self._text.positional_embedding.detach().float().cpu().numpy()
        return hashlib.sha256(weight.tobytes() + position.tobytes()).hexdigest()

    @property
    def context(self) -> int:
        """Tokens of a prompt, the two at its ends included."""
        return int(self._text.positional_embedding.shape[0])

    def vectors_of(self, text: str) -> Any:
        """The vectors (K, width) of a text's own tokens: what a pseudo-word may start from."""
        ids = self._tokenizer.encode(text)
        device = self._text.token_embedding.weight.device
        return self._text.token_embedding(self._torch.tensor(ids, device=device, dtype=self._torch.long))

    def encode(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> Encoded:
        """The prompts with the vectors of their handles; raises SceneError("value") for a handle without any, or of
        vectors of another width."""
        tokens = self.tokens(prompts, vectors or {})
        torch, text = self._torch, self._text
        own = text.token_embedding(tokens.ids)
        state = torch.where(tokens.mask[..., None], tokens.vectors.to(own.dtype), own)
        state = state + text.positional_embedding.to(own.dtype)
        blocks = list(text.transformer.resblocks)
        mask = text.attn_mask
        for block in blocks[:-1]:
            state = block(state, attn_mask=mask)
        earlier = text.ln_final(state)
        words = text.ln_final(blocks[-1](state, attn_mask=mask))
        pooled = words[torch.arange(len(words), device=words.device), tokens.ends]
        projection = text.text_projection
        if projection is not None:
            pooled = projection(pooled) if callable(projection) else pooled @ projection
        return Encoded(words, earlier, pooled)

    def tokens(self, prompts: Sequence[Prompt], vectors: Vectors) -> Tokens:
        """What the encoder reads of each prompt; longer ones are cut, as CLIP does."""
        tokenizer = self._tokenizer
        vocabulary = Vocabulary(
            tokenizer.encode, tokenizer.sot_token_id, tokenizer.eot_token_id, 0, self.context, self.width
        )
        return tokens_of(prompts, vectors, vocabulary, self._text.token_embedding.weight.device)
