## The operations pages.

pages-light = Light
pages-dark = Dark
pages-login =
    .name = Name
    .password = Password
    .enter = Log in
    .leave = Log out
    .wrong = Name or password is not right.
    .shut = Too many tries failed. Wait a minute, or up to an hour, and try again.
pages-role =
    .viewer = viewer
    .operator = operator
    .verifier = verifier
    .issuer = issuer
    .administrator = administrator
pages-no-such-page = There is no such page
pages-not-answered = This cannot be shown
pages-failed = The pages themselves failed
pages-no-database = The catalogue cannot be reached; this page asks again by itself

pages-line = Line
    .about = What each station does now, and what the line has made today
pages-line-no-station = No run was acquired from a station in this home yet; `mimucal acquire STATION`, or an order on the page Do, starts one.
pages-line-today = Today, { $day } (UTC)
pages-line-queue = Queue
pages-line-no-server = No Prefect server is named (PREFECT_API_URL), so there is no queue: orders are carried out where they are given.
pages-line-dead = process ended without a word
pages-line-unit = Unit
pages-line-now = Now
pages-line-segment = Segment
pages-line-left = Remaining
pages-line-minutes = { $minutes } min
pages-line-rates = Rows in a second
pages-line-noise = Noise of single samples
pages-line-at = Written
pages-line-output =
    .runs = Runs taken in
    .valid = valid
    .remarks = with remarks
    .invalid = invalid
    .not-judged = not judged
    .passed = Units that pass
    .failed = Units that fail
    .issued = Certificates issued
    .by-station = By station
pages-queue-column =
    .name = Flow run
    .state = State
    .expected = Expected (UTC)

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
pages-column-result-state = Result
pages-column-verdict = Verdict
pages-column-state = Certificate state
pages-column-certificate = Certificate
pages-column-due = Due
pages-column-procedure = Procedure
pages-column-method = Method
pages-column-seconds = Length (s)
pages-column-recording-id = Recording

pages-run = Run
    .about = One run: its items, segments, signals, certificates, log and lineage
pages-run-tab =
    .items = Items
    .segments = Segments
    .signals = Signals
    .certificate = Certificates
    .log = Log
    .lineage = Lineage
pages-run-no-log = The recording has no log: no acquisition of this program made it.
pages-run-state =
    .begun = begun
    .warming-up = warming up
    .measuring = measuring
    .repeating = repeating
    .paused = paused
    .turning-over = turning over
    .finishing = finishing
    .done = done
    .stopped = stopped
pages-items-limits = Limits and verdicts are those of certificate { $certificate }.
pages-items-no-limits = No certificate prints this result yet, so no limits stand beside it.
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
pages-segments-left-out = { $rows }, { $out } left out
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
    .why = Why
pages-log-column =
    .at = UTC
    .t = at (s)
    .state = State
    .cause = Cause
pages-lineage-raw = SHA-256 of the raw content
pages-lineage-sources = Taken in from
pages-lineage-heading =
    .results = Results, each with what it supersedes
    .standards = Measurement standards
    .settings = Settings of the newest result
pages-results-column =
    .id = Result
    .method = Method
    .code = Code version
    .made = Made (UTC)
    .supersedes = Supersedes
    .why = Why
    .certificates = Certificates
pages-standards-column =
    .name = Standard
    .serial = Serial number
    .certificate = Certificate
    .document = Named by
pages-standards-manifest = the manifest of the recording
pages-settings-column =
    .name = Setting
    .value = Value

pages-signals = Signals
    .about = Raw channels of a run; of each point that stands for many rows, the smallest and the largest
pages-signals-channel = Channel
pages-signals-time = time (s)
pages-signals-rows =
    .whole = { $rows } rows, each of them shown
    .reduced = { $rows } rows in { $points } bins: the band goes from the smallest to the largest of each; zoom in for every row

pages-budget = Budget
    .about = What the uncertainty of one element is made of
pages-budget-of = Budget of
pages-budget-summary = { $item }: { $symbol } = { $value }, u = { $u }, k = { $k }, U = { $expanded }
pages-budget-column =
    .input = Input quantity
    .kind = Type, distribution
    .u = Standard uncertainty
    .sensitivity = Sensitivity
    .contribution = Contribution
    .share = Share of the variance
    .source = Source
pages-distribution =
    .normal = normal
    .rectangular = rectangular
    .triangular = triangular
    .arcsine = arcsine
    .t = Student's t

