"""The text encoder of a Stable Diffusion checkpoint, with learned vectors in place of handles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.clip.prompts import Prompt
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

_FIRST = 0  # the number of a token that is no end, where a vector will stand


@dataclass(frozen=True, slots=True, eq=False)
class Encoded:
    """B prompts encoded: ``words`` (B, T, D) are what attention reads, ``pooled`` (B, D) the states at their ends."""

    words: Any
    pooled: Any


@dataclass(frozen=True, slots=True, eq=False)
class TransformerWords:
    """``encoder`` is transformers' CLIPTextModel, ``tokenizer`` its CLIPTokenizer."""

    encoder: Any
    tokenizer: Any

    @property
    def width(self) -> int:
        """Numbers of a token's vector."""
        return int(self.encoder.get_input_embeddings().weight.shape[1])

    @property
    def context(self) -> int:
        """Tokens of a prompt, the two at its ends included."""
        return int(self.encoder.config.max_position_embeddings)

    def encode(self, prompts: Sequence[Prompt], vectors: Mapping[str, Any] | None = None) -> Encoded:
        """The prompts with the vectors (K, D) of their handles; longer ones are cut, as CLIP does. Gradients flow into
        the vectors.

        Raises SceneError("value") for a handle without vectors, or of vectors of another width.
        """
        torch = need("torch", INSTALL)
        lines = [self._line(prompt, vectors or {}) for prompt in prompts]
        device = self.encoder.get_input_embeddings().weight.device
        ids = torch.tensor([[number for number, _ in line] for line in lines], device=device)
        ends = [max(i for i, (_, vector) in enumerate(line) if vector is _END) for line in lines]
        options = {}
        if getattr(self.encoder.config, "use_attention_mask", False):
            places = torch.arange(ids.shape[1], device=device)
            options["attention_mask"] = (places <= torch.tensor(ends, device=device)[:, None]).long()
        with self._spliced(lines):
            states = self.encoder(ids, **options).last_hidden_state
        return Encoded(states, states[torch.arange(len(lines), device=device), ends])

    def _line(self, prompt: Prompt, vectors: Mapping[str, Any]) -> list[tuple[int, Any]]:
        """The token numbers of a prompt up to the context's end, each with the vector in its place."""
        tokens: list[tuple[int, Any]] = []
        for piece in prompt:
            if isinstance(piece, str):
                read = self.tokenizer(piece, add_special_tokens=False, truncation=True, max_length=self.context)
                tokens += [(number, None) for number in read.input_ids]
                continue
            found = vectors.get(piece.name)
            if found is None:
                raise SceneError("value", f"nothing is known of <{piece.name}>: neither vectors nor a text")
            if found.ndim != 2 or found.shape[1] != self.width:
                shape = " x ".join(map(str, found.shape))
                message = f"the vectors of <{piece.name}> are {shape}; those of this model are {self.width} wide"
                raise SceneError("value", message, hint="they were learned for another model")
            tokens += [(_FIRST, vector) for vector in found]
        head, end, pad = self.tokenizer.bos_token_id, self.tokenizer.eos_token_id, self.tokenizer.pad_token_id
        line = [(head, None), *tokens[: self.context - 2], (end, _END)]
        return line + [(pad, None)] * (self.context - len(line))

    @contextmanager
    def _spliced(self, lines: Sequence[Sequence[tuple[int, Any]]]) -> Iterator[None]:
        """Inside the block the encoder reads the vectors: CLIPTextModel takes token numbers only, so they are put in
        place where it looks those up."""
        torch = need("torch", INSTALL)
        places = [
            (b, i, vector)
            for b, line in enumerate(lines)
            for i, (_, vector) in enumerate(line)
            if vector is not None and vector is not _END
        ]

        def splice(_module: Any, _given: Any, looked_up: Any) -> Any:
            mask = torch.zeros(looked_up.shape[:2], dtype=torch.bool, device=looked_up.device)
            mask[[b for b, _, _ in places], [i for _, i, _ in places]] = True
            learned = torch.stack([vector for _, _, vector in places]).to(looked_up)
            return looked_up.masked_scatter(mask[..., None], learned)

        if not places:
            yield
            return
        hook = self.encoder.get_input_embeddings().register_forward_hook(splice)
        try:
            yield
        finally:
            hook.remove()


_END = object()  # marks the end token of a line
