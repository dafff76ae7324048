"""Image patches of each object."""
