## What every room uses.

list-separator = {", "}
clause-sequence = { $first }; { $rest }
