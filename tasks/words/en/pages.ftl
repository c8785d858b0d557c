## The operations pages.

pages-light = Light
pages-dark = Dark
pages-login =
    .name = Name
    .password = Password
    .enter = Log in
    .leave = Log out
    .wrong = Incorrect name or password.
    .shut = Too many failed attempts. Try again in a minute to an hour.
pages-role =
    .viewer = viewer
    .operator = operator
    .verifier = verifier
    .issuer = issuer
    .administrator = administrator
pages-times = Times: { $zone } (UTC{ $offset })
pages-asking =
    .yes = Yes
    .no = No
pages-no-such-page = Page not found
pages-not-answered = This request cannot be answered
pages-failed = Internal error of the pages
pages-no-database = The catalogue cannot be reached; this page retries automatically

pages-runs = Runs
    .about = All runs with the state of each step
pages-runs-count = { $count ->
    [one] { $count } run
   *[other] { $count } runs
}

pages-validity =
    .valid = valid
    .remarks = with remarks
    .invalid = invalid
    .missing = not assessed
pages-result =
    .whole = complete
    .partial = { $count } missing
    .missing = no result
    .failed = reprocessing failed
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
pages-column-result-state = Result
pages-column-verdict = Verdict
pages-column-state = Certificate state
pages-column-certificate = Certificate
pages-column-due = Due
pages-column-procedure = Procedure
pages-column-method = Method
pages-column-seconds = Duration (s)
pages-column-recording-id = Recording

pages-run = Run
    .about = A run with its items, segments, signals, certificates, log and lineage
pages-run-tab =
    .items = Items
    .segments = Segments
    .signals = Signals
    .certificate = Certificates
    .log = Log
    .lineage = Lineage
pages-run-no-log = The recording has no log because it was not acquired by this program.
pages-run-state =
    .begun = started
    .warming-up = warming up
    .measuring = measuring
    .repeating = repeating
    .paused = paused
    .turning-over = turning over
    .finishing = finishing
    .done = done
    .stopped = stopped
pages-run-order = Order
pages-run-again = { $number }, measurement { $count }
pages-run-undecided = Why the certificate is inconclusive
pages-items-limits = Limits and verdicts are taken from certificate { $certificate }.
pages-items-no-limits = No certificate prints this result yet, so no limits are shown.
pages-items-column =
    .item = Item
    .symbol = Symbol
    .value = Value
    .u = U
    .limits = Limits
    .margin = Margin
    .verdict = Verdict
pages-segments-column =
    .name = Segment
    .kind = Kind
    .since = From (s)
    .until = To (s)
    .rate = Rate
    .rows = Rows used
    .checks = Remarks
pages-segments-left-out = { $rows }, { $out } excluded
pages-segment-kind =
    .static = static
    .rate = rate
    .rotation = rotation
    .settle = settling
    .transition = transition
pages-certificate-column =
    .number = Certificate
    .state = State
    .verdict = Verdict
    .result = Result
    .calibrated = Calibrated
    .issued = Issued
    .due = Due
    .why = Reason
pages-log-column =
    .at = Time
    .t = t (s)
    .state = State
    .cause = Cause
pages-lineage-raw = SHA-256 of the raw content
pages-lineage-sources = Imported from
pages-lineage-heading =
    .results = Results, each with the one it supersedes
    .standards = Measurement standards
    .settings = Settings of the latest result
pages-results-column =
    .id = Result
    .method = Method
    .code = Code version
    .made = Created
    .supersedes = Supersedes
    .why = Reason
    .certificates = Certificates
pages-standards-column =
    .name = Standard
    .serial = Serial number
    .certificate = Certificate
    .document = Stated in
pages-standards-manifest = the manifest of the recording
pages-settings-column =
    .name = Setting
    .value = Value

pages-signals = Signals
    .about = Raw channels of a run; where one point represents many rows, minimum and maximum are shown
pages-signals-channel = Channel
pages-signals-time = time (s)
pages-signals-rows =
    .whole = { $rows } rows, all shown
    .reduced = { $rows } rows in { $points } bins: the band spans minimum to maximum of each bin; zoom in for every row

pages-budget = Budget
    .about = Contributions to the uncertainty of one element
pages-budget-of = Budget of
pages-budget-summary = { $item }: { $symbol } = { $value }, u = { $u }, k = { $k }, U = { $expanded }
pages-budget-column =
    .input = Input quantity
    .kind = Type, distribution
    .u = Standard uncertainty
    .sensitivity = Sensitivity
    .contribution = Contribution
    .share = Share of variance
    .source = Source
pages-distribution =
    .normal = normal
    .rectangular = rectangular
    .triangular = triangular
    .arcsine = arcsine
    .t = Student's t

pages-do = Do
    .about = Orders permitted for your role; each one is recorded in the audit trail
