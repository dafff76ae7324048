"""Patches that the product's own simulator did not draw: ray-cast solids on other tables."""
