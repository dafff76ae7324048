"""Backends: each turns a sentence into its EDS readings, the best first."""
