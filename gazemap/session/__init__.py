"""Recordings: opened from any format with `open_session`."""

from gazemap.session.opening import open_session

__all__ = ["open_session"]
