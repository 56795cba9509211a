"""Requests of studies: their cases and keys, and the reasons why stored results cannot be used."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from contactstudy import InvalidInput
from contactstudy.domain.identity import IdentityRecord, canonical, key
from studies.model.case import Computation
from studies.model.outcome import RESERVED_NAMES
from studies.model.plain_text import one_line
from studies.model.study import Point, Study
from studies.store.fingerprint import disagreements, study_fingerprint, versions
from studies.store.records import CaseIdentity, Contents


@dataclass(frozen=True, eq=False)
class Request:
    """Cases that a study asks for.

    Attributes
    ----------
    keys
        Key of the case at every point.
    cases
        Each case by its key.
    identities
        Identity of each case by its key.
    context
        Versions and hashes of the code and the files that the cases depend on.
    """

    keys: Sequence[str]
    cases: Mapping[str, Computation]
    identities: Mapping[str, CaseIdentity]
    context: Mapping[str, str]

    @classmethod
    def of(cls, study: Study) -> "Request":
        """Return the request of a study; each distinct case is made once.

        Raises
        ------
        InvalidInput
            For an axis with a reserved name, and for a computation that lacks a method.
        """
        if reserved := RESERVED_NAMES & {axis.name for axis in study.points}:
            raise InvalidInput(
                f"Study {study.name!r} has the axes {sorted(reserved)}: these names are taken, choose others."
            )
        memory = IdentityRecord()
        keys, cases, identities = [], {}, {}
        for point, case in study.visits():
            if not all(hasattr(case, part) for part in ("prepare", "run", "record")):
                raise InvalidInput(_no_case(study, point, case))
            tree = canonical(case, memory)
            name = key(tree)
            keys.append(name)
            if name not in cases:
                cases[name], identities[name] = case, CaseIdentity(name, tree, point_text(point))
        kinds = {type(case) for case in cases.values()}
        return cls(keys, cases, identities, versions() | study_fingerprint(study, kinds))


def point_text(point: Point) -> Mapping[str, str]:
    """Return the values of `point` as text, as the journal has them."""
    return {axis: str(value) for axis, value in point.items()}


def _no_case(study: Study, point: Point, case: object) -> str:
    """Return the message on an object that is no case."""
    return (
        f"scene_at of study {study.name!r} gives {one_line(repr(case), 60)} at {dict(point)}: return a "
        "studies.model.case.Case, or a frozen dataclass with prepare, run and record."
    )


def recompute_reasons(
    contents: Contents, identity: CaseIdentity, context: Mapping[str, str]
) -> str:
    """Return in one line why what is stored for `identity`, or at its point, cannot be used; empty if nothing is."""
    changes = contents.changed(identity)
    before = contents.other_records.get(identity.key)
    if before is not None and identity.key not in contents.records:
        changes += disagreements(before.context, context)
    return ", ".join(changes)
