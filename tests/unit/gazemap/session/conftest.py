from pathlib import Path

import pytest

from tests.session_writer import SessionWriter


@pytest.fixture
def writer(tmp_path: Path) -> SessionWriter:
    """A session folder that holds a little of everything."""
    made = SessionWriter(path=tmp_path / "walk")
    made.write_all()
    return made
