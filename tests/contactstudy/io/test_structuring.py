import math
from decimal import Decimal
from itertools import product

import pytest

import contactstudy as cs
from contactstudy.domain.validation import HARDNESS, KNOWN, Unit, _registry, decimal_unit, in_si, parted

METRES = Unit("m", "a length", "10 mm")
PASCALS = Unit("Pa", "a pressure", "1.2 GPa")
PER_PASCAL = Unit("1/Pa", "a coefficient", "1e-17 1/Pa")
LOAD = Unit("N/m", "a load per length", "100 N/mm")
NUMBER = Unit("", "a number", "0.3")
HERTZ = Unit("Hz", "a frequency", "50 Hz")
WRITTEN: list[tuple[str, Unit, float | None]] = [
    ("0.01", METRES, None), ("10 mm", METRES, 1e-2), ("30 um", METRES, 3e-5),
    ("30 µm", METRES, 3e-5), ("1 inch", METRES, 0.0254), ("1.2 GPa", PASCALS, 1.2e9), ("100 N/mm", LOAD, 1e5),
    ("5 N*mm**-1", LOAD, 5e3), ("5 N mm^-1", LOAD, 5e3), ("20 1/GPa", PER_PASCAL, 2e-8), ("30 %", NUMBER, 0.3),
    ("30 %", METRES, None),
    ("90 degree", Unit("rad", "an angle", "90 degree"), math.pi / 2),
    ("inf", PASCALS, math.inf),
    ("3000 rpm", HERTZ, 50.0), ("50 1/s", HERTZ, 50.0),
    ("1e-8 mm^3/(N m)", PER_PASCAL, 1e-17), ("20 °C", Unit("K", "a temperature", "333 K"), 293.15),
    ("1e-6 mm³/Nm", PER_PASCAL, 1e-15), ("206000 N/mm2", PASCALS, 2.06e11),
    ("40 mPas", Unit("Pa*s", "a viscosity", "40 mPa*s"), 0.04), ("700 HV", HARDNESS, 700 * 9.80665e6),
    ("59 HRC", HARDNESS, 675 * 9.80665e6), ("10 HRC", HARDNESS, None), ("700 HV", PASCALS, None),
    ("10 mm +- 0.05 mm", METRES, 1e-2), ("60 HRC ± 2", HARDNESS, 697 * 9.80665e6), ("10 mm +- 1 N", METRES, None),
    ("10 mm ±", METRES, None), ("± 1 mm", METRES, None), ("(100 ± 5) N/mm", LOAD, 1e5), ("100 +- 5 um", LOAD, None),
    ("46 W/(m*K)", Unit("W/(m*K)", "a thermal conductivity", "46 W/(m*K)"), 46.0),
]  # fmt: skip


def test_a_text_with_a_unit_is_the_number_in_si() -> None:
    for written, unit, expected in WRITTEN:
        if expected is None:
            with pytest.raises(cs.InvalidInput):
                in_si("field", written, unit)
        else:
            # to the last bit: decimals are converted in decimals
            assert in_si("field", written, unit) == expected, written


def test_a_tolerance_is_in_the_unit_of_its_number() -> None:
    for written, tolerance in (
        ("10 mm", None), ("10 mm ± 50 um", 0.05), ("-20 N +- 5 %", 1.0), ("2 % ± 1 %", 1.0), ("(100 ± 5) N/mm", 5.0),
    ):  # fmt: skip
        assert parted("field", written)[2] == pytest.approx(tolerance)


def test_texts_with_units_are_read_in_python_wherever_a_number_is() -> None:
    assert cs.LineLoad("100 N/mm") == cs.LineLoad(1e5)
    assert cs.Grid((2, 2), ("1 mm", "2 mm")) == cs.Grid((2, 2), (1e-3, 2e-3))
    history = cs.LoadHistory(times=["0 s", "1 min"], per_length=("1 N/mm", 2e3))
    assert history == cs.LoadHistory((0.0, 60.0), (1e3, 2e3))
    with pytest.raises(cs.InvalidInput, match=r"LineLoad\.per_length is '100 N': give a load per"):
        cs.LineLoad("100 N")


def test_a_decimal_unit_is_that_of_the_library_of_units() -> None:
    registry = _registry()
    for symbol, written in product(sorted(KNOWN), ("{}", "1/{}", "N*{}^-2/mm", "{} / s")):
        text = written.format(symbol or "1")
        read = registry.Quantity(Decimal(7), text).to_base_units()
        power, *powers = decimal_unit(text)
        base = registry.Quantity(Decimal(7).scaleb(power), "")
        for unit, exponent in zip(("meter", "kilogram", "second", "kelvin"), powers, strict=True):
            base *= registry.Quantity(Decimal(1), unit) ** exponent
        assert read.is_compatible_with(base), text
        assert float(read.magnitude) == float(base.magnitude), text


def test_what_is_no_length_is_refused_with_an_example() -> None:
    texts = "10 N", "mm", "", "ten mm", "1..2 mm", "10 mm mm", "1e999 mm/s", "nan m", "0 a^0"
    for written in texts:
        with pytest.raises(cs.InvalidInput, match="give a length, such as '10 mm', or a number in"):
            in_si("Cylinder.radius", written, METRES)
