"""Cases computed in this process, one after the other."""

import os
from collections.abc import Callable, Mapping
from dataclasses import replace

from threadpoolctl import threadpool_limits

from studies.engine.workers.compute import compute, warm_up
from studies.engine.workers.interpreter_state import restored_state
from studies.model.case import Computation
from studies.model.outcome import OnFinished, RunSettings
from studies.store.fingerprint.modules import RECORDER
from studies.store.stop import Stop


def compute_here(
    cases: Mapping[str, Computation],
    settings: RunSettings,
    finished: OnFinished,
    stop: Stop,
    begins: Callable[[str], object] = lambda name: None,
) -> None:
    """Compute cases, by name, in this process, and pass each outcome to `finished`.

    A signal to stop is noticed between two cases. `begins` gets the name of each case before it begins, so that a death
    can be attributed to it.
    """
    warm_up()
    process_id = os.getpid()
    RECORDER.scan()
    with threadpool_limits(1), restored_state() as interpreter_state:
        for name, case in cases.items():
            stop.check()
            begins(name)
            interpreter_state.restore(name)
            with stop.interruptible():
                outcome = compute(case, settings)
            if os.getpid() != process_id:
                # a case has forked, and this is its child, which must not go on with the run
                os._exit(0)
            interpreter_state.restore(name)
            finished(name, replace(outcome, loaded=RECORDER.scan()))
