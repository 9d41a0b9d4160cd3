"""Embeddings file of a program (Z) from Python: texts, attributes, learned vectors, descriptions and encodings.

``Embeddings`` refers to a file in the format of ``zfile``; its contents are described in docs/embeddings.md.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from scenelang.backends.neural.weights import Models
from scenelang.backends.neural.wording import Wording, prompt_for
from scenelang.console.reports import table
from scenelang.files import beside, zfile
from scenelang.files.zfile import Made
from scenelang.grammar.datum import Handle, Source
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.reader import read
from scenelang.grammar.settings import typed
from scenelang.interpreter.expand.macros import quoted_value
from scenelang.interpreter.inspection.numbering import frame_numbers, instances, number_scene
from scenelang.interpreter.runtime.runtime import ZEntry
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.scene.entity import Entity
from scenelang.learning import stored_words as stored
from scenelang.session.loaded import LoadedScene, literal
from scenelang.session.session import Session, is_scene_file

if TYPE_CHECKING:
    from scenelang.backends.neural.clip import ClipModel
    from scenelang.backends.neural.descriptions import Describe
    from scenelang.backends.neural.inversion import PictureWord
    from scenelang.backends.neural.prompts import Encodings, Granularity, PromptContext
    from scenelang.backends.neural.wording import Wording


EXPORTS = (".npz", ".safetensors", ".json")
MAX_ROWS = 500  # of a table
_PICTURES = (".png", ".jpg", ".jpeg", ".webp")
_NO_PLACE = "expected an embeddings file: --z FILE"
_FINISHED = "set the embeddings of its source program instead"


@dataclass(frozen=True, slots=True, repr=False)
class EmbeddingRow:
    """An embedding of a scene.

    Attributes
    ----------
    handle : str
        Name without angle brackets, such as ``z5``.
    entity : Entity
        First entity that has the embedding.
    shape : (K, width), optional
        Shape of the learned vectors, if any.
    made : Made, optional
        Provenance of the vectors: ``how``, ``source``, ``model``, ``when``.
    """

    handle: str
    entity: Entity
    shape: tuple[int, ...] | None = None
    made: Made | None = None

    @property
    def word(self) -> str:
        """Word of the entity."""
        return self.entity.word

    @property
    def text(self) -> str | None:
        """Text of the embedding."""
        return self.entity.embedding.text

    @property
    def attributes(self) -> Mapping[str, Any]:
        """Attributes of the embedding, as values of the language."""
        return self.entity.embedding.attributes

    @property
    def learned(self) -> str:
        """Description of the learned vectors, such as ``1 x 1024, inversion of photo.png``; empty without any."""
        if self.shape is None:
            return ""
        size = " x ".join(map(str, self.shape))
        return f"{size}, {self.made.how} of {self.made.source}" if self.made is not None else size

    def data(self) -> dict[str, Any]:
        """Return the row as JSON data."""
        from scenelang.interpreter.runtime.show import plain_attributes

        row: dict[str, Any] = {"handle": f"<{self.handle}>", "word": self.word, "text": self.text}
        row["attributes"] = plain_attributes(self.entity)
        return row | ({"vectors": self.learned} if self.learned else {})

    def __repr__(self) -> str:
        text = f": {self.text!r}" if self.text else ""
        return f'<EmbeddingRow <{self.handle}> "{self.word}"{text}>'


@dataclass(frozen=True, slots=True)
class SimilarEmbedding:
    """Search result: the ``cosine`` similarity of the encoded ``prompt`` to the query, and its word and handles."""

    cosine: float
    word: str
    prompt: str
    handles: tuple[str, ...]

    def data(self) -> dict[str, Any]:
        """Return the result as JSON data."""
        handles = [f"<{handle}>" for handle in self.handles]
        return {"cosine": self.cosine, "word": self.word, "prompt": self.prompt, "handles": handles}


@dataclass(frozen=True, slots=True, repr=False)
class SceneWording:
    """Descriptions of a scene's primitives, and the number of ``handles`` that were already described."""

    wording: Wording
    known: int = 0

    @property
    def handles(self) -> frozenset[str]:
        """Handles that have a text."""
        return frozenset(handle for row in self.wording.rows for handle in row.handles)

    @property
    def texts(self) -> frozenset[str]:
        """Distinct texts."""
        return frozenset(row.text for row in self.wording.rows)

    def data(self) -> dict[str, Any]:
        """Return the style and all rows as JSON data; ``plain`` is the prompt for text encoders without embeddings."""
        from scenelang.backends.neural.wording import plain_text

        rows = [
            {
                "word": row.word,
                "text": row.text,
                "template": row.template,
                "plain": plain_text(row.word, row.text),
                "handles": [f"<{handle}>" for handle in row.handles],
            }
            for row in self.wording.rows
        ]
        return {"style": {"handle": f"<{self.wording.style}>", "text": self.wording.style_text}, "rows": rows}

    def __str__(self) -> str:
        return f"{_counted(len(self.texts), 'text')} for {_counted(len(self.handles), 'embedding')}"

    def __repr__(self) -> str:
        return f"<SceneWording: {self}>"


