"""The text encoder of a CLIP model, with learned vectors in place of handles (Textual Inversion's pseudo-words)."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.base import need
from scenelang.backends.files import reason_of, user_folder, written_whole
from scenelang.backends.neural.weights import INSTALL, Shelf, shelf
from scenelang.grammar.diagnostics import SceneError

# OpenCLIP models by name: loaded from a folder, from the hub's cache or from the hub.


@dataclass(frozen=True, slots=True)
class ClipName:
    """An architecture of OpenCLIP and the tag of its weights; ``weights`` is empty for a folder that has its own."""

    architecture: str
    weights: str = ""

    def __str__(self) -> str:
        return f"{self.architecture}/{self.weights}" if self.weights else self.architecture

    @staticmethod
    def parse(text: str) -> ClipName:
        """``ViT-H-14/laion2b_s32b_b79k``, or a folder."""
        if Path(text).expanduser().is_dir():
            return ClipName(text)
        architecture, _, weights = text.partition("/")
        return ClipName(architecture, weights)


TEXT_SPACE = ClipName("ViT-H-14", "laion2b_s32b_b79k")  # Z_CLIP, the space of the paper's embeddings
JUDGE = ClipName("ViT-H-14-378-quickgelu", "dfn5b")  # that of its metric


@dataclass(frozen=True, slots=True, eq=False)
class ClipModel:
    """A model, its tokenizer and the function that prepares a PIL picture for it; weights are frozen."""

    name: ClipName
    network: Any
    tokenizer: Any
    prepare: Any


def load_clip(name: ClipName = TEXT_SPACE, shelf: Shelf | None = None, device: str = "cpu") -> ClipModel:
    """The model ``name``, ready to encode.

    A folder on the shelf called after the architecture holds ``open_clip_config.json`` and the weights, as OpenCLIP
    writes them. Raises SceneError: "weights" where these are not to be had, "backend" without the packages.
    """
    open_clip = need("open_clip", INSTALL)
    network, prepare, tokenizer = (shelf or Shelf()).load(
        name.architecture,
        lambda folder: _made(open_clip, f"local-dir:{folder}", device),
        partial(_from_hub, open_clip, name, device),
    )
    network.eval().requires_grad_(False)
    return ClipModel(name, network, tokenizer, prepare)


def _from_hub(open_clip: Any, name: ClipName, device: str, architecture: str, offline: bool) -> Any:
    if (architecture, name.weights) not in open_clip.list_pretrained():
        known = sorted({tag for model, tag in open_clip.list_pretrained() if model == architecture})
        hint = f"its weights are {', '.join(known)}" if known else "name a model of OpenCLIP, or a folder"
        raise SceneError("value", f"OpenCLIP has no model `{name}`", hint=hint)
    if offline:
        _check_cached(open_clip, name)
    return _made(open_clip, architecture, device, pretrained=name.weights)


def _check_cached(open_clip: Any, name: ClipName) -> None:
    """Raises FileNotFoundError where the hub would be asked for the weights."""
    hub = need("huggingface_hub", INSTALL)
    found = open_clip.get_pretrained_cfg(name.architecture, name.weights).get("hf_hub", "")
    repository = found.rstrip("/")
    for file in ("open_clip_model.safetensors", "open_clip_pytorch_model.bin"):
        if isinstance(hub.try_to_load_from_cache(repository, file), str):
            return
    raise FileNotFoundError(f"{repository or name} is not in the cache, and downloads are disabled")


def _made(open_clip: Any, architecture: str, device: str, **options: Any) -> Any:
    network, _, prepare = open_clip.create_model_and_transforms(architecture, device=device, **options)
    return network, prepare, open_clip.get_tokenizer(architecture)


# The image encoder of a CLIP model.


_LARGEST = 64_000_000  # pixels


def encode_images(model: ClipModel, pictures: Sequence[Any], batch: int = 16) -> Any:
    """The embeddings (N, D) of PIL pictures, not normalised; gradients stop here."""
    torch = need("torch", INSTALL)
    device = next(model.network.parameters()).device
    found = []
    with torch.no_grad():
        for start in range(0, len(pictures), batch):
            rows = [model.prepare(picture.convert("RGB")) for picture in pictures[start : start + batch]]
            found.append(model.network.encode_image(torch.stack(rows).to(device)))
    return torch.cat(found)


def open_picture(path: Path | str | BytesIO) -> Any:
    """A picture file as RGB; raises SceneError("file") where it is none, or too large."""
    image = need("PIL.Image", "pillow")
    try:
        with image.open(path) as picture:
            if picture.width * picture.height > _LARGEST:
                raise SceneError("file", f"{path} has more than {_LARGEST:,} pixels")
            return need("PIL.ImageOps", "pillow").exif_transpose(picture).convert("RGB")
    except (OSError, ValueError, SyntaxError, image.DecompressionBombError) as error:
        raise SceneError("file", f"cannot read {path} as an image: {reason_of(error)}") from None


# Prompts with handles: text in which `<z2>` stands for learned vectors, or for a text of its own.


_HANDLE = re.compile(r"<([A-Za-z][A-Za-z0-9_-]*\*?)>")


@dataclass(frozen=True, slots=True)
class Slot:
    """The place of the handle ``name`` in a prompt."""

    name: str


Prompt = tuple[str | Slot, ...]  # no two texts beside each other, no empty ones


def parse_prompt(text: str) -> Prompt:
    """``a <z2> moai`` as its parts: ``("a ", Slot("z2"), " moai")``."""
    pieces: list[str | Slot] = []
    for number, piece in enumerate(_HANDLE.split(text)):
        if number % 2:
            pieces.append(Slot(piece))
        elif piece:
            pieces.append(piece)
    return tuple(pieces)


def with_texts(prompt: Prompt, text_of: Callable[[str], str | None]) -> Prompt:
    """The prompt with the slots that ``text_of`` has a text for written out."""
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
    """The names of the handles in a prompt, each once, in order."""
    return tuple(dict.fromkeys(piece.name for piece in prompt if isinstance(piece, Slot)))


# Prompts as the tokens that a text encoder reads, with learned vectors in the places of handles.


Vectors = Mapping[str, Any]  # by handle: tensors (K, width) in the space of the tokens' own vectors, K words each


@dataclass(frozen=True, slots=True, eq=False)
class Tokens:
    """Prompts as token numbers ``ids`` (B, T), with ``vectors`` (B, T, width) in the places where ``mask`` (B, T);
    ``ends`` (B,) are the places of the end tokens."""

    ids: Any
    vectors: Any
    mask: Any
    ends: Any


@dataclass(frozen=True, slots=True, eq=False)
class PromptVocabulary:
    """How an encoder reads text: ``numbers`` gives the tokens of a text, ``start``, ``end`` and ``padding`` stand
    around them; ``context`` tokens in all, each a vector of ``width``."""

    numbers: Callable[[str], list[int]]
    start: int
    end: int
    padding: int
    context: int
    width: int


def tokens_of(prompts: Sequence[Prompt], vectors: Vectors, vocabulary: PromptVocabulary, device: Any) -> Tokens:
    """What an encoder reads of each prompt; longer ones are cut, as CLIP does.

    Raises SceneError("value") for a handle without vectors, or of vectors of another width.
    """
    torch = need("torch", INSTALL)
    context, width = vocabulary.context, vocabulary.width
    ids = torch.full((len(prompts), context), vocabulary.padding, dtype=torch.long, device=device)
    mask = torch.zeros((len(prompts), context), dtype=torch.bool, device=device)
    rows, ends = [], []
    for b, prompt in enumerate(prompts):
        pieces = [_piece(piece, vectors, vocabulary) for piece in prompt]
        numbers = [n for piece, _ in pieces for n in piece][: context - 2]
        learned = [vector for _, piece in pieces for vector in piece][: context - 2]
        line = [vocabulary.start, *numbers, vocabulary.end]
        ids[b, : len(line)] = torch.tensor(line, device=device)
        zero = torch.zeros(width, device=device)
        row = [zero, *(zero if vector is None else vector.to(device) for vector in learned)]
        for place, vector in enumerate(learned, start=1):
            mask[b, place] = vector is not None
        rows.append(torch.stack([*row, *[zero] * (context - len(row))]))
        ends.append(len(line) - 1)
    return Tokens(ids, torch.stack(rows), mask, torch.tensor(ends, device=device))


def _piece(piece: str | Slot, vectors: Vectors, vocabulary: PromptVocabulary) -> tuple[list[int], list[Any]]:
    """The token numbers of a piece, and the vector in place of each, None for a token's own."""
    if isinstance(piece, str):
        numbers = vocabulary.numbers(piece)
        return numbers, [None] * len(numbers)
    found = vectors.get(piece.name)
    if found is None:
        raise SceneError("value", f"nothing is known of <{piece.name}>: neither vectors nor a text")
    if found.ndim != 2 or found.shape[1] != vocabulary.width:
        shape = " x ".join(map(str, found.shape))
        message = f"the vectors of <{piece.name}> are {shape}; those of this model are {vocabulary.width} wide"
        raise SceneError("value", message, hint="they were learned for another model")
    return [0] * len(found), list(found)


