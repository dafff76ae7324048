"""Live tracking and mapping: causal, frame by frame, with the mapping in a process of its own."""
