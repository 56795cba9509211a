"""Where cases are computed: what a run asks of an executor, and the one that computes in this process."""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import cloudpickle
from threadpoolctl import threadpool_limits

from contactstudy import InvalidInput
from studies.engine.stop import Stop
from studies.engine.workers.compute import compute, warm_up
from studies.engine.workers.supervisor import WorkerSupervisor
from studies.engine.workers.surroundings import kept_surroundings
from studies.model.case import Computation
from studies.model.outcome import CaseStatus, Finished, Outcome, Work


class Executor(Protocol):
    """Computes every case and calls ``finished(name, outcome)`` for each, one call at a time."""

    def run(
        self, cases: Mapping[str, Computation], work: Work, finished: Finished, stop: Stop
    ) -> None:
        """Compute ``cases``, by their names. What ``finished`` raises ends the run, and is raised; so does ``stop``.

        What a worker had finished by then is given to ``finished`` all the same.
        """
        ...

    def rest(self) -> None:
        """Leave the processor to others, until the next run."""
        ...


def packed(work: Work) -> bytes:
    """Pickle ``work`` for another process; raises :class:`~contactstudy.InvalidInput` where it cannot go there."""
    try:
        return bytes(cloudpickle.dumps(work))
    except Exception as error:  # noqa: BLE001 (a study's own objects may do anything)
        raise InvalidInput(
            f"measures cannot be sent to a worker process ({type(error).__name__}: {error}): keep open files "
            "and the like out of the file's top level, or run with --workers 0."
        ) from None


@dataclass(frozen=True)
class InProcess:
    """This process alone, but for ``suspects``: cases during which an earlier run died.

    ``begins(name)`` is called before each case, so that a death can be laid to it.
    """

    begins: Callable[[str], object] = lambda name: None
    suspects: frozenset[str] = frozenset()

    def run(
        self, cases: Mapping[str, Computation], work: Work, finished: Finished, stop: Stop
    ) -> None:
        """Compute one case after the other."""
        warm_up()
        number = os.getpid()
        with threadpool_limits(1), kept_surroundings() as surroundings:
            for name, case in cases.items():
                stop.check()
                if name in self.suspects:
                    _run_alone(name, case, work, finished, stop)
                    continue
                self.begins(name)
                surroundings.restore(name)
                with stop.interruptible():
                    outcome = compute(case, work)
                if os.getpid() != number:
                    # the case has forked, and this is the other one: the run is not its to go on with
                    os._exit(0)
                surroundings.restore(name)
                finished(name, outcome)

    def rest(self) -> None:
        """Do nothing: between runs there is nothing of it."""


def _run_alone(name: str, case: Computation, work: Work, finished: Finished, stop: Stop) -> None:
    """Compute one case in a process of its own."""
    supervisor = WorkerSupervisor(packed(work))
    try:
        with stop.interruptible():
            outcomes = list(supervisor.run(cloudpickle.dumps((case,)), [name]))
        for outcome in outcomes:
            finished(name, _with_advice(outcome))
    finally:
        supervisor.end()


def _with_advice(outcome: Outcome) -> Outcome:
    """Add to the failure of a case that died that it needs a process of its own."""
    if outcome.case_status is not CaseStatus.KILLED or outcome.failure is None:
        return outcome
    sentence = (
        f"{outcome.failure.sentence}; it needs a process of its own, since an earlier run in one process "
        "ended with it"
    )
    return replace(outcome, failure=replace(outcome.failure, sentence=sentence))
