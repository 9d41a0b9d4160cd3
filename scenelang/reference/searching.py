"""Search of the language by meaning: forms, functions, primitives, attributes, relations, diagnostics and examples.

Documents are the records of the reference and the comments of example programs, ranked by BM25 (Robertson and Zaragoza,
2009) over stemmed words; a few synonyms lead from the words of other languages and programs to ours.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from scenelang.backends.files import read_regular
from scenelang.grammar.diagnostics import CODES, SceneError
from scenelang.interpreter.scene import primitives
from scenelang.interpreter.scene.declarations import RELATIONS
from scenelang.reference.primer import attribute_doc, attribute_names, attributes_of, stated_task
from scenelang.stdlib.reference import COMBINATORS, LibraryPart, parts, records

MAX_QUERY = 500  # characters
_K1, _B = 1.2, 0.75  # saturation of frequencies and weight of lengths in BM25, at their usual values
_NAME_WEIGHT = 4  # occurrences that a word of a name counts as
_MAX_EXAMPLE_SIZE = 100_000  # bytes
_MIN_STEM_LENGTH = 3  # letters
_SCENES = frozenset(
    {"forms", "paper", "poses", "combinators", "entities", "solids", "profiles", "paths", "random", "colors", "parts"}
)
_EXACT_SCORE = 100.0  # above that of any text: a query that is a name finds it first
_SYNONYM_WEIGHT, _PHRASE_WEIGHT = 0.7, 2.0
_GENERAL_WEIGHT = 0.5  # of general functions, which work as in other languages, and of diagnostics
_PACKAGE = Path(__file__).parents[1]
_INSTALLED, _CHECKOUT = _PACKAGE / "examples", _PACKAGE.parent / "examples"
_EXAMPLES = _INSTALLED if _INSTALLED.is_dir() else _CHECKOUT
_WORD = re.compile(r"[a-z]+|\d+")
_ENDINGS = ("ations", "ation", "ings", "ing", "ies", "ied", "ers", "er", "ed", "es", "s", "e", "y")
_STOP = frozenset(
    re.findall(
        r"\S+",
        "a an and are as at be by can do for from have how i in into is it its make made my of on or part scene that "
        "the their this thing to want what which with",
    )
)
# Words of other tools and languages, and of tasks, with the names that they mean here. Search, help and the reference
# read them. From the documentation of OpenSCAD, CadQuery, build123d, Blender, trimesh, three.js, numpy, Scheme, Python.
_SYNONYMS = {
    # copies and arrangements
    "duplicate": "copy repeat", "clone": "copy repeat", "repeat": "copy loop", "copies": "ring row grid union-loop",
    "copy": "ring row grid", "circle": "ring around", "radial": "ring", "circular": "ring", "polar": "ring",
    "around": "ring", "array": "ring row grid along array", "pattern": "ring row grid", "linear": "row",
    "instance": "call union along scatter", "distribute": "row scatter scatter-on", "clones": "union-loop grid",
    "pile": "stack", "tower": "stack", "snap": "align attach on-top-of", "flip": "mirror reflect",
    "reflect": "mirror", "mirrored": "mirror symmetric", "symmetry": "mirror symmetric",
    # solids
    "subtract": "difference cut", "carve": "difference cut", "hole": "difference subtract", "cut": "difference",
    "cutout": "difference", "boolean": "difference intersection solid-union", "fuse": "solid-union",
    "weld": "solid-union", "merge": "union", "combine": "union", "group": "union", "collection": "union",
    "bevel": "rounded", "fillet": "rounded", "chamfer": "rounded", "hollow": "shell difference", "thicken": "shell",
    "inset": "offset-profile", "grow": "offset-solid", "slice": "cut-plane split profile-section",
    "linear-extrude": "extrude", "pad": "extrude", "revolve": "lathe", "revolution": "lathe", "screw": "helix sweep",
    "thread": "helix sweep", "spiral": "helix", "spring": "helix sweep", "tube": "sweep", "pipe": "sweep",
    "letters": "text", "font": "text", "terrain": "heightfield", "landscape": "heightfield noise", "convex": "hull",
    "svg": "svg-path", "vertices": "mesh", "faces": "mesh",
    # poses
    "move": "translate", "shift": "translate", "position": "translate", "offset": "translate offset-profile",
    "spin": "rotate", "turn": "rotate", "orient": "look-at rotate", "aim": "look-at", "lookat": "look-at",
    "resize": "scale", "pivot": "rotate scale pose", "place": "transform translate", "parent": "transform union",
    "multmatrix": "transform @", "matmul": "@", "compose": "@", "tween": "lerp smoothstep",
    "boundingbox": "compute-shape-min compute-shape-max", "bounds": "compute-shape-min compute-shape-max",
    "bbox": "compute-shape-min compute-shape-max", "dimensions": "compute-shape-sizes",
    # looks
    "material": "roughness metallic", "shiny": "metallic roughness", "metal": "metallic roughness",
    "glass": "opacity ior", "transparent": "opacity", "transparency": "opacity", "alpha": "opacity",
    "glow": "emission", "light": "emission", "lights": "emission", "lamp": "emission", "colour": "color",
    "hex": "color", "paint": "color", "texture": "color noise", "uneven": "noise", "perlin": "noise fbm",
    # primitives
    "ball": "sphere", "box": "cube", "block": "cube set-cuboid", "cuboid": "cube", "pyramid": "cone",
    "donut": "torus", "pill": "capsule", "plane": "cube", "minecraft": "block", "obj": "mesh", "gltf": "mesh",
    "glb": "mesh", "model": "mesh", "asset": "mesh",
    # films
    "animation": "frames", "animate": "frames", "video": "frames", "motion": "frames", "keyframe": "frames lerp",
    "keyframes": "frames lerp", "timeline": "frames",
    # language
    "variable": "define let", "function": "lambda define", "def": "define", "module": "define import",
    "iterate": "for", "loop": "for union-loop do while", "foreach": "for for-each", "comprehension": "for/list",
    "slider": "param", "customizer": "param", "adjustable": "param", "else": "if cond", "elif": "cond",
    "switch": "case cond", "match": "case cond", "try": "guard", "catch": "guard", "except": "guard",
    "throw": "raise error", "return": "let/ec", "break": "let/ec", "null": "none null?", "nil": "none null?",
    "dict": "table", "dictionary": "table", "hash": "table", "object": "table define-record", "struct": "define-record",
    "class": "define-record", "len": "length", "size": "length", "nth": "ref list-ref",
    "concat": "append string-append", "concatenation": "append string-append",
    "join": "string-join append", "substr": "substring",
    "uppercase": "string-upcase", "lowercase": "string-downcase", "interpolate": "format lerp interp",
    "debug": "print", "echo": "print", "log": "print", "seed": "random set-seed! random-stream",
    "gaussian": "normal", "rand": "random uniform", "modulo": "%", "power": "expt", "pow": "expt", "ln": "log",
    "atan2": "atan", "degree": "deg to-degrees", "degrees": "deg to-degrees",
    "radians": "to-degrees deg", "angle": "deg rotate", "mix": "lerp", "clip": "clamp",
    "magnitude": "norm", "unit": "normalize",
    # relations and errors
    "touch": "touching", "stands": "on supported", "stand": "on supported", "rest": "on supported",
    "resting": "on supported", "floating": "supported on", "collide": "clear-of", "collision": "clear-of",
    "overlap": "clear-of", "gap": "distance", "apart": "distance clear-of", "undefined": "unbound",
    "defined": "unbound",
}  # fmt: skip

_AROUND = re.compile(r"\b(?:in|into|around|on) an? (?:circle|ring)\b")  # a place, not the profile


@dataclass(frozen=True, slots=True)
class SearchResult:
    """A name or example that was found.

    Attributes
    ----------
    kind
        "form", "function", "combinator", "constant", "type", "part", "primitive", "attribute", "relation", "diagnostic"
        or "example".
    name, usage, doc
        As in the reference; the usage of an example is its file.
    example
        An expression that uses it, or "".
    score
        The BM25 score, comparable within one search.
    """

    kind: str
    name: str
    usage: str
    doc: str
    example: str
    score: float

    def data(self) -> dict[str, Any]:
        """Return the result as JSON data."""
        data: dict[str, Any] = {"kind": self.kind, "name": self.name, "usage": self.usage, "doc": self.doc}
        return data | ({"example": self.example} if self.example else {}) | {"score": round(self.score, 3)}

    def text(self) -> str:
        """Return the result as lines."""
        example = f"\n    for example {self.example}" if self.example else ""
        return f"{self.kind}  {self.usage}\n    {self.doc}{example}"


def search(query: str, limit: int = 8) -> list[SearchResult]:
    """Return the names and examples whose documentation fits a query best, at most ``limit``.

    Raises SceneError("value") for a query of more than 500 characters.

    Examples
    --------
    >>> [result.name for result in search("repeat along a curve", 1)]
    ['along']
    """
    if len(query) > MAX_QUERY:
        raise SceneError("value", f"a query has at most {MAX_QUERY} characters, got {len(query):,}")
    index = _index()
    scores: dict[int, float] = {}
    for term, weight in _query_terms(query).items():
        for number, part in index.postings.get(term, ()):
            scores[number] = scores.get(number, 0.0) + weight * part
    exact = query.strip().strip('"`:').lower()
    for number, document in enumerate(index.documents):
        if document.kind != "example" and document.name.lower().lstrip(":") == exact:
            scores[number] = scores.get(number, 0.0) + _EXACT_SCORE
    best = sorted(scores, key=lambda number: (-scores[number], number))[:limit]
    return [_scored(index.documents[number], scores[number]) for number in best]


def fitting_parts(text: str, limit: int = 8) -> list[LibraryPart]:
    """Return the parts that a text is about, at most ``limit``: by their words, other words for them, or their places.

    Parts whose own word the text has come first, in its order. Whole words are compared, in both numbers, since a stem
    takes "mirrored" for a mirror and "bowling" for a bowl.

    Examples
    --------
    >>> [part.word for part in fitting_parts("two chairs at a table")]
    ['chair', 'table']
    """
    lower = text.lower()
    named = {part.word: _place(lower, (part.word,)) for part in parts()}
    meant = {part.word: _place(lower, part.others) for part in parts()}
    fitting = [part for part in parts() if named[part.word] >= 0 or meant[part.word] >= 0]
    fitting.sort(key=lambda part: (named[part.word] < 0, named[part.word], meant[part.word]))
    return fitting[:limit]


def is_like(word: str, other: str) -> bool:
    """Return whether two words have one stem: "pipes" and "pipe"."""
    return _stem(word) == _stem(other)


def other_words() -> Mapping[str, tuple[str, ...]]:
    """Return the words of other tools, each with the names that it means here."""
    return {word: tuple(meant.split()) for word, meant in _SYNONYMS.items()}


def synonyms_of(names: Sequence[str]) -> tuple[str, ...]:
    """Return the words that lead a search to some names.

    >>> synonyms_of(["helix"])
    ('screw', 'thread', 'spiral', 'spring')
    """
    return tuple(word for word, meant in _SYNONYMS.items() if set(names) & set(meant.split()))


def _place(text: str, names: Sequence[str]) -> int:
    """Return where a text has one of some nouns first, in either number; -1 if it has none."""
    alternatives = "|".join(re.escape(name).replace(r"\ ", r"[ -]") for name in names)
    match = re.search(rf"\b(?:{alternatives})(?:e?s)?\b", text)
    return match.start() if match else -1


def _scored(result: SearchResult, score: float) -> SearchResult:
    """Return a document with its score."""
    return SearchResult(result.kind, result.name, result.usage, result.doc, result.example, score)


def _query_terms(query: str) -> dict[str, float]:
    """Return the stems of a query and their weights; those of synonyms count less."""
    query, count = _AROUND.subn("", query.lower())
    weights: dict[str, float] = {}
    for word in _words(query):
        for other in _SYNONYMS.get(word, _SYNONYMS.get(word.removesuffix("s"), "")).split():
            weights.update((_stem(part), _SYNONYM_WEIGHT) for part in _words(other))
    weights |= dict.fromkeys(map(_stem, _words(query)), 1.0)
    return weights | ({_stem("ring"): _PHRASE_WEIGHT} if count else {})


def _words(text: str) -> list[str]:
    """Return the lower-case words of a text without stop words."""
    return [word for word in _WORD.findall(text.lower()) if word not in _STOP]


@cache
def _stem(word: str) -> str:
    """Return a word without its ending, so that "rotated", "rotation" and "rotates" are the same."""
    for ending in _ENDINGS:
        if word.endswith(ending) and len(word) - len(ending) >= _MIN_STEM_LENGTH:
            return word.removesuffix(ending)
    return word


# --- index -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class _Index:
    """Documents, and for each stem the documents that contain it with their scores."""

    documents: tuple[SearchResult, ...]
    postings: dict[str, list[tuple[int, float]]]


@cache
def _index() -> _Index:
    """Index all documents, with the score of each term precomputed.

    BM25 (Robertson and Zaragoza, "The Probabilistic Relevance Framework", 2009): three hundred short documents need no
    index on disk and no model.
    """
    weighted = list(_documents())
    documents = tuple(document for document, _ in weighted)
    counts = [_counts(document) for document in documents]
    lengths = [sum(count.values()) for count in counts]
    mean = sum(lengths) / len(lengths)
    having = Counter(term for count in counts for term in count)
    postings: dict[str, list[tuple[int, float]]] = {}
    for number, count in enumerate(counts):
        norm = _K1 * (1.0 - _B + _B * lengths[number] / mean)
        for term, frequency in count.items():
            idf = math.log(1.0 + (len(documents) - having[term] + 0.5) / (having[term] + 0.5))
            postings.setdefault(term, []).append(
                (number, weighted[number][1] * idf * frequency * (_K1 + 1.0) / (frequency + norm))
            )
    return _Index(documents, postings)


def _counts(document: SearchResult) -> Counter[str]:
    """Return the number of occurrences of each stem in a document."""
    stems = [_stem(word) for word in _words(f"{document.usage} {document.doc} {document.kind}")]
    return Counter(stems) + Counter({_stem(word): _NAME_WEIGHT for word in _words(document.name)})


def _documents() -> Iterator[tuple[SearchResult, float]]:
    """Yield all documents and their weights."""
    for record in records():
        kind = "combinator" if record.topic == COMBINATORS.partition(".")[0] else record.kind.value
        example = record.examples[0] if record.examples else None
        shown = f"{example.expression} gives {example.value}" if example else record.picture or ""
        module = f' Requires (import "{record.module}").' if record.module else ""
        weight = 1.0 if record.topic in _SCENES else _GENERAL_WEIGHT
        yield SearchResult(kind, record.name, record.signature, record.doc + module, _short(shown), 0.0), weight
    for word, doc in primitives.docs_of_words().items():
        attributes = " ".join(f":{name}" for name in attributes_of(word)[:12])
        yield SearchResult("primitive", word, f'(call "{word}" {attributes})', doc, "", 0.0), 1.0
    for name in attribute_names():
        yield SearchResult("attribute", f":{name}", f":{name}", attribute_doc(None, name) or "", "", 0.0), 1.0
    for relation in RELATIONS.values():
        yield SearchResult("relation", relation.name, relation.usage, relation.doc, relation.example, 0.0), 1.0
    for name, code in CODES.items():
        yield SearchResult("diagnostic", name, code.code, code.why, "", 0.0), _GENERAL_WEIGHT
    yield from _examples()


_FOLDER_WEIGHT = 0.1  # an example of `making` has the name of its object, as a part of the library, which comes first


def _examples() -> Iterator[tuple[SearchResult, float]]:
    """Yield the example programs, by the comment at their head and the words that they bind."""
    for name, path in _example_files().items():
        try:
            text = read_regular(path, _MAX_EXAMPLE_SIZE).decode("utf-8", "replace")
        except OSError:
            continue
        words = " ".join(dict.fromkeys(re.findall(r'\(bind "([^"]+)"', text)))
        doc = f"{stated_task(text) or ''} ({words})"
        yield (
            SearchResult("example", path.stem, f"examples/{name}.scene", doc, "", 0.0),
            _FOLDER_WEIGHT if "/" in name else 1.0,
        )


def example_text(name: str) -> str | None:
    """Return the text of an example program that ``search`` finds, None for an unknown name."""
    path = _example_files().get(name)
    return None if path is None else read_regular(path, _MAX_EXAMPLE_SIZE).decode("utf-8", "replace")


def example_names() -> list[str]:
    """Return the names of the example programs, with their folders: ``mug``, ``making/gear-pair``."""
    return sorted(_example_files())


def _example_files() -> dict[str, Path]:
    """Return the files of the example programs by name."""
    return {path.relative_to(_EXAMPLES).with_suffix("").as_posix(): path for path in _EXAMPLES.rglob("*.scene")}


def _short(text: str) -> str:
    """Return a text on one line of at most 200 characters."""
    line = " ".join(text.split())
    return line if len(line) <= 200 else line[:197] + "..."
