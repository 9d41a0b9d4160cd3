"""How each mistake is mended, by the names of ``codes``. Read where somebody asks for it only: the command ``explain``,
the reference of diagnostics."""

from __future__ import annotations

from collections.abc import Mapping

from scenelang.grammar.codes import CODES

_READING = {
    "unclosed": 'Close what the message points at: add the missing `)`, `]`, `"` or `|#` where the form is to end.',
    "extra-close": "Remove the closer, close with the one that fits the opener, or find the opener that is missing.",
    "bad-atom": 'Write a number that is one, put text in `"..."`, and index with `(ref xs 0)` instead of `xs[0]`.',
    "bad-string": "Double a backslash that is meant as one, `\\\\`, or use one of the escapes that the hint lists.",
    "bad-dot": "Put something before the dot and one datum after it, or write `.5` without a blank.",
    "nesting": "Break the program into definitions, or make deep data by a loop.",
    "encoding": "Save the file as UTF-8 in your editor.",
}

_FORMS = {
    "syntax": "Give the form the shape that the hint shows; `docs/reference/forms.md` has an example of each.",
    "lambda-list": "Write each parameter as `name`, `(name default)`, `:name` or `(:name default)`, a rest one last.",
    "misplaced": "Move the form to where it belongs: `scene` and `param` to the top level, `else` into `cond`.",
    "reserved": "Choose another name.",
    "duplicate": "Rename one of the two, or remove it.",
    "absent": "Do it the way that the hint names.",
    "macro": "Compare the macro's patterns with its use; the first element of a pattern is the macro's name.",
    "expansion": "Look for a macro that expands into itself, or for a loop in the body of a `define-macro`.",
    "bracket": "Write round parentheses: only arrays of numbers stand in `[...]`; lists of others are `(list ...)`.",
    "strict": "Use only what the rule allows, or check without `--strict`: the full language allows more.",
    "empty-application": "Write `'()` or `(list)` for the empty list, `(union)` for no parts.",
}

_NAMES = {
    "unbound": "Correct the spelling, define the name, or import the file that does.",
    "undefined-yet": "Move the definition above its first use, or use the name in a function that is called later.",
    "type-name": "Use a type of the list in `docs/reference/stdlib.md`, or the name of a record.",
    "no-root": 'Bind a word: `(bind "word" (lambda () (call "cube")))`.',
    "param": "Give a value of the param's own kind within its `:min` and `:max`, under the name that the program has.",
}

_RUNNING = {
    "type": "Pass a value of the type that the message names, or convert it first.",
    "arity": "Pass as many arguments as the signature in the hint has.",
    "not-a-procedure": "Put a function at the head; a value alone stands without parentheses. A name of the library "
    "that a parameter hides is still there as `std/name`.",
    "keyword": "Name the attributes that the function has, each once, and give those that have no default.",
    "index": "Count from 0 to one less than the length, or from -1 backwards; test with `length` before.",
    "key": "Ask for a key that is there, or give a default: `(ref table key default)`.",
    "zero-division": "Test the divisor before, or keep it away from 0 with `max`.",
    "domain": "Keep the number inside the function's domain, with `clamp`, `max` or a test.",
    "value": "Pass a value that the message allows.",
    "immutable": "Make the mutable twin, `(mutable-list ...)` or `(mutable-array ...)`, or build a new value.",
    "changed": "Collect the keys first, `(table-keys table)`, and change the table while running over that list.",
    "pattern": "Make the pattern as long as the sequence, or take the rest with `(a b . more)`.",
    "assert": "The program says that this must hold: correct what it tests, or the values that lead there.",
    "user": "The message is the program's own: look at the call that it points at, or catch it with `guard`.",
    "escape": "Call the escape procedure inside the body of its `let/ec` only.",
    "format": "Write one `{}` for each value, and a format behind the colon that the value has: `{:.2f}`.",
}

_LIMITS = {
    "steps": "Look for a loop or recursion without end; else raise `--max-steps`.",
    "depth": "Give the recursion an end, or make it a loop; else raise `--max-depth`.",
    "entities": "Let copies share one call with equal attributes; else raise `--max-entities`.",
    "primitives": "Make fewer levels or copies, look with `count` and `bounds`, which never expand, or raise "
    "`--max-primitives`.",
    "size": "Look for a list, string or number that grows without end; else raise `--max-size`.",
    "memory": "Keep less at a time; else raise `--max-memory`.",
    "time": "Look for a loop or recursion without end; else raise `--max-seconds`.",
    "crash": "Lower --max-memory where the system ran out of memory; otherwise a library failed: please report it.",
    "interrupted": "Run it again, with smaller numbers or limits if it took too long.",
}

_SCENES = {
    "parts": "Return entities, pairs that `transform` makes, or lists of these; `(union)` stands for nothing at all.",
    "pose": "Make the matrix with `translate`, `rotate`, `scale`, `reflect` and `@`, from finite numbers.",
    "attribute": "Give the attribute the kind of value that the message names.",
    "embedding": "Name the attribute, `:height 3`, or write a text, a handle or `(embedding ...)`.",
    "frames": "Return `(frames list)` from the root itself, with one member or more.",
    "root": "Name a word that the program binds, and let its function return parts.",
    "empty-scene": 'Return at least one primitive, such as `(call "cube")`.',
    "endless": "Take as many handles as you need: `(list-head gamma n)`.",
    "word": 'Put the word in quotes: `"park"`.',
    "blocks": "Compose blocks with `translate` and whole numbers in `scale` only.",
}

