"""The routes /login and /logout."""

from flask import Blueprint, redirect, render_template, request, session
from flask_wtf.csrf import generate_csrf
from werkzeug.wrappers import Response

from flows.pages.access import log_in
from flows.pages.page import view_of_request
from flows.pages.passwords import Gate
from flows.pages.register import PAGES
from schemas.base import Unusable
from storage.catalogue.users import users
from storage.home import Home
from tasks.words import Message, message

Page = str | Response | tuple[str, int]
WORDS = {name: message(f"pages-login.{name}") for name in ("name", "password", "enter")}


def login(home: Home, gate: Gate) -> Blueprint:
    """The form, and what becomes of it."""
    made = Blueprint("login", __name__, template_folder="templates")

    @made.get("/login")
    def form() -> Page:
        return _form(None, request.args.get("next", ""))

    @made.post("/login")
    def enter() -> Page:
        name, password = request.form.get("name", ""), request.form.get("password", "")
        address, wanted = request.remote_addr or "", request.form.get("next", "")
        if gate.is_shut(name, address):
            return _form(message("pages-login.shut"), wanted), 429
        try:
            user = users(home).get(name)
        except Unusable:
            return _form(message("pages-no-database"), wanted), 503
        if not gate.check(user, password, name, address) or user is None:
            return _form(message("pages-login.wrong"), wanted), 403
        log_in(user)
        return redirect(_own(wanted))

    @made.post("/logout")
    def leave() -> Page:
        session.clear()
        return redirect("/login")

    return made


def _own(wanted: str) -> str:
    """The page that somebody wanted, if it is one of ours; else the first."""
    return wanted if wanted.lstrip("/") in {page.name for page in PAGES} else "/"


def _form(fault: Message | None, wanted: str) -> str:
    view = view_of_request()
    return render_template(
        "login.html", language=view.language, theme=view.theme, next=wanted,
        fault=fault and view.say(fault), token=generate_csrf(),
        words={name: view.say(each) for name, each in WORDS.items()},
    )  # fmt: skip
