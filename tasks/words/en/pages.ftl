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
pages-runs-count = { $count ->
    [one] { $count } run
   *[other] { $count } runs
}

pages-validity =
    .valid = valid
    .remarks = with remarks
    .invalid = invalid
    .missing = not judged
pages-result =
    .whole = whole
    .partial = { $count } missing
    .missing = no result
    .failed = re-processing failed
pages-certificate =
    .draft = draft
    .checked = checked
    .issued = issued
    .amended = amended
    .withdrawn = withdrawn
    .missing = none
pages-verdict-missing = none

pages-column-id = Run
pages-column-recorded-on = Recorded
pages-column-station = Station
pages-column-model = Model
pages-column-serial = Serial number
pages-column-manufacturer = Manufacturer
pages-column-validity = Run validity
pages-column-result = Result
pages-column-verdict = Verdict
pages-column-state = Certificate state
pages-column-certificate = Certificate
pages-column-due = Due
pages-column-procedure = Procedure
pages-column-method = Method
pages-column-seconds = Length (s)
pages-column-recording-id = Recording

## The words of the grid itself; each identifier ends with the grid's own key.

pages-grid-contains = Contains
pages-grid-notContains = Does not contain
pages-grid-startsWith = Begins with
pages-grid-endsWith = Ends with
pages-grid-equals = Equals
pages-grid-notEqual = Does not equal
pages-grid-blank = Blank
pages-grid-notBlank = Not blank
pages-grid-lessThan = Less than
pages-grid-lessThanOrEqual = Less than or equal to
pages-grid-greaterThan = Greater than
pages-grid-greaterThanOrEqual = Greater than or equal to
pages-grid-inRange = Between
pages-grid-before = Before
pages-grid-after = After
pages-grid-andCondition = and
pages-grid-orCondition = or
pages-grid-filterOoo = Filter…
pages-grid-noRowsToShow = No rows
pages-grid-loadingOoo = Loading…
