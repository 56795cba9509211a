"""Program of a worker process, which computes cases for its supervisor, one after the other."""

import os
import pickle
import signal
import sys
import threading
from typing import Any

from threadpoolctl import threadpool_limits

from studies.engine.workers.channel import (
    EXIT_CODE,
    FORK,
    REQUEST,
    SETUP,
    UNREAD,
    Batch,
    Channel,
    ClosedError,
    ForgedError,
    Setup,
)
from studies.engine.workers.compute import compute, failed, timed, warm_up
from studies.engine.workers.process import (
    CAN_FORK,
    MARK,
    end_all,
    exit_code,
    fork,
    release,
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
        self._supervisor, self._leash = supervisor, leash
        self._work: Work | None = None
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=channel.close)
        # a keeper finds its channel closed; a thread of its own would be lost in a fork
        if not is_keeper:
            threading.Thread(target=self._end_with_supervisor, daemon=True).start()

    def serve(self) -> None:
        """Answer requests until the channel is closed, or none comes for a long time."""
        try:
            while self._channel.poll(IDLE):
                self._answer(self._channel.receive(REQUEST, self._supervisor))
        except (ClosedError, ForgedError):
            pass
        # a case may have left threads or exit handlers, for which nobody waits
        os._exit(0)

    def _answer(self, request: Setup | str | Batch) -> None:
        """Carry out a request, and send the answer."""
        match request:
            case Setup():
                self._channel.send(SETUP, self._set_up(request))
            case Batch():
                self._compute(request)
            case _:
                self._fork()

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

    def _fork(self) -> None:
        """Fork a process that serves the socket sent next; answer its number, and its exit code once it has ended."""
        end = self._channel.receive_socket()
        number = fork()
        if number == 0:
            worker = _Worker(Channel(end), self._supervisor, self._leash, is_keeper=False)
            worker._work, worker._surroundings = self._work, self._surroundings
            worker.serve()
        end.close()
        self._channel.send(FORK, number)
        self._channel.send(EXIT_CODE, exit_code(number))
        self._channel.poll(IDLE)  # the supervisor ends what the fork has left, by its number
        release(number)

    def _compute(self, batch: Batch) -> None:
        """Compute or time the cases of a batch, and send an answer for each."""
        cases: Any
        try:
            cases, unreadable = pickle.loads(batch.cases), None
        except Exception as error:  # noqa: BLE001 (a study's class may do anything)
            is_alone = batch.first + 1 == len(batch.names)
            unreadable = failed(error, "setup" if is_alone else UNREAD, 0.0)
        for place in range(batch.first, len(batch.names)):
            self._surroundings.restore(batch.names[place])
            answer = unreadable or self._outcome(cases[place], batch)
            if os.getpid() != self._number:
                # a case has forked, and this is its child, which must not answer
                os._exit(0)
            self._send((batch.number, place), answer)

    def _outcome(self, case: Any, batch: Batch) -> Any:
        """Return the outcome of a case, or its times."""
        if batch.task == "clock":
            return timed(case, batch.limit)
        assert self._work is not None
        return compute(case, self._work)

    def _send(self, subject: object, answer: Any) -> None:
        """Send an answer, or a failure where it cannot be pickled."""
        try:
            self._channel.send(subject, answer)
        except ClosedError:
            raise
        except Exception as error:  # noqa: BLE001 (a measure's own class may do anything)
            seconds = answer.seconds if isinstance(answer, Outcome) else 0.0
            self._channel.send(subject, failed(error, "measure", seconds))

    def _end_with_supervisor(self) -> None:
        """End this process when the supervisor ends, whose end of the pipe closes then."""
        try:
            os.read(self._leash, 1)
        finally:
            end_all(os.getpid(), os.environ.get(MARK, ""))
            os._exit(1)


if __name__ == "__main__":
    main()
