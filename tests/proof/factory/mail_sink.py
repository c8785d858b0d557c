"""A mail server that keeps what it gets: `python -m tests.proof.factory.mail_sink PORT FOLDER`."""

import os
import sys
import time
from pathlib import Path
from typing import Any

from aiosmtpd.controller import Controller


class Kept:
    """Each message as a file of the folder, whole before the client hears that it was taken."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    async def handle_DATA(self, _: object, __: object, envelope: Any) -> str:  # noqa: N802
        name = f"{time.time_ns()}.eml"
        draft = self._folder / f".{name}"
        draft.write_bytes(envelope.content)
        os.replace(draft, self._folder / name)
        return "250 OK"


def main(port: int, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    controller = Controller(Kept(folder), hostname="127.0.0.1", port=port)
    controller.start()
    while True:
        time.sleep(3600)


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]))