@dataclass(frozen=True, slots=True, init=False, repr=False)
class Embeddings:
    """Embeddings file (Z) of a program. It is read again on each access, since other programs may change it.

    Parameters
    ----------
    path : path, optional
        Path of the file, which may not exist yet; None for a scene without embeddings.

    Examples
    --------
    >>> import tempfile
    >>> z = Embeddings(tempfile.mkdtemp() + "/beach.z.safetensors")
    >>> z.set("<z2>", text="of polished jade", attributes={"color": (0, 0.5, 0.25)})
    >>> z
    <Embeddings beach.z.safetensors: 1 entry, 0 learned vectors>
    >>> z.entries["z2"].text
    'of polished jade'
    """

    path: Path | None

    @typed
    def __init__(self, path: str | Path | None) -> None:
        """Refer to a file, without reading it."""
        object.__setattr__(self, "path", None if path is None else Path(path))

    # --- files -------------------------------------------------------------------------------------------------------

    @staticmethod
    @typed
    def open(path: str | Path) -> Embeddings:
        """Open an existing file; raises SceneError("file") if it is missing, "z-file" if it is malformed."""
        zfile.read_entries(Path(path))
        return Embeddings(path)

    @staticmethod
    @typed
    def beside(program: str | Path) -> Embeddings:
        """Return the file beside a program, which may not exist yet: ``beach.z.safetensors`` for ``beach.scene``.

        Raises
        ------
        SceneError
            If the program cannot be read ("file"), or is a flattened scene without embeddings ("unsupported").
        """
        check_program(program)
        return Embeddings(beside(str(program)))

    @staticmethod
    @typed
    def of(scene: LoadedScene, given: Embeddings | str | Path | None = "auto") -> Embeddings:
        """Return the embeddings of a scene: "auto" selects the file beside its program if any, None disables them."""
        if isinstance(given, Embeddings):
            return given
        if given is None:
            return Embeddings(None)
        if given != "auto":
            return Embeddings(given)
        return Embeddings(None if scene.name.startswith("<") else beside(scene.name))

    @property
    def exists(self) -> bool:
        """Whether the file exists."""
        return self.path is not None and os.path.exists(self.path)

    def place(self) -> Path:
        """Return the path to write to; raises SceneError("file") if there is none."""
        if self.path is None:
            raise SceneError("file", _NO_PLACE)
        return self.path

    # --- contents ----------------------------------------------------------------------------------------------------

    @property
    def entries(self) -> dict[str, ZEntry]:
        """Texts and attributes by handle; raises SceneError for a malformed file."""
        return zfile.read_entries(self.path) if self.path is not None and self.exists else {}

    @property
    def vectors(self) -> dict[str, npt.NDArray[Any]]:
        """Learned vectors (K, width) by handle."""
        return zfile.read_z(self.path)[1] if self.path is not None and self.exists else {}

    @property
    def made(self) -> dict[str, Made]:
        """Provenance of the vectors by handle."""
        return zfile.read_made(self.path) if self.path is not None and self.exists else {}

    @property
    def encodings(self) -> Encodings | None:
        """Result of ``encode``, or None."""
        return stored.read_encodings(self.path) if self.path is not None and self.exists else None

    @property
    def wording(self) -> Wording | None:
        """Result of ``describe``, or None."""
        return stored.read_wording(self.path) if self.path is not None and self.exists else None

    @typed
    def table(self, scene: LoadedScene, limit: int = MAX_ROWS) -> tuple[EmbeddingRow, ...]:
        """Return the embeddings of a scene, each handle once, at most ``limit`` rows.

        Examples
        --------
        >>> import scenelang as sl
        >>> scene = sl.evaluate('(bind "beach" (lambda () (union (call "moai" "weathered"))))')
        >>> Embeddings(None).table(scene)
        (<EmbeddingRow <z1> "beach">, <EmbeddingRow <z2> "moai": 'weathered'>)
        """
        vectors, made = self.vectors, self.made
        rows: dict[str, EmbeddingRow] = {}
        for name, entity in _named(scene):
            if name not in rows:
                shape = vectors[name].shape if name in vectors else None
                rows[name] = EmbeddingRow(name, entity, shape, made.get(name))
            if len(rows) >= limit:
                break
        return tuple(rows.values())

    @typed
    def prompt_context(self, template: str | None = None) -> tuple[PromptContext, Mapping[str, Any]]:
        """Return the texts of the file, for prompts by ``template``, and its learned vectors by handle."""
        from scenelang.backends.neural.prompts import PromptContext
        from scenelang.backends.neural.wording import DEFAULT_TEMPLATE

        if self.path is None or not self.exists:
            return PromptContext(template=template or DEFAULT_TEMPLATE), {}
        entries, vectors = zfile.read_z(self.path)
        wording = self.wording
        texts = {handle: row.text for row in wording.rows for handle in row.handles} if wording is not None else {}
        if wording is not None:
            texts[wording.style] = wording.style_text
        texts |= {handle: entry.text for handle, entry in entries.items() if entry.text}
        stored_rows = wording.rows if wording is not None and template is None else ()
        templates = {handle: row.template for row in stored_rows for handle in row.handles}
        return PromptContext(frozenset(vectors), texts, template or DEFAULT_TEMPLATE, templates), vectors

    # --- changes -----------------------------------------------------------------------------------------------------

    @typed
    def set(
        self,
        handle: str,
        *,
        text: str | None = None,
        attributes: Mapping[str, Any] | None = None,
        vectors: npt.ArrayLike | None = None,
        image: str | Path | None = None,
        start: str | None = None,
        model: str | None = None,
        clear: bool = False,
        models: Models | None = None,
    ) -> PictureWord | None:
        """Set properties of an embedding; omitted ones are unchanged.

        Parameters
        ----------
        handle : str
            Handle, such as ``<z2>``, as printed by ``scene.tree()``.
        text : str, optional
            Description of the entity's appearance.
        attributes : mapping, optional
            Attributes to add, by name: numbers, booleans, strings or sequences of numbers.
        vectors : (K, width) or (width,) array, optional
            Learned vectors, one per token.
        image : path, optional
            Image from which to learn a pseudo-word in OpenCLIP's token space.
        start : str, optional
            Word that initializes the pseudo-word; default "object".
        model : str, optional
            OpenCLIP model for ``image``: architecture/weights, or a folder.
        clear : bool
            First remove all existing properties of the handle.
        models : Models, optional
            Location of the weights, and compute device.

        Returns
        -------
        PictureWord or None
            For ``image``: the cosine similarity of prompt and image after (``cosine``) and ``before`` learning.

        Raises
        ------
        SceneError
            If nothing is set, the handle is invalid, an attribute cannot be stored, or a file cannot be read.
        """
        name = handle_name(handle)
        path = self.place()
        if text is None and not attributes and not clear and image is None and vectors is None:
            raise SceneError("value", "nothing to set", "give a text, attributes, vectors or an image")
        array = _given_vectors(vectors)
        values = {key: _attribute_value(value) for key, value in (attributes or {}).items()}
        model_name, word = (
            _picture_word(Path(image), start, model, models or Models()) if image is not None else ("", None)
        )
        zfile.set_entry(path, name, text, values, clear)
        if array is not None:
            zfile.write_vectors(path, {name: array}, {name: Made("array", "Python", "", _now())})
        if word is not None and image is not None:
            zfile.write_vectors(
                path, {name: word.vectors}, {name: Made("picture", Path(image).name, model_name, _now())}
            )
        return word

    @typed
    def remove(self, handle: str) -> None:
        """Remove text, attributes and vectors of a handle; raises SceneError if it has no entry."""
        name = handle_name(handle)
        if self.path is None or name not in self.entries:
            raise SceneError("value", f"nothing to remove: <{name}> has no entry")
        zfile.set_entry(self.path, name, None, {}, clear=True)

    @typed
    def swap(self, one: str, other: str) -> None:
        """Swap the entries of two handles; encodings of the old prompts are removed.

        Raises
        ------
        SceneError
            If the file does not exist, or has no entry of either handle.
        """
        first, second = handle_name(one), handle_name(other)
        if self.path is None or not self.exists:
            raise SceneError(
                "file",
                "nothing to swap: the embeddings file does not exist",
                hint="create it with `embeddings FILE set`",
            )
        if not zfile.swap_handles(self.path, first, second):
            raise SceneError("value", f"nothing to swap: neither <{first}> nor <{second}> has an entry")

    # --- descriptions ------------------------------------------------------------------------------------------------

    @typed
    def words_of(
        self,
        scene: LoadedScene,
        *,
        template: str | None = None,
        describe: Describe | None = None,
        force: bool = False,
        limit: int | None = None,
    ) -> SceneWording:
        """Describe every primitive of a scene in words, reusing stored descriptions; nothing is written.

        Parameters
        ----------
        scene : LoadedScene
            Scene whose colors, materials, proportions and other attributes are described.
        template : str, optional
            Prompt template of a primitive, with ``{embedding}``, ``{word}`` and ``{style}``.
        describe : callable, optional
            Function that maps a sequence of questions to texts, such as a language model; default: a fixed table.
        force : bool
            Ignore stored descriptions.
        limit : int, optional
            Maximum number of primitives; default 1,000,000.

        Examples
        --------
        >>> import scenelang as sl
        >>> scene = sl.evaluate('(bind "pawn" (lambda () (union (call "cone" :color [.9 .9 .9]))))')
        >>> Embeddings(None).words_of(scene)
        <SceneWording: 1 text for 1 embedding>
        """
        from scenelang.backends.neural.wording import DEFAULT_LIMIT, DEFAULT_TEMPLATE, check_template, merge, wording_of

        check_template(DEFAULT_TEMPLATE if template is None else template)
        if describe is not None and not force:
            self.check_undescribed()
        old = None if force else self.wording
        new = wording_of(
            scene.graph, DEFAULT_TEMPLATE if template is None else template, describe, limit or DEFAULT_LIMIT
        )
        return SceneWording(new) if old is None else SceneWording(*merge(old, new))

    @typed
    def describe(
        self,
        scene: LoadedScene,
        *,
        template: str | None = None,
        describe: Describe | None = None,
        force: bool = False,
        limit: int | None = None,
    ) -> SceneWording:
        """Describe every primitive as ``words_of`` does, and store the descriptions for neural backends."""
        path = self.place()
        descriptions = self.words_of(scene, template=template, describe=describe, force=force, limit=limit)
        stored.write_wording(path, descriptions.wording)
        return descriptions

    def check_undescribed(self) -> None:
        """Raise SceneError("value") if descriptions are already stored, before a language model is queried."""
        if self.wording is not None:
            raise SceneError("value", "the scene is already described", "use --force to overwrite the descriptions")

    # --- encodings ---------------------------------------------------------------------------------------------------

    @typed
    def encode(
        self,
        scene: LoadedScene,
        *,
        model: str | None = None,
        template: str | None = None,
        granularity: Granularity | None = None,
        models: Models | None = None,
    ) -> Encodings:
        """Encode the prompt of every primitive with OpenCLIP's text encoder, and store the vectors.

        Parameters
        ----------
        scene : LoadedScene
            Scene to encode; texts and vectors in the embeddings file take precedence.
        model : str, optional
            OpenCLIP model: architecture/weights, or a folder; default: the paper's ViT-H-14.
        template : str, optional
            Prompt template, with ``{embedding}``, ``{word}`` and ``{style}``.
        granularity : Granularity, optional
            Grouping of entities to instances; default: every primitive is an instance.
        models : Models, optional
            Location of the weights, and compute device.

        Returns
        -------
        Encodings
            Unit vectors ``matrix`` (K, D), ``rows`` and ``model``.

        Raises
        ------
        SceneError
            If the embeddings file is missing, the scene is empty, or the weights are unavailable.

        Examples
        --------
        >>> Embeddings.beside("beach.scene").encode(scene, models=Models("weights")).matrix.shape  # doctest: +SKIP
        (3, 1024)
        """
        from scenelang.backends.neural.clip import TextEncoder
        from scenelang.backends.neural.prompts import Granularity, encode_conditions, leaves_of, merge_conditions

        path = self.place()
        context, vectors = self.prompt_context(template)
        frames = leaves_of(scene.graph, granularity or Granularity(), context)
        conditions = merge_conditions(leaf.condition for leaves in frames for leaf in leaves)
        chosen = models or Models()
        loaded = _clip(model, chosen)
        encodings = encode_conditions(
            conditions, TextEncoder(loaded), tensors_of(vectors, chosen.resolve_device()), str(loaded.name)
        )
        stored.write_encodings(path, encodings)
        return encodings

    @typed
    def similar(
        self, query: str | Path, number: int = 10, *, models: Models | None = None
    ) -> tuple[SimilarEmbedding, ...]:
        """Find the encoded prompts most similar to a handle ``<z2>``, a text or an image file, best first.

        Raises
        ------
        SceneError
            If the scene has not been encoded, or the handle is not part of it.
        """
        encodings = self.encodings
        if encodings is None:
            hint = "scenelang embeddings FILE encode"
            raise SceneError("value", "the scene has not been encoded", hint=hint)
        query_vector, own_row = _query_vector(str(query), encodings, models or Models())
        best = [(i, cosine) for i, cosine in encodings.nearest(query_vector) if i != own_row][:number]
        rows = ((cosine, encodings.rows[i]) for i, cosine in best)
        return tuple(SimilarEmbedding(cosine, row.word, row.prompt, row.handles) for cosine, row in rows)

    @typed
    def export(self, output: str | Path) -> Path:
        """Export the learned vectors and the encodings as .npz, .safetensors or .json.

        Returns the path. ``encodings`` is the matrix (K, D), ``rows`` the row index of each handle.

        Raises
        ------
        SceneError
            If the file extension is not supported, or there are no vectors.
        """
        from scenelang.backends.files import atomic_write

        target = Path(output)
        check_export(target)
        if self.path is None or not self.exists:
            raise SceneError("file", "nothing to export: the embeddings file does not exist")
        arrays, encodings = dict(self.vectors), self.encodings
        rows: dict[str, int] = {}
        if encodings is not None:
            arrays["encodings"] = encodings.matrix
            rows = {handle: i for i, row in enumerate(encodings.rows) for handle in row.handles}
        if not arrays:
            raise SceneError("value", "nothing to export: no vectors", hint="scenelang embeddings FILE encode")
        with atomic_write(target) as temporary:
            _write_arrays(temporary, target.suffix.lower(), arrays, rows)
        return target

    def __repr__(self) -> str:
        if self.path is None or not self.exists:
            return f"<Embeddings {self.path.name if self.path else ''}: no file>".replace(" :", ":")
        entries, vectors = len(self.entries), len(self.vectors)
        counts = f"{entries:,} {'entry' if entries == 1 else 'entries'}"
        return f"<Embeddings {self.path.name}: {counts}, {_counted(vectors, 'learned vector')}>"


