"""A browser's page of a tablet's width that notes what must not happen."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from tests.shared import chromium

OPTIONS = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --no-proxy-server --disable-dev-shm-usage"
)


@contextmanager
def watched_page(address: str, faults: list[str], locale: str) -> Iterator[Any]:
    """faults: takes every error, dialog and request to a host other than the address."""
    path = chromium()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=OPTIONS.split())
        page = browser.new_page(viewport={"width": 820, "height": 1100}, locale=locale)
        page.set_default_timeout(120_000)  # ms, for a machine that is busy with other work
        page.on("console", lambda m: faults.append(m.text) if m.type == "error" else None)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("dialog", lambda dialog: (faults.append(dialog.message), dialog.dismiss()))
        ours = (address, "data:", "blob:")
        page.on("request", lambda r: None if r.url.startswith(ours) else faults.append(r.url))
        yield page
        browser.close()
