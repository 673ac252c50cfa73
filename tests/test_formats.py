"""Numbers and durations for people."""

from millscale.formats import clock, counted, degrees, duration, hundredths, number, percent


def test_numbers_for_people():
    assert [hundredths(0.0123), hundredths(None)] == ["1.23", "–"]
    assert [hundredths(x, signed=True) for x in (0.0123, -0.5)] == ["+1.23", "-50.00"]
    assert [degrees(1.0), degrees(None)] == ["57.3", "–"]
    assert [number(1.23456, 2), number(None), number(0.0)] == ["1.23", "–", "0.000"]
    # A small mill's energies and power are not shown as nothing.
    assert [number(2.39e-5, 4), number(-4.2e-4)] == ["2.39e-05", "-0.00042"]
    assert number(0.0012) == "0.001"
    assert [percent(0.0123), percent(-0.5, 0), percent(None)] == ["+1.23 %", "-50 %", "–"]
    given = (3.14, 9.96, 59.4, 59.6, 185, 8000, None)
    shown = ["3.1 s", "10 s", "59 s", "1 min 0 s", "3 min 5 s", "2 h 13 min", "–"]
    assert [duration(x) for x in given] == shown


def test_times_of_a_column_have_one_form():
    given = (0.62, 9.94, 9.96, 59.6, 3725.0, 1e6, None)
    shown = ["0:00:00.6", "0:00:09.9", "0:00:10", "0:01:00", "1:02:05", "277:46:40", "–"]
    assert [clock(x) for x in given] == shown


def test_a_count_has_its_noun_in_the_singular_or_plural():
    assert [counted(n, "case") for n in (0, 1, 2)] == ["no cases", "1 case", "2 cases"]
