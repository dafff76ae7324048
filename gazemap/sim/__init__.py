"""A simulated person at a table, with exact truth; shares no code with the estimators."""
