"""Contacts that are too large for bodies of their size to be half-spaces."""

from math import inf, log, pi, sqrt

from contactstudy.domain.units import readable
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.shape import curvatures_of
from contactstudy.scene.solids.bodies import HalfSpace

# Largest half-width of the contact over a body's radius, and least thickness of a body over the half-width, for which
# the body counts as a half-space. At that half-width a parabola in place of a circle changes the load by 0.6 %.
LARGEST_WIDTH, LEAST_THICKNESS = 1 / 8, 4.0
# Radius of a hollow body less that of the convex body in it, over the latter, below which the two are called conforming
# and are compared with a pin in a hole.
CONFORMING_CLEARANCE = 0.2


def beyond_half_space(scene: Scene | None) -> str:
    """Return a sentence if a body is too small for its contact to be a half-space, with the error where it is known.

    The half-width is that of Hertz's theory. The radius of a body is that of its shape. Its thickness is the field
    ``thickness`` of a half-space.
    """
    if scene is None or (hertz := scene.hertz) is None:
        return ""
    widths = (hertz.half_width,) if scene.ellipse is None else scene.ellipse.semi_axes
    faults: list[str] = []
    for axis, half_width in enumerate(widths):
        bends = [curvatures_of(shape)[axis] for shape in scene.shapes]
        radius = min((1 / abs(bend) for bend in bends if bend), default=inf)
        if half_width > LARGEST_WIDTH * radius:
            faults.append(
                f"the contact is {readable(2 * half_width, digits=3)} wide "
                f"on a radius of {readable(radius, digits=3)}; {_error_of_curvature(scene, bends, half_width)}; reduce "
                "the load, see that it is in N/m, radii in m and moduli in Pa, or compute the whole bodies with finite "
                "elements"
            )
            break
    half_width = min(widths)
    for number, body in enumerate(scene.solids):
        thickness = getattr(body, "thickness", inf) / half_width
        if not isinstance(body, HalfSpace) or not body.compliance or thickness >= LEAST_THICKNESS:
            continue
        from contactstudy.scene.solids.coated import CoatedHalfSpace  # only where it is needed

        material = HalfSpace(body.youngs_modulus, body.poisson_ratio)
        layer = CoatedHalfSpace(material, body.thickness, HalfSpace(inf, 0.3))
        stiffer = body.compliance / layer.compliance_at(half_width)
        faults.append(
            f"Scene.solids[{number}] is {thickness:.2g} half-widths thick, and bonded to a rigid base {stiffer:.3g} "
            "times as stiff; give a CoatedHalfSpace of that thickness, with { youngs_modulus = inf, poisson_ratio = "
            "0.3 } as the substrate"
        )
    return f"The half-space is not a good approximation: {'; '.join(faults)}." if faults else ""


def _error_of_curvature(scene: Scene, bends: list[float], half_width: float) -> str:
    """Return, as a clause of a sentence, what is known of the error due to the curvature of the bodies.

    `bends` [1/m] are the curvatures of both bodies along one axis. `half_width` [m] is that of the contact along it.
    """
    convex = sum(bend for bend in bends if bend > 0)
    hollow = -sum(bend for bend in bends if bend < 0)
    hertz = scene.hertz
    assert hertz is not None
    if scene.ellipse is None and 0 < convex / (hollow or inf) - 1 < CONFORMING_CLEARANCE:
        radius = 1 / convex
        # twice E* is E / (1 - nu^2) of two bodies of one material
        load = hertz.load_per_length / (2 * hertz.contact_modulus * (1 / hollow - radius))
        ratio = hertz.peak_pressure / (hertz.load_per_length / radius * pin_in_hole(load))
        return f"Hertz's peak pressure is {ratio:.3g} times that of a pin in a hole (Persson 1964)"
    # The gap below a circle of radius R is x^2 / (2 R) + x^4 / (8 R^3) + ... In a line contact of half-width a, the
    # second term takes 3 a^2 / (8 R^2) times the load of the first. The gaps of the two bodies add up.
    change = 3 / 8 * half_width**2 * sum(bend**3 for bend in bends) / sum(bends)
    return (
        f"parabolas in place of circles alone change its load by about {100 * change:.2g} %, and the error "
        "of the bodies' finite size is not known"
    )


def pin_in_hole(load: float) -> float:
    """Return the dimensionless peak pressure of a pin of radius R in a hole of the same material.

    It is the peak pressure times R, over the load per length.

    Parameters
    ----------
    load
        Dimensionless load: the load per length, over the product of ``E / (1 - nu^2)`` and the difference of the radii.

    The solution is Persson's (1964), in the form of Ciavarella & Decuzzi (2001), Int. J. Solids Struct. 38, 4507, eqs.
    41 and 43. There b is the tangent of a quarter of the angle of the arc in contact.
    """
    from scipy.optimize import brentq  # imported late, since it is slow

    def excess(log_b: float) -> float:
        """Return eq. 41 for ``b = 10**log_b``, less the reciprocal of the load; it is zero at the b of this load."""
        square = 10 ** (2 * log_b)
        arc = (log(square + 1) + 2 * square**2) / (pi * square * (square + 1))
        return 2 * (1 - square) / (pi * square) - arc - 1 / load

    b = 10 ** brentq(excess, -6.0, 0.0)
    root = sqrt(b**2 + 1)
    return float(2 * b / (pi * root) + log((root + b) / (root - b)) / (2 * pi * b**2 * (1 + b**2)))
