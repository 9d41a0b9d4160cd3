"""``python -m scenelang``: the command line."""

from scenelang.cli.start import entry

entry()
