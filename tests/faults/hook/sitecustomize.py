"""Loaded by each Python process of the tests while this folder is in PYTHONPATH: subprocesses report too."""

import fault_probe

fault_probe.install()
