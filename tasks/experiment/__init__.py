"""Design of the shortest recording on a station that tells competing models apart."""
