"""The result of the last `mimucal review`, kept in the home folder."""

from pydantic import ValidationError

from schemas.base import Unusable, first_fault
from schemas.review import KeptReview
from storage.home import Home
from storage.whole_files import writing_to

NAME = "review.json"


def keep(kept: KeptReview, home: Home) -> None:
    """Keeps an answer in the place of the one before. Raises Unusable where the home only reads."""
    with writing_to(home.path / NAME) as draft:
        draft.write_text(kept.model_dump_json(indent=1), encoding="utf-8")


def last(home: Home) -> KeptReview | None:
    """The last answer; None without one. Raises Unusable for one that cannot be read."""
    path = home.path / NAME
    try:
        return KeptReview.model_validate_json(path.read_bytes())
    except FileNotFoundError:
        return None
    except OSError as error:
        raise Unusable(f"{path} cannot be read ({error.strerror}); grant access to it.") from error
    except ValidationError as error:
        raise Unusable(
            f"{path}: {first_fault(error)}; `mimucal review` writes it again."
        ) from error
