"""Warnings about programs that have no error: what is nearly always a mistake, found before anything runs.

``facts`` gathers what is to be known of each top-level form; ``lint`` puts the warnings together.
"""
