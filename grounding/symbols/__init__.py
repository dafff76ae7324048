"""What each word means, learnt from a few noisy patches."""
