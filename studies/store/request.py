"""Requests of studies: their cases and keys, and what these are computed with."""

import re
import secrets
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import cloudpickle

from contactstudy import InvalidInput
from contactstudy.domain.identity import CanonicalMemo, canonical, keys, text
from studies.model.case import Computation
from studies.model.outcome import RESERVED_NAMES
from studies.model.plain_text import shortened
from studies.model.study import Point, Study
from studies.store.fingerprint.functions import States
from studies.store.fingerprint.modules import RECORDER, digest, is_older
from studies.store.fingerprint.numerical_part import numerical_part
from studies.store.records import CaseIdentity, Context, without_garbage_collection

SESSION = secrets.token_hex(8)  # stands for code that this process alone can know
CLASS = re.compile(r'"":"([^"]+)"')  # the name of a class in the JSON of a tree


@dataclass(frozen=True, eq=False)
class Request:
    """Cases that a study requests: the key at every point, and each case and its identity by its key.

    Its `context` is what the cases are computed with: the part of the study, and what would be loaded now.
    """

    keys: Sequence[str]
    cases: Mapping[str, Computation]
    identities: Mapping[str, CaseIdentity]
    context: Context

    @classmethod
    @without_garbage_collection()
    def of(cls, study: Study) -> "Request":
        """Return the request of a study; each distinct case is made once.

        Raises
        ------
        InvalidInput
            For an axis with a reserved name, a computation that lacks a method, and measures whose state cannot be seen.
        """
        if reserved := RESERVED_NAMES & {axis.name for axis in study.axes}:
            raise InvalidInput(
                f"Study {study.name!r} has the axes {sorted(reserved)}: these names are taken, choose others."
            )
        states = CaseStates()
        keys, cases, identities = [], {}, {}
        for point, case in study.visits():
            if not all(hasattr(case, part) for part in ("prepare", "run", "record")):
                raise InvalidInput(
                    f"case_at of study {study.name!r} gives {shortened(case)} at {dict(point)}: return a "
                    "studies.model.case.Case, or a frozen dataclass with prepare, run and record."
                )
            identity = states.identity(point, case)
            keys.append(identity.key)
            if identity.key not in cases:
                cases[identity.key], identities[identity.key] = case, identity
        return cls(keys, cases, identities, Context(study_part(study, states.states)))


class CaseStates:
    """Identities of cases, and states of their classes, each taken once."""

    def __init__(self) -> None:
        self.states, self._memory = States(), CanonicalMemo()
        self._digests: dict[frozenset[str], str] = {}

    def identity(self, point: Point, case: object) -> CaseIdentity:
        """Return the identity of the case at a point."""
        tree, kinds_by_name = canonical(case, self._memory), self._memory.kinds
        names = frozenset(CLASS.findall(text(tree)))
        if names not in self._digests:
            kinds = [kinds_by_name[name] for name in sorted(names) if name in kinds_by_name]
            state = text([self.states.of_class(kind) for kind in kinds])
            self._digests[names] = digest(state.encode())
        about = {axis: str(value) for axis, value in point.items()}
        return CaseIdentity(*keys(tree), tree, about, self._digests[names])


def study_part(study: Study, states: States) -> dict[str, str]:
    """Return digests of what a study's numbers come from besides the modules that its cases load.

    These are the state of its measures, the statements of its file that can change a number, a script or a module that
    is sent to workers as it is, and the files that it depends on. Code that was typed at a prompt is known in this
    process alone.

    Raises
    ------
    InvalidInput
        For a file that cannot be read, and for measures whose state cannot be seen.
    """
    part = {"measures": digest(text(states.state_of(study.measures)).encode())}
    case_at = getattr(study.case_at, "__module__", "")
    sent = cloudpickle.list_registry_pickle_by_value()
    for name in states.modules | ({case_at} - {"__main__"}):
        module = sys.modules.get(name)
        source = getattr(module, "__source__", None)
        if isinstance(source, bytes):
            part[f"study file {Path(str(getattr(module, '__file__', name))).name}"] = (
                numerical_part(source)
            )
        elif name == "__main__":
            part[name] = _script(getattr(module, "__file__", None))
        elif name in sent:
            part[f"module {name}"] = RECORDER.scan().get(f"module {name}", SESSION)
    for name in study.depends:
        try:
            part[f"file {name}"] = digest((study.folder / name).read_bytes())
        except (OSError, ValueError) as error:
            raise InvalidInput(
                f"Study {study.name!r} depends on the file {name!r}, which cannot be read ({error}): correct 'depends'."
            ) from None
    return part


def _script(file: str | None) -> str:
    """Return a digest of the script that runs; at a prompt, or where it has been edited since, one of this process."""
    try:
        path = Path(file or "")
        return digest(path.read_bytes()) if is_older(path, RECORDER.started) else SESSION
    except OSError:
        return SESSION
