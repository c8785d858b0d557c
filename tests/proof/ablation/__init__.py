"""Each rule of `explain` switched off in turn, on kept recordings whose truth is known."""
