"""The command `review`: what many runs show together."""

import typer

from flows import options

app = typer.Typer()


@app.command(epilog="Example: mimucal review --station ST-03 --since 2026-03-01")
def review(
    paths: options.Reviewed = None,
    station: options.StationId = None,
    model: options.Model = None,
    serial: options.Serial = None,
    since: options.Since = None,
    until: options.Until = None,
    out: options.ReviewFolder = None,
    as_json: options.Json = False,
) -> None:
    """Find effects that only many runs show together, what carries them, and since when."""
    from flows.carry_out import carry_out
    from schemas.orders import ReviewOrder, order_of

    order = order_of(
        ReviewOrder,
        paths=tuple(paths or ()),
        station=station,
        model=model,
        serial=serial,
        since=since.date() if since else None,
        until=until.date() if until else None,
        out=str(out) if out else None,
    )
    reviewed = carry_out("review", order, "runs")
    if as_json:
        print(reviewed.review.model_dump_json(indent=1))
        return
    from flows.print_review import print_review

    print_review(reviewed)
