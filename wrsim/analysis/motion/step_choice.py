"""The step that a run asks for, held against the limit of stability."""

from __future__ import annotations

from wrsim.errors import InputError


class StepTooLong(InputError):
    """The step asked for is not stable. ``rule`` says what is allowed, without file and key."""

    def __init__(self, step: float, rule: str) -> None:
        super().__init__(f"run.step_us = {1e6 * step:g}: {rule}")
        self.rule = rule


def allowed_step(step: float, limit: float, speed: float) -> float:
    """The step itself [s]. Raises StepTooLong when it is beyond the limit [s] at this speed [m/s]."""
    if step > limit:
        raise StepTooLong(
            step,
            f"must be at most {1e6 * limit:.0f}, where the integration becomes unstable at "
            f"{3.6 * speed:g} km/h; without step_us a good one is chosen",
        )
    return step
