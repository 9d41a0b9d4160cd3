"""Benchmark of language models: tasks with predicates, runs, replay of recorded answers, and tables.

It judges answers by evaluating them, and knows nothing of how they were requested or how results are printed.
"""
