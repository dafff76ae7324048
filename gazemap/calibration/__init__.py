"""A rig before any recording; the numbers live in /calib."""

from gazemap.calibration.rig import Rig, load_rig

__all__ = ["Rig", "load_rig"]
