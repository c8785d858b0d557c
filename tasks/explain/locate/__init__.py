"""Where the excess of a finding lies: channel, part of the run and segments."""
