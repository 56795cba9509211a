"""A process that computes cases for another, one after the other, until that other is gone."""

import os
import pickle
import signal
import sys
import threading
from typing import Any

from threadpoolctl import threadpool_limits

from studies.engine.workers.channel import Address, Channel, ClosedError, ForgedError
from studies.engine.workers.compute import compute, failed, timed, warm_up
from studies.engine.workers.messages import REQUEST, REQUEST_KEY, SETUP, Order, Setup
from studies.engine.workers.process import MARK, end_all, take_over
from studies.model.outcome import Outcome, Work

IDLE = 120.0  # seconds without a request after which it ends


def main() -> None:
    """Answer the supervisor's requests, in their order."""
    own = os.getpid()
    end, supervisor, leash = take_over()
    channel = Channel(end)
    if hasattr(os, "register_at_fork"):
        os.register_at_fork(after_in_child=channel.close)
    threading.Thread(target=_end_with_supervisor, args=(leash,), daemon=True).start()
    # an interrupt from outside ends the process, and is no error of the case
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        with threadpool_limits(1):
            _serve(channel, own, supervisor)
    except (ClosedError, ForgedError):
        pass
    # a case may have left threads or exit handlers, for which nobody waits
    os._exit(0)


def _serve(channel: Channel, own: int, supervisor: int) -> None:
    requests = Address(REQUEST, supervisor, REQUEST_KEY)
    work: Work | None = None
    while channel.wait(IDLE):
        for request in pickle.loads(channel.receive(requests)):
            if isinstance(request, Setup):
                problem = ""
                try:
                    sys.path[:] = request.path
                    work = pickle.loads(request.work)
                    warm_up()
                except Exception as error:  # noqa: BLE001 (a study's module may do anything)
                    problem = failed(error, "setup", 0.0).error
                answer: Any = problem
                number, key = SETUP, request.key
            else:
                assert work is not None
                answer, number, key = _answer(request, work), request.number, request.key
            if os.getpid() != own:
                # a case has forked, and this is the other one: the answer is not its to give
                os._exit(0)
            channel.send(Address(number, own, key), _packed(answer))


def _answer(order: Order, work: Work) -> Any:
    try:
        case = pickle.loads(order.case)
    except Exception as error:  # noqa: BLE001 (a study's class may do anything)
        return failed(error, "setup", 0.0)
    if order.task == "clock":
        return timed(case, order.limit)
    return compute(case, work)


def _packed(answer: Any) -> bytes:
    try:
        return pickle.dumps(answer, pickle.HIGHEST_PROTOCOL)
    except Exception as error:  # noqa: BLE001 (a measure's own class may do anything)
        seconds = answer.seconds if isinstance(answer, Outcome) else 0.0
        return pickle.dumps(failed(error, "measure", seconds))


def _end_with_supervisor(leash: int) -> None:
    """End with the other process, whatever ended it: its end of the pipe closes then."""
    try:
        os.read(leash, 1)
    finally:
        end_all(os.getpid(), os.environ.get(MARK, ""))
        os._exit(1)


if __name__ == "__main__":
    main()
