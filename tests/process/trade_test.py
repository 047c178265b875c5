#!/usr/bin/python3 -B
"""./tern study: its arithmetic on rows whose answers are known, its bookkeeping with a stand-in for the solver, and the committed
tables of docs/trade measured again where that is cheap."""

import math
import os
import signal
import subprocess
import tempfile
import unittest
from pathlib import Path

from fake_build import ROOT, FakeBuild, wait_until
from real_run import build_directory

from tern.launch import cases
from tern.results.tables import read_table
from tern.studies import accuracy, documents, front, parameters, rows, sweep
from tern.studies.rows import Row

# A fluid whose front arrives at 1 + 4 dx^2 seconds, which bursts where the Courant number is 0.3, and takes 1/dx^3 of a time.
FLUID = r'''#!/usr/bin/python3 -IB
import json, os, sys, time
words, options = sys.argv[1:], {}
for word, text in zip(words, words[1:]):
    if word == "--set":
        key, _, value = text.partition("=")
        options[key] = value
out = words[words.index("--out") + 1]
with open(os.environ["FAKE_LOG"], "a") as log:
    log.write(" ".join(f"{key}={value}" for key, value in options.items()) + "\n")
dx = float(options.get("fluid.spacing", "0.1")) * (2 if "draft" in words else 0.5 if "reference" in words else 1)
time.sleep(float(os.environ.get("FAKE_SLEEP", "0")) * (0.1 / dx) ** 3)
with open(out + "/gauges.csv", "w") as file:
    rows = int(100 * float(words[words.index("--until") + 1])) + 1
    file.write("t_s,front.x_m\n" + "".join(f"{0.01 * k},{0.01 * k - 4 * dx * dx}\n" for k in range(rows)))
burst = options.get("fluid.numerics.courant") == "0.25"
code = int(os.environ.get("FAKE_CODE", "3")) if burst else 0
with open(out + "/report.fluid.json", "w") as file:
    json.dump({"role": "fluid", "status": "failed" if burst else "done", "exit_code": code, "cause": "It burst." if burst else "",
               "cause_time": time.time() if burst else 0, "steps": 10, "time_s": 3.0, "wall_s": 0.1, "timing_s": {},
               "measures": {"pressure_iterations_mean": 5.0}}, file)
sys.exit(code)
'''

CASE = r'''#!/usr/bin/python3 -IB
import json, sys
if "--version" in sys.argv:
    print("tern-case 0.0 (stand-in)")
    sys.exit(0)
options = dict(text.split("=", 1) for word, text in zip(sys.argv, sys.argv[1:]) if word == "--set")
dx = float(options.get("fluid.spacing", "0.1")) * (2 if "draft" in sys.argv else 0.5 if "reference" in sys.argv else 1)
numerics = {"courant": float(options.get("fluid.numerics.courant", "0.2")), "gradient": "blend"}
print(json.dumps({"name": "pond", "path": sys.argv[2], "hash": json.dumps(options), "dimension": 2, "end_time": 3.0, "title": "",
                  "has_fluid": True, "has_structure": False, "expected_cpu_s": 1 / dx**3,
                  "settings": {"fluid": {"spacing": dx, "numerics": numerics,
                  "body": [{"shape": {"box": {"min": [0, 0], "max": [1, 1]}}}]}}}))
'''

EXPECTED = """[[quantity]]
name = "arrival"
kind = "crossing"
column = "front.x_m"
threshold = 1.0
unit = "s"
reference = 1.0
band = [0.9, 1.1]
source = "stand-in"
confidence = "A"
"""


def row(point, cpu_s, error, **others):
    return Row(point, status="done", cpu_s=cpu_s, wall_s=cpu_s, error=error, **others)


