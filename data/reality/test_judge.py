#!/usr/bin/env python3
"""The rules of counting on diagnoses written by hand, with the keys of version 2.

    python data/reality/test_judge.py
"""

import unittest

from judge import judge

BACKLASH = {"physics": "joint-backlash", "place": {"joint": "A3"}}
FRICTION = {"physics": "joint-friction", "place": {"joint": "A3"}}
STAND = {"physics": "gauge-stand-compliance", "place": {"direction": "y"}}


def answer(expected: str, **more) -> dict:
    truth = {"name": "joint-backlash@A3", "standard_errors": 12.0, "near": [{"name": "gauge-stand-compliance@y", "standard_errors_left": 1.0}]}
    truths = [] if expected == "nothing" else [truth]
    return {"row": "any", "kind": "any", "expected": expected, "truth": truths, "also_right": [], **more}


def said(verdict: str, findings=(), grade=None, **more) -> dict:
    groups = [{**finding, "alternative_group": group} if group else finding for finding, group in findings]
    return {"verdict": verdict, "findings": groups, "grade": grade, "left_over": {}, "where": [], **more}


def judged(one: dict, data: dict | None):
    return judge("id", one, data, None, 1.0)


class Names(unittest.TestCase):
    def test_right_is_the_true_name_or_a_set_that_cannot_be_separated(self):
        named = answer("named")
        self.assertTrue(judged(named, said("explained", [(BACKLASH, None)], "weak")).right)
        self.assertTrue(judged(named, said("ambiguous", [(BACKLASH, 1), (STAND, 1)], "is")).right)
        self.assertFalse(judged(named, said("ambiguous", [(BACKLASH, 1), (FRICTION, 1)], "is")).right)
        self.assertFalse(judged(named, said("explained", [(BACKLASH, None), (STAND, None)], "is")).right)
        self.assertFalse(judged(named, said("unknown", [(BACKLASH, None)], "unknown")).right)
        alone = judged(named, said("explained", [(STAND, None)], "is"))
        self.assertEqual((alone.right, alone.inseparable), (False, True))

    def test_two_effects_need_a_finding_each(self):
        two = answer("named")
        two["truth"].append({"name": "slip@P1.x.2.4", "standard_errors": 9.0, "near": []})
        slip = {"physics": "slip", "place": {"run": {"pose": "P1", "direction": "x", "repeat": 2}, "step": 4}}
        self.assertTrue(judged(two, said("explained", [(slip, None), (BACKLASH, None)], "is")).right)
        self.assertFalse(judged(two, said("explained", [(BACKLASH, None)], "is")).right)

    def test_drift_per_kelvin_is_another_name_than_per_second(self):
        drift = answer("named", truth=[{"name": "thermal-drift@clock:per-kelvin", "standard_errors": 9.0, "near": []}])
        finding = {"physics": "thermal-drift", "place": {"clock": True}, "parameters": {"rate": {"value": 1e-6, "unit": "m/K"}}}
        self.assertTrue(judged(drift, said("explained", [(finding, None)])).right)
        finding["parameters"]["rate"]["unit"] = "m/s"
        self.assertFalse(judged(drift, said("explained", [(finding, None)])).right)


