"""The recording that decides: the shortest that a station can make to tell models apart."""
