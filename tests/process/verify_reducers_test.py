#!/usr/bin/python3 -B
"""The reducers of ./tern verify on signals whose answers are known, and that a wrong signal makes each of them fail.

Every test evaluates one quantity twice: on a right signal (passes) and on a spoilt one (fails), through judge(), the
function ./tern verify uses; so each is a proof that its reducer can go red.
"""

import json
import math
import tempfile
import unittest
from pathlib import Path

from tern.errors import Error
from tern.verify import bands, expected

EVERYWHERE = {"unit": "m", "source": "closed form", "confidence": "A", "name": "q"}


class ReducerTest(unittest.TestCase):
    def setUp(self):
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(directory.cleanup)
        self.run = Path(directory.name)

    def judge(self, function, times=None, **quantity):
        """The row of one quantity for the signal v = function(t), t = 0, 0.01 ... 2 s unless told; None = empty cell."""
        times = times or [0.01 * step for step in range(201)]
        rows = [f"{t:.9g},{'' if function(t) is None else format(function(t), '.9g')}" for t in times]
        (self.run / "gauges.csv").write_text("t_s,P.ux_m\n" + "\n".join(rows) + "\n")
        table = EVERYWHERE | {"column": "P.ux_m"} | {key.rstrip("_"): value for key, value in quantity.items()}
        return bands.judge(self.run, [expected.check("expected.toml", table, self.run)])[0]

    def both(self, right, spoilt, **quantity):
        row = self.judge(right, **quantity)
        self.assertTrue(row["passed"], row)
        self.assertFalse(self.judge(spoilt, **quantity)["passed"])
        return row["value"]

    def test_value_interpolates_between_rows(self):
        value = self.both(lambda t: 3 * t, lambda t: 3.1 * t, kind="value", at=0.505, band=[1.514, 1.516])
        self.assertAlmostEqual(value, 1.515, 12)

    def test_mean_weights_by_time_and_not_by_row(self):
        uneven = [0, 0.9, 0.95, 0.96, 0.97, 0.98, 0.99, 1.0]
        quantity = {"kind": "mean", "band": [0.49, 0.51], "times": uneven}
        self.both(lambda t: t, lambda t: t + 0.05, **quantity)

    def test_extremes_and_their_times(self):
        def right(t):
            return math.sin(math.pi * t)  # one maximum at 0.5 s, one minimum at 1.5 s
        self.both(right, lambda t: 1.1 * right(t), kind="maximum", band=[0.99, 1.01])
        self.both(right, lambda t: 1.1 * right(t), kind="minimum", band=[-1.01, -0.99])
        self.both(right, lambda t: right(t - 0.1), kind="time_of_maximum", band=[0.49, 0.51])
        self.both(right, lambda t: right(t - 0.1), kind="time_of_minimum", band=[1.49, 1.51])

    def test_loss_per_period_is_that_of_the_swing(self):
        def swing(t, loss):
            return 3 + (1 - loss) ** (t / 0.4) * math.cos(2 * math.pi * t / 0.4)
        value = self.both(lambda t: swing(t, 0.1), lambda t: swing(t, 0.12), kind="loss_per_period", about=3.0, band=[0.09, 0.11])
        self.assertAlmostEqual(value, 0.1, 2)

    def test_largest_magnitude_bounds_both_signs(self):
        self.both(lambda t: -0.9 * t, lambda t: -1.1 * t, kind="largest_magnitude", at_most=2.0)

    def test_crossing_is_the_first_rise_through_the_threshold(self):
        value = self.both(lambda t: -max(0.0, t - 1) * 0.1, lambda t: -max(0.0, t - 1.1) * 0.1, kind="crossing",
                          threshold=5e-4, band=[1.0, 1.01])
        self.assertAlmostEqual(value, 1.005, 9)
        self.assertIn("never rises", self.judge(lambda t: 0.0, kind="crossing", threshold=5e-4, band=[0, 9])["why"])

    def test_period_frequency_and_zero_crossings(self):
        def wave(f):
            return lambda t: 0.3 + math.cos(2 * math.pi * f * t)
        self.both(wave(4.95), wave(4.656), kind="frequency", about=0.3, band=[4.9, 5.0])
        self.both(wave(4.95), wave(4.656), kind="period", about=0.3, band=[0.2, 0.204])
        self.both(wave(2.5), wave(2.4), kind="zero_crossing", about=0.3, number=2, band=[0.299, 0.301])
        self.assertIn("three zero crossings", self.judge(lambda t: t - 1, kind="period", band=[0, 9])["why"])

    def test_monotone_decay_is_told_from_growth(self):
        self.both(lambda t: math.exp(-t), lambda t: math.exp(-t) + 0.02 * math.sin(20 * t), kind="non_monotone",
                  direction="decreasing", at_most=1e-12)

    def test_largest_rise_adds_up_over_many_rows(self):
        value = self.both(lambda t: -t if t < 1 else -1 + 0.1 * (t - 1), lambda t: -t if t < 1 else -1 + 0.2 * (t - 1),
                          kind="largest_rise", at_most=0.11)
        self.assertAlmostEqual(value, 0.1, 9)
        self.assertEqual(self.judge(lambda t: -t, kind="largest_rise", at_most=0)["value"], 0)

    def test_a_list_of_columns_is_their_sum(self):
        def judge(growth):
            rows = [f"{0.01 * k:.9g},{k},{growth * k}" for k in range(201)]
            (self.run / "energy.csv").write_text("t_s,kinetic_J,potential_J\n" + "\n".join(rows) + "\n")
            table = EVERYWHERE | {"kind": "largest_rise", "file": "energy.csv", "column": ["kinetic_J", "potential_J"],
                                  "at_most": 1e-9}
            return bands.judge(self.run, [expected.check("expected.toml", table, self.run)])[0]["passed"]
        self.assertTrue(judge(-1))
        self.assertFalse(judge(-0.9))

    def test_differences_to_an_expression(self):
        quantity = {"expression": "0.1*exp(-t)*cos(2*pi*t)", "from_": 0.5, "to": 1.5}
        right = lambda t: 0.1 * math.exp(-t) * math.cos(2 * math.pi * t)  # noqa: E731
        self.both(right, lambda t: right(t) + 0.02, kind="max_difference", at_most=0.001, **quantity)
        self.both(right, lambda t: right(t) + 0.02, kind="l2_difference", scale=0.1, at_most=0.01, **quantity)
        # 0.3 off for a tenth of the window: 0.03 in the mean, 0.095 in the root of the mean square.
        self.both(lambda t: right(t) + (0.3 if 0.9 < t < 1 else 0), lambda t: right(t) - (0.6 if 0.9 < t < 1 else 0),
                  kind="l1_difference", at_most=0.05, **quantity)
        self.assertTrue(self.judge(lambda t: right(t) + (9 if t < 0.4 else 0), kind="max_difference", at_most=0.001,
                                   **quantity)["passed"], "outside of the window nothing counts")

    def test_differences_to_a_csv_with_comments_and_other_times(self):
        rows = "\n".join(f"{0.03 * step},{0.06 * step}" for step in range(80))
        (self.run / "reference.csv").write_text(f"# source: a line\nt_s,u_m\n{rows}\n")
        self.both(lambda t: 2 * t, lambda t: 2.1 * t, kind="max_difference", csv="reference.csv", csv_column="u_m",
                  at_most=0.01)

    def test_a_run_that_ended_early_does_not_pass_a_window_it_never_reached(self):
        # Seen to fail: without covers() in reducers._part().
        row = self.judge(lambda t: 0.0, times=[0, 0.5, 1.0], kind="largest_magnitude", from_=0, to=2, at_most=1)
        self.assertFalse(row["passed"])
        self.assertIn("only from t = 0 s to t = 1 s", row["why"])

    def test_undefined_cells_are_left_out_and_a_column_of_them_fails(self):
        # Seen to fail: with empty cells read as 0.
        row = self.judge(lambda t: None if t < 1 else 5.0, kind="minimum", band=[4.9, 5.1])
        self.assertTrue(row["passed"])
        self.assertFalse(self.judge(lambda t: None, kind="minimum", band=[-9, 9])["passed"])

    def test_a_single_value_that_is_not_a_number_fails(self):
        # Seen to fail: without the isfinite check in series.read() (max() of a list steps over the NaN in it).
        row = self.judge(lambda t: math.nan if t == 1.0 else 0.0, kind="maximum", at_most=1)
        self.assertFalse(row["passed"])
        self.assertIn("line 102: P.ux_m is nan", row["why"])

    def test_a_missing_file_or_column_fails_and_says_so(self):
        table = EVERYWHERE | {"kind": "maximum", "column": "Q.ux_m", "at_most": 1.0}
        self.assertIn("does not exist", bands.judge(self.run, [dict(table)])[0]["why"])
        (self.run / "gauges.csv").write_text("t_s,P.ux_m\n0,1\n")
        self.assertIn("no column Q.ux_m; it has t_s, P.ux_m", bands.judge(self.run, [dict(table)])[0]["why"])

    def test_measures_come_from_run_json(self):
        table = EVERYWHERE | {"kind": "measure", "measure": "volume_drift", "magnitude": True, "at_most": 0.01}
        for value, passed in ((-0.009, True), (-0.011, False)):
            contents = {"status": "done", "processes": {"fluid": {"measures": {"volume_drift": value}}}}
            (self.run / "run.json").write_text(json.dumps(contents))
            self.assertEqual(bands.judge(self.run, [table])[0]["passed"], passed)
        (self.run / "run.json").write_text('{"status": "done"}')
        self.assertIn("no process reported", bands.judge(self.run, [table])[0]["why"])

    def test_field_norms_at_a_frame(self):
        import h5py
        import numpy
        y = numpy.linspace(0.0125, 0.9875, 40)
        table = EVERYWHERE | {"kind": "field", "process": "fluid", "field": "pressure", "expression": "9810*(1-y)",
                              "scale": 9810.0, "at": "end"}

        def write(pressure):
            with h5py.File(self.run / "fluid.h5", "w") as file:
                for number, factor in enumerate((3.0, 1.0)):  # the first frame is far off: "end" must not see it
                    group = file.create_group(f"frame_{number:06d}")
                    group.attrs["time_s"] = 0.5 * number
                    group["position"] = numpy.stack([0 * y, y, 0 * y], axis=1)
                    group["pressure"] = factor * pressure

        for norm, spoilt in (("l2", 1.02), ("max", 1.02), ("mean", 1.03)):
            quantity = expected.check("expected.toml", table | {"norm": norm, "band": [-0.01, 0.01]}, self.run)
            write(9810 * (1 - y))
            self.assertTrue(bands.judge(self.run, [quantity])[0]["passed"])
            write(9810 * (1 - y) * spoilt)
            self.assertFalse(bands.judge(self.run, [quantity])[0]["passed"])
        window = {key: value for key, value in table.items() if key != "at"} | {"from": 0.0, "norm": "l2", "at_most": 0.1}
        self.assertFalse(bands.judge(self.run, [window])[0]["passed"], "the worst frame of a window counts")
        write(9810 * (1 - y) + 981 * (y > 0.5))
        whole = table | {"norm": "max", "at_most": 0.01}
        self.assertFalse(bands.judge(self.run, [whole])[0]["passed"])
        self.assertTrue(bands.judge(self.run, [whole | {"max": [1.0, 0.4]}])[0]["passed"], "a box leaves the rest out")

    def test_a_mistake_in_expected_toml_is_refused(self):
        # Seen to fail: without _check_keys().
        for wrong in ({"kind": "maximun", "at_most": 1}, {"kind": "maximum"}, {"kind": "maximum", "at_most": 1, "too": 2},
                      {"kind": "value", "at_most": 1}, {"kind": "max_difference", "at_most": 1},
                      {"kind": "maximum", "at_most": 1, "band": [0, 1]}):
            with self.assertRaises(Error):
                expected.check("expected.toml", EVERYWHERE | {"column": "P.ux_m"} | wrong, self.run)

    def test_every_expected_toml_of_the_repository_is_valid(self):
        # Seen to fail: with a misspelt key in one of them.
        paths = sorted((Path(__file__).resolve().parent.parent.parent / "cases").glob("*/expected.toml"))
        self.assertGreaterEqual(len(paths), 4)
        for path in paths:
            expected.read(path)

    def test_expressions_are_arithmetic_only(self):
        # Seen to fail: with eval().
        row = self.judge(lambda t: 0.0, kind="max_difference", expression="__import__('os').getpid()", at_most=1e9)
        self.assertIn("is not arithmetic", row["why"])


if __name__ == "__main__":
    unittest.main()
