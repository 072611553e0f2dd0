"""The batched pose solver against the commands `robot map` and `robot compliance`."""

import threading
import warnings

import numpy as np
import pandas as pd
import pytest
import stiffbench
from stiffbench import Robot


def random_poses(robot, count, seed=0):
    low, high = robot.limits.T
    return np.random.default_rng(seed).uniform(low, high, (count, len(low)))


@pytest.mark.parametrize("mechanism, kind", [("F", "compliance"), ("A", "compliance"), ("F", "stiffness")])
def test_every_number_is_that_of_the_map(program, tmp_path, mechanism, kind):
    out = tmp_path / "map"
    made = program("robot", "map", "--mechanisms", mechanism, "--samples", 300, f"--matrix={kind}", "--out", out)
    assert made["ok"]
    points = pd.read_csv(out / f"points-{mechanism}.csv")
    robot = Robot("hp-robot", mechanism=mechanism)
    poses = np.empty((len(points), len(robot.variables)))
    nominal = program("robot", "show", "hp-robot")["data"]["variables"]
    for place, (name, unit) in enumerate(zip(robot.variables, robot.units)):
        column = points.get(f"{name}_{unit}")
        poses[:, place] = nominal[place]["nominal_deg"] if column is None else column
    found = getattr(robot, kind)(poses)
    start = "C_" if kind == "compliance" else "K_"
    expected = points[[name for name in points if name.startswith(start)]].to_numpy().reshape(-1, 6, 6)
    assert len(expected) >= 300
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(robot.positions(poses), points[["x_m", "y_m", "z_m"]])


@pytest.mark.parametrize("name", ["hp-robot", "serial-arm", "fanuc-r2000ic", "scara", "gantry"])
def test_named_poses(program, name):
    robot = Robot(name)
    assert len(robot.poses) > 0
    for pose, values in robot.poses.items():
        expected = np.array(program("robot", "compliance", name, "--pose", pose)["data"]["compliance"])
        found = robot.compliance(values[None])[0]
        scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
        assert np.all(np.abs(found - expected) <= 1e-8 * scale)


def test_effects_and_model(program, sprung, tmp_path):
    effect = "joint-compliance@A3:c=20urad/(N*m)"
    with_spring = Robot("hp-robot", mechanism="A", effects=[effect])
    words = ["robot", "compliance", "--mechanism", "A", "--pose", "P1", "--effect", effect]
    expected = np.array(program(*words)["data"]["compliance"])
    pose = with_spring.poses["P1"][None]
    np.testing.assert_allclose(with_spring.compliance(pose)[0, :3, :3].diagonal(), expected[:3, :3].diagonal(), rtol=1e-8)
    stiffbench.diagnose(sprung, mechanism="A", out=tmp_path / "out", no_figures=True)
    found = Robot(model=tmp_path / "out/model.toml")
    assert found.mechanism == "A"
    np.testing.assert_allclose(found.compliance(pose)[0, :3, :3].diagonal(), expected[:3, :3].diagonal(), rtol=0.05)


def test_what_a_robot_is():
    robot = Robot("fanuc-r2000ic")
    assert len(robot.variables) == 6 and robot.units == ["deg"] * 6
    assert robot.limits.shape == (6, 2)
    assert robot.mechanism == robot.mechanisms[-1]
    assert "mechanism=" in repr(robot)
    assert "m" in Robot("gantry").units
    assert Robot().name == Robot("hp-robot").name


def test_stiffness_is_the_inverse():
    robot = Robot("fanuc-r2000ic")
    poses = random_poses(robot, 200)
    product = robot.stiffness(poses) @ robot.compliance(poses)
    found = product[np.isfinite(product).all(axis=(1, 2))]
    assert len(found) > 150
    np.testing.assert_allclose(found, np.broadcast_to(np.eye(6), found.shape), atol=1e-4)


