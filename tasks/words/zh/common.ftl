## 各处共用。

list-separator = 、
clause-sequence = { $first }；{ $rest }
