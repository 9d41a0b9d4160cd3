"""The text encoder of a CLIP model, with learned vectors in place of handles (Textual Inversion's pseudo-words)."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.clip.models import ClipModel
from scenelang.backends.clip.prompts import Prompt, Slot
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

Vectors = Mapping[str, Any]  # by handle: tensors (K, width) in the space of the tokens' own vectors, K words each


@dataclass(frozen=True, slots=True, eq=False)
class Encoded:
    """B prompts encoded: ``words`` (B, T, width) are the states of the last layer after the final norm, ``earlier``
    those of the layer before (what MVDream and Stable Diffusion 2 listen to), ``pooled`` (B, D) the embedding in
    Z_CLIP, not normalised."""

    words: Any
    earlier: Any
    pooled: Any


@dataclass(frozen=True, slots=True, eq=False)
class Tokens:
    """Prompts as token numbers ``ids`` (B, T), with ``vectors`` (B, T, width) in the places where ``mask`` (B, T);
    ``ends`` (B,) are the places of the end tokens."""

    ids: Any
    vectors: Any
    mask: Any
    ends: Any


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
        torch, context = self._torch, self.context
        device = self._text.token_embedding.weight.device
        ids = torch.zeros((len(prompts), context), dtype=torch.long, device=device)
        mask = torch.zeros((len(prompts), context), dtype=torch.bool, device=device)
        rows, ends = [], []
        for b, prompt in enumerate(prompts):
            pieces = [self._piece(piece, vectors) for piece in prompt]
            numbers = [n for piece, _ in pieces for n in piece][: context - 2]
            learned = [vector for _, piece in pieces for vector in piece][: context - 2]
            line = [self._tokenizer.sot_token_id, *numbers, self._tokenizer.eot_token_id]
            ids[b, : len(line)] = torch.tensor(line, device=device)
            zero = torch.zeros(self.width, device=device)
            row = [zero, *(zero if vector is None else vector.to(device) for vector in learned)]
            for place, vector in enumerate(learned, start=1):
                mask[b, place] = vector is not None
            rows.append(torch.stack([*row, *[zero] * (context - len(row))]))
            ends.append(len(line) - 1)
        return Tokens(ids, torch.stack(rows), mask, torch.tensor(ends, device=device))

    def _piece(self, piece: str | Slot, vectors: Vectors) -> tuple[list[int], list[Any]]:
        """The token numbers of a piece, and the vector in place of each, None for a token's own."""
        if isinstance(piece, str):
            numbers: list[int] = self._tokenizer.encode(piece)
            return numbers, [None] * len(numbers)
        found = vectors.get(piece.name)
        if found is None:
            raise SceneError("value", f"nothing is known of <{piece.name}>: neither vectors nor a text")
        if found.ndim != 2 or found.shape[1] != self.width:
            shape = " x ".join(map(str, found.shape))
            message = f"the vectors of <{piece.name}> are {shape}; those of this model are {self.width} wide"
            raise SceneError("value", message, hint="they were learned for another model")
        return [0] * len(found), list(found)
