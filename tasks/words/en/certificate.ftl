## The certificate: texts, by specification and method where they differ, and labels.

certificate-title =
    .virtual = { $title } – VIRTUAL, of a simulation
    .calibration = Calibration Certificate
    .report = Calibration Report
    .invalid-run = Report of an Invalid Run
certificate-not-given = not given
certificate-quoted = { $text }
certificate-watermark =
    .virtual = VIRTUAL
    .draft = DRAFT
    .checked = NOT ISSUED
    .amended = AMENDED
    .withdrawn = WITHDRAWN
certificate-field =
    .client = Client
    .client-address = Address of the client
    .object = Object
    .manufacturer = Manufacturer
    .model = Model
    .serial = Serial number
    .specification = Specification
    .received = Date of receipt
    .place = Place of calibration
    .accreditation = Accreditation
    .contact = Contact of the laboratory
    .condition = Condition
    .rate-range = Range of angular rate
    .accel-range = Range of specific force
    .output-rate = Output rate
    .bandwidth = Bandwidth
    .firmware = Firmware
    .adjustment = Adjustment
    .sampling = Sampling
    .calibrated = Date of calibration
    .report = Kind of report
    .replaces = Replaces certificate
    .due = Recalibration due
    .as-found = Verdict as found
    .dwell = Dwell (shortest)
    .positions = Positions at rest
    .zero-positions = Positions for the zero offset
    .turns = Whole turns
    .attitudes = Mounting quaternion wxyz
    .mounting = Mounting position
    .limits-from = Limits from
    .rule = Decision rule
    .rule-number = Decision rule { $number }
    .risk = Risk of a wrong decision
    .global-risk = Risks over the production
    .marks = Marks
    .verdict = Verdict
    .recording = Recording
    .run = Run
    .digest = Digest of the raw data
    .method = Method
    .procedure = Procedure
    .code-version = Code version
    .settings = Settings
    .station = Station
    .gravity = Local gravity
    .latitude = Latitude
certificate-role =
    .operator = Operator
    .checker = Checked by
    .issuer = Issued by
certificate-not-issued = not yet issued
certificate-step-open =
    .check = not yet checked
    .issue = not yet issued
certificate-no-statement = no statement of conformity
certificate-due-from-issue = { $day }, counted from the date of issue because the date of calibration is not given
certificate-replaced = { $number } of { $day }; reason: { $why }
certificate-scope =
    .pass = { $limited } of { $items } items { $limited ->
        [one] has limits and passes
       *[other] have limits and pass
    }
    .fail = items with limits: { $limited } of { $items }; decided on: { $decided }; failed: { $failed }
    .inconclusive = items with limits: { $limited } of { $items }; decided on: { $decided ->
        [0] none
       *[other] { $decided }
    }
    .in-part = { $scope }; in { $count ->
        [one] 1 item
       *[other] { $count } items
    } only some elements have limits
    .near = { $scope }; in { $count ->
        [one] 1 item
       *[other] { $count } items
    } a value lies within U of a limit
    .as-found = { $scope }; as found, before it was adjusted: { $verdict }
certificate-environment =
    .temperature = Air temperature
    .humidity = Relative humidity

## By specification and method

certificate-object =
    .jjf-2003-2022 = Micro inertial measurement unit (MIMU)
    .jjf-1536-2015 = Strapdown inertial flight attitude unit
certificate-specification =
    .jjf-2003-2022 = JJF 2003-2022, Calibration Specification for Micro Inertial Measurement Units (MIMU)
    .jjf-1536-2015 = JJF 1536-2015, Calibration Specification for Strapdown Inertial Flight Attitudes
certificate-followed =
    .jjf2003 = JJF 2003-2022
    .jjf2003-deviating = JJF 2003-2022, with deviations, see Remarks
    .joint = based on JJF 2003-2022
    .joint-deviating = based on JJF 2003-2022, with deviations, see Remarks
    .jjf1536 = JJF 1536-2015
    .jjf1536-deviating = JJF 1536-2015, with deviations, see Remarks
certificate-setting =
    .gravity-m-s2 = gravity used
    .latitude-deg = latitude used
    .uncertainty = uncertainty
    .limits = limits of the equipment
    .u1-of-the-table = u1 of the table
    .effective-bits = effective bits
    .axes = axes of the results
    .mount = largest angle between an axis of the unit and the fixture's, by the stated mount
