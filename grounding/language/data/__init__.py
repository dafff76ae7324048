"""Tables of words: data, no code."""
