"""From the syntax tree to an EDS in the vocabulary of the English Resource Grammar."""