# --- helpers ---------------------------------------------------------------------------------------------------------


def check_program(program: str | Path, hint: str = _FINISHED) -> None:
    """Raise SceneError if a program cannot be read, or is a flattened scene, which has no embeddings."""
    if is_scene_file(Session().source(str(program))):
        raise SceneError("unsupported", f"{program} is a flattened scene and cannot have embeddings", hint)


def check_export(output: Path) -> None:
    """Raise SceneError("backend") if vectors cannot be written to a file of this type."""
    if output.suffix.lower() not in EXPORTS:
        raise SceneError("backend", f"cannot write vectors to `{output.name}`", f"use {' '.join(EXPORTS)}")


def handle_name(text: str) -> str:
    """Return the name of a handle, written with or without angle brackets.

    Raises
    ------
    SceneError
        If the text is not a handle.

    Examples
    --------
    >>> handle_name("<z5>"), handle_name("young")
    ('z5', 'young')
    """
    inner = text if text.startswith("<") else f"<{text}>"
    forms = read(Source("<handle>", inner)).forms
    value = getattr(forms[0], "value", None) if len(forms) == 1 else None
    if type(value) is Handle:
        return str(value)
    raise SceneError("value", f"invalid handle `{text}`", "write a handle as '<z5>', quoted for the shell")


