## Reminders of recalibration, and advice on its interval.

reminder-title =
    .before = Recalibration of { $unit } due on { $due }
    .after = Recalibration of { $unit } was due on { $due }
reminder-body =
    .before = { $unit } is due for recalibration on { $due }, as agreed for certificate { $certificate } of { $issued }. This is the reminder { $days } days before. { $laboratory }
    .after = { $unit } was due for recalibration on { $due }, as agreed for certificate { $certificate } of { $issued }; no later certificate has been issued since. This is the reminder { $days } days after. { $laboratory }
reminder-entry = Recalibration of { $unit } due
reminder-entry-of = As agreed for certificate { $certificate }.
reminder-advice =
    .too-few-unknown = { $unit }: { $intervals } intervals with a verdict are too few for the reliability method (3 are needed); the agreed { $agreed } days stand.
    .shorten-unknown = { $unit }: in none of { $intervals } intervals did the unit stay within its limits; shorten the agreed { $agreed } days.
    .keep = { $unit }: within its limits after { $conforming } of { $intervals } intervals. 95 % reliability lasts { $days } days (between { $shortest } and { $longest } with 90 % probability), which does not contradict the agreed { $agreed } days: keep them.
    .shorten = { $unit }: within its limits after { $conforming } of { $intervals } intervals. 95 % reliability lasts { $days } days (between { $shortest } and { $longest } with 90 % probability), less than the agreed { $agreed } days: shorten them.
    .may-be-longer = { $unit }: within its limits after { $conforming } of { $intervals } intervals. 95 % reliability lasts { $days } days (between { $shortest } and { $longest } with 90 % probability), more than the agreed { $agreed } days: they may be longer, up to { $shortest }.
reminder-no-advice =
    .none = The interval of “{ $serial }” needs issued certificates of one unit with the day of calibration; there is none.
    .several = The interval of “{ $serial }” needs issued certificates of one unit with the day of calibration; there are some of { $units }.
    .not-agreed = Certificate { $certificate } has no recalibration date to start from: agree on one in the order (recalibration_agreed = true).
alert-title = mimucal: something needs attention
