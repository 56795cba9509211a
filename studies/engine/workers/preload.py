"""What a worker process needs, loaded once by the process that worker processes are forked from."""

from studies.engine.workers import worker
from studies.engine.workers.compute import warm_up
from studies.store.fingerprint.modules import RECORDER

__all__ = ["worker"]

warm_up()
RECORDER.scan()