def attribute_of(text: str) -> Any:
    """Parse an attribute value, a literal of the language in which arrays may contain commas, as in `[1,0,0]`; a bare
    word is a string."""
    written = text.replace(",", " ") if text.strip().startswith("[") else text
    result = read(Source("<attribute>", written))
    if len(result.forms) != 1 or result.diagnostics:
        return text
    value = quoted_value(result.forms[0])
    return text if type(value).__name__ == "Symbol" else value


def tensors_of(vectors: Mapping[str, Any], device: str) -> dict[str, Any]:
    """Convert arrays to float32 tensors on a device."""
    import torch

    return {handle: torch.from_numpy(vector).float().to(device) for handle, vector in vectors.items()}


def _attribute_value(value: Any) -> Any:
    """Convert a plain Python value to a value of the language; values of the language are returned unchanged."""
    if isinstance(value, np.generic | np.ndarray) or type(value) in (list, tuple):
        return quoted_value(read(Source("<attribute>", literal(value))).forms[0])
    return value


def _given_vectors(vectors: npt.ArrayLike | None) -> npt.NDArray[np.float32] | None:
    """Return vectors as a float32 array (K, width), None for none; raises SceneError."""
    if vectors is None:
        return None
    array = np.atleast_2d(np.ascontiguousarray(vectors, np.float32))
    if array.ndim != 2 or not array.size or not np.isfinite(array).all():
        raise SceneError("value", f"expected finite vectors of shape (K, width), got {np.shape(vectors)}")
    return array


