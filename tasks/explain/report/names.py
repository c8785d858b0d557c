"""Names of channels, elements and quantities with U in the sentences of the report."""

from schemas.discrepancy import Consequence, FoundParameter, VerdictChange
from tasks.explain.channels import CHANNELS
from tasks.explain.correction.consequences import OVERALL
from tasks.specifications.items import ITEMS
from tasks.words import Message, Sayable, known, message
from tasks.words.quantities import Quantities, multiple, quantities, quantity
from tasks.words.rounding import USUAL_K


def channel_title(channels: str) -> Message:
    """“gyro x” of “gyro_x”; several where an entry of `Where` names several: “gyro_x, gyro_y”."""
    names = channels.split(", ")
    titles = (message(f"channel-{name}") if name in CHANNELS else name for name in names)
    return message("list", entries=tuple(titles))


def short_channel_title(channel: str) -> Message:
    """“accel. x” of “accel_x”, where there is little room."""
    return message(f"channel-{channel}.short")


def element_title(item: str, element: str) -> Sayable:
    """An element of a certificate's item; the item where the element is empty."""
    if item == OVERALL:
        return message("report-whole-certificate")
    if item not in ITEMS:
        return f"{item} {element}".strip()
    defined = ITEMS[item]
    return defined.element_title(element) if element else defined.title


def verdict_title(verdict: str) -> Sayable:
    """“pass”, “fail”, “inconclusive”."""
    id_ = f"conformity-verdict.{verdict}"
    return message(id_) if known(id_) else verdict


def change_title(change: VerdictChange) -> Message:
    """“fail → pass”."""
    before, after = verdict_title(change.before), verdict_title(change.after)
    return message("report-change", before=before, after=after)


def shift_text(moved: Consequence) -> str:
    """By how many U an element of the certificate moves, with its sign; empty where it does not."""
    by = moved.in_U
    return multiple(by) if by else ""


def before_and_after(moved: Consequence) -> Quantities:
    """An element's value without the finding and with it, each that is there with its U."""
    U_before = moved.U if moved.U_before is None else moved.U_before  # of an earlier version
    values = [moved.before, moved.after]
    pairs = zip(values, [U_before, moved.U], strict=True)
    return quantities(values, [None if value is None else U for value, U in pairs], moved.unit)


def capital(phrase: Sayable) -> Message:
    """The text with a capital initial; a symbol stays as it is."""
    return message("initial", text=phrase)


def sentence(phrase: Sayable) -> Message:
    """What stands alone as a sentence, with its full stop."""
    return capital(message("report-sentence", text=phrase))


def lower(phrase: Sayable) -> Message:
    """The text with a lower-case initial; a symbol stays as it is."""
    return message("initial.lower", text=phrase)


def parameter_name(name: str) -> Sayable:
    """“vertical rate” of “vertical_rate”, “gyro x” of “gyro_x”; a symbol stays: “r_x”."""
    for kind in ("parameter-", "channel-", "triad-"):
        if known(kind + name):
            return message(kind + name)
    quantity, _, channel = name.partition("_")
    if channel in CHANNELS and known("parameter-of-" + quantity):
        return message("parameter-of-" + quantity, channel=channel_title(channel))
    channel, _, number = name.rpartition("_")
    if channel in CHANNELS and number.isdigit():
        return message("report-factor", channel=channel_title(channel), number=int(number))
    return name if name[1:2] == "_" else name.replace("_", " ")


def parameter_text(parameter: FoundParameter) -> Message:
    """“vertical rate = (9.66 ± 0.40) °/h”; U = 2 u."""
    size = quantity(parameter.value, USUAL_K * parameter.u, parameter.unit)
    return message("report-parameter", name=parameter_name(parameter.name), size=size)
