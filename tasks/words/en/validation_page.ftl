## The page of a validation record.

validation-page-title = Validation of the estimation
validation-page-made = { $valid } of { $items } items are validated. Created on { $date } with { $code }, seed { $seed }, in { $seconds } s.
validation-page-fingerprints = Fingerprints of the source:
validation-page-method = Each unit is simulated with the physics of the virtual station: its noise is white, or white plus flicker of individual strength; errors of table, fixture, gravity and latitude are drawn for each run within the limits that the budgets claim. An item is validated if its worked example is reproduced, an ideal run recovers the truth, other programs agree, and its stated 95 % intervals contain the truth in at least { $least } % of cases; an element, if its own intervals do so in { $least } % to { $most } %.
validation-page-picture = Share of cases in which the 95 % interval contains the truth, with its own 95 % interval; green: required range.
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
validation-page-outside = { $short } elements are not validated: their intervals contain the truth in less than { $least } % of cases, and no unit passes on them. The intervals of { $long } elements contain it in more than { $most } %: longer than they need be, and valid.
validation-page-column-element = element
