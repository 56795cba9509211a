import random
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from contactstudy import InvalidInput
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.store.journal import Journal
from studies.store.provenance import machine
from tests.campaigns.conftest import case_count
from tests.studies.conftest import quiet
from tests.studies.engine import trouble

NUMBERS = [number + 0.5 for number in range(12)]
ALONE = RunOptions(workers=0, repeats=0)
Said = dict[str, object]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    folder = tmp_path_factory.mktemp("whole")
    run(trouble.study(NUMBERS), folder, options=ALONE, log=quiet)
    return (folder / "cases.jsonl").read_bytes()


def content(path: Path) -> Said:
    journal = Journal(path, machine())
    return {
        str(key): (
            outcome.case_status,
            [(name, v.dims, v.dtype.str, v.values.tolist(), dict(v.attrs)) for name, v in outcome.variables.items()],
        )
        for key in journal.cases
        if (outcome := journal.outcome(key)) is not None
    }


def damages(raw: bytes) -> Iterator[bytes]:
    rng = random.Random(7)
    lines = raw.splitlines(keepends=True)
    for _ in range(case_count(whole=5000, thin=150)):
        flipped = bytearray(raw)
        flipped[rng.randrange(len(raw))] ^= 1 << rng.randrange(8)
        yield bytes(flipped)
    for _ in range(case_count(whole=500, thin=20)):
        at, size, number = rng.randrange(len(raw)), rng.randrange(1, 400), rng.randrange(len(lines))
        yield raw[:at] + rng.randbytes(size) + raw[at + size :]
        yield raw[:at] + raw[at + size :]
        yield raw[:at]
        zeros = b"\0" * (len(lines[number]) - 1) + b"\n"
        yield b"".join([*lines[:number], zeros, *lines[number + 1 :]])
        odd = rng.choice([b"5\n", b"[]\n", b"\n", b'{"case":[]}\n', b'{"run":{}}\n', b"[" * 9999 + b"\n"])
        yield b"".join([*lines[:number], odd, *lines[number:]])
        yield b"".join(rng.sample(lines, len(lines)))


def test_no_damage_makes_a_wrong_value(whole: bytes, tmp_path: Path) -> None:
    path = tmp_path / "cases.jsonl"
    path.write_bytes(whole)
    right = content(path)
    assert len(right) == len(NUMBERS)
    found: Said = {}
    for damaged in damages(whole):
        path.write_bytes(damaged)
        with suppress(InvalidInput):  # nothing of it is a journal
            found = content(path)
        assert found.items() <= right.items()


@pytest.mark.parametrize(
    ("name", "foreign", "refused"),
    [
        ("out/cases.jsonl", "precious without newline", "is not a journal of this program: move the file away"),
        ("out/cases.jsonl", "{}\n", "is not a journal of this program: move the file away"),
        ("precious", "precious", "it is a symbolic link, which is not followed"),
    ],
)
def test_a_file_that_is_no_journal_or_a_link_is_left_as_it_is(
    name: str, foreign: str, refused: str, tmp_path: Path
) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / name).write_text(foreign)
    if name == "precious":
        (tmp_path / "out/cases.jsonl").symlink_to(tmp_path / name)
    with pytest.raises(InvalidInput, match=refused):
        run(trouble.study([1]), tmp_path / "out", options=ALONE, log=quiet)
    assert (tmp_path / name).read_text(encoding="utf-8") == foreign
