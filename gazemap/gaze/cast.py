"""Fixations cast into the scene, with covariances.

The uncertain direction is represented by a grid of rays (Gauss-Hermite) rather than by a
derivative: at an object's rim the neighbours hit something else, and the covariance must say so.
"""

from dataclasses import replace

import numpy as np

from gazemap.gaze.config import GazeNoise
from gazemap.gaze.directions import angles_of, directions_of
from gazemap.geometry.arrays import FloatArray
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Cam, Overhead, Pose, World
from gazemap.ports import SurfaceQuery
from gazemap.types.fixation import Fixation3D, GazeOffset
from gazemap.types.scene import HitKind, Miss, SurfaceHit
from gazemap.types.session import Fixation
from gazemap.types.tracking import Trajectory

_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(5)
_GRID = np.stack(np.meshgrid(_NODES, _NODES), axis=-1).reshape(-1, 2)
_CHANGE_WEIGHT = 0.16  # of the scene one standard deviation of time away, on either side
_GRID_WEIGHTS = np.outer(_WEIGHTS, _WEIGHTS).ravel() / _WEIGHTS.sum() ** 2

PosedOverhead = tuple[Camera, Pose[World, Overhead]]


def cast_fixations(  # noqa: PLR0913 - all that a stage of its own needs, by name
    fixations: tuple[Fixation, ...],
    *,
    trajectory: Trajectory,
    camera: Camera,
    surface: SurfaceQuery,
    offset: GazeOffset,
    noise: GazeNoise,
    overhead: PosedOverhead | None = None,
) -> tuple[Fixation3D, ...]:
    """Cast each fixation at its mid-time into the scene as it stood then.

    Args:
        fixations: as detected.
        trajectory: the camera's path.
        camera: the scene camera.
        surface: the scene.
        offset: taken out where it is applied; its uncertainty counts in any case.
        noise: what else is uncertain.
        overhead: the camera into which the points are projected, with its pose.
    """
    caster = FixationCaster(camera=camera, surface=surface, offset=offset, noise=noise)
    return tuple(caster.cast(f, trajectory.at(f.mid_ns), overhead=overhead) for f in fixations)


def in_scene_image(
    fixation: Fixation3D, T_world_cam: Pose[World, Cam] | None, camera: Camera
) -> Fixation3D:
    """Return a fixation of another camera with its pixel in the scene camera's image."""
    if fixation.point_world is None or T_world_cam is None:
        return replace(fixation, scene_uv_px=np.full(2, np.nan))
    point_cam = T_world_cam.inverse().transform(fixation.point_world)
    return replace(fixation, scene_uv_px=camera.project(point_cam[None])[0])


class FixationCaster:
    """Casts fixations one by one, as the live service does."""

    def __init__(
        self, *, camera: Camera, surface: SurfaceQuery, offset: GazeOffset, noise: GazeNoise
    ) -> None:
        """Keep what all fixations share."""
        self._camera, self._surface, self._noise = camera, surface, noise
        estimate = np.array([offset.azimuth_rad, offset.elevation_rad])
        sigma = np.array([offset.azimuth_sigma_rad, offset.elevation_sigma_rad])
        self._taken_out = estimate if offset.is_applied else np.zeros(2)
        left = np.zeros(2) if offset.is_applied else estimate
        own = np.radians(np.hypot(noise.fixation_sigma_deg, noise.pose_sigma_deg))
        self._sigma_rad = np.sqrt(sigma**2 + left**2 + own**2)

    def cast(
        self,
        fixation: Fixation,
        T_world_cam: Pose[World, Cam] | None,
        *,
        overhead: PosedOverhead | None = None,
    ) -> Fixation3D:
        """Cast one fixation from the pose at its mid-time; None where the camera was lost."""
        seen = angles_of(self._camera.unproject(np.array([[fixation.u_px, fixation.v_px]])))
        angles = seen[0] - self._taken_out
        uv_px = self._camera.project(directions_of(angles[None]))[0]
        if T_world_cam is None:
            return _miss(fixation, uv_px, "the head camera was lost")
        rays_cam = directions_of(np.vstack([angles, angles + _GRID * self._sigma_rad]))
        hits = self._surface.cast(
            t_ns=fixation.mid_ns,
            origins_world=np.tile(T_world_cam.t, (len(rays_cam), 1)),
            directions_world=T_world_cam.rotate(rays_cam),
        )
        middle = hits[0]
        if isinstance(middle, Miss):
            return _miss(fixation, uv_px, middle.reason, T_world_cam.t)
        earlier_later = self._at_other_times(fixation.mid_ns, T_world_cam, rays_cam[:1])
        return Fixation3D(
            fixation=fixation,
            scene_uv_px=uv_px,
            hit=HitKind.OBJECT if middle.object_id else HitKind.SURFACE,
            point_world=middle.point_world,
            cov_world=self._covariance(middle, hits[1:], earlier_later),
            object_id=middle.object_id,
            overhead_uv_px=_projected(middle.point_world, overhead),
            origin_world=T_world_cam.t,
        )

    def _at_other_times(
        self, t_ns: int, T_world_cam: Pose[World, Cam], rays_cam: FloatArray
    ) -> list[SurfaceHit | Miss]:
        """Return what the ray meets in the scene as it stood a little earlier and later."""
        step_ns = int(self._noise.change_sigma_s * 1e9)
        return [
            self._surface.cast(
                t_ns=t_ns + shift_ns,
                origins_world=T_world_cam.t[None],
                directions_world=T_world_cam.rotate(rays_cam),
            )[0]
            for shift_ns in (-step_ns, step_ns)
        ]

    def _covariance(
        self,
        middle: SurfaceHit,
        around: list[SurfaceHit | Miss],
        earlier_later: list[SurfaceHit | Miss],
    ) -> FloatArray:
        """Return gaze, pose, surface and its changes together (3, 3)."""
        met = [
            (hit.point_world - middle.point_world, weight)
            for hit, weight in zip(around, _GRID_WEIGHTS, strict=True)
            if isinstance(hit, SurfaceHit)
        ]
        away, weights = np.array([a for a, _ in met]), np.array([w for _, w in met])
        cov = np.einsum("k,ki,kj->ij", weights / weights.sum(), away, away)
        cov += middle.sigma_m**2 * np.outer(middle.normal_world, middle.normal_world)
        for hit in earlier_later:
            if isinstance(hit, SurfaceHit):
                change = hit.point_world - middle.point_world
                cov += _CHANGE_WEIGHT * np.outer(change, change)
        total: FloatArray = cov + self._noise.pose_sigma_m**2 * np.eye(3)
        return total


def _miss(
    fixation: Fixation, uv_px: FloatArray, reason: str, origin_world: FloatArray | None = None
) -> Fixation3D:
    return Fixation3D(
        fixation=fixation,
        scene_uv_px=uv_px,
        hit=HitKind.NONE,
        point_world=None,
        cov_world=None,
        object_id=None,
        overhead_uv_px=None,
        reason=reason,
        origin_world=origin_world,
    )


def _projected(point_world: FloatArray, overhead: PosedOverhead | None) -> FloatArray | None:
    if overhead is None:
        return None
    camera, T_world_overhead = overhead
    uv_px = camera.project(T_world_overhead.inverse().transform(point_world)[None])
    return uv_px[0] if camera.contains(uv_px).all() else None
