"""What a worker process needs, loaded once by the fork server."""

from studies.engine.workers import worker
from studies.engine.workers.compute import warm_up
from studies.store.fingerprint.modules import RECORDER

__all__ = ["worker"]

warm_up()
RECORDER.scan()
