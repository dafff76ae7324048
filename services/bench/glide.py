"""GLIDE: what exact inference costs, beside the paper's sampling, and drawn scenes to try it on."""

from dataclasses import dataclass

import numpy as np

from grounding.glide.config import GlideConfig
from grounding.glide.dirichlet import infer_sampled
from grounding.glide.exact import infer
from grounding.glide.model import Demonstration, initial_parameters, session_of
from grounding.glide.tables import build
from grounding.types import (
    Action,
    FixationObservation,
    FloatArray,
    Instruction,
    ObjectInstance,
    RestingPlace,
    SpokenInstruction,
)
from services.bench.figures import Figure, median_ms

_TABLE = np.array([0.45, 0.25])  # half sides, metres
_HEIGHT_M = 0.02
_LOOK_S = 0.3
_SACCADE_S = 0.05
_Stay = tuple[float, float | None, FloatArray]  # from, until, where


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneConfig:
    """A drawn demonstration of picking and placing.

    Attributes:
        pairs: pick-and-place pairs; each is two instructions.
        things: on the table.
        sigma_m: of a look, in the table's plane.
        outliers: share of looks within an action that go anywhere.
        looks: mean number of looks in one action.
        motion: whether vision saw the things move.
        times: whether the narration has times.
    """

    pairs: int = 4
    things: int = 8
    sigma_m: float = 0.015
    outliers: float = 0.15
    looks: int = 6
    motion: bool = False
    times: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scene:
    """A drawn demonstration and its truth.

    Attributes:
        demonstration: what is observed.
        labels: the instruction of each look, or None.
        things: the instance that each instruction is about.
    """

    demonstration: Demonstration
    labels: tuple[int | None, ...]
    things: tuple[str, ...]


class _Person:
    """Looks at places in turn and writes down when."""

    def __init__(self, config: SceneConfig, rng: np.random.Generator) -> None:
        self._config, self._rng = config, rng
        self.now_s = 0.0
        self.looks: list[FixationObservation] = []
        self.labels: list[int | None] = []

    def act(self, instruction: int, place: FloatArray, landmark: FloatArray | None = None) -> None:
        """Look at a place, now and then at its landmark or anywhere."""
        for _ in range(int(self._rng.integers(self._config.looks - 2, self._config.looks + 3))):
            chance = self._rng.random()
            if chance < self._config.outliers:
                self.idle(1)
            elif landmark is not None and chance > 0.85:
                self._look(landmark, instruction)
            else:
                self._look(place, instruction)

    def idle(self, count: int) -> None:
        """Look anywhere."""
        for _ in range(count):
            self._look(_anywhere(self._rng), None)

    def _look(self, at: FloatArray, label: int | None) -> None:
        sigma = self._config.sigma_m
        noise = np.append(self._rng.normal(0.0, sigma, 2), 0.0)
        self.looks.append(
            FixationObservation(
                fixation_id=len(self.looks),
                start_ns=round(self.now_s * 1e9),
                end_ns=round((self.now_s + _LOOK_S) * 1e9),
                point_world=at + noise,
                cov_world=np.diag([sigma**2, sigma**2, 1e-6]),
            )
        )
        self.labels.append(label)
        self.now_s += _LOOK_S + _SACCADE_S


