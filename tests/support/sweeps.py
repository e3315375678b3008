"""Contact forces along a way of the wheel, and their jumps."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from support.contacts import PLAIN, bench, contact_of, pair_model, settle

STEP = 10e-6
HALVINGS = 12  # to 2.4 nm


def jumps(pair, yaw, load, span, most=15, **choices):
    """(lateral shift, largest jump of a force component over the load) at the steepest places of a sweep."""
    stand = bench(pair_model(pair, **choices))
    knots = np.arange(span[0], span[1] + 1e-9, 2.5e-4)
    path = PchipInterpolator(knots, [settle(stand, y, yaw, load)[0].height for y in knots])

    def force(y):
        stand.evaluate(y, float(path(y)), yaw, 0.0)
        return stand.force / load

    return steepest(force, np.arange(knots[0], knots[-1], STEP), most)


def steepest(force, xs, most, values=None):
    """(place, change) of a function of one number at its steepest places, halved until a jump is left.

    values: its values at ``xs``, where they are known."""
    values = [force(x) for x in xs] if values is None else values
    change = np.abs(np.diff(values, axis=0)).max(axis=1)
    usual = np.array([np.median(change[max(0, i - 4) : i + 5]) for i in range(len(change))])
    rows = []
    for i in np.argsort(usual - change)[:most]:
        left, right = xs[i], xs[i + 1]
        at_left, at_right = force(left), force(right)
        for _ in range(HALVINGS):
            middle = 0.5 * (left + right)
            between = force(middle)
            if np.abs(between - at_left).max() > np.abs(at_right - between).max():
                right, at_right = middle, between
            else:
                left, at_left = middle, between
        rows.append((left, np.abs(at_right - at_left).max()))
    return np.array(rows)


def normal_forces(pair, lateral, yaw, depths, **choices):
    """Sum of N over the wheel's descent below its touching height."""
    stand = bench(pair_model(pair, **PLAIN, **choices), rolling=False)
    touching = settle(stand, lateral, yaw, 10.0)[0].height
    forces = []
    for depth in depths:
        stand.evaluate(lateral, touching - depth, yaw, 0.0)
        forces.append(contact_of(stand).patches["N"].sum())
    return np.array(forces)
