"""Sealing of the answers, so that nothing reads them by accident.  README.md describes the format."""

import hashlib

SCHEMA = "stiffbench/sealed-answers/1"
PHRASE = "concealed benches of stiffbench"
WIDTH = 96


def keystream(length: int, phrase: str = PHRASE) -> bytes:
    """SHA-256 of the phrase followed by a counter, eight bytes, big-endian, from 0; block after block."""
    blocks = []
    for counter in range((length + 31) // 32):
        blocks.append(hashlib.sha256(phrase.encode() + counter.to_bytes(8, "big")).digest())
    return b"".join(blocks)[:length]


def seal(plain: bytes) -> str:
    hidden = bytes(a ^ b for a, b in zip(plain, keystream(len(plain)))).hex()
    head = [f"schema = {SCHEMA}", f"plain_bytes = {len(plain)}", f"plain_sha256 = {hashlib.sha256(plain).hexdigest()}", ""]
    return "\n".join(head + [hidden[k : k + WIDTH] for k in range(0, len(hidden), WIDTH)]) + "\n"


def unseal(text: str) -> bytes:
    head, _, body = text.partition("\n\n")
    facts = dict(line.split(" = ", 1) for line in head.splitlines())
    if facts["schema"] != SCHEMA:
        raise ValueError(f"schema {facts['schema']} is not {SCHEMA}")
    hidden = bytes.fromhex("".join(body.split()))
    plain = bytes(a ^ b for a, b in zip(hidden, keystream(len(hidden))))
    if len(plain) != int(facts["plain_bytes"]) or hashlib.sha256(plain).hexdigest() != facts["plain_sha256"]:
        raise ValueError("the sealed answers are damaged")
    return plain
