"""Bodies that end along the length, with faces that are free of traction."""

from dataclasses import replace
from math import isclose

from contactstudy.domain.validation import InvalidInput, Metres, readable, valid
from contactstudy.scene.shapes.roller import FiniteLength
from contactstudy.scene.solids.bodies import HalfSpace, SceneContext

# Least length between two faces over the half-width of the contact, down to which the pressure was compared with finite
# elements.
SHORTEST = 4.0


def FreeFaces(solid: HalfSpace, length: float) -> HalfSpace:
    """Return a body of the material of `solid` that ends along the length, with faces free of traction.

    The faces are at ``|y| = length / 2``, at right angles to the surface, and contact ends there: no
    :class:`~contactstudy.FiniteLength` is needed. Beside the faces the body is softer, up to two and a half times. Each
    face is that of a quarter-space, with the load mirrored evenly about both. A load that varies over long waves at one
    face also acts on the other, by a fit whose error is not in the bounds: 0.4 % of the pressure in L1 in bodies of 20
    half-widths, 1.4 % in those of 4. Displacement counts from points on the surface at three body lengths from the axis.
    Sources: Hetenyi (1970), Journal of Applied Mechanics 37, 89; Wang, Guo, Wong & Zhang (2017), Tribology International
    114, 358.

    Parameters
    ----------
    solid
        Elastic half-space, whose fields it keeps.
    length
        Length between the faces [m], above zero, in a scene at least 4 half-widths of the contact.

    Raises
    ------
    InvalidInput
        For a body that is no elastic half-space, and a length that is not above zero.
    """
    if not isinstance(solid, HalfSpace):
        raise InvalidInput(
            f"FreeFaces.solid is of the type {type(solid).__name__}: faces are known of a HalfSpace without coating, "
            "creep or yielding, give one, or a FiniteLength among the shapes, which ends the contact alone."
        )
    return replace(solid, free_faces=valid("FreeFaces.length", length, Metres))


def check_free_faces(scene: SceneContext) -> None:
    """Raise :class:`~contactstudy.InvalidInput` for a roller of another length, and for faces too near to each other.

    Faces are too near if they are less than `SHORTEST` half-widths apart. The `scene` has free faces.
    """
    length = scene.free_length
    for number, shape in enumerate(scene.shapes):
        if isinstance(shape, FiniteLength) and not isclose(shape.length, length):
            raise InvalidInput(
                f"Scene.shapes[{number}] is {shape!r}, and contact ends at free faces {readable(length)} apart: leave "
                "it out, or give the body that it ends faces of that length."
            )
    hertz = scene.hertz
    if hertz is not None and length < SHORTEST * hertz.half_width:
        raise InvalidInput(
            f"HalfSpace.free_faces is {readable(length)}, and in a contact of the half-width "
            f"{readable(hertz.half_width)} the faces load each other: give {readable(SHORTEST * hertz.half_width)} or "
            "more, or leave free_faces out and end the contact by a FiniteLength."
        )
