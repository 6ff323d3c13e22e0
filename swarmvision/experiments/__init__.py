"""Experiments: whole questions, each answered by one function."""
