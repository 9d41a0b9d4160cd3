"""Benchmark of language models: tasks with predicates, runs, replay of recorded answers, and tables."""
