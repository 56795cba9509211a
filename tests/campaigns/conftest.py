"""Campaigns: many kills, much damage, much nonsense. A few of each by default, all of them with
``CONTACTSTUDY_CAMPAIGNS=whole python -m pytest tests/campaigns``."""

import os
import signal

# they limit, stop and kill processes as POSIX alone can
collect_ignore_glob = [] if hasattr(signal, "SIGKILL") else ["test_*.py"]
IS_WHOLE = os.environ.get("CONTACTSTUDY_CAMPAIGNS") == "whole"


def case_count(whole: int, thin: int) -> int:
    return whole if IS_WHOLE else thin
