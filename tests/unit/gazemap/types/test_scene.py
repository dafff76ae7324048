import numpy as np
import pytest

from gazemap.geometry.pose import Pose
from gazemap.types.scene import ObjectState, SceneObject, yaw_rad


def state(t_ns, left_ns, x):
    return ObjectState(
        t_ns=t_ns,
        left_ns=left_ns,
        T_world_body=Pose.from_rotvec([0, 0, 0.5], [x, 0, 0]),
        cov_world=np.eye(3),
    )


@pytest.mark.parametrize(
    ("t_ns", "x"),
    [(9, None), (10, 1.0), (49, 1.0), (50, None), (79, None), (80, 2.0), (10**9, 2.0)],
)
def test_an_object_rests_where_it_was_put_and_is_nowhere_while_it_is_carried(t_ns, x):
    thing = SceneObject(
        object_id="object-1",
        size_m=np.ones(3),
        track=(state(10, 50, 1.0), state(80, None, 2.0)),
        mean_bgr=np.zeros(3),
    )
    found = thing.at(t_ns)
    assert (None if found is None else found.T_world_body.t[0]) == x


def test_yaw_is_the_heading_about_z():
    assert yaw_rad(state(0, None, 0.0).T_world_body) == pytest.approx(0.5)
