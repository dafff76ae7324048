"""Poses, cameras, rays and alignment: pure functions on numpy arrays."""
