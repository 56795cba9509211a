"""One line of a journal: JSON that starts with a checksum of the rest."""

import hashlib
import json
from collections.abc import Mapping
from typing import Any

START = b'{"sum":"'
DIGITS = 16
_HEAD = len(START) + DIGITS
# what lines of the first format, which had no checksum, started with
FIRST_FORMAT = (b'{"run":', b'{"kind":', b'{"case":', b'{"begin":', b'{"time":', b'{"score":')


def encoded(line: Mapping[str, Any]) -> bytes:
    """``line`` with its checksum, as bytes that end with a line feed."""
    rest = b'",' + json.dumps(line, separators=(",", ":")).encode()[1:]
    return START + _checksum(rest) + rest + b"\n"


def decoded(raw: bytes) -> dict[str, Any] | None:
    """The line, or None where its checksum is not that of its content."""
    rest = raw[_HEAD:].rstrip(b"\n")
    if not raw.startswith(START) or raw[len(START) : _HEAD] != _checksum(rest):
        return None
    try:
        line = json.loads(b"{" + rest[2:])
    except (ValueError, RecursionError):
        return None
    return line if isinstance(line, dict) else None


def _checksum(rest: bytes) -> bytes:
    return hashlib.blake2b(rest, digest_size=DIGITS // 2).hexdigest().encode()


def short_hash(tree: object) -> str:
    """A name for what is written once and referred to: twelve digits of a hash of its JSON."""
    text = json.dumps(tree, separators=(",", ":"), sort_keys=True).encode()
    return hashlib.blake2b(text, digest_size=6).hexdigest()
