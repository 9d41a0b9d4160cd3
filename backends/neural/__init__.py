"""Neural models and methods that use them; torch is imported on first use.

``weights`` locates models and devices; ``clip``, ``diffusion``, ``mvdream`` and ``grounding`` load networks;
``descriptions``, ``wording`` and ``prompts`` convert entities to text; ``inversion`` and ``metrics`` are methods with
one module each. The package does not depend on the command line.
"""
