## The operations pages.

pages-light = Light
pages-dark = Dark
pages-no-such-page = There is no such page
pages-not-answered = This cannot be shown
pages-no-database = The catalogue cannot be reached; this page asks again by itself

pages-line = Line
    .about = What each station does now, and what the line has made today
pages-line-no-station = No run was acquired from a station in this home yet.

pages-runs = Runs
    .about = Every run with the state of each of its steps
pages-runs-none = There is no run in this home yet.