pages-do = Do
    .about = Orders, as far as your role allows; every one of them is in the trail
pages-do-nothing = Your role looks at the pages and gives no orders; the table below says whose does.
pages-do-nobody = Nobody has a password in this home yet, so the pages only show: after `mimucal user add NAME --role administrator` and a log-in, orders are given here.
pages-do-no-order = No order was given yet.
pages-roles = { $roles }
pages-do-roles = Who may give which order
pages-do-orders = Orders given here since the pages are served
pages-do-refused = Refused
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
    .serial = Serial number
pages-action =
    .acquire = Start a run
    .reprocess = Re-process
    .certify = Draft a certificate
    .check = Check a draft
    .issue = Issue a certificate
    .withdraw = Withdraw a certificate
pages-order =
    .running = running
    .done = done
    .failed = failed
pages-order-column =
    .at = UTC
    .person = Person
    .action = Order
    .subject = Of
    .state = State
    .fault = Why it failed
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
    .about = First-pass yield, capability, control charts, and station against station
pages-quality-no-run = There is no run in this home yet.
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
    .change = changes since the unit's last run
pages-quality-yield = First-pass yield
pages-quality-capability = Capability
pages-quality-chart = Control chart
pages-quality-stations = Station against station
pages-quality-counted = { $runs } runs: { $first } first runs and { $retests } retests. Of the first runs { $invalid } are invalid, which counts as not passed, and { $undecided } are valid but have no certificate or draft, and are not counted.
pages-quality-rule = Retest rule: a run is a retest where the same unit was run within the { $days } days before it, on whatever station and however that ended. A first run passes where it is valid, no element is missing, and its certificate or draft says that the unit passes; an item passes where all of its limited elements do. Intervals: 95 % (Wilson).
pages-quality-by-item = Item
pages-quality-by-station = Station
pages-quality-by-model = Model
pages-quality-by-week = Week (ISO 8601)
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
    .n = Values n
    .limits = Limits
    .mean = Mean
    .within = σ of moving ranges
    .overall = σ of all values
    .margin-median = Margin that U takes, median
    .margin-95 = Margin that U takes, 95 % of values
    .over = Less than U within the limit, or outside
pages-quality-about =
    .capability = Of valid first runs, in the order of time. Cp and Cpk by the moving ranges of successive values, Pp and Ppk by the standard deviation of all of them.
    .margin = The margin is the distance of a value to its nearer limit; at 100 % the limit is U away.
    .no-limits = No certificate puts limits on this value, so there are no indices.
    .one-sided = The limit is one-sided: Cpk and Ppk count to it, and there is no Cp or Pp.
    .limits-vary = Certificates of this selection print other limits as well; the newest count here.
    .chart-value = { $count } valid runs, retests as well, in the order of time. Click a point for its run.
    .chart-change = { $count } valid runs, each less the run of the same unit before it, without steps over an adjustment: what a unit is by itself drops out. Click a point for its run.
    .stations = What a station reads beside the mean of those that agree with one another, by the steps of units that went from one to another in this time, of all units of the model. U (k = 2) comes from the scatter between units.
pages-quality-broken = breaks a rule
pages-quality-range = Moving range
pages-quality-cause =
    .adjusted = unit adjusted
    .station = station changed
    .equipment = equipment renewed
pages-quality-nelson =
    .rule = Nelson's rule
    .pattern = Pattern
    .count = Values
    .rule-1 = one value beyond 3σ
    .rule-2 = nine in a row on one side of the centre
    .rule-3 = six in a row rising, or falling
    .rule-4 = fourteen in a row up and down in turn
    .rule-5 = two of three beyond 2σ on one side
    .rule-6 = four of five beyond 1σ on one side
    .rule-7 = fifteen in a row within 1σ
    .rule-8 = eight in a row beyond 1σ
pages-quality-station =
    .station = Station
    .difference = Difference
    .u = U
    .runs = Runs
    .state = Beside U
pages-quality-state =
    .off = more than U
    .within = within U
    .open = not determined

## Unit

pages-unit = Units
    .about = Every coefficient of a unit over the years, its drift, its certificates and when it is due
