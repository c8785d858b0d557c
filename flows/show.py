"""One run as a person wants to see it."""

from flows.orders import run_of
from flows.printing import print_calibration, print_json, print_rows, stdout
from storage import store
from storage.home import home
from tasks.stages import plain


def show_run(reference: str, as_json: bool) -> None:
    """Print a run: unit, station, segments, newest result of each method, certificates."""
    run = run_of(reference, home(), plain)
    manifest = store.load(run, home()).manifest
    results = store.results(run, home())
    certificates = [entry for entry in store.certificates(home()) if entry.run == run.id]
    if as_json:
        print_json(
            {
                "format": "mimu-run/1",
                "run": run.model_dump(mode="json"),
                "manifest": manifest.model_dump(mode="json"),
                "results": [result.model_dump(mode="json") for result in results],
                "certificates": [entry.model_dump(mode="json") for entry in certificates],
            }
        )
        return
    unit, station = manifest.unit, manifest.station
    console = stdout(markup=False)
    console.print(f"{run.id} {run.recording_id} ({run.standard})", style="bold")
    console.print(f"unit     {unit.manufacturer} {unit.model} {unit.serial}")
    console.print(f"station  {station.id}")
    console.print(
        f"length   {run.seconds:.1f} s, {run.rows} rows; taken in {run.taken_in_at:%F %R}"
    )
    if manifest.segments:
        print_rows(
            "Segments",
            ("name", "kind", "from s", "to s"),
            [(s.name, s.kind, f"{s.t_start:.2f}", f"{s.t_end:.2f}") for s in manifest.segments],
        )
    if results:
        print_calibration(results[-1].calibration)
    for entry in certificates:
        console.print(f"certificate {entry.number}: {entry.verdict} ({entry.state}), {entry.pdf}")
