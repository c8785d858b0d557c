"""The unit under test: frames on its line, its silences and restarts."""

import logging
import queue
import re
import socket
import threading
import time
from binascii import crc32, crc_hqx
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, reduce
from operator import xor
from pathlib import Path
from typing import Protocol

import numpy as np
from pymodbus.framer import FramerRTU

from schemas.base import Unusable
from schemas.recording import Stream
from schemas.unit_link import (
    CHECK_BYTES,
    SIZES,
    AnyFrame,
    BinaryField,
    BinaryFrame,
    Check,
    FrameField,
    TextFrame,
    UnitLink,
)
from tasks.station.clock import wall_s
from tasks.station.drivers.backend import READ_BYTES, READ_TIMEOUT_S, unit_port
from tasks.station.drivers.modbus import host_and_port
from tasks.station.drivers.text_device import NUMBER
from tasks.station.ports import Line
from tasks.words import message

# The unit's line, read by a thread so that no byte is lost while the run is busy.

LOG = logging.getLogger("mimucal.station.unit")


class Source(Protocol):
    """Where bytes come from. Both raise OSError where nothing more will come."""

    def read(self, most: int, /) -> bytes:
        """What has come, after READ_TIMEOUT_S at the latest."""

    def close(self) -> None: ...


class UnitLine:
    """Reads from when it is made until it is closed. Raises Unusable where it cannot be opened."""

    def __init__(self, link: UnitLink) -> None:
        self._link = link
        self._chunks: queue.SimpleQueue[tuple[float, bytes]] = queue.SimpleQueue()
        self._done = threading.Event()
        self.broken: str | None = None
        try:
            self._source = _opened(link)
        except (OSError, ValueError) as error:  # pyserial's own is an OSError
            raise Unusable(
                f"the unit's line {link.url} cannot be opened ({error}): check the cable "
                f"and unit_link.url of the station file",
                message("station-cause.line", unit=link.url),
            ) from error
        LOG.info("opened", extra={"of": link.url})
        self._thread = threading.Thread(target=self._read, name="unit", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Read to the end, and hang up."""
        self.end()
        self._source.close()

    def end(self) -> None:
        """Read what is on the line now, and no more."""
        self._done.set()
        self._thread.join()

    def received(self) -> tuple[bytes, float]:
        """What came since the last call, and the time.monotonic() at which the last came."""
        chunks = []
        arrived_s = 0.0
        while not self._chunks.empty():
            arrived_s, chunk = self._chunks.get_nowait()
            chunks.append(chunk)
        return b"".join(chunks), arrived_s

    def _read(self) -> None:
        while not self._done.is_set():
            try:
                chunk = self._source.read(READ_BYTES)
            except OSError as error:
                self.broken = (
                    f"the unit's line {self._link.url} broke ({error}): check the unit and the "
                    f"cable"
                )
                LOG.error("broken", extra={"of": self._link.url, "cause": str(error)})
                return
            if chunk:
                self._chunks.put((time.monotonic(), chunk))


def _opened(link: UnitLink) -> Source:
    if link.url.startswith("udp://"):
        return _Udp(link.url)
    if link.url.startswith("file://"):
        return _File(Path(link.url.removeprefix("file://")))
    return _Serial(link)


class _Serial:
    """A serial line or a TCP connection, whatever pyserial opens."""

    def __init__(self, link: UnitLink) -> None:
        self._port = unit_port(link)

    def read(self, most: int) -> bytes:
        """What has come; a socket of pyserial does not tell how much that is."""
        data: bytes = self._port.read(most)
        return data

    def close(self) -> None:
        self._port.close()


class _Udp:
    """Datagrams sent to an address of this machine."""

    def __init__(self, url: str) -> None:
        address = host_and_port(url.replace("udp://", "socket://", 1))
        assert address is not None
        family = socket.AF_INET6 if ":" in address[0] else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.bind(address)
        except OSError:
            self._socket.close()
            raise
        self._socket.settimeout(READ_TIMEOUT_S)

    def read(self, most: int) -> bytes:
        """The next datagram, if one comes."""
        try:
            return self._socket.recv(most)
        except TimeoutError:
            return b""

    def close(self) -> None:
        self._socket.close()


class _File:
    """A file that another program is writing, from its end on."""

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            raise OSError("there is no such file")
        self._file = path.open("rb")
        self._file.seek(0, 2)

    def read(self, most: int) -> bytes:
        """What was written since."""
        data = self._file.read(most)
        if not data:
            time.sleep(READ_TIMEOUT_S)
        return data

    def close(self) -> None:
        self._file.close()


# The unit's samples decoded from its frames, of either kind.

COUNTER_TURN = 2**32
NO_COUNTER = -1
LAST_STAMP_US = 2.0**62


def sample_type(frame: AnyFrame) -> np.dtype:
    """A numpy record: counter, stamp (µs since power-on) and the channels' values in SI."""
    return np.dtype(
        [("counter", "<i8"), ("stamp", "<i8"), ("values", "<f8", (len(frame.channels),))]
    )


def no_samples(frame: AnyFrame) -> np.ndarray:
    """None at all, (0,)."""
    return np.empty(0, sample_type(frame))


@dataclass(frozen=True)
class FrameSearch:
    """What was found in some bytes: samples (n,), how many frames were bad, and bytes left over."""

    samples: np.ndarray
    bad: int
    rest: bytes


def to_stream(samples: np.ndarray, frame: AnyFrame, shift_us: int = 0) -> Stream:
    """Samples over their own time stamps, moved by `shift_us`."""
    columns = dict(zip(frame.channels, samples["values"].T, strict=True))
    return Stream((samples["stamp"] + shift_us) / 1e6, columns)


def counter_turn(frame: AnyFrame) -> int:
    """The number of frames after which the counter wraps; that of 32 bits if unknown."""
    bits = _bits(frame, "counter")
    return COUNTER_TURN if bits is None else min(2**bits, COUNTER_TURN)


def stamp_turn_us(frame: AnyFrame) -> int | None:
    """The time after which the time stamp wraps, µs; None if it does not within a lifetime."""
    bits = _bits(frame, "time")
    if bits is None or bits > 32:
        return None
    factor = next(field.factor for field in frame.fields if field.name == "time")
    return round(2**bits * factor * 1e6)


def _bits(frame: AnyFrame, name: str) -> int | None:
    if isinstance(frame, TextFrame):
        return None
    field = next((field for field in frame.fields if field.name == name), None)
    if field is None or field.type.startswith("float"):
        return None
    return 8 * SIZES[field.type] - field.type.startswith("int")


def filled(frame: AnyFrame, raw: dict[str, np.ndarray], n: int) -> np.ndarray:
    """Samples (n,) from the raw values of each field, (n,) each; stamps are -1 if there are
    none.
    """
    samples = np.empty(n, sample_type(frame))
    fields: dict[str, FrameField] = {field.name: field for field in frame.fields}
    samples["counter"] = raw.get("counter", NO_COUNTER)
    samples["stamp"] = -1
    if "time" in raw:
        stamps = np.rint(raw["time"] * (fields["time"].factor * 1e6))
        is_time = np.abs(stamps) < LAST_STAMP_US  # nan is none
        samples["stamp"] = np.where(is_time, stamps, 0)
    for place, name in enumerate(frame.channels):
        samples["values"][:, place] = raw[name] * fields[name].factor
    return samples[is_time] if "time" in raw else samples


# Frames of the unit, binary or lines of text: found in a byte stream, checked and decoded.

MOST_BYTES = 4096  # of a line; what is longer is no line
CHECK_DIGITS = {"xor8": 2, "crc16_xmodem": 4}


def find_binary(data: bytes, frame: BinaryFrame) -> FrameSearch:
    """Every frame with a correct checksum, wherever it starts.

    `rest` goes before the next bytes. Bytes of a frame's length that begin with the sync bytes,
    have a wrong checksum and overlap no good frame count as a bad frame. The search continues at
    the next byte, so that garbage costs no frame whose own bytes are intact.
    """
    size = frame.size
    if len(data) < size:
        return FrameSearch(no_samples(frame), 0, data)
    octets = np.frombuffer(data, np.uint8)
    starts = _sync_places(octets, frame)
    rows = np.lib.stride_tricks.sliding_window_view(octets, size)[starts]
    good = _is_good(rows, frame)
    taken = _without_overlap(starts[good], size)
    samples = _read(octets[taken[:, None] + np.arange(size)], frame)
    end = int(taken[-1]) + size if len(taken) else 0
    # two frames long, so that what a bad one touches is known when it is counted
    rest_from = max(end, len(data) - 2 * size + 1, 0)
    bad = _apart(starts[~good & (starts < rest_from)], taken, size)
    return FrameSearch(samples, bad, data[rest_from:])


def _is_good(rows: np.ndarray, frame: BinaryFrame) -> np.ndarray:
    width = CHECK_BYTES[frame.check]
    stated = np.zeros(len(rows), np.uint64)
    order = frame.check_byte_order or frame.byte_order
    places = range(width) if order == "big" else reversed(range(width))
    for place in places:
        stated = (stated << np.uint64(8)) | rows[:, rows.shape[1] - width + place]
    return np.asarray(check_sums(frame.check, rows[:, frame.check_from : -width]) == stated)


def _read(rows: np.ndarray, frame: BinaryFrame) -> np.ndarray:
    """Samples (n,) of rows of octets, (n, size)."""
    raw, start = {}, len(frame.sync_bytes)
    for field in frame.fields:
        end = start + SIZES[field.type]
        octets = np.ascontiguousarray(rows[:, start:end])
        raw[field.name] = octets.view(_type(field, frame))[:, 0]
        start = end
    return filled(frame, raw, len(rows))


def _type(field: BinaryField, frame: BinaryFrame) -> np.dtype:
    return np.dtype(field.type).newbyteorder("<" if frame.byte_order == "little" else ">")


def _sync_places(octets: np.ndarray, frame: BinaryFrame) -> np.ndarray:
    last = len(octets) - frame.size + 1
    is_sync = np.ones(last, bool)
    for place, octet in enumerate(frame.sync_bytes):
        is_sync &= octets[place : last + place] == octet
    return np.flatnonzero(is_sync)


def _without_overlap(starts: np.ndarray, size: int) -> np.ndarray:
    """Of good frames that overlap, the last: one whose end was lost may run into it by chance."""
    if np.all(np.diff(starts) >= size):
        return starts
    taken: list[int] = []
    for start in reversed(starts.tolist()):
        if not taken or start + size <= taken[-1]:
            taken.append(start)
    return np.array(taken[::-1], dtype=starts.dtype)


def _apart(places: np.ndarray, taken: np.ndarray, size: int) -> int:
    """How many of the places are a frame's length or more from every frame taken."""
    apart = np.abs(places[:, None] - taken).min(axis=1, initial=size)
    return int(np.count_nonzero(apart >= size))


def check_sums(kind: Check, rows: np.ndarray) -> np.ndarray:
    """The check sum of each row of octets, (n, k) -> (n,) uint64."""
    return np.array([CHECKS[kind](row.tobytes()) for row in rows], np.uint64)


def _crc16_modbus(octets: bytes) -> int:
    low_first = FramerRTU.compute_CRC(octets)
    return low_first >> 8 | (low_first & 0xFF) << 8


CHECKS: dict[str, Callable[[bytes], int]] = {
    "sum8": lambda octets: sum(octets) & 0xFF,
    "xor8": lambda octets: reduce(xor, octets, 0),
    "crc16_xmodem": lambda octets: crc_hqx(octets, 0),
    "crc16_ccitt_false": lambda octets: crc_hqx(octets, 0xFFFF),
    "crc16_modbus": _crc16_modbus,
    "crc32": crc32,
}


def find_text(data: bytes, frame: TextFrame) -> FrameSearch:
    """Every whole line that matches the frame and has a correct checksum.

    `rest` goes before the next bytes. If frames have no checksum, a line counts only after the end
    of another: the beginning of the first one may be missing.
    """
    end = frame.terminator.encode()
    *lines, rest = data.split(end)
    found: list[tuple[float, ...]] = []
    bad = 0
    for place, line in enumerate(lines):
        values = _values(line, frame)
        is_whole = frame.check != "none" or place > 0
        if values is not None and is_whole:
            found.append(values)
        elif (is_whole and frame.start and frame.start.encode() in line) or (
            is_whole and not frame.start and line
        ):
            bad += 1
    if frame.check == "none" and lines:
        rest = end + rest
    return FrameSearch(_samples(found, frame), bad, rest[-MOST_BYTES:])


def _samples(found: list[tuple[float, ...]], frame: TextFrame) -> np.ndarray:
    if not found:
        return no_samples(frame)
    columns = np.array(found).T
    raw = {field.name: column for field, column in zip(frame.fields, columns, strict=True)}
    return filled(frame, raw, len(found))


def _values(line: bytes, frame: TextFrame) -> tuple[float, ...] | None:
    """The numbers of a line, None where it is no good frame; what is before it does not count."""
    if frame.start:
        begin = line.rfind(frame.start.encode())
        if begin < 0:
            return None
        line = line[begin:]
    match = _pattern(frame).fullmatch(line)
    if match is None:
        return None
    *texts, stated = match.groups() if frame.check != "none" else (*match.groups(), b"")
    if frame.check != "none" and int(stated, 16) != _check(line, frame):
        return None
    values = tuple(map(float, texts))
    return values if np.isfinite(values).all() else None


def _check(line: bytes, frame: TextFrame) -> int:
    return CHECKS[frame.check](line[line[:1] in (b"$", b"!") : line.rindex(b"*")])


@lru_cache
def _pattern(frame: TextFrame) -> re.Pattern[bytes]:
    blank = frame.separator == " "
    separator = b" +" if blank else b" *" + re.escape(frame.separator.encode()) + b" *"
    fields = separator.join(
        re.escape(field.prefix.encode()) + rb"(" + NUMBER.encode() + rb")" for field in frame.fields
    )
    check = b""
    if frame.check != "none":
        check = rb"\*([0-9a-fA-F]{%d})" % CHECK_DIGITS[frame.check]
    start = re.escape(frame.start.encode())
    return re.compile(start + b" *" + fields + b" *" + check + rb"\r?")


LONGEST_STEP_US = 3_000_000
STEPS = 10  # of a slow unit, that a step may be long
SILENCE_S = 3.0
LOOK_S = 0.5


class StampSequence:
    """Takes the samples found, and returns those with consistent stamps.

    A sample whose stamp does not follow the previous one counts only if the next one follows it:
    the unit was silent, or was restarted. Otherwise garbage happened to look like a frame, and
    `rejected` counts it. Stamps continue where the unit's own wrap; without a stamp in the frame
    they are those of the counter, at the rate of the link, or of arrival.
    """

    def __init__(self, link: UnitLink) -> None:
        self.rejected = 0
        self._link = link
        self._turn_us = self._turn()
        self._longest_us = max(LONGEST_STEP_US, STEPS * 1e6 / link.rate_hz)
        self._held = no_samples(link.frame)
        self._last_us: int | None = None  # as the unit tells it
        self._own_us: int | None = None  # of the last sample given
        self._before_us = 0  # what it has turned over by

    def _turn(self) -> int | None:
        if not self._link.frame.has("time") and self._link.frame.has("counter"):
            return round(counter_turn(self._link.frame) * 1e6 / self._link.rate_hz)
        return stamp_turn_us(self._link.frame)

    def take(self, samples: np.ndarray, arrived_s: float) -> np.ndarray:
        """The samples (n,) whose place is known now; the last may be kept for the next call."""
        self._stamp(samples, arrived_s)
        waiting = np.concatenate([self._held, samples])
        kept = self._following(waiting)
        self._run_on(kept)
        return kept

    def _stamp(self, samples: np.ndarray, arrived_s: float) -> None:
        """Stamps for frames that have none. Those that came together are a period apart."""
        period_us = 1e6 / self._link.rate_hz
        if self._link.frame.has("time"):
            return
        if self._link.frame.has("counter"):
            samples["stamp"] = np.rint(samples["counter"] * period_us)
            return
        back = np.arange(len(samples) - 1, -1, -1)
        samples["stamp"] = np.rint(arrived_s * 1e6 - back * period_us)
        if self._last_us is not None and len(samples):
            late_us = self._last_us + 1 - int(samples["stamp"][0])
            samples["stamp"] += max(late_us, 0)

    def _following(self, waiting: np.ndarray) -> np.ndarray:
        stamps = waiting["stamp"]
        if self._last_us is not None:
            before = np.concatenate([[self._last_us], stamps[:-1]])
            if self._follows(before, stamps).all():
                self._held = waiting[:0]
                self._last_us = int(stamps[-1]) if len(stamps) else self._last_us
                return waiting.copy()
        return self._sound(waiting)

    def _sound(self, waiting: np.ndarray) -> np.ndarray:
        """The consistent samples, in order; the last is held back if the next one must decide."""
        stamps, kept, last_us = waiting["stamp"].tolist(), [], self._last_us
        self._held = waiting[:0]
        for place, stamp in enumerate(stamps):
            follows = self._comes_after(last_us, stamp)
            if not follows and place + 1 == len(stamps):
                self._held = waiting[place:]
            elif follows or self._is_confirmed(last_us, stamp, stamps[place + 1]):
                kept.append(place)
                last_us = stamp
            else:
                self.rejected += 1
        self._last_us = last_us
        return waiting[kept]

    def _is_confirmed(self, last_us: int | None, stamp: int, following: int) -> bool:
        """Whether the sample behind it follows it, and not the one before it."""
        return self._comes_after(stamp, following) and not self._comes_after(last_us, following)

    def _comes_after(self, last_us: int | None, stamp: int) -> bool:
        return last_us is not None and bool(self._follows(last_us, stamp))

    def _follows(self, before: np.ndarray | int, stamps: np.ndarray | int) -> np.ndarray:
        steps = np.asarray(stamps) - np.asarray(before)
        if self._turn_us is not None:
            steps = steps % self._turn_us
        return np.asarray((steps > 0) & (steps <= self._longest_us))

    def _run_on(self, samples: np.ndarray) -> None:
        """Adds the wraps of the stamps; a restart is none."""
        if self._turn_us is None or not len(samples):
            return
        own = samples["stamp"].copy()
        before = np.concatenate([[self._own_us if self._own_us is not None else own[0]], own])
        turns = (np.diff(before) < 0) & self._follows(before[:-1], before[1:])
        samples["stamp"] += self._before_us + np.cumsum(turns) * self._turn_us
        self._before_us += int(turns.sum()) * self._turn_us
        self._own_us = int(own[-1])


class UnitDriver:
    """Takes samples from a line that has just been opened.

    Raises Unusable if the line breaks, carries no whole frame for SILENCE_S of wall time (a pause
    in which nobody looked counts as LOOK_S at most), or if the unit restarts its clock without
    having been switched off and on between `switched_off` and `switched_on`.
    """

    def __init__(self, link: UnitLink, line: Line) -> None:
        self.link = link
        self.arrived_s = self._looked_s = wall_s()
        self._silent_s = 0.0
        self._line = line
        self._rest = b""
        self._bytes_since = 0
        self._bad_frames = 0
        self._sequence = StampSequence(link)
        self._last_stamp = -1
        self.is_off = False
        self._may_restart = False

    @property
    def bad_frames(self) -> int:
        """Frames with a wrong check sum, and what only passed for one."""
        return self._bad_frames + self._sequence.rejected

    def end(self) -> None:
        """Read what is on the line now, and no more."""
        self._line.end()

    def switched_off(self) -> None:
        """From now on the unit may be silent, and then restart its clock once."""
        self.is_off = self._may_restart = True

    def switched_on(self) -> None:
        """From now on its silence counts again."""
        self.is_off = False
        self._silent_s = 0.0
        self.arrived_s = wall_s()

    def take(self) -> tuple[np.ndarray, np.ndarray]:
        """The samples that came since the last call: before and after its restart, if it had one.

        Records (n,) and (m,) of drivers.samples; n, m or both may be 0, and m is while it has not
        been restarted. `arrived_s` is the wall time at which the last came.
        """
        data, arrived_s = self._line.received()
        found = find_frames(self._rest + data, self.link.frame)
        self._rest = found.rest
        self._bad_frames += found.bad
        samples = self._sequence.take(found.samples, arrived_s)
        self._bytes_since = 0 if len(samples) else self._bytes_since + len(data)
        now_s = wall_s()
        self._silent_s += min(now_s - self._looked_s, LOOK_S)
        self._looked_s = now_s
        if len(samples):
            self._silent_s = 0.0
            self.arrived_s = arrived_s or self.arrived_s
            restart = self._restart_in(samples["stamp"])
            return samples[:restart], samples[restart:]
        if self._silent_s > SILENCE_S and not self.is_off:
            raise self._silent()
        if self._line.broken:
            raise Unusable(self._line.broken, message("station-cause.line", unit=self.link.url))
        return no_samples(self.link.frame), no_samples(self.link.frame)

    def stream(self, samples: np.ndarray, shift_us: int = 0) -> Stream:
        """Samples over their own time stamps, moved by `shift_us`."""
        return to_stream(samples, self.link.frame, shift_us)

    def lost(self, samples: np.ndarray) -> np.ndarray:
        """Samples missing between neighbours, (n,) -> (n - 1,): by the counter, else by time."""
        if self.link.frame.has("counter"):
            return (np.diff(samples["counter"]) - 1) % counter_turn(self.link.frame)
        periods = np.rint(np.diff(samples["stamp"]) / 1e6 * self.link.rate_hz)
        return np.maximum(periods.astype(np.int64) - 1, 0)

    def _restart_in(self, stamps: np.ndarray) -> int:
        """The index in the stamps (n,) at which the unit's clock restarts; n if it does not."""
        before = np.concatenate([[self._last_stamp], stamps[:-1]])
        back = np.flatnonzero(stamps <= before)
        self._last_stamp = int(stamps[-1])
        if not len(back):
            return len(stamps)
        if not self._may_restart or len(back) > 1:
            raise Unusable(
                f"the unit's time stamp went back from {before[back[-1]] / 1e6:.6f} s to "
                f"{stamps[back[-1]] / 1e6:.6f} s, as after a restart: check its supply and "
                f"start again",
                message("station-cause.unit-restarted", unit=self.link.url),
            )
        self._may_restart = False
        return int(back[0])

    def _silent(self) -> Unusable:
        kind, what, look = "nothing-sent", "nothing", "its supply"
        if self._bytes_since:
            kind, what = "no-frame", f"{self._bytes_since} bytes and no whole frame"
            look = "unit_link.frame of the station file, its baud rate"
        seconds = f"{SILENCE_S:g}"
        return Unusable(
            f"the unit on {self.link.url} has sent {what} for {seconds} s: check {look} and the "
            f"cable",
            message(f"station-cause.{kind}", unit=self.link.url, seconds=seconds),
        )


def find_frames(data: bytes, frame: AnyFrame) -> FrameSearch:
    """Every whole frame in some bytes, by its description."""
    if isinstance(frame, BinaryFrame):
        return find_binary(data, frame)
    return find_text(data, frame)