pages-unit-count = { $count ->
    [one] { $count } unit
   *[other] { $count } units
}
pages-unit-no-result = No run of this unit has a result yet.
pages-unit-interval = Interval of recalibration
pages-unit-item = Item
pages-unit-not-adjusted = No certificate says that the unit was adjusted, so every value is as found.
pages-unit-drift-about = Weighted least squares over all valid runs; an adjustment moves the level and leaves the slope. U (k = 2) is the larger of what the stated U of the values and what their scatter about the line give.
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
    .certificate = Bars are U, dotted lines the limits of certificate { $certificate }.
    .document = Bars are U, dotted lines the limits of { $document }.
    .none = Bars are U; no certificate and no tolerance file has limits for this unit.
pages-unit-state =
    .found = as found
    .left = as left after an adjustment
    .invalid = of an invalid run
pages-unit-heading =
    .drift = Values and drift
    .adjustments = As found and as left
    .certificates = Certificates
pages-unit-drift =
    .item = Item
    .symbol = Symbol
    .value = Last valid value
    .limits = Limits
    .drift = Drift in a year
    .readings = Values
    .state = Beside U
pages-unit-drifts =
    .yes = drifts
    .no = within U
    .open = not determined
pages-unit-adjustment =
    .day = Run after the adjustment
    .symbol = Symbol
    .found = As found
    .left = As left
    .run-found = Run as found
    .run-left = Run as left
pages-certificates-none = There is no certificate yet.
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
    .about = When units come back for recalibration, what their clients were told, and the laboratory's own equipment
pages-due-all = all
pages-due-counts = { $overdue ->
    [0] No unit is overdue
    [one] { $overdue } unit is overdue
   *[other] { $overdue } units are overdue
} on { $today }; { $coming ->
    [0] none falls
    [one] { $coming } falls
   *[other] { $coming } fall
} due within { $days } days. Only units whose order agreed on an interval come back.
pages-due-overdue = Overdue
pages-due-within = { $days ->
    [0] Overdue alone
   *[other] Within { $days } days
}
pages-due-months = Units due in the month
pages-due-asked =
    .client = Client
    .model = Model
    .within = Time
pages-due-heading =
    .units = Units
    .clients = By client and month
    .messages = Messages
    .equipment = Equipment of the laboratory
pages-due-none =
    .clients = No client has a unit that is due.
    .messages = No message was sent yet; `mimucal remind` sends them to the clients of recall.toml.
    .equipment = The register of equipment is empty; `mimucal equipment add` takes standards in.
pages-due-column =
    .name = Unit
    .client = Client
    .due = Due
    .state = State
    .certificate = Certificate
    .messages = Messages sent
pages-due-message =
    .at = UTC
    .certificate = Certificate
    .occasion = Occasion
    .channel = Client and channel
    .state = State
    .tries = Tries
    .fault = Why it failed
pages-due-occasion =
    .before = { $days } days before
    .after = { $days } days after
pages-due-sent =
    .sent = sent
    .failed = failed, tried again
    .waiting = on its way
pages-due-standard =
    .name = Standard
    .serial = Serial number
    .certificate = Certificate
    .until = Valid until
    .state = State

## Mismatch

pages-mismatch = Mismatch
    .about = Which physics the model leaves out, on which station, unit and model, since when, and which certificates it touches
pages-mismatch-review = What the runs show together
pages-mismatch-no-review = No review was made in this home yet: `mimucal review` makes one, and it stands here from then on.
pages-mismatch-own = What runs show one by one
pages-mismatch-runs = Explained runs, the newest first
pages-mismatch-explained = { $explained } explained runs of { $runs } runs in all; `mimucal explain RUN` adds one.
pages-mismatch-all = all
pages-mismatch-asked =
    .effect = Effect
    .station = Station
    .model = Model
    .serial = Serial number
pages-mismatch-fact =
    .at = Reviewed
    .asked = Asked of
    .runs = Runs (+ left out)
    .days = From, to
    .since = Since
    .until = Until
    .shown = Runs that lean towards it
    .sizes = Size (k = 2)
    .moved = Moves most, in U
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
pages-mismatch-their-runs = the runs
pages-mismatch-between = { $at } (95 %: between { $low } and { $high })
pages-mismatch-uncertain = From { $since } to { $until } no run decides whether it was there: { $issued } more issued certificates
pages-mismatch-moved = { $count ->
    [one] What it moves in the certificate of a reviewed run, in U of the certificate
   *[other] What it moves in { $count } certificates of reviewed runs, in U of the certificate; the { $listed } that it moves most
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
    .verdict = Answer
    .findings = Found
    .report = Report
pages-mismatch-recordings = { $count ->
    [one] { $count } named recording
   *[other] { $count } named recordings
}
pages-mismatch-report = open