def draw_scene(config: SceneConfig, rng: np.random.Generator) -> Scene:
    """Draw things on a table and a person who picks and places some of them."""
    homes = _apart(config.things, rng)
    tracks: list[list[_Stay]] = [[(0.0, None, p)] for p in homes]
    person, spoken, things = _Person(config, rng), [], []
    person.idle(int(rng.integers(1, 5)))
    order = rng.permutation(config.things)
    for k in range(config.pairs):
        thing, landmark = int(order[k % config.things]), int(order[(k + 1) % config.things])
        since, _, home = tracks[thing][-1]
        goal = tracks[landmark][-1][2] + np.array([-0.1, 0.0, 0.0])
        spoken.append(_said(2 * k, thing, None, person.now_s if config.times else None))
        person.act(2 * k, home)
        tracks[thing][-1] = (since, person.now_s - 0.2, home)
        person.idle(int(rng.integers(0, 2)))
        spoken.append(_said(2 * k + 1, thing, landmark, person.now_s if config.times else None))
        person.act(2 * k + 1, goal, tracks[landmark][-1][2])
        tracks[thing].append((person.now_s - 0.3, None, goal))
        person.idle(int(rng.integers(1, 4)))
        things += [f"object-{thing}"] * 2
    still: list[list[_Stay]] = [[(0.0, None, p)] for p in homes]
    seen = tracks if config.motion else still
    demonstration = Demonstration(
        spoken=spoken,
        fixations=person.looks,
        objects=[_instance(i, track) for i, track in enumerate(seen)],
        table_height=0.0,
    )
    return Scene(demonstration=demonstration, labels=tuple(person.labels), things=tuple(things))


def run() -> list[Figure]:
    """Measure exact inference against its two sizes, and the paper's sampling beside it."""
    figures = [_exact(pairs=20, looks=500), _exact(pairs=20, looks=250)]
    figures += [_exact(pairs=10, looks=500), _exact(pairs=5, looks=500)]
    return figures


def _exact(*, pairs: int, looks: int) -> Figure:
    config = GlideConfig()
    scene = draw_scene(
        SceneConfig(pairs=pairs, looks=max(3, looks // (2 * pairs) - 1), motion=True, times=True),
        np.random.default_rng(1),
    )
    session = session_of(scene.demonstration, config)
    parameters = initial_parameters(session, config)
    model = build(session, parameters, config)
    rng = np.random.default_rng(0)
    infer_sampled(session, model, parameters, config, rng=rng)
    infer(session, model)
    return Figure(
        name=f"exact, {session.sights.count} looks, {2 * pairs} instructions",
        value=median_ms(lambda: infer(session, model), repeats=7),
        unit="ms CPU",
        peer=f"Dirichlet, {config.samples} samples",
        peer_value=median_ms(
            lambda: infer_sampled(session, model, parameters, config, rng=rng), repeats=3
        ),
    )


def _anywhere(rng: np.random.Generator) -> FloatArray:
    return np.append(rng.uniform(-_TABLE, _TABLE), _HEIGHT_M)


def _apart(count: int, rng: np.random.Generator) -> list[FloatArray]:
    """Draw places that are at least 9 cm apart."""
    places: list[FloatArray] = []
    while len(places) < count:
        place = _anywhere(rng) * [0.85, 0.85, 1.0]
        if all(np.linalg.norm(place - other) > 0.09 for other in places):
            places.append(place)
    return places


def _said(index: int, thing: int, landmark: int | None, at_s: float | None) -> SpokenInstruction:
    target = (f"word{thing}", "thing")
    own = "-".join(target) + "-location"
    return SpokenInstruction(
        index=index,
        sentence="",
        instruction=Instruction(
            action=Action.PICK if landmark is None else Action.PLACE,
            target=target,
            location=own if landmark is None else f"to-left-of-word{landmark}-thing",
        ),
        said_start_ns=None if at_s is None else round(at_s * 1e9),
        said_end_ns=None if at_s is None else round((at_s + 1.0) * 1e9),
    )


def _instance(number: int, track: list[_Stay]) -> ObjectInstance:
    return ObjectInstance(
        object_id=f"object-{number}",
        size_m=np.full(3, 2 * _HEIGHT_M),
        track=tuple(
            RestingPlace(
                t_ns=round(since * 1e9),
                left_ns=None if left is None else round(left * 1e9),
                position_world=place,
                quat_xyzw=np.array([0.0, 0.0, 0.0, 1.0]),
                cov_world=np.eye(3) * 0.003**2,
            )
            for since, left, place in track
        ),
    )
