"""A table and a thermometer of another maker that take lines of text."""

import socketserver

from tests.tasks.station.makers.modbus_maker import Drive, listening

AXES = "ABC"


class TextMaker:
    """The table. `refused` has what it did not understand."""

    def __init__(self) -> None:
        self.drives = {axis: Drive() for axis in AXES}
        self.speeds = dict.fromkeys(AXES, 10.0)
        self.is_on = False
        self.refused: list[str] = []

    def answer(self, line: str) -> str:
        match line.split():
            case ["*IDN?"]:
                return "TURNTABLES,TT-3,2.1"
            case ["POS?"]:
                return ",".join(f"{self.drives[axis].angle:+.5f}" for axis in AXES)
            case ["VEL?", axis]:
                return f"VEL {self.drives[axis].rate:.5f}"
            case ["STAT?"]:
                return "#00"
            case ["SERVO", "ON" | "OFF" as state]:
                self.is_on = state == "ON"
                return "OK"
            case [command, axis, *value] if self.is_on and axis in self.drives:
                return self._command(command, axis, *map(float, value))
        self.refused.append(line)
        return "ERR 1"

    def _command(self, command: str, axis: str, value: float = 0.0) -> str:
        drive = self.drives[axis]
        match command:
            case "VEL":
                self.speeds[axis] = value
            case "MOVE":
                drive.move(value, self.speeds[axis])
            case "JOG":
                drive.spin(value)
            case "STOP":
                drive.halt()
        return "OK"


def over_tcp(maker: TextMaker) -> socketserver.ThreadingTCPServer:
    """It listens on a free port of this machine, until it is shut down."""

    class Connection(socketserver.BaseRequestHandler):
        def handle(self) -> None:
            waiting = b""
            while received := self.request.recv(1000):
                *lines, waiting = (waiting + received).split(b"\r")
                for line in lines:
                    self.request.sendall(maker.answer(line.decode()).encode() + b"\r\n")

    return listening(Connection)


def thermometer() -> socketserver.ThreadingTCPServer:
    """It answers lines on a free port of this machine, until it is shut down."""

    class Connection(socketserver.StreamRequestHandler):
        def handle(self) -> None:
            for line in self.rfile:
                answers = {b"MEAS:TEMP?\n": b"+2.150E+01\n", b"MEAS:HUM?\n": b"44.0 %RH\n"}
                self.wfile.write(answers[line])

    return listening(Connection)
