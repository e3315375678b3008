"""Sliders: springs of a finite stiffness behind a surface that slips, the friction of suspension elements.

A slider's spring is stretched by z = e - x: the travel e less the slip x, an unknown that the solver integrates with
everything else (as it does the extension of a damper behind a spring). The force k z never leaves the bound F.

- COULOMB: elastic-plastic, along one direction or in a plane. With the unit vector n along z

      x_t = share (n.e_t)+ n,   share = 0 for k |z| < STUCK F, rising evenly to 1 at k |z| = F.

  Below STUCK F it sticks and does not creep, back from any force it is elastic, and in steady slip the force is F
  against the velocity. No rate comes in: nothing gets stiffer at low speed. After Dupont, Hayward, Armstrong and
  Altpeter, "Single state elastoplastic friction models", IEEE Trans. Automatic Control 47 (2002) 787, with an even
  rise; in a plane the bound is a circle and the slip goes along its normal.
- FANCHER: x_t = |e_t| z k / F. The force tends to F over the distance F / k, as a leaf spring's to its envelopes:
  Fancher, Ervin, MacAdam and Winkler, SAE 800905 (1980). The same as Dahl's friction of exponent 1.
- BERG: with the force f_s and the travel e_s of the last return, x2 = F / k,

      f = f_s + (e - e_s) (F - f_s) / (x2 (1 - f_s / F) + e - e_s)

  on the way up, and mirrored on the way down: Berg, "A non-linear rubber spring model for rail vehicle dynamics
  analysis", Vehicle System Dynamics 30 (1998) 197. Its rate form is z_t = e_t ((x2 - z)/(x2 - z_s))^2. The returns z_s
  of either way are two unknowns more: each follows z while the other way is gone, over a distance of MEMORY x2, and
  rests on its own way. So the law is Berg's for strokes of some MEMORY x2 and longer.

Where the bound falls below the force (the normal force falls) the force falls with it, and the slip takes up the rest
within some SETTLING. All of these take power: force times rate of travel less the rate of k z^2/2 is nowhere negative,
but for a little of BERG's on the way back from a return, where it yields before its force has turned.

"Relaxed" is a slider that went straight to where it is: FRESH from the design position, where it had no force, on its
law's own line; HELD from the slip that it has, elastic up to its bound: a state within the bound stays what it is.
"""

from math import exp

from wrsim.jit import Array, Record, inlined, kernel
from wrsim.jit.linalg import ZERO, Vec, dot, norm, scale, shifted, sub

NO_SLIDER, COULOMB, FANCHER, BERG = range(4)
MOVING, FRESH, HELD = range(3)

STUCK = 0.8
"""Part of the bound up to which a COULOMB slider sticks."""

SETTLING = 1e-3
"""Time in which the slip takes up what lies beyond the bound [s]."""

MEMORY = 0.05
"""Distance over which a return is forgotten, as a part of Berg's x2."""

SMALLEST = 1e-12
"""Shortest extension that has a direction [m]."""


@kernel
def slide(element: Record, bound: float, z: Vec, v: Vec) -> tuple[Vec, Vec, float]:
    """Pull of a slider of the kinds COULOMB and FANCHER against the travel [N], the rate of its slip [m/s], and what
    friction and damping take [W]. element: a record ELEMENT; bound [N]; z: extension of its spring [m]; v: rate of the
    travel [m/s]; both vectors.

    What the pull does on the slip is taken, not what the spring would: beyond the bound there is no such force. What a
    spring holds there, F^2 / 2 k at the most, is lost with the bound and not counted."""
    k, size = element.stick, norm(z)
    slip = ZERO
    if size > SMALLEST:
        force = k * size
        first = STUCK if element.slider == COULOMB else 0.0
        share = 1.0 if force >= bound else max(0.0, (force / bound - first) / (1.0 - first))
        way = norm(v) if element.slider == FANCHER else max(0.0, dot(z, v) / size)
        slip = scale((share * way + max(0.0, force - bound) / (k * SETTLING)) / size, z)
    rate = sub(v, slip)
    pull = shifted(scale(k, z), element.stick_damping, rate)
    size = norm(pull)
    held = bound / size if size > bound else 1.0
    return scale(held, pull), slip, held * (dot(pull, slip) + element.stick_damping * dot(rate, rate))


@kernel
def relaxed_force(element: Record, bound: float, z: Vec) -> Vec:
    """Pull of a relaxed slider after the travel z from where it began [m], both vectors."""
    k, size = element.stick, norm(z)
    if size < SMALLEST or bound <= 0.0:
        return ZERO
    part = k * size / bound
    if element.relaxed == HELD:
        force = min(part, 1.0)
    elif element.slider == BERG:
        force = part / (1.0 + part)
    else:
        first = STUCK if element.slider == COULOMB else 0.0
        force = part if part < first else 1.0 - (1.0 - first) * exp(-(part - first) / (1.0 - first))
    return scale(bound * force / size, z)


@inlined
def follow_strokes(element: Record, bound: float, e: float, v: float, inner: Array, inner_t: Array) -> float:
    """Pull of a BERG slider against the travel e [m] at the rate v [m/s]; its unknowns as in ``suspension_forces``."""
    first, x2 = element.slip, bound / element.stick
    z, bottom, top = e - inner[first], inner[first + 1], inner[first + 2]
    z = min(max(z, -x2), x2)
    z_t = v
    room = x2 - bottom if v > 0.0 else x2 + top
    if room > SMALLEST:
        part = (x2 - z if v > 0.0 else x2 + z) / room
        z_t = v * part * part
    inner_t[first] = v - z_t
    forget = abs(v) / (MEMORY * x2)
    inner_t[first + 1] = 0.0 if v > 0.0 else z_t + forget * (z - bottom)
    inner_t[first + 2] = z_t + forget * (z - top) if v > 0.0 else 0.0
    return element.stick * z


@kernel
def slider_force(element: Record, bound: float, e: float, v: float, inner: Array, inner_t: Array) -> float:
    """Pull of a slider in one direction against the travel e [m] at the rate v [m/s]. Adds what friction takes to the
    element's loss. inner, inner_t: the slider's unknowns, and where their rates go; of a relaxed slider the unknowns
    where it has come to go there."""
    first = element.slip
    if element.relaxed != MOVING:
        force = relaxed_force(element, bound, Vec(e - inner[first], 0.0, 0.0)).x
        z = force / element.stick
        inner_t[first] = e - z
        if element.slider == BERG:
            inner_t[first + 1] = min(z, inner[first + 1])
            inner_t[first + 2] = max(z, inner[first + 2])
        return force
    if element.slider == BERG:
        force = follow_strokes(element, bound, e, v, inner, inner_t)
        element.loss += force * inner_t[first]
        return force
    z = e - inner[first]
    pull, slip, loss = slide(element, bound, Vec(z, 0.0, 0.0), Vec(v, 0.0, 0.0))
    inner_t[first] = slip.x
    element.loss += loss
    return pull.x
