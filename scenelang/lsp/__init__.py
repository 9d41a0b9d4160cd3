"""Language Server Protocol implementation (docs/editors.md).

``server`` implements the protocol; ``names``, ``references`` and ``completion`` answer requests from a session.
Programs run only inside the sandbox.
"""
