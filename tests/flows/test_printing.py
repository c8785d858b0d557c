"""Tables on standard output."""

from flows.printing import FRAMED, print_rows


def test_a_table_of_thousands_of_rows_keeps_its_columns_without_lines(capsys) -> None:
    rows = [(f"r{number}", "转台" if number % 2 else "table") for number in range(FRAMED + 1)]
    print_rows("Runs", ("run", "unit"), rows)
    title, head, *lines = capsys.readouterr().out.splitlines()
    assert (title, head, len(lines)) == ("Runs", "run   unit", FRAMED + 1)
    assert (lines[0], lines[-2], lines[-1]) == ("r0    table", "r499  转台", "r500  table")
