import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.lubricated_contact import film_answer
from contactstudy.io.pictures.interference import interference_colours
from contactstudy.lubrication.solve_lubricated import solve_lubricated
from tests.contactstudy.lubrication.scenes import by_moes, grid


def hue(path: float) -> np.ndarray:
    """Colour over its brightest channel at an optical path difference 2 n h [m]."""
    colour = interference_colours(np.array(path / 3))
    return np.asarray(colour / colour.max())


def test_colours_follow_the_scale_of_newton() -> None:
    # path differences of the first two orders in reflected light
    assert interference_colours(np.array(0.0)) == pytest.approx(0)
    assert hue(259e-9).min() > 0.9  # white
    red, green, blue = hue(430e-9)  # brownish yellow
    assert red > green + 0.1 > blue + 0.2
    red, green, blue = hue(565e-9)  # purple, between the first and the second order
    assert green < 0.2
    assert min(red, blue) > 0.3
    red, green, blue = hue(664e-9)  # sky blue
    assert blue > green > red
    red, green, blue = hue(910e-9)  # yellow of the second order
    assert min(red, green) > 0.8
    assert blue < 0.2


@pytest.mark.parametrize(("wavelength", "index"), [(546e-9, 1.5), (633e-9, 1.6)])
def test_fringes_are_half_a_wavelength_in_oil_apart(wavelength: float, index: float) -> None:
    fringe = wavelength / (2 * index)
    dark = interference_colours(np.arange(4) * fringe, index, (wavelength,))
    bright = interference_colours((np.arange(4) + 0.5) * fringe, index, (wavelength,))
    assert dark == pytest.approx(0, abs=1e-9)
    assert bright.max(axis=1) == pytest.approx(1)


def test_a_contact_is_drawn_in_these_colours() -> None:
    contact = film_answer(solve_lubricated(by_moes(20, 5), grid(100, 4.5)))
    figure = contact.plot(colours="interference", refractive_index=1.45)
    (image,) = (image for ax in figure.axes for image in ax.images)
    near = np.abs(contact.grid.x) <= 2 * contact.scales.hertz.half_width
    drawn = np.asarray(image.get_array())[:, 0]
    assert drawn == pytest.approx(interference_colours(contact.film[near, 0], 1.45))
    for wrong in ({"colours": "none"}, {"colours": "interference", "refractive_index": 0}):
        with pytest.raises(cs.InvalidInput, match="plot"):
            contact.plot(**wrong)  # type: ignore[arg-type]