class Others(unittest.TestCase):
    def test_alarms_and_flat_statements(self):
        weak = judged(answer("nothing"), said("explained", [(STAND, None)], "weak"))
        self.assertEqual((weak.alarm, weak.flat), (True, False))
        older = judged(answer("nothing"), said("explained", [(STAND, None)]))
        self.assertEqual((older.alarm, older.flat), (True, True))
        self.assertFalse(judged(answer("nothing"), said("nothing-missing", data_findings=[{"kind": "bad-reading", "lines": [9]}])).alarm)

    def test_bad_readings(self):
        place = {"pose": "P1", "direction": "x", "repeat": 2, "step": 3, "branch": "loading"}
        bad = answer("nothing", bad={"line": 40, "place": place})
        by_line = {"kind": "bad-reading", "lines": [40], "place": {}}
        by_place = {"kind": "bad-reading", "place": {"reading": place}}
        other = {"kind": "bad-reading", "lines": [41], "place": {"reading": {**place, "step": 4}}}
        for findings, named, good in (([by_line], True, False), ([by_place], True, False), ([other], False, True), ([by_line, other], True, True), ([], False, False)):
            one = judged(bad, said("nothing-missing", data_findings=findings))
            self.assertEqual((one.bad_named, one.good_named_bad), (named, good))

    def test_a_set_up_may_be_unknown_at_its_place(self):
        cells = [{"pose": "P1", "direction": "z", "standard_errors": 8.0}, {"pose": "P2", "direction": "z", "standard_errors": 3.0}]
        setup = answer("setup", cells=cells)
        place = lambda pose, direction: said("unknown", grade="unknown", where=[{"pose": pose, "direction": direction}])
        self.assertTrue(judged(setup, place("P1", "z")).unknown_with_place)
        self.assertFalse(judged(setup, place("P2", "z")).unknown_with_place)
        self.assertFalse(judged(setup, place(None, "z")).unknown_with_place)
        self.assertTrue(judged(setup, said("unknown", [(BACKLASH, None)], "unknown")).unknown_with_place)

    def test_misled(self):
        mishap = answer("mishap", also_right=["joint-*@A4"], cells=[])
        near = judged(mishap, said("explained", [(STAND, None)], "is"))
        self.assertEqual((near.misled, near.inseparable), (False, True))
        self.assertTrue(judged(mishap, said("explained", [(FRICTION, None)], "weak")).misled)
        tilt = {"physics": "joint-tilt-compliance", "place": {"joint": "A4", "axis": "y"}}
        self.assertFalse(judged(mishap, said("ambiguous", [(FRICTION, 1), (tilt, 1)], "is")).misled)
        self.assertFalse(judged(mishap, said("unknown", [(FRICTION, None)], "unknown")).misled)

    def test_unsaid(self):
        nothing, named = answer("nothing"), answer("named")
        self.assertTrue(judged(nothing, said("nothing-missing", grade="nothing", omnibus={"p": 1e-9, "contrast": "any"})).unsaid_page)
        self.assertTrue(judged(named, said("explained", [(BACKLASH, None)], "is", left_over={"standard_errors": 7.0})).unsaid_page)
        self.assertFalse(judged(named, said("explained", [(BACKLASH, None)], "mostly", left_over={"standard_errors": 7.0})).unsaid_page)
        self.assertTrue(judged(named, said("nothing-missing", grade="nothing")).unsaid_truth)
        self.assertFalse(judged(named, said("explained", [(BACKLASH, None)], "is")).unsaid_truth)

    def test_what_is_left_of_a_mishap(self):
        hand = answer("mishap", also_right=["slip@*"], cells=[])
        hand["truth"] = [{"name": "hand", "standard_errors": 15.0, "near": [],
                          "left_after": {"slip@P1.x.1.3": 12.0, "slip@P1.x.1.4": 12.5, "slip@P2.y.4.2": 12.0, "link-length@arm": 9.0}}]
        slip = lambda pose, direction, repeat, step: {"physics": "slip", "place": {"run": {"pose": pose, "direction": direction, "repeat": repeat}, "step": step}}
        unsaid = lambda *findings: judged(hand, said("explained", [(finding, None) for finding in findings], "is")).unsaid_truth
        self.assertTrue(unsaid(slip("P1", "x", 1, 3)))
        # 225 less 81 for each of two runs.
        self.assertFalse(unsaid(slip("P1", "x", 1, 3), slip("P2", "y", 4, 2)))
        self.assertTrue(unsaid(slip("P1", "x", 1, 3), slip("P1", "x", 1, 4)))
        self.assertFalse(unsaid({"physics": "link-length", "place": {"body": "arm", "entry": "l2"}}))
        self.assertTrue(unsaid({"physics": "creep", "place": {"structure": True}}))

    def test_a_failure_counts_as_nothing(self):
        self.assertFalse(judged(answer("nothing"), None).right)


if __name__ == "__main__":
    unittest.main()
