"""The tree keeps its shape: small files, one subject each."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_no_source_file_is_longer_than_400_lines():
    listed = subprocess.run(
        ["git", "ls-files", "*.py"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    ).stdout.split()
    sources = [ROOT / name for name in listed if "generated" not in name and (ROOT / name).exists()]
    lengths = {path.name: len(path.read_text().splitlines()) for path in sources}
    assert sources
    assert {name: n for name, n in lengths.items() if n > 400} == {}