certificate-setting-with = { $name }: { $value }
certificate-setting-stated = { $half_width } ({ $source })
certificate-setting-limit = laboratory limit, { $limit }
certificate-setting-by-example = { $number } (as in the specification's example)
certificate-setting-of-unit = { $number } (the unit's own)
certificate-method =
    .jjf2003 = JJF 2003-2022, clause by clause
    .joint = joint least squares
    .jjf1536 = JJF 1536-2015, clause by clause
certificate-basis =
    .jjf2003 = Calibrated according to { $specification }
    .jjf2003-deviating = Calibrated according to { $specification } with deviations, see Remarks
    .joint = Models (1) and (2) of { $specification }, fitted jointly by least squares, which is not the computation of its clauses
    .joint-deviating = Models (1) and (2) of { $specification }, fitted jointly by least squares, which is not the computation of its clauses; with deviations, see Remarks
    .jjf1536 = Calibrated according to { $specification }
    .jjf1536-deviating = Calibrated according to { $specification } with deviations, see Remarks
    .clauses = { $basis }; clauses { $clauses }
    .end = { $basis }.
certificate-taken-off = Corrected in the readings beforehand: { $title }.
    .sizes = Corrected in the readings beforehand: { $title }, { $sizes } (k = 2); U of each item includes their U.
certificate-absent =
    .jjf-2003-2022 = Items of Table 2 not determined: { $items }.
    .jjf-1536-2015 = Items of clause 7 not determined: { $items }.
certificate-adjusted =
    .no = no adjustment is recorded: the results are those as found and as left
    .yes = adjusted during this calibration: results as found and as left are given below
certificate-sampling = none: the object identified on page 1 itself was calibrated
certificate-traceability = The results are traceable to the International System of Units (SI) through the measurement standards above and the certificates stated for them.
    .in-part = The results are traceable to the International System of Units (SI) through those measurement standards above that have a traceable certificate; none is given for { $names }.
    .none = No traceable certificate of a measurement standard is given: no metrological traceability is claimed for the results.
    .invalid-run = The run is invalid: no metrological traceability is claimed for its values.
certificate-as-found = The unit was adjusted. Results and verdict of this certificate are those of the unit as left; as found, before adjustment, it was calibrated by the same method and assessed against the same limits, with the results below.
certificate-other-results = Other results
certificate-column = Value
    .gyro-g-sensitivity = (a) by eq. (7)
    .gyro-g-sensitivity-second = (b) without Earth rate
    .accel-rate-sensitivity = (a) by eq. (12), (13)
    .accel-rate-sensitivity-joint = (a) sign of eq. (12)
    .accel-rate-sensitivity-second = (b) sign of model (2)
certificate-not-decided =
    .gyro-fit-offset = b of eq. (4) is given for information and no decision is based on it; the gyro bias is given in section 2.
certificate-about =
    .gyro-fit-offset = b is determined from the rate points and differs from the bias B: about a vertical axis b also includes g_ii × 1 g and the component of Earth's rotation about that axis.
    .gyro-g-sensitivity = g is the local gravity. First index: the axis that reads; second: the input axis.
    .accel-rate-sensitivity = The unit m is m/s² per (rad/s)². (a) is rest minus turning, the negative of p in model (2); compensate with (b). The values of p hold for this mounting position.
    .accel-rate-sensitivity-joint = The unit m is m/s² per (rad/s)². The joint fit gives p of model (2), which is (b): compensate with it; (a) is its negative, the sign of eq. (12) and (13). The values of p hold for this mounting position.
certificate-applied = The limits are applied to: { $quantities }.
certificate-relative = Relative limits: { $limits }.
certificate-missing = Not determined: { $cause }.
    .item = this item is not part of this calibration
    .second = (b) could not be computed

## What the clause's value contains

certificate-contained = { $value } includes { $part }: most clearly for { $element }, { $size }, { $times } times U; the value without it is given in the annex.
    .gyro-g-sensitivity-without-earth-rotation = Earth's rotation
    .accel-rate-sensitivity-without-lever-arm = the lever arm
certificate-value-of =
    .gyro-g-sensitivity-without-earth-rotation = The value by eq. (7)
    .accel-rate-sensitivity-without-lever-arm = The value by eq. (12), (13)
    .joint = The value

## Conditions of the measurement

certificate-turns =
    .known-angle = { $count } turns by a known angle
    .counts = { $counts } turns
    .at-rates = { $counts } turns at { $rates } °/s
certificate-dwell =
    .static = { $seconds } s at rest
    .rate = { $seconds } s at constant rate
certificate-positions =
    .rests = { $count } rests
    .up = { $count } directions up: { $ups }
    .headings = headings { $headings }
    .some-headings = headings { $headings } (not each with every axis up)
    .not-given = headings not given
    .zero = { $count } of { $seconds } s each
certificate-of-axis = { $axis } axis: { $text }

## Uncertainty

certificate-kind =
    .type-a = type A
    .gum = GUM, type A and B combined
    .as-the-specifications-example = as Appendix A of the specification
    .monte-carlo = Monte Carlo, type A and B combined
certificate-rounding = U is the expanded uncertainty, U = k·u; the coverage factor k is given in the heading of each item. u is first rounded to three significant digits; according to JJF 1059.1, U has two and is rounded up; the value is rounded to the same last place.
certificate-u-contains =
    .type-a = The uncertainties of this certificate are type A only, evaluated from the scatter of this run. The contributions of the turntable, the reference standards and the data acquisition are not included; until they are added, U is not the complete measurement uncertainty.
    .gum = The uncertainties follow the law of propagation (GUM, JJF 1059.1): type A from the data of this run, with their autocorrelation, and type B from the limits of the equipment.
    .as-the-specifications-example = The uncertainties are evaluated as in the examples of Appendix A: u1 (table), u2 (data acquisition) and u3 (repeatability, added linearly), in quadrature.
    .monte-carlo = The uncertainties follow from the propagation of distributions by Monte Carlo (JCGM 101, JJF 1059.2) through the equation of each item: type A from the data of this run, with their autocorrelation, and type B from the limits of the equipment; U is not less than half the coverage interval.
certificate-u-in-short = { $parts }.
    .type-a = U includes type A only
    .gum = U includes type A and type B (GUM)
    .as-the-specifications-example = U is evaluated as in the specification's Appendix A
    .monte-carlo = U includes type A and type B (Monte Carlo), coverage probability 95 % or more
certificate-coverage = k = { $k }, about { $percent } % coverage probability for a normal distribution
    .by-t = k = 2 to { $k } as stated at each item, about 95 % coverage probability
    .up-to = k up to { $k }
certificate-coverage-by-t = A factor k above 2 is that of Student's t for 95 % coverage probability, where an element of the item has fewer than 50 effective degrees of freedom.
certificate-limits = Limits used for type B: { $parts }.
    .own = limits stated by the laboratory: { $limits }
    .recommended = for table and fixture the limits recommended by { $sources }, which this equipment is assumed to meet: { $limits }
    .assumed = { $limit } assumed known to { $known }
certificate-limit-of-standard = { $limit } { $half_width }
    .shaped = { $limit } { $half_width } ({ $shape })
    .uncertainty = { $limit } { $U } (k = 2)
certificate-function-of-standard =
    .corrected = { $limit }{ $range }: deviation within { $deviation }, corrected; U ≤ { $U } (k = { $k })
    .budgeted = { $limit }{ $range }: deviation within { $deviation }, not corrected but counted with U; U ≤ { $U } (k = { $k })
certificate-by-function =
    .corrected = { $paper }, deviation corrected
    .budgeted = { $paper }, deviation not corrected but counted with U
    .drift = { $source }, drift over { $years } years included
certificate-assumed =
    .gravity = assumed: calculated from latitude and height, anomalies within 50 mGal
    .latitude = assumed: latitude stated to 0.1°
    .level = assumed: the outermost axis is as vertical as the axes are square
certificate-axes =
    .fixture = The results hold for the axes of the fixture: U does not include how far the base of the unit is tilted in it.
    .unit = The results hold for the axes of the unit, turned from those of the fixture as the mount in the recording states: U includes neither that statement's error nor how far the base of the unit is tilted.
    .mounting-plane = The results hold for the axes of the unit's mounting plane (its base): U includes how far it may be tilted in the fixture.
    .mounting-unknown = The results are ordered for the axes of the unit's mounting plane (its base), but how far it is tilted in the fixture is not known and not included in U: U holds for the axes of the fixture alone.
certificate-axes-setting =
    .fixture = those of the fixture
    .unit = those of the unit, by the stated mount
    .mounting-plane = those of the mounting plane
certificate-switch-on = A zero (bias, fit offset, zero offset) is its mean over this switch-on. U has the noise and what is slower up to relaxations of 5000 s; it does not have what a zero changes from one switch-on to the next, which a mean over all time would add.
certificate-flatness =
    .jjf-2003-2022 = The flatness of table and fixture (Table 1, 6.2: 0.02 mm) is not included: the tilt of the base that it causes depends on the length of the base, which the specification does not give; over 100 mm it would be about 41″, more than the limit of the fixture's squareness.
    .jjf-1536-2015 = The flatness of the fixture (6.2.2 b): 0.01 mm) is not included: the tilt of the base that it causes depends on the length of the base, which the specification does not give; over 100 mm it would be about 21″, more than the limit of the fixture's squareness.
certificate-capability =
    .stated = The laboratory states no U below its calibration and measurement capability (CMC, k = 2): of { $items } the evaluated U is smaller, and the capability is stated in its place.
    .outside = The laboratory's calibration and measurement capabilities do not cover { $items }, which are outside its accreditation: this certificate does not refer to the accreditation.
certificate-capability-item = { $item } ({ $symbols })
certificate-validation = { $record }.
certificate-distribution =
    .normal = normal
    .rectangular = rectangular
    .triangular = triangular
    .arcsine = arcsine
    .t = t
certificate-budget-of = Budget of { $symbol }, the largest of this item
certificate-budgets =
    .gum = The inputs are independent of each other; a sensitivity is in the unit of the result per that of the input. U = k·u with k = 2 where no element has fewer than 50 effective degrees of freedom, else with the largest k of the item's elements. The half width of the 95 % interval follows from the propagation of the distributions (JCGM 101).
    .as-the-specifications-example = As in Appendix A of the specification: u1 and u2 with sensitivity 1; u3 is the sum of the standard uncertainties of the positions, each in the unit of the result; U = 2·u.
    .monte-carlo = The inputs are independent of each other, drawn from their distributions and propagated through the item's equation (JCGM 101); sensitivities and contributions are those of its linear form. U is half the probabilistically symmetric coverage interval, with the largest k = U/u of the item's elements.

## Statement of conformity

certificate-rule =
    .simple-acceptance = simple acceptance (JCGM 106, 8.2): a measured value inside its limits conforms, without a guard band (w = 0)
    .guard-band = guard band (JCGM 106, 8.3): a measured value inside its acceptance limits AL conforms; they lie inside the limits by w = { $w }
    .guard-band-outwards = guard band (JCGM 106, 8.3): a measured value inside its acceptance limits AL conforms; they lie outside the limits by w = { $w }
    .shared-risk = shared risk (JCGM 106, 8.2): as both parties agreed, a measured value inside its limits conforms (w = 0)
    .capability = { $rule }, provided that C_m = T/(2 U) ≥ { $needed }, with T the width of the interval; otherwise a value fails only if value ± U lies entirely outside the limits, and is not decided on in any other case
    .unbounded = { $rule }, one-sided limits for which no largest U is agreed are decided on only if P_c ≥ 95 % or ≤ 5 %
    .bound = { $item } decided on only if U ≤ { $U_max }, or if value ± U lies entirely outside the limits
    .coverage-factor = U has k = { $k }
certificate-rule-of = { $items }: { $rule }
certificate-risk = { $parts } (JCGM 106, 9.3)
    .acceptance = false acceptance of a pass, 1 − P_c, the largest { $chance } ({ $symbol })
    .rejection = false rejection of a fail, P_c, the largest { $chance } ({ $symbol })
certificate-risk-how = The probability of conformity and the risks follow from the measured value and its standard uncertainty u (normal, or t where its degrees of freedom are finite), without prior knowledge (JCGM 106, 9.3).
certificate-global-risk = { $parts } (JCGM 106, 9.5)
    .item = { $item }: consumer's { $consumer }, producer's { $producer }
certificate-marks =
    .absent = —: no limit specified; not determined: no value, the reason is given below the table
    .chance = the percentage under a verdict is the probability of conformity P_c
    .conditional = conditional: the value lies within U of a limit, or is accepted outside it (ILAC-G8:09/2019)
    .nothing-accepted = AL –: U is larger than the guard bands allow, and leaves no acceptance interval
certificate-reason-alike = { $reason }; likewise, with their own figures: { $symbols }
certificate-see-remarks = Remarks below that prevent a pass: { $count }.
certificate-accepted = AL { $limits }
certificate-segments =
    .static = { $count ->
        [one] 1 rest
       *[other] { $count } rests
    }
    .rate = { $count ->
        [one] 1 constant rate
       *[other] { $count } constant rates
    }
    .rotation = { $count ->
        [one] 1 turn by a known angle
       *[other] { $count } turns by a known angle
    }
    .settle = { $count ->
        [one] 1 wait
       *[other] { $count } waits
    }
    .transition = { $count ->
        [one] 1 move
       *[other] { $count } moves
    }
certificate-remark = { $remark } [{ $segments }]
    .alike = { $remark } The same applies, with { $count ->
        [one] its own figures, to 1 more segment
       *[other] their own figures, to { $count } more segments
    }.
    .blocks = { $remark } This prevents a pass.
    .invalid = { $remark } This makes the run invalid.
certificate-reading-of = { $items }
certificate-unregistered = this identifier is not in the register

## Labels of the layout

certificate-figure =
    .rate-residuals = Residuals over angular rate
    .rate-residuals-caption = Points: mean reading minus scale factor times table rate, minus the mean of these differences, for each axis. Grey: ± U of the line at that rate, from the U of its scale factor and offset.
    .tumble = Residuals in the positions of the tumble
    .tumble-caption = Mean reading of each accelerometer minus the prediction by its scale factor, cross coupling and bias in that position, labelled by the axis pointing up. Bars: ± U of that model.
    .allan = Allan deviation
    .allan-caption = Overlapping Allan deviation of the longest rests of this run. Bars: ± U for the degrees of freedom of white noise.
    .history = History of the unit
    .history-caption = Values of earlier certificates minus those of this one, with ± U of each. Certificates: { $certificates }.
certificate-label-certificate-number = Certificate No.
certificate-label-report-number = Report No.
certificate-label-page = Page { $here } of { $last }
certificate-label-basis = Basis of the calibration
certificate-label-object = Condition and configuration of the object
certificate-label-traceability = Metrological traceability
certificate-label-standards = Measurement standards used
certificate-label-name = Name
certificate-label-serial = Serial number
certificate-label-accuracy = Accuracy
certificate-label-standard-certificate = Certificate number
certificate-label-valid-until = Valid until
certificate-label-environment = Environmental conditions
certificate-label-condition = Condition
certificate-label-during = During the calibration
certificate-label-required = Specification, clause 6
certificate-label-conditions = Conditions of the measurement
certificate-label-axis = Axis
certificate-label-rate-points = Rate points (°/s)
certificate-label-points = Points
certificate-label-rate-for-p = Rate used for p (°/s)
certificate-label-as-found = As found and as left
certificate-label-found = As found
certificate-label-left = As left
certificate-label-found-verdict = Verdict as found
certificate-label-results = Results of the calibration
certificate-label-figures = Figures
certificate-label-uncertainty = Statement of uncertainty
certificate-label-annex = Annex
certificate-label-annex-introduction = For the laboratory, and for whoever asks how the results came about: how the specification was read, how the uncertainty was evaluated, figures, further information, origin of the data. Nothing in this annex changes results or verdict.
certificate-label-annex-follows = An annex follows: readings of the specification, evaluation of the uncertainty, figures, further information, origin of the data.
certificate-label-segments = Segments of the remarks
certificate-label-conformity = Statement of conformity
certificate-label-reasons = Reasons
certificate-label-remarks = Remarks
certificate-label-readings = Readings of the specification
certificate-label-trace = Origin and processing of the data
certificate-label-information = For information, not decided on
certificate-label-information-introduction = Derived from the data of this run; these are not results of the clauses, and no decision is based on them. Stated as value ± U, with k from Student's t for few degrees of freedom. Where a number or U is missing, the sentence below gives the reason.
certificate-label-not-determined = not determined
certificate-label-clause = Clause
certificate-label-element = Element
certificate-label-expanded-uncertainty = Uncertainty
certificate-label-of-a = of (a)
certificate-label-of-b = of (b)
certificate-label-unit = Unit
certificate-label-limits = Limits
certificate-label-verdict = Verdict
certificate-label-conclusion = Verdict
certificate-label-job-title = Title
certificate-label-issue-date = Date of issue
certificate-label-stamp = Calibration stamp
certificate-label-end = End of certificate
certificate-label-only-this = The results relate only to the object calibrated. This certificate may not be reproduced other than in full without the written consent of the laboratory.
certificate-label-budgets = Uncertainty budgets
certificate-label-equipment-limits = Limits of the equipment
certificate-label-input = Input
certificate-label-type = Type
certificate-label-distribution = Distribution
certificate-label-standard-uncertainty = Standard uncertainty
certificate-label-sensitivity = Sensitivity
certificate-label-contribution = Contribution
certificate-label-share = Share %
certificate-label-dof = dof
certificate-label-half-width = Half width, or U with k = 2
certificate-label-source = Source
certificate-label-budget-element = Element
certificate-label-type-a = Type A
certificate-label-type-b = Type B
certificate-label-combined = Combined
certificate-label-effective-dof = Effective dof
certificate-label-expanded = Expanded
certificate-label-half-width-95 = 95 % half width
certificate-label-every-element = Every element
certificate-label-in = in
certificate-label-no-symbol = Appendix B|type B|X axis
certificate-seal = Number and SHA-256 digest of the record, as in the code on page 1; the Digital Calibration Certificate (DCC) containing that record is attached to this file.
    .signed = This file and the DCC are signed electronically by the laboratory.
    .by-hand = To be signed by hand: this file has no electronic signature.
