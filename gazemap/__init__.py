"""From images and gaze to poses, surfaces and metric 3D fixations; knows no network."""

__version__ = "0.1.0"
