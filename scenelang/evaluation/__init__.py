"""Evaluation as in the paper: metrics of many scenes, kept and laid out as tables, and a page that asks people."""