class ArithmeticTest(unittest.TestCase):
    # Seen to fail: with every point taken that is cheaper than the one before.
    def test_the_front_holds_what_nobody_beats(self):
        known = [row("a", 1, 0.5), row("b", 2, 0.5), row("c", 3, 0.1), row("d", 2.5, 0.6), row("e", 9, 0.09),
                 Row("f", status="failed", cpu_s=0.1),
                 row("standard-again", 0.5, 0.01)]
        self.assertEqual([one.point for one in front.pareto(known)], ["a", "c", "e"])

    def family(self, error, values=(0.4, 0.2, 0.1)):
        names = {0.2: "standard"}
        return [row(names.get(value, f"p{value}"), 1, error(value), parameter="" if value == 0.2 else "fluid.spacing", value=str(value),
                    settings={"fluid.spacing_m": str(value)}, distance_to_standard=abs(error(value) - error(0.2)),
                    distance_in_parameter=None if value == 0.2 else abs(error(value) - error(min(values)))) for value in values]

    # Seen to fail: with log(e1/e2)/log(v2/v1).
    def test_the_order_of_second_order_errors_is_two(self):
        found = front.orders(self.family(lambda value: 3 * value**2), ["fluid.spacing"])[0]
        self.assertEqual([round(order, 9) for order in found.against_reference], [2, 2])
        self.assertAlmostEqual(found.of_itself, 2, 6)
        self.assertIsNone(found.plateau)

    # Seen to fail: with the distances to the finest treated as errors, (0.4^p)/(0.2^p).
    def test_the_order_of_the_curves_does_not_see_a_wrong_reference(self):
        found = front.orders(self.family(lambda value: 0.2 + value**1.5), ["fluid.spacing"])[0]
        self.assertAlmostEqual(found.of_itself, 1.5, 6)
        self.assertLess(found.against_reference[-1], 0.5)

    # Seen to fail: with the plateau looked for from the coarse end.
    def test_a_plateau_begins_where_refining_stops_to_help(self):
        found = front.orders(self.family(lambda value: {0.4: 0.3, 0.2: 0.05, 0.1: 0.049}[value]), ["fluid.spacing"])[0]
        self.assertEqual(found.plateau, 0.2)

    # Seen to fail: with max(..., key=cpu) for min, and without the fallback.
    def test_the_answer_is_the_cheapest_within_the_error_or_the_nearest(self):
        known = [row("a", 1, 0.10), row("b", 2, 0.04), row("c", 5, 0.03), row("d", 9, 0.01)]
        self.assertEqual([(found.point, met) for found, met in (front.best_for_error(known, 0.05), front.best_for_error(known, 0.001))],
                         [("b", True), ("d", False)])
        self.assertEqual([(found.point, met) for found, met in (front.best_for_time(known, 6), front.best_for_time(known, 0.5))],
                         [("c", True), ("a", False)])

    # Seen to fail: with the error against another code taken for the judge.
    def test_nearness_to_another_code_is_no_merit(self):
        known = [row("near", 3, 0.01, distance_to_finest=0.2, judged_by="finest"),
                 row("converged", 3, 0.06, distance_to_finest=0.02, judged_by="finest")]
        self.assertEqual(front.best_for_error(known, 0.05)[0].point, "converged")
        criterion = accuracy.Criterion([{"confidence": "A"}, {"confidence": "B"}], [], 1.0, [])
        self.assertEqual(criterion.judged_by, "finest")

    # Seen to fail: with each component over its own magnitude (the second is round-off), and with undefined cells taken.
    def test_a_distance_is_over_the_magnitude_of_the_vector(self):
        import numpy
        t = numpy.linspace(0, 1, 101)
        finest = {"t_s": t, "P.ux_m": 2 + 0 * t, "P.uy_m": 1e-17 * t, "q.Fx_N": numpy.where(t < 0.5, numpy.nan, 5.0)}
        other = {"t_s": t[::2], "P.ux_m": 2.02 + 0 * t[::2], "P.uy_m": -1e-17 * t[::2], "q.Fx_N": 5.0 + 0 * t[::2]}
        self.assertAlmostEqual(accuracy.distance(other, finest), 0.01 / math.sqrt(2), 9)
        self.assertAlmostEqual(accuracy.distance(other, finest, ["P.ux_m"]), 0.01, 9)

    # Seen to fail: with numbers rounded to whole ones.
    def test_a_table_reads_back_as_it_was_written(self):
        with tempfile.TemporaryDirectory(prefix="tern-test-") as directory:
            path = Path(directory) / "cost_accuracy.csv"
            one = row("x", 1.25, 0.034, parameter="k", cause="a, \"b\"", steps=7, quantities={"height, 1 s": 0.034},
                      settings={"fluid.spacing_m": "0.1"}, version="v", distance_in_parameter=0.02)
            rows.append(path, one, rows.header(one.quantities, one.settings))
            rows.append(path, row("y", 2.0, None), rows.header(one.quantities, one.settings))
            self.assertEqual(rows.read(path)[0], one)
            self.assertEqual([back.error for back in rows.read(path)], [0.034, None])
            # Seen to fail: without _OLD_NAMES.
            path.write_text(path.read_text().replace("parameter", "knob"))
            self.assertEqual(rows.read(path)[0], one)

    # Seen to fail: with the old block left behind the new one.
    def test_only_what_is_between_the_markers_is_replaced(self):
        text = f"before\n{documents.BEGIN}\nold\n{documents.END}\nafter\n"
        block = f"{documents.BEGIN}\nnew\n{documents.END}"
        self.assertEqual(documents.replace_block(text, block), text.replace("old", "new"))


    # Seen to fail: with a figure of docs/TRADE.md and of README.md changed by hand.
    def test_the_documents_are_what_the_committed_tables_say(self):
        tables = documents.read_all()
        self.assertEqual((ROOT / "docs" / "TRADE.md").read_text(), documents.trade_text(tables) + "\n",
                         "write it anew: ./tern study --write-docs")
        readme = (ROOT / "README.md").read_text()
        self.assertEqual(readme, documents.replace_block(readme, documents.readme_block(tables)),
                         "write it anew: ./tern study --write-docs")


