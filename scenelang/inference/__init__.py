"""Scenes from words and pictures: a language model proposes, grammar and interpreter check (the paper, section 5).

``brief`` is what is asked, ``steps`` what an answer is worth, ``conductor`` asks, repairs and chooses, ``records``
keeps runs, ``listing`` is a scene without a program, ``generation`` has ``generate`` and ``edit``. It does not know
which provider answers.
"""
