"""What is installed, what is missing, and what to do about it."""

import ctypes
import importlib.metadata
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

_PACKAGES = (
    "pycolmap",
    "open3d-cpu",
    "gtsam",
    "opencv-python-headless",
    "numpy",
    "scipy",
    "numba",
    "av",
    "eclipse-zenoh",
    "mcap",
    "pydelphin",
)
_MEMORY_WANTED_GB = 4.0
_CORES_WANTED = 2
# What open3d links against; libusb comes with a package of ours where the system has none.
_SYSTEM_LIBRARIES = {"libGL.so.1": "libgl1", "libEGL.so.1": "libegl1", "libX11.so.6": "libx11-6"}
_PROBE_TIMEOUT_S = 120
_OPEN3D_PROBE = (
    "import ctypes, libusb_package as u;"
    "ctypes.CDLL(str(u.get_library_path()), ctypes.RTLD_GLOBAL);"
    "import open3d"
)


class Verdict(StrEnum):
    """How a finding bears on the system."""

    OK = "ok"
    OPTIONAL = "optional"
    MISSING = "missing"


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One thing that was looked at; `todo` is empty where nothing is to be done."""

    name: str
    verdict: Verdict
    found: str
    todo: str = ""


def examine() -> Iterator[Finding]:
    """Yield a finding for everything that gazemap uses on this machine."""
    yield _python()
    yield from (_package(name) for name in _PACKAGES)
    yield from (_library(name, package) for name, package in _SYSTEM_LIBRARIES.items())
    yield _open3d()
    yield _cores()
    yield _memory()
    yield from _parsers()


def _python() -> Finding:
    good = sys.version_info >= (3, 11)
    verdict = Verdict.OK if good else Verdict.MISSING
    todo = "" if good else "install Python 3.11 or newer and run `make setup PYTHON=...`"
    return Finding(name="Python", verdict=verdict, found=platform.python_version(), todo=todo)


def _package(name: str) -> Finding:
    try:
        version = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return Finding(name=name, verdict=Verdict.MISSING, found="absent", todo="run `make setup`")
    return Finding(name=name, verdict=Verdict.OK, found=version)


def _library(name: str, package: str) -> Finding:
    try:
        ctypes.CDLL(name)
    except OSError:
        todo = f"if open3d does not import: apt-get install {package}"
        return Finding(name=name, verdict=Verdict.OPTIONAL, found="absent", todo=todo)
    return Finding(name=name, verdict=Verdict.OK, found="present")


def _open3d() -> Finding:
    """Import it in a process of its own: a missing library may end the process that tries."""
    todo = "apt-get install libgl1 libegl1 libx11-6 libusb-1.0-0"
    try:
        probe = subprocess.run(  # noqa: S603  our own interpreter and a constant
            [sys.executable, "-c", _OPEN3D_PROBE],
            capture_output=True,
            text=True,
            check=False,
            timeout=_PROBE_TIMEOUT_S,
        )
    except subprocess.TimeoutExpired:
        late = f"not within {_PROBE_TIMEOUT_S} s"
        return Finding(name="open3d imports", verdict=Verdict.MISSING, found=late, todo=todo)
    if probe.returncode == 0:
        return Finding(name="open3d imports", verdict=Verdict.OK, found="yes")
    last = (probe.stderr.strip().splitlines() or ["no message"])[-1]
    return Finding(name="open3d imports", verdict=Verdict.MISSING, found=last, todo=todo)


def _cores() -> Finding:
    count = len(os.sched_getaffinity(0))
    if count >= _CORES_WANTED:
        return Finding(name="cores", verdict=Verdict.OK, found=str(count))
    todo = "give it two cores, or replay slower than real time"
    return Finding(name="cores", verdict=Verdict.OPTIONAL, found=str(count), todo=todo)


def _memory() -> Finding:
    gigabytes = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9
    found = f"{gigabytes:.1f} GB"
    if gigabytes >= _MEMORY_WANTED_GB:
        return Finding(name="memory", verdict=Verdict.OK, found=found)
    todo = f"long sessions want {_MEMORY_WANTED_GB:.0f} GB"
    return Finding(name="memory", verdict=Verdict.OPTIONAL, found=found, todo=todo)


def _parsers() -> Iterator[Finding]:
    yield Finding(name="parser: embedded", verdict=Verdict.OK, found="built in")
    ace = shutil.which("ace")
    todo = (
        "for the full English Resource Grammar: put `ace` (ace-0.9.34-x86-64.tar.gz from ACE's"
        " site) on the path and name the ERG image (erg-2025-x86-64-0.9.34.dat) in GAZEMAP_ERG"
    )
    if ace is None:
        yield Finding(name="parser: ace", verdict=Verdict.OPTIONAL, found="absent", todo=todo)
        return
    grammar = os.environ.get("GAZEMAP_ERG")
    if grammar and os.path.exists(grammar):  # noqa: PTH110  a plain question
        yield Finding(name="parser: ace", verdict=Verdict.OK, found=f"{ace} with {grammar}")
        return
    todo = "set GAZEMAP_ERG to the grammar image (erg-2025-x86-64-0.9.34.dat)"
    yield Finding(name="parser: ace", verdict=Verdict.OPTIONAL, found=ace, todo=todo)
