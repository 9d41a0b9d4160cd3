"""Language model services: requests, replies, prices and cost limits.

``provider`` defines the interface of a service, ``anthropic_messages`` and ``openai_chat`` implement it, ``catalogue``
contains models, prices and API keys, ``client`` enforces the budget and caches replies. The package does not depend on
the content of requests: tasks are in ``scenelang.inference``.
"""
