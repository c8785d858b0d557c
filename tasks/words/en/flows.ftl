## What the command line asks the person at the terminal.

flows-press-enter = Then press Enter.
