## What every room uses.

list-separator = {", "}
