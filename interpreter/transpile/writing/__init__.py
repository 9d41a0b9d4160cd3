"""From the analysed Python to the text of a program, as functions over one ``Writer``.

``writer`` is the context, ``code`` and ``blocks`` what is written; ``statements``, ``expressions``, ``calls`` and the
other files write what their names say. It takes what ``analysis`` found and looks nothing up in the Python itself.
"""
