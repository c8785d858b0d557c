"""Certificates, log and lineage of a run."""

from collections.abc import Sequence

import dash_mantine_components as dmc
from dash.development.base_component import Component

from flows.pages.local_time import minute_of, second_of
from flows.pages.page import View
from flows.pages.parts import facts, heading, link, table
from flows.pages.run.models import CertificateShown, RunShown
from flows.pages.states import badge, certificate_state, decision_state
from storage.catalogue.lineage import MANIFEST
from tasks.certificate.settings import setting


def certificate_table(shown: Sequence[CertificateShown], view: View) -> Component:
    """Certificates, each with its PDF and the run that it stands on."""
    names = "number state verdict result calibrated issued due why"
    rows = [
        (
            dmc.Anchor(
                each.number, href=f"/certificate/{each.number}.pdf", refresh=True, inherit=True
            ),
            badge(certificate_state(each.state), view),
            badge(decision_state(each.verdict), view),
            link(each.result, "/run", id=each.run),
            str(each.calibrated_on or "–"),
            str(each.issued_on),
            str(each.due or "–"),
            each.why,
        )
        for each in shown
    ]
    return table("pages-certificate-column", names, rows, view, none="pages-certificates-none")


def log(shown: RunShown, view: View) -> Component:
    """Every change of the run's state, when and why."""
    rows = [
        (
            second_of(entry.at),
            f"{entry.t:.2f}",
            view.text(f"pages-run-state.{entry.state.replace('_', '-')}"),
            view.say(entry),
        )
        for entry in shown.log
    ]
    return table("pages-log-column", "at t state cause", rows, view, none="pages-run-no-log")


def lineage(shown: RunShown, view: View) -> Component:
    """What the run and its results come from, and what stands on them."""
    results = [
        (
            each.id,
            each.method,
            each.code_version,
            minute_of(each.made_at),
            each.supersedes,
            each.why,
            ", ".join(c.number for c in shown.certificates if c.result == each.id) or None,
        )
        for each in shown.results
    ]
    names = "id method code made supersedes why certificates"
    standards = [
        (each.name, each.serial, each.certificate, _named_by(each.document, view))
        for each in shown.standards
    ]
    made_with = [setting(*each) for each in shown.settings.items()]
    settings = [(view.say(each.name), view.say(each.value)) for each in made_with]
    return dmc.Stack(
        [
            facts(
                {
                    "pages-lineage-raw": dmc.Code(shown.digest),
                    "pages-lineage-sources": ", ".join(shown.sources),
                    "pages-column-recording-id": shown.run.recording_id,
                    "pages-column-procedure": shown.run.procedure,
                },
                view,
            ),
            heading("pages-lineage-heading.results", view),
            table("pages-results-column", names, results, view),
            heading("pages-lineage-heading.standards", view),
            table("pages-standards-column", "name serial certificate document", standards, view),
            heading("pages-lineage-heading.settings", view),
            table("pages-settings-column", "name value", settings, view),
        ]
    )


def _named_by(document: str, view: View) -> str:
    """The number of a certificate, or that the recording's manifest does."""
    return view.text("pages-standards-manifest") if document == MANIFEST else document
