"""Thirty drawn sessions against their truth: `python -m tests.drawn_study FOLDER [FIRST COUNT]`.

Length, level, table, things, cameras, gaze rate, noise and offset are drawn. Sessions that are in
the folder already are not drawn again. One line a session, then what all have in common.
"""

import importlib.util
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.stats import chi2

from gazemap.pipeline import MappingConfig, OffsetMode, find_looks, locate_cameras, model_scene
from gazemap.scene.config import SceneConfig, SweepConfig
from gazemap.session import open_session
from gazemap.sim.config import Level, SimConfig, preset, resized
from tests.builders import build_session

SCORE = Path(__file__).resolve().parents[1].parent / "shared" / "score" / "score.py"
# The surroundings do not matter to what is on the table, and cost the most.
CONFIG = MappingConfig(scene=SceneConfig(sweep=SweepConfig(pool=1)))
_LEVELS = (Level.EASY, Level.MEDIUM, Level.HARD)
_COLOURS = ("red", "blue", "yellow", "green", "purple", "white", "black", "pink", "cyan")
_SHAPES = ("cube", "block", "cell", "brick", "tile", "pillar", "plank")
_NEAR_M = 0.04  # a thing is found if one is so near


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """Things at one moment: errors of those found (metres), how many were missed and invented."""

    errors_m: tuple[float, ...]
    missed: int
    false: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What one session gave.

    Attributes:
        looks: how many true fixations there are.
        is_inside: whether each look lies in its 95 % ellipsoid.
        sigmas_m: the ellipsoids' longest half axes, one standard deviation.
        mapping_m: how far the points lie from what their own pixels truly show.
        gaze_m: how far they lie from what was looked at; and the same without any correction.
        uncorrected_m: the latter.
        offset_deg: the eye tracker's error.
        left_deg: what is left of it.
        start: the things at the start.
        end: the things at the end.
    """

    looks: int
    is_inside: tuple[bool, ...]
    sigmas_m: tuple[float, ...]
    mapping_m: tuple[float, ...]
    gaze_m: tuple[float, ...]
    uncorrected_m: tuple[float, ...]
    offset_deg: float
    left_deg: float
    start: Found
    end: Found


def drawn(n: int) -> SimConfig:
    """Return the n-th session of the study."""
    rng = np.random.default_rng([41, n])
    config = preset(_LEVELS[n % 3])
    things = config.tabletop
    if n % 2:
        colours, shapes = (tuple(rng.permutation(w)[:4].tolist()) for w in (_COLOURS, _SHAPES))
        things = replace(things, colours=colours, shapes=shapes)
    things = replace(
        things,
        object_count=int(rng.integers(4, 10)),
        grain_contrast=float(rng.uniform(0.2, 1.0)),
        speck_count=int(rng.integers(0, 80)),
    )
    wide, rate_hz = (800, 30.0) if n % 5 == 4 else (640, 20.0)
    return replace(
        config,
        seed=41_000 + n,
        seconds=float(rng.uniform(20.0, 40.0)),
        gaze_rate_hz=float(rng.choice([30, 60, 120, 200])),
        tabletop=things,
        person=replace(
            config.person,
            gaze_offset_deg=float(rng.uniform(0.0, 3.0)),
            gaze_noise_deg=float(rng.uniform(0.1, 0.6)),
        ),
        scene_lens=resized(
            config.scene_lens, width_px=wide, height_px=wide * 3 // 4, rate_hz=rate_hz
        ),
        overhead_lens=replace(config.overhead_lens, rate_hz=float(rng.choice([5, 10]))),
    )


def measured(folder: Path) -> Outcome:
    """Map a simulated session and compare what is said about it with its truth."""
    session = open_session(folder / "session")
    located = locate_cameras(session, CONFIG, progress=silent)
    return compared(folder, session, located)


def compared(folder, session, located) -> Outcome:
    """The same with known poses of the cameras."""
    scene = model_scene(session, located, CONFIG, progress=silent)
    looks = find_looks(session, located, scene, CONFIG)
    bare = find_looks(session, located, scene, replace(CONFIG, offset_mode=OffsetMode.OFF))
    true = score().World(folder / "truth")
    given = np.array([looks.offset.azimuth_rad, looks.offset.elevation_rad])
    focal_px = located.slam.camera.K[0, 0]
    bias_rad = np.array(true.truth["gaze_bias_px"]) / focal_px * [1, -1]
    inside, sigmas, mapping, gaze = [], [], [], []
    for look, point in pairs(true, looks):
        away = look.point_world - point
        inside.append(bool(away @ np.linalg.solve(look.cov_world, away) < chi2.ppf(0.95, 3)))
        sigmas.append(float(np.sqrt(np.linalg.eigvalsh(look.cov_world)[-1])))
        gaze.append(float(np.linalg.norm(away)))
        seen = true.hit_pixel(true.seconds(look.fixation.mid_ns), tuple(look.scene_uv_px))
        if seen is not None:
            mapping.append(float(np.linalg.norm(look.point_world - seen)))
    return Outcome(
        looks=len(true.truth["fixations"]),
        is_inside=tuple(inside),
        sigmas_m=tuple(sigmas),
        mapping_m=tuple(mapping),
        gaze_m=tuple(gaze),
        uncorrected_m=tuple(
            float(np.linalg.norm(look.point_world - point)) for look, point in pairs(true, bare)
        ),
        offset_deg=float(np.degrees(np.linalg.norm(bias_rad))),
        left_deg=float(np.degrees(np.linalg.norm(bias_rad - given * looks.offset.is_applied))),
        start=found([o.track[0] for o in scene.objects if o.track], true.start),
        end=found([o.track[-1] for o in scene.objects if o.track], true.end),
    )


def pairs(true, looks):
    """Return cast fixations with the points on the table that were truly looked at."""
    cast = {look.fixation.fixation_id: look for look in looks.fixations}
    both = []
    for fixation in true.truth["fixations"]:
        look = cast.get(fixation["id"])
        middle_s = true.seconds((fixation["start_ns"] + fixation["end_ns"]) // 2)
        point = true.hit_point(middle_s, fixation["point"])
        if look is not None and look.point_world is not None and point is not None:
            both.append((look, point))
    return both


def found(states, poses) -> Found:
    """Compare resting places with the true poses, each used once, as the shared scoring does."""
    have, used, errors = [s.T_world_body.t for s in states], set(), []
    for pose in poses:
        near = [
            (float(np.linalg.norm(at - pose[:3, 3])), j)
            for j, at in enumerate(have)
            if j not in used
        ]
        if near and min(near)[0] < _NEAR_M:
            errors.append(min(near)[0])
            used.add(min(near)[1])
    return Found(
        errors_m=tuple(errors), missed=len(poses) - len(errors), false=len(have) - len(used)
    )


def score():
    """Return the shared scoring as a module."""
    spec = importlib.util.spec_from_file_location("score", SCORE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def silent(stage, done, total):
    """Take a report and do nothing."""


def line(outcome: Outcome) -> str:
    """Return one session's figures."""
    things = ", ".join(
        f"{name} {1e3 * np.median(each.errors_m):.1f} mm -{each.missed} +{each.false}"
        for name, each in (("start", outcome.start), ("end", outcome.end))
    )
    mapping, gaze, bare, sigma = (
        1e3 * np.median(each)
        for each in (outcome.mapping_m, outcome.gaze_m, outcome.uncorrected_m, outcome.sigmas_m)
    )
    return (
        f"inside {np.mean(outcome.is_inside):.3f} of {len(outcome.is_inside)}/{outcome.looks}, "
        f"sigma {sigma:.1f} mm, mapping {mapping:.1f} / "
        f"{1e3 * np.quantile(outcome.mapping_m, 0.95):.1f} mm, "
        f"gaze {gaze:.1f} (off {bare:.1f}) mm, "
        f"offset {outcome.offset_deg:.2f} left {outcome.left_deg:.2f} deg; {things}"
    )


