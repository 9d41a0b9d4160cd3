"""Entry point of ``python -m scenelang``."""

from scenelang.cli.start import entry

entry()
