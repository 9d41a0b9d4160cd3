"""Rigid bodies of a scene: which they are, what they weigh, how they move, and their files for simulators.

Knows nothing of commands. MuJoCo and CoACD are imported when something is simulated or written; only `dynamics` and
`colliders` name them.
"""