@dataclass(frozen=True, slots=True, eq=False)
class EncodedText:
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

    def encode(self, prompts: Sequence[Prompt], vectors: Vectors | None = None) -> EncodedText:
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
        return EncodedText(words, earlier, pooled)

    def tokens(self, prompts: Sequence[Prompt], vectors: Vectors) -> Tokens:
        """What the encoder reads of each prompt; longer ones are cut, as CLIP does."""
        tokenizer = self._tokenizer
        vocabulary = PromptVocabulary(
            tokenizer.encode, tokenizer.sot_token_id, tokenizer.eot_token_id, 0, self.context, self.width
        )
        return tokens_of(prompts, vectors, vocabulary, self._text.token_embedding.weight.device)


# The text encoder of an OpenCLIP model alone, without that of pictures, which is as large again.


_SETTINGS = {"context_length", "vocab_size", "width", "heads", "layers", "mlp_ratio"}


def empty_tower(config: Mapping[str, Any]) -> Any:
    """The text encoder of a ``model_cfg`` of OpenCLIP on torch's device "meta": shapes without weights.

    Raises SceneError("weights") where it is more than a plain transformer.
    """
    torch = need("torch", INSTALL)
    transformer = need("open_clip.transformer", INSTALL)
    settings = config.get("text_cfg")
    if not isinstance(settings, dict) or not isinstance(config.get("embed_dim"), int):
        raise SceneError("weights", "the settings of the text encoder are not OpenCLIP's")
    foreign = sorted(set(settings) - _SETTINGS)
    if foreign:
        raise SceneError("weights", f"a text encoder with `{foreign[0]}` cannot be used by a diffusion model here")
    activation = transformer.QuickGELU if config.get("quick_gelu") else torch.nn.GELU
    with torch.device("meta"):
        tower = transformer.TextTransformer(**settings, output_dim=config["embed_dim"], act_layer=activation)
    tower.attn_mask = tower.build_causal_mask()  # no weight, so no file brings it
    return tower