def test_layouts():
    robot = Robot("fanuc-r2000ic")
    poses = random_poses(robot, 5000)
    expected = robot.compliance(poses)
    assert expected.shape == (5000, 6, 6) and expected.flags.c_contiguous and expected.dtype == np.float64
    np.testing.assert_array_equal(robot.compliance(np.asfortranarray(poses)), expected)
    np.testing.assert_array_equal(robot.compliance(poses[::-1])[::-1], expected)
    np.testing.assert_array_equal(robot.compliance(np.repeat(poses, 2, axis=1)[:, ::2]), expected)
    shifted = np.frombuffer(b"x" + poses.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(poses.shape)
    assert not shifted.flags.aligned
    np.testing.assert_array_equal(robot.compliance(shifted), expected)
    np.testing.assert_array_equal(robot.compliance(poses[7:8])[0], expected[7])
    locked = poses.copy()
    locked.flags.writeable = False
    np.testing.assert_array_equal(robot.compliance(locked), expected)
    assert robot.compliance(poses[:0]).shape == (0, 6, 6)
    assert robot.positions(poses[:0]).shape == (0, 3)


@pytest.mark.parametrize("method", ["compliance", "stiffness", "positions", "within_limits"])
def test_wrong_poses(method):
    robot = Robot("fanuc-r2000ic")
    solve = getattr(robot, method)
    good = random_poses(robot, 4)
    for wrong in [good[:, :5], good[0], good[None], np.zeros((0,))]:
        with pytest.raises(ValueError, match=r"expected shape \(n, 6\)"):
            solve(wrong)
    for wrong in [good.astype(np.float32), good.astype(int), good.astype(">f8"), good.astype(object)]:
        with pytest.raises(TypeError, match="float64"):
            solve(wrong)
    for wrong in [good.tolist(), None, "P1", pd.DataFrame(good)]:
        with pytest.raises(TypeError, match="float64"):
            solve(wrong)
    for value in [np.nan, np.inf, -np.inf]:
        wrong = good.copy()
        wrong[2, 3] = value
        with pytest.raises(ValueError, match=r"poses\[2, 3\]"):
            solve(wrong)


def test_poses_that_cannot_be_taken():
    robot = Robot("hp-robot")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robot.compliance(robot.poses["P1"][None])
    low, high = robot.limits.T
    wide = np.random.default_rng(1).uniform(low - 400, high + 400, (3000, len(low)))
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = robot.compliance(wide)
    missing = np.isnan(found).any(axis=(1, 2))
    assert bool(missing.any()) == bool(caught)
    for warning in caught:
        assert warning.category is RuntimeWarning and f"{missing.sum()} of 3000 poses" in str(warning.message)


def test_limits():
    robot = Robot("hp-robot")
    poses = np.array(list(robot.poses.values()))
    assert robot.within_limits(poses).all()
    low, _ = robot.limits.T
    assert not robot.within_limits(low[None] - 1.0).any()


@pytest.mark.parametrize(
    "arguments, options, code",
    [
        (["no-such-robot"], {}, "stiffbench::"),
        (["hp-robot"], {"mechanism": "Z"}, "stiffbench::robot"),
        (["hp-robot"], {"factors": "none"}, "stiffbench::robot"),
        (["hp-robot"], {"effects": ["joint-compliance@A3:c=many"]}, "stiffbench::"),
        (["hp-robot"], {"effects": ["joint-backlash@A3:play=30urad,seat_moment=9N*m"]}, "stiffbench::distribution::linear_only"),
    ],
)
def test_failures(arguments, options, code):
    with pytest.raises(stiffbench.StiffbenchError) as raised:
        Robot(*arguments, **options)
    assert raised.value.code.startswith(code)


def test_other_threads_run():
    robot = Robot("fanuc-r2000ic")
    poses = random_poses(robot, 20_000)
    expected = robot.compliance(poses)
    found = [None] * 4

    def solve(place):
        found[place] = robot.compliance(poses)

    threads = [threading.Thread(target=solve, args=(place,)) for place in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for one in found:
        np.testing.assert_array_equal(one, expected)


def test_bench_effects_are_left_out_and_named():
    robot = Robot("hp-robot", effects=["gauge-stand-compliance@y:c=0.1um/N"])
    assert any("left out" in warning for warning in robot.warnings)
