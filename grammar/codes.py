"""The table of diagnostic codes. Programs test errors by name (``(error-is? e "index")``), people quote the code."""

from __future__ import annotations

from typing import NamedTuple


class Code(NamedTuple):
    """``code`` is stable for ever; ``why`` says what went wrong and how to mend it."""

    code: str
    why: str


CODES: dict[str, Code] = {
    # E1xx: reading
    "unclosed": Code("E101", "A parenthesis, bracket, string or comment was opened and never closed."),
    "extra-close": Code("E102", "A closing parenthesis or bracket has no opener, or closes one of the other kind."),
    "bad-atom": Code("E103", "Something begins like a number, keyword, handle or `#` literal and is none."),
    "bad-string": Code("E104", "A string holds an escape that does not exist."),
    "bad-dot": Code("E105", "A dot stands where no pair can be: write `(a . b)`."),
    "nesting": Code("E106", "Parentheses are nested deeper than the reader allows."),
    "encoding": Code("E107", "The file is not UTF-8 text."),
    # E2xx: forms
    "syntax": Code("E201", "A form does not have the shape that its head asks for."),
    "lambda-list": Code("E202", "A list of parameters is malformed."),
    "misplaced": Code(
        "E203", "A form stands where it may not: `scene` inside a body, `else` outside `cond`, and so on."
    ),
    "reserved": Code("E204", "The name is reserved and cannot be bound."),
    "duplicate": Code("E205", "The same name is bound twice in one place."),
    "absent": Code("E206", "A Scheme feature that this language leaves out on purpose."),
    "macro": Code("E207", "A macro is malformed, or no rule of it matches its use."),
    "expansion": Code("E208", "Expanding a macro failed or did not end."),
    "bracket": Code("E209", "Square brackets are array literals; here the language wants parentheses."),
    "strict": Code("E210", "The program is outside the paper's grammar, which `--strict` asks for."),
    "empty-application": Code("E211", "`()` cannot be evaluated; the empty list is `'()` or `(list)`."),
    # E3xx: names
    "unbound": Code("E301", "The name has no definition."),
    "undefined-yet": Code("E302", "The name is read before its definition has run."),
    "type-name": Code("E303", "The annotation names no type."),
    "no-root": Code("E304", "The program binds no word that could be the root of a scene."),
    "param": Code("E305", "A `--define` or `:min`/`:max` does not fit the program's `param`."),
    # E4xx: running
    "type": Code("E401", "A value has another type than the operation needs."),
    "arity": Code("E402", "A function was called with too few or too many arguments."),
    "not-a-procedure": Code("E403", "Something that is no function stands at the head of a call."),
    "keyword": Code("E404", "A keyword argument is missing, unknown or repeated."),
    "index": Code("E405", "An index is outside the sequence."),
    "key": Code("E406", "A table, record or embedding does not hold the key."),
    "zero-division": Code("E407", "A division by zero."),
    "domain": Code("E408", "A number is outside the domain of the function, or the result is too large for a float."),
    "value": Code("E409", "A value has the right type but cannot be used here."),
    "immutable": Code("E410", "An immutable value cannot be changed; make a mutable twin of it."),
    "changed": Code("E411", "A table or set was changed while it was being iterated."),
    "pattern": Code("E412", "A sequence does not have the length that the pattern takes apart."),
    "assert": Code("E413", "An assertion does not hold."),
    "user": Code("E414", "The program raised an error itself."),
    "escape": Code("E415", "An escape procedure was called after its `let/ec` had ended."),
    "format": Code("E416", "A format string is malformed."),
    # E5xx: limits
    "steps": Code("E501", "The program ran more steps than allowed (--max-steps)."),
    "depth": Code("E502", "Calls were nested deeper than allowed (--max-depth)."),
    "entities": Code("E503", "The scene has more distinct entities than allowed (--max-entities)."),
    "primitives": Code("E504", "The scene expands to more primitives than allowed (--max-primitives)."),
    "size": Code("E505", "A list or string grew larger than allowed (--max-size), or an integer past 4,000 digits."),
    "memory": Code("E506", "The program used more memory than allowed (--max-memory)."),
    "time": Code("E507", "The program ran longer than allowed (--max-seconds)."),
    "interrupted": Code("E508", "The evaluation was interrupted."),
    "crash": Code("E509", "The process that worked on the program ended without a result."),
    # E6xx: scenes
    "parts": Code("E601", "A function's value is no entity, pair of entity and matrix, or list of these."),
    "pose": Code("E602", "A pose must be a finite 4x4 matrix whose last row is 0 0 0 1."),
    "attribute": Code("E603", "An attribute of a primitive has a value that its geometry cannot use."),
    "embedding": Code("E604", "Something that is no embedding was passed where `call` wants one."),
    "frames": Code("E605", "`frames` may only be the value of the root, and needs at least one frame."),
    "root": Code("E606", "The root word is not bound, or its value cannot be a scene."),
    "empty-scene": Code("E607", "The scene has no primitives, so there is nothing to draw or export."),
    "endless": Code("E608", "The root's list of handles has no end, and this operation would need it."),
    "word": Code("E609", "A word must be a string."),
    "blocks": Code("E610", "A pose or size of Minecraft blocks does not come to whole cells."),
    # E7xx: files
    "file": Code("E701", "A file cannot be read or written."),
    "import-cycle": Code("E702", "Files import one another in a circle."),
    "import-outside": Code("E703", "A path leaves the project folder."),
    "z-file": Code("E704", "The file of embeddings is malformed."),
    "backend": Code("E705", "No backend can write this file, or the one that can is not installed."),
    "unsupported": Code("E706", "The backend cannot draw this scene."),
    "weights": Code("E707", "The weights of a neural model are not on this machine, or are those of another model."),
    # E8xx: a language model's Python
    "python-syntax": Code("E801", "The Python does not parse."),
    "python-forbidden": Code(
        "E802", "Python that has no meaning for a scene: files, network, `eval`, Python's insides."
    ),
    "python-unsupported": Code("E803", "A feature of Python that the translation does not know."),
    "python-name": Code("E804", "A name of the Python has no definition."),
    "python-call": Code("E805", "A call in the Python does not fit what it calls."),
    # E9xx: language models
    "model-key": Code("E901", "There is no key for a language model's service, or the service does not accept it."),
    "model-offline": Code("E902", "A language model's service cannot be reached."),
    "model-request": Code("E903", "A language model's service does not accept a request, or fails."),
    "model-cost": Code("E904", "The next request could cost more than is left of --max-cost."),
    "model-price": Code("E905", "The price of a model is not known."),
    "model-refusal": Code("E906", "The model declines to answer."),
    "model-answer": Code("E907", "The model's answers came to no program that works."),
    "listing": Code("E908", "The list of primitives in a model's answer is malformed."),
    "prompt": Code("E909", "A prompt's file is missing, or has a place for which there is no text."),
    "run": Code("E910", "There is no such run, or its folder is damaged or in use."),
    # W
    "undefined-word": Code("W301", "A word is called at top level before its `bind`."),
    "shadowed-macro": Code("W302", "One of the paper's four macros is shadowed."),
    "bound-twice": Code("W303", "A word is bound twice in one file; the last binding wins."),
    "ambiguous-root": Code("W304", "Several words could be the root; the last bound was taken."),
    "optional-embedding": Code("W305", "A `call` never fills optional positional parameters; their defaults are used."),
    "unused": Code("W306", "A definition, local or parameter is never used."),
    "shadowed-builtin": Code("W307", "Something that is no function is called by the name of a builtin that it hides."),
    "unreachable-word": Code("W308", "The root of the scene never reaches a word of its file."),
    "constant-condition": Code("W309", "A condition is always true or always false."),
    "turned-after-moved": Code("W609", "A thing is turned about the origin after it was moved away from it."),
    "overlap": Code("W611", "Things are where others are: twice in one place, hidden inside, or deep in one another."),
    "floating": Code("W612", "Something touches nothing, a little off the ground or off the thing that it belongs to."),
    "below-ground": Code("W613", "Something reaches far below y = 0, on which the scene stands."),
    "coincident-faces": Code("W614", "Two faces of different colours lie in one plane, so either may be drawn."),
    "geometry-limit": Code("W615", "The scene is larger than `check --geometry` looks at, or has too many findings."),
    "empty-box": Code("W601", "The bounding box of nothing is the unit box."),
    "no-extent": Code("W602", "A primitive has no extent in some direction."),
    "unused-entry": Code("W603", "An entry of the file of embeddings names nothing in the scene."),
    "embedding-only": Code("W604", "The call changed things outside it, so only its embedding was replaced."),
    "near-word": Code("W605", "A word is never bound, but one close to it is: perhaps a misspelling."),
    "idle-attribute": Code("W608", "A primitive's geometry does not read an attribute: perhaps a misspelling."),
    "set-order": Code("W607", "The order of a set's strings is not that of Python."),
    "unknown-block": Code("W616", "Minecraft has no block of this name, so another one is laid instead."),
    "block-property": Code("W623", "A Minecraft block takes no such property or value, so it is left out."),
    "off-cells": Code(
        "W624", "Blocks stand between cells, and moving them to cells changes the distances between them."
    ),
    "no-block": Code("W617", "Something lays no blocks, so it is missing from the build."),
    "too-new": Code("W620", "The version of Minecraft that a file is for does not have a block."),
    "lost-contents": Code("W618", "A file of a Minecraft build holds things that blocks alone do not."),
    "plain-look": Code(
        "W619", "The game's looks have no model for a block, so boxes of its average colour stand for it."
    ),
    "not-shown": Code("W625", "More was found than is shown at once."),
    "crowded-layout": Code("W621", "More things are seen than a text-to-image model is told of at once."),
    "unread-vectors": Code("W622", "Learned vectors are for another text encoder than the model's, so texts serve."),
    "unknown-function": Code("W801", "`library_call` names no registered function; the call gives an empty shape."),
    "ignored-block": Code("W802", "Only one block of Python in a response is read."),
    "python-ignored": Code("W803", "A statement of the Python has no effect on the scene and was left out."),
    "draw-order": Code("W804", "A generator and the loop over it both draw random numbers; the generator draws first."),
    "print-limit": Code("W501", "The log is full; the rest of what the program prints is dropped."),
}
