"""Fixtures that tests of several packages share."""

import pytest
from hypothesis import HealthCheck, settings

from tests.builders import SimulatedSession, build_session, small_config

# Slow machines are no bugs, and the same tests are run everywhere.
settings.register_profile(
    "gazemap",
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("gazemap")


@pytest.fixture(scope="session")
def small_session(tmp_path_factory: pytest.TempPathFactory) -> SimulatedSession:
    """Return an easy session of 8 s at 480 x 360: nobody may change its files."""
    return build_session(tmp_path_factory.mktemp("small"), small_config())
