"""Worker processes that leave Ctrl-C to their parent."""

import signal
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import active_children
from multiprocessing.context import SpawnContext, SpawnProcess


class _DeafProcess(SpawnProcess):
    def start(self) -> None:
        # A terminal sends Ctrl-C to every process of the group. The mask is inherited, so that the
        # child is deaf from its first instruction, before any code of ours could run in it.
        held = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, held)


class _DeafContext(SpawnContext):
    Process = _DeafProcess


@contextmanager
def process_pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """``workers`` processes, which end at once where the block ends in an error or an interrupt.

    Spawned, since a fork would copy the state of threads.
    """
    pool = ProcessPoolExecutor(workers, mp_context=_DeafContext())
    try:
        yield pool
    except BaseException:
        for child in active_children():
            if isinstance(child, _DeafProcess):
                child.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
