"""Real recordings with a known secret: what other people's hardware holds, by hand and by explain.

`present`: effects that are really there, each shown by two independent hand analyses. `hide`: a
known transformation concealed in a real recording. Neither shares code with `tasks.explain`.
"""
