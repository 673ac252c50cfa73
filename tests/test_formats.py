"""Numbers and durations for people."""

from millscale.formats import counted, degrees, duration, hundredths, number, percent


def test_numbers_for_people():
    assert [hundredths(0.0123), hundredths(None)] == ["1.23", "–"]
    assert [degrees(1.0), degrees(None)] == ["57.3", "–"]
    assert [number(1.23456, 2), number(None), number(0.0)] == ["1.23", "–", "0.000"]
    # A small mill's energies and power are not shown as nothing.
    assert [number(2.39e-5, 4), number(-4.2e-4)] == ["2.39e-05", "-0.00042"]
    assert number(0.0012) == "0.001"
    assert [percent(0.0123), percent(-0.5, 0), percent(None)] == ["+1.23 %", "-50 %", "–"]
    given = (3.14, 9.96, 59.4, 59.6, 185, 8000, None)
    shown = ["3.1 s", "10 s", "59 s", "1 min 0 s", "3 min 5 s", "2 h 13 min", "–"]
    assert [duration(x) for x in given] == shown


def test_a_count_has_its_noun_in_the_singular_or_plural():
    assert [counted(n, "case") for n in (0, 1, 2)] == ["no cases", "1 case", "2 cases"]
