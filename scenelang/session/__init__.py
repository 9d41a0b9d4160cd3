"""Sessions: texts are checked, evaluated, edited, formatted and compared.

``session`` is the way of every command to a scene; ``editing`` continues versions of a text; ``declarations``,
``motion`` and ``materials`` are what scenes are asked. Nothing here knows a command or a protocol.
"""
