"""Everything that runs a neural model; torch is imported when it is first used.

``weights`` finds models and devices, ``clip``, ``diffusion``, ``mvdream`` and ``grounding`` load them; ``describing``,
``wording`` and ``sentences`` turn entities into text; ``inversion`` and ``metrics`` are methods of one file. It knows
nothing of what a user typed.
"""
