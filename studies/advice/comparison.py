"""What was measured of a scene's settings, and the verdict on a requested error."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite, nan

import numpy as np

import contactstudy as cs
from studies.advice.compared_scene import Setting
from studies.advice.front import pareto_front
from studies.advice.rounds import median_ratio_and_p
from studies.reference.line_contact import PADDINGS

# A setting of another padding is chosen only if it is quicker by this factor, with a p-value below this one.
MIN_SPEED_UP, SIGNIFICANCE_LEVEL = 1.1, 0.01
# Factor by which the median of few times outside of rounds may be too short.
FACTOR_WITHOUT_ROUNDS = 1.25
FREE = "free"
# Boundary with one cell along a length on which nothing varies.
LINE = "exact, one cell along"


def name_and_images(padding: cs.Padding | cs.Paddings) -> tuple[str, int]:
    """Return the name of a padding and its number of images, 0 if it counts none."""
    if isinstance(padding, tuple):
        names = [name_and_images(axis)[0] for axis in padding]
        return FREE if set(names) == {"zero"} else " by ".join(names), 0
    images = getattr(padding, "images", 0)
    named = (name for name, make in PADDINGS.items() if type(make(1)) is type(padding))
    return next(named, repr(padding)), images


def label_of(padding: cs.Padding | cs.Paddings) -> str:
    """Return a padding in words, with its n where it has one."""
    name, images = name_and_images(padding)
    return f"{name}, n = {images}" if hasattr(padding, "images") else name


@dataclass(frozen=True)
class MeasuredPadding:
    """Error of a padding alone: its answer against the scene's own boundary on the same grid.

    `l1` is the relative L1 error of the pressure, `changes` are the relative changes of the main numbers.
    """

    padding: cs.Padding | cs.Paddings
    l1: float
    changes: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class MeasuredSetting:
    """A setting with its error and times.

    Attributes
    ----------
    setting
        The setting.
    label
        Name of its padding, with :data:`LINE` for one cell along a length on which nothing varies.
    error
        Relative L1 error of the pressure against the reference; the largest of this and any finer grid of its padding.
    is_bounded
        Whether the solution or one on coarser cells has a bound on its error, or the reference is a closed form.
    seconds
        Processor times [s] outside of rounds.
    rounds
        Processor time [s] in each round; nan or missing where it took no part.
    """

    setting: Setting
    label: str
    error: float
    is_bounded: bool
    seconds: tuple[float, ...]
    rounds: tuple[float, ...] = ()

    @property
    def time(self) -> float:
        """Median processor time [s], of the rounds if it took part in some."""
        rounds = [second for second in self.rounds if isfinite(second)]
        return float(np.median(rounds or self.seconds))


@dataclass(frozen=True)
class Alternative:
    """Quickest setting of another padding that meets the request.

    `ratio` is its time over the chosen one's, `p` the p-value of the sign test: the probability of the observed majority
    of rounds if both are equally fast.
    """

    measured: MeasuredSetting
    ratio: float
    p: float

    @property
    def is_as_fast(self) -> bool:
        """True if the times differ by less than a tenth."""
        return 1 / MIN_SPEED_UP <= self.ratio <= MIN_SPEED_UP

    @property
    def is_significant(self) -> bool:
        """True if the median ratio is beyond a tenth and the sign test over the rounds is significant."""
        return not self.is_as_fast and self.p < SIGNIFICANCE_LEVEL


@dataclass(frozen=True)
class Verdict:
    """The quickest setting for a request.

    Attributes
    ----------
    error
        Requested relative L1 error.
    best
        The setting; if none meets the request, that of least error, or the scene's own padding where the bound on the
        reference is larger than the difference.
    alternatives
        The quickest setting of every other padding that meets it.
    coarser
        The next coarser setting of the same padding, or None.
    meets
        Whether its error and that of the reference together meet the request.
    """

    error: float
    best: MeasuredSetting
    alternatives: tuple[Alternative, ...]
    coarser: MeasuredSetting | None
    meets: bool


@dataclass(frozen=True)
class Comparison:
    """Settings of a scene with their measured errors and times.

    Attributes
    ----------
    name, text
        Name of the scene, and the scene as TOML.
    extent
        Width and length [m].
    boundary
        The scene's own padding.
    error
        Requested relative L1 error.
    reference_bound
        Bound on the error of the reference, below which errors are not resolved.
    reference
        Cells of the reference; None where it is Hertz's contact.
    bounds
        Bounds on the relative errors of the reference's main numbers.
    paddings, paddings_on
        Error of each padding alone, and the cells on which it was measured.
    tolerances
        Relative L1 error by each tolerance, on the same cells.
    settings
        All settings.
    notes
        A sentence for each thing that was left out or is to be known.
    seconds, budget
        Wall time [s] of the measurement, and the time that it was given.
    """

    name: str
    text: str
    extent: tuple[float, float]
    boundary: cs.Padding | cs.Paddings
    error: float
    reference_bound: float
    reference: tuple[int, int] | None
    bounds: Mapping[str, float]
    paddings: tuple[MeasuredPadding, ...]
    paddings_on: tuple[int, int]
    tolerances: Mapping[float, float]
    settings: tuple[MeasuredSetting, ...]
    notes: tuple[str, ...] = ()
    seconds: float = nan
    budget: float = nan

    @property
    def boundary_label(self) -> str:
        """Label of the scene's own padding."""
        return label_of(self.boundary)

    def settings_of(self, label: str) -> list[MeasuredSetting]:
        """Return the settings of one padding, from the coarsest."""
        chosen = [measured for measured in self.settings if measured.label == label]
        return sorted(chosen, key=lambda measured: np.prod(measured.setting.cells))

    @property
    def labels(self) -> list[str]:
        """Names of all paddings that were timed, the scene's own first."""
        timed = (measured.label for measured in self.settings)
        return list(dict.fromkeys([self.boundary_label, *timed]))

    def settings_meeting(self, error: float) -> list[MeasuredSetting]:
        """Return the settings that meet an error with the reference's own bound added, from the quickest."""
        meeting = [
            measured
            for measured in self.settings
            if measured.is_bounded and measured.error + self.reference_bound <= error
        ]
        return sorted(meeting, key=lambda measured: measured.time)

    def quickest_by_padding(self, error: float) -> dict[str, MeasuredSetting]:
        """Return the quickest setting of each padding that meets an error, by its name.

        One that took no part in the rounds must be quicker by a quarter than one that did.
        """

        def expected(measured: MeasuredSetting) -> float:
            return measured.time * (1 if measured.rounds else FACTOR_WITHOUT_ROUNDS)

        quickest: dict[str, MeasuredSetting] = {}
        for measured in sorted(self.settings_meeting(error), key=expected):
            quickest.setdefault(measured.label, measured)
        return dict(sorted(quickest.items(), key=lambda pair: pair[1].time))

    def front(self, label: str) -> list[MeasuredSetting]:
        """Return the Pareto front, in time and error, of the settings of a padding."""
        good = [measured for measured in self.settings_of(label) if measured.is_bounded]
        if not good:
            return []
        cost = np.array([measured.time for measured in good])
        error = np.array([measured.error for measured in good])
        return [good[k] for k in pareto_front(cost, error)]

    def verdict(self, error: float | None = None) -> Verdict | None:
        """Return the quickest setting that meets an error, by default the requested one; None without any setting.

        It has the scene's own padding, unless another one is quicker by more than a tenth in the median, and quicker in
        nearly all rounds.
        """
        error = self.error if error is None else error
        meeting = self.settings_meeting(error)
        if not meeting:
            bounded = [measured for measured in self.settings if measured.is_bounded]
            candidates = bounded or self.settings
            if not candidates:
                return None
            best = min(candidates, key=_by_error)
            at_boundary = (item for item in candidates if item.label == self.boundary_label)
            nearest = min(at_boundary, key=_by_error, default=best)
            # below the reference's own bound errors are equal
            if nearest.error <= best.error + self.reference_bound:
                best = nearest
            return Verdict(error, best, (), self._coarser(best), meets=False)
        quickest = self.quickest_by_padding(error)
        best = quickest.get(self.boundary_label, meeting[0])
        for measured in quickest.values():
            alternative = _alternative(measured, best)
            if alternative.is_significant and alternative.ratio < 1:
                best = measured
        alternatives = tuple(
            _alternative(measured, best) for measured in quickest.values() if measured is not best
        )
        return Verdict(error, best, alternatives, self._coarser(best), meets=True)

    def _coarser(self, best: MeasuredSetting) -> MeasuredSetting | None:
        """Return the next coarser setting of the same padding."""
        cells = np.prod(best.setting.cells)
        line = self.settings_of(best.label)
        coarser = [measured for measured in line if np.prod(measured.setting.cells) < cells]
        return coarser[-1] if coarser else None


def _by_error(measured: MeasuredSetting) -> tuple[float, float]:
    """Return what sorts settings by their error to two digits, then by their time."""
    return float(f"{measured.error:.1e}"), measured.time


def _alternative(measured: MeasuredSetting, best: MeasuredSetting) -> Alternative:
    """Return a setting with its time over that of the best one."""
    rounds = min(len(measured.rounds), len(best.rounds))
    ratio, probability = median_ratio_and_p(measured.rounds[:rounds], best.rounds[:rounds])
    ratio = ratio if isfinite(ratio) else measured.time / best.time
    return Alternative(measured, ratio, probability)


def with_envelope(errors: Sequence[float]) -> list[float]:
    """Return errors on ever finer grids with each replaced by the largest of itself and those on finer grids."""
    return [float(error) for error in np.fmax.accumulate(errors[::-1])[::-1]]
