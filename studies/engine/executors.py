"""Executors, which compute cases: their protocol, and the one that computes in this process."""

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Protocol

import cloudpickle
from threadpoolctl import threadpool_limits

from contactstudy import InvalidInput
from studies.engine.stop import Stop
from studies.engine.workers.compute import compute, warm_up
from studies.engine.workers.interpreter_state import restored_state
from studies.engine.workers.process import Worker
from studies.model.case import Computation
from studies.model.outcome import Finished, Work
from studies.store.loaded import LOADED


class Executor(Protocol):
    """Protocol of what computes cases and calls ``finished(name, outcome)`` for each, one call at a time."""

    def run(
        self, cases: Mapping[str, Computation], work: Work, finished: Finished, stop: Stop
    ) -> None:
        """Compute cases.

        An error that `finished` raises ends the run and is raised here; outcomes that workers had by then are still
        reported.

        Parameters
        ----------
        cases
            Cases by name.
        work
            Instructions for every case.
        finished
            Called with the name and the outcome of each case.
        stop
            Raises where a signal asks to stop.
        """
        ...


def packed(work: Work) -> bytes:
    """Return `work` pickled for another process; raise InvalidInput where it cannot be pickled."""
    try:
        return bytes(cloudpickle.dumps(work))
    except Exception as error:  # noqa: BLE001 (a study's own objects may do anything)
        raise InvalidInput(
            f"measures cannot be sent to a worker process ({type(error).__name__}: {error}): keep open files "
            "and the like out of the file's top level, or run with --workers 0."
        ) from None


@dataclass(frozen=True)
class InProcess:
    """An executor that computes in this process.

    Parameters
    ----------
    begins
        Called with the name of each case before it begins, so that a death can be attributed to it.
    """

    begins: Callable[[str], object] = lambda name: None

    def run(
        self, cases: Mapping[str, Computation], work: Work, finished: Finished, stop: Stop
    ) -> None:
        """Compute the cases one after the other."""
        warm_up()
        number = os.getpid()
        LOADED.scan()
        with threadpool_limits(1), restored_state() as interpreter_state:
            for name, case in cases.items():
                stop.check()
                self.begins(name)
                interpreter_state.restore(name)
                with stop.interruptible():
                    outcome = compute(case, work)
                if os.getpid() != number:
                    # a case has forked, and this is its child, which must not go on with the run
                    os._exit(0)
                interpreter_state.restore(name)
                finished(name, replace(outcome, loaded=LOADED.scan()))


@contextmanager
def own_process(work: bytes) -> Iterator[Worker]:
    """Provide the worker process that has read the pickled `work` and ends with the block."""
    worker = Worker(work)
    try:
        yield worker
    finally:
        worker.end()
