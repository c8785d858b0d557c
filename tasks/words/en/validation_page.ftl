## The page of a validation record.

validation-page-title = Validation of the estimation
validation-page-made = { $valid } of { $items } items are validated. Made on { $date } with { $code }, seed { $seed }, in { $seconds } s.
validation-page-fingerprints = Fingerprints of the source:
validation-page-method = Each unit is simulated with the physics of the virtual station: noise is white, or white and flicker of a strength of its own; errors of table, fixture, gravity and latitude are drawn for each run within the limits that the budgets claim. An item is validated if its worked example comes out, an ideal run gives the truth back, other programs agree, and its stated 95 % intervals hold the truth in at least { $least } % of the cases; an element of it, if its own do so in { $least } % to { $most } %.
validation-page-picture = Share of the cases in which the 95 % interval holds the truth, with its own 95 % interval; green: what is asked.
validation-page-column-method = method
validation-page-column-item = item
validation-page-column-units = units
validation-page-column-inside = inside 95 %
validation-page-column-interval = (95 % of that)
validation-page-column-expanded = inside U
validation-page-column-rms = rms z
validation-page-column-valid = valid
validation-page-worked-example = worked example
validation-page-truth-recovery = truth recovery
validation-page-coverage = coverage
validation-page-independent-program = independent program
validation-page-yes = yes
validation-page-no = no
validation-page-in-words = In words
validation-page-by-element = Element by element
validation-page-outside = { $count } elements are not validated: their intervals hold the truth in less than { $least } % or more than { $most } % of the cases. No unit passes on them.
validation-page-column-element = element
