"""Code generation from the analysed Python, as functions that share one ``Writer``.

``writer`` is the context, ``code`` and ``blocks`` the representation of the output; ``statements``, ``expressions``,
``calls`` and the other modules generate code for the constructs in their names. The results of ``analysis`` are inputs;
nothing is inferred here.
"""
