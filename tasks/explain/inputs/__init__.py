"""From a recording to block means of readings and motion: noise, events, delay."""
