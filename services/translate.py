"""From the records of mapping to those of grounding: the two packages never meet elsewhere."""

import cv2
import numpy as np

from gazemap.types.fixation import Fixation3D
from gazemap.types.scene import SceneObject
from grounding.types import FixationObservation, ObjectInstance, RestingPlace


def observation(fixation: Fixation3D) -> FixationObservation:
    """Return a 3D fixation as grounding sees it."""
    return FixationObservation(
        fixation_id=fixation.fixation.fixation_id,
        start_ns=fixation.fixation.start_ns,
        end_ns=fixation.fixation.end_ns,
        point_world=fixation.point_world,
        cov_world=fixation.cov_world,
        origin_world=fixation.origin_world,
    )


def instance(thing: SceneObject) -> ObjectInstance:
    """Return an object with its resting places as grounding sees it."""
    track = tuple(
        RestingPlace(
            t_ns=state.t_ns,
            left_ns=state.left_ns,
            position_world=state.T_world_body.t,
            quat_xyzw=state.T_world_body.quat_xyzw,
            cov_world=state.cov_world,
        )
        for state in thing.track
    )
    bgr = np.asarray(thing.mean_bgr, dtype=np.float32).reshape(1, 1, 3) / 255
    return ObjectInstance(
        object_id=thing.object_id,
        size_m=thing.size_m,
        track=track,
        colour_lab=cv2.cvtColor(bgr, cv2.COLOR_BGR2LAB).reshape(3).astype(np.float64),
    )
