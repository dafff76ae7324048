"""What is measured on a patch, by name."""
