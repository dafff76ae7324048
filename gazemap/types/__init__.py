"""Frozen records that are handed from stage to stage."""
