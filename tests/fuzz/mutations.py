"""Seeded damage to the bytes of a file: the same seed gives the same damage on every machine."""

import random
import re

_NUMBERS = (
    b"-1",
    b"0",
    b"1e308",
    b"nan",
    b"-inf",
    b"99999999999",
    b"2147483648",
    b"0x10",
    b"1_0",
    b"",
    b"\xff",
)
_INTEGERS = (0, 1, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)


def mutated(content: bytes, seed: str) -> bytes:
    """The content with one to eight places changed, cut out, doubled, cut off or given another number."""
    chance, data = random.Random(seed), bytearray(content)
    for _ in range(chance.randint(1, 8)):
        _KINDS[chance.randrange(len(_KINDS))](data, chance)
    return bytes(data)


def _place(data: bytearray, chance: random.Random) -> int:
    """A place, half of the time in the first 400 bytes, where headers are."""
    end = len(data) if chance.random() < 0.5 else min(len(data), 400)
    return chance.randrange(end) if end else 0


def _change(data: bytearray, chance: random.Random) -> None:
    if data:
        data[_place(data, chance)] = chance.randrange(256)


def _cut_out(data: bytearray, chance: random.Random) -> None:
    at = _place(data, chance)
    del data[at : at + chance.randint(1, 16)]


def _double(data: bytearray, chance: random.Random) -> None:
    at = _place(data, chance)
    data[at:at] = data[at : at + chance.randint(1, 64)]


def _cut_off(data: bytearray, chance: random.Random) -> None:
    if chance.random() < 0.2:
        del data[_place(data, chance) :]


def _integer(data: bytearray, chance: random.Random) -> None:
    at, size = _place(data, chance), chance.choice((1, 2, 4, 8))
    value = chance.choice(_INTEGERS) % 256**size
    data[at : at + size] = value.to_bytes(size, chance.choice(("little", "big")))


def _number(data: bytearray, chance: random.Random) -> None:
    found = list(re.finditer(rb"[-+]?\d+(\.\d+)?", bytes(data)))
    if found:
        one = chance.choice(found[:40] if chance.random() < 0.5 else found)
        data[one.start() : one.end()] = chance.choice(_NUMBERS)


def _swap_lines(data: bytearray, chance: random.Random) -> None:
    lines = bytes(data).split(b"\n")
    first, second = chance.randrange(len(lines)), chance.randrange(len(lines))
    lines[first], lines[second] = lines[second], lines[first]
    data[:] = b"\n".join(lines)


_KINDS = (_change, _cut_out, _double, _cut_off, _integer, _number, _swap_lines)
