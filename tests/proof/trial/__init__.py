"""The sealed trial: cases are drawn, recorded and sealed; explained blind; then opened and scored.

`blind` imports nothing of the plant, so that the processes that explain hold none of its code.
"""
