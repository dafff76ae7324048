"""Tracking of the head camera and the sparse map; the home of gtsam and pycolmap."""
