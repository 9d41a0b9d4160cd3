"""``python -m scenelang``: the command line."""

from scenelang.cli.main import entry

entry()
