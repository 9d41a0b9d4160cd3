"""The language server: what editors ask about programs (docs/editors.md).

``server`` speaks the protocol; ``names``, ``references`` and ``completion`` answer from a session. It runs no program
outside the sandbox.
"""
