"""What commands print and ask for.

``reports`` are tables and progress, ``shell_completion`` completes command lines, ``doctor`` checks the installation.
Commands themselves are in ``cli``.
"""
