"""Ranges of random phantoms with nodules, each with its source, fixed before any detector was judged on them.

Sources: [1] Samani et al. 2007, 169 samples of breast: normal tissue about 3 kPa, benign tumours twice, carcinoma 3 to
13 times as stiff; [2] Krouskop et al. 1998: fat of the breast about 20 kPa, carcinoma more than ten times as stiff
under compression; [3] silicone breasts for training have lumps of 3 to 10 mm, and stage T1 of tumours ends at 20 mm;
[4] recorded robot presses on silicone, meat and pig liver: depths of 2 and 3 mm, force noise 7 to 54 mN, exponents 1.2
to 3.3; [5] Kaneko & Horie 2012, 100 resting persons: the abdominal wall moves by about 10 mm; [6] reviews of the
friction of skin (Derler & Gerhardt 2012): about 0.2 to 0.6 dry, less where lubricated. What has no source is a
choice, marked [c].
"""

from dataclasses import dataclass

Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Ranges:
    """Lowest and highest value of each drawn quantity.

    Attributes:
        size_mm: diameter of a nodule, which is a sphere; logarithmic.
        depth_mm: tissue between the surface and the nodule's top; logarithmic.
        ratio: Young's modulus of the nodule over that of its surroundings; logarithmic.
        nodules: share of phantoms with no, one and two nodules.
        side_mm: side of the square that is pressed.
        margin_mm: least distance of a nodule's centre from the edge of the square.
        apart_mm: least gap between two nodules.
        layer_mm: thickness of the soft layer over its rigid base.
        beneath_mm: least tissue between a nodule and the base.
        ground_kpa: Young's modulus of the tissue at a depth of 2 mm; logarithmic.
        ground_sd: standard deviation of the natural variation of ln(stiffness) over the surface.
        ground_length_mm: correlation length of this variation, of a squared-exponential field.
        exponent: exponent of force over depth on tissue without a nodule.
        tilt_deg: angle between the surface's normal and the direction of the presses.
        breath_mm: amplitude of the surface's motion left by the tracking of the hand or by a held breath.
        breaths_per_min: rate of breathing.
        friction: coefficient of friction between probe and surface; logarithmic.
        force_noise_n: standard deviation of a force reading, white; logarithmic.
        place_noise_mm: standard deviation of the stated place of a press, along x and along y.
        depth_noise_mm: standard deviation of a depth reading, white.
        probe_mm: radius of the spherical probe.
        press_mm: largest depth of a press.
        presses_a_side: presses along one side of the raster, one of these with equal chance.
    """

    size_mm: Range = (4.0, 20.0)  # [3]
    depth_mm: Range = (2.0, 15.0)  # [c], skin to the middle of a breast
    ratio: Range = (1.3, 20.0)  # [1] [2]
    nodules: tuple[float, float, float] = (0.2, 0.4, 0.4)  # [c]
    side_mm: float = 70.0  # [c]
    margin_mm: float = 8.0  # [c]
    apart_mm: float = 8.0  # [c]
    layer_mm: Range = (20.0, 60.0)  # [c], over rib or muscle
    beneath_mm: float = 3.0  # [c]
    ground_kpa: Range = (5.0, 40.0)  # [1] [2]
    ground_sd: Range = (0.02, 0.15)  # [4] [c]
    ground_length_mm: Range = (10.0, 30.0)  # [c]
    exponent: Range = (1.2, 3.0)  # [4]
    tilt_deg: Range = (0.0, 15.0)  # [c]; the normal is measured, [4] has up to 55
    breath_mm: Range = (0.0, 0.5)  # [5], less than a tenth of it remains [c]
    breaths_per_min: Range = (12.0, 20.0)  # [c], resting adults
    friction: Range = (0.05, 0.6)  # [6]
    force_noise_n: Range = (0.005, 0.05)  # [4]
    place_noise_mm: Range = (0.1, 0.5)  # [c], calibrated robot to tracked hand
    depth_noise_mm: Range = (0.005, 0.05)  # [c]
    probe_mm: Range = (4.0, 8.0)  # [c], fingertip
    press_mm: Range = (2.0, 4.0)  # [4]
    presses_a_side: tuple[int, ...] = (7, 10, 13)  # [c]


RANGES = Ranges()
"""The ranges of all phantoms."""
DEPTH_STEPS = 8
"""Readings of a press, at equal steps of depth."""
STEP_S = 0.1
"""Time between two readings of a press, s."""
PRESS_S = 1.5
"""Time from one press to the next, s."""
CONTACT_N = 0.075
"""Force at which depth counts as 0, N, as in the recorded presses."""
FORCE_LIMIT_N = 5.0
"""Force at which a press ends, N: the patient gate's limit."""

DEPTH_EDGES_MM = (2.0, 4.0, 8.0, 15.0)
"""Edges of the judged cells in depth of the nodule's top, mm."""
SIZE_EDGES_MM = (4.0, 7.0, 12.0, 20.0)
"""Edges of the judged cells in diameter, mm."""
RATIO_EDGES = (1.3, 3.2, 8.0, 20.0)
"""Edges of the judged cells in stiffness ratio."""
PHANTOMS = 500
"""Judged phantoms; all are reported."""