_FILES = {
    "file": "Check the path and the permissions; paths are relative to the file that names them.",
    "import-cycle": "Move what both files need into a third one that imports neither.",
    "import-outside": "Move the file into the project folder, or allow it with `--allow-outside`.",
    "z-file": "Write the file anew with `scenelang embeddings`, or remove it.",
    "backend": "Choose an ending or backend that `scenelang backends` lists, and install what the hint names.",
    "unsupported": "Bring the scene to a size that can be drawn, or take another backend (`scenelang backends`).",
    "weights": "Connect once so that they are fetched, or name the folder that holds them: `--models-dir DIR`.",
}

_PYTHON = {
    "python-syntax": "Correct the Python at the place shown, or ask the model for its program again.",
    "python-forbidden": "Remove it: a scene needs shapes, numbers and random draws, and nothing of the computer.",
    "python-unsupported": "Write it with plain functions, loops and lists; `docs/transpiler.md` lists what is known.",
    "python-name": "Correct the spelling, or define the name before it is used.",
    "python-call": "Pass the arguments that the function has.",
}

_MODELS = {
    "model-key": "Set the key in the environment, or write it into the configuration file, which only you may read.",
    "model-offline": "Connect the machine, or check the base URL; `--dry-run` needs no network.",
    "model-request": "Read what the service says; wait and continue with `--resume` where it has too much to do.",
    "model-cost": "Raise `--max-cost`, or ask for less: `--max-tokens`, `-n`, `--critique`.",
    "model-price": "Give it with `--price INPUT,OUTPUT`, or in the configuration file, or take a model that is known.",
    "model-refusal": "Word the task differently.",
    "model-answer": "Allow more tries with `--repair`, take another model or more `--effort`, or ask for less.",
    "listing": "Ask again: items want `shape`, `attributes` and `pose`.",
    "prompt": "Correct the place's name, or remove the file so that the package's own prompt is used.",
    "run": "Take one that `scenelang runs` lists, and wait until no other process is at work on it.",
}

_WARNINGS = {
    "undefined-word": "Move the `bind` above the call, or call the word inside a function.",
    "shadowed-macro": "Choose another name, or write `std/union` for the paper's.",
    "bound-twice": "Remove one of the two bindings, or rename one word.",
    "ambiguous-root": 'Say which word is the scene: `(scene "word")`, or `--root WORD`.',
    "optional-embedding": "Make it a keyword parameter, `(:height 2)`, and pass `:height` in the `call`.",
    "unused": "Remove it, use it, or begin its name with `_`.",
    "shadowed-builtin": "Rename the parameter or local, or call the library's function as `std/name`.",
    "unreachable-word": "Call the word somewhere, remove its `bind`, or name another root.",
    "constant-condition": "Test what can differ, or keep only the branch that is taken.",
    "turned-after-moved": "Turn first, then move, `(@ (translate v) (rotate a axis))`, or give `rotate` the point to "
    "turn about.",
    "empty-box": "Measure something that has a primitive in it.",
    "no-extent": "Give the primitive a size, or two different end points.",
    "unused-entry": "Look at the handles with `scenelang tree`, then rename or remove the entry with `scenelang "
    "embeddings`.",
    "embedding-only": "Let the call change nothing outside itself, or write the attribute in the program.",
    "near-word": "Correct the spelling, or leave it if a word of its own is meant.",
    "idle-attribute": "Correct the spelling, or remove the attribute.",
    "set-order": "Keep them in a list where the order matters; in Python, loop over `sorted(names)`.",
    "overlap": "Move one of the two, or remove what is there twice; `; lint: allow overlap` allows what is meant.",
    "floating": "Set it down with `on-top-of`, `align` or `attach`, or allow it: `; lint: allow floating`.",
    "below-ground": "Lift it by what is below 0: `compute-shape-min` tells how much.",
    "coincident-faces": "Move one of the faces by a thousandth, or make one of the things a little smaller.",
    "geometry-limit": "Check a part of the scene by itself: `--root WORD`.",
    "unknown-block": "Name the block that is laid instead, or another one that the game has.",
    "block-property": "Take one of those that the message lists, or leave the property out: it has a default.",
    "off-cells": "Move blocks by whole numbers: distances and gaps of combinators too.",
    "no-block": "Lay blocks with `set-cuboid`, or turn the scene into blocks with `export --voxelize`.",
    "too-new": "Name a newer version with `--mc-version`, or lay a block that the older one has.",
    "lost-contents": "Nothing need be done; fill chests and write signs in the game.",
    "plain-look": "Give the looks of the whole game with `--textures`; a resource pack may hold a part of them only.",
    "not-shown": "Fix what is shown first; one mistake often has many consequences.",
    "crowded-layout": "Take whole entities as one: `--depth N`, `--entity NAME`; or come nearer with `--camera`.",
    "unread-vectors": "Name a model whose text encoder they were learned for: `--model NAME`.",
    "unknown-function": "Register a function of that name, or correct the name.",
    "ignored-block": "Keep one block with the whole program.",
    "python-ignored": "Nothing need be done; `--seed N` sets the seed.",
    "draw-order": "Compare the picture with the model's; draw in one place only if the order matters.",
    "print-limit": "Print less, or run with `--quiet`.",
}

MENDS: Mapping[str, str] = {
    **_READING, **_FORMS, **_NAMES, **_RUNNING, **_LIMITS, **_SCENES, **_FILES, **_PYTHON, **_MODELS, **_WARNINGS
}  # fmt: skip


def diagnostic_named(asked: str) -> str | None:
    """The name of the diagnostic that a code or name means; None where there is none."""
    by_code = {entry.code: name for name, entry in CODES.items()}
    name = by_code.get(asked.upper(), asked.lower())
    return name if name in CODES else None


def explanation(name: str) -> tuple[str, str, str]:
    """A diagnostic for people: code and name, why it arises, how it is mended."""
    return f"{CODES[name].code} {name}", f"  {CODES[name].why}", f"  {MENDS[name]}"
