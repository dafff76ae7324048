"""Loading and checking of calibrations; the numbers live in /calib."""
