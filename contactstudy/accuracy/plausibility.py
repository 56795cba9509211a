"""Warnings of an answer: where elastic half-spaces are no model of the bodies, or the input is most likely mistaken.

They are sentences, empty where there is nothing to warn of: bodies too small to be half-spaces (`beyond_half_space`),
ends of a roller that carry more than its middle (`end_of_half_space`, `unrelieved_ends`), implausible numbers
(`implausible`), and stresses beyond hardness or yield stress (`beyond_strength`). The margin to yield of an elastic
body by a computed stress is here too. A body is layered if it has a coating; each of its parts is a layer or the
substrate, given by words, material, and depths [m] at its top and its bottom.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, isinf, log, pi, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contactstudy.analytic import first_yield, first_yield_of_ball
from contactstudy.domain.grid import Array, ExactPeriodicity
from contactstudy.domain.validation import InvalidInput, readable
from contactstudy.problem.problem import Field
from contactstudy.scene.scene import Scene, scene_of
from contactstudy.scene.shapes.roller import Crown, EndRelief, LundbergProfile, ProfilePoints
from contactstudy.scene.shapes.shape import curvatures_of, length_scales_of
from contactstudy.scene.solids.bodies import HalfSpace, in_part, is_layered, modulus_at_own_width
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Largest half-width of the contact over a body's radius for which the body counts as a half-space. At that half-width a
# parabola in place of a circle changes the load by 0.6 %.
LARGEST_WIDTH = 1 / 8
# Least thickness of a body over the half-width for which it counts as a half-space: bonded to a rigid base, a layer of
# that thickness is stiffer than a half-space by less than 1 %.
LEAST_THICKNESS = 4.0
# Radius of a hollow body less that of the convex body in it, over the latter, below which the two are called conforming
# and are compared with a pin in a hole. Plain bearings have some thousandths.
CONFORMING_CLEARANCE = 0.2


def beyond_half_space(scene: Scene | None) -> str:
    """Return a sentence if a body is too small for its contact to be a half-space, with the error where it is known.

    The half-width is that of Hertz's theory, of a point contact along each axis. The radius of a body is that of its
    shape. Its thickness is the field ``thickness`` of a half-space. Nothing is said without a scene, and of one whose
    shapes have no curvature.
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


# Largest number of cells of a contact that is solved once more for a suggested drop, which takes seconds, and the
# residual at which that solve ends: pressures at the ends are then known to a per cent.
MOST_CELLS, TOLERANCE = 2**17, 1e-4
# Highest pressure in the outer tenths of a roller over that of the rest, up to which the ends count as relieved.
RELIEVED = 1.05
# Multiples of Lundberg's drop to try in turn, each half as large again: Lundberg's own, for one load on a centred
# roller, leaves ends under a tilt or a peak load unrelieved.
MULTIPLES = 1.0, 1.5, 2.25, 3.4
# Shapes that the suggested profile would replace.
PROFILES = Crown, LundbergProfile, EndRelief, ProfilePoints