def text_weights(tensors: Mapping[str, Any]) -> dict[str, Any]:
    """Those of an OpenCLIP model's ``tensors`` that are its text encoder's, named as there."""
    own = {key.removeprefix("text."): tensor for key, tensor in tensors.items() if not key.startswith("visual.")}
    return {key: tensor for key, tensor in own.items() if key not in ("logit_scale", "logit_bias", "attn_mask")}


def tower_model(name: str, tower: Any) -> ClipModel:
    """The text encoder with OpenCLIP's tokenizer, which encodes no pictures."""
    open_clip = need("open_clip", INSTALL)
    return ClipModel(ClipName(name), tower, open_clip.SimpleTokenizer(context_length=tower.context_length), None)


_SENTENCE = "a block of {} in Minecraft"


_BATCH = 32


def by_meaning(name: str, candidates: Sequence[str]) -> str | None:
    """The candidate nearest to ``name`` in OpenCLIP's text space; None where the extra `neural` or the weights are not
    on this machine: none are fetched for this."""
    if find_spec("open_clip") is None or find_spec("torch") is None:
        return None
    try:
        encoder = _encoder(str(shelf().folder or ""))
    except SceneError:
        return None
    known = _known(encoder, tuple(candidates))
    (wanted,) = _encoded(encoder, [name])
    return candidates[int(np.argmax(known @ wanted))]


@lru_cache(maxsize=1)
def _encoder(folder: str) -> TextEncoder:
    """The encoder of the paper's text space from the shelf at ``folder``, or the hub's cache."""
    return TextEncoder(load_clip(TEXT_SPACE, shelf(folder or None, fetch=False)))


def _known(encoder: TextEncoder, names: tuple[str, ...]) -> npt.NDArray[np.float32]:
    """The embeddings of all blocks' names (N, D), worked out once and kept in the user's cache."""
    told = "\n".join([str(TEXT_SPACE), encoder.fingerprint, *names])
    path = user_folder("CACHE") / f"blocks-{hashlib.sha256(told.encode()).hexdigest()[:16]}.npy"
    kept = _kept(path, len(names))
    if kept is not None:
        return kept
    made = _encoded(encoder, names)
    _keep(path, made)
    return made


def _encoded(encoder: TextEncoder, names: Sequence[str]) -> npt.NDArray[np.float32]:
    """Of length 1 each."""
    rows = []
    for start in range(0, len(names), _BATCH):
        said = [(_SENTENCE.format(name.replace("_", " ")),) for name in names[start : start + _BATCH]]
        rows.append(encoder.encode(said).pooled.float().cpu().numpy())
    matrix: npt.NDArray[np.float32] = np.concatenate(rows, dtype=np.float32)
    matrix /= np.maximum(np.linalg.norm(matrix, axis=1, keepdims=True), 1e-12)
    return matrix


def _kept(path: Path, count: int) -> npt.NDArray[np.float32] | None:
    try:
        found: npt.NDArray[np.float32] = np.load(path, allow_pickle=False)
    except (OSError, ValueError):
        return None
    return found if found.ndim == 2 and len(found) == count else None


def _keep(path: Path, matrix: npt.NDArray[np.float32]) -> None:
    """Written for the next time; where that cannot be, it is worked out again then."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(path) as temporary, temporary.open("wb") as file:
            np.save(file, matrix)
    except (OSError, SceneError):
        return