class StandInTest(unittest.TestCase):
    def setUp(self):
        fake = FakeBuild()
        self.path = fake.__enter__().path
        self.addCleanup(fake.__exit__)
        for role, script in (("fluid", FLUID), ("case", CASE)):
            (self.path / "build" / f"tern-{role}").write_text(script)
        (self.path / "pond" / "expected.toml").write_text(EXPECTED)
        self.log = self.path / "runs.log"

    def start(self, *words, **environment):
        return subprocess.Popen([ROOT / "tern", "study", "pond", *words], cwd=self.path, text=True, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT,
                                env=os.environ | {"TERN_BUILD": str(self.path / "build"), "FAKE_LOG": str(self.log)} | environment,
                                start_new_session=True)

    def study(self, *words, **environment):
        process = self.start(*words, **environment)
        output, _ = process.communicate(timeout=120)
        return process.returncode, output

    def count(self):
        return len(self.log.read_text().splitlines()) if self.log.exists() else 0

    def rows(self):
        return {one.point: one for one in rows.read(self.path / "runs" / "study-pond" / "cost_accuracy.csv")}

    # Seen to fail: with the rows of the file left aside; with a failed point run again; with its failure raised.
    def test_a_failed_point_is_a_row_and_nothing_is_run_twice(self):
        words = ("--parameters", "fluid.spacing,fluid.numerics.courant", "--levels", "2")
        code, output = self.study(*words)
        self.assertEqual(code, 0, output)
        self.assertEqual(self.count(), 6, output)  # standard twice, two spacings, two Courant numbers
        found = self.rows()
        burst = found["fluid.numerics.courant=0.25"]
        self.assertEqual((burst.status, burst.exit_code, burst.cause, burst.error), ("numerical failure", 3, "It burst.", None))
        self.assertAlmostEqual(found["standard"].error, 0.04, 4)
        self.assertAlmostEqual(found["fluid.spacing=0.2"].error, 0.16, 4)
        self.assertEqual(found["fluid.spacing=0.05"].distance_to_finest, found["standard"].distance_to_finest, "its uncertainty")
        self.assertEqual(self.study(*words)[0], 0)
        self.assertEqual(self.count(), 6)
        self.study("--parameters", "gradient")
        self.assertEqual(self.count(), 7, "one parameter more is one run more")
        text = (self.path / "runs" / "study-pond" / "study.md").read_text()
        self.assertIn("order 2, 2", text)
        self.assertIn("It burst.", text)
        self.assertTrue((self.path / "runs" / "study-pond" / "trade.png").stat().st_size > 10000)

    # Seen to fail: with every failure kept.
    def test_a_point_lost_to_the_machine_is_run_again(self):
        words = ("--parameters", "fluid.numerics.courant", "--levels", "1")
        _, output = self.study("--knobs", *words[1:], FAKE_CODE="4")
        self.assertIn("--knobs is called --parameters now", output)
        self.assertEqual((self.rows()["fluid.numerics.courant=0.25"].status, self.count()), ("peer lost", 3))
        self.study(*words)
        self.assertEqual((self.rows()["fluid.numerics.courant=0.25"].status, self.count()), ("numerical failure", 4))

    # Seen to fail: with the other rows left out when the table is written; with the curves of whatever run is in the directory.
    def test_another_end_neither_mixes_with_nor_loses_what_was_measured(self):
        words = ("--parameters", "fluid.spacing", "--levels", "1")
        self.study(*words)
        before = self.rows()
        code, output = self.study(*words, "--until", "2.5")
        self.assertEqual((code, self.count()), (0, 6), output)
        self.assertIn("3 rows of the table are of another version, end or case", output)
        self.study(*words)
        self.assertEqual(self.count(), 6, "measured before, and not forgotten")
        again = {one.point: one for one in rows.read(self.path / "runs" / "study-pond" / "cost_accuracy.csv") if one.end_time_s == 3.0}
        self.assertEqual(again["fluid.spacing=0.2"].error, before["fluid.spacing=0.2"].error)
        self.assertIsNone(again["fluid.spacing=0.2"].distance_to_standard, "its curves were replaced by those of the shorter run")

    # Seen to fail: with the wish answered though nothing was measured.
    def test_a_wish_is_answered_with_a_line_to_copy(self):
        code, output = self.study("--parameters", "fluid.spacing", "--levels", "2", "--error", "2%")
        self.assertEqual(code, 0, output)
        self.assertIn("./tern run pond --set fluid.spacing=0.05\n  error against the reference 1 %", output)
        runs = self.count()
        code, output = self.study("--error", "0.1 %", "--time", "1h")
        self.assertEqual(self.count(), runs, "answered from what is there")
        self.assertIn("No point of the study reaches an error against the reference of at most 0.1 %; the nearest is:", output)

    # Seen to fail: with the distance of the finest run from itself taken for its error.
    def test_one_spacing_alone_tells_no_error(self):
        (self.path / "pond" / "expected.toml").unlink()
        code, output = self.study("--parameters", "gradient", "--error", "5%")
        self.assertEqual(code, 0, output)
        self.assertIn("No point of the study has a known distance to the finest run", output)
        self.study("--parameters", "fluid.spacing")
        found = self.rows()  # 4 (0.1^2 - 0.05^2) = 0.03 of a front at 3 m
        self.assertAlmostEqual(found["standard"].distance_to_finest, 0.01, 4)
        self.assertEqual(found["fluid.spacing=0.05"].distance_to_finest, found["standard"].distance_to_finest, "its uncertainty")

    # Seen to fail: without the comparison with the budget.
    def test_a_budget_leaves_out_what_does_not_fit_and_says_so(self):
        code, output = self.study("--parameters", "fluid.spacing,gradient", "--budget", "0.1", FAKE_SLEEP="1")
        self.assertEqual(code, 0, output)
        self.assertRegex(output, r"left out, not expected to fit the budget: .*fluid.spacing=0.05")
        self.assertIn("standard-again", self.rows())
        self.assertNotIn("fluid.spacing=0.05", self.rows())

    # Seen to fail: with rows written at the end only; with the interrupted run taken for a failed point.
    def test_an_interrupt_leaves_the_finished_rows(self):
        process = self.start("--parameters", "fluid.spacing", FAKE_SLEEP="1.5")
        self.assertTrue(wait_until(lambda: self.count() >= 2, 60))
        self.assertEqual(list(self.rows()), ["standard"], "written as soon as it has finished")
        os.killpg(process.pid, signal.SIGINT)
        output, _ = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 130, output)
        self.assertEqual(list(self.rows()), ["standard"])

    # Each seen to fail without its check.
    def test_mistakes_are_refused_with_a_remedy(self):
        for words, sentence in ((("--parameters", "fluid.spacng"), "did you mean fluid.spacing?"),
                                (("--parameters", "smoothing_length_ratio"), "write it in full"),
                                (("--error", "much"), "write for example 5% or 0.05"), (("--time", "-3"), "write for example 60s"),
                                (("--levels", "0"), "not a whole number"), (("--budget", "x"), "not a positive number")):
            code, output = self.study(*words)
            self.assertEqual(code, 2, output)
            self.assertIn(sentence, output)
        (self.path / "pond" / "study.toml").write_text("[[quantity]]\nname = \"arival\"\n")
        code, output = self.study()
        self.assertEqual(code, 2, output)
        self.assertIn("expected.toml has no quantity named 'arival'; it has arrival", output)
        self.assertEqual(self.count(), 0)


