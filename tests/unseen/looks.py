"""Looks to measure under: each moves away from the sample in its own way."""

from tests.unseen.render import Look

WARM, COOL, GREENISH = (0.70, 0.92, 1.10), (1.18, 1.0, 0.82), (0.92, 1.06, 0.95)

LOOKS = {
    "as the sample": Look(),
    "walnut, warm": Look(table="walnut", tint_bgr=WARM, sun_deg=(30, 45)),
    "birch, cool": Look(table="birch", tint_bgr=COOL, sun_deg=(200, 55)),
    "planks, hard shadow": Look(table="planks", softness=0.01, ambient=0.25, sun_deg=(300, 38)),
    "black, dim": Look(table="black", light=0.35, noise=4.0),
    "walnut, dark and noisy": Look(table="walnut", light=0.22, noise=6.0, jpeg=80),
    "grey, plain": Look(table="grey", sun_deg=(80, 70)),
    "white, bright": Look(table="white", light=1.25, gloss=0.25),
    "white, half light": Look(table="white", light=0.5, tint_bgr=WARM),
    "steel, glossy": Look(table="steel", gloss=0.5, sun_deg=(150, 75), softness=0.1),
    "teal, cool": Look(table="teal", tint_bgr=COOL),
    "granite": Look(table="granite", noise=3.5),
    "terrazzo": Look(table="terrazzo", light=0.8),
    "marble, greenish": Look(table="marble", tint_bgr=GREENISH),
    "linen, low sun": Look(table="linen", sun_deg=(10, 28), ambient=0.35),
    "gingham": Look(table="gingham", light=0.9),
    "checks": Look(table="checks", light=0.9),
    "mat": Look(table="mat", sun_deg=(250, 50)),
    "oak, noise and artefacts": Look(noise=9.0, jpeg=55),
    "oak, blurred": Look(blur_px=1.8, noise=3.0),
    "birch, small patches": Look(table="birch", side_px=72, mm_per_px=1.8, noise=3.0),
    "walnut, large patches": Look(table="walnut", side_px=288, mm_per_px=0.45),
    "oak, camera aside": Look(aside_mm=420, height_mm=1100),
    "grey, camera tilted": Look(table="grey", tilt_deg=28, aside_mm=100, height_mm=900),
    "black, close camera": Look(table="black", height_mm=600, reach_mm=180, light=0.7),
    "oak, unsteady light": Look(flicker=0.4, ambient=0.3),
}
