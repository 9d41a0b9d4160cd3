"""Scenes of the Python API: what ``load`` and ``evaluate`` return.

``scene`` has the class ``Scene`` with cameras, images, videos and maps; each method is a call into one domain. Nothing
here knows a command or a protocol.
"""
