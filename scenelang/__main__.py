"""``python -m scenelang``: the command line."""

from scenelang.start import entry

entry()
