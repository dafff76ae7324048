"""Both pipelines over a recording, stage by stage, resumable; no network."""
