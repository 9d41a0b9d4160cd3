"""CLIP models of OpenCLIP, and prompts with learned token embeddings in place of handles.

Learned embeddings are the pseudo-words of Textual Inversion (Gal et al., "An Image is Worth One Word", 2022).
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import require
from scenelang.backends.files import atomic_write
from scenelang.backends.neural.weights import INSTALL, ModelHub, model_hub
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.loading import user_folder

# Loading OpenCLIP models by name, from a folder, the hub's cache or the hub.


@dataclass(frozen=True, slots=True)
class ClipName:
    """OpenCLIP architecture and the tag of its pretrained weights; ``weights`` is empty for a folder."""

    architecture: str
    weights: str = ""

    def __str__(self) -> str:
        return f"{self.architecture}/{self.weights}" if self.weights else self.architecture

    @staticmethod
    def parse(text: str) -> ClipName:
        """Parse a name such as ``ViT-H-14/laion2b_s32b_b79k``, or the path of a folder."""
        if Path(text).expanduser().is_dir():
            return ClipName(text)
        architecture, _, weights = text.partition("/")
        return ClipName(architecture, weights)


EMBEDDING_MODEL = ClipName("ViT-H-14", "laion2b_s32b_b79k")  # its text space is the paper's Z_CLIP (section 4)
SCORE_MODEL = ClipName("ViT-H-14-378-quickgelu", "dfn5b")  # of the paper's CLIP similarity metric


@dataclass(frozen=True, slots=True, eq=False)
class ClipModel:
    """CLIP network with frozen weights, its tokenizer, and the preprocessing function ``prepare`` for PIL images."""

    name: ClipName
    network: Any
    tokenizer: Any
    prepare: Any


def load_clip(name: ClipName = EMBEDDING_MODEL, hub: ModelHub | None = None, device: str = "cpu") -> ClipModel:
    """Load the model ``name`` for inference.

    A local folder contains ``open_clip_config.json`` and the weights, as OpenCLIP saves them. Raises SceneError:
    "value" for an unknown name, "weights" if the weights are unavailable, "backend" without the packages.
    """
    open_clip = require("open_clip", INSTALL)
    network, prepare, tokenizer = (hub or ModelHub()).load(
        name.architecture,
        lambda folder: _create(open_clip, f"local-dir:{folder}", device),
        lambda architecture, offline: _from_hub(open_clip, name, device, architecture, offline=offline),
    )
    network.eval().requires_grad_(False)
    return ClipModel(name, network, tokenizer, prepare)


def _from_hub(open_clip: Any, name: ClipName, device: str, architecture: str, *, offline: bool) -> Any:
    if (architecture, name.weights) not in open_clip.list_pretrained():
        known = sorted({tag for model, tag in open_clip.list_pretrained() if model == architecture})
        hint = f"available weights: {', '.join(known)}" if known else "specify a model of OpenCLIP, or a folder"
        raise SceneError("value", f"unknown OpenCLIP model `{name}`", hint=hint)
    if offline:
        _check_cached(open_clip, name)
    return _create(open_clip, architecture, device, pretrained=name.weights)


def _check_cached(open_clip: Any, name: ClipName) -> None:
    """Raise FileNotFoundError if the weights would have to be downloaded; OpenCLIP has no offline mode itself."""
    huggingface_hub = require("huggingface_hub", INSTALL)
    hub_name = open_clip.get_pretrained_cfg(name.architecture, name.weights).get("hf_hub", "")
    repository = hub_name.rstrip("/")
    for file in ("open_clip_model.safetensors", "open_clip_pytorch_model.bin"):
        if isinstance(huggingface_hub.try_to_load_from_cache(repository, file), str):
            return
    raise FileNotFoundError(f"{repository or name} is not in the cache, and downloads are disabled")


def _create(open_clip: Any, architecture: str, device: str, **options: Any) -> Any:
    network, _, prepare = open_clip.create_model_and_transforms(architecture, device=device, **options)
    return network, prepare, open_clip.get_tokenizer(architecture)


# Image encoder.


def encode_images(model: ClipModel, pictures: Sequence[Any], batch: int = 16) -> Any:
    """Return the embeddings (N, D) of PIL images, not normalised and without gradients."""
    torch = require("torch", INSTALL)
    device = next(model.network.parameters()).device
    embeddings = []
    with torch.no_grad():
        for start in range(0, len(pictures), batch):
            rows = [model.prepare(picture.convert("RGB")) for picture in pictures[start : start + batch]]
            embeddings.append(model.network.encode_image(torch.stack(rows).to(device)))
    return torch.cat(embeddings)


# Prompts with handles: `<z2>` is a placeholder for learned token embeddings, or for the text of that handle.


_HANDLE = re.compile(r"<([A-Za-z][A-Za-z0-9_-]*\*?)>")


@dataclass(frozen=True, slots=True)
class Slot:
    """Placeholder of the handle ``name`` in a prompt."""

    name: str


Prompt = tuple[str | Slot, ...]  # normalised: no empty texts, and no two adjacent texts


def parse_prompt(text: str) -> Prompt:
    """Parse a text with handles: ``a <z2> moai`` becomes ``("a ", Slot("z2"), " moai")``."""
    pieces: list[str | Slot] = []
    for number, piece in enumerate(_HANDLE.split(text)):
        if number % 2:
            pieces.append(Slot(piece))
        elif piece:
            pieces.append(piece)
    return tuple(pieces)


def substitute_texts(prompt: Prompt, text_of: Callable[[str], str | None]) -> Prompt:
    """Replace each slot by ``text_of(name)``; slots for which it returns None remain."""
    pieces: list[str | Slot] = []
    for piece in prompt:
        text = text_of(piece.name) if isinstance(piece, Slot) else piece
        if text is None:
            pieces.append(piece)
        elif pieces and isinstance(pieces[-1], str):
            pieces[-1] += text
        elif text:
            pieces.append(text)
    return tuple(pieces)


def slots(prompt: Prompt) -> tuple[str, ...]:
    """Return the names of the handles in a prompt, without duplicates, in order."""
    return tuple(dict.fromkeys(piece.name for piece in prompt if isinstance(piece, Slot)))


# Tokenized prompts, with learned embeddings at the positions of handles.


Vectors = Mapping[str, Any]  # learned token embeddings by handle: tensors (K, width), which occupy K tokens


@dataclass(frozen=True, slots=True, eq=False)
class TokenBatch:
    """Tokenized prompts: token ``ids`` (B, T); learned ``vectors`` (B, T, width), which replace the embeddings of the
    tokens where ``mask`` (B, T) is set; and ``eos_positions`` (B,)."""

    ids: Any
    vectors: Any
    mask: Any
    eos_positions: Any


@dataclass(frozen=True, slots=True, eq=False)
class PromptVocabulary:
    """Tokenization of a text encoder: ``tokenize`` maps a text to token ids without special tokens; ``bos``, ``eos``
    and ``padding`` are the ids of the special tokens; every prompt has ``context_length`` tokens, embedded in ``width``
    dimensions."""

    tokenize: Callable[[str], list[int]]
    bos: int
    eos: int
    padding: int
    context_length: int
    width: int


def tokenize_prompts(
    prompts: Sequence[Prompt], vectors: Vectors, vocabulary: PromptVocabulary, device: Any
) -> TokenBatch:
    """Tokenize prompts; longer ones are truncated, as CLIP does.

    Raises SceneError("value") for a handle without vectors, or with vectors of another width.
    """
    torch = require("torch", INSTALL)
    length, width = vocabulary.context_length, vocabulary.width
    ids = torch.full((len(prompts), length), vocabulary.padding, dtype=torch.long, device=device)
    mask = torch.zeros((len(prompts), length), dtype=torch.bool, device=device)
    rows, eos_positions = [], []
    for b, prompt in enumerate(prompts):
        pieces = [_tokenize_piece(piece, vectors, vocabulary) for piece in prompt]
        tokens = [n for piece, _ in pieces for n in piece][: length - 2]
        learned = [vector for _, piece in pieces for vector in piece][: length - 2]
        line = [vocabulary.bos, *tokens, vocabulary.eos]
        ids[b, : len(line)] = torch.tensor(line, device=device)
        zero = torch.zeros(width, device=device)
        row = [zero, *(zero if vector is None else vector.to(device) for vector in learned)]
        for position, vector in enumerate(learned, start=1):
            mask[b, position] = vector is not None
        rows.append(torch.stack([*row, *[zero] * (length - len(row))]))
        eos_positions.append(len(line) - 1)
    return TokenBatch(ids, torch.stack(rows), mask, torch.tensor(eos_positions, device=device))


def _tokenize_piece(piece: str | Slot, vectors: Vectors, vocabulary: PromptVocabulary) -> tuple[list[int], list[Any]]:
    """Return the token ids of a piece and the learned vector at each; None: the embedding of the token itself."""
    if isinstance(piece, str):
        tokens = vocabulary.tokenize(piece)
        return tokens, [None] * len(tokens)
    vector = vectors.get(piece.name)
    if vector is None:
        raise SceneError("value", f"<{piece.name}> has neither learned vectors nor a text")
    if vector.ndim != 2 or vector.shape[1] != vocabulary.width:
        shape = " x ".join(map(str, vector.shape))
        message = (
            f"the vectors of <{piece.name}> have the shape {shape}, but this model requires width {vocabulary.width}"
        )
        raise SceneError("value", message, hint="they were learned for another model")
    return [0] * len(vector), list(vector)


@dataclass(frozen=True, slots=True, eq=False)
class EncodedText:
    """Encodings of B prompts.

    Attributes
    ----------
    hidden_states
        (B, T, width), of the last layer after the final norm.
    penultimate
        (B, T, width), of the layer before it after the final norm: the conditioning of MVDream and Stable Diffusion 2.
    pooled
        (B, D), the embeddings in Z_CLIP, not normalised.
    """

    hidden_states: Any
    penultimate: Any
    pooled: Any


class TextEncoder:
    """Text encoder for prompts; gradients flow into the learned vectors only."""

    def __init__(self, model: ClipModel) -> None:
        self._torch = require("torch", INSTALL)
        self._text = getattr(model.network, "text", model.network)  # some architectures have a separate text tower
        self._tokenizer = model.tokenizer

    @property
    def width(self) -> int:
        """Dimensions of a token embedding."""
        return int(self._text.token_embedding.weight.shape[1])

    @property
    def fingerprint(self) -> str:
        """Hash that distinguishes these weights from others of the same architecture."""
        weight = self._text.ln_final.weight.detach().float().cpu().numpy()
        position = self._text.positional_embedding.detach().float().cpu().numpy()
        return hashlib.sha256(weight.tobytes() + position.tobytes()).hexdigest()

    @property
    def context_length(self) -> int:
        """Number of tokens of a prompt, including the two special tokens."""
        return int(self._text.positional_embedding.shape[0])

    def token_embeddings(self, text: str) -> Any:
        """Return the embeddings (K, width) of a text's tokens, from which a pseudo-word may be initialized."""
        ids = self._tokenizer.encode(text)
        device = self._text.token_embedding.weight.device
        return self._text.token_embedding(self._torch.tensor(ids, device=device, dtype=self._torch.long))

    def encode(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> EncodedText:
        """Encode prompts with the vectors of their handles.

        Raises SceneError("value") for a handle without vectors, or with vectors of another width.
        """
        tokens = self.tokenize(prompts, vectors or {})
        torch, text = self._torch, self._text
        embedded = text.token_embedding(tokens.ids)
        state = torch.where(tokens.mask[..., None], tokens.vectors.to(embedded.dtype), embedded)
        state = state + text.positional_embedding.to(embedded.dtype)
        # OpenCLIP's encode_text runs all blocks at once; here the state before the last one is needed too
        blocks = list(text.transformer.resblocks)
        mask = text.attn_mask
        for block in blocks[:-1]:
            state = block(state, attn_mask=mask)
        penultimate = text.ln_final(state)
        hidden_states = text.ln_final(blocks[-1](state, attn_mask=mask))
        rows = torch.arange(len(hidden_states), device=hidden_states.device)
        pooled = hidden_states[rows, tokens.eos_positions]
        projection = text.text_projection
        if projection is not None:
            pooled = projection(pooled) if callable(projection) else pooled @ projection
        return EncodedText(hidden_states, penultimate, pooled)

    def tokenize(self, prompts: Sequence[Prompt], vectors: Vectors) -> TokenBatch:
        """Tokenize prompts; longer ones are truncated, as CLIP does."""
        tokenizer = self._tokenizer
        vocabulary = PromptVocabulary(
            tokenizer.encode, tokenizer.sot_token_id, tokenizer.eot_token_id, 0, self.context_length, self.width
        )
        return tokenize_prompts(prompts, vectors, vocabulary, self._text.token_embedding.weight.device)


# The text tower of an OpenCLIP model alone, without the image tower, which is as large.


_SUPPORTED_SETTINGS = {"context_length", "vocab_size", "width", "heads", "layers", "mlp_ratio"}


def build_text_tower(config: Mapping[str, Any]) -> Any:
    """Build the text tower of an OpenCLIP ``model_cfg`` on the device "meta", without weights.

    Raises SceneError("weights") if it is not a plain transformer.
    """
    torch = require("torch", INSTALL)
    transformer = require("open_clip.transformer", INSTALL)
    settings = config.get("text_cfg")
    if not isinstance(settings, dict) or not isinstance(config.get("embed_dim"), int):
        raise SceneError("weights", "invalid OpenCLIP configuration: expected `text_cfg` and `embed_dim`")
    unsupported = sorted(set(settings) - _SUPPORTED_SETTINGS)
    if unsupported:
        raise SceneError("weights", f"unsupported setting `{unsupported[0]}` of the OpenCLIP text encoder")
    activation = transformer.QuickGELU if config.get("quick_gelu") else torch.nn.GELU
    with torch.device("meta"):
        tower = transformer.TextTransformer(**settings, output_dim=config["embed_dim"], act_layer=activation)
    tower.attn_mask = tower.build_causal_mask()  # not a weight, so it is not in the checkpoint
    return tower


def text_weights(tensors: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tensors of the text tower among those of an OpenCLIP checkpoint."""
    own = {key.removeprefix("text."): tensor for key, tensor in tensors.items() if not key.startswith("visual.")}
    return {key: tensor for key, tensor in own.items() if key not in ("logit_scale", "logit_bias", "attn_mask")}


def text_only_model(name: str, tower: Any) -> ClipModel:
    """Return a model with the text tower and OpenCLIP's tokenizer, which cannot encode images.

    The image encoder is larger, and unused.
    """
    open_clip = require("open_clip", INSTALL)
    return ClipModel(ClipName(name), tower, open_clip.SimpleTokenizer(context_length=tower.context_length), None)


# Nearest name by meaning, for unknown Minecraft blocks.


_BLOCK_PROMPT = "a block of {} in Minecraft"


_BATCH = 32


def image_similarity(first: Any, second: Any) -> float:
    """Return the cosine of two PIL images for the model of the CLIP score, which is not downloaded for it.

    Raises SceneError or OSError if its weights are missing.
    """
    a, b = encode_images(load_clip(SCORE_MODEL, ModelHub(download=False)), [first, second])
    return float(a @ b / (a.norm() * b.norm()))


def nearest_by_meaning(name: str, candidates: Sequence[str]) -> str | None:
    """Return the candidate with the largest cosine similarity to ``name`` in OpenCLIP's text space.

    None if the extra `neural` or the weights are not installed locally; this never downloads weights.
    """
    if find_spec("open_clip") is None or find_spec("torch") is None:
        return None
    try:
        encoder = _encoder(str(model_hub().folder or ""))
    except SceneError:
        return None
    embeddings = _candidate_embeddings(encoder, tuple(candidates))
    (query,) = _embed_names(encoder, [name])
    return candidates[int(np.argmax(embeddings @ query))]


@lru_cache(maxsize=1)
def _encoder(folder: str) -> TextEncoder:
    """Return the encoder of the paper's text space, from the local ``folder`` or the hub's cache."""
    return TextEncoder(load_clip(EMBEDDING_MODEL, model_hub(folder or None, download=False)))


def _candidate_embeddings(encoder: TextEncoder, names: tuple[str, ...]) -> npt.NDArray[np.float32]:
    """Return the unit embeddings (N, D) of all candidate names, cached in the user's cache folder."""
    key = "\n".join([str(EMBEDDING_MODEL), encoder.fingerprint, *names])
    path = user_folder("CACHE") / f"blocks-{hashlib.sha256(key.encode()).hexdigest()[:16]}.npy"
    cached = _load_cached(path, len(names))
    if cached is not None:
        return cached
    embeddings = _embed_names(encoder, names)
    _save_cached(path, embeddings)
    return embeddings


def _embed_names(encoder: TextEncoder, names: Sequence[str]) -> npt.NDArray[np.float32]:
    """Return the unit embeddings (N, D) of block names."""
    rows = []
    for start in range(0, len(names), _BATCH):
        prompts = [(_BLOCK_PROMPT.format(name.replace("_", " ")),) for name in names[start : start + _BATCH]]
        rows.append(encoder.encode(prompts).pooled.float().cpu().numpy())
    matrix: npt.NDArray[np.float32] = np.concatenate(rows, dtype=np.float32)
    matrix /= np.maximum(np.linalg.norm(matrix, axis=1, keepdims=True), 1e-12)
    return matrix


def _load_cached(path: Path, count: int) -> npt.NDArray[np.float32] | None:
    try:
        array: npt.NDArray[np.float32] = np.load(path, allow_pickle=False)
    except (OSError, ValueError):
        return None
    return array if array.ndim == 2 and len(array) == count else None


def _save_cached(path: Path, matrix: npt.NDArray[np.float32]) -> None:
    """Save embeddings to the cache, if it is writable."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as temporary, temporary.open("wb") as file:
            np.save(file, matrix)
    except (OSError, SceneError):
        return