def _named(scene: LoadedScene) -> Iterator[tuple[str, Entity]]:
    """Yield all instances in depth-first order with their handles' names."""
    graph = scene.graph
    numbers = frame_numbers(graph) if graph.animated else {}
    numbering = number_scene(graph)
    rank = 0
    for root in graph.frames:
        for path, entity in instances(root):
            name = entity.embedding.handle
            if name is None:
                rank += 1
                name = f"z{numbers[path] if graph.animated else numbering.number(rank)}"
            yield name, entity


def _picture_word(image: Path, start: str | None, model: str | None, models: Models) -> tuple[str, PictureWord]:
    """Return the name of the model, and the pseudo-word learned from an image."""
    from scenelang.backends.pictures.film import open_image

    picture = open_image(image)
    loaded = _clip(model, models)  # fails with an install hint if a package is missing
    from scenelang.backends.neural.inversion import INITIAL_WORD, learn_picture_word

    return str(loaded.name), learn_picture_word(loaded, picture, start or INITIAL_WORD)


def _clip(model: str | None, models: Models) -> ClipModel:
    """Load the OpenCLIP model that embeddings are learned with."""
    from scenelang.backends.neural.clip import EMBEDDING_MODEL, ClipName, load_clip

    name = ClipName.parse(model) if model else EMBEDDING_MODEL
    return load_clip(name, models.hub(), models.resolve_device())


