"""Program of a worker process, which computes cases for its supervisor, one after the other."""

import os
import pickle
import signal
import sys
import threading
from typing import Any

from threadpoolctl import threadpool_limits

from studies.engine.workers.channel import (
    ENDING,
    FORK,
    REQUEST,
    REQUEST_KEY,
    SETUP,
    UNREAD,
    Address,
    Batch,
    Channel,
    ClosedError,
    Ending,
    ForgedError,
    Fork,
    Order,
    Setup,
)
from studies.engine.workers.compute import compute, failed, timed, warm_up
from studies.engine.workers.process import (
    CAN_FORK,
    MARK,
    end_all,
    exit_code,
    fork,
    runs,
    take_over,
)
from studies.engine.workers.surroundings import Surroundings
from studies.model.outcome import Outcome, Work

IDLE = 120.0  # seconds without a request after which it ends


def main() -> None:
    """Answer the supervisor's requests in order."""
    end, supervisor, leash = take_over()
    # an interrupt from outside ends the process, and is no error of the case
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    with threadpool_limits(1):
        _Worker(Channel(end), supervisor, leash, is_keeper=CAN_FORK).serve()


class _Worker:
    """A process that serves a channel: a keeper, its fork, or, where there are no forks, both in one."""

    def __init__(self, channel: Channel, supervisor: int, leash: int, *, is_keeper: bool) -> None:
        self._channel, self._number = channel, os.getpid()
        self._requests = Address(REQUEST, supervisor, REQUEST_KEY)
        self._leash = leash
        self._fork: int | None = None
        self._work: Work | None = None
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=channel.close)
        if (
            not is_keeper
        ):  # a keeper finds its channel closed; a thread of its own would be lost in a fork
            threading.Thread(target=self._end_with_supervisor, daemon=True).start()

    def serve(self) -> None:
        """Answer requests until the channel is closed, or none comes for a long time."""
        try:
            while (is_asked := self._channel.wait(IDLE)) or runs(self._fork):
                for request in (
                    pickle.loads(self._channel.receive(self._requests)) if is_asked else ()
                ):
                    self._answer(request)
        except (ClosedError, ForgedError):
            pass
        # a case may have left threads or exit handlers, for which nobody waits
        os._exit(0)

    def _answer(self, request: Setup | Fork | Ending | Batch) -> None:
        """Carry out a request, and send the answer."""
        match request:
            case Setup():
                self._send(SETUP, request.key, self._set_up(request))
            case Fork():
                self._fork = self._begin_fork()
                self._send(FORK, request.key, self._fork)
            case Ending():
                self._send(ENDING, request.key, exit_code(request.process))
                self._fork = None
            case Batch():
                self._compute(request)

    def _set_up(self, request: Setup) -> str:
        """Read the study; return why it cannot be read, or an empty text."""
        try:
            sys.path[:] = request.path
            self._work = pickle.loads(request.work)
            warm_up()
        except Exception as error:  # noqa: BLE001 (a study's module may do anything)
            return failed(error, "setup", 0.0).error
        self._surroundings = Surroundings.now()
        return ""

    def _begin_fork(self) -> int:
        """Fork a process that computes what comes through the socket that the supervisor sends now."""
        end = self._channel.receive_socket()
        supervisor = self._requests.process
        number = fork()
        if number == 0:
            worker = _Worker(Channel(end), supervisor, self._leash, is_keeper=False)
            worker._work, worker._surroundings = self._work, self._surroundings
            worker.serve()
        end.close()
        return number

    def _compute(self, batch: Batch) -> None:
        """Carry out the orders of a batch, and send an answer to each."""
        cases: Any
        try:
            cases, unreadable = pickle.loads(batch.cases), None
        except Exception as error:  # noqa: BLE001 (a study's class may do anything)
            is_alone = len(batch.orders) == 1
            unreadable = failed(error, "setup" if is_alone else UNREAD, 0.0)
        for order in batch.orders:
            self._surroundings.restore(order.name)
            answer = unreadable or self._outcome(cases[order.place], order)
            if os.getpid() != self._number:
                # a case has forked, and this is the other one: the answer is not its to give
                os._exit(0)
            self._send(order.place, order.key, answer)

    def _outcome(self, case: Any, order: Order) -> Any:
        """Return the outcome of a case, or its times."""
        if order.task == "clock":
            return timed(case, order.limit)
        assert self._work is not None
        return compute(case, self._work)

    def _send(self, place: int, key: bytes, answer: Any) -> None:
        """Send an answer, or a failure where it cannot be pickled."""
        try:
            body = pickle.dumps(answer, pickle.HIGHEST_PROTOCOL)
        except Exception as error:  # noqa: BLE001 (a measure's own class may do anything)
            seconds = answer.seconds if isinstance(answer, Outcome) else 0.0
            body = pickle.dumps(failed(error, "measure", seconds))
        self._channel.send(Address(place, self._number, key), body)

    def _end_with_supervisor(self) -> None:
        """End this process when the supervisor ends, whose end of the pipe closes then."""
        try:
            os.read(self._leash, 1)
        finally:
            end_all(os.getpid(), os.environ.get(MARK, ""))
            os._exit(1)


if __name__ == "__main__":
    main()
