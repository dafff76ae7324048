"""Fixation detection, the session's gaze offset and the way from gaze to 3D."""