def summary(outcomes: list[Outcome]) -> str:
    """Return what all sessions have in common."""
    inside = np.concatenate([each.is_inside for each in outcomes])
    mapping = np.concatenate([each.mapping_m for each in outcomes])
    left = [each.left_deg for each in outcomes]
    sigma = [np.median(each.sigmas_m) for each in outcomes]
    gain = [np.median(each.gaze_m) / np.median(each.uncorrected_m) for each in outcomes]
    things = [
        f"{name}: {1e3 * np.median(np.concatenate([e.errors_m for e in each])):.1f} mm, "
        f"missed {sum(e.missed for e in each)}, false {sum(e.false for e in each)}"
        for name, each in (
            ("start", [e.start for e in outcomes]),
            ("end", [e.end for e in outcomes]),
        )
    ]
    return (
        f"{len(outcomes)} sessions: inside {inside.mean():.3f} of {len(inside)}; sigma "
        f"{1e3 * np.median(sigma):.1f} mm (largest {1e3 * max(sigma):.1f}); mapping "
        f"{1e3 * np.median(mapping):.1f} / {1e3 * np.quantile(mapping, 0.95):.1f} mm; left "
        f"{np.median(left):.2f} deg, {max(left):.2f} at most; gaze with over without correction "
        f"{np.median(gain):.2f}; {'; '.join(things)}"
    )


def main() -> None:
    """Draw, map and compare; print."""
    root, first, count = Path(sys.argv[1]), *(int(a) for a in [*sys.argv[2:4], 0, 30][:2])
    outcomes = []
    for n in range(first, first + count):
        folder = root / f"{n:02d}"
        if not folder.exists():
            build_session(folder, drawn(n))
        outcomes.append(measured(folder))
        sys.stdout.write(f"{n} {line(outcomes[-1])}\n")
        sys.stdout.flush()
    sys.stdout.write(f"{summary(outcomes)}\n")


if __name__ == "__main__":
    main()
