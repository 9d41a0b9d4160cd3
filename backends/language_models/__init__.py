"""Language models as a service: requests, answers, prices, limits of cost.

``provider`` is what a family of models is, ``anthropic_messages`` and ``openai_chat`` are two, ``catalogue`` knows
models, prices and keys, ``client`` counts and keeps. It does not know what is asked for: tasks are in
``scenelang.inference``.
"""
