"""Bundle adjustment by pycolmap, on a camera without distortion.

Views come as x/z, y/z and are given to pycolmap as pixels of a pinhole with a round focal length
and its principal point at 0, so no lens model and no half pixel comes in here.
"""

from dataclasses import dataclass

import numpy as np

from gazemap.errors import SolverError
from gazemap.geometry.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BundleProblem:
    """Cameras, points and who saw what.

    Attributes:
        R_cam_map: (K, 3, 3).
        t_cam_map: (K, 3).
        points_map: (P, 3).
        camera_index: (M,) into the cameras.
        point_index: (M,) into the points.
        flat: (M, 2) views.
        focal_px: what turns flat units into pixels.
        cauchy_px: scale of the robust loss.
        iterations: at most so many.
        refine_focal: whether the focal length is solved for as well.
    """

    R_cam_map: FloatArray
    t_cam_map: FloatArray
    points_map: FloatArray
    camera_index: IntArray
    point_index: IntArray
    flat: FloatArray
    focal_px: float
    cauchy_px: float
    iterations: int = 30
    refine_focal: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BundleSolution:
    """The adjusted cameras (K, 3, 3), (K, 3) and points (P, 3); by what the focal length grew."""

    R_cam_map: FloatArray
    t_cam_map: FloatArray
    points_map: FloatArray
    focal_factor: float = 1.0


def adjust(problem: BundleProblem) -> BundleSolution:
    """Return the cameras and points that minimise the robust reprojection.

    Points with fewer than two views stay where they are.

    Raises:
        SolverError: if the solver finds no usable solution.
    """
    import pycolmap

    rec, point_ids = _reconstruction(problem)
    options = pycolmap.BundleAdjustmentOptions(
        refine_focal_length=problem.refine_focal,
        refine_principal_point=False,
        refine_extra_params=False,
        refine_sensor_from_rig=False,
        print_summary=False,
    )
    options.ceres.loss_function_type = pycolmap.LossFunctionType.CAUCHY
    options.ceres.loss_function_scale = problem.cauchy_px
    options.ceres.solver_options.max_num_iterations = problem.iterations
    options.ceres.solver_options.function_tolerance = 1e-4
    options.ceres.solver_options.num_threads = 1  # sums in a fixed order: the same to the bit
    config = pycolmap.BundleAdjustmentConfig()
    for image_id in rec.images:
        config.add_image(image_id)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    summary = pycolmap.create_default_bundle_adjuster(options, config, rec).solve()
    if not summary.is_solution_usable():
        raise SolverError("bundle adjustment found no usable solution")
    return _solution(problem, rec, point_ids)


def _reconstruction(problem: BundleProblem):  # type: ignore[no-untyped-def]  # noqa: ANN202 - pycolmap is imported late
    import pycolmap

    rec = pycolmap.Reconstruction()
    camera = pycolmap.Camera(
        model="SIMPLE_PINHOLE", width=2, height=2, params=[problem.focal_px, 0.0, 0.0], camera_id=1
    )
    rec.add_camera_with_trivial_rig(camera)
    order = np.argsort(problem.camera_index, kind="stable")
    camera_of = problem.camera_index[order]
    starts = np.searchsorted(camera_of, np.arange(len(problem.R_cam_map) + 1))
    feature_index = np.empty(len(order), dtype=np.int64)
    feature_index[order] = np.arange(len(order)) - starts[camera_of]
    for k, (R, t) in enumerate(zip(problem.R_cam_map, problem.t_cam_map, strict=True)):
        mine = order[starts[k] : starts[k + 1]]
        if len(mine) == 0:
            continue
        image = pycolmap.Image(
            name=f"{k}",
            keypoints=problem.flat[mine] * problem.focal_px,
            camera_id=1,
            image_id=k + 1,
        )
        rec.add_image_with_trivial_frame(image, pycolmap.Rigid3d(np.column_stack([R, t])))
    return rec, _add_points(problem, rec, feature_index)


def _add_points(problem: BundleProblem, rec, feature_index: IntArray) -> dict[int, int]:  # type: ignore[no-untyped-def]  # noqa: ANN001 - pycolmap is imported late
    import pycolmap

    by_point = np.argsort(problem.point_index, kind="stable")
    starts = np.searchsorted(problem.point_index[by_point], np.arange(len(problem.points_map) + 1))
    camera_of, feature_of = problem.camera_index.tolist(), feature_index.tolist()
    ids = {}
    for j in range(len(problem.points_map)):
        mine = by_point[starts[j] : starts[j + 1]].tolist()
        if len(mine) < 2:
            continue
        track = pycolmap.Track(
            [pycolmap.TrackElement(camera_of[m] + 1, feature_of[m]) for m in mine]
        )
        ids[j] = rec.add_point3D(problem.points_map[j], track)
    return ids


def _solution(problem: BundleProblem, rec, ids: dict[int, int]) -> BundleSolution:  # type: ignore[no-untyped-def]  # noqa: ANN001 - pycolmap is imported late
    R, t = problem.R_cam_map.copy(), problem.t_cam_map.copy()
    points = problem.points_map.copy()
    for image_id, image in rec.images.items():
        matrix = image.cam_from_world().matrix()
        R[image_id - 1], t[image_id - 1] = matrix[:, :3], matrix[:, 3]
    for j, point_id in ids.items():
        points[j] = rec.points3D[point_id].xyz
    focal_factor = float(rec.cameras[1].params[0]) / problem.focal_px
    return BundleSolution(R_cam_map=R, t_cam_map=t, points_map=points, focal_factor=focal_factor)
