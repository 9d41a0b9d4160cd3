"""What is wrong with a file of a build, before it is known which file that is."""

from __future__ import annotations


class Damaged(Exception):
    """A file is not what it should be; the message says why, as the end of a sentence."""
