"""The rough half of the sealed trial: recordings on which what explains must not go on talking.

They are explained by the command of an installed engine, of this checkout or of another, so that
two engines answer the same sealed recordings.
"""
