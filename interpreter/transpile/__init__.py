"""Transpiler from a language model's Python to a program of the language; the Python is parsed, never executed.

``python_text`` extracts and parses the code, ``analysis`` resolves names and infers types, ``writing`` generates the
program, and ``translate`` runs all of these steps (docs/transpiler.md). The helper API is known from a table; it is not
imported.

What Python means in a program of the language:

- A shape used as a list (`len(shape)`, `shape[0]`, `for s in shape`) is translated with `primitives`, not `parts`. In
  the reference implementation a shape is the flat list of its primitives, so only this gives the same counts and
  items.
- A parameter that any caller passes by name becomes a keyword parameter of a local function, even if all arguments
  could be positional. A parameter whose name shadows a builtin that its function needs keeps its name, because calls
  use it; the builtin is then called `std/name`.
- A keyword parameter that a table may supply (`f(**table)`) keeps Python's spelling, `:num_seats`, because the table's
  keys are strings.
- Variables keep their names in translated programs; a hidden builtin is written `std/length`, as in the library
  itself.
- Tuples and lists are one type in the language. If the types are known, comparing a tuple with a list is false as in
  Python (`==`, `in`, `count`, `index`, `remove`, nested ones too). Otherwise equal items compare equal, because
  programs that compare values of unknown types nearly always compare values of one type.
- Closures that outlive an iteration of a loop or a comprehension share its variable, as in Python. A generator
  expression that is not collected runs in step with its consumer, so its closures see the value of their iteration. A
  function passed to a call is assumed to be called during that call, unless the method stores it (`append` and
  similar) or a function of the program does.
- `concat_shapes` of matrices as a pose (also `np.concatenate` or `np.vstack` of whole matrices) returns the first
  matrix, with a warning: the reference stacks the rows and reads the first four.
- Numpy views are not supported: modifying a slice through another name is an error of the transpiler. Programs
  normally only read slices.
- `except` with a single handler catches every error if the language splits that exception into several codes
  (`ValueError`).
- Generators are lists, and are written in place only where that makes a difference, because lists read better, and
  the body of a loop would be repeated for each `yield`.
- Random numbers that decide what is built are fixed (W805) rather than refused, although nothing that draws should be
  folded: a program that builds the scene of the seed 0 is worth more than none. Draws that only give numbers stay
  draws.
- The transpiler formats its output as `fmt` does, to 88 columns.
"""
