"""Alignment of the plan with the fixations by probabilistic inference."""
