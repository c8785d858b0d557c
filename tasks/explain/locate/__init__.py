"""Where a finding's excess sits: channel, part of the run and segments."""
