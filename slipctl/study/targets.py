"""What Sections V-A and V-B must give, as numbers to compare with.

The paper prints pictures and no table. These numbers come from its models and gains, integrated once more in
a prototype of their own under continuous control; where the paper leaves something open they belong to the
choices that the page names.
"""

from __future__ import annotations

from dataclasses import dataclass

SOURCE = "derived independently"


@dataclass(frozen=True)
class Target:
    """One number that a run should give.

    Attributes
    ----------
    case : str
        Which run: ``section/label``.
    quantity : str
        Key in the measured numbers of that run.
    value : float
    unit : str
    upper : bool
        Whether the number should stay below `value` instead of meeting it.
    source : str
    """

    case: str
    quantity: str
    value: float
    unit: str
    upper: bool = False
    source: str = SOURCE

    @property
    def tolerance(self) -> float:
        """One per cent, or half of the last digit that the target has, whichever is more."""
        digits = len(repr(self.value).partition(".")[2])
        return max(0.01 * abs(self.value), 0.5 * 10.0**-digits)

    def met(self, measured: float) -> bool:
        """Whether a measured value agrees."""
        if self.upper:
            return measured <= self.value + self.tolerance
        return abs(measured - self.value) <= self.tolerance


_QUANTITIES = (
    ("max_x", "mm"),
    ("max_y", "mm"),
    ("max", "mm"),
    ("rms", "mm"),
    ("final", "mm"),
    ("min_speed", "m/s"),
)
_ROWS = {
    "kinematic/nominal": (21.8, 31.1, 37.8, 17.3, 31.1, 0.0605),
    "kinematic/paper": (2.25, 3.27, 3.95, 0.87, 0.49, 0.0643),
    "kinematic/independent": (3.8, 5.5, 6.7, 1.40, 0.83, 0.0643),
    "kinematic/slip_ratio": (8.2, 12.0, 14.5, 3.47, 2.3, 0.0643),
    "dynamic/nominal": (66.9, 75.4, 100.4, 54.4, 8.0, 0.0630),
    "dynamic/paper": (48.5, 56.3, 74.3, 28.9, 0.16, 0.0585),
    "dynamic/proportional": (42.2, 48.9, 64.6, 22.9, 0.09, 0.0631),
}

TARGETS: tuple[Target, ...] = (
    *(
        Target(case, quantity, value, unit)
        for case, values in _ROWS.items()
        for (quantity, unit), value in zip(_QUANTITIES, values, strict=True)
    ),
    Target("kinematic/paper", "heading_offset", 0.278, "rad"),
    Target("kinematic/paper", "first_slip", 0.060, "m/s"),
    Target("kinematic/paper", "least_slip", 0.026, "m/s"),
    Target("kinematic/paper", "max_nominal_input", 0.0926, "m/s²"),
    Target("kinematic/paper", "max_robust_input", 0.78, "m/s²"),
    Target("kinematic/paper", "late_robust_input", 0.0115, "m/s²", upper=True),
    Target("dynamic/proportional", "heading_offset", 0.227, "rad"),
    Target("dynamic/proportional", "max_torque", 0.06, "N·m", upper=True),
)
"""Every target, in the order of the table."""
