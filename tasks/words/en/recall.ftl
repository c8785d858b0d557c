## Reminders of recalibration, and advice on its interval.

recall-title =
    .before = Recalibration of { $unit } due on { $due }
    .after = Recalibration of { $unit } was due on { $due }
recall-body =
    .before = { $unit } is due for recalibration on { $due }, as agreed for certificate { $certificate } of { $issued }. This is the reminder { $days } days before. { $laboratory }
    .after = { $unit } was due for recalibration on { $due }, as agreed for certificate { $certificate } of { $issued }; no later certificate has been issued since. This is the reminder { $days } days after. { $laboratory }
recall-entry = Recalibration of { $unit } due
recall-entry-of = As agreed for certificate { $certificate }.