class CommittedTablesTest(unittest.TestCase):
    """Error (without a reference: distance of draft from standard) within 30 % and 0.05 percentage points of the table. Cost of
    draft over standard: within a factor of 2, as CPU times of a shared machine are."""

    @classmethod
    def setUpClass(cls):
        os.environ["TERN_BUILD"] = str(build_directory())

    def measure(self, case, *names):
        directory = tempfile.TemporaryDirectory(prefix="tern-test-")
        self.addCleanup(directory.cleanup)
        path, out = cases.find(case), Path(directory.name)
        build = build_directory()
        criterion = accuracy.read(path.parent, cases.read(build, path, [])["end_time"])
        points = {"draft": parameters.Point("draft", "preset", "draft", ("--preset", "draft")), "standard": parameters.STANDARD}
        work = sweep.Sweep(path, [], out, criterion, [])
        found = [work.measure(planned) for planned in sweep.plan(build, path, [], [points[name] for name in names])]
        tables = {name: read_table(out / "points" / name / "gauges.csv") for name in names}
        for row in found:
            self.assertTrue(row.done, row.cause)
            if row.error is None:
                row.distance_to_standard = accuracy.distance(tables[row.point], tables["standard"], criterion.curves)
        return found

    # Seen to fail: with draft at 3 times the spacing; with blend_theta = 0 as the default; with draft at the step of standard.
    def check(self, case, *names):
        now, table = self.measure(case, *names), rows.read(ROOT / "docs" / "trade" / f"{case}.csv")
        for name in names:
            found, written = (row.distance_to_standard if row.error is None else row.error
                              for row in (front.find(now, name), front.find(table, name)))
            self.assertAlmostEqual(found, written, delta=0.3 * written + 5e-4, msg=f"{case}, {name}")
        if "standard" in names:
            ratio, written = (front.find(some, "draft").cpu_s / front.standard_cost(some)[0] for some in (now, table))
            self.assertLess(abs(math.log(ratio / written)), math.log(2),
                            f"{case}: draft costs {ratio:.3f} of standard, {written:.3f} in the table")

    def test_hydrostatic_tank(self):
        self.check("hydrostatic_tank", "standard", "draft")

    def test_dam_break_front(self):
        self.check("dam_break_front", "standard", "draft")

    def test_gray_cantilever(self):
        self.check("gray_cantilever", "draft")


if __name__ == "__main__":
    unittest.main()
