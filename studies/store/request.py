"""What a study asks for, and why what is stored is not it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from contactstudy import InvalidInput
from studies.model.case import Computation
from studies.model.outcome import RESERVED_NAMES
from studies.model.plain_text import one_line
from studies.model.study import Point, Study
from studies.store.fingerprint import measures_fingerprint, versions
from studies.store.identity import Memory, Tree, canonical, key
from studies.store.journal import CaseIdentity, Contents


@dataclass(frozen=True, eq=False)
class Request:
    """What a study asks for: the key of the case at every point, and each case by its key."""

    keys: Sequence[str]
    cases: Mapping[str, Computation]
    identities: Mapping[str, CaseIdentity]
    context: Mapping[str, str]

    @classmethod
    def of(cls, study: Study) -> "Request":
        """The cases of ``study``, of which those that differ in rounding only are one."""
        if taken := RESERVED_NAMES & {axis.name for axis in study.points}:
            raise InvalidInput(
                f"Study {study.name!r} has the axes {sorted(taken)}: these names are taken, choose others."
            )
        found: dict[Computation, tuple[str, Tree]] = {}
        memory: Memory = {}
        keys, cases, identities = [], {}, {}
        for point, case in study.visits():
            try:
                known = found.get(case)
            except TypeError:
                raise InvalidInput(_no_case(study, point, case)) from None
            if known is None:
                if not all(hasattr(case, part) for part in ("prepare", "run", "record")):
                    raise InvalidInput(_no_case(study, point, case))
                tree = canonical(case, memory)
                known = found[case] = key(tree), tree
            name, tree = known
            keys.append(name)
            if name not in cases:
                cases[name], identities[name] = case, CaseIdentity(name, tree, point_text(point))
        kinds = frozenset(type(case) for case in cases.values())
        context = dict(versions()) | {"measures": measures_fingerprint(study.measures, kinds)}
        return cls(keys, cases, identities, context)


def point_text(point: Point) -> Mapping[str, str]:
    """The values of ``point`` as the journal has them."""
    return {axis: str(canonical(value)) for axis, value in point.items()}


def _no_case(study: Study, point: Point, case: object) -> str:
    return (
        f"scene_at of study {study.name!r} gives {one_line(repr(case), 60)} at {dict(point)}: return a "
        "studies.model.case.Case, or a frozen dataclass with prepare, run and record."
    )


def recompute_reasons(
    contents: Contents, identity: CaseIdentity, context: Mapping[str, str]
) -> list[str]:
    """Why what is stored for ``identity``, or at its point, is not what is asked for."""
    found = contents.changed(identity)
    before = contents.others.get(identity.key)
    if before is None or identity.key in contents.records:
        return found
    names = sorted(before.context.keys() | context.keys())
    return found + [
        f"{name} was {before.context.get(name, 'absent')} and is {context.get(name, 'absent')}"
        for name in names
        if before.context.get(name) != context.get(name)
    ]
