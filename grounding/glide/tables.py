"""From a session and its parameters to the factors of the semi-Markov model."""

from dataclasses import dataclass

import numpy as np

from grounding.glide import priors
from grounding.glide.config import GlideConfig
from grounding.glide.emissions import (
    look_tables,
    moving,
    part_weights,
    place_ratio,
    popularity,
)
from grounding.glide.grid import Unseen, unseen_positions
from grounding.glide.kernels import Tables
from grounding.glide.landmarks import landings, landmark_shares
from grounding.glide.model import Parameters, Session, present
from grounding.types import FloatArray

_SLACK_S = 0.5
_UNSAID = 0.5  # of the looks while something moves, where more moved than was spoken of


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Model:
    """The factors, and what they were made of, to read the posterior with.

    Attributes:
        tables: the factors.
        popular: (T,) density of a look at any thing over that of a look anywhere.
        ratio: (T, R) density of each look for each resting place over that of the background.
        landmark: (A, H, T) the same for the mixture over each action's landmarks.
        landmark_share: (A, H, R) the mixture's weights before time decides which place is taken.
        present: (T, R) whether the place was taken at the look's time.
        weights: (A, 3, 3) for each third of an action: of the target, the location, the landmark.
        unseen: the grids of positions where there is no instance.
    """

    tables: Tables
    popular: FloatArray
    ratio: FloatArray
    landmark: FloatArray
    landmark_share: FloatArray
    present: FloatArray
    weights: FloatArray
    unseen: Unseen


def build(
    session: Session, parameters: Parameters, config: GlideConfig, *, open_end: bool = False
) -> Model:
    """Compute every factor of the model, eq. 1 to 11.

    Args:
        session: what was observed.
        parameters: what was learnt so far.
        config: the constants.
        open_end: the session goes on: actions may not have happened yet.

    Returns:
        The model; hypotheses are the resting places and, last, "elsewhere".
    """
    anywhere = place_ratio(session, parameters, config)
    taken = present(session, session.sights.mid_s, slack_s=_SLACK_S).astype(np.float64)
    popular = popularity(session, anywhere, taken)
    background = 1.0 + parameters.popular_share * (popular - 1.0)  # eq. 1
    unsaid = _UNSAID if session.unsaid_share else 0.0
    calm = 1.0 / (background * (1.0 - unsaid) + moving(session, anywhere) * unsaid)
    ratio = anywhere * calm[:, None]
    share = landmark_shares(session, parameters, config)
    landmark = np.einsum("ahr,tr->aht", share, ratio * taken)
    weights = part_weights(session, config)
    unseen = unseen_positions(session, parameters, config, parts=(weights, landmark, calm))
    return Model(
        tables=_tables(
            session,
            parameters,
            config,
            looks=look_tables(session, ratio, landmark, weights),
            unseen=unseen,
            open_end=open_end,
        ),
        popular=popular,
        ratio=ratio,
        landmark=landmark,
        landmark_share=share,
        present=taken,
        weights=weights,
        unseen=unseen,
    )


def _tables(
    session: Session,
    parameters: Parameters,
    config: GlideConfig,
    *,
    looks: FloatArray,
    unseen: Unseen,
    open_end: bool,
) -> Tables:
    duration, cuts = priors.durations(session, parameters, config, open_end=open_end)
    longest = duration.shape[2] - 1
    stay, leave = priors.gaps(session, parameters)
    start = priors.starts(session, parameters, config)
    end = priors.ends(session, parameters, config, open_end=open_end)
    end[:, :-1] += landings(session, parameters, config)[..., None]
    return Tables(
        kind=np.array([act.kind for act in session.acts], dtype=np.int64),
        in_hand=np.array([act.in_hand for act in session.acts], dtype=np.int64),
        is_level=np.all(looks[:, :, :1] == looks, axis=(1, 2, 3)).astype(np.int64),
        log_theta=priors.log_theta(session, parameters, config),
        start=priors.without_dead_ends(start, end, longest=longest),
        end=end,
        duration=duration,
        cuts=cuts,
        looks=looks,
        grid_row=unseen.row,
        grid=unseen.segments(longest=longest),
        stay=stay,
        leave=leave,
        skip=priors.skips(session, config, open_end=open_end),
    )