pages-do-nothing = Your role may view the pages but give no orders; the table below shows which roles may.
pages-do-nobody = No user has a password in this home yet, so the pages are read-only. Ask whoever installed the program to add users.
pages-do-no-order = No orders yet.
pages-roles = { $roles }
pages-do-roles = Permissions by order
pages-do-queue = Queue of the stations
pages-do-orders = Other orders given here since the server started
pages-do-refused = Refused
pages-do-busy = Being carried out …
pages-do-limits = { $passed } pass, { $failed } fail, { $open } inconclusive
pages-do-step =
    .draft = Drafted
    .check = Checked
    .issue = Issued
pages-do-pdf = Open the PDF
pages-do-withdraw = Withdraw certificate { $certificate }? This cannot be undone, and its client has to be informed.
pages-do-done = { $action }: { $subject }
pages-do-field =
    .station = Station
    .procedure = Procedure
    .run = Run
    .certificate = Certificate
    .reason = Reason
    .since = Recorded since (YYYY-MM-DD)
    .until = Recorded until (YYYY-MM-DD)
    .model = Model
    .serial = Serial number (commas between several)
    .manufacturer = Manufacturer (default: the station file's)
    .client-order = Client's order
    .tolerance = Limits (default: the home's)
    .operator = Who carried it out (where the run does not say)
    .report = Report of less than a certificate: agreement with the client
pages-action =
    .acquire = Order a run
    .stop = Stop a station
    .reprocess = Reprocess
    .certify = Draft a certificate
    .check = Check a draft
    .issue = Issue a certificate
    .amend = Amend a certificate
    .withdraw = Withdraw a certificate
pages-order =
    .running = running
    .done = done
    .failed = failed
    .waiting = waiting
    .cancelled = cancelled
pages-order-column =
    .at = Time
    .person = Person
    .action = Order
    .subject = Subject
    .state = State
    .fault = Reason for failure
    .station = Station
    .unit = Unit
    .procedure = Procedure
    .number = Number
    .outcome = Certificates, or reason for failure
    .step = Action
pages-order-step =
    .cancel = Cancel
    .retry = Repeat
pages-roles-column =
    .action = Order
    .roles = Roles

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

## Quality

pages-quality = Quality
    .about = First-pass yield, capability, control charts, and comparison of stations
pages-quality-no-run = There are no runs in this home yet.
pages-quality-all = all
pages-quality-total = All items
pages-quality-asked =
    .model = Model
    .item = Item
    .element = Element
    .station = Station
    .serial = Serial number
    .since = From
    .until = To
    .plot = Chart of
pages-quality-plot =
    .value = values
    .change = changes since the unit's previous run
pages-quality-yield = First-pass yield
pages-quality-capability = Capability
pages-quality-failing = What fails
    .limit = Limit
    .failed = failed
    .inconclusive = inconclusive
    .cumulative = cumulative share
pages-quality-invalid = Run invalid
pages-quality-golden = Golden units
pages-quality-golden-state =
    .few = only { $count } values
    .out = out of control: rule { $rules }
    .within = in control
pages-quality-chart = Control chart
pages-quality-stations = Comparison of stations
pages-quality-counted = { $runs } runs: { $first } first runs and { $retests } retests. Of the first runs, { $passed } passed, { $failed } failed, { $inconclusive } are inconclusive or lack elements and { $invalid } are invalid; all but those that passed count as not passed. { $undecided } are valid but have no certificate or draft and are not counted. { $golden ->
    [0] {""}
   *[other] Runs of golden units, which are no production: { $golden }.
}
pages-quality-rule = Retest rule: a run is a retest if the same unit was run within the preceding { $days } days, on any station and with any outcome. A first run passes if it is valid, no element is missing, and its certificate or draft states a pass; an item passes if all of its elements with limits pass. Adjacent weeks are pooled until a point has { $fewest } first runs. Intervals: 95 % (Wilson).
pages-quality-by-item = Item
pages-quality-by-station = Station
pages-quality-by-model = Model
pages-quality-column =
    .passed = Passed
    .share = Yield
    .interval = 95 %
pages-quality-index =
    .cp = Cp (95 %)
    .cpk = Cpk (95 %)
    .pp = Pp (95 %)
    .ppk = Ppk (95 %)
pages-quality-fact =
    .n = Number of values n
    .limits = Limits
    .mean = Mean
    .within = σ of moving ranges
    .overall = σ of all values
    .margin-median = Share of margin consumed by U, median
    .margin-95 = Share of margin consumed by U, 95th percentile
    .over = Closer than U to a limit, or outside
pages-quality-about =
    .capability = Valid first runs in chronological order. Cp and Cpk are based on moving ranges of successive values, Pp and Ppk on their overall standard deviation.
    .margin = The margin is the distance of a value from its nearer limit; at 100 % it equals U.
    .few = No index of { $count } values: at least { $fewest } are needed for an interval that can be acted on.
    .one-station = Not determined: no unit of this model was run on two stations in this period.
    .no-limits = No certificate defines limits for this value, so there are no indices.
    .one-sided = The limit is one-sided: Cpk and Ppk refer to it, and Cp and Pp are undefined.
    .limits-vary = Certificates in this selection print different limits; the latest ones are used here.
    .chart-value = { $count } valid runs including retests, in chronological order. Click a point to open its run.
    .chart-change = { $count } valid runs, each minus the previous run of the same unit, excluding steps across an adjustment: constant differences between units cancel. Click a point to open its run.
    .failing = Limits that the first runs do not pass, reasons for which a certificate decides on nothing, and invalid runs, the most frequent first ({ $shown } of { $count }). A run counts once for each of them.
    .golden = What each station reads of the golden units (quality.toml), against the mean and moving ranges of their own first { $most } values there; with fewer than { $fewest } there are no limits yet.
    .stations = Deviation of a station from the mean of the mutually consistent stations, estimated from units that moved between stations in this period, over all units of the model. U (k = 2) follows from the scatter between units.
pages-quality-broken = violates a rule
pages-quality-range = Moving range
pages-quality-cause =
    .adjusted = unit adjusted
    .station = station changed
    .equipment = equipment renewed
pages-quality-nelson =
    .rule = Nelson rule
    .pattern = Pattern
    .count = Values
    .rule-1 = one value beyond 3σ
    .rule-2 = nine in a row on one side of the centre
    .rule-3 = six in a row rising or falling
    .rule-4 = fourteen in a row alternating up and down
    .rule-5 = two of three beyond 2σ on one side
    .rule-6 = four of five beyond 1σ on one side
    .rule-7 = fifteen in a row within 1σ
    .rule-8 = eight in a row beyond 1σ
pages-quality-station =
    .station = Station
    .difference = Difference
    .u = U
    .runs = Runs
    .state = vs. U
pages-quality-state =
    .off = more than U
    .within = within U
    .open = not determined

## Unit

pages-unit = Units
    .about = Every coefficient of a unit over the years, with drift, certificates and next due date
pages-unit-count = { $count ->
    [one] { $count } unit
   *[other] { $count } units
}
pages-unit-no-result = No run of this unit has a result yet.
pages-unit-interval = Recalibration interval
pages-unit-item = Item
pages-unit-not-adjusted = No certificate states an adjustment of the unit, so all values are as found.
pages-unit-drift-about = Weighted least squares over all valid runs; an adjustment shifts the level but not the slope. U (k = 2) is the larger of the values from the stated U and from the scatter about the line.
pages-unit-column =
    .serial = Serial number
    .model = Model
    .manufacturer = Manufacturer
    .runs = Runs
    .last-run = Last run
    .certificate = Certificate
    .verdict = Verdict
    .due = Next due
pages-unit-limits =
    .certificate = Bars: U; dotted lines: limits of certificate { $certificate }.
    .document = Bars: U; dotted lines: limits of { $document }.
    .none = Bars: U; no certificate or tolerance file defines limits for this unit.
pages-unit-state =
    .found = as found
    .left = as left after an adjustment
    .invalid = from an invalid run
pages-unit-heading =
    .drift = Values and drift
    .adjustments = As found and as left
    .certificates = Certificates
pages-unit-drift =
    .item = Item
    .symbol = Symbol
    .value = Last valid value
    .limits = Limits
    .drift = Drift per year
    .readings = Values
    .state = vs. U
pages-unit-drifts =
    .yes = drifts
    .no = within U
    .open = not determined
pages-unit-adjustment =
    .day = Run after the adjustment
    .symbol = Symbol
    .found = As found
    .left = As left
    .run-found = Run (as found)
    .run-left = Run (as left)
pages-certificates-none = There are no certificates yet.
pages-due-state =
    .none = no date agreed
    .overdue = { $days ->
        [one] { $days } day overdue
       *[other] { $days } days overdue
    }
    .in = { $days ->
        [0] today
        [one] in { $days } day
       *[other] in { $days } days
    }

## Due

pages-due = Due
    .about = Units due for recalibration, reminders sent to their clients, and the laboratory's own equipment
pages-due-all = all
pages-due-counts = { $overdue ->
    [0] No unit is overdue
    [one] { $overdue } unit is overdue
   *[other] { $overdue } units are overdue
} on { $today }; { $coming ->
    [0] none falls
    [one] { $coming } falls
   *[other] { $coming } fall
} due within { $days } days. Only units with an agreed recalibration interval are listed.
pages-due-overdue = Overdue
pages-due-within = { $days ->
    [0] Overdue only
   *[other] Within { $days } days
}
pages-due-months = Units due by month
pages-due-asked =
    .client = Client
    .model = Model
    .within = Period
pages-due-heading =
    .units = Units
    .clients = By client and month
    .messages = Messages
    .equipment = Equipment of the laboratory
pages-due-none =
    .clients = No client has a unit due.
    .messages = No messages have been sent yet; an administrator sets up which clients get them.
    .equipment = The equipment register is empty; an administrator adds standards.
pages-due-column =
    .name = Unit
    .client = Client
    .due = Due
    .state = State
    .certificate = Certificate
    .messages = Messages sent
pages-due-message =
    .at = Time
    .certificate = Certificate
    .occasion = Occasion
    .channel = Client and channel
    .state = State
    .tries = Attempts
    .fault = Reason for failure
pages-due-occasion =
    .before = { $days } days before
    .after = { $days } days after
pages-due-sent =
    .sent = sent
    .failed = failed, retrying
    .waiting = pending
pages-due-standard =
    .name = Standard
    .serial = Serial number
    .certificate = Certificate
    .until = Valid until
    .state = State

## Mismatch

pages-mismatch = Mismatch
    .about = Physics missing from the model: on which station, unit and model, since when, and which certificates are affected
pages-mismatch-review = Findings common to many runs
pages-mismatch-no-review = No review over many runs has been made in this home yet. Ask an administrator for one; it will appear here.
pages-mismatch-own = Findings of single runs
pages-mismatch-runs = Explained runs, latest first
pages-mismatch-explained = { $explained } of { $runs } runs explained. { $invalid ->
    [0] {""}
    [one] One of these is invalid; its findings are listed below and counted for no effect.
   *[other] { $invalid } of these are invalid; their findings are listed below and counted for no effect.
}
pages-mismatch-clear = { $z } times its standard deviation (median)
pages-mismatch-all = all
pages-mismatch-asked =
    .effect = Effect
    .station = Station
    .model = Model
    .serial = Serial number
pages-mismatch-fact =
    .at = Reviewed
    .asked = Scope
    .runs = Runs (+ excluded)
    .days = From, to
    .since = Since
    .until = Until
    .shown = Runs that favour it
    .sizes = Size (k = 2)
    .clear = In a single run
    .moved = Largest change, in U
pages-mismatch-verdict =
    .no-mismatch = no mismatch
    .explained = mismatch, explained
    .partly-explained = mismatch, partly explained
    .unexplained = mismatch, unexplained
pages-mismatch-level =
    .station = Station
    .unit = Unit
    .model = Model
    .lot = Lot
    .site = Site
pages-mismatch-touched = Certificates on these runs: { $issued } issued, { $drafts ->
    [one] 1 draft
   *[other] { $drafts } drafts
}
pages-mismatch-their-runs = show runs
pages-mismatch-between = { $at } (95 %: between { $low } and { $high })
pages-mismatch-uncertain = From { $since } to { $until } no run decides whether it was present: { $issued } more issued certificates
pages-mismatch-moved = { $count ->
    [one] Changes to the certificate of a reviewed run, in U of the certificate
   *[other] Changes to { $count } certificates of reviewed runs, in U of the certificate; the { $listed } most affected
}
    .paper = Certificate
    .run = Run
    .elements = Elements
pages-mismatch-in-runs = { $count ->
    [one] in { $count } run
   *[other] in { $count } runs
}
pages-mismatch-column =
    .run = Run
    .day = Recorded
    .station = Station
    .unit = Unit
    .validity = Run validity
    .verdict = Result
    .findings = Findings (share of the run's mismatch)
    .report = Report
pages-mismatch-recordings = { $count ->
    [one] { $count } named recording
   *[other] { $count } named recordings
}
pages-mismatch-report = open

## Why something was not done, as the pages show it.

cause-none =
    .run = There is no run { $name }.
    .unit = There is no unit { $name }.
    .certificate = There is no certificate { $name }.
    .file = There is no file { $name } for this.
    .choice = There is no { $name }; there are: { $known }
cause-several-runs = { $name } means { $count } runs: give the id of one.
cause-empty = “{ $field }” is empty.
cause-may = Your role does not allow “{ $action }”; these do: { $roles }
cause-person =
    .draft = { $person } took a step of { $number } already, so another person must draft it.
    .check = { $person } took a step of { $number } already, so another person must check it.
    .issue = { $person } took a step of { $number } already, so another person must issue it.
cause-state =
    .earlier = { $number } was drafted by an earlier version: draft a certificate of its run again.
    .draft = { $number } is a draft: it has to be checked first.
    .checked = { $number } is checked and not issued: issuing comes next.
    .issued = { $number } is issued already: amend it instead.
    .amended = { $number } is amended: take the certificate that replaced it.
    .withdrawn = { $number } is withdrawn: draft a certificate of its run again.
