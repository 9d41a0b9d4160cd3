"""The REPL: a session that goes on, in a terminal or driven by another program (docs/repl.md).

``loop`` takes one input after another, ``evaluation`` evaluates, ``commands`` are the lines with a comma, ``display``
shows; ``console`` is the terminal with completion, ``plain`` everything else.
"""
