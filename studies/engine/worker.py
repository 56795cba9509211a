"""A process that computes cases for another, one after the other, until that other is gone."""

import os
import pickle
import sys
import threading
from multiprocessing.connection import Connection

from threadpoolctl import threadpool_limits

from studies.model.outcome import CaseStatus, Failure, Outcome, Work, compute, warm_up

IDLE = 120.0  # seconds without work after which it ends


def main() -> None:
    """Take the other's paths and the work, say that all is there, then answer case by case."""
    threading.Thread(target=_exit_with_parent, daemon=True).start()
    connection = Connection(int(sys.argv[1]))
    sys.path[:] = connection.recv()
    work = connection.recv()
    warm_up()
    connection.send("ready")
    try:
        with threadpool_limits(1):
            while connection.poll(IDLE):
                message = pickle.loads(connection.recv_bytes())
                if isinstance(message, Work):
                    work = message
                    connection.send("ready")
                    continue
                for case in message:
                    connection.send_bytes(_pickled(compute(case, work)))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        pass


def _pickled(outcome: Outcome) -> bytes:
    try:
        return pickle.dumps(outcome, pickle.HIGHEST_PROTOCOL)
    except (pickle.PicklingError, TypeError, AttributeError) as error:
        sentence = f"{type(error).__name__} in sending the measures: {error}"
        failure = Failure(type(error).__name__, sentence, "measure")
        return pickle.dumps(Outcome(CaseStatus.FAILED, {}, failure, outcome.seconds))


def _exit_with_parent() -> None:
    """End with the other process, whatever ended it: its end of standard input closes then."""
    os.read(0, 1)
    os._exit(1)


if __name__ == "__main__":
    main()