def _query_vector(query: str, encodings: Encodings, models: Models) -> tuple[Any, int | None]:
    """Return the embedding of the query, and its row index if the query is a handle."""
    if query.startswith("<") and query.endswith(">"):
        row = encodings.row_of(query[1:-1])
        if row is None:
            raise SceneError("value", f"{query} has not been encoded")
        return encodings.matrix[row], row
    from scenelang.backends.neural.clip import TextEncoder, encode_images
    from scenelang.backends.pictures.film import open_image

    model = _clip(encodings.model, models)
    if Path(query).suffix.lower() in _PICTURES:
        return encode_images(model, [open_image(query)])[0].float().cpu().numpy(), None
    return TextEncoder(model).encode([(query,)]).pooled[0].float().cpu().numpy(), None


def _write_arrays(path: Path, ending: str, arrays: dict[str, Any], rows: dict[str, int]) -> None:
    """Write the arrays by handle, and the row index in ``encodings`` of each handle."""
    if ending == ".npz":
        with path.open("wb") as file:
            np.savez(file, **arrays, rows=np.array(json.dumps(rows)))
    elif ending == ".safetensors":
        from safetensors.numpy import save

        path.write_bytes(save(arrays, metadata={"rows": json.dumps(rows)}))
    else:
        listed = {name: array.tolist() for name, array in arrays.items()}
        path.write_text(json.dumps({"vectors": listed, "rows": rows}), "utf-8")


