"""summary.json: how each stage went, and what the user should know."""

from collections.abc import Mapping

import numpy as np

from gazemap.types.fixation import GazeOffset
from gazemap.types.tracking import Tracked
from services.rebuild.grounding_stage import Mapped
from services.rebuild.stages import StageReport


def summary_document(
    mapped: Mapped, reports: Mapping[str, StageReport], versions: Mapping[str, str]
) -> dict[str, object]:
    """Return the content of summary.json."""
    outcomes = mapped.located.slam.outcomes
    tracked = sum(isinstance(each, Tracked) for each in outcomes)
    return {
        "stages": {
            name: {
                "status": report.status.value,
                "messages": list(report.messages),
                "seconds": report.seconds,
            }
            for name, report in reports.items()
        },
        "frames": {"seen": len(outcomes), "tracked": tracked, "lost": len(outcomes) - tracked},
        "scale": mapped.located.slam.trajectory.scale.value,
        **_offset(mapped.looks.offset),
        "readout_s": mapped.located.slam.camera.readout_s,
        "versions": dict(versions),
    }


def _offset(offset: GazeOffset) -> dict[str, object]:
    """Return the estimate with its spread; only an applied one was taken out."""
    estimate = np.degrees([offset.azimuth_rad, offset.elevation_rad])
    sigma = np.degrees([offset.azimuth_sigma_rad, offset.elevation_sigma_rad])
    return {
        "gaze_offset_deg": estimate.round(4).tolist(),
        "gaze_offset_sigma_deg": sigma.round(4).tolist(),
        "gaze_offset_applied": offset.is_applied,
    }
