"""Contacts that are too large for bodies of their size to be half-spaces."""

from math import inf, log, pi, sqrt

from contactstudy.domain.units import readable
from contactstudy.scene.scene import Scene
from contactstudy.scene.solids.bodies import HalfSpace

# Half-width over the radius, and thickness over the half-width, at which a half-space is no good approximation any more.
LARGEST_WIDTH, LEAST_THICKNESS = 1 / 8, 4.0
# Difference of the radii of a hollow and a convex body, over that of the convex one, up to which they conform.
CONFORMING_CLEARANCE = 0.2


def beyond_half_space(scene: Scene | None) -> str:
    """Return a sentence if a body is too small for its contact to be a half-space, with the error where it is known.

    The contact is Hertz's. A body has the radii of the shapes, and the ``thickness`` of a half-space.
    """
    if scene is None or (hertz := scene.hertz) is None:
        return ""
    widths = (hertz.half_width,) if scene.ellipse is None else scene.ellipse.semi_axes
    faults: list[str] = []
    for axis, half_width in enumerate(widths):
        bends = [_curvatures(shape)[axis] for shape in scene.shapes]
        radius = min((1 / abs(bend) for bend in bends if bend), default=inf)
        if half_width > LARGEST_WIDTH * radius:
            faults.append(
                f"the contact is {readable(2 * half_width, digits=3)} wide "
                f"on a radius of {readable(radius, digits=3)}; {_error_of_curvature(scene, bends, half_width)}; reduce "
                "the load, or compute the whole bodies with finite elements"
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


def _curvatures(shape: object) -> tuple[float, float]:
    return getattr(shape, "curvatures", (getattr(shape, "curvature", 0.0), 0.0))


def _error_of_curvature(scene: Scene, bends: list[float], half_width: float) -> str:
    """Return what is known of the error of a contact of this `half_width` [m] on bodies with curvatures [1/m]."""
    convex = sum(bend for bend in bends if bend > 0)
    hollow = -sum(bend for bend in bends if bend < 0)
    hertz = scene.hertz
    assert hertz is not None
    if scene.ellipse is None and 0 < convex / (hollow or inf) - 1 < CONFORMING_CLEARANCE:
        radius = 1 / convex
        load = hertz.load_per_length / (2 * hertz.contact_modulus * (1 / hollow - radius))
        ratio = hertz.peak_pressure / (hertz.load_per_length / radius * pin_in_hole(load))
        return f"Hertz's peak pressure is {ratio:.3g} times that of a pin in a hole (Persson 1964)"
    # the load of the gap's fourth power over that of its second, of a line contact
    change = 3 / 8 * half_width**2 * sum(bend**3 for bend in bends) / sum(bends)
    return (
        f"parabolas in place of circles alone change its load by about {100 * change:.2g} %, and the error "
        "of the bodies' finite size is not known"
    )


def pin_in_hole(load: float) -> float:
    """Return the peak pressure, times R over the load per length, of a pin of radius R in a hole of its material.

    Parameters
    ----------
    load
        Load per length over ``E / (1 - nu^2)`` and the difference of the radii.

    Persson (1964), by way of Ciavarella & Decuzzi (2001), Int. J. Solids Struct. 38, 4507, eqs. 41 and 43, with the
    tangent b of a quarter of the arc in contact.
    """
    from scipy.optimize import brentq  # imported late, since it is slow

    def excess(log_b: float) -> float:
        square = 10 ** (2 * log_b)
        arc = (log(square + 1) + 2 * square**2) / (pi * square * (square + 1))
        return 2 * (1 - square) / (pi * square) - arc - 1 / load

    b = 10 ** brentq(excess, -6.0, 0.0)
    root = sqrt(b**2 + 1)
    return float(2 * b / (pi * root) + log((root + b) / (root - b)) / (2 * pi * b**2 * (1 + b**2)))
