"""Softness that is asked for: springs and dampers of contacts and equalities, against their closed forms."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest
from field import FLOOR, Array, G, Scene, box, scene, slope

from stiction.mujoco import Stepper, patch, rollout

GROUND = FLOOR.replace("<geom", '<geom name="floor"')
APART = 'contype="0" conaffinity="0"'
K, D = 2000.0, 30.0
DIRECT = f'solref="{-K} {-D}"'


def soft_scene(world: str, rest: str = "", option: str = "", h: float = 0.002, **asked: Any) -> Scene:
    """A scene in which something may be soft."""
    made = scene(world, rest, option, h)
    return Scene(made.model, made.data, Stepper(made.model, tol=1e-9, **asked))


def crate(name: str, x: float, more: str = "", z: float = 0.05) -> str:
    """A box of 2 kg; its bottom is 5 cm below its middle."""
    return box(".1 .1 .05", f"{x} 0 {z}", 2.0, more=f'name="{name}" {more}')


def sunk(s: Scene, body: int) -> float:
    """How deep something has sunk from where it began (m)."""
    return float(s.model.qpos0[7 * body + 2] - s.data.qpos[7 * body + 2])


def fallen(h: float, steps: int, damping: float, start: float = 0.0, mass: float = 2.0, pushes: bool = False) -> Array:
    """Where a mass is that a spring holds, or only pushes: implicit over each step."""
    z, v, places = start, 0.0, []
    for _ in range(steps):
        v -= h * G
        # Over a gap the spring and its damper act from where it closes.
        stretch, gain = (z / h, h * K + damping) if pushes and z > 0 else (K * z / (h * K + damping), h * K + damping)
        pull = h * gain * (stretch + v) / (mass + h * gain) * mass
        v -= (min(pull, 0.0) if pushes else pull) / mass
        z += h * v
        places.append(z)
    return np.array(places)


@pytest.mark.parametrize("compliance", [1e-6, 1e-4, 5e-4])
def test_a_crate_sags_by_its_weight_on_four_springs(compliance: float) -> None:
    s = soft_scene(GROUND + crate("a", 0), compliance=compliance)
    s.run(5)
    assert sunk(s, 0) == pytest.approx(2 * G * compliance / 4, rel=1e-5, abs=1e-9)
    assert s.forces()[1] == pytest.approx(2 * G, rel=1e-5) and s.is_clean()


@pytest.mark.parametrize("key", [("a", "floor"), ("floor", "a"), (0, 1), ("floor", 1)])
def test_one_pair_is_soft_beside_a_rigid_one(key: tuple[str | int, str | int]) -> None:
    s = soft_scene(GROUND + crate("a", 0) + crate("b", 1), compliance={key: 1e-4})
    s.run(3)
    assert sunk(s, 0) == pytest.approx(2 * G * 1e-4 / 4, rel=1e-5)
    assert abs(sunk(s, 1)) < 1e-8 and s.is_clean()


def test_what_is_named_comes_before_solref_and_that_before_one_number() -> None:
    world = GROUND.replace("/>", f" {DIRECT}/>") + '<geom type="box" size=".2 .2 .1" pos="2 0 0"/>'
    world += crate("a", 0) + crate("b", 1) + '<body pos="2 0 .15"><freejoint/><geom size=".05" mass="2"/></body>'
    named = soft_scene(world, compliance={("a", "floor"): 1e-4, ("b", "floor"): 0.0}, soft=True)
    named.run(5)
    assert [sunk(named, i) for i in range(3)] == pytest.approx([2 * G * 1e-4 / 4, 0, 0], rel=1e-5, abs=1e-8)
    all_soft = soft_scene(world, compliance=1e-4, soft=True)
    all_soft.run(5)
    of_solref = 2 * G / K / 4
    assert [sunk(all_soft, i) for i in range(3)] == pytest.approx([of_solref, of_solref, 2 * G * 1e-4], rel=1e-4)


@pytest.mark.parametrize("damping", [0.0, D])
@pytest.mark.parametrize("h", [0.0005, 0.002, 0.01])
def test_a_ball_bounces_on_spring_and_damper(h: float, damping: float) -> None:
    """Dropped from 10 cm; each step is that of the implicit law."""
    floor = GROUND.replace("/>", f' solref="{-K} {-damping}"/>')
    ball = '<body pos="0 0 .15"><freejoint/><geom size=".05" mass="2"/></body>'
    s, places = soft_scene(floor + ball, h=h, soft=True), []
    for _ in range(round(1 / h)):
        places.append(s.step().qpos[2] - 0.05)
    assert np.abs(places - fallen(h, len(places), damping, 0.1, pushes=True)).max() < 1e-6
    assert min(places) < -0.01 and s.is_clean()


WELD = '<weld name="tie" body1="a" {}/>'
CONNECT = '<connect name="tie" body1="a" anchor="0 0 0" {}/>'
JOINT = '<joint name="tie" joint1="z" {}/>'
ASKED: dict[str, dict[str, Any]] = {
    "solref": {"soft": True},
    "name": {"compliance": {"tie": 1 / K}},
    "number": {"compliance": 1 / K},
}


@pytest.mark.parametrize("asked", ASKED)
@pytest.mark.parametrize("tie", [WELD, CONNECT, JOINT])
def test_a_mass_hangs_on_an_equality(tie: str, asked: str) -> None:
    joint = '<joint name="z" type="slide" axis="0 0 1"/>' if tie == JOINT else "<freejoint/>"
    world = f'<body name="a" pos="0 0 1">{joint}<geom size=".05" mass="2" {APART}/></body>'
    s = soft_scene(world, f"<equality>{tie.format(DIRECT if asked == 'solref' else '')}</equality>", **ASKED[asked])
    places = np.array([s.step().qpos[0 if tie == JOINT else 2] for _ in range(3000)]) - (tie != JOINT)
    assert np.abs(places - fallen(s.h, 3000, D if asked == "solref" else 0.0)).max() < 1e-9
    assert places[-1] == pytest.approx(-2 * G / K, rel=5e-3) and s.is_clean()


def test_it_is_the_damped_oscillator_as_steps_become_small() -> None:
    world = f'<body name="a" pos="0 0 1"><freejoint/><geom size=".05" mass="2" {APART}/></body>'
    decay, errors = D / 2 / 2, []
    omega = np.sqrt(K / 2 - decay**2)
    for h in (2e-4, 1e-4):
        s = soft_scene(world, f"<equality>{CONNECT.format(DIRECT)}</equality>", h=h, soft=True)
        places = np.array([s.step().qpos[2] - 1 for _ in range(round(0.5 / h))])
        t = h * np.arange(1, len(places) + 1)
        exact = 2 * G / K * (np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t)) - 1)
        errors.append(np.abs(places - exact).max())
    assert errors[1] == pytest.approx(errors[0] / 2, rel=0.05) and errors[1] < 0.01 * G / K


@pytest.mark.parametrize("scale", [1.0, 0.3])
def test_a_weld_turns_by_half_the_angle(scale: float) -> None:
    """The energy of its spring is ``k (torquescale sin(a / 2))² / 2``."""
    rod = '<joint name="q" axis="0 0 1" damping="2"/><inertial pos="0 0 0" mass="1" diaginertia=".1 .1 .1"/>'
    weld = f'<equality><weld name="tie" body1="a" torquescale="{scale}"/></equality><actuator><motor joint="q"/></actuator>'
    s = soft_scene(f'<body name="a">{rod}</body>', weld, compliance={"tie": 0.01})
    s.data.ctrl[:] = 0.5
    s.run(40)
    angle = s.data.qpos[0]
    assert 100 * scale**2 * np.sin(angle / 2) * np.cos(angle / 2) / 2 == pytest.approx(0.5, rel=1e-6) and s.is_clean()


@pytest.mark.parametrize("compliance", [1e-5, 5e-4])
@pytest.mark.parametrize("mu", [0.5, 0.3])
def test_friction_on_soft_ground_is_coulombs(mu: float, compliance: float) -> None:
    """On a slope of 20° it sticks without creep, or slides as it would on a rigid one."""
    angle = np.deg2rad(20)
    world = GROUND.replace("/>", f' friction="{mu} 0 0"/>') + box(".1 .1 .05", "0 0 .05", 2.0, mu)
    s = soft_scene(world, option=slope(angle), compliance=compliance)
    s.run(5)
    place, velocity = s.data.qpos[:2].copy(), s.data.qvel[0]
    s.run(10)
    if mu > np.tan(angle):
        assert np.abs(s.data.qpos[:2] - place).max() < 1e-9
    else:
        assert (s.data.qvel[0] - velocity) / 10 == pytest.approx(-G * (np.sin(angle) - mu * np.cos(angle)), rel=1e-6)
    assert s.is_clean()


@pytest.mark.parametrize("compliance", [1e-5, 1e-4])
def test_soft_pads_hold_what_is_shaken(compliance: float) -> None:
    """Nothing creeps in a hand that goes up and down, whose pads are pressed by 20 N."""
    pad = '<body pos="{1} 0 0"><joint name="{0}" type="slide" axis="{2} 0 0"/>'
    pad += '<geom type="box" size=".01 .02 .02" mass=".1"/></body>'
    hand = f'<joint name="z" type="slide" axis="0 0 1"/><geom size=".01" mass=".1" {APART}/>'
    hand += pad.format("l", -0.045, 1) + pad.format("r", 0.045, -1)
    world = f'<body name="hand" pos="0 0 .3">{hand}</body>' + box(".03 .03 .03", "0 0 .3", 0.5)
    motors = '<motor joint="l"/><motor joint="r"/><position joint="z" kp="2000" kv="100"/>'
    s = soft_scene(world, f"<actuator>{motors}</actuator>", compliance=compliance)
    s.data.ctrl[:2], held = 20.0, []
    for i in range(3000):
        s.data.ctrl[2] = 0.02 * np.sin(4 * np.pi * s.data.time)
        s.step()
        if i >= 1000:
            held.append(s.data.qpos[5] - s.data.qpos[0])
    assert np.ptp(held) < 1e-9 and s.is_clean()


def test_what_stands_on_soft_ground_is_held_as_a_loop_closes() -> None:
    """A part of 0.3 kg is put 0.1 mm off its place on a crate: it comes back, and the crate, which friction holds, stays."""
    part = f'<body name="part" pos="0 0 .15"><freejoint/><geom size=".02" mass=".3" {APART}/></body>'
    weld = '<equality><weld body1="crate" body2="part"/></equality>'
    world = GROUND + part + '<body name="crate" pos="0 0 .05"><freejoint/><geom type="box" size=".15 .15 .05" mass="10"/></body>'
    s = soft_scene(world, weld, compliance={("floor", 2): 1e-4})
    s.run(4)
    before = s.data.qpos.copy()
    s.data.qpos[0] += 1e-4
    s.run(4)
    assert np.abs(s.data.efc_pos[:3]).max() < 1e-9 and abs(s.data.qpos[7] - before[7]) < 1e-9


def test_what_stands_on_a_soft_turntable_goes_round() -> None:
    """A crate leans outward by as much as springs do; straight steps would lead it out by 5 µm each."""
    table = '<body><joint name="q" axis="0 0 1"/><geom type="box" size=".6 .6 .02" mass="20"/></body>' + crate("a", 0.3, z=0.07)
    s = soft_scene(table, '<actuator><velocity joint="q" kv="1000"/></actuator>', compliance=1e-4)
    s.run(2)
    for _ in range(2000):
        s.data.ctrl[0] = 3 * min(1.0, (s.data.time - 2) / 2)
        s.step()
    lean = 2 * 0.3 * 3**2 * 0.05 / (4 * 0.1**2 / 1e-4)
    assert np.hypot(*s.data.qpos[1:3]) == pytest.approx(0.3 + 0.05 * lean, abs=1e-6)
    assert s.stepper.modes == [1] * 4 and s.is_clean()


def test_no_point_is_deeper_than_it_is() -> None:
    """A ball on an arm goes along a circle into a wall between it and the hinge: each step has the overlap with which it begins."""
    wall = '<geom type="plane" size="1 1 1" pos=".18 0 0" euler="0 90 0" condim="1"/>'
    arm = '<body><joint axis="0 0 1"/><geom pos=".2 0 0" size=".02" mass=".1" condim="1"/></body>'
    s = soft_scene(wall + arm, compliance=1e-3)
    s.data.qvel[:] = 5.0
    for _ in range(20):
        overlap = 0.2 * (1 - np.cos(s.data.qpos[0]))
        assert s.step().contact.dist == pytest.approx(-overlap, abs=1e-8)
    assert overlap > 1e-3 and s.is_clean()


def test_each_point_bears_by_its_own_spring() -> None:
    """Also where there are many in a face, of which a rigid one needs few: a box on a flat field of heights."""
    field = '<asset><hfield name="flat" nrow="9" ncol="9" size="1 1 .5 .1"/></asset>'
    s = soft_scene('<geom type="hfield" hfield="flat"/>' + box(".3 .3 .05", "0 0 .05"), field, compliance=1e-4)
    for _ in range(40):
        s.step()
        first = s.data.contact.efc_address
        open_after = s.data.contact.dist + s.h * (s.data.efc_J.reshape(-1, 6)[first] @ s.data.qvel)
        assert s.data.efc_force[first] == pytest.approx(np.maximum(-open_after, 0) / 1e-4, abs=1e-6)
    assert s.data.ncon > 24 and s.is_clean()


def cuffed(cuff: str, **asked: Any) -> Scene:
    """An exoskeleton beside a shank, its axis off by 10 mm; 10 N m turn it, and the knee has a stop at -120°."""
    rod = f'<geom type="capsule" fromto="0 0 0 0 0 -.4" size=".03" mass="{{}}" {APART}/><site name="{{}}" pos="{{}}"/>'
    knee = '<joint name="knee" axis="0 1 0" damping="1" range="-120 0" limited="true"/>' + rod.format(3, "s", "0 0 -.3")
    frame = '<joint name="x" axis="0 1 0"/>' + rod.format(1, "f", "-.01 0 -.295")
    world = f'<body name="shank" pos="0 0 1">{knee}</body><body name="frame" pos=".01 0 .995">{frame}</body>'
    s = soft_scene(world, f'{cuff}<actuator><motor joint="x"/></actuator>', **asked)
    s.data.qpos[:], s.data.ctrl[0] = -0.2, -10.0
    s.run(3)
    return s


def test_a_soft_cuff_lets_the_knee_turn() -> None:
    """It is where a tendon of the same stiffness leads."""
    tendon = '<tendon><spatial stiffness="2e4" damping="200"><site site="s"/><site site="f"/></spatial></tendon>'
    like = cuffed(tendon).data.qpos
    cuff = '<equality><connect name="cuff" body1="shank" body2="frame" anchor="0 0 -.3" {}/></equality>'
    solref = 'solref="-2e4 -200"'
    for s in (cuffed(cuff.format(""), compliance={"cuff": 5e-5}), cuffed(cuff.format(solref), soft=True)):
        assert np.rad2deg(s.data.qpos[0]) == pytest.approx(-120, abs=1e-6)
        assert s.data.qpos == pytest.approx(like, abs=1e-7)
        assert s.data.efc_force[:3] == pytest.approx(-2e4 * s.data.efc_pos[:3], rel=1e-6, abs=1e-6)
        assert np.abs(s.data.efc_force).max() < 50 and s.is_clean()
    rigid = cuffed(cuff.format(solref))
    assert np.rad2deg(rigid.data.qpos[0]) > -20 and np.abs(rigid.data.efc_force).max() > 500


def test_a_soft_weld_follows_motion_capture_as_a_spring() -> None:
    """Far faster than the hand, which moves by 1 mm/s, and is 30 cm away as it begins."""
    lead = '<body name="hand" mocap="true" pos="0 0 1"/><body name="a" pos="0 0 1"><freejoint/>'
    lead += f'<geom size=".05" mass="2" {APART}/></body>'
    weld = f'<equality><weld name="tie" body1="hand" body2="a" {DIRECT}/></equality>'
    s = soft_scene(lead, weld, 'gravity="0 0 0"', compliance={"tie": 1 / K})
    x = v = 0.0
    for _ in range(1000):
        s.data.mocap_pos[0, 0] = goal = 0.3 + 1e-3 * s.data.time
        s.step()
        v = (2 * v - s.h * K * (x - goal)) / (2 + s.h**2 * K)
        x += s.h * v
        assert abs(s.data.qpos[0] - x) < 1e-9
    assert s.is_clean()


def test_a_body_of_motion_capture_presses_by_the_spring() -> None:
    """Rigid, it would contradict the wall."""
    wall = '<geom type="box" size=".1 .2 .2" pos=".2 0 .5"/><body name="f" mocap="true" pos="-.13 0 .5">'
    finger = '<geom name="f" size=".05"/></body>'
    part = '<body pos=".02 0 .5"><freejoint/><geom name="part" type="box" size=".08 .04 .04" mass="1"/></body>'
    s = soft_scene(wall + finger + part, option='gravity="0 0 0"', compliance={("part", "f"): 1e-5})
    for _ in range(600):
        s.data.mocap_pos[0, 0] = -0.13 + 0.03 * min(s.data.time, 1)
        s.step()
    force = 0.01 / 1e-5
    assert s.forces()[2] == pytest.approx(2 * force, rel=1e-5) and s.is_clean()  # the finger's and the wall's


def test_a_slow_body_of_motion_capture_throws_by_the_spring() -> None:
    """It moves by 1 mm/s, but for one jump, to 10 mm deep."""
    finger = '<body mocap="true" pos="-.14 0 0"><geom size=".05"/></body>'
    part = '<body><freejoint/><geom type="box" size=".08 .04 .04" mass="1"/></body>'
    s, x, v = soft_scene(finger + part, option='gravity="0 0 0"', compliance=1e-5), 0.0, 0.0
    for step in range(50):
        s.data.mocap_pos[0, 0] = tip = (-0.12 if step > 5 else -0.14) + 1e-3 * s.data.time
        s.step()
        v = max(v, (v + s.h / 1e-5 * (tip + 0.13 - x)) / (1 + s.h**2 / 1e-5))
        x += s.h * v
        assert abs(s.data.qpos[0] - x) < 1e-8
    assert v > 1 and s.is_clean()


def bouncing() -> mujoco.MjModel:
    """Two crates, of which one falls on springs by its `solref`, and a mass that hangs."""
    hung = f'<body name="a" pos="2 0 1"><freejoint/><geom size=".05" mass="2" {APART}/></body>'
    world = GROUND + crate("a", 0, DIRECT, z=0.1) + crate("b", 1) + hung
    return scene(world, f"<equality>{CONNECT.format('')}</equality>").model


GIVEN: dict[str, Any] = {"compliance": {("b", "floor"): 1e-4, "tie": 1e-3}, "soft": True}


def ways(**asked: Any) -> Array:
    """Where a run leads."""
    model = bouncing()
    data, stepper, found = mujoco.MjData(model), Stepper(model, tol=1e-9, **asked), []
    for _ in range(300):
        stepper.step(data)
        found.append(np.concatenate([data.qpos, data.qvel]))
    return np.array(found)


def test_off_by_default() -> None:
    """A `solref` that is not in the direct form is not read either way."""
    plain = ways()
    assert (ways(compliance=0.0, soft=False) == plain).all() and (ways(compliance={}) == plain).all()
    assert np.abs(plain[-1] - ways(**GIVEN)[-1]).max() > 1e-3
    model = scene(GROUND + crate("a", 0, 'solref=".1 .5"')).model
    found = []
    for soft in (False, True):
        data = mujoco.MjData(model)
        Stepper(model, soft=soft).step(data, 100)
        found.append(data.qpos.copy())
    assert (found[0] == found[1]).all()


class Environment:
    """As one of gymnasium."""

    def __init__(self) -> None:
        self.model = bouncing()
        self.data = mujoco.MjData(self.model)

    def _step_mujoco_simulation(self, ctrl: Array, n_frames: int) -> None:
        raise AssertionError("MuJoCo's law")


def test_rollouts_copies_and_environments_are_as_soft() -> None:
    expected, model = ways(**GIVEN), bouncing()
    data = mujoco.MjData(model)
    size, first = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS), []
    state = np.empty(size)
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    done = rollout(model, [state], np.zeros((2, 300, 0)), tol=1e-9, **GIVEN)
    assert (done.states[:, :, 1:] == expected).all()
    stepper = Stepper(model, tol=1e-9, **GIVEN)
    stepper.step(data, 100)
    again: list[Callable[[Any], Any]] = [copy.deepcopy, lambda own: pickle.loads(pickle.dumps(own))]
    copies = [copied((stepper, data)) for copied in again]
    stepper.step(data, 200)
    for other, its in copies:
        other.step(its, 200)
        assert (its.qpos == data.qpos).all() and its.qpos == pytest.approx(expected[-1, : model.nq], abs=1e-12)
    environment = Environment()
    patch(environment, tol=1e-9, **GIVEN)
    for own in [environment, *(copied(environment) for copied in again)]:
        own._step_mujoco_simulation(np.zeros(0), 300)
        first.append(np.concatenate([own.data.qpos, own.data.qvel]))
    assert [(found == expected[-1]).all() for found in first] == [True] * 3


@pytest.mark.parametrize(
    ("compliance", "said"),
    [
        (-1e-3, "compliance: -0.001"),
        (np.nan, "compliance: nan"),
        ({("a", "floor"): np.inf}, r"compliance\[\('a', 'floor'\)\]: inf"),
        ({"tie": -1.0}, r"compliance\['tie'\]: -1.0"),
        ({("a", "flor"): 1e-3}, r"compliance\[\('a', 'flor'\)\].*flor"),
        ({("a", 99): 1e-3}, r"compliance\[\('a', 99\)\].*99"),
        ({("a", "b", "floor"): 1e-3}, r"compliance\[\('a', 'b', 'floor'\)\]"),
        ({"strap": 1e-3}, r"compliance\['strap'\].*strap"),
        ({7: 1e-3}, r"compliance\[7\]"),
    ],
)
def test_errors_name_what_is_wrong(compliance: Any, said: str) -> None:
    model = bouncing()
    with pytest.raises(ValueError, match=said):
        Stepper(model, compliance=compliance)
    with pytest.raises(ValueError, match=said):
        rollout(model, np.zeros((1, 1)), np.zeros((1, 1, 0)), compliance=compliance)
    with pytest.raises(ValueError, match=said):
        patch(Environment(), compliance=compliance)


def test_derivatives_are_refused_where_something_is_soft() -> None:
    model = bouncing()
    data = mujoco.MjData(model)
    Stepper(model, compliance={("a", "b"): 1e-3}).derivatives(data)  # which do not touch
    with pytest.raises(ValueError, match="soft"):
        Stepper(model, compliance={"tie": 1e-3}).derivatives(data)
    model.eq("tie").active0[:] = 0
    with pytest.raises(ValueError, match="soft"):
        Stepper(model, compliance={("b", "floor"): 1e-4}).derivatives(mujoco.MjData(model))
