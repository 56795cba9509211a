import itertools
import random
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from studies.model.outcome import CaseStatus
from tests.campaigns.conftest import case_count
from tests.campaigns.victim import CASES
from tests.conftest import HANGS

ROOT = Path(__file__).parents[2]
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
# whom, at which event of which phase, with how many workers
PLACES = (
    ("parent", "solving", CASES, 2), ("worker", "solving", CASES, 2), ("server", "solving", CASES, 2),
    ("parent", "timing", CASES, 2), ("worker", "timing", CASES, 2), ("parent", "writing", 3, 2),
    ("parent", "drawing", 1, 2), ("parent", "solving", CASES, 0), ("parent", "writing", 3, 0),
)  # fmt: skip
KILLS = [
    (target, number, phase, 1 + draw % most, workers)
    for (target, phase, most, workers), number, draw in itertools.islice(
        zip(
            itertools.cycle(PLACES),
            itertools.cycle(SIGNALS[:2] + SIGNALS),
            (random.Random(1).randrange(1000) for _ in itertools.count()),
            strict=False,
        ),
        case_count(whole=200, thin=4),
    )
]


def start(*words: object) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "tests.campaigns.victim", *map(str, words)],
        cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip


def ended(process: subprocess.Popen[str]) -> str:
    """What it said, once it and all it started have closed their output: nobody is left."""
    with process:
        try:
            said, _ = process.communicate(timeout=HANGS)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
    return said


def examine(folder: Path) -> None:
    dataset = xr.load_dataset(folder / "victim.nc")
    assert (dataset["case_status"] == CaseStatus.OK).all()
    np.testing.assert_array_equal(dataset["square"], dataset["number"] ** 2)
    np.testing.assert_array_equal(
        dataset["powers"], dataset["number"].values[:, None] ** np.arange(3.0)
    )
    assert np.isfinite(dataset["solve_time"]).all()
    left = [path.name for path in folder.rglob(".*")]
    assert left == [], left
    assert not list(folder.glob("*.damaged"))
    assert (folder / "victim" / "squares.png").is_file()


@pytest.mark.whole
@pytest.mark.parametrize(
    ("target", "number", "phase", "count", "workers"),
    KILLS,
    ids=lambda part: part.name if isinstance(part, signal.Signals) else str(part),
)
def test_after_a_kill_the_same_command_ends_with_every_number(
    target: str, number: signal.Signals, phase: str, count: int, workers: int, tmp_path: Path
) -> None:
    words = (tmp_path, target, int(number), phase, count, workers)
    first = start(*words)
    said = ended(first)
    assert (tmp_path / "events" / "killed").exists()
    if target in ("worker", "server"):  # the run itself goes on
        assert first.returncode == 0, said
    else:
        assert first.returncode != 0
    if number is not signal.SIGINT:  # the script lets KeyboardInterrupt pass, as any script does
        assert "Traceback" not in said
    second = start(*words)
    said = ended(second)
    assert second.returncode == 0, said
    assert "Traceback" not in said
    examine(tmp_path)
    # computed, timed, and perhaps run untimed before; once more where it was in hand or on its way
    most = max(path.stat().st_size for path in (tmp_path / "events").glob("case*"))
    assert most <= 2 * 3