def _counted(number: int, what: str) -> str:
    """Return a number with its noun."""
    return f"{number:,} {what}{'' if number == 1 else 's'}"


def _now() -> str:
    """Return the current time in UTC, as provenance stores it."""
    return datetime.now(UTC).isoformat(timespec="seconds")


# --- tables ----------------------------------------------------------------------------------------------------------


_MAX_LISTED_HANDLES = 3  # handles listed per row


def rows_table(rows: Sequence[EmbeddingRow]) -> str:
    """Format the rows of ``Embeddings.table``, without the column of learned vectors if it is empty."""
    shown = 5 if any(row.learned for row in rows) else 4
    cells = [("handle", "word", "text", "attributes", "learned vectors"), *map(_row_cells, rows)]
    text = table([row[:shown] for row in cells], (False,) * shown)
    return f"{text}\n... only the first {MAX_ROWS} are shown" if len(rows) == MAX_ROWS else text


def _row_cells(row: EmbeddingRow) -> tuple[str, ...]:
    """Return the cells of a row of the table."""
    attributes = " ".join(f":{key} {show(value, 40)}" for key, value in row.attributes.items())
    return f"<{row.handle}>", row.word, row.text or "", attributes, row.learned


def similar_table(results: Sequence[SimilarEmbedding]) -> str:
    """Format the results of ``Embeddings.similar``."""
    cells = [(f"{row.cosine:.3f}", _some(row.handles, "({:,})"), row.prompt) for row in results]
    return table([("cosine", "handles", "prompt"), *cells], (True, False, False))


def wording_table(wording: Wording) -> str:
    """Format the descriptions of a scene."""
    titles = ("handle", "word", "text", "template")
    rows = [
        (_some(row.handles, "{:,} in all"), row.word, row.text, prompt_for(row.template, row.handles[0]))
        for row in wording.rows[:MAX_ROWS]
    ]
    rest = [f"... only the first {MAX_ROWS} rows are shown"] if len(wording.rows) > MAX_ROWS else []
    head = f"the style is <{wording.style}>, {wording.style_text}"
    return "\n".join([head, "", table([titles, *rows], (False,) * 4), *rest])


def _some(handles: tuple[str, ...], rest: str) -> str:
    """List the first handles; ``rest`` is the format of the total number."""
    shown = " ".join(f"<{handle}>" for handle in handles[:_MAX_LISTED_HANDLES])
    return shown if len(handles) <= _MAX_LISTED_HANDLES else f"{shown} ... {rest.format(len(handles))}"