def end_of_half_space(solution: Solution) -> str:
    """Return a sentence if a roller's ends carry more than its middle, and no body ends there with free faces."""
    if (roller := _roller_of(solution)) is None:
        return ""
    scene, rows = roller
    middle = solution.pressure[:, rows[len(rows) // 2]].max()
    if scene.free_length < np.inf or solution.pressure[:, rows[[0, -1]]].max() <= middle:
        return ""
    number = next(number for number, body in enumerate(scene.solids) if body.compliance)
    key = f'free_faces = "{readable(scene.roller_length or 0.0)}" of Scene.solids[{number}]'
    return (
        f"A roller's end is stiffer as a part of a half-space, and its pressure an upper estimate: {key} ends the body "
        "too, where its other effects allow it."
    )


def unrelieved_ends(solution: Solution) -> str:
    """Return a sentence if a smooth roller's ends carry more than the rest of it, with a drop that would relieve them.

    The suggested drop is that of the profile which Lundberg (1939) makes for the load and the length, or one and a half
    or more times as large where a solve with it finds that the ends still carry more.
    """
    if (roller := _roller_of(solution)) is None:
        return ""
    scene, rows = roller
    hertz, length, paddings = scene.hertz, scene.roller_length, solution.problem.paddings
    is_rough = any(scales.height for scales in length_scales_of(scene.shapes))
    if hertz is None or length is None or paddings is None or is_rough:
        return ""
    excess = _excess(solution.pressure, rows)
    if excess <= RELIEVED or length < 2 * hertz.half_width or solution.pressure.size > MOST_CELLS:
        return ""
    start = f"The ends carry up to {excess:.2f} times as much as the rest of the roller"
    even = LundbergProfile.for_load(
        hertz.load_per_length, contact_modulus=hertz.contact_modulus, radius=hertz.radius, length=length
    )
    kept = tuple(shape for shape in scene.shapes if not isinstance(shape, PROFILES))
    for multiple in MULTIPLES:
        amplitude, drop = multiple * even.amplitude, multiple * even.end_drop
        shapes = (*kept, LundbergProfile(amplitude, drop, length))
        try:
            problem = replace(scene, shapes=shapes, outputs=()).problem(solution.problem.grid, paddings)
            relieved = solve_contact(problem, SolveOptions(TOLERANCE))
        except InvalidInput:  # an effect of the scene is not computed with such a profile
            break
        if _excess(relieved.pressure, rows) <= RELIEVED:
            highest = [readable(float(p.max()), "Pa") for p in (solution.pressure, relieved.pressure)]
            return (
                f"{start}: suggested drop {readable(drop)} at each end, by LundbergProfile(amplitude={amplitude:.3g}, "
                f"end_drop={drop:.3g}, length={length:.6g}), with which the highest pressure on this grid is "
                f"{highest[1]} and not {highest[0]}."
            )
    return f"{start}, and Lundberg's profile for this load does not relieve them: lower the load or the tilt."


def _roller_of(solution: Solution) -> tuple[Scene, NDArray[np.intp]] | None:
    """Return the scene of a roller that ends within the grid or with it, and the indices along y of its rows of cells.

    Of a contact without a roller of known length it is None.
    """
    problem, scene = solution.problem, scene_of(solution.problem)
    if scene is None or scene.roller_length is None or problem.source is None or not problem.source.ends_along:
        return None
    covered = problem.covered_fractions
    return scene, np.arange(problem.grid.cells[1]) if covered is None else np.flatnonzero(covered)


def _excess(pressure: Array, rows: NDArray[np.intp]) -> float:
    """Return the highest `pressure` (x, y) in the outer tenths of the `rows` along y over that between them, or 0."""
    along = pressure.max(axis=0)[rows]
    count = max(len(rows) // 10, 1)
    between = along[count:-count].max(initial=0.0)
    return float(max(along[:count].max(), along[-count:].max()) / between) if between else 0.0


# Largest peak pressure over E*, slope of the heights, and approach over the radius of a contact of elastic half-spaces,
# where strains are a tenth and surfaces nearly flat. Each is many times what machines have.
MAX_PRESSURE, MAX_SLOPE, MAX_APPROACH = 0.1, 1.0, 1.0
# Largest width of the grid over that of the contact: wider, a row of a thousand cells has the contact in one cell.
MAX_WIDTH = 1e3
# Depth on the substrate's side of an interface, over that of the interface.
BELOW_INTERFACE = 1 + 1e-9
GIVE_STRENGTH = "give an ElasticPlasticHalfSpace, or the strength of your material."
HEIGHTS_HINT = "are heights given in µm as if they were m?"
MODULUS_HINT = "is a modulus given in GPa or MPa as if it were Pa?"
EXTENT_HINT = "is a length of the grid or the load given in another unit, such as mm or N/mm?"
LOAD_HINT = (
    "is the load or a radius given in another unit, such as N/mm or mm? If not, strains are too large for linear "
    "elasticity."
)
# A modulus below this [Pa] is softer than any gel: that of a metal or a polymer was given in GPa or MPa.
MIN_MODULUS = 1e3


def implausible(solution: Solution) -> str:
    """Return a sentence about implausible numbers of a contact, with the unit that was likely mistaken; else ``""``."""
    scene, grid, pressure = scene_of(solution.problem), solution.problem.grid, solution.pressure
    if scene is None or not np.isfinite(pressure).all():
        return ""
    peak, hertz = solution.peak_pressure, scene.hertz
    modulus = scene.contact_modulus if hertz is None else hertz.contact_modulus
    slope, radius = _slope(solution), inf if hertz is None else hertz.radius
    wider = grid.cells[0] / max(int(pressure.any(axis=1).sum()), 1)
    of_load = EXTENT_HINT if solution.status is Status.CONTACT_AT_EDGE else LOAD_HINT
    facts = (  # number, its limit, what is said of it, and which unit may be mistaken
        (slope, MAX_SLOPE, "the heights have slopes of {:.2g}", HEIGHTS_HINT),
        (peak / modulus, MAX_PRESSURE, "the peak pressure is {:.2g} times the contact modulus E*", of_load),
        (abs(solution.approach) / radius, MAX_APPROACH, "the approach is {:.2g} times the radius", LOAD_HINT),
        (wider, MAX_WIDTH, "the grid is {:.2g} times as wide as the contact", EXTENT_HINT),
    )
    beyond = [(fact.format(size), hint) for size, limit, fact, hint in facts if size > limit]
    if not beyond:
        return ""
    hint = MODULUS_HINT if modulus < MIN_MODULUS else beyond[0][1]
    return f"The input is implausible: {', '.join(fact for fact, _ in beyond)}; {hint}"


def beyond_strength(solution: Solution) -> str:
    """Return a sentence if the contact is beyond the hardness or the yield stress of an elastic body, or ``""``.

    Hardness and yield stress are those of the bodies, of a coated one of all its materials. First yield is that of the
    smooth line contact with the same ratio of largest shear to peak pressure, or of a ball. Nothing is said of a body
    that yields, nor together with ``Scene.hardness``, which caps the pressure.
    """
    scene, peak = scene_of(solution.problem), solution.peak_pressure
    if scene is None or scene.hardness < inf or not peak > 0:
        return ""
    shear = 0.0 if solution.traction is None else float(np.hypot(*solution.traction.shear).max())
    for number, body in enumerate(scene.solids):
        limit = getattr(getattr(body, "coating", body), "hardness", inf)
        if peak > limit:
            return (
                f"The peak pressure of {peak / 1e9:.3g} GPa is {peak / limit:.3g} times the hardness of "
                f"Scene.solids[{number}], {limit / 1e9:.3g} GPa: give Scene.hardness, or a body that yields."
            )
        if is_layered(body) or getattr(body, "hardness_profile", None) is not None:
            if sentence := _beyond_varying_strength(solution, number, body, shear):
                return sentence
            continue
        if not isinstance(body, HalfSpace) or isinf(body.yield_stress):
            continue
        radius = scene.hertz.radius if scene.hertz else 1.0  # the pressure at first yield does not depend on it
        first = first_yield(radius, scene.contact_modulus, body.yield_stress, body.poisson_ratio, shear / peak)
        pressure, kind = first.peak_pressure, "line"
        if scene.ellipse is not None:
            kind, pressure = "point", min(pressure, first_yield_of_ball(body.yield_stress, body.poisson_ratio))
        if peak > pressure:
            at = f" at {_load_at_peak(scene, pressure)}" if scene.hertz else ""
            return (
                f"The peak pressure of {peak / 1e9:.3g} GPa is {peak / pressure:.3g} times that at which "
                f"Scene.solids[{number}] first yields in a smooth {kind} contact{at}: give an ElasticPlasticHalfSpace, "
                "or the yield_stress of your material."
            )
    return ""


def _load_at_peak(scene: Scene, pressure: float) -> str:
    """Return the load of the smooth contact of a scene with this peak `pressure` [Pa], with its unit.

    A line contact has ``W = pi R p^2 / E*`` per length with the modulus at its own half-width ``2 p R / E*``; the load
    of a point contact goes with the third power of the pressure (Johnson 1985, eqs. 4.45 and 4.24).
    """
    if (ellipse := scene.ellipse) is not None:
        return f"{ellipse.load * (pressure / ellipse.peak_pressure) ** 3:.3g} N"
    assert scene.hertz is not None
    radius = scene.hertz.radius
    modulus = modulus_at_own_width(lambda modulus: 2 * pressure * radius / modulus, scene.solids)
    return f"{pi * radius * pressure**2 / modulus / 1e3:.3g} N/mm"


def _beyond_varying_strength(solution: Solution, number: int, body: Any, shear: float) -> str:
    """Return a sentence if a body whose strength varies with depth is beyond its yield stress or hardness, or ``""``.

    The `body` is that of the `number` in the scene, and `shear` the largest tangential traction [Pa]. The stress is
    that at the surface, in the middle of each layer, on both sides of its lower interface, and at up to a width of the
    contact, where that in a half-space is largest; of a hardness profile, also at the depths of its points. The
    pressure on each part below a layer is compared with the hardness of that part.
    """
    parts, name = list(getattr(body, "parts", {}).values()), f"Scene.solids[{number}]"
    # the stress in a half-space is at most its pressure; a stiff layer takes the strain of what is below
    moduli = [material.youngs_modulus for _, material, *_ in parts if not isinf(material.youngs_modulus)] or [1.0]
    largest = (solution.peak_pressure + 2 * shear) * max(moduli) / min(moduli)
    if parts and largest < min(min(material.yield_stress, material.hardness) for _, material, *_ in parts):
        return ""
    from contactstudy.scene.stress import SubsurfaceStress, von_mises  # imported only where it is needed

    problem = solution.problem
    assert problem.paddings is not None
    width = np.count_nonzero(solution.pressure.any(axis=1)) * problem.grid.cell_size[0]
    examined = {0.0, 0.1 * width, 0.2 * width, 0.35 * width, 0.7 * width, width}
    if not parts:
        examined |= {*body.hardness_profile.points[0]}
    for _, _, top, bottom in parts[:-1]:
        examined |= {(top + bottom) / 2, bottom, bottom * BELOW_INTERFACE}
    depths = tuple(sorted(examined))
    # images along hardly matter at these depths, and each image of a window takes a second
    paddings = problem.paddings[0], ExactPeriodicity()
    # it takes the body of this number in a pair
    operator = SubsurfaceStress(depths, number).of((body, body), problem.grid, paddings)
    if solution.traction is not None:
        operator = operator.with_shear(solution.traction.shear)
    stress = operator(solution.net_pressure)
    for part, material, top, _ in parts[1:]:
        pressure = -float(stress[2, depths.index(top * BELOW_INTERFACE)].min())  # stress zz, tension positive
        if pressure > (hardness := material.hardness):
            return (
                f"The pressure on {part} of {name} of {pressure / 1e9:.3g} GPa is "
                f"{pressure / hardness:.2g} times its hardness, {hardness / 1e9:.3g} GPa: {GIVE_STRENGTH}"
            )
    return yield_margin(body, number, np.array(depths), von_mises(stress)).sentence


@dataclass(frozen=True)
class YieldMargin:
    """Margin to yield of a body: where the `ratio` of the yield stress to the largest von Mises stress is least.

    There the stress is `von_mises` [Pa], at the `depth` [m] in the `part` of the body, in words. The ratio is infinite
    where nothing is known of the yield stress.
    """

    ratio: float = inf
    von_mises: float = 0.0
    part: str = ""
    depth: float = 0.0

    @property
    def sentence(self) -> str:
        """A sentence if the stress is beyond the yield stress, or ``""``."""
        if self.ratio >= 1:
            return ""
        return (
            f"The von Mises stress of {self.von_mises / 1e6:.3g} MPa in {self.part} is {1 / self.ratio:.3g} times the "
            f"yield stress: {GIVE_STRENGTH}"
        )


def stress_margin(scene: Scene, derived: Mapping[str, Field]) -> YieldMargin:
    """Return the margin to yield of the body whose stress is an output of `scene`, by its fields.

    Those are `derived` from the solution: ``z``, depths (z,) [m], and ``von_mises``, the stress (z, x, y) [Pa].
    """
    number = next(output.body for output in scene.outputs if hasattr(output, "body"))
    depths, stress = derived["z"].values, derived["von_mises"].values
    return yield_margin(scene.solids[number], number, depths, stress)


def yield_margin(body: Any, number: int, depths: Array, von_mises: Array) -> YieldMargin:
    """Return the margin to yield of the elastic `body` with this `number` in a scene; if coated, of its weakest part.

    The stress `von_mises` (z, x, y) [Pa] is that at `depths` (z,) [m]; the depth of an interface is in the part above.
    """
    largest, strength = von_mises.max(axis=(1, 2)), yield_stresses(body, depths)
    ratios = np.divide(strength, largest, out=np.full(largest.shape, inf), where=largest > 0)
    least = int(ratios.argmin())
    if isinf(ratios[least]):
        return YieldMargin()
    depth, part = float(depths[least]), f"Scene.solids[{number}]"
    for words, _, top, bottom in body.parts.values() if is_layered(body) else ():
        if in_part(np.array(depth), top, bottom):
            part = f"{words} of {part}"
    return YieldMargin(float(ratios[least]), float(largest[least]), part, depth)


def yield_stresses(body: Any, depths: Array) -> Array:
    """Return the yield stress [Pa] of an elastic body at `depths` [m], infinite where it is not known."""
    if is_layered(body):
        of_parts = (
            np.where(in_part(depths, top, bottom), material.yield_stress, inf)
            for _, material, top, bottom in body.parts.values()
        )
        return np.asarray(np.minimum.reduce(list(of_parts)))
    if (profile := getattr(body, "hardness_profile", None)) is not None:
        return np.asarray(profile.yield_stress(depths))
    stress = body.yield_stress if isinstance(body, HalfSpace) else inf
    return np.full(depths.shape, stress)


def _slope(solution: Solution) -> float:
    """Return the median slope of the undeformed gap, along the steeper axis; 0 if no slope is above `MAX_SLOPE`."""
    largest = 0.0
    for axis, step in enumerate(solution.problem.grid.cell_size):
        slopes = np.abs(np.diff(solution.problem.undeformed_gap, axis=axis)) / step
        if slopes.size and slopes.max() > MAX_SLOPE:
            largest = max(largest, float(np.median(slopes)))
    return largest
