"""`acquire --dry-run`: what the procedure would do, without moving anything."""

from typing import Any

from flows.execute import procedure_of
from flows.terminal import print_json, print_rows
from schemas.orders import AcquireOrder
from tasks.station.plan import plan


def print_dry_run(order: AcquireOrder, as_json: bool) -> None:
    """Print every segment of a checked order, with its start and its motion."""
    procedure = procedure_of(order)
    begins_s, rows = procedure.warm_up_s, []
    for segment in plan(procedure):
        rows.append(
            {
                "segment": segment.name,
                "begins_s": round(begins_s, 1),
                "takes_s": round(segment.planned_s, 1),
                "angles_deg": segment.angles_deg,
                "rate_deg_s": segment.rate_deg_s,
                "refix": segment.refix.name if segment.refix else None,
            }
        )
        begins_s += segment.planned_s
    if as_json:
        print_json({"format": "mimu-dry-run/1", "station_s": round(begins_s, 1), "segments": rows})
        return
    print_rows(f"{procedure.title}: {begins_s:.0f} s", tuple(rows[0]), [_text(row) for row in rows])


def _text(row: dict[str, Any]) -> tuple[str, ...]:
    angles = " ".join(f"{angle:g}" for angle in row["angles_deg"])
    return tuple(
        str("" if value is None else value) for value in (row | {"angles_deg": angles}).values()
    )
