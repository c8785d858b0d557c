"""A Modbus table of another maker, over TCP and over a serial line, byte by byte."""

import os
import select
import socketserver
import struct
import threading
import time
from collections.abc import Callable
from typing import Any

AXES = 3


class ModbusMaker:
    """Device 7, the table, and 9, the chamber. `refused` has what it did not understand."""

    def __init__(self) -> None:
        self.drives = [Drive() for _ in range(AXES)]
        self.holding = [0] * 100
        self.is_on = False
        self.refused: list[bytes] = []

    def answer(self, device: int, request: bytes) -> bytes:
        """The answer to a request, from the function code on."""
        code, address, count = struct.unpack(">BHH", request[:5])
        inputs = {7: self._inputs, 9: lambda: [215, 440, 501]}.get(device)
        if inputs is not None and code == 4 and address + count <= len(inputs()):
            words = inputs()[address : address + count]
            return struct.pack(f">BB{count}H", code, 2 * count, *words)
        if device == 7 and code == 16 and address + count <= len(self.holding):
            self.holding[address : address + count] = struct.unpack(f">{count}H", request[6:])
            return request[:5]
        if device == 7 and code == 5 and count in (0, 0xFF00):
            self._coil(address, count != 0)
            return request[:5]
        self.refused.append(request)
        return bytes([code | 0x80, 1])

    def _inputs(self) -> list[int]:
        words = [0] * 151
        words[0] = 3300
        for axis, drive in enumerate(self.drives):
            place = 2 * axis
            words[100 + place : 102 + place] = _low_first(round(drive.angle * 1000) % 360_000)
            words[120 + place : 122 + place] = _low_first(round(drive.rate * 1000) % 2**32)
            words[140 + axis] = (drive.rate != 0) | (drive.is_there << 1) | (self.is_on << 3)
        return words

    def _coil(self, address: int, on: bool) -> None:
        if address == 0:
            self.is_on = on
            return
        what, axis = divmod(address, 10)
        speed = self._long(30, axis) / 1000
        if what == 1:
            target = self._long(10, axis)
            self.drives[axis].move((target - 2**32 * (target >= 2**31)) / 1000, speed)
        elif what == 2:
            self.drives[axis].spin(speed if self.holding[70 + axis] else -speed)
        else:
            self.drives[axis].halt()

    def _long(self, base: int, axis: int) -> int:
        low, high = self.holding[base + 2 * axis : base + 2 * axis + 2]
        return low + 65536 * high


def _low_first(value: int) -> tuple[int, int]:
    return value % 65536, value // 65536


def over_tcp(maker: ModbusMaker) -> socketserver.ThreadingTCPServer:
    """It listens on a free port of this machine, until it is shut down."""

    class Connection(socketserver.StreamRequestHandler):
        def handle(self) -> None:
            while len(head := self.rfile.read(7)) == 7:
                number, protocol, length, device = struct.unpack(">HHHB", head)
                assert protocol == 0
                body = maker.answer(device, self.rfile.read(length - 1))
                self.wfile.write(struct.pack(">HHHB", number, 0, len(body) + 1, device) + body)

    return listening(Connection)


def over_tcp_as_rtu(maker: ModbusMaker) -> socketserver.ThreadingTCPServer:
    """A serial server: what comes by TCP goes on as it is, frames of Modbus/RTU."""

    class Connection(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            waiting = b""
            while received := self.request.recv(300):
                answers, waiting = _rtu_answers(maker, waiting + received)
                self.request.sendall(answers)

    return listening(Connection)


def listening(handler: Any) -> socketserver.ThreadingTCPServer:
    """A server of a thread for each connection."""
    server = socketserver.ThreadingTCPServer(("127.0.0.1", 0), handler)
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
    return server


def over_serial(maker: ModbusMaker) -> tuple[str, Callable[[], None]]:
    """A serial device at whose other end it answers (Modbus/RTU), and how to end it."""
    import tty

    near, far = os.openpty()
    tty.setraw(near)
    tty.setraw(far)
    ended, end = os.pipe()

    def serve() -> None:
        waiting = b""
        while ended not in select.select([near, ended], [], [])[0]:
            answers, waiting = _rtu_answers(maker, waiting + os.read(near, 300))
            os.write(near, answers)

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()

    def stop() -> None:
        os.write(end, b"x")
        thread.join()  # before its files are closed, whose numbers others get
        for each in (far, near, ended, end):
            os.close(each)

    return os.ttyname(far), stop


def _rtu_answers(maker: ModbusMaker, waiting: bytes) -> tuple[bytes, bytes]:
    """The answers to the whole frames in what came, and what is left of it."""
    answers = b""
    while len(waiting) >= 8:
        size = 8 if waiting[1] != 16 else 9 + waiting[6]
        if len(waiting) < size:
            break
        request, waiting = waiting[:size], waiting[size:]
        assert _crc(request[:-2]) == request[-2:], request.hex()
        body = request[:1] + maker.answer(request[0], request[1:-2])
        answers += body + _crc(body)
    return answers, waiting


def _crc(data: bytes) -> bytes:
    crc = 0xFFFF
    for octet in data:
        crc ^= octet
        for _ in range(8):
            crc = (crc >> 1) ^ (0xA001 if crc & 1 else 0)
    return struct.pack("<H", crc)


# A drive that turns at a constant rate to where it was sent, in wall time.


class Drive:
    """Angle and rate in deg and deg/s."""

    def __init__(self) -> None:
        self._began_s = time.monotonic()
        self._from, self._rate, self._end = 0.0, 0.0, None

    def _go(self, rate: float, end: float | None) -> None:
        self._from, self._began_s, self._rate, self._end = self.angle, time.monotonic(), rate, end

    def move(self, angle: float, speed: float) -> None:
        self._go(speed if angle >= self.angle else -speed, angle)

    def spin(self, rate: float) -> None:
        self._go(rate, None)

    def halt(self) -> None:
        self._go(0.0, None)

    @property
    def angle(self) -> float:
        gone = self._from + self._rate * (time.monotonic() - self._began_s)
        if self._end is None:
            return gone
        return min(gone, self._end) if self._rate > 0 else max(gone, self._end)

    @property
    def rate(self) -> float:
        return 0.0 if self._end is not None and self.angle == self._end else self._rate

    @property
    def is_there(self) -> bool:
        return self._end is None or self.angle == self._end
